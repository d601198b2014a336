"""A run is integrated segment by segment, from its start to its end or to where it stops; it can be saved after each.

Without contacts a segment is a number of output times (`SmoothLoop`); with them it ends at events (motion_with_events.py).
A segment that fails or halts loses what it has integrated. It is integrated again from its start, in parts that end ever
closer to the place where it stopped: errors name that place.
"""

import time
from abc import ABC, abstractmethod
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from pendpin.effects.pace import Pace
from pendpin.engines import Derivative, ProgressCallback
from pendpin.errors import Halted, InputError, Interrupted, PendpinError, RunError
from pendpin.ground.arrays import EPS, Array, Indices, subdivided
from pendpin.integrators import Memory, Run, Segment, StepPlan, Stop, integrator_for
from pendpin.integrators.base import SHORTEST
from pendpin.integrators.fixed import count_equal_steps
from pendpin.runs.checkpoint import Checkpoint, EventState, RunState, Shifts, SmoothState
from pendpin.runs.limits import SamplesTooFew, Stalled
from pendpin.runs.preparation import Prepared

LEVELS, PARTS = 6, 16  # the place of a stop is then known to a 10,000,000th of the time between two samples
EVALUATIONS = 20_000  # in a segment, about: an interrupt loses at most these
LEAST_EVALUATIONS = 2_000  # of a large model, whose evaluations take longer
SMALL = 2  # joints: those of a model with EVALUATIONS in a segment
FIRST_STEPS = 2  # that it takes at least, the first of them a small one
FIRST_CHANGE = 0.2  # rad, or rad/s, from state to state at the start, before it is measured how fast rods turn
GROWTH = 256  # of the output times of a segment, where the states that it needs are not known
MARGIN = 1.25  # of the density of states in the next segment, over that which this one needed
NUMBERS = 100_000  # in the states of a segment: a processor's fast memory holds what is computed while angles are read
MOST_STATES = 1e9  # between two output times, from which turns are counted; a hundred thousand swings take 1e6
MOST_PARTS = 1e12  # of an interval: a segment ends before there are as many
BESIDE = 4 * EPS  # of the time: so far from a corner its side is certain in spite of rounding


class IntegrationLoop(ABC):
    """The integration of a scene over its output times; `library` and `version` name the integrating program."""

    library: str
    version: str
    first_segment = 1  # output times of it, as long as nothing is known of what they cost
    shifts: Shifts | None = None  # of the state during the motion; not with events

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
        """The state one segment later, by `done` alone, and why the run has to end there, or None. RunError, LinAlgError."""

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

    def finish(self, done: RunState, error: RunError | None, stop: Stop | None) -> Run:
        """The run as far as it was integrated, and why and where it ended early, if it did."""
        for sampled in self.held:
            sampled.finish()
        nv, end, rows = self.nv, 2 * self.nv + self.accounts, done.room[: done.n]
        q, v, work, torque = (x.copy() for x in np.split(rows, [nv, 2 * nv, end], 1))
        compiling = self.integrator.compile_seconds + self.engine.compile_seconds
        self.engine.compile_seconds = 0.0  # the next run on this engine compiles nothing
        motion = self.times[: done.n], q, v, torque if torque.shape[1] else None, work
        counts = done.steps, done.evaluations, done.events, done.seconds
        who = self.library, self.version, compiling
        return Run(*motion, *counts, *who, error, stop, happened=tuple(done.log[: done.logged]))


class SmoothLoop(IntegrationLoop):
    """A scene without contacts. Where angles are read from directions, a segment may end between two output times."""

    def __init__(self, prepared: Prepared, pace: Pace, progress: ProgressCallback) -> None:
        super().__init__(prepared, pace, progress)
        self.library, self.version = self.integrator.library, self.integrator.version
        self._derivative, self._evaluations = self.integrator.equations(self.engine, self.progress)
        if self.balance is not None and not self.engine.compiles:  # else the work is compiled too
            motion, balance, size = self._derivative, self.balance, self.engine.size

            def derivative(dy: Array, t: float, y: Array) -> None:  # of the engine's state, and of the work
                motion(dy[:size], t, y[:size])
                dy[size:] = balance.powers(t, y[:size])

            self._derivative = derivative
        self._largest = dict[str, Array]()  # numbers so far of a state that is shifted
        self._budget = max(LEAST_EVALUATIONS, EVALUATIONS * SMALL // max(SMALL, self.nv))

    def begin(self, q: Array, v: Array) -> RunState:
        t, y, work, density = float(self.times[0]), self.engine.pack(q, v), np.zeros(self.accounts), 0.0
        self.sample(t, y)
        whole = np.concatenate([y, work])
        if not self.engine.on_angles and len(self.times) > 1:  # from which the first angles should be read
            rate = np.zeros(len(whole))
            self._derivative(rate, t, whole)
            change = float(np.nan_to_num(np.abs(rate[: len(y)])).max()) / FIRST_CHANGE
            some = FIRST_STEPS / max(float(self.times[1] - self.times[0]), SHORTEST)
            density = max(self.engine.density(y[None]), change, some)
        memory = self.integrator.memory(whole)
        first = SmoothState(t, q, y, work, self.first_segment, 0.0, density, memory, self.records)
        return RunState.at_start(np.concatenate([q, v, work]), len(self.times), first)

    def go_on(self, done: RunState) -> tuple[RunState, str | None]:
        """One segment; its number of output times follows from the evaluations of the last one."""
        last = done.last
        assert isinstance(last, SmoothState)
        self.recall(last)
        n, due = len(last.y), self.times[done.n :][: last.most]
        span = np.concatenate([[last.t], due])
        self.progress(last.t)
        before = self._evaluations()
        segment, times, at, density = self._integrate_closely(span, last)
        took = self._evaluations() - before
        states, work = segment.y[:, :n], segment.y[:, n:]
        q, v = self.engine.unpack(times[: len(states)], states, last.q)
        at = at[at < len(states)]
        ahead = max(1, len(at)) * self._budget // max(took, 1)
        next_one = SmoothState(
            t=float(times[len(states) - 1]),
            q=q[-1],
            y=states[-1] if self.integrator.step else self.engine.project(states[-1]),
            work=work[-1],
            most=max(1, min(ahead, GROWTH * len(due) if density else len(self.times))),
            first_step=float(times[-1] - times[0]) / segment.steps if segment.steps else last.first_step,
            density=MARGIN * density,
            memory=segment.memory,
            held=self.records,
        )
        rows = np.concatenate([q[at], v[at], work[at]], 1)
        return done.grown(rows, next_one, segment.steps, took), segment.failure

    def _integrate_closely(self, span: Array, last: SmoothState) -> tuple[Segment, Array, Array, float]:
        """A segment over the beginning of `span` (n,), the times (k,) of its states, where output times are, the density."""
        start, density = np.concatenate([last.y, last.work]), last.density
        if self.engine.on_angles:
            at = np.arange(1, len(span))
            return self._integrate_shifted(start, span, at, last.first_step or None, last.memory), span, at, 0.0
        first_step, room = last.first_step or None, NUMBERS // len(start) + 1
        while True:
            parts = self._parts(span, density)
            at = np.cumsum(parts)
            if at[0] > room:
                times = span[0] + (span[1] - span[0]) * (np.arange(room + 1) / at[0])
            else:
                count = np.searchsorted(at, room, "right")
                times = subdivided(span[: count + 1], parts[:count])
            segment = self._integrate_shifted(start, times, at, first_step, last.memory)
            needed = self.engine.density(segment.y[:, : len(last.y)])  # states per s, and at least one a step
            if needed * float(np.diff(span).max()) > MOST_STATES:
                raise SamplesTooFew("thin rods turn too far between samples to count their turns: take more samples")
            needed = max(needed, segment.steps / max(float(times[-1] - times[0]), SHORTEST))
            if segment.failure or (self._parts(span, needed) <= parts).all():
                return segment, times, at, needed
            density = MARGIN * needed

    def _parts(self, span: Array, density: float) -> Indices:
        """How many parts each interval of `span` (n,) is cut into, (n - 1,): one, or all its steps where these are fixed."""
        if not density:
            return np.ones(len(span) - 1, int)
        step, intervals = self.integrator.step, np.diff(span)
        parts = np.ceil(np.clip(density * intervals, 1.0, MOST_PARTS)).astype(int)
        if step:
            pairs = zip(intervals, parts, strict=True)
            parts = np.array([count_equal_steps(dt, step) if more > 1 else 1 for dt, more in pairs])
        return parts

    def _integrate_shifted(
        self, y: Array, times: Array, at: Indices, first_step: float | None, memory: Memory
    ) -> Segment:
        """Integrate over `times` (n,), with output times at the places `at` (k,), and the shifts of the run."""
        if self.shifts is None:
            return self._integrate(y, times, first_step, memory)
        # They come at the beginning of a segment, but for the start, and behind every few output times.
        segment, rows, steps, size = Segment(y[None], 0, memory=memory), [y[None]], 0, len(y) - self.accounts
        part_of_largest, every = self.shifts
        cuts = at[every - 1 :: every]
        for begin, end in pairwise([0, *cuts[cuts < len(times) - 1], len(times) - 1]):
            y, part = segment.y[-1].copy(), part_of_largest * (times[begin] > self.times[0])
            if begin and not (self.integrator.step or self.engine.on_angles):
                y[:size] = self.engine.project(y[:size])
            y[:size] = self._shift("y", y[:size], part)
            kept: Any = segment.memory
            if hasattr(kept, "motion"):
                kept = kept._replace(motion=self._shift("memory", kept.motion, part))
            segment = self._integrate(y, times[begin : end + 1], first_step, kept)
            rows.append(segment.y[1:])
            steps += segment.steps
            if segment.failure:
                break
            first_step = float(times[end] - times[begin]) / segment.steps if segment.steps else first_step
        return replace(segment, y=np.concatenate(rows), steps=steps)

    def _shift(self, name: str, x: Array, part: float) -> Array:
        """Numbers of a state, each shifted away from 0 by a part of its largest so far."""
        largest = self._largest[name] = np.maximum(self._largest.get(name, 0.0), np.abs(x))
        return x + np.copysign(part * largest, x) if part else x

    def _integrate(self, y: Array, span: Array, first_step: float | None, memory: Memory) -> Segment:
        """Integrate from y (size,) over the output times `span` (n,); restart at each corner of the pace."""
        if not len(self.pace.corners) and not self.held:
            plan = StepPlan(first_step, longest=float(self.pace.shortest[0]), memory=memory)
            return self.integrator.states_at(self._derivative, y, span, plan)
        rows, steps, first_step = y[None], 0, None if span[0] in self.pace.corners else first_step
        for times, due, longest in self.pace.pieces(span):
            begin, end = times[[0, -1]]
            plan = StepPlan(first_step, longest, memory, anew=bool(begin in self.pace.corners))
            part = self.integrator.states_at(self._one_sided(begin, end), y, times, plan)
            rows, steps = np.concatenate([rows, part.y[1 : due + 1]]), steps + part.steps
            if not part.failure:
                self.sample(float(end), part.y[-1])
            if part.failure or end == span[-1]:
                return replace(part, y=rows, steps=steps)
            y, memory, first_step = part.y[-1], part.memory, None
        raise AssertionError

    def _one_sided(self, begin: float, end: float) -> Derivative:
        """The derivative between two times in s; at a corner of the pace, where effects may jump, as on this side."""
        corners = self.pace.corners
        at_begin, at_end = (corners.searchsorted(t, "left") < corners.searchsorted(t, "right") for t in (begin, end))
        if not (at_begin or at_end):
            return self._derivative
        margin = BESIDE * (abs(self.dynamics.start) + abs(end))
        low, high = begin + at_begin * margin, end - at_end * margin
        derivative = self._derivative
        return lambda dy, t, y: derivative(dy, max(low, min(t, high)), y)


def integrate_to_end(loop: IntegrationLoop, q: Array, v: Array, checkpoint: Checkpoint | None = None) -> Run:
    """Integrate from q, v (nv,), or from the saved state, to the end. A failed or halted run keeps what was integrated."""
    try:
        done, error, stop = loop.begin(q, v), None, None
    except np.linalg.LinAlgError as fault:
        raise InputError(f"start: {fault}") from None
    if checkpoint:
        done = checkpoint.resume(done)

    def clock() -> float:
        return time.thread_time() - loop.engine.compile_seconds  # which is counted apart

    before = done.seconds - clock()
    while error is None and done.n < len(done.room):
        try:
            done, failure = loop.go_on(done)
            error = RunError(failure) if failure else None
            if error is None and checkpoint and checkpoint.due:
                checkpoint.save(replace(done, seconds=before + clock()))
        except KeyboardInterrupt:
            error = Interrupted("stopped by the user")
        except np.linalg.LinAlgError as fault:
            error = RunError(f"{fault}; give the rod a radius, or remove the torque about theta")
        except RunError as fault:
            error = fault
    done = replace(done, seconds=before + clock())
    if checkpoint and (error is None or isinstance(error, Halted)):
        with suppress(Halted):  # the previous save remains
            checkpoint.save(done)
    if error is not None and (isinstance(error, Stalled) or not isinstance(error, Halted)) and loop.shifts is None:
        times = loop.times
        try:
            done, stop = _locate_stop(loop, done, error)
        finally:
            loop.times = times
    return loop.finish(done, error, stop)


def _locate_stop(loop: IntegrationLoop, done: RunState, error: RunError) -> tuple[RunState, Stop | None]:
    """The run with the samples that its last segment has lost, and the last state before it stopped, where that is known."""

    def integrate(state: RunState) -> RunState:
        failure = None
        while state.n < len(loop.times) and failure is None:
            try:
                state, failure = loop.go_on(state)
            except (PendpinError, np.linalg.LinAlgError):
                break
        return state

    def stop_at(state: RunState) -> Stop:
        return Stop(float(loop.times[state.n - 1]), *np.split(state.room[state.n - 1, : 2 * loop.nv], 2))

    if isinstance(error, Stalled):  # integrated again up to where it still advanced
        if error.t <= done.last.t:
            return done, None
        loop.times = np.append(loop.times[loop.times < error.t], error.t)
        again = integrate(done)
        return (again, None) if again.n < len(loop.times) else (replace(again, n=again.n - 1), stop_at(again))
    if loop.integrator.step is not None or done.n == len(done.room) or isinstance(error, SamplesTooFew):
        return done, None  # a method with a fixed step has a sample there, and too few samples stop nothing
    end, state, stop = loop.times[done.n], done, None
    for _ in range(LEVELS):  # approached in ever smaller parts
        loop.times = np.linspace(state.last.t, end, PARTS + 1)
        state = integrate(RunState.at_start(state.room[state.n - 1], PARTS + 1, state.last))
        if state.n > 1:
            stop = stop_at(state)
        if state.n > PARTS:
            break
        end = loop.times[state.n]
    return done, stop
