"""Compiled equations with the numbers of model and effects as parameters."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from effect_cases import MODELS
from laws import law
from pendpin import effects as fx
from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import Compiled
from pendpin.model.build import build
from test_compiled import rates, with_engine

TRACK = "t,x,y,z\n" + "".join(f"{t / 4},{0.1 * np.sin(t)},{0.02 * t},{0.3 * np.cos(2 * t)}\n" for t in range(20))


# --- parameters -----------------------------------------------------------------------------------------------------


def test_a_track_is_a_table(tmp_path: Path) -> None:
    """The spline of a csv in machine code is that of SciPy, in all its pieces and at their ends, with drag in its wind."""
    (tmp_path / "track.csv").write_text(TRACK)
    effects = (fx.Support(csv=tmp_path / "track.csv"), fx.Drag(wind=(1, 2, 0), gust=(0, 1, 0), frequency=2.0))
    model, random = build(MODELS["chain of 5"]), np.random.default_rng(3)
    plain, compiled = (Dynamics(model, effects, engine, form="angles", start=0.5) for engine in ("auto", "compiled"))
    for t in (0.0, 0.25, 0.6, 2.0, 4.25):
        y = np.concatenate([random.uniform(-1.2, 1.2, 10), random.uniform(-3, 3, 10)])
        expected, found = rates(plain, t, y), rates(compiled, t, y)
        assert np.abs(found - expected).max() < 1e-11 * np.abs(expected).max()


@law(20)
@given(
    mass=st.floats(0.1, 10.0), length=st.floats(0.1, 2.0), damping=st.floats(0.01, 1.0), gravity=st.floats(1.0, 20.0)
)
def test_other_numbers_are_no_new_code(mass: float, length: float, damping: float, gravity: float) -> None:
    """Masses, lengths, damping, gravity and air are parameters: one function is right for all of them."""
    rod = pp.Rod(length=length, mass=mass, radius=0.05)
    effects = (
        fx.Gravity(acceleration=gravity),
        fx.Viscous(coefficient=damping),
        fx.Drag(density=mass, wind=(length, 0, 0)),
    )
    model = build(pp.Chain(rods=[rod], copies=2))
    plain, compiled = (Dynamics(model, effects, engine, form="angles") for engine in ("auto", "compiled"))
    first = Dynamics(
        build(pp.Chain(rods=[pp.Rod(length=1, mass=1, radius=0.1)], copies=2)), OTHERS, "compiled", "angles"
    )
    assert isinstance(first.engine, Compiled)
    assert isinstance(compiled.engine, Compiled)
    assert compiled.engine.equations is first.engine.equations
    y = np.array([0.5, -0.3, 0.2, 0.9, 1.0, -2.0, 0.5, 1.5])
    expected, found = rates(plain, 0.0, y), rates(compiled, 0.0, y)
    assert np.abs(found - expected).max() < 1e-11 * np.abs(expected).max()


OTHERS = (fx.Gravity(), fx.Viscous(coefficient=0.2), fx.Drag(wind=(3.0, 0, 0)))


def test_another_structure_is_new_code() -> None:
    """What is 0 in one scene and not in another is no parameter of the first; nor is another joint."""
    model, damped = build(MODELS["chain of 5"]), fx.Viscous(coefficient=0.2)
    several = [(fx.Viscous(coefficient=0.0),), (damped,), (fx.Viscous(coefficient=0.2, joints=("theta_1",)),)]
    functions = [Dynamics(model, effects, "compiled", "angles").engine for effects in several]
    assert len({id(engine.equations) for engine in functions if isinstance(engine, Compiled)}) == 3


def test_the_series_take_parameters_too() -> None:
    """Taylor's method on two masses, one after another, against dop853 on Pinocchio for each."""
    pytest.importorskip("heyoka", reason="heyoka is not installed: pip install heyoka")
    for mass in (0.5, 2.0):
        rods = [pp.Rod(length=0.7, mass=mass, radius=0.05), pp.Rod(length=0.4, mass=1.0, radius=0.02)]
        scene = pp.Scene(
            duration=2.0,
            model=pp.Chain(rods=rods),
            start=pp.Start(time=1.5, positions={"theta_1": 0.7, "phi_2": 0.4}),
            effects=(fx.Gravity(), fx.Viscous(coefficient=0.1), fx.Support(amplitude=(0.1, 0, 0), frequency=3.0)),
        )
        series = pp.simulate(scene, method="taylor", tolerance=1e-15)
        steps = pp.simulate(with_engine(scene, "pinocchio"), method="dop853", tolerance=1e-13)
        np.testing.assert_allclose(series.q, steps.q, atol=1e-11)


@pytest.mark.parametrize("method", ["auto", "dop853", "rk4"])
def test_the_same_scene_gives_the_same_bits(method: str) -> None:
    """Whatever the process has compiled before: the choice of the engine depends on the scene alone."""
    pytest.importorskip("CyRK", reason="CyRK is not installed: pip install CyRK")
    scene = pp.Scene(
        duration=6.0,
        model=MODELS["chain of 5"],
        start=pp.Start(positions={"theta_1": 0.5}),
        effects=(fx.Gravity(), fx.Spring(stiffness=3.21)),  # of no other test
    )
    setting = {"step": 1e-3} if method == "rk4" else {"tolerance": 1e-9}
    runs = [pp.simulate(scene, method=method, samples=11, **setting) for _ in range(3)]
    assert len({run.q.tobytes() for run in runs}) == 1
    assert {run.stats.engine for run in runs} == {"pinocchio, compiled"}
