"""Accuracy as the target: the method and its setting that bring the tips within a given error.

A run is repeated with a finer setting, and the distance between the two is the error of the coarser one. Errors fall
with the setting like a power of it, at least PACE of that which the method promises; so the error of the finer run
follows, and what setting is fine enough. Rounding adds up to EPS a step.
"""

from dataclasses import dataclass, replace
from importlib.util import find_spec

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.compiling import MAX_COMPILED
from pendpin.dynamics.dynamics import bind
from pendpin.effects import BodyEffect
from pendpin.engines import ProgressCallback
from pendpin.errors import RunError
from pendpin.integrators import ADAPTIVE, FEW_JOINTS, MAX_JOINTS, automatic, taylor_takes
from pendpin.model.build import build, start_state
from pendpin.model.kinematics import apart
from pendpin.model.kinematics import reach as length_of
from pendpin.scene import FIXED_METHODS, Scene, least_tolerance
from pendpin.simulation.guards import Deadline
from pendpin.simulation.run import OFF_THE_BOOKS, run_scene
from pendpin.trajectory import Trajectory

PACE = 0.85  # of the power with which errors fall; measured on smooth scenes: 0.9 to 1.1
ORDERS = {"gauss2": 2, "gauss4": 4, "gauss6": 6, "rk4": 4, "euler": 1}  # in the step; 1 in the tolerance
GUESS = {"taylor": 1.0}  # tolerance over accuracy, at first; 0.1 of the others, whose errors are larger
COARSER = {"taylor": 1e4}  # the pilot's error over that of the first guess; 1000 of the others
LOOSEST = 1e-2  # tolerance of a pilot
FINE = 1e-12  # accuracies below are for the Taylor integrator wherever it can
FINEST = 1e6  # how much smaller than the last error the next may be
BLIND = 16.0  # the same, after a run that did not get to its end
COMING = 5.0  # the time of the runs to come, over that of the pilot
COMPILING = 0.02  # s a joint
MOST_STEPS = 1e7  # of fixed size
EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class _Way:
    """A method, how its error falls with its setting, the coarsest setting worth a run and the finest there is."""

    method: str
    order: float
    first: float
    least: float

    def finer(self, setting: float, factor: float) -> float:
        """The setting with an error smaller by a factor."""
        return max(setting * factor ** (-1 / self.order), self.least)


def reach(scene: Scene, energy_balance: bool, progress: ProgressCallback, deadline: Deadline) -> Trajectory:
    """The motion of a scene to the accuracy of its solver; as `simulate`, which see."""
    target, length = scene.solver.accuracy or 0.0, length_of(build(scene.model))
    way = _way(scene, energy_balance, progress, deadline)
    scene, coarse = _compiled(scene, way.method) if _has_wrenches(scene) else scene, way.first
    before = _run(scene.by(way.method, coarse), energy_balance, progress, deadline)
    setting = way.finer(coarse, COARSER.get(way.method, 1e3))
    spent = before.stats.seconds
    if COMING * spent > COMPILING * len(before.joints):
        scene = _compiled(scene, way.method)
    while True:
        run = _run(scene.by(way.method, setting), energy_balance, progress, deadline)
        gap, rounding = _gap(before, run, length, len(scene.times)), EPS * run.stats.steps
        error, spent = float(gap.max()) * (setting / coarse) ** (PACE * way.order) + rounding, spent + run.stats.seconds
        run = replace(run, stats=replace(run.stats, accuracy=target, error=error, all_seconds=spent))
        if error <= target:
            return run
        if setting <= way.least or rounding > target:
            raise RunError(_missed(target, run, gap), run)
        factor = float(np.clip(2 * error / target, 10, FINEST)) if np.isfinite(error) else BLIND
        before, coarse, setting = run, setting, way.finer(setting, factor)


def _compiled(scene: Scene, method: str) -> Scene:
    """The scene on compiled equations, where it and its method take them."""
    smooth = all(effect.smooth for effect in scene.effects)
    if not (smooth and method in ADAPTIVE and scene.solver.engine == "auto" and find_spec("heyoka")):
        return scene
    if len(build(scene.model).joints) > MAX_COMPILED:
        return scene
    return scene.model_copy(update={"solver": scene.solver.model_copy(update={"engine": "compiled"})})


def _has_wrenches(scene: Scene) -> bool:
    """Whether an evaluation computes what acts on the bodies, which takes far longer than all else."""
    return any(isinstance(effect, BodyEffect) for effect in scene.effects)


def _gap(coarse: Trajectory, fine: Trajectory, length: float, count: int) -> Array:
    """How far the tips are apart at `count` output times, over the length; inf where a run did not get that far."""
    n = min(len(coarse.t), len(fine.t))
    return np.append(apart(coarse.tips()[:n], fine.tips()[:n], length), np.full(count - n, np.inf))


def _run(scene: Scene, energy_balance: bool, progress: ProgressCallback, deadline: Deadline) -> Trajectory:
    """A run; one that is too coarse to get to its end is good up to there."""
    try:
        return run_scene(scene, energy_balance, progress, deadline)
    except RunError as error:
        if error.partial.stats.stopped != OFF_THE_BOOKS:
            raise
        return error.partial


def _missed(target: float, run: Trajectory, gap: Array) -> str:
    held = run.t[: int(np.argmax(np.append(gap[: len(run.t)] > target, True)))]
    up_to = f"two runs agree to it up to t = {held[-1]:g} s" if len(held) else "two runs agree to it nowhere"
    return (
        f"accuracy {target:g} is not met: with {run.stats.method}, {run.stats.setting}, the error is about "
        f"{run.stats.error:.1g}; {up_to}; beyond, the motion is chaotic or rounding too large"
    )


def _way(scene: Scene, energy_balance: bool, progress: ProgressCallback, deadline: Deadline) -> _Way:
    solver, target = scene.solver, scene.solver.accuracy or 0.0
    method = solver.method if solver.method != "auto" else _fastest(scene, energy_balance)
    if method in FIXED_METHODS:
        steps = _run(scene.by("dop853", LOOSEST), False, progress, deadline).stats.steps
        span = scene.duration or 1.0  # without a duration any step will do
        return _Way(method, ORDERS[method], span / max(steps, 1), span / MOST_STEPS)
    least = least_tolerance(method)
    return _Way(
        method, 1.0, min(COARSER.get(method, 1e3) * max(GUESS.get(method, 0.1) * target, least), LOOSEST), least
    )


def _fastest(scene: Scene, energy_balance: bool) -> str:
    """The method for a scene that names none."""
    dynamics, target = bind(scene), scene.solver.accuracy or 0.0
    found = automatic(dynamics, *start_state(dynamics.model, scene.start), scene.duration)
    few = MAX_JOINTS if target < FINE else FEW_JOINTS
    return "taylor" if found == "dop853" and taylor_takes(scene, dynamics, energy_balance, few) else found
