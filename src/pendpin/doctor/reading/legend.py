"""What a text says of its own symbols: "where $A$ is the transverse inertia about the joint", or a row of a table."""

import re
from collections.abc import Iterator

from pendpin.doctor.reading.names import Written

MOST_WORDS = 90  # characters of a phrase that says what a symbol is
_SYMBOL = r"\$\s*(?P<symbol>\\?[A-Za-z]+(?:_\{?\\?\w+\}?)?'?)\s*\$"
_BARE = r"(?P<bare>\b(?:[A-Za-z]|alpha|beta|gamma|psi|theta|phi|delta)(?:_\w+)?)"
_VERB = r"\s*(?:\|\s*(?:--+|—)?|is|are|be|denotes|stands for|means|being|for|[:—–-]+|)\s*"
_BEGINS = r"(?:the|an?|its) |(?=angle|mass|length|inertia|transverse|axial|distance|cent|moment|polar|azimuth|energy)"
_PHRASE = rf"(?P<phrase>(?:{_BEGINS})[A-Za-z][^$|.;\n]{{2,90}}?)(?=$|[.;|\n,]|\s+and\s+\$|\$)"
_SAID = re.compile(_SYMBOL + _VERB + _PHRASE)
_SAID_PLAINLY = re.compile(
    rf"(?:where|with|and|let|,|^\s*[-*|]?)\s*`?{_BARE}`?\s*(?:is|be|denotes|stands for|means|:|\|)\s*{_PHRASE}", re.M
)

# what a phrase speaks of, the special before the general, and how that is printed in one system or another
PHRASES: tuple[tuple[str, tuple[str, ...]], ...] = (
    (r"angular velocity|frequency|rate|unit vector|period|number|ratio|function|constant|coordinate", ()),
    (
        r"angle theta|\btheta\b|angle from the vertical|polar angle|first angle|angle of deflection|swing angle",
        ("theta",),
    ),
    (r"angle phi|\bphi\b|azimuth|second angle", ("phi",)),
    (r"inertia.*(?:axial|axis of the rod|rod'?s (?:own )?axis|own axis|longitudinal|long axis|spin)", ("I_3",)),
    (r"(?:axial|longitudinal).*inertia", ("I_3",)),
    (r"inertia.*(?:joint|pivot|hinge|suspen|support|point O|\bO\b|its end|fixed point)", ("J_1", "J")),
    (r"inertia.*(?:cent(?:re|er)|centroid|\bG\b|gravity|com\b)|(?:central|centroidal).*inertia", ("I_1", "I_G", "I")),
    (r"cent(?:re|er) of (?:mass|gravity)|centroid", ("h",)),
    (r"mass of the cart|cart'?s mass|cart mass", ("M",)),
    (r"mass of the (?:pole|pendulum|bob|rod)|pole mass", ("m",)),
    (r"position of the cart|cart'?s position|displacement", ("x",)),
    (r"\b(?:its|the|a|total)? ?mass\b(?! matrix| point| of the (?:first|second|upper|lower))", ("m",)),
    (r"gravitational|acceleration of gravity|acceleration due to gravity|free fall|\bgravity\b", ("g",)),
    (r"\blength\b(?! of the (?:first|second|upper|lower))", ("l",)),
    (r"radius of the rod|rod'?s radius", ("r",)),
    (r"kinetic energy", ("T",)),
    (r"potential energy", ("V",)),
    (r"Lagrangian|Lagrange function", ("L",)),
    (r"total energy|mechanical energy", ("E",)),
    (r"tension", ("R_3", "S")),
)

# "of mass $M$", "the length $L$", not "centre of mass $G$" nor "half the length $a$"; a tension may stand before an equation
_NAMED = re.compile(
    rf"(?:^|[.,;(]\s*|(?<!\w)(?P<before>\w+\s+)?\b(?:of|with|and|its|has|the|a|total)\s+)"
    rf"(?P<phrase>mass|length)\s+{_SYMBOL}",
    re.IGNORECASE | re.MULTILINE,
)
_NO_NAME = re.compile(r"cent(?:re|er)|half|per|unit|quarter|twice|double", re.IGNORECASE)
_FILLING = (
    "force|in|at|of|along|the|a|rod|joint|string|rope|wire|then|therefore|thus|is|equals|becomes|reads|follows|as"
)
_PULL = re.compile(
    rf"\b(?P<phrase>tension|(?:reaction|force)\s+along\s+the\s+rod)(?:\s+(?:{_FILLING})\b)*[:,]?\s*"
    rf"(?:\$\$?|\\\[|\\begin\{{(?:equation|align)\*?\}})\s*(?P<symbol>[A-Za-z](?:_\{{?\w+\}}?)?)\s*(?:&?=|\$)",
    re.IGNORECASE,
)


def named(text: str) -> Iterator[tuple[str, Written]]:
    """The symbols that a text names in passing, each with how that is printed for a rod."""
    for match in _NAMED.finditer(text):
        if not _NO_NAME.fullmatch((match["before"] or "").strip()) and not re.search(r"\d", match["symbol"]):
            yield match["symbol"], Written("m" if match["phrase"].lower() == "mass" else "l")
    for match in _PULL.finditer(text):
        yield match["symbol"], Written("R", 0, "3")


def legend(text: str) -> Iterator[tuple[str, tuple[Written, ...]]]:
    """The symbols of which a text says what they are, and how that is printed in the systems that the doctor knows."""
    for match in [*_SAID.finditer(text), *_SAID_PLAINLY.finditer(text)]:
        groups = match.groupdict()
        symbol, phrase = groups.get("symbol") or groups.get("bare") or "", match["phrase"][:MOST_WORDS]
        for pattern, printed in PHRASES:
            if re.search(pattern, phrase, re.IGNORECASE):
                if printed:
                    yield symbol, tuple(_written(name) for name in printed)
                break


def _written(name: str) -> Written:
    letter, _, index = name.partition("_")
    return Written(letter, 0, index)
