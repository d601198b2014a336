"""Chaos and symmetries, and many turns and swings, where the errors of all steps add up."""

from functools import cache, partial

import numpy as np

from pendpin.equations.chain import angles, thin
from pendpin.equations.exact import planar
from pendpin.ground.arrays import EPS, Array
from pendpin.motions.simulate import simulate
from pendpin.motions.trajectory import Trajectory
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
    drift_of,
    reverse_rates,
    scene,
    settings,
    tip_errors,
)

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
    image = angles.read(d[None], rate[None])
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


def cone(rate: float, turns: int, samples: int = 3) -> Scene:
    """A thin rod in conical motion at a rate in rad/s: cos(phi) = g / (reduced length rate²)."""
    phi = float(np.arccos(G / (REDUCED * rate**2)))
    v = (-rate * np.tan(phi), 0.0)
    return scene(THIN, q=(0.0, phi), v=v, duration=2 * np.pi * turns / rate, samples=samples)


def _spinning(rate: float) -> Case:
    drift, fastest = drift_of(partial(cone, rate), long=10_000, short=50), rate / (G / (REDUCED * rate**2))
    methods = settings(auto=1e-10, taylor=1e-16)
    return case("cone", 1e-10 * 10_000 * 10 * 2, methods, drift, rate=rate, fastest=fastest)


ANGLE = 0.7  # rad
SWINGS = 1_000_000
STEPS_A_SWING = 30  # of a method of high order near rounding


def swing_period() -> float:
    """The period of the thin rod of 1 m from ANGLE at rest, s."""
    from scipy.special import ellipk

    return 4 / SWING * float(ellipk(np.sin(ANGLE / 2) ** 2))


def _swings(solve: Solve, full: bool) -> float:
    duration, samples = ((SWINGS if full else 30) + 0.3) * swing_period(), 11  # the end is in full swing
    run = solve(scene(THIN, q=(ANGLE,), duration=duration, samples=samples))
    return tip_errors(run, run.q[:, 0], planar(ANGLE, 0.0, REDUCED, G, np.linspace(0.0, duration, samples)))


def in_space(duration: float) -> Scene:
    """A thick rod that swings in space."""
    return scene(THICK, q=(0.7, 0.4), v=(1.3, -0.8), duration=duration, samples=801)


TRIPLE = Chain(rods=(ROD,), copies=3)


def triple(duration: float) -> Scene:
    """Three thick rods that move chaotically."""
    return scene(TRIPLE, q=(1.5, 0.3, 1.0, -0.2, 0.5, 0.1), duration=duration, samples=101)


# --- the cases ------------------------------------------------------------------------------------------------------

CASES = (
    case(
        "chaos-methods",
        bound=1.0,
        methods=settings(auto=1e-10, rk45=1e-9, radau=1e-9, lsoda=1e-10, taylor=1e-10),
        measure=_methods_agree,
    ),
    case("chaos-back", 1.0, settings(auto=1e-10, lsoda=1e-10, taylor=1e-10), _there_and_back),
    case("mirrored", 100 * EPS * 1000 * GROWTH, ALIKE, _mirrored),
    case("turned", 2 * 1e-12 * 1000 * GROWTH, settings(auto=1e-12, rk45=1e-12, taylor=1e-16), _quarter),
    case(
        "reversed",
        bound=2 * 1e-12 * 1000 * GROWTH,
        methods=settings(auto=1e-12, taylor=1e-16, gauss2=0.02, gauss4=0.02, gauss6=0.02),
        measure=_reversed,
    ),
    *(_spinning(rate) for rate in (1e2, 1e3, 1e4)),
    case(
        "swings-1e6",
        bound=EPS * np.sqrt(STEPS_A_SWING * SWINGS) * 2 * np.pi * SWINGS,
        methods=settings(auto=1e-14, taylor=1e-18),
        measure=_swings,
    ),
    case(
        "swings-in-space",
        bound=1e-12 * 50 * 1600,
        methods=settings(auto=1e-12, taylor=1e-16, gauss6=0.05),
        measure=drift_of(in_space, long=1600.0, short=40.0),
    ),
    case("triple-1e4", 1e-10 * 200 * 10_000 * 10, settings(auto=1e-10), drift_of(triple, 1e4, 10.0)),
)
