"""One rod or two: through the pole and from it, upright, stiff springs and dampers, joints that stick or hit a stop."""

from functools import cache
from typing import Any

import numpy as np

from pendpin.effects import DryFriction, Gravity, Motor, Spring, Stop, Support, Viscous
from pendpin.equations.base import THETA
from pendpin.equations.exact import direction, direction_rate, planar, spherical
from pendpin.ground.arrays import EPS
from pendpin.scene import Chain, Rod, Scene
from pendpin.verification.hardcases.base import (
    HANG,
    REDUCED,
    ROD,
    SWING,
    THICK,
    THIN,
    TIGHT,
    Case,
    G,
    J,
    Solve,
    case,
    departure,
    drift_of,
    inertia_about_joint,
    refused,
    scene,
    settings,
    tip_errors,
)

# --- through the pole: thin rods ------------------------------------------------------------------------------------

TURN_RATE = 9.0  # rad/s: enough for full turns, through both poles
TURNING: dict[str, Any] = {"bound": 1e-12 * 1000 * 180, "methods": settings(auto=1e-12, rk45=1e-12, taylor=1e-16)}


def _straight_through(solve: Solve, full: bool) -> float:
    run = solve(scene(THIN, q=(0.0, 0.3), v=(0.0, TURN_RATE), duration=20.0 if full else 4.0, samples=21))
    return tip_errors(run, run.q[:, 1], planar(0.3, TURN_RATE, REDUCED, G, run.t))


def _close_by(solve: Solve, full: bool) -> float:
    q, v = np.array([1e-9, 0.3]), np.array([1e-8, TURN_RATE])
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
        way = [nearest, mpf(AWAY)]

        def D(x):
            return I3 + k * mp.sin(x) ** 2

        def over(x):  # D - J b²
            return max(rest, mpf(0)) + k * mp.sin(x - nearest) * mp.sin(x + nearest)

        half = mp.quad(lambda x: mp.sqrt(D(x) / over(x)), way) / w
        turn = J * b * mp.quad(lambda x: 1 / mp.sqrt(D(x) * over(x)), way) if aim else mpf(0)
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
I3 = ROD.properties.I3
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
FINE = settings(auto=FINEST, taylor=1e-16)


# --- springs, dampers and supports ten thousand times faster than the motion ----------------------------------------

STIFF = 1e8  # N m/rad, or N m s/rad
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
AVERAGED = (SHAKE / REDUCED) ** 2 + LEAN**2 + 1e-12 * 40_000 / LEAN  # what averaging leaves out, and 40,000 steps
SLOW = float(np.sqrt((SHAKE * SHAKEN / REDUCED) ** 2 / 2 - G / REDUCED))  # rad/s, Kapitza's swing about the upright


def _kapitza(solve: Solve, full: bool) -> float:
    """The difference of the lean to the averaged motion with its ripple, divided by the first lean."""
    support = Support(amplitude=(0.0, 0.0, SHAKE), frequency=SHAKEN, phase=np.pi / 2)
    duration = 2.0 if full else 0.03
    run = solve(scene(THIN, support, q=(np.pi - LEAN,), duration=duration, samples=41))
    ripple = 1 + SHAKE / REDUCED * np.cos(SHAKEN * run.t)
    averaged = np.cos(SLOW * run.t) * ripple / ripple[0]
    return float(np.abs((np.pi - run.q[:, 0]) / LEAN - averaged).max())


def _edge(solve: Solve, full: bool) -> float:
    """How many of two rods are wrong: friction 1e-9 above the torque of the weight must hold, 1e-9 below must not."""
    needed = ROD.mass * ROD.properties.h * G * np.sin(0.3)  # N m
    sticking, loose = (
        solve(scene(THICK, DryFriction(kinetic=0.1, static=needed * (1 + margin)), q=(0.3,), duration=2.0, samples=5))
        for margin in (1e-9, -1e-9)
    )
    moved = (sticking.q != sticking.q[0]).any() or sticking.v.any()
    return float(moved) + float(np.abs(loose.q[:, 0] - 0.3).max() < 0.1)


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
    run = solve(scene(THICK, Stop(lower=0.2, joints=("theta",)), q=(0.2,), duration=5.0, samples=11))
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


METHODS = settings(auto=1e-11, rk45=1e-11, radau=1e-11)


LEVEL, SPUN, COARSE = (0.0, POLE), (SPIN, 0.0), settings(gauss4=0.1, rk4=0.1, euler=0.1)
PUSHED, BESIDE, AT_ONE = Motor(joint="theta", torque=1.0), Stop(upper=0.5), {"q": (1.0,), "duration": 1.0}
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
    case("pole-torque-thin", 0.0, settings(auto=None), refused("rod", "radius", THIN, PUSHED, q=LEVEL, duration=2.0)),
    case("upright-exact", 0.0, settings(auto=None, rk45=None, radau=None, taylor=None) | COARSE, _upright),
    case("upright-1e-15", float(np.log1p(FINEST / 1e-15)) / SWING, FINE | settings(gauss6=0.01, rk4=0.001), _leaning),
    case("upright-pi", float(np.log1p((FINEST * np.pi + 20 * EPS) / (2 * OFF_POLE))) / SWING, FINE, _upside_down),
    case("spring-1e8", 1e-12 * 270 * 20 * 0.1 * FAST * FAST / (1e-3 * FAST), TIGHT | settings(gauss6=1e-5), _ringing),
    case("spring-chain", 1e-10 * 20_000 * 10, settings(auto=1e-10), drift_of(bent, 0.1, 0.01)),
    case("clamped-1e8", 2 * (100 * 2 / STIFF + 1e-9 * 1000 * 15), settings(auto=1e-9, radau=1e-9, bdf=1e-9), _clamped),
    _overdamped(1e4),
    _overdamped(1e8),
    case("kapitza-1e4", (1 + SLOW * 2) * AVERAGED, settings(auto=1e-12, taylor=1e-15), _kapitza),
    case("stick-edge", 0.0, METHODS, _edge),
    case("stick-slip", 1e-11 * 2000, settings(auto=1e-11, rk45=1e-11), _sticking),
    case("stop-rest", 0.0, METHODS, _resting),
    case("bounces", 1e-11 * 1000 * 3, METHODS, _bouncing),
    case("stops-at-once", 1e-11 * 2000, METHODS, _both),
    case("stop-beyond", 0.0, METHODS, refused("start.positions.theta", "beyond its stop", THICK, BESIDE, **AT_ONE)),
)
