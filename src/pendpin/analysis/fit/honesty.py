"""What the data can tell: directions they determine, standard errors that hold for correlated residuals, whiteness."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from pendpin.analysis.fit.data import Swing
from pendpin.arrays import Array

RANK = 1e-5  # of the largest singular value, unknowns in natural scales: less is rounding
TOO_WIDE = 30.0  # natural scales, 30 % of the accelerations: a number with such a standard error is not determined
ALONG = 3e-5  # of a number's gradient that may lie in directions that the data do not see
FEWEST_SWINGS = 8  # for errors from the scatter of swings
WHITE = 1e-4  # level of the test of whiteness
OUTLYING = 0.05  # of the spread of a column
NOISY = 1.5  # times the noise: larger residuals are no noise


@dataclass(frozen=True, eq=False)
class Certainty:
    """What is known of the unknowns x (nx,)."""

    covariance: Array  # (nx, nx), of what is determined, correlations of the residuals being counted
    null: Array  # (nx, k) directions that the data do not determine, in natural scales
    scale: Array  # (nx,)
    inflation: float  # the largest ratio of these standard errors to those of uncorrelated residuals

    def determined(self, gradient: Array) -> bool:
        """Whether a number with this gradient by the unknowns (nx,) is determined by the data.

        It has no part in a direction that they do not see, and an error that is small against what it can do.
        """
        g = gradient * self.scale
        size = np.linalg.norm(g)
        seen = np.linalg.norm(self.null.T @ g) <= ALONG * size
        return bool(size > 0 and seen and self.error(gradient) <= TOO_WIDE * size)

    def error(self, gradient: Array) -> float:
        """Its standard error, in its unit; gradient (nx,)."""
        return float(np.sqrt(max(gradient @ self.covariance @ gradient, 0.0)))


def certainty(r: Array, J: Array, scale: Array, swing: Array, unknown_starts: int) -> Certainty:
    """From residuals r (P, M, columns) and derivatives J (P, M, columns, nx), both less what the starts explain.

    `swing` (P,) says which swing a piece is of. The covariance is a sandwich: scores are summed with their
    autocovariances up to a few correlation times (W. Newey, K. West, Econometrica 55 (1987), 703), and over whole
    swings where there are enough of them; it is never below that of uncorrelated residuals.
    """
    nx = len(scale)
    rows = (J * scale).reshape(-1, nx)
    _, s, Vt = np.linalg.svd(rows, full_matrices=False)
    used = int((r != 0).sum())
    sigma = np.sqrt((r**2).sum() / max(used - nx - unknown_starts, 1))
    sure = s > RANK * s.max(initial=0.0)
    spread = np.divide(1.0, s, out=np.full_like(s, np.inf), where=sure)
    V = Vt[sure].T * spread[sure]  # (nx, k): unit information in the kept directions
    scores = ((J * scale) @ V * r[..., None]).sum(2)  # (P, M, k)
    meat = [sigma**2 * np.eye(V.shape[1]), _lagged(scores, _memory(r))]
    if swing.max(initial=0) + 1 >= FEWEST_SWINGS:
        sums = np.array([scores[swing == k].sum((0, 1)) for k in range(swing.max() + 1)])
        meat.append(sums.T @ sums * len(sums) / (len(sums) - 1))
    covariances = [V @ m @ V.T for m in meat]
    variances = np.array([np.diag(c) for c in covariances])
    growth = np.sqrt(np.maximum(variances.max(0) / np.maximum(variances[0], 1e-300), 1.0))
    grown = covariances[0] * np.outer(growth, growth)
    return Certainty(grown * np.outer(scale, scale), Vt[~sure].T, scale, float(growth.max(initial=1.0)))


def _memory(r: Array) -> int:
    """Over how many samples residuals (P, M, columns) remember: four correlation times."""
    rho = autocorrelation(r, r.shape[1] // 2)
    ends = np.flatnonzero(rho < 0.05)
    first = int(ends[0]) if len(ends) else len(rho)
    return min(int(np.ceil(4 * (0.5 + rho[1:first].sum()))) if first > 1 else 0, r.shape[1] // 2)


def autocorrelation(r: Array, most: int) -> Array:
    """The autocorrelation of residuals (P, M, columns) at lags 0 to `most`, pieces and columns pooled."""
    M = r.shape[1]
    size = 2 ** int(np.ceil(np.log2(2 * M)))
    power = (np.abs(np.fft.rfft(r, size, axis=1)) ** 2).sum((0, 2))
    found = np.fft.irfft(power, size)[: min(most, M - 1) + 1]
    return found / found[0] if found[0] > 0 else np.eye(1, len(found))[0]


def _lagged(scores: Array, memory: int) -> Array:
    """The long-run covariance (k, k) of scores (P, M, k), Bartlett's weights up to a lag."""
    total = np.einsum("pmk,pml->kl", scores, scores)
    for lag in range(1, memory + 1):
        one = np.einsum("pmk,pml->kl", scores[:, lag:], scores[:, :-lag])
        total += (1 - lag / (memory + 1)) * (one + one.T)
    return total


def sensor_noise(swings: Sequence[Swing]) -> Array:
    """The noise of each column (columns,), from sixth differences of samples, in which a slow motion leaves nothing."""
    found = []
    for k in range(swings[0].y.shape[1]):
        series = (s.y[~np.isnan(s.y[:, k]), k] for s in swings)
        differences = [np.abs(np.diff(y, 6)) / np.sqrt(924) for y in series if len(y) > 6]
        pooled = np.concatenate(differences) if differences else np.zeros(1)
        found.append(1.4826 * np.median(pooled))
    return np.array(found)


def outliers(residuals: Sequence[Swing], spread: Array) -> list[tuple[float, Swing, int, int]]:
    """Samples off the median of their neighbours' residuals by far: by how much, swing, sample, column; the farthest first.

    By ten times the usual such difference and by OUTLYING of the spread (columns,): what a model misses is smooth.
    """
    found = []
    for column, width in enumerate(spread):
        off = [(swing, _off_neighbours(swing.y[:, column])) for swing in residuals]
        usual = 1.4826 * np.median(np.concatenate([d for _, d in off]))
        far = ((swing, d, np.flatnonzero(d > max(10 * usual, OUTLYING * width))) for swing, d in off)
        found += [(float(d[i]), swing, int(i), column) for swing, d, where in far for i in where]
    return sorted(found, key=lambda one: -one[0])


def _off_neighbours(y: Array) -> Array:
    """How far each of some values (m,) is from the median of the seven around it; 0 where there is none."""
    off, seen = np.zeros(len(y)), ~np.isnan(y)
    if seen.any():
        around = np.lib.stride_tricks.sliding_window_view(np.pad(y[seen], 3, mode="edge"), 7)
        off[seen] = np.abs(y[seen] - np.median(around, axis=1))
    return off


def whiteness(r: Array) -> float:
    """The probability of so much autocorrelation in white residuals (P, M, columns).

    G. Ljung, G. Box, Biometrika 65 (1978), 297.
    """
    n = int((r != 0).sum())
    lags = min(20, r.shape[1] // 5)
    if n < 10 or lags < 1:
        return 1.0
    rho = autocorrelation(r, lags)[1:]
    return float(chdtrc(len(rho), n * (n + 2) * (rho**2 / (n - np.arange(1, len(rho) + 1))).sum()))
