"""In which motions a wrong equation fails, and how its error grows with the parameters."""

import numpy as np

from pendpin.analysis.doctor.checking.evaluation import norm
from pendpin.analysis.doctor.checking.mechanics import Pendulum, Quantities, Values
from pendpin.analysis.doctor.checking.residuals import (
    TOLERANCE,
    Equation,
    random_states,
    relative_error,
    residuals_and_sizes,
)
from pendpin.analysis.doctor.reading.tree import Unread


def when(equation: Equation, pendulum: Pendulum) -> str:
    """In which motions a wrong equation fails, in words."""
    cases = {
        "already at rest": ("dtheta", "dphi"),
        "as soon as theta turns": ("dphi",),
        "as soon as phi turns": ("dtheta",),
    }
    full = random_states(pendulum)
    states = {text: random_states(pendulum, still) for text, still in cases.items()}
    wrong = [text for text, there in states.items() if _fails(equation, there, full)]
    if wrong[:1] == ["already at rest"]:
        return wrong[0]
    return " and ".join(wrong) or "only when theta and phi both turn"


def _fails(equation: Equation, quantities: Quantities, full: Quantities) -> bool:
    """Whether an equation fails at some states; not where it has no value, as one that is divided by a rate at rest."""
    try:
        return relative_error(equation, quantities, full) > TOLERANCE
    except Unread:
        return False


def scaling(equation: Equation, pendulum: Pendulum) -> str:
    """How the residual grows with m, l and g, as a product of powers; empty where it is none."""
    here = _size(equation, random_states(pendulum))
    words = []
    for name in ("m", "l", "g"):
        there = _size(equation, random_states(pendulum, doubled=name))
        with np.errstate(all="ignore"):
            power = np.log2(there / here)
        if not np.isfinite(power).all() or np.ptp(power) > 1e-6 or abs(power[0] - round(power[0])) > 1e-6:
            return ""
        words += [name + ("" if round(power[0]) == 1 else f"^{round(power[0])}")] if round(power[0]) else []
    return " ".join(words)


def _size(equation: Equation, quantities: Quantities) -> Values:
    with np.errstate(all="ignore"):
        return np.concatenate([norm(rows) for rows, _ in residuals_and_sizes(equation, quantities)])
