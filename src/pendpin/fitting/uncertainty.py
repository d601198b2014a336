"""What the data can tell: directions they determine, standard errors that hold for correlated residuals, whiteness.

Residuals are white noise beside noise whose correlation decays with time. Starts and unknowns take up part of the noise, and
most of it where it is slow, so that residuals look shorter in memory than the noise was: with ten correlation times in the
data the usual errors are half of the true ones. The restricted likelihood (H. Patterson, R. Thompson, Biometrika 58 (1971),
545) counts what was taken up. It is evaluated for many kinds of noise, and variances are averaged over these, because few
data do not tell one kind from its neighbours. benchmarks/fit_coverage.py shows what the bounds are good for.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc, chdtri, ndtr, stdtrit

from pendpin.fitting.data import Swing
from pendpin.ground.arrays import Array, Mask, lapack

# Standard deviations, from where on residuals count less: 95 % efficient (Huber, Robust Statistics, 1981).
CORNER = 1.345
BETA = 1 - 2 * ndtr(-CORNER) * (1 - CORNER**2) - 2 * CORNER * np.exp(-(CORNER**2) / 2) / np.sqrt(2 * np.pi)
STEPS = 40  # of the scale; each leaves less than half of the error where noise is normal
RANK = 1e-5  # of the largest singular value, unknowns in natural scales: less is rounding
TOO_WIDE = 30.0  # natural scales, 30 % of the accelerations: a number with such a standard error is not determined
ALONG = 3e-5  # of a number's gradient that may lie in directions that the data do not see
FEWEST_SWINGS = 8  # for errors from the scatter of swings
FEWEST_TIMES = 3.0  # correlation times to either side: with fewer, 95 % intervals hold 91 to 99 % (fit_coverage.py)
BARTLETT = 1.5  # degrees of freedom, times samples over lags, of a sum with Bartlett's weights (P. Bloomfield, 1976)
CHANCE = 0.01  # how often a scatter of noise alone is counted
WHITE = 1e-4  # level of the test of whiteness
OUTLYING = 0.05  # of the spread of a column
NOISY = 1.5  # times the noise: larger residuals are no noise
TIMES, RATIOS = 12, 9  # kinds of noise tried, twice: over the whole range, then where the likelihood is
SHORTEST = 0.2  # correlation time, of the time between two samples: these are then uncorrelated but for 0.7 %
LONGEST = 1.0  # of the longest series: slower noise looks like a drift
LEAST, MOST = 1e-3, 1e4  # variance of slow noise over that of white noise: as good as none of either
UNLIKELY = 1e-3  # of the largest likelihood: such a kind adds nothing
TINY = 1e-300
ROUNDING = 1e-14  # of the largest eigenvalue of products of columns: less is rounding


@dataclass(frozen=True, eq=False)
class Certainty:
    """What is known of the unknowns x (nx,)."""

    covariance: Array  # (nx, nx), of what is determined, correlations of the residuals being counted
    null: Array  # (nx, k) directions that the data do not determine, in natural scales
    scale: Array  # (nx,)
    inflation: float  # the largest ratio of these standard errors to those of uncorrelated residuals
    memory: float  # s, the typical correlation time of the residuals
    duration: float  # s, of all swings together
    new: Array  # (P, M, columns) what is new in each residual, if they are noise with such a memory

    @property
    def enough(self) -> bool:
        """Whether the data last long enough against the memory of the residuals for standard errors."""
        return self.duration >= 2 * FEWEST_TIMES * self.memory

    def determined(self, gradient: Array) -> bool:
        """Whether the data determine a number with this gradient (nx,): they see it, and its error is small."""
        g = gradient * self.scale
        size = np.linalg.norm(g)
        seen = np.linalg.norm(self.null.T @ g) <= ALONG * size
        return bool(size > 0 and seen and self.error(gradient) <= TOO_WIDE * size)

    def error(self, gradient: Array) -> float:
        """Its standard error, in its unit; gradient (nx,)."""
        return float(np.sqrt(max(gradient @ self.covariance @ gradient, 0.0)))


def certainty(r: Array, J: Array, starts: Array, scale: Array, swing: Array, t: Array, seen: Mask) -> Certainty:
    """From residuals r (P, M, columns) and derivatives J (P, M, columns, nx), both less what the starts explain.

    starts (P, M, columns, 2n) is a basis of what they explain, `swing` (P,) says which swing a piece is of, t (M, P) in s
    and `seen` (P, M, columns) when and where there was a sample. Two standard errors hold 95 % of few samples too (Student).
    """
    nx, columns = len(scale), starts.shape[-1]
    rows = (J * scale).reshape(-1, nx)
    _, s, Vt = np.linalg.svd(rows, full_matrices=False)
    sure = s > RANK * s.max(initial=0.0)
    spread = np.divide(1.0, s, out=np.full_like(s, np.inf), where=sure)
    V = Vt[sure].T * spread[sure]  # (nx, k): unit information in the directions that are determined
    unit = (J * scale) @ V  # (P, M, columns, k)
    scores = (unit * r[..., None]).sum(2)  # (P, M, k)
    series = series_of(t, seen)
    freedom = degrees_of_freedom(series, columns + V.shape[1], columns)
    sigma2 = (r**2).sum() / max(freedom, 1)
    duration = float((t[-1] - t[0]).sum())
    lags, white = memory_lags(r), sigma2 * np.eye(V.shape[1])
    meat, time, new = white, duration, np.zeros_like(r)
    if freedom > 0:
        parts = [x[series.rows] for x in (r, starts, unit)]
        kinds = likely_kinds(series, *parts)
        meat, time = sum_covariance(series, kinds, parts[-1]), kinds.time
        best = int(np.argmax(kinds.weights))  # by the likeliest kind: white if that explains the residuals
        share = kinds.ratios[best] / (1 + kinds.ratios[best])
        decay, gain, fresh = (x[0] for x in _filters(series, kinds.times[best : best + 1], np.array([share])))
        new[series.rows] = _whiten(parts[0][:, None], decay, gain, fresh)[:, 0]
    # A model that is wrong in every swing shows in scores summed with their autocovariances up to a few correlation times
    # (W. Newey, K. West, Econometrica 55 (1987), 703), and in the scatter of swings where there are enough: these count
    # where they are larger than chance makes them.
    others = [(summed_covariance(scores, lags), BARTLETT * len(series.gap) / (lags + 1))]
    if (many := int(swing.max(initial=0)) + 1) >= FEWEST_SWINGS:
        sums = np.array([scores[swing == k].sum((0, 1)) for k in range(many)])
        others.append((sums.T @ sums * many / (many - 1), many - 1))

    def variances(meat: Array) -> Array:  # of the unknowns (nx,) from the covariance (k, k) of sums of scores
        return np.einsum("xk,kl,xl->x", V, meat, V)

    base, variance = variances(white), variances(meat)
    largest = np.maximum(base, variance)
    for m, its_freedom in others:
        other = variances(m)
        by_chance = variance * chdtri(its_freedom, CHANCE) / its_freedom
        largest = np.where(other > by_chance, np.maximum(largest, other), largest)
    growth = np.sqrt(largest / np.maximum(base, 1e-300))
    growth = np.maximum(growth, 1.0) * stdtrit(max(freedom, 1), 0.975) / stdtrit(np.inf, 0.975)
    grown = V @ white @ V.T * np.outer(scale * growth, scale * growth)
    return Certainty(grown, Vt[~sure].T, scale, float(growth.max(initial=1.0)), time, duration, new)


# --- the memory of residuals ----------------------------------------------------------------------------------------


class Series(NamedTuple):
    """N residuals one after the other: by piece, then by column, then by time."""

    rows: tuple[Array, Array, Array]  # each (N,): piece, sample and column of each
    gap: Array  # (N,) s since the one before; infinite at the first of a piece and column
    firsts: Array  # (S,) the residuals at which a piece and column begins
    edges: Array  # (P - 1,) those at which a piece begins, but for the first


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
    edges = np.flatnonzero(np.diff(piece)) + 1
    return Series((piece, sample, column), np.where(first, np.inf, gap), np.flatnonzero(first), edges)


def likely_kinds(series: Series, r: Array, starts: Array, scores: Array) -> Kinds:
    """The kinds of noise that explain residuals r (N,), less what `starts` (N, 2n) and `scores` (N, k) explain."""
    blocks, between = np.column_stack([starts, scores, r]), np.median(series.gap[np.isfinite(series.gap)])
    durations = np.add.reduceat(np.where(np.isinf(series.gap), 0.0, series.gap), series.firsts)  # of the S series, s
    times = np.geomspace(SHORTEST * between, LONGEST * durations.max(), TIMES)
    ratios = np.geomspace(LEAST, MOST, RATIOS)

    def compare() -> Kinds:  # those of all pairs of times and ratios that are likely
        pairs = [x.reshape(-1) for x in np.meshgrid(times, ratios)]
        filters = zip(*_filters(series, pairs[0], pairs[1] / (1 + pairs[1])), strict=True)
        logs, variances = np.array([_likelihood(series, *kind, blocks, starts.shape[1]) for kind in filters]).T
        likelihood = np.exp(logs - logs.max())
        some = likelihood > UNLIKELY
        return Kinds(pairs[0][some], pairs[1][some], variances[some], likelihood[some] / likelihood[some].sum())

    def narrow(tried: Array, likely: Array) -> Array:  # as many, from below the least likely to above the largest
        low, high = (int(np.argmin(np.abs(tried - x))) for x in (likely.min(), likely.max()))
        return np.geomspace(tried[max(low - 1, 0)], tried[min(high + 1, len(tried) - 1)], len(tried))

    rough = compare()
    times, ratios = narrow(times, rough.times), narrow(ratios, rough.ratios)
    return compare()


def _filters(series: Series, times: Array, shares: Array) -> tuple[Array, Array, Array]:
    """Decays, gains and variances of what is new in each sample (T, N), of T kinds of noise: R. Kalman's filter (1960)."""
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
    """The logarithm of the restricted likelihood of a kind of noise by its filter (N,), and its variance."""
    pieces = np.split(_whiten(blocks, decay, gain, new), series.edges)
    # not @: threads of BLAS cost more than they save here
    rest, log_size = _project(np.array([np.einsum("ni,nj->ij", rows, rows) for rows in pieces]), count)
    left, size = _project(rest.sum(0), blocks.shape[1] - count - 1)
    freedom = degrees_of_freedom(series, blocks.shape[1] - 1, count)
    variance = max(left[0, 0] / freedom, TINY)
    return -0.5 * (freedom * np.log(variance) + np.log(new).sum()) - log_size - size, variance


def _project(products: Array, count: int) -> tuple[Array, float]:
    """Products (..., K, K) of columns less what the first `count` of them explain, and the logarithm of their volume."""
    sizes, axes = np.linalg.eigh(products[..., :count, :count])
    sizes = np.maximum(sizes, ROUNDING * sizes.max(-1, keepdims=True, initial=TINY))
    along = (axes.swapaxes(-1, -2) @ products[..., :count, count:]) / np.sqrt(sizes)[..., None]
    return products[..., count:, count:] - along.swapaxes(-1, -2) @ along, 0.5 * float(np.log(sizes).sum())


def degrees_of_freedom(series: Series, unknowns: int, starts: int) -> int:
    """Those that residuals keep; `unknowns` counts those of one piece, `starts` of them its own."""
    return len(series.gap) - starts * (len(series.edges) + 1) - (unknowns - starts)


def _whiten(x: Array, decay: Array, gain: Array, new: Array) -> Array:
    """Rows (N, K) less what those before say of them, over the root of the variance that is left."""
    decay, gain = decay[1:], gain[:-1]  # the gain of the sample before; at the first of a series decay is 0
    bands = np.array([np.ones(len(x)), np.append(-(decay * (1 - gain)), 0.0)])
    before = np.vstack([np.zeros_like(x[:1]), (decay * gain)[:, None] * x[:-1]])
    known, _ = lapack("tbtrs")(bands, before, uplo="L", diag="U")  # SciPy's solve_banded takes three times as long
    return (x - known) / np.sqrt(new)[:, None]


def sum_covariance(series: Series, kinds: Kinds, scores: Array) -> Array:
    """The covariance (k, k) of the sum of noise times scores (N, k)."""
    white, total = scores.T @ scores, np.zeros((scores.shape[1], scores.shape[1]))
    for time, ratio, variance, weight in zip(*kinds, strict=True):
        share = ratio / (1 + ratio)
        decay, left = np.exp(-series.gap / time), np.sqrt(-np.expm1(-2 * series.gap / time))
        bands = np.array([np.append(0.0, -(decay / left)[1:]), 1 / left])
        # without scores, SciPy's tbtrs would take one column and write behind it
        root = lapack("tbtrs")(bands, scores, uplo="U")[0] if scores.size else scores
        total += weight * variance * ((1 - share) * white + share * root.T @ root)
    return total


def memory_lags(r: Array) -> int:
    """Over how many samples residuals (P, M, columns) remember: four correlation times, of rho^k 2 (1 + rho) / (1 - rho)."""
    time = correlation_time(r)
    return min(int(np.ceil(4 * time)) if time > 0.5 else 0, r.shape[1] // 2)


def correlation_time(r: Array) -> float:
    """The correlation time of residuals (P, M, columns) in samples: 1/2 plus rho up to where it falls below 0.05."""
    rho = autocorrelation(r, r.shape[1] // 2)
    ends = np.flatnonzero(rho < 0.05)
    return 0.5 + float(rho[1 : ends[0] if len(ends) else None].sum())


def autocorrelation(r: Array, most: int) -> Array:
    """The autocorrelation of residuals (P, M, columns) at lags 0 to `most`, pieces and columns pooled."""
    M = r.shape[1]
    size = 2 ** int(np.ceil(np.log2(2 * M)))
    power = (np.abs(np.fft.rfft(r, size, axis=1)) ** 2).sum((0, 2))
    products = np.fft.irfft(power, size)[: min(most, M - 1) + 1]
    return products / products[0] if products[0] > 0 else np.eye(1, len(products))[0]


def summed_covariance(scores: Array, memory: int) -> Array:
    """The covariance (k, k) of the sum of scores (P, M, k): their autocovariances with Bartlett's weights up to a lag."""
    total = np.einsum("pmk,pml->kl", scores, scores)
    for lag in range(1, memory + 1):
        product = np.einsum("pmk,pml->kl", scores[:, lag:], scores[:, :-lag])
        total += (1 - lag / (memory + 1)) * (product + product.T)
    return total


def sensor_noise(swings: Sequence[Swing]) -> Array:
    """The noise of each column (columns,), from sixth differences of samples, in which a slow motion leaves nothing.

    They are divided differences, so that uneven times and gaps leave nothing in them either.
    """
    noise = []
    for k in range(swings[0].y.shape[1]):
        differences = []
        for t, y in ((s.t[seen], s.y[seen, k]) for s in swings if (seen := ~np.isnan(s.y[:, k])).sum() > 6):
            t, y = (np.lib.stride_tricks.sliding_window_view(x, 7).T for x in (t, y))  # (7, m - 6)
            weights = [1 / np.prod((t[i] - np.delete(t, i, 0)) / (t[6] - t[0]), 0) for i in range(7)]
            differences.append(np.abs(np.sum(weights * y, 0)) / np.linalg.norm(weights, axis=0))
        noise.append(1.4826 * np.median(np.concatenate(differences or [np.zeros(1)])))
    return np.array(noise)


def outliers(residuals: Sequence[Swing], spread: Array) -> list[tuple[float, Swing, int, int]]:
    """Samples far off the median of their neighbours' residuals, farthest first: by how much, swing, sample, column."""
    outlying = []
    for column, width in enumerate(spread):
        off = []
        for swing in residuals:
            y = swing.y[:, column]
            apart, seen = np.zeros(len(y)), np.isfinite(y)  # infinite where the model does not come
            if seen.any():  # from the median of the seven around it
                around = np.lib.stride_tricks.sliding_window_view(np.pad(y[seen], 3, mode="edge"), 7)
                apart[seen] = np.abs(y[seen] - np.median(around, axis=1))
            off.append(apart)
        usual = 1.4826 * np.median(np.concatenate(off))
        least = max(10 * usual, OUTLYING * width)
        far = ((swing, d, np.flatnonzero(d > least)) for swing, d in zip(residuals, off, strict=True))
        outlying += [(float(d[i]), swing, int(i), column) for swing, d, where in far for i in where]
    return sorted(outlying, key=lambda sample: -sample[0])


def whiteness(r: Array, most: int = 20) -> float:
    """The probability of so much autocorrelation in white residuals (P, M, columns): G. Ljung, G. Box (1978)."""
    n = int((r != 0).sum())
    lags = min(most, r.shape[1] // 5)
    if n < 10 or lags < 1:
        return 1.0
    rho = autocorrelation(r, lags)[1:]
    return float(chdtrc(len(rho), n * (n + 2) * (rho**2 / (n - np.arange(1, len(rho) + 1))).sum()))


# --- robust fits: P. Huber's weights, the size of residuals without their outliers, and what errors are computed from ---


def huber_scale(r: Array, seen: Mask, axis: int | tuple[int, ...] | None) -> Array:
    """The standard deviation of residuals without their outliers: Huber's proposal 2; 0 where nothing was seen."""
    squares, count = np.where(seen, r, 0.0) ** 2, np.maximum(seen.sum(axis, keepdims=True), 1)
    variance = squares.sum(axis, keepdims=True) / count
    for _ in range(STEPS):
        variance = np.minimum(squares, CORNER**2 * variance).sum(axis, keepdims=True) / (BETA * count)
    return np.sqrt(np.squeeze(variance, axis))


def pseudo_residuals(r: Array, seen: Mask) -> Array:
    """What least squares would leave over with a robust fit's numbers (J. Street et al., Am. Stat. 42 (1988), 152)."""
    whole = np.mean(np.abs(r[seen]) <= CORNER)
    return np.clip(r, -CORNER, CORNER) / max(float(whole), 0.5)
