"""Laws of the search for an accuracy: coarser targets are easier, mirror images get one answer, other methods are tried."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.equations import exact
from pendpin.ground.arrays import EPS
from pendpin.runs.accuracy.estimate import RoundingError, measure_rounding
from pendpin.runs.accuracy.runs import Attempt, Runs
from pendpin.runs.accuracy.thresholds import ESTIMATE, ROUNDING
from pendpin.runs.limits import Deadline
from pendpin.runs.preparation import Prepared

MASS = pp.Rod(length=1.0, mass=1.0, com=1.0, inertia=(0, 0, 0))  # on a massless rod
TARGETS = (1e-9, 1e-6, 1e-3, 1e-2)
MIRRORED = 2000.0  # s


def is_met(scene: pp.Scene, method: str, accuracy: float) -> bool:
    """Whether a target is met; a refusal names a time unless the error that it names is above the target."""
    try:
        pp.simulate(scene, method=method, accuracy=accuracy)
    except pp.RunError as error:
        assert f"accuracy {accuracy:g} is not met: " in str(error)  # noqa: PT017
        stated = error.partial.stats.error
        assert stated is None or stated > accuracy, str(error)  # noqa: PT017
        return False
    return True


# --- coarser targets ------------------------------------------------------------------------------------------------


@law(4)
@given(
    rods=st.integers(1, 2),
    radius=st.sampled_from([0.0, 0.01, 0.05]),
    amplitude=st.tuples(*3 * [st.sampled_from([0.0, 1e-3, 1.0])]),
    frequency=st.floats(-5.0, -1.0).map(lambda power: 10.0**power),
    method=st.sampled_from(["dop853", "rk45", "radau", "lsoda"]),
)
@example(
    rods=1, radius=0.01, amplitude=(0.0, 1.0, 0.0), frequency=1e-4, method="dop853"
)  # refused at 1e-9 and 1e-2 once
@example(rods=1, radius=0.0, amplitude=(0.0, 1.0, 0.0), frequency=1e-4, method="rk45")
@example(rods=1, radius=0.0, amplitude=(0.0, 1.0, 0.0), frequency=1e-4, method="lsoda")
@example(rods=3, radius=0.05, amplitude=(1e-3, 1e-3, 0.0), frequency=0.01, method="dop853")
def test_what_is_met_is_met_at_every_coarser_target(rods, radius, amplitude, frequency, method) -> None:
    """A hanging chain on a support that hardly moves it, far below the target: one verdict, and no refusal without cause."""
    scene = pp.Scene(
        duration=10.0 if rods == 1 else 5.0,
        model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=radius)] * rods),
        effects=[fx.Gravity(), fx.Support(amplitude=amplitude, frequency=frequency)],
        solver=pp.Solver(samples=61),
    )
    met = [is_met(scene, method, accuracy) for accuracy in TARGETS]
    assert met == sorted(met)
    assert met[1]


# --- mirror images --------------------------------------------------------------------------------------------------


def swing(theta: float, duration: float, samples: int) -> pp.Scene:
    """A point mass let go at an angle: its motion is known exactly."""
    return pp.Scene(
        duration=duration,
        model=pp.Chain(rods=[MASS]),
        start=pp.Start(positions=[theta, 0.0]),
        effects=[fx.Gravity()],
        solver=pp.Solver(samples=samples),
    )


def estimate_rounding(scene: pp.Scene, method: str, tolerance: float) -> tuple[RoundingError, pp.Trajectory]:
    """The estimate of rounding beside a run of the finest tolerance, and that run."""
    runs = Runs(Prepared.of(scene.with_solver(accuracy=1e-9, method=method)), lambda t: None, Deadline(None))
    attempts = [
        Attempt(tried, setting, runs.run(tried))
        for setting in (100 * tolerance, tolerance)
        for tried in [scene.by(method, setting)]
    ]
    return measure_rounding(runs, *attempts, 1e-9, runs.ruler(attempts[-1].run)), attempts[-1].run


def true_error(scene: pp.Scene, run: pp.Trajectory) -> float:
    """The largest distance of the tip from the exact motion, over the length."""
    angle = exact.planar(scene.start.positions[0], 0.0, 1.0, 9.81, scene.times)
    tip = exact.direction(np.stack([angle, np.zeros_like(angle)], -1))
    return float(np.linalg.norm(run.tips[:, 0] - tip, axis=-1).max())


@pytest.mark.parametrize("samples", [2, pytest.param(201, marks=pytest.mark.slow)])
def test_a_long_swing_and_its_mirror_image(samples: int) -> None:
    """IFToMM's A01, 2,000 s: met from both sides, with the same estimate, and the claim holds."""
    right, left = (pp.simulate(swing(angle, MIRRORED, samples), accuracy=1e-9) for angle in (0.5 * np.pi, -0.5 * np.pi))
    assert right.stats.error == left.stats.error
    assert right.stats.tolerance == left.stats.tolerance
    assert np.array_equal(right.q[:, 0], -left.q[:, 0])
    y, z = right.tips[-1, 0, 1:]
    away = np.hypot(abs(y) - 0.8146030685890322, z + 0.5800188278369355)
    assert away <= right.stats.error <= 1e-9


@law(6)
@given(
    angles=st.lists(st.floats(0.05, 3.0), min_size=2, max_size=4).filter(lambda x: len(x) % 2 == 0),
    rates=st.lists(st.floats(-2.0, 2.0), min_size=4, max_size=4),
    signs=st.tuples(st.sampled_from([-1.0, 1.0]), st.sampled_from([-1.0, 1.0])),
    radius=st.sampled_from([0.0, 0.05]),
    method=st.sampled_from(["auto", "dop853", "radau", "rk4"]),
    accuracy=st.sampled_from([1e-3, 1e-7]),
)
def test_mirror_images_get_one_answer(angles, rates, signs, radius, method, accuracy) -> None:
    """Mirrored in the planes of theta and phi: the same verdict, setting and steps, and estimates equal but for rounding."""
    rods, outcomes = len(angles) // 2, []
    for mirror in (np.ones(len(angles)), np.tile(signs, rods)):
        scene = pp.Scene(
            duration=2.0,
            model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=radius)] * rods),
            start=pp.Start(positions=(mirror * angles).tolist(), velocities=(mirror * rates[: len(angles)]).tolist()),
            effects=[fx.Gravity()],
            solver=pp.Solver(samples=41),
        )
        try:
            outcomes.append(("met", pp.simulate(scene, method=method, accuracy=accuracy).stats))
        except pp.RunError as error:
            outcomes.append(("refused", error.partial.stats))
    (one, here), (other, there) = outcomes
    assert one == other
    assert here.error == pytest.approx(there.error, rel=1e-2)
    assert here.steps == there.steps


@law(6)
@given(st.floats(0.3, 2.5), st.floats(1.5, 3.3).map(lambda power: 10.0**power))
@example(2.46875, 562.3413251903491)  # the shifts cancelled: the true error was 0.8 to 1.8 times the estimate
def test_the_estimate_of_rounding_is_near_the_truth(theta: float, duration: float) -> None:
    """Series at their finest err by rounding alone: the estimate is above that, and at most 60 times a usual error.

    Usual is a random walk of a tenth of a unit a step, each over the whole path; a true error may be small by chance.
    """
    scene = swing(theta, duration, 501)
    rounding, run = estimate_rounding(scene, "taylor", 1e-18)
    usual = 0.1 * EPS * np.sqrt(run.stats.steps) * rounding.path
    assert true_error(scene, run) <= rounding.last <= 60 * usual
    assert not rounding.magnified_beyond(1e-11)


@law(6)
@given(st.floats(-12.0, -3.0), st.floats(1.0, 14.0), st.sampled_from([-1.0, 1.0]))
@example(-3.9776, 10.126410259641556, -1.0)  # 260 times low once: shifts in random directions cancelled
@example(-5.25, 13.0, -1.0)  # shifted runs that are a whole turn apart: their distance no longer grows
def test_the_estimate_of_rounding_holds_near_upright(away: float, duration: float, side: float) -> None:
    """A rod that falls and comes back: the rounding of its speed at the bottom decides when it falls again.

    Where shifts move a run too far to be in proportion, the estimate only says that no target up to there is met.
    """
    scene = swing(side * (np.pi - 10.0**away), duration, 101)
    rounding, run = estimate_rounding(scene, "taylor", 1e-18)
    assert true_error(scene, run) <= rounding.last or rounding.last > ROUNDING.linear / ROUNDING.enlargement > 1e-9
    assert rounding.last >= ROUNDING.start_units * EPS * rounding.growth  # no less than the start's own, magnified


def test_what_falls_from_an_unstable_rest_is_magnified() -> None:
    """Its errors grow by e each 0.32 s, a long swing's with its path alone: the first needs further evidence."""
    rounding, _ = estimate_rounding(swing(np.pi - 1e-9, 6.0, 101), "taylor", 1e-18)
    assert rounding.magnified_beyond(1e-11)
    assert rounding.growth > ESTIMATE.noise * np.exp(6.0 / 0.32) / 1e4


# --- other methods --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [0, 2, 6])
def test_auto_tries_other_methods_before_it_refuses(tmp_path: Path, seed: int) -> None:
    """A support along a track from a file, with corners in its acceleration: 1e-9 is met, by rk45 if not by dop853."""
    random, t = np.random.default_rng(seed), np.linspace(0, 4.0, 400)
    track = sum(0.05 / k * np.sin(k * t[:, None] + random.uniform(0, 6, (1, 3))) for k in (1, 2, 5, 9))
    file = tmp_path / "track.csv"
    np.savetxt(file, np.column_stack([t, track]), fmt="%.17g", delimiter=",", header="t,x,y,z", comments="")
    scene = pp.Scene(
        duration=4.0,
        model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.05)]),
        start=pp.Start(positions=[0.4, 0.2]),
        effects=[fx.Gravity(), fx.Support(csv=file)],
    )
    run = pp.simulate(scene, accuracy=1e-9)
    fine = pp.simulate(scene, method="radau", tolerance=1e-13)
    assert np.linalg.norm(run.tips - fine.tips, axis=-1).max() <= run.stats.error <= 1e-9
    assert run.stats.all_seconds > run.stats.seconds
