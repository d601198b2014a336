"""The verdict on an equation at random states; in which motions it fails; laws of any system; what definitions come to."""

import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from pendpin.doctor.checking.evaluation import ENERGIES, Equation, evaluate
from pendpin.doctor.checking.residuals import TOLERANCE, Disagreement, dimension, relative_error, stack_residuals
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.tree import Node, Unread, parts, walk
from pendpin.doctor.systems.base import STATES, Formula, Quantities, Spec, System, Values, free_states, random_states
from pendpin.equations.base import exact
from pendpin.ground.libraries import optional

EXACT = 1e-25  # what is left in 50 digits: three derivatives within each other leave 1e-32
SAME = 1e-8  # relative: of second derivatives eight digits are left
PAIRS = 4  # states in 50 digits from either half of the random states
SHORT, LONG = 3, 9  # parts of an expression that is named like a quantity; of one that is none by chance
MOST_MEANT = 4  # readings of a definition
ACCELERATION = re.compile(r"acc|dd|dot|alpha")


def check(equation: Equation, system: System) -> tuple[bool, bool, float]:
    """Whether an equation holds on every true motion, whether to 25 digits rather than those of floats, and its error.

    It is compared at random states, in floats and then in 50 digits. The error is relative to its terms. Raises Unread.
    """
    states = random_states(system)
    error = relative_error(equation, states)
    if error > TOLERANCE:
        with suppress(Unread):  # rates of points have no rates off the true motion
            if changes_no_motion(equation, system):
                return True, system.spec.analytic, 0.0
    if error > TOLERANCE or not system.spec.analytic:
        return error <= TOLERANCE, error > TOLERANCE, error
    try:
        return bool(np.abs(stack_residuals(equation, in_fifty_digits(states))).max() < EXACT), True, error
    except ZeroDivisionError:
        raise Unread("it divides by 0") from None


def changes_no_motion(equation: Equation, system: System) -> bool:
    """Whether it gives a Lagrangian that is not T - V but has its motions: times a factor, or with a total derivative."""
    lone = [side for side in equation.sides if side.kind == "symbol" and equation.meaning(side.value) == "L"]
    others = [side for side in equation.sides if side not in lone]
    if len(lone) != 1 or len(others) != 1 or equation.names & set(system.spec.unknowns):
        return False
    exact = in_fifty_digits if system.spec.analytic else lambda q: q
    states, free = exact(random_states(system)), exact(free_states(system))
    law, off = (_motion(side, equation, free) for side in (lone[0], others[0]))
    left = _motion(others[0], equation, states)
    return bool((law * off).sum() > 0 and np.abs(left).max() <= SAME * np.abs(off).max())


def _motion(side: Node, equation: Equation, quantities: Quantities) -> Values:
    """Euler and Lagrange's left sides of an expression, (coordinates, n)."""
    context = equation.context(quantities)
    return np.stack([evaluate(left, context) for left in euler_lagrange(side, quantities.spec)])


def when(equation: Equation, system: System) -> str:
    """In which motions a wrong equation fails, in words."""
    rates, full = system.spec.rates, random_states(system)

    def fails_without(still: list[str]) -> bool:
        try:
            return relative_error(equation, random_states(system, tuple((n, 0.0) for n in still)), full) > TOLERANCE
        except Unread:  # it has no value there, as one that is divided by a rate at rest
            return False

    if fails_without([*rates]):
        return "already at rest"
    turns = {
        name: "turns" if system.spec.dimensions[name] == (0, 0, 0) else "moves" for name in system.spec.coordinates
    }
    alone = [name for name in turns if fails_without([rate for rate in rates if rate != f"d{name}"])]
    wrong = " and ".join(f"as soon as {name} {turns[name]}" for name in alone)
    return wrong or f"only when {' and '.join(turns)} both turn"


def euler_lagrange(lagrangian: Node, spec: Spec) -> list[Node]:
    """The left sides of Euler and Lagrange's equations, one for each coordinate."""
    place = (lagrangian.outer[0], lagrangian.outer[0])
    by = lambda node, name: Node("derivative", lagrangian.span, name, (node,))  # noqa: E731
    return [
        Node("sum", lagrangian.span, (1, -1), (by(by(lagrangian, f"d{q}"), "t"), by(lagrangian, q)), (place, place))
        for q in spec.coordinates
    ]


def is_general(equation: Equation, system: System) -> bool:
    """Whether an equation is Euler and Lagrange's or Hamilton's for any coordinate q_i, or with a force Q of its own."""
    spec, nodes = system.spec, [*parts(equation.sides)]
    by = {str(node.value).lstrip("?") for node in nodes if node.kind == "derivative" and node.value != "t"}
    lone = [side for side in equation.sides if side.kind == "symbol" and str(side.value).startswith("?")]
    sides = [side for side in equation.sides if side not in lone]
    known = equation.names & {*spec.parameters, "q_i"}  # of a rod q_i is known, and the equation is checked
    named = [name for name in spec.coordinates if {name, f"d{name}"} & by]
    if not by or len(equation.sides) != 2 or not sides or known or (named and not lone):
        return False  # one coordinate: checked as any other equation
    bases = {name.removeprefix("d") for name in by if name not in spec.state and name[0] != "p"}
    momenta = {name.lstrip("?") for name in {str(node.value) for node in nodes} if re.match(r"\??d?p", name)}
    states, free = random_states(system), free_states(system)
    try:
        for name in named or spec.coordinates:
            own = spec.momentum(name)
            meanings = {f"{mark}{d}{base}": f"{d}{name}" for base in bases for d in ("", "d") for mark in ("?", "")}
            meanings |= {f"{mark}{one}": "d" * (one[0] == "d") + own for one in momenta if own for mark in ("?", "")}
            here = replace(equation, meanings=equation.meanings | meanings, sides=tuple(sides))
            off, true = (stack_residuals(here, quantities, plain=True) for quantities in (free, states))
            law = _motion(Node("symbol", (0, 0), "L"), here, free)[spec.coordinates.index(name)]
            is_law = min(np.abs(off - law).max(), np.abs(off + law).max()) <= TOLERANCE * np.abs(law).max()
            if not is_law and (lone or not momenta or np.abs(true).max() > TOLERANCE):
                return False
    except (Unread, KeyError):
        return False
    return True


@cache
def in_fifty_digits(states: Quantities) -> Quantities:
    """Some of the states in mpmath's numbers of 50 digits, as many of the second half as of the first."""
    numbers = exact(50)
    pi = numbers.asarray("3.14159265358979323846264338327950288419716939937510582097")
    chosen = [place + start for start in (0, STATES // 2) for place in range(PAIRS)]
    base = {name: numbers.asarray(values[chosen]) for name, values in states.base.items()}
    return Quantities(base, states.system, SimpleNamespace(**vars(numbers), pi=pi), states.true)


@cache
def in_symbols(system: System) -> Quantities:
    """Every quantity as sympy's expression in the state, the parameters and the unknowns."""
    sympy: Any = optional("sympy", "the equation doctor", "sympy")

    def on_each(function: Callable[[Any], Any]) -> Callable[[Any], Values]:
        one_by_one = np.frompyfunc(function, 1, 1)
        return lambda x: np.asarray(one_by_one(np.asarray(x, dtype=object)), dtype=object)

    def derivative(q: Quantities, function: Formula, variable: str) -> Values:
        value, rates = function(q), {sympy.Symbol(name): rate[0] for name, rate in q.direction(variable).items()}
        if variable == "t" and any(str(one) in q.spec.unknowns for x in value.flat for one in x.free_symbols):
            raise Unread("the rate of an acceleration or reaction is not known")
        return on_each(lambda x: sum(x.diff(symbol) * rate for symbol, rate in rates.items()))(value)

    functions = {name: on_each(getattr(sympy, name)) for name in ("sin", "cos", "sqrt")}
    numbers = SimpleNamespace(asarray=on_each(sympy.sympify), pi=sympy.pi, derivative=derivative, **functions)
    names = (*system.spec.state, *system.spec.parameters, *system.spec.unknowns)
    return Quantities({name: np.array([sympy.Symbol(name)], dtype=object) for name in names}, system, numbers)


def quantity_of(one: Printed, system: System) -> tuple[str, Equation] | None:
    """The quantity that a definition comes to, such as acc1 = (M22*R1 - M12*R2)/det, and how it is read; None for none.

    A short one comes to it by chance, unless it is named like it: xs = L*sin(theta), with X1 or pos_x for x1 and x. Of two
    bodies the indices agree. Energies have a constant.
    """
    if len(one.sides) != 2 or one.statement.name or one.sides[0].kind != "symbol" or not one.sides[0].written:
        return None
    word, size = one.sides[0].value.lstrip("?"), sum(1 for _ in walk(one.sides[1]))
    if size < SHORT or one.lacking - {one.defines}:
        return None
    dimensions = system.spec.dimensions  # a Lagrangian that comes to the energy is wrong, as is a place to another
    usual = {dimensions.get(name) for name in system.spec.words(one.sides[0].written)} & {(1, 2, -2), (0, 1, 0)}
    rows, first, apart = _quantities_of(system)
    for equation in (each for each in one.meant[:MOST_MEANT] if _is_own(each, one, system)):
        try:
            with np.errstate(all="ignore"):
                value = evaluate(one.sides[1], equation.context(random_states(system)))
        except (Unread, KeyError):
            continue
        # most are another quantity at the first state already
        near = np.flatnonzero(~(np.abs(value.flat[0] - first) > apart)) if np.isfinite(value).all() else ()
        names = list[str]()
        for name, row in (rows[i] for i in near):
            if row.shape == value.shape and dimensions.get(name, ()) not in usual:
                off = value - row
                off = np.diff(np.split(off, 2), axis=0) if name in ENERGIES else off  # the halves share the parameters
                names += [name] * bool(np.abs(off).max() <= TOLERANCE * np.abs(row).max())
        called = size >= LONG or ACCELERATION.search(word)
        fits = [name for name in names if (called and _agrees(word, name)) or _is_named_like(word, name)]
        if fits := sorted(fits, key=lambda name: (not _is_named_like(word, name), len(name), name)):
            return fits[0], equation
    return None


def _is_own(equation: Equation, one: Printed, system: System) -> bool:
    """Whether the name on the left is the text's own: nobody's, or of another dimension than what it usually means."""
    left, right = one.sides
    usual = system.spec.dimensions.get(equation.meaning(left.value))
    mine = left.value == one.defines
    if mine or not usual or left.value in system.spec.state or (left.written and left.written.dots):
        return mine
    with suppress(Disagreement):
        found = dimension(right, equation.definitions, system.spec)
        return found is not None and tuple(found) != tuple(usual)
    return False


@cache
def _quantities_of(system: System) -> tuple[list[tuple[str, Values]], Values, Values]:
    """The quantities of a system at random states of the true motion; their first values; how far others may be off these.

    Any value may be that of an energy, which has a constant.
    """
    spec, states = system.spec, random_states(system)
    names = [name for name in spec.formulas if not name.endswith("_")]
    moving = [name for name in names if re.match(r"r|[xyz][pG]?\d?$", name)]
    names += [*spec.unknowns, *spec.rates, *(f"d{name}" for name in names if re.fullmatch(r"p(?:\d|x|theta)?", name))]
    names += ["ddq"] * ("q" in spec.formulas) + [d + name for name in moving for d in ("d", "dd")]
    rows = [(name, states[name]) for name in dict.fromkeys(names) if 0 < np.abs(states[name]).max() < np.inf]
    apart = [np.inf if name in ENERGIES else TOLERANCE * np.abs(row).max() for name, row in rows]
    return rows, np.array([row.flat[0] for _, row in rows]), np.array(apart)


def _agrees(word: str, name: str) -> bool:
    """Whether the indices of a name and of a quantity do not contradict each other."""
    mine, others = (re.findall(r"(?<![\[\d])(\d{1,2})", text)[:1] for text in (word, name))
    return not mine or not others or len(mine[0]) != len(others[0]) or mine == others


def _is_named_like(word: str, name: str) -> bool:
    """Whether a name begins like a quantity: xs, X1 or pos_x for x1 or x."""
    if (match := re.fullmatch(r"(d{0,2})([A-Za-z])[pG]?(\d*)", name)) is None:
        return False
    rate, letter, _ = match.groups()
    if rate:  # v_1x, a_x
        return bool(re.match(rf"{'va'[len(rate) - 1]}.*{letter}", word)) and _agrees(word[1:], name)
    begins = word[:1].lower() == letter.lower() or re.search(rf"(?:_|[Pp]os|tip|bob|end){letter}(?![a-z])", word)
    return bool(begins) and _agrees(word, name)


def in_use(equations: list[Printed], systems: list[System]) -> set[str]:
    """The symbols without dots and components that some equations use; those of a definition if what it defines is used.

    What comes to a quantity of the system is used as an equation is.
    """
    laws = [bool(one.ways) and bool(quantity_of(one, system)) for one, system in zip(equations, systems, strict=True)]
    used, before = set[str](), -1
    while len(used) > before:
        before = len(used)
        for one, law in zip(equations, laws, strict=True):
            if one.ways and (law or not one.defines or len(one.sides) > 2 or bare(one.defines) in used):
                letters = {bare(name) for name in one.names - {one.defines}}
                used |= letters | {letter.rpartition("_")[0] for letter in letters}
    return used


def bare(name: str) -> str:
    """A symbol without its dots."""
    return name.lstrip("?").lstrip("d") or "d"
