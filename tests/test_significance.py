"""What effects change: verdicts that follow from the physics."""

import numpy as np
import pytest

import pendpin as pp
from pendpin.effects import Gravity, Rotation, Spring, Viscous
from pendpin.sweeps import significance as significance_module
from pendpin.sweeps.significance import significance
from scenes import scene_of

ROD = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.05),))


def swing(*effects, model=ROD, q=(0.5, 0.2), **given) -> pp.Scene:
    """A short run of one rod."""
    return scene_of(model, *effects, q=q, **given)


def test_gravity_is_needed_and_a_spring_of_no_stiffness_is_not() -> None:
    """What moves the tip by more than the accuracy is needed; what does nothing changes exactly nothing."""
    rows = {row.effect: row for row in significance(swing(Gravity(), Spring(stiffness=0.0)), 1e-3).rows}
    assert rows["gravity"].verdict == "needed"
    assert rows["spring"].change == 0.0
    assert rows["spring"].verdict == "not needed"
    assert rows["spring"].added >= 0.0


def test_the_verdict_follows_the_accuracy() -> None:
    """Earth's rotation matters at 1e-6 and not at 1e-2; it is offered where the scene lacks it, and only there."""
    scene = swing(Gravity())
    for accuracy, verdict in ((1e-2, "not needed"), (1e-6, "needed")):
        (row,) = [row for row in significance(scene, accuracy).rows if "rotation" in row.effect]
        assert row.verdict == verdict
        assert not row.listed
    listed = significance(swing(Gravity(), Rotation(latitude=45.0)), 1e-2).rows
    assert [row.listed for row in listed if "otation" in row.effect] == [True]


@pytest.mark.parametrize("times", [(0.0, 1.0, 5.0), (1.0, 5.0)])
def test_uneven_times_change_no_verdict(times: tuple[float, ...]) -> None:
    """Both runs are compared at the same instants: gravity is needed whatever times the scene asks for."""
    rows = {row.effect: row for row in significance(swing(Gravity(), duration=5.0, times=times)).rows}
    assert rows["gravity"].verdict == "needed"


def test_a_change_is_the_distance_of_the_tips() -> None:
    """Viscous damping's change is what two runs differ by."""
    scene = swing(Gravity(), Viscous(coefficient=0.05))
    (row,) = [row for row in significance(scene, 1e-3).rows if row.effect == "viscous"]
    with_it, without = (pp.simulate(s, tolerance=1e-7) for s in (scene, swing(Gravity())))
    assert row.change == pytest.approx(np.linalg.norm(with_it.tips - without.tips, axis=-1).max(), rel=1e-6)


def test_chaos_ends_the_comparison() -> None:
    """A wild triple pendulum is compared only as far as its own run can be believed."""
    model = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.02),) * 2)
    found = significance(swing(Gravity(), model=model, duration=30.0, q=(2.5, 0.3, 2.0, 0.5)), 1e-4)
    assert 0 < found.horizon < 30.0
    calm = significance(swing(Gravity()), 1e-4)
    assert calm.horizon == 2.0


def test_a_clock_that_stands_still_adds_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Evaluations too short for the clock."""
    monkeypatch.setattr(significance_module, "_measure_evaluation", lambda run, engine: 0.0)
    assert {row.added for row in significance(swing(Gravity(), Viscous(coefficient=0.1)), 1e-3).rows} <= {0.0, None}
