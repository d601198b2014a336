"""One scene with many sets of numbers: every case is run and measured."""

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

from pendpin.errors import InputError, Interrupted, RunError, shown
from pendpin.ground.arrays import ArrayLike
from pendpin.ground.files import refuse_targets
from pendpin.ground.libraries import optional
from pendpin.runs.batches.pools import cores
from pendpin.runs.batches.series import WIDTH
from pendpin.scene import Scene, chosen_scene
from pendpin.sweeps import plan as plans
from pendpin.sweeps.cases import run_block, vectors_of
from pendpin.sweeps.measures import MEASURES, Function
from pendpin.sweeps.plan import Plan
from pendpin.sweeps.store import Store
from pendpin.sweeps.task import EXTRA, Task, checked
from pendpin.sweeps.workers import Results, Span, remote_cluster, run_in_processes, run_in_threads, run_on_cluster

WORKERS_EACH = 8  # processes for each processor, at most
BLOCK_SECONDS = 3.0  # of a block
FEWEST_BLOCKS = 8  # for each worker, so that none waits long for the last
LARGEST_BLOCK = 20_000  # cases

Progress = Callable[[int, int], None]  # cases done, cases in all


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
    progress: Progress = lambda done, count: None,
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
    setting = {name: value for name, value in settings.items() if value is not None}
    plan = vary if isinstance(vary, Plan) else plans.grid(vary)
    chosen = chosen_scene(scene)
    if setting or "solver.accuracy" not in plan.keys:  # beside an accuracy a scene has no tolerance
        chosen = chosen.with_solver(**setting)
    measures = (measure,) if isinstance(measure, str) or not isinstance(measure, Sequence) else tuple(measure)
    if not measures:
        raise InputError("measure: nothing is measured; name a number of a run, such as swing")
    task = checked(Task(chosen, plan, measures))
    _check_place(workers, dask)
    if not isinstance(out, str | Path | None):
        raise InputError(f"out: {shown(out)} is not the path of a store")
    new = out is None or not Path(out).exists()
    if out is not None and new:
        refuse_targets([Path(out)], [])
    size = _block_size(task, workers or cores()) if new else 1
    results = Store(task, None if out is None else Path(out), size)
    _run(task, results, workers, dask, progress)
    dataset = results.dataset()
    own = tuple(f"{m.name}: " for m in task.chosen if callable(m.function) and m.name not in MEASURES)
    if own and all(str(reason).startswith(own) for reason in dataset["why"].values.flat):
        raise RunError(f"measure: {dataset['why'].values.flat[0]}, in every case", dataset)
    return dataset


def _check_place(workers: int | None, dask: str | None) -> None:
    """Raises InputError for a number of workers or an address that cannot be."""
    most = WORKERS_EACH * cores()
    if workers is not None and (type(workers) is not int or not 1 <= workers <= most):
        right = f"a count from 1 to {most}, {WORKERS_EACH} for each processor"
        raise InputError(f"workers: {shown(workers)} is not {right}")
    if dask is not None and not isinstance(dask, str):
        raise InputError(f"dask: {shown(dask)} is not an address, such as tcp://host:8786")
    if workers is not None and dask is not None:
        raise InputError("workers: the cluster of `dask` has its own; give one of both")


def _run(task: Task, results: Store, workers: int | None, dask: str | None, progress: Progress) -> None:
    count, left = task.plan.count, results.left()
    spans = [results.blocks.span(block) for block in left]
    done = count - sum(end - begin for begin, end in spans)
    try:
        progress(done, count)
        with ExitStack() as stack:
            for place, block in stack.enter_context(closing(_run_spans(task, spans, workers, dask, stack))):
                results.put(left[place], block)
                begin, end = spans[place]
                done += end - begin
                progress(done, count)
    except (KeyboardInterrupt, Interrupted):
        again = "; the same sweep resumes from there" if results.path else ""
        raise Interrupted(f"stopped by the user after {done} of {count} cases{again}", results.dataset()) from None
    except RunError as error:
        raise RunError(str(error), results.dataset()) from None


def _run_spans(task: Task, spans: list[Span], workers: int | None, dask: str | None, stack: ExitStack) -> Results:
    """The results of the blocks that are left, as they come; a cluster ends with the stack."""
    if spans and dask is not None:
        return run_on_cluster(task, spans, stack.enter_context(remote_cluster(dask)))
    if spans and workers is not None and workers > 1:
        return run_in_processes(task, spans, workers)
    return run_in_threads(task, spans, workers or cores())


def _block_size(task: Task, workers: int) -> int:
    """How many cases make a block of a few seconds of processor time."""
    few = min(WIDTH if vectors_of(task) else 1, task.plan.count)
    run_block(task, 0, 1)  # what is compiled or imported is not counted
    begin = time.thread_time()
    run_block(task, 0, few)
    each = max((time.thread_time() - begin) / few, 1e-6)
    fair = -(-task.plan.count // (FEWEST_BLOCKS * workers))
    return max(1, min(int(BLOCK_SECONDS / each), fair, LARGEST_BLOCK))
