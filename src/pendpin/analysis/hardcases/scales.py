"""The same motion in other units, under other gravities, at other times."""

from functools import partial

import numpy as np

from pendpin.analysis.hardcases.base import EPS, THICK, Case, G, Solve, chain_of, inertia_about_joint, scene, tip_errors
from pendpin.arrays import Array
from pendpin.effects import Gravity, Motor
from pendpin.equations.exact import planar
from pendpin.scene import Rod, Scene

ROD = THICK.rods[0]
REDUCED = inertia_about_joint(ROD) / (ROD.mass * ROD.properties.h)  # m


def _off(found: Array, wanted: Array) -> float:
    return float(np.abs(found - wanted).max())


# --- units ----------------------------------------------------------------------------------------------------------


def _sized(length: float, mass: float, duration: float, samples: int | None = 21, time: float = 0.0) -> Scene:
    """Two rods, in units of this length and mass; with gravity as it is, the unit of time is sqrt(length)."""
    unit = np.sqrt(length)
    upper = Rod(length=length, mass=mass, radius=0.05 * length)
    lower = Rod(length=0.7 * length, mass=2 * mass, radius=0.05 * length)
    v = np.array([1.3, -0.8, 0.2, 0.5]) / unit
    given = {"q": (0.7, 0.4, -0.3, 0.2), "v": v, "duration": float(duration * unit), "samples": samples, "time": time}
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
    """The largest difference to the run from t = 0, in q, v and t, over their sizes."""
    here, there = (solve(_sized(SMALL, 1e-9, 5.0, time=time)) for time in (0.0, LATE))
    return float(np.abs(here.q - there.q).max() + np.abs(here.v - there.v).max()) + _off(there.t, LATE + here.t)


RATE = 1e3  # rad/s


def _driven_late(solve: Solve, full: bool) -> float:
    """A motor that is a sinusoid of the time, from 1e9 s and from 0 with the phase that it has there."""
    from mpmath import mp, mpf

    with mp.workdps(40):
        phase = float(mp.fmod(mpf(RATE) * mpf(LATE), 2 * mp.pi))
    starts = {0.0: phase, LATE: 0.0}
    here, there = (
        solve(
            scene(
                THICK,
                Motor(joint="theta", amplitude=100.0, frequency=RATE, phase=phase),
                q=(0.3,),
                duration=0.02,
                samples=11,
                time=time,
            )
        )
        for time, phase in starts.items()
    )
    return float(np.abs(here.q - there.q).max())


def _no_duration(solve: Solve, full: bool) -> float:
    run = solve(scene(THICK, q=(0.7, 0.4), v=(1.3, -0.8), duration=0.0))
    return float(np.abs(run.q[0] - (0.7, 0.4)).max()) + abs(len(run.t) - 1)


def _one_sample(solve: Solve, full: bool) -> float:
    run = solve(scene(THICK, q=(0.7, 0.4), v=(1.3, -0.8), duration=0.0, samples=1))
    return float(np.abs(run.q[0] - (0.7, 0.4)).max()) + abs(len(run.t) - 1)


def _fine_samples(solve: Solve, full: bool) -> float:
    count = 100_001 if full else 10_001
    run = solve(scene(THICK, q=(1.0,), duration=1.0, samples=count))
    some = slice(None, None, count // 200)
    return tip_errors(run, run.q[some, 0], planar(1.0, 0.0, REDUCED, G, run.t[some]))


FINE = {"auto": {"tolerance": 1e-14}, "taylor": {"tolerance": 1e-18}}
TIGHT = {"auto": {"tolerance": 1e-12}, "taylor": {"tolerance": 1e-16}}
GRAVITIES = ((1e-12, 1e4, 2), (1e6, 0.2, 250))  # m/s², s, 1 + omega T

CASES = (
    *(
        Case(
            name=f"scale-{name}",
            group=12,
            title=f"two rods in {units}",
            physics="The same two rods in other units: lengths times L, masses times M, times sqrt(L).",
            why="Absolute tolerances, thresholds and differences of fixed size mean something else at every scale.",
            figure="angles against those of the scene in m and kg, rad",
            bound=1e-12,
            derivation="tolerance 1e-14 and the rounding of 100 steps: the dimensionless equations are the same",
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
        title="gravity listed, and 0",
        physics="A rod turns about one axis at a constant rate for 100 s.",
        why="Periods, steps and tolerances that are taken from gravity become infinite.",
        figure="theta against the straight line, rad",
        bound=1000 * EPS * 200,
        derivation="rounding of at most 1,000 sums that reach 200 rad",
        methods=TIGHT | {"gauss6": {"step": 0.1}, "rk4": {"step": 0.1}},
        measure=_straight,
    ),
    *(
        Case(
            name=f"gravity-{g:g}",
            group=12,
            title=f"gravity of {g:g} m/s²",
            physics=f"A rod is released from 1 rad under {g:g} m/s² for {duration:g} s.",
            why="Steps have to go by the motion that there is: a million times slower, or 300 times faster, than on Earth.",
            figure="tip against the elliptic functions, m",
            bound=1e-12 * 1500 * growth + 1500 * EPS * growth,
            derivation=f"tolerance 1e-12, at most 1,500 steps, growing like 1 + omega T = {growth}",
            methods=TIGHT,
            measure=partial(_falling, g=g, duration=duration),
        )
        for g, duration, growth in GRAVITIES
    ),
    Case(
        name="late",
        group=13,
        title="millisecond motion at t = 1e9 s",
        physics="Rods of micrometres swing within milliseconds, thirty years after t = 0.",
        why="Doubles near 1e9 are 1e-7 apart: a step of 1e-5 s keeps two digits.",
        figure="difference to the same run from t = 0, in rad, rad/s and s",
        bound=0.0,
        derivation="the laws do not change with time: the same numbers, bit for bit",
        methods={"auto": {}, "rk45": {}, "radau": {}, "taylor": {}, "gauss6": {"step": 1e-5}, "rk4": {"step": 1e-5}},
        measure=_late,
    ),
    Case(
        name="late-driven",
        group=13,
        title="a motor at 1,000 rad/s at t = 1e9 s",
        physics="The phase of the motor at t = 1e9 s, 1e12 rad, is known to the last digit, and so is the motion.",
        why="As a double the time is known to 1e-7 s there, and the phase to 1e-4 rad, in jumps.",
        figure="theta against the run from 0 with that phase, rad",
        bound=1e-12 * 500 * 10,
        derivation="two runs at tolerance 1e-12, at most 500 steps, errors grow 10 times: late times cost no digits",
        methods=TIGHT,
        measure=_driven_late,
    ),
    Case(
        name="no-duration",
        group=13,
        title="a duration of 0",
        physics="The start, with its accelerations and reactions.",
        why="No step can be taken.",
        figure="difference to the start, rad, and to one sample",
        bound=0.0,
        derivation="the start is given",
        methods={"auto": {}, "radau": {}, "taylor": {}, "gauss6": {"step": 0.01}, "rk4": {"step": 0.01}},
        measure=_no_duration,
    ),
    Case(
        name="one-sample",
        group=13,
        title="one sample, asked for",
        physics="A duration of 0 with samples = 1; a longer run has two samples at least, and one is refused.",
        why="There is no interval to sample.",
        figure="difference to the start, rad, and to one sample",
        bound=0.0,
        derivation="the start is given",
        methods={"auto": {}, "radau": {}, "taylor": {}, "gauss6": {"step": 0.01}, "rk4": {"step": 0.01}},
        measure=_one_sample,
    ),
    Case(
        name="fine-samples",
        group=13,
        title="100,001 samples in 1 s",
        physics="A swing sampled every 10 microseconds, a thousand times within a step.",
        why="Samples come from inside the steps, where a method is less accurate than at their ends.",
        figure="tip against the elliptic functions, at 200 of the samples, m",
        bound=1e-10 * 50 * 5 * 10,
        derivation="tolerance 1e-10, 50 steps, growing like 1 + omega T = 5; 10 for an interpolant one order lower",
        methods={"auto": {"tolerance": 1e-10}, "rk45": {"tolerance": 1e-10}, "taylor": {"tolerance": 1e-15}},
        measure=_fine_samples,
    ),
)
