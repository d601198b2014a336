"""The course of a smooth motion: a lane goes over the output times, stretch by stretch."""

import numpy as np

from pendpin.checkpoint import Progress
from pendpin.derivations.base import Array
from pendpin.driving import Course
from pendpin.dynamics import Dynamics
from pendpin.engines import Watch
from pendpin.ledger import Ledger
from pendpin.solvers import Lane

EVALUATIONS = 20_000  # about, in a stretch, which bounds what an interrupt loses
LEAST_EVALUATIONS = 2_000  # of a large model, whose evaluations take longer
SMALL = 2  # joints: those of a model with EVALUATIONS in a stretch
FIRST_STRETCH = 1  # output times


class Smooth(Course):
    """A scene without contacts, integrated in stretches of so many output times as the last took evaluations."""

    def __init__(self, lane: Lane, dynamics: Dynamics, books: Ledger | None, times: Array, watch: Watch) -> None:
        super().__init__(lane, dynamics, books, times, watch)
        self.library, self.version = lane.library, lane.version
        self._engine = dynamics.engine
        self._derivative, self._evaluations = lane.equations(self._engine, watch)
        if books is not None:
            size = len(self._engine.pack(*np.zeros((2, self.nv))))
            self._derivative = books.booked(self._derivative, size)
        self._budget = max(LEAST_EVALUATIONS, EVALUATIONS * SMALL // max(SMALL, self.nv))

    def begin(self, q: Array, v: Array) -> Progress:
        """As `Course.begin`."""
        y = self._engine.pack(q, v)
        carried = {"y": y, "ahead": np.array(float(FIRST_STRETCH)), "first_step": np.array(0.0), **self.lane.memory(y)}
        return Progress.at_start(np.concatenate([q, v, np.zeros(self.accounts)]), len(self.times), carried)

    def go_on(self, done: Progress) -> tuple[Progress, str | None]:
        """As `Course.go_on`."""
        y, ahead, first_step = done.carried["y"], int(done.carried["ahead"]), float(done.carried["first_step"])
        span, last = self.times[done.n - 1 :][: ahead + 1], done.samples[-1]
        before, start = self._evaluations(), np.concatenate([y, last[2 * self.nv :]])
        stretch = self.lane.integrate(self._derivative, start, span, first_step or None, done.carried)
        took = self._evaluations() - before
        states, work = np.split(stretch.y, [len(y)], axis=1)
        q, v = self._engine.unpack(span[1 : len(states)], states[1:], last[: self.nv])
        carried = {
            "y": self._engine.settle(states[-1]),
            "ahead": np.array(float(max(1, ahead * self._budget // max(took, 1)))),
            "first_step": np.array((span[-1] - span[0]) / max(stretch.steps, 1)),
            **stretch.memory,
        }
        return done.grown(np.concatenate([q, v, work[1:]], 1), carried, stretch.steps, took), stretch.failure
