"""Starts on the pole and upright, where rounding determines when the motion begins."""

from functools import partial

import numpy as np

from pendpin.effects import Gravity, Motor
from pendpin.equations.exact import planar
from pendpin.ground.arrays import EPS
from pendpin.scene import Chain
from pendpin.verification.hardcases.base import (
    REDUCED,
    ROD,
    SWING,
    THICK,
    THIN,
    G,
    Solve,
    case,
    departure,
    inertia_about_joint,
    refused,
    scene,
    settings,
    tip_errors,
)

POLE = np.pi / 2
OFF_POLE = 6.123233995736766e-17  # rad, the double nearest to pi/2 below it
SPIN = 5.0  # rad/s
TORQUE = 1e-2  # N m
UPWARDS = Gravity(direction=(0.0, 0.0, 1.0))  # so that hanging straight, 0 rad, is upright
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
    models = (THIN, THICK, Chain(rods=(ROD,), copies=3)) if full else (THICK,)
    runs = [solve(scene(model, duration=100.0, samples=11, gravity=UPWARDS)) for model in models]
    return max(float(np.abs(run.q).max()) for run in runs)


def _leaning(solve: Solve, full: bool) -> float:
    run = solve(scene(THIN, q=(1e-15,), duration=10.0, samples=601, gravity=UPWARDS))
    return abs(departure(run, run.q[:, 0], 1e-2) - float(np.arccosh(1e-2 / 1e-15)) / SWING)


def _upside_down(solve: Solve, full: bool) -> float:
    run = solve(scene(THIN, q=(np.pi,), duration=12.0, samples=721))
    return abs(departure(run, run.q[:, 0] - np.pi, 1e-2) - float(np.arccosh(1e-2 / (2 * OFF_POLE))) / SWING)


FALLING = 1e-12 * 1000 * 80  # at most 1,000 steps; errors grow by 1 + omega T = 80
TIGHT = settings(auto=1e-12, taylor=1e-16)
FINE = settings(auto=FINEST, taylor=1e-16)

CASES = (
    case("pole-rest-thin", bound=FALLING, methods=TIGHT, measure=_fall(THIN, REDUCED, (0.0, POLE), (0.0, 0.0))),
    case("pole-spin-thin", bound=FALLING, methods=TIGHT, measure=_fall(THIN, REDUCED, (0.0, POLE), (SPIN, 0.0))),
    case(
        "pole-rest-thick",
        bound=FALLING,
        methods=TIGHT | settings(gauss6=0.002),
        measure=_fall(THICK, J / (ROD.mass * ROD.properties.h), (0.0, POLE), (0.0, 0.0)),
    ),
    case(
        "pole-spin-thick",
        bound=float(np.log1p(FINEST / OFF_POLE)) / SPIN / np.sqrt(1 - I3 / J),
        methods=FINE,
        measure=_spinning,
    ),
    case(
        "pole-torque-thick",
        bound=1e-12 * 500 * 20 + (OFF_POLE * np.exp(20)) ** 2 * J / I3 * 20,
        methods=TIGHT,
        measure=_about_itself,
    ),
    case("pole-phi-torque-thin", bound=1e-12 * 500 * 13.5, methods=settings(auto=1e-12, radau=1e-12), measure=_across),
    case("pole-torque-thin", bound=0.0, methods=settings(auto=None), measure=partial(_no_motion, phi=POLE)),
    case(
        "upright-exact",
        bound=0.0,
        methods=settings(auto=None, rk45=None, radau=None, taylor=None, gauss4=0.1, rk4=0.1, euler=0.1),
        measure=_upright,
    ),
    case(
        "upright-1e-15",
        bound=float(np.log1p(FINEST / 1e-15)) / SWING,
        methods=FINE | settings(gauss6=0.01, rk4=0.001),
        measure=_leaning,
    ),
    case(
        "upright-pi",
        bound=float(np.log1p((FINEST * np.pi + 20 * EPS) / (2 * OFF_POLE))) / SWING,
        methods=FINE,
        measure=_upside_down,
    ),
)
