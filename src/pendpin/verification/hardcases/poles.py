"""Rods through the pole phi = pi/2, where the rod lies along the first axis of the universal joint."""

from functools import cache
from typing import Any

import numpy as np

from pendpin.equations.exact import direction, direction_rate, planar, spherical
from pendpin.scene import Chain, Rod, Scene
from pendpin.verification.hardcases.base import (
    REDUCED,
    THIN,
    Case,
    G,
    Solve,
    case,
    inertia_about_joint,
    scene,
    settings,
    tip_errors,
)

FAST = 9.0  # rad/s: enough for full turns, through both poles


# --- thin rods ------------------------------------------------------------------------------------------------------


def _straight_through(solve: Solve, full: bool) -> float:
    run = solve(scene(THIN, q=(0.0, 0.3), v=(0.0, FAST), duration=20.0 if full else 4.0, samples=21))
    return tip_errors(run, run.q[:, 1], planar(0.3, FAST, REDUCED, G, run.t))


def _close_by(solve: Solve, full: bool) -> float:
    q, v = np.array([1e-9, 0.3]), np.array([1e-8, FAST])
    run = solve(scene(THIN, q=q, v=v, duration=20.0 if full else 4.0, samples=11))
    exact = spherical(direction(q), direction_rate(q, v), REDUCED, G, run.t)
    return float(np.linalg.norm(run.tips[:, 0] - exact, axis=-1).max())


MIDDLE = Chain(rods=(Rod(length=1.0, mass=100.0), Rod(length=0.5, mass=0.1), Rod(length=0.3, mass=0.02)))


def _in_a_chain(solve: Solve, full: bool) -> float:
    q, v = np.array([[0.0, 0.1], [0.0, 0.4], [0.0, 0.05]]), np.array([[0.0, 0.2], [0.0, 12.0], [0.0, 0.3]])
    duration = 10.0 if full else 2.0
    through, turned = (
        solve(scene(MIDDLE, q=np.ravel(a), v=np.ravel(b), duration=duration, samples=11))
        for a, b in ((q, v), (q[:, ::-1], v[:, ::-1]))
    )
    x, y, z = np.moveaxis(through.tips, -1, 0)
    return float(np.abs(np.stack([0 * y, -x, z], -1) - turned.tips).max())


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
        return scene(Chain(rods=(rod,)), q=q, v=v, duration=float(2 * half), samples=2, gravity=None), end


def _passing(radius: float, aim: float) -> Case:
    rod = Rod(length=1.0, mass=1.0, radius=radius)
    narrow = float(np.sqrt(rod.properties.I3 / inertia_about_joint(rod)))

    def measure(solve: Solve, full: bool) -> float:
        at_pole, end = passage(radius, aim)
        return float(np.abs(solve(at_pole).q[-1] - end).max())

    return case(
        "thick-pole",
        bound=1e-12 * 1000 * np.pi / narrow,
        methods=settings(auto=1e-12, radau=1e-12, taylor=1e-16),
        measure=measure,
        mm=1e3 * radius,
        aim=aim,
        narrow=narrow,
    )


TURNING: dict[str, Any] = {"bound": 1e-12 * 1000 * 180, "methods": settings(auto=1e-12, rk45=1e-12, taylor=1e-16)}

CASES = (
    case("thin-pole", **TURNING, measure=_straight_through),
    case("thin-pole-close", **TURNING, measure=_close_by),
    case(
        "thin-pole-chain", bound=2 * 1e-12 * 2000 * 240, methods=settings(auto=1e-12, lsoda=1e-12), measure=_in_a_chain
    ),
    *(_passing(radius, aim) for radius in (1e-3, 1e-4) for aim in (1e-3, 1e-6, 0.0)),
)
