"""What a text is about: the names that it uses, the system that it describes, and in which convention."""

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain, islice
from typing import Any

import numpy as np

from pendpin.doctor.checking.conditions import holds_as_stated
from pendpin.doctor.checking.dimensions import of_equation
from pendpin.doctor.checking.residuals import residuals
from pendpin.doctor.conventions import conventions_of, find_convention, likely_rod, single_conventions
from pendpin.doctor.letters import MOST_COUNTED, Again, held, settled, weight, with_own_letters
from pendpin.doctor.patients import Printed, holding, printed
from pendpin.doctor.proposals import option, proposed
from pendpin.doctor.reading.documents import Document
from pendpin.doctor.reading.grammar import lone
from pendpin.doctor.reading.legend import legend, named
from pendpin.doctor.reading.names import GREEK, Vocabulary, Written, of_word, raw
from pendpin.doctor.reading.tree import Node, Unread, parts, symbols, walk
from pendpin.doctor.systems.base import LOADS, Convention, Spec, System, random_states, unloaded
from pendpin.doctor.systems.known import SPECS
from pendpin.doctor.systems.planar import FAMILIES
from pendpin.doctor.systems.rod import RODS
from pendpin.doctor.systems.scene import scene_spec
from pendpin.errors import InputError, not_one_of, shown

Name = tuple[str, str]  # a letter and its index
Renamed = dict[Name, Written]

ANGLE_LETTERS = {
    "theta",
    "phi",
    "alpha",
    "beta",
    "psi",
    "gamma",
    "q",
    "varphi",
    "vartheta",
    "delta",
    "chi",
    "xi",
    "eta",
}
INERTIA = (1, 2, 0)  # powers of kg, m, s
UNKNOWN = "no system that pendpin knows"
RARELY = 5  # times that a letter stands more often than another that is a slip
LIKELIER = 0.01  # equations: what a system of more coordinates counts, of which the text has each
NEARLY = 0.99  # of what may hold: the search ends
CLOSE, MOST_SETTLED = 2.5, 4  # readings in which so few equations fewer hold are compared more closely, and how many
MOST_PROPOSED = 20  # readings in which the meanings of unknown letters are searched
SURE = 0.6  # of what may hold: no other system is tried then
FEW = 3  # equations: fewer, none of which holds, may all be wrong
FROM_HORIZONTAL = re.compile(r"horizontal|manipulator|\barm\b|elbow|x[- ]axis", re.IGNORECASE)
ON_A_JOINT = re.compile(
    r"^(?!.*(?:spherical|polar|azimuth)).*(?:Cardan|universal joint|U-joint|Hooke'?s? joint)", re.I | re.S
)
# words of texts about systems that pendpin does not know
FOREIGN = re.compile(
    r"\b(?:roll\w*|dis[ck]|wheel|spring|elastic|hoop|bead|pulley|satellite|planet|orbit\w*|spool|ladder|gyroscope|"
    r"spinning top|projectile|vibrat\w*|oscillates|rocket|charge|oscillator|beam|plate|fluid|Atwood|Kepler)\b",
    re.IGNORECASE,
)
ELSEWHERE = re.compile(
    r"Furuta|\b(?:rotary|rotational)(?: inverted)? pendulum", re.IGNORECASE
)  # some equations are a rod's


@dataclass(frozen=True, eq=False)
class Reading:
    """The equations of a document as they are read. `chosen` says that the user named the system."""

    equations: list[Printed]
    system: System
    title: str
    remarks: tuple[str, ...] = ()
    chosen: bool = False
    unknown: bool = False
    conventions: tuple[Convention, ...] = ()  # others, under one of which an equation may be right
    again: Again | None = None  # reads them with other words
    angles: dict[str, str] = field(default_factory=dict)  # guessed: the letters of the angles

    @property
    def remedy(self) -> str:
        """What to write so that more is checked."""
        return "say which system it is with --rod, or what its symbols are with --symbols"

    def says(self, one: Printed) -> str:
        """What an equation says that is no law: a state, or a choice of parameters; empty for what may be a law."""
        sides, spec = one.sides, self.system.spec
        names = [_names(side) for side in sides]
        if all(side.kind == "symbol" for side in sides) and any("q_i" in inside for inside in names):
            return "it says what a name stands for"
        every = set().union(*names)
        multiples = every <= spec.still and all(_is_multiple(side) for side in sides)
        if multiples and (not self.chosen or _can_be_chosen(one, self.system)):  # else J may be called I
            return "it chooses a parameter: nothing to check"
        values = [side for side, inside in zip(sides, names, strict=True) if not inside]
        lone = all(side.kind == "symbol" for side in sides if side not in values)
        states = {*spec.state, *(name for name in spec.formulas if name.startswith(("sin", "cos")))}
        if values and not one.statement.name and ((lone and len(every) == 1) or every <= states) and not one.defines:
            return "it gives a state or a value, and no law: nothing to check"
        return ""


def _is_multiple(node: Node) -> bool:
    """Whether an expression is a number times one symbol at most."""
    inside = [part for part in walk(node) if part.kind == "symbol"]
    return len(inside) <= 1 and all(part.kind in ("symbol", "number", "product", "power") for part in walk(node))


def _can_be_chosen(one: Printed, system: System) -> bool:
    """Whether parameters may be equal: one is a number, also of metres, or neither is always the larger."""
    names = [_names(side) for side in one.sides]
    lengths = {name for name in system.spec.still if system.spec.dimensions[name] == (0, 1, 0)}
    if not all(names) or ({"m"} in names and lengths.intersection(*names[:1])):
        return True
    for equation in one.readings():
        rows = np.concatenate([rows for rows, _ in residuals(equation, random_states(system))])
        if rows.min() <= 0 <= rows.max() and not of_equation(equation, system.spec)[1]:
            return True
    return False


def _names(node: Node) -> set[str]:
    return symbols(node) - {"pi"}


def check_choices(rod: str | None, convention: str | None) -> None:
    """Check the names of a system and of a convention. Raises InputError."""
    if rod is not None and rod not in (*RODS, *FAMILIES):
        raise InputError(f"rod: {not_one_of(rod, (*RODS, *FAMILIES))}")
    conventions_of(convention or "")


def read(document: Document, choices: dict[str, Any]) -> Reading:
    """The equations of a document, read as those of the system that they fit best. Raises InputError."""
    kind, convention = choices.get("rod") or document.rod, choices.get("convention") or document.convention
    check_choices(kind, convention)
    table = {**document.symbols, **choices.get("symbols", {})}
    if scene := choices.get("scene"):
        return _as_scene(document, table, scene)
    rod = _as_rod(document, table, kind if kind in RODS else None, convention)
    best, most = rod, held(rod.equations, rod.system) + 0.5 if kind not in FAMILIES else -1.0
    is_rod = kind in RODS or convention is not None
    sure = rod.unknown or most > max(SURE * _most(rod), 0.5)
    counted: list[tuple[float, Reading]] = []
    renamed = () if kind in FAMILIES else _renamed_rods(document, table, kind, convention)
    for other in () if sure else chain(renamed, () if is_rod else _others(document, table, kind)):
        counted.append((held(other.equations, other.system), other))
        if (count := counted[-1][0] + LIKELIER * len(other.system.spec.coordinates)) > most:
            most, best = count, other
        if most > NEARLY * _most(best):
            break
    if most < 1:
        small = [(held(one.equations, one.system, small=True), one) for one in (rod, *(one for _, one in counted))]
        most, best = max([(0.5, best), *small], key=lambda pair: pair[0])
    elif not sure and most <= NEARLY * _most(best):
        likely = sorted(((count, other) for count, other in counted if count > most - CLOSE), key=lambda pair: -pair[0])
        best = _best_settled(best, [other for _, other in likely if other is not best])
    if not (sure or choices.get("proposed")) and (
        better := _proposed(document, choices, [best, *(r for _, r in counted)])
    ):
        return better
    best = best if best.unknown else replace(_settled(best), chosen=kind is not None)
    most = max(most, held(best.equations, best.system))
    return best if best.chosen or best.unknown else _doubted(best, int(most), document)


def _proposed(document: Document, choices: dict[str, Any], readings: list[Reading]) -> Reading | None:
    """The document read with meanings of its unknown letters, if more holds so; None for one of an unknown system."""
    best, most, meanings = readings[0], held(readings[0].equations, readings[0].system), dict[str, str]()
    if FOREIGN.search(document.text) or not any(one.unknown for one in best.equations):
        return None
    for reading in islice(readings, MOST_PROPOSED):
        rods = [SPECS[kind] for kind in ("symmetric", "thin")] if reading.system.kind in RODS else []
        for spec in rods or [reading.system.spec]:
            score, found = proposed(reading.equations, replace(reading.system, spec=spec))
            if score > most:
                best, most, meanings = reading, score, found
    if not meanings:
        return None
    names = best.angles | {option(letter): option(meaning) for letter, meaning in sorted(meanings.items())}
    symbols = {**names, **choices.get("symbols", {})}
    found = read(document, {**choices, "symbols": symbols, "proposed": True})
    text = ",".join(f"{name}={meaning}" for name, meaning in names.items())
    words = f"The letters are read so that most equations hold; confirm it with --symbols {text}."
    return replace(found, remarks=(words, *found.remarks))


def _settled(reading: Reading) -> Reading:
    """The same, each of whose letters has one meaning."""
    if reading.again is None:
        return reading
    return replace(reading, equations=settled(reading.equations, reading.system, reading.again), again=None)


def _best_settled(best: Reading, others: list[Reading]) -> Reading:
    """Of readings in which about as many equations hold that in which most do once their letters have one meaning.

    Equations that hold as their words state it, such as those of a pendulum that is released at rest, count here too.
    """
    readings = [_settled(one) for one in (best, *others[:MOST_SETTLED])]
    return max(readings, key=lambda one: held(one.equations, one.system) + _stated(one))


def _stated(reading: Reading) -> int:
    """How many equations hold under a condition that the words around them state."""
    every = (one for one in reading.equations if one.ways and not one.defines and not holding(one, reading.system))
    stated = (holds_as_stated(e, reading.system, one.statement.context) for one in every for e in one.readings())
    return sum(map(bool, stated))


def _as_scene(document: Document, table: dict[str, str], scene: Any) -> Reading:
    """The equations read as those of the chain of a scene."""
    spec = scene_spec(scene)
    words, given = read_symbols(table, spec, {}, document.text)
    equations = printed(document.statements, given, {}, words)
    return Reading(equations, System(spec), spec.title, (), True)


def _as_rod(
    document: Document, table: dict[str, str], rod: str | None, convention: str | None, renamed: Renamed | None = None
) -> Reading:
    """The equations read as those of a rod on a universal joint, whose angles may have other names."""
    words, given = read_symbols(table, SPECS["thin"], renamed or {}, document.text)
    usual = {f"?{letter}": lone(f"{name}(phi)", words) for letter, name in (("s", "sin"), ("c", "cos"))}
    known = {k: v for k, v in usual.items() if v}
    equations = printed(document.statements, given, known, words)
    kind = rod or likely_rod(equations)
    if convention is not None:
        base, remarks = conventions_of(convention), list[str]()
    else:  # angles whose names are guessed are tried in both orders
        base, remarks = find_convention(equations, kind, swaps=renamed is None)
    if rod is None and kind == "point":
        text = "These are equations of a point mass on a massless rod or string"
        remarks.insert(0, f"{text}; for a rod with mass write --rod thin.")
    if base.words:
        remarks.insert(0, f"The text has its own convention: {base.words}.")
    system = System(SPECS[kind], base)
    title = system.spec.title
    chained = rod is None and len(re.findall(r"\\(?:up|down)arrow|\bchain\b", document.text)) > 3
    if chained:
        title = "a chain of rods, each equation as one of a single rod"
        remarks.insert(0, "This text is about a chain of rods: give the chain as --scene to have it checked.")
    conventions = tuple(single_conventions()) if convention is None else ()
    again = partial(printed, document.statements, given, known)
    return Reading(equations, system, title, tuple(remarks), rod is not None, chained, conventions, again)


def _renamed_rods(
    document: Document, table: dict[str, str], rod: str | None, convention: str | None
) -> Iterator[Reading]:
    """The equations as those of a rod whose angles have other names."""
    found = _letters(document, table)
    letters = [name for name in found.angles if name in found.moving and name[1] in ("", "1", "2")]
    if len(letters) != 2 or {"theta", "phi"} <= {name[0] for name in letters}:
        return
    for first, second in (letters, letters[::-1]):
        found = _as_rod(document, table, rod, convention, {first: Written("theta"), second: Written("phi")})
        angles = {"_".join(first).rstrip("_"): "theta", "_".join(second).rstrip("_"): "phi"}
        text = ",".join(f"{name}={angle}" for name, angle in angles.items())
        words = f"The angles are read so that most equations hold; confirm it with --symbols {text}."
        yield replace(found, remarks=(words, *found.remarks), angles=angles)


def _others(document: Document, table: dict[str, str], kind: str | None) -> Iterator[Reading]:
    """The equations read as those of each other system whose coordinates the text may have."""
    letters = _letters(document, table)
    inertias = {name[0] for name in letters.every} & {"I", "J"} or re.search("inertia|gyration", document.text)
    for family, specs in FAMILIES.items():
        if kind not in (None, family) or (kind is None and family == "polar" and ON_A_JOINT.search(document.text)):
            continue
        for renamed in _renamings(family, letters):
            general = ("h", "") in letters.every and bool(inertias) and family != "polar"
            bodies = sorted(
                specs, key=lambda spec: (" any" in spec.kind) != bool(inertias)
            )  # simple ones unless it says so
            for spec in (spec for spec in bodies if not general or " any" in spec.kind):
                if " horizontal" in spec.kind and not FROM_HORIZONTAL.search(document.text):
                    continue
                words, given = read_symbols(table, spec, renamed, document.text)
                equations = printed(document.statements, given, {}, words)
                again = partial(printed, document.statements, given, {})
                if not any(any(e.names & {*LOADS} for e in one.readings()) for one in equations):
                    spec = unloaded(spec)
                equations = with_own_letters(equations, System(spec), again)
                yield Reading(equations, System(spec), spec.title, again=again)


@dataclass(frozen=True)
class Letters:
    """The letters of a text with their indices: those that have rates, and all, each with how often; and its angles."""

    moving: Counter[Name]
    every: Counter[Name]
    turned: set[Name]  # in sines and cosines

    @property
    def angles(self) -> list[Name]:
        """Those that may be angles: the usual ones, or where there are none those that move in a sine or cosine."""
        usual = [name for name in sorted(self.every) if name[0] in ANGLE_LETTERS]
        return usual or sorted(self.turned & self.moving.keys())


def _letters(document: Document, table: dict[str, str]) -> Letters:
    """The letters of a text."""
    words, _ = read_symbols(table, replace(SPECS["thin"], words=raw), {})
    moving, every, turned = Counter[Name](), Counter[Name](), set[Name]()
    for one in printed(document.statements, {}, {}, words):
        for node in parts(one.sides):
            if node.kind == "symbol" and node.written:
                name = (node.written.letter, node.written.index)
                every[name] += 1
                moving[name] += node.written.dots > 0
            inside = [(p.written.letter, p.written.index) for p in walk(node) if p.written]
            moving.update(inside if node.kind == "derivative" else ())
            turned.update(inside if node.kind == "function" else ())
    return Letters(+moving, every, turned)


def _renamings(family: str, letters: Letters) -> Iterator[Renamed]:
    """How the letters of a text may stand for the coordinates of a system: none, or each way that has them all."""
    moving, mentioned = letters.moving, letters.every
    turning = [name for name in letters.angles if name in moving] or letters.angles
    turning = [
        n for n in turning if n[1] or not {(n[0], "1"), (n[0], "2")} <= {*turning}
    ]  # of q = (q_1, q_2) the parts
    single, pair = [n for n in turning if n[1] in ("", "1", "0")], [n for n in turning if n[1] in ("1", "2")]
    usual = sorted(turning, key=lambda name: -mentioned[name])
    if family in ("plane", "cart-pole") and usual[1:] and mentioned[usual[0]] > RARELY * mentioned[usual[1]]:
        turning = single = usual[:1]  # another letter may be a slip
    if family == "plane" and len(turning) == 1:
        yield {single[0]: Written("theta")} if single else {}
    elif family in ("double", "acrobot") and len(turning) == 2:
        first, second = pair if len(pair) == 2 else turning
        yield {first: Written("theta", 0, "1"), second: Written("theta", 0, "2")}
        if len(pair) != 2:
            yield {second: Written("theta", 0, "1"), first: Written("theta", 0, "2")}
    elif family == "polar" and len(turning) == 2 and not pair:
        for first, second in (turning, turning[::-1]):
            yield {first: Written("theta"), second: Written("phi")}
    elif family == "cart-pole":
        slides = [name for name in sorted(moving) if name[0] in "xsqzp" and name[1] in ("", "1", "c")]
        if slides and len(turning) == 1 and turning[0] not in slides:
            yield {slides[0]: Written("x"), turning[0]: Written("theta")}
        if {("q", "1"), ("q", "2")} <= moving.keys():
            yield {("q", "1"): Written("x"), ("q", "2"): Written("theta")}


def _most(reading: Reading) -> float:
    """How much would hold if every equation did."""
    spec = reading.system.spec
    readings = [next(one.readings()) for one in reading.equations[:MOST_COUNTED] if one.ways and not one.defines]
    return sum(weight(equation, spec) for equation in readings)


def _doubted(reading: Reading, held: int, document: Document) -> Reading:
    """The same, as of no system that pendpin knows where too little of the text holds in the best one."""
    read = [one for one in reading.equations if one.ways and not one.defines]
    foreign = bool(FOREIGN.search(document.text)) or bool(_strange(reading))
    if not ELSEWHERE.search(document.text) and (held or not read or (len(read) < FEW and not foreign)):
        return reading
    words = "No system that pendpin knows fits this text"
    return replace(reading, title=UNKNOWN, remarks=(f"{words}: {reading.remedy}.",), unknown=True)


def _strange(reading: Reading) -> set[str]:
    """The letters with rates that have no meaning in a system."""
    derivatives = [p for one in reading.equations for p in parts(one.sides) if p.kind == "derivative"]
    moved = {str(p.children[0].value) for p in derivatives if p.children[0].kind == "symbol"}
    return {name for name in moved if name.startswith("?")} - {one.defines for one in reading.equations}


def read_symbols(
    table: dict[str, str], spec: Spec, renamed: Renamed, text: str = ""
) -> tuple[Vocabulary, dict[str, Node]]:
    """The words of a system, with symbols that are given as other names, or as expressions. Raises InputError."""
    named = {name for written in renamed.values() for name in spec.words(written)[:1]} & set(spec.coordinates)
    words = Vocabulary(spec.words, dict(renamed), frozenset(spec.state), frozenset(named))
    _say(words, spec, text)
    found: dict[str, Node] = {}
    for name, text in table.items():
        try:
            left, right = _key(name), lone(str(text), words)
        except Unread as error:
            raise InputError(f"symbols.{name}: {error.reason}") from None
        if left is None:
            raise InputError(f"symbols.{name}: {shown(name)} is not one symbol")
        if right is None:
            raise InputError(f"symbols.{name}: {shown(text)} is not one expression")
        if text not in table and _is_no_name(str(text), right):
            raise InputError(f"symbols.{name}: {not_one_of(text, (*spec.state, *spec.unknowns, *spec.parameters))}")
        if right.kind == "symbol" and right.written and not left.dots:
            words.renamed[left.letter, left.index] = right.written
        else:
            found[words(left)[0]] = right
    return words, found


def _say(words: Vocabulary, spec: Spec, text: str) -> None:
    """Note what a text says of its symbols: other names, and which of its own meanings a letter has.

    What it says in passing is one more meaning, as is no letter's own.
    """
    for symbol, printed_names, passing in (
        *((*one, False) for one in legend(text)),
        *((*one, True) for one in named(text)),
    ):
        try:
            left = _key(symbol)
        except Unread:  # a slip such as \thta: the equations that hold it say so
            continue
        if left is None or (name := (left.letter, left.index)) in words.renamed:
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
        elif meanings[0] not in {
            *spec.state,
            *spec.still,
        }:  # what has a meaning of its own a phrase misread may not take
            words.renamed[name] = meant


def _is_no_name(text: str, node: Node) -> bool:
    """Whether a word neither names a quantity nor is a product of letters that all have a meaning."""
    unknown = any(part.startswith("?") for part in symbols(node))
    return unknown and text not in GREEK and bool(re.fullmatch("[A-Za-z]{2,}", text))


def _key(name: str) -> Written | None:
    """The name on the left of an entry of symbols; any word of letters is one."""
    if re.fullmatch(r"[A-Za-z]{2,}\d*", name):
        return of_word(name) or Written(name)
    found = lone(name, Vocabulary(raw))
    return found.written if found is not None and found.kind == "symbol" else None
