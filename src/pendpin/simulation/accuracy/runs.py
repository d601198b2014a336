"""The runs of a search for a target accuracy, at samples close enough to compare them."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pendpin.arrays import Array
from pendpin.engines import ProgressCallback
from pendpin.errors import Halted, RunError
from pendpin.model.build import Model, build
from pendpin.model.kinematics import chain_length, marks, tip_distance
from pendpin.scene import FIXED_METHODS, Scene, UrdfModel
from pendpin.simulation.checkpoint import RunState
from pendpin.simulation.limits import Deadline
from pendpin.simulation.run import ENERGY_ERROR, run_scene
from pendpin.trajectory import Trajectory, samples_of

Between = Callable[[RunState], RunState]

INTERVALS = 64  # at least, between times at which runs are compared
MOST_DENSER = 3  # times that samples are doubled for a run that differs


@dataclass(frozen=True, eq=False)
class Attempt:
    """A run, with the scene that gave it and its setting."""

    scene: Scene
    setting: float
    run: Trajectory


class Runs:
    """Runs of one scene, each at the same times; `seconds` of all of them together."""

    def __init__(self, scene: Scene, energy_balance: bool, progress: ProgressCallback, deadline: Deadline) -> None:
        self._options, self.seconds = (energy_balance, progress, deadline), 0.0
        self.scene, self.every = scene, 1
        intervals = len(scene.times) - 1
        while 0 < self.every * intervals < INTERVALS and _apart(_with_samples(scene, 2 * self.every)):
            self.every *= 2

    @property
    def times(self) -> Array:
        """When runs are compared, (n,) in s since the start: the output times and, where these are few, times between."""
        return _with_samples(self.scene, self.every).times

    def run(self, scene: Scene, denser: int = 1, between: Between | None = None) -> Trajectory:
        """A run of a scene with a method and its setting; if too coarse, it may end early. `between`: as in the loop."""
        try:
            found = run_scene(_with_samples(scene, self.every * denser), *self._options, between=between)
        except Halted as error:
            raise type(error)(str(error), self.at_output_times(_thinned(error.partial, denser))) from None
        except RunError as error:
            found, coarse = error.partial, scene.solver.method in FIXED_METHODS
            if not coarse and found.stats.stopped != ENERGY_ERROR:
                raise self._failed(found, denser, str(error)) from None
        self.seconds += found.stats.seconds
        return _thinned(found, denser)

    def _failed(self, run: Trajectory, denser: int, why: str) -> RunError:
        """The error of a search in which a run ends early for another reason than that it is coarse."""
        target, stats = self.scene.solver.accuracy, run.stats
        message = f"accuracy {target:g} is not met: with {stats.method}, {stats.setting}, {why}"
        return RunError(message, self.at_output_times(_thinned(run, denser)))

    def unlike(self, scene: Scene, before: Trajectory) -> Trajectory:
        """A run that differs from the one before: with denser samples if the first try is equal to it."""
        found = self.run(scene)
        for doublings in range(MOST_DENSER):
            if not alike(before, found):
                break
            found = self.run(scene, 2 << doublings)
        return found

    def at_output_times(self, run: Trajectory) -> Trajectory:
        """The run at the output times only."""
        own = self.scene.solver.model_dump(mode="json", include={"samples", "times"})
        scene = run.scene | {"solver": run.scene["solver"] | own}
        return replace(_thinned(run, self.every), scene=scene)


def alike(one: Trajectory, other: Trajectory) -> bool:
    """Whether two runs have the same steps and results."""
    return one.stats.steps == other.stats.steps and np.array_equal(one.q, other.q) and np.array_equal(one.v, other.v)


def at_rest(run: Trajectory) -> bool:
    """Whether all rates and accelerations are 0."""
    return not (run.v.any() or run.a.any())


def points(run: Trajectory) -> Array:
    """The points by which runs are compared, (n, bodies, 3) m in W: see `kinematics.marks`."""
    model = run.scene["model"]
    if model["kind"] == "chain":
        return run.tips()
    return marks(build(run.source.model if run.source else UrdfModel(**model)), run.tips(), run.q)


def gap(one: Trajectory, other: Trajectory, length: float, count: int) -> Array:
    """The largest distance of tips so far, over a length, at each of `count` times; inf after the end of a run."""
    n = min(len(one.t), len(other.t))
    distance = tip_distance(points(one)[:n], points(other)[:n], length)
    return np.maximum.accumulate(np.append(distance, np.full(count - n, np.inf)))


def _with_samples(scene: Scene, every: int) -> Scene:
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


def extent(run: Trajectory, length: float) -> float:
    """The largest distance of a tip from its start, over a length."""
    return float(tip_distance(points(run), points(run)[:1], length).max())


def length_of(model: Model, run: Trajectory) -> float:
    """The length that errors are divided by, m: the largest possible distance of a tip from W's origin; else the actual."""
    return chain_length(model) or float(np.linalg.norm(run.tips(), axis=-1).max()) or 1.0


def _apart(scene: Scene) -> bool:
    """Whether all samples have different times as doubles."""
    return bool((np.diff(scene.clock) > 0).all())


def _thinned(run: Trajectory, every: int) -> Trajectory:
    return run if every == 1 else samples_of(run, slice(None, None, every))
