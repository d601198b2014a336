"""The same motion in other units, under other gravities, at other times."""

from functools import partial
from typing import Any

import numpy as np

from pendpin.effects import Gravity, Motor
from pendpin.equations.exact import planar
from pendpin.ground.arrays import EPS, Array
from pendpin.scene import Chain, Rod, Scene
from pendpin.verification.hardcases.base import (
    ROD,
    THICK,
    G,
    Solve,
    case,
    inertia_about_joint,
    scene,
    settings,
    tip_errors,
)

REDUCED = inertia_about_joint(ROD) / (ROD.mass * ROD.properties.h)  # m


def _off(values: Array, exact: Array) -> float:
    """The largest difference of two arrays of one shape (n, k)."""
    return float(np.abs(values - exact).max())


# --- units ----------------------------------------------------------------------------------------------------------


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
GRAVITIES = ((1e-12, 1e4, 2), (1e6, 0.2, 250))  # m/s², s, 1 + omega T

AT_ONCE: dict[str, Any] = {
    "bound": 0.0,
    "methods": settings(auto=None, radau=None, taylor=None, gauss6=0.01, rk4=0.01),
}

CASES = (
    *(
        case(
            "scale",
            bound=1e-12,
            methods=FINE,
            measure=partial(_rescaled, length=length, mass=mass),
            name=name,
            units=units,
        )
        for name, units, length, mass in (
            ("micro", "micrometres and micrograms", 1e-6, 1e-9),
            ("kilo", "kilometres and tonnes", 1e3, 1e3),
        )
    ),
    case("gravity-0", bound=1000 * EPS * 200, methods=TIGHT | settings(gauss6=0.1, rk4=0.1), measure=_straight),
    *(
        case(
            "gravity",
            bound=1e-12 * 1500 * growth + 1500 * EPS * growth,
            methods=TIGHT,
            measure=partial(_falling, g=g, duration=duration),
            g=g,
            duration=duration,
            growth=growth,
        )
        for g, duration, growth in GRAVITIES
    ),
    case(
        "late",
        bound=0.0,
        methods=settings(auto=None, rk45=None, radau=None, taylor=None, gauss6=1e-5, rk4=1e-5),
        measure=_late,
    ),
    case("late-driven", bound=1e-12 * 500 * 10, methods=TIGHT, measure=_driven_late),
    case("no-duration", **AT_ONCE, measure=partial(_start_alone, samples=None)),
    case("one-sample", **AT_ONCE, measure=partial(_start_alone, samples=1)),
    case(
        "fine-samples",
        bound=1e-10 * 50 * 5 * 10,
        methods=settings(auto=1e-10, rk45=1e-10, taylor=1e-15),
        measure=_fine_samples,
    ),
)
