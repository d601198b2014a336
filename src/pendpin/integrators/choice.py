"""From a scene's solver to its integrator."""

from importlib.util import find_spec
from typing import Literal

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import Compiled
from pendpin.errors import InputError, choices
from pendpin.integrators import machine
from pendpin.integrators.adaptive import NAMES, Adaptive
from pendpin.integrators.base import Integrator
from pendpin.integrators.fixed import RungeKutta4, SemiImplicitEuler, refuse_steps
from pendpin.integrators.gauss import STAGES, Gauss
from pendpin.integrators.taylor import Taylor
from pendpin.scene import AdaptiveMethod, Scene

LARGE = 100  # numbers in a state, above which no Jacobian is computed
STIFF = 3e5  # decay rate times duration, above which explicit steps are too many (about 6 of it to a step of dop853)
LONG = (
    1e5  # rad that the fastest motion goes through: beyond, the Taylor integrator is ten times as fast and keeps more
)
FEW_JOINTS = 4  # up to which it is
OVERDAMPED = 0.5  # decay over the fastest rate: a motion that swings as fast as it decays needs small steps anyway


def integrator_for(scene: Scene, dynamics: Dynamics, energy_balance: bool = False) -> Integrator:
    """The integrator of a scene's method, with its setting.

    With an energy balance the work is integrated together with the motion, in Python. Raises InputError for a scene that
    the method cannot run.
    """
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
        return Taylor(scene.effects, solver.tolerance, scene.start.time)
    if isinstance(dynamics.engine, Compiled) and not energy_balance and machine.available():
        return machine.AdaptiveInMachineCode(method, solver.tolerance)
    return Adaptive(method, solver.tolerance)


def taylor_takes(scene: Scene, dynamics: Dynamics, energy_balance: bool, most: int = FEW_JOINTS) -> bool:
    """Whether the Taylor integrator is installed and can run the scene, with at most `most` joints."""
    few = len(dynamics.model.joints) <= most and all(effect.smooth for effect in scene.effects)
    return few and scene.solver.engine == "auto" and not energy_balance and find_spec("heyoka") is not None


def automatic(
    dynamics: Dynamics, q: Array, v: Array, duration: float, taylor: bool = False
) -> AdaptiveMethod | Literal["taylor"]:
    """The method for "auto": dop853, or radau if something decays too fast for explicit steps. q, v (nv,).

    Decay rates are the eigenvalues of the Jacobian at the start. `taylor` says whether the Taylor method can run the
    scene: then it is the method for long runs.
    """
    y = dynamics.engine.pack(q, v)
    if len(y) > LARGE:
        return "dop853"
    slopes = _slopes(dynamics, y)
    if not np.isfinite(slopes).all():
        return "dop853"
    rates = np.linalg.eigvals(slopes)
    decay, fastest = -rates.real.min(), np.abs(rates).max()
    if decay * duration > STIFF and decay > OVERDAMPED * fastest:
        return "radau"
    return "taylor" if taylor and fastest * duration > LONG else "dop853"


def _slopes(dynamics: Dynamics, y: Array) -> Array:
    """d y'/d y at the start, (n, n), by forward differences."""
    derivative, _ = dynamics.engine.derivative(lambda t: None)
    steps = np.sqrt(np.finfo(float).eps) * np.maximum(np.abs(y), 1.0)

    def rate(y: Array) -> Array:
        dy = np.empty_like(y)
        derivative(dy, 0.0, y)
        return dy

    base = rate(y)
    return np.array([(rate(y + step) - base) / size for step, size in zip(np.diag(steps), steps, strict=True)]).T
