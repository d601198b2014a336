"""One rod or two: through the pole and from it, upright, stiff springs and dampers, joints that stick or hit a stop."""

import numpy as np

from pendpin.equations.base import THETA
from pendpin.equations.exact import direction, direction_rate, spherical
from pendpin.ground.arrays import EPS
from pendpin.motions.trajectory import Trajectory
from pendpin.scene import Rod
from pendpin.verification.hardcases.base import (
    HANG,
    REDUCED,
    ROD,
    SWING,
    Case,
    G,
    J,
    Solve,
    case,
    departure,
    drift,
    inertia_about_joint,
    largest,
    plane_swing,
    refused,
    scene,
    start_at,
    start_of,
)

# --- through the pole: thin rods ------------------------------------------------------------------------------------

TURN_RATE = 9.0  # rad/s: enough for full turns, through both poles


def _close_by(run: Trajectory) -> float:
    q, v = np.array([1e-9, 0.3]), np.array([1e-8, TURN_RATE])
    exact = spherical(direction(q), direction_rate(q, v), REDUCED, G, run.t)
    return float(np.linalg.norm(run.tips[:, 0] - exact, axis=-1).max())


def _in_a_chain(solve: Solve, full: bool) -> float:
    there = scene("thin-pole-chain", None if full else {"duration": 2.0})
    q, v = (x.reshape(-1, 2)[:, ::-1].ravel() for x in start_of(there))
    through, turned = solve(there), solve(start_at(there, q, v))
    x, y, z = np.moveaxis(through.tips, -1, 0)
    return largest(np.stack([0 * y, -x, z], -1) - turned.tips)


AWAY = 0.3  # rad from the pole, at the start and at the end
SPEED = 3.0  # rad/s


def _passing(radius: float, aim: float) -> Case:
    """A rod of 1 m that moves towards the pole and would miss it by `aim` rad if it were thin.

    Without gravity p = D theta' and J phi'² + p²/D = J SPEED² are constant, where D = I3 + k sin²(x), k = J - I3, x the
    distance from the pole; p = J aim SPEED. So SPEED dt = sqrt(D / (D - J aim²)) dx and d theta = p dt / D: two
    integrals give the time from AWAY to AWAY, which is the scene's duration, and how far theta turns. Where
    I3 < J aim² the rod turns back.
    """
    rod = Rod(length=1.0, mass=1.0, radius=radius)
    narrow = float(np.sqrt(rod.properties.I3 / inertia_about_joint(rod)))

    def figure(run: Trajectory) -> float:
        from mpmath import mp, mpf

        with mp.workdps(60):
            J, I3, b = (mpf(x) for x in (inertia_about_joint(rod), rod.properties.I3, aim))
            k, rest = J - I3, I3 - J * b**2
            nearest = mp.asin(mp.sqrt(-rest / k)) if rest < 0 else mpf(0)

            def rate(x):  # of theta by x: D and D - J b² under the root
                D = I3 + k * mp.sin(x) ** 2
                return 1 / mp.sqrt(D * (max(rest, mpf(0)) + k * mp.sin(x - nearest) * mp.sin(x + nearest)))

            turn = J * b * mp.quad(rate, [nearest, mpf(AWAY)]) if aim else mpf(0)
            end = (0.3 + float(2 * turn), float(mp.pi / 2 + (-1 if rest < 0 else 1) * AWAY))
        return largest(run.q[-1] - end)

    bound = 1e-12 * 1000 * np.pi / narrow
    return case("thick-pole", bound, figure, mm=1e3 * radius, aim=aim, narrow=narrow)


# --- starts on the pole and upright ---------------------------------------------------------------------------------

POLE = np.pi / 2
OFF_POLE = 6.123233995736766e-17  # rad, the double nearest to pi/2 below it
SPIN = 5.0  # rad/s
TORQUE = 1e-2  # N m
I3 = ROD.properties.I3
FINEST = 1e-14  # the smallest tolerance of the Runge-Kutta methods
FALLING = 1e-12 * 1000 * 80  # at most 1,000 steps; errors grow by 1 + omega T = 80
SHORT_FALL = {"duration": 3.0, "solver.samples": 4}
UPRIGHT = ({}, {"model.rods[0].radius": 0.0}, {"model.copies": 3})  # the first alone in the short form


def _leaving(
    name: str, rounding: float, off: float, place: float, angle: int = 0, far: float = 1e-2, rate: float = SWING
) -> Case:
    """The error in s of the time at which a rod that starts `off` rad from a place is `far` from it: off cosh(rate t).

    Its bound is what `rounding` in rad of the start changes in that time.
    """

    bound, exact = float(np.log1p(rounding / off)) / rate, float(np.arccosh(far / off)) / rate
    return case(name, bound, lambda run: abs(departure(run, run.q[:, angle] - place, far) - exact))


# --- springs, dampers and supports ten thousand times faster than the motion ----------------------------------------

STIFF = 1e8  # N m/rad, or N m s/rad
WEIGHT = ROD.mass * ROD.properties.h * G  # N m/rad of a small angle
FAST = float(np.sqrt(STIFF / J))  # rad/s


def _overdamped(damping: float) -> Case:
    """The error of theta in rad. Without inertia damping theta' = -weight sin(theta): tan(theta/2) falls exponentially."""
    decay = WEIGHT / damping  # 1/s

    def figure(run: Trajectory) -> float:
        return largest(run.q[:, 0] - 2 * np.arctan(np.tan(0.5) * np.exp(-decay * run.t)))

    bound = 1e-10 * 1000 + 10 * J * WEIGHT / damping**2
    return case("overdamped", bound, figure, damping=damping, decay=damping / J, rate=decay)


def _clamped(solve: Solve, full: bool) -> float:
    """The distance in m between the tips of two clamped rods and of one rod of twice the length and mass."""
    clamped = scene("clamped-1e8", None if full else {"duration": 0.5})
    rods = {"model.copies": 1, "model.rods": [{"length": 2.0, "mass": 2.0, "radius": ROD.radius}]}
    one_rod = rods | {"start.positions": {"theta": 0.5, "phi": 0.1}, "effects": clamped.effects[:1]}
    two, one = solve(clamped), solve(clamped.replace(one_rod))
    return float(np.linalg.norm(two.tips[:, 1] - one.tips[:, 0], axis=-1).max())


SHAKE, SHAKEN = 1e-3, 1e4  # m, rad/s
LEAN = 1e-3  # rad from upright
AVERAGED = (SHAKE / REDUCED) ** 2 + LEAN**2 + 1e-12 * 40_000 / LEAN  # what averaging leaves out, and 40,000 steps
SLOW = float(np.sqrt((SHAKE * SHAKEN / REDUCED) ** 2 / 2 - G / REDUCED))  # rad/s, Kapitza's swing about the upright


def _kapitza(run: Trajectory) -> float:
    """The difference of the lean to the averaged motion with its ripple, divided by the first lean."""
    ripple = 1 + SHAKE / REDUCED * np.cos(SHAKEN * run.t)
    averaged = np.cos(SLOW * run.t) * ripple / ripple[0]
    return largest((np.pi - run.q[:, 0]) / LEAN - averaged)


# --- joints that stick or hit a stop --------------------------------------------------------------------------------


def _edge(solve: Solve, full: bool) -> float:
    """How many of two rods are wrong: friction 1e-9 above the torque of the weight must hold, 1e-9 below must not."""
    needed = ROD.mass * ROD.properties.h * G * np.sin(0.3)  # N m
    frictions = needed * (1 + 1e-9), needed * (1 - 1e-9)
    sticking, loose = (solve(scene("stick-edge", {"effects[1].static": friction})) for friction in frictions)
    moved = (sticking.q != sticking.q[0]).any() or sticking.v.any()
    return float(moved) + float(np.abs(loose.q[:, 0] - 0.3).max() < 0.1)


STIFFNESS, FRICTION = 4.0, 0.13  # N m/rad, N m


def _sticking(run: Trajectory) -> float:
    """The error of the place where a rod on a spring sticks: each half swing is 2 friction / stiffness shorter."""
    amplitude, sign = 1.0, 1.0
    while amplitude > FRICTION / STIFFNESS:
        amplitude, sign = amplitude - 2 * FRICTION / STIFFNESS, -sign
    return float(abs(run.q[-1, 0] - sign * amplitude) + abs(run.v[-1, 0]))


def _bouncing(run: Trajectory) -> float:
    """The error of a joint that 1 N m pushes from -1 rad to a stop at 0: shorter and shorter bounces, then rest."""
    back, a = 0.5, 1 / J  # restitution, rad/s²
    t, exact = run.t, -1 + a * run.t**2 / 2
    start, speed = np.sqrt(2 / a), np.sqrt(2 * a) * back
    while speed > 1e-9:
        flight = 2 * speed / a
        inside = (t >= start) & (t < start + flight)
        since = t[inside] - start
        exact[inside] = -speed * since + a * since**2 / 2
        start, speed = start + flight, speed * back
    exact[t >= start] = 0.0
    return largest(run.q[:, 0] - exact)


RATE, LIMIT = 1.0, 0.5  # rad/s, rad


def _both(run: Trajectory) -> float:
    """The error of two joints with coupled inertias at one rate; exact: a triangle wave between their stops."""
    wave = np.abs((RATE * run.t + LIMIT) % (4 * LIMIT) - 2 * LIMIT)
    return largest(run.q[:, THETA] - (LIMIT - wave)[:, None])


CASES = (
    case("thin-pole", 1e-12 * 1000 * 180, plane_swing(0.3, REDUCED, 1, TURN_RATE), {"duration": 4.0}),
    case("thin-pole-close", 1e-12 * 1000 * 180, _close_by, {"duration": 4.0}),
    case("thin-pole-chain", 2 * 1e-12 * 2000 * 240, measure=_in_a_chain),
    *(_passing(radius, aim) for radius in (1e-3, 1e-4) for aim in (1e-3, 1e-6, 0.0)),
    case("pole-rest-thin", FALLING, plane_swing(POLE, REDUCED, 1), SHORT_FALL),
    case("pole-spin-thin", FALLING, plane_swing(POLE, REDUCED, 1), SHORT_FALL),
    case("pole-rest-thick", FALLING, plane_swing(POLE, HANG, 1), SHORT_FALL),
    _leaving("pole-spin-thick", FINEST, OFF_POLE, POLE, angle=1, far=1e-3, rate=SPIN * float(np.sqrt(1 - I3 / J))),
    case(
        "pole-torque-thick",  # up to 20 rad, before the growth exp(20) of OFF_POLE is seen; in the short form to 10 rad
        1e-12 * 500 * 20 + (OFF_POLE * np.exp(20)) ** 2 * J / I3 * 20,
        lambda run: largest(run.q[:, 0] - TORQUE * run.t**2 / (2 * I3)),
        {"duration": np.sqrt(2 * I3 * 10.0 / TORQUE)},
    ),
    case("pole-phi-torque-thin", 1e-12 * 500 * 13.5, lambda run: largest(run.q[:, 1] - POLE - 1.5 * run.t**2)),
    case("pole-torque-thin", 0.0, measure=refused("pole-torque-thin", "rod", "radius")),
    case(
        "upright-exact",
        0.0,
        measure=lambda solve, full: max(
            largest(solve(scene("upright-exact", UPRIGHT[i])).q) for i in range(1 + 2 * full)
        ),
    ),
    _leaving("upright-1e-15", FINEST, 1e-15, 0.0),
    _leaving("upright-pi", FINEST * np.pi + 20 * EPS, 2 * OFF_POLE, np.pi),
    case(
        "spring-1e8",  # the error of the angle, divided by the first angle; exact: a cosine
        1e-12 * 270 * 20 * 0.1 * FAST * FAST / (1e-3 * FAST),
        lambda run: largest(run.q[:, 0] / 1e-3 - np.cos(FAST * run.t)),
        {"duration": 0.01},
    ),
    case("spring-chain", 1e-10 * 20_000 * 10, drift, {"duration": 0.01}),
    case("clamped-1e8", 2 * (100 * 2 / STIFF + 1e-9 * 1000 * 15), measure=_clamped),
    _overdamped(1e4),
    _overdamped(1e8),
    case("kapitza-1e4", (1 + SLOW * 2) * AVERAGED, _kapitza, {"duration": 0.03}),
    case("stick-edge", 0.0, measure=_edge),
    case("stick-slip", 1e-11 * 2000, _sticking),
    case("stop-rest", 0.0, lambda run: float(np.abs(run.q - run.q[0]).max() + np.abs(run.v).max())),
    case("bounces", 1e-11 * 1000 * 3, _bouncing),
    case("stops-at-once", 1e-11 * 2000, _both, {"duration": 4.0}),
    case("stop-beyond", 0.0, measure=refused("stop-beyond", "start.positions.theta", "beyond its stop")),
)
