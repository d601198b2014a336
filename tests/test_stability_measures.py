"""Frequencies, damping and stability as measures of a sweep, against closed forms."""

import numpy as np
import pytest

import pendpin as pp
from pendpin import effects as fx

pytest.importorskip("llvmlite", reason="llvmlite is not installed: pip install 'pendpin[fast]'")
THIN = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)])
UPRIGHT = pp.Start(positions={"theta": np.pi})


def measured(scene: pp.Scene, key: str, values: list[float], *names: str) -> list[list[float]]:
    found = pp.sweep(scene, {key: values}, list(names), workers=1)
    return [found[name].values.tolist() for name in names]


def test_kapitza_s_tongue() -> None:
    """A point mass at 0.2 m, shaken at 300 rad/s, stands upright from 0.0066046038 to 0.0909876411 m."""
    scene = pp.Scene(
        model=pp.Chain(rods=[pp.Rod(length=0.2, mass=0.0, payload=1.0)]),
        effects=[fx.Gravity(), fx.Support(amplitude=(0.0, 0.0, 0.01), frequency=300.0)],
        start=UPRIGHT,
        duration=0.0,
    )
    values = [0.00660, 0.006604, 0.006605, 0.05, 0.09098, 0.0910]
    stable, multiplier = measured(scene, "effects[1].amplitude[2]", values, "stable", "multiplier")
    assert stable == [0, 0, 1, 1, 1, 0]
    assert all((x > 1 + 1e-5) == (not ok) for x, ok in zip(multiplier, stable, strict=True))


def test_a_rod_that_a_spring_holds_up() -> None:
    """Upright it is stable from k = m g l / 2 on, with omega² = (k - m g l / 2) / I and zeta = c / (2 I omega)."""
    springs = [fx.Spring(stiffness=6.0, rest=np.pi, joints=["theta"]), fx.Spring(stiffness=9.0, joints=["phi"])]
    effects = [fx.Gravity(), fx.Viscous(coefficient=0.1), *springs]
    scene = pp.Scene(model=THIN, effects=effects, start=UPRIGHT, duration=0.0)
    values = [4.90, 4.91, 6.0]
    key = "effects[2].stiffness"
    stable, omega, zeta = measured(scene, key, values, "stable", "frequency_1", "damping_1")
    assert stable == [0, 1, 1]
    expected = np.sqrt((6.0 - 4.905) * 3)
    assert omega[2] == pytest.approx(expected, rel=1e-9)
    assert zeta[2] == pytest.approx(0.1 * 3 / (2 * expected), rel=1e-9)


def test_an_unstable_rest_is_left() -> None:
    """`Start.at_rest` from upright, where nothing pulls, is a rest that stays: the rod falls, held by a weak spring."""
    springs = [fx.Spring(stiffness=1.0, rest=np.pi, joints=["theta"]), fx.Spring(stiffness=9.0, joints=["phi"])]
    scene = pp.Scene(model=THIN, effects=[fx.Gravity(), *springs], start=UPRIGHT)
    theta = pp.Start.at_rest(scene).positions["theta"]
    assert abs(theta - np.pi) > 1
    assert 4.905 * np.sin(theta) == pytest.approx(np.pi - theta, rel=1e-9)


def test_a_scene_without_a_drive_has_no_multiplier_at_rest() -> None:
    """The case says why it has none."""
    found = pp.sweep(
        pp.Scene(model=THIN, effects=[fx.Gravity()], duration=1.0),
        {"model.rods[0].mass": [1.0]},
        ["multiplier"],
        workers=1,
    )
    assert np.isnan(found.multiplier.values).all()
    assert "period" in str(found.why.values[0])
