"""From a scene's solver to its integrator."""

from importlib.util import find_spec

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.acting import built_in
from pendpin.dynamics.dynamics import Dynamics, bind, without_compiling
from pendpin.engines import Derivative
from pendpin.errors import InputError, choices
from pendpin.integrators import machine, prices
from pendpin.integrators.adaptive import NAMES, Adaptive
from pendpin.integrators.base import Integrator
from pendpin.integrators.events import ONE_STEP
from pendpin.integrators.fixed import RungeKutta4, SemiImplicitEuler, refuse_steps
from pendpin.integrators.gauss import STAGES, Gauss
from pendpin.integrators.taylor import Taylor
from pendpin.scene import Method, Scene

LARGE = 100  # numbers in a state, above which no Jacobian is computed
STIFF = 3e5  # decay rate times duration, above which explicit steps are too many (about 6 of it to a step of dop853)
LONG = 1e5  # rad that the fastest motion goes through: beyond, the Taylor method keeps more digits
FEW_JOINTS = 4  # up to which it does so at no more cost
STEP = float(np.sqrt(np.finfo(float).eps))  # of differences
WIDER = 16.0  # times those steps, to tell a slope from a jump
POWERS = 8
ON_COMPILED = ("rk4", *NAMES)  # methods whose loops run in machine code
OVERDAMPED = 0.5  # decay over the fastest rate: what swings as fast as it decays has to be followed anyway


def integrator_for(scene: Scene, dynamics: Dynamics) -> Integrator:
    """The integrator of a scene's method, with its setting. Raises InputError for a scene that the method cannot run."""
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
        return Taylor(dynamics.effects, solver.tolerance, scene.start.time)
    if dynamics.engine.compiles and machine.available():
        return machine.AdaptiveInMachineCode(method, solver.tolerance)
    return Adaptive(method, solver.tolerance)


def taylor_takes(scene: Scene, dynamics: Dynamics, energy_balance: bool, most: int = FEW_JOINTS) -> bool:
    """Whether the Taylor integrator is there and takes a scene of up to `most` joints."""
    smooth = built_in(dynamics.effects) and all(effect.smooth for effect in dynamics.effects)
    return (
        smooth
        and len(dynamics.model.joints) <= most
        and scene.solver.engine == "auto"
        and not energy_balance
        and find_spec("heyoka") is not None
    )


def automatic(scene: Scene, dynamics: Dynamics, q: Array, v: Array, energy_balance: bool = False) -> tuple[Method, str]:
    """The cheapest method and engine (pendpin.integrators.prices) where none is named, for a run from q, v (nv,).

    radau where something decays too fast to be followed, by the eigenvalues of the equations' slopes at the start; the
    Taylor method over long horizons, where it takes the scene; else dop853; on compiled equations where these pay. The
    choice depends on the scene alone.
    """
    solver, duration, method = scene.solver, scene.duration, scene.solver.method
    if method not in {"auto", *ON_COMPILED} or (method != "auto" and solver.engine != "auto"):
        return method, solver.engine
    y = dynamics.engine.pack(q, v)
    decay, fastest = _rates(dynamics, y, STEP)
    stiff = decay * duration > STIFF and decay > OVERDAMPED * fastest and not _jumps(dynamics, y, decay)
    turns = (decay if stiff else fastest) * duration / (2 * np.pi)
    if method == "auto":
        if not stiff and fastest * duration > LONG and taylor_takes(scene, dynamics, energy_balance):
            return "taylor", solver.engine
        method = "radau" if stiff else "dop853"
    if solver.engine != "auto":
        return method, solver.engine
    if dynamics.contacts is not None and NAMES.get(method) not in ONE_STEP:
        return method, without_compiling(dynamics.engine)
    return method, prices.cheapest_engine(scene.with_solver(method=method), dynamics, turns)


def uncompiled(scene: Scene) -> Scene:
    """The scene on the engine that it runs on if its equations are not compiled, unless it names its engine."""
    if scene.solver.engine != "auto" or scene.solver.method not in ON_COMPILED:
        return scene
    return scene.with_solver(engine=without_compiling(bind(scene).engine))


def _jumps(dynamics: Dynamics, y: Array, decay: float) -> bool:
    """Whether a decay in 1/s at the start y (size,) is that of a jump: wider differences make it slower."""
    return _rates(dynamics, y, WIDER * STEP)[0] < decay / 2


def _rates(dynamics: Dynamics, y: Array, step: float) -> tuple[float, float]:
    """The fastest decay and the fastest rate in 1/s at the start y (size,); of a large state the latter only.

    `step` is that of the differences, relative to the state.
    """
    derivative, _ = dynamics.engine.derivative(lambda t: None)
    if len(y) > LARGE:
        return 0.0, _fastest(derivative, y)
    slopes = _slopes(derivative, y, step)
    if not np.isfinite(slopes).all():
        return 0.0, 0.0
    rates = np.linalg.eigvals(slopes)
    return float(-rates.real.min()), float(np.abs(rates).max())


def _fastest(derivative: Derivative, y: Array) -> float:
    """The fastest rate in 1/s at y (size,), within a few tenths: the power method on the slopes, never written out."""
    base, rate, size = np.empty_like(y), np.empty_like(y), STEP * max(1.0, float(np.linalg.norm(y)))
    derivative(base, 0.0, y)
    direction, growth = np.cos(np.arange(len(y))), []  # without a symmetry by which a motion would be missed
    for _ in range(POWERS):
        direction /= max(float(np.linalg.norm(direction)), 1e-300)
        derivative(rate, 0.0, y + size * direction)
        direction = (rate - base) / size
        growth.append(float(np.linalg.norm(direction)))
    return float(np.sqrt(growth[-1] * growth[-2]))  # positions and rates take turns


def _slopes(derivative: Derivative, y: Array, step: float) -> Array:
    """d y'/d y at the start, (n, n), by forward differences with a step relative to y (n,)."""
    steps = step * np.maximum(np.abs(y), 1.0)

    def rate(y: Array) -> Array:
        dy = np.empty_like(y)
        derivative(dy, 0.0, y)
        return dy

    base = rate(y)
    return np.array([(rate(y + step) - base) / size for step, size in zip(np.diag(steps), steps, strict=True)]).T
