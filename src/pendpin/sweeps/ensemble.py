"""Many starts of one scene at once.

A smooth scene of few joints is compiled once, as Taylor series of several starts side by side in SIMD vectors, each with
its own steps; threads share the starts. Any other scene is simulated start by start, in this process, or in several if
`workers` asks for them: a process runs the script that started it again. docs/accuracy.md lists the alternatives that
were measured.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np

from pendpin.dynamics.dynamics import bind
from pendpin.errors import InputError, Interrupted, RunError, amount, shown
from pendpin.ground.arguments import function, whole_number
from pendpin.ground.arrays import Array, ArrayLike
from pendpin.ground.libraries import version
from pendpin.ground.records import LARGEST
from pendpin.integrators import choose_method_and_engine, integrator_for, taylor_takes
from pendpin.integrators.fixed import largest_step
from pendpin.integrators.taylor import Taylor
from pendpin.model import kinematics
from pendpin.model.build import FARTHEST, Model, build
from pendpin.runs.batches import MOST_JOINTS, Series, ends_well
from pendpin.runs.simulate import run_to_setting
from pendpin.scene import Scene, Start, chosen_scene
from pendpin.sweeps.workers import cores, end_if_stopped, in_processes, in_threads, run_all
from pendpin.trajectory import Counts

MAX_BYTES = 4e9  # of the result

# Of m starts: positions and rates (2, m, n, nv), NaN from where one ended early; why it did; counts.
Part = tuple[Array, dict[int, str], list[Counts]]


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
        model, q = build(self.scene.model), self.q[starts]
        return kinematics.evaluate_each(lambda m, q: kinematics.tips(m, kinematics.poses(m, q)), [model], q)

    def __repr__(self) -> str:
        k, n, nv = self.q.shape
        failed = f", {len(self.stats.failures)} ended early" if self.stats.failures else ""
        how = f"{self.stats.method}, {self.stats.seconds:.3g} s{failed}"
        return f"Ensemble of {amount(k, 'start')}: {amount(n, 'sample')} of {amount(nv, 'joint')}, {how}"


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
    progress = function("progress", progress)
    workers = None if workers is None else whole_number("workers", workers)
    auto = scene.solver.method == "auto" and not scene.solver.accuracy
    free = auto and taylor_takes(scene, dynamics.model, MOST_JOINTS)
    if free and choose_method_and_engine(scene, dynamics, q[0], v[0])[0] == "dop853":  # the first start is not stiff
        scene = scene.with_solver(method="taylor")
    series, count = None, len(q)
    if scene.solver.method != "auto" and not scene.solver.accuracy:
        integrator = integrator_for(scene, bind(scene))
        if isinstance(integrator, Taylor):
            made = Series(scene, integrator.tolerance, np.stack([q, v], 1))
            series = made if made.covered else None
    if series is not None:
        workers = min(workers or cores(), count)
        pieces = series.started(q, v).pieces(len(scene.times), workers)
        spans = [(int(piece[0]), int(piece[-1]) + 1) for piece in pieces]
    else:
        workers, spans = min(workers or 1, count), [(i, i + 1) for i in range(count)]
    run = partial(_run_starts, scene, q, v, series)
    parts = in_threads(run, spans, workers) if series is not None or workers == 1 else in_processes(run, spans, workers)
    rows = np.full((2, count, len(scene.times), q.shape[1]), np.nan)
    done, failures, took = np.zeros(count, bool), dict[int, str](), list[Counts]()

    def put(place: int, part: Part) -> None:
        some = slice(*spans[place])
        rows[:, some], done[some] = part[0], True
        failures.update(part[1])
        took.extend(part[2])

    def ensemble(reason: str = "") -> Ensemble:
        libraries = sorted({(counts.library, counts.version) for counts in took})
        summed = "steps", "evaluations", "seconds", "compile_seconds"
        total: dict[str, Any] = {name: sum(getattr(counts, name) for counts in took) for name in summed}
        if series is not None:
            total["compile_seconds"] += series.compile_seconds
        stats = EnsembleStats(
            method=", ".join(sorted({counts.method for counts in took})) or scene.solver.method,
            tolerance=scene.solver.tolerance,
            step=largest_step(scene.times, scene.solver.step),
            **total,
            workers=workers,
            library=", ".join(library for library, _ in libraries),
            version=", ".join(number for _, number in libraries),
            failures=dict(sorted((failures | {int(i): f"not run: {reason}" for i in np.flatnonzero(~done)}).items())),
        )
        asked = slice(scene.extra_samples, None)  # without the start if that is not one of the requested times
        joints, (q, v) = dynamics.model.joints, rows[:, :, asked]
        return Ensemble(joints, scene.clock[asked], q, v, stats, scene)

    run_all(parts, spans, count, put, progress, "starts", ensemble)
    return ensemble()


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # overflow is reported as an error of the run
def _run_starts(
    scene: Scene, q: Array, v: Array, series: Series | None, begin: int, end: int, stopped: Event | None = None
) -> Part:
    """The starts from `begin` to `end` of q, v (k, nv): by `series` side by side, else one by one. Interrupted."""
    q, v, stopped = q[begin:end], v[begin:end], stopped or Event()
    rows, failures, took = np.full((2, len(q), len(scene.times), q.shape[1]), np.nan), dict[int, str](), list[Counts]()
    done = np.zeros(len(q), bool)
    if series is not None:
        series.stopped, clock = stopped, time.thread_time()
        cases = series.started(q, v)
        motions = series.run(cases, scene.times)
        seconds, steps = time.thread_time() - clock, int(np.nansum(motions.steps))
        done = ends_well(series.dynamics, cases, motions)
        rows[:, done] = motions.q[done], motions.v[done]
        how = {"method": "taylor", "tolerance": scene.solver.tolerance, "step": None, "library": "heyoka"}
        counts = {"steps": steps, "evaluations": steps, "seconds": seconds, "compile_seconds": 0.0}
        took.append(Counts(**how, **counts, version=version("heyoka")))
    for i in np.flatnonzero(~done).tolist():  # what does not end well wants the closer look of `simulate`
        end_if_stopped(stopped)
        start = Start.at_state(scene.start.time, q[i], v[i])
        try:
            run = run_to_setting(scene.model_copy(update={"start": start}), progress=partial(end_if_stopped, stopped))
        except Interrupted:
            raise
        except RunError as error:
            run, failures[begin + i] = error.partial, str(error)
        except InputError as error:
            failures[begin + i] = str(error)
            continue
        rows[:, i, : len(run.t)] = run.q, run.v
        took.append(run.stats)
    return rows, failures, took


def _starts(model: Model, scene: Scene, positions: ArrayLike, velocities: ArrayLike) -> list[Array]:
    """Positions and velocities as arrays (k, nv). Raises InputError for shapes and sizes that cannot be run."""
    n, nv, found = len(scene.times), len(model.joints), list[Array]()
    for name, values, most in (("positions", positions, FARTHEST), ("velocities", velocities, LARGEST)):
        try:
            rows = np.array(values)
        except ValueError:
            raise InputError(f"{name}: rows of different lengths, where each start has {nv} numbers") from None
        if rows.dtype.kind not in "iuf":
            raise InputError(f"{name}: {shown(values)} is not an array of numbers")
        if rows.ndim != 2 or rows.shape[1] != nv or not len(rows):
            raise InputError(f"{name}: shape {rows.shape}, where (starts, {nv}) is wanted, with at least one start")
        found.append(rows := rows.astype(float))
        if (bad := ~(np.abs(rows) <= most)).any():
            start, joint = np.argwhere(bad)[0]
            right = f"a finite number up to {most:g}"
            raise InputError(f"{name}[{start}]: {model.joints[joint]} is {rows[start, joint]:g}, not {right}")
    count = len(found[0])
    if count != len(found[1]):
        raise InputError(f"velocities: {len(found[1])} starts, where positions have {count}")
    if (size := 16.0 * count * n * nv) > MAX_BYTES:
        more = f"{size / 1e9:.3g} GB, more than {MAX_BYTES / 1e9:g} GB; use fewer starts, or fewer solver.samples"
        raise InputError(f"positions: {count} starts with {n} samples of {nv} joints need {more}")
    return found
