"""The runs of a search for a target accuracy, at samples close enough to compare them."""

from dataclasses import dataclass, replace

import numpy as np

from pendpin.engines import ProgressCallback
from pendpin.errors import Halted, RunError
from pendpin.ground.arrays import Array
from pendpin.model.build import Model, build
from pendpin.model.kinematics import chain_length, marks, marks_at, tip_distance
from pendpin.runs.accuracy.thresholds import SAMPLE
from pendpin.runs.limits import Deadline
from pendpin.runs.preparation import Prepared
from pendpin.runs.run import ENERGY_ERROR, prepare, run_prepared
from pendpin.runs.state import Shifts
from pendpin.scene import FIXED_METHODS, Scene, scene_of
from pendpin.trajectory import RunRecord, samples_of


@dataclass(frozen=True, eq=False)
class Attempt:
    """A run, with the scene that gave it and its setting."""

    scene: Scene
    setting: float
    run: RunRecord


class Runs:
    """Runs of one scene, each at the same times; `seconds` of all of them together."""

    def __init__(self, scene: Scene, energy_balance: bool, progress: ProgressCallback, deadline: Deadline) -> None:
        self._energy_balance, self._progress, self._deadline, self.seconds = energy_balance, progress, deadline, 0.0
        self._prepared = dict[tuple[str, str], Prepared]()
        self.scene, self.every = scene, 1
        intervals = len(scene.times) - 1
        while 0 < self.every * intervals < SAMPLE.intervals:
            if not (np.diff(_sample_closely(scene, 2 * self.every).clock) > 0).all():
                break  # times so close are no different doubles
            self.every *= 2

    @property
    def times(self) -> Array:
        """When runs are compared, (n,) in s since the start: the output times and, where these are few, times between."""
        return _sample_closely(self.scene, self.every).times

    def prepare(self, scene: Scene) -> Prepared:
        """The scene with another solver or start, bound once for each method and engine."""
        key = scene.solver.method, scene.solver.engine
        if key in self._prepared:
            return self._prepared[key].with_scene(scene)
        self._prepared[key] = prepare(scene, self._energy_balance, self._deadline)
        return self._prepared[key]

    def run(self, scene: Scene, denser: int = 1, shifts: Shifts | None = None, longest: float = np.inf) -> RunRecord:
        """A run of a scene with a method and its setting; if too coarse, it may end early. `shifts` move its state.

        `longest` in s limits its steps. Raises RunError where it ends early for another reason.
        """
        if scene.solver.step is not None and scene.solver.step > longest:
            scene = scene.by(scene.solver.method, longest)
        close = _sample_closely(scene, self.every * denser)
        try:
            run = run_prepared(self.prepare(close), self._progress, self._deadline, shifts=shifts, longest=longest)
        except Halted as error:
            raise type(error)(str(error), self.keep_output_times(_thin_out(error.partial, denser))) from None
        except RunError as error:
            run, coarse = error.partial, scene.solver.method in FIXED_METHODS
            if not coarse and run.stats.stopped != ENERGY_ERROR:
                reason = f"with {run.stats.method}, {run.stats.setting}, {error}"
                message = f"accuracy {self.scene.solver.accuracy:g} is not met: {reason}"
                raise RunError(message, self.keep_output_times(_thin_out(run, denser))) from None
        self.seconds += run.stats.seconds
        return _thin_out(run, denser)

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


def compute_points(run: RunRecord) -> Array:
    """The points by which runs are compared, (n, bodies, 3) m in W: see `kinematics.marks`."""
    if run.scene["model"]["kind"] == "chain":
        return run.tips
    return marks(build(scene_of(run).model), run.tips, run.q)


def measure_gap(one: RunRecord, other: RunRecord, length: float, count: int) -> Array:
    """The largest distance of tips so far, over a length, at each of `count` times; inf after the end of a run."""
    n = min(len(one.t), len(other.t))
    distance = tip_distance(compute_points(one)[:n], compute_points(other)[:n], length)
    return np.maximum.accumulate(np.append(distance, np.full(count - n, np.inf)))


def _sample_closely(scene: Scene, every: int) -> Scene:
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


def compute_speeds(run: RunRecord, length: float) -> Array:
    """The largest speed of a tip so far (n,), over a length, 1/s."""
    model, rates = build(scene_of(run).model), np.abs(run.v).max(initial=0.0)
    if not rates:
        return np.zeros(len(run.t))
    after, before = (marks_at(model, run.q + x * run.v) for x in (SAMPLE.step / rates, -SAMPLE.step / rates))
    return np.maximum.accumulate(tip_distance(after, before, length)) * rates / (2 * SAMPLE.step)


def compute_extent(run: RunRecord, length: float) -> float:
    """The largest distance of a tip from its start, over a length."""
    return float(tip_distance(compute_points(run), compute_points(run)[:1], length).max())


def choose_length(model: Model, tips: Array) -> float:
    """The length that errors are divided by, m: the largest possible distance of a tip from W's origin; else the actual."""
    return chain_length(model) or float(np.linalg.norm(tips, axis=-1).max()) or 1.0


def _thin_out(run: RunRecord, every: int) -> RunRecord:
    return run if every == 1 else samples_of(run, slice(None, None, every))
