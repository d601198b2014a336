"""Running a block of a sweep's cases: side by side in the processor's vectors, else each simulated on its own.

Smooth scenes of few joints go side by side, by runs/batches/series.py.
"""

from contextlib import suppress
from functools import lru_cache, partial
from threading import Event

import numpy as np

from pendpin.engines import ProgressCallback
from pendpin.errors import Interrupted, PendpinError
from pendpin.ground.arrays import Array, Indices, Mask
from pendpin.ground.keypaths import parsed
from pendpin.ground.libraries import installed
from pendpin.ground.records import LARGEST
from pendpin.integrators import Run
from pendpin.model.build import FARTHEST, Model, build, start_state
from pendpin.runs.accuracy.thresholds import VECTOR
from pendpin.runs.batches.series import Cases, Motions, Series, ends_well, takes
from pendpin.runs.batches.side_by_side import Ladder
from pendpin.runs.run import fill_in
from pendpin.runs.simulate import run_to_setting
from pendpin.scene import Scene
from pendpin.sweeps.measures import Measure, accumulated, evaluate_measure
from pendpin.sweeps.task import LOOSER, Block, Task, set_numbers, typical
from pendpin.trajectory import RunRecord

AT_POLE = 1e-4  # of cos(phi): rounding over its square is an error of 1e-8 in the angular acceleration of theta


def run_block(task: Task, begin: int, end: int, stopped: Event | None = None) -> Block:
    """The measures of the cases from `begin` to `end`; what one gives does not depend on the others.

    Raises Interrupted where the sweep was stopped, which a thread is not told of otherwise.
    """

    def look(t: float = 0.0) -> None:
        if stopped is not None and stopped.is_set():
            raise Interrupted("stopped by the user")

    rows = task.plan.rows(np.arange(begin, end))
    block, vectors = Block.empty(len(rows), task.columns[-1].stop), vectors_of(task)
    done = vectors.fill(rows, block) if vectors else np.zeros(len(rows), bool)
    for i in np.flatnonzero(~done):
        look()
        block.values[i], block.why[i] = run_case(task, rows[i], look)
    return block


def run_case(task: Task, row: Array, progress: ProgressCallback = lambda t: None) -> tuple[Array, str]:
    """The measures (measures,) of the case with these numbers (keys,), simulated on its own, and why there are none."""
    try:
        scene = set_numbers(task.scene, task.plan.keys, row)
        run = run_to_setting(scene, progress=progress)
        looser = run_to_setting(_looser(scene), progress=progress) if task.two else run
        return np.concatenate([np.ravel(evaluate_measure(m, run, looser)) for m in task.chosen]), ""
    except Interrupted:
        raise
    except PendpinError as error:
        return np.full(task.columns[-1].stop, np.nan), str(error)


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


class Vectors:
    """A sweep whose cases go side by side."""

    def __init__(self, task: Task) -> None:
        scene = typical(task)
        with_flips = any(m.name.startswith("flip_time") for m in task.chosen)
        self._flips = sums = accumulated(build(scene.model)) if with_flips else []
        if all(m.ends for m in task.chosen):
            few = {"times": tuple(scene.clock[[0, -1]].tolist())} if scene.solver.times else {"samples": 2}
            scene = scene.model_copy(update={"solver": scene.solver.model_copy(update=few)})
        self.task, self.scene, self.ladder = task, scene, None
        moved, keys = None, [key for key in task.plan.keys if key.startswith("start.")]
        with suppress(PendpinError):  # a start with other numbers, where it is varied
            moved = set_numbers(scene, keys, np.random.default_rng(0).uniform(0.1, 1.0, len(keys)))
        model = build(scene.model)
        starts = [start_state(model, case.start) for case in (scene, moved or scene)]
        made = partial(Series, scene, starts=np.array(starts), flips=sums)
        if scene.solver.accuracy:
            self.ladder = Ladder(scene, made)
            self.series = self.ladder.series[::-1]
        else:
            fine = scene.solver.tolerance or 0.0
            self.series = [made(tolerance) for tolerance in ([fine, min(0.1, LOOSER * fine)] if task.two else [fine])]
        self._joints = _start_joints(task, self.series[0].dynamics.model)
        self._start = start_state(self.series[0].dynamics.model, scene.start)
        self._starts_alone = all(key.startswith("start") for key in task.plan.keys)
        self._clock = scene.clock

    def fill(self, rows: Array, block: Block) -> Mask:
        """Put in what the cases with these numbers (k, keys) give; those that went well (k,), the rest is untouched."""
        places, cases = self._cases(rows) if self._joints is None else self._starts(rows, self._joints)
        done = np.zeros(len(rows), bool)
        if cases:
            for piece in cases.pieces(len(self._clock)):
                done[places[piece]] = self._fill_piece(rows, places[piece], cases.some(piece), block)
        return done

    def _cases(self, rows: Array) -> tuple[Indices, Cases | None]:
        """The cases with these numbers (k, keys), and where they are among them; `simulate` has to look at the others.

        A number that is 0 makes another structure: its equations lack what it stands for.
        """
        cases = dict[int, Cases]()
        for place, row in enumerate(rows):
            with suppress(PendpinError):  # simulate says why
                if case := self.series[0].case(set_numbers(self.task.scene, self.task.plan.keys, row)):
                    cases[place] = case
        return np.array([*cases], int), Cases.joined([*cases.values()]) if cases else None

    def _starts(self, rows: Array, joints: tuple[Indices, Indices]) -> tuple[Indices, Cases]:
        """The cases of numbers (k, keys) that are angles and rates of the start."""
        states = np.tile(self._start, (len(rows), 1, 1))
        states[:, *joints] = rows
        places = np.flatnonzero(np.all(np.abs(states) <= [[FARTHEST], [LARGEST]], axis=(1, 2)))
        return places, self.series[0].started(*np.moveaxis(states[places], 1, 0))

    def _runs(self, cases: Cases) -> tuple[list[Motions], Mask]:
        """The motions of c cases and, where two are compared, looser ones; which cases (c,) met the setting."""
        if self.ladder:
            *runs, met = self.ladder.run(cases)
        else:
            runs, met = [series.run(cases, self.scene.times) for series in self.series], np.ones(len(cases.q), bool)
        return [run._replace(t=self._clock) for run in runs], met

    def _fill_piece(self, rows: Array, places: Indices, cases: Cases, block: Block) -> Mask:
        """Put in the measures of c cases, which are at `places` (c,) of the numbers (k, keys); which went well (c,)."""
        runs, good = self._runs(cases)
        for run in runs:
            good &= run.finite
        if self._flips:  # as series on angles, which a thin rod at its pole does not have
            good &= ~_turning_at_poles(cases)
        if self._starts_alone:  # else each case has energies of its own
            good &= ends_well(self.series[0].dynamics, runs[0].q, runs[0].v)
        columns = [_measure_motions(m, runs) for m in self.task.chosen]
        for values, columns_of in zip(columns, self.task.columns, strict=True):
            if values is not None:
                block.values[places[good], columns_of.start] = values[good]
        untold = [
            np.isnan(values) & m.between if values is not None else np.ones(len(good), bool)
            for m, values in zip(self.task.chosen, columns, strict=True)
        ]
        for i in np.flatnonzero(good & np.any(untold, 0)).tolist():
            if self.series[0].stopped.is_set():
                break
            self._complete(rows, int(places[i]), i, [k for k, which in enumerate(untold) if which[i]], runs, block)
        return good

    def _complete(self, rows: Array, place: int, i: int, missing: list[int], runs: list[Motions], block: Block) -> None:
        """Put in the measures of case i of `runs` that need whole runs; its numbers are rows[place] (keys,)."""
        try:
            whole = [self._whole(rows[place], run, i) for run in runs]
            for k in missing:
                values = evaluate_measure(self.task.chosen[k], whole[0], whole[-1])
                block.values[place, self.task.columns[k]] = np.ravel(values)
        except PendpinError as error:
            block.values[place], block.why[place] = np.nan, str(error)

    def _whole(self, row: Array, motions: Motions, place: int) -> RunRecord:
        """The trajectory of case `place` of a batch, with forces and energies; its numbers are row (keys,)."""
        scene = set_numbers(self.scene, self.task.plan.keys, row).by("taylor", self.series[0].tolerance)
        dynamics = self.series[0].bound(scene)
        dynamics.use_compiled_samples()
        version = installed("heyoka")["heyoka"] or ""
        steps, none = int(motions.steps[place]), np.zeros((len(scene.times), 0))
        run = Run(scene.times, motions.q[place], motions.v[place], None, none, steps, steps, 0, 0.0, "heyoka", version)
        return fill_in(scene, dynamics, None, run)


def _turning_at_poles(cases: Cases) -> Mask:
    """Which cases (c,) start with a thin rod at its pole, and not in the plane of phi alone."""
    rods = cases.models[0].rods
    thetas, phis = [rod.theta for rod in rods if rod.theta >= 0], [rod.phi for rod in rods if rod.phi >= 0]
    off_plane = np.any(cases.q[:, thetas], 1) | np.any(cases.v[:, thetas], 1)
    at_pole = np.asarray(off_plane & np.any(np.abs(np.cos(cases.q[:, phis])) < AT_POLE, 1))
    for i in np.flatnonzero(at_pole).tolist():
        at_pole[i] = cases.models[i].thin_at_pole(cases.q[i], AT_POLE) is not None
    return at_pole


def _measure_motions(m: Measure, motions: list[Motions]) -> Array | None:
    """The measure (c,) from positions and rates alone; None where these do not say it."""
    try:
        if m.two:
            return m.of_motions(*motions) if m.of_motions else None
        return m.of_motion(motions[0]) if m.of_motion else None
    except LookupError:  # a series of something else
        return None


def _start_joints(task: Task, model: Model) -> tuple[Indices, Indices] | None:
    """Where in (q, v) each key belongs, if all are angles or rates of the start in radians; else None."""
    paths = [parsed(key) for key in task.plan.keys]
    fields = ("positions", "velocities")
    states = all(len(path) == 3 and path[0] == "start" and path[1] in fields for path in paths)
    if not states or task.scene.start.unit == "degrees":
        return None
    joints = [path[2] if isinstance(path[2], int) else model.index(path[2], "vary") for path in paths]
    return np.array([fields.index(str(path[1])) for path in paths]), np.array(joints)


@lru_cache(1)
def vectors_of(task: Task) -> Vectors | None:
    """What runs a task side by side, made once for it; None where series do not take its scene, or a key changes the run."""
    solver, kinds = task.scene.solver, {parsed(key)[0] for key in task.plan.keys}
    side_by_side = (
        takes(task.scene)
        and (solver.accuracy is None or solver.accuracy >= VECTOR.finest)
        and not kinds - {"model", "effects", "start"}
        and "start.time" not in task.plan.keys
    )
    made = Vectors(task) if side_by_side else None
    return made if made and made.series[0].covered else None
