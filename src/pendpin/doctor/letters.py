"""The letters of a text: which may stand for the coordinates of a system, and the meaning under which most of it holds.

What holds in a reading counts. An equation that holds only if a letter means there another thing than everywhere else in its
section does not hold. A letter that the text defines itself has that meaning, whatever it usually stands for.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import islice, permutations, product
from operator import itemgetter

import numpy as np

from pendpin.doctor.checking.check import quantity_of
from pendpin.doctor.checking.conditions import loads_at_zero, small_angles
from pendpin.doctor.checking.residuals import Equation
from pendpin.doctor.printed import MOST_KNOWN, Printed, Text, holding, letters_in
from pendpin.doctor.reading.names import ANGLES, ENERGY, MASS, Vocabulary, Written, of_coordinate
from pendpin.doctor.reading.states import COORDINATE
from pendpin.doctor.reading.tree import Name, names_in, parts, walk
from pendpin.doctor.systems.base import Spec, System
from pendpin.doctor.systems.tables import FAMILIES

Renamed = dict[Name, Written]  # what letters of a text stand for

_ANGLE_LETTERS = "theta phi alpha beta psi gamma q varphi vartheta delta chi xi eta"
ANGLE_LETTERS = set(_ANGLE_LETTERS.split())
SLIDES = "xXsqzpyudr"  # letters of what slides
MOST_ANGLES, MOST_SLIDES = 5, 2
RARELY = 15  # times that a letter stands more often than another that is a slip
MOST_COUNTED = 60  # equations that tell which system a text is about
MOST_TRIED = 24  # meanings of letters in equations that do not hold
MOST_LOADS = 3  # unknown forces and dampings of an equation that holds without them
HARDLY = 0.25  # equations: what one such as L = T - V counts, of names alone
ANSWER, NAMED = 2.0, 0.5  # what a definition that comes to an acceleration, or is named like a quantity, counts
MOST_CHANGED = 4  # letters of a text that mean what they usually do not
TWINS = {"1": "2", "2": "1"}  # indices of two like bodies
OFTEN = 2  # equations that hold with one meaning of a letter, so that a single other one is a slip


@dataclass(frozen=True)
class Letters:
    """The letters of a text with their indices: those that have rates, and all, each with how often; and its angles."""

    moving: Counter[Name]
    every: Counter[Name]
    turned: set[Name]  # in sines and cosines

    @property
    def angles(self) -> list[Name]:
        """Those that may be angles: the usual letters, and those in a sine or cosine that move or are one of several."""
        turned = {name for name in self.turned if name in self.moving or name[1].strip("[]").isdigit()}
        return [name for name in sorted(self.every) if name[0] in ANGLE_LETTERS or name in turned]


def letters_of(equations: list[Printed]) -> Letters:
    """The letters of some equations of whose letters nothing is known."""
    moving, every, turned = Counter[Name](), Counter[Name](), set[Name]()
    for node in (node for one in equations for node in parts(one.sides)):
        if node.kind == "symbol" and node.written:
            name = node.written.name
            every[name] += 1
            moving[name] += node.written.dots > 0
        inside = [p.written.name for p in walk(node) if p.written and p.kind == "symbol"]
        moving.update(inside if node.kind == "derivative" else ())
        turned.update(inside if node.kind == "function" and node.value in ("sin", "cos", "tan") else ())
    return Letters(
        Counter({name: often for name, often in moving.items() if often and name[0] != COORDINATE}), every, turned
    )


def renamings(family: str, letters: Letters) -> Iterator[Renamed]:
    """How the letters of a text may stand for the coordinates of a system: every way, the letters seen most first."""
    often, coordinates = letters.every, FAMILIES[family][0].coordinates
    turning = [name for name in coordinates if name.startswith(ANGLES)]
    if letters.moving.keys() <= {("x", "")} and (COORDINATE, "1") in often:  # a linear model alone, x' = A x + B u
        yield {}
    angles = sorted(letters.angles, key=lambda name: -often[name])
    angles = [name for name in angles if name[1] != "0" or (name[0], "") not in often]  # theta_0 is where theta begins
    alone = [name for name in angles if name in letters.moving] or angles  # a page may begin with one pendulum
    if len(coordinates) > 1:
        angles = [name for name in angles if name in alone or (name in letters.turned and name[1])]
        indexed = {name[0] for name in angles if name[1] in ("1", "2")}  # of q = (q_1, q_2) the parts are the angles
        angles = [name for name in angles if name[1] or name[0] not in indexed][:MOST_ANGLES]
    else:
        angles = [name for name in alone if often[name] * RARELY >= often[alone[0]]]
    sliding = {*SLIDES, *(("l", "L", "rho") if family in ("elastic", "pulled") else ())}
    moving = {*letters.moving, *((("s", ""), ("x", "")) if ("v", "") in often else ())} & often.keys()  # v is its rate
    slides = [name for name in moving - letters.turned if name[0] in sliding or name[1][:1] == "["]
    slides = sorted(slides, key=lambda name: (name in angles, -often[name], name))[:MOST_SLIDES]
    # an azimuth, and a cart in a vector of states, stand in no sine
    others = [name for name in slides if name[1] and "phi" in coordinates and name not in angles]
    if "theta1" in coordinates:  # numbers count the bodies
        slides = [name for name in slides if not name[1].isdigit()]
    else:
        slides += [(name[0], f"[{i}]") for name in angles if name[1][:1] == "[" for i in range(3)]
    carts = [(name,) for name in dict.fromkeys(slides)] if len(coordinates) > len(turning) else [()]
    for cart, turned in product(carts, permutations([*angles, *others], len(turning))):
        names = (*cart, *turned)
        if len({*names}) == len(names) and turned[0] in angles and ("phi" in coordinates or _numbered(turned, letters)):
            found = _with_rates(dict(zip(names, map(of_coordinate, coordinates), strict=True)), letters)
            for slide in (name for name in cart if name not in letters.moving):  # v and a are the rates of a cart
                rates = {("v", ""): replace(found[slide], dots=1), ("a", ""): replace(found[slide], dots=2)}
                found |= {name: rate for name, rate in rates.items() if name in often}
            found |= _namesakes(found, letters)
            yield from (found | masses for masses in _masses(family, letters))


def _namesakes(renamed: Renamed, letters: Letters) -> Renamed:
    """Names that have that of a coordinate in them: the momentum p_phi, and phi_0, where phi begins."""
    named, found = {letter + index: one for (letter, index), one in renamed.items() if not one.dots}, Renamed()
    for letter, index in letters.every:
        if letter == "p" and (one := named.get(index.replace("_", ""))):
            found[letter, index] = Written("p", 0, one.letter + one.index)
        elif index in ("0", "m", "max") and (one := named.get(letter)):
            found[letter, index] = replace(one, index=index)
    return found


def _masses(family: str, letters: Letters) -> Iterator[Renamed]:
    """How two masses, one of them with an index of the text's own, may be those of a system: either may be the first."""
    spec = FAMILIES[family][0]
    masses = [name for name in spec.parameters if spec.dimensions[name] == MASS]
    names = sorted(name for name in letters.every if re.fullmatch("[mM][a-z]?", name[0]))
    if len(names) == len(masses) == 2 and not all(spec.words(Written(name[0], 0, name[1])) for name in names):
        yield from (dict(zip(order, map(of_coordinate, masses), strict=True)) for order in permutations(names))
    else:
        yield {}


def _numbered(names: tuple[Name, ...], letters: Letters) -> bool:
    """Whether angles are those of bodies in turn: one letter with rising indices, or several with none, or with 1, 2."""
    indices = [index for _, index in names]
    if ((names[0][0], "3") in letters.turned) != (len(names) == 3) and len(names) > 1:  # three pendulums
        return False
    if len({letter for letter, _ in names}) == 1:
        return indices == sorted(indices)
    return not any(indices) or indices == ["1", "2"]


def _with_rates(renamed: Renamed, letters: Letters) -> Renamed:
    """The same with names of rates: the usual ones, and in a vector of four states, where no coordinate has one.

    theta1_ddot may stand beside angle1, or beside y[0]; of x[1] and x[2] the rates are x[3] and x[4].
    """
    if renamed.keys() & letters.moving.keys():
        return renamed
    (vector, *others), places = {name[0] for name in renamed}, sorted(name[1] for name in renamed)
    apart = [name for name in letters.moving if name[0] in ANGLE_LETTERS and name not in letters.turned]
    renamed |= {key: name for name in renamed.values() for key in apart if key[1] == name.index}
    named = any(letter in ("omega", "w") for letter, _ in letters.every)  # the usual names of angular velocities
    speeds = {("v", index): replace(one, dots=1) for (_, index), one in renamed.items() if index.isdigit()}
    if len(speeds) > 1 and speeds.keys() <= letters.every.keys() - letters.turned and not named:
        return renamed | speeds
    if others or not all(re.fullmatch(r"\[\d\]", place) for place in places):
        return renamed
    begin = 0 if (vector, "[0]") in {*letters.every, *renamed} else 1
    rates = [place for place in (f"[{i}]" for i in range(begin, begin + 4)) if place not in places]
    pairs = zip(places, rates, strict=False)
    return renamed | {(vector, rate): replace(renamed[vector, place], dots=1) for place, rate in pairs}


def weight(equation: Equation, spec: Spec) -> float:
    """What an equation counts: those of motion and energy say most, and what is true of every system hardly anything."""
    every, accelerations = [*parts(equation.sides)], {name for name in spec.unknowns if name.startswith("dd")}
    moves = any(part.kind == "derivative" or part.value in accelerations for part in every)
    still = equation.names if moves else names_in(equation.sides, {})  # a' = b, where b is computed
    saying = ("product", "power", "function") if moves else ("product", "power")
    if not still & spec.still and not any(part.kind in saying for part in every):
        return HARDLY  # as L = T - V, or a name for a sine
    energies = {name for name in equation.names if name[0] in "TVL" and spec.dimensions.get(name) == ENERGY}
    return 2.0 if energies or equation.names & accelerations else 1.0


def telling(equations: list[Printed]) -> list[Printed]:
    """The equations that tell which system a text is about: the first that hold more than a name and its value."""
    return [one for one in equations if one.ways and len(one.names) > 1][:MOST_COUNTED]


def held(equations: list[Printed], system: System) -> float:
    """How many equations hold; those of motion and energy, which say most, twice."""
    return sum(credit(one, system) for one in telling(equations))


@lru_cache(maxsize=MOST_KNOWN)
def credit(one: Printed, system: System, small: bool = False) -> float:
    """What an equation counts for a system, or for `small` angles: nothing where it does not hold."""
    equation = None if small else holding(one, system)
    if small and not one.defines:
        equation = next((reading for reading in one.readings() if small_angles(reading, system)), None)
    if equation is not None:
        return weight(equation, system.spec)
    if not small and (quantity := quantity_of(one, system)):
        return ANSWER if quantity[0] in (*system.spec.unknowns, "ddq") else NAMED
    if 0 < len(one.lacking) <= MOST_LOADS and one.ways and not one.defines:
        return float(any(loads_at_zero(e, system, one.lacking) for e in one.meant))
    return 0.0


def settled(text: Text, words: Vocabulary, system: System, inside: np.ndarray) -> Vocabulary:
    """The words in which each letter has the meaning with which most of those `inside` a section hold."""
    here = lambda words: text.bind(words, inside)  # noqa: E731
    if telling(here(words)):
        for _ in range(MOST_CHANGED):
            section, better = here(words), dict[Name, str]()
            own, most = _own(section, system, words), held(section, system) + HARDLY
            singles = ({name: meaning} for name, meaning in islice(_other_meanings(section, system, words), MOST_TRIED))
            for change in filter(None, (own, *singles)):
                if (count := held(here(words.choosing(change)), system)) > most:
                    most, better = count, change
            # a letter that need not be the text's own is not
            for name in own if better is own and len(own) > 1 else ():
                fewer = {other: meaning for other, meaning in better.items() if other != name}
                better = fewer if held(here(words.choosing(fewer)), system) >= most else better
            if not better:
                break
            words = words.choosing(better)
        words = _agreed(text, system, words)
    return words


def _meanings(name: Name, words: Vocabulary) -> list[str]:
    """What a letter can mean, without dots."""
    if name in words.chosen:
        return []
    every = [one for bold in (False, True) for one in words(Written(name[0], 0, name[1], bold))]
    return [meaning for meaning in dict.fromkeys(every) if not meaning.startswith("?")]


def _own(equations: list[Printed], system: System, words: Vocabulary) -> dict[Name, str]:
    """The letters that equations which do not hold define, all as the text's own: a = (m_1 + m_2) l_1, b = ..."""
    found: dict[Name, str] = {}
    for one in (one for one in equations if len(one.sides) == 2 and holding(one, system) is None):
        named, other = one.sides
        if named.kind == other.kind == "symbol" and named.value in system.spec.state:  # theta1dot = z1
            named, other = other, named
        if named.kind == "symbol" and (written := named.written) and not written.dots and other.names:
            meanings = _meanings(written.name, words)
            if meanings and not {*meanings} & {*system.spec.state}:
                found[written.name] = ""
    return found


def _other_meanings(equations: list[Printed], system: System, words: Vocabulary) -> Iterator[tuple[Name, str]]:
    """Letters of equations that do not hold, with each other meaning; none, "", for those that the text may define."""
    readable = [one for one in equations if one.ways]
    wrong = [one for one in readable if holding(one, system) is None]
    used = {id(one): one.letters | letters_in(one.definitions.values()) for one in readable}
    right = set[Name]().union(*(used[id(one)] for one in readable if one not in wrong))
    lone = letters_in(side for one in wrong for side in one.sides if side.kind == "symbol")
    for name, _ in Counter(name for one in wrong for name in sorted(used[id(one)])).most_common():
        meanings = _meanings(name, words)
        own = (name in lone or name not in right) and meanings
        if own and not set(meanings) & {*system.spec.state, *system.spec.unknowns}:
            yield name, ""
        yield from ((name, meaning) for meaning in (meanings if len(meanings) > 1 else ()))


def _agreed(text: Text, system: System, words: Vocabulary) -> Vocabulary:
    """The words, where a letter that means another thing in one equation alone means there what it does elsewhere."""
    count = lambda words: sum(holding(one, system) is not None for one in text.bind(words))  # noqa: E731
    for _ in range(MOST_CHANGED):
        now = count(words)
        changes = [words.choosing({name: usual}) for name, usual in _slips(text.bind(words), system, words)]
        lost, other = min(((now - count(other), other) for other in changes), key=itemgetter(0), default=(2, words))
        if lost not in (0, 1):  # first what leaves all right: l may tell what I is
            break
        words = other
    return words


def _slips(equations: list[Printed], system: System, words: Vocabulary) -> Iterator[tuple[Name, str]]:
    """Letters that mean another thing in one equation alone, each with what it means elsewhere.

    I_1 and I_2 are inertias about the same point. Of two parameters that a letter means once each one is meant.
    """
    uses: dict[Name, Counter[str]] = defaultdict(Counter)  # how often each letter has each meaning where equations hold
    twins: dict[Name, Counter[str]] = defaultdict(Counter)  # and the same letter with the index of a twin
    for equation in filter(None, (holding(one, system) for one in equations if one.ways)):
        pairs = ((node.written, equation.meaning(str(node.value))) for node in parts(equation.sides))
        written = [(name, meaning) for name, meaning in pairs if name and not name.styled]
        used = {w.name: meaning[w.dots :] for w, meaning in written}
        for (letter, index), meaning in used.items():
            uses[letter, index][meaning] += 1
            if (twin := TWINS.get(index)) and (letter, twin) not in used:
                twins[letter, twin][meaning.removesuffix(index) + twin] += 1
    dimensions = system.spec.dimensions
    for name, own in uses.items():
        meanings = _meanings(name, words)
        found = own + Counter({meaning: often for meaning, often in twins[name].items() if meaning in meanings})
        rank = lambda one, meanings=meanings: meanings.index(one) if one in meanings else len(meanings)  # noqa: E731
        (usual, often), *others = sorted(found.items(), key=lambda pair: (-pair[1], rank(pair[0]), pair[0]))
        alike = [(meaning, n) for meaning, n in others if dimensions.get(usual) == dimensions.get(meaning)]
        sure = often >= OFTEN or {usual, *(meaning for meaning, _ in alike)} <= system.spec.still
        if len(alike) == 1 and alike[0][1] == 1 and own[alike[0][0]] and sure:
            yield name, usual
            if own[usual] == often == 1:
                yield name, alike[0][0]
