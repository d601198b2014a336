"""The state of a run: the samples so far, and where its integration continues."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from pendpin.dynamics.contacts.contacts import Mode
from pendpin.ground.arrays import Array
from pendpin.integrators import Memory
from pendpin.trajectory import Event


class SmoothState(NamedTuple):
    """Where a motion without events continues. Shapes do not change during a run."""

    t: float  # s since the start
    q: Array  # (nv,) the angles from which turns are counted
    y: Array  # (size,) the engine's state
    work: Array  # (accounts,) J
    most: int  # output times of the next segment
    first_step: float  # s, a proposal; 0 without one
    density: float  # states per s, from which angles are read in the next segment; 0 where the state holds angles
    memory: Memory  # of the integrator
    held: tuple[Array, ...]  # the records of the sampled torques, which all states share


class EventState(NamedTuple):
    """Where a motion with events continues."""

    t: float  # s since the start
    y: Array  # (size,) positions, rates, work of the accounts
    mode: Mode
    at_once: int  # events at this instant, so far
    held: tuple[Array, ...]  # as in SmoothState


@dataclass(frozen=True, eq=False)
class RunState:
    """The motion at the first n output times, and the state with which its integration continues.

    All states of a run share one array `room`; its first n rows do not change any more.
    """

    room: Array  # (output times, columns): q, v, work of the accounts, torques of contacts
    n: int
    last: SmoothState | EventState
    steps: int = 0
    evaluations: int = 0
    events: int = 0
    seconds: float = 0.0
    log: list[Event] = field(default_factory=list)  # what happened at the events, shared as `room` is
    logged: int = 0  # how many of these belong to the state

    @classmethod
    def at_start(cls, first: Array, count: int, last: SmoothState | EventState) -> "RunState":
        """A state with the first of `count` samples, first (columns,)."""
        room = np.empty((count, len(first)))
        room[0] = first
        return cls(room, 1, last)

    @property
    def samples(self) -> Array:
        """The rows so far, (n, columns)."""
        return self.room[: self.n]

    @property
    def complete(self) -> bool:
        """Whether there is a sample for every output time."""
        return self.n == len(self.room)

    def cut(self, n: int) -> "RunState":
        """The state with the first n samples; it cannot be continued."""
        return replace(self, n=n)

    def grown(
        self,
        samples: Array,
        last: SmoothState | EventState,
        steps: int,
        evaluations: int,
        happened: Sequence[Event] | None = None,
    ) -> "RunState":
        """The state with more samples (k, columns), the counts increased, and what happened if there was an event."""
        n = self.n + len(samples)
        self.room[self.n : n] = samples
        self.log[self.logged :] = happened or ()
        counts = (self.steps + steps, self.evaluations + evaluations, self.events + (happened is not None))
        return RunState(self.room, n, last, *counts, self.seconds, self.log, len(self.log))


@dataclass(frozen=True)
class Shifts:
    """Shifts of a motion without events: every few samples, each number of its state by a part of its largest so far.

    All are away from 0, so that they add up. With a size of 0 they only cut the run into segments.
    """

    size: float  # relative to the largest value
    samples: int  # from one shift to the next, at most
