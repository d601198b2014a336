"""The laws in their usual form, off the true motion: what a mended equation is compared with.

An equation multiplied by 4 holds as well; of two mends the one that gives a law in its usual form is the likelier.
"""

from functools import cache

import numpy as np

from pendpin.doctor.checking.dimensions import of_equation
from pendpin.doctor.checking.residuals import Equation, residuals
from pendpin.doctor.mending.monomials import reader_of
from pendpin.doctor.systems.base import System, Values, free_states, solved

USUAL = -0.12  # what a law in its usual form takes off the cost
MULTIPLE = 0.12  # what an odd multiple of one adds
UNUSUAL = 0.06  # what sides of an unusual dimension add


@cache
def _laws(system: System) -> list[Values]:
    """What each balance leaves over, (n,): forces, moments about G and about the joint, along the axes of B and A."""
    q = free_states(system)
    truth = solved(q)
    return [q[name] - truth[name] for name in system.spec.unknowns] + system.spec.laws(q)


def standing(equation: Equation, system: System) -> tuple[Values, float]:
    """An equation's residual off the true motion up to a factor, and what its form adds to the cost of a mend."""
    quantities = free_states(system)
    values = np.concatenate([rows for rows, _ in residuals(equation, quantities)])
    odd = _unusual(equation, system) + (_oddness(values[0], system) if len(values) == 1 else 0.0)
    flat = values.ravel()
    largest = flat[np.argmax(np.abs(flat))]
    return (flat / largest if abs(largest) > 1e-12 else flat), odd


def _unusual(equation: Equation, system: System) -> float:
    """What an equation costs whose sides are not a quantity of mechanics, such as a mass over a time squared."""
    found, disagreement = of_equation(equation, system.spec)
    usual = found is None or tuple(map(int, found)) in system.spec.dimensions.values() or found == (0, 2, -2)
    return 0.0 if usual and not disagreement else UNUSUAL


def _oddness(values: Values, system: System) -> float:
    reader = reader_of(free_states(system))
    for law in _laws(system):
        with np.errstate(all="ignore"):
            ratio = values / law
        if np.isfinite(ratio).all() and (found := reader.plain(ratio)) is not None:
            return USUAL if abs(found.factor) == 1 else MULTIPLE
    return 0.0
