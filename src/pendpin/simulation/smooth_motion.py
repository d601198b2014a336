"""A motion without contacts, integrated segment by segment; a segment is a number of output times."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from pendpin.arrays import Array, subdivided
from pendpin.errors import RunError
from pendpin.integrators import Memory, Segment, StepPlan
from pendpin.integrators.fixed import steps_in
from pendpin.simulation.checkpoint import RunState
from pendpin.simulation.loop import IntegrationLoop, Task

EVALUATIONS = 20_000  # in a segment, about: an interrupt loses at most these
LEAST_EVALUATIONS = 2_000  # of a large model, whose evaluations take longer
SMALL = 2  # joints: those of a model with EVALUATIONS in a segment
FIRST_SEGMENT = 1  # output times
FIRST_STEPS = 2  # that it takes at least, the first of them a small one
GROWTH = 256  # of the output times of a segment, where the states that it needs are not known
MARGIN = 1.25  # of the states in the next segment, over those that this one needed
MOST_STATES = 4_000_000  # in a segment


class SmoothLoop(IntegrationLoop):
    """A scene without contacts. The length of a segment is chosen from the evaluations that the last one took."""

    def __init__(self, task: Task) -> None:
        super().__init__(task)
        self.library, self.version = self.integrator.library, self.integrator.version
        self._derivative, self._evaluations = self.integrator.equations(self.engine, self.progress)
        if self.balance is not None:
            size = len(self.engine.pack(*np.zeros((2, self.nv))))
            self._derivative = self.balance.with_work(self._derivative, size)
        self._budget = max(LEAST_EVALUATIONS, EVALUATIONS * SMALL // max(SMALL, self.nv))

    def begin(self, q: Array, v: Array) -> RunState:
        """The first sample, from q, v (nv,)."""
        y = self.engine.pack(q, v)
        carried = {
            "y": y,
            "ahead": np.array(float(FIRST_SEGMENT)),
            "first_step": np.array(0.0),
            "parts": np.array(self._first_parts(y)),
            **self.integrator.memory(y),
        }
        return RunState.at_start(np.concatenate([q, v, np.zeros(self.accounts)]), len(self.times), carried)

    def _first_parts(self, y: Array) -> float:
        """How many states the first interval should have, from the state (size,) at the start."""
        t = self.times[: FIRST_SEGMENT + 1]
        needed = self.engine.denser(t, np.tile(y, (len(t), 1)), FIRST_STEPS)
        return float(np.clip(math.ceil(needed), 1, MOST_STATES))

    def go_on(self, done: RunState) -> tuple[RunState, str | None]:
        """One segment; its number of output times follows from the evaluations of the last one."""
        y, ahead, first_step = done.carried["y"], int(done.carried["ahead"]), float(done.carried["first_step"])
        span, last = self.times[done.n - 1 :][: ahead + 1], done.samples[-1]
        self.progress(float(span[0]))
        before, start = self._evaluations(), np.concatenate([y, last[2 * self.nv :]])
        segment, parts, needed = self._read_closely(
            start, span, int(done.carried["parts"]), first_step or None, done.carried
        )
        took = self._evaluations() - before
        states, work = (x[::parts] for x in np.split(segment.y, [len(y)], axis=1))
        fine = subdivided(span, parts)[: len(segment.y)]
        q, v = (x[::parts][1:] for x in self.engine.unpack(fine, segment.y[:, : len(y)], last[: self.nv]))
        ahead = max(1, min(ahead * self._budget // max(took, 1), GROWTH * ahead if needed else len(self.times)))
        carried = {
            "y": states[-1] if self.integrator.step else self.engine.project(states[-1]),
            "ahead": np.array(float(ahead)),
            "first_step": np.array((span[-1] - span[0]) / max(segment.steps, 1)),
            "parts": np.array(float(max(1, math.ceil(MARGIN * parts * needed)))),
            **segment.memory,
        }
        return done.grown(np.concatenate([q, v, work[1:]], 1), carried, segment.steps, took), segment.failure

    def _read_closely(
        self, y: Array, span: Array, parts: int, first_step: float | None, memory: Memory
    ) -> tuple[Segment, int, float]:
        """A segment from y (size,) over `span` (n,), with more states between output times if angles are read from them.

        Also returns the number of parts of each interval, and by what factor there should have been more.
        """
        step = self.integrator.step
        whole = steps_in(span[1] - span[0], step) if step else 0  # steps in an interval
        while True:
            parts = parts if not step else 1 if parts == 1 else whole  # else the steps would change
            segment = self._integrate(y, subdivided(span, parts), first_step, memory)
            states = segment.y[:, : len(memory["y"])]
            needed = self.engine.denser(subdivided(span, parts)[: len(states)], states, segment.steps)
            wanted = math.ceil(parts * needed)
            if segment.failure or wanted <= parts or (step and parts == whole):
                return segment, parts, needed
            if wanted * len(span) > MOST_STATES:
                raise RunError("thin rods turn too far between samples to count their turns: take more samples")
            parts = wanted

    def _integrate(self, y: Array, span: Array, first_step: float | None, memory: Memory) -> Segment:
        """Integrate from y (size,) over the output times `span` (n,); restart at each corner of the pace."""
        corners = self.pace.corners[(self.pace.corners > span[0]) & (self.pace.corners < span[-1])]
        bounds, rows, steps = np.concatenate([span[:1], corners, span[-1:]]), y[None], 0
        first_step = None if span[0] in self.pace.corners else first_step
        for (begin, end), longest in zip(pairwise(bounds), self.pace.at(bounds[:-1]), strict=True):
            due = span[(span > begin) & (span <= end)]
            times = np.concatenate([[begin], due, [] if len(due) and due[-1] == end else [end]])
            part = self.integrator.integrate(self._derivative, y, times, StepPlan(first_step, float(longest), memory))
            rows, steps = np.concatenate([rows, part.y[1 : len(due) + 1]]), steps + part.steps
            if part.failure or end == span[-1]:
                return replace(part, y=rows, steps=steps)
            y, memory, first_step = part.y[-1], part.memory, None
        raise AssertionError
