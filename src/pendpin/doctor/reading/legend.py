"""What a text, or its reader, says of its symbols: "where $A$ is the transverse inertia", a row of a table, --symbols."""

import re
from dataclasses import replace
from functools import lru_cache

from pendpin.doctor.reading.grammar import lone
from pendpin.doctor.reading.names import GREEK, Vocabulary, Written, of_word, raw
from pendpin.doctor.reading.states import COORDINATE
from pendpin.doctor.reading.tree import Unread, symbols
from pendpin.doctor.systems.base import Spec
from pendpin.errors import InputError, not_one_of, shown

INERTIA = (1, 2, 0)  # powers of kg, m, s

MOST_WORDS = 90  # characters of a phrase that says what a symbol is
_SYMBOL = r"\$\s*(?P<symbol>\\?[A-Za-z]+(?:_\{?\\?\w+\}?)?'?)\s*\$"
_BARE = r"(?P<bare>\b(?:[A-Za-z]|alpha|beta|gamma|psi|theta|phi|delta)(?:_\w+)?)"
_VERB = r"\s*(?:\|\s*(?:--+|—)?|is|are|be|denotes|stands for|means|being|for|[:—–-]+|)\s*"
_BEGINS = r"(?:the|an?|its) |(?=angle|mass|length|inertia|transverse|axial|distance|cent|moment|polar|azimuth|energy)"
_PHRASE = rf"(?P<phrase>(?:{_BEGINS})[A-Za-z][^$|.;\n]{{2,90}}?)(?=$|[.;|\n,]|\s+and\s+(?:\$|\w+\s+is\b)|\$)"
_SAID = re.compile(_SYMBOL + _VERB + _PHRASE)
_SAID_PLAINLY = re.compile(
    rf"(?:where|with|and|let|,|^\s*[-*|]?)\s*`?{_BARE}`?\s*(?:is|be|denotes|stands for|means|:|\|)\s*{_PHRASE}", re.M
)

# a value in code and the comment behind it
_VALUED = re.compile(r"^\s*(?:\w+ )?(?P<bare>[A-Za-z]\w*)\s*:?=\s*[-\d.][^#%/\n]*(?:#+|%+|//+)\s*(?P<phrase>.+)", re.M)
_DAMPING = re.compile(r"damping|friction|viscous|drag", re.I)
_OF_DAMPING = re.compile(r"[bcdkfBCD]|gamma|mu|beta|delta")

# what a phrase speaks of, the special before the general, and how that is printed in one system or another
PHRASES: tuple[tuple[str, tuple[str, ...]], ...] = (
    (r"angular velocity|frequency|rate|unit vector|period|number|ratio|function|constant|coordinate", ()),
    (r"theta.{0,4} and .{0,4}phi", ()),
    (
        r"angle theta|\btheta\b|angle (?:from|with|to|between [\w ]+ and) the (?:downward )?vertical|polar angle|"
        r"first angle|angle of deflection|swing angle",
        ("theta",),
    ),
    (r"angle phi|\bphi\b|azimuth|second angle", ("phi",)),
    (
        r"inertia.*(?:axial|ax[ie]s of (?:the rod|symmetry|revolution)|symmetry axis|rod'?s (?:own )?axis|"
        r"\b(?:its|own) axis|longitudinal|long axis|spin)|(?:axial|longitudinal|polar|spin).*inertia",
        ("I_3", "J"),
    ),
    (r"inertia.*(?:joint|pivot|hinge|suspen|support|point O|\bO\b|its end|fixed point)", ("J_1", "J")),
    (r"inertia.*(?:cent(?:re|er)|centroid|\bG\b|gravity|com\b)|(?:central|centroidal).*inertia", ("I_G", "I_1", "I")),
    (r"inertia about the axis", ("I_3", "J")),
    (r"cent(?:re|er) of (?:mass|gravity)|centroid", ("h",)),
    (r"mass of the cart|cart'?s mass|cart mass", ("M",)),
    (r"mass of the (?:pole|pendulum|bob|rod)|pole mass", ("m",)),
    (r"position of the cart|cart'?s position|displacement", ("x",)),
    (r"\bmass\b(?! matrix| point| of the (?:first|second|upper|lower))", ("m",)),
    (r"gravitational|acceleration of gravity|acceleration due to gravity|free fall|\bgravity\b", ("g",)),
    (r"\blength\b(?! of the (?:first|second|upper|lower))", ("l",)),
    (r"radius of the rod|rod'?s radius", ("r",)),
    (r"kinetic energy", ("T",)),
    (r"potential energy", ("V",)),
    (r"Lagrangian|Lagrange function", ("L",)),
    (r"total energy|mechanical energy", ("E",)),
    (r"tension|along the rod", ("R_3", "S")),
)

# "of mass $M$", "the length $L$", not "centre of mass $G$" nor "half the length $a$"
_NO_NAME = "".join(
    f"(?<!{word} )" for word in ("centre", "center", "half", "per", "unit", "quarter", "twice", "double")
)
_NAMED = re.compile(
    rf"(?:^|[.,;(]\s*|{_NO_NAME}\b(?:of|with|and|its|has|the|a|total)\s+)(?P<phrase>mass|length)\s+(?!\$[^$]*\d){_SYMBOL}",
    re.IGNORECASE | re.MULTILINE,
)
_FILLING = """force in at of along the a rod joint string rope wire then therefore thus is equals becomes reads follows as
bob body bodies system pendulum total both two"""
_PASSING = re.compile(
    r"\b(?P<phrase>tension|(?:reaction|force)\s+along\s+the\s+rod|(?:kinetic|potential|total|mechanical)\s+energy|"
    r"(?:central|centroidal|polar|axial|spin|transverse)\s+(?:moments?\s+of\s+)?inertias?)"
    rf"(?:\s+(?:{'|'.join(_FILLING.split())})\b)*[:,]?\s*"
    r"(?:\$\$?|\\\[|\\begin\{(?:equation|align)\*?\})\s*(?P<symbol>[A-Za-z](?:_\{?\w+\}?)?)\s*(?:&?=|\$)"
    r"(?:(?:,|\s+and)\s*\$(?P<other>[A-Za-z]_\{?\w+\}?)\$)?"
    r"(?P<after>\s*\(?(?:about|around|through)(?:(?! and )[A-Za-z ]){2,60})?",
    re.IGNORECASE,
)


def read_symbols(
    table: dict[str, str], spec: Spec, renamed: dict[tuple[str, str], Written], text: str = ""
) -> Vocabulary:
    """The words of a system, with symbols that are given as other names, or as expressions. Raises InputError."""
    named = {name for written in renamed.values() for name in spec.words(written)[:1]} & set(spec.coordinates)
    words = Vocabulary(spec.words, dict(renamed), frozenset(spec.state), frozenset(named), spec=spec)
    for i, name in enumerate(spec.coordinates, start=1):
        words.renamed[COORDINATE, str(i)] = Written(name.rstrip("12"), 0, name[-1:].strip("aeihpqstx"))
    _say(words, spec, text)
    for name, meaning in table.items():
        try:
            left, right = _key(name), lone(str(meaning), words)
        except Unread as error:
            raise InputError(f"symbols.{name}: {error.reason}") from None
        if left is None:
            raise InputError(f"symbols.{name}: {shown(name)} is not one symbol")
        if right is None:
            raise InputError(f"symbols.{name}: {shown(meaning)} is not one expression")
        # a word that neither names a quantity nor is a product of letters that all have a meaning
        strange = any(part.startswith("?") for part in symbols(right)) and meaning not in GREEK and meaning not in table
        if strange and re.fullmatch("[A-Za-z]{2,}", str(meaning)):
            raise InputError(f"symbols.{name}: {not_one_of(meaning, (*spec.state, *spec.unknowns, *spec.parameters))}")
        if right.kind == "symbol" and right.written and not left.dots:
            words.renamed[left.letter, left.index] = right.written
        else:
            words.given[words(left)[0]] = right
    return words


@lru_cache(maxsize=10)
def _said(text: str) -> list[tuple[str, tuple[Written, ...], bool]]:
    """The symbols of which a text says what they are, how that is printed in some system, and if it is said in passing."""
    found = list[tuple[str, tuple[Written, ...], bool]]()
    for pattern in (_SAID, _SAID_PLAINLY, _VALUED, _NAMED, _PASSING):
        for match in pattern.finditer(text):
            groups = match.groupdict("")
            phrase = groups["phrase"][:MOST_WORDS] + groups.get("after", "")
            meant = next((meant for known, meant in PHRASES if re.search(known, phrase, re.IGNORECASE)), ())
            printed = tuple(Written(letter, 0, index) for letter, _, index in (one.partition("_") for one in meant))
            passing = pattern in (_NAMED, _PASSING)
            names = (groups.get("symbol") or groups.get("bare", ""), groups.get("other", ""))
            if printed or passing or _DAMPING.search(phrase):
                found += [(name, printed, passing) for name in names if name]
    return found


def _say(words: Vocabulary, spec: Spec, text: str) -> None:
    """Note what a text says of its symbols: other names, and which of its own meanings a letter has.

    What it says in passing is one more meaning, as is no letter's own.
    """
    for symbol, printed_names, passing in _said(text):
        try:
            left = _key(symbol)
        except Unread:  # a slip such as \thta: the equations that hold it say so
            continue
        if left is None or (name := (left.letter, left.index)) in words.renamed:
            continue
        if not printed_names:
            words.chosen.update({name: ""} if _OF_DAMPING.fullmatch(left.letter) else {})
            continue
        own = [replace(one, index=left.index or one.index) for one in printed_names]
        meant = next((one for one in (*own, *printed_names) if spec.words(one)), None)
        meanings = words(left)
        if meant is None:
            continue
        if spec.dimensions.get(meanings[0]) == INERTIA:
            about = printed_names[0].letter  # I about the centre of mass, J about the joint
            words.chosen[name] = next((meaning for meaning in meanings if meaning[0] == about), "")
        elif passing:
            words.also[name] = meant
        elif meanings[0] not in {*spec.state, *spec.still}:  # what has a meaning a phrase misread may not take
            words.renamed[name] = meant


def _key(name: str) -> Written | None:
    """The name on the left of an entry of symbols; any word of letters is one."""
    if re.fullmatch(r"[A-Za-z]{2,}\d*", name):
        return of_word(name) or Written(name)
    found = lone(name, Vocabulary(raw))
    return found.written if found is not None and found.kind == "symbol" else None
