"""The verdict on an equation: at random states first, then by proof; in which motions it fails; laws of any system."""

import re
from dataclasses import dataclass, replace

import numpy as np

from pendpin.doctor.checking import exact
from pendpin.doctor.checking.evaluation import evaluate
from pendpin.doctor.checking.residuals import (
    TOLERANCE,
    Equation,
    relative_error,
    residuals,
    residuals_and_sizes,
    slopes,
)
from pendpin.doctor.reading.tree import Node, Unread, parts
from pendpin.doctor.systems.base import Quantities, Spec, System, Values, free_states, random_base, random_states

EXACT_STATES = 60
SAME = 1e-8  # relative: of second derivatives eight digits are left


@dataclass(frozen=True)
class Verdict:
    """Whether an equation holds, whether that is proved, and the error relative to its terms."""

    holds: bool
    proved: bool
    error: float
    remark: str = ""


def check(equation: Equation, system: System) -> Verdict:
    """Whether an equation holds on every true motion: at random states first, then by proof. Raises Unread."""
    error = relative_error(equation, random_states(system))
    if error > TOLERANCE:
        difference, sure = harmless(equation, system)
        return Verdict(True, sure, 0.0, difference) if difference else Verdict(False, True, error)
    if not system.spec.analytic:
        return Verdict(True, False, error, "compared with the scene's dynamics at 60 random states")
    try:
        return Verdict(_proves(equation, system), True, error)
    except exact.Unprovable:  # a square root: 50 digits tell
        xp = exact.fifty_digits()
        base = {name: xp.asarray(values) for name, values in random_base(system.spec, EXACT_STATES, seed=1).items()}
        rows = residuals_and_sizes(equation, Quantities(base, system, xp, true=True))
        return Verdict(all(abs(x) < 1e-30 for row, _ in rows for x in np.asarray(row).flat), False, error)


def _proves(equation: Equation, system: System) -> bool:
    """Whether sympy's polynomials reduce every residual to 0. Raises Unprovable where they cannot tell."""
    quantities = exact.polynomial_states(system, True)
    values = [row[0] for rows, _ in residuals(equation, quantities) for row in rows]
    if not equation.floats:
        return all(value.zero for value in values)
    moved = [row[0] for rows in slopes(equation, quantities, None) for row in rows]
    pairs = zip(values, moved, strict=True)
    return all(value.zero if slope.zero else exact.constant(value / slope, system.spec) for value, slope in pairs)


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
    alone = (name for name in rates if fails_without([rate for rate in rates if rate != name]))
    wrong = [f"as soon as {name[1:]} {'turns' if name[1:] in system.spec.angles else 'moves'}" for name in alone]
    return " and ".join(wrong) or f"only when {' and '.join(system.spec.coordinates)} both turn"


def harmless(equation: Equation, system: System) -> tuple[str, bool]:
    """How a Lagrangian differs from T - V where that changes no equation of motion, and whether that is proved."""
    lone = [side for side in equation.sides if side.kind == "symbol" and equation.meaning(side.value) == "L"]
    others = [side for side in equation.sides if side not in lone]
    if not lone or not others or equation.names & set(system.spec.unknowns):
        return "", False
    # a positive multiple: states of the second half share their parameters with the first, and nothing else
    same, true = True, _motion(lone[0], equation, free_states(system))
    for side in others:
        with np.errstate(all="ignore"):
            ratio = _motion(side, equation, free_states(system)) / true
        first, second = np.split(ratio, 2, axis=1)
        if not (ratio > 0).all() or max(np.abs(ratio - ratio[0]).max(), np.abs(first - second).max()) > SAME:
            return "", False
        same = same and (side is not others[0] or bool(np.abs(ratio - 1).max() < SAME))
    words = f"it is T - V{'' if same else ' times a constant'} up to a total derivative, which changes no equation of motion"
    return words, system.spec.analytic and _proves_motion(equation, lone[0], others, system)


def _proves_motion(equation: Equation, lone: Node, others: list[Node], system: System) -> bool:
    """Whether Euler and Lagrange's equations of two Lagrangians are proved to be the same but for a constant."""
    try:
        states = exact.polynomial_states(system, False)
        true = _motion(lone, equation, states)[:, 0]
        for side in others:
            motion = _motion(side, equation, states)[:, 0]
            ratio = motion[0] / true[0]
            same = all((m - ratio * t).zero for m, t in zip(motion, true, strict=True))
            if not (same and exact.constant(ratio, system.spec)):
                return False
    except exact.Unprovable:
        return False
    return True


def euler_lagrange(lagrangian: Node, spec: Spec) -> list[Node]:
    """The left sides of Euler and Lagrange's equations, one for each coordinate."""
    place = (lagrangian.outer[0], lagrangian.outer[0])
    by = lambda node, name: Node("derivative", lagrangian.span, name, (node,))  # noqa: E731
    return [
        Node("sum", lagrangian.span, (1, -1), (by(by(lagrangian, f"d{q}"), "t"), by(lagrangian, q)), (place, place))
        for q in spec.coordinates
    ]


def _motion(side: Node, equation: Equation, quantities: Quantities) -> Values:
    """Euler and Lagrange's left sides of an expression, (coordinates, n)."""
    context = equation.context(quantities)
    return np.stack([evaluate(left, context) for left in euler_lagrange(side, quantities.spec)])


def is_general(equation: Equation, system: System) -> bool:
    """Whether an equation is Euler and Lagrange's or Hamilton's for any coordinate q_i, or with a force Q of its own."""
    spec, nodes = system.spec, [*parts(equation.sides)]
    by = {str(node.value).lstrip("?") for node in nodes if node.kind == "derivative" and node.value != "t"}
    lone = [side for side in equation.sides if side.kind == "symbol" and str(side.value).startswith("?")]
    sides = [side for side in equation.sides if side not in lone]
    known = equation.names & {*spec.parameters, "q_i"}  # of a rod q_i is known, and the equation is proved
    if not by or len(equation.sides) != 2 or not sides or known:
        return False
    named = [name for name in spec.coordinates if {name, f"d{name}"} & by]
    if named and not lone:  # one coordinate: checked as any other equation
        return False
    bases = {name.removeprefix("d") for name in by if name not in spec.state and name[0] != "p"}
    momenta = {name.lstrip("?") for name in {str(node.value) for node in nodes} if re.match(r"\??d?p", name)}
    states, free = random_states(system), free_states(system)
    try:
        for name in named or spec.coordinates:
            own = next((one for one in (f"p{name}", f"p{name[-1]}", "p") if one in spec.formulas), "")
            meanings = {f"{mark}{d}{base}": f"{d}{name}" for base in bases for d in ("", "d") for mark in ("?", "")}
            meanings |= {f"{mark}{one}": "d" * (one[0] == "d") + own for one in momenta if own for mark in ("?", "")}
            here = replace(equation, meanings=equation.meanings | meanings)
            signs = (1, -1)
            off, true = (
                sum(
                    np.asarray(evaluate(side, here.context(q))) * sign for side, sign in zip(sides, signs, strict=False)
                )
                for q in (free, states)
            )
            law = _motion(Node("symbol", (0, 0), "L"), here, free)[spec.coordinates.index(name)]
            is_law = min(np.abs(off - law).max(), np.abs(off + law).max()) <= TOLERANCE * np.abs(law).max()
            if not is_law and (lone or not momenta or np.abs(true).max() > TOLERANCE):
                return False
    except (Unread, KeyError):
        return False
    return True
