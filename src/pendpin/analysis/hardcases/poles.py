"""Rods through the pole phi = pi/2, where the rod lies along the first axis of the universal joint."""

from functools import cache
from typing import Any

import numpy as np

from pendpin.analysis.hardcases.base import (
    REDUCED,
    REGULAR,
    THIN,
    Case,
    G,
    Solve,
    chain_of,
    inertia_about_joint,
    scene,
    settings,
    tip_errors,
)
from pendpin.equations.exact import direction, direction_rate, planar, spherical
from pendpin.scene import Rod, Scene

FAST = 9.0  # rad/s: enough for full turns, through both poles


# --- thin rods ------------------------------------------------------------------------------------------------------


def _straight_through(solve: Solve, full: bool) -> float:
    run = solve(scene(THIN, q=(0.0, 0.3), v=(0.0, FAST), duration=20.0 if full else 4.0, samples=21))
    return tip_errors(run, run.q[:, 1], planar(0.3, FAST, REDUCED, G, run.t))


def _close_by(solve: Solve, full: bool) -> float:
    q, v = np.array([1e-9, 0.3]), np.array([1e-8, FAST])
    run = solve(scene(THIN, q=q, v=v, duration=20.0 if full else 4.0, samples=11))
    exact = spherical(direction(q), direction_rate(q, v), REDUCED, G, run.t)
    return float(np.linalg.norm(run.tips()[:, 0] - exact, axis=-1).max())


MIDDLE = chain_of(Rod(length=1.0, mass=100.0), Rod(length=0.5, mass=0.1), Rod(length=0.3, mass=0.02))


def _in_a_chain(solve: Solve, full: bool) -> float:
    q, v = np.array([[0.0, 0.1], [0.0, 0.4], [0.0, 0.05]]), np.array([[0.0, 0.2], [0.0, 12.0], [0.0, 0.3]])
    duration = 10.0 if full else 2.0
    through, turned = (
        solve(scene(MIDDLE, q=np.ravel(a), v=np.ravel(b), duration=duration, samples=11))
        for a, b in ((q, v), (q[:, ::-1], v[:, ::-1]))
    )
    x, y, z = np.moveaxis(through.tips(), -1, 0)
    return float(np.abs(np.stack([0 * y, -x, z], -1) - turned.tips()).max())


# --- thick rods -----------------------------------------------------------------------------------------------------

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
        width = mp.sqrt(abs(rest) / k)
        marks = [nearest, *(nearest + width * 10**i for i in range(4) if nearest + width * 10**i < AWAY), mpf(AWAY)]

        def D(x):
            return I3 + k * mp.sin(x) ** 2

        def over(x):  # D - J b²
            return max(rest, mpf(0)) + k * mp.sin(x - nearest) * mp.sin(x + nearest)

        half = mp.quad(lambda x: mp.sqrt(D(x) / over(x)), marks) / w
        turn = J * b * mp.quad(lambda x: 1 / mp.sqrt(D(x) * over(x)), marks) if aim else mpf(0)
        rates = (J * b * w / D(mpf(AWAY)), w * mp.sqrt(over(mpf(AWAY)) / D(mpf(AWAY))))
        side = -1 if rest < 0 else 1
        q, v = (0.3, float(mp.pi / 2 - AWAY)), tuple(map(float, rates))
        end = (0.3 + float(2 * turn), float(mp.pi / 2 + side * AWAY))
        return scene(chain_of(rod), q=q, v=v, duration=float(2 * half), samples=2, gravity=None), end


def _passing(radius: float, aim: float) -> Case:
    rod = Rod(length=1.0, mass=1.0, radius=radius)
    narrow = float(np.sqrt(rod.properties.I3 / inertia_about_joint(rod)))
    where = f"radius {1e3 * radius:g} mm, aimed {aim:g} rad past the pole"

    def measure(solve: Solve, full: bool) -> float:
        given, end = passage(radius, aim)
        return float(np.abs(solve(given).q[-1] - end).max())

    return Case(
        name=f"thick-pole-{1e3 * radius:g}mm-{aim:g}",
        group=2,
        title=f"rod of 1 m, {where}",
        physics="A rod with axial inertia moves past the pole without gravity. Near the pole its axis nearly coincides "
        "with the theta axis. The rod passes and spins about itself, or turns back, depending on its angular momentum.",
        why=f"Within {narrow:.1g} rad of the pole the inertia about theta falls to I3 and theta'' becomes very large, "
        "for about a thousandth of the run. No step may jump over it.",
        figure="error of theta and phi after the passage, rad",
        bound=1e-12 * 1000 * np.pi / narrow,
        derivation="tolerance 1e-12, at most 1,000 steps; an error of the aim changes theta pi / sqrt(I3/J) times as much",
        methods=settings(auto=1e-12, radau=1e-12, taylor=1e-16),
        measure=measure,
    )


TURNING: dict[str, Any] = {
    "bound": 1e-12 * 1000 * 180,
    "derivation": REGULAR.format("1,000", 180),
    "methods": settings(auto=1e-12, rk45=1e-12, taylor=1e-16),
}

CASES = (
    Case(
        name="thin-pole",
        group=1,
        title="thin rod straight through the pole, many times",
        physics="A thin rod turns in the plane theta = 0. It passes exactly through phi = 90 and 270 degrees in every turn.",
        why="At these angles the inertia about theta is 0: the equations in angles divide 0 by 0.",
        figure="distance of the tip to the exact solution (elliptic functions), m",
        **TURNING,
        measure=_straight_through,
    ),
    Case(
        name="thin-pole-close",
        group=1,
        title="thin rod past the pole by 1e-9 rad",
        physics="The same rod with a sideways motion of 1e-9 rad. At each pole theta turns by 180 degrees within 1e-10 s.",
        why="theta' reaches 1e10 rad/s. A method in angles needs extremely small steps, or it steps over the turn.",
        figure="distance of the tip to the exact spherical pendulum, m",
        **TURNING,
        measure=_close_by,
    ),
    Case(
        name="thin-pole-chain",
        group=1,
        title="the middle rod of three thin rods through the pole",
        physics="The second rod turns fast between a heavy rod and a light one, in the plane of the pole. The same scene "
        "turned by 90 degrees about the vertical does not pass through a pole; it is the reference.",
        why="One singular rod makes the accelerations of the whole chain wrong.",
        figure="distance of the tips to those of the turned scene, turned back, m",
        bound=2 * 1e-12 * 2000 * 240,
        derivation="two runs; " + REGULAR.format("2,000", 240),
        methods=settings(auto=1e-12, lsoda=1e-12),
        measure=_in_a_chain,
    ),
    *(_passing(radius, aim) for radius in (1e-3, 1e-4) for aim in (1e-3, 1e-6, 0.0)),
)
