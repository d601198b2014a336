"""Special cases: conditions under which an equation that is not true in general may well be meant.

A condition counts where the text says so, or where the equation does not contain what the condition sets to 0: an equation
without phi may be about the motion at phi = 0; one with phi is not.
"""

import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache

import numpy as np

from pendpin.doctor.checking.evaluation import evaluate, norm
from pendpin.doctor.checking.residuals import (
    TOLERANCE,
    Equation,
    holds,
    names_in,
    relative_error,
    residuals,
    stack_residuals,
)
from pendpin.doctor.reading.tree import Node, Unread, parts
from pendpin.doctor.systems.base import LOADS, Formula, Quantities, System, Values, inverse, random_states
from pendpin.doctor.systems.planar import AMPLITUDE, conical_rate
from pendpin.doctor.systems.rod import SPECIAL

SAID_SMALL = re.compile(r"\bsmall|lineari|first order|approx", re.IGNORECASE)
ROUGHLY = re.compile(r"\\approx|\\simeq|≈")
SMALL = (1e-2, 1e-3)  # the sizes of states at which an equation to the first order is compared
FEW = 2  # equations that contain what a condition makes vanish: from then on it must be stated
# letters of what cannot be left out, also as Ip
NO_LOAD = re.compile("[mMlLIJghrapxyzq]|[mMlLIJ][a-tv-z]|theta|phi|psi")
PIVOT = re.compile(r"\??(?:origin|pivot|offset|anchor|cent)", re.I)  # letters of a place from which others are measured
LOAD_RATIO = 1e-7  # of two values of one coefficient
TRIVIAL = 1e-9  # what is left of an equation's terms where a condition makes all of them vanish


@dataclass(frozen=True)
class Condition:
    """A special case: `instead` gives parts of the state or parameters a value; `stated` is how a text says it.

    `free` says that it need not be stated where the equation contains nothing that changes with `instead`.
    """

    words: str
    instead: tuple[tuple[str, float | Formula], ...] = ()
    stated: str = "^$"
    system: System | None = None
    free: bool = True
    absent: frozenset[str] = frozenset()  # names that an equation on it does not contain


def conditions(system: System) -> list[Condition]:
    """The special cases of a system, the usual ones first."""
    spec = system.spec
    at_rest, down = (tuple((name, 0.0) for name in names) for names in (spec.rates, spec.state))
    found = [Condition("at rest", at_rest, r"\bat rest\b|\bstatic|equilibrium|stands? still|does not move")]
    found += [Condition("at rest, hanging straight down", down, r"straight down|at rest|equilibrium|hangs? vertically")]
    if len(spec.coordinates) > 1 and spec.kind in SPECIAL:
        for name in spec.coordinates:
            held = ((name, 0.0), (f"d{name}", 0.0))
            letter = rf"(?:\$|for |at |with |,)\s*\\?{name}\s*=\s*0"
            found.append(Condition(f"{name} = 0 throughout", held, letter))
    if spec.kind.startswith("polar"):
        cone = (("dtheta", 0.0), ("dphi", conical_rate))
        stated = r"conical|theta.{0,4} (?:is|stays) constant|(?:dot\{?\\?theta\}?|theta')\s*=\s*0|theta\s*=.{0,7}const"
        found.append(Condition("theta is constant, as in a conical pendulum", cone, stated, free=False))
    if spec.kind.startswith("plane"):  # it was at rest at an angle with a name, or one that the text gives in words
        up = spec.kind.endswith("up")
        for start, words in ((AMPLITUDE, "theta_0"), (np.pi / 2, "90°"), (np.pi * (not up), "the top")):

            def rate(q: Quantities, start: float = start) -> Values:
                there = Quantities({**q.base, "theta": np.full(q.shape, start)}, q.system, q.xp)
                return np.sqrt(2 * (there["V"] - q["V"]) / q["J"])

            below = (lambda q, start=start: start + 0.3 * q["theta"] ** 2) if up else lambda q: 0.8 * q["theta"]
            instead = (("theta", below), ("dtheta", rate))
            found.append(Condition(f"it is released at rest from {words}", instead, "", free=False))
    if loads := [name for name in LOADS if name in spec.parameters]:
        found.append(Condition(f"{' and '.join(loads)} = 0", tuple((name, 0.0) for name in loads), "force|torque|free"))
    if "g" in spec.parameters:
        weightless = r"(?:without|no|zero) (?:gravity|field)|weightless|(?:field|gravity|force)-free|\bg\s*=\s*0"
        found.append(Condition("there is no gravity", (("g", 0.0),), weightless))
    for words, kind, stated, absent in SPECIAL.get(spec.kind, ()):
        found.append(Condition(words, (), stated, replace(system, spec=kind), absent=frozenset(absent)))
    return found


def holds_as_stated(equation: Equation, system: System, context: str) -> str:
    """The condition that the words around an equation state and under which it holds; empty where there is none."""
    for condition in conditions(system):
        said = re.search(condition.stated, context, re.IGNORECASE)
        if said and _holds_under(equation, system, condition):
            return condition.words
    return small_angles(equation, system) if SAID_SMALL.search(context) else ""


def holds_if(equation: Equation, system: System, neighbours: list[Equation], chosen: bool) -> str:
    """A condition that nothing states, under which an equation holds that does not contain what it makes vanish.

    Neighbours that contain it show that the text is not about the special case, and so does a system that was `chosen`;
    but a reaction at rest may stand in any text. Beside one law with gravity no other is without.
    """
    lone = {equation.meaning(side.value) for side in equation.sides if side.kind == "symbol"}
    reaction = bool(lone & ({name for name in system.spec.unknowns if not name.startswith("dd")} | {"Mc"}))
    for condition in conditions(system):
        if _may_mean(condition, equation, system) and _holds_under(equation, system, condition):
            still = set(system.spec.rates) <= {name for name, _ in condition.instead}
            others = sum(not _may_mean(condition, other, system) for other in neighbours)
            most = 1 if condition.instead[:1] == (("g", 0.0),) else FEW
            if (still and reaction) or (others < most and not chosen):
                return condition.words
    return small_angles(equation, system)


def _may_mean(condition: Condition, equation: Equation, system: System) -> bool:
    """Whether an equation contains nothing, but for a name that stands alone on a side, that the condition makes vanish."""
    own = equation.definitions
    sides = [side for side in equation.sides if side.kind != "symbol" or len(equation.sides) == 1 or side.value in own]
    names = names_in(sides, equation.definitions)
    changing = condition.absent if condition.system else frozenset[str]()
    changing = changing.union(*(dependents(system, name) for name, _ in condition.instead))
    return condition.free and changing.isdisjoint(map(equation.meaning, names))


@cache
def dependents(system: System, name: str) -> frozenset[str]:
    """The quantities that change with a coordinate, rate or parameter, but for accelerations and reactions."""
    here, there = random_states(system), random_states(system, ((name, 0.321),))
    changing = {name, f"d{name}", f"dd{name}"}
    for other in system.spec.formulas:
        with suppress(KeyError, Unread):
            if other not in system.spec.unknowns and np.abs(here[other] - there[other]).max() > 1e-9:
                changing.add(other)
    return frozenset(changing)


def _holds_under(equation: Equation, system: System, condition: Condition) -> bool:
    """Whether an equation holds in a special case, which makes no side vanish that does not in general, nor all terms."""
    special = condition.system or system
    here, full = random_states(special, condition.instead), random_states(special)
    with suppress(Unread):
        if relative_error(equation, here, full) > TOLERANCE:
            return False
        zero = any(side.kind == "number" and not side.value for side in equation.sides)
        if zero and {side.kind for side in equation.sides} == {"symbol", "number"}:
            return True  # it says that one quantity is 0
        if max(np.abs(size).max() for _, size in residuals(equation, here)) < TRIVIAL:
            return False
        for side in () if zero else equation.sides:
            special_size, size = (norm(evaluate(side, equation.context(q))).max() for q in (here, full))
            if special_size < TRIVIAL < size:
                return False
        return True
    return False


def small_angles(equation: Equation, system: System) -> str:
    """In words, whether an equation without circular functions holds to the first order: its error shrinks."""
    if not may_be_linear(equation, system):
        return ""
    try:
        near, nearer = (random_states(system, scale=size) for size in SMALL)
        errors = [relative_error(equation, states) for states in (near, nearer)]
        rests = [np.abs(stack_residuals(equation, states)).max() for states in (near, nearer)]
    except Unread:
        return ""
    # what is left is of the second order, by itself and beside the terms
    small = errors[0] < 10 * SMALL[0] and errors[1] < 0.2 * errors[0] and rests[1] < 0.03 * rests[0]
    return "the angles are small, to the first order" if small else ""


def may_be_linear(equation: Equation, system: System) -> bool:
    """Whether an equation on coordinates or accelerations has no circular function, and so may be one for small angles."""
    inside = [*equation.sides, *(equation.definitions[name] for name in equation.names & set(equation.definitions))]
    every = list(parts(inside))
    names = {equation.meaning(part.value) for part in every if part.kind == "symbol"}
    angles = {name for angle in system.spec.coordinates for name in (angle, f"dd{angle}")} & names
    # energies are of the second order: to the first they say nothing
    angles = set() if names & {"T", "V", "L", "E"} else angles
    return bool(angles) and not any(part.kind == "function" and part.value != "sqrt" for part in every)


def without(equation: Equation, loads: set[str]) -> Equation:
    """The equation where some unknown symbols are 0."""
    zeros = {name: Node("number", (0, 0), Fraction(0)) for name in loads}
    return replace(equation, definitions=equation.definitions | zeros)


def loads_at_zero(equation: Equation, system: System, unknown: set[str], sure: bool = False) -> str:
    """The symbols without which an equation holds, such as a torque or a damping, in words; empty for none.

    An equation without circular functions may hold to the first order. `sure` says that they are nothing else.
    """
    other = lambda name: NO_LOAD.fullmatch(name.lstrip("?").partition("_")[0]) or "arrow" in name  # noqa: E731
    rates = any(part.kind == "derivative" and part.value == "t" for part in parts(equation.sides))
    moves = rates or any(name.startswith(("dd", "dE", "domega", "dw", "alpha")) for name in equation.names)
    if not (moves or all(map(PIVOT.match, unknown))) or (any(map(other, unknown)) and not sure):
        return ""
    bare, here = without(equation, unknown), random_states(system)
    with suppress(Unread):
        terms = any(np.abs(size).min() > 0 for _, size in residuals(bare, here))
        right = holds(bare, here)
        small = "" if right else small_angles(bare, system)
        if terms and (small or right):
            words = [f"{name.lstrip('?')} = 0" for name in sorted(unknown)]
            return " and ".join([*words, small] if small else words)
    return ""


def loads_in_words(equation: Equation, system: System, loads: set[str]) -> str | None:
    """What each symbol does without which an equation holds: "b is a damping"; empty where one does nothing of the kind.

    With it the equation has to hold in a motion with another generalised force, M q'' = f + c Q, where Q is one of
    _usual_forces and c depends on the parameters alone, so that b may be meant for each mass. None where that cannot be
    told: of energies, which are known up to a constant, and of systems without a mass matrix.
    """
    if "mass" not in system.spec.formulas or equation.energies:
        return None
    found = list[str]()
    for name in sorted(loads):
        alone = without(equation, loads - {name})
        alone = replace(alone, definitions=alone.definitions | {name: Node("number", (0, 0), Fraction(7, 10))})
        kinds = (kind for kind, force in _usual_forces(system) if _acts(alone, system, force, kind == "damping"))
        found.append(f"{name.lstrip('?')} is a {kind}" if (kind := next(kinds, "")) else "")
    return " and ".join(found) if all(found) else ""


def _usual_forces(system: System) -> Iterator[tuple[str, Values]]:
    """Generalised forces (k, n) of a rate, a deflection or 1: at a coordinate, between two, at all, at all joints."""
    true, names = random_states(system), system.spec.coordinates
    one = np.eye(len(names))
    between = [one[i] - one[j] for i in range(len(names)) for j in range(i)]
    joints = [one[0], *(one[i] - one[i - 1] for i in range(1, len(names)))]
    for kind, order in (("damping", "d"), ("spring", "")):
        moves = np.array([true[order + name] for name in names])
        for axes in (*([axis] for axis in (*one, *between)), one, joints):
            yield kind, np.sum([np.outer(axis, axis @ moves) for axis in axes], 0)
        yield kind, np.einsum("ijn,jn->in", true["mass"], moves)  # on each mass, as drag of a point mass
    yield from (("load", np.outer(axis, np.ones(true.shape))) for axis in (*one, *between))


def _acts(equation: Equation, system: System, force: Values, brakes: bool) -> bool:
    """Whether an equation holds with some multiple of a generalised force, a negative one if it `brakes`."""
    true = random_states(system)
    turned = np.einsum("ijn,jn->in", inverse(true["mass"], true), force)
    still = {**true.base, **{name: true[name] for name in system.spec.unknowns}}
    pushed = {f"dd{name}": still[f"dd{name}"] + turned[i] for i, name in enumerate(system.spec.coordinates)}
    with suppress(Unread), np.errstate(all="ignore"):
        off, there = (stack_residuals(equation, Quantities(base, system, np)) for base in (still, still | pushed))
        slope = there - off
        rows = np.abs(slope).max(1) > TOLERANCE * np.abs(there).max()
        if not rows.any() or np.abs(off[~rows]).max(initial=0.0) > TOLERANCE * np.abs(off).max():
            return False
        first, second = np.split(-off[rows] / slope[rows], 2, axis=1)  # the halves of the states share their parameters
        size = np.abs(first).max()
        alike = np.abs(first - second).max() < LOAD_RATIO * size and np.ptp(first, axis=0).max() < LOAD_RATIO * size
        return bool(size > TOLERANCE and alike and not (brakes and (first > 0).any()))
    return False
