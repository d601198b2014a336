"""The way in: a scene, and how it is to be solved."""

from pathlib import Path

from pendpin.checkpoint import EVERY, Checkpoint
from pendpin.engines import Watch
from pendpin.errors import InputError
from pendpin.goal import reach
from pendpin.runs import run_scene
from pendpin.scene import Scene
from pendpin.trajectory import Trajectory


def simulate(
    scene: Scene,
    *,
    method: str | None = None,
    tolerance: float | None = None,
    step: float | None = None,
    accuracy: float | None = None,
    ledger: bool = False,
    watch: Watch = lambda t: None,
    limit: float | None = None,
    checkpoint: str | Path | None = None,
    every: float = EVERY,
) -> Trajectory:
    """The motion of a scene at its output times.

    method, tolerance, step and accuracy stand in for those of scene.solver. An accuracy is a goal, the largest tip
    distance to the true motion over the chain's length: the tolerance or step that meets it is found, and the method
    where none is given; the trajectory's stats say what was chosen, what error is estimated and what it took. `ledger`
    books the work of every effect along the way, in the trajectory's `work`. `watch` is called with the time reached,
    for progress. `limit` in s ends a run that takes longer.

    `checkpoint` names a file where the state of the run is saved, whole or not at all, every so many seconds of wall
    time, at output times. Where the file exists the run goes on from it and gives, bit for bit, what it would have
    given unbroken; the stats add up. It has to be of the same scene, setting, ledger and versions. It stays when the
    run is done: delete it once the result is safe.

    Raises InputError for a scene that cannot be run, RunError for a run that cannot reach its end or its accuracy: the
    error's `partial` is the Trajectory that there is.
    """
    wanted = {"method": method, "tolerance": tolerance, "step": step, "accuracy": accuracy}
    solver = scene.solver.replaced(**{name: value for name, value in wanted.items() if value is not None})
    scene = scene.model_copy(update={"solver": solver})
    kept = None if checkpoint is None else Checkpoint(Path(checkpoint), every)
    if solver.accuracy is None:
        return run_scene(scene, ledger, watch, limit, kept)
    if kept:
        raise InputError("checkpoint: an accuracy takes several runs, and one can be saved: give a tolerance or a step")
    return reach(scene, ledger, watch, limit)
