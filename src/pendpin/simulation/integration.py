"""Integration from the start of a run to its end, or to where it stops.

A segment that fails or halts loses what it has integrated. It is integrated again from its start, in parts that end ever
closer to the place where it stopped: errors name that place.
"""

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import numpy as np

from pendpin.arrays import Array
from pendpin.errors import Halted, Interrupted, PendpinError, RunError
from pendpin.integrators import Run, Stop
from pendpin.simulation.checkpoint import RunState, Saver
from pendpin.simulation.limits import SamplesTooFew, Stalled
from pendpin.simulation.loop import IntegrationLoop

LEVELS, PARTS = 6, 16  # the place of a stop is then known to a 10,000,000th of the time between two samples


def integrate_to_end(
    loop: IntegrationLoop, q: Array, v: Array, saver: Saver, between: Callable[[RunState], RunState] | None = None
) -> Run:
    """Integrate from q, v (nv,), or from the saved state, to the end. A failed or halted run keeps what was integrated.

    `between` changes the state between two segments.
    """
    done, error = saver.resume(loop.begin(q, v)), None

    def clock() -> float:
        return time.perf_counter() - loop.engine.compile_seconds  # which is counted apart

    before, begin = done.seconds, clock()

    def timed(state: RunState) -> RunState:
        return replace(state, seconds=before + clock() - begin)

    while error is None and not done.complete:
        try:
            done, failure = loop.go_on(between(done) if between else done)
            error = RunError(failure) if failure else None
            if error is None and saver.due:
                saver.save(timed(done))
        except KeyboardInterrupt:
            error = Interrupted("stopped by the user")
        except np.linalg.LinAlgError as fault:
            error = RunError(f"{fault}; give the rod a radius, or remove the torque about theta")
        except RunError as fault:
            error = fault
    done = timed(done)
    if error is None or isinstance(error, Halted):
        with suppress(Halted):  # the previous save remains
            saver.save(done)
    stop = None
    if error is not None and (isinstance(error, Stalled) or not isinstance(error, Halted)) and between is None:
        done, stop = _locate_stop(loop, done, error)
    return replace(loop.outcome(done, error), stop=stop)


def _locate_stop(loop: IntegrationLoop, done: RunState, error: RunError) -> tuple[RunState, Stop | None]:
    """The run with the samples that its last segment has lost, and the last state before it stopped, where there is one.

    The error is that of the segment. A method with a fixed step has a sample there. Too few samples stop nothing: nearer
    ones would pass.
    """
    times = loop.times
    try:
        if isinstance(error, Stalled):
            return _recover(loop, done, error.t)
        if loop.integrator.step is not None or done.complete or isinstance(error, SamplesTooFew):
            return done, None
        return done, _approach(loop, done)
    finally:
        loop.times = times


def _recover(loop: IntegrationLoop, done: RunState, t: float) -> tuple[RunState, Stop | None]:
    """The run up to a time in s at which it still advanced."""
    if t <= done.carried["t"]:
        return done, None
    loop.times = np.append(loop.times[loop.times < t], t)
    again = _integrate(loop, done, len(loop.times))
    if again.n < len(loop.times):
        return again, None
    return again.cut(again.n - 1), _state_of(loop, again)


def _approach(loop: IntegrationLoop, done: RunState) -> Stop | None:
    """The last state before the place, between the last sample and the next, at which the integration fails."""
    end, state, stop = loop.times[done.n], done, None
    for _ in range(LEVELS):
        loop.times = np.linspace(float(state.carried["t"]), end, PARTS + 1)
        state = _integrate(loop, RunState.at_start(state.samples[-1], PARTS + 1, state.carried), PARTS + 1)
        if state.n > 1:
            stop = _state_of(loop, state)
        if state.complete:
            break
        end = loop.times[state.n]
    return stop


def _integrate(loop: IntegrationLoop, state: RunState, count: int) -> RunState:
    """The state with up to `count` samples, as far as they can be integrated."""
    failure = None
    while state.n < count and failure is None:
        try:
            state, failure = loop.go_on(state)
        except (PendpinError, np.linalg.LinAlgError):
            break
    return state


def _state_of(loop: IntegrationLoop, state: RunState) -> Stop:
    q, v = np.split(state.samples[-1][: 2 * loop.nv], 2)
    return Stop(float(loop.times[state.n - 1]), q, v)
