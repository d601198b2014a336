"""Estimates of error that cannot be fooled: claims hold against exact motions, and what cannot be known is said."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.equations import exact
from pendpin.runs.accuracy.estimate import Gaps, estimate_error
from pendpin.runs.accuracy.runs import Runs, are_equal, refine_by_step, refine_by_tolerance
from pendpin.runs.accuracy.thresholds import ESTIMATE
from pendpin.runs.limits import Deadline
from pendpin.runs.preparation import Prepared
from pendpin.scene import method_of

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
    return float(np.linalg.norm(run.tips[:, 0] - tip, axis=-1).max())


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
    [*((method, 2) for method in FIXED), ("rk4", None)],
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
    refinement = refine_by_step(method, np.linspace(0, duration, samples), wanted)
    finer = refinement.finer(refinement.first, factor)
    counts = [refinement.spacing / step for step in (refinement.first, finer)]
    assert np.allclose(counts, np.round(counts), rtol=1e-12)
    assert round(counts[1]) > round(counts[0])
    assert refinement.predict_fall(refinement.first, finer) >= factor * (1 - 1e-6)


@given(st.sampled_from(["dop853", "taylor", "bdf"]), st.floats(1e-15, 0.1), st.floats(1.0, 1e3))
def test_three_tolerances_differ(method: str, accuracy: float, factor: float) -> None:
    """From the first to the third, before the least is reached, each by at least three."""
    refinement = refine_by_tolerance(method, accuracy)
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
    errors, norm = [], ESTIMATE.small * size / 2
    for k in range(3):
        way = random.normal(size=3) if random.random() < 0.5 or not errors else errors[-1][-1]
        errors.append(np.linspace(0, 1, 20)[:, None] * norm * way / np.linalg.norm(way))
        norm *= scatter * promised ** -(pace if k else 1.0) * 10 ** (-3 * off[k % 2])
    one, two = (np.maximum.accumulate(np.linalg.norm(a - b, axis=-1)) for a, b in pairwise(errors))
    found = estimate_error(Gaps(one, two, (promised, promised), pace, scatter), size, np.full(20, 1e-16), 0.0)
    assert found.error[-1] >= np.linalg.norm(errors[-1], axis=-1).max()


@given(st.floats(1e-9, 1e-2), st.floats(1e-9, 1.0), st.floats(20.0, 1e3), st.floats(1.0, 2.5))
def test_runs_that_agree_by_accident_are_no_evidence(gap: float, accident: float, fall: float, scatter: float) -> None:
    """However small the last gap: the error is not below what the first one says, nor below what the last one says."""
    last = accident * gap / fall**0.85
    found = estimate_error(
        Gaps(np.array([gap]), np.array([last]), (fall, fall), 0.85, scatter), 1.0, np.full(1, 1e-16), 0.0
    ).error[-1]
    assert found >= gap / fall * scatter / fall
    assert found >= last * scatter / fall
    assert found <= ESTIMATE.disagreement * gap + 1e-15


@given(st.floats(1e-12, 1e-3), st.floats(1e-12, 1e-3), st.floats(1.0, 10.0))
def test_an_estimate_never_falls_and_holds_rounding(gap: float, rounding: float, safety: float) -> None:
    """Along a run the error only grows; the rounding is added once, beside the part of the gaps with its margin."""
    gaps = Gaps(np.array([gap, gap, 0.0]), np.array([gap, gap / 50, 0.0]) / 50, (50.0, 50.0), 0.85, 1.0)
    noise = np.full(3, rounding)
    plain, safe = (estimate_error(gaps, 1e3 * (gap + rounding), noise, 0.0, margin).error for margin in (1.0, safety))
    assert (np.diff(plain) >= 0).all()
    assert (plain >= rounding).all()
    np.testing.assert_allclose(safe - rounding, safety * (plain - rounding), rtol=1e-6, atol=1e-12 * rounding)


@given(st.floats(1e-15, 1e-6), st.floats(1.0, 3.0))
def test_gaps_of_rounding_need_not_fall(rounding: float, above: float) -> None:
    """The last gap is within the noise: it says that no finer setting helps, not that the method fails its order."""
    noise = ESTIMATE.noise * rounding
    gaps = Gaps(np.array([above * noise]), np.array([0.9 * noise]), (100.0, 100.0), 0.85, 1.0)
    verdict = estimate_error(gaps, 1.0, np.full(1, rounding), 0.0)
    assert verdict.small
    assert verdict.regular
    assert rounding < verdict.error[-1] <= 2 * above * noise


@given(st.floats(0.1, 1.0), st.floats(1.1, 1.9), st.floats(2.1, 1e3))
def test_runs_are_lost_where_large_gaps_do_not_fall(gap: float, slow: float, fast: float) -> None:
    """Large gaps that fall belong to runs that are only coarse."""
    for fall, lost in ((slow, True), (fast, False)):
        gaps = Gaps(np.array([fall * gap]), np.array([gap]), (100.0, 100.0), 0.85, 1.0)
        assert estimate_error(gaps, gap, np.full(1, 1e-16), 0.0).lost == lost


@given(st.sampled_from(["dop853", "rk45", "rk23", "radau", "bdf", "lsoda"]), st.floats(1.0, 1.5), st.floats(1.0, 1e4))
def test_a_tolerance_that_takes_no_more_steps_promises_nothing(method: str, more: float, ratio: float) -> None:
    """The promised fall is that of the tolerance or that of the steps, whichever is less."""
    refinement = refine_by_tolerance(method, 1e-6)
    assert refinement.predict_fall(1e-6 * ratio, 1e-6, 1.0) == 1.0
    assert refinement.predict_fall(1e-6 * ratio, 1e-6, more) <= more ** method_of(method).steepest
    assert refinement.predict_fall(1e-6 * ratio, 1e-6) == pytest.approx(ratio)


def test_fixed_steps_promise_their_order() -> None:
    """However many steps are counted: half the step of rk4 makes a 16th of the error."""
    refinement = refine_by_step("rk4", np.array([0.0, 1.0]), 10)
    for more in (1.0, 2.0, np.inf):
        assert refinement.predict_fall(0.1, 0.05, more) == pytest.approx(16, rel=1e-12)


@pytest.mark.parametrize(("pace", "scatter"), [(0.85, 1.5), (0.5, 3.0)])
def test_the_bounds_of_what_is_evidence(pace: float, scatter: float) -> None:
    """Gaps that fall with half the expected power are regular; settings are distinct from 1.1 times the scatter on."""
    for beside, good in ((1.001, True), (0.999, False)):
        fallen = 100.0 ** (pace / 2 * beside)
        gaps = Gaps(np.array([1e-3]), np.array([1e-3 / fallen]), (100.0, 100.0), pace, scatter)
        assert estimate_error(gaps, 1.0, np.full(1, 1e-16), 0.0).regular == good
        promised = (1.1 * scatter * beside) ** (1 / pace)
        assert Gaps(gaps.first, gaps.second, (1e9, promised), pace, scatter).distinct == good


@given(st.floats(1e-12, 1e-2), st.floats(1.0, 1.3))
def test_settings_that_change_nothing_are_no_evidence(gap: float, promised: float) -> None:
    """Runs whose steps are the same, because a fast effect bounds them, agree and may both be wrong."""
    gaps = Gaps(np.array([gap]), np.array([gap / 30]), (30.0, promised), 0.7, 2.0)
    assert estimate_error(gaps, 1.0, np.full(1, 1e-16), 0.0).error[-1] == np.inf


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
        assert np.linalg.norm(run.tips - exactly.tips, axis=-1).max() <= run.stats.error <= accuracy


@given(st.integers(0, 2**32 - 1), st.floats(0.2, 10.0))
def test_gaps_of_the_size_of_the_motion_say_nothing(seed: int, size: float) -> None:
    """Whatever their ratios: neither a small gap after a large one nor falling gaps are evidence."""
    one, two = np.random.default_rng(seed).uniform(0, 1, 2) * [10 * size, size]
    gaps = Gaps(np.array([0.0, max(one, ESTIMATE.small * size * 1.01)]), np.array([0.0, two]), (10.0, 10.0), 0.85, 1.0)
    assert estimate_error(gaps, size, np.full(2, 1e-16), 0.0).error[-1] == np.inf


@given(st.floats(1e-10, 1e-3), st.floats(0.5, 3.0))
def test_gaps_that_do_not_fall_are_not_extrapolated(gap: float, ratio: float) -> None:
    """The error is then several times the larger gap, not a tenth of the smaller."""
    gaps = Gaps(np.array([gap]), np.array([gap / ratio]), (30.0, 30.0), 0.85, 1.0)
    error = estimate_error(gaps, 1.0, np.full(1, 1e-16), 0.0).error[-1]
    assert 5 * gap <= error <= ESTIMATE.disagreement * gap * max(1.0, 1 / ratio) * (1 + 1e-5)


def test_a_run_is_not_compared_with_itself() -> None:
    """Where a finer tolerance changes no bit, samples are taken closer; another method decides where that helps nothing."""
    free = swing(0.1, 3.0, 101, 1.0).model_copy(update={"effects": ()})  # at a constant rate: exact for every method
    runs = Runs(Prepared.of(free), lambda t: None, Deadline(None))
    one = runs.run(free.by("dop853", 1e-4))
    assert not are_equal(one, runs.run_differently(free.by("dop853", 1e-4), one)) or one.stats.steps < 10
    for method in ("taylor", "dop853", "lsoda"):
        run = pp.simulate(free, method=method, accuracy=1e-9)
        assert np.abs(run.q[:, 0] - 0.1 - run.t).max() <= 1e-9
        assert 0 < run.stats.error <= 1e-9


@law(50)
@given(error=st.floats(-9, -3), fall=st.floats(30.0, 1e4), pace=st.floats(0.7, 1.0), scatter=st.floats(1.0, 3.0))
def test_the_worst_case_is_claimed_exactly(error: float, fall: float, pace: float, scatter: float) -> None:
    """Two runs that agree, and a third whose error has fallen as little as the scatter allows: the gap tells no less."""
    coarse = 10.0**error
    fine = coarse * scatter / fall**pace
    gaps = Gaps(np.zeros(1), np.array([coarse - fine]), (fall, fall), pace, scatter)
    assert estimate_error(gaps, 1.0, np.zeros(1), 0.0).error[0] == pytest.approx(fine, rel=1e-9)
