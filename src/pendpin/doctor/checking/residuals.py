"""The residuals of an equation at random states of the true motion, and its dimensions."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np

from pendpin.doctor.checking.evaluation import ENERGIES, Equation, Instead, Known, evaluate, norm, scale
from pendpin.doctor.reading.tree import Mismatch, Node, Unread
from pendpin.doctor.systems.base import Quantities, Spec, Values

TOLERANCE = 1e-9  # relative to the terms, in floats
ZERO = Node("number", (0, 0), Fraction(0))  # the right side of an expression alone
Dimension = tuple[float, ...]  # powers of kg, m, s: multiples of 1/2 or 1/4, which floats hold exactly
NONE: Dimension = (0, 0, 0)

WHOLE = {"sqrt": 0.5, "norm": 1, "transpose": 1}  # functions of quantities with a unit


def residuals(
    equation: Equation, q: Quantities, known: Known | None = None, instead: Instead | None = None, plain: bool = False
) -> list[tuple[Values, Values]]:
    """Of each pair of neighbouring sides: left minus right, rows of scalars (k, n), and the size of the terms (n,).

    `instead` gives parts another value; the sizes are then 0. Raises Unread where a vector is set equal to a number.

    They are less what a constant in the energies may account for, but for `plain` ones. That constant is the residual over
    its slope in the energies. It may depend on the parameters, which the second half of the states shares with the first:
    what is left is the difference between the halves, times the slope.
    """
    if equation.names & {"q_i", "dq_i"}:
        meant = ({"q_i": angle, "dq_i": f"d{angle}"} for angle in ("theta", "phi"))
        each = (replace(equation, meanings=equation.meanings | one) for one in meant)
        return [pair for one in each for pair in residuals(one, q, known, instead, plain)]
    known, context, found = {} if known is None else known, equation.context(q), list[tuple[Values, Values]]()
    sides = equation.sides if len(equation.sides) > 1 else (*equation.sides, ZERO)
    values = {id(side): evaluate(side, context, known, instead) for side in (*sides, *equation.still)}
    for pair in (*pairwise(sides), *([equation.still] if equation.still else ())):
        left, right = (values[id(side)] for side in pair)
        if left.shape[:-1] != right.shape[:-1]:  # 0 fits any shape
            if left.ndim == right.ndim:
                raise Mismatch("vectors of different lengths are set equal", pair[0].span[0])
            small = pair[0] if left.ndim < right.ndim else pair[1]
            if small.kind != "number" or small.value:
                raise Mismatch("a vector is set equal to a number", small.span[0])
            left, right = (np.zeros_like(right), right) if small is pair[0] else (left, np.zeros_like(left))
        size: Values = np.zeros(1)
        if q.xp is np and instead is None:
            size = norm(left) + sum((scale(side, context, known) for side in pair), start=size)
        found.append(((left - right).reshape(-1, left.shape[-1]), size))
    if plain or not equation.energies:
        return found
    names = {id(node): equation.meaning(node.value) for node in equation.energies}
    moved = {place: q[name] + q.number(ENERGIES[name]) for place, name in names.items()}
    half = q.shape[-1] // 2
    for i, (there, _) in enumerate(residuals(equation, q, None, moved | dict(instead or {}), plain=True)):
        rows, size = found[i]
        if np.any(slope := there - rows):
            with np.errstate(all="ignore"):
                constant = rows / slope
            found[i] = (constant[:, :half] - constant[:, half : 2 * half]) * slope[:, :half], size
    return found


def stack_residuals(
    equation: Equation, q: Quantities, known: Known | None = None, instead: Instead | None = None, plain: bool = False
) -> Values:
    """The residuals as one array (k, n); where a constant in the energies halves some rows, all have the first half."""
    rows = [rows for rows, _ in residuals(equation, q, known, instead, plain)]
    states = min(part.shape[1] for part in rows)
    return np.concatenate([part[:, :states] for part in rows])


def changed(equation: Equation, quantities: Quantities, instead: Instead) -> Values | None:
    """The residual with other values for some parts, rows (k, n); None where they have no meaning there."""
    with suppress(Unread), np.errstate(all="ignore"):
        return stack_residuals(equation, quantities, None, instead)
    return None


def relative_error(equation: Equation, quantities: Quantities, full: Quantities | None = None) -> float:
    """The residual over the terms, root mean square over random states. Raises Unread, also for infinite values.

    `full` gives other states whose terms the residual is compared with: where nothing turns, terms may be rounding alone.
    """
    with np.errstate(all="ignore"):
        here = residuals(equation, quantities)
        there = here if full is None else residuals(equation, full)
        top = np.array([np.sqrt((rows**2).sum(0).mean()) for rows, _ in here])
        bottom = np.array([np.sqrt((size**2).mean()) for _, size in there])
    if not (np.isfinite(top).all() and np.isfinite(bottom).all()):
        raise Unread("it divides by 0, takes the root of a negative number or grows beyond bounds")
    return float((top / np.where(bottom, bottom, 1.0)).max())


def holds(equation: Equation, quantities: Quantities) -> bool:
    """Whether an equation has a value and holds at random states."""
    with suppress(Unread, KeyError):
        return relative_error(equation, quantities) < TOLERANCE
    return False


class Disagreement(Exception):
    """Terms of different dimensions are added or set equal; the message names them."""


def dimension(
    node: Node, definitions: Mapping[str, Node], spec: Spec, found: dict[str, Dimension | None]
) -> Dimension | None:
    """Powers of kg, m and s; None for what fits anything (0, or a name that is not known). Raises Disagreement.

    `found` holds what definitions come to, each worked out once; one that is by itself fits anything.
    """
    parts = [dimension(child, definitions, spec, found) for child in node.children]
    match node.kind:
        case "number":
            return NONE if node.value else None
        case "symbol":
            name = str(node.value)
            if name in definitions and name not in found:
                found[name] = None
                found[name] = dimension(definitions[name], definitions, spec, found)
            return found[name] if name in definitions else spec.dimensions.get(name)
        case "sum" | "matrix":
            return common(parts)
        case "product":
            total = NONE
            for operator, part in zip(node.value, parts, strict=True):
                if part is None:
                    return None
                (kg, m, s), (in_kg, in_m, in_s) = total, part
                below = operator == "/"
                total = (kg - in_kg, m - in_m, s - in_s) if below else (kg + in_kg, m + in_m, s + in_s)
            return total
        case "power":
            return _times(parts[0], float(node.value))
        case "function" if node.value in WHOLE:
            return _times(parts[0], WHOLE[node.value])
        case "function":
            common([parts[0], NONE])
            return NONE
        case _:
            return None


def _times(of: Dimension | None, factor: float) -> Dimension | None:
    return None if of is None else tuple(factor * power for power in of)


def common(parts: list[Dimension | None]) -> Dimension | None:
    """The dimension that all have. Raises Disagreement."""
    definite = [part for part in parts if part is not None]
    for part in definite:
        if part != definite[0]:
            raise Disagreement(f"{unit(definite[0])} and {unit(part)}")
    return definite[0] if definite else None


def unit(dimension: Dimension) -> str:
    """A dimension as a unit."""
    names: dict[Dimension, str] = {(1, 2, -2): "N m", (1, 1, -2): "N", (0, 0, 0): "a pure number"}
    if (plain := tuple(dimension)) in names:
        return names[plain]
    digits, written = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"), []
    for symbol, power in zip(("kg", "m", "s"), map(Fraction, dimension), strict=True):
        raised = str(power).translate(digits) if power.denominator == 1 else f"^({power})"
        written += [symbol + ("" if power == 1 else raised)] if power else []
    return " ".join(written)


def of_equation(equation: Equation, spec: Spec) -> tuple[Dimension | None, str]:
    """The dimension that all sides have, and in words which do not agree, empty where all do."""
    chosen = {name: Node("symbol", (0, 0), other) for name, other in equation.meanings.items() if name != other}
    try:
        known, found = equation.definitions | chosen, dict[str, Dimension | None]()
        return common([dimension(side, known, spec, found) for side in equation.sides]), ""
    except Disagreement as disagreement:
        return None, str(disagreement)
