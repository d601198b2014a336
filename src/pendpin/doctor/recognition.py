"""What a text is about: every system, with every way to read its letters, scored against all equations of a section."""

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import permutations
from typing import Any

import numpy as np

from pendpin.doctor.checking.residuals import stack_residuals
from pendpin.doctor.conventions import EVERY, SINGLE, conventions_of, likeliest_rod
from pendpin.doctor.letters import Letters, Renamed, credit, letters_of, renamings, settled, telling
from pendpin.doctor.printed import Printed, Text, name_states, parse_statements
from pendpin.doctor.reading.documents import Document
from pendpin.doctor.reading.grammar import lone
from pendpin.doctor.reading.legend import read_symbols
from pendpin.doctor.reading.names import LENGTH, Vocabulary, Written, raw
from pendpin.doctor.reading.tree import Name, parts, walk
from pendpin.doctor.systems.base import LOADS, Convention, Spec, System, random_states, unloaded
from pendpin.doctor.systems.rod import RODS, SPECS
from pendpin.doctor.systems.scene import scene_spec
from pendpin.doctor.systems.tables import BODIES, FAMILIES, POSES
from pendpin.errors import InputError, not_one_of

DRIVES = {("tau", ""), ("u", ""), ("tau", "m"), ("tau", "in"), ("tau", "ext"), ("Q", "")}  # of the joint of a pendulum
TORQUES = {"tau", "u", "Q", "F", "M", "T", "B"}  # letters of torques at joints
MEASURES = {*"gmlMLRrJI"}  # letters of a page that is not in units of a pendulum
UNKNOWN = "no system that pendpin knows"
REMEDY = "say which system it is with --rod, or what its symbols are with --symbols"
# what counts for a reading, or against it, in equations that hold
ROD = 0.5  # a rod on a universal joint before any holds
LIKELIER = 0.01  # each coordinate of a system, of which the text has as many
SAID, UNSAID = 0.5, -0.75  # the words of a section name the system, or another one
LOST, MOST_LOST = 0.5, 1.5  # each letter with rates that a system does not have, and all together
ELSEWHERE, MOST_ELSEWHERE = 0.1, 3.0  # each equation of other sections, and all together
CLOSE = 2.5  # readings in which so few equations fewer hold are compared more closely
MOST_ALIKE, MOST_SETTLED = 2, 8  # how many of a family, and of all
ALONE = 1.0  # the same of a reading for which nothing else is written
OWN = 0.25  # by how much another reading has to explain a section better than that of the whole text
CLEARLY = 0.6  # by how much a reading has to explain more, so that what only another one explains is wrong
FEW = 3  # equations: fewer, none of which holds, may all be wrong
WORDS = {  # of texts about each family, and about what else tells one system from another
    "cart-pole": r"\b(?:cart|trolley|carriage|chariot|wagen|carro|carrito|carrinho|carrello|cart-?pole)s?\b|тележк|小车|"
    r"滑块|台車|카트",
    "double": r"double[- ]pendul|doppelpendel|péndulo doble|pêndulo duplo|pendule double|doppio pendolo|двойно\w* маятник|"
    r"双摆|二重振り?子|이중 ?진자|two[- ]link|acrobot|pendubot",
    "polar": r"spherical pendul|azimuth|sphärische|péndulo esférico|pendule sphérique|球面摆|球面振り?子",
    "conical": r"conical|\bcone\b|governor|centrifugal regulator|fliehkraftregler|regulador centr|kegelpend|c[óô]nic|"
    r"conique|konisch|конич|horizontal circle|horizontalen kreis|圆锥摆|円錐振り?子|원추 ?진자",
    "turning": r"\bhoop|\bbead\b|(?:turn|rotat|spin)\w* (?:with .{0,40})?(?:ring|wire|circle|loop|frame|plane|"
    r"about (?:an?|its|the) vertical)|\baro\b|\banello|\banneau|旋转圆环",
    "coupled": r"\bcoupl(?:ed|ing)|gekoppelt|acoplad|accoppiat|couplés|связанны|耦合|連成|결합",
    "furuta": r"Furuta|\b(?:rotary|rotational)(?: inverted)? pendulum|古田|旋转倒立摆|旋轉倒立擺",
    "triple": r"triple pendul|dreifachpendel|péndulo triple|pêndulo triplo|pendule triple|pendolo triplo|三摆|"
    r"тройно\w* маятник|三重振り?子|삼중 ?진자|three[- ]link",
    "elastic": r"elastic pendul|spring pendul|swinging spring|pendule élastique|péndulo elástico|pêndulo elástico|"
    r"pendolo elastico|пружинн\w* маятник|弹簧摆|ばね振り?子|탄성 ?진자",
    "pulled": r"Atwood|length.{0,30} (?:chang|var|shorten)|variable length|pulled (?:up|in)|veränderliche\w* länge|"
    r"longueur variable|longitud variable|comprimento variável|lunghezza variabile",
    "moved": r"Kapi[tc]za|Капиц|卡皮察|カピッツァ|parametric\w* (?:driven|excited)|(?:pivot|support) (?:moves|osc|vib)|"
    r"(?:vibrat|oscillat|mov|driven|shak)\w* (?:pivot|support|suspension)",
    "rod": r"cardan|universal joint|U-joint|hooke'?s? joint|gimbal",
    "upright": r"upright|inverted|invertido|invertito|inverso|inversé|inverses|перев[её]рнут|обратн\w* маятник|倒立|역진자|"
    r"도립|unstable|balanc|\btop\b|upward|stand|acrobot",
    "horizontal": r"horizontal|manipulator|\barm\b|elbow|x[- ]axis|two[- ]link|acrobot|pendubot|gymnast",
    "arm": r"\brotary\b|\barm (?:rotation|angle|yaw|turns)|\barm\b[^.]{0,90}\b(?:turn|rotat)|(?:rotat|turn)\w* arm|"
    r"horizontal arm|旋臂|旋转臂",
    "spring": r"spring|elasti|ressort|muelle|resorte|\bmola\b|feder|molla|пружин|弹簧|彈簧|ばね|バネ|용수철",
    # systems that pendpin does not know
    "foreign": r"\b(?:roll\w*|dis[ck]|wheel|spring|elastic|hoop|bead|pulley|satellite|planet|orbit\w*|spool|ladder|"
    r"gyroscope|spinning top|projectile|vibrat\w*|oscillates|rocket|charge|oscillator|beam|plate|fluid|Atwood|Kepler)\b",
}
RELATED = {"acrobot": "double", "cart-double": "cart-pole"}  # families that the same words name
CHAINED = re.compile(r"\\(?:up|down)arrow|\bchain\b")


@lru_cache(maxsize=200)
def words_of(text: str) -> set[str]:
    """What the words of a text are about, as WORDS names it."""
    return {name for name, words in WORDS.items() if re.search(words, text, re.I)}


@dataclass(frozen=True, eq=False)
class Reading:
    """The equations of a document read as those of one system. `chosen` says that the user named the system."""

    equations: list[Printed]
    words: Vocabulary  # to which they are bound
    system: System
    title: str
    remarks: tuple[str, ...] = ()
    chosen: bool = False
    unknown: bool = False
    conventions: tuple[Convention, ...] = ()  # others, under one of which an equation may be right
    small: bool = False  # what holds for small angles counts, where nothing else does

    @cached_property
    def credits(self) -> np.ndarray:
        """What each equation counts for this reading, (n,): 0 where it does not hold."""
        counts = np.zeros(len(self.equations))
        for one in telling(self.equations):
            counts[one.number - 1] = credit(one, self.system, self.small)
        return counts

    @cached_property
    def strangers(self) -> list[set[str]]:
        """The letters with rates in each equation that this system does not have and the text does not define."""
        known = {one.defines for one in self.equations}
        known |= {f"?d{name.lstrip('?')}" for name in known}
        return [{letter for name, letter in one.strange_rates if name not in known} for one in self.equations]

    def score(self, inside: np.ndarray, text: str) -> float:
        """How well it explains a section and its words: its own equations, and a little those of the others.

        A system of more coordinates counts a little more, and a rod on a joint, of which this is about.
        """
        kinds = self.system.kind.split()
        family = "rod" if kinds[0] in RODS else RELATED.get(kinds[0], kinds[0])
        words = words_of(text)
        said = words & {*FAMILIES, "rod"}
        holds = bool(self.credits[inside].any())  # what the words name counts where something holds
        prior = 0.0 if not said else SAID * holds if family in said else UNSAID
        prior += (LIKELIER if "upright" in words else UNSAID) * ("up" in kinds) - 0.3 * ("mirrored" in kinds)
        letters = set[Name]().union(*(one.letters for one in self.equations))
        single = not any({(letter, "1"), (letter, "2")} <= letters for letter in "mM")  # a rod has one mass
        prior += ROD * single if family == "rod" else LIKELIER * len(self.system.spec.coordinates)
        lost = set().union(*(strange for strange, here in zip(self.strangers, inside, strict=True) if here))
        elsewhere = min(MOST_ELSEWHERE, ELSEWHERE * float(self.credits[~inside].sum()))
        return float(self.credits[inside].sum()) + elsewhere + prior - min(MOST_LOST, LOST * len(lost))

    def says(self, one: Printed) -> str:
        """What an equation says that is no law: a state, or a choice of parameters; empty for what may be a law."""
        sides, spec = one.sides, self.system.spec
        names = [side.names - {"pi"} for side in sides]
        every = set().union(*names)
        if any(part.kind == "product" and any(factor.value == 0 for factor in part.children) for part in parts(sides)):
            return "it gives a state at an instant, and no law: nothing to check"  # theta(0) = theta_0
        if len(sides) == 2 and sides[0].kind == "symbol" and sides[0].value in names[1] & {*spec.state}:
            return "it gives a state a new value: nothing to check"
        entries = [part for side in sides for part in (side.children if side.kind == "matrix" else (side,))]
        vector = "q_i" in every or any(side.kind == "matrix" for side in sides)
        if vector and all(part.kind == "symbol" for part in entries):
            return "it gives the states their names: nothing to check"
        if "t" in spec.parameters and all(inside and inside <= {"a", "nu", "t"} for inside in names[1:]):
            return "it says how the pivot moves: nothing to check"
        below = [[*walk(side)] for side in sides]  # each side a number times one symbol at most
        plain = all(part.kind in ("symbol", "number", "product", "power") for inside in below for part in inside)
        multiples = plain and all(sum(part.kind == "symbol" for part in inside) <= 1 for inside in below)
        if every <= spec.still and multiples and (not self.chosen or _can_be_chosen(one, names, self.system)):
            return "it chooses a parameter: nothing to check"  # else J may be called I
        values = [side for side, inside in zip(sides, names, strict=True) if not inside]
        alone = all(side.kind == "symbol" for side in sides if side not in values)
        states = {*spec.state, *(name for name in spec.formulas if name.startswith(("sin", "cos")))}
        if values and not one.statement.name and ((alone and len(every) == 1) or every <= states) and not one.defines:
            return "it gives a state or a value, and no law: nothing to check"
        return ""


@dataclass(frozen=True, eq=False)
class Recognition:
    """A document as it was read. Of each equation the reading of its section, and `close` ones that explain as much.

    `others` are all readings of the page, also those that explain little.
    """

    main: Reading
    chosen: tuple[Reading, ...]
    close: tuple[tuple[tuple[float, Reading], ...], ...]  # and by how much less each explains
    others: tuple[Reading, ...] = ()

    @property
    def equations(self) -> list[Printed]:
        """Each equation as its own reading has it."""
        return [reading.equations[i] for i, reading in enumerate(self.chosen)]

    @property
    def title(self) -> str:
        """What the document is about."""
        every = [reading.title for reading in dict.fromkeys((self.main, *self.chosen))]
        return " and ".join(dict.fromkeys(every)) if not self.main.unknown else self.main.title


def _can_be_chosen(one: Printed, names: list[frozenset[str]], system: System) -> bool:
    """Whether parameters may be equal: one is a number, also of metres, or neither is always the larger."""
    lengths = {name for name in system.spec.still if system.spec.dimensions[name] == LENGTH}
    if not all(names) or ({"m"} in names and lengths.intersection(*names[:1])):
        return True
    rows = (stack_residuals(equation, random_states(system), plain=True) for equation in one.sound)
    return any(row.min() <= 0 <= row.max() for row in rows)


def check_choices(rod: str | None, convention: str | None) -> None:
    """Check the names of a system and of a convention. Raises InputError."""
    if rod is not None and rod not in (*RODS, *FAMILIES):
        raise InputError(f"rod: {not_one_of(rod, (*RODS, *FAMILIES))}")
    conventions_of(convention or "")


@dataclass(frozen=True, eq=False)
class _Page:
    """A document, its equations as they are written, what the user says of its symbols, and its choices."""

    document: Document
    written: list[Printed]
    table: dict[str, str]
    kind: str | None
    convention: str | None

    @cached_property
    def text(self) -> Text:
        """Its equations with the names that they give themselves."""
        return Text(name_states(self.written))

    @cached_property
    def letters(self) -> list[Letters]:
        """The letters of the whole document, and of each section."""
        every = self.text.bind(read_symbols(self.table, replace(SPECS["thin"], words=raw), {}))
        each = [[every[i] for i in np.flatnonzero(inside)] for inside, _ in self.sections]
        return [letters_of(equations) for equations in (every, *(each if len(each) > 1 else ()))]

    @property
    def sections(self) -> Iterator[tuple[np.ndarray, str]]:
        """Of each section which equations stand in it, and its text."""
        where = np.array([one.statement.section for one in self.text.raw])
        for section in sorted(set(where.tolist())):
            texts = self.document.sections
            yield where == section, texts[section] if section < len(texts) else self.document.text

    def words(self, spec: Spec, renamed: Renamed) -> Vocabulary:
        """What the letters of the document mean for a system, some of them renamed."""
        return self.text.own_words(read_symbols(self.table, spec, renamed, self.document.text))


def read(document: Document, choices: dict[str, Any]) -> Recognition:
    """The equations of a document, those of each section read as of the system that explains most. Raises InputError."""
    kind, convention = choices.get("rod") or document.rod, choices.get("convention") or document.convention
    check_choices(kind, convention)
    table = {**document.symbols, **choices.get("symbols", {})}
    page = _Page(document, parse_statements(document.statements), table, kind, convention)
    if scene := choices.get("scene"):
        spec = scene_spec(scene)
        words = page.words(spec, {})
        reading = Reading(page.text.bind(words), words, System(spec), spec.title, (), True)
        return Recognition(reading, (reading,) * len(page.text.raw), ((),) * len(page.text.raw))
    whole = np.ones(len(page.text.raw), dtype=bool)
    readings = sorted(_readings(page), key=lambda one: -one.score(whole, document.text))
    if readings[0].credits.sum() < 1:  # nothing holds: perhaps for small angles
        small = sorted((replace(one, small=True) for one in readings), key=lambda one: -one.score(whole, ""))
        readings = small if any(one.credits.sum() for one in small) else readings
    return _by_section(page, readings)


def _closest(page: _Page, readings: list[Reading], inside: np.ndarray, text: str) -> list[Reading]:
    """The readings that explain a section about as well, few of a family, each letter of which has one meaning."""
    scores = {id(one): one.score(inside, text) for one in readings}
    best, found = max(scores.values()), list[Reading]()
    often = Counter[str]()
    for one in sorted(readings, key=lambda one: -scores[id(one)]):
        family = " ".join(word for word in one.system.kind.split() if word in (*FAMILIES, *RODS, *POSES))
        if scores[id(one)] > best - CLOSE and often[family] < MOST_ALIKE and len(found) < MOST_SETTLED:
            often[family] += 1
            words = settled(page.text, one.words, one.system, inside)
            found.append(replace(one, equations=page.text.bind(words), words=words))
    return found


def _by_section(page: _Page, readings: list[Reading]) -> Recognition:
    """Each section read as by what explains it best, with the others that explain about as much."""
    text, count = page.document.text, len(page.text.raw)
    whole = np.ones(count, dtype=bool)
    near = _closest(page, readings, whole, text)
    main = replace(max(near, key=lambda one: one.score(whole, text)), chosen=page.kind is not None)
    main = main if main.chosen or main.unknown else _doubted(main, text)
    chosen: list[Reading] = [main] * count
    close: list[tuple[tuple[float, Reading], ...]] = [()] * count
    furuta = "furuta" in words_of(text)  # some of its equations are a rod's
    if main.chosen or (main.unknown and furuta):
        return Recognition(main, tuple(chosen), tuple(close))
    sections = [*page.sections]
    for inside, words in sections:
        here, scores, best = _explaining(page, readings, [main, *near], inside, words, len(sections) > 1)
        mine, less = here[best], [scores[best] - score for score in scores]
        found = [pair for pair in zip(less, here, strict=True) if pair[0] < CLEARLY and pair[1] is not mine]
        # the same system with other bodies, if more than one equation says so, or upright, if the words of the page do
        upright = "down" in mine.system.kind.split() and "upright" in words_of(text)
        for one in (one for one in readings if one.system != mine.system):
            other = {*one.system.kind.split()} ^ {*mine.system.kind.split()}
            more = other <= {*BODIES} and (one.credits > mine.credits).sum() > 1
            if more or (upright and other == {"down", "up"}):
                found.append((CLEARLY, one))
        every = tuple(found)
        # what moves letters that the section's system does not have is about another one: a bob before two of them
        strange = np.array([bool(letters) for letters in mine.strangers]) & inside
        others = _closest(page, readings, strange, words) if strange.any() else [mine]
        other = max(others, key=lambda one: one.score(strange, words))
        apart = strange & (other.credits > mine.credits)
        if not other.credits[strange].any() and not any(other.strangers[i] for i in np.flatnonzero(strange)):
            apart, other = strange, replace(other, unknown=True)
        for i in np.flatnonzero(inside):
            chosen[i], close[i] = (other, tuple((0.0, one) for one in others)) if apart[i] else (mine, every)
    main = next((one for one, _ in Counter(chosen).most_common() if not one.unknown), main)
    return Recognition(main, tuple(chosen), tuple(close), tuple(readings))


def _explaining(
    page: _Page, readings: list[Reading], near: list[Reading], inside: np.ndarray, words: str, several: bool
) -> tuple[list[Reading], list[float], int]:
    """Readings that may explain a section, how well each does, and the place of the best; the page's, `near`, first."""
    main = near[0]
    # of a long text the last equations are not counted: that says nothing against its reading
    saying = [one.number - 1 for one in telling(main.equations) if inside[one.number - 1] and not one.defines]
    wanting = several and not main.credits[saying].all()
    here = [*near, *(_closest(page, readings, inside, words) if wanting else ())]
    scores = [one.score(inside, words) for one in here]
    best = int(np.argmax(scores))
    if scores[0] > scores[best] - OWN or not here[best].credits[inside].any():
        best = 0  # the page's own, if as good
    if not here[best].credits[inside].all():  # the same with the angles from elsewhere, though no words say so
        kind, known, loads = here[best].system.kind, len(here), {*LOADS} & {*here[best].system.spec.parameters}
        for spec in FAMILIES.get(kind.split()[0], ()):
            if spec.kind != kind and {*spec.kind.split()} ^ {*kind.split()} <= {*POSES, "mirrored"}:
                system = System(spec if loads else unloaded(spec))
                here.append(replace(here[best], system=system, title=spec.title, unknown=False))
                scores.append(here[-1].score(inside, words))
        says_so = (i for i in range(known, len(here)) if here[i].credits.any())
        best = max((best, *says_so), key=lambda i: scores[i])
    little = (here[best].credits[saying] == 0).sum() > max(1, len(saying) / 2)
    if several and little:  # letters of other sections may hide what it says by itself
        kept = zip(page.written, inside, strict=True)
        lone = replace(page, written=[one if own else replace(one, ways=()) for one, own in kept])
        alone = _closest(lone, [*_readings(lone)], inside, words)
        own = [one.score(inside, words) for one in alone]
        if max(own) > scores[best] + ALONE:
            return alone, own, int(np.argmax(own))
    return here, scores, best


def _readings(page: _Page) -> Iterator[Reading]:
    """The equations of a page as those of each system that it may be about."""
    if page.kind not in FAMILIES:
        yield from _rods(page)
    if page.kind not in RODS and page.convention is None:
        yield from _others(page)


def _rods(page: _Page) -> Iterator[Reading]:
    """The equations read as those of a rod on a universal joint, also with other names of its angles in both orders.

    Each is of the kind and in the convention that explain most.
    """
    namings: list[Renamed] = [{}]
    for found in page.letters:
        letters = [name for name in found.angles if name in found.moving and name[1] in ("", "1", "2")]
        if len(letters) == 2 and not {"theta", "phi"} <= {name[0] for name in letters}:
            orders = permutations((Written("theta"), Written("phi")))
            namings += [one for order in orders if (one := dict(zip(letters, order, strict=True))) not in namings]
    own, said = page.kind in RODS, page.convention
    kinds = (str(page.kind),) if own else RODS
    for renamed in namings:
        words = page.words(SPECS["thin"], renamed)
        words.usual.update({f"?{name[0]}": node for name in ("sin", "cos") if (node := lone(f"{name}(phi)", words))})
        equations, remarks = page.text.bind(words), list[str]()
        # angles whose names are guessed are tried in both orders
        conventions = [c for c in EVERY if not (renamed and c.swapped)] if said is None else [conventions_of(said)]
        system = likeliest_rod(equations, kinds, conventions)
        title, chained = system.spec.title, not own and len(CHAINED.findall(page.document.text)) > 3
        if renamed:
            text = ",".join(f"{'_'.join(name).rstrip('_')}={angle.letter}" for name, angle in renamed.items())
            remarks.append(f"The angles are read so that most equations hold; confirm it with --symbols {text}.")
        if chained:
            title = "a chain of rods, each equation as one of a single rod"
            remarks.append("This text is about a chain of rods: give the chain as --scene to have it checked.")
        if system.convention.words:
            remarks.append(f"The text has its own convention: {system.convention.words}.")
        if system.kind == "point" and not own:
            remarks.append(f"These are equations of {SPECS[system.kind].title}; for a rod with mass write --rod thin.")
        others = SINGLE if said is None else ()
        yield Reading(equations, words, system, title, tuple(remarks), own, chained, others)


def _others(page: _Page) -> Iterator[Reading]:
    """The equations read as those of each other system whose coordinates the text may have."""
    text, every = page.document.text, page.letters[0].every
    inertias = any(re.fullmatch("[IJ][a-z]?", name[0]) for name in every) or re.search("inertia|gyration", text)
    unequal = any({(letter, "1"), (letter, "2")} <= every.keys() for letter in "mMlL")
    unequal = unequal and not re.search(r"m_\{?1\}?\s*=\s*m_\{?2|l_\{?1\}?\s*=\s*l_\{?2|L_\{?1\}?\s*=\s*L_\{?2", text)
    driven = any(name[0] in TORQUES for name in every)
    masses = {name for name in every if name[0] in ("m", "M")}
    said = words_of(text)
    timed = (one.kind == "function" and "?t" in one.names for raw in page.text.raw for one in parts(raw.sides))
    points = not (inertias or re.search("uniform|homogen|slender|physical", text))
    may = {  # what only some texts are about
        "acrobot": driven,
        "moved": points and any(timed),
        "elastic": "spring" in said,
        "pulled": "spring" not in said and {("l", ""), ("L", ""), ("r", "")} & page.letters[0].moving.keys(),
        "conical": "conical" in said,
        "turning": "turning" in said,
        "coupled": {"coupled", "spring"} <= said,
        "furuta": bool(said & {"furuta", "arm"}),
        "triple": points and any(name[1] == "3" for name in page.letters[0].turned),
        "polar": "rod" not in said or "polar" in said,
    }
    for family, specs in FAMILIES.items():
        if page.kind != family and (page.kind or not may.get(family, True)):
            continue
        # simple ones unless it says so
        bodies = sorted(specs, key=lambda spec: (" any" in spec.kind) != bool(inertias))
        every_way = [one for letters in page.letters for one in renamings(family, letters)]
        ways = [one for i, one in enumerate(every_way) if one not in every_way[:i]]
        # the user says it, though no coordinate is in it, or a page on periods and inertias has none
        periods = family == "plane" and ("pi", "") in every and not page.letters[0].angles
        places = family == "polar" and {(name, "") for name in "xyz"} <= page.letters[0].moving.keys()
        still = page.kind == family or periods or places or family == "conical"
        for renamed in ways or [Renamed()] * still:
            bound_to: dict[tuple[str, bool], tuple[Vocabulary, list[Printed]]] = {}
            for spec in bodies:
                sideways, drive = (f" {word}" in spec.kind for word in ("horizontal", "driven"))
                other = (sideways and "horizontal" not in said) or (drive and not every.keys() & DRIVES)
                other = other or (" unit" in spec.kind and any(name[0] in MEASURES for name in every))
                other = other or ("-" in spec.kind.split()[1] and len(masses) != 2)
                if other or (" equal" in spec.kind and unequal):
                    continue
                alike = spec.kind.split()[1], drive  # of a body and a drive all names are the same
                if alike not in bound_to:
                    words = page.words(spec, renamed)
                    bound_to[alike] = words, page.text.bind(words)
                words, equations = bound_to[alike]
                loaded = any(e.names & {*LOADS} for one in equations for e in one.meant)
                yield Reading(equations, words, System(spec if loaded else unloaded(spec)), spec.title)


def _doubted(reading: Reading, text: str) -> Reading:
    """The same, as of no system that pendpin knows where too little of the text holds in the best one."""
    readable = [one for one in reading.equations if one.ways and not one.defines]
    foreign = "foreign" in words_of(text) or any(reading.strangers)
    holds = int(reading.credits.sum())
    furuta = "furuta" in words_of(text) and not reading.system.kind.startswith("furuta")
    if not (furuta and holds < 2 * FEW) and (holds or not readable or (len(readable) < FEW and not foreign)):
        return reading
    words = f"No system that pendpin knows fits this text: {REMEDY}."
    return replace(reading, title=UNKNOWN, remarks=(words,), unknown=True)
