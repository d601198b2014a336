"""Starts on the pole and upright, where rounding determines when the motion begins."""

from functools import partial
from typing import Any

import numpy as np

from pendpin.analysis.hardcases.base import (
    EPS,
    REDUCED,
    REGULAR,
    SWING,
    THICK,
    THIN,
    Case,
    G,
    Solve,
    chain_of,
    departure,
    inertia_about_joint,
    refused,
    scene,
    settings,
    tip_errors,
)
from pendpin.effects import Gravity, Motor
from pendpin.equations.exact import planar
from pendpin.scene import Chain

POLE = np.pi / 2
OFF_POLE = 6.123233995736766e-17  # rad, the double nearest to pi/2 below it
SPIN = 5.0  # rad/s
TORQUE = 1e-2  # N m
UPWARDS = Gravity(direction=(0.0, 0.0, 1.0))  # so that hanging straight, 0 rad, is upright
ROD = THICK.rods[0]
J, I3 = inertia_about_joint(ROD), ROD.properties.I3
FINEST = 1e-14  # the smallest tolerance of the Runge-Kutta methods


def _fall(model: Chain, reduced: float, q: tuple[float, float], v: tuple[float, float]):
    def measure(solve: Solve, full: bool) -> float:
        run = solve(scene(model, q=q, v=v, duration=20.0 if full else 3.0, samples=21 if full else 4))
        return tip_errors(run, run.q[:, 1], planar(POLE, 0.0, reduced, G, run.t))

    return measure


def _spinning(solve: Solve, full: bool) -> float:
    """The error in s of the time at which the rod leaves the pole; exact: OFF_POLE cosh(rate t) = far."""
    rate, far = SPIN * np.sqrt(1 - I3 / J), 1e-3
    run = solve(scene(THICK, q=(0.0, POLE), v=(SPIN, 0.0), duration=9.0, samples=1801, gravity=None))
    return abs(departure(run, run.q[:, 1] - POLE, far) - float(np.arccosh(far / OFF_POLE)) / rate)


def _about_itself(solve: Solve, full: bool) -> float:
    turned = 20.0 if full else 10.0  # rad: before the growth exp(turned) of OFF_POLE is seen
    motor = Motor(joint="theta", torque=TORQUE)
    run = solve(scene(THICK, motor, q=(0.0, POLE), duration=np.sqrt(2 * I3 * turned / TORQUE), samples=5, gravity=None))
    return float(np.abs(run.q[:, 0] - TORQUE * run.t**2 / (2 * I3)).max())


def _across(solve: Solve, full: bool) -> float:
    run = solve(scene(THIN, Motor(joint="phi", torque=1.0), q=(0.0, POLE), duration=3.0, samples=5, gravity=None))
    return float(np.abs(run.q[:, 1] - POLE - 1.5 * run.t**2).max())


def _no_motion(solve: Solve, full: bool, phi: float) -> float:
    motor = Motor(joint="theta", torque=1.0)
    return refused(solve, lambda: scene(THIN, motor, q=(0.0, phi), v=(0.0, 0.0), duration=2.0), "rod", "radius")


def _upright(solve: Solve, full: bool) -> float:
    models = (THIN, THICK, chain_of(ROD, copies=3)) if full else (THICK,)
    runs = [solve(scene(model, duration=100.0, samples=11, gravity=UPWARDS)) for model in models]
    return max(float(np.abs(run.q).max()) for run in runs)


def _leaning(solve: Solve, full: bool) -> float:
    run = solve(scene(THIN, q=(1e-15,), duration=10.0, samples=601, gravity=UPWARDS))
    return abs(departure(run, run.q[:, 0], 1e-2) - float(np.arccosh(1e-2 / 1e-15)) / SWING)


def _upside_down(solve: Solve, full: bool) -> float:
    run = solve(scene(THIN, q=(np.pi,), duration=12.0, samples=721))
    return abs(departure(run, run.q[:, 0] - np.pi, 1e-2) - float(np.arccosh(1e-2 / (2 * OFF_POLE))) / SWING)


FALLING: dict[str, Any] = {
    "figure": "distance of the tip to the exact solution (elliptic functions), m",
    "bound": 1e-12 * 1000 * 80,
    "derivation": REGULAR.format("1,000", 80),
}
TIGHT = settings(auto=1e-12, taylor=1e-16)
FINE = settings(auto=FINEST, taylor=1e-16)
LATE = (
    "an error of 1e-14 (the tolerance) in a first angle of {} rad changes the time of leaving by up to "
    "ln(1 + 1e-14 / {}) / rate"
)

CASES = (
    Case(
        name="pole-rest-thin",
        group=3,
        title="thin rod released on the pole",
        physics="A thin rod, level and along the x axis, falls from rest.",
        why="The angles are singular at the start.",
        **FALLING,
        methods=TIGHT,
        measure=_fall(THIN, REDUCED, (0.0, POLE), (0.0, 0.0)),
    ),
    Case(
        name="pole-spin-thin",
        group=3,
        title="thin rod on the pole with theta' = 5 rad/s",
        physics="At the pole theta turns a rod about itself. For a thin rod that is no motion: it falls as from rest.",
        why="The inertia about theta is 0. A method in angles turns the 5 rad/s into a sideways motion.",
        **FALLING,
        methods=TIGHT,
        measure=_fall(THIN, REDUCED, (0.0, POLE), (SPIN, 0.0)),
    ),
    Case(
        name="pole-rest-thick",
        group=3,
        title="thick rod released on the pole",
        physics="A rod of radius 5 cm, level and along the x axis, falls from rest in the plane theta = 0.",
        why="The rounding errors of theta'' are multiplied by J/I3. They must not change the motion in the plane.",
        **FALLING,
        methods=TIGHT | settings(gauss6=0.002),
        measure=_fall(THICK, J / (ROD.mass * ROD.properties.h), (0.0, POLE), (0.0, 0.0)),
    ),
    Case(
        name="pole-spin-thick",
        group=3,
        title="thick rod spinning on the pole",
        physics="A rod that spins about its own axis on the pole, without gravity, is in unstable equilibrium. The double "
        "nearest to pi/2 differs from it by 6e-17 rad; this distance grows by the factor cosh(spin sqrt(1 - I3/J) t).",
        why="The first distance is smaller than the rounding of phi. Only the acceleration depends on it.",
        figure="error of the time at which the distance is 1e-3 rad, s",
        bound=float(np.log1p(FINEST / OFF_POLE)) / SPIN / np.sqrt(1 - I3 / J),
        derivation=LATE.format("6e-17", "6e-17"),
        methods=FINE,
        measure=_spinning,
    ),
    Case(
        name="pole-torque-thick",
        group=3,
        title="thick rod on the pole under a constant torque about theta",
        physics="On the pole the torque turns the rod about itself: theta = torque t² / (2 I3). This motion is unstable and "
        "ends after about 37 rad; the run ends at 20 rad.",
        why="Only the small axial inertia resists the torque.",
        figure="error of theta, rad",
        bound=1e-12 * 500 * 20 + (OFF_POLE * np.exp(20)) ** 2 * J / I3 * 20,
        derivation="tolerance 1e-12, 500 steps, relative to 20 rad; and what 6e-17 rad, grown exp(20) times, change in D",
        methods=TIGHT,
        measure=_about_itself,
    ),
    Case(
        name="pole-phi-torque-thin",
        group=3,
        title="thin rod on the pole under a constant torque about phi",
        physics="The torque about phi turns the rod in the plane theta = 0, through further poles: phi = pi/2 + 1.5 t².",
        why="A scene with joint torques is computed in angles. At a pole theta is singular; it must stay 0.",
        figure="error of phi, rad",
        bound=1e-12 * 500 * 13.5,
        derivation="tolerance 1e-12, 500 steps, relative to 13.5 rad",
        methods=settings(auto=1e-12, radau=1e-12),
        measure=_across,
    ),
    Case(
        name="pole-torque-thin",
        group=3,
        title="thin rod on the pole under a constant torque about theta",
        physics="The rod has no inertia about theta: the equations have no solution.",
        why="The acceleration is 1e33 rad/s². A method would take smaller and smaller steps for ever.",
        figure="0 if the run ends with one line that names the rod and the remedy, else 1",
        bound=0.0,
        derivation="there is nothing to compute",
        methods=settings(auto=None),
        measure=partial(_no_motion, phi=POLE),
    ),
    Case(
        name="upright-exact",
        group=5,
        title="upright at rest, exactly",
        physics="Rods stand upright at rest, in unstable equilibrium. Gravity points up here, so that upright "
        "is 0 rad, which a double holds exactly.",
        why="An error of one bit grows 46 times in every second.",
        figure="largest angle after 100 s, rad",
        bound=0.0,
        derivation="sin(0) = 0: no acceleration, in exact arithmetic and in doubles",
        methods=settings(auto=None, rk45=None, radau=None, taylor=None, gauss4=0.1, rk4=0.1, euler=0.1),
        measure=_upright,
    ),
    Case(
        name="upright-1e-15",
        group=5,
        title="1e-15 rad from upright",
        physics="The angle grows as 1e-15 cosh(sqrt(3 g / 2 l) t): the rod falls after eight seconds.",
        why="During the first seven seconds the angle is smaller than the tolerance of a step.",
        figure="error of the time at which the rod leans by 0.01 rad, s",
        bound=float(np.log1p(FINEST / 1e-15)) / SWING,
        derivation=LATE.format("1e-15", "1e-15"),
        methods=FINE | settings(gauss6=0.01, rk4=0.001),
        measure=_leaning,
    ),
    Case(
        name="upright-pi",
        group=5,
        title="at the double nearest to theta = pi",
        physics="The double nearest to pi is 1.2e-16 rad below upright. That determines when the rod falls.",
        why="Doubles near pi are 4e-16 apart. The motion of the first seconds is smaller than that.",
        figure="error of the time at which the rod leans by 0.01 rad, s",
        bound=float(np.log1p((FINEST * np.pi + 20 * EPS) / (2 * OFF_POLE))) / SWING,
        derivation="errors of 1e-14 of 3.14 rad and rounding in a first angle of 1.2e-16 rad: ln(1 + their ratio) / rate",
        methods=FINE,
        measure=_upside_down,
    ),
)
