"""Accuracy as the target: what is returned is as accurate as was asked, and what cannot be reached is said."""

import re
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.model.build import build
from pendpin.model.kinematics import chain_length, tip_distance
from pendpin.runs.preparation import Prepared
from pendpin.runs.run import run_prepared

needs_heyoka = pytest.mark.skipif(find_spec("heyoka") is None, reason="heyoka is not installed: pip install heyoka")
ROD = pp.Rod(length=1.0, mass=1.0, radius=0.05)
SWING = pp.Start(positions=[0.7, 0.4], velocities=[1.3, -0.8])


def scene(*effects: fx.Effect, rods: tuple[pp.Rod, ...] = (ROD,), start: pp.Start = SWING, duration: float = 3.0):
    chosen = pp.Solver(samples=61)
    return pp.Scene(
        duration=duration, model=pp.Chain(rods=rods), start=start, effects=(fx.Gravity(), *effects), solver=chosen
    )


def error(run: pp.Trajectory, asked: pp.Scene) -> float:
    """The true error: the largest tip distance to a run far finer, over the length."""
    truth = pp.simulate(asked, method="taylor" if find_spec("heyoka") else "dop853", tolerance=1e-14)
    return float(tip_distance(truth.tips, run.tips, chain_length(build(asked.model))).max())


@needs_heyoka
@law(5)
@given(
    lengths=st.lists(st.floats(0.3, 2.0), min_size=1, max_size=3),
    radius=st.sampled_from([0.0, 0.05]),
    viscous=st.sampled_from([0.0, 0.05]),
    angle=st.floats(-0.8, 0.8),
    accuracy=st.sampled_from([1e-4, 1e-7, 1e-10]),
)
def test_what_is_asked_is_met(lengths, radius, viscous, angle, accuracy) -> None:
    """The true error of random smooth scenes is within the asked one, and the estimate is no promise below the truth."""
    rods = tuple(pp.Rod(length=length, mass=1.0, radius=radius * length) for length in lengths)
    start = pp.Start(positions=np.resize([angle, 0.3, -0.2], 2 * len(rods)).tolist())
    asked = scene(*([fx.Viscous(coefficient=viscous)] if viscous else []), rods=rods, start=start)
    run = pp.simulate(asked, accuracy=accuracy)
    assert run.stats.accuracy == accuracy
    assert run.stats.error <= accuracy
    assert error(run, asked) <= accuracy
    assert run.stats.all_seconds > run.stats.seconds


@pytest.mark.parametrize(
    ("method", "accuracy"),
    [
        *((method, 1e-6) for method in ("dop853", "rk45", "radau", "lsoda", "rk4", "gauss4", "gauss6")),
        ("gauss2", 1e-5),
        pytest.param("gauss2", 1e-6, marks=pytest.mark.slow),
        ("euler", 1e-2),
    ],
)
def test_every_method_can_be_held_to_it(method: str, accuracy: float) -> None:
    """A method named is the one used; its tolerance or step is found."""
    asked = scene(duration=1.0)
    run = pp.simulate(asked, method=method, accuracy=accuracy)
    assert run.stats.method == method
    assert error(run, asked) <= accuracy


def test_nonsmooth_effects_and_contacts() -> None:
    """Scenes that are off the Taylor integrator: against the same at a tolerance of 1e-13."""
    for effects in ((fx.Drag(),), (fx.DryFriction(kinetic=0.1),), (fx.Stop(upper=0.9, joints=("theta_1",)),)):
        asked = scene(*effects)
        run, truth = pp.simulate(asked, accuracy=1e-6), pp.simulate(asked, method="dop853", tolerance=1e-13)
        assert tip_distance(truth.tips, run.tips, 1.0).max() <= 1e-6


def test_chaos_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """A double pendulum thrown hard: 1e-8 cannot be had for 40 s; the message holds the run, after few runs."""
    tolerances: list[float] = []

    def noted(asked: Prepared, *args: Any, **options: Any) -> pp.Trajectory:
        tolerances.append(asked.scene.solver.tolerance or 0.0)
        return run_prepared(asked, *args, **options)

    monkeypatch.setattr("pendpin.runs.accuracy.runs.run_prepared", noted)
    wild = scene(
        rods=(ROD, ROD), start=pp.Start(positions=[2.0, 0.3, -1.0, 0.5], velocities=[3, 1, -2, 4]), duration=40.0
    )
    with pytest.raises(pp.RunError, match=r"accuracy 1e-08 is not met: .* it is met up to t = ") as caught:
        pp.simulate(wild, accuracy=1e-8)
    assert caught.value.partial.t[-1] == 40.0
    assert caught.value.partial.stats.error > 1e-8
    assert len(tolerances) == 9  # three ever finer, two pairs that differ by rounding, and the finest two


@pytest.mark.parametrize("method", ["auto", "dop853", "gauss4", "euler"])
def test_rounding_is_said(method: str) -> None:
    """A target that no number can hold is refused before anything is integrated, and no method is advised."""
    with pytest.raises(pp.RunError, match="accuracy 1e-16 is not met: it is finer than numbers of 64 bits") as refusal:
        pp.simulate(scene(), method=method, accuracy=1e-16)
    assert refusal.value.partial.stats.steps == 0
    with pytest.raises(pp.InputError, match="accuracy: 1e-16 is finer than can be measured"):
        pp.cost(scene(), methods=[method.replace("auto", "rk4")], accuracy=1e-16)


def test_steps_that_cost_more_are_fewer() -> None:
    """A million steps of gauss2 take minutes, as ten millions of euler do: both are foretold, and another method named."""
    for method, accuracy in (("gauss2", 1e-12), ("euler", 1e-9)):
        with pytest.raises(pp.RunError, match=r"would take about .* steps, about .*, such as dop853; ") as refusal:
            pp.simulate(scene(duration=0.5), method=method, accuracy=accuracy)
        assert refusal.value.partial.stats.steps < 1e5


@pytest.mark.parametrize("method", ["auto", "rk4", "gauss4"])
def test_a_start_alone_is_exact(method: str) -> None:
    """A duration of 0: one sample, and no error to make."""
    alone = scene().model_copy(update={"duration": 0.0, "solver": pp.Solver()})
    run = pp.simulate(alone, method=method, accuracy=1e-6)
    assert run.stats.error == 0
    assert run.q.tolist() == [[0.7, 0.4]]


def test_a_start_in_degrees_is_that_in_radians() -> None:
    """The same runs, estimate and all: shifted starts are in radians, whatever the unit of the scene."""
    angles, rates = {"theta": 0.5, "phi": -0.3}, {"theta": 1.0}
    found = []
    for unit, factor in (("radians", 1.0), ("degrees", 180 / np.pi)):
        positions, velocities = ({joint: factor * x for joint, x in given.items()} for given in (angles, rates))
        start = pp.Start(positions=positions, velocities=velocities, unit=unit)
        scene = pp.Scene(duration=3.0, model=pp.Chain(rods=[ROD]), start=start, effects=[fx.Gravity()])
        found.append(pp.simulate(scene, accuracy=1e-7))
    one, other = found
    assert np.abs(one.q - other.q).max() < 1e-13
    assert one.stats.error == pytest.approx(other.stats.error, rel=1e-3)


def test_rest_is_exact() -> None:
    """Nothing moves: any accuracy is met at once."""
    run = pp.simulate(scene(start=pp.Start()), accuracy=1e-10)
    assert np.array_equal(run.q, np.zeros_like(run.q))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"accuracy": 0.0}, "accuracy: 0.0 is not above 0"),
        ({"accuracy": 0.2}, "accuracy: 0.2 is above 0.1"),
        ({"accuracy": 1e-6, "tolerance": 1e-6}, "tolerance: an accuracy is given"),
        ({"accuracy": 1e-6, "method": "rk4", "step": 0.1}, "step: an accuracy is given"),
    ],
)
def test_options_that_do_not_fit(options: dict, message: str) -> None:
    with pytest.raises(pp.InputError) as caught:
        pp.simulate(scene(), **options)
    assert message in str(caught.value)


def test_a_finer_run_that_fails_ends_in_a_refusal_at_the_output_times() -> None:
    """bdf's steps become shorter than doubles can tell, in a motion that magnifies errors."""
    scene = pp.Scene(
        duration=2.897261406785438,
        model=pp.Chain(
            rods=[
                pp.Rod(
                    length=1.4634650660048842,
                    mass=1.076048519538486,
                    radius=0.1300525160843814,
                    payload=4.125608572069971,
                ),
                pp.Rod(length=0.6306876093768377, mass=0.8046756985761025, radius=0.019892746732437135),
            ]
        ),
        start=pp.Start(
            positions=[-0.8828507591693828, 1.8486459754765727, 2.0498544516147534, 2.0205870873412977],
            velocities=[1.2526379494058735, -1.1330675866604931, -0.6323030410004823, -0.3128772118911495],
        ),
        effects=[pp.effects.Gravity(), pp.effects.Spring(stiffness=2.6846037429580534, rest=0.2405687062612889)],
        solver=pp.Solver(method="bdf", accuracy=1e-6, samples=31),
    )
    with pytest.raises(pp.RunError, match=r"^accuracy 1e-06 is not met: ") as caught:
        pp.simulate(scene)
    partial = caught.value.partial
    np.testing.assert_array_equal(partial.t, scene.times[: len(partial.t)])


@pytest.mark.parametrize(
    ("angles", "duration", "least"), [((2.0, 0.0, 1.0, 0.0), 20.0, 10.0), ((1.5, 0.6, 2.5, 0), 40.0, 3.0)]
)
def test_a_refusal_in_chaos_says_how_far_the_finest_run_reaches(angles, duration, least) -> None:
    """Two rods that turn over: the time in the message is reached by a run of its own, and the partial run is true there."""
    chain = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.02),), copies=2)
    scene = pp.Scene(duration=duration, model=chain, start=pp.Start(positions=angles), effects=(pp.effects.Gravity(),))
    with pytest.raises(pp.RunError, match="no setting meets it over the whole run") as caught:
        pp.simulate(scene, accuracy=1e-6)
    reached = float(re.search(r"met up to t = ([0-9.]+) s", str(caught.value)).group(1))
    assert reached >= least
    run = caught.value.partial
    end = int(np.argmin(np.abs(run.t - reached)))
    shorter = pp.simulate(scene, duration=run.t[end], accuracy=1e-6, samples=61)
    assert np.linalg.norm(run.tips[end] - shorter.tips[-1], axis=-1).max() <= 2.0 * (
        1e-6 + shorter.stats.error
    )  # 2 m long
