"""Integration with events: an adaptive method of SciPy, watched between its steps."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import integrate, optimize

from pendpin.arrays import Array, Mask
from pendpin.engines import Derivative
from pendpin.integrators.adaptive import LEAST_RTOL, NOT_FINITE, returning

LOOKS = 8  # places inside a step at which the margins are looked at
AT_ONCE = 1e-13  # s, or of the time: events no farther apart happen together

Margins = Callable[[float, Array], Array]  # t, y -> what is above 0 until an event


@dataclass(frozen=True, eq=False)
class SegmentToEvent:
    """A segment of motion up to an event or to its end."""

    t: float
    y: Array  # the state there
    samples: Array  # (n, size), the states at the output times on the way
    steps: int
    fired: Mask | None = None  # which margins came down to 0; None if none did
    failure: str | None = None


def integrate_to_event(
    derivative: Derivative, margins: Margins, t: float, y: Array, times: Array, method: str, tolerance: float
) -> SegmentToEvent:
    """Integrate from t to times[-1] or to the first event; samples at those of `times` (after t) that are reached.

    An event is where a margin comes down to 0. The state there is integrated anew up to the event, so that it has the
    accuracy of a step, not of the interpolation that found it.
    """
    make = _solver(derivative, method, tolerance)
    solver, samples, steps, before = make(t, y, times[-1]), np.empty((0, len(y))), 0, margins(t, y)
    while solver.status == "running":
        start, begin = solver.t, solver.y.copy()
        try:
            failure = solver.step()
        except FloatingPointError:
            failure = NOT_FINITE
        if failure:
            return SegmentToEvent(start, begin, samples, steps, None, failure)
        steps += 1
        inside = solver.dense_output()
        event, fired, before = _first_event(margins, inside, start, solver.t, before)
        due = times[len(samples) : np.searchsorted(times, event, "right")]
        samples = np.concatenate([samples, inside(due).T])
        if fired is not None:
            return SegmentToEvent(event, _state_at(make, start, begin, event), samples, steps, fired)
    return SegmentToEvent(float(times[-1]), solver.y, samples, steps)


def _solver(derivative: Derivative, method: str, tolerance: float) -> Callable[[float, Array, float], Any]:
    kind, function = getattr(integrate, method), returning(derivative)
    return lambda t, y, end: kind(function, t, y, end, rtol=max(tolerance, LEAST_RTOL), atol=tolerance)


def _first_event(
    margins: Margins, inside: Any, start: float, end: float, before: Array
) -> tuple[float, Mask | None, Array]:
    """The time of the first event in a step and which margins fired, else the end and None; and the margins there."""
    last = start
    for t in np.linspace(start, end, LOOKS + 1)[1:]:
        now = margins(t, inside(t))
        below = now < 0
        if below.any():
            at = np.full(len(now), np.inf)
            at[below] = [_crossing(margins, inside, last, t, int(i)) for i in np.flatnonzero(below)]
            return float(at.min()), at <= at.min() + AT_ONCE * max(1.0, abs(t)), before
        last, before = t, now
    return end, None, before


def _crossing(margins: Margins, inside: Any, start: float, end: float, which: int) -> float:
    def margin(t: float) -> float:
        return float(np.clip(margins(t, inside(t))[which], -1e300, 1e300))

    if margin(start) <= 0:  # it never rose: the event is at the start
        return start
    return optimize.root_scalar(margin, bracket=(start, end), xtol=1e-15 + 4e-16 * abs(end), rtol=1e-15).root


def _state_at(make: Callable[[float, Array, float], Any], start: float, y: Array, end: float) -> Array:
    if end <= start:
        return y
    solver = make(start, y, end)
    while solver.status == "running":
        solver.step()
    return solver.y
