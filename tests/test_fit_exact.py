"""Parts of a fit against exact values: swings in pieces, coordinates of the search, errors from the scatter of swings."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

import pendpin as pp
from fit_scenes import scene_of
from laws import law
from pendpin.effects import Drag, DryFriction, Gravity, Viscous
from pendpin.errors import InputError
from pendpin.fitting.data import FEWEST, Swing, batch, cut_pieces, read_swings, spread_of, thin_out
from pendpin.fitting.fitting import prepare
from pendpin.fitting.parameters import free_parameters, substitute
from pendpin.fitting.uncertainty import certainty, memory_lags, outliers, sensor_noise, whiteness
from pendpin.scene import Data
from test_fit_errors import Swings, swing_of

# --- swings and their pieces ----------------------------------------------------------------------------------------


def swing(count: int, spacing: float = 0.01, name: str = "1") -> Swing:
    """Samples 0, 1, 2, ... at even times."""
    return Swing(name, 5 + np.arange(count) * spacing, np.arange(count) * 1.0, np.arange(count), "sample", 0)._replace(
        y=np.arange(count, dtype=float)[:, None]
    )


@law(100)
@given(st.integers(2 * FEWEST, 400), st.floats(0.05, 5.0))
def test_pieces_are_the_swing_in_as_few_parts_as_may_be(count: int, longest: float) -> None:
    """One after the other they are the swing; all of one length but for a sample, none too long, and none too short."""
    whole = swing(count)
    pieces = cut_pieces(whole, longest)
    assert np.concatenate([piece.t for piece in pieces]).tolist() == whole.t.tolist()
    assert np.concatenate([piece.y for piece in pieces]).tolist() == whole.y.tolist()
    sizes = [len(piece.t) for piece in pieces]
    assert max(sizes) - min(sizes) <= 1
    assert min(sizes) >= FEWEST
    duration = 0.01 * (count - 1)
    most = count // FEWEST
    assert len(pieces) == most or (duration / len(pieces) <= longest * (1 + 1e-8))
    assert len(pieces) == 1 or duration / (len(pieces) - 1) > longest * (1 - 1e-8)


def test_pieces_lie_side_by_side() -> None:
    """Of a swing of 3 s, in halves, and of one of 1 s: what is missing is NaN at the last time."""
    whole = batch([swing(301), swing(101)], 1.6)
    assert whole.swing.tolist() == [0, 0, 1]
    lengths = (~np.isnan(whole.y[:, 0])).sum(0)
    assert lengths.tolist() == [150, 151, 101] or lengths.tolist() == [151, 150, 101]
    assert whole.y[: lengths[0], 0, 0].tolist() == list(range(lengths[0]))
    assert whole.y[:101, 0, 2].tolist() == list(range(101))
    for k, length in enumerate(lengths):
        np.testing.assert_allclose(np.diff(whole.t[:length, k]), 0.01, rtol=1e-9)
        assert (whole.t[length:, k] == whole.t[length - 1, k]).all()
        assert np.isnan(whole.y[length:, 0, k]).all()


def test_swings_of_too_many_samples_are_thinned() -> None:
    """To 20,000, but not to a spacing that is longer than allowed."""
    long, short = swing(60_000), swing(20_000)
    one, other = thin_out([long, short], 0.1)
    assert one.y[:, 0].tolist() == list(range(0, 60_000, 3))
    assert other.y.tolist() == short.y.tolist()
    (kept,) = thin_out([long], 0.021)
    assert kept.y[:, 0].tolist() == list(range(0, 60_000, 2))
    (whole,) = thin_out([long], 0.001)
    assert len(whole.t) == 60_000


def test_the_spread_is_the_standard_deviation() -> None:
    """Of all swings together, each column for itself, without what is missing."""
    one, other = (
        Swing("1", np.arange(3.0), np.array(y), np.arange(3), "sample", 0)
        for y in ([[1.0, 0.0], [2.0, np.nan], [3.0, 2.0]], [[6.0, 4.0], [6.0, 6.0], [6.0, 8.0]])
    )
    assert spread_of([one, other]) == pytest.approx([np.std([1, 2, 3, 6, 6, 6]), np.std([0, 2, 4, 6, 8])])


# --- coordinates of the search --------------------------------------------------------------------------------------

SCENE = pp.Scene(
    model=pp.Chain(rods=[pp.Rod(length=0.3, mass=0.2, radius=0.01), pp.Rod(length=0.2, mass=0.1, radius=0.005)]),
    effects=[
        Gravity(),
        Viscous(coefficient=1e-4),
        DryFriction(kinetic=1e-4, static=3e-4, stribeck=5.0),
        Drag(diameter=0.02),
    ],
)
KEYS = [
    "model.rods[0].com", "model.rods[0].inertia", "model.rods[1].inertia[0]", "model.rods[0].length",
    "effects[1].coefficient", "effects[2].static", "effects[2].kinetic", "effects[2].stribeck", "effects[3].coefficient",
]  # fmt: skip


def test_the_search_starts_at_the_guess() -> None:
    """Every number, in the order of the keys, an inertia being three."""
    free = free_parameters(SCENE, KEYS)
    rods, effects = SCENE.model.rods, SCENE.effects
    inertia = rods[0].properties[2:]
    exact = [rods[0].properties.h, *inertia, rods[1].properties.I1, 0.3, 1e-4, 3e-4, 1e-4, 5.0, effects[3].coefficient]
    assert free.guess == pytest.approx(exact, rel=1e-12)
    assert [float(x) for x in free.values(free.start)] == pytest.approx(exact, rel=1e-9)
    assert free.keys[:5] == ("model.rods[0].com", *(f"model.rods[0].inertia[{k}]" for k in range(3)), KEYS[2])


def test_gradients_are_those_of_the_values() -> None:
    """By central differences."""
    free = free_parameters(SCENE, KEYS)
    step = 1e-6
    columns = [
        (np.array(free.values(free.start + step * e), float) - np.array(free.values(free.start - step * e), float))
        / (2 * step)
        for e in np.eye(len(free.start))
    ]
    assert free.gradients(free.start) == pytest.approx(np.array(columns).T, rel=1e-6, abs=1e-9)


@law(100)
@given(st.integers(0, 2**32 - 1))
def test_wherever_the_search_is_there_is_a_body(seed: int) -> None:
    """Inertias that a body can have, numbers that are positive stay so, and static friction is not below kinetic."""
    free = free_parameters(SCENE, KEYS)
    draw = np.random.default_rng(seed)
    z = free.start + draw.normal(0, 2, len(free.start)) * np.maximum(1e-5, abs(free.start))
    value = dict(zip(free.keys, (float(x) for x in free.values(np.clip(z, free.lower, free.upper))), strict=True))
    I1, I2, I3 = (value[f"model.rods[0].inertia[{k}]"] for k in range(3))
    assert I1 + I2 >= I3 * (1 - 1e-12)
    assert I2 + I3 >= I1 * (1 - 1e-12)
    assert I3 + I1 >= I2 * (1 - 1e-12)
    assert value["effects[2].static"] >= value["effects[2].kinetic"] >= 0
    assert value["effects[1].coefficient"] >= 0
    assert value["model.rods[0].length"] > 0
    other = SCENE.model.rods[1].properties
    assert abs(other.I2 - other.I3) <= value[KEYS[2]] <= other.I2 + other.I3


def test_what_takes_energy_and_what_is_a_speed() -> None:
    """Frictions and drags; the speed of Stribeck's friction."""
    free = free_parameters(SCENE, KEYS)
    takes = [
        any(free.transform[i, k] for i, key in enumerate(free.keys) if key.startswith("effects"))
        for k in range(len(free.start))
    ]
    assert free.dissipation(SCENE).tolist() == takes
    row = free.keys.index("effects[2].stribeck")
    assert np.flatnonzero(free.is_stribeck_speed).tolist() == np.flatnonzero(free.transform[row]).tolist()
    assert sum(takes) == 5


# --- what the data can tell -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [8, 9, 20])
def test_numbers_of_equal_swings_have_the_error_of_their_mean(count: int) -> None:
    """Swings that show a number equally well, each with its own: s / sqrt(n), s with n - 1 in the denominator."""
    swings = Swings(count, 300)
    swings.J = np.repeat(swings.J[:1, :, :, :1], count, 0)
    own = np.random.default_rng(count).normal(0, 1, count)
    mean = own.mean()
    r = swings.J[..., 0] * (own - mean)[:, None, None]  # what is left by the best common number
    known = certainty(r, swings.J, swings.starts, np.ones(1), swings.swing, swings.t, swings.seen)
    assert known.error(np.ones(1)) == pytest.approx(np.std(own, ddof=1) / np.sqrt(count), rel=2e-3)  # Student: 1.0005
    assert known.error(np.full(1, -3.0)) == pytest.approx(3 * known.error(np.ones(1)))


def test_the_scatter_of_seven_swings_is_not_counted() -> None:
    """Too few: the error is larger then by what a memory as long as a swing makes of it, not that of their mean."""
    swings = Swings(7, 300)
    swings.J = np.repeat(swings.J[:1, :, :, :1], 7, 0)
    own = np.random.default_rng(0).normal(0, 1, 7)
    r = swings.J[..., 0] * (own - own.mean())[:, None, None]
    known = certainty(r, swings.J, swings.starts, np.ones(1), swings.swing, swings.t, swings.seen)
    assert known.error(np.ones(1)) != pytest.approx(np.std(own, ddof=1) / np.sqrt(7), rel=1e-2)


@pytest.mark.parametrize(("P", "M"), [(1, 30), (3, 60), (2, 300)])
def test_whiteness_is_the_test_of_ljung_and_box(P: int, M: int) -> None:
    """n (n + 2) sum rho_k² / (n - k), of chi², over a fifth of the samples and 20 lags at most."""
    r = np.random.default_rng(M).normal(0, 1, (P, M, 1))
    n, lags = P * M, min(20, M // 5)
    rho = [(r[:, k:] * r[:, : M - k]).sum() / (r**2).sum() for k in range(1, lags + 1)]
    statistic = n * (n + 2) * sum(x**2 / (n - k) for k, x in enumerate(rho, 1))
    assert whiteness(r) == pytest.approx(chi2.sf(statistic, lags), rel=1e-9)
    padded = np.concatenate([r, np.zeros_like(r)], 1)[:, : M + 3]  # what is missing is 0, and no sample
    assert whiteness(padded[:, :M]) == whiteness(r)


def test_noise_of_seven_samples() -> None:
    """The sixth difference of seven samples, over the root of the sum of squares of its coefficients; of six none."""
    y = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    assert sensor_noise([swing_of(y[:, None])]) == pytest.approx([1.4826 * 20 / np.sqrt(924)])
    assert sensor_noise([swing_of(y[:6, None])]) == [0]


def test_outliers_between_missing_samples() -> None:
    """A column in which every third sample is missing has the same outlier; one without any sample has none."""
    draw = np.random.default_rng(0)
    y = 1e-3 * draw.normal(size=(300, 2))
    y[::3, 0], y[:, 1] = np.nan, np.nan
    y[100, 0] += 0.4
    found = outliers([swing_of(y)], np.array([1.0, 1.0]))
    assert [(sample, column) for _, _, sample, column in found] == [(100, 0)]


def test_pieces_too_short_for_a_correlation_are_white() -> None:
    """Of four samples no lag is looked at, however many pieces there are."""
    assert whiteness(np.random.default_rng(0).normal(size=(10, 4, 1)).cumsum(1)) == 1.0


# --- what is read and what is written -------------------------------------------------------------------------------


def test_samples_of_a_table_are_counted_from_1() -> None:
    """The third sample is the one that is named."""
    table = Data(columns={"a": ("theta",)})
    y = np.arange(10.0)
    y[2] = np.inf
    with pytest.raises(InputError, match="sample 3, column a: an infinite number"):
        read_swings({"t": np.arange(10.0), "a": y}, table)


def test_physics_is_what_the_motion_shows() -> None:
    """Centres of mass, inertias, and the lengths of rods that others hang on; frictions and drags."""
    keys = free_parameters(SCENE, "physics").keys
    bodies = [f"model.rods[{i}].{part}" for i in (0, 1) for part in ("com", *(f"inertia[{k}]" for k in range(3)))]
    frictions = [f"effects[2].{name}" for name in ("kinetic", "static", "stribeck")]
    assert keys == (*bodies, "model.rods[0].length", KEYS[4], *frictions, KEYS[8])
    copies = SCENE.replace(model=pp.Chain(rods=SCENE.model.rods[:1], copies=2))
    assert "model.rods[0].length" in free_parameters(copies, "physics").keys
    assert free_parameters(SCENE, "friction").keys == keys[9:]


def test_numbers_are_written_to_their_places() -> None:
    """Of rods and effects, whole numbers and parts of lists; nothing else changes."""
    keys = ["model.rods[1].inertia[2]", "model.rods[0].com", "effects[2].kinetic"]
    values = [2e-6, 0.1, 2e-4]
    changed = substitute(SCENE, keys, values)
    assert free_parameters(changed, keys).guess.tolist() == values
    I1, I2 = SCENE.model.rods[1].properties[2:4]
    assert changed.model.rods[1].inertia == pytest.approx((I1, I2, 2e-6))
    assert changed.effects[2] == SCENE.effects[2].model_copy(update={"kinetic": 2e-4})
    assert changed.effects[1] == SCENE.effects[1]
    assert changed.effects[3] == SCENE.effects[3]


def test_noise_that_is_large_where_it_counts() -> None:
    """White, five times as large where the motion shows the number: its error is that of these samples, not of the mean."""
    swings, (P, M) = Swings(2, 2_000), (2, 2_000)
    shows = np.random.default_rng(0).random((P, M)) < 0.1
    swings.J = np.where(shows, 1.0, 1e-6)[:, :, None, None]
    noise = np.random.default_rng(1).normal(0, np.where(shows, 5.0, 1.0))
    r = noise - swings.J[..., 0, 0] * (noise * shows).sum() / shows.sum()
    assert memory_lags(r[:, :, None]) == 0
    known = certainty(r[:, :, None], swings.J, swings.starts, np.ones(1), swings.swing, swings.t, swings.seen)
    assert known.error(np.ones(1)) == pytest.approx(5.0 / np.sqrt(shows.sum()), rel=0.1)


# --- joint angles from tips -----------------------------------------------------------------------------------------

TIPS = {
    "x, y and z": {f"{axis}{rod}": f"rod_{rod}.{axis}" for rod in (1, 2) for axis in "xyz"},
    "x and y": {f"{axis}{rod}": f"rod_{rod}.{axis}" for rod in (1, 2) for axis in "xy"},
    "an angle and a tip each": {"a": ("theta_1",), "x1": "rod_1.x", "b": ("theta_2",), "x2": "rod_2.x"},
}


@pytest.mark.parametrize("noise", [0.0, 2e-4])  # m and rad
@pytest.mark.parametrize("columns", TIPS.values(), ids=TIPS.keys())
def test_joint_angles_from_tips_are_those_of_the_motion(columns: dict, noise: float) -> None:
    """In space each tip is reached by theta and phi, and by theta + pi and pi - phi: the angles change to others nowhere.

    Two rods of 0.2 m, so that noise turns them by 1e-3 rad, the second one by twice as much; theta by 1/cos(phi) more.
    """
    scene = scene_of(2, data=Data(columns=columns, offsets="zero"), duration=1.5)
    start = {"theta_1": 0.7, "phi_1": 0.3, "theta_2": -0.5, "phi_2": -0.4}
    run = pp.simulate(pp.Scene(**scene.given() | {"start": pp.Start(positions=start)}))
    draw, table = np.random.default_rng(0), {"t": run.t}
    for name, measured in columns.items():
        of_tip = isinstance(measured, str)
        y = run.tips[:, int(measured[4]) - 1, "xyz".index(measured[-1])] if of_tip else run[measured[0]]
        table[name] = y + draw.normal(0, noise, len(y))
    (swing,) = prepare(scene, table, "model.rods[1].com").angles
    assert np.abs(swing.y - run.q).max() < (30e-3 if noise else 1e-7)


def test_a_centre_of_mass_names_its_centre_of_oscillation(tmp_path) -> None:
    """h and I / (m h) give the same swing: from a guess near one the fit is that one, and its report names the other."""
    rod = pp.Rod(length=1.0, mass=1.0, com=0.4, inertia=(0.05, 0.05, 0.001), joint="hinge")
    true = pp.Scene(
        duration=6.0,
        model=pp.Chain(rods=[rod]),
        effects=[Gravity()],
        start=pp.Start(positions={"theta": 0.8}),
        data=Data(columns={"theta": ["theta"]}),
    )
    data = pp.simulate(true, samples=301).to_csv(tmp_path / "swing.csv", "theta")
    key, other = "model.rods[0].com", 0.05 / 0.4
    for guess, found, named in ((0.35, 0.4, other), (0.1, other, 0.4)):
        fit = pp.fit(true.replace({key: guess}), data, free=[key])
        assert fit.values[key] == pytest.approx(found, rel=1e-5)
        assert f"{key} = {named:.4g} m, its centre of oscillation" in str(fit)
