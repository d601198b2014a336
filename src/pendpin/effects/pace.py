"""How fast an effect changes with time, so that no step of an integration jumps over it."""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pendpin.ground.arrays import Array

DECAY = 3.0  # a signal is resolved where its distance to polynomials of degree 4 falls so much from interval to half
STEP = 0.25  # of a resolved interval: the longest step that cannot jump over it
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

    @classmethod
    def sinusoid(cls, frequency: float | None) -> "Pace":
        """Half a period of a sinusoid of a frequency in rad/s; no change without one."""
        return cls.even(np.inf if frequency is None else np.pi / frequency)

    def at(self, t: Array) -> Array:
        """The shortest time in s right after each of the times t (n,) in s."""
        return np.asarray(self.shortest)[np.searchsorted(self.corners, t, "right")]

    def pieces(self, times: Array) -> Iterator[tuple[Array, int, float]]:
        """Times (n,) in s cut at the corners: of each piece its times with both ends, how many are due, the shortest time.

        Due are those of `times` behind the beginning of the piece; its end is one of them, or a corner.
        """
        corners, done = self.corners[(self.corners > times[0]) & (self.corners < times[-1])], 1
        bounds = np.concatenate([times[:1], corners, times[-1:]])
        for (begin, end), shortest in zip(pairwise(bounds), self.at(bounds[:-1]), strict=True):
            due = times[done : (done := int(np.searchsorted(times, end, "right")))]
            yield (
                np.concatenate([[begin], due, [] if len(due) and due[-1] == end else [end]]),
                len(due),
                float(shortest),
            )


STEADY = Pace.even(np.inf)  # of an effect to which time makes no difference


def join_paces(paces: Sequence[Pace]) -> Pace:
    """The pace of several effects that act at once."""
    if not paces:
        return Pace.even(np.inf)
    corners = np.array(sorted({float(t) for pace in paces for t in pace.corners}))  # np.unique imports numpy.ma
    starts = np.append(-np.inf, corners)
    return Pace(corners, np.min([pace.at(starts) for pace in paces], 0))


def intervals_for(least: int) -> int:
    """The number of intervals that `measure_pace` takes: 4 times a power of 2, not below 4 times `least`."""
    return 4 << max(0, int(least - 1).bit_length())


def measure_pace(t: Array, values: Array, negligible: float, rounding: float | Array = 0.0) -> Pace:
    """The pace of a signal with values (n, k) at rising times t (n,) in s, n - 1 being of `intervals_for`.

    The samples are cut into halves, and halves of these, down to intervals that are resolved: from there on down, their
    distance to the polynomials of degree 4 through five of their samples falls by `DECAY` or more with each halving, as
    that of smooth functions does, or is below `negligible` of the largest value. A pulse, a ripple or a jump gets
    intervals of its own length, at any time, and however small it is compared with other changes. `rounding`,
    one number or (n,), is what the values may be off by anyway.
    """
    floor = np.broadcast_to(negligible * np.abs(values).max(initial=0.0) + rounding, t.shape)
    distances = [np.zeros((len(t) - 1) // 4)]  # of the intervals of each level, the shortest first
    resolved = [np.ones(len(distances[0]), bool)]
    while len(distances[-1]) > 1:
        own, halves = _distances(t, values, floor, len(distances[-1]) // 2), distances[-1].reshape(-1, 2)
        resolved.append(resolved[-1].reshape(-1, 2).all(1) & (DECAY * halves.max(1) <= own))
        distances.append(own)
    return _joined(float(t[0]), *_pieces(t, distances, resolved))


def remove_jumps(values: Callable[[float], Array], t: Array, samples: Array, negligible: float) -> tuple[Array, Array]:
    """The times (n,) in s at which a signal jumps, and its samples (m, k) at rising times t (m,) in s less the jumps.

    Each time is the first floating-point number after its jump. A jump is a change between two samples that does not
    become smaller from interval to half.
    """
    changes, samples = np.abs(np.diff(samples, axis=0)).max(1), samples.copy()
    around = np.median(np.lib.stride_tricks.sliding_window_view(np.pad(changes, BESIDE), 2 * BESIDE + 1), axis=1)
    steep = np.flatnonzero((changes > negligible * np.abs(samples).max(initial=0.0)) & (changes > STEEP * around))
    places = []
    for i in steep[np.argsort(-changes[steep], kind="stable")][:MOST_JUMPS]:
        place, before, after = _halved(values, float(t[i]), float(t[i + 1]))
        if np.abs(after - before).max() > changes[i] / 2:
            places.append(place)
            samples[i + 1 :] -= after - before
    return np.unique(places), samples


def _halved(values: Callable[[float], Array], a: float, b: float) -> tuple[float, Array, Array]:
    """Where between a and b in s a signal changes most: a time, and the values just before it and at it."""
    before, after = values(a), values(b)
    while a < (middle := a + (b - a) / 2) < b:
        value = values(middle)
        if np.abs(value - before).max() > np.abs(after - value).max():
            b, after = middle, value
        else:
            a, before = middle, value
    return b, before, after


def _distances(t: Array, values: Array, floor: Array, count: int) -> Array:
    """Of `count` equal parts of the samples, (count,): the largest distance to the polynomial through five of them.

    Distances below the floor (n,) of their samples count as 0.
    """
    size = (len(t) - 1) // count
    places = np.arange(count)[:, None] * size + np.arange(size + 1)
    nodes = np.arange(5) * (size // 4)
    time, value = t[places], values[places]  # (count, size + 1), (count, size + 1, k)
    time = (time - time[:, :1]) / (time[:, -1:] - time[:, :1])
    knots, table = time[:, nodes], value[:, nodes].astype(float)
    for order in range(1, 5):  # Newton's divided differences
        gaps = (knots[:, order:] - knots[:, :-order])[..., None]
        table[:, order:] = (table[:, order:] - table[:, order - 1 : -1]) / gaps
    values_between = table[:, 4, None]
    for k in (3, 2, 1, 0):
        values_between = table[:, k, None] + (time - knots[:, k, None])[..., None] * values_between
    distance = np.abs(value - values_between).max(2)
    return np.where(distance > floor[places], distance, 0.0).max(1)


def _pieces(t: Array, distances: list[Array], resolved: list[Array]) -> tuple[Array, Array]:
    """Ends (n,) of the largest resolved intervals, in s, and the longest steps in them."""
    unresolved, ends, steps = np.ones(1, bool), [], []
    for distance, good in zip(reversed(distances), reversed(resolved), strict=True):
        size = (len(t) - 1) // len(good)
        accepted = np.flatnonzero(unresolved & good)
        length = t[(accepted + 1) * size] - t[accepted * size]
        ends.append(t[(accepted + 1) * size])
        steps.append(np.where(distance[accepted] > 0, STEP * length, length))
        unresolved = np.repeat(unresolved & ~good, 2)
    order = np.argsort(np.concatenate(ends))
    return np.concatenate(ends)[order], np.concatenate(steps)[order]


def _joined(begin: float, ends: Array, steps: Array) -> Pace:
    """Pieces, with ends and longest steps (n,) in s, made few: neighbours become one wherever that costs fewer steps."""
    joined: list[tuple[float, float]] = []  # length, longest step
    for length, step in zip(np.diff(ends, prepend=begin), steps, strict=True):
        piece = (float(length), float(step))
        while joined:
            before = joined[-1]
            both = before[0] + piece[0], min(before[1], piece[1])
            if _cost(both) > _cost(before) + _cost(piece) + RESTART:
                break
            joined.pop()
            piece = both
        joined.append(piece)
    lengths, steps = np.array(joined).T
    return Pace(begin + np.cumsum(lengths)[:-1], np.where(steps < lengths, steps, np.inf))


def _cost(piece: tuple[float, float]) -> float:
    """The steps that a piece takes at least."""
    return max(1.0, piece[0] / piece[1])
