"""One scene with many sets of numbers: every case is run and measured."""

import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from pendpin.errors import InputError, Interrupted, RunError, shown
from pendpin.ground.arguments import function, whole_number
from pendpin.ground.arrays import ArrayLike
from pendpin.ground.files import path_of, refuse_targets
from pendpin.ground.libraries import optional
from pendpin.runs.batches import WIDTH
from pendpin.scene import Scene, chosen_scene
from pendpin.sweeps import plan as plans
from pendpin.sweeps.cases import Task, checked, run_block, sampled
from pendpin.sweeps.measures import MEASURES, Function
from pendpin.sweeps.plan import Plan
from pendpin.sweeps.store import Store, blocks_left, finished
from pendpin.sweeps.workers import EXTRA, cores, in_processes, in_threads, run_all, run_on_cluster

WORKERS_EACH = 8  # processes for each processor, at most
BLOCK_SECONDS = 3.0  # of a block
FEWEST_BLOCKS = 8  # for each worker, so that none waits long for the last
LARGEST_BLOCK = 20_000  # cases


def sweep(
    scene: Scene | str | Path,
    vary: Mapping[str, ArrayLike] | Plan,
    measure: Sequence[str | Function] | str | Function = ("swing",),
    *,
    out: str | Path | None = None,
    workers: int | None = None,
    dask: str | None = None,
    method: str | None = None,
    tolerance: float | None = None,
    accuracy: float | None = None,
    progress: Callable[[int, int], None] = lambda done, count: None,
) -> Any:
    """Run a scene with many sets of numbers and measure each run.

    A case that cannot be run is NaN, with the reason in the variable `why`.

    Args:
        scene: a Scene, or the path of a TOML file.
        vary: a grid, by key paths of numbers of the scene (`model.rods[0].length`, `start.positions.theta_1`) and their
            values; or a Plan (pendpin.sweeps.plan: pairs, samples, cases_of).
        measure: names of numbers of a run (docs/sweep.md lists them), or functions of a Trajectory.
        out: a Zarr store, written block by block. The same call resumes an interrupted sweep, with bit-identical results.
        workers: processes on this machine; threads of this process if absent.
        dask: the address of a Dask cluster, which does the work then.
        method: in place of the scene's.
        tolerance: in place of the scene's.
        accuracy: in place of the scene's.
        progress: called with the numbers of cases done and in all.

    Returns:
        An xarray.Dataset with a dimension for each number that is varied.

    Raises:
        InputError: for keys, measures or a store that cannot be used.
        Interrupted: after Ctrl-C, with the Dataset so far as `partial`.
        MissingLibrary: without the extra `sweep`.
    """
    for library in ("xarray", "zarr"):
        optional(library, "a sweep", EXTRA)
    settings = {"method": method, "tolerance": tolerance, "accuracy": accuracy}

    plan = vary if isinstance(vary, Plan) else plans.grid(vary)
    chosen = chosen_scene(scene)
    if any(value is not None for value in settings.values()) or "solver.accuracy" not in plan.keys:
        chosen = chosen.with_solver(**settings)  # beside an accuracy a scene has no tolerance
    measures = (measure,) if isinstance(measure, str) or not isinstance(measure, Sequence) else tuple(measure)
    if not measures:
        raise InputError("measure: nothing is measured; name a number of a run, such as swing")
    task = checked(sampled(Task(chosen, plan, measures)))
    workers = None if workers is None else whole_number("workers", workers, most=WORKERS_EACH * cores())
    if dask is not None and not isinstance(dask, str):
        raise InputError(f"dask: {shown(dask)} is not an address, such as tcp://host:8786")
    if workers is not None and dask is not None:
        raise InputError("workers: the cluster of `dask` has its own; give one of both")
    progress, out = function("progress", progress), None if out is None else path_of(out)
    new = out is None or not out.exists()
    if out is not None and new:
        refuse_targets([out], [])
    count = plan.count
    try:
        size = _block_size(task, workers or cores()) if new else 1
    except (KeyboardInterrupt, Interrupted):  # of a single run, which knows nothing of the sweep
        reason = f"stopped by the user before the first of {count} cases; nothing is kept"
        raise Interrupted(reason, finished(Store(task, None, count).data)) from None
    results = Store(task, out, size)
    left = blocks_left(results.data)
    spans = [results.blocks.span(block) for block in left]
    if dask is not None and spans:
        blocks = run_on_cluster(run_block, Task, (task.scene, plan, measures), spans, dask)
    elif workers is not None and workers > 1 and spans:
        optional("cloudpickle", "a sweep in processes", EXTRA)  # pickle refuses functions of a script
        blocks = in_processes(partial(run_block, task), spans, workers)
    else:
        blocks = in_threads(partial(run_block, task), spans, workers or cores())
    put, show = (lambda place, block: results.put(left[place], block)), (lambda done: progress(done, count))
    cases = "cases; the same sweep resumes from there" if results.path else "cases"
    run_all(blocks, spans, count, put, show, cases, lambda reason: finished(results.data))
    dataset = finished(results.data)
    own = tuple(f"{m.name}: " for m in task.chosen if not m.two and m.name not in MEASURES)
    if own and all(str(reason).startswith(own) for reason in dataset["why"].values.flat):
        raise RunError(f"measure: {dataset['why'].values.flat[0]}, in every case", dataset)
    return dataset


def _block_size(task: Task, workers: int) -> int:
    """How many cases make a block of a few seconds of processor time."""
    few = min(WIDTH if task.batch else 1, task.plan.count)
    run_block(task, 0, 1)  # what is compiled or imported is not counted
    begin = time.thread_time()
    run_block(task, 0, few)
    each = max((time.thread_time() - begin) / few, 1e-6)
    fair = -(-task.plan.count // (FEWEST_BLOCKS * workers))
    return max(1, min(int(BLOCK_SECONDS / each), fair, LARGEST_BLOCK))
