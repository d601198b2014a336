"""What the tests of effects share: models, one of each effect, random states, one evaluation."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

import pendpin as pp
from pendpin import effects as fx
from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import LongChain, Revolute
from pendpin.model.build import build

URDF = Path(__file__).parents[1] / "urdf" / "universal_rod.urdf"

ROD = pp.Rod(length=1.0, mass=1.0, radius=0.01)
THIN = pp.Rod(length=1.0, mass=1.0)
POINT = pp.Rod(length=1.0, mass=0.0, payload=1.0)
FIVE = (
    pp.Rod(length=0.5, mass=0.4, radius=0.02),
    pp.Rod(length=0.7, mass=0.3, radius=0.03, payload=0.2),
    pp.Rod(length=0.4, mass=0.5, com=0.25, inertia=(0.012, 0.01, 0.004), radius=0.01),
    pp.Rod(length=0.6, mass=0.2, radius=0.05),
    pp.Rod(length=0.3, mass=0.4, radius=0.04),
)
MODELS = {
    "one rod": pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.05),)),
    "chain of 5": pp.Chain(rods=FIVE),
    "thin chain of 3": pp.Chain(rods=(THIN, pp.Rod(length=0.6, mass=0.5, payload=0.3), THIN)),
}

EFFECTS = {
    "gravity": fx.Gravity(),
    "viscous": fx.Viscous(coefficient=0.3),
    "viscous on one": fx.Viscous(coefficient=0.3, joints=("phi_1",)),
    "spring": fx.Spring(stiffness=2.0, rest=0.4),
    "motor": fx.Motor(joint="theta_1", torque=0.6),
    "sinusoid motor": fx.Motor(joint="phi_1", torque=0.1, amplitude=0.7, frequency=3.0, phase=0.5),
    "hold": fx.Motor(joint="theta_1", target=0.5, proportional=3.0, derivative=0.4),
    "push": fx.Push(link="rod_1", force=(0.3, -0.5, 0.7), point=0.8),
    "push and torque": fx.Push(
        link="rod_1", force=(1, 2, 3), torque=(0.1, 0.4, -0.2), amplitude=(0, 1, 0), frequency=2.0
    ),
    "drag": fx.Drag(diameter=0.1, wind=(3, -2, 1), linear=0.2, density=3.0),
    "still air": fx.Drag(diameter=0.3),
    "gust and buoyancy": fx.Drag(gust=(4, 0, 1), frequency=2.0, buoyancy=True, density=20.0, diameter=0.05),
    "support": fx.Support(amplitude=(0.1, 0.2, -0.3), frequency=5.0, phase=0.3),
    "rotation": fx.Rotation(rate=(0.7, -1.1, 2.0)),
    "earth": fx.Rotation(latitude=48.85),
    "bending": fx.Bending(stiffness=0.8),
    "clamped bending": fx.Bending(stiffness=0.8, clamp=(0.3, -0.5, -2.0)),
    "anchor": fx.Anchor(link="rod_1", point=(0.3, -0.2, -0.6), stiffness=4.0),
    "damped anchor": fx.Anchor(link="rod_1", point=(0.3, -0.2, -0.6), stiffness=4.0, damping=0.5, at=0.2),
}
ZERO = {
    "viscous": fx.Viscous(coefficient=0),
    "spring": fx.Spring(stiffness=0, rest=1.0),
    "motor": fx.Motor(joint="phi_1", torque=0),
    "sinusoid motor": fx.Motor(joint="phi_1", amplitude=0, frequency=1.0),
    "hold": fx.Motor(joint="theta_1", target=1.0, proportional=0, derivative=0),
    "push": fx.Push(link="rod_1"),
    "sinusoid push": fx.Push(link="rod_1", amplitude=(0, 0, 0), frequency=1.0, point=0.3),
    "bending": fx.Bending(stiffness=0, clamp=(1, 0, 0)),
    "anchor": fx.Anchor(link="rod_1", point=(9, 9, 9), stiffness=0),
    "drag without air": fx.Drag(density=0, wind=(9, 9, 9), buoyancy=True),
    "drag without coefficient": fx.Drag(coefficient=0, wind=(9, 9, 9)),
    "support": fx.Support(amplitude=(0, 0, 0), frequency=9.0),
    "rotation": fx.Rotation(rate=(0, 0, 0)),
    "gravity": fx.Gravity(acceleration=0, direction=(1.0, 0.2, 0.1)),
    "drag without anything but a gust": fx.Drag(density=0, gust=(1, 2, 3), frequency=5.0),
    "friction": fx.DryFriction(kinetic=0, joints=("theta_1",)),
    "friction that falls": fx.DryFriction(kinetic=0, static=0, stribeck=0.3),
}


def states(nv: int, count: int = 20, seed: int = 1, rate: float = 3.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Random times (n,), positions and rates (n, nv)."""
    random = np.random.default_rng(seed)
    shape = (count, nv)
    return random.uniform(0, 10, count), random.uniform(-1.4, 1.4, shape), random.uniform(-rate, rate, shape)


def on_both(model: pp.Chain, effects: Sequence[fx.Effect], t, q, v) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations (n, nv) by Pinocchio on revolute joints and by the chain equations."""
    dynamics = Dynamics(build(model), tuple(effects))
    return tuple(
        engine(dynamics.model, dynamics.loads).evaluate(t, q, v).acceleration for engine in (Revolute, LongChain)
    )


def planar(effects: Sequence[fx.Effect], rod: pp.Rod, start: tuple, duration: float, **solver) -> pp.Trajectory:
    """A run of one rod that swings in theta alone; `start` is its angle and rate."""
    theta, rate = start
    chosen = pp.Start(positions=(theta, 0.0), velocities=(rate, 0.0))
    options = {"tolerance": 1e-13, "samples": 101} | solver
    scene = pp.Scene(
        duration=duration,
        model=pp.Chain(rods=(rod,)),
        start=chosen,
        effects=tuple(effects),
        solver=pp.Solver(**options),
    )
    return pp.simulate(scene)
