"""Where a quantity of a run crosses a level, and where it is largest: searched between the samples, to the run's accuracy.

A quantity is interpolated through samples near an interval. Where the interpolation does not tell on which side of 0 it is,
or whether it may exceed the largest value so far, it is sampled at Chebyshev points, in shorter and shorter intervals. An
instant is then a zero of the run itself.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from pendpin.errors import InputError
from pendpin.ground.arguments import number
from pendpin.ground.arrays import TINY, Array, Indices, Mask
from pendpin.integrators.events import COEFFICIENTS, DEGREE, SHARES, STEEPEST, UNSEEN, turning_points
from pendpin.motions.continuation import ROUNDING, Continuation, margin_of_events, resolve, times_of_events
from pendpin.trajectory import RunRecord, samples_of
from pendpin.trajectory.columns import DRIFT

Quantity = Callable[[RunRecord], Array]  # of a run, (n,); of which the largest is looked for, (n, m)

POINTS = (6, 4)  # samples by which a quantity is interpolated; the distance of both is the error
CANCELLED = 2.0**26  # times their sum: shares of samples that cancel to it leave half of the digits
OVERSHOOT = 4.0  # times the range of the samples near an interval: what a quantity may exceed them by
DEEPEST = 12  # times an interval is cut in two, about; its points alone are looked at then
CORNER, FEW = 52, 4  # or so often, to a trillionth of it, where the largest value is at a corner; so many parts then
MOST = 200_000  # samples
EXACT = 0.01  # of the run's tolerance: how well the largest value is resolved
FIXED = 1e-8  # in place of a tolerance, of a method with a fixed step
JUMP = 1e-3  # of the offsets around it: what is still on the other side has not crossed but jumps
AFTER = 1e-13  # of the times: how far behind a jump the state is taken
CLOSE = 2.0  # units in the last place of an instant: two ends of an interval so close are one
CUTS = 120  # times an interval is cut: a jump is found by halving


class Changes(NamedTuple):
    """Intervals of time at whose ends a quantity has different signs, and in which it has one zero or jumps."""

    begin: Array  # (k,) s
    end: Array
    before: Array  # (k,), the quantity there
    after: Array


class Extreme(NamedTuple):
    """The largest or the least value of a quantity of a run, and when it is reached.

    Where the quantity jumps at an event, a t that is the event's stands for just behind it, the double before for just
    before it.
    """

    value: float
    t: float  # s


class _Pieces(NamedTuple):
    """A quantity in p intervals, at their Chebyshev points, which begin and end with their ends; exact there."""

    begin: Array  # (p,) s
    end: Array
    column: Indices  # (p,) of the quantity
    values: Array  # (p, DEGREE + 1)
    error: Array  # (p,), what the interpolation leaves out

    def some(self, which: Mask | Indices) -> "_Pieces":
        """Some of the pieces, those at which a mask (p,) is set or those of the indices."""
        return _Pieces(*(x[which] for x in self))

    @property
    def times(self) -> Array:
        """The times (p, DEGREE + 1) of the values."""
        begin, end = self.begin[:, None], self.end[:, None]
        return np.clip(begin * (1 - SHARES) + end * SHARES, begin, end)  # which rounding may leave

    def turns(self, i: int | np.integer, series: Array) -> tuple[Array, Array]:
        """The ends and turning points of the interpolation in piece i, a Chebyshev series: times in s and values."""
        x = np.array(turning_points(series))
        return self.begin[i] + (self.end[i] - self.begin[i]) * (x + 1) / 2, chebyshev.chebval(x, series)


def check_crossing(level: Any, direction: Any) -> tuple[float, int]:
    """A level that is crossed and the direction, as they are used. Raises InputError."""
    one_of = "1 (upwards), -1 (downwards) or 0 (both)"
    return number("level", level), int(number("direction", direction, one_of, {-1, 0, 1}.__contains__))


def crossings(run: RunRecord, name: str, level: float, direction: int, wrapped: bool = False) -> RunRecord:
    """The run at the instants at which a quantity crosses a level (Trajectory.crossings), a `wrapped` angle in each turn."""
    level, direction = check_crossing(level, direction)
    run[name]  # an unknown name is refused before anything is integrated

    def offset(rows: RunRecord) -> Array:
        off = rows[name] - level
        return np.sin(off) if wrapped else off  # 0 half a turn away too: these are left out below

    more = resolve(run)
    changes = sign_changes(more, offset, 1.0 if wrapped else abs(level))
    chosen = np.isin(np.sign(changes.after), [direction] if direction else [-1, 1])
    instants = np.unique(find_instants(more, offset, Changes(*(x[chosen] for x in changes))))
    if not len(instants):
        return replace(samples_of(run, slice(0, 0)), stats=replace(run.stats, steps=0, evaluations=0, events=0))
    rows = more.at(instants)
    return samples_of(rows, np.cos(rows[name] - level) > 0) if wrapped else rows


def first_crossings(more: Continuation, quantities: Sequence[Quantity]) -> Array:
    """The first instant in s at which each of k quantities of a run that is resolved changes its sign, (k,); else NaN."""
    first = np.full(len(quantities), np.nan)
    for i, quantity in enumerate(quantities):
        changes = Changes(*(x[:1] for x in sign_changes(more, quantity)))
        if len(changes.begin):
            first[i] = find_instants(more, quantity, changes)[0]
    return first


def sign_changes(more: Continuation, quantity: Quantity, size: float = 0.0) -> Changes:
    """All sign changes of a quantity, of numbers up to `size`, of a resolved run; 0 counts to where it comes from."""
    times, values = more.run.t, quantity(more.run)
    tiny = max(ROUNDING * max(size, float(np.abs(values).max(initial=0.0))), TINY)  # what underflows is rounding too
    known, every = [(times, values)], np.arange(len(times) - 1)
    pieces = _interpolate(times, values[:, None], times_of_events(more.run), every, np.zeros_like(every))

    def settle(pieces: _Pieces, cuts: int) -> _Pieces:
        """The pieces that are unsettled: neither away from 0, nor monotone, nor rounding, nor turning round away from 0."""
        series = pieces.values @ COEFFICIENTS.T
        size, error = np.abs(series), np.maximum(pieces.error, tiny)
        clear = size[:, 0] - size[:, 1:].sum(1) > error
        steep = size[:, 1] - (size * STEEPEST)[:, 2:].sum(1) > STEEPEST[-1] * pieces.error
        flat = np.abs(pieces.values).max(1) + pieces.error <= tiny
        left = ~(clear | steep | flat)
        for i in np.flatnonzero(left):
            t, x = pieces.turns(i, series[i])
            if np.abs(x).min() > error[i]:
                known.append((t[1:-1], x[1:-1]))
                left[i] = False
        pieces = pieces.some(left)
        if cuts:
            known.append((pieces.times[:, 1:-1].reshape(-1), pieces.values[:, 1:-1].reshape(-1)))
        return pieces

    _search(more, lambda rows: quantity(rows)[:, None], pieces, settle)
    t, x = (np.concatenate(parts) for parts in zip(*known, strict=True))
    t, first = np.unique(t, return_index=True)
    x = x[first]
    signs = np.sign(x)
    for i in np.flatnonzero(signs == 0):
        signs[i] = signs[i - 1] if i else 0.0
    i = np.flatnonzero(signs[1:] * signs[:-1] < 0)
    return Changes(t[i], t[i + 1], x[i], x[i + 1])


def find_largest(more: Continuation, quantity: Quantity, first: float = -np.inf) -> tuple[float, float, int, int]:
    """The largest value of a quantity (n, m) of a resolved run from `first` s on; when, in which column, of how many."""
    run = more.run if first <= more.run.t[0] else samples_of(more.run, more.run.t >= first)
    times, values, events = run.t, quantity(run), times_of_events(run)
    t, x = times, values
    if ((events > times[0]) & (events <= times[-1])).any():  # where it jumps, one of the sides may be the largest
        behind = more.sides_of_events.t > times[0]
        sides = samples_of(more.sides_of_events, behind)
        t, x = np.concatenate([t, sides.t]), np.concatenate([x, quantity(sides)])
    row, column = np.unravel_index(int(np.argmax(x)), x.shape)
    best = [(float(x[row, column]), float(t[row]), int(column))]
    tiny = max(max(ROUNDING, EXACT * (run.stats.tolerance or FIXED)) * float(np.abs(x).max()), TINY)

    high, most = np.ones((len(values) - 1, values.shape[1]), bool), POINTS[0]
    if len(values) >= most:  # the intervals in which the samples near may exceed the largest one
        windows = np.lib.stride_tricks.sliding_window_view(values, most, axis=0)
        top, least = windows.max(-1), windows.min(-1)
        high = (top + OVERSHOOT * (top - least) > best[0][0])[_first_near(len(values), most)]
    intervals, columns = np.nonzero(high)
    begin, end = times[intervals], times[intervals + 1]
    jumps = np.searchsorted(events, begin, "right") < np.searchsorted(events, end, "right")
    apart = ~(jumps & (end - begin <= 3 * margin_of_events(run)))

    def settle(pieces: _Pieces, cuts: int) -> _Pieces:
        """The pieces in which the quantity may still exceed the best one."""
        more_than = tiny if cuts > DEEPEST else 0.0  # at a corner; the top of what is smooth is known
        if cuts:
            i, k = np.unravel_index(int(np.argmax(pieces.values)), pieces.values.shape)
            if pieces.values[i, k] > best[-1][0] + more_than:
                best.append((float(pieces.values[i, k]), float(pieces.times[i, k]), int(pieces.column[i])))
        series = pieces.values @ COEFFICIENTS.T
        left = series[:, 0] + np.abs(series[:, 1:]).sum(1) + pieces.error > best[-1][0] + tiny
        for i in np.flatnonzero(left & (pieces.error <= tiny)):
            t, x = pieces.turns(i, series[i])
            if (top := float(x.max())) > best[-1][0] + more_than:
                best.append((top, float(t[int(x.argmax())]), int(pieces.column[i])))
            left[i] = False
        return pieces.some(left)

    _search(more, quantity, _interpolate(times, values, events, intervals[apart], columns[apart]), settle, CORNER)
    return *best[-1], values.shape[1]


def extreme(run: RunRecord, name: str, sign: float) -> Extreme:
    """The largest value of a quantity of a run, for sign 1, or the least, for -1. Raises InputError."""
    if not np.isfinite(run[name]).all():
        raise InputError(f"{name}: this run does not have it, so it has no largest value")
    if name == DRIFT:
        raise InputError(f"{DRIFT} is known at the samples alone: it is the error of the run; ask for energy")
    more = resolve(run)
    value, t, *_ = find_largest(more, lambda rows: sign * rows[name][:, None])
    if t in run.t:
        return Extreme(sign * value, t)
    more.run = run  # from its own samples, as run.at(t) has it
    return Extreme(float(more.at(np.array([t]))[name][0]), t)


def impacts(run: RunRecord) -> int:
    """The number of impacts on stops in a run."""
    return sum(event.kind == "stop" for event in run.events)


def _search(
    more: Continuation,
    quantity: Quantity,
    pieces: _Pieces,
    settle: Callable[[_Pieces, int], _Pieces],
    deepest: int = DEEPEST,
) -> None:
    """Sample the pieces of a quantity (n, m) that are not settled at their points; cut those that this does not settle."""
    pieces, room, middle = settle(pieces, 0), MOST, (DEGREE + 1) // 2
    for cuts in range(1, deepest + 1):
        room -= (DEGREE - 1) * len(pieces.begin)
        if room < 0 or not len(pieces.begin):
            return
        times, place = np.unique(pieces.times[:, 1:-1], return_inverse=True)
        inside = quantity(more.at(times))[place.reshape(len(pieces.begin), -1), pieces.column[:, None]]
        values = np.concatenate([pieces.values[:, :1], inside, pieces.values[:, -1:]], 1)
        series = np.abs(values @ COEFFICIENTS.T)
        error = UNSEEN * np.maximum(series[:, -1], series[:, -2])
        pieces = settle(pieces._replace(values=values, error=error), cuts)
        if cuts >= DEEPEST:  # the highest of those that rise and then fall, as rounding does not
            rise = np.diff(pieces.values)
            fallen = np.minimum.accumulate(rise, 1) < 0
            pieces = pieces.some(~np.any(fallen[:, :-1] & (rise[:, 1:] > 0), 1))
            pieces = pieces.some(np.argsort(-pieces.values.max(1))[:FEW])
        # Two parts, cut at the Chebyshev point next to the middle; their values inside are not known.
        cut, x = pieces.times[:, middle], pieces.values[:, [0, middle, middle, -1]].reshape(-1, 2)
        begin, end = np.stack([pieces.begin, cut], 1).reshape(-1), np.stack([cut, pieces.end], 1).reshape(-1)
        pieces = _Pieces(begin, end, np.repeat(pieces.column, 2), x[:, [0] * DEGREE + [1]], np.full(len(begin), np.inf))


def _interpolate(t: Array, x: Array, events: Array, intervals: Indices, columns: Indices) -> _Pieces:
    """Polynomials through POINTS[0] of n samples near some intervals; unknown of few or close samples, or across events."""
    begin, end, most = t[intervals], t[intervals + 1], POINTS[0]
    ends = x[intervals, columns][:, None], x[intervals + 1, columns][:, None]
    line = ends[0] * (1 - SHARES) + ends[1] * SHARES
    if len(t) < most:
        return _Pieces(begin, end, columns, line, np.full(len(begin), np.inf))
    inside = begin[:, None] + (end - begin)[:, None] * SHARES[1:-1]
    interpolated = list[Array]()
    for count in POINTS:  # polynomials through so many samples near p intervals, inside these (p, k); barycentric
        near = _first_near(len(t), count)[intervals][:, None] + np.arange(count)
        apart = (t[near][:, :, None] - t[near][:, None, :]) / (end - begin)[:, None, None]
        apart[:, np.arange(count), np.arange(count)] = 1.0
        with np.errstate(divide="ignore", invalid="ignore"):  # a time inside may be a sample, where these are close
            shares = 1 / apart.prod(2)[:, None] / (inside[..., None] - t[near][:, None])
            total, size = shares.sum(-1), np.abs(shares).sum(-1)
            values = (shares * x[near, columns[:, None]][:, None]).sum(-1) / total
        interpolated.append(np.where(size < CANCELLED * np.abs(total), values, np.nan))
    fine, rough = interpolated
    first = _first_near(len(t), most)[intervals]
    across = np.searchsorted(events, t[first]) < np.searchsorted(events, t[first + most - 1], "right")
    error = UNSEEN * np.abs(fine - rough).max(1)
    known = np.isfinite(error)
    values = np.where(known[:, None], np.concatenate([ends[0], fine, ends[1]], 1), line)
    return _Pieces(begin, end, columns, values, np.where(known & ~across, error, np.inf))


def _first_near(samples: int, count: int) -> Indices:
    """The first of `count` samples near each interval between samples, (samples - 1,)."""
    return np.clip(np.arange(samples - 1) - count // 2 + 1, 0, samples - count)


def find_instants(more: Continuation, quantity: Quantity, changes: Changes) -> Array:
    """The instants (k,) of sign changes; of a jump, the instant after it (Chandrupatla, Adv. Eng. Softw. 28 (1997))."""
    # all at once, by inverse quadratic interpolation where it is monotone, or halving
    a, b, fa, fb = (x.copy() for x in (changes.begin, changes.end, changes.before, changes.after))
    share, open_ = fa / (fa - fb), np.ones(len(a), bool)
    for _ in range(CUTS):
        least = CLOSE * np.spacing(np.maximum(np.abs(a), np.abs(b))) / np.maximum(np.abs(b - a), 1e-300)
        open_ &= (least < 0.5) & (fa != 0) & (fb != 0)
        if not open_.any():
            break
        t, f = a + np.clip(share, least, 1 - least) * (b - a), fa.copy()
        times, place = np.unique(t[open_], return_inverse=True)
        f[open_] = quantity(more.at(times))[place]
        same = np.sign(f) == np.sign(fa)
        c, fc = np.where(same, a, b), np.where(same, fa, fb)
        b, fb = np.where(open_ & ~same, a, b), np.where(open_ & ~same, fa, fb)
        a, fa = np.where(open_, t, a), np.where(open_, f, fa)
        with np.errstate(divide="ignore", invalid="ignore"):
            xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
            quadratic = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
            share = np.where((phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi) & np.isfinite(quadratic), quadratic, 0.5)
    # The better end; behind it where the quantity has jumped and not passed 0.
    nearer = np.abs(fa) <= np.abs(fb)
    instant, off = np.where(nearer, a, b), np.where(nearer, fa, fb)
    # A smooth quantity changes so much between two doubles where an interval is a few of them, as in a late run.
    width = changes.end - changes.begin
    share = np.maximum(JUMP, 2 * CLOSE * np.spacing(np.abs(instant)) / np.maximum(width, 1e-300))
    around = np.maximum(np.abs(changes.before), np.abs(changes.after))
    jumped = (off * changes.after < 0) & (np.abs(off) > share * around)
    behind = instant + AFTER * np.maximum(width, np.abs(instant))
    return np.where(jumped, np.minimum(changes.end, behind), instant)
