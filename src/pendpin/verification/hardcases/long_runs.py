"""Many turns and many swings: the errors of all steps add up."""

from functools import cache, partial

import numpy as np

from pendpin.equations.exact import planar
from pendpin.ground.arrays import EPS, Array
from pendpin.scene import Chain, Scene
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
    scene,
    settings,
    tip_errors,
)

# --- conical motion -------------------------------------------------------------------------------------------------


def cone(rate: float, turns: int, samples: int = 3) -> Scene:
    """A thin rod in conical motion at a rate in rad/s: cos(phi) = g / (reduced length rate²)."""
    phi = float(np.arccos(G / (REDUCED * rate**2)))
    v = (-rate * np.tan(phi), 0.0)
    return scene(THIN, q=(0.0, phi), v=v, duration=2 * np.pi * turns / rate, samples=samples)


def _spinning(rate: float) -> Case:
    return case(
        "cone",
        bound=1e-10 * 10_000 * 10 * 2,
        methods=settings(auto=1e-10, taylor=1e-16),
        measure=drift_of(partial(cone, rate), long=10_000, short=50),
        rate=rate,
        fastest=rate / (G / (REDUCED * rate**2)),
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


def in_space(duration: float) -> Scene:
    """A thick rod that swings in space."""
    return scene(THICK, q=(0.7, 0.4), v=(1.3, -0.8), duration=duration, samples=801)


TRIPLE = Chain(rods=(ROD,), copies=3)


def triple(duration: float) -> Scene:
    """Three thick rods that move chaotically."""
    return scene(TRIPLE, q=(1.5, 0.3, 1.0, -0.2, 0.5, 0.1), duration=duration, samples=101)


CASES = (
    *(_spinning(rate) for rate in (1e2, 1e3, 1e4)),
    case(
        "swings-1e6",
        bound=EPS * np.sqrt(STEPS_A_SWING * SWINGS) * 2 * np.pi * SWINGS,
        methods=settings(auto=1e-14, taylor=1e-18),
        measure=partial(_swings, most=SWINGS, short=30),
    ),
    case(
        "swings-in-space",
        bound=1e-12 * 50 * 1600,
        methods=settings(auto=1e-12, taylor=1e-16, gauss6=0.05),
        measure=drift_of(in_space, long=1600.0, short=40.0),
    ),
    case(
        "triple-1e4",
        bound=1e-10 * 200 * 10_000 * 10,
        methods=settings(auto=1e-10),
        measure=drift_of(triple, 1e4, 10.0),
    ),
)
