"""What ends a run that leads nowhere: time that stands still, numbers out of range, energy that does not add up."""

import time

import numpy as np

from pendpin.arrays import Array
from pendpin.engines import ProgressCallback
from pendpin.errors import Halted
from pendpin.trajectory import Trajectory

WINDOW = 5.0  # s of wall time between two looks at how far a run gets
LONGEST = 86_400.0  # s of wall time that a run may still need: a day
OFF = 0.1  # of the energy moved: an energy that is off by more belongs to no motion
ROUNDING = 1e-9  # of the energies themselves, which may be large where little moves


class Patience:
    """A progress that passes the time on, and raises Halted where a run takes over `limit` s or would take days."""

    def __init__(self, duration: float, limit: float | None, progress: ProgressCallback) -> None:
        self._duration, self._limit, self._progress = duration, limit, progress
        self._begin, self._marked = time.perf_counter(), np.inf  # until the first call: compiling is no standstill
        self._reached = self._before = 0.0

    def __call__(self, t: float) -> None:
        self._progress(t)
        now = time.perf_counter()
        self._reached = max(self._reached, t)
        if self._limit is not None and now - self._begin > self._limit:
            raise Halted(f"it takes over {self._limit:g} s")
        if now - self._marked > WINDOW:
            self._refuse_days(now)
        self._marked = min(self._marked, now)

    def _refuse_days(self, now: float) -> None:
        """Raise Halted if the rest, at the pace of the last window, takes longer than anyone waits."""
        gained, took = self._reached - self._before, now - self._marked
        rest = self._duration - self._reached
        if rest * took > LONGEST * gained:
            days = rest * took / gained / LONGEST if gained > 0 else np.inf
            how_long = f"about {days:.0e} days" if np.isfinite(days) else "for ever"
            raise Halted(f"at its pace of {gained:.1e} s in {took:.0f} s the rest takes {how_long}")
        self._marked, self._before = now, self._reached


def balanced(trajectory: Trajectory) -> int:
    """How many samples there are before the first where the energy is off by more than OFF of what has moved.

    The total counts where every effect has a potential, the energy balance where there is one. Where little moves, as at
    the start from an unstable rest, off by the tolerance's share of the energies themselves is what was asked for.
    """
    off, moved, size = np.zeros(len(trajectory.t)), np.abs(trajectory.kinetic), np.abs(trajectory.potential)
    if trajectory.stats.conservative:
        total = trajectory.energy().total
        off, moved = np.abs(total - total[0]), moved + np.abs(trajectory.potential - trajectory.potential[0])
    if trajectory.work:
        works = np.array(list(trajectory.work.values()))
        off = np.maximum(off, np.abs(trajectory.kinetic - trajectory.kinetic[0] - works.sum(0)))
        moved = moved + np.abs(works).sum(0)
    allowed = max(ROUNDING, trajectory.stats.tolerance or 0.0)
    bad = off > OFF * _so_far(moved) + allowed * _so_far(moved + size)
    return int(np.argmax(bad)) if bad.any() else len(bad)


def _so_far(x: Array) -> Array:
    return np.maximum.accumulate(x)
