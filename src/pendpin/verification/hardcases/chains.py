"""Long chains, unlike neighbours, sizes, gravities and times far from everyday ones; chaos, symmetries and long horizons."""

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from pendpin.equations.base import split_by_rod
from pendpin.equations.chain import solution, thin
from pendpin.ground.arrays import EPS, Array
from pendpin.model.build import build
from pendpin.motions.trajectory import Trajectory, simulate
from pendpin.scene import Chain, Scene
from pendpin.verification.hardcases.base import (
    HANG,
    REDUCED,
    SWING,
    Case,
    G,
    Solve,
    case,
    drift,
    largest,
    plane_swing,
    scene,
    start_at,
    start_of,
)

# --- unlike neighbours ----------------------------------------------------------------------------------------------


@cache
def _solve_by_reactions(name: str, duration: float) -> Array:
    """The tips (n, rods, 3) in m by the chain equations (reactions as the unknowns), at a tight tolerance."""
    solver = {"engine": "chain", "method": "dop853", "tolerance": 1e-12, "samples": 11}
    return simulate(scene(name, {"duration": duration, "solver": solver})).tips


def _unlike(name: str, tolerance: float, most_steps: int, growth: float, short: float) -> Case:
    """The largest distance of a rod's tip to that by the chain equations, seen from the rod's joint, over its length."""

    def measure(solve: Solve, full: bool) -> float:
        swinging = scene(name, None if full else {"duration": short})
        apart = solve(swinging).tips - _solve_by_reactions(name, swinging.duration)
        relative = np.diff(apart, axis=1, prepend=0.0)  # of each rod's tip to its own joint
        assert isinstance(swinging.model, Chain)
        return float((np.linalg.norm(relative, axis=-1) / [rod.length for rod in swinging.model.rods]).max())

    words = {"tolerance": tolerance, "most_steps": most_steps, "growth": growth}
    return case(name, tolerance * most_steps * growth, measure=measure, **words)


# --- long chains ----------------------------------------------------------------------------------------------------


def tumbling(name: str, changes: Mapping[str, Any] | None = None) -> Scene:
    """A chain with random angles and rates, and with other values at key paths."""
    still = scene(name, changes)
    q, v = np.random.default_rng(0).normal(size=(2, len(build(still.model).joints)))
    return start_at(still, 0.3 * q, v)


def _tumbling_case(name: str, bound: float, short: float) -> Case:
    """The energy drift of a tumbling chain, in the short form for some s."""
    changes = {"duration": short}
    return case(name, bound, measure=lambda solve, full: drift(solve(tumbling(name, None if full else changes))))


def _digits(solve: Solve, full: bool) -> float:
    """The largest difference of the accelerations of runs from random states to the chain equations, over the largest."""
    still = scene("chain-100", {"duration": 0.0, "solver": {}})
    q, v = np.random.default_rng(1).uniform(-1, 1, (2, 3, 200))[:, : 3 if full else 1]
    accelerations = np.array([solve(start_at(still, *state)).a[0] for state in zip(q, v, strict=True)])
    inertia, field = build(still.model).chain, np.array([0.0, 0.0, G])
    assert inertia is not None
    exact = solution.solve(inertia, split_by_rod(q), split_by_rod(v), field).acceleration.reshape(q.shape)
    return largest(accelerations - exact) / largest(exact)


SHORT_WHIP = {"model.copies": 12, "model.rods": [{"length": 1 / 12, "mass": 1 / 12}], "duration": 0.3}

# --- the same motion in other units ---------------------------------------------------------------------------------


def _rescaled(name: str, units: str, length: float) -> Case:
    """Two rods in other units of length and mass; gravity stays the same, so the unit of time is sqrt(length)."""

    def measure(solve: Solve, full: bool) -> float:
        here = scene("scale", None if full else {"duration": 1.0})
        there = scene(f"scale-{name}", None if full else {"duration": float(np.sqrt(length))})
        return largest(solve(here).q - solve(there).q)

    return case("scale", 1e-12, measure=measure, name=name, units=units)


def _falling_case(g: float, duration: float, growth: float) -> Case:
    """A rod that falls by a gravity g in m/s² for some s, in which errors grow 1 + omega T times."""
    bound = 1e-12 * 1500 * growth + 1500 * EPS * growth
    words: Any = {"g": g, "duration": duration, "growth": growth}
    return case("gravity", bound, plane_swing(1.0, HANG, g=g), {"duration": duration / 4}, **words)


LATE = 1e9  # s


def _late(solve: Solve, full: bool) -> float:
    """The largest differences of q, v and t to the run from t = 0, summed; rad, rad/s, s."""
    here, there = (solve(scene("late", {"start.time": time})) for time in (0.0, LATE))
    return largest(here.q - there.q) + largest(here.v - there.v) + largest(there.t - (LATE + here.t))


RATE = 1e3  # rad/s


def _driven_late(solve: Solve, full: bool) -> float:
    """The difference in rad of two runs with a sinusoidal motor: from 1e9 s, and from 0 with the phase of 1e9 s."""
    from mpmath import mp, mpf

    with mp.workdps(40):
        phase = float(mp.fmod(mpf(RATE) * mpf(LATE), 2 * mp.pi))
    early = {"start.time": 0.0, "effects[1].phase": phase}
    return largest(solve(scene("late-driven", early)).q - solve(scene("late-driven")).q)


def _start_alone(run: Trajectory) -> float:
    return largest(run.q[0] - (0.7, 0.4)) + abs(len(run.t) - 1)


# --- chaos ----------------------------------------------------------------------------------------------------------

WILD = np.array([2.0, 0.5, 1.0, 0.3])
APART = 1e-8  # rad, of two starts
FAR = 1e-2  # m: runs this far apart are no longer compared


def wild(duration: float, q: Array = WILD) -> Scene:
    """A double pendulum that moves chaotically, from q (4,) in rad."""
    changes = {"duration": duration, "start.positions": q.tolist(), "solver.samples": round(20 * duration) + 1}
    return scene("chaos-methods", changes)


def _gap(one: Trajectory, other: Trajectory) -> Array:
    return np.linalg.norm(one.tips - other.tips, axis=-1).max(-1)


@cache
def _reference(duration: float) -> tuple[Trajectory, Array]:
    """A run at the smallest tolerance, and the largest growth so far of a difference at the start, at each sample (n,)."""
    starts = WILD, WILD + np.array([APART, 0.0, 0.0, 0.0])
    one, other = (simulate(wild(duration, q), method="dop853", tolerance=1e-14) for q in starts)
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
    back = solve(start_at(wild(duration), there.q[-1], -there.v[-1]))
    predicted = 2 * _predicted(there, _reference(duration)[1])[-1]
    return float(np.abs(np.concatenate([back.q[-1] - WILD, back.v[-1]])).max() / predicted)


# --- symmetry -------------------------------------------------------------------------------------------------------

SIGNS = {"x to -x": (1.0, -1.0), "y to -y": (-1.0, 1.0), "half a turn": (-1.0, -1.0)}  # of theta, phi
BRIEF = {"duration": 1.0}


def _mirrored(solve: Solve, full: bool) -> float:
    calm = scene("mirrored", None if full else BRIEF)
    (q, v), plain = start_of(calm), solve(calm)
    signs = [np.tile(pair, 2) for pair in SIGNS.values()]
    return max(largest(solve(start_at(calm, both * q, both * v)).q - both * plain.q) for both in signs)


def _quarter(solve: Solve, full: bool) -> float:
    """Thin rods, whose joint has no preferred axes, turned by 90 degrees about the vertical."""
    here = scene("turned", None if full else BRIEF)
    q, v = (x.reshape(2, 2) for x in start_of(here))
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    d, rate = (x @ turn for x in thin.directions(q, v))  # in I, whose z points down, the turn is the other way
    image = thin.read(d[None], rate[None])
    there = start_at(here, image.q.ravel(), image.v.ravel())
    return largest(solve(there).tips - solve(here).tips @ turn.T)


def _reversed(solve: Solve, full: bool) -> float:
    calm = scene("mirrored", None if full else BRIEF)
    (q, v), there = start_of(calm), solve(calm)
    back = solve(start_at(calm, there.q[-1], -there.v[-1]))
    return largest(np.concatenate([back.q[-1] - q, back.v[-1] + v]))


GROWTH = 100  # of a small difference within 4 s in the regular motion

# --- many turns in conical motion, and many swings ------------------------------------------------------------------


def turns(rate: float) -> dict[str, float]:
    """The duration of 50 turns in conical motion at a rate in rad/s: cos(phi) = g / (reduced length rate²)."""
    return {"duration": 2 * np.pi * 50 / rate}


ANGLE = 0.7  # rad
SWINGS = 1_000_000
STEPS_A_SWING = 30  # of a method of high order near rounding


def _swings(solve: Solve, full: bool) -> float:
    """The error in m after many swings and 0.3 of one, so that the end is in full swing; 30 in the short form."""
    from scipy.special import ellipk

    period = 4 / SWING * float(ellipk(np.sin(ANGLE / 2) ** 2))  # s, of the thin rod of 1 m from ANGLE at rest
    return plane_swing(ANGLE, REDUCED)(solve(scene("swings-1e6", None if full else {"duration": (30 + 0.3) * period})))


CASES = (
    _unlike("mass-light-below", 1e-11, 1000, 100, short=1.0),
    _unlike("mass-light-above", 1e-11, 1000, 100, short=1.0),
    _unlike("mass-heavy-below", 1e-11, 1000, 100, short=1.0),
    _unlike("mass-mixed", 1e-10, 1000, 100, short=0.05),
    _unlike("length-short-below", 1e-11, 2000, 100, short=0.05),
    _unlike("length-short-above", 1e-9, 2000, 1000, short=0.05),
    _tumbling_case("chain-100", 1e-9 * 1000 * 10, 0.02),
    case("chain-100-digits", 200 * 100 * EPS, measure=_digits),
    _tumbling_case("chain-2000", 1e-8 * 1000 * 10, 0.001),
    case("whip", 1e-10 * 2000 * 100, drift, SHORT_WHIP),
    _rescaled("micro", "micrometres and micrograms", 1e-6),
    _rescaled("kilo", "kilometres and tonnes", 1e3),
    case("gravity-0", 1000 * EPS * 200, lambda run: largest(run.q[:, 0] - 0.3 - 2.0 * run.t)),
    _falling_case(1e-12, 1e4, 2),
    _falling_case(1e6, 0.2, 250),
    case("late", 0.0, measure=_late),
    case("late-driven", 1e-12 * 500 * 10, measure=_driven_late),
    case("no-duration", 0.0, _start_alone),
    case("one-sample", 0.0, _start_alone),
    case("fine-samples", 1e-10 * 50 * 5 * 10, plane_swing(1.0, HANG), {"solver.samples": 10_001}),
    case("chaos-methods", 1.0, measure=_methods_agree),
    case("chaos-back", 1.0, measure=_there_and_back),
    case("mirrored", 100 * EPS * 1000 * GROWTH, measure=_mirrored),
    case("turned", 2 * 1e-12 * 1000 * GROWTH, measure=_quarter),
    case("reversed", 2 * 1e-12 * 1000 * GROWTH, measure=_reversed),
    *(
        case("cone", 1e-10 * 10_000 * 10 * 2, drift, turns(x), rate=x, fastest=REDUCED * x**3 / G)
        for x in (1e2, 1e3, 1e4)
    ),
    case("swings-1e6", EPS * np.sqrt(STEPS_A_SWING * SWINGS) * 2 * np.pi * SWINGS, measure=_swings),
    case("swings-in-space", 1e-12 * 50 * 1600, drift, {"duration": 40.0}),
    case("triple-1e4", 1e-10 * 200 * 10_000 * 10, drift, {"duration": 10.0}),
)
