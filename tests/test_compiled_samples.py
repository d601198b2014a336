"""Samples of chains in machine code: accelerations, wrenches, poses and energies as by the engines' own equations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.dynamics.dynamics import Dynamics
from pendpin.model import kinematics
from pendpin.model.build import build
from test_compiled_chains import AIR, MOVING, chain, state

pytest.importorskip("llvmlite", reason="llvmlite is not installed: pip install llvmlite")

JOINTS = (fx.Viscous(coefficient=0.1), fx.Spring(stiffness=0.3, joints=("theta_1",)))


@law(30)
@given(st.integers(1, 30), st.integers(0, 10**6), st.sampled_from([(), (AIR, *MOVING), (AIR, *JOINTS)]), st.booleans())
def test_the_same_samples(n: int, seed: int, effects: tuple, thin: bool) -> None:
    """As by the hand-derived chain equations, thick rods and thin ones, with further torques at the joints."""
    if thin:  # a torque about the joints of thin rods keeps them on angles
        effects = tuple(effect for effect in effects if effect not in JOINTS)
    dynamics = Dynamics(build(chain(n, seed, thin)), (fx.Gravity(), *effects), "chain")
    dynamics.use_compiled_samples()
    assert dynamics.sampler is not None
    q, v = (np.array(x) for x in zip(*(state(n, seed + i) for i in range(3)), strict=True))
    t, torque = np.array([0.0, 0.4, 1.1]), None if thin else np.sin(q)
    found = dynamics.sampler(t, q, v, torque)
    expected = (*dynamics.engine.evaluate(t, q, v, torque), *kinematics.poses_and_energy(dynamics.model, q, v))
    for own, plain in zip(found, expected, strict=True):
        assert np.abs(own - plain).max() < 3e-13 * n**2 * np.abs(plain).max()


def test_thin_rods_at_the_pole() -> None:
    """Wrenches are regular where the angles are singular; the tip's acceleration too."""
    dynamics = Dynamics(build(chain(3, thin=True)), (fx.Gravity(),), "chain")
    dynamics.use_compiled_samples()
    assert dynamics.sampler is not None
    q, v = np.array([[0.3, 0.2, 0.1, np.pi / 2, -0.4, 0.5]]), np.array([[0.5, 0.3, 0.0, 1.0, 0.2, 0.1]])
    found, expected = dynamics.sampler(np.zeros(1), q, v), dynamics.engine.evaluate(np.zeros(1), q, v)
    assert found is not None
    assert np.isfinite(found[0]).all()
    assert np.abs(found[1] - expected.wrench).max() < 1e-12 * np.abs(expected.wrench).max()


def test_an_engine_by_its_name_computes_its_own_samples() -> None:
    """So that routes stay independent; else a run has the samples of the compiled equations, which agree."""
    scene = pp.Scene(
        duration=0.2,
        model=chain(4, seed=1),
        start=pp.Start(positions={"theta_1": 0.7, "phi_2": 0.4}),
        effects=(fx.Gravity(), AIR),
        solver=pp.Solver(tolerance=1e-12),
    )
    own, plain = pp.simulate(scene), pp.simulate(scene.replace({"solver.engine": "chain"}))
    assert own.stats.engine.endswith("compiled")
    assert not plain.stats.engine.endswith("compiled")
    for name in ("q", "a", "wrench", "kinetic", "potential"):
        one, other = getattr(own, name), getattr(plain, name)
        assert np.abs(one - other).max() < 1e-9 * np.abs(other).max()
