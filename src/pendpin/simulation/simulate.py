"""The way in: a scene, and how it is to be solved."""

from pathlib import Path

from pendpin.engines import ProgressCallback
from pendpin.errors import InputError
from pendpin.scene import Scene
from pendpin.simulation.checkpoint import EVERY, Checkpoint
from pendpin.simulation.guards import Deadline
from pendpin.simulation.run import run_scene
from pendpin.simulation.target_accuracy import reach
from pendpin.trajectory import Trajectory


def simulate(
    scene: Scene,
    *,
    method: str | None = None,
    tolerance: float | None = None,
    step: float | None = None,
    accuracy: float | None = None,
    energy_balance: bool = False,
    progress: ProgressCallback = lambda t: None,
    limit: float | None = None,
    checkpoint: str | Path | None = None,
    every: float = EVERY,
) -> Trajectory:
    """The motion of a scene at its output times.

    method, tolerance, step and accuracy stand in for those of scene.solver. An accuracy is a target, the largest tip
    distance to the true motion over the chain's length: the tolerance or step that meets it is found, and the method
    where none is given; the trajectory's stats say what was chosen, what error is estimated and what it took. With
    `energy_balance` the work of every effect is integrated along, in the trajectory's `work`. `progress` is called with
    the time reached. `limit` in s ends a call that takes longer: compiling, all runs of an accuracy, and
    computing wrenches and energies at the samples are in it.

    `checkpoint` names a file where the state of the run is saved, whole or not at all, every so many seconds of wall
    time, at output times. Where the file exists the run goes on from it and gives, bit for bit, what it would have
    given unbroken; the stats add up. It has to be of the same scene, setting, energy_balance and versions. It stays when the
    run is done: delete it once the result is safe.

    Raises InputError for a scene that cannot be run, RunError for a run that cannot reach its end or its accuracy: the
    error's `partial` is the Trajectory that there is.
    """
    deadline = Deadline(limit)
    wanted = {"method": method, "tolerance": tolerance, "step": step, "accuracy": accuracy}
    solver = scene.solver.replaced(**{name: value for name, value in wanted.items() if value is not None})
    scene = scene.model_copy(update={"solver": solver})
    kept = None if checkpoint is None else Checkpoint(Path(checkpoint), every)
    if solver.accuracy is None:
        return run_scene(scene, energy_balance, progress, deadline, kept)
    if kept:
        raise InputError("checkpoint: an accuracy takes several runs, and one can be saved: give a tolerance or a step")
    return reach(scene, energy_balance, progress, deadline)
