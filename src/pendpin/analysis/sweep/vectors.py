"""A sweep's cases side by side, in the processor's vectors: smooth scenes of few joints, by simulation/batches.py."""

from collections.abc import Sequence
from functools import partial
from importlib.util import find_spec
from threading import Lock

import numpy as np

from pendpin.analysis.sweep.measures import Measure, Motion, accumulated, measured
from pendpin.analysis.sweep.task import LOOSER, Task, typical, with_numbers
from pendpin.arrays import Array, Indices, Mask
from pendpin.errors import PendpinError
from pendpin.integrators import Run
from pendpin.keypaths import parsed
from pendpin.model.build import FARTHEST, Model, build, start_state
from pendpin.records import LARGEST
from pendpin.scene import Scene
from pendpin.simulation.accuracy.side_by_side import FINEST, Ladder
from pendpin.simulation.batches import WIDTH, Case, Motions, Series, ends_well
from pendpin.simulation.run import fill_in
from pendpin.trajectory import Trajectory
from pendpin.versions import installed

MOST_JOINTS = 10  # five rods compile in 2 s
Answer = tuple[Array, str]  # the measures (measures,), and why there are none


class Vectors:
    """A sweep whose cases go side by side."""

    def __init__(self, task: Task) -> None:
        scene = typical(task)
        wanted = any(m.name.startswith("flip_time") for m in task.chosen)
        sums = accumulated(build(scene.model).joints) if wanted else []
        if all(m.ends for m in task.chosen):
            few = {"times": tuple(scene.clock[[0, -1]].tolist())} if scene.solver.times else {"samples": 2}
            scene = scene.model_copy(update={"solver": scene.solver.model_copy(update=few)})
        self.task, self.scene, self.ladder = task, scene, None
        made = partial(Series, scene, flips=sums, other=_from_elsewhere(task, scene))
        if scene.solver.accuracy:
            self.ladder = Ladder(scene, made)
            self.series = self.ladder.series[::-1]
        else:
            fine = scene.solver.tolerance or 0.0
            self.series = [made(tolerance) for tolerance in ([fine, min(0.1, LOOSER * fine)] if task.two else [fine])]
        self._joints = _start_joints(task, self.series[0].dynamics.model)
        self._start = start_state(self.series[0].dynamics.model, scene.start)
        self._own_models = any(key.startswith("model") for key in task.plan.keys)
        self._clock = scene.clock

    def fill(self, rows: Array, answers: list[Answer | None]) -> None:
        """Put in the answers of the cases that go well; None is left for those that do not."""
        of_rows = [self._case(row) for row in rows] if self._joints is None else self._starts(rows, self._joints)
        cases = [(place, case) for place, case in enumerate(of_rows) if case is not None]
        for begin in range(0, len(cases), WIDTH):
            places, numbers = zip(*cases[begin : begin + WIDTH], strict=True)
            for place, answer in zip(places, self._answers(rows[list(places)], numbers), strict=True):
                answers[place] = answer

    def _case(self, row: Array) -> Case | None:
        """The case with these numbers (keys,); None for one that `simulate` has to look at."""
        try:
            return self.series[0].case(with_numbers(self.task.scene, self.task.plan.keys, row))
        except PendpinError:
            return None  # simulate says why

    def _starts(self, rows: Array, joints: tuple[Indices, Indices]) -> list[Case | None]:
        """The cases with these numbers (k, keys), which are angles and rates of the start; None as of `_case`."""
        states = np.tile(self._start, (len(rows), 1, 1))
        states[:, *joints] = rows
        good = np.all(np.abs(states) <= [[FARTHEST], [LARGEST]], axis=(1, 2)).tolist()
        return [self.series[0].started(*state) if ok else None for state, ok in zip(states, good, strict=True)]

    def _runs(self, cases: Sequence[Case]) -> tuple[list[Motions], Mask]:
        """The motions of the cases and, where two are compared, looser ones; which cases (c,) met the setting."""
        if self.ladder:
            *found, met = self.ladder.run(cases)
            return found, met
        return [series.run(cases, self.scene.times) for series in self.series], np.ones(len(cases), bool)

    def _answers(self, rows: Array, cases: Sequence[Case]) -> list[Answer | None]:
        """What the cases with these numbers (c, keys) give; None for one that has to be simulated on its own."""
        series, (found, good) = self.series[0], self._runs(cases)
        for one in found if self._own_models else found[1:]:
            good &= np.isfinite(one.q).all((1, 2)) & np.isfinite(one.v).all((1, 2))
        if not self._own_models:
            good &= ends_well(series.dynamics, found[0].q, found[0].v)
        models = [case.model for case in cases]
        motions = [Motion(models, self._clock, one.q, one.v, one.flips) for one in found]
        known = [_of_motions(m, motions) for m in self.task.chosen]
        missing = [k for k, values in enumerate(known) if values is None]
        table = np.array([np.full(len(cases), np.nan) if values is None else values for values in known]).T
        if not missing:
            return [(values, "") if ok else None for values, ok in zip(table, good.tolist(), strict=True)]
        return [self._completed(i, rows[i], table[i], missing, found) if ok else None for i, ok in enumerate(good)]

    def _completed(self, i: int, row: Array, values: Array, missing: list[int], found: list[Motions]) -> Answer:
        """The measures (measures,) of one case, with those that need whole runs."""
        try:
            runs = [self._whole(row, one, i) for one in found]
            for k in missing:
                values[k] = measured(self.task.chosen[k], runs[0], runs[-1])
        except PendpinError as error:
            return np.full(len(values), np.nan), str(error)
        return values, ""

    def _whole(self, row: Array, found: Motions, place: int) -> Trajectory:
        """The trajectory of a case, with forces and energies."""
        scene = with_numbers(self.scene, self.task.plan.keys, row).by("taylor", self.series[0].tolerance)
        dynamics = self.series[0].bound(scene)
        version = installed("heyoka")["heyoka"] or ""
        steps, none = int(found.steps[place]), np.zeros((len(scene.times), 0))
        run = Run(scene.times, found.q[place], found.v[place], None, none, steps, steps, 0, 0.0, "heyoka", version)
        return fill_in(scene, dynamics, None, run)


def _of_motions(m: Measure, motions: list[Motion]) -> Array | None:
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
    if (
        any(len(path) != 3 or path[0] != "start" or path[1] not in fields for path in paths)
        or task.scene.start.unit == "degrees"
    ):
        return None
    joints = [path[2] if isinstance(path[2], int) else model.index(path[2], "vary") for path in paths]
    return np.array([fields.index(str(path[1])) for path in paths]), np.array(joints)


def _from_elsewhere(task: Task, scene: Scene) -> Scene | None:
    """The scene with other numbers, by chance, where the start is varied."""
    keys = [key for key in task.plan.keys if key.startswith("start.")]
    try:
        return with_numbers(scene, keys, np.random.default_rng(0).uniform(0.1, 1.0, len(keys)))
    except PendpinError:
        return None


_VECTORS: dict[str, Vectors | None] = {}
_LOCK = Lock()


def vectors_of(task: Task) -> Vectors | None:
    """What runs the task in vectors, made once in a process; None where that cannot be."""
    name = f"{task.plan.identity} {[m.name for m in task.chosen]} {task.scene.model_dump_json()}"
    with _LOCK:
        if name not in _VECTORS:
            _VECTORS.clear()
            _VECTORS[name] = _made(task)
        return _VECTORS[name]


def _made(task: Task) -> Vectors | None:
    """None for a scene that series do not take, or a key that changes how it is run."""
    solver, kinds = task.scene.solver, {parsed(key)[0] for key in task.plan.keys}
    if find_spec("heyoka") is None or solver.method not in ("auto", "taylor"):
        return None
    if solver.accuracy is not None and not (solver.accuracy >= FINEST and task.scene.duration):
        return None
    if kinds - {"model", "effects", "start"} or "start.time" in task.plan.keys:
        return None
    smooth = all(effect.smooth for effect in task.scene.effects)
    if not smooth or len(build(task.scene.model).joints) > MOST_JOINTS or solver.engine != "auto":
        return None
    made = Vectors(task)
    return made if made.series[0].covered else None
