"""The Taylor integrator on many states at once, in the processor's vectors: its way along output times, and its guards."""

from threading import Event
from typing import Any

import numpy as np

from pendpin.arrays import Array

SAMPLES_AT_ONCE = 256  # between two chances to stop
STEPS_AT_ONCE = 65_536  # in so many samples, at most


class Passage:
    """Notes the first time at which a guard passes 0 in each place of the vector; copied with the series it belongs to."""

    def __init__(self, width: int) -> None:
        self.first = np.full(width, np.nan)

    def __call__(self, series: Any, t: float, direction: int, place: int) -> None:
        self.first[place] = np.fmin(self.first[place], t)


def along(series: Any, y: Array, times: Array, longest: Array, stopped: Event) -> tuple[Array, Array]:
    """States (width, n, size) at the times, and steps (width,), of `longest` (width,) s at most; NaN where one fails."""
    states, steps = np.full((len(times), *y.T.shape), np.nan), np.zeros(len(y))
    states[0] = series.state[:] = y.T
    series.set_time(times[0])
    for passage in passages(series):
        passage.first[:] = np.nan
    limits = {"max_steps": STEPS_AT_ONCE, "max_delta_t": longest}
    for first in range(0, len(times) - 1, SAMPLES_AT_ONCE):
        ahead = times[first + 1 : first + SAMPLES_AT_ONCE + 1]
        if len(times) == 2:  # nothing is to be read between two steps
            series.propagate_until(ahead[0], **limits)
            found = series.state[None]
        else:
            grid = np.concatenate([series.time[None], np.repeat(ahead[:, None], len(y), axis=1)])
            found = series.propagate_grid(grid, **limits)[1][1:]
        outcomes, _, _, taken = zip(*series.propagate_res, strict=True)
        steps += taken
        if stopped.is_set() or any(outcome != outcome.time_limit for outcome in outcomes):
            break
        states[first + 1 : first + 1 + len(ahead)] = found
    return states.transpose(2, 0, 1), steps


def passages(series: Any) -> list[Passage]:
    """What notes the passages of its guards."""
    return [event.callback for event in series.nt_events] if series.with_events else []
