"""What the data can tell: directions they determine, standard errors that hold for correlated residuals, whiteness."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc, chdtri, ndtr, stdtrit

from pendpin.fitting.correlated_noise import degrees_of_freedom, innovations, likely_kinds, series_of, sum_covariance
from pendpin.fitting.data import Swing
from pendpin.fitting.parameters import Free, replace_unchecked, substitute
from pendpin.ground.arrays import Array, Mask
from pendpin.scene import Chain, Scene

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


def certainty(r: Array, J: Array, starts: Array, scale: Array, swing: Array, t: Array, seen: Mask) -> Certainty:
    """From residuals r (P, M, columns) and derivatives J (P, M, columns, nx), both less what the starts explain.

    starts (P, M, columns, 2n) is a basis of what they explain, `swing` (P,) says which swing a piece is of, t (M, P) in s
    and `seen` (P, M, columns) when and where there was a sample. Variances: correlated_noise.py.
    A model that is wrong in every swing shows in scores summed with their autocovariances up to a few correlation times
    (W. Newey, K. West, Econometrica 55 (1987), 703), and in the scatter of swings where there are enough: these count where
    they are larger than chance makes them. Two standard errors hold 95 % with few samples too (Student).
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
        kinds = likely_kinds(series, series.take(r), series.take(starts), series.take(unit))
        meat, time = sum_covariance(series, kinds, series.take(unit)), kinds.time
        new[series.rows] = innovations(series, kinds, series.take(r))
    others = [(summed_covariance(scores, lags), BARTLETT * len(series.gap) / (lags + 1))]
    if (many := int(swing.max(initial=0)) + 1) >= FEWEST_SWINGS:
        sums = np.array([scores[swing == k].sum((0, 1)) for k in range(many)])
        others.append((sums.T @ sums * many / (many - 1), many - 1))
    base, variance = (_variances(V, m) for m in (white, meat))
    largest = np.maximum(base, variance)
    for m, its_freedom in others:
        other = _variances(V, m)
        by_chance = variance * chdtri(its_freedom, CHANCE) / its_freedom
        largest = np.where(other > by_chance, np.maximum(largest, other), largest)
    growth = np.sqrt(largest / np.maximum(base, 1e-300))
    growth = np.maximum(growth, 1.0) * stdtrit(max(freedom, 1), 0.975) / stdtrit(np.inf, 0.975)
    grown = V @ white @ V.T * np.outer(scale * growth, scale * growth)
    return Certainty(grown, Vt[~sure].T, scale, float(growth.max(initial=1.0)), time, duration, new)


def _variances(V: Array, meat: Array) -> Array:
    """The variances (nx,) of unknowns from the covariance (k, k) of sums of scores, and their basis V (nx, k)."""
    return np.einsum("xk,kl,xl->x", V, meat, V)


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
    """The noise of each column (columns,), from sixth differences of samples, in which a slow motion leaves nothing."""
    noise = []
    for k in range(swings[0].y.shape[1]):
        series = (s.y[~np.isnan(s.y[:, k]), k] for s in swings)
        differences = [np.abs(np.diff(y, 6)) / np.sqrt(924) for y in series if len(y) > 6]
        pooled = np.concatenate(differences) if differences else np.zeros(1)
        noise.append(1.4826 * np.median(pooled))
    return np.array(noise)


def outliers(residuals: Sequence[Swing], spread: Array) -> list[tuple[float, Swing, int, int]]:
    """Samples off the median of their neighbours' residuals by far: by how much, swing, sample, column; the farthest first.

    By ten times the usual such difference and by OUTLYING of the spread (columns,): what a model misses is smooth.
    """
    outlying = []
    for column, width in enumerate(spread):
        off = [(swing, _off_neighbours(swing.y[:, column])) for swing in residuals]
        usual = 1.4826 * np.median(np.concatenate([d for _, d in off]))
        far = ((swing, d, np.flatnonzero(d > max(10 * usual, OUTLYING * width))) for swing, d in off)
        outlying += [(float(d[i]), swing, int(i), column) for swing, d, where in far for i in where]
    return sorted(outlying, key=lambda sample: -sample[0])


def _off_neighbours(y: Array) -> Array:
    """How far each of some values (m,) is from the median of the seven around it; 0 where there is none."""
    off, seen = np.zeros(len(y)), ~np.isnan(y)
    if seen.any():
        around = np.lib.stride_tricks.sliding_window_view(np.pad(y[seen], 3, mode="edge"), 7)
        off[seen] = np.abs(y[seen] - np.median(around, axis=1))
    return off


def whiteness(r: Array, most: int = 20) -> float:
    """The probability of so much autocorrelation, over `most` samples, in white residuals (P, M, columns).

    G. Ljung, G. Box, Biometrika 65 (1978), 297.
    """
    n = int((r != 0).sum())
    lags = min(most, r.shape[1] // 5)
    if n < 10 or lags < 1:
        return 1.0
    rho = autocorrelation(r, lags)[1:]
    return float(chdtrc(len(rho), n * (n + 2) * (rho**2 / (n - np.arange(1, len(rho) + 1))).sum()))


# --- robust fits: P. Huber's weights, the size of residuals without their outliers, and what errors are computed from ---


def huber_weights(r: Array) -> Array:
    """By what residuals r, in standard deviations, are multiplied before they are squared."""
    return np.sqrt(np.minimum(1.0, CORNER / np.maximum(np.abs(r), 1e-300)))


def huber_scale(r: Array, seen: Mask, axis: int | tuple[int, ...]) -> Array:
    """The standard deviation of residuals without their outliers: Huber's proposal 2; 0 where nothing was seen.

    It is that of a normal distribution where the squares, clipped at CORNER standard deviations, have their mean.
    """
    squares, count = np.where(seen, r, 0.0) ** 2, np.maximum(seen.sum(axis, keepdims=True), 1)
    variance = squares.sum(axis, keepdims=True) / count
    for _ in range(STEPS):
        variance = np.minimum(squares, CORNER**2 * variance).sum(axis, keepdims=True) / (BETA * count)
    return np.sqrt(np.squeeze(variance, axis))


def pseudo_residuals(r: Array, seen: Mask) -> Array:
    """What ordinary least squares would have to leave over, to give the numbers and errors of the robust fit.

    Clipped residuals over the part that is not clipped (J. Street, R. Carroll, D. Ruppert, Am. Stat. 42 (1988), 152).
    r is in standard deviations, and 0 where nothing was seen.
    """
    whole = np.mean(np.abs(r[seen]) <= CORNER)
    return np.clip(r, -CORNER, CORNER) / max(float(whole), 0.5)


# --- what free swings tell where they do not tell the numbers themselves: ratios to the first moment of the last rod ---


class Combination(NamedTuple):
    """A determined function of free numbers that are not determined themselves."""

    name: str
    value: float
    error: float | None  # standard error; None where the fit gives none
    unit: str

    def __str__(self) -> str:
        error = "" if self.error is None else f" +- {self.error:.2g}"
        return f"{self.name} = {self.value:.6g}{error} {self.unit}".rstrip()


def combinations(scene: Scene, free: Free, z: Array, certainty: Certainty, unsure: set[str]) -> tuple[Combination, ...]:
    """The ratios of a chain that the data determine, of those that hold an undetermined number; z (nz,).

    They have errors if the data are long enough.
    """
    if not isinstance(scene.model, Chain) or not scene.model.tip_to_tip or not unsure:
        return ()
    determined = []
    for name, unit, function in _ratios(scene, free, unsure):
        values = free.values(z)
        gradient = np.zeros(len(certainty.scale))
        steps = np.diag(1e-6 * np.where(values != 0, np.abs(values), 1.0))  # of central differences
        slopes = np.array([(function(values + d) - function(values - d)) / (2 * d.sum()) for d in steps])
        gradient[: len(z)] = slopes @ free.gradients(z)
        if certainty.determined(gradient):
            error = certainty.error(gradient) if certainty.enough else None
            determined.append(Combination(name, float(function(values)), error, unit))
    return tuple(determined)


def _ratios(scene: Scene, free: Free, unsure: set[str]) -> list[tuple[str, str, Callable[[Array], float]]]:
    """Name, unit and function of the K free numbers (K,), of each ratio that holds an undetermined number."""
    moments = lambda values: _moments(substitute(scene, free.keys, list(values), replace_unchecked))  # noqa: E731
    assert isinstance(scene.model, Chain)
    last = scene.model.count - 1
    ratios: list[tuple[str, str, Callable[[Array], float]]] = []
    for i in range(last + 1):
        of = f"rod {i + 1}" + " with all below" * (i < last)
        about, first = f"inertia of {of} about its joint", f"first moment of {of}"
        ratios.append((f"{about} / {first}", "m", lambda v, i=i: moments(v)[0][i] / moments(v)[1][i]))
        if i < last:
            ratio = f"{first} / first moment of rod {last + 1}"
            ratios.append((ratio, "", lambda v, i=i: moments(v)[1][i] / moments(v)[1][last]))
    for row, key in enumerate(free.keys):
        if key.startswith("effects") and key in unsure:
            name = f"{key} / first moment of rod {last + 1}"
            ratios.append((name, "", lambda v, row=row: v[row] / moments(v)[1][last]))
    return ratios


def _moments(scene: Scene) -> tuple[Array, Array]:
    """Each rod's inertia about its joint (kg m²) and first moment (kg m), with the masses that hang on its tip."""
    assert isinstance(scene.model, Chain)
    rods = scene.model.all_rods
    below, inertia, first = 0.0, [], []
    for rod in reversed(rods):
        m, h, I1, _, _ = rod.properties
        inertia.append(I1 + m * h * h + below * rod.length**2)
        first.append(m * h + below * rod.length)
        below += m
    return np.array(inertia[::-1]), np.array(first[::-1])
