"""Which methods a search for an accuracy runs with: the scene's or the cheapest, its settings, and others beside it."""

import math
from collections.abc import Iterator

import numpy as np

from pendpin.dynamics.dynamics import bind
from pendpin.dynamics.timing import timing
from pendpin.errors import RunError
from pendpin.integrators import FEW_JOINTS, MAX_JOINTS, automatic, taylor_takes
from pendpin.model.build import build, start_state
from pendpin.scene import FIXED_METHODS, Scene, method_of
from pendpin.simulation.accuracy.refinement import Refinement, refine_by_step, refine_by_tolerance
from pendpin.simulation.accuracy.runs import Runs
from pendpin.simulation.accuracy.thresholds import SETTING
from pendpin.trajectory import Trajectory


def choose_refinement(scene: Scene, runs: Runs) -> Refinement:
    """The settings of the scene's method."""
    method, target = scene.solver.method, scene.solver.accuracy or 0.0
    if method not in FIXED_METHODS:
        q, _ = start_state(build(scene.model), scene.start)
        return refine_by_tolerance(method, target, float(np.abs(q).max(initial=0.0)))
    if not scene.duration:
        return Refinement(method, 1.0, 0.0)
    run = runs.run(scene.by("dop853", SETTING.loosest))
    return refine_by_step(method, runs.times, max(run.stats.steps, _count_steps_of_pace(scene, runs, run)))


def _count_steps_of_pace(scene: Scene, runs: Runs, run: Trajectory) -> int:
    """How many equal steps do not jump over what acts in a scene. Raises RunError for too many; the run is a partial one."""
    dynamics = runs.bind(scene)
    pace_of_run = timing(dynamics, dynamics.effects, *start_state(dynamics.model, scene.start), scene.duration, None)
    needed = scene.duration / float(pace_of_run.pace.shortest.min())
    if needed * method_of(scene.solver.method).step_price <= SETTING.most_steps:
        return math.ceil(needed)
    name, shortest = min(pace_of_run.fastest, key=lambda one: one[1])
    raise RunError(
        f"accuracy {scene.solver.accuracy:g} is not met: {name} changes within {shortest:.3g} s, and "
        f"{scene.solver.method} needs {needed:.0e} equal steps to resolve it; use a method with a tolerance, such as dop853",
        runs.keep_output_times(run),
    )


def choose_method(scene: Scene, energy_balance: bool) -> Scene:
    """The scene with the cheapest method that can meet its target, and engine, where it names none."""
    solver, target = scene.solver, scene.solver.accuracy or 0.0
    dynamics = bind(scene)
    method, engine = automatic(scene, dynamics, *start_state(dynamics.model, scene.start), energy_balance)
    few = MAX_JOINTS if target < SETTING.for_series else FEW_JOINTS  # the series are the surest, and cheap for few
    if solver.method == "auto" and method == "dop853" and taylor_takes(scene, dynamics, energy_balance, few):
        method, engine = "taylor", solver.engine
    return scene.model_copy(update={"solver": solver.replaced(method=method, engine=engine)})


def choose_independent(scene: Scene) -> tuple[str, str]:
    """Two methods that can run a scene and see different things: implicit ones for stiff equations, else explicit ones."""
    free = scene.model_copy(update={"solver": scene.solver.replaced(method="auto")})
    dynamics = bind(free)
    method, _ = automatic(free, dynamics, *start_state(dynamics.model, scene.start))
    return ("radau", "bdf") if method == "radau" else ("dop853", "rk45")


def list_alternatives(scene: Scene, energy_balance: bool, tried: str) -> Iterator[Scene]:
    """The scene with methods that were not tried, where it names none."""
    if scene.solver.method == "auto":
        for method in choose_independent(scene):
            if method != tried:
                yield choose_method(scene.with_solver(method=method), energy_balance)
