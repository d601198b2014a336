"""Long chains, unlike neighbours, sizes, gravities and times far from everyday ones; chaos, symmetries and long horizons."""

from functools import cache, partial

import numpy as np

from pendpin.effects import Gravity, Motor
from pendpin.equations.base import split_by_rod
from pendpin.equations.chain import solution, thin
from pendpin.equations.exact import planar
from pendpin.ground.arrays import EPS, Array
from pendpin.model.bodies import pinocchio
from pendpin.model.build import build
from pendpin.motions.trajectory import Trajectory, simulate
from pendpin.scene import Chain, Rod, Scene, Solver
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
    Solve,
    case,
    drift_of,
    reverse_rates,
    scene,
    settings,
    tip_errors,
)

# --- unlike neighbours ----------------------------------------------------------------------------------------------

ONE, LIGHT, HEAVY, SHORT = (1.0, 1.0), (1e-6, 1.0), (1e6, 1.0), (1.0, 1e-4)  # kg, m
Scale = tuple[tuple[float, float], ...]  # mass in kg and length in m of each rod


def _swinging(sizes: Scale, duration: float) -> Scene:
    model = Chain(rods=tuple(Rod(length=length, mass=mass, radius=0.02 * length) for mass, length in sizes))
    return scene(model, q=np.resize([0.4, 0.2, 0.3, -0.1], 2 * len(sizes)), duration=duration, samples=11)


@cache
def _solve_by_reactions(sizes: Scale, duration: float) -> Array:
    """The tips (n, rods, 3) in m by the chain equations (reactions as the unknowns), at a tight tolerance."""
    solver = Solver(engine="chain", method="dop853", tolerance=1e-12, samples=11)
    return simulate(_swinging(sizes, duration).model_copy(update={"solver": solver})).tips


def _unlike(
    name: str, sizes: Scale, tolerance: float, most_steps: int, growth: float, most: float, short: float
) -> Case:
    """The largest distance of a rod's tip to that by the chain equations, seen from the rod's joint, over its length."""

    def measure(solve: Solve, full: bool) -> float:
        duration = most if full else short
        apart = solve(_swinging(sizes, duration)).tips - _solve_by_reactions(sizes, duration)
        relative = np.diff(apart, axis=1, prepend=0.0)  # of each rod's tip to its own joint
        return float((np.linalg.norm(relative, axis=-1) / [length for _, length in sizes]).max())

    methods = settings(auto=tolerance) | (settings(taylor=1e-14) if len(sizes) == 2 else {})
    words = {"tolerance": tolerance, "most_steps": most_steps, "growth": growth}
    return case(name, tolerance * most_steps * growth, methods, measure, **words)


HUNDRED, CABLE = Chain(rods=(ROD,), copies=100), Chain(rods=(ROD,), copies=2000)


def tumbling(model: Chain, duration: float) -> Scene:
    """A chain with random angles and rates."""
    random = np.random.default_rng(0)
    q, v = random.normal(size=(2, 2 * model.count))
    return scene(model, q=0.3 * q, v=v, duration=duration, samples=3)


def _digits(solve: Solve, full: bool) -> float:
    """The largest difference of the accelerations of runs from random states to the chain equations, over the largest."""
    q, v = np.random.default_rng(1).uniform(-1, 1, (2, 3, 2 * HUNDRED.count))[:, : 3 if full else 1]
    starts = [scene(HUNDRED, q=q, v=v, duration=0.0) for q, v in zip(q, v, strict=True)]
    accelerations = np.array([solve(start).a[0] for start in starts])
    inertia, field = build(HUNDRED).chain, np.array([0.0, 0.0, G])
    assert inertia is not None
    exact = solution.solve(inertia, split_by_rod(q), split_by_rod(v), field).acceleration.reshape(q.shape)
    return float(np.abs(accelerations - exact).max() / np.abs(exact).max())


def _other_joints() -> dict[str, float]:
    """Of Pinocchio's own joints the torque that rnea leaves of aba's accelerations, over that which holds the chain."""
    pin, (x, y, _) = pinocchio(), np.eye(3)
    m, h, *principal = ROD.properties
    body, figures = pin.Inertia(m, np.array([0, 0, -h]), np.diag(principal)), {}
    for name, joint in (("Universal", pin.JointModelUniversal(-x, -y)), ("Spherical", pin.JointModelSpherical())):
        model, parent = pin.Model(), 0
        for i in range(HUNDRED.count):
            place = pin.SE3(np.eye(3), np.array([0.0, 0.0, -ROD.length if i else 0.0]))
            parent = model.addJoint(parent, joint, place, str(i))
            model.appendBodyToJoint(parent, body, pin.SE3.Identity())
        data, none = pin.Data(model), [pin.Force.Zero()] * model.njoints
        step, v = np.random.default_rng(1).uniform(-1, 1, (2, model.nv))
        q = pin.integrate(model, pin.neutral(model), step)
        for word in ("LOCAL", "WORLD"):
            a = pin.aba(model, data, q, v, 0 * v, none, getattr(pin.Convention, word))
            left = np.abs(pin.rnea(model, data, q, v, a)).max()
            holding = np.abs(pin.rnea(model, data, q, 0 * v, 0 * v)).max()
            figures[f"pin {name}, {word}"] = float(left / holding)
    return figures


def whip(size: tuple[int, float]) -> Scene:
    """A chain of n thin rods, 1 m long, released level and at rest for a duration in s."""
    n, duration = size
    model = Chain(rods=(Rod(length=1 / n, mass=1 / n),), copies=n)
    return scene(model, q=(np.pi / 2,), duration=duration, samples=31)


# --- the same motion in other units ---------------------------------------------------------------------------------


def _off(values: Array, exact: Array) -> float:
    """The largest difference of two arrays of one shape (n, k)."""
    return float(np.abs(values - exact).max())


def _sized(length: float, mass: float, duration: float, time: float = 0.0) -> Scene:
    """Two rods in units of this length and mass; gravity stays the same, so the unit of time is sqrt(length)."""
    unit = np.sqrt(length)
    upper = Rod(length=length, mass=mass, radius=0.05 * length)
    lower = Rod(length=0.7 * length, mass=2 * mass, radius=0.05 * length)
    v = np.array([1.3, -0.8, 0.2, 0.5]) / unit
    fields = {"q": (0.7, 0.4, -0.3, 0.2), "v": v, "duration": float(duration * unit), "samples": 21, "time": time}
    return scene(Chain(rods=(upper, lower)), **fields)


def _rescaled(solve: Solve, full: bool, length: float, mass: float) -> float:
    duration = 3.0 if full else 1.0
    here, there = solve(_sized(1.0, 1.0, duration)), solve(_sized(length, mass, duration))
    return _off(here.q, there.q)


def _straight(solve: Solve, full: bool) -> float:
    run = solve(scene(THICK, q=(0.3,), v=(2.0,), duration=100.0, samples=11, gravity=Gravity(acceleration=0.0)))
    return float(np.abs(run.q[:, 0] - 0.3 - 2.0 * run.t).max())


def _falling_case(g: float, duration: float, growth: float) -> Case:
    """A rod that falls by a gravity g in m/s² for some s, in which errors grow 1 + omega T times."""

    def measure(solve: Solve, full: bool) -> float:
        gravity = Gravity(acceleration=g)
        run = solve(scene(THICK, q=(1.0,), duration=duration if full else duration / 4, samples=11, gravity=gravity))
        return tip_errors(run, run.q[:, 0], planar(1.0, 0.0, HANG, g, run.t))

    bound, words = 1e-12 * 1500 * growth + 1500 * EPS * growth, {"g": g, "duration": duration, "growth": growth}
    return case("gravity", bound, settings(auto=1e-12, taylor=1e-16), measure, **words)


LATE = 1e9  # s
SMALL = 1e-6  # m: millisecond dynamics


def _late(solve: Solve, full: bool) -> float:
    """The largest differences of q, v and t to the run from t = 0, summed; rad, rad/s, s."""
    here, there = (solve(_sized(SMALL, 1e-9, 5.0, time=time)) for time in (0.0, LATE))
    return _off(here.q, there.q) + _off(here.v, there.v) + _off(there.t, LATE + here.t)


RATE = 1e3  # rad/s


def _driven_late(solve: Solve, full: bool) -> float:
    """The difference in rad of two runs with a sinusoidal motor: from 1e9 s, and from 0 with the phase of 1e9 s."""
    from mpmath import mp, mpf

    with mp.workdps(40):
        phase = float(mp.fmod(mpf(RATE) * mpf(LATE), 2 * mp.pi))

    def drive(time: float, phase: float) -> Scene:
        motor = Motor(joint="theta", amplitude=100.0, frequency=RATE, phase=phase)
        return scene(THICK, motor, q=(0.3,), duration=0.02, samples=11, time=time)

    return _off(solve(drive(0.0, phase)).q, solve(drive(LATE, 0.0)).q)


def _start_alone(solve: Solve, full: bool, samples: int | None) -> float:
    run = solve(scene(THICK, q=(0.7, 0.4), v=(1.3, -0.8), duration=0.0, samples=samples))
    return float(np.abs(run.q[0] - (0.7, 0.4)).max()) + abs(len(run.t) - 1)


def _fine_samples(solve: Solve, full: bool) -> float:
    count = 100_001 if full else 10_001
    run = solve(scene(THICK, q=(1.0,), duration=1.0, samples=count))
    some = slice(None, None, count // 200)
    return tip_errors(run, run.q[some, 0], planar(1.0, 0.0, HANG, G, run.t[some]))


FINE = settings(auto=1e-14, taylor=1e-18)
AT_ONCE = settings(auto=None, radau=None, taylor=None, gauss6=0.01, rk4=0.01)
UNITS = (("micro", "micrometres and micrograms", 1e-6, 1e-9), ("kilo", "kilometres and tonnes", 1e3, 1e3))  # m, kg


DOUBLE = Chain(rods=(ROD,), copies=2)
WILD = np.array([2.0, 0.5, 1.0, 0.3])
APART = 1e-8  # rad, of two starts
FAR = 1e-2  # m: runs this far apart are no longer compared

# --- chaos ----------------------------------------------------------------------------------------------------------


def wild(duration: float, q: Array = WILD) -> Scene:
    """A double pendulum that moves chaotically, from q (4,) in rad."""
    return scene(DOUBLE, q=q, duration=duration, samples=round(20 * duration) + 1)


def _gap(one: Trajectory, other: Trajectory) -> Array:
    return np.linalg.norm(one.tips - other.tips, axis=-1).max(-1)


@cache
def _reference(duration: float) -> tuple[Trajectory, Array]:
    """A run at the smallest tolerance, and the largest growth so far of a difference at the start, at each sample (n,)."""
    one, other = (
        simulate(wild(duration, WILD + off), method="dop853", tolerance=1e-14) for off in (0.0, [APART, 0.0, 0.0, 0.0])
    )
    return one, np.maximum.accumulate(np.maximum(_gap(one, other) / APART, 1.0))


def _predicted(run: Trajectory, growth: Array) -> Array:
    """The predicted error (n,) in m: the tolerance, times the steps so far, times the measured growth (n,)."""
    assert run.stats.tolerance is not None
    return run.stats.tolerance * (1 + run.stats.steps * run.t / run.t[-1]) * growth


def _methods_agree(solve: Solve, full: bool) -> float:
    duration = 20.0 if full else 10.0
    reference, growth = _reference(duration)
    run = solve(wild(duration))
    predicted = _predicted(run, growth)
    within = (predicted < FAR) & (growth < FAR / APART)
    return float((_gap(run, reference) / predicted)[within].max())


def _there_and_back(solve: Solve, full: bool) -> float:
    duration = 8.0 if full else 4.0
    there = solve(wild(duration))
    back = solve(reverse_rates(there, wild(duration)))
    predicted = 2 * _predicted(there, _reference(duration)[1])[-1]
    return float(np.abs(np.concatenate([back.q[-1] - WILD, back.v[-1]])).max() / predicted)


# --- symmetry -------------------------------------------------------------------------------------------------------

CALM_Q, CALM_V = np.array([0.7, 0.4, -0.3, 0.2]), np.array([1.3, -0.8, 0.2, 0.5])
SIGNS = {"x to -x": (1.0, -1.0), "y to -y": (-1.0, 1.0), "half a turn": (-1.0, -1.0)}  # of theta, phi


def _calm(q: Array, v: Array, full: bool) -> Scene:
    """A double pendulum from q (4,) in rad, v (4,) in rad/s."""
    return scene(DOUBLE, q=q, v=v, duration=4.0 if full else 1.0, samples=11)


def _mirrored(solve: Solve, full: bool) -> float:
    plain, worst = solve(_calm(CALM_Q, CALM_V, full)), 0.0
    for signs in SIGNS.values():
        both = np.tile(signs, 2)
        image = solve(_calm(both * CALM_Q, both * CALM_V, full))
        worst = max(worst, float(np.abs(image.q - both * plain.q).max()))
    return worst


THIN_PAIR = Chain(rods=(Rod(length=1.0, mass=1.0), Rod(length=0.5, mass=0.3)))


def _quarter(solve: Solve, full: bool) -> float:
    """Thin rods, whose joint has no preferred axes, turned by 90 degrees about the vertical."""
    q, v = CALM_Q.reshape(2, 2), CALM_V.reshape(2, 2)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    d, rate = (x @ turn for x in thin.directions(q, v))  # in I, whose z points down, the turn is the other way
    image = thin.read(d[None], rate[None])
    tips = [
        solve(scene(THIN_PAIR, q=a.ravel(), v=b.ravel(), duration=4.0 if full else 1.0, samples=11)).tips
        for a, b in ((q, v), (image.q, image.v))
    ]
    return float(np.abs(tips[1] - tips[0] @ turn.T).max())


def _reversed(solve: Solve, full: bool) -> float:
    calm = _calm(CALM_Q, CALM_V, full)
    back = solve(reverse_rates(solve(calm), calm))
    return float(np.abs(np.concatenate([back.q[-1] - CALM_Q, back.v[-1] + CALM_V])).max())


GROWTH = 100  # of a small difference within 4 s in the regular motion
ALIKE = settings(auto=1e-12, rk45=1e-9, radau=1e-9, taylor=1e-16, gauss6=0.01, rk4=0.002, euler=0.002)


# --- many turns in conical motion, and many swings ------------------------------------------------------------------


def cone(rate: float, turns: int) -> Scene:
    """A thin rod in conical motion at a rate in rad/s: cos(phi) = g / (reduced length rate²)."""
    phi = float(np.arccos(G / (REDUCED * rate**2)))
    v = (-rate * np.tan(phi), 0.0)
    return scene(THIN, q=(0.0, phi), v=v, duration=2 * np.pi * turns / rate, samples=3)


def _spinning(rate: float) -> Case:
    drift, fastest = drift_of(partial(cone, rate), long=10_000, short=50), rate / (G / (REDUCED * rate**2))
    methods = settings(auto=1e-10, taylor=1e-16)
    return case("cone", 1e-10 * 10_000 * 10 * 2, methods, drift, rate=rate, fastest=fastest)


ANGLE = 0.7  # rad
SWINGS = 1_000_000
STEPS_A_SWING = 30  # of a method of high order near rounding


def _swings(solve: Solve, full: bool) -> float:
    from scipy.special import ellipk

    period = 4 / SWING * float(ellipk(np.sin(ANGLE / 2) ** 2))  # s, of the thin rod of 1 m from ANGLE at rest
    duration, samples = ((SWINGS if full else 30) + 0.3) * period, 11  # the end is in full swing
    run = solve(scene(THIN, q=(ANGLE,), duration=duration, samples=samples))
    return tip_errors(run, run.q[:, 0], planar(ANGLE, 0.0, REDUCED, G, np.linspace(0.0, duration, samples)))


def in_space(duration: float) -> Scene:
    """A thick rod that swings in space."""
    return scene(THICK, q=(0.7, 0.4), v=(1.3, -0.8), duration=duration, samples=801)


TRIPLE = Chain(rods=(ROD,), copies=3)


def triple(duration: float) -> Scene:
    """Three thick rods that move chaotically."""
    return scene(TRIPLE, q=(1.5, 0.3, 1.0, -0.2, 0.5, 0.1), duration=duration, samples=101)


CASES = (
    _unlike("mass-light-below", (ONE, LIGHT), 1e-11, 1000, 100, most=3.0, short=1.0),
    _unlike("mass-light-above", (LIGHT, ONE), 1e-11, 1000, 100, most=3.0, short=1.0),
    _unlike("mass-heavy-below", (ONE, HEAVY), 1e-11, 1000, 100, most=3.0, short=1.0),
    _unlike("mass-mixed", (ONE, LIGHT, ONE, HEAVY), 1e-10, 1000, 100, most=0.3, short=0.05),
    _unlike("length-short-below", (ONE, SHORT), 1e-11, 2000, 100, most=0.5, short=0.05),
    _unlike("length-short-above", (SHORT, ONE), 1e-9, 2000, 1000, most=0.2, short=0.05),
    case("chain-100", 1e-9 * 1000 * 10, settings(auto=1e-9), drift_of(partial(tumbling, HUNDRED), 0.5, 0.02)),
    case("chain-100-digits", 200 * 100 * EPS, settings(auto=None), _digits, _other_joints),
    case("chain-2000", 1e-8 * 1000 * 10, settings(auto=1e-8), drift_of(partial(tumbling, CABLE), 0.02, 0.001)),
    case("whip", 1e-10 * 2000 * 100, settings(auto=1e-10, rk45=1e-10), drift_of(whip, (40, 0.9), (12, 0.3))),
    *(
        case("scale", 1e-12, FINE, partial(_rescaled, length=length, mass=mass), name=name, units=units)
        for name, units, length, mass in UNITS
    ),
    case("gravity-0", 1000 * EPS * 200, TIGHT | settings(gauss6=0.1, rk4=0.1), _straight),
    _falling_case(1e-12, 1e4, 2),
    _falling_case(1e6, 0.2, 250),
    case("late", 0.0, settings(auto=None, rk45=None, radau=None, taylor=None, gauss6=1e-5, rk4=1e-5), _late),
    case("late-driven", 1e-12 * 500 * 10, TIGHT, _driven_late),
    case("no-duration", 0.0, AT_ONCE, partial(_start_alone, samples=None)),
    case("one-sample", 0.0, AT_ONCE, partial(_start_alone, samples=1)),
    case("fine-samples", 1e-10 * 50 * 5 * 10, settings(auto=1e-10, rk45=1e-10, taylor=1e-15), _fine_samples),
    case("chaos-methods", 1.0, settings(auto=1e-10, rk45=1e-9, radau=1e-9, lsoda=1e-10, taylor=1e-10), _methods_agree),
    case("chaos-back", 1.0, settings(auto=1e-10, lsoda=1e-10, taylor=1e-10), _there_and_back),
    case("mirrored", 100 * EPS * 1000 * GROWTH, ALIKE, _mirrored),
    case("turned", 2 * 1e-12 * 1000 * GROWTH, settings(auto=1e-12, rk45=1e-12, taylor=1e-16), _quarter),
    case("reversed", 2 * 1e-12 * 1000 * GROWTH, TIGHT | settings(gauss2=0.02, gauss4=0.02, gauss6=0.02), _reversed),
    *(_spinning(rate) for rate in (1e2, 1e3, 1e4)),
    case("swings-1e6", EPS * np.sqrt(STEPS_A_SWING * SWINGS) * 2 * np.pi * SWINGS, FINE, _swings),
    case("swings-in-space", 1e-12 * 50 * 1600, TIGHT | settings(gauss6=0.05), drift_of(in_space, 1600.0, 40.0)),
    case("triple-1e4", 1e-10 * 200 * 10_000 * 10, settings(auto=1e-10), drift_of(triple, 1e4, 10.0)),
)
