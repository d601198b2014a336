"""Solutions in time, theta(t) = A exp(-b t) cos(w t): whether they obey an equation of motion of their text.

Constants that the text does not define have some value; a solution is right for any.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice
from typing import Any

import mpmath
import numpy as np

from pendpin.doctor.checking.evaluation import Equation
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.tree import Node, parts, with_meaning
from pendpin.doctor.systems.base import System, random_states

DIGITS, SMALL = 30, 1e-12  # what is left of the terms; parameters and what follows from them have 16 digits
TIMES = (0.37, 1.61)  # at which a solution is tried
MOST_READINGS, MOST_LAWS = 4, 20
FUNCTIONS = ("sin", "cos", "tan", "sqrt", "exp")


def solved(one: Printed, equations: list[Printed], system: System) -> tuple[Equation, int] | None:
    """How a solution in time is read, and the number of the equation that it obeys; None for one that obeys none.

    A rate in time obeys the solution of which it is the rate.
    """
    coordinates = {f"{'d' * dots}{name}": (name, dots) for name in system.spec.coordinates for dots in (0, 1)}
    left, right = (one.sides[0], one.sides[-1]) if len(one.sides) > 1 else (None, None)
    if left is None or right is None or left.value not in coordinates or not _is_of_time(right):
        return None
    name, dots = coordinates[left.value]
    laws = [other for other in equations if other is not one and len(other.sides) == 2]
    for equation in (*islice(one.readings(), MOST_READINGS), *_with_own_letters(one, laws)):
        for other in islice(_laws_of(name, dots, laws), MOST_LAWS):
            for law in islice(other.readings(), MOST_READINGS):
                meanings, definitions = law.meanings | equation.meanings, law.definitions | equation.definitions
                both = replace(law, meanings=meanings, definitions=definitions)
                motion = _function_of_time(equation.sides[-1], both, system, {})
                rates = {f"{'d' * order}{name}": _rate(motion, order) for order in range(3)}
                sides = [_function_of_time(side, both, system, {} if dots else rates) for side in law.sides]
                if _agree(*((_rate(sides[1]), motion) if dots else sides)):
                    return equation, other.number
    return None


def _laws_of(name: str, dots: int, laws: list[Printed]) -> Iterator[Printed]:
    """The equations that a motion of a coordinate has to obey; of its rate, solutions of it."""
    for other in laws:
        timely = any(map(_is_of_time, other.sides))
        if (dots and timely and other.sides[0].value == name) or (not (dots or timely) and f"dd{name}" in other.names):
            yield other


def _with_own_letters(one: Printed, laws: list[Printed]) -> Iterator[Equation]:
    """The equation with what its text says of letters that usually mean another thing, as omega of the damped swing."""
    pairs = [(other.sides[0].written, other.sides[1]) for other in laws]
    inside = {part.written for part in parts(one.sides[1:]) if not str(part.value).startswith("?")}
    own = {name: node for name, node in pairs if name in inside and name and not name.dots and node.children}
    if own:
        sides = one.sides
        for name in own:
            sides = (*sides[:1], *(with_meaning(side, name, f"?own {name}") for side in sides[1:]))
        definitions = {f"?own {name}": node for name, node in own.items()}
        yield Equation(sides, definitions=one.definitions | definitions)


def _is_of_time(node: Node) -> bool:
    return any(part.kind == "symbol" and part.value == "t" for part in parts([node]))


def _rate(function: Callable[[Any], Any], order: int = 1) -> Callable[[Any], Any]:
    return lambda t: mpmath.diff(function, t, order)


def _agree(first: Callable[[Any], Any], second: Callable[[Any], Any]) -> bool:
    """Whether two functions of time are the same."""
    with mpmath.workdps(DIGITS):
        try:
            pairs = [(first(mpmath.mpf(t)), second(mpmath.mpf(t))) for t in TIMES]
        except (ArithmeticError, ValueError, KeyError, TypeError):  # what has no value there, or is no function of time
            return False
        sizes = [abs(a) + abs(b) for a, b in pairs]
        return all(abs(a - b) <= SMALL * max(1, size) for (a, b), size in zip(pairs, sizes, strict=True))


def _function_of_time(
    node: Node, equation: Equation, system: System, motion: dict[str, Callable[[Any], Any]]
) -> Callable[[Any], Any]:
    """An expression as a function of time: states are those of a motion, parameters of a system have their values.

    KeyError for a state where no motion is given.
    """
    states = random_states(system)
    strange = dict[str, float]()  # constants of the text, by their names

    def value(node: Node, t: Any) -> Any:
        inside = [value(child, t) for child in node.children]
        match node.kind:
            case "number":
                return mpmath.mpf(node.value.numerator) / node.value.denominator
            case "symbol":
                return named(equation.meaning(str(node.value)), t)
            case "sum":
                return mpmath.fsum(sign * part for sign, part in zip(node.value, inside, strict=True))
            case "product" if {*node.value} <= {*"*/."}:
                return mpmath.fprod(1 / x if sign == "/" else x for sign, x in zip(node.value, inside, strict=True))
            case "power":
                return inside[0] ** (mpmath.mpf(node.value.numerator) / node.value.denominator)
            case "function" if node.value in FUNCTIONS:
                return getattr(mpmath, node.value)(inside[0])
        raise KeyError(node.kind)

    def named(name: str, t: Any) -> Any:
        if name in motion:
            return motion[name](t)
        if name in equation.definitions:
            return value(equation.definitions[name], t)
        if name in ("t", "pi"):
            return t if name == "t" else mpmath.pi
        if name.startswith("?"):
            return strange.setdefault(name, 0.3 + math.fmod(sum(map(ord, name)) * 0.6180339887, 1.0))
        first, second = np.split(states[name], 2)  # other motions with the same parameters
        if np.abs(first - second).max() > SMALL * np.abs(first).max():  # it moves
            raise KeyError(name)
        return mpmath.mpf(float(first[0]))

    return lambda t: value(node, t)
