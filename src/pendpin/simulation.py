"""The way in: a scene, and how it is to be solved."""

from pendpin.engines import Watch
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
) -> Trajectory:
    """The motion of a scene at its output times.

    method, tolerance, step and accuracy stand in for those of scene.solver. An accuracy is a goal, the largest tip
    distance to the true motion over the chain's length: the tolerance or step that meets it is found, and the method
    where none is given; the trajectory's stats say what was chosen, what error is estimated and what it took. `ledger`
    books the work of every effect along the way, in the trajectory's `work`. `watch` is called with the time reached,
    for progress. `limit` in s ends a run that takes longer.
    Raises InputError for a scene that cannot be run, RunError for a run that cannot reach its end or its accuracy: the
    error's `partial` is the Trajectory that there is.
    """
    wanted = {"method": method, "tolerance": tolerance, "step": step, "accuracy": accuracy}
    solver = scene.solver.replaced(**{name: value for name, value in wanted.items() if value is not None})
    scene = scene.model_copy(update={"solver": solver})
    if solver.accuracy is not None:
        return reach(scene, ledger, watch, limit)
    return run_scene(scene, ledger, watch, limit)
