"""Special cases: conditions under which an equation that is not true in general may well be meant.

A condition counts where the text says so. Small angles count without a word where an equation has no sine or cosine, no
load where it has none, and another rod where it has nothing that this rod lacks.
"""

import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import cache
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from pendpin.doctor.checking.evaluation import Equation, evaluate, norm
from pendpin.doctor.checking.residuals import (
    NONE,
    TOLERANCE,
    ZERO,
    holds,
    of_equation,
    relative_error,
    residuals,
    stack_residuals,
)
from pendpin.doctor.reading.names import ENERGY
from pendpin.doctor.reading.tree import Node, Unread, names_in, parts
from pendpin.doctor.systems.base import LOADS, Formula, Quantities, Spec, System, Values, inverse, random_states
from pendpin.doctor.systems.rod import SPECIAL
from pendpin.doctor.systems.tables import FAMILIES

_CONICAL_RATE = itemgetter("conical_rate")
FEW_DEGREES = re.compile(r"\bsmall|lineari|klein|petit|peque|piccol|малы|小", re.I)
ROUGHLY = re.compile(r"\\approx|\\simeq|≈")
# sizes of states at which an equation of the first order, or more, is compared
SMALL, MIDDLING = (1e-2, 1e-3), (0.3, 0.1)
ORDERS = {1: "first", 2: "second", 3: "third"}
FEW = 2  # equations that contain what a condition makes vanish: from then on it must be stated
# letters of what cannot be left out, also as Ip
NO_LOAD = re.compile("[mMlLIJghrapxyz]|[mMlLIJ][a-tv-z]|theta|phi|psi")
PIVOT = re.compile(r"\??(?:origin|pivot|offset|anchor|cent)", re.I)  # letters of a place from which others are measured
LOAD_RATIO = 1e-7  # of two values of one coefficient
AGAINST = ("damping", "drag", "dry friction", "spring")  # forces against the motion or the deflection
LARGE = Node("number", (0, 0), Fraction(10**40))  # what divides by it is 0 to 25 digits
SOME = Node("number", (0, 0), Fraction(7, 10))  # that a load is
TINY = 1e-10  # the size of states at which only terms of the first order are left
TRIVIAL = 1e-9  # what is left of an equation's terms where a condition makes all of them vanish


class Condition(NamedTuple):
    """A special case: `instead` gives parts of the state or parameters a value; `stated` is how a text says it.

    Where the equation and most others have none of the `absent` quantities, it need not be stated.
    """

    words: str
    stated: str
    instead: tuple[tuple[str, float | Formula], ...] = ()
    absent: frozenset[str] = frozenset()
    spec: Spec | None = None  # of another rod


def conditions(system: System) -> list[Condition]:
    """The special cases of a system, the usual ones first."""
    spec = system.spec

    def zero(words: str, stated: str, *names: str) -> Condition:
        return Condition(words, stated, tuple((name, 0.0) for name in names), dependents(system, names))

    rest = r"\bat rest\b|\bstatic|equilibrium|stands? still|does not move"
    down = r"straight down|at rest|equilibrium|hangs? vertically"
    found = [zero("at rest", rest, *spec.rates), zero("at rest, hanging straight down", down, *spec.state)]
    for name in spec.coordinates if spec.kind in SPECIAL else ():
        letter = rf"(?:\$|for |at |with |,)\s*\\?{name}\s*=\s*0"
        found.append(zero(f"{name} = 0 throughout", letter, name, f"d{name}"))
    if spec.kind.startswith("polar"):
        said = r"conical|theta.{0,4} (?:is|stays) constant|(?:dot\{?\\?theta\}?|theta')\s*=\s*0|theta\s*=.{0,7}const"
        cone = (("dtheta", 0.0), ("dphi", _CONICAL_RATE))
        found.append(Condition("theta is constant, as in a conical pendulum", said, cone))
    if spec.kind.startswith("plane") and "down" in spec.kind:
        lowest = r"lowest|bottom|maxim|máxim|greatest|largest|tiefst|plus bas|más bajo|mais baixo|más baja"
        found.append(Condition("it is at its lowest point", lowest, (("theta", 0.0),)))
    if spec.kind.startswith("plane"):  # it was at rest at an angle with a name, or one that the text gives in words
        up = spec.kind.endswith("up")
        for start, words in ((spec.values["theta0"], "theta_0"), (np.pi / 2, "90°"), (np.pi * (not up), "the top")):

            def rate(q: Quantities, start: float = start) -> Values:
                there = Quantities({**q.base, "theta": np.full(q.shape, start)}, q.system, q.xp)
                return np.sqrt(2 * (there["V"] - q["V"]) / q["J"])

            below = (lambda q, start=start: start + 0.3 * q["theta"] ** 2) if up else lambda q: 0.8 * q["theta"]
            found.append(Condition(f"it is released at rest from {words}", "", (("theta", below), ("dtheta", rate))))
    if loads := [name for name in LOADS if name in spec.parameters]:
        found.append(zero(f"{' and '.join(loads)} = 0", "force|torque|free", *loads))
    weightless = r"(?:without|no|zero) (?:gravity|field)|weightless|(?:field|gravity|force)-free|\bg\s*=\s*0"
    found.append(zero("there is no gravity", weightless, "g"))
    others = SPECIAL.get(spec.kind, ())
    return found + [Condition(words, stated, (), absent, other) for words, other, stated, absent in others]


def holds_if(equation: Equation, system: System, context: str, neighbours: list[Equation], chosen: bool) -> str:
    """The condition under which an equation holds, in words; empty where it holds under none.

    The words around it state the condition. Or it has nothing of what the condition makes vanish, and nothing shows that
    the text is not about that: neighbours that have it, or a system that was `chosen`. A reaction at rest may stand in any
    text. Beside one law with gravity no other is without.
    """
    lone = {equation.meaning(str(side.value)) for side in equation.sides if side.kind == "symbol"}
    reaction = bool(lone & ({name for name in system.spec.unknowns if not name.startswith("dd")} | {"Mc"}))
    others_in = dict[int, set[str]]()  # the quantities of each equation but for one that stands alone on a side
    for one in (equation, *neighbours):
        several, own = len(one.sides) > 1, one.definitions
        sides = [side for side in one.sides if not several or side.kind != "symbol" or side.value in own]
        others_in[id(one)] = {*map(one.meaning, names_in(sides, own))}
    for case in conditions(system):
        has = lambda one, case=case: bool(case.absent & others_in[id(one)])  # noqa: E731
        still = reaction and {*system.spec.rates} <= {name for name, _ in case.instead}
        few = sum(map(has, neighbours)) < (1 if case.words == "there is no gravity" else FEW) and not chosen
        meant = re.search(case.stated, context, re.IGNORECASE) or (case.absent and (few or still) and not has(equation))
        if meant and _holds_under(equation, system, case):
            return case.words
    return small_angles(equation, system, bool(FEW_DEGREES.search(context)))


@cache
def dependents(system: System, names: tuple[str, ...]) -> frozenset[str]:
    """The quantities that change with some coordinates, rates or parameters, but for accelerations and reactions."""
    changing = {f"{d}{name}" for name in names for d in ("", "d", "dd")}
    for one in names:
        here, there = random_states(system), random_states(system, ((one, 0.321),))
        for other in system.spec.formulas.keys() - {*system.spec.unknowns}:
            with suppress(KeyError, Unread):
                if np.abs(here[other] - there[other]).max() > TRIVIAL:
                    changing.add(other)
    return frozenset(changing)


def _holds_under(equation: Equation, system: System, case: Condition) -> bool:
    """Whether an equation holds in a special case, in which no letter or side vanishes that does not in general."""
    special = replace(system, spec=case.spec or system.spec)
    here, full = random_states(special, case.instead), random_states(special)
    with suppress(Unread):
        if relative_error(equation, here, full) > TOLERANCE:
            return False
        zero = any(side.kind == "number" and not side.value for side in equation.sides)
        if max(np.abs(size).max() for _, size in residuals(equation, here)) < TRIVIAL:
            return False
        # nor may a letter of it vanish: what multiplies it would not be checked
        letters = [part for part in parts(equation.sides) if part.kind == "symbol"]
        for part in (*letters, *(() if zero else equation.sides)):
            special, general = (norm(evaluate(part, equation.context(q))).max() for q in (here, full))
            if special < TRIVIAL < general:
                return False
        return True
    return False


def may_be_linear(equation: Equation, system: System, energy: bool = False) -> bool:
    """Whether an equation may be one of small angles: what moves, or an `energy`, is in it, and in no circular function."""
    state = {*system.spec.state}
    circular = (part for part in _with_definitions(equation) if part.kind == "function" and part.value != "sqrt")
    moves = energy or any({name, f"dd{name}"} & equation.names for name in system.spec.coordinates)
    return moves and not any({*map(equation.meaning, names_in((p,), equation.definitions))} & state for p in circular)


def _with_definitions(equation: Equation) -> list[Node]:
    """The parts of an equation, and of the definitions that it uses."""
    own = equation.definitions
    return [*parts([*equation.sides, *(own[name] for name in equation.names & own.keys())])]


def small_angles(equation: Equation, system: System, stated: bool = False) -> str:
    """In words, whether an equation without circular functions holds to the order of its terms: its error shrinks.

    An energy without angles is one of small angles only where the text has `stated` that they are.
    """
    names = equation.names
    of_energy = of_equation(replace(equation, sides=equation.sides[:1]), system.spec)[0] == ENERGY
    energy = bool(names & {*"TVLE"}) or (of_energy and not names & {*system.spec.unknowns})
    if not may_be_linear(equation, system, energy):
        return ""
    upright = {*system.kind.split()} ^ {"down", "up"}  # where a matrix is, it may be made linear there
    others = FAMILIES.get(system.kind.split()[0], ()) if any(side.kind == "matrix" for side in equation.sides) else ()
    turned = next((one for one in others if {*one.kind.split()} == upright and "up" in upright), None)
    pairs = (system.spec, "the angles are small"), (turned, "the angles are small, from upright")
    angles = {name for name in system.spec.coordinates if system.spec.dimensions.get(name) == NONE}
    raised = (part for part in _with_definitions(equation) if part.kind == "power" and part.names & angles)
    powers = [int(part.value) for part in raised if part.value > 1]
    if energy and not (powers or stated):
        return ""
    # a series has to be right up to its own last term, and energies to the squares of rates
    order = max((2 if energy else 1, *powers))
    sizes = SMALL if order == 1 else MIDDLING  # where a fifth power is more than rounding
    for spec, words in pairs[: 1 + (turned is not None)]:
        with suppress(Unread):
            scaled = [random_states(replace(system, spec=spec, scale=size)) for size in sizes]
            if (far := relative_error(equation, scaled[0])) >= 10 * sizes[0]:
                continue
            ratio = (sizes[1] / sizes[0]) ** (order - 0.5)  # half an order above what a wrong last term leaves
            rest, less = (np.abs(stack_residuals(equation, states)).max() for states in scaled)
            if relative_error(equation, scaled[1]) < ratio * far and less < ratio * sizes[1] / sizes[0] * rest:
                return f"{words}, to the {ORDERS.get(order, f'{order}th')} order"
    return ""


def without(equation: Equation, loads: set[str]) -> Equation:
    """The equation where some unknown symbols are 0, or very large if they divide, as Q in theta'/Q."""
    products = (part for part in parts(equation.sides) if part.kind == "product")
    pairs = (pair for part in products for pair in zip(part.value, part.children, strict=True))
    below = set[str]().union(*(factor.names for sign, factor in pairs if sign == "/"))
    values = {name: LARGE if name in below else ZERO for name in loads}
    return replace(equation, definitions=equation.definitions | values)


def is_identity(equation: Equation, system: System) -> bool:
    """Whether an equation holds whatever numbers its unknown symbols are, as a step of algebra does.

    Of energies, which are known up to a constant, that says nothing.
    """
    if equation.energies:
        return False
    with suppress(Unread):
        return holds(with_numbers(equation), random_states(system))
    return False


def with_numbers(equation: Equation) -> Equation:
    """The equation where its unknown symbols are some numbers."""
    unknown = sorted(name for name in equation.names - equation.definitions.keys() if name.startswith("?"))
    numbers = {name: Node("number", (0, 0), Fraction(7 * i + 10, 9)) for i, name in enumerate(unknown)}
    return replace(equation, definitions=equation.definitions | numbers)


def loads_at_zero(equation: Equation, system: System, unknown: set[str], sure: bool = False) -> str:
    """The symbols without which an equation holds, such as a torque or a damping, in words; empty for none.

    An equation without circular functions may hold to the first order. `sure` says that they are nothing else.
    """
    products = (part for part in parts(equation.sides) if part.kind == "product")
    drives = (part for part in products if SOME.value in [one.value for one in part.children if one.kind == "number"])
    free = {"?M_0"}.union(*(part.names for part in drives))  # the moment M_0 may drive, as may a in a cos(w t)
    other = lambda name: (  # noqa: E731
        name not in free and (NO_LOAD.fullmatch(name.lstrip("?").partition("_")[0]) or "arrow" in name)
    )
    rates = any(part.kind == "derivative" and part.value == "t" for part in parts(equation.sides))
    moves = rates or any(name.startswith(("dd", "dE", "domega", "dw", "alpha")) for name in equation.names)
    if not (moves or all(map(PIVOT.match, unknown))) or (any(map(other, unknown)) and not sure):
        return ""
    bare, here = without(equation, unknown), random_states(system)
    with suppress(Unread):
        small = "" if (right := holds(bare, here)) else small_angles(bare, system)
        if (right or small) and any(np.abs(size).min() > 0 for _, size in residuals(bare, here)):
            return " and ".join([*(f"{name.lstrip('?')} = 0" for name in sorted(unknown)), *filter(None, (small,))])
    return ""


def loads_in_words(equation: Equation, system: System, loads: set[str], scale: float = 1.0) -> str | None:
    """What each symbol does without which an equation holds: "b is a damping"; empty where one does nothing of the kind.

    With it the equation has to hold in a motion with another generalised force, M q'' = f + c Q, where Q is one of
    _usual_forces and c depends on the parameters alone, so that b may be meant for each mass. None where that cannot be
    known: of energies, which are known up to a constant, and of systems without a mass matrix.
    """
    if "mass" not in system.spec.formulas or equation.energies:
        return None
    found = [_acts_as(without(equation, loads - {name}), system, {name}, scale) for name in sorted(loads)]
    if len(loads) > 1 and not any(found):  # rho C_d A is one
        found = [_acts_as(equation, system, loads, scale)]
    return " and ".join(found) if all(found) else ""


def _acts_as(equation: Equation, system: System, loads: set[str], scale: float) -> str:
    """What some symbols do together: "b is a damping"; empty for nothing of the kind."""
    names = " ".join(sorted(name.lstrip("?") for name in loads))
    return f"{names} is a {load[0]}" if (load := load_of(equation, system, loads, scale)) else ""


def load_of(equation: Equation, system: System, loads: set[str], scale: float = 1.0) -> tuple[str, Values] | None:
    """What some symbols do together where they have a value, and how much of that (n,); None for nothing usual.

    `scale` is the size of the states at which the equation holds: TINY for one of small angles.
    """
    given = replace(equation, definitions=equation.definitions | dict.fromkeys(loads, SOME))
    true = random_states(replace(system, scale=scale))
    for kind, force in _usual_forces(true):
        size = _multiple(given, true, force)
        if size is not None and not (kind in AGAINST and (size > 0).any()):
            return kind, size
    return None


def _usual_forces(true: Quantities) -> Iterator[tuple[str, Values]]:
    """Generalised forces (k, n) of a rate, a deflection or 1: at a coordinate, between two, at all, on each mass."""
    names = true.spec.coordinates
    one = np.eye(len(names))
    axes = [*one, *(one[i] - one[j] for i in range(len(names)) for j in range(i))]
    for kind, order in (("damping", "d"), ("spring", "")):
        moves = np.array([true[order + name] for name in names])
        yield from ((kind, np.outer(axis, axis @ moves)) for axis in axes)
        yield from ((kind, moves), (kind, np.einsum("ijn,jn->in", true["mass"], moves)))  # as drag of a point mass
        if kind == "damping":
            yield from (("drag", np.outer(axis, (axis @ moves) * np.abs(axis @ moves))) for axis in one)
            yield from (("dry friction", np.outer(axis, np.sign(axis @ moves))) for axis in axes)
    yield from (("load", np.outer(axis, np.ones(true.shape))) for axis in axes)


def _multiple(equation: Equation, true: Quantities, force: Values) -> Values | None:
    """The multiple of a generalised force with which an equation holds, (n,) of its parameters; None for none."""
    system = true.system
    turned = np.einsum("ijn,jn->in", inverse(true["mass"], true), force)
    still = {**true.base, **{name: true[name] for name in system.spec.unknowns}}
    pushed = {f"dd{name}": still[f"dd{name}"] + turned[i] for i, name in enumerate(system.spec.coordinates)}
    with suppress(Unread), np.errstate(all="ignore"):
        off, there = (stack_residuals(equation, Quantities(base, system, np)) for base in (still, still | pushed))
        slope = there - off
        rows = np.abs(slope).max(1) > TOLERANCE * np.abs(there).max()
        if not rows.any() or np.abs(off[~rows]).max(initial=0.0) > TOLERANCE * np.abs(off).max():
            return None
        first, second = np.split(-off[rows] / slope[rows], 2, axis=1)  # the halves of the states share their parameters
        size = np.abs(first).max()
        alike = np.abs(first - second).max() < LOAD_RATIO * size and np.ptp(first, axis=0).max() < LOAD_RATIO * size
        return first[0] if size > TOLERANCE and alike else None
    return None
