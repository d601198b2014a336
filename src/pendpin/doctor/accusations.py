"""What an accusation rests on: why an equation that does not hold is not accused.

An accusation needs a reading that laws bear out: they hold with it, or one small change makes laws of equations.
"""

import re
from contextlib import suppress
from dataclasses import replace
from itertools import product

import numpy as np

from pendpin.doctor.cases import Case, meanings_used, plain, says, size_of
from pendpin.doctor.checking.evaluation import Equation, evaluate
from pendpin.doctor.checking.residuals import TOLERANCE, holds, of_equation
from pendpin.doctor.mending.mends import Mend
from pendpin.doctor.printed import squared
from pendpin.doctor.reading.names import ENERGY, INERTIA, LENGTH, MASS
from pendpin.doctor.reading.tokens import is_latex
from pendpin.doctor.reading.tree import Unread, key, parts, symbols, with_meaning
from pendpin.doctor.recognition import FEW
from pendpin.doctor.systems.base import LOADS, Spec, random_states
from pendpin.doctor.systems.rod import RODS

# the line after an equation, if it is the rest of it
GOES_ON = re.compile(r"(?:[\s&$\\{}]|\\q?quad|\\[,;:!]|\\hspace\{[^}]*\}|\\left|\\right)*(?:[+−]|-\s*[\d½(\\])")
ELEMENT = re.compile(r"([A-Za-z]\w*)[(\[]\d")  # of a vector in code
OF_TERMS = re.compile(r"\bterm .*? is (?:too many|missing)")
ONE_CHANGE, PLAIN = 1.9, 1.8  # what two changes cost more than, and a factor of a number and some letters
SHORT = 9  # equations of a short text, each of which may be wrong
SHORTEST = {1: 13, 2: 20}  # parts of an equation that one change or two may accuse, whatever else the text shows
LEAST = 7  # parts of an equation that two changes may accuse in a short text
OF_TWO = 4  # parts of an equation of two names and a sign
LONG = 20  # parts of one that a single change may accuse, whatever its other letters mean
VERY_LONG = 30  # parts of one that a single change may accuse, whatever else the text holds
TRUSTED = 0.9  # the share of the other equations of a text that hold where a short one may be accused
ENOUGH = 3  # laws of a short text that hold before a letter that moves has to stand in one of them
SEVERAL = (2, 7)  # laws that hold before a term may be called too many or missing: in a short text, in a longer one
CONSTANTS = ("g", "t", "pi")  # that mean the same everywhere
# entries of the mass matrix, and matrices and columns whose rows may all be multiplied by something
MASSES = ("M11", "M12", "M22", "mass", "turn", "turn2", "turned", "weight", "pull")
TURNING = ("C11", "C12", "C21", "C22", "D11", "D12")  # entries of a matrix that is not unique


def objection_to(case: Case, cases: list[Case]) -> str:
    """Why an equation is not accused though it does not hold; empty where it is."""
    one, spec, equation = case.one, case.spec, case.finding.equation
    if equation is None:
        return ""
    as_read = f"as I read it, for {spec.title}, it does not hold"
    else_wrong = f". If it is meant so, {case.finding.mends[0].words}" if case.mends_itself else ""
    if words := _objection_to_form(case, cases, as_read):
        return words
    if words := _objection_to_mend(case, cases, as_read) if case.mends_itself else "":
        return words
    own, others = case.lengths, (other for other in cases if other.is_true and other.reading is case.reading)
    others = {name: value for other in others for name, value in other.lengths.items()}
    for (first, a), (second, b) in product(own.items(), (others | own).items()):
        alike = np.ptp(a / b) < TOLERANCE if len(spec.coordinates) == 1 else np.array_equal(a, b)
        if first != second and alike:  # as the radius of a body that rolls, and that of its bowl
            return f"{as_read}; the length {plain(first)} would be that of {plain(second)}, or a fixed part of it"
    of_sign = case.mends_itself and case.finding.mends[0].words.startswith("the sign of ")
    if of_sign and size_of(one) <= OF_TWO and spec.kind not in RODS and not (case.unit or INERTIA)[0]:
        return f"{as_read}; a direction may be chosen so{else_wrong}"
    if GOES_ON.match(one.statement.after):
        return "it goes on in the next line"
    first, *between, last = equation.sides if len(equation.sides) > 1 else (*equation.sides, None)
    if between and last and holds(replace(equation, sides=(first, last)), random_states(case.system)):
        return "its first side is its last one; a letter between them may be the text's own"
    few = spec.kind in RODS and sum(bool(other.one.ways) for other in cases) < FEW
    if few and not equation.names <= spec.still:
        return ""
    # what shows that the text is about this system: laws of it that hold, or that one small change makes hold
    here = [other for other in cases if other.spec.kind == spec.kind and other.finding.equation]
    laws = [other for other in here if other.is_true and _is_law(other.finding.equation, spec)]
    if not any(map(_moves, laws)) and not any(map(_is_near, here)):
        return f"{as_read}; but no other equation shows that it is meant so{else_wrong}"
    if words := _objection_to_evidence(case, cases, len(laws)) if spec.kind not in RODS else "":
        return f"{as_read}; {words}{else_wrong}"
    # a term that is written or left out by mistake is rarer than a load, an origin or another system
    is_long = len(cases) > SHORT and spec.kind not in RODS
    mended = [other for other in here if other.finding.mends and other.finding.verdict == "fails" and other is not case]
    shown = len(laws) + sum(_is_law(other.finding.mends[0].equation, spec) for other in mended)
    terms = OF_TERMS.findall(words := case.finding.mends[0].words) if case.mends_itself else []
    if (terms and shown < SEVERAL[is_long]) or len(terms) > 1:
        return f"{as_read}; all that helps is that {words}"
    return ""


def _objection_to_form(case: Case, cases: list[Case], as_read: str) -> str:
    """Why an equation as it stands may say something else: a choice, an instant, or a quantity that is not unique."""
    one, spec, equation = case.one, case.spec, case.finding.equation
    if equation is None:
        return ""
    if one.remark and spec.kind not in RODS:  # where its missing bracket stood is guessed
        return f"{as_read}; {one.remark}"
    values = [str(side.value) for side in one.sides]
    if all(side.kind == "symbol" for side in one.sides):
        if {*values} & {*spec.state} or all(value.startswith("?") for value in values):  # names of the text
            return "it gives a state a name"
        alike = len({side.written.letter for side in one.sides if side.written}) == 1  # omega = omega_0 at resonance
        if alike or not (case.finding.dimensions or {*values} & {*spec.unknowns}):
            return "it may say when the two are equal"
    if {"derivative", "number"} == {side.kind for side in one.sides} and "0" in values and "t" not in values:
        return "it asks where a slope is 0, as that of a potential at a rest"
    if one.names & {*spec.parameters} and not equation.names & {*spec.state, *spec.unknowns}:
        moves = any(part.kind == "derivative" or (part.written and part.written.dots > 1) for part in parts(one.sides))
        moves = moves or case.unit in ((0, 0, -2), (0, 1, -2))
        if moves or (case.meaning() == "V" and equation.names <= {"V", *spec.still}):
            return f"{as_read}; it has no coordinate, and may be about an instant, a body that falls or a height"
    moving = [symbols(part) for part in parts(one.sides) if part.kind == "product"]
    if any(names & {"dx", "dy", "dz"} - {*spec.rates} and names & {*spec.rates} for names in moving):
        return f"{as_read}; it may be about a body that moves by itself, as a cart"
    of_speeds = case.left is None and bool(equation.names & {"v", *spec.rates}) and size_of(one) < SHORTEST[1]
    instant = of_speeds and not equation.names & {*spec.unknowns, *"TVLE"}  # as m g h = m v^2/2
    speeds = {part.written for part in parts(one.sides) if part.written and part.written.letter == "v"}
    instant = instant or (len(speeds) > 1 and not equation.names & {*spec.coordinates, *spec.unknowns})
    if instant or squared(one.sides) is not one.sides:
        return f"{as_read}; a speed may be that of one start"
    if case.entry in TURNING:
        return "the matrix of velocity terms is not unique: this is another entry than the one that I know"
    if case.entry in MASSES and not any(o.entry in MASSES for o in cases if o.finding.verdict == "holds"):
        return "it is no part of the mass matrix or its equation as it stands; a row may be multiplied by something"
    return ""


def _objection_to_evidence(case: Case, cases: list[Case], laws: int) -> str:
    """Why a text shows too little that an equation means what it is read as; empty where it shows enough.

    A letter has its meaning from what holds with it, but a long equation that a single change makes hold shows what it means
    itself. A short equation may follow another convention, unless its units disagree, another index is meant or all else
    holds. In a short text each equation may be wrong: only letters that move are asked for, where several laws hold.
    """
    is_long, too_short = len(cases) > SHORT, "it is so short that it may be meant otherwise"
    number = case.finding.follows
    others = [other for other in cases if other is not case and other.finding.kind != "condition"]
    others = [other for other in others if other.finding.number != number]
    trusted = sum(other.confirmed for other in others) >= TRUSTED * len(others)
    if not case.mends_itself:  # it uses a wrong definition, which has to be long or used by several
        used = sum(other.finding.follows == number for other in cases) if number else len(cases)
        short = is_long and not trusted and used < 2 and size_of(cases[number - 1].one) < SHORTEST[1]
        return too_short if short else ""
    one, spec, size, change = case.one, case.spec, size_of(case.one), case.finding.mends[0]
    equation = case.finding.equation or change.equation
    is_rate = case.left is not None and any(
        other.is_true and says(other.one) and other.left == replace(case.left, dots=case.left.dots - 1)
        for other in cases
    )
    shown = case.finding.dimensions or trusted or is_rate or _is_of_index(change, equation)
    shown = shown or change.words.endswith(" is upside down")  # as 1/(2 pi) before the root of l/g
    is_plain = change.count == 1 and shown
    if is_long and size < SHORTEST[change.count] and not is_plain:
        return too_short
    true = (other for other in cases if other.spec.kind == spec.kind and other.is_true and says(other.one))
    known = {name.name for other in true for name in other.written}
    changed = [part for part in parts(equation.sides) if id(part) in change.swaps]
    asked = changed if change.count == 1 and size >= LONG else parts(one.sides)
    for part in asked if is_long or laws >= ENOUGH else ():
        name, meaning = part.written, equation.meaning(str(part.value))
        own = part.kind != "symbol" or name == case.left or meaning[:1] == "?" or meaning in CONSTANTS
        if name and not own and (is_long or meaning not in spec.still) and name.name not in known:
            return f"nothing that holds has {plain(name)}"
    return ""


def _objection_to_mend(case: Case, cases: list[Case], as_read: str) -> str:
    """Why the first mend of an equation, or a name that it uses, accuses nobody; empty where it may."""
    finding, one, mend = case.finding, case.one, case.finding.mends[0]
    equation = finding.equation or mend.equation
    matrices = any(part.kind == "matrix" for part in parts(mend.equation.sides))  # whose entries have several units
    if finding.dimensions and of_equation(mend.equation, case.spec)[1] and not matrices:
        return f"{as_read}; nor do the units of its letters agree"
    known = set[str]().union(*(o.finding.equation.names for o in cases if o.is_true and o.finding.equation))
    other = size_of(one) < LEAST or (mend.equation.names ^ equation.names) - known
    if mend.count > 1 and size_of(one) < SHORTEST[2] and other:
        return f"{as_read}; it may be about something else"  # as sqrt(m/k), of a spring, beside sqrt(l/g)
    start, end, new = mend.splices[0]
    around = one.text[:start][-1:] + one.text[end : end + 1]
    if not (new or is_latex(one.text)) and one.text[start:end].isalpha() and re.search("[A-Za-z]", around):
        return f"{as_read}, and what helps takes letters from a name"
    gone = [part for part in parts(equation.sides) if id(part) in mend.swaps]
    if mend.words.startswith("the factor ") and any(one.kind == "sum" and one.children[0].value == 1 for one in gone):
        return f"{as_read}; the first terms of a series may be meant"
    # a part of an energy that becomes constant is left out, as F x
    moved = [part for part in gone if part.kind == "symbol" and equation.meaning(str(part.value)) in case.spec.state]
    left_out = equation.energies and any(mend.swaps[id(part)].names <= case.spec.still for part in moved)
    if left_out and equation.names & {*LOADS}:
        return f"{as_read}; a part of it may be the potential of a load"
    away = equation.names & {*case.spec.parameters} - mend.equation.names - known
    if away and mend.words.startswith("the factor ") and mend.words.partition(" is too many")[1]:
        return f"{as_read}; nothing that holds has {min(away)}"
    kg, m, s = of_equation(equation, case.spec)[0] or (1, 0, 0)
    of_time = kg == m == 0 != s and not equation.names & {*case.spec.rates, *case.spec.unknowns}
    letters = [{part.written for part in parts(sides)} for sides in (equation.sides, mend.equation.sides)]
    if of_time and "is too many" in mend.words and letters[0] - letters[1]:
        return f"{as_read}; it may be a frequency or a period of other motions"
    lone = re.fullmatch(r"the term (\S+) is too many", mend.words)
    if lone and (finding.dimensions or re.fullmatch(r"[A-Za-z]\w*", lone[1])):
        return f"it holds without {lone[1]}, which may stand for a load, an origin or another body"
    no_law = not equation.names & {*case.spec.unknowns}
    if no_law and mend.words.endswith(" is missing") and mend.equation.names & {*LOADS} - equation.names:
        return f"{as_read}; a load may be 0 there"
    loads = {part.written for part in parts(equation.sides) if equation.meaning(str(part.value)) in LOADS}
    if scaled := [
        load for load in loads if load and re.search(rf" missing in \W*{re.escape(load.letter)}\W*$", mend.words)
    ]:
        return f"{as_read}; {plain(scaled[0])} may be a load over a mass or length"
    bodies = {name for name in case.spec.parameters if case.spec.dimensions.get(name) == MASS}
    lacks = lambda one: bodies & one.finding.mends[0].equation.names - one.finding.equation.names  # noqa: E731
    is_sum, is_term = any(new.kind == "sum" for new in mend.swaps.values()), mend.words.endswith(" is missing")
    if (is_sum or is_term) and (new := lacks(case)):
        same = (o for o in cases if o.mends_itself and o.finding.equation and o.finding.verdict == "fails")
        if case.unit == ENERGY or (new - known and (is_sum or sum(lacks(o) == new for o in same) > 1)):
            return f"{as_read}; it may be about one body alone"
    return _objection_to_names(case, cases, as_read)


def _objection_to_names(case: Case, cases: list[Case], as_read: str) -> str:
    """Why what the names of an equation mean, or those that its mend writes, accuses nobody; empty where it may."""
    one, left, mend = case.one, case.left, case.finding.mends[0]
    equation = case.finding.equation or mend.equation
    gone = [part for part in parts(equation.sides) if id(part) in mend.swaps]
    # not by mistake, if it has no parameter, the text never writes these, or several equations lack them
    brought = _brought(case)
    written = set().union(*(other.finding.equation.names for other in cases if other.finding.equation))
    named = {*case.spec.coordinates, *(() if mend.words.endswith(" is missing") else case.spec.parameters)}
    fresh = mend.equation.names & named - equation.names
    if strange := next((name for name in sorted(fresh) if not {name, f"d{name}", f"dd{name}"} & written), ""):
        return f"{as_read}; nothing has {strange}"
    own = {*case.spec.parameters}
    units = mend.equation.names & own if not equation.names & own else set[str]()  # a text may choose them to be 1
    if units or (brought and (brought - written or sum(_brought(other) == brought for other in cases) > 1)):
        return f"it does not hold, but where {' = '.join(sorted(units or brought))} = 1"
    right = {key(side) for other in cases if other.finding.verdict == "holds" for side in other.one.sides}
    given = case.reading.words.given.keys() | case.reading.words.usual.keys()  # what the user or a system says
    own = [name for name, what in meanings_used(equation) if key(what) not in right and symbols(what)]
    if own := next((name for name in own if name not in given), ""):  # the fault may be there
        return f"it does not hold, but nothing confirms {own.lstrip('?')}, which it uses"
    written = (part.written for part in parts(equation.sides) if str(part.value) in equation.definitions)
    for name in dict.fromkeys(filter(None, written)):  # as omega_0 where a spring has one too
        for usual in case.spec.words(name):
            sides = tuple(with_meaning(side, name, usual) for side in equation.sides)
            readings = replace(equation, sides=sides).readings(case.reading.words)
            if any(holds(reading, random_states(case.system)) for reading in readings):
                return f"it holds where {plain(name)} is not what the text says elsewhere"
    used = dict(meanings_used(equation))
    for other in cases:
        own = used.get(other.one.defines) if not other.confirmed and len(other.one.sides) == 2 else None
        if own and key(own) not in map(key, other.one.sides):
            return f"it does not hold, but {other.finding.place} says otherwise what {other.one.defines.lstrip('?')} is"
    # of an element, as y(1), what it is: where y is named anew, as in another function, it may be another one
    changed = [one.text[slice(*part.span)] for part in gone if part.kind == "symbol"]
    vectors = {match[1] for text in changed if (match := ELEMENT.match(text))}
    known = {name for other in cases if other.is_true for name in ELEMENT.findall(other.one.text)}
    if unknown := vectors - known:
        return f"{as_read}; nothing that holds has an element of {min(unknown)}"
    lefts = {other.left for other in cases if other.confirmed}
    named = lambda other: other.one.sides[-1].kind == "symbol"  # noqa: E731  a state that gets a name
    doubted = {o.left: o.finding.place for o in cases if o.finding.unknown and o.left not in lefts and not named(o)}
    for part in parts(one.sides[1:]):
        if part.written and part.written in doubted:
            return f"it does not hold, but what {plain(part.written)} is, {doubted[part.written]}, is not checked"
    new = mend.equation.sides[0].written
    known = {(name.letter, name.dots) for name in lefts if name}  # beside a_1, which is an acceleration, a_2 is one
    other = left and new and (new.letter != left.letter or (new.index and not left.index))  # as T_0 for T
    if left and other and (left.letter, left.dots) not in known:
        return f"nothing shows what {plain(left)} means here"
    return ""


def _brought(case: Case) -> set[str]:
    """The parameters that a mend writes into an equation whose dimensions do not agree: a text may set them to 1."""
    finding = case.finding
    if finding.verdict != "fails" or not (case.mends_itself and finding.equation and finding.dimensions):
        return set()
    return {*case.spec.parameters} & finding.mends[0].equation.names - finding.equation.names


def _is_near(case: Case) -> bool:
    """Whether one small change makes a law of an equation of several terms, or one that makes its dimensions agree."""
    finding, mends = case.finding, case.finding.mends
    if finding.verdict != "fails" or not mends or mends[0].cost > ONE_CHANGE:
        return False
    fits = finding.dimensions and mends[0].cost <= PLAIN and not of_equation(mends[0].equation, case.spec)[1]
    if not case.mends_itself or fits:
        return True
    equation = mends[0].equation
    moving = {*case.spec.coordinates, *case.spec.rates, *case.spec.unknowns}
    return _is_law(equation, case.spec) and bool(equation.names & moving)


def _is_of_index(change: Mend, equation: Equation) -> bool:
    """Whether a change writes another index, as l_2 for l_1, which no other convention would."""
    pairs = [(part, change.swaps[id(part)]) for part in parts(equation.sides) if id(part) in change.swaps]
    names = [(equation.meaning(str(old.value)), str(new.value)) for old, new in pairs if new.kind == "symbol"]
    return len(names) == len(pairs) > 0 and all(old[:-1] == new[:-1] and old[-1:].isdigit() for old, new in names)


def shows_itself(case: Case) -> bool:
    """Whether an equation is so long that what one small change makes hold is what it means; no term more or less."""
    change = case.finding.mends[0] if case.mends_itself else None
    return bool(change and change.count == 1 and not OF_TERMS.search(change.words) and size_of(case.one) >= VERY_LONG)


def _is_law(equation: Equation | None, spec: Spec) -> bool:
    """Whether an equation is about more than how points move, or a point as T = m v^2/2 is.

    A mass, a force, an energy or gravity is in it, and a coordinate or a length.
    """
    names = equation.names if equation else set[str]()
    heavy = any(name == "g" or spec.dimensions.get(name, (0, 0, 0))[0] for name in names)
    lengths = {name for name in spec.still if spec.dimensions.get(name) == LENGTH}
    own = {*spec.coordinates, *spec.rates, *spec.unknowns, *lengths}
    return heavy and bool(names & {*spec.parameters}) and bool(names & own)


def _moves(case: Case) -> bool:
    """Whether the sides of an equation differ between states of the same parameters, unlike those of F = m g."""
    if (law := case.finding.equation) is None:
        return False
    with suppress(Unread, KeyError, ValueError):  # the halves of the states share their parameters
        context = law.context(random_states(case.system))
        halves = [np.split(evaluate(side, context), 2, axis=-1) for side in law.sides if side.kind != "number"]
        return any(np.abs(first - second).max() > TOLERANCE * np.abs(first).max() for first, second in halves)
    return True
