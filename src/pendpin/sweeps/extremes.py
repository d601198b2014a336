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
    """The largest values (c,) of c motions, of series x (c, n, m) with rates (c, n, m) per s at times t (n,) in s, and when.

    `sizes`: of their sizes. NaN for a motion whose samples do not tell it to EXACT: where the largest value may be, the
    series do not follow from their rates; or they do not at all, as `follows` (c,) says.
    """
    sized, dt = np.abs(x) if sizes else x, np.diff(t)
    places = sized.reshape(len(x), -1).argmax(1)
    value, when = np.take_along_axis(sized.reshape(len(x), -1), places[:, None], 1)[:, 0], t[places // x.shape[2]]
    told = np.full(len(x), len(t) >= POINTS) if follows is None else follows & (len(t) >= POINTS)
    if not told.any():
        return np.full(len(x), np.nan), np.full(len(x), np.nan)
    if follows is None:
        row, i, j = np.nonzero(strays(dt[:, None], x, rate))
        beside = np.clip(i[:, None] + np.arange(-1, 3), 0, len(t) - 1)
        path = dt[i] * np.abs(rate[row[:, None], beside, j[:, None]]).max(1)
        told[row[np.maximum(sized[row, i, j], sized[row, i + 1, j]) + FAR * path >= value[row]]] = False
    turns = (rate[:, :-1] >= 0) & (rate[:, 1:] < 0)  # a rod let go from rest may rise before it falls
    if sizes:
        turns |= (rate[:, :-1] <= 0) & (rate[:, 1:] > 0)
    row, i, j = np.nonzero(turns & told[:, None, None])
    sign = -np.sign(rate[row, i + 1, j])
    ahead, behind = x[row, i, j] + dt[i] * rate[row, i, j], x[row, i + 1, j] - dt[i] * rate[row, i + 1, j]
    some = np.maximum(sign * ahead, sign * behind) > value[row]
    row, i, j, sign = row[some], i[some], j[some], sign[some]
    top, at, off = _find_turns(t, x, rate, row, i, j)
    top = sign * top
    told[row[~(off <= EXACT * np.abs(x).max((1, 2))[row])]] = False
    order = np.argsort(top)  # of several tops of a motion the last one written is the largest
    row, top, at = row[order], top[order], at[order]
    above = top > value[row]
    value[row[above]], when[row[above]] = top[above], at[above]
    return np.where(told, value, np.nan), np.where(told, when, np.nan)


def _find_turns(t: Array, x: Array, rate: Array, row: Indices, i: Indices, j: Indices) -> tuple[Array, Array, Array]:
    """The turning points (k,) of series j (k,) of motions `row` (k,) in the intervals behind samples i (k,).

    Their values, when, and what they may be off by.
    """
    near = np.clip(i - POINTS // 2 + 1, 0, len(t) - POINTS)[:, None] + np.arange(POINTS)
    near = np.take_along_axis(near, np.argsort(np.abs(near - i[:, None] - 0.5), 1, kind="stable"), 1)  # both ends first
    h, some = t[i + 1] - t[i], (row[:, None], near, j[:, None])
    nodes = np.repeat((t[near] - t[i][:, None]) / h[:, None], 2, axis=1).T  # each twice: for its value and for its rate
    table, slopes = np.repeat(x[some], 2, axis=1).T, np.repeat(rate[some] * h[:, None], 2, axis=1).T
    coefficients = [table[0]]
    for order in range(1, 2 * POINTS):  # divided differences
        gap = nodes[order:] - nodes[:-order]
        table = np.where(gap == 0, slopes[order:], np.diff(table, axis=0) / np.where(gap == 0, 1.0, gap))
        coefficients.append(table[0])
    begin, end = rate[row, i, j], rate[row, i + 1, j]
    value, place, step = np.zeros(len(i)), begin / (begin - end), np.ones(len(i))
    place[begin == 0] = 1.0  # from the other end, as that of a rest is a turning point too
    for _ in range(CORRECTIONS):
        value, slope, bend = np.zeros((3, len(i)))
        for coefficient, node in zip(coefficients[::-1], nodes[::-1], strict=True):  # Horner's rule, with derivatives
            apart = place - node
            bend, slope, value = 2 * slope + apart * bend, value + apart * slope, coefficient + apart * value
        step = np.clip(place - slope / np.where(bend * end > 0, bend, np.sign(end) * TINY), 0.0, 1.0) - place
        place = place + step
    terms = np.abs(np.array(coefficients) * np.cumprod(np.vstack([np.ones_like(place), place - nodes[:-1]]), 0))
    before, last = terms[-4:-2].sum(0), terms[-2:].sum(0)
    off = last * np.minimum(1.0, last / np.maximum(before, TINY))
    return value, t[i] + h * place, np.where(np.abs(step) < 1e-6, off, np.inf)
