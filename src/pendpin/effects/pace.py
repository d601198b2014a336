"""How fast an effect changes with time, so that no step of an integration jumps over it."""

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pendpin.ground.arrays import Array

SIGNS = np.array([math.comb(8, k) * (-1.0) ** k for k in range(9)])  # of an eighth difference: 8 is the order of dop853
BLOCK = 64  # intervals of samples, at least, in which steps are as long as in all of them
RESTART = 8.0  # steps, about what a break of the integration costs
STEEP, BESIDE = 4.0, 8  # a change that may be a jump: over the median of so many changes before and after it
MOST_JUMPS = 64  # located; a signal with more is rough everywhere, and its steps are short anyway


class Pace(NamedTuple):
    """The pieces of a run, and in each the shortest time on which an effect changes.

    The integration restarts at the corners and takes no step longer than the shortest time of the piece.
    """

    corners: Array  # (n - 1,) s, ends of the pieces: an effect may switch, jump or begin there
    shortest: Array  # (n,) s; inf where nothing changes with time

    @classmethod
    def even(cls, shortest: float) -> "Pace":
        """The same shortest time in s throughout."""
        return cls(np.empty(0), np.array([shortest]))

    @property
    def varies(self) -> bool:
        """Whether anything changes with time."""
        return len(self.corners) > 0 or bool(np.isfinite(self.shortest).any())

    def at(self, t: Array) -> Array:
        """The shortest time in s right after each of the times t (n,) in s."""
        return np.asarray(self.shortest)[np.searchsorted(self.corners, t, "right")]

    def pieces(self, times: Array) -> Iterator[tuple[Array, int, float]]:
        """Cut times (n,) in s at the corners: of each piece its times with both ends, how many are due, the shortest."""
        # Due are those of `times` behind the beginning of the piece; its end is one of them, or a corner.
        if not len(self.corners):
            yield times, len(times) - 1, float(self.shortest[0])
            return
        corners, done = self.corners[(self.corners > times[0]) & (self.corners < times[-1])], 1
        bounds = np.concatenate([times[:1], corners, times[-1:]])
        for (begin, end), shortest in zip(pairwise(bounds), self.at(bounds[:-1]), strict=True):
            due = times[done : (done := int(np.searchsorted(times, end, "right")))]
            last = [] if len(due) and due[-1] == end else [end]
            yield np.concatenate([[begin], due, last]), len(due), float(shortest)


STEADY = Pace.even(np.inf)  # of an effect to which time makes no difference


def join_paces(paces: Sequence[Pace]) -> Pace:
    """The pace of several effects that act at once."""
    if not paces:
        return STEADY
    corners = np.array(sorted({float(t) for pace in paces for t in pace.corners}))  # np.unique imports numpy.ma
    starts = np.append(-np.inf, corners)
    return Pace(corners, np.min([pace.at(starts) for pace in paces], 0))


def measure_pace(t: Array, values: Array, negligible: float) -> Pace:
    """The pace of a signal with values (n + 1, k) at even times t (n + 1,) in s; n is `BLOCK` times a power of 2."""
    # A step spans at most eight strides of 1, 2, 4, ... intervals: the longest such that over it, and over shorter ones, all
    # eighth differences are below `negligible` of the largest value; and one interval where there is none. So a pulse, a
    # ripple or a corner gets steps of its own length, at any time, and however small it is beside other changes.
    n, floor, stride = len(t) - 1, negligible * np.abs(values).max(initial=0.0), 1
    steps, smooth = np.ones(n), np.ones(n, bool)  # intervals
    while 8 * stride <= n and smooth.any():
        windows = np.lib.stride_tricks.sliding_window_view(values, 8 * stride + 1, 0)[..., ::stride]
        rough = np.cumsum(np.pad((np.abs(windows @ SIGNS) > floor).any(1), (8 * stride, 8 * stride)))
        smooth &= rough[8 * stride : 8 * stride + n] == rough[:n]  # no window over the interval
        steps[smooth] = 8 * stride
        stride *= 2
    lengths, longest = np.array(_split(np.where(steps >= n, np.inf, steps))).T
    new = np.append(np.diff(longest) != 0, True)  # pieces with equal steps are one
    ends, step = np.cumsum(lengths)[new].astype(int), longest[new] * (t[1] - t[0])
    return Pace(t[ends[:-1]], step)


def _split(steps: Array) -> list[tuple[int, float]]:
    """Pieces of a signal, each with its length and its longest step, in intervals: halves where that saves steps."""
    whole, half = [(len(steps), float(steps.min()))], len(steps) // 2
    if half < BLOCK or whole[0][1] == np.inf:
        return whole
    halves = [*_split(steps[:half]), *_split(steps[half:])]
    counts = (sum(max(1.0, length / step) for length, step in pieces) for pieces in (whole, halves))
    return whole if next(counts) <= next(counts) + RESTART * (len(halves) - 1) else halves


def remove_jumps(values: Callable[[float], Array], t: Array, samples: Array, negligible: float) -> tuple[Array, Array]:
    """The times (n,) in s just behind a signal's jumps, and its samples (m, k) at rising times t (m,) less the jumps."""
    # A jump is a change between two samples that does not become smaller from interval to half.
    changes, samples = np.abs(np.diff(samples, axis=0)).max(1), samples.copy()
    around = np.median(np.lib.stride_tricks.sliding_window_view(np.pad(changes, BESIDE), 2 * BESIDE + 1), axis=1)
    steep = np.flatnonzero((changes > negligible * np.abs(samples).max(initial=0.0)) & (changes > STEEP * around))
    places = []
    for i in steep[np.argsort(-changes[steep], kind="stable")][:MOST_JUMPS]:
        a, b = float(t[i]), float(t[i + 1])
        before, after = values(a), values(b)
        while a < (middle := a + (b - a) / 2) < b:  # to the half in which the signal changes most
            value = values(middle)
            if np.abs(value - before).max() > np.abs(after - value).max():
                b, after = middle, value
            else:
                a, before = middle, value
        if np.abs(after - before).max() > changes[i] / 2:
            places.append(b)
            samples[i + 1 :] -= after - before
    return np.unique(places), samples
