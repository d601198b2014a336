"""Springs, dampers and supports ten thousand times faster than the motion; joints that stick, hit a stop or rest on it."""

from functools import partial

import numpy as np

from pendpin.effects import DryFriction, Motor, Spring, Stop, Support, Viscous
from pendpin.equations.base import THETA
from pendpin.scene import Chain, Rod, Scene
from pendpin.verification.hardcases.base import (
    REDUCED,
    ROD,
    THICK,
    THIN,
    Case,
    G,
    Solve,
    case,
    drift_of,
    inertia_about_joint,
    refused,
    scene,
    settings,
)

STIFF = 1e8  # N m/rad, or N m s/rad
J = inertia_about_joint(ROD)
WEIGHT = ROD.mass * ROD.properties.h * G  # N m/rad of a small angle
FAST = float(np.sqrt(STIFF / J))  # rad/s


def _ringing(solve: Solve, full: bool) -> float:
    """The error of the angle of a rod on a spring, divided by the first angle; exact: a cosine."""
    spring = Spring(stiffness=STIFF, joints=("theta",))
    run = solve(scene(THICK, spring, q=(1e-3,), duration=0.1 if full else 0.01, samples=11, gravity=None))
    return float(np.abs(run.q[:, 0] / 1e-3 - np.cos(FAST * run.t)).max())


def _overdamped(damping: float) -> Case:
    """The error of theta in rad. Without inertia damping theta' = -weight sin(theta): tan(theta/2) falls exponentially."""
    decay = WEIGHT / damping  # 1/s

    def measure(solve: Solve, full: bool) -> float:
        run = solve(scene(THICK, Viscous(coefficient=damping), q=(1.0,), duration=2 / decay, samples=11))
        return float(np.abs(run.q[:, 0] - 2 * np.arctan(np.tan(0.5) * np.exp(-decay * run.t))).max())

    bound, words = 1e-10 * 1000 + 10 * J * WEIGHT / damping**2, {"decay": damping / J, "rate": decay}
    return case("overdamped", bound, settings(auto=1e-10, radau=1e-10), measure, damping=damping, **words)


JOINTS = ("theta_2", "phi_2")
CLAMP = (Spring(stiffness=STIFF, joints=JOINTS), Viscous(coefficient=STIFF, joints=JOINTS))


def _clamped(solve: Solve, full: bool) -> float:
    """The distance in m between the tips of two clamped rods and of one rod of twice the length and mass."""
    span = {"duration": 3.0 if full else 0.5, "samples": 11}
    two = solve(scene(Chain(rods=(ROD,), copies=2), *CLAMP, q=(0.5, 0.1), **span))
    one = solve(scene(Chain(rods=(Rod(length=2.0, mass=2.0, radius=ROD.radius),)), q=(0.5, 0.1), **span))
    return float(np.linalg.norm(two.tips[:, 1] - one.tips[:, 0], axis=-1).max())


def bent(duration: float) -> Scene:
    """Two rods with a stiff spring between them, which starts with a small bend."""
    spring = Spring(stiffness=STIFF, joints=JOINTS)
    return scene(Chain(rods=(ROD,), copies=2), spring, q=(0.5, 0.1, 1e-3), duration=duration, samples=11)


SHAKE, SHAKEN = 1e-3, 1e4  # m, rad/s
LEAN = 1e-3  # rad from upright
SLOW = float(np.sqrt((SHAKE * SHAKEN / REDUCED) ** 2 / 2 - G / REDUCED))  # rad/s, Kapitza's swing about the upright


def _kapitza(solve: Solve, full: bool) -> float:
    """The difference of the lean to the averaged motion with its ripple, divided by the first lean."""
    support = Support(amplitude=(0.0, 0.0, SHAKE), frequency=SHAKEN, phase=np.pi / 2)
    duration = 2.0 if full else 0.03
    run = solve(scene(THIN, support, q=(np.pi - LEAN,), duration=duration, samples=41))
    ripple = 1 + SHAKE / REDUCED * np.cos(SHAKEN * run.t)
    averaged = np.cos(SLOW * run.t) * ripple / ripple[0]
    return float(np.abs((np.pi - run.q[:, 0]) / LEAN - averaged).max())


# --- joints that stick ----------------------------------------------------------------------------------------------


def _edge(solve: Solve, full: bool) -> float:
    """How many of two rods are wrong: friction 1e-9 above the torque of the weight must hold, 1e-9 below must not."""
    needed = ROD.mass * ROD.properties.h * G * np.sin(0.3)  # N m
    sticking, loose = (
        solve(scene(THICK, DryFriction(kinetic=0.1, static=needed * (1 + margin)), q=(0.3,), duration=2.0, samples=5))
        for margin in (1e-9, -1e-9)
    )
    return float((sticking.q != sticking.q[0]).any() or sticking.v.any()) + float(
        np.abs(loose.q[:, 0] - 0.3).max() < 0.1
    )


STIFFNESS, FRICTION = 4.0, 0.13  # N m/rad, N m


def _sticking(solve: Solve, full: bool) -> float:
    """The error of the place where a rod on a spring sticks: each half swing is 2 friction / stiffness shorter."""
    spring = Spring(stiffness=STIFFNESS, joints=("theta",))
    rubbing = scene(THICK, spring, DryFriction(kinetic=FRICTION), q=(1.0,), duration=16.0, samples=2, gravity=None)
    amplitude, sign = 1.0, 1.0
    while amplitude > FRICTION / STIFFNESS:
        amplitude, sign = amplitude - 2 * FRICTION / STIFFNESS, -sign
    run = solve(rubbing)
    return float(abs(run.q[-1, 0] - sign * amplitude) + abs(run.v[-1, 0]))


def _resting(solve: Solve, full: bool) -> float:
    stop = Stop(lower=0.2, joints=("theta",))
    run = solve(scene(THICK, stop, q=(0.2,), duration=5.0, samples=11))
    return float(np.abs(run.q - run.q[0]).max() + np.abs(run.v).max())


def _bouncing(solve: Solve, full: bool) -> float:
    """The error of a joint that 1 N m pushes from -1 rad to a stop at 0: shorter and shorter bounces, then rest."""
    back, a = 0.5, 1 / J  # restitution, rad/s²
    effects = Motor(joint="theta", torque=1.0), Stop(upper=0.0, restitution=back, joints=("theta",))
    run = solve(scene(THICK, *effects, q=(-1.0,), duration=3.0, samples=601, gravity=None))
    t, exact = run.t, -1 + a * run.t**2 / 2
    start, speed = np.sqrt(2 / a), np.sqrt(2 * a) * back
    while speed > 1e-9:
        flight = 2 * speed / a
        inside = (t >= start) & (t < start + flight)
        since = t[inside] - start
        exact[inside] = -speed * since + a * since**2 / 2
        start, speed = start + flight, speed * back
    exact[t >= start] = 0.0
    return float(np.abs(run.q[:, 0] - exact).max())


BALANCED = Chain(rods=(ROD, Rod(length=1.0, mass=1.0, com=0.0, inertia=(0.1, 0.1, 0.01))))
RATE, LIMIT = 1.0, 0.5  # rad/s, rad


def _both(solve: Solve, full: bool) -> float:
    """The error of two joints with coupled inertias at one rate; exact: a triangle wave between their stops."""
    stop = Stop(lower=-LIMIT, upper=LIMIT, restitution=1.0)
    bouncing = scene(BALANCED, stop, v=(RATE, 0.0, RATE, 0.0), duration=20.0 if full else 4.0, samples=81, gravity=None)
    run = solve(bouncing)
    wave = np.abs((RATE * run.t + LIMIT) % (4 * LIMIT) - 2 * LIMIT)
    return float(np.abs(run.q[:, THETA] - (LIMIT - wave)[:, None]).max())


def _beyond(solve: Solve, full: bool) -> float:
    make_scene = partial(scene, THICK, Stop(upper=0.5), q=(1.0,), duration=1.0)
    return refused(solve, make_scene, "start.positions.theta", "beyond its stop")


METHODS = settings(auto=1e-11, rk45=1e-11, radau=1e-11)


# --- the cases ------------------------------------------------------------------------------------------------------

CASES = (
    case(
        "spring-1e8",
        bound=1e-12 * 270 * 20 * 0.1 * FAST * FAST / (1e-3 * FAST),
        methods=settings(auto=1e-12, taylor=1e-16, gauss6=1e-5),
        measure=_ringing,
    ),
    case("spring-chain", 1e-10 * 20_000 * 10, settings(auto=1e-10), drift_of(bent, 0.1, 0.01)),
    case("clamped-1e8", 2 * (100 * 2 / STIFF + 1e-9 * 1000 * 15), settings(auto=1e-9, radau=1e-9, bdf=1e-9), _clamped),
    _overdamped(1e4),
    _overdamped(1e8),
    case(
        "kapitza-1e4",
        bound=(1 + SLOW * 2) * ((SHAKE / REDUCED) ** 2 + LEAN**2 + 1e-12 * 40_000 / LEAN),
        methods=settings(auto=1e-12, taylor=1e-15),
        measure=_kapitza,
    ),
    case("stick-edge", 0.0, METHODS, _edge),
    case("stick-slip", 1e-11 * 2000, settings(auto=1e-11, rk45=1e-11), _sticking),
    case("stop-rest", 0.0, METHODS, _resting),
    case("bounces", 1e-11 * 1000 * 3, METHODS, _bouncing),
    case("stops-at-once", 1e-11 * 2000, METHODS, _both),
    case("stop-beyond", 0.0, METHODS, _beyond),
)
