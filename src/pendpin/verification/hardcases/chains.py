"""Long chains, neighbours that differ much, and scenes far from everyday sizes, gravities and times."""

from functools import cache, partial

import numpy as np

from pendpin.effects import Gravity, Motor
from pendpin.equations.base import split_by_rod
from pendpin.equations.chain import solution
from pendpin.equations.exact import planar
from pendpin.ground.arrays import EPS, Array
from pendpin.model.bodies import pinocchio
from pendpin.model.build import build
from pendpin.motions.simulate import simulate
from pendpin.scene import Chain, Rod, Scene, Solver
from pendpin.verification.hardcases.base import (
    ROD,
    THICK,
    Case,
    G,
    Solve,
    case,
    drift_of,
    inertia_about_joint,
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


# --- many rods ------------------------------------------------------------------------------------------------------

HUNDRED = Chain(rods=(ROD,), copies=100)


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
    """The figure for Pinocchio's own joints of two and three degrees of freedom, by both of its algorithms.

    The largest torque that rnea computes for the accelerations of aba, over the torque that holds the chain.
    """
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


def whip(n: int, duration: float) -> Scene:
    """A chain of n thin rods, 1 m long, released level and at rest."""
    model = Chain(rods=(Rod(length=1 / n, mass=1 / n),), copies=n)
    return scene(model, q=(np.pi / 2,), duration=duration, samples=31)


def _whip(solve: Solve, full: bool) -> float:
    return solve(whip(40, 0.9) if full else whip(12, 0.3)).energy().drift


# --- the same motion in other units ---------------------------------------------------------------------------------

REDUCED = inertia_about_joint(ROD) / (ROD.mass * ROD.properties.h)  # m


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


# --- gravities ------------------------------------------------------------------------------------------------------


def _straight(solve: Solve, full: bool) -> float:
    run = solve(scene(THICK, q=(0.3,), v=(2.0,), duration=100.0, samples=11, gravity=Gravity(acceleration=0.0)))
    return float(np.abs(run.q[:, 0] - 0.3 - 2.0 * run.t).max())


def _falling_case(g: float, duration: float, growth: float) -> Case:
    """A rod that falls by a gravity g in m/s² for some s, in which errors grow 1 + omega T times."""

    def measure(solve: Solve, full: bool) -> float:
        gravity = Gravity(acceleration=g)
        run = solve(scene(THICK, q=(1.0,), duration=duration if full else duration / 4, samples=11, gravity=gravity))
        return tip_errors(run, run.q[:, 0], planar(1.0, 0.0, REDUCED, g, run.t))

    bound, words = 1e-12 * 1500 * growth + 1500 * EPS * growth, {"g": g, "duration": duration, "growth": growth}
    return case("gravity", bound, settings(auto=1e-12, taylor=1e-16), measure, **words)


# --- times ----------------------------------------------------------------------------------------------------------

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
    return tip_errors(run, run.q[some, 0], planar(1.0, 0.0, REDUCED, G, run.t[some]))


FINE = settings(auto=1e-14, taylor=1e-18)
TIGHT = settings(auto=1e-12, taylor=1e-16)
AT_ONCE = settings(auto=None, radau=None, taylor=None, gauss6=0.01, rk4=0.01)
UNITS = (("micro", "micrometres and micrograms", 1e-6, 1e-9), ("kilo", "kilometres and tonnes", 1e3, 1e3))  # m, kg


# --- the cases ------------------------------------------------------------------------------------------------------

CASES = (
    _unlike("mass-light-below", (ONE, LIGHT), 1e-11, 1000, 100, most=3.0, short=1.0),
    _unlike("mass-light-above", (LIGHT, ONE), 1e-11, 1000, 100, most=3.0, short=1.0),
    _unlike("mass-heavy-below", (ONE, HEAVY), 1e-11, 1000, 100, most=3.0, short=1.0),
    _unlike("mass-mixed", (ONE, LIGHT, ONE, HEAVY), 1e-10, 1000, 100, most=0.3, short=0.05),
    _unlike("length-short-below", (ONE, SHORT), 1e-11, 2000, 100, most=0.5, short=0.05),
    _unlike("length-short-above", (SHORT, ONE), 1e-9, 2000, 1000, most=0.2, short=0.05),
    case("chain-100", 1e-9 * 1000 * 10, settings(auto=1e-9), drift_of(partial(tumbling, HUNDRED), 0.5, 0.02)),
    case("chain-100-digits", 200 * 100 * EPS, settings(auto=None), _digits, _other_joints),
    case(
        "chain-2000",
        bound=1e-8 * 1000 * 10,
        methods=settings(auto=1e-8),
        measure=drift_of(partial(tumbling, Chain(rods=(ROD,), copies=2000)), long=0.02, short=0.001),
    ),
    case("whip", 1e-10 * 2000 * 100, settings(auto=1e-10, rk45=1e-10), _whip),
    *(
        case("scale", 1e-12, FINE, partial(_rescaled, length=length, mass=mass), name=name, units=units)
        for name, units, length, mass in UNITS
    ),
    case("gravity-0", 1000 * EPS * 200, TIGHT | settings(gauss6=0.1, rk4=0.1), _straight),
    _falling_case(1e-12, 1e4, 2),
    _falling_case(1e6, 0.2, 250),
    case(
        "late",
        bound=0.0,
        methods=settings(auto=None, rk45=None, radau=None, taylor=None, gauss6=1e-5, rk4=1e-5),
        measure=_late,
    ),
    case("late-driven", 1e-12 * 500 * 10, TIGHT, _driven_late),
    case("no-duration", 0.0, AT_ONCE, partial(_start_alone, samples=None)),
    case("one-sample", 0.0, AT_ONCE, partial(_start_alone, samples=1)),
    case("fine-samples", 1e-10 * 50 * 5 * 10, settings(auto=1e-10, rk45=1e-10, taylor=1e-15), _fine_samples),
)
