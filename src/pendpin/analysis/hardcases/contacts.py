"""Joints that stick, strike and rest: what happens at an instant has to happen there, once, and come to an end."""

import numpy as np

from pendpin.analysis.hardcases.base import THICK, Case, G, Solve, chain_of, inertia_about_joint, refused, scene
from pendpin.arrays import Array
from pendpin.effects import DryFriction, Motor, Spring, Stop
from pendpin.scene import Rod

ROD = THICK.rods[0]
J = inertia_about_joint(ROD)


def _edge(solve: Solve, full: bool) -> float:
    """How many of two rods do wrong: one held by a billionth, one loose by a billionth."""
    needed = ROD.mass * ROD.properties.h * G * np.sin(0.3)  # N m
    held, loose = (
        solve(scene(THICK, DryFriction(kinetic=0.1, static=needed * (1 + margin)), q=(0.3,), duration=2.0, samples=5))
        for margin in (1e-9, -1e-9)
    )
    return float((held.q != held.q[0]).any() or held.v.any()) + float(np.abs(loose.q[:, 0] - 0.3).max() < 0.1)


STIFFNESS, FRICTION = 4.0, 0.13  # N m/rad, N m


def _sticking(solve: Solve, full: bool) -> float:
    """The place where a rod on a spring sticks: every half swing is shorter by 2 friction / stiffness."""
    spring = Spring(stiffness=STIFFNESS, joints=("theta",))
    given = scene(THICK, spring, DryFriction(kinetic=FRICTION), q=(1.0,), duration=16.0, samples=2, gravity=None)
    amplitude, sign = 1.0, 1.0
    while amplitude > FRICTION / STIFFNESS:
        amplitude, sign = amplitude - 2 * FRICTION / STIFFNESS, -sign
    run = solve(given)
    return float(abs(run.q[-1, 0] - sign * amplitude) + abs(run.v[-1, 0]))


def _resting(solve: Solve, full: bool) -> float:
    stop = Stop(lower=0.2, joints=("theta",))
    run = solve(scene(THICK, stop, q=(0.2,), duration=5.0, samples=11))
    return float(np.abs(run.q - run.q[0]).max() + np.abs(run.v).max())


BACK = 0.5  # restitution


def _bounced(t: Array) -> Array:
    """A joint under a constant torque of 1 N m onto a stop at 0 from -1 rad: parabolas, shorter and shorter, then rest."""
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


BALANCED = chain_of(ROD, Rod(length=1.0, mass=1.0, com=0.0, inertia=(0.1, 0.1, 0.01)))
RATE, LIMIT = 1.0, 0.5  # rad/s, rad


def _both(solve: Solve, full: bool) -> float:
    """Two joints at one rate, whose inertias are coupled, against the triangle wave between their stops."""
    stop = Stop(lower=-LIMIT, upper=LIMIT, restitution=1.0)
    given = scene(BALANCED, stop, v=(RATE, 0.0, RATE, 0.0), duration=20.0 if full else 4.0, samples=81, gravity=None)
    run = solve(given)
    wave = np.abs((RATE * run.t + LIMIT) % (4 * LIMIT) - 2 * LIMIT)
    return float(np.abs(run.q[:, ::2] - (LIMIT - wave)[:, None]).max())


def _beyond(solve: Solve, full: bool) -> float:
    return refused(
        solve, lambda: scene(THICK, Stop(upper=0.5), q=(1.0,), duration=1.0), "start.positions.theta", "beyond its stop"
    )


METHODS = {name: {"tolerance": 1e-11} for name in ("auto", "rk45", "radau")}

CASES = (
    Case(
        name="stick-edge",
        group=11,
        title="at the edge of sticking, a billionth to either side",
        physics="A leaning rod is held by friction whose limit is its weight's torque, more or less 1e-9 of it.",
        why="Smoothed friction creeps in both cases; sticking is a yes or no.",
        figure="how many of the two rods do the wrong thing",
        bound=0.0,
        derivation="the law itself: at rest exactly, or sliding",
        methods=METHODS,
        measure=_edge,
    ),
    Case(
        name="stick-slip",
        group=11,
        title="a swing that friction ends",
        physics="A rod on a spring loses the same angle in every half swing and sticks where it stops.",
        why="Every turning point is an instant at which it might stick; one missed changes where it ends.",
        figure="where it sticks against the exact place, rad, and its rate",
        bound=1e-11 * 2000,
        derivation="tolerance 1e-11, at most 2,000 steps; sliding friction takes up no error of the place",
        methods={"auto": METHODS["auto"], "rk45": METHODS["rk45"]},
        measure=_sticking,
    ),
    Case(
        name="stop-rest",
        group=11,
        title="rest exactly on a stop",
        physics="A rod leans on its stop under gravity from the start.",
        why="Distance 0, rate 0: every rounding looks like an impact.",
        figure="largest motion, rad and rad/s",
        bound=0.0,
        derivation="the stop carries it: nothing moves",
        methods=METHODS,
        measure=_resting,
    ),
    Case(
        name="bounces",
        group=11,
        title="bounces that accumulate",
        physics="A torque drives a rod onto its stop; it comes back with half its rate, infinitely often in finite time.",
        why="An event loop goes on for ever, or gives up, or lets the rod through.",
        figure="theta against the parabolas and the rest after them, rad",
        bound=1e-11 * 1000 * 3,
        derivation="tolerance 1e-11, at most 1,000 steps, growing with the time of 3 s",
        methods=METHODS,
        measure=_bouncing,
    ),
    Case(
        name="stops-at-once",
        group=11,
        title="two stops struck in the same instant",
        physics="Two joints with coupled inertias turn at one rate and strike their stops together, again and again.",
        why="Taken one after the other the impacts give other rates than together.",
        figure="both angles against the triangle wave, rad",
        bound=1e-11 * 2000,
        derivation="tolerance 1e-11, at most 2,000 steps; the motion between impacts is a straight line",
        methods=METHODS,
        measure=_both,
    ),
    Case(
        name="stop-beyond",
        group=11,
        title="a start beyond a stop",
        physics="No motion exists.",
        why="An event that has already happened is never found.",
        figure="1 unless it is refused in one line that names the joint and its limits",
        bound=0.0,
        derivation="there is nothing to compute",
        methods=METHODS,
        measure=_beyond,
    ),
)
