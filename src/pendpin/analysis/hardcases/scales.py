"""The same motion in other units, under other gravities, at other times."""

from functools import partial
from typing import Any

import numpy as np

from pendpin.analysis.hardcases.base import (
    EPS,
    THICK,
    Case,
    G,
    Solve,
    chain_of,
    inertia_about_joint,
    scene,
    settings,
    tip_errors,
)
from pendpin.arrays import Array
from pendpin.effects import Gravity, Motor
from pendpin.equations.exact import planar
from pendpin.scene import Rod, Scene

ROD = THICK.rods[0]
REDUCED = inertia_about_joint(ROD) / (ROD.mass * ROD.properties.h)  # m


def _off(found: Array, wanted: Array) -> float:
    """The largest difference of two arrays of one shape (n, k)."""
    return float(np.abs(found - wanted).max())


# --- units ----------------------------------------------------------------------------------------------------------


def _sized(length: float, mass: float, duration: float, time: float = 0.0) -> Scene:
    """Two rods in units of this length and mass; gravity stays the same, so the unit of time is sqrt(length)."""
    unit = np.sqrt(length)
    upper = Rod(length=length, mass=mass, radius=0.05 * length)
    lower = Rod(length=0.7 * length, mass=2 * mass, radius=0.05 * length)
    v = np.array([1.3, -0.8, 0.2, 0.5]) / unit
    given = {"q": (0.7, 0.4, -0.3, 0.2), "v": v, "duration": float(duration * unit), "samples": 21, "time": time}
    return scene(chain_of(upper, lower), **given)


def _rescaled(solve: Solve, full: bool, length: float, mass: float) -> float:
    duration = 3.0 if full else 1.0
    here, there = solve(_sized(1.0, 1.0, duration)), solve(_sized(length, mass, duration))
    return _off(here.q, there.q)


# --- gravities ------------------------------------------------------------------------------------------------------


def _straight(solve: Solve, full: bool) -> float:
    run = solve(scene(THICK, q=(0.3,), v=(2.0,), duration=100.0, samples=11, gravity=Gravity(acceleration=0.0)))
    return float(np.abs(run.q[:, 0] - 0.3 - 2.0 * run.t).max())


def _falling(solve: Solve, full: bool, g: float, duration: float) -> float:
    gravity = Gravity(acceleration=g)
    run = solve(scene(THICK, q=(1.0,), duration=duration if full else duration / 4, samples=11, gravity=gravity))
    return tip_errors(run, run.q[:, 0], planar(1.0, 0.0, REDUCED, g, run.t))


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

    def given(time: float, phase: float) -> Scene:
        motor = Motor(joint="theta", amplitude=100.0, frequency=RATE, phase=phase)
        return scene(THICK, motor, q=(0.3,), duration=0.02, samples=11, time=time)

    return _off(solve(given(0.0, phase)).q, solve(given(LATE, 0.0)).q)


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
GRAVITIES = ((1e-12, 1e4, 2), (1e6, 0.2, 250))  # m/s², s, 1 + omega T

AT_ONCE: dict[str, Any] = {
    "figure": "difference to the start, rad, plus the number of samples less 1",
    "bound": 0.0,
    "derivation": "the start is given",
    "methods": settings(auto=None, radau=None, taylor=None, gauss6=0.01, rk4=0.01),
}

CASES = (
    *(
        Case(
            name=f"scale-{name}",
            group=12,
            title=f"two rods in {units}",
            physics="The same two rods in other units: lengths are multiplied by L, masses by M, times by sqrt(L).",
            why="Fixed tolerances, thresholds and finite differences mean something else at another scale.",
            figure="difference of the angles to the scene in m and kg, rad",
            bound=1e-12,
            derivation="tolerance 1e-14 and the rounding of 100 steps; the dimensionless equations are the same",
            methods=FINE,
            measure=partial(_rescaled, length=length, mass=mass),
        )
        for name, units, length, mass in (
            ("micro", "micrometres and micrograms", 1e-6, 1e-9),
            ("kilo", "kilometres and tonnes", 1e3, 1e3),
        )
    ),
    Case(
        name="gravity-0",
        group=12,
        title="a gravity effect of 0 m/s²",
        physics="A rod turns about one axis at a constant rate for 100 s.",
        why="Periods, steps and tolerances computed from gravity become infinite.",
        figure="error of theta, rad",
        bound=1000 * EPS * 200,
        derivation="rounding of at most 1,000 sums of up to 200 rad",
        methods=TIGHT | settings(gauss6=0.1, rk4=0.1),
        measure=_straight,
    ),
    *(
        Case(
            name=f"gravity-{g:g}",
            group=12,
            title=f"gravity of {g:g} m/s²",
            physics=f"A rod is released from 1 rad under {g:g} m/s² for {duration:g} s.",
            why="The motion is a million times slower, or 300 times faster, than on Earth. Steps must follow it.",
            figure="distance of the tip to the exact solution (elliptic functions), m",
            bound=1e-12 * 1500 * growth + 1500 * EPS * growth,
            derivation=f"tolerance 1e-12, at most 1,500 steps, errors grow by a factor 1 + omega T = {growth}",
            methods=TIGHT,
            measure=partial(_falling, g=g, duration=duration),
        )
        for g, duration, growth in GRAVITIES
    ),
    Case(
        name="late",
        group=13,
        title="millisecond motion at t = 1e9 s",
        physics="Rods of micrometres swing with periods of milliseconds, thirty years after t = 0.",
        why="Doubles near 1e9 are 1e-7 apart: a step of 1e-5 s would have two digits.",
        figure="difference to the same run from t = 0, rad, rad/s and s",
        bound=0.0,
        derivation="the equations do not depend on time: the same numbers, bit for bit",
        methods=settings(auto=None, rk45=None, radau=None, taylor=None, gauss6=1e-5, rk4=1e-5),
        measure=_late,
    ),
    Case(
        name="late-driven",
        group=13,
        title="a motor at 1,000 rad/s at t = 1e9 s",
        physics="A sinusoidal motor torque has a phase of 1e12 rad at t = 1e9 s. The reference computes it in 40 digits.",
        why="Doubles near 1e9 s are 1e-7 s apart: the phase would jump by 1e-4 rad.",
        figure="difference of theta to a run from t = 0 with that phase, rad",
        bound=1e-12 * 500 * 10,
        derivation="two runs at tolerance 1e-12, at most 500 steps, errors grow 10 times; late times lose no digits",
        methods=TIGHT,
        measure=_driven_late,
    ),
    Case(
        name="no-duration",
        group=13,
        title="a duration of 0",
        physics="The run consists of the start with its accelerations and reactions.",
        why="No step can be taken.",
        **AT_ONCE,
        measure=partial(_start_alone, samples=None),
    ),
    Case(
        name="one-sample",
        group=13,
        title="one requested sample",
        physics="A duration of 0 with samples = 1. A longer run needs at least two samples; pendpin refuses one.",
        why="There is no interval between samples.",
        **AT_ONCE,
        measure=partial(_start_alone, samples=1),
    ),
    Case(
        name="fine-samples",
        group=13,
        title="100,001 samples in 1 s",
        physics="A swing with a sample every 10 microseconds: a thousand samples in each step.",
        why="Samples inside a step are interpolated, which is less accurate than the end of a step.",
        figure="distance of the tip to the exact solution (elliptic functions) at 200 of the samples, m",
        bound=1e-10 * 50 * 5 * 10,
        derivation="tolerance 1e-10, 50 steps, errors grow 1 + omega T = 5 times; 10 for an interpolant one order lower",
        methods=settings(auto=1e-10, rk45=1e-10, taylor=1e-15),
        measure=_fine_samples,
    ),
)
