"""The hard cases in other simulators: MuJoCo, Drake, and SciPy on Pinocchio's accelerations, each at its best setting."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np

from pendpin.errors import RunError
from pendpin.model import kinematics
from pendpin.model.build import build
from pendpin.motions.simulate import simulate
from pendpin.motions.trajectory import Trajectory
from pendpin.scene import Scene
from pendpin.trajectory import Derived, Stats
from pendpin.verification.claims import Progress
from pendpin.verification.hardcases import chains, chaos
from pendpin.verification.hardcases.base import Case, Outcome, Solve, measured, outcome, scene
from pendpin.verification.simulators import Peer, PeerRun, require_libraries, task_of
from pendpin.verification.simulators.base import Kind
from pendpin.verification.simulators.drake import drake_peers
from pendpin.verification.simulators.mujoco import mujoco_peers
from pendpin.verification.simulators.scipy import scipy_peers

SETTINGS = {"tolerance": (1e-9, 1e-12), "step": (1e-3, 1e-4, 1e-5)}  # steps as fractions of the duration
LIMIT = 20.0  # s that a run may take
CLOSE = 1e-6  # of the chain's length: the bound where tips are compared with pendpin's at a tight tolerance
SIMULATORS: Mapping[str, tuple[Callable[..., Iterator[Peer]], str, Kind]] = {
    "MuJoCo RK4": (mujoco_peers, "mujoco rk4", "step"),
    "Drake RK5": (drake_peers, "drake rk5", "tolerance"),
    "SciPy DOP853": (scipy_peers, "scipy dop853", "tolerance"),
}
# the groups whose figures come from angles alone, but for some cases
GRAVITY_ALONE = (1, 2, 3, 5, 6, 7, 12, 13, 14, 15)
NOT_FOR_PEERS = (  # other effects than gravity; figures that need rates or pendpin's settings; starts at other times
    *("pole-torque-thick", "pole-phi-torque-thin", "pole-torque-thin", "swings-in-space", "triple-1e4"),
    *("late", "late-driven", "chaos-methods", "chaos-back", "reversed"),
)


def contests(cases: Sequence[Case]) -> tuple[Case, ...]:
    """The short forms that other simulators can run: measured by their angles, or by tips compared with pendpin's.

    Raises MissingLibrary where a simulator is not installed.
    """
    require_libraries()
    direct = [case for case in cases if case.group in GRAVITY_ALONE and case.name not in NOT_FOR_PEERS]
    compared = [_against_ours(case, COMPARED[case.name]) for case in cases if case.name in COMPARED]
    return tuple(sorted([*direct, *compared], key=lambda case: case.group))


COMPARED: Mapping[str, Callable[[], Scene]] = {
    **{f"cone-{rate:g}": partial(chaos.cone, rate, 50) for rate in (1e2, 1e3, 1e4)},
    "swings-in-space": lambda: scene(chaos.THICK, q=(0.7, 0.4), v=(1.3, -0.8), duration=40.0, samples=41),
    "triple-1e4": lambda: chaos.triple(3.0),
    "chain-100": lambda: chains.tumbling(chains.HUNDRED, 0.1),
    "whip": lambda: chains.whip(12, 0.3),
    "chaos-methods": lambda: chaos.wild(5.0),
}


def _against_ours(case: Case, make_scene: Callable[[], Scene]) -> Case:
    @cache
    def ours() -> Trajectory:
        return simulate(make_scene(), method="dop853", tolerance=1e-13)

    def measure(solve: Solve, full: bool) -> float:
        length = kinematics.chain_length(build(make_scene().model))
        return float(kinematics.tip_distance(solve(make_scene()).tips, ours().tips, length).max())

    words = {"figure": "distance to pendpin's tips at tolerance 1e-13, over the chain's length", "derivation": "chosen"}
    return replace(case, measure=measure, bound=CLOSE, beside=None, **words)


def run_on_peers(case: Case, progress: Progress) -> Iterator[Outcome]:
    """A case on `auto` and on other simulators."""
    progress(f"{case.name} on auto")
    yield replace(outcome(case, "auto", full=False), claimed=False)
    for name in SIMULATORS:
        progress(f"{case.name} on {name}")
        yield _best(case, name)


def _best(case: Case, name: str) -> Outcome:
    """The best outcome over settings from coarse to fine; none finer after a run longer than LIMIT."""
    build_peers, method, kind = SIMULATORS[name]
    outcomes: list[Outcome] = []
    for setting in SETTINGS[kind]:
        solve = partial(_run_peer, build_peers, method, setting)
        outcomes.append(replace(measured(case, f"{name}, {setting:g}", solve, full=False), claimed=False))
        if outcomes[-1].seconds > LIMIT:
            break
    return min(outcomes, key=lambda o: np.inf if o.measured is None else o.measured)


def _run_peer(build_peers: Callable[..., Iterator[Peer]], method: str, setting: float, scene: Scene) -> Trajectory:
    """A scene run by another simulator. Raises RunError if the run does not reach its end."""
    peer = next(peer for peer in build_peers(task_of(scene)) if peer.name == method)
    if peer.kind == "step":
        setting *= scene.duration or 1.0
    try:
        run = peer.run(setting, LIMIT)
    except RuntimeError as error:  # Drake's, before its first step
        raise RunError(str(error)) from None
    if run.failure:
        raise RunError(run.failure)
    return _trajectory(scene, peer, setting, run)


def _trajectory(scene: Scene, peer: Peer, setting: float, run: PeerRun) -> Trajectory:
    """The run of another simulator as a Trajectory; NaN for what it does not compute."""
    model, (n, nv) = build(scene.model), run.q.shape
    unknown: Any = np.full((n, nv), np.nan)
    tolerance, step = (setting if peer.kind == kind else None for kind in ("tolerance", "step"))
    stats = Stats(
        method=peer.name,
        tolerance=tolerance,
        step=step,
        steps=run.steps,
        evaluations=run.evaluations,
        events=0,
        seconds=run.seconds,
        compile_seconds=0.0,
        engine="",
        library=peer.library,
        version="",
    )
    return Trajectory(
        joints=model.joints,
        t=run.t,
        q=run.q,
        v=unknown,
        derived=Derived(
            a=unknown,
            wrench=np.full((n, nv, 6), np.nan),
            kinetic=unknown[:, 0],
            potential=unknown[:, 0],
            tips=kinematics.tips(model, kinematics.poses(model, run.q)),
            rod_reactions=None,
        ),
        stats=stats,
    )
