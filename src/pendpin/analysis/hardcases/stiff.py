"""Springs, dampers and shaken supports, ten thousand times faster than the motion."""

from functools import partial

import numpy as np

from pendpin.analysis.hardcases.base import (
    REDUCED,
    THICK,
    THIN,
    Case,
    G,
    Solve,
    chain_of,
    inertia_about_joint,
    scene,
    settings,
)
from pendpin.effects import Spring, Support, Viscous
from pendpin.scene import Rod

STIFF = 1e8  # N m/rad, or N m s/rad
ROD = THICK.rods[0]
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
    two = solve(scene(chain_of(ROD, copies=2), *CLAMP, q=(0.5, 0.1), **span))
    one = solve(scene(chain_of(Rod(length=2.0, mass=2.0, radius=ROD.radius)), q=(0.5, 0.1), **span))
    return float(np.linalg.norm(two.tips()[:, 1] - one.tips()[:, 0], axis=-1).max())


def _bending(solve: Solve, full: bool) -> float:
    spring = Spring(stiffness=STIFF, joints=JOINTS)
    span = {"duration": 0.1 if full else 0.01, "samples": 11}
    return solve(scene(chain_of(ROD, copies=2), spring, q=(0.5, 0.1, 1e-3), **span)).energy().drift


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
    Case(
        name="spring-1e8",
        group=9,
        title="spring of 1e8 N m/rad",
        physics="A rod of 1 kg on a spring vibrates at 17,000 rad/s with an amplitude of 1e-3 rad.",
        why="270 vibrations in 0.1 s. Their amplitude is only 1e-3 rad, so an absolute tolerance limits them less.",
        figure="error of the angle divided by the first angle",
        bound=1e-12 * 270 * 20 * 0.1 * FAST * FAST / (1e-3 * FAST),
        derivation="tolerance 1e-12 of rates up to 17 rad/s, 20 steps a vibration, 270 vibrations; errors grow with the "
        "phase, 1,700 rad",
        methods=settings(auto=1e-12, taylor=1e-16, gauss6=1e-5),
        measure=_ringing,
    ),
    Case(
        name="spring-chain",
        group=9,
        title="two rods with a spring of 1e8 N m/rad between them",
        physics="The angle between the rods vibrates by 1e-3 rad at 50,000 rad/s while both rods swing.",
        why="The vibration has 50 J and the swing 1 rad/s. Fast and slow motion take place in the same joints.",
        figure="energy drift divided by the energy exchanged",
        bound=1e-10 * 20_000 * 10,
        derivation="tolerance 1e-10, at most 20,000 steps, 10 for the share of the fast motion",
        methods=settings(auto=1e-10),
        measure=_bending,
    ),
    Case(
        name="clamped-1e8",
        group=9,
        title="two rods clamped by 1e8 N m/rad and 1e8 N m s/rad",
        physics="Spring and damper fix the second rod to the first: both swing like one rod of 2 m.",
        why="Motions decay at 1e10 /s in a run of seconds: an explicit method would take 1e10 steps.",
        figure="distance of the tip to that of the single rod, m",
        bound=2 * (100 * 2 / STIFF + 1e-9 * 1000 * 15),
        derivation="100 N m bend the clamp by 1e-6 rad, over 2 m; two runs at 1e-9, 1,000 steps, errors grow 15 times",
        methods=settings(auto=1e-9, radau=1e-9, bdf=1e-9),
        measure=_clamped,
    ),
    *(
        Case(
            name=f"overdamped-{damping:g}",
            group=9,
            title=f"overdamped joints, {damping:g} N m s/rad",
            physics=f"A rod falls slowly against a damper of {damping:g} N m s/rad; its inertia does not matter.",
            why=f"Rates decay at {damping / J:.0e} /s, the angle changes at {WEIGHT / damping:.0e} /s.",
            figure="difference of theta to the motion without inertia, rad",
            bound=1e-10 * 1000 + 10 * J * WEIGHT / damping**2,
            derivation="tolerance 1e-10, at most 1,000 steps, errors decay; and the effect of the inertia",
            methods=settings(auto=1e-10, radau=1e-10),
            measure=partial(_creeping, damping=damping, duration=2 * damping / WEIGHT),
        )
        for damping in (1e4, 1e8)
    ),
    Case(
        name="kapitza-1e4",
        group=10,
        title="upright on a support that vibrates by 1 mm at 1e4 rad/s",
        physics="The fast vibration makes the upright position stable: the rod swings slowly about it (Kapitza).",
        why="The slow swing is the average of accelerations of 10,000 g over 3,000 cycles.",
        figure="difference of the lean to the averaged motion with its ripple, divided by the first lean",
        bound=(1 + SLOW * 2) * ((SHAKE / REDUCED) ** 2 + LEAN**2 + 1e-12 * 40_000 / LEAN),
        derivation="the next order of the average and of the lean, and tolerance 1e-12 with 40,000 steps, in the slow phase",
        methods=settings(auto=1e-12, taylor=1e-15),
        measure=_kapitza,
    ),
)
