"""Special states through every public call: rest, right angles, straight up, numbers that underflow; and mirrors, names."""

import warnings
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.errors import Note
from pendpin.ground.arrays import EPS, TINY
from pendpin.motions.continuation import resolve
from pendpin.motions.crosschecks.crosscheck import crosscheck_run
from pendpin.motions.search import find_largest, sign_changes
from test_crosschecks import RODS

UP = np.pi  # rad
SPECIAL_ANGLES = (0.0, -0.0, UP / 2, -UP / 2, UP, -UP, 1e-300, -1e-300, 5e-324, 1e-160, 0.3)
SPECIAL_RATES = (0.0, 0.0, 0.0, -0.0, 1.0, -1.0, 1e-300, -1e-160, 1e-8)
METHODS: list[dict[str, Any]] = [
    {},
    {"method": "dop853", "tolerance": 1e-9},
    {"method": "rk23", "tolerance": 1e-5},
    {"method": "radau", "tolerance": 1e-6},
    {"method": "bdf", "tolerance": 1e-6},
    {"method": "lsoda", "tolerance": 1e-8},
    {"method": "taylor", "tolerance": 1e-12},
    {"method": "rk4", "step": 0.05},
    {"method": "euler", "step": 0.05},
    {"method": "gauss4", "step": 0.05},
]
BY_TOLERANCE = [method for method in METHODS if "step" not in method and method.get("method") != "taylor"]
NUMBERS = ("t", "q", "v", "a", "wrench", "kinetic", "potential", "tips")


def acting(touching: bool) -> list[fx.Effect]:
    """Effects, some of strength 0, for any chain."""
    contacts = [
        fx.DryFriction(kinetic=0.0),
        fx.DryFriction(kinetic=0.1),
        fx.Stop(lower=-UP, upper=UP),
        fx.Stop(lower=-UP / 2, upper=UP / 2, restitution=0.5),
    ]
    return [
        fx.Gravity(acceleration=0.0),
        fx.Gravity(direction=(0.0, 1.0, 0.0)),
        fx.Viscous(coefficient=0.0),
        fx.Viscous(coefficient=0.1),
        fx.Spring(stiffness=0.0),
        fx.Spring(stiffness=1.0, rest=UP / 2),
        fx.Drag(density=0.0),
        fx.Drag(diameter=0.1),
        fx.Support(amplitude=(0.0, -0.0, 0.0), frequency=3.0),
        fx.Support(amplitude=(0.1, -0.0, 0.0), frequency=3.0),
        fx.Rotation(rate=(0.0, 0.0, 0.0)),
        fx.Rotation(latitude=90.0),
        *contacts * touching,
    ]


def finite(run: pp.Trajectory) -> None:
    """No NaN, no infinite number in a run."""
    for name in NUMBERS:
        assert np.isfinite(getattr(run, name)).all(), name


def walk(scene: pp.Scene, options: dict[str, Any], folder: Path, data: st.DataObject) -> None:
    """Every method of a run, at special times and levels."""
    run = pp.simulate(scene, **options)
    finite(run)
    middle = run.t[0] + (run.t[-1] - run.t[0]) * np.array([0.3, 0.5])
    finite(run.at(middle))
    finite(run.at(run.t))
    name = data.draw(st.sampled_from(run.names[1:]))
    level = data.draw(st.sampled_from([0.0, -0.0, UP / 2, float(run[name][0]), float(run[name][-1])]))
    for direction in (-1, 0, 1):
        instants = run.crossings(name, level=level, direction=direction).t
        assert ((run.t[0] <= instants) & (instants <= run.t[-1])).all()
    finite(run.extend(0.1))
    assert repr(run)
    assert repr(run.summary())
    assert all(np.isfinite(figure.value) for figure in run.summary().values())
    assert pp.Trajectory.load(run.save(folder / "run.npz")) == run
    run.to_csv(folder / "run.csv")
    assert np.isfinite(run.energy().drift)
    report = crosscheck_run(run)
    assert report is None or report.ok, report.fault


@law(10)
@given(st.data(), st.booleans(), st.sampled_from([0.5, 0.5, 0.5, 0.0, 1e-9]))
def test_every_method_of_a_run_from_special_states(data: st.DataObject, touching: bool, duration: float) -> None:
    """Finite numbers, or one line that says why not; no other error, whatever vanishes."""
    options = data.draw(st.sampled_from(BY_TOLERANCE if touching else METHODS))
    rods = data.draw(st.lists(st.sampled_from(list(RODS.values())), min_size=1, max_size=2))
    n = 2 * len(rods)
    q, v = (data.draw(st.lists(st.sampled_from(x), min_size=n, max_size=n)) for x in (SPECIAL_ANGLES, SPECIAL_RATES))
    effects = [fx.Gravity()] * data.draw(st.booleans())
    effects += data.draw(st.lists(st.sampled_from(acting(touching)), max_size=2, unique_by=lambda x: type(x)))
    start = pp.Start(time=data.draw(st.sampled_from([0.0, -0.0, -3.0])), positions=q, velocities=v)
    samples = None if duration == 0 else data.draw(st.sampled_from([2, 7]))
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", Note)
        try:
            scene = pp.Scene(
                duration=duration,
                model=pp.Chain(rods=rods),
                start=start,
                effects=effects,
                solver=pp.Solver(samples=samples),
            )
            walk(scene, options, Path(folder), data)
        except pp.PendpinError as error:
            said = str(error)
        else:
            return
    assert "\n" not in said
    assert "energy is off" not in said or options.get("method") in ("euler", "rk23")  # coarse: it may be


@pytest.mark.parametrize("position", [(0.0, -UP / 2), (UP / 2, 0.0), (UP, 0.0), (0.0, UP), (0.3, -0.2)])
@pytest.mark.parametrize("duration", [1e-12, 1e-9, 1e-7])
def test_a_motion_too_short_to_exchange_energy_is_no_error(position: tuple, duration: float) -> None:
    """From rest, horizontal or upright: the energy exchanged is far below the rounding of the potential, which may be 0."""
    start = pp.Start(positions=position)
    model, effects = pp.Chain(rods=(RODS["thick"],)), (fx.Gravity(),)
    scene = pp.Scene(duration=duration, model=model, start=start, effects=effects)
    for options in ({}, {"method": "rk23", "tolerance": 1e-5}, {"energy_balance": True}, {"accuracy": 1e-6}):
        assert len(pp.simulate(scene, **options).t) == len(scene.times)
    assert np.isfinite(pp.simulate_many(scene, [position] * 2, [(0.0, 0.0)] * 2).q).all()


def test_numbers_that_underflow_are_not_searched() -> None:
    """The moment of a thin rod with phi = -1e-300 is below the smallest normal double: its signs and sizes are rounding."""
    start = pp.Start(positions=(-UP, -1e-300), velocities=(-1.0, 0.0))
    scene = pp.Scene(duration=0.5, model=pp.Chain(rods=(RODS["thin"],)), start=start, effects=(fx.Gravity(),))
    more, samples = resolve(pp.simulate(scene, method="gauss4", step=0.05, samples=7)), list[int]()

    def moment(rows: Any) -> np.ndarray:
        samples.append(len(rows.t))
        return rows["M3"]

    assert 0 < np.abs(moment(more.run)).max() < TINY
    assert not sign_changes(more, moment).begin.size
    find_largest(more, lambda rows: moment(rows)[:, None])
    assert sum(samples) < 1000  # 200,000 otherwise


@pytest.mark.parametrize("method", ["taylor", "dop853"])
@pytest.mark.parametrize("rate", [(1e-300, 0.0), (0.0, 1e-160)])
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_hardly_moving_at_a_pole(method: str, rate: tuple[float, float]) -> None:
    """A thin rod let go at its pole with a rate that is rounding: no rate of an angle is that rounding divided by it."""
    start = pp.Start(positions=(0.3, UP / 2), velocities=rate)
    for effects in ((), (fx.Gravity(),)):
        scene = pp.Scene(duration=1.0, model=pp.Chain(rods=(RODS["thin"],)), start=start, effects=effects)
        run = pp.simulate(scene, method=method, samples=2)
        soon = run.at([0.0, 1e-200, 1e-160, 1e-20, 1e-9])
        assert np.abs(soon.v).max() < 1e-7


@pytest.mark.parametrize("options", [{}, {"method": "taylor"}, {"method": "dop853"}])
def test_starts_alone_are_an_ensemble(options: dict[str, Any]) -> None:
    """Of duration 0: each member is its start, as a run of duration 0 is."""
    model, q, v = pp.Chain(rods=(RODS["thick"],)), [(1.0, 0.0), (0.0, -0.3)], [(0.0, 0.0), (2.0, 0.0)]
    scene = pp.Scene(duration=0.0, model=model, effects=(fx.Gravity(),))
    many = pp.simulate_many(scene, q, v, **options)
    np.testing.assert_array_equal(many.q[:, 0], q)
    np.testing.assert_array_equal(many.v[:, 0], v)
    found = pp.sweep(scene, {"start.positions.theta": [0.0, 1.0]}, ["swing", "flip_time"])
    np.testing.assert_allclose(found["swing"].values, [0.0, 1.0], rtol=1e-15)


def test_a_start_alone_is_extended() -> None:
    """A run of duration 0 has one sample and no density of samples: what follows has the usual one."""
    start, model = pp.Start(positions=(1.0, 0.0)), pp.Chain(rods=(RODS["thick"],))
    scene = pp.Scene(duration=0.0, model=model, start=start, effects=(fx.Gravity(),))
    for samples in (None, 1):
        longer = pp.simulate(scene.replace({"solver.samples": samples}), method="rk4", step=0.01).extend(0.5)
        assert longer == pp.simulate(scene.replace(duration=0.5), method="rk4", step=0.01)


# --- mirrors --------------------------------------------------------------------------------------------------------

SIGNS = [(-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]  # of theta and phi: W mirrored in y, in x, in both
MIRRORED = [*METHODS, {"energy_balance": True}]


@law(12)
@given(
    st.sampled_from(sorted(RODS)),
    st.integers(1, 2),
    st.sampled_from(SIGNS),
    st.sampled_from(MIRRORED),
    st.lists(st.sampled_from(["air", "oil", "spring"]), max_size=2, unique=True),
    st.lists(st.sampled_from([0.0, 0.3, -1.1, UP / 2, UP, 1e-160, 0.05]), min_size=8, max_size=8),
)
def test_a_mirror_image_is_the_same_motion(
    name: str, count: int, signs: tuple, options: dict, more: list, state
) -> None:
    """All numbers of a run but their signs, to the bit; also its steps and crossings, and what it refuses."""
    sign, n, runs = np.tile(signs, count), 2 * count, []
    q, v = np.split(np.array(state[: 2 * n]), 2)
    # Jacobians from differences upwards, LAPACK's pivots: mirrored to rounding. Near its pole theta of a thin rod has no
    # inertia: moments about it, and gauss4's stages in angles, leave no bound on what rounding becomes
    implicit = options.get("method") in ("radau", "bdf", "lsoda", "gauss4")
    unbounded = UP / 2 in q[1::2] or {"oil", "spring"} & {*more} or options.get("method") == "gauss4"
    assume(not (implicit and name == "thin" and unbounded))
    for mirror in (np.ones(n), sign):
        parts = {
            "air": fx.Drag(diameter=0.1),
            "oil": fx.Viscous(coefficient=0.1),
            "spring": fx.Spring(stiffness=1.0),
        }
        start = pp.Start(positions=tuple(q * mirror), velocities=tuple(v * mirror))
        effects = (fx.Gravity(), *(parts[part] for part in more))
        model = pp.Chain(rods=(RODS[name],) * count)
        scene = pp.Scene(duration=0.4, model=model, start=start, effects=effects, solver=pp.Solver(samples=5))
        try:
            runs.append(pp.simulate(scene, **options))
        except pp.PendpinError as error:
            runs.append(type(error))
    one, other = runs
    if not isinstance(one, pp.Trajectory) or not isinstance(other, pp.Trajectory):
        assert one == other
        return
    if implicit:
        error = 10 * options.get("tolerance", 1e-13)
        np.testing.assert_allclose(other.q, one.q * sign, rtol=0, atol=error)
        return
    if name == "thin":  # their angles are read from directions, half turns added, and their rates divided by cos(phi)
        np.testing.assert_allclose(other.tips, one.tips * [signs[1], signs[0], 1.0], rtol=0, atol=20 * EPS * count)
        return
    for numbers in ("q", "v", "a"):
        np.testing.assert_array_equal(getattr(other, numbers), getattr(one, numbers) * sign, err_msg=numbers)
    np.testing.assert_array_equal(other.tips, one.tips * [signs[1], signs[0], 1.0])
    for numbers in ("t", "kinetic", "potential"):
        np.testing.assert_array_equal(getattr(other, numbers), getattr(one, numbers), err_msg=numbers)
    assert (one.stats.method, one.stats.steps) == (other.stats.method, other.stats.steps)
    level = float(one["theta" + "_1" * (count > 1)][[0, -1]].mean())
    instants = [
        run.crossings("theta" + "_1" * (count > 1), level=level * m).t for run, m in ((one, 1.0), (other, signs[0]))
    ]
    np.testing.assert_array_equal(*instants)


@law(12)
@given(
    st.sampled_from(["thin", "thick"]),
    st.sampled_from(MIRRORED[:-1]),
    st.lists(st.sampled_from([0.0, 0.3, -1.1, 1e-160, 0.05, 1.4]), min_size=4, max_size=4),
)
def test_a_swing_in_one_plane_is_that_in_the_other(name: str, options: dict, state: list) -> None:
    """Both axes of a joint meet at a right angle: a symmetric chain swings in y-z (theta) as in x-z (phi)."""
    oil, air = fx.Viscous(coefficient=0.1 * (name == "thick")), fx.Drag(diameter=0.1)
    effects = (fx.Gravity(), oil) if options.get("method") == "taylor" else (fx.Gravity(), oil, air)
    model, runs = pp.Chain(rods=(RODS[name],) * 2), []
    for place in (0, 1):
        q, v = np.zeros((2, 2, 2))
        q[:, place], v[:, place] = state[:2], state[2:]
        start = pp.Start(positions=tuple(q.ravel()), velocities=tuple(v.ravel()))
        scene = pp.Scene(duration=0.4, model=model, start=start, effects=effects, solver=pp.Solver(samples=5))
        runs.append(pp.simulate(scene, **options))
    theta, phi = runs
    bound = 1e-9 if "step" in options else 10 * options.get("tolerance", 1e-11)  # other steps, where one is refused
    np.testing.assert_allclose(phi.tips, theta.tips[..., [1, 0, 2]] * [-1, 1, 1], rtol=0, atol=bound)
    for one, other in (("R1", "R2"), ("R2", "R1"), ("R3", "R3")):
        sizes = [[abs(run[f"{kind}_{i}"]) for i in (1, 2)] for run, kind in ((theta, one), (phi, other))]
        np.testing.assert_allclose(*sizes, rtol=0, atol=1e3 * bound)  # N; rates of up to 10 rad/s in a second or so


@pytest.mark.parametrize("name", ["thin", "thick"])
@pytest.mark.parametrize("options", BY_TOLERANCE + METHODS[-3:])
def test_other_units_and_later_starts_are_the_same_motion(name: str, options: dict[str, Any]) -> None:
    """Masses in 4^7 of a kilogram, lengths in 4^-5 of a metre, clocks set to 1024 s: the same angles, to the bit."""
    runs, thick = [], name == "thick"
    for mass, length, begin in ((1.0, 1.0, 0.0), (4.0**7, 4.0**-5, 1024.0)):
        rod = pp.Rod(length=1.1 * length, mass=1.3 * mass, radius=0.05 * length * thick, payload=0.2 * mass)
        moment = mass * length**2
        moments = (fx.Viscous(coefficient=0.2 * moment), fx.Spring(stiffness=1.3 * moment)) if thick else ()
        effects = (fx.Gravity(acceleration=9.81 * length), *moments)
        start = pp.Start(time=begin, positions=(0.7, 0.4), velocities=(1.3, -0.8))
        scene = pp.Scene(duration=0.6, model=pp.Chain(rods=(rod,)), start=start, effects=effects)
        run = pp.simulate(scene, samples=5, **(options | ({"step": 0.01} if "step" in options else {})))
        forces = (run[name] / (mass * length) for name in ("R1", "R3"))
        runs.append((run.q, run.v, run.a, *forces, run.tips / length, run.stats.steps))
    for one, other in zip(*runs, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("signs", SIGNS)
def test_contacts_have_mirror_images(signs: tuple[float, float]) -> None:
    """Two rods under dry friction that bounce on their stops: each number to the bit, each event at its instant."""
    sign, q, v = np.tile(signs, 2), np.array([0.3, -0.4, 0.05, 0.2]), np.array([1.0, -0.7, 0.3, 0.9])
    effects = (fx.Gravity(), fx.DryFriction(kinetic=0.1), fx.Stop(lower=-0.5, upper=0.5, restitution=0.5))
    model = pp.Chain(rods=(RODS["own inertia"],) * 2)
    runs = []
    for mirror in (np.ones(4), sign):
        start = pp.Start(positions=tuple(q * mirror), velocities=tuple(v * mirror))
        scene = pp.Scene(duration=0.8, model=model, start=start, effects=effects)
        runs.append(pp.simulate(scene, method="dop853", tolerance=1e-9, samples=9))
    one, other = runs
    assert len(one.events) > 2
    np.testing.assert_array_equal(other.q, one.q * sign)
    np.testing.assert_array_equal(other.v, one.v * sign)
    assert [event.t for event in other.events] == [event.t for event in one.events]


def test_a_force_on_the_axis_lets_a_thin_rod_through_its_pole() -> None:
    """An anchor turns no rod about itself: past phi = 90 degrees by 1e-9 rad, the tip goes on as through it."""
    anchor = pp.effects.Anchor(link="rod_1", point=(0.5, 0.0, -0.8), stiffness=3.0)
    thin = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)])
    through, past = (
        pp.simulate(
            pp.Scene(
                model=thin,
                effects=[pp.effects.Gravity(), anchor],
                start=pp.Start(positions={"theta": theta, "phi": 1.2}, velocities={"phi": 4.0}),
                duration=0.3,
            )
        )
        for theta in (0.0, 1e-9)
    )
    assert not pp.bind(past.source).engine.on_angles  # but on directions, which have no pole
    assert through["phi"].max() > np.pi / 2
    np.testing.assert_allclose(past.tips, through.tips, atol=1e-8)


@pytest.mark.parametrize("angle", [UP / 2, -UP / 2, 0.3])
def test_a_motion_in_a_plane_goes_on_from_its_samples(angle: float) -> None:
    """A rod that turns about a fixed axis: phi grows evenly between its samples, though their angles are rounded."""
    start = pp.Start(positions=(angle, UP / 2), velocities=(0.0, 1.0))
    model = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0),))
    run = pp.simulate(pp.Scene(duration=0.5, model=model, start=start, effects=(), solver=pp.Solver(samples=2)))
    times = np.linspace(0, 0.5, 8)
    assert np.ptp(run.at(times).q[:, 1] - times) < 1e-8
