"""The verdict on an equation: at random states first, then by proof; and Lagrangians that give the same motion."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from pendpin.analysis.doctor.checking import exact
from pendpin.analysis.doctor.checking.evaluation import Context, evaluate
from pendpin.analysis.doctor.checking.exact import printed_quantities
from pendpin.analysis.doctor.checking.mechanics import COORDINATES, PARAMETERS, Pendulum, Quantities, solved
from pendpin.analysis.doctor.checking.residuals import (
    TOLERANCE,
    Equation,
    random_base,
    random_states,
    relative_error,
    residuals,
    residuals_and_sizes,
    slopes,
)
from pendpin.analysis.doctor.reading.names import UNKNOWNS
from pendpin.analysis.doctor.reading.tree import Unread

EXACT_STATES = 500


@dataclass(frozen=True)
class Verdict:
    """Whether an equation holds, whether that is proved, and the error relative to its terms."""

    holds: bool
    proved: bool
    error: float
    remark: str = ""


def check(equation: Equation, pendulum: Pendulum) -> Verdict:
    """Whether an equation holds on every true motion: at random states first, then by proof. Raises Unread."""
    error = relative_error(equation, random_states(pendulum))
    if error > TOLERANCE:
        difference = harmless(equation, pendulum)
        return Verdict(True, True, 0.0, difference) if difference else Verdict(False, True, error)
    try:
        proved = proves(equation, pendulum)
    except exact.Unprovable:
        return Verdict(_holds_in_50_digits(equation, pendulum), False, error)
    return Verdict(proved, True, error)


def proves(equation: Equation, pendulum: Pendulum) -> bool:
    """Whether sympy's polynomials reduce every residual to 0. Raises Unprovable where they cannot tell."""
    quantities = _polynomial_truth(pendulum)
    values = [row[0] for rows, _ in residuals(equation, quantities) for row in rows]
    if not equation.floats:
        return all(value.zero for value in values)
    moved = [row[0] for rows in slopes(equation, quantities, None) for row in rows]
    pairs = zip(values, moved, strict=True)
    return all(value.zero if slope.zero else exact.constant(value / slope) for value, slope in pairs)


@cache
def _polynomial_truth(pendulum: Pendulum) -> Quantities:
    xp = exact.polynomials()
    base = exact.polynomial_base((*COORDINATES, *PARAMETERS[pendulum.rod]))
    return solved(Quantities(base, pendulum, xp))


def _holds_in_50_digits(equation: Equation, pendulum: Pendulum) -> bool:
    xp = exact.fifty_digits()
    base = {name: xp.asarray(values) for name, values in random_base(pendulum.rod, EXACT_STATES, seed=1).items()}
    quantities = solved(Quantities(base, pendulum, xp))
    return all(abs(x) < 1e-35 for rows, _ in residuals_and_sizes(equation, quantities) for x in np.asarray(rows).flat)


def harmless(equation: Equation, pendulum: Pendulum) -> str:
    """How a Lagrangian differs from T - V, in words, where that changes no equation of motion; else empty."""
    lone = [side for side in equation.sides if side.kind == "symbol" and equation.meanings.get("L", "L") == side.value]
    others = [side for side in equation.sides if side not in lone]
    if not lone or not others or lone[0].value != "L" or equation.names & set(UNKNOWNS):
        return ""
    quantities = printed_quantities(pendulum)
    context = equation.context(quantities)
    values = [evaluate(side, context) for side in others]
    factors = {_factor(value[0], quantities["L"][0]) if value.ndim == 1 else None for value in values}
    factor = factors.pop()
    if factors or factor is None:
        return ""
    times = "" if factor == 1 else f" times {factor}".replace("**", "^")
    return f"it is T - V{times} up to a total derivative, which changes no equation of motion"


def _factor(lagrangian: Any, true: Any) -> Any:
    """The positive constant times which a Lagrangian gives the true one's equations of motion; None where none does."""
    from sympy import Symbol, cancel, diff

    still = dict.fromkeys(map(Symbol, COORDINATES), 0)
    inertias = [diff(value, Symbol("dphi"), 2).subs(still) for value in (lagrangian, true)]
    factor = cancel(inertias[0] / inertias[1])
    size = factor.subs(dict.fromkeys(factor.free_symbols, 1))
    return factor if size.is_positive and _no_motion(lagrangian - factor * true) else None


def _no_motion(lagrangian: Any) -> bool:
    """Whether Euler and Lagrange's equations of an expression are 0 for every motion."""
    return all(_identically_zero(expression) for expression in euler_lagrange(lagrangian))


def euler_lagrange(lagrangian: Any) -> list[Any]:
    """The left sides of Euler and Lagrange's equations for theta and phi, in sympy's symbols."""
    from sympy import Symbol, diff

    q, v, a = (tuple(Symbol(f"{d}{name}") for name in ("theta", "phi")) for d in ("", "d", "dd"))
    momenta = [diff(lagrangian, rate) for rate in v]
    rates = [sum(diff(p, q[j]) * v[j] + diff(p, v[j]) * a[j] for j in range(2)) for p in momenta]
    return [rate - diff(lagrangian, angle) for rate, angle in zip(rates, q, strict=True)]


def _identically_zero(expression: Any) -> bool:
    from pendpin.analysis.doctor.reading.grammar import parse

    names = (*COORDINATES, *UNKNOWNS, "m", "l", "g", "h", "r", "I1", "I2", "I3")
    try:
        quantities = Quantities(exact.polynomial_base(names), Pendulum("general"), exact.polynomials())
        value = evaluate(parse(str(expression))[0][0], Context(quantities, {}))
        return bool(value[0].zero)
    except (exact.Unprovable, Unread):
        return False
