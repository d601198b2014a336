"""Which methods a search for an accuracy runs with: the scene's or the cheapest, its settings, and others beside it."""

import numpy as np

from pendpin.dynamics.dynamics import bind
from pendpin.integrators import FEW_JOINTS, MAX_JOINTS, automatic, taylor_takes
from pendpin.model.build import build, start_state
from pendpin.scene import FIXED_METHODS, Scene
from pendpin.simulation.accuracy.refinement import LOOSEST, Refinement, by_step, by_tolerance
from pendpin.simulation.accuracy.runs import Runs

FINE = 1e-12  # accuracies below are for the Taylor integrator wherever it can


def refinement_of(scene: Scene, runs: Runs) -> Refinement:
    """The settings of the scene's method."""
    method, target = scene.solver.method, scene.solver.accuracy or 0.0
    if method not in FIXED_METHODS:
        q, _ = start_state(build(scene.model), scene.start)
        return by_tolerance(method, target, float(np.abs(q).max(initial=0.0)))
    if not scene.duration:
        return Refinement(method, 1.0, 0.0)
    return by_step(method, runs.times, runs.run(scene.by("dop853", LOOSEST)).stats.steps)


def with_method(scene: Scene, energy_balance: bool) -> Scene:
    """The scene with the cheapest method that can meet its target, and engine, where it names none."""
    solver, target = scene.solver, scene.solver.accuracy or 0.0
    dynamics = bind(scene)
    method, engine = automatic(scene, dynamics, *start_state(dynamics.model, scene.start), energy_balance)
    few = MAX_JOINTS if target < FINE else FEW_JOINTS  # the series are the surest, and cheap for few
    if solver.method == "auto" and method == "dop853" and taylor_takes(scene, dynamics, energy_balance, few):
        method, engine = "taylor", solver.engine
    return scene.model_copy(update={"solver": solver.replaced(method=method, engine=engine)})


def independent(scene: Scene) -> tuple[str, str]:
    """Two methods that can run a scene and see different things: implicit ones for stiff equations, else explicit ones."""
    free = scene.model_copy(update={"solver": scene.solver.replaced(method="auto")})
    dynamics = bind(free)
    method, _ = automatic(free, dynamics, *start_state(dynamics.model, scene.start))
    return ("radau", "bdf") if method == "radau" else ("dop853", "rk45")
