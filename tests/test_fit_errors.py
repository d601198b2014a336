"""Standard errors of fits: exact parts, known series, coverage, and what is said of numbers that are not determined."""

import numpy as np
import pytest
from scipy.signal import lfilter

import pendpin as pp
from fit_scenes import ANGLE, scene_of, swings_of
from pendpin.effects import DryFriction, Viscous
from pendpin.fitting.data import Swing
from pendpin.fitting.parameters import Combination
from pendpin.fitting.uncertainty import (
    Certainty,
    Kinds,
    _filters,
    _likelihood,
    autocorrelation,
    certainty,
    huber_scale,
    likely_kinds,
    memory_lags,
    outliers,
    pseudo_residuals,
    sensor_noise,
    series_of,
    sum_covariance,
    summed_covariance,
    whiteness,
)


def remembering(rho: float, shape: tuple[int, ...], draw: np.random.Generator) -> np.ndarray:
    """Noise of variance 1 along the last axis, each sample remembering rho of the one before."""
    new = draw.normal(0, 1, shape)
    new[..., 1:] *= np.sqrt(1 - rho**2)
    return lfilter([1.0], [1.0, -rho], new, axis=-1)


# --- parts that are known exactly -----------------------------------------------------------------------------------


@pytest.mark.parametrize("rho", [0.5, 0.9, 0.98])
def test_memory_is_that_of_the_series(rho: float) -> None:
    """Four correlation times, the sum of all autocorrelations: 2 (1 + rho) / (1 - rho), but for the 5 % that are cut off."""
    r = remembering(rho, (20, 20_000), np.random.default_rng(0))[..., None]
    exact = 2 * (1 + rho) / (1 - rho)
    assert 0.9 * exact < memory_lags(r) <= exact + 1


def test_white_noise_has_no_memory() -> None:
    """Nor has a short series a longer one than half of itself."""
    draw = np.random.default_rng(0)
    assert memory_lags(draw.normal(0, 1, (20, 2_000, 1))) == 0
    assert memory_lags(np.ones((1, 40, 1))) == 20


def test_autocorrelation_is_the_mean_product() -> None:
    """Of pieces and columns pooled, against sums of products."""
    r = np.random.default_rng(0).normal(0, 1, (3, 50, 2)).cumsum(1)
    sums = np.array([(r[:, lag:] * r[:, : 50 - lag]).sum() for lag in range(20)])
    for unit in (1.0, 1e-9):  # rad, or nrad
        assert autocorrelation(unit * r, 19) == pytest.approx(sums / sums[0], abs=1e-12)
    assert autocorrelation(0 * r, 3).tolist() == [1, 0, 0, 0]


def test_summed_covariance_is_that_of_windows() -> None:
    """Autocovariances with Bartlett's weights up to lag L are the mean over all windows of L + 1 samples, zeros outside."""
    scores, L = np.random.default_rng(0).normal(0, 1, (2, 30, 3)).cumsum(1), 7
    padded = np.pad(scores, ((0, 0), (L, L), (0, 0)))
    sums = np.array([padded[:, i : i + L + 1].sum(1) for i in range(30 + L)])
    assert summed_covariance(scores, L) == pytest.approx(np.einsum("npk,npl->kl", sums, sums) / (L + 1), rel=1e-10)


def uneven(draw: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Times (M, P) of two pieces with two columns, uneven, and which samples there are (P, M, columns)."""
    return np.cumsum(draw.uniform(0.5, 2, (9, 2)), 0), draw.random((2, 9, 2)) > 0.2


@pytest.mark.parametrize(("time", "ratio"), [(2.3, 2.0), (0.4, 0.1), (30.0, 1e3)])
def test_likelihood_is_that_of_the_dense_covariance(time: float, ratio: float) -> None:
    """The filter and products piece by piece, against one dense matrix with all starts and unknowns; gaps, uneven times."""
    draw = np.random.default_rng(0)
    t, seen = uneven(draw)
    series, share = series_of(t, seen), ratio / (1 + ratio)
    (piece, sample, column), N = series.rows, len(series.gap)
    at = t[sample, piece]
    same = (piece[:, None] == piece) & (column[:, None] == column)
    dense = share * np.where(same, np.exp(-np.abs(at[:, None] - at) / time), 0.0) + (1 - share) * np.eye(N)
    starts, unknowns, r = draw.normal(size=(N, 2)), draw.normal(size=(N, 3)), draw.normal(size=N)
    columns = np.hstack([starts * (piece == 0)[:, None], starts * (piece == 1)[:, None], unknowns])
    inverse = np.linalg.inv(dense)
    size = columns.T @ inverse @ columns
    rest = r - columns @ np.linalg.solve(size, columns.T @ inverse @ r)
    variance = rest @ inverse @ rest / (N - 7)
    volume = np.linalg.slogdet(dense)[1] + np.linalg.slogdet(size)[1]
    kind = [x[0] for x in _filters(series, np.array([time]), np.array([share]))]
    logarithm, found = _likelihood(series, *kind, np.column_stack([starts, unknowns, r]), 2)
    assert found == pytest.approx(variance, rel=1e-10)
    assert logarithm == pytest.approx(-0.5 * ((N - 7) * np.log(variance) + volume), rel=1e-10)
    kinds = Kinds(*(np.array([x]) for x in (time, ratio, 1.5, 1.0)))
    assert sum_covariance(series, kinds, unknowns) == pytest.approx(1.5 * unknowns.T @ dense @ unknowns, rel=1e-10)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9, 0.98])
def test_the_variance_of_a_mean_is_in_closed_form(rho: float) -> None:
    """(1 + rho) / (1 - rho) over the number of samples; 80 correlation times tell it to a fifth, and doubt widens it."""
    draw, P, M = np.random.default_rng(0), 4, 2_000
    series = series_of(np.repeat(np.arange(M)[:, None], P, 1).astype(float), np.ones((P, M, 1), bool))
    r, ones = remembering(rho, (P, M), draw).reshape(-1), np.ones((P * M, 1)) / (P * M)
    kinds = likely_kinds(series, r - r.mean(), np.zeros((P * M, 0)), ones)
    assert 0.9 < sum_covariance(series, kinds, ones)[0, 0] / ((1 + rho) / (1 - rho) / (P * M)) < 1.4
    assert kinds.weights.sum() == pytest.approx(1, rel=1e-12)
    if rho:
        assert kinds.time == pytest.approx(-1 / np.log(rho), rel=0.25)


# --- errors and coverage --------------------------------------------------------------------------------------------


class Swings:
    """P pieces of M samples a second apart, whose starts explain a decaying oscillation each; numbers and a zero."""

    def __init__(self, P: int, M: int) -> None:
        t = np.arange(M) * 1.0
        wave, decay, P_, self.M = np.exp(0.4j * t), np.exp(-t / M), P, M
        phases = np.exp(2j * np.pi * np.random.default_rng(1).random(P))[:, None]
        start = np.stack([decay * wave.real, decay * wave.imag], -1)
        self.starts = np.repeat(np.linalg.qr(start)[0][None], P, 0)[:, :, None, :]
        drift = [(phases * t * decay * wave).real, (phases * t**2 * decay * wave).real, np.ones((P, M))]
        J = np.stack(drift, -1)[:, :, None, :]
        self.J = J - self.projected(J)
        self.t, self.seen, self.swing = np.repeat(t[:, None], P_, 1), np.ones((P, M, 1), bool), np.arange(P)

    def projected(self, x: np.ndarray) -> np.ndarray:
        """What the starts explain of x (P, M, 1, ...)."""
        Q = self.starts[:, :, 0]
        return (Q @ (Q.transpose(0, 2, 1) @ x[:, :, 0])).reshape(x.shape)

    def fitted(self, noise: np.ndarray, scale: np.ndarray | None = None) -> tuple[np.ndarray, Certainty]:
        """Least squares of noise (P, M): the errors of the three numbers, and what is said of them."""
        r = noise[:, :, None, None] - self.projected(noise[:, :, None, None])
        rows = self.J.reshape(-1, 3)
        x = -np.linalg.lstsq(rows, r.reshape(-1), rcond=None)[0]
        rest = (r.reshape(-1) + rows @ x).reshape(len(r), self.M, 1)
        scale = 1 / np.linalg.norm(rows, axis=0) if scale is None else scale
        return x, certainty(rest, self.J, self.starts, scale, self.swing, self.t, self.seen)


def test_errors_of_white_noise_are_those_of_least_squares() -> None:
    """sigma (J'J)^-1/2, to the 2 % that 5,000 samples tell, and up to 15 % for slow noise that they may hide."""
    swings = Swings(5, 1_000)
    _, known = swings.fitted(np.random.default_rng(0).normal(0, 3.0, (5, 1_000)))
    rows = swings.J.reshape(-1, 3)
    exact = 3.0 * np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))
    errors = [known.error(unit) for unit in np.eye(3)]
    assert (errors > 0.96 * exact).all()
    assert (errors < 1.15 * exact).all()
    assert known.inflation == pytest.approx(np.max(errors / exact), rel=0.05)
    _, other = swings.fitted(np.random.default_rng(0).normal(0, 3.0, (5, 1_000)), known.scale * [1, 2, 3])
    assert [other.error(unit) for unit in np.eye(3)] == pytest.approx(errors, rel=1e-6)
    assert known.duration == 5 * 999.0  # s, of all pieces


def coverage(rho: float, P: int, M: int, count: int) -> tuple[float, float, np.ndarray]:
    """The part of 95 % intervals that hold the truth, of all numbers, the least of a number, and which had errors."""
    swings, z, enough = Swings(P, M), [], []
    for case in range(count):
        x, known = swings.fitted(remembering(rho, (P, M), np.random.default_rng([case, round(100 * rho)])))
        z.append(np.abs(x) / [known.error(unit) for unit in np.eye(3)])
        enough.append(known.enough)
    good = np.array(z)[enough] < 1.96
    return good.mean(), good.mean(0).min(), np.array(enough)


@pytest.mark.slow
@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9, 0.98])
@pytest.mark.parametrize(("P", "M"), [(2, 400), (10, 400)])
def test_intervals_cover(rho: float, P: int, M: int) -> None:
    """Of 60 fits of three numbers: 95 % to two standard deviations of 180 draws, of each number to three of 60."""
    every, least, enough = coverage(rho, P, M, 60)
    assert 0.915 <= every <= 0.985
    assert least >= 0.87
    assert enough.mean() > 0.8


def test_slow_noise_in_few_data_is_seen() -> None:
    """Eight correlation times: residuals look white; errors from their own autocorrelation are 2 times too small."""
    every, _, enough = coverage(0.98, 2, 400, 12)
    assert every >= 0.9
    assert enough.mean() > 0.7


def test_numbers_that_differ_from_swing_to_swing_have_the_error_of_their_scatter() -> None:
    """Each of ten swings has numbers of its own: the error is that of a mean of ten, to 2.5 times the 24 % that ten tell."""
    swings, draw = Swings(10, 400), np.random.default_rng(0)
    own = draw.normal(0, 1, (10, 3)) * [1, 1e-3, 0]
    noise = (swings.J[:, :, 0] @ own[:, :, None])[..., 0] + 1e-3 * draw.normal(size=(10, 400))
    _, known = swings.fitted(noise)
    weights = (swings.J[..., 0] ** 2).sum((1, 2))
    assert known.error(np.eye(3)[0]) == pytest.approx(np.sqrt((weights**2).sum()) / weights.sum(), rel=0.6)
    assert known.inflation > 5


def test_noise_slower_than_the_data_gives_no_errors() -> None:
    """A random walk: it cannot be told from a drift."""
    walk = np.random.default_rng(0).normal(0, 1, (2, 200)).cumsum(1)
    assert not Swings(2, 200).fitted(walk)[1].enough


def test_a_direction_that_nothing_shows_is_not_determined() -> None:
    """Two numbers that only their sum is seen of: the sum has an error, neither number has; nor has a difference."""
    swings = Swings(3, 200)
    swings.J[..., 1] = swings.J[..., 0]
    known = swings.fitted(np.random.default_rng(0).normal(0, 1, (3, 200)))[1]
    assert known.null.shape == (3, 1)
    assert np.abs(known.null[:, 0]) == pytest.approx([0.5**0.5, 0.5**0.5, 0], abs=1e-6)
    assert [known.determined(np.array(g)) for g in ([1, 1, 0], [0, 0, 1], [1, 0, 0], [1, -1, 0])] == [1, 1, 0, 0]
    assert not known.determined(np.zeros(3))


@pytest.mark.parametrize(("size", "determined"), [(20.0, True), (45.0, False)])
def test_an_error_of_a_third_of_the_accelerations_is_none(size: float, determined: bool) -> None:
    """The limit is 30 natural scales, each a hundredth."""
    known = Certainty(np.diag([size**2, 1.0]) * 4, np.zeros((2, 0)), np.array([2.0, 2.0]), 1.0, 0.0, 1.0, np.zeros(0))
    assert known.determined(np.array([1.0, 0.0])) == determined


def test_few_samples_widen_the_errors() -> None:
    """By Student's quantile over the normal one: 2.776 / 1.960 for 4 degrees of freedom, of one piece of 9 samples here."""
    swings = Swings(1, 9)
    x = np.random.default_rng(0).normal(0, 1, (1, 9))
    _, known = swings.fitted(x)
    assert known.inflation >= 2.776445 / 1.959964 - 1e-6


# --- what is read from samples --------------------------------------------------------------------------------------


def swing_of(y: np.ndarray) -> Swing:
    return Swing("1", np.arange(len(y)) * 0.01, y, np.arange(len(y)), "sample", 0)


def test_sensor_noise_is_that_of_the_samples() -> None:
    """Of each column, to 2 %; a polynomial of order 5 leaves nothing, nor do cells without a number, nor uneven times."""
    draw, t = np.random.default_rng(0), np.linspace(-1, 1, 20_000)
    y = np.column_stack([2e-3 * draw.normal(size=t.size), 5e-2 * draw.normal(size=t.size)])
    y[::7, 1] = np.nan
    assert sensor_noise([swing_of(y)]) == pytest.approx([2e-3, 5e-2], rel=0.02)
    uneven = np.sort(draw.uniform(-1, 1, t.size))
    for times in (t, uneven):
        noise = sensor_noise([swing_of(y)._replace(t=times)])
        assert noise == pytest.approx([2e-3, 5e-2], rel=0.03)
        moving = y + 1e3 * (1 + times**5)[:, None]  # up to 0.5 from one sample to the next
        assert sensor_noise([swing_of(moving)._replace(t=times)]) == pytest.approx(noise, rel=1e-3)


def test_outliers_are_those_that_were_planted() -> None:
    """The farthest first, with swing, sample and column; smooth excursions are none, nor is what is small."""
    draw = np.random.default_rng(0)
    swings = [swing_of(1e-3 * draw.normal(size=(300, 2))) for _ in range(2)]
    swings[0].y[:, 0] += np.exp(-((np.arange(300) - 150) ** 2) / 2000)
    swings[1].y[70, 1] += 0.4
    swings[0].y[20, 0] -= 0.9
    swings[0].y[200, 1] += 0.03  # thirty times the noise, but 3 % of the spread
    found = outliers(swings, np.array([1.0, 1.0]))
    assert [(swing is swings[0], sample, column) for _, swing, sample, column in found] == [
        (True, 20, 0),
        (False, 70, 1),
    ]
    assert [size for size, *_ in found] == pytest.approx([0.9, 0.4], abs=0.01)


def test_a_robust_scale_is_that_without_outliers() -> None:
    """Of 20,000 normal residuals to 3 %, six standard errors; one sample in 50 that is far off adds less than 6 %.

    Pseudo-residuals keep that variance; of what is not seen nothing counts.
    """
    r = np.random.default_rng(0).normal(0, 0.01, (20_000, 2))
    seen = np.ones(r.shape, bool)
    assert huber_scale(r, seen, 0) == pytest.approx(0.01, rel=0.03)
    assert pseudo_residuals(100 * r, seen).std() == pytest.approx(1 / np.sqrt(0.95), rel=0.03)  # 95 % efficient
    r[::50] = 1e3
    assert (huber_scale(r, seen, 0) < 0.0106).all()
    seen[::50] = False
    assert huber_scale(r, seen, 0) == pytest.approx(0.01, rel=0.03)


def test_whiteness_is_a_probability() -> None:
    """Of white noise it is spread evenly; of noise with a memory it is nothing, and of few samples it is not asked."""
    draw = np.random.default_rng(0)
    p = np.array([whiteness(draw.normal(size=(2, 300, 1))) for _ in range(400)])
    assert np.mean(p < 0.5) == pytest.approx(0.5, abs=0.08)
    assert np.mean(p < 0.1) == pytest.approx(0.1, abs=0.05)
    assert whiteness(remembering(0.5, (2, 300), draw)[..., None]) < 1e-10
    assert whiteness(draw.normal(size=(1, 4, 1))) == 1.0


# --- numbers that are not determined --------------------------------------------------------------------------------

SCALE = ["model.rods[0].mass", "effects[1].coefficient", "model.rods[0].com"]


@pytest.fixture(scope="module")
def viscous() -> tuple[pp.Scene, dict[str, np.ndarray]]:
    """A rod with viscous friction, whose mass nothing shows, and two of its swings."""
    truth = scene_of(1, Viscous(coefficient=5e-5), data=ANGLE)
    return truth, swings_of(truth, [1.2], [0.7])


@pytest.mark.parametrize("mass", [0.1, 1.0])
def test_what_is_not_determined_stays_nearest_to_the_guess(viscous, mass: float) -> None:
    """The mass keeps it, friction follows; nothing along a direction that nothing shows; no such value is printed."""
    truth, table = viscous
    guess = truth.replace({"model.rods[0].mass": mass, "effects[1].coefficient": 2e-4})
    fit = pp.fit(guess, table, SCALE)
    assert fit.undetermined == tuple(SCALE[:2])
    assert fit.values[SCALE[0]] == pytest.approx(mass, rel=0.01)
    assert fit.values[SCALE[1]] == pytest.approx(5e-5 * mass / 0.1, rel=0.05)
    text = str(fit)
    assert [line.split()[1:] for line in text.splitlines()[1:3]] == [["not", "determined"]] * 2
    assert [fit.report().data["values"][key] is None for key in SCALE] == [True, True, False]
    assert "nearest to your guess" in text
    assert fit.scene.model.rods[0].mass == fit.values[SCALE[0]]


def test_combinations_do_not_depend_on_the_guess(viscous) -> None:
    """Nor does the motion: only what is not determined follows it."""
    truth, table = viscous
    fits = [pp.fit(truth.replace({"model.rods[0].mass": mass}), table, SCALE) for mass in (0.05, 0.4)]
    one, other = (
        {c.name: c for c in fit.combinations}["effects[1].coefficient / first moment of rod 1"] for fit in fits
    )
    assert one.value == pytest.approx(other.value, rel=1e-4)
    assert one.error == pytest.approx(other.error, rel=1e-2)
    assert fits[0].train.rms["a1"] == pytest.approx(fits[1].train.rms["a1"], rel=1e-6)
    assert fits[0].values[SCALE[2]] == pytest.approx(fits[1].values[SCALE[2]], rel=1e-6)


def test_data_too_short_for_errors_say_so(viscous) -> None:
    """A sensor that drifts over the whole of them: values, but no error, and the reason with its times."""
    truth, table = viscous
    drift = np.random.default_rng(0).normal(0, 1e-4, (2, len(table["t"]) // 2)).cumsum(1)
    fit = pp.fit(truth, table | {"a1": table["a1"] + drift.reshape(-1)}, SCALE[1:])
    assert not fit.errors
    assert "No standard errors: residuals stay correlated for" in str(fit)
    assert "+-" not in str(fit)
    assert str(Combination("ratio", 2.0, None, "m")) == "ratio = 2 m"
    assert str(Combination("ratio", 2.0, 0.1, "m")) == "ratio = 2 +- 0.1 m"


def test_a_friction_that_holds_the_scale_determines_the_mass() -> None:
    """A known dry friction weighs the rod."""
    truth = scene_of(1, Viscous(coefficient=5e-5), DryFriction(kinetic=1e-4), data=ANGLE)
    fit = pp.fit(truth.replace({"model.rods[0].mass": 0.12}), swings_of(truth, [1.2], [0.7]), SCALE)
    assert not fit.undetermined
    assert abs(fit.values[SCALE[0]] - 0.1) < 4 * fit.errors[SCALE[0]] < 0.02
