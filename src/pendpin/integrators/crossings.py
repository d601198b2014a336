"""The first zero crossing of functions of time, from their signs and turning points.

A function is sampled at Chebyshev points. The coefficients of its interpolant bound its least value; most intervals have
no crossing by this test. Otherwise the interval is halved until the last coefficients vanish; the turning points of the
interpolant then show whether it crosses zero, and where.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from pendpin.arrays import Array, Mask

DEGREE = 8  # of the interpolants
UNSEEN = 4.0  # times the larger of the last two coefficients: the bound on what the interpolant leaves out
SHORTEST = 2.0**-44  # of the interval searched: a function that is not resolved there jumps
MOST = 2000  # intervals examined; for a function that needs more, only the signs of its samples are used
TOGETHER = 1e-12  # of the interval searched: crossings no farther apart happen at once

Functions = Callable[[Array], Array]  # times (n,) -> values (n, m)

_NODES = -np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)  # rising, -1 to 1
_STEEPEST = np.arange(DEGREE + 1) ** 2  # the largest slopes of Chebyshev's polynomials on -1 to 1
_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(_NODES, DEGREE))


@dataclass(frozen=True, eq=False)
class Crossing:
    """The earliest crossing of several functions."""

    t: float
    which: int  # the function that crosses first
    fired: Mask  # (m,) those that cross then
    slope: float  # of the first, per s


def first_crossing_of(sample: Functions, bounds: Array, floor: Array) -> tuple[Crossing, int] | None:
    """As `first_crossing` in the intervals between bounds (k + 1,), one after another; also returns which it is in.

    All intervals are sampled at once; those that may hold a crossing are searched.
    """
    values = sample(_times(bounds[:-1], bounds[1:]).reshape(-1)).reshape(len(bounds) - 1, DEGREE + 1, -1)
    coefficients = np.einsum("ij,kjm->ikm", _COEFFICIENTS, values)
    for i in np.flatnonzero(_reaching(coefficients, floor).any(1)):
        if found := first_crossing(sample, float(bounds[i]), float(bounds[i + 1]), floor):
            return found, int(i)
    return None


def first_crossing(sample: Functions, begin: float, end: float, floor: Array) -> Crossing | None:
    """The earliest time at which one of m functions falls to 0 and then below -floor (m,).

    None if there is no such time between begin and end: then no function was below -floor, but for what its interpolant
    leaves out (`UNSEEN`). A function may start at 0 or below; it crosses where it next falls below -floor.
    """
    waiting, looks = [(begin, end)], 0
    while waiting:
        (a, b), looks = waiting.pop(), looks + 1
        values = sample(_times(a, b))
        coefficients = _COEFFICIENTS @ values
        reaching = np.flatnonzero(_reaching(coefficients, floor))
        if not len(reaching):
            continue
        jumps = b - a <= SHORTEST * (end - begin) or looks > MOST
        if not jumps and (_unseen(coefficients) > floor)[reaching].any():
            middle = (a + b) / 2
            waiting += [(middle, b), (a, middle)]
            continue
        found = [(_drop(values[:, k], floor[k]) if jumps else _root(coefficients[:, k], floor[k]), k) for k in reaching]
        place, which = min(((x, k) for x, k in found if x is not None), default=(None, 0))
        if place is not None:
            t = min(max(a + (place + 1) * (b - a) / 2, a), b)
            return _crossing(sample, t, int(which), TOGETHER * (end - begin), end)
    return None


def _unseen(coefficients: Array) -> Array:
    """What interpolants with coefficients (DEGREE + 1, ...) may leave out, (...)."""
    return UNSEEN * np.abs(coefficients[-2:]).max(0)


def _reaching(coefficients: Array, floor: Array) -> Mask:
    """Whether functions with coefficients (DEGREE + 1, ..., m) may fall below -floor (m,): (..., m)."""
    return coefficients[0] - np.abs(coefficients[1:]).sum(0) - _unseen(coefficients) < -floor


def _times(a: Array | float, b: Array | float) -> Array:
    """The Chebyshev points (..., DEGREE + 1) between a and b (...), both ends included."""
    a, b = np.asarray(a)[..., None], np.asarray(b)[..., None]
    return np.where(_NODES == 1, b, a + (_NODES + 1) * ((b - a) / 2))


def _root(coefficients: Array, floor: float) -> float | None:
    """Where a Chebyshev series (n,) on -1 to 1 comes down to 0 and goes on below -floor; None if it does not."""
    series = coefficients.tolist()
    places = _turning_points(coefficients)
    values = [_value(series, x) for x in places]
    last = next((i for i, value in enumerate(values) if value < -floor), None)
    if last is None:
        return None
    if last == 0 or values[last - 1] <= 0:
        return places[max(0, last - 1)]
    from scipy import optimize  # late: it takes 0.1 s

    bracket = places[last - 1 : last + 1]
    return optimize.root_scalar(lambda x: _value(series, x), bracket=bracket, xtol=4e-16, rtol=1e-15).root


def _value(series: list[float], x: float) -> float:
    """A Chebyshev series at x, by Clenshaw's recurrence: in floats, as one value takes numpy longer."""
    one = two = 0.0
    for c in reversed(series[1:]):
        one, two = c + 2 * x * one - two, one
    return series[0] + x * one - two


def _turning_points(coefficients: Array) -> list[float]:
    """-1, the zeros in between of the derivative of a Chebyshev series (k,), and 1; rising."""
    sizes = np.abs(coefficients)
    if sizes[1] > _STEEPEST[2:] @ sizes[2:]:  # the first term outweighs the slopes of all others: there is none
        return [-1.0, 1.0]
    slope = chebyshev.chebder(coefficients)
    slope = chebyshev.chebtrim(slope, 1e-15 * np.abs(slope).max())
    roots = chebyshev.chebroots(slope) if len(slope) > 1 else np.empty(0)
    inside = roots.real[(np.abs(roots.imag) < 1e-3) & (np.abs(roots.real) < 1)]
    return [-1.0, *np.sort(inside).tolist(), 1.0]


def _drop(values: Array, floor: float) -> float | None:
    """Where samples (n,) of a function that jumps are below -floor for the first time."""
    below = values < -floor
    return float(_NODES[np.argmax(below)]) if below.any() else None


def _crossing(sample: Functions, t: float, which: int, together: float, end: float) -> Crossing:
    """The crossing of one function at t, and the others that cross with it."""
    around = np.array([t - together, min(t + together, end)])
    before, after = sample(around)
    fired = (after < 0) & (after < before)
    fired[which] = True
    return Crossing(t, which, fired, float((after - before)[which] / (around[1] - around[0])))
