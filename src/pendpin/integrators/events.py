"""Integration up to events: the steps of an adaptive method are searched for the first zero crossing of guards.

A guard is sampled at Chebyshev points. The coefficients of its interpolant bound its least value; most steps have no
crossing by this test. Otherwise the interval is halved until the last coefficients vanish; the turning points of the
interpolant then show whether it crosses zero, and where.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from pendpin.ground.arrays import Array
from pendpin.integrators.base import ROUNDING, SHORTEST

REFINEMENTS = 4  # of the time of an event, with the state integrated anew
NEAR = 1e-7  # of a step: a correction of the time so small is made without integrating anew
INSTANT = 1e-12  # of a step: times no farther from an event happen with it
LOOKS, SHORTER = 2, 16.0  # steps, and times as short each, that also have to show an event at the start of a segment

Guards = Callable[[Array, Array], Array]  # t (n,), y (n, size) -> (n, m), what an event brings down to 0


class SegmentToEvent(NamedTuple):
    """A segment of motion up to an event or to its end."""

    t: float
    y: Array  # the state there
    samples: Array  # (n, size), the states at the output times on the way
    steps: int
    fired: list[int] | None = None  # which guards came down to 0; None if none did
    failure: str | None = None


class Steps(NamedTuple):
    """Some steps, one after another, with their interpolation; k may be 0 where a failure comes at once."""

    bounds: Array  # (k + 1,) s, where the steps begin and end
    states: Array  # (k + 1, size) there
    inside: Callable[[Array], Array]  # t (n,) -> (n, size)
    failure: str | None = None  # of the step after these


class Stepper(ABC):
    """A method with its setting on the equations of one mode."""

    @abstractmethod
    def steps(self, t: float, y: Array, end: float) -> Iterator[Steps]:
        """The steps from y (size,) at t to `end`, s."""

    def state_at(self, t: float, y: Array, end: float) -> Array:
        """The state (size,) at `end`, from y at t, as accurate as a step and not as its interpolation."""
        for part in self.steps(t, y, end) if end > t else ():
            y = part.states[-1]
        return y


@dataclass(frozen=True)
class AtRest(Stepper):
    """The steps of a state that does not change, no longer than `longest` in s."""

    longest: float

    def steps(self, t: float, y: Array, end: float) -> Iterator[Steps]:
        bounds = np.linspace(t, end, max(1, int(np.ceil((end - t) / self.longest))) + 1)
        yield Steps(bounds, np.tile(y, (len(bounds), 1)), lambda s: np.tile(y, (len(s), 1)))


def integrate_to_event(
    stepper: Stepper, guards: Guards, floor: Array, t: float, y: Array, end: float, times: Array, looks: int = LOOKS
) -> SegmentToEvent:
    """Integrate from t to `end` or to the first event; samples at those of `times` (n,), after t, that are reached.

    An event is a time at which a guard falls to 0 and then below -floor (m,). The state is integrated again up to the
    event and the time is corrected with it: both have the accuracy of a step. An output time at the event belongs to the
    next segment: its sample is the state after the event. A segment ends early, without one, if only the interpolation of a
    long first step showed one at its start.
    """
    samples, taken, begin, start = np.empty((0, len(y))), 0, t, y
    for part in stepper.steps(t, y, end):
        event = None
        if len(floor) and len(part.bounds) > 1:
            event = first_crossing(lambda t, part=part: guards(t, part.inside(t)), part.bounds, floor)
        first = float(part.bounds[1] - begin) if event and looks else 0.0
        if event and SHORTER * instant(begin, 0.0) < first and event.t <= begin + instant(begin, first):
            # A joint that leaves its stop with the third power of time moves less at first than radau's interpolation errs.
            return integrate_to_event(stepper, guards, floor, begin, start, begin + first / SHORTER, times, looks - 1)
        count = event.place + 1 if event else len(part.bounds) - 1
        t = before = float(part.bounds[count])
        y, taken = part.states[count], taken + count
        if event:
            t, y = _locate(stepper, guards, part, event)
            before = t - instant(t, float(part.bounds[count] - part.bounds[count - 1]))
        due = times[len(samples) : times.searchsorted(before, "left" if event else "right")]
        if len(due):
            states, place = part.inside(due), part.bounds.searchsorted(due)
            exact = part.bounds[place] == due  # where steps begin and end, the states are those of the method itself
            states[exact] = part.states[place[exact]]
            samples = np.concatenate([samples, states])
        if event:
            return SegmentToEvent(t, y, samples, taken, event.fired)
        if part.failure:
            return SegmentToEvent(t, y, samples, taken, None, part.failure)
    return SegmentToEvent(end, y, samples, taken)


def instant(t: float, length: float) -> float:
    """How far from an event at t, found in a step of a length, times count as its instant, s."""
    return max(INSTANT * length, ROUNDING * math.ulp(t), SHORTEST)


def _locate(stepper: Stepper, guards: Guards, part: Steps, event: "Crossing") -> tuple[float, Array]:
    """The time of an event in some steps and the state (size,) there, by Newton's method and new integrations."""
    # The last correction is so small that the change of the interpolation serves.
    (begin, end), start, t = part.bounds[event.place :][:2].tolist(), part.states[event.place], event.t
    y = stepper.state_at(begin, start, t)
    for _ in range(REFINEMENTS):
        off = guards(np.array([t]), y[None])[0, event.which]
        better = min(max(t - off / event.slope if event.slope < 0 else t, begin), end)
        if abs(better - t) <= NEAR * (end - begin):
            return better, y + np.subtract(*part.inside(np.array([better, t])))
        if abs(better - t) >= (end - begin) / 2:
            break
        t, y = better, stepper.state_at(begin, start, better)
    return t, y


# --- the first zero crossing of functions of time, from their signs and turning points ------------------------------

DEGREE = 9  # of the interpolants: those of dop853 have degree 7, so that the last two coefficients vanish
UNSEEN = 4.0  # times the larger of the last two coefficients: the bound on what the interpolant leaves out
SHORTEST_SHARE = 2.0**-44  # of the interval searched: a function that is not resolved there jumps
ROUNDING_SHARE = 2.0**-48  # of a function's size in an interval: a value less than this below 0 is rounding
MOST = 2000  # parts of an interval examined; for a function that needs more, only the signs of its samples are used
TOGETHER = 1e-12  # of the interval searched: crossings no farther apart happen at once
CLOSE = 1e-9  # a correction of a root so small is the last: the next by Newton's method would be its square
CLOSEST = 2.0**-52  # and by halving, this

Functions = Callable[[Array], Array]  # times (n,) -> values (n, m)

_NODES = -np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)  # rising, -1 to 1
SHARES = (_NODES + 1) / 2  # of an interval
STEEPEST = np.arange(DEGREE + 1) ** 2.0  # the largest slopes of Chebyshev's polynomials on -1 to 1
_SUMS = np.stack([np.ones(DEGREE + 1), np.where(STEEPEST > 1, STEEPEST, 0.0)])
_VALUES = chebyshev.chebvander(_NODES, DEGREE)  # at the nodes, of each polynomial
COEFFICIENTS = np.linalg.inv(_VALUES)
_SLOPE = chebyshev.chebder(np.eye(DEGREE + 1))  # of the coefficients, those of the derivative


class Crossing(NamedTuple):
    """The earliest crossing of several functions."""

    t: float
    place: int  # of the interval in which it is
    which: int  # the function that crosses first
    fired: list[int]  # those that cross then
    slope: float  # of the first, per s; -inf if it jumps


class _Interval(NamedTuple):
    """A part of the times searched in which a function may fall below its floor."""

    place: int  # of the interval of the caller that it belongs to
    begin: float
    end: float
    series: Array  # (DEGREE + 1, m), the interpolants
    floor: Array  # (m,)
    reaching: list[int]  # the functions that may
    resolved: bool  # whether the interpolants of these leave out less than the floor


def first_crossing(sample: Functions, bounds: Array, floor: Array) -> Crossing | None:
    """The earliest time between rising `bounds` (k + 1,) at which one of m functions falls to 0 and then below -floor."""
    # All intervals are sampled at once, and those that may hold a crossing are searched. None if there is none: then no
    # function was below -floor (m,), but for what its interpolant leaves out (`UNSEEN`). A function may start at 0 or
    # below; it crosses where it next falls below -floor.
    waiting, looks = _intervals(sample, bounds, floor), dict[int, int]()
    while waiting:
        part = waiting.pop()
        looks[part.place] = looks.get(part.place, 0) + 1
        a, b, whole = part.begin, part.end, float(bounds[part.place + 1] - bounds[part.place])
        jumps = b - a <= SHORTEST_SHARE * whole or looks[part.place] > MOST
        if not (part.resolved or jumps):
            waiting += _intervals(sample, np.array([a, (a + b) / 2, b]), floor, part.place)
            continue
        seek, scale, floors = _drop if jumps else _root, 2 / (b - a), part.floor.tolist()
        roots = {k: seek(part.series[:, k], floors[k]) for k in part.reaching}
        which = min(roots, key=lambda k: roots[k][0])
        x, slope = roots[which]
        if x < math.inf:
            fired = [k for k, (place, _) in roots.items() if place <= x + scale * (TOGETHER * whole)]
            return Crossing(min(max(a + (x + 1) / scale, a), b), part.place, which, fired, slope * scale)
    return None


def _intervals(sample: Functions, bounds: Array, floor: Array, place: int | None = None) -> list[_Interval]:
    """Those of the k intervals between bounds (k + 1,) that have to be searched for floor (m,), the last one first."""
    # A function whose first term outweighs the slopes of all others has its least value at an end.
    begin, end = bounds[:-1, None], bounds[1:, None]
    times = begin + (end - begin) * SHARES
    times[:, -1:] = end
    values = sample(times.reshape(-1)).reshape(*times.shape, -1)
    series = COEFFICIENTS @ values
    sizes = np.abs(series)
    unseen = UNSEEN * np.maximum(sizes[:, -1], sizes[:, -2])
    whole, curved = (_SUMS @ sizes).swapaxes(0, 1)
    inside = series[:, 0] + sizes[:, 0] - whole
    least = np.where(sizes[:, 1] > curved, np.minimum(values[:, 0], values[:, -1]), inside)
    change = sizes[:, 1] + 4 * sizes[:, 2]  # of the function, where time changes by half an interval
    rounded = 2 * np.spacing(np.abs(end)) / np.maximum(end - begin, SHORTEST)  # of steps of no length
    floors = np.maximum(floor, np.maximum(ROUNDING_SHARE * whole, rounded * change))
    reaching, intervals = least < unseen - floors, list[_Interval]()
    for i in np.flatnonzero(np.any(reaching, 1))[::-1].tolist():
        which = reaching[i].nonzero()[0].tolist()
        resolved = all(unseen[i, k] <= floors[i, k] for k in which)
        ends = float(bounds[i]), float(bounds[i + 1])
        intervals.append(_Interval(i if place is None else place, *ends, series[i], floors[i], which, resolved))
    return intervals


def _root(coefficients: Array, floor: float) -> tuple[float, float]:
    """Where a Chebyshev series (k,) on -1 to 1 falls through 0 and goes on below -floor, and its slope; inf if nowhere."""
    series = coefficients.tolist()
    places = turning_points(coefficients)
    values = [_value(series, x) for x in places]
    last = next((i for i, (value, _) in enumerate(values) if value < -floor), None)
    if last is None:
        return math.inf, 0.0
    before = max(0, last - 1)
    if last == before or values[before][0] <= 0:
        return places[before], values[before][1]
    a, b = places[before], places[last]  # it falls from a to b: by Newton's method, or halving
    x, far = (a + b) / 2, math.inf
    while True:
        value, slope = _value(series, x)
        a, b = (x, b) if value > 0 else (a, x)
        newton = min(max(x - value / slope, a), b) if slope < 0 else a  # a zero at an end is rounded to either side
        converges = abs(newton - x) < far / 2
        better = newton if converges else (a + b) / 2
        x, far = better, abs(better - x)
        if far <= (CLOSE if converges else CLOSEST):
            return x, slope


def _value(series: list[float], x: float) -> tuple[float, float]:
    """A Chebyshev series and its slope at x, by Clenshaw's recurrence: in floats, as one value takes numpy longer."""
    one = two = slope = before = 0.0
    for c in reversed(series[1:]):
        slope, before = 2 * (one + x * slope) - before, slope
        one, two = c + 2 * x * one - two, one
    return series[0] + x * one - two, one + x * slope - before


def turning_points(coefficients: Array) -> list[float]:
    """-1, the zeros in between of the derivative of a Chebyshev series (k,), and 1; rising."""
    slope = _SLOPE @ coefficients
    sizes = np.abs(slope)
    if 2 * sizes[0] >= sizes.sum():  # there is none
        return [-1.0, 1.0]
    roots = chebyshev.chebroots(slope[: np.flatnonzero(sizes > 1e-15 * sizes.max())[-1] + 1])
    inside = roots.real[(np.abs(roots.imag) < 1e-3) & (np.abs(roots.real) < 1)]
    return [-1.0, *np.sort(inside).tolist(), 1.0]


def _drop(coefficients: Array, floor: float) -> tuple[float, float]:
    """The first node where a function that jumps, a series (k,), is below -floor, and the slope; inf if there is none."""
    below = _VALUES @ coefficients < -floor
    return (float(_NODES[np.argmax(below)]), -math.inf) if below.any() else (math.inf, 0.0)
