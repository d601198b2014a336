"""From a scene's solver to its integrator."""

import math
from importlib import import_module

import numpy as np

from pendpin.dynamics.acting import built_in
from pendpin.dynamics.compiling import compilable
from pendpin.dynamics.dynamics import Dynamics, bind, without_compiling
from pendpin.effects import Anchor, Bending
from pendpin.errors import InputError, choices, shown
from pendpin.ground.arrays import EPS, Array
from pendpin.ground.libraries import is_there
from pendpin.integrators.base import Integrator
from pendpin.model.build import Model
from pendpin.scene import Chain, Method, Scene, event_methods, method_of
from pendpin.scene.methods import MULTISTEP

MAX_STEPS = 1e9  # of a run; chosen: whoever asks for more has rather mistaken a unit
LARGE = 100  # numbers in a state, above which no Jacobian is computed, and explicit steps are taken
STIFF = 3e5  # decay rate times duration, above which explicit steps are too many (about 6 of it to a step of dop853)
LONG = 1e5  # rad that the fastest motion goes through: beyond, the Taylor method keeps more digits
FEW_JOINTS = 4  # up to which it does so at no more cost
STEP = EPS**0.5  # of differences
WIDER = 16.0  # times those steps, to tell a slope from a jump
MANY_STEPS = 10_000  # of a run: where an anchor or bending makes as many, a note says so
# of dop853 for each radian, or e-fold, of the fastest rate: 0.55 to 1.2 by benchmarks/cables.py --stiff
STEPS_PER_RATE = 0.6
OVERDAMPED = 0.5  # decay over the fastest rate: what swings as fast as it decays has to be followed anyway


def integrator_for(scene: Scene, dynamics: Dynamics) -> Integrator:
    """The integrator of a scene's method, with its setting. Raises InputError for a scene that the method cannot run."""
    solver = scene.solver
    method = method_of(solver.method)
    if dynamics.contacts is not None and not method.handles_events:
        these = choices(event_methods())
        raise InputError(f"solver.method: {method.name} cannot handle stops and dry friction; use {these}")
    if solver.step is not None and scene.times[-1] - scene.times[0] > MAX_STEPS * solver.step:
        raise InputError(f"solver.step: {shown(solver.step)} s takes more than {MAX_STEPS:g} steps")
    return integrator_class(method).for_scene(scene, dynamics)


def integrator_class(method: Method) -> type[Integrator]:
    """The class that a method's record names, imported now: heyoka and CyRK load only for the methods that need them."""
    if not isinstance(method.integrator, str):
        return method.integrator
    module, _, name = method.integrator.partition(":")
    return getattr(import_module(f"pendpin.integrators.{module}"), name)


def taylor_takes(scene: Scene, model: Model, most: int = FEW_JOINTS) -> bool:
    """Whether heyoka is installed and its Taylor series can integrate the scene, of up to `most` joints.

    A user's own effects that call themselves smooth are believed where the method is asked for by name.
    """
    if len(model.joints) > most or scene.solver.engine != "auto":
        return False
    trusted = scene.solver.method == "taylor" or built_in(scene.effects)
    return trusted and all(effect.smooth for effect in scene.effects) and is_there("heyoka")


def choose_method_and_engine(
    scene: Scene, dynamics: Dynamics, q: Array, v: Array, energy_balance: bool = False
) -> tuple[str, str]:
    """The method and engine where none is named, for a run from q, v (nv,).

    radau where something decays too fast to be followed, by the eigenvalues of the equations' slopes at the start; the
    Taylor method over long horizons, where it takes the scene; else dop853; on compiled equations wherever there are any:
    compiling takes less time than importing what calls equations from Python. The choice depends on the scene alone, so
    that the same scene gives the same bits whatever a process has compiled before.
    """
    solver, method = scene.solver, scene.solver.method
    if method != "auto" and (solver.engine != "auto" or not method_of(method).machine_code):
        return method, solver.engine
    compiles = solver.engine == "auto" and compilable(dynamics.model, dynamics.effects) and is_there("CyRK")
    if method == "auto":
        looked_at = dynamics
        if compiles and dynamics.contacts is None:  # in machine code: no Pinocchio or SciPy is imported for that
            looked_at = dynamics.in_motion(q, v, compiled=True)
        decay, fastest = _rates(looked_at, looked_at.engine.pack(q, v), STEP)
        method = "dop853"
        if fastest * scene.duration > LONG and not energy_balance and taylor_takes(scene, dynamics.model):
            method = "taylor"
        if decay * scene.duration > STIFF and decay > OVERDAMPED * fastest:
            slower, _ = _rates(looked_at, looked_at.engine.pack(q, v), WIDER * STEP)
            if not slower < decay / 2:  # else it is the decay of a jump, which wider differences make slower
                method = "radau"
    if solver.engine != "auto" or not method_of(method).machine_code:
        return method, solver.engine
    if compiles and (dynamics.contacts is None or method_of(method).family != MULTISTEP):
        return method, "compiled"
    return method, without_compiling(dynamics.engine)


def notes_on_stiffness(scene: Scene, steps: int) -> tuple[str, ...]:
    """Notes on the anchors and the bending of a chain that make many steps, or that an implicit method serves.

    An anchor on a rod of mass m moves at sqrt(stiffness / m) and decays at damping / m; rods of mass m and length l bend at
    up to 4 sqrt(EI / (m l³)). radau steps over a decay. A vibration is followed by every method, by dop853 in the fewest
    steps.
    """
    method = method_of(scene.solver.method)
    stiff = [(i, effect) for i, effect in enumerate(scene.effects) if isinstance(effect, Anchor | Bending)]
    if not stiff or not isinstance(scene.model, Chain) or method.setting == "step":
        return ()
    rods, notes = scene.model.all_rods, list[str]()
    for i, effect in stiff:
        if isinstance(effect, Anchor):
            rod = rods[int(effect.link.removeprefix("rod").removeprefix("_") or 1) - 1]  # a single one is called rod
            mass = rod.mass + rod.payload
            rate, decay, less = math.sqrt(effect.stiffness / mass), effect.damping / mass, "a smaller stiffness takes"
        else:
            softest = min((rod.mass + rod.payload) * rod.length**3 for rod in rods)
            rate, decay, less = 4 * math.sqrt(effect.stiffness / softest), 0.0, "fewer rods take"
        expected = STEPS_PER_RATE * max(rate, decay) * scene.duration
        if expected < MANY_STEPS:
            continue
        name = f"effects[{i}] ({effect.kind})"
        decays = f"{name} decays at {decay:.1e}/s"
        if method.damps and decay > rate:
            notes.append(f"{decays}, which {method.name} steps over; dop853 takes {expected:.0e} steps")
        elif steps > expected / 2:
            vibrates = f"{name} vibrates at {rate:.1e} rad/s, so this took {steps} steps; {less} fewer"
            notes.append(f"{decays}, so this took {steps} steps; radau takes far fewer" if decay > rate else vibrates)
    return tuple(notes)


def uncompiled(scene: Scene) -> Scene:
    """The scene on the engine that it runs on if its equations are not compiled, unless it names its engine."""
    solver = scene.solver
    if solver.engine != "auto" or not (solver.method == "auto" or method_of(solver.method).machine_code):
        return scene
    return scene.with_solver(engine=without_compiling(bind(scene).engine))


def _rates(dynamics: Dynamics, y: Array, step: float) -> tuple[float, float]:
    """The fastest decay and the fastest rate in 1/s at the start y (size,); 0 of a large state."""
    # By forward differences with a `step` relative to the state.
    if len(y) > LARGE:
        return 0.0, 0.0
    derivative, _ = dynamics.engine.derivative(lambda t: None)

    def rate(y: Array) -> Array:
        dy = np.empty_like(y)
        derivative(dy, 0.0, y)
        return dy

    base, steps = rate(y), step * np.maximum(np.abs(y), 1.0)
    slopes = np.array([(rate(y + step) - base) / size for step, size in zip(np.diag(steps), steps, strict=True)]).T
    if not np.isfinite(slopes).all():
        return 0.0, 0.0
    rates = np.linalg.eigvals(slopes)
    return float(-rates.real.min()), float(np.abs(rates).max())
