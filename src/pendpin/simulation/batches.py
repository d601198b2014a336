"""Starts of one scene side by side in the processor's vectors, as Taylor series with steps of their own, in threads."""

import math
import time
from collections.abc import Generator
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from queue import SimpleQueue
from threading import Event
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pendpin.arrays import Array, subdivided
from pendpin.engines import Engine
from pendpin.integrators.taylor import SERIES, Taylor

VECTORS = 2  # side by side: hides the time that an instruction takes (measured: 1.0 to 1.4 times as fast as one)
MOST_STATES = 200_000  # of a start
SAMPLES_AT_ONCE = 256  # between two chances to stop
STEPS_AT_ONCE = 65_536  # in so many samples, at most

Places = NDArray[np.intp]  # of starts


class Batch(NamedTuple):
    """The motions of a few starts; a start that did not get to its end has NaN behind its first sample."""

    places: Places  # (c,)
    q: Array  # (c, n, nv)
    v: Array
    steps: int
    seconds: float


def side_by_side(
    integrator: Taylor, engine: Engine, times: Array, q: Array, v: Array, workers: int, longest: float = np.inf
) -> Generator[Batch, None, None]:
    """The motions from q, v (k, nv), batch by batch, in order. `integrator.compile_seconds` is set before.

    A batch ends with the first of its starts that fails, or that needs too many steps. No step is longer than a series
    may take where an effect changes within `longest` s. Close the iterator to stop.
    """
    import heyoka

    begin, width = time.perf_counter(), VECTORS * heyoka.recommended_simd_size()
    series, spare, stopped = integrator.compiled(engine, width), SimpleQueue[Any](), Event()
    integrator.compile_seconds = time.perf_counter() - begin
    for _ in range(workers):
        spare.put(copy(series))

    def run(places: Places) -> Batch:
        own, begin = spare.get(), time.perf_counter()
        found, steps = _motions(own, engine, times, q[places], v[places], longest, stopped)
        spare.put(own)
        return Batch(places, *found, steps, time.perf_counter() - begin)

    pool = ThreadPoolExecutor(workers)
    try:
        pieces = np.split(np.arange(len(q)), range(width, len(q), width))
        running = [pool.submit(run, places) for places in pieces]
        while running:
            yield running.pop(0).result()
    finally:
        stopped.set()
        pool.shutdown(cancel_futures=True)


def _motions(
    series: Any, engine: Engine, times: Array, q: Array, v: Array, longest: float, stopped: Event
) -> tuple[tuple[Array, Array], int]:
    """Positions and rates (c, n, nv) from q, v (c, nv), and the steps of all."""
    y = np.array([engine.pack(*start) for start in zip(q, v, strict=True)]).T
    filled = y[:, np.resize(np.arange(len(q)), series.state.shape[1])]  # up to the width, with copies
    states, steps, parts = _close_enough(series, engine, filled, times, longest, stopped)
    fine = subdivided(times, parts)
    rows = np.full((2, len(q), len(times), q.shape[1]), np.nan)
    rows[:, :, 0] = q, v
    for i, near in enumerate(q):
        found = np.ascontiguousarray(states[:, :, i])
        if np.isfinite(found).all():
            rows[:, i, 1:] = [x[::parts][1:] for x in engine.unpack(fine, found, near)]
    return (rows[0], rows[1]), int(steps[: len(q)].sum())


def _close_enough(
    series: Any, engine: Engine, y: Array, times: Array, longest: float, stopped: Event
) -> tuple[Array, Places, int]:
    """As `_along`, with so many states in each interval of the times that angles can be read from them.

    What would need too many is left NaN.
    """
    parts = 1
    while True:
        fine = subdivided(times, parts)
        states, steps = _along(series, y, fine, longest, stopped)
        ended = [i for i in range(y.shape[1]) if np.isfinite(states[-1, :, i]).all()]
        needed = max((engine.denser(fine, states[:, :, i], int(steps[i])) for i in ended), default=0.0)
        if needed <= 1:
            return states, steps, parts
        if math.ceil(parts * needed) * len(times) > MOST_STATES:
            states[1:] = np.nan
            return states, steps, parts
        parts = math.ceil(parts * needed)


def _along(series: Any, y: Array, times: Array, longest: float, stopped: Event) -> tuple[Array, Places]:
    """States (n, size, width) at the times from y (size, width), and their steps (width,); NaN from where one fails."""
    width = y.shape[1]
    states, steps = np.full((len(times), *y.shape), np.nan), np.zeros(width, dtype=np.intp)
    states[0], series.state[:] = y, y
    series.set_time(times[0])
    for first in range(0, len(times) - 1, SAMPLES_AT_ONCE):
        grid = np.repeat(times[first : first + SAMPLES_AT_ONCE + 1, None], width, axis=1)
        grid[0] = series.time
        _, found = series.propagate_grid(grid, max_steps=STEPS_AT_ONCE, max_delta_t=[SERIES * longest] * width)
        outcomes, _, _, taken = zip(*series.propagate_res, strict=True)
        steps += taken
        if stopped.is_set() or any(outcome != outcome.time_limit for outcome in outcomes):
            break
        states[first + 1 : first + len(grid)] = found[1:]
    return states, steps
