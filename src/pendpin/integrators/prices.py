"""What a run costs, in seconds of processor, before it is made: the one place for these numbers.

Measured on an AMD EPYC with pin 4.1, CyRK 0.20 and llvmlite 0.50; benchmarks/auto.py shows how good the choices are that
rest on them. A run costs its evaluations; compiled equations cost their compiling too. The choice of the engine depends on
the scene alone, not on what a process has compiled or imported before: the same scene then gives the same bits in every run.
"""

from collections.abc import Sequence

from pendpin.dynamics.compiling import compilable
from pendpin.dynamics.dynamics import Dynamics, without_compiling
from pendpin.effects import BodyEffect, ContactEffect, Drag, Effect
from pendpin.engines import AngleEngine, LongChain, Spherical
from pendpin.integrators import cyrk
from pendpin.scene import Scene

EVALUATIONS = 90.0  # of dop853 at a tolerance of 1e-4 for each turn of the fastest motion; of few rods
POWER = 0.114  # with which they grow as the tolerance falls
LONG_CHAIN = 0.25  # power of the number of rods by which the fastest motion of a chain matters less
IMPLICIT = 2_000.0  # evaluations of radau for each number of the state, about: its matrices are differences
OF_EVENTS = 50  # evaluations with friction or stops, for each joint and each turn of the fastest motion, about
STAGES = 4  # evaluations in a step of rk4
RUNS = 3  # for an accuracy

OPERATIONS = 410  # of compiled equations for each rod
OF_BODIES, OF_DRAG, OF_CONTACTS = 80, 80, 230  # and with body effects, with drag, with friction or stops
LARGE = 20_000  # operations, beyond which the code is larger than the processor's cache: each of them costs more
COMPILE = (0.012, 1.3e-5, 1.8e-5)  # s, times 1, operations, and those beyond; without optimisation
IMPORT = 0.25  # s: of CyRK and, with it, Numba, where the equations are called from Python
COMPILED = (0.05e-6, 4.8e-10, 7.5e-10)  # s an evaluation, times the same
PINOCCHIO = (1.4e-6, 0.55e-6)  # s an evaluation, times 1 and rods, called from Python
SPHERICAL = (9e-6, 0.6e-6)
CHAIN = (300e-6, 2.6e-6)
TORQUES, FIELDS = 5e-6, 8e-6  # s an evaluation in Python, where there are any
WRENCHES = (80e-6, 6e-6)  # for each body effect, times 1 and rods
CONTACTS = (50e-6, 4e-6)  # for friction and stops, times 1 and rods


def cheapest_engine(scene: Scene, dynamics: Dynamics, turns: float) -> str:
    """The cheaper of the dynamics' own engine and "compiled", for so many turns of the fastest motion."""
    joints, effects, plainly = len(dynamics.model.joints), dynamics.effects, without_compiling(dynamics.engine)
    if not (compilable(effects, joints) and cyrk.installed()):
        return plainly
    compiling = compile_seconds(effects, joints / 2)
    count = evaluations(scene, dynamics, turns) * (RUNS if scene.solver.accuracy else 1)
    saved = plain(dynamics) - compiled(effects, joints / 2)
    return "compiled" if compiling < IMPORT + count * saved else plainly


def evaluations(scene: Scene, dynamics: Dynamics, turns: float) -> float:
    """How many evaluations a run takes, within a factor of about two; of methods of lower order than dop853 more."""
    solver, joints = scene.solver, len(dynamics.model.joints)
    if solver.step is not None:
        return STAGES * scene.duration / solver.step
    if solver.method == "radau":
        return 2 * joints * IMPLICIT
    tolerance = solver.tolerance or (solver.accuracy or 0.0) / 10  # about what an accuracy takes
    steps = EVALUATIONS * (1e-4 / tolerance) ** POWER * turns / max(1.0, joints / 2) ** LONG_CHAIN
    return steps + OF_EVENTS * joints * turns * (dynamics.contacts is not None)


def compile_seconds(effects: Sequence[Effect], rods: float) -> float:
    """How long compiling takes; the compiler comes with CyRK."""
    return _price(COMPILE, effects, rods)


def compiled(effects: Sequence[Effect], rods: float) -> float:
    """Seconds of an evaluation in machine code."""
    return _price(COMPILED, effects, rods)


def plain(dynamics: Dynamics) -> float:
    """Seconds of an evaluation that is called from Python."""
    engine, (first, each) = dynamics.engine, CHAIN
    if isinstance(engine, Spherical):
        first, each = SPHERICAL
    elif isinstance(engine, AngleEngine) and not isinstance(engine, LongChain):
        first, each = PINOCCHIO
    rods, loads = len(engine.model.joints) / 2, engine.loads
    bodies = sum(isinstance(effect, BodyEffect) for effect in dynamics.effects)
    others = TORQUES * (loads.torque is not None) + FIELDS * (loads.varying is not None)
    contacts = dynamics.contacts is not None
    rules = ((1, (first, each)), (bodies, WRENCHES), (contacts, CONTACTS))
    return others + sum(times * (once + more * rods) for times, (once, more) in rules)


def _price(rule: tuple[float, float, float], effects: Sequence[Effect], rods: float) -> float:
    bodies = any(isinstance(effect, BodyEffect) for effect in effects)
    drag = any(isinstance(effect, Drag) for effect in effects)
    contacts = any(isinstance(effect, ContactEffect) for effect in effects)
    operations = rods * (OPERATIONS + OF_BODIES * bodies + OF_DRAG * drag + OF_CONTACTS * contacts)
    return rule[0] + rule[1] * operations + rule[2] * max(0.0, operations - LARGE)
