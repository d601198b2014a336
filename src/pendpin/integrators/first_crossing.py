"""The first zero crossing of functions of time, from their signs and turning points.

A function is sampled at Chebyshev points. The coefficients of its interpolant bound its least value; most intervals have
no crossing by this test. Otherwise the interval is halved until the last coefficients vanish; the turning points of the
interpolant then show whether it crosses zero, and where.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from pendpin.arrays import Array, Mask

DEGREE = 9  # of the interpolants: those of dop853 have degree 7, so that the last two coefficients vanish
UNSEEN = 4.0  # times the larger of the last two coefficients: the bound on what the interpolant leaves out
SHORTEST = 2.0**-44  # of the interval searched: a function that is not resolved there jumps
MOST = 2000  # intervals examined; for a function that needs more, only the signs of its samples are used
TOGETHER = 1e-12  # of the interval searched: crossings no farther apart happen at once
CLOSE = 1e-9  # a correction of a root so small is the last: the next by Newton's method would be its square

Functions = Callable[[Array], Array]  # times (n,) -> values (n, m)

_NODES = -np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)  # rising, -1 to 1
_STEEPEST = np.arange(DEGREE + 1) ** 2  # the largest slopes of Chebyshev's polynomials on -1 to 1
_VALUES = chebyshev.chebvander(_NODES, DEGREE)  # at the nodes, of each polynomial
_COEFFICIENTS = np.linalg.inv(_VALUES)
_SLOPE = chebyshev.chebder(np.eye(DEGREE + 1))  # of the coefficients, those of the derivative


@dataclass(frozen=True, eq=False)
class Crossing:
    """The earliest crossing of several functions."""

    t: float
    interval: int  # in which it is
    which: int  # the function that crosses first
    fired: Mask  # (m,) those that cross then
    slope: float  # of the first, per s; -inf if it jumps


def first_crossing(sample: Functions, bounds: Array, floor: Array) -> Crossing | None:
    """The earliest time at which one of m functions falls to 0 and then below -floor (m,).

    In the intervals between the rising times `bounds` (k + 1,): all are sampled at once, and those that may hold a
    crossing are searched. None if there is none: then no function was below -floor, but for what its interpolant leaves
    out (`UNSEEN`). A function may start at 0 or below; it crosses where it next falls below -floor.
    """
    series = _series(sample, bounds[:-1], bounds[1:])
    for i in np.flatnonzero(_reaching(series, floor)[0].any(1)):
        if found := _searched(sample, int(i), float(bounds[i]), float(bounds[i + 1]), series[i], floor):
            return found
    return None


def _searched(sample: Functions, i: int, begin: float, end: float, series: Array, floor: Array) -> Crossing | None:
    """The first crossing in interval i, from begin to end, with interpolants `series` (DEGREE + 1, m)."""
    waiting, looks = [(begin, end)], 0
    while waiting:
        (a, b), looks = waiting.pop(), looks + 1
        series = series if looks == 1 else _series(sample, np.array([a]), np.array([b]))[0]
        reaching, unseen = _reaching(series, floor)
        if not reaching.any():
            continue
        jumps = b - a <= SHORTEST * (end - begin) or looks > MOST
        if not jumps and (reaching & (unseen > floor)).any():
            middle = (a + b) / 2
            waiting += [(middle, b), (a, middle)]
            continue
        places, slopes = np.full((2, len(floor)), math.inf)
        for k in np.flatnonzero(reaching):
            places[k], slopes[k] = (_drop if jumps else _root)(series[:, k], float(floor[k]))
        which, scale = int(places.argmin()), 2 / (b - a)
        if (x := places[which]) < math.inf:
            fired = places <= x + scale * TOGETHER * (end - begin)
            return Crossing(float(min(max(a + (x + 1) / scale, a), b)), i, which, fired, float(slopes[which]) * scale)
    return None


def _series(sample: Functions, a: Array, b: Array) -> Array:
    """Coefficients (k, DEGREE + 1, m) of the interpolants from a (k,) to b (k,)."""
    times = a[:, None] + np.multiply.outer((b - a) / 2, _NODES + 1)
    times[:, -1] = b
    return _COEFFICIENTS @ sample(times.reshape(-1)).reshape(*times.shape, -1)


def _reaching(series: Array, floor: Array) -> tuple[Mask, Array]:
    """Whether functions with coefficients (..., DEGREE + 1, m) may fall below -floor (m,), and what these leave out.

    A function whose first term outweighs the slopes of all others has its least value at an end.
    """
    sizes = np.abs(series)
    unseen = UNSEEN * np.maximum(sizes[..., -1, :], sizes[..., -2, :])
    ends = series[..., ::2, :].sum(-2) - np.abs(series[..., 1::2, :].sum(-2))
    least = np.where(_slopes(sizes) > 0, ends, series[..., 0, :] - sizes[..., 1:, :].sum(-2))
    return least - unseen < -floor, unseen


def _slopes(sizes: Array) -> Array:
    """The slope of the first term less the largest of all others, from absolute coefficients (..., DEGREE + 1, m)."""
    return sizes[..., 1, :] - _STEEPEST[2:] @ sizes[..., 2:, :]


def _root(coefficients: Array, floor: float) -> tuple[float, float]:
    """Where a Chebyshev series on -1 to 1 comes down to 0 and goes on below -floor, and its slope; inf if nowhere."""
    series = coefficients.tolist()
    places = _turning_points(coefficients)
    values = [_value(series, x) for x in places]
    last = next((i for i, (value, _) in enumerate(values) if value < -floor), None)
    if last is None:
        return math.inf, 0.0
    before = max(0, last - 1)
    if last == before or values[before][0] <= 0:
        return places[before], values[before][1]
    return _zero(series, places[before], places[last])


def _zero(series: list[float], a: float, b: float) -> tuple[float, float]:
    """The zero of a Chebyshev series that falls from a to b, and its slope: by Newton's method, or halving."""
    x, last = (a + b) / 2, math.inf
    while True:
        value, slope = _value(series, x)
        a, b = (x, b) if value > 0 else (a, x)
        better = x - value / slope if slope < 0 else a
        if not (a <= better <= b and abs(better - x) < last / 2):
            better = (a + b) / 2
        x, last = better, abs(better - x)
        if last <= CLOSE:
            return x, slope


def _value(series: list[float], x: float) -> tuple[float, float]:
    """A Chebyshev series and its slope at x, by Clenshaw's recurrence: in floats, as one value takes numpy longer."""
    one = two = slope = before = 0.0
    for c in reversed(series[1:]):
        slope, before = 2 * (one + x * slope) - before, slope
        one, two = c + 2 * x * one - two, one
    return series[0] + x * one - two, one + x * slope - before


def _turning_points(coefficients: Array) -> list[float]:
    """-1, the zeros in between of the derivative of a Chebyshev series (k,), and 1; rising."""
    if _slopes(np.abs(coefficients)[:, None]) > 0:
        return [-1.0, 1.0]
    slope = _SLOPE @ coefficients
    slope = chebyshev.chebtrim(slope, 1e-15 * np.abs(slope).max())
    roots = chebyshev.chebroots(slope) if len(slope) > 1 else np.empty(0)
    inside = roots.real[(np.abs(roots.imag) < 1e-3) & (np.abs(roots.real) < 1)]
    return [-1.0, *np.sort(inside).tolist(), 1.0]


def _drop(coefficients: Array, floor: float) -> tuple[float, float]:
    """The first node at which a function that jumps is below -floor, and the slope there; inf if there is none."""
    below = _VALUES @ coefficients < -floor
    return (float(_NODES[np.argmax(below)]), -math.inf) if below.any() else (math.inf, 0.0)
