"""From a scene's solver to its lane."""

from pendpin.dynamics import Dynamics
from pendpin.errors import InputError, choices
from pendpin.scene import Scene
from pendpin.solvers.adaptive import NAMES, Adaptive
from pendpin.solvers.base import Lane
from pendpin.solvers.fixed import RungeKutta4, SemiImplicitEuler, refuse_steps
from pendpin.solvers.gauss import STAGES, Gauss
from pendpin.solvers.taylor import Taylor


def lane_for(scene: Scene, dynamics: Dynamics) -> Lane:
    """The lane of a scene's method, with its setting. Raises InputError for what that lane does not take."""
    solver = scene.solver
    method, step = solver.method, solver.step
    if dynamics.contacts is not None and method not in NAMES:
        raise InputError(f"solver.method: {method} takes no stops and no dry friction; these do: {choices(NAMES)}")
    if step is not None:
        refuse_steps(scene.times, step)
        if method in STAGES:
            return Gauss(method, step)
        return RungeKutta4(step) if method == "rk4" else SemiImplicitEuler(step)
    assert solver.tolerance is not None
    if method == "taylor":
        return Taylor(scene.effects, solver.tolerance)
    return Adaptive(method, solver.tolerance)
