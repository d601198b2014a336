"""Many turns and many swings: the errors of all steps add up."""

from functools import cache, partial

import numpy as np

from pendpin.analysis.hardcases.base import (
    EPS,
    REDUCED,
    SWING,
    THICK,
    THIN,
    Case,
    G,
    Solve,
    chain_of,
    scene,
    settings,
    tip_errors,
)
from pendpin.arrays import Array
from pendpin.equations.exact import planar
from pendpin.scene import Scene

# --- conical motion -------------------------------------------------------------------------------------------------


def cone(rate: float, turns: int, samples: int = 3) -> Scene:
    """A thin rod in conical motion at a rate in rad/s: cos(phi) = g / (reduced length rate²)."""
    phi = float(np.arccos(G / (REDUCED * rate**2)))
    v = (-rate * np.tan(phi), 0.0)
    return scene(THIN, q=(0.0, phi), v=v, duration=2 * np.pi * turns / rate, samples=samples)


def _cone(solve: Solve, full: bool, rate: float) -> float:
    return solve(cone(rate, 10_000 if full else 50)).energy().drift


def _spinning(rate: float) -> Case:
    return Case(
        name=f"cone-{rate:g}",
        group=4,
        title=f"conical motion at {rate:g} rad/s for 10,000 turns",
        physics="A thin rod moves on a cone, so fast that it is nearly level. It passes the pole of its joint twice a turn.",
        why="Against the kinetic energy the weight is a small difference of large numbers, and theta' reaches "
        f"{rate / (G / (REDUCED * rate**2)):.0e} rad/s.",
        figure="energy drift divided by the kinetic energy",
        bound=1e-10 * 10_000 * 10 * 2,
        derivation="tolerance 1e-10 a step, 10 steps a turn; the relative error of the energy is twice that of the rate",
        methods=settings(auto=1e-10, taylor=1e-16),
        measure=partial(_cone, rate=rate),
    )


# --- swings ---------------------------------------------------------------------------------------------------------

ANGLE = 0.7  # rad
SWINGS = 1_000_000
STEPS_A_SWING = 30  # of a method of high order near rounding


@cache
def swing_period() -> float:
    """The period of the thin rod of 1 m from ANGLE at rest, s."""
    from scipy.special import ellipk

    return 4 / SWING * float(ellipk(np.sin(ANGLE / 2) ** 2))


@cache
def _exact(duration: float, samples: int) -> Array:
    return planar(ANGLE, 0.0, REDUCED, G, np.linspace(0.0, duration, samples))


def _swings(solve: Solve, full: bool, most: int, short: int) -> float:
    duration, samples = ((most if full else short) + 0.3) * swing_period(), 11  # the end is in full swing
    run = solve(scene(THIN, q=(ANGLE,), duration=duration, samples=samples))
    return tip_errors(run, run.q[:, 0], _exact(duration, samples))


def _thousand(solve: Solve, full: bool) -> float:
    duration = 1600.0 if full else 40.0
    return solve(scene(THICK, q=(0.7, 0.4), v=(1.3, -0.8), duration=duration, samples=801)).energy().drift


TRIPLE = chain_of(THICK.rods[0], copies=3)


def triple(duration: float) -> Scene:
    """Three thick rods that move chaotically."""
    return scene(TRIPLE, q=(1.5, 0.3, 1.0, -0.2, 0.5, 0.1), duration=duration, samples=101)


def _triple(solve: Solve, full: bool) -> float:
    return solve(triple(10_000.0 if full else 10.0)).energy().drift


CASES = (
    *(_spinning(rate) for rate in (1e2, 1e3, 1e4)),
    Case(
        name="swings-1e6",
        group=6,
        title="a million swings of one rod",
        physics="A thin rod swings with an amplitude of 0.7 rad for 19 days.",
        why="An error of the energy changes the period; with a steady drift the phase error grows as time squared.",
        figure="distance of the tip to the exact solution (elliptic functions), m",
        bound=EPS * np.sqrt(STEPS_A_SWING * SWINGS) * 2 * np.pi * SWINGS,
        derivation="rounding errors of the energy add up as a random walk over 30 steps a swing (Brouwer's law) and change "
        "the phase of all swings",
        methods=settings(auto=1e-14, taylor=1e-18),
        measure=partial(_swings, most=SWINGS, short=30),
    ),
    Case(
        name="swings-in-space",
        group=6,
        title="a thousand swings of a thick rod in three dimensions",
        physics="A rod of radius 5 cm swings in both planes for 1,600 s; its universal joint prevents free spin.",
        why="A method that is not symplectic loses or gains energy at every step.",
        figure="energy drift divided by the energy exchanged",
        bound=1e-12 * 50 * 1600,
        derivation="tolerance 1e-12 a step, 50 steps a second; gauss6 at 0.05 s has a smaller error, which does not grow",
        methods=settings(auto=1e-12, taylor=1e-16, gauss6=0.05),
        measure=_thousand,
    ),
    Case(
        name="triple-1e4",
        group=6,
        title="three rods in chaos for 10,000 s",
        physics="Three thick rods move chaotically.",
        why="The motion never repeats and reaches 50 rad/s: two million steps.",
        figure="energy drift divided by the energy exchanged",
        bound=1e-10 * 200 * 10_000 * 10,
        derivation="tolerance 1e-10 a step, 200 steps a second; the energies of fast rods have 10 times the error",
        methods=settings(auto=1e-10),
        measure=_triple,
    ),
)
