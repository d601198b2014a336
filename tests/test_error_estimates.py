"""Estimates of error that cannot be fooled: claims hold against exact motions, and what cannot be known is said."""

import math
import warnings
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.equations import exact
from pendpin.simulation.accuracy.estimate import SMALL, Gaps, estimate
from pendpin.simulation.accuracy.refinement import by_step, by_tolerance
from pendpin.simulation.accuracy.runs import Runs, alike
from pendpin.simulation.limits import Deadline

ROD = pp.Rod(length=1.0, mass=1.0, radius=0.02)
REDUCED = (ROD.properties.I1 + ROD.properties.h**2) / ROD.properties.h  # m, of the simple pendulum that swings alike
FIXED = {"rk4": 3e-7, "gauss2": 1e-4, "gauss4": 1e-7, "gauss6": 1e-8, "euler": 0.1}


def swing(theta: float, duration: float, samples: int | None, rate: float = 0.0) -> pp.Scene:
    """A rod let go in the plane of theta: its motion is known exactly (Jacobi's elliptic functions)."""
    return pp.Scene(
        duration=duration,
        model=pp.Chain(rods=[ROD]),
        start=pp.Start(positions=[theta, 0.0], velocities=[rate, 0.0]),
        effects=[fx.Gravity()],
        solver=pp.Solver(samples=samples),
    )


def true_error(scene: pp.Scene, run: pp.Trajectory) -> float:
    """The largest distance of the tip from the exact motion, over the length."""
    start = scene.start
    angle = exact.planar(start.positions[0], start.velocities[0], REDUCED, 9.81, scene.times[: len(run.t)])
    tip = exact.direction(np.stack([angle, np.zeros_like(angle)], -1))
    return float(np.linalg.norm(run.tips()[:, 0] - tip, axis=-1).max())


def claim_holds(scene: pp.Scene, method: str, accuracy: float) -> bool:
    """Whether the accuracy was met; an estimate that is smaller than the true error fails."""
    try:
        run = pp.simulate(scene, method=method, accuracy=accuracy)
    except pp.RunError as error:
        assert f"accuracy {accuracy:g} is not met: " in str(error)  # noqa: PT017
        return False
    assert true_error(scene, run) <= run.stats.error <= accuracy
    return True


# --- 1: fixed steps -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("method", "samples"),
    [*((method, 2) for method in FIXED), *((method, None) for method in ("rk4", "gauss4", "gauss6"))],
)
def test_fixed_steps_are_those_taken(method: str, samples: int | None) -> None:
    """Whatever the samples cut the steps to: the claim holds, and the step named is the one taken."""
    scene = swing(1.9, 0.5, samples)
    run = pp.simulate(scene, method=method, accuracy=FIXED[method])
    assert true_error(scene, run) <= FIXED[method]
    assert run.stats.steps == round(scene.duration / (run.stats.step or 1))
    again = pp.simulate(scene, method=method, step=run.stats.step)
    assert again.stats.steps == run.stats.steps
    assert np.allclose(run.q, again.q, rtol=0, atol=1e-12)  # the same steps, but for the rounding of their times
    assert run.scene == again.scene
    assert run.t.tolist() == scene.times.tolist()


@given(
    st.sampled_from(list(FIXED)),
    st.floats(1e-3, 1e3),
    st.integers(2, 2000),
    st.integers(1, 5000),
    st.floats(1.0, 1e6),
)
def test_finer_steps_differ(method: str, duration: float, samples: int, wanted: int, factor: float) -> None:
    """Every next step is a whole fraction of the spacing and shorter; the error promised to fall falls at least so much."""
    refinement = by_step(method, np.linspace(0, duration, samples), wanted)
    finer = refinement.finer(refinement.first, factor)
    counts = [refinement.spacing / step for step in (refinement.first, finer)]
    assert np.allclose(counts, np.round(counts), rtol=1e-12)
    assert round(counts[1]) > round(counts[0])
    assert refinement.promised(refinement.first, finer) >= factor * (1 - 1e-6)


@given(st.sampled_from(["dop853", "taylor", "bdf"]), st.floats(1e-15, 0.1), st.floats(1.0, 1e3))
def test_three_tolerances_differ(method: str, accuracy: float, factor: float) -> None:
    """From the first to the third, before the least is reached, each by at least three."""
    refinement = by_tolerance(method, accuracy)
    second = refinement.finer(refinement.first, refinement.usual)
    third = refinement.finer(second, factor)
    assert refinement.least <= third <= second / 3 <= refinement.first / 9


def test_a_low_order_is_refused_beforehand() -> None:
    """Steps by the thousand million are foreseen, with the reason, from runs of some ten thousand."""
    with pytest.raises(
        pp.RunError, match=r"euler is of order 1 and would take about \de\+\d+ steps, about .*; take"
    ) as caught:
        pp.simulate(swing(1.0, 3.0, 61), method="euler", accuracy=1e-10)
    assert caught.value.partial.stats.steps < 1e6


# --- 2: gaps that behave --------------------------------------------------------------------------------------------


@law(25)
@given(
    theta=st.floats(0.1, 3.1),
    duration=st.floats(1.0, 60.0),
    accuracy=st.sampled_from([1e-1, 1e-2, 1e-3, 1e-6, 1e-9]),
    method=st.sampled_from(["dop853", "rk45", "lsoda", "radau"]),
    samples=st.sampled_from([2, 7, 101]),
)
def test_long_swings(theta: float, duration: float, accuracy: float, method: str, samples: int) -> None:
    """First runs that have lost the phase are no evidence."""
    claim_holds(swing(theta, duration, samples), method, accuracy)


@given(
    seed=st.integers(0, 2**32 - 1),
    size=st.floats(1e-8, 1.0),
    promised=st.floats(10.0, 1e4),
    pace=st.floats(0.5, 1.0),
    scatter=st.floats(1.0, 2.5),
    off=st.tuples(st.floats(0, 1), st.floats(0, 1)),
)
def test_the_estimate_is_an_upper_bound(seed, size, promised, pace, scatter, off) -> None:
    """Errors in any directions, each off its power law by up to the scatter, so that gaps may be small by accident."""
    assume(promised**pace > 1.2 * scatter)
    random = np.random.default_rng(seed)
    errors, norm = [], SMALL * size / 2
    for k in range(3):
        way = random.normal(size=3) if random.random() < 0.5 or not errors else errors[-1][-1]
        errors.append(np.linspace(0, 1, 20)[:, None] * norm * way / np.linalg.norm(way))
        norm *= scatter * promised ** -(pace if k else 1.0) * 10 ** (-3 * off[k % 2])
    one, two = (np.maximum.accumulate(np.linalg.norm(a - b, axis=-1)) for a, b in pairwise(errors))
    found = estimate(Gaps(one, two, (promised, promised), pace, scatter), size, np.full(20, 1e-16), 0.0)
    assert found.error[-1] >= np.linalg.norm(errors[-1], axis=-1).max()


@given(st.floats(1e-12, 1e-2), st.floats(1.0, 1.3))
def test_settings_that_change_nothing_are_no_evidence(gap: float, promised: float) -> None:
    """Runs whose steps are the same, because a fast effect bounds them, agree and may both be wrong."""
    gaps = Gaps(np.array([gap]), np.array([gap / 30]), (30.0, promised), 0.7, 2.0)
    assert estimate(gaps, 1.0, np.full(1, 1e-16), 0.0).error[-1] == np.inf


@pytest.mark.parametrize("method", ["dop853", "rk45", "lsoda"])
@pytest.mark.parametrize("samples", [2, 61])
def test_steps_that_an_effect_bounds(method: str, samples: int) -> None:
    """A fast motor bounds the steps, so that loose tolerances give runs that are almost the same: the estimate holds."""
    scene = swing(0.4, 6.0, samples, 0.3)
    scene = scene.model_copy(
        update={"effects": (*scene.effects, fx.Motor(joint="theta", amplitude=2.0, frequency=30.0))}
    )
    exactly = pp.simulate(scene, method="taylor", tolerance=1e-18)
    for accuracy in (1e-2, 1e-4, 1e-6):
        run = pp.simulate(scene, method=method, accuracy=accuracy)
        assert np.linalg.norm(run.tips() - exactly.tips(), axis=-1).max() <= run.stats.error <= accuracy


@given(st.integers(0, 2**32 - 1), st.floats(0.2, 10.0))
def test_gaps_of_the_size_of_the_motion_say_nothing(seed: int, size: float) -> None:
    """Whatever their ratios: neither a small gap after a large one nor falling gaps are evidence."""
    one, two = np.random.default_rng(seed).uniform(0, 1, 2) * [10 * size, size]
    gaps = Gaps(np.array([0.0, max(one, SMALL * size * 1.01)]), np.array([0.0, two]), (10.0, 10.0), 0.85, 1.0)
    assert estimate(gaps, size, np.full(2, 1e-16), 0.0).error[-1] == np.inf


@given(st.floats(1e-10, 1e-3), st.floats(0.5, 3.0))
def test_gaps_that_do_not_fall_are_not_extrapolated(gap: float, ratio: float) -> None:
    """The error is then several times the larger gap, not a tenth of the smaller."""
    gaps = Gaps(np.array([gap]), np.array([gap / ratio]), (30.0, 30.0), 0.85, 1.0)
    assert estimate(gaps, 1.0, np.full(1, 1e-16), 0.0).error[-1] >= 5 * gap


def test_a_run_is_not_compared_with_itself() -> None:
    """Where a finer tolerance changes no bit, samples are taken closer; another method decides where that helps nothing."""
    free = swing(0.1, 3.0, 101, 1.0).model_copy(update={"effects": ()})  # at a constant rate: exact for every method
    runs = Runs(free, False, lambda t: None, Deadline(None))
    one = runs.run(free.by("dop853", 1e-4))
    assert not alike(one, runs.unlike(free.by("dop853", 1e-4), one)) or one.stats.steps < 10
    for method in ("taylor", "dop853", "lsoda"):
        run = pp.simulate(free, method=method, accuracy=1e-9)
        assert np.abs(run.q[:, 0] - 0.1 - run.t).max() <= 1e-9
        assert 0 < run.stats.error <= 1e-9


# --- 3: rounding ----------------------------------------------------------------------------------------------------


@law(15)
@given(
    away=st.sampled_from([0.0, 1e-12, 1e-9, 1e-6, 1e-3]),
    duration=st.floats(1.0, 15.0),
    accuracy=st.sampled_from([1e-2, 1e-4, 1e-6, 1e-9]),
    method=st.sampled_from(["auto", "dop853", "rk45", "radau", "bdf", "lsoda", "rk4"]),
)
@example(away=1e-9, duration=9.84971296208291, accuracy=1e-2, method="dop853")  # 1.5 times low once
@example(
    away=2.7203057531455935e-12, duration=5.079516041323486, accuracy=1e-4, method="bdf"
)  # all runs stayed at rest
def test_from_the_unstable_rest(away: float, duration: float, accuracy: float, method: str) -> None:
    """Upside down the rounding of pi and of every step grows by e each 0.26 s."""
    claim_holds(swing(math.pi - away, duration, 61), method, accuracy)


@law(8)
@given(
    away=st.lists(st.floats(-9.0, -3.0), min_size=4, max_size=4),
    lower=st.sampled_from([0.0, math.pi]),
    duration=st.floats(1.0, 5.0),
    accuracy=st.sampled_from([1e-1, 1e-2, 1e-4]),
    method=st.sampled_from(["auto", "dop853", "rk45", "radau", "bdf", "lsoda", "gauss6"]),
)
@example(
    away=[-9.7, -6.5, -12, -12], lower=math.pi, duration=3.494, accuracy=4.5e-2, method="radau"
)  # 5 times low once
def test_double_pendulums_from_unstable_rests(away, lower, duration, accuracy, method) -> None:
    """Both rods or one upside down: what a claim says holds against the series with their own rounding."""
    rods = [pp.Rod(length=0.883, mass=0.227, radius=0.05), pp.Rod(length=0.901, mass=1.985, radius=0.05)]
    angles = np.array([math.pi, 0.0, lower, 0.0]) + 10.0 ** np.array(away)
    scene = pp.Scene(
        duration=duration, model=pp.Chain(rods=rods), start=pp.Start(positions=angles.tolist()), effects=[fx.Gravity()]
    )
    try:
        run = pp.simulate(scene, method=method, accuracy=accuracy)
    except pp.RunError as error:
        assert f"accuracy {accuracy:g} is not met: " in str(error)  # noqa: PT017
        return
    exact, other = (pp.simulate(scene, method="taylor", tolerance=tolerance).tips() for tolerance in (1e-18, 1e-16))
    far, doubt = (np.linalg.norm(tips - exact, axis=-1).max() / 1.784 for tips in (run.tips(), other))
    assert far - doubt <= run.stats.error <= accuracy


@law(8)
@given(
    theta=st.floats(0.4, 1.2),
    friction=st.floats(0.02, 0.15),
    accuracy=st.sampled_from([1e-2, 1e-3]),
    method=st.sampled_from(["auto", "radau", "bdf", "lsoda", "dop853", "rk45", "rk4"]),
)
@example(theta=0.7, friction=0.1, accuracy=1e-3, method="auto")  # 49 times low once: the start is on the jump
@example(theta=0.7, friction=0.1, accuracy=1e-3, method="bdf")
def test_functions_that_jump(theta: float, friction: float, accuracy: float, method: str) -> None:
    """A user's torque that jumps with the rate, let go at rest, is dry friction that never sticks: claims hold."""
    scene = swing(theta, 1.5, 31)
    slides = [*scene.effects, fx.DryFriction(kinetic=friction, joints=["theta"])]
    jumps = [*scene.effects, fx.Torque(lambda t, q, v: -friction * np.sign(v), joints=["theta"])]
    true = pp.simulate(scene.replace(effects=slides), tolerance=1e-12).tips()
    try:
        run = pp.simulate(scene.replace(effects=jumps), method=method, accuracy=accuracy)
    except pp.RunError:
        assert method in {"radau", "bdf", "lsoda"}  # these may not get across
        return
    assert np.linalg.norm(run.tips() - true, axis=-1).max() <= run.stats.error <= accuracy


@pytest.mark.parametrize(("method", "theta", "duration"), [("dop853", 2.8, 3e3), ("lsoda", 3.0, 2e3)])
def test_coarse_runs_that_turn_over_are_no_chaos(method: str, theta: float, duration: float) -> None:
    """Coarse runs gain energy until the rod turns over the top, and are then unstable; the true motion is not."""
    assert claim_holds(swing(theta, duration, 501), method, 1e-3)


def test_an_unstable_rest_is_refused_when_rounding_decides() -> None:
    """From pi, as well as doubles can say it: 15 s is beyond what anyone can tell, 4 s is not."""
    with pytest.raises(pp.RunError, match="rounding errors of the start and of the steps grow") as caught:
        pp.simulate(swing(math.pi, 15.0, 61), accuracy=1e-6)
    assert caught.value.partial.stats.error > 1e-6
    assert claim_holds(swing(math.pi, 4.0, 61), "auto", 1e-6)


def _heavy(*case: Any) -> Any:
    return pytest.param(*case, marks=pytest.mark.slow)


@pytest.mark.parametrize(
    ("method", "accuracy"),
    [
        *((method, accuracy) for method in ("dop853", "taylor") for accuracy in (1e-2, 1e-4, 1e-6)),
        *(("gauss4", 1e-4), ("rk4", 1e-4)),
        *(_heavy("gauss4", accuracy) for accuracy in (1e-2, 1e-6)),
        *(_heavy("rk4", accuracy) for accuracy in (1e-2, 1e-6)),
    ],
)
def test_rounding_on_the_way_counts(method: str, accuracy: float) -> None:
    """Let go 1e-6 rad from upright it comes round to 1e-6 rad from upright: rounding at the bottom decides when it falls."""
    claim_holds(swing(math.pi + 1e-6, 13.0, 31), method, accuracy)


@pytest.mark.parametrize("method", ["auto", "dop853", "rk4"])
def test_turns_cost_digits(method: str) -> None:
    """An angle of 2e8 pi + 0.5 is known to 1e-7 only: a finer accuracy is refused, a coarser one met."""
    far = swing(2e8 * math.pi + 0.5, 2.0, 61)
    with pytest.raises(pp.RunError, match="finer than the start, where theta = "):
        pp.simulate(far, method=method, accuracy=1e-9)
    if method != "dop853":  # its relative tolerance is one of 6e8 rad
        assert claim_holds(far, method, 1e-4)


def test_the_estimate_holds_the_rounding_of_every_step() -> None:
    """A long run at the finest tolerance: its error is rounding, and the claim is not below it."""
    scene = swing(2.0, 100.0, 31)
    run = pp.simulate(scene, method="dop853", accuracy=1e-9)
    assert true_error(scene, run) <= run.stats.error


# --- few samples, slides, limits ------------------------------------------------------------------------------------


def test_few_samples_are_looked_at_closely() -> None:
    """Two output times at which the tip is by chance where a lost run has it do not make an estimate."""
    scene = swing(2.9, 40.0, 2)
    run = pp.simulate(scene, accuracy=1e-3)
    assert len(run.t) == 2
    assert true_error(scene, run) <= 1e-3
    dense = pp.simulate(swing(2.9, 40.0, 129), method=run.stats.method, tolerance=run.stats.tolerance)
    assert true_error(swing(2.9, 40.0, 129), dense) <= 1e-3


def test_output_times_of_any_spacing() -> None:
    """One late time, or times crowded and far apart: the claim holds at those asked for, and they are what comes back."""
    scene = swing(2.6, 20.0, 41)
    for times in ([20.0], [0.0, 1e-9, 3.0, 3.001, 20.0], [0.1, 19.0]):
        for method in ("auto", "rk45", "rk4", "gauss4"):
            run = pp.simulate(scene, times=times, method=method, accuracy=1e-4)
            assert run.t.tolist() == times
            angle = exact.planar(2.6, 0.0, REDUCED, 9.81, run.t)
            assert np.abs(run.q[:, 0] - angle).max() <= 1e-4


SLIDE = """<robot name="slide"><link name="base"/><link name="car"><inertial><mass value="2"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="x" type="prismatic">
<parent link="base"/><child link="car"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"""


@pytest.mark.parametrize("method", ["auto", "dop853", "rk4"])
@pytest.mark.parametrize("start", [(0.0, 0.0), (0.3, 0.0), (0.0, 1.0)])
def test_a_slide_has_a_length(tmp_path: Path, method: str, start: tuple[float, float]) -> None:
    """Errors of a slide are over the way that it goes; no NaN, no warning of NumPy."""
    file = tmp_path / "slide.urdf"
    file.write_text(SLIDE)
    scene = pp.Scene(
        duration=2.0,
        model=pp.UrdfModel(path=file),
        start=pp.Start(positions={"x": start[0]}, velocities={"x": start[1]}),
        effects=[fx.Spring(stiffness=8.0)],
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        run = pp.simulate(scene, method=method, accuracy=1e-6)
    exactly = start[0] * np.cos(2 * run.t) + start[1] / 2 * np.sin(2 * run.t)
    assert np.abs(run.q[:, 0] - exactly).max() <= 1e-6 * max(np.abs(exactly).max(), 1e-300)
    assert 0 <= run.stats.error <= 1e-6


def test_a_limit_is_of_all_runs_together() -> None:
    """The error names the limit and holds the run so far."""
    with pytest.raises(pp.RunError, match=r"it takes over 0\.01 s") as caught:
        pp.simulate(swing(2.0, 1000.0, 2), accuracy=1e-9, method="rk45", limit=0.01)
    assert len(caught.value.partial.t) <= 2
