"""Which methods a search for an accuracy runs with, and others beside it; the settings of each from coarse to fine."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pendpin.dynamics.timing import timing
from pendpin.errors import RunError
from pendpin.ground.arrays import Array
from pendpin.integrators import FEW_JOINTS, MAX_JOINTS, automatic, taylor_takes
from pendpin.runs.accuracy.runs import Runs
from pendpin.runs.accuracy.thresholds import SETTING
from pendpin.runs.preparation import Prepared
from pendpin.scene import Scene, fixed_methods, method_of
from pendpin.trajectory import RunRecord

TAYLOR, HIGH_ORDER = "taylor", "dop853"
UNITS = (("days", 86_400.0), ("hours", 3_600.0), ("minutes", 60.0))  # s


@dataclass(frozen=True)
class Refinement:
    """The settings of one method, a tolerance or a step; errors should fall with their power `order`.

    A step is a whole fraction of `spacing`, the longest time between samples, so that the steps taken equal the setting
    and different settings give different runs.
    """

    method: str
    first: float  # the coarsest setting
    least: float  # the finest there is; 0 for steps, which end at `most_steps`
    order: float = 1.0
    usual: float = 100.0  # how much smaller the next error should be, without an estimate
    smallest: float = 10.0  # the least such factor: with a smaller one two runs may be equal
    pace: float = 0.85  # the power of the promised factor by which errors fall at least
    scatter: float = 1.5  # the largest factor between two errors and their power law
    spacing: float | None = None  # s, of steps

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
        """How much smaller the error of the finer setting should be, with so many times `more` steps.

        A tolerance that does not change the steps, as where a fast effect bounds them, promises nothing.
        """
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
    """The tolerances of an adaptive method, which are relative to angles of up to `turned` rad.

    The error of a power series jumps with its order, from 5 to 1000 a hundredth.
    """
    least, scatter = method_of(method).least_tolerance, method_of(method).scatter
    large = 10.0 ** math.floor(math.log10(max(turned, 1.0)))
    coarser = SETTING.first_tolerance_of_series if method == TAYLOR else SETTING.first_tolerance
    first = max(min(coarser * accuracy, SETTING.loosest) / large, SETTING.room * least)
    if method == TAYLOR:
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
    """The settings of the scene's method."""
    method, target = scene.solver.method, scene.solver.accuracy or 0.0
    if method not in fixed_methods():
        return refine_by_tolerance(method, target, float(np.abs(runs.start[0]).max(initial=0.0)))
    if not scene.duration:
        return Refinement(method, 1.0, 0.0)
    run = runs.run(scene.by("dop853", SETTING.loosest))
    return refine_by_step(method, runs.times, max(run.stats.steps, _count_steps_of_pace(scene, runs, run)))


def _count_steps_of_pace(scene: Scene, runs: Runs, run: RunRecord) -> int:
    """How many equal steps do not jump over what acts in a scene. Raises RunError for too many; the run is a partial one."""
    pace_of_run = timing(runs.dynamics, runs.dynamics.effects, *runs.start, scene.duration, None)
    needed = scene.duration / float(pace_of_run.pace.shortest.min())
    if needed * method_of(scene.solver.method).step_price <= SETTING.most_steps:
        return math.ceil(needed)
    name, shortest = min(pace_of_run.fastest, key=lambda one: one[1])
    raise RunError(
        f"accuracy {scene.solver.accuracy:g} is not met: {name} changes within {shortest:.3g} s, and "
        f"{scene.solver.method} needs {needed:.0e} equal steps to resolve it; use a method with a tolerance, such as dop853",
        runs.keep_output_times(run),
    )


def choose_method(scene: Scene, prepared: Prepared) -> Prepared:
    """A prepared scene, by the series where it names no method and they take it: they are the surest, and cheap for few."""
    few = MAX_JOINTS if (scene.solver.accuracy or 0.0) < SETTING.for_series else FEW_JOINTS
    free = scene.solver.method == "auto" and prepared.scene.solver.method == HIGH_ORDER
    if free and taylor_takes(scene, prepared.bound, prepared.balance is not None, few):
        return prepared.with_scene(scene.with_solver(method=TAYLOR))
    return prepared


def choose_independent(runs: Runs) -> tuple[str, str]:
    """Two methods that can run a scene and see different things: implicit ones for stiff equations, else explicit ones."""
    free = runs.scene.with_solver(method="auto", engine="auto")
    method, _ = automatic(free, runs.dynamics, *runs.start)
    return ("radau", "bdf") if method == "radau" else ("dop853", "rk45")


def list_alternatives(scene: Scene, runs: Runs) -> Iterator[Scene]:
    """The scene with methods that were not tried, where it names none."""
    if scene.solver.method == "auto":
        for method in choose_independent(runs):
            if method != runs.scene.solver.method:
                yield scene.with_solver(method=method)
