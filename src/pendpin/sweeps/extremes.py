"""The largest values of smooth series of many motions, between their samples, from the values and the rates there.

Where a series rises at one sample and falls at the next, the polynomial through POINTS samples near, in values and rates
(Hermite's), has a top between them. It is of degree 11: what it leaves out is estimated from its last terms.
"""

import numpy as np

from pendpin.ground.arrays import TINY, Array, Indices, Mask
from pendpin.motions.continuation import strays

POINTS = 6  # samples that a polynomial passes through
EXACT = 1e-10  # of a series' largest value: what its polynomials may leave out
CORRECTIONS = 8  # of a top's place, by Newton's method: as many as double the digits from one to all, and some more


def largest(t: Array, x: Array, rate: Array, follows: Mask | None = None) -> tuple[Array, Array]:
    """The largest values (c,) of series x (c, n) with rates (c, n) per s at times t (n,) in s, and when they are reached.

    NaN for a series whose samples do not tell it to EXACT, or do not follow it: as `follows` (c,) says, else by its rates.
    """
    value, when = x.max(1), t[x.argmax(1)]
    dt, size = np.diff(t), np.abs(x).max(1)
    if follows is None:
        follows = np.asarray(~strays(dt[:, None], x[..., None], rate[..., None]).any((1, 2)))
    told = follows & (len(t) >= POINTS)
    if not told.any():
        return np.full(len(x), np.nan), np.full(len(x), np.nan)
    higher = np.maximum(x[:, :-1] + dt * rate[:, :-1], x[:, 1:] - dt * rate[:, 1:]) > value[:, None]
    row, i = np.nonzero((rate[:, :-1] > 0) & (rate[:, 1:] < 0) & higher & told[:, None])
    top, at, off = _tops(t, x, rate, row, i)
    told[row[~(off <= EXACT * size[row])]] = False
    order = np.argsort(top)  # of several tops of a series the last one written is the largest
    row, top, at = row[order], top[order], at[order]
    above = top > value[row]
    value[row[above]], when[row[above]] = top[above], at[above]
    return np.where(told, value, np.nan), np.where(told, when, np.nan)


def _tops(t: Array, x: Array, rate: Array, row: Indices, i: Indices) -> tuple[Array, Array, Array]:
    """The tops (k,) of series `row` (k,) in the intervals behind samples i (k,), when, and what they may be off by."""
    near = np.clip(i - POINTS // 2 + 1, 0, len(t) - POINTS)[:, None] + np.arange(POINTS)
    near = np.take_along_axis(near, np.argsort(np.abs(near - i[:, None] - 0.5), 1, kind="stable"), 1)  # both ends first
    h = t[i + 1] - t[i]
    nodes = np.repeat((t[near] - t[i][:, None]) / h[:, None], 2, axis=1)  # each twice: for its value and for its rate
    table, coefficients = np.repeat(x[row[:, None], near], 2, axis=1), [x[row, near[:, 0]]]
    slopes = np.repeat(rate[row[:, None], near] * h[:, None], 2, axis=1)
    for order in range(1, 2 * POINTS):  # divided differences
        gap = nodes[:, order:] - nodes[:, :-order]
        table = np.where(gap == 0, slopes[:, order:], np.diff(table) / np.where(gap == 0, 1.0, gap))
        coefficients.append(table[:, 0])
    value, place, step = np.zeros(len(i)), np.full(len(i), 0.5), np.ones(len(i))
    for _ in range(CORRECTIONS):
        value, slope, bend = np.zeros((3, len(i)))
        for coefficient, node in zip(coefficients[::-1], nodes.T[::-1], strict=True):  # Horner's rule, with derivatives
            apart = place - node
            bend, slope, value = 2 * slope + apart * bend, value + apart * slope, coefficient + apart * value
        step = np.clip(place - slope / np.where(bend < 0, bend, -TINY), 0.0, 1.0) - place
        place = place + step
    terms = np.abs(np.array(coefficients) * np.cumprod(np.vstack([np.ones_like(place), place - nodes.T[:-1]]), 0))
    before, last = terms[-4:-2].sum(0), terms[-2:].sum(0)
    off = last * np.minimum(1.0, last / np.maximum(before, TINY))
    return value, t[i] + h * place, np.where(np.abs(step) < 1e-6, off, np.inf)
