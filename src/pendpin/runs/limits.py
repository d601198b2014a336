"""Reasons to end a run before its end: its limit, and progress that is too slow."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from threading import TIMEOUT_MAX
from typing import TypeVar

import numpy as np

from pendpin.engines import ProgressCallback
from pendpin.errors import Halted, RunError
from pendpin.ground import libraries
from pendpin.ground.arguments import seconds

WINDOW = 5.0  # s of processor time between two checks of the progress of a run
LONGEST = 86_400.0  # s of processor time that a run may still need: a day
BACK = 1e-5  # of the duration: so long before it stalls a run advances fast, and its state shows why it will stall
GRACE = 0.2  # s, that a computation gets at least: one that is compiled already needs less
MOST_BUSY = 4.0  # how many times as long as its processor time a computation may take, among others
T = TypeVar("T")


class Deadline:
    """The limit of a whole run in s of wall time, counted from the creation of this object; None is no limit."""

    def __init__(self, limit: float | None) -> None:
        given = None if limit is None else seconds("limit", limit)
        self.limit = given if given is not None and given < TIMEOUT_MAX else None  # longer than a thread can wait
        self._begin, self._begin_own = time.perf_counter(), time.thread_time()

    def check(self, reserve: float) -> None:
        """Raise Halted if the time left is less than `reserve` s of processor time take at the pace so far."""
        if self.limit is None:
            return
        wall, own = time.perf_counter() - self._begin, time.thread_time() - self._begin_own
        if self.limit - wall < reserve * max(1.0, min(wall / max(own, 1e-9), MOST_BUSY)):
            raise Halted(f"it takes over {self.limit:g} s, compiling included")

    def wait_for(self, compute: Callable[[], T], long: bool) -> T:
        """The result of a computation; a long one, as compiling, goes on in a thread at the deadline. Raises Halted then."""
        if self.limit is None or not long:
            return compute()
        try:
            return libraries.wait_for(compute, max(self.limit - (time.perf_counter() - self._begin), GRACE))
        except TimeoutError:
            raise Halted(f"it reached the limit of {self.limit:g} s while compiling") from None


class Stalled(Halted):
    """A run that hardly advances any more; up to `t`, in s since its start, it advanced at a usable pace."""

    t = 0.0


class SamplesTooFew(RunError):
    """Output times are too far apart to read a result from: another choice of them is the cure, wherever the run is."""


@dataclass(eq=False)
class Patience:
    """A progress callback that raises Halted at the deadline, or Stalled if the rest of the run would take days."""

    duration: float  # s
    deadline: Deadline
    reserve: Callable[[float], float]  # t -> s to complete the samples up to it, to be left before the deadline
    progress: ProgressCallback
    _marked: float = np.inf  # until the first call, so that compiling does not count
    _reached: float = 0.0
    _before: float = 0.0

    def __call__(self, t: float) -> None:
        self.progress(t)
        now = time.process_time()  # on a busy machine a run may get none for long
        self._reached = max(self._reached, t)
        self.deadline.check(self.reserve(t))
        if (took := now - self._marked) > WINDOW:
            gained, rest = self._reached - self._before, self.duration - self._reached
            self._marked = now  # what is integrated again gets a window of its own
            if rest * took > LONGEST * gained:
                days = rest * took / gained / LONGEST if gained > 0 else np.inf
                rest_of_it = f"the rest would take about {days:.0e} days" if np.isfinite(days) else "it would never end"
                error = Stalled(f"it advanced {gained:.1e} s in the last {took:.0f} s: {rest_of_it}")
                error.t = self._before - BACK * self.duration
                raise error
            self._before = self._reached
        self._marked = min(self._marked, now)
