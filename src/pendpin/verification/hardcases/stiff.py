"""Springs, dampers and shaken supports, ten thousand times faster than the motion."""

from functools import partial

import numpy as np

from pendpin.effects import Spring, Support, Viscous
from pendpin.scene import Chain, Rod, Scene
from pendpin.verification.hardcases.base import (
    REDUCED,
    ROD,
    THICK,
    THIN,
    G,
    Solve,
    case,
    drift_of,
    inertia_about_joint,
    scene,
    settings,
)

STIFF = 1e8  # N m/rad, or N m s/rad
J = inertia_about_joint(ROD)
WEIGHT = ROD.mass * ROD.properties.h * G  # N m/rad of a small angle
FAST = float(np.sqrt(STIFF / J))  # rad/s


def _ringing(solve: Solve, full: bool) -> float:
    """The error of the angle of a rod on a spring, divided by the first angle; exact: a cosine."""
    spring = Spring(stiffness=STIFF, joints=("theta",))
    run = solve(scene(THICK, spring, q=(1e-3,), duration=0.1 if full else 0.01, samples=11, gravity=None))
    return float(np.abs(run.q[:, 0] / 1e-3 - np.cos(FAST * run.t)).max())


def _creeping(solve: Solve, full: bool, damping: float, duration: float) -> float:
    """The error of theta in rad. Without inertia damping theta' = -weight sin(theta): tan(theta/2) falls exponentially."""
    run = solve(scene(THICK, Viscous(coefficient=damping), q=(1.0,), duration=duration, samples=11))
    exact = 2 * np.arctan(np.tan(0.5) * np.exp(-WEIGHT / damping * run.t))
    return float(np.abs(run.q[:, 0] - exact).max())


JOINTS = ("theta_2", "phi_2")
CLAMP = (Spring(stiffness=STIFF, joints=JOINTS), Viscous(coefficient=STIFF, joints=JOINTS))


def _clamped(solve: Solve, full: bool) -> float:
    """The distance in m between the tips of two clamped rods and of one rod of twice the length and mass."""
    span = {"duration": 3.0 if full else 0.5, "samples": 11}
    two = solve(scene(Chain(rods=(ROD,), copies=2), *CLAMP, q=(0.5, 0.1), **span))
    one = solve(scene(Chain(rods=(Rod(length=2.0, mass=2.0, radius=ROD.radius),)), q=(0.5, 0.1), **span))
    return float(np.linalg.norm(two.tips[:, 1] - one.tips[:, 0], axis=-1).max())


def bent(duration: float) -> Scene:
    """Two rods with a stiff spring between them, which starts with a small bend."""
    spring = Spring(stiffness=STIFF, joints=JOINTS)
    return scene(Chain(rods=(ROD,), copies=2), spring, q=(0.5, 0.1, 1e-3), duration=duration, samples=11)


SHAKE, SHAKEN = 1e-3, 1e4  # m, rad/s
LEAN = 1e-3  # rad from upright
SLOW = float(np.sqrt((SHAKE * SHAKEN / REDUCED) ** 2 / 2 - G / REDUCED))  # rad/s, Kapitza's swing about the upright


def _kapitza(solve: Solve, full: bool) -> float:
    """The difference of the lean to the averaged motion with its ripple, divided by the first lean."""
    support = Support(amplitude=(0.0, 0.0, SHAKE), frequency=SHAKEN, phase=np.pi / 2)
    duration = 2.0 if full else 0.03
    run = solve(scene(THIN, support, q=(np.pi - LEAN,), duration=duration, samples=41))
    ripple = 1 + SHAKE / REDUCED * np.cos(SHAKEN * run.t)
    averaged = np.cos(SLOW * run.t) * ripple / ripple[0]
    return float(np.abs((np.pi - run.q[:, 0]) / LEAN - averaged).max())


CASES = (
    case(
        "spring-1e8",
        bound=1e-12 * 270 * 20 * 0.1 * FAST * FAST / (1e-3 * FAST),
        methods=settings(auto=1e-12, taylor=1e-16, gauss6=1e-5),
        measure=_ringing,
    ),
    case(
        "spring-chain",
        bound=1e-10 * 20_000 * 10,
        methods=settings(auto=1e-10),
        measure=drift_of(bent, 0.1, 0.01),
    ),
    case(
        "clamped-1e8",
        bound=2 * (100 * 2 / STIFF + 1e-9 * 1000 * 15),
        methods=settings(auto=1e-9, radau=1e-9, bdf=1e-9),
        measure=_clamped,
    ),
    *(
        case(
            "overdamped",
            bound=1e-10 * 1000 + 10 * J * WEIGHT / damping**2,
            methods=settings(auto=1e-10, radau=1e-10),
            measure=partial(_creeping, damping=damping, duration=2 * damping / WEIGHT),
            damping=damping,
            decay=damping / J,
            rate=WEIGHT / damping,
        )
        for damping in (1e4, 1e8)
    ),
    case(
        "kapitza-1e4",
        bound=(1 + SLOW * 2) * ((SHAKE / REDUCED) ** 2 + LEAN**2 + 1e-12 * 40_000 / LEAN),
        methods=settings(auto=1e-12, taylor=1e-15),
        measure=_kapitza,
    ),
)
