"""In which motions a wrong equation fails."""

from pendpin.doctor.checking.residuals import (
    TOLERANCE,
    Equation,
    relative_error,
)
from pendpin.doctor.reading.tree import Unread
from pendpin.doctor.systems.base import Quantities, System, random_states


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
