"""Reasons to end a run: its limit, too slow progress, an energy error."""

import time
from collections.abc import Callable
from threading import TIMEOUT_MAX
from typing import TypeVar

import numpy as np

from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import ProgressCallback
from pendpin.errors import Halted, RunError
from pendpin.ground import libraries
from pendpin.ground.arguments import seconds
from pendpin.ground.arrays import Array, Mask
from pendpin.ground.records import LARGEST
from pendpin.trajectory import RunRecord, exchanged
from pendpin.trajectory.parts import ROUNDING

WINDOW = 5.0  # s of processor time between two checks of the progress of a run
LONGEST = 86_400.0  # s of processor time that a run may still need: a day
BACK = 1e-5  # of the duration: so long before it stalls a run advances fast, and its state shows why it will stall
OFF = 0.1  # of the energy exchanged: largest energy error of a valid run

GRACE = 0.2  # s, that a computation gets at least: one that is compiled already needs less
MOST_BUSY = 4.0  # how many times as long as its processor time a computation may take, among others
T = TypeVar("T")


class Deadline:
    """The limit of a whole run in s of wall time, counted from the creation of this object; None is no limit."""

    def __init__(self, limit: float | None) -> None:
        given = None if limit is None else seconds("limit", limit)
        self.limit = given if given is not None and given < TIMEOUT_MAX else None  # longer than a thread can wait
        self._begin, self._begin_own = time.perf_counter(), time.thread_time()

    @property
    def left(self) -> float:
        """The time that is left, in s."""
        return np.inf if self.limit is None else self.limit - (time.perf_counter() - self._begin)

    def check(self, reserve: float) -> None:
        """Raise Halted if the time left is less than `reserve` s of processor time take at the pace so far."""
        if self.limit is None:
            return
        wall, own = time.perf_counter() - self._begin, time.thread_time() - self._begin_own
        if self.limit - wall < reserve * max(1.0, min(wall / max(own, 1e-9), MOST_BUSY)):
            raise Halted(f"it takes over {self.limit:g} s, compiling included")

    def wait_for(self, compute: Callable[[], T], long: bool) -> T:
        """The result of a computation; of a long one that cannot be stopped, such as compiling, only until the deadline.

        Raises Halted if it takes longer. The computation then goes on in a thread, which Python waits for at its end.
        """
        if self.limit is None or not long:
            return compute()
        try:
            return libraries.wait_for(compute, max(self.left, GRACE))
        except TimeoutError:
            raise Halted(f"it reached the limit of {self.limit:g} s while compiling") from None


class Stalled(Halted):
    """A run that hardly advances any more; up to `t`, in s since its start, it advanced at a usable pace."""

    t = 0.0


class SamplesTooFew(RunError):
    """Output times are too far apart to read a result from: another choice of them is the cure, wherever the run is."""


class Patience:
    """A progress callback that raises Halted at the deadline, or Stalled if the rest of the run would take days.

    `reserve` returns the time in s to complete the samples up to a time t; it must be left before the deadline.
    """

    def __init__(
        self, duration: float, deadline: Deadline, reserve: Callable[[float], float], progress: ProgressCallback
    ) -> None:
        self._duration, self._deadline, self._reserve, self._progress = duration, deadline, reserve, progress
        self._marked = np.inf  # until the first call, so that compiling does not count
        self._reached = self._before = 0.0

    def __call__(self, t: float) -> None:
        self._progress(t)
        now = time.process_time()  # on a busy machine a run may get none for long
        self._reached = max(self._reached, t)
        self._deadline.check(self._reserve(t))
        if now - self._marked > WINDOW:
            self._refuse_days(now)
        self._marked = min(self._marked, now)

    def _refuse_days(self, now: float) -> None:
        """Raise Stalled if the rest takes longer than LONGEST at the pace of the last window."""
        gained, took = self._reached - self._before, now - self._marked
        rest = self._duration - self._reached
        if rest * took > LONGEST * gained:
            days = rest * took / gained / LONGEST if gained > 0 else np.inf
            rest_of_it = f"the rest would take about {days:.0e} days" if np.isfinite(days) else "it would never end"
            error = Stalled(f"it advanced {gained:.1e} s in the last {took:.0f} s: {rest_of_it}")
            error.t = self._before - BACK * self._duration
            self._marked = now  # what is integrated again gets a window of its own
            raise error
        self._marked, self._before = now, self._reached


def balanced(trajectory: RunRecord) -> int:
    """The number of samples up to which the energy is off by at most OFF of the energy exchanged until then.

    That is the drift of the total energy if every effect has a potential, and the imbalance if the works are known.
    A run from rest exchanges little at first, so the last such sample counts, not the first that is not.
    """
    so_far, errors = np.maximum.accumulate, list[tuple[Array, Array]]()  # each with its scale, (n,) J
    kinetic, potential = trajectory.kinetic, trajectory.potential
    if trajectory.stats.conservative:
        total = kinetic + potential
        errors.append((so_far(np.abs(total - total[0])), exchanged(kinetic, potential)))
    if works := trajectory.work.values():
        errors.append((so_far(np.abs(trajectory.unbalanced)), exchanged(kinetic, *works)))
    if not any((error > OFF * scale).any() for error, scale in errors):
        return len(trajectory.t)
    # Where nothing is exchanged, rounding counts: that of the terms of a potential energy, which round also where they
    # cancel, as in a horizontal rod. Its scale takes longer than all the rest.
    force, moment = (np.linalg.norm(x, axis=-1).max(1) for x in np.split(trajectory.wrench, 2, -1))
    least = ROUNDING * so_far(moment + force * np.linalg.norm(trajectory.tips, axis=-1).max(1, initial=0.0))
    bad = np.any([error > OFF * np.maximum(scale, least) for error, scale in errors], 0)
    return int(np.flatnonzero(~bad)[-1]) + 1


def ends_well(dynamics: Dynamics, q: Array, v: Array) -> Mask:
    """Whether each start (c,) came to its end, in numbers that are not too large, with the energy it should have."""
    good = np.asarray(((np.abs(q) <= LARGEST) & (np.abs(v) <= LARGEST)).all((1, 2)))
    if not dynamics.conservative or not good.any():
        return good
    ends = [rows[good][:, [0, -1]].reshape(-1, q.shape[2]) for rows in (q, v)]
    kinetic, potential = (energy.reshape(-1, 2) for energy in dynamics.energies(*ends))
    elsewhere = dynamics.energies(ends[0] + 1.0, np.zeros_like(ends[1]))[1].reshape(-1, 2)
    least = ROUNDING * np.abs(elsewhere).max(1)  # the potential at the ends may vanish, its rounding does not
    off = np.abs(np.diff(kinetic + potential))[:, 0]
    good[good] = off <= OFF * np.maximum(exchanged(kinetic.T, potential.T)[-1], least)
    return good
