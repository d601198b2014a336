"""Rods through the pole phi = pi/2, and starts on the pole and upright, where rounding determines when they move."""

from functools import cache
from typing import Any

import numpy as np

from pendpin.effects import Gravity, Motor
from pendpin.equations.exact import direction, direction_rate, planar, spherical
from pendpin.ground.arrays import EPS
from pendpin.scene import Chain, Rod, Scene
from pendpin.verification.hardcases.base import (
    REDUCED,
    ROD,
    SWING,
    THICK,
    THIN,
    Case,
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

# --- through the pole: thin rods ------------------------------------------------------------------------------------

FAST = 9.0  # rad/s: enough for full turns, through both poles
TURNING: dict[str, Any] = {"bound": 1e-12 * 1000 * 180, "methods": settings(auto=1e-12, rk45=1e-12, taylor=1e-16)}


def _straight_through(solve: Solve, full: bool) -> float:
    run = solve(scene(THIN, q=(0.0, 0.3), v=(0.0, FAST), duration=20.0 if full else 4.0, samples=21))
    return tip_errors(run, run.q[:, 1], planar(0.3, FAST, REDUCED, G, run.t))


def _close_by(solve: Solve, full: bool) -> float:
    q, v = np.array([1e-9, 0.3]), np.array([1e-8, FAST])
    run = solve(scene(THIN, q=q, v=v, duration=20.0 if full else 4.0, samples=11))
    exact = spherical(direction(q), direction_rate(q, v), REDUCED, G, run.t)
    return float(np.linalg.norm(run.tips[:, 0] - exact, axis=-1).max())


MIDDLE = Chain(rods=(Rod(length=1.0, mass=100.0), Rod(length=0.5, mass=0.1), Rod(length=0.3, mass=0.02)))


def _in_a_chain(solve: Solve, full: bool) -> float:
    q, v = np.array([[0.0, 0.1], [0.0, 0.4], [0.0, 0.05]]), np.array([[0.0, 0.2], [0.0, 12.0], [0.0, 0.3]])
    duration = 10.0 if full else 2.0
    through, turned = (
        solve(scene(MIDDLE, q=np.ravel(a), v=np.ravel(b), duration=duration, samples=11))
        for a, b in ((q, v), (q[:, ::-1], v[:, ::-1]))
    )
    x, y, z = np.moveaxis(through.tips, -1, 0)
    return float(np.abs(np.stack([0 * y, -x, z], -1) - turned.tips).max())


# --- thick rods -----------------------------------------------------------------------------------------------------

AWAY = 0.3  # rad from the pole, at the start
SPEED = 3.0  # rad/s


@cache
def passage(radius: float, aim: float) -> tuple[Scene, tuple[float, float]]:
    """A rod of 1 m that moves towards the pole and would miss it by `aim` rad if it were thin; and theta, phi at the end.

    Without gravity p = D theta' and J phi'² + p²/D = J SPEED² are constant, where D = I3 + k sin²(x), k = J - I3, x the
    distance from the pole; p = J aim SPEED. So SPEED dt = sqrt(D / (D - J aim²)) dx and d theta = p dt / D: two
    integrals give the time from AWAY to AWAY and how far theta turns. Where I3 < J aim² the rod turns back.
    """
    from mpmath import mp, mpf

    rod = Rod(length=1.0, mass=1.0, radius=radius)
    with mp.workdps(60):
        J, I3, b, w = (mpf(x) for x in (inertia_about_joint(rod), rod.properties.I3, aim, SPEED))
        k, rest = J - I3, I3 - J * b**2
        nearest = mp.asin(mp.sqrt(-rest / k)) if rest < 0 else mpf(0)
        width = mp.sqrt(abs(rest) / k)
        marks = [nearest, *(nearest + width * 10**i for i in range(4) if nearest + width * 10**i < AWAY), mpf(AWAY)]

        def D(x):
            return I3 + k * mp.sin(x) ** 2

        def over(x):  # D - J b²
            return max(rest, mpf(0)) + k * mp.sin(x - nearest) * mp.sin(x + nearest)

        half = mp.quad(lambda x: mp.sqrt(D(x) / over(x)), marks) / w
        turn = J * b * mp.quad(lambda x: 1 / mp.sqrt(D(x) * over(x)), marks) if aim else mpf(0)
        rates = (J * b * w / D(mpf(AWAY)), w * mp.sqrt(over(mpf(AWAY)) / D(mpf(AWAY))))
        side = -1 if rest < 0 else 1
        q, v = (0.3, float(mp.pi / 2 - AWAY)), tuple(map(float, rates))
        end = (0.3 + float(2 * turn), float(mp.pi / 2 + side * AWAY))
        return scene(Chain(rods=(rod,)), q=q, v=v, duration=float(2 * half), samples=2, gravity=None), end


def _passing(radius: float, aim: float) -> Case:
    rod = Rod(length=1.0, mass=1.0, radius=radius)
    narrow = float(np.sqrt(rod.properties.I3 / inertia_about_joint(rod)))

    def measure(solve: Solve, full: bool) -> float:
        at_pole, end = passage(radius, aim)
        return float(np.abs(solve(at_pole).q[-1] - end).max())

    methods, words = settings(auto=1e-12, radau=1e-12, taylor=1e-16), {"mm": 1e3 * radius, "aim": aim, "narrow": narrow}
    return case("thick-pole", 1e-12 * 1000 * np.pi / narrow, methods, measure, **words)


# --- starts on the pole and upright ---------------------------------------------------------------------------------

POLE = np.pi / 2
OFF_POLE = 6.123233995736766e-17  # rad, the double nearest to pi/2 below it
SPIN = 5.0  # rad/s
TORQUE = 1e-2  # N m
UPWARDS = Gravity(direction=(0.0, 0.0, 1.0))  # so that hanging straight, 0 rad, is upright
J, I3 = inertia_about_joint(ROD), ROD.properties.I3
FINEST = 1e-14  # the smallest tolerance of the Runge-Kutta methods


def _measure_fall(model: Chain, reduced: float, q: tuple[float, float], v: tuple[float, float]):
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


def _no_motion(solve: Solve, full: bool) -> float:
    motor = Motor(joint="theta", torque=1.0)
    return refused(solve, lambda: scene(THIN, motor, q=(0.0, POLE), duration=2.0), "rod", "radius")


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


# --- the cases ------------------------------------------------------------------------------------------------------

LEVEL, SPUN, HANG = (0.0, POLE), (SPIN, 0.0), J / (ROD.mass * ROD.properties.h)
CASES = (
    case("thin-pole", **TURNING, measure=_straight_through),
    case("thin-pole-close", **TURNING, measure=_close_by),
    case("thin-pole-chain", 2 * 1e-12 * 2000 * 240, settings(auto=1e-12, lsoda=1e-12), _in_a_chain),
    *(_passing(radius, aim) for radius in (1e-3, 1e-4) for aim in (1e-3, 1e-6, 0.0)),
    case("pole-rest-thin", FALLING, TIGHT, _measure_fall(THIN, REDUCED, LEVEL, (0.0, 0.0))),
    case("pole-spin-thin", FALLING, TIGHT, _measure_fall(THIN, REDUCED, LEVEL, SPUN)),
    case("pole-rest-thick", FALLING, TIGHT | settings(gauss6=0.002), _measure_fall(THICK, HANG, LEVEL, (0.0, 0.0))),
    case("pole-spin-thick", float(np.log1p(FINEST / OFF_POLE)) / SPIN / np.sqrt(1 - I3 / J), FINE, _spinning),
    case("pole-torque-thick", 1e-12 * 500 * 20 + (OFF_POLE * np.exp(20)) ** 2 * J / I3 * 20, TIGHT, _about_itself),
    case("pole-phi-torque-thin", 1e-12 * 500 * 13.5, settings(auto=1e-12, radau=1e-12), _across),
    case("pole-torque-thin", 0.0, settings(auto=None), _no_motion),
    case(
        "upright-exact",
        bound=0.0,
        methods=settings(auto=None, rk45=None, radau=None, taylor=None, gauss4=0.1, rk4=0.1, euler=0.1),
        measure=_upright,
    ),
    case("upright-1e-15", float(np.log1p(FINEST / 1e-15)) / SWING, FINE | settings(gauss6=0.01, rk4=0.001), _leaning),
    case("upright-pi", float(np.log1p((FINEST * np.pi + 20 * EPS) / (2 * OFF_POLE))) / SWING, FINE, _upside_down),
)
