"""Many starts of one scene at once.

A smooth scene of few joints is compiled once, as Taylor series of several starts side by side in SIMD vectors, each with
its own steps; threads share the starts. Any other scene is simulated start by start, in this process, or in several if
`workers` asks for them: a process runs the script that started it again. docs/accuracy.md lists the alternatives that
were measured.
"""

import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pendpin.dynamics.dynamics import Dynamics, bind
from pendpin.errors import InputError, Interrupted, RunError, shown
from pendpin.ground.arrays import Array, ArrayLike, Indices
from pendpin.ground.records import LARGEST
from pendpin.integrators import automatic, integrator_for, taylor_takes
from pendpin.integrators.fixed import largest_step
from pendpin.integrators.taylor import Taylor
from pendpin.model import kinematics
from pendpin.model.build import FARTHEST, Model, build
from pendpin.runs.batches.pools import cores, in_processes, in_threads
from pendpin.runs.batches.series import MOST_JOINTS, Motions, Series, ends_well
from pendpin.runs.simulate import run_to_setting
from pendpin.scene import Scene, Start, chosen_scene
from pendpin.trajectory import Counts, Stats

MAX_BYTES = 4e9  # of the result


@dataclass(frozen=True, kw_only=True)
class EnsembleStats(Counts):
    """Counts and times of all runs together; seconds are summed over the workers."""

    workers: int
    failures: dict[int, str] = field(default_factory=dict)  # reasons of starts that ended early, by index


@dataclass(frozen=True, eq=False, repr=False)
class Ensemble:
    """Motions of one scene from k starts, at the same times; NaN from where a start ended early."""

    joints: tuple[str, ...]
    t: Array  # (n,) s
    q: Array  # (k, n, nv) rad, m for prismatic joints
    v: Array  # (k, n, nv)
    stats: EnsembleStats
    scene: Scene  # of its start only the time is used

    def tips(self, starts: slice | Sequence[int] = slice(None)) -> Array:
        """The far end of each rod, (starts, n, rods, 3) m in W, of all starts or of some: a URDF takes 5 us a sample."""
        q = self.q[starts]
        flat = kinematics.tips(self._model, kinematics.poses(self._model, q.reshape(-1, q.shape[-1])))
        return flat.reshape(*q.shape[:2], *flat.shape[1:])

    def __repr__(self) -> str:
        k, n, nv = self.q.shape
        failed = f", {len(self.stats.failures)} ended early" if self.stats.failures else ""
        return f"Ensemble of {k} starts: {n} samples of {nv} joints, {self.stats.method}, {self.stats.seconds:.3g} s{failed}"

    @cached_property
    def _model(self) -> Model:
        return build(self.scene.model)


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # overflow is reported as an error of the run
def simulate_many(
    scene: Scene | str | Path,
    positions: ArrayLike,
    velocities: ArrayLike,
    *,
    method: str | None = None,
    tolerance: float | None = None,
    workers: int | None = None,
    progress: Callable[[int], None] = lambda done: None,
) -> Ensemble:
    """Simulate a scene from many starts.

    Each row equals the result of `simulate` for that start within the tolerance, and does not depend on the others. The
    rows of a start that ends early are NaN from there on; `stats.failures` holds the reason.

    Args:
        scene: a Scene, or the path of a TOML file.
        positions: (k, nv) rad, in model order.
        velocities: (k, nv) rad/s.
        method: in place of the scene's; with "auto", smooth scenes of up to MOST_JOINTS joints use taylor.
        tolerance: in place of the scene's.
        workers: processes for methods other than taylor, which runs in threads on all processors; this process if absent.
            A script with processes needs `if __name__ == "__main__":`.
        progress: called with the number of finished starts.

    Returns:
        The Ensemble.

    Raises:
        InputError: for starts or a scene that cannot be run.
        Interrupted: after Ctrl-C, with the result so far as `partial`.
    """
    scene = chosen_scene(scene).with_solver(method=method, tolerance=tolerance)
    dynamics = bind(scene)
    q, v = _starts(dynamics.model, scene, positions, velocities)
    threads, processes = _workers(workers, len(q))
    scene = _choose_method(scene, dynamics, q[0], v[0])
    dynamics = bind(scene)
    integrator = None if scene.solver.accuracy or scene.solver.method == "auto" else integrator_for(scene, dynamics)
    table = _Table(q, v, len(scene.times), progress)
    in_series = isinstance(integrator, Taylor)
    result = partial(table.ensemble, scene, dynamics.model.joints, threads if in_series else processes)
    try:
        if in_series:
            _run_series(scene, integrator, table, threads)
        _run_each(scene, table, processes)
    except (KeyboardInterrupt, Interrupted):
        reason = f"stopped by the user after {table.done.sum()} of {len(q)} starts"
        raise Interrupted(reason, result("not run: stopped by the user")) from None
    except RunError as error:
        raise RunError(str(error), result(f"not run: {error}")) from None
    return result()


def _choose_method(scene: Scene, dynamics: Dynamics, q: Array, v: Array) -> Scene:
    """The scene with taylor where taylor is chosen; the first start q, v (nv,) shows whether the scene is stiff."""
    solver = scene.solver
    if solver.method != "auto" or solver.accuracy or not taylor_takes(scene, dynamics, False, MOST_JOINTS):
        return scene
    if automatic(scene, dynamics, q, v)[0] != "dop853":
        return scene
    return scene.with_solver(method="taylor")


# --- what is refused ------------------------------------------------------------------------------------------------


def _starts(model: Model, scene: Scene, positions: ArrayLike, velocities: ArrayLike) -> tuple[Array, Array]:
    """Positions and velocities as arrays (k, nv). Raises InputError for shapes and sizes that cannot be run."""
    q, v = _numbers("positions", positions, model, FARTHEST), _numbers("velocities", velocities, model, LARGEST)
    if len(q) != len(v):
        raise InputError(f"velocities: {len(v)} starts, where positions have {len(q)}")
    n, nv = len(scene.times), len(model.joints)
    if (size := 16.0 * len(q) * n * nv) > MAX_BYTES:
        raise InputError(
            f"positions: {len(q)} starts with {n} samples of {nv} joints need {size / 1e9:.3g} GB, more "
            f"than {MAX_BYTES / 1e9:g} GB; use fewer starts, or fewer solver.samples"
        )
    return q, v


def _numbers(name: str, values: ArrayLike, model: Model, most: float) -> Array:
    """Rows of finite numbers, (k, nv), as an array of their own."""
    nv = len(model.joints)
    try:
        rows = np.array(values)
    except ValueError:
        raise InputError(f"{name}: rows of different lengths, where each start has {nv} numbers") from None
    if rows.dtype.kind not in "iuf":
        raise InputError(f"{name}: {shown(values)} is not an array of numbers")
    if rows.ndim != 2 or rows.shape[1] != nv or not len(rows):
        raise InputError(f"{name}: shape {rows.shape}, where (starts, {nv}) is wanted, with at least one start")
    rows = rows.astype(float)
    if (bad := ~(np.abs(rows) <= most)).any():
        start, joint = np.argwhere(bad)[0]
        right = f"a finite number up to {most:g}"
        raise InputError(f"{name}[{start}]: {model.joints[joint]} is {rows[start, joint]:g}, not {right}")
    return rows


def _workers(workers: int | None, starts: int) -> tuple[int, int]:
    """How many threads, and how many processes, run the starts."""
    if workers is None:
        return min(cores(), starts), 1
    if not isinstance(workers, int) or isinstance(workers, bool) or workers < 1:
        raise InputError(f"workers: {shown(workers)} is not a whole number above 0")
    return min(workers, starts), min(workers, starts)


# --- what is done ---------------------------------------------------------------------------------------------------


class _Took(NamedTuple):
    """What some runs took."""

    steps: int = 0
    evaluations: int = 0
    seconds: float = 0.0
    compile_seconds: float = 0.0

    def plus(self, other: "_Took") -> "_Took":
        """The sum of both."""
        return _Took._make(one + more for one, more in zip(self, other, strict=True))


class _Table:
    """The starts, and the rows that there are."""

    def __init__(self, q: Array, v: Array, samples: int, progress: Callable[[int], None]) -> None:
        shape = (len(q), samples, q.shape[1])
        self.starts, self.q, self.v = (q, v), np.full(shape, np.nan), np.full(shape, np.nan)
        self.done, self._progress = np.zeros(len(q), dtype=bool), progress
        self.took, self.failures = _Took(), dict[int, str]()
        self.methods, self.libraries = set[str](), set[tuple[str, str]]()

    def finish(self, places: Indices | int, took: _Took) -> None:
        """Mark rows (m,) as done and add their counts."""
        self.done[places] = True
        self.took = self.took.plus(took)
        self._progress(int(self.done.sum()))

    def ensemble(self, scene: Scene, joints: tuple[str, ...], workers: int, left: str = "") -> Ensemble:
        """The result; `left` says why the rest was not run."""
        self.q[~self.done], self.v[~self.done] = np.nan, np.nan
        failures = self.failures | {int(place): left for place in np.flatnonzero(~self.done)}
        solver, took = scene.solver, self.took
        stats = EnsembleStats(
            method=", ".join(sorted(self.methods)) or solver.method,
            tolerance=solver.tolerance,
            step=largest_step(scene.times, solver.step),
            **took._asdict(),
            workers=workers,
            library=", ".join(name for name, _ in sorted(self.libraries)),
            version=", ".join(version for _, version in sorted(self.libraries)),
            failures=dict(sorted(failures.items())),
        )
        return Ensemble(joints, scene.clock, self.q, self.v, stats, scene)


# --- as series, side by side ----------------------------------------------------------------------------------------


def _run_series(scene: Scene, integrator: Taylor, table: _Table, workers: int) -> None:
    """Fill in what ends well; the rest wants the closer look of `simulate`."""
    table.methods.add("taylor")
    table.libraries.add((integrator.library, integrator.version))
    series = Series(scene, integrator.tolerance, np.stack(table.starts, 1))
    if not series.covered:
        return
    cases = series.started(*table.starts)
    pieces = cases.pieces(len(scene.times), workers)

    def run(places: Indices) -> tuple[Motions, float]:
        begin = time.thread_time()
        return series.run(cases.some(places), scene.times), time.thread_time() - begin

    with closing(in_threads(run, pieces, workers, series.stopped.set)) as results:
        for piece, (motions, seconds) in results:
            places, steps = pieces[piece], int(motions.steps.sum())
            table.q[places], table.v[places] = motions.q, motions.v
            good = ends_well(series.dynamics, motions.q, motions.v)
            table.finish(places[good], _Took(steps, steps, seconds))
    table.took = table.took.plus(_Took(compile_seconds=series.compile_seconds))


# --- one by one -----------------------------------------------------------------------------------------------------


class _Row(NamedTuple):
    """One start's motion, as far as it came."""

    q: Array  # (n, nv)
    v: Array
    stats: Stats | None  # None where it did not begin
    failure: str | None  # why it ended early


def _run_each(scene: Scene, table: _Table, workers: int) -> None:
    """Run what is not done yet."""
    left = np.flatnonzero(~table.done)
    jobs = [(table.starts[0][place], table.starts[1][place]) for place in left]
    with closing(in_processes(partial(_alone, scene), jobs, max(1, min(workers, len(jobs))))) as results:
        for job, row in results:
            place, n = int(left[job]), len(row.q)
            for room, rows in ((table.q, row.q), (table.v, row.v)):
                room[place, :n], room[place, n:] = rows, np.nan
            if row.stats:
                table.methods.add(row.stats.method)
                table.libraries.add((row.stats.library, row.stats.version))
            table.failures |= {place: row.failure} if row.failure else {}
            table.finish(place, _Took._make(getattr(row.stats, name, 0) for name in _Took._fields))


def _alone(scene: Scene, start: tuple[Array, Array]) -> _Row:
    """One run from a start q, v (nv,); an error of the run is part of the row."""
    q, v = start
    at = Start(time=scene.start.time, positions=tuple(q.tolist()), velocities=tuple(v.tolist()))
    try:
        run, failure = run_to_setting(scene.model_copy(update={"start": at})), None
    except Interrupted:
        raise
    except RunError as error:
        run, failure = error.partial, str(error)
    except InputError as error:
        none = np.empty((0, len(q)))
        return _Row(none, none, None, str(error))
    return _Row(run.q, run.v, run.stats, failure)
