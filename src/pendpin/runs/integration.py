"""A run is integrated segment by segment, from its start to its end or to where it stops; it can be saved after each.

A segment that fails or halts loses what it has integrated. It is integrated again from its start, in parts that end ever
closer to the place where it stopped: errors name that place.
"""

import time
from abc import ABC, abstractmethod
from contextlib import suppress
from dataclasses import replace

import numpy as np

from pendpin.effects.pace import Pace
from pendpin.engines import ProgressCallback
from pendpin.errors import Halted, Interrupted, PendpinError, RunError
from pendpin.ground.arrays import Array
from pendpin.integrators import Run, Stop, integrator_for
from pendpin.runs.checkpoint import Saver
from pendpin.runs.limits import SamplesTooFew, Stalled
from pendpin.runs.preparation import Prepared
from pendpin.runs.state import EventState, RunState, Shifts, SmoothState

LEVELS, PARTS = 6, 16  # the place of a stop is then known to a 10,000,000th of the time between two samples


class IntegrationLoop(ABC):
    """The integration of a scene over its output times; `library` and `version` name the integrating program."""

    library: str
    version: str
    first_segment = 1  # output times of it, as long as nothing is known of what they cost

    def __init__(self, prepared: Prepared, pace: Pace, progress: ProgressCallback) -> None:
        self.dynamics, self.balance = prepared.dynamics, prepared.balance
        self.times, self.pace, self.progress = prepared.scene.times, pace, progress
        self.integrator = integrator_for(prepared.scene, self.dynamics)
        self.engine = self.balance.engine if self.balance else self.dynamics.engine  # that is integrated
        self.held = self.dynamics.sampled_torques
        for sampled in self.held:
            sampled.begin(self.dynamics.start, float(self.times[-1]))
        self.nv, self.accounts = len(self.dynamics.model.joints), len(self.balance.kinds) if self.balance else 0

    @abstractmethod
    def begin(self, q: Array, v: Array) -> RunState:
        """The first sample, at q, v (nv,). Raises InputError for a start that cannot be integrated."""

    @abstractmethod
    def go_on(self, done: RunState) -> tuple[RunState, str | None]:
        """The state one segment later, and why the run has to end there, or None. The result depends on `done` only.

        Raises RunError or LinAlgError if the segment cannot be integrated.
        """

    def sampled_at(self, t: float) -> bool:
        """Whether t in s is an instant of a sampled torque."""
        return any(sampled.is_instant(t) for sampled in self.held)

    def sample(self, t: float, y: Array) -> bool:
        """Evaluate the sampled torques whose instant t in s is; whether there are any. y begins with q, v (2 nv,)."""
        due = [sampled for sampled in self.held if sampled.is_instant(t)]
        for sampled in due:
            sampled.sample(t, y[: self.nv], y[self.nv : 2 * self.nv])
        return bool(due)

    @property
    def records(self) -> tuple[Array, ...]:
        """The outputs of the sampled torques, for the state of a run: all states share them."""
        return tuple(sampled.record for sampled in self.held)

    def recall(self, last: SmoothState | EventState) -> None:
        """Go on with what the sampled torques held in a state of the run."""
        for sampled, record in zip(self.held, last.held, strict=True):
            sampled.recall(last.t, record)

    def shifted(self, done: RunState, shifts: Shifts, largest: dict[str, Array]) -> RunState:
        """The state, shifted unless it is the first one; `largest` holds the largest numbers so far. Not with events."""
        return done

    def outcome(self, done: RunState, error: RunError | None) -> Run:
        """The run as far as it was integrated, and why it ended early, if it did."""
        for sampled in self.held:
            sampled.finish()
        rows, nv, end = done.samples, self.nv, 2 * self.nv + self.accounts
        torque = rows[:, end:].copy() if rows.shape[1] > end else None
        arrays = (
            self.times[: done.n],
            rows[:, :nv].copy(),
            rows[:, nv : 2 * nv].copy(),
            torque,
            rows[:, 2 * nv : end].copy(),
        )
        compiling = self.integrator.compile_seconds + self.engine.compile_seconds
        self.engine.compile_seconds = 0.0  # the next run on this engine compiles nothing
        counts = (done.steps, done.evaluations, done.events, done.seconds)
        run = Run(*arrays, *counts, self.library, self.version, compiling)
        return replace(run, failure=error, happened=tuple(done.log[: done.logged]))


def integrate_to_end(
    loop: IntegrationLoop, q: Array, v: Array, saver: Saver | None, shifts: Shifts | None = None
) -> Run:
    """Integrate from q, v (nv,), or from the saved state, to the end. A failed or halted run keeps what was integrated."""
    done, error, largest = loop.begin(q, v), None, dict[str, Array]()
    if saver:
        done = saver.resume(done)

    def clock() -> float:
        return time.thread_time() - loop.engine.compile_seconds  # which is counted apart

    before, begin = done.seconds, clock()

    def timed(state: RunState) -> RunState:
        return replace(state, seconds=before + clock() - begin)

    while error is None and not done.complete:
        try:
            done, failure = loop.go_on(loop.shifted(done, shifts, largest) if shifts else done)
            error = RunError(failure) if failure else None
            if error is None and saver and saver.due:
                saver.save(timed(done))
        except KeyboardInterrupt:
            error = Interrupted("stopped by the user")
        except np.linalg.LinAlgError as fault:
            error = RunError(f"{fault}; give the rod a radius, or remove the torque about theta")
        except RunError as fault:
            error = fault
    done = timed(done)
    if saver and (error is None or isinstance(error, Halted)):
        with suppress(Halted):  # the previous save remains
            saver.save(done)
    stop = None
    if error is not None and (isinstance(error, Stalled) or not isinstance(error, Halted)) and shifts is None:
        done, stop = _locate_stop(loop, done, error)
    return replace(loop.outcome(done, error), stop=stop)


def _locate_stop(loop: IntegrationLoop, done: RunState, error: RunError) -> tuple[RunState, Stop | None]:
    """The run with the samples that its last segment has lost, and the last state before it stopped, where there is sampled.

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
    if t <= done.last.t:
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
        loop.times = np.linspace(state.last.t, end, PARTS + 1)
        state = _integrate(loop, RunState.at_start(state.samples[-1], PARTS + 1, state.last), PARTS + 1)
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
