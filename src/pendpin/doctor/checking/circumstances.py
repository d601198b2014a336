"""In which motions a wrong equation fails, and how its error grows with the parameters."""

import numpy as np

from pendpin.doctor.checking.evaluation import norm
from pendpin.doctor.checking.residuals import (
    TOLERANCE,
    Equation,
    relative_error,
    residuals_and_sizes,
)
from pendpin.doctor.reading.tree import Unread
from pendpin.doctor.systems.base import Quantities, System, Values, random_states


def when(equation: Equation, system: System) -> str:
    """In which motions a wrong equation fails, in words."""
    rates = system.spec.rates
    full = random_states(system)
    still = lambda names: random_states(system, tuple((name, 0.0) for name in names))  # noqa: E731
    if _fails(equation, still(rates), full):
        return "already at rest"
    alone = (name for name in rates if _fails(equation, still([r for r in rates if r != name]), full))
    wrong = [f"as soon as {name[1:]} {'turns' if name[1:] in system.spec.angles else 'moves'}" for name in alone]
    return " and ".join(wrong) or f"only when {' and '.join(system.spec.coordinates)} both turn"


def _fails(equation: Equation, quantities: Quantities, full: Quantities) -> bool:
    """Whether an equation fails at some states; not where it has no value, as one that is divided by a rate at rest."""
    try:
        return relative_error(equation, quantities, full) > TOLERANCE
    except Unread:
        return False


def scaling(equation: Equation, system: System) -> str:
    """How the residual grows with m, l and g, as a product of powers; empty where it is none."""
    here = _size(equation, random_states(system))
    words = []
    for name in (name for name in ("m", "l", "g") if name in system.spec.parameters):
        there = _size(equation, random_states(system, doubled=name))
        with np.errstate(all="ignore"):
            power = np.log2(there / here)
        if not np.isfinite(power).all() or np.ptp(power) > 1e-6 or abs(power[0] - round(power[0])) > 1e-6:
            return ""
        words += [name + ("" if round(power[0]) == 1 else f"^{round(power[0])}")] if round(power[0]) else []
    return " ".join(words)


def _size(equation: Equation, quantities: Quantities) -> Values:
    with np.errstate(all="ignore"):
        return np.concatenate([norm(rows) for rows, _ in residuals_and_sizes(equation, quantities)])
