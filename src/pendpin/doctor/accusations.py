"""What an accusation rests on: why an equation that does not hold is not accused.

An accusation needs laws of the text that hold with its reading, and that contradict what is accused.
"""

import re
from dataclasses import replace
from itertools import permutations, product
from math import gcd

import numpy as np

from pendpin.doctor.cases import Case, is_contradicted, meanings_used, plain, says, size_of
from pendpin.doctor.checking.evaluation import Equation
from pendpin.doctor.checking.residuals import TOLERANCE, holds, of_equation
from pendpin.doctor.mending.mends import Mend
from pendpin.doctor.printed import squared
from pendpin.doctor.reading.names import ENERGY, FORCE, INERTIA, LENGTH, MASS
from pendpin.doctor.reading.tokens import is_latex
from pendpin.doctor.reading.tree import Node, Written, key, parts
from pendpin.doctor.recognition import FEW
from pendpin.doctor.systems.base import LOADS, Spec, random_states
from pendpin.doctor.systems.rod import RODS

ELEMENT = re.compile(r"([A-Za-z]\w*)[(\[]\d")  # of a vector in code
OF_TERMS = re.compile(r"\bterm .*? is (?:too many|missing)")
FRACTION = re.compile(r"(?:frac\{?(\d+)\}?\{?|(?<!\d)(\d+)/)(\d+)")  # of two whole numbers, in LaTeX or in code
SWAPPED = re.compile(r"(sin|cos).* should be .*(?!\1)(sin|cos)")  # a mend that writes a sine for a cosine
POINTS = (LENGTH, (0, 1, -1))  # powers of kg, m, s of places and speeds
OF_TWO = 4  # parts of an equation of two names and a sign
MANY = 9  # equations of a long text
SHORT = 5  # parts of an equation that may be meant otherwise, unless units show what it means
SHORTEST = 13  # parts of a wrong definition that only one equation uses
LONG = 20  # parts of an equation that two changes may accuse, or a letter that nothing else has
VERY_LONG = 30  # parts of one that a single change may accuse, whatever else the text holds
SEVERAL = 2  # laws that hold before a term may be called too many or missing; of a very long equation one is enough
OF_BODIES = ((0, 0, 1), (0, 0, -1), (0, 0, -2))  # powers of kg, m, s of periods and frequencies, which tell of a body
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
    if words := _objection_to_names(case, cases, as_read) if case.mends_itself else "":
        return words
    right = (other for other in cases if other.is_true and other.reading is case.reading)
    others = {name: value for other in right for name, value in other.measures.items()}
    mend = case.finding.mends[0] if case.mends_itself else None
    known = set[Written]() if mend and _is_of_numbers(mend, _changed(mend, equation)) else {*others}
    for (first, a), (second, b) in product(case.measures.items(), (others | case.measures).items()):
        alike = np.ptp(a / b) < TOLERANCE if len(spec.coordinates) == 1 else np.array_equal(a, b)
        if first != second and alike and (first not in known or second in case.measures):
            # as the radius of a body that rolls, and that of its bowl
            return f"{as_read}; {plain(first)} would be the same as {plain(second)}, or a fixed part of it"
    if case.mends_itself and case.finding.mends[0].words.startswith("the sign of ") and spec.kind not in RODS:
        of_force = case.left and case.unit == FORCE and {*case.finding.mends[0].swaps} <= {*map(id, equation.sides)}
        if of_force or (size_of(one) <= OF_TWO and not (case.unit or INERTIA)[0]):
            return f"{as_read}; a direction may be chosen so{else_wrong}"
    first, *between, last = equation.sides if len(equation.sides) > 1 else (*equation.sides, None)
    if between and last and holds(replace(equation, sides=(first, last)), random_states(case.system)):
        return "its first side is its last one; a letter between them may be the text's own"
    few = spec.kind in RODS and sum(bool(other.one.ways) for other in cases) < FEW
    if few and not equation.names <= spec.still:
        return ""
    words = _objection_to_evidence(case, cases)
    return f"{as_read}; {words}{else_wrong}" if words else ""


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
    again = case.left and case.left.dots and any(part.written == case.left for part in parts(one.sides[1:]))
    if again and is_latex(one.text):
        return "it may say what its left side depends on"
    if any(side.kind == "number" and side.value for side in one.sides):
        return "it gives a value"
    letters = all(part.kind in ("symbol", "product") for part in parts(one.sides))
    if letters and ELEMENT.match(one.text[slice(*one.sides[-1].span)]):  # rL = x(1), whatever r and L are
        return "it gives a state a name"
    if one.names & {*spec.parameters} and not equation.names & {*spec.state, *spec.unknowns}:
        moves = any(part.kind == "derivative" or (part.written and part.written.dots > 1) for part in parts(one.sides))
        moves = moves or (case.unit in ((0, 0, -2), (0, 1, -2)) and case.meaning() not in spec.parameters)
        if moves or (case.meaning() == "V" and equation.names <= {"V", *spec.still}):
            return f"{as_read}; it has no coordinate, and may be about an instant, a body that falls or a height"
    moving = [part.names for part in parts(one.sides) if part.kind == "product"]
    places = {"dx", "dy", "dz"} - {*spec.rates}
    alone = case.is_energy and len(equation.names & places) == 1
    if alone or any(names & places and names & {*spec.rates} for names in moving):
        return f"{as_read}; it may be about a body that moves by itself, as a cart"
    of_speeds = case.left is None and one.sides[0].kind != "derivative" and bool(equation.names & {"v", *spec.rates})
    of_speeds = of_speeds and size_of(one) < SHORTEST
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


def _objection_to_evidence(case: Case, cases: list[Case]) -> str:
    """Why a text shows too little that an equation means what it is read as; empty where it shows enough.

    Another body, load or pivot has other numbers, factors and terms; a slip changes one part. What holds has to contradict
    the equation, and to have the letters that are changed. Units that then agree show what an equation means, as does its
    length.
    """
    spec, change = case.spec, case.finding.mends[0] if case.mends_itself else None
    if change is None:  # it uses a wrong definition, which has to be long or used by several
        number = case.finding.follows
        alone = sum(other.finding.follows == number for other in cases) < 2 if number else len(cases) < 2
        short = alone and len(cases) > MANY and size_of(cases[number - 1].one) < SHORTEST
        words = next((f"all that helps is that {mend.words}" for mend in case.finding.mends[:1]), "")
        words = words if OF_TERMS.search(words) else "it is so short that it may be meant otherwise" if short else ""
        return words if spec.kind not in RODS else ""
    equation, size = case.finding.equation or change.equation, size_of(case.one)
    if change.count > 1 and size < LONG:
        return "two changes would be needed"
    changed = _changed(change, equation)
    fits = bool(case.finding.dimensions) and change.count == 1 and not of_equation(change.equation, spec)[1]
    true = [one for one in cases if one is not case and one.is_true and one.spec.kind == spec.kind and says(one.one)]
    laws = [one for one in true if _is_law(one.finding.equation, spec)]
    beside = _is_beside(case, true)
    shown = fits or size >= LONG or laws or beside
    if not shown and (len(cases) > 1 or not _is_law(change.equation, spec)):
        return "no other equation shows that it is meant so"
    if OF_TERMS.search(change.words) and len(laws) < (SEVERAL if change.count > 1 or size < VERY_LONG else 1):
        return f"all that helps is that {change.words}"
    if spec.kind in RODS:
        return ""
    of_numbers = _is_of_numbers(change, changed)
    of_period = case.unit in OF_BODIES and not equation.names & {*spec.unknowns} and not re.search("pi|π", change.words)
    halves = [gcd(int(a or b), int(c)) > 1 for a, b, c in FRACTION.findall(change.new)]  # as 2/2, which nobody writes
    if (of_numbers and (of_period or any(halves))) or _changes_more(case, change, changed):
        return "it may be about another system, one body alone or a load"
    derived = any(part.kind == "derivative" for part in parts(equation.sides))
    if size < SHORT and not (fits or derived or beside):
        return "it is so short that it may be meant otherwise"
    known = {name.name for one in true for name in one.written} | {("g", "")}
    reactions = {name for name, unit in spec.dimensions.items() if unit == FORCE} - {*spec.parameters}
    forces = [part for part in parts(equation.sides) if equation.meaning(str(part.value)) in reactions]
    names = (part.written for part in (*changed, *forces) if part.kind == "symbol")
    strange = [name for name in names if name and name != case.left and name.name not in known]
    if strange and (size < LONG or len(laws) > SEVERAL) and not (fits and len(cases) == 1):
        return f"nothing that holds has {plain(strange[0])}"
    said = (" ".join([one.finding.remark, *(mend.words for mend in one.finding.mends)]) for one in cases)
    axes = any(one.left and one.meaning() in _axes(case) and not one.is_true for one in cases)
    if SWAPPED.search(change.words) and (axes or sum(bool(SWAPPED.search(words)) for words in said) > 1):
        return "its angle may be measured from elsewhere"
    itself = fits or len(cases) == 1 or (shows_itself(case) and not of_numbers)
    of_body = of_numbers or (change.count == 1 and change.words.startswith(("the factor ", "the term ")))
    if itself or not of_body or is_contradicted(case, cases):  # another body has other numbers, factors and terms
        return ""
    return "nothing that holds contradicts it"


def _is_beside(case: Case, true: list[Case]) -> bool:
    """Whether what holds says of the same: of a point its other coordinates, of a sum of energies each of its terms."""
    stated, equation = {other.meaning() for other in true if other.left}, case.finding.equation
    if case.unit != ENERGY or equation is None:
        return bool(_axes(case) & stated)
    terms = equation.names - {case.meaning()}
    return case.finding.mends[0].words.startswith("the sign of ") and {*"TV"} & terms <= terms <= stated & {*"TVE"}


def _axes(case: Case) -> set[str]:
    """The other coordinates of the point whose coordinate, or rate of one, an equation gives; empty where it gives none."""
    name = case.meaning() if case.left and case.unit in POINTS else ""
    return {name.replace(a, b) for a, b in permutations("xyz", 2) if a in name}


def _changes_more(case: Case, change: Mend, changed: list[Node]) -> bool:
    """Whether a mend takes letters or a lone term away, writes several, another body or an acceleration, or changes a load.

    Or it gives another name to what an equation is solved for.
    """
    equation, spec = case.finding.equation or change.equation, case.spec
    words, is_fewer, _ = change.words.partition(" is too many")
    gone, new = equation.names - change.equation.names, change.equation.names - equation.names
    gone = gone or {part.written for part in parts(equation.sides)} - {p.written for p in parts(change.equation.sides)}
    gone = gone or (words.startswith("the term ") and any(not part.children for part in changed))
    factors = [one for new in change.swaps.values() for one in new.children[1:] if words.startswith("the factor ")]
    several = (len(new) > 1 and case.entry not in MASSES) or len({name for one in factors for name in one.names}) > 1
    held = words.startswith("the term ") and any(one.startswith("dd") for one in new)  # as a cart is
    lone = change.swaps.get(id(equation.sides[0]))
    named = lone is not None and lone.kind == "symbol"
    more = change.words.endswith(" is missing") or any(one.kind == "sum" for one in change.swaps.values())
    bodies = {name for name in spec.parameters if spec.dimensions.get(name) == MASS}
    loaded = equation.names if equation.energies else {equation.meaning(str(part.value)) for part in changed}
    other = several or held or named or loaded & {*LOADS} or (case.unit == ENERGY and more and new & bodies)
    return bool(other or (is_fewer and gone))


def _changed(change: Mend, equation: Equation) -> list[Node]:
    """The parts of an equation in whose places a mend puts others."""
    return [part for part in parts(equation.sides) if id(part) in change.swaps]


def _is_of_numbers(change: Mend, changed: list[Node]) -> bool:
    """Whether only numbers are changed, as other bodies would have them."""
    pairs = [(old, change.swaps[id(old)]) for old in changed]
    factors = [new.children[1:] if new.kind == "product" else (new,) * (old.kind == "number") for old, new in pairs]
    other = change.words.startswith("the sign ") or change.words.endswith(" is upside down")
    return not other and all(each and all(one.kind == "number" for one in each) for each in factors)


def _objection_to_names(case: Case, cases: list[Case], as_read: str) -> str:
    """Why what the names of an equation mean, or those that its mend writes, accuses nobody; empty where it may."""
    one, mend = case.one, case.finding.mends[0]
    equation = case.finding.equation or mend.equation
    gone = [part for part in parts(equation.sides) if id(part) in mend.swaps]
    matrices = any(part.kind == "matrix" for part in parts(mend.equation.sides))  # whose entries have several units
    if case.finding.dimensions and of_equation(mend.equation, case.spec)[1] and not matrices:
        return f"{as_read}; nor do the units of its letters agree"
    # a mend writes nothing that the text never writes, and no parameter that may be 1 in the text
    written = set().union(*(other.finding.equation.names for other in cases if other.finding.equation))
    own, new = {*case.spec.parameters}, mend.equation.names - equation.names
    missing = own & {"M"} if mend.words.endswith(" is missing") else own  # a cart, which pages on its pole never name
    fresh = new & ({*case.spec.coordinates} | missing)
    if strange := next((name for name in sorted(fresh) if not {name, f"d{name}", f"dd{name}"} & written), ""):
        return f"{as_read}; nothing has {strange}"
    if new & own and not equation.names & own:
        return f"it does not hold, but where {' = '.join(sorted(new & own))} = 1"
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
    return ""


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
