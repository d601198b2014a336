"""The verdict on an equation at random states, in floats and in 50 digits; in which motions it fails; laws of any system."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from pendpin.doctor.checking.evaluation import Equation, evaluate
from pendpin.doctor.checking.residuals import TOLERANCE, relative_error, stack_residuals
from pendpin.doctor.reading.tree import Node, Unread, parts
from pendpin.doctor.systems.base import STATES, Formula, Quantities, Spec, System, Values, free_states, random_states
from pendpin.equations.base import exact
from pendpin.ground.libraries import optional

EXACT = 1e-25  # what is left in 50 digits: three derivatives within each other leave 1e-32
PAIRS = 4  # states in 50 digits from either half of the random states


def check(equation: Equation, system: System) -> tuple[bool, bool, float]:
    """Whether an equation holds on every true motion, whether to 25 digits rather than those of floats, and its error.

    It is compared at random states, in floats and then in 50 digits. The error is relative to its terms. Raises Unread.
    """
    states = random_states(system)
    error = relative_error(equation, states)
    if error > TOLERANCE or not system.spec.analytic:
        return error <= TOLERANCE, error > TOLERANCE, error
    return bool(np.abs(stack_residuals(equation, in_fifty_digits(states))).max() < EXACT), True, error


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
            lefts = euler_lagrange(Node("symbol", (0, 0), "L"), spec)
            law = evaluate(lefts[spec.coordinates.index(name)], here.context(free))
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
