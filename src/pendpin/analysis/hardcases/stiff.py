"""Springs, dampers and shaken supports that are ten thousand times faster than the motion."""

from functools import partial

import numpy as np

from pendpin.analysis.hardcases.base import REDUCED, THICK, THIN, Case, G, Solve, chain_of, inertia_about_joint, scene
from pendpin.effects import Gravity, Spring, Support, Viscous
from pendpin.scene import Rod

STIFF = 1e8  # N m/rad, or N m s/rad
ROD = THICK.rods[0]
J = inertia_about_joint(ROD)
WEIGHT = ROD.mass * ROD.properties.h * G  # N m/rad of a small angle
FAST = float(np.sqrt(STIFF / J))  # rad/s


def _ringing(solve: Solve, full: bool) -> float:
    """The angle of a rod on a spring alone against the cosine, in parts of the first angle."""
    spring = Spring(stiffness=STIFF, joints=("theta",))
    run = solve(scene(THICK, spring, q=(1e-3,), duration=0.1 if full else 0.01, samples=11, gravity=None))
    return float(np.abs(run.q[:, 0] / 1e-3 - np.cos(FAST * run.t)).max())


def _creeping(solve: Solve, full: bool, damping: float, duration: float) -> float:
    """Inertia apart, damping theta' = -weight sin(theta): tan(theta/2) falls exponentially."""
    run = solve(scene(THICK, Viscous(coefficient=damping), q=(1.0,), duration=duration, samples=11))
    exact = 2 * np.arctan(np.tan(0.5) * np.exp(-WEIGHT / damping * run.t))
    return float(np.abs(run.q[:, 0] - exact).max())


JOINTS = ("theta_2", "phi_2")
CLAMP = (Spring(stiffness=STIFF, joints=JOINTS), Viscous(coefficient=STIFF, joints=JOINTS))


def _clamped(solve: Solve, full: bool) -> float:
    """Two rods clamped to each other against one of twice the length and mass."""
    span = {"duration": 3.0 if full else 0.5, "samples": 11}
    two = solve(scene(chain_of(ROD, copies=2), *CLAMP, q=(0.5, 0.1), **span))
    one = solve(scene(chain_of(Rod(length=2.0, mass=2.0, radius=ROD.radius)), q=(0.5, 0.1), **span))
    return float(np.linalg.norm(two.tips()[:, 1] - one.tips()[:, 0], axis=-1).max())


def _bending(solve: Solve, full: bool) -> float:
    spring = Spring(stiffness=STIFF, joints=JOINTS)
    given = scene(
        chain_of(ROD, copies=2),
        spring,
        q=(0.5, 0.1, 1e-3),
        duration=0.1 if full else 0.01,
        samples=11,
        gravity=Gravity(),
    )
    return solve(given).energy().drift


SHAKE, SHAKEN = 1e-3, 1e4  # m, rad/s
LEAN = 1e-3  # rad from upright
SLOW = float(np.sqrt((SHAKE * SHAKEN / REDUCED) ** 2 / 2 - G / REDUCED))  # rad/s, Kapitza's swing about the upright


def _kapitza(solve: Solve, full: bool) -> float:
    """The lean of a rod on a shaken support against the averaged motion with its ripple, in parts of the first lean."""
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
        physics="A rod of 1 kg on a spring rings at 17,000 rad/s, by 1e-3 rad.",
        why="270 swings in 0.1 s, all below a thousandth of a radian: absolute tolerances see little of them.",
        figure="angle against the cosine, in parts of the first",
        bound=1e-12 * 270 * 20 * 0.1 * FAST * FAST / (1e-3 * FAST),
        derivation="tolerance 1e-12 of rates up to 17 rad/s, 20 steps a swing, 270 swings, growing with the phase 1,700",
        methods={"auto": {"tolerance": 1e-12}, "taylor": {"tolerance": 1e-16}, "gauss6": {"step": 1e-5}},
        measure=_ringing,
    ),
    Case(
        name="spring-chain",
        group=9,
        title="two rods with a spring of 1e8 N m/rad between them",
        physics="A bend of 1e-3 rad rings at 50,000 rad/s while the rods swing.",
        why="50 J ring in a motion of 1 rad/s; the fast and the slow share all joints.",
        figure="energy drift over the energy moved",
        bound=1e-10 * 20_000 * 10,
        derivation="tolerance 1e-10, at most 20,000 steps, 10 for the share of the fast motion",
        methods={"auto": {"tolerance": 1e-10}},
        measure=_bending,
    ),
    Case(
        name="clamped-1e8",
        group=9,
        title="two rods clamped by 1e8 N m/rad and 1e8 N m s/rad",
        physics="Spring and damper leave the second rod no freedom: both swing like one rod of 2 m.",
        why="Decay at 1e10 /s in a motion of seconds: explicit steps would be ten thousand million.",
        figure="tip against the single rod's, m",
        bound=2 * (100 * 2 / STIFF + 1e-9 * 1000 * 15),
        derivation="moments of up to 100 N m bend the clamp by 1e-6 rad, over 2 m; two runs at 1e-9, 1,000 steps, growth 15",
        methods={"auto": {"tolerance": 1e-9}, "radau": {"tolerance": 1e-9}, "bdf": {"tolerance": 1e-9}},
        measure=_clamped,
    ),
    *(
        Case(
            name=f"overdamped-{damping:g}",
            group=9,
            title=f"overdamped joints, {damping:g} N m s/rad",
            physics=f"A rod sinks through a joint of {damping:g} N m s/rad; its inertia does not matter.",
            why=f"Rates decay at {damping / J:.0e} /s, the angle moves at {WEIGHT / damping:.0e} /s.",
            figure="theta against the motion without inertia, rad",
            bound=1e-10 * 1000 + 10 * J * WEIGHT / damping**2,
            derivation="tolerance 1e-10, at most 1,000 steps, errors decay; and what the inertia changes",
            methods={"auto": {"tolerance": 1e-10}, "radau": {"tolerance": 1e-10}},
            measure=partial(_creeping, damping=damping, duration=2 * damping / WEIGHT),
        )
        for damping in (1e4, 1e8)
    ),
    Case(
        name="kapitza-1e4",
        group=10,
        title="upright on a support shaken at 1e4 rad/s by 1 mm",
        physics="Shaken that fast the upright rod swings about the upright as if it hung there.",
        why="The slow swing is what is left of accelerations of 10,000 g, averaged over 3,000 cycles.",
        figure="lean against the averaged motion with its ripple, in parts of the first lean",
        bound=(1 + SLOW * 2) * ((SHAKE / REDUCED) ** 2 + LEAN**2 + 1e-12 * 40_000 / LEAN),
        derivation="next order of the average and of the lean, and tolerance 1e-12 with 40,000 steps, in the slow phase",
        methods={"auto": {"tolerance": 1e-12}, "taylor": {"tolerance": 1e-15}},
        measure=_kapitza,
    ),
)
