"""Running a block of a sweep's cases: in vectors (vectors.py) where these cover them, else each simulated on its own."""

import numpy as np

from pendpin.arrays import Array
from pendpin.errors import Interrupted, PendpinError
from pendpin.scene import Scene
from pendpin.simulation.simulate import run_to_setting
from pendpin.sweeps.measures import measured
from pendpin.sweeps.task import LOOSER, Block, Task, with_numbers
from pendpin.sweeps.vectors import vectors_of


def run_block(task: Task, begin: int, end: int) -> Block:
    """The measures of the cases from `begin` to `end`; what one gives does not depend on the others."""
    rows = task.plan.rows(np.arange(begin, end))
    block, vectors = Block.empty(len(rows), len(task.chosen)), vectors_of(task)
    done = vectors.fill(rows, block) if vectors else np.zeros(len(rows), bool)
    for i in np.flatnonzero(~done):
        block.values[i], block.why[i] = run_case(task, rows[i])
    return block


def run_case(task: Task, row: Array) -> tuple[Array, str]:
    """The measures (measures,) of the case with these numbers (keys,), simulated on its own, and why there are none."""
    try:
        scene = with_numbers(task.scene, task.plan.keys, row)
        run = run_to_setting(scene)
        looser = run_to_setting(_looser(scene)) if task.two else run
        return np.array([measured(m, run, looser) for m in task.chosen]), ""
    except Interrupted:
        raise
    except PendpinError as error:
        return np.full(len(task.chosen), np.nan), str(error)


def _looser(scene: Scene) -> Scene:
    """The scene at a tolerance or accuracy 100 times looser, or a step twice as long."""
    solver = scene.solver
    if solver.accuracy is not None:
        settings = {"accuracy": min(0.1, LOOSER * solver.accuracy)}
    elif solver.step is not None:
        settings = {"step": 2 * solver.step}
    else:
        settings = {"tolerance": min(0.1, LOOSER * (solver.tolerance or 0.0))}
    return scene.model_copy(update={"solver": solver.replaced(**settings)})
