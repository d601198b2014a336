"""What a text, or its reader, says of its symbols: "where $A$ is the transverse inertia", a row of a table, --symbols."""

import re
from dataclasses import replace
from functools import lru_cache

from pendpin.doctor.reading.grammar import lone
from pendpin.doctor.reading.names import GREEK, INERTIA, Vocabulary, Written, of_coordinate, of_word
from pendpin.doctor.reading.states import COORDINATE
from pendpin.doctor.reading.tree import Name, Unread
from pendpin.doctor.systems.base import Spec
from pendpin.errors import InputError, not_one_of, shown

MOST_WORDS = 90  # characters of a phrase that says what a symbol is
_SYMBOL = r"\$\s*(?P<symbol>\\?[A-Za-z]+(?:_\{?\\?\w+\}?)?'?)\s*\$"
_VERB = r"\s*(?:\|\s*(?:--+|—)?|is|are|be|denotes|stands for|means|being|for|[:—–-]+|)\s*"
_BEGINS = r"(?:the|an?|its) |(?=angle|mass|length|inertia|transverse|axial|distance|cent|moment|polar|azimuth|energy)"
_PHRASE = rf"(?P<phrase>(?:{_BEGINS})[A-Za-z][^$|.;\n]{{2,90}}?)(?=$|[.;|\n,$]|\s+and\s+\$)"
_SAID = re.compile(_SYMBOL + _VERB + _PHRASE)  # "$A$ is the transverse inertia"
# "of mass $M$", "the potential energy is $P = ...", "the inertias $A$ and $C$ about the joint"; not "centre of mass $G$"
_PASSING = re.compile(
    r"(?<!cent[re][re] of )(?<!half the )\b(?P<phrase>mass|length|tension|(?:reaction|force) along the rod|"
    r"(?:kinetic|potential|total|mechanical) energy|(?:[a-z]+ )?(?:moments? of )?inertias?)"
    r"(?:\s+(?!and\b|mass\b|length\b|inertia)[a-z]+){0,4}[:,]?\s*(?:\$\$?|\\\[|\\begin\{(?:equation|align)\*?\})\s*"
    r"(?P<symbol>\\?[A-Za-z]+(?:_\{?\w+\}?)?)\s*(?:&?=|\$)(?:(?:,|\s+and)\s*\$(?P<other>[A-Za-z]_\{?\w+\}?)\$)?"
    r"(?P<after>\s*\(?(?:about|around|through)(?:(?! and )[A-Za-z ]){2,60})?",
    re.IGNORECASE,
)
# what a phrase speaks of, the special before the general, and how that is printed in one system or another
PHRASES = {
    "angular velocity|frequency|rate|unit vector|period|number|ratio|function|constant|coordinate": "",
    "theta.{0,4} and .{0,4}phi": "",
    r"\btheta\b|angle (?:from|with|to) the (?:downward )?vertical|polar angle|first angle|swing angle": "theta",
    r"\bphi\b|azimuth|second angle": "phi",
    "inertia.*(?:axial|axis of (?:symmetry|the rod)|symmetry axis|long axis|the axis$)": "I_3 J",
    "(?:axial|longitudinal|polar|spin).*inertia": "I_3 J",
    r"inertia.*(?:joint|pivot|hinge|suspension|support|\bO\b)": "J_1 J",
    r"inertia.*(?:cent(?:re|er)|\bG\b)|central.*inertia": "I_G I_1 I",
    "cent(?:re|er) of (?:mass|gravity)|centroid": "h",
    "mass of the cart|cart'?s mass": "M",
    r"\bmass\b(?! matrix| point| of the (?:first|second|upper|lower))": "m",
    r"position of the cart|displacement": "x",
    r"gravit|free fall": "g",
    r"\blength\b(?! of the (?:first|second|upper|lower))": "l",
    "radius of the rod|rod'?s radius": "r",
    "kinetic energy": "T",
    "potential energy": "V",
    "Lagrangian|Lagrange function": "L",
    "total energy|mechanical energy": "E",
    "tension|along the rod": "S R_3",
}


def read_symbols(table: dict[str, str], spec: Spec, renamed: dict[Name, Written], text: str = "") -> Vocabulary:
    """The words of a system, with symbols that are given as other names, or as expressions. Raises InputError."""
    named = {name for written in renamed.values() for name in spec.words(written)[:1]} & set(spec.coordinates)
    words = Vocabulary(spec, dict(renamed), frozenset(named))
    for i, name in enumerate(spec.coordinates, start=1):
        words.renamed[COORDINATE, str(i)] = of_coordinate(name)
    _say(words, text)
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
        strange = any(part.startswith("?") for part in right.names) and meaning not in GREEK and meaning not in table
        if strange and re.fullmatch("[A-Za-z]{2,}", str(meaning)):
            raise InputError(f"symbols.{name}: {not_one_of(meaning, (*spec.state, *spec.unknowns, *spec.parameters))}")
        if right.kind == "symbol" and right.written and not left.dots:
            words.renamed[left.name] = right.written
        else:
            words.given[words(left)[0]] = right
    return words


@lru_cache(maxsize=10)
def _said(text: str) -> list[tuple[str, tuple[Written, ...], bool]]:
    """The symbols of which a text says what they are, how that is printed in some system, and if it is said in passing."""
    found = list[tuple[str, tuple[Written, ...], bool]]()
    for pattern in (_SAID, _PASSING):
        for match in pattern.finditer(text):
            groups = match.groupdict("")
            phrase = groups["phrase"][:MOST_WORDS] + groups.get("after", "")
            meant = next((meant for known, meant in PHRASES.items() if re.search(known, phrase, re.IGNORECASE)), "")
            printed = tuple(Written(letter, 0, index) for letter, _, index in (n.partition("_") for n in meant.split()))
            names = filter(None, (groups["symbol"], groups.get("other")))
            found += [(name, printed, pattern is _PASSING) for name in names if printed]
    return found


def _say(words: Vocabulary, text: str) -> None:
    """Note what a text says of its symbols: other names, and which of its own meanings a letter has.

    What it says in passing is one more meaning, as is no letter's own.
    """
    spec = words.spec
    for symbol, printed_names, passing in _said(text):
        try:
            left = _key(symbol)
        except Unread:  # a slip such as \thta: the equations that hold it say so
            continue
        if left is None or (name := left.name) in words.renamed:
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
    found = lone(name, Vocabulary())
    return found.written if found is not None and found.kind == "symbol" else None
