"""Solutions in time, theta(t) = A exp(-b t) cos(w t): whether they obey an equation of motion of their text.

Constants that the text does not define have some value; a solution is right for any.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import islice

import numpy as np

from pendpin.doctor.checking.check import EXACT, in_fifty_digits
from pendpin.doctor.checking.conditions import with_numbers
from pendpin.doctor.checking.evaluation import Equation
from pendpin.doctor.checking.residuals import stack_residuals
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.tree import Node, Unread, parts, walk, with_meaning
from pendpin.doctor.systems.base import Quantities, System, random_states

TIMES = (0.37, 1.61)  # at which a solution is tried
MOST_READINGS, MOST_LAWS = 4, 20


def solved(one: Printed, equations: list[Printed], system: System) -> tuple[Equation, int] | None:
    """How a solution in time is read, and the number of the equation that it obeys; None for one that obeys none.

    It takes the place of the coordinate there, and its rates that of the rates. A rate in time obeys the solution of which
    it is the rate.
    """
    coordinates = {f"{'d' * dots}{name}": (name, dots) for name in system.spec.coordinates for dots in (0, 1)}
    left, right = (one.sides[0], one.sides[-1]) if len(one.sides) > 1 else (None, None)
    if left is None or right is None or left.value not in coordinates or all(part.value != "t" for part in walk(right)):
        return None
    name, dots = coordinates[left.value]
    laws = [other for other in equations if other is not one and len(other.sides) == 2]
    obeyed = list[Printed]()  # laws of the coordinate, or of its rate solutions
    for other in laws:
        timely = any(part.value == "t" and part.kind == "symbol" for part in parts(other.sides))
        of_rate, of_motion = dots and timely and other.sides[0].value == name, f"dd{name}" in other.names
        obeyed += [other] if of_rate or (of_motion and not (dots or timely)) else []
    for equation in (*islice(one.readings(), MOST_READINGS), *_with_own_letters(one, laws)):
        motion = equation.sides[-1]
        moves = {} if dots else {name: motion, f"d{name}": _rate(motion), f"dd{name}": _rate(_rate(motion))}
        for other in obeyed[:MOST_LAWS]:
            for law in islice(other.readings(), MOST_READINGS):
                sides = (_rate(law.sides[1]), motion) if dots else tuple(map(_of_small_angles, law.sides))
                definitions = law.definitions | equation.definitions | moves
                tried = replace(law, sides=sides, meanings=law.meanings | equation.meanings, definitions=definitions)
                with suppress(Unread, ArithmeticError):
                    rows = stack_residuals(with_numbers(tried), _in_time(system), plain=True)
                    if (np.abs(rows) < EXACT).all():
                        return equation, other.number
    return None


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


def _rate(node: Node) -> Node:
    return Node("derivative", node.span, "t", (node,))


def _of_small_angles(node: Node) -> Node:
    """An expression with angles in place of their sines, and 1 in place of their cosines."""
    if node.kind == "function" and node.value in ("sin", "cos") and node.children[0].kind == "symbol":
        return node.children[0] if node.value == "sin" else Node("number", node.span, Fraction(1))
    return replace(node, children=tuple(map(_of_small_angles, node.children))) if node.children else node


@cache
def _in_time(system: System) -> Quantities:
    """Some parameters of a system at some times, in 50 digits; where it is then, a solution has to say."""
    states = in_fifty_digits(random_states(system))
    base = {name: values[: len(TIMES)] for name, values in states.base.items()}
    base |= {name: base[name] * np.nan for name in system.spec.state}
    return Quantities(base | {"t": states.xp.asarray(TIMES)}, system, states.xp)
