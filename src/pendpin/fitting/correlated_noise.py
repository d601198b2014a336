"""The memory of residuals: white noise beside noise whose correlation decays with time, and the variances that they give.

Starts and unknowns take up part of the noise, and most of it where it is slow, so that residuals look shorter in memory
than the noise was: with ten correlation times in the data the usual errors are half of the true ones. The restricted
likelihood (H. Patterson, R. Thompson, Biometrika 58 (1971), 545) counts what was taken up. It is evaluated for many kinds
of noise, and variances are averaged over these, because few data do not tell one kind from its neighbours.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_banded

from pendpin.ground.arrays import Array, Mask

TINY = 1e-300
RANK = 1e-14  # of the largest eigenvalue of products of columns: less is rounding


class Grid(NamedTuple):
    """The kinds of noise that are compared; benchmarks/fit_coverage.py shows what the bounds are good for."""

    times: int = 12  # correlation times, tried twice: over the whole range, then where the likelihood is
    ratios: int = 9  # variances of slow noise over those of white noise, the same
    shortest: float = 0.2  # of the time between two samples: these are then uncorrelated but for 0.7 %
    longest: float = 1.0  # of the longest series: slower noise looks like a drift
    least: float = 1e-3  # ratio: slow noise that no data show
    most: float = 1e4  # ratio: as good as no white noise
    unlikely: float = 1e-3  # of the largest likelihood: such a kind adds nothing


GRID = Grid()


class Series(NamedTuple):
    """N residuals one after the other: by piece, then by column, then by time."""

    rows: tuple[Array, Array, Array]  # each (N,): piece, sample and column of each
    gap: Array  # (N,) s since the one before; infinite at the first of a piece and column

    def take(self, x: Array) -> Array:
        """Values (P, M, columns, ...) in this order, (N, ...)."""
        return x[self.rows]

    @property
    def firsts(self) -> Array:
        """The S residuals at which a piece and column begins, (S,)."""
        return np.flatnonzero(np.isinf(self.gap))

    @property
    def edges(self) -> Array:
        """The residuals at which a piece begins, but for the first (P - 1,)."""
        return np.flatnonzero(np.diff(self.rows[0])) + 1

    @property
    def durations(self) -> Array:
        """The times in s from the first to the last residual of a piece and column (S,)."""
        return np.add.reduceat(np.where(np.isinf(self.gap), 0.0, self.gap), self.firsts)


class Kinds(NamedTuple):
    """T kinds of noise."""

    times: Array  # (T,) s, correlation times of the slow part
    ratios: Array  # (T,) of the variance of the slow part over that of white noise
    variances: Array  # (T,)
    weights: Array  # (T,) how likely each is; their sum is 1

    @property
    def time(self) -> float:
        """The typical correlation time in s."""
        return float(np.exp(self.weights @ np.log(self.times)))


def series_of(t: Array, seen: Mask) -> Series:
    """The residuals that were measured: `seen` (P, M, columns), at times t (M, P) in s."""
    piece, column, sample = np.nonzero(seen.transpose(0, 2, 1))
    gap = np.diff(t[sample, piece], prepend=np.nan)
    first = (np.diff(piece, prepend=-1) != 0) | (np.diff(column, prepend=-1) != 0)
    return Series((piece, sample, column), np.where(first, np.inf, gap))


def likely_kinds(series: Series, r: Array, starts: Array, scores: Array) -> Kinds:
    """The kinds of noise that explain residuals r (N,) of least squares.

    These are less what `starts` (N, 2n), piece by piece, and `scores` (N, k) explain.
    """
    blocks = np.column_stack([starts, scores, r])
    between = np.median(series.gap[np.isfinite(series.gap)])
    times = np.geomspace(GRID.shortest * between, GRID.longest * series.durations.max(), GRID.times)
    ratios = np.geomspace(GRID.least, GRID.most, GRID.ratios)
    rough = _compare(series, blocks, starts.shape[1], times, ratios)
    times, ratios = _narrow(times, rough.times), _narrow(ratios, rough.ratios)
    return _compare(series, blocks, starts.shape[1], times, ratios)


def _compare(series: Series, blocks: Array, count: int, times: Array, ratios: Array) -> Kinds:
    """Those of all pairs of times and ratios that are likely."""
    times, ratios = (x.reshape(-1) for x in np.meshgrid(times, ratios))
    filters = zip(*_filters(series, times, ratios / (1 + ratios)), strict=True)
    logs, variances = np.array([_likelihood(series, *kind, blocks, count) for kind in filters]).T
    likelihood = np.exp(logs - logs.max())
    some = likelihood > GRID.unlikely
    weights = likelihood[some] / likelihood[some].sum()
    return Kinds(times[some], ratios[some], variances[some], weights)


def _narrow(tried: Array, likely: Array) -> Array:
    """As many values as were tried, from below the least of the likely ones to above the largest."""
    low, high = (int(np.argmin(np.abs(tried - x))) for x in (likely.min(), likely.max()))
    return np.geomspace(tried[max(low - 1, 0)], tried[min(high + 1, len(tried) - 1)], len(tried))


def _filters(series: Series, times: Array, shares: Array) -> tuple[Array, Array, Array]:
    """Decays, gains, and variances of what is new in each sample (T, N), of T kinds of noise of variance 1.

    The filter of R. Kalman (1960) for slow noise seen through white noise.
    """
    firsts = series.firsts
    lengths = np.diff(firsts, append=len(series.gap))
    decay = np.exp(-series.gap / times[:, None])
    fresh = -np.expm1(-2 * series.gap / times[:, None]) * shares[:, None]
    gain, new = np.empty_like(decay), np.empty_like(decay)
    left = np.zeros((len(times), len(firsts)))  # variance of the slow part, as known after the sample before
    for place in range(lengths.max()):
        some = lengths > place
        at = firsts[some] + place
        slow = decay[:, at] ** 2 * left[:, some] + fresh[:, at]
        new[:, at] = slow + (1 - shares[:, None])
        gain[:, at] = slow / new[:, at]
        left[:, some] = slow * (1 - gain[:, at])
    return decay, gain, new


def _likelihood(
    series: Series, decay: Array, gain: Array, new: Array, blocks: Array, count: int
) -> tuple[float, float]:
    """The logarithm of the restricted likelihood of a kind of noise by its filter (N,), and its variance.

    blocks (N, count + k + 1): derivatives by the starts of a piece and by the unknowns, and the residuals.
    """
    rows, rest, log_size = _whiten(blocks, decay, gain, new), 0.0, 0.0
    for block in np.split(rows, series.edges):
        products = np.einsum("ni,nj->ij", block, block)  # not @: threads of BLAS cost more than they save here
        left, size = _project(products, count)
        rest, log_size = rest + left, log_size + size
    left, size = _project(np.asarray(rest), blocks.shape[1] - count - 1)
    freedom = degrees_of_freedom(series, blocks.shape[1] - 1, count)
    variance = max(left[0, 0] / freedom, TINY)
    return -0.5 * (freedom * np.log(variance) + np.log(new).sum()) - log_size - size, variance


def _project(products: Array, count: int) -> tuple[Array, float]:
    """Products (K, K) of columns less what the first `count` of them explain, and the logarithm of the volume of these."""
    first, mixed = products[:count, :count], products[:count, count:]
    sizes, axes = np.linalg.eigh(first)
    sizes = np.maximum(sizes, RANK * sizes.max(initial=TINY))
    along = (axes.T @ mixed) / np.sqrt(sizes)[:, None]
    return products[count:, count:] - along.T @ along, 0.5 * float(np.log(sizes).sum())


def degrees_of_freedom(series: Series, unknowns: int, starts: int) -> int:
    """Those that residuals keep; `unknowns` counts those of one piece, `starts` of them its own."""
    return len(series.gap) - starts * (len(series.edges) + 1) - (unknowns - starts)


def _whiten(x: Array, decay: Array, gain: Array, new: Array) -> Array:
    """Rows (N, K) less what those before say of them, over the root of the variance that is left."""
    gain = np.roll(gain, 1)  # of the sample before; at the first of a series decay is 0
    bands = np.array([np.ones(len(x)), np.append(-(decay * (1 - gain))[1:], 0.0)])
    before = np.vstack([np.zeros_like(x[:1]), (decay * gain)[1:, None] * x[:-1]])
    return (x - solve_banded((1, 0), bands, before)) / np.sqrt(new)[:, None]


def innovations(series: Series, kinds: Kinds, r: Array) -> Array:
    """What is new in each residual (N,), by the likeliest kind of noise: white if that kind explains them."""
    best = int(np.argmax(kinds.weights))
    share = kinds.ratios[best] / (1 + kinds.ratios[best])
    decay, gain, new = _filters(series, kinds.times[best : best + 1], np.array([share]))
    return _whiten(r[:, None], decay[0], gain[0], new[0])[:, 0]


def sum_covariance(series: Series, kinds: Kinds, scores: Array) -> Array:
    """The covariance (k, k) of the sum of noise times scores (N, k)."""
    white, total = scores.T @ scores, 0.0
    for time, ratio, variance, weight in zip(*kinds, strict=True):
        share = ratio / (1 + ratio)
        decay, left = np.exp(-series.gap / time), np.sqrt(-np.expm1(-2 * series.gap / time))
        bands = np.array([np.append(0.0, -(decay / left)[1:]), 1 / left])
        root = solve_banded((0, 1), bands, scores)
        total = total + weight * variance * ((1 - share) * white + share * root.T @ root)
    return np.asarray(total)
