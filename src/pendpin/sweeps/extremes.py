"""The largest values of smooth series of many motions, between their samples, from the values and the rates there.

Where a series rises at one sample and falls at the next, the polynomial through POINTS samples near, in values and rates
(Hermite's), has a top between them. It is of degree 11: what it leaves out is estimated from its last terms.
"""

import numpy as np

from pendpin.ground.arrays import TINY, Array, Indices, Mask
from pendpin.motions.continuation import strays

POINTS = 6  # samples that a polynomial passes through
EXACT = 2e-11  # of the largest value: what a polynomial may leave out by an estimate, which is right within a factor of five
CORRECTIONS = 8  # of a top's place, by Newton's method: as many as double the digits from one to all, and some more
FAR = 4.0  # times what the rates move a series in an interval: farther it does not get there, whatever it does


def largest(t: Array, x: Array, rate: Array, sizes: bool = False, follows: Mask | None = None) -> tuple[Array, Array]:
    """The largest values, or `sizes`, (c,) of c motions: series x and rates (c, n, m) at times t (n,) in s; and when.

    NaN where samples do not tell it to EXACT: the series do not follow from their rates there, or as `follows` (c,) says.
    """
    sized, dt = np.abs(x) if sizes else x, np.diff(t)
    places = sized.argmax(1)  # (c, m)
    tops = np.take_along_axis(sized, places[:, None], 1)[:, 0]
    value = tops.max(1)
    when = t[np.where(tops == value[:, None], places, len(t) - 1).min(1)]
    sure = np.full(len(x), len(t) >= POINTS) if follows is None else follows & (len(t) >= POINTS)
    if not sure.any():
        return np.full(len(x), np.nan), np.full(len(x), np.nan)
    if follows is None:
        row, i, j = _where(strays(dt[:, None], x, rate))
        beside = np.clip(i[:, None] + np.arange(-1, 3), 0, len(t) - 1)
        path = dt[i] * np.abs(rate[row[:, None], beside, j[:, None]]).max(1)
        sure[row[np.maximum(sized[row, i, j], sized[row, i + 1, j]) + FAR * path >= value[row]]] = False
    falls = rate < 0
    turns = falls[:, 1:] & ~falls[:, :-1]  # a rod let go from rest may rise before it falls
    if sizes:
        rises = rate > 0
        turns |= rises[:, 1:] & ~rises[:, :-1]
    row, i, j = _where(turns & sure[:, None, None])
    sign = -np.sign(rate[row, i + 1, j])
    ahead, behind = x[row, i, j] + dt[i] * rate[row, i, j], x[row, i + 1, j] - dt[i] * rate[row, i + 1, j]
    some = np.maximum(sign * ahead, sign * behind) > value[row]
    row, i, j, sign = row[some], i[some], j[some], sign[some]
    top, at, off = _find_turns(t, x, rate, row, i, j)
    top = sign * top
    sure[row[~(off <= EXACT * np.abs(x).max((1, 2))[row])]] = False
    order = np.argsort(top)  # of several tops of a motion the last one written is the largest
    row, top, at = row[order], top[order], at[order]
    above = top > value[row]
    value[row[above]], when[row[above]] = top[above], at[above]
    return np.where(sure, value, np.nan), np.where(sure, when, np.nan)


def _where(mask: Mask) -> tuple[Indices, Indices, Indices]:
    """The places (k,) where a mask (c, n, m) is set, searched as the samples lie in memory: faster than np.nonzero."""
    row, j, i = np.unravel_index(np.flatnonzero(np.moveaxis(mask, 1, 2)), (len(mask), *mask.shape[:0:-1]))
    return row, i, j


def _find_turns(t: Array, x: Array, rate: Array, row: Indices, i: Indices, j: Indices) -> tuple[Array, Array, Array]:
    """Turning points (k,) of series j of motions `row` in the intervals behind samples i: values, times, what is off."""
    near = np.clip(i - POINTS // 2 + 1, 0, len(t) - POINTS)[:, None] + np.arange(POINTS)
    near = np.take_along_axis(near, np.argsort(np.abs(near - i[:, None] - 0.5), 1, kind="stable"), 1)  # both ends first
    near, h = np.ascontiguousarray(near.T), t[i + 1] - t[i]
    nodes = np.repeat((t[near] - t[i]) / h, 2, axis=0)  # each twice: for its value and for its rate
    table, slopes = np.repeat(x[row, near, j], 2, axis=0), rate[row, near, j] * h
    coefficients = np.empty_like(table)
    coefficients[0] = table[0]
    for order in range(1, 2 * POINTS):  # divided differences; of two equal nodes the rate
        gap, table = nodes[order:] - nodes[:-order], table[1:] - table[:-1]
        if order == 1:
            table[::2], gap[::2] = slopes, 1.0
        table /= gap
        coefficients[order] = table[0]
    begin, end = rate[row, i, j], rate[row, i + 1, j]
    place, step, value = begin / (begin - end), np.ones(len(i)), np.zeros(len(i))
    place[begin == 0] = 1.0  # from the other end, as that of a rest is a turning point too
    for _ in range(CORRECTIONS):
        apart = place - nodes
        value, slope, half = coefficients[-1], np.zeros(len(i)), np.zeros(len(i))  # half: of the curvature
        # Horner's rule, with derivatives
        for coefficient, off in zip(coefficients[-2::-1], apart[-2::-1], strict=True):
            half = off * half + slope
            slope = off * slope + value
            value = off * value + coefficient
        step = np.clip(place - slope / np.where(half * end > 0, 2 * half, np.sign(end) * TINY), 0.0, 1.0) - place
        place = place + step
    products = np.cumprod(place - nodes[:-1], 0)
    terms = np.abs(coefficients[-4:] * products[-4:])
    before, last = terms[:2].sum(0), terms[2:].sum(0)
    off = last * np.minimum(1.0, last / np.maximum(before, TINY))
    return value, t[i] + h * place, np.where(np.abs(step) < 1e-6, off, np.inf)
