"""Joints that stick, hit a stop or rest on it: every event must be found at its time, once, and the events must end."""

from functools import partial

import numpy as np

from pendpin.effects import DryFriction, Motor, Spring, Stop
from pendpin.equations.base import THETA
from pendpin.ground.arrays import Array
from pendpin.scene import Chain, Rod
from pendpin.verification.hardcases.base import (
    ROD,
    THICK,
    G,
    Solve,
    case,
    inertia_about_joint,
    refused,
    scene,
    settings,
)

J = inertia_about_joint(ROD)


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


BACK = 0.5  # restitution


def _bounced(t: Array) -> Array:
    """Angles (n,) in rad of a joint that 1 N m pushes from -1 rad to a stop at 0: shorter and shorter bounces, then rest."""
    a = 1 / J
    start, speed, angle = np.sqrt(2 / a), np.sqrt(2 * a) * BACK, -1 + a * t**2 / 2
    while speed > 1e-9:
        flight = 2 * speed / a
        inside = (t >= start) & (t < start + flight)
        since = t[inside] - start
        angle[inside] = -speed * since + a * since**2 / 2
        start, speed = start + flight, speed * BACK
    angle[t >= start] = 0.0
    return angle


def _bouncing(solve: Solve, full: bool) -> float:
    effects = Motor(joint="theta", torque=1.0), Stop(upper=0.0, restitution=BACK, joints=("theta",))
    run = solve(scene(THICK, *effects, q=(-1.0,), duration=3.0, samples=601, gravity=None))
    return float(np.abs(run.q[:, 0] - _bounced(run.t)).max())


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

CASES = (
    case("stick-edge", bound=0.0, methods=METHODS, measure=_edge),
    case("stick-slip", bound=1e-11 * 2000, methods=settings(auto=1e-11, rk45=1e-11), measure=_sticking),
    case("stop-rest", bound=0.0, methods=METHODS, measure=_resting),
    case("bounces", bound=1e-11 * 1000 * 3, methods=METHODS, measure=_bouncing),
    case("stops-at-once", bound=1e-11 * 2000, methods=METHODS, measure=_both),
    case("stop-beyond", bound=0.0, methods=METHODS, measure=_beyond),
)
