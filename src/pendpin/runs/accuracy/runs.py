"""The runs of a search for a target accuracy: their settings from coarse to fine, and how they are compared."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from pendpin.dynamics.pace import paces_of
from pendpin.engines import ProgressCallback
from pendpin.errors import Halted, RunError
from pendpin.ground.arrays import TINY, Array, Indices, subdivided
from pendpin.integrators import FEW_JOINTS, MAX_JOINTS, choose_method_and_engine, taylor_takes
from pendpin.model.build import Model
from pendpin.model.kinematics import chain_length, marks_at, tip_distance
from pendpin.runs.accuracy.thresholds import SAMPLE, SETTING
from pendpin.runs.checkpoint import Shifts
from pendpin.runs.limits import Deadline
from pendpin.runs.preparation import Prepared
from pendpin.runs.run import ENERGY_ERROR, prepare, run_prepared
from pendpin.scene import Scene, fixed_methods, method_of
from pendpin.trajectory import RunRecord, samples_of

TAYLOR, HIGH_ORDER = "taylor", "dop853"
UNITS = (("days", 86_400.0), ("hours", 3_600.0), ("minutes", 60.0))  # s


@dataclass(frozen=True, eq=False)
class Attempt:
    """A run, with the scene that gave it, its setting, and its distance from the attempt before."""

    scene: Scene
    setting: float
    run: RunRecord
    gap: Array = field(default_factory=lambda: np.full(1, np.inf))  # (k,), the largest so far, over the length


class Runs:
    """Runs of one scene at `times` (n,) in s since the start: output times and, where these are few, times between.

    At some of them, `places` (k,), runs are compared. `scene` names its method and engine, which are chosen once.
    """

    def __init__(self, prepared: Prepared, progress: ProgressCallback, deadline: Deadline) -> None:
        self._progress, self._deadline, self.scene = progress, deadline, prepared.scene
        self.seconds = 0.0  # of all runs together
        self._balanced = prepared.balance is not None
        self._prepared = {(self.scene.solver.method, self.scene.solver.engine): prepared}  # bound once for each
        self.dynamics, self.start = prepared.bound, (prepared.q, prepared.v)
        self.every = choose_density(self.scene)
        self.times = sample_closely(self.scene, self.every).times
        self.places = choose_places(len(self.times))

    def ruler(self, run: RunRecord) -> "Ruler":
        """How the runs are compared, each as large as the first of them."""
        model = self.dynamics.model
        return Ruler(model, chain_length(model) or choose_length(model, run.tips), self.places)

    def run(
        self, scene: Scene, denser: int = 1, shifts: Shifts | None = None, longest: float = np.inf, whole: bool = False
    ) -> RunRecord:
        """A run with steps up to `longest` s; it may end early if it is too coarse. `whole`: its energy counts. RunError."""
        if scene.solver.step is not None and scene.solver.step > longest:
            scene = scene.by(scene.solver.method, longest)
        scene = sample_closely(scene, self.every * denser)
        key, options = (scene.solver.method, scene.solver.engine), {"shifts": shifts, "longest": longest}
        if key not in self._prepared:
            self._prepared[key] = prepare(scene, self._balanced, self._deadline)
        prepared = self._prepared[key].with_scene(scene)
        try:
            run = run_prepared(prepared, self._progress, self._deadline, **options, pilot=not whole)
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

    def run_differently(self, scene: Scene, before: RunRecord) -> RunRecord:
        """A run that differs from the one before: with denser samples if the first try is equal to it."""
        run = self.run(scene)
        for doublings in range(SAMPLE.doublings):
            if not are_equal(before, run):
                break
            run = self.run(scene, 2 << doublings)
        return run

    def keep_output_times(self, run: RunRecord) -> RunRecord:
        """A run at the output times alone, with a scene that says so."""
        solver = self.scene.solver
        scene = run.source.sampled(solver.samples, solver.times)
        return replace(_thin_out(run, self.every), scene=scene.recorded(), source=scene)


def are_equal(one: RunRecord, other: RunRecord) -> bool:
    """Whether two runs took as many steps to the same states."""
    return one.stats.steps == other.stats.steps and np.array_equal(one.q, other.q) and np.array_equal(one.v, other.v)


def is_at_rest(run: RunRecord) -> bool:
    """Whether nothing moves or accelerates at any sample."""
    return not (run.v.any() or run.a.any())


@dataclass(frozen=True, eq=False)
class Ruler:
    """How runs are compared: by the marks of a model (`kinematics.marks`) at some of their samples, over a length."""

    model: Model
    length: float  # m
    places: Indices  # (k,), of the samples

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
        step = SAMPLE.step / max(np.abs(run.v).max(initial=0.0), TINY)
        ahead = marks_at(self.model, run.q[some] + step * run.v[some])
        speeds = np.maximum.accumulate(tip_distance(ahead, self.marks(run), self.length)) / step
        return np.append(speeds, np.full(len(self.places) - len(some), np.inf))

    def marks(self, run: RunRecord) -> Array:
        """The marks of a run at the places that it reaches, (k or less, bodies, 3) m in W."""
        return marks_at(self.model, run.q[self.places[self.places < len(run.t)]])


def choose_places(count: int) -> Indices:
    """Which of `count` samples are compared, (k,): all of a few, else about 100 with the first and the last."""
    if count <= SAMPLE.most:
        return np.arange(count)
    parts, golden = np.arange(SAMPLE.most), (5**0.5 - 1) / 2  # by whose ratio no period of a motion falls in with them
    spread = (parts + parts * golden % 1.0) * ((count - 1) / SAMPLE.most)
    return np.unique(np.append(spread.astype(int), [0, count - 1]))


def sample_closely(scene: Scene, every: int) -> Scene:
    """The scene with `every` intervals in place of each interval of output times."""
    if every == 1:
        return scene
    if scene.solver.times is None:
        return scene.sampled((len(scene.times) - 1) * every + 1)
    return scene.sampled(None, tuple(subdivided(scene.clock, every).tolist()))


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


# --- the methods, and their settings from coarse to fine -------------------------------------------------------------


@dataclass(frozen=True)
class Refinement:
    """The settings of one method, a tolerance or a step; errors should fall with their power `order`."""

    method: str
    first: float  # the coarsest setting
    least: float  # the finest there is; 0 for steps, which end at `most_steps`
    order: float = 1.0
    usual: float = 100.0  # how much smaller the next error should be, without an estimate
    smallest: float = 10.0  # the least such factor: with a smaller one two runs may be equal
    pace: float = 0.85  # the power of the promised factor by which errors fall at least
    scatter: float = 1.5  # the largest factor between two errors and their power law
    # s, of steps: the longest time between samples, which they divide, so that different settings give different runs
    spacing: float | None = None

    def finer(self, setting: float, factor: float) -> float:
        """The setting with an error smaller by about `factor`, or half way to the least where that is too small."""
        if self.method == TAYLOR:  # compiled series are kept: few different ones
            factor = self.smallest ** math.ceil(math.log(max(factor, 1.0), self.smallest) * SETTING.whole)
        ratio = max(factor, self.smallest) ** (1 / self.order)
        if self.spacing is not None:
            count = round(self.spacing / setting)
            return self.spacing / max(count + 1, math.ceil(count * ratio * SETTING.whole))
        if setting / ratio >= self.least * self.smallest:
            return setting / ratio
        middle = math.sqrt(setting * self.least)
        return middle if middle >= self.least * self.smallest**2 else self.least

    def predict_fall(self, coarse: float, fine: float, more: float = math.inf) -> float:
        """How much smaller the error of the finer setting should be, with so many times `more` steps."""
        # A tolerance that does not change the steps, as where a fast effect bounds them, promises nothing.
        factor = (coarse / fine) ** self.order
        steepest = method_of(self.method).steepest
        return min(factor, more**steepest) if steepest < math.inf else factor

    def describe_too_many(self, steps: float, seconds: float) -> str:
        """What is said of a run of more than `most_steps`."""
        order = f" is of order {self.order:g} and" if self.spacing else ""
        unit, size = next((unit for unit in UNITS if seconds > 2 * unit[1]), ("s", 1.0))
        higher = "" if self.method in (HIGH_ORDER, TAYLOR) else f"; take a method of higher order, such as {HIGH_ORDER}"
        return f"{self.method}{order} would take about {steps:.0e} steps, about {seconds / size:.0f} {unit}{higher}"


def refine_by_tolerance(method: str, accuracy: float, turned: float = 1.0) -> Refinement:
    """The tolerances of an adaptive method, which are relative to angles of up to `turned` rad."""
    least, scatter = method_of(method).least_tolerance, method_of(method).scatter
    large = 10.0 ** math.floor(math.log10(max(turned, 1.0)))
    coarser = SETTING.first_tolerance_of_series if method == TAYLOR else SETTING.first_tolerance
    first = max(min(coarser * accuracy, SETTING.loosest) / large, SETTING.room * least)
    if method == TAYLOR:  # the error of a power series jumps with its order, from 5 to 1000 a hundredth
        return Refinement(method, first, least, smallest=100.0, pace=0.5, scatter=scatter)
    return Refinement(method, first, least, pace=0.7, scatter=scatter)


def refine_by_step(method: str, times: Array, count: int) -> Refinement:
    """The steps of a method with fixed ones over output times (n,) in s; the first takes about `count` steps in all."""
    spacing = float(np.diff(times).max())
    first = spacing / max(1, math.ceil(count * spacing / float(times[-1] - times[0])))
    order = method_of(method).order
    assert order is not None
    return Refinement(method, first, 0.0, order, usual=30.0, smallest=4.0, spacing=spacing)


def choose_refinement(scene: Scene, runs: Runs) -> Refinement:
    """The settings of the scene's method. Raises RunError where steps that do not jump over an effect are too many."""
    method, target = scene.solver.method, scene.solver.accuracy or 0.0
    if method not in fixed_methods():
        return refine_by_tolerance(method, target, float(np.abs(runs.start[0]).max(initial=0.0)))
    if not scene.duration:
        return Refinement(method, 1.0, 0.0)
    run = runs.run(scene.by("dop853", SETTING.loosest))
    pace_of_run = paces_of(runs.dynamics, runs.dynamics.effects, *runs.start, scene.duration, None)
    needed = scene.duration / float(pace_of_run.pace.shortest.min())  # equal steps: none jumps over what acts
    if needed * method_of(method).step_price > SETTING.most_steps:
        name, shortest = min(pace_of_run.fastest, key=lambda one: one[1])
        why = f"{name} changes within {shortest:.3g} s, and {method} needs {needed:.0e} equal steps to resolve it"
        remedy = "use a method with a tolerance, such as dop853"
        raise RunError(f"accuracy {target:g} is not met: {why}; {remedy}", runs.keep_output_times(run))
    return refine_by_step(method, runs.times, max(run.stats.steps, math.ceil(needed)))


def choose_method(scene: Scene, prepared: Prepared) -> Prepared:
    """A prepared scene, by the series where it names no method and they take it: they are the surest, and cheap for few."""
    few = MAX_JOINTS if (scene.solver.accuracy or 0.0) < SETTING.for_series else FEW_JOINTS
    free = scene.solver.method == "auto" and prepared.scene.solver.method == HIGH_ORDER
    if free and prepared.balance is None and taylor_takes(scene, prepared.bound.model, few):
        return prepared.with_scene(scene.with_solver(method=TAYLOR))
    return prepared


def choose_other_methods(runs: Runs, method: str) -> list[str]:
    """Methods that run a scene and err in other ways: implicit ones for stiff equations, else explicit ones."""
    free = runs.scene.with_solver(method="auto", engine="auto")
    stiff = choose_method_and_engine(free, runs.dynamics, *runs.start)[0] == "radau"
    return [other for other in (("radau", "bdf") if stiff else ("dop853", "rk45")) if other != method]


def list_alternatives(scene: Scene, runs: Runs) -> list[Scene]:
    """The scene with methods that were not tried, where it names none."""
    others = choose_other_methods(runs, runs.scene.solver.method) if scene.solver.method == "auto" else []
    return [scene.with_solver(method=method) for method in others]
