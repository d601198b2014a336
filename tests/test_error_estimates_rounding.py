"""Estimates of errors where rounding counts, with few samples, and on slides."""

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.equations import exact
from pendpin.runs.accuracy.runs import Runs
from pendpin.runs.run import run_prepared
from test_accuracy_measures import SLIDE
from test_error_estimates import REDUCED, claim_holds, swing, true_error

# --- 3: rounding ----------------------------------------------------------------------------------------------------


@law(15)
@given(
    away=st.sampled_from([0.0, 1e-12, 1e-9, 1e-6, 1e-3]),
    duration=st.floats(1.0, 15.0),
    accuracy=st.sampled_from([1e-2, 1e-4, 1e-6, 1e-9]),
    method=st.sampled_from(["auto", "dop853", "rk45", "radau", "bdf", "lsoda", "rk4"]),
)
@example(away=1e-9, duration=9.84971296208291, accuracy=1e-2, method="dop853")  # 1.5 times low once
@example(away=1e-9, duration=4.625, accuracy=1e-4, method="dop853")  # 1.9 times low once: two runs agreed by accident
@example(away=1e-9, duration=4.553039495800414, accuracy=1e-4, method="dop853")  # 1.3 times low once
@example(
    away=2.7203057531455935e-12, duration=5.079516041323486, accuracy=1e-4, method="bdf"
)  # all runs stayed at rest
def test_from_the_unstable_rest(away: float, duration: float, accuracy: float, method: str) -> None:
    """Upside down the rounding of pi and of every step grows by e each 0.26 s."""
    claim_holds(swing(math.pi - away, duration, 61), method, accuracy)


@pytest.mark.slow
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
@example(away=[-6.0, -5.0, -6.0, -6.0], lower=math.pi, duration=3.0, accuracy=1e-4, method="radau")  # 3 times low once
@example(away=[-6.0, -5.0, -6.0, -6.0], lower=math.pi, duration=2.5, accuracy=1e-4, method="radau")  # 10 times low once
def test_double_pendulums_from_unstable_rests(away, lower, duration, accuracy, method) -> None:
    """Both rods or one upside down: what a claim says holds against the series with their own rounding."""
    scene = _double(np.array([math.pi, 0.0, lower, 0.0]) + 10.0 ** np.array(away), duration)
    try:
        run = pp.simulate(scene, method=method, accuracy=accuracy)
    except pp.RunError as error:
        assert f"accuracy {accuracy:g} is not met: " in str(error)  # noqa: PT017
        return
    exact, other = (pp.simulate(scene, method="taylor", tolerance=tolerance).tips for tolerance in (1e-18, 1e-16))
    far, doubt = (np.linalg.norm(tips - exact, axis=-1).max() / 1.784 for tips in (run.tips, other))
    assert far - doubt <= run.stats.error <= accuracy


def _double(angles: np.ndarray, duration: float) -> pp.Scene:
    rods = [pp.Rod(length=0.883, mass=0.227, radius=0.05), pp.Rod(length=0.901, mass=1.985, radius=0.05)]
    start = pp.Start(positions=angles.tolist())
    return pp.Scene(duration=duration, model=pp.Chain(rods=rods), start=start, effects=[fx.Gravity()])


@pytest.mark.parametrize("method", ["gauss6", "rk4"])
def test_fixed_steps_are_not_halved_for_ever_in_chaos(monkeypatch: pytest.MonkeyPatch, method: str) -> None:
    """Where rounding decides, a search ends after a few coarse runs: no step is short enough (once 1e7 steps were tried)."""
    evaluations, run_once = [], Runs.run

    def counted(*arguments: Any, **options: Any) -> pp.Trajectory:
        run = run_once(*arguments, **options)
        evaluations.append(run.stats.evaluations)
        return run

    monkeypatch.setattr(Runs, "run", counted)
    scene = _double(
        np.array([3.1415928248974745, 2.682487408405094e-8, 1.9121128921930715e-8, 1.8479139289026185e-6]),
        4.811819219412128,
    )
    with pytest.raises(pp.RunError, match="rounding errors of the start and of the steps grow"):
        pp.simulate(scene, method=method, accuracy=0.1)
    assert sum(evaluations) < 2e5  # two runs at 1e-12 take 4e4


@pytest.mark.slow
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
    true = pp.simulate(scene.replace(effects=slides), tolerance=1e-12).tips
    try:
        run = pp.simulate(scene.replace(effects=jumps), method=method, accuracy=accuracy)
    except pp.RunError:
        assert method in {"radau", "bdf", "lsoda"}  # these may not get across
        return
    assert np.linalg.norm(run.tips - true, axis=-1).max() <= run.stats.error <= accuracy


@pytest.mark.parametrize(
    ("method", "theta", "duration"), [("dop853", 2.8, 3e3), pytest.param("lsoda", 3.0, 2e3, marks=pytest.mark.slow)]
)
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


def test_two_methods_may_agree_by_accident_near_an_unstable_rest() -> None:
    """A motion smaller than its target: two methods were 3e-9 apart, both 1e-7 wrong; no claim is below target / 1000."""
    scene = swing(math.pi - 1e-9, 2.778759007947322, 121)
    assert claim_holds(scene, "dop853", 1e-2)
    assert pp.simulate(scene, method="dop853", accuracy=1e-2).stats.error >= 1e-5


@pytest.mark.parametrize(
    ("theta", "duration", "method", "accuracy"),
    [
        (2.6, 20.0, "gauss6", 1e-10),  # finer than another method can tell: it went on and on once
        pytest.param(2.6, 20.0, "gauss6", 3e-12, marks=pytest.mark.slow),
        (3.1, 8.0, "gauss6", 1e-10),  # just above what rounding does: the same
        (2.6, 20.0, "radau", 1e-10),
    ],
)
def test_a_search_ends_where_nothing_is_gained(
    monkeypatch: pytest.MonkeyPatch, theta: float, duration: float, method: str, accuracy: float
) -> None:
    """A few runs decide: the accuracy is met or refused, however close it is to what rounding allows."""
    count = [0]

    def counted(*arguments: Any, **options: Any) -> pp.Trajectory:
        count[0] += 1
        return run_prepared(*arguments, **options)

    monkeypatch.setattr("pendpin.runs.accuracy.runs.run_prepared", counted)
    claim_holds(swing(theta, duration, 41), method, accuracy)
    assert count[0] <= 10


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
    for times in ([20.0], [0.0, 1e-9, 3.0, 3.001, 19.0]):
        for method in ("auto", "rk45", "rk4", "gauss4"):
            run = pp.simulate(scene, times=times, method=method, accuracy=1e-4)
            assert run.t.tolist() == times
            angle = exact.planar(2.6, 0.0, REDUCED, 9.81, run.t)
            assert np.abs(run.q[:, 0] - angle).max() <= 1e-4


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
