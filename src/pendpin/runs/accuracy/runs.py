"""The runs of a search for a target accuracy, at samples close enough to compare them."""

from dataclasses import dataclass, field, replace

import numpy as np

from pendpin.engines import ProgressCallback
from pendpin.errors import Halted, RunError
from pendpin.ground.arrays import TINY, Array, Indices
from pendpin.model.build import Model
from pendpin.model.kinematics import chain_length, marks_at, tip_distance
from pendpin.runs.accuracy.thresholds import SAMPLE
from pendpin.runs.checkpoint import Shifts
from pendpin.runs.limits import Deadline
from pendpin.runs.preparation import Prepared
from pendpin.runs.run import ENERGY_ERROR, balanced, prepare, run_prepared
from pendpin.scene import Scene, fixed_methods
from pendpin.trajectory import RunRecord, samples_of

GOLDEN = (5**0.5 - 1) / 2


@dataclass(frozen=True, eq=False)
class Attempt:
    """A run, with the scene that gave it and its setting."""

    scene: Scene
    setting: float
    run: RunRecord


class Runs:
    """Runs of one scene, each at the same times; `seconds` of all of them together.

    `scene` names its method and engine, which are chosen once. `times` (n,) in s since the start are the output times and,
    where these are few, times between; at some of them, `places` (k,), runs are compared.
    """

    def __init__(self, prepared: Prepared, progress: ProgressCallback, deadline: Deadline) -> None:
        self._progress, self._deadline, self.seconds, self.scene = progress, deadline, 0.0, prepared.scene
        self._balanced = prepared.balance is not None
        self._prepared = {(self.scene.solver.method, self.scene.solver.engine): prepared}
        self.dynamics, self.start = prepared.bound, (prepared.q, prepared.v)
        self.every = choose_density(self.scene)
        self.times = sample_closely(self.scene, self.every).times
        self.places = choose_places(len(self.times))

    def ruler(self, run: RunRecord) -> "Ruler":
        """How the runs are compared, each as large as the first of them."""
        model = self.dynamics.model
        return Ruler(model, chain_length(model) or choose_length(model, run.tips), self.places)

    def prepare(self, scene: Scene) -> Prepared:
        """The scene with another solver or start, bound once for each method and engine."""
        key = scene.solver.method, scene.solver.engine
        if key not in self._prepared:
            self._prepared[key] = prepare(scene, self._balanced, self._deadline)
        return self._prepared[key].with_scene(scene)

    def run(
        self,
        scene: Scene,
        denser: int = 1,
        shifts: Shifts | None = None,
        longest: float = np.inf,
        whole: bool = False,
    ) -> RunRecord:
        """A run of a scene with a method and its setting; if too coarse, it may end early. `shifts` move its state.

        `longest` in s limits its steps. A `whole` run has its energy checked; others are only compared with each other.
        Raises RunError where it ends early for another reason.
        """
        if scene.solver.step is not None and scene.solver.step > longest:
            scene = scene.by(scene.solver.method, longest)
        prepared = self.prepare(sample_closely(scene, self.every * denser))
        options = {"shifts": shifts, "longest": longest, "pilot": not whole}
        try:
            run = run_prepared(prepared, self._progress, self._deadline, **options)
        except Halted as error:
            raise type(error)(str(error), self.keep_output_times(_thin_out(error.partial, denser))) from None
        except RunError as error:
            run, coarse = error.partial, scene.solver.method in fixed_methods()
            if not coarse and run.stats.stopped != ENERGY_ERROR:
                reason = f"with {run.stats.method}, {run.stats.setting}, {error}"
                message = f"accuracy {self.scene.solver.accuracy:g} is not met: {reason}"
                raise RunError(message, self.keep_output_times(_thin_out(run, denser))) from None
        self.seconds += run.stats.seconds
        return _thin_out(run, denser)

    def complete(self, attempt: Attempt) -> RunRecord:
        """The run of an attempt with all its samples; cut where its energies do not add up.

        Raises RunError or InputError where a sample cannot be computed.
        """
        try:
            good = attempt.run.sound == balanced(attempt.run) == len(self.times)
        except np.linalg.LinAlgError:
            good = False
        return attempt.run if good else self.run(attempt.scene, whole=True)

    def run_differently(self, scene: Scene, before: RunRecord) -> RunRecord:
        """A run that differs from the one before: with denser samples if the first try is equal to it."""
        run = self.run(scene)
        for doublings in range(SAMPLE.doublings):
            if not are_equal(before, run):
                break
            run = self.run(scene, 2 << doublings)
        return run

    def keep_output_times(self, run: RunRecord) -> RunRecord:
        """The run at the output times only."""
        output_times = self.scene.solver.model_dump(mode="json", include={"samples", "times"})
        scene = run.scene | {"solver": run.scene["solver"] | output_times}
        return replace(_thin_out(run, self.every), scene=scene)


def are_equal(one: RunRecord, other: RunRecord) -> bool:
    """Whether two runs have the same steps and results."""
    return one.stats.steps == other.stats.steps and np.array_equal(one.q, other.q) and np.array_equal(one.v, other.v)


def is_at_rest(run: RunRecord) -> bool:
    """Whether all rates and accelerations are 0."""
    return not (run.v.any() or run.a.any())


@dataclass(frozen=True, eq=False)
class Ruler:
    """How runs are compared: by the marks of a model (`kinematics.marks`) at some of their samples, over a length."""

    model: Model
    length: float  # m
    places: Indices  # (k,), of the samples
    _marks: dict[int, tuple[RunRecord, Array]] = field(default_factory=dict)  # of runs that were compared, by identity

    def measure_gap(self, one: RunRecord, other: RunRecord) -> Array:
        """The largest distance of marks so far, over the length, (k,); inf after the end of a run."""
        one_marks, other_marks = self.marks(one), self.marks(other)
        n = min(len(one_marks), len(other_marks))
        distance = tip_distance(one_marks[:n], other_marks[:n], self.length)
        return np.maximum.accumulate(np.append(distance, np.full(len(self.places) - n, np.inf)))

    def measure_extent(self, run: RunRecord) -> float:
        """The largest distance of a mark from its start, over the length."""
        return float(tip_distance(self.marks(run), self.marks(run)[:1], self.length).max())

    def measure_speeds(self, run: RunRecord) -> Array:
        """The largest speed of a mark so far, over the length, 1/s, (k,); inf after the end of the run."""
        some = self.places[self.places < len(run.t)]
        q, v, step = run.q[some], run.v[some], SAMPLE.step / max(np.abs(run.v).max(initial=0.0), TINY)
        after, before = (marks_at(self.model, q + x * v) for x in (step, -step))
        speeds = np.maximum.accumulate(tip_distance(after, before, self.length)) / (2 * step)
        return np.append(speeds, np.full(len(self.places) - len(some), np.inf))

    def marks(self, run: RunRecord) -> Array:
        """The marks of a run at the places that it reaches, (k or less, bodies, 3) m in W."""
        if id(run) not in self._marks:
            self._marks[id(run)] = run, marks_at(self.model, run.q[self.places[self.places < len(run.t)]])
        return self._marks[id(run)][1]


def choose_places(count: int) -> Indices:
    """Which of `count` samples are compared, (k,): all of a few, else about 100 with the first and the last.

    They are spread by the golden ratio, so that no period of a motion falls in with them.
    """
    if count <= SAMPLE.most:
        return np.arange(count)
    parts = np.arange(SAMPLE.most)
    spread = (parts + parts * GOLDEN % 1.0) * ((count - 1) / SAMPLE.most)
    return np.unique(np.append(spread.astype(int), [0, count - 1]))


def sample_closely(scene: Scene, every: int) -> Scene:
    """The scene with `every` intervals in place of each interval of output times."""
    if every == 1:
        return scene
    if scene.solver.times is None:
        new = {"samples": (len(scene.times) - 1) * every + 1}
    else:
        t = scene.clock
        between = t[:-1, None] + np.diff(t)[:, None] * np.arange(every) / every
        new = {"times": (*between.ravel().tolist(), float(t[-1]))}
    return scene.model_copy(update={"solver": scene.solver.model_copy(update=new)})


def choose_density(scene: Scene) -> int:
    """Into how many parts each interval of output times is cut, so that runs are compared at enough times."""
    every, intervals = 1, len(scene.times) - 1
    while 0 < every * intervals < SAMPLE.intervals:
        if not (np.diff(sample_closely(scene, 2 * every).clock) > 0).all():
            break  # times so close are no different doubles
        every *= 2
    return every


def choose_length(model: Model, tips: Array) -> float:
    """The length that errors are divided by, m: the largest possible distance of a tip from W's origin; else the actual."""
    return chain_length(model) or float(np.linalg.norm(tips, axis=-1).max()) or 1.0


def _thin_out(run: RunRecord, every: int) -> RunRecord:
    return run if every == 1 else samples_of(run, slice(None, None, every))
