"""Where a quantity of a run changes its sign, pairs of changes between two samples included.

The samples show where the motion went between them if positions follow from rates and rates from accelerations; if they do
not, there are more. A quantity is then interpolated between them. Where the interpolation does not tell on which side of 0
the quantity is, it is sampled at Chebyshev points, in shorter and shorter intervals.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from pendpin.errors import InputError
from pendpin.ground.arrays import Array, Indices, Mask, subdivided
from pendpin.integrators.grid import NEAR
from pendpin.motions.continuation import Continuation
from pendpin.trajectory import RunRecord, joined, samples_of

Quantity = Callable[[RunRecord], Array]  # of a run, (n,)

OFF = 0.1  # of what a joint moves in an interval or beside it: a sine in steps of a radian is integrated so well
STILL = 1e-9  # of what a joint moves in all: less is rounding
STEPS = 2  # parts that an interval is cut into, times the steps that the run took in it
PARTS, LEVELS = 4, 8  # into how many it is cut again, how often: a rod that passes its pole turns in any time
GROWN = 4  # times as many intervals as after the first cut: a passage of a pole has few at any level, rounding has ever more
MOST = 200_000  # samples after that, and again where a quantity is sampled
BESIDE = 1e-7  # of the run: how far before and behind an event a sample is taken, as rates jump in between
POINTS = (6, 4)  # samples by which a quantity is interpolated; the distance of both is the error
DEGREE = 9  # of an interpolation at Chebyshev points
UNSEEN = 4.0  # times the larger of its last two coefficients, or times that distance: what it leaves out
DEEPEST = 12  # times an interval is cut in two, about; its points alone are looked at then
ROUNDING = 2.0**-46  # of the largest value: values so small have no sign


class Changes(NamedTuple):
    """Intervals of time at whose ends a quantity has different signs, and in which it has one zero or jumps."""

    begin: Array  # (k,) s
    end: Array
    before: Array  # (k,), the quantity there
    after: Array


class _Pieces(NamedTuple):
    """A quantity in m intervals, as Chebyshev series that are exact at both ends."""

    begin: Array  # (m,) s
    end: Array
    values: Array  # (m, d + 1), at the Chebyshev points of each, which begin and end with its ends
    error: Array  # (m,), what the series leave out

    def some(self, which: Mask) -> "_Pieces":
        """The pieces of some of the intervals."""
        return _Pieces(*(x[which] for x in self))


def resolved(run: RunRecord) -> Continuation:
    """The run; where its samples do not tell how it moved between them, with more.

    Raises InputError if these would be too many.
    """
    dense = STEPS * run.stats.steps / max(len(run.t) - 1, 1)  # parts of a whole interval between samples
    most = np.inf
    more = _sampled_too(Continuation(run), _beside_events(run, _coarse(run)))
    for _ in range(LEVELS):
        if not 0 < len(coarse := _coarse(more.run)) <= most:
            break
        most = np.inf if dense else min(most, GROWN * len(coarse))
        shares = np.diff(more.run.t)[coarse] / np.diff(run.t)[_intervals_of(run, more.run.t[coarse])]
        parts = np.maximum(PARTS, np.ceil(dense * shares)).astype(int)
        if len(more.run.t) + parts.sum() > MOST:
            raise InputError(
                f"crossings: {len(run.t)} samples are too few for a run of {run.stats.steps} steps; "
                f"run it with samples = {run.stats.steps}"
            )
        cuts = np.ones(len(more.run.t) - 1, int)
        cuts[coarse] = parts
        more, dense = _sampled_too(more, subdivided(more.run.t, cuts)), 0.0
    return more


def _sampled_too(more: Continuation, times: Array) -> Continuation:
    """The run with samples at some times (k,) as well."""
    run, times = more.run, np.setdiff1d(_where_steps_end(more, times), more.run.t)
    if not len(times):
        return more
    whole = joined([run, more.at(times)])
    return more.beside(replace(samples_of(whole, np.argsort(whole.t, kind="stable")), events=run.events))


def _where_steps_end(more: Continuation, times: Array) -> Array:
    """The times (k,), of a run with a fixed step the ends of steps before them, counted from its samples.

    Steps begin anew at a sample: inside a step it would change the motion behind it.
    """
    if (step := more.scene.solver.step) is None:
        return times
    before = _intervals_of(more.run, times)
    begin, left = more.run.t[before], more.run.t[before + 1] - times
    steps = np.floor((times - begin) / step + NEAR)
    return np.where(left > NEAR * step, begin + steps * step, times)


def _intervals_of(run: RunRecord, t: Array) -> Indices:
    """The intervals (k,) between samples in which times (k,) are."""
    return np.clip(np.searchsorted(run.t, t, "right") - 1, 0, max(len(run.t) - 2, 0))


def _events_of(run: RunRecord) -> Array:
    """The times (k,) of its events, rising."""
    return np.array([event.t for event in run.events])


def _beside_events(run: RunRecord, intervals: Indices) -> Array:
    """Times (2 k,) just before and behind the k events in some intervals."""
    at = _events_of(run)
    at = at[np.isin(_intervals_of(run, at), intervals)]
    margin = BESIDE * (run.t[-1] - run.t[0])
    return np.clip(np.concatenate([at - margin, at + margin]), run.t[0], run.t[-1])


def _coarse(run: RunRecord) -> Indices:
    """The intervals (k,) in which a position does not follow from the rates at both ends, or a rate from accelerations.

    Not those of an event, where they jump.
    """
    dt, coarse = np.diff(run.t)[:, None], np.zeros(len(run.t) - 1, bool)
    for x, rate in ((run.q, run.v), (run.v, run.a)):
        off = np.abs(np.diff(x, axis=0) - dt * (rate[1:] + rate[:-1]) / 2)
        path = dt * np.maximum(np.abs(rate[1:]), np.abs(rate[:-1]))
        beside = np.concatenate([path[:1], path, path[-1:]])
        path = np.maximum(path, np.maximum(beside[:-2], beside[2:]))
        coarse |= (off > OFF * path + STILL * np.ptp(x, 0) + ROUNDING * np.abs(x).max(initial=0.0)).any(1)
    closed = _intervals_of(run, _events_of(run))
    closed = closed[dt[closed, 0] <= 3 * BESIDE * (run.t[-1] - run.t[0])]
    coarse[closed] = False
    return np.flatnonzero(coarse)


def sign_changes(more: Continuation, quantity: Quantity, size: float = 0.0) -> Changes:
    """All sign changes of a quantity of a run that is `resolved`; a value of 0 counts to the side that it comes from.

    The quantity is a difference of numbers up to `size`, or itself larger: it is rounded as these are.
    """
    times, values = more.run.t, quantity(more.run)
    tiny = ROUNDING * max(size, float(np.abs(values).max(initial=0.0)))
    pieces, samples, room = _interpolated(times, values, _events_of(more.run)), [(times, values)], MOST
    for depth in range(DEEPEST + 1):
        turns, pieces = _settled(pieces, tiny)
        samples += turns
        if depth:
            samples.append((_times(pieces)[:, 1:-1].reshape(-1), pieces.values[:, 1:-1].reshape(-1)))
            pieces = _halves(pieces)
        room -= (DEGREE - 1) * len(pieces.begin)
        if depth == DEEPEST or room < 0 or not len(pieces.begin):
            break
        pieces = _sampled(more, quantity, pieces)
    t, x = (np.concatenate(parts) for parts in zip(*samples, strict=True))
    t, first = np.unique(t, return_index=True)
    x = x[first]
    signs = _signs(x)
    i = np.flatnonzero(signs[1:] * signs[:-1] < 0)
    return Changes(t[i], t[i + 1], x[i], x[i + 1])


def _signs(values: Array) -> Array:
    """Signs (n,); that of a 0 is the sign before it."""
    signs = np.sign(values)
    for i in np.flatnonzero(signs == 0):
        signs[i] = signs[i - 1] if i else 0.0
    return signs


def _shares(degree: int) -> Array:
    """The Chebyshev points of an interval, both ends included, as shares of it, (degree + 1,), rising."""
    return (1 - np.cos(np.pi * np.arange(degree + 1) / degree)) / 2


def _times(pieces: _Pieces) -> Array:
    """The times (m, d + 1) of the values."""
    shares = _shares(pieces.values.shape[1] - 1)
    return pieces.begin[:, None] * (1 - shares) + pieces.end[:, None] * shares


def _interpolated(t: Array, x: Array, events: Array) -> _Pieces:
    """Between any two of n samples the polynomial through POINTS[0] near them; of fewer samples nothing is known.

    Nor where one of the events, at times (k,), is among these: there is no polynomial then.
    """
    begin, end, most = t[:-1], t[1:], POINTS[0]
    shares = _shares(most - 1)
    if len(t) < most:
        values = x[:-1, None] * (1 - shares) + x[1:, None] * shares
        return _Pieces(begin, end, values, np.full(len(begin), np.inf))
    inside = begin[:, None] + np.diff(t)[:, None] * shares[1:-1]
    fine, rough = (_through(t, x, inside, count) for count in POINTS)
    values = np.concatenate([x[:-1, None], fine, x[1:, None]], 1)
    first = _first_near(len(t), most)
    across = np.searchsorted(events, t[first]) < np.searchsorted(events, t[first + most - 1], "right")
    return _Pieces(begin, end, values, np.where(across, np.inf, UNSEEN * np.abs(fine - rough).max(1)))


def _first_near(samples: int, count: int) -> Indices:
    """The first of `count` samples near each interval between samples, (samples - 1,)."""
    return np.clip(np.arange(samples - 1) - count // 2 + 1, 0, samples - count)


def _through(t: Array, x: Array, inside: Array, count: int) -> Array:
    """The polynomials through `count` samples near each interval, at times inside it (n - 1, k); barycentric."""
    near = _first_near(len(t), count)[:, None] + np.arange(count)
    apart = (t[near][:, :, None] - t[near][:, None, :]) / np.diff(t)[:, None, None]
    apart[:, np.arange(count), np.arange(count)] = 1.0
    shares = 1 / apart.prod(2)[:, None] / (inside[..., None] - t[near][:, None])
    return (shares * x[near][:, None]).sum(-1) / shares.sum(-1)


def _sampled(more: Continuation, quantity: Quantity, pieces: _Pieces) -> _Pieces:
    """The same intervals, in order, with the quantity at their Chebyshev points."""
    values = np.empty((len(pieces.begin), DEGREE + 1))
    values[:, [0, -1]] = pieces.values[:, [0, -1]]
    pieces = pieces._replace(values=values)
    times, place = np.unique(_times(pieces)[:, 1:-1], return_inverse=True)
    values[:, 1:-1] = quantity(more.at(times))[place].reshape(len(values), -1)
    series = np.abs(_series(values))
    return pieces._replace(error=UNSEEN * np.maximum(series[:, -1], series[:, -2]))


def _halves(pieces: _Pieces) -> _Pieces:
    """Two parts of each interval, cut at the Chebyshev point next to its middle."""
    middle = pieces.values.shape[1] // 2
    cut, value = _times(pieces)[:, middle], pieces.values[:, middle]
    begin, end = np.stack([pieces.begin, cut], 1).reshape(-1), np.stack([cut, pieces.end], 1).reshape(-1)
    ends = np.stack([pieces.values[:, 0], value, value, pieces.values[:, -1]], 1).reshape(-1, 2)
    return _Pieces(begin, end, ends, np.repeat(pieces.error, 2))


def _series(values: Array) -> Array:
    """The coefficients (m, d + 1) of Chebyshev series from their values (m, d + 1) at the Chebyshev points."""
    degree = values.shape[1] - 1
    return values @ np.linalg.inv(chebyshev.chebvander(2 * _shares(degree) - 1, degree)).T


def _settled(pieces: _Pieces, tiny: float) -> tuple[list[tuple[Array, Array]], _Pieces]:
    """Turning points, times and values, where all sign changes are between these; and the intervals that are left.

    Settled is an interval in which the quantity is away from 0 by more than the error, or rises or falls throughout, or
    turns round only where it is away from 0, or is rounding throughout.
    """
    series, size = _series(pieces.values), np.abs(_series(pieces.values))
    steepest = np.arange(series.shape[1]) ** 2.0  # slopes of Chebyshev's polynomials
    error = np.maximum(pieces.error, tiny)
    clear = size[:, 0] - size[:, 1:].sum(1) > error
    steep = size[:, 1] - (size * steepest)[:, 2:].sum(1) > steepest[-1] * pieces.error
    flat = np.abs(pieces.values).max(1) + pieces.error <= tiny
    left, turns = ~(clear | steep | flat), list[tuple[Array, Array]]()
    for i in np.flatnonzero(left):
        slope = chebyshev.chebder(series[i])
        roots = chebyshev.chebroots(slope) if slope.any() else np.empty(0)
        x = np.sort(roots.real[(np.abs(roots.imag) < 1e-3) & (np.abs(roots.real) < 1)])
        values = chebyshev.chebval(x, series[i])
        if np.abs(np.concatenate([values, pieces.values[i, [0, -1]]])).min() > error[i]:
            turns.append((pieces.begin[i] + (pieces.end[i] - pieces.begin[i]) * (x + 1) / 2, values))
            left[i] = False
    return turns, pieces.some(left)
