"""What a run costs, in seconds of processor, before it is made: the one place for these numbers.

Measured on an AMD EPYC with pin 4.1, CyRK 0.20 and llvmlite 0.50; benchmarks/auto.py shows how good the choices are that
rest on them. A run costs its evaluations; compiled equations cost their compiling too. The choice of the engine depends on
the scene alone, not on what a process has compiled before: the same scene then gives the same bits in every run. Compiling
that costs little beside the start of a process counts for nothing, since most runs are not the last.
"""

from collections.abc import Sequence

from pendpin.dynamics.compiling import compilable
from pendpin.dynamics.dynamics import Dynamics, without_compiling
from pendpin.effects import BodyEffect, Drag, Effect
from pendpin.engines import AngleEngine, LongChain, Spherical
from pendpin.integrators import cyrk
from pendpin.scene import Scene

EVALUATIONS = 90.0  # of dop853 at a tolerance of 1e-4 for each turn of the fastest motion; of few rods
POWER = 0.114  # with which they grow as the tolerance falls
LONG_CHAIN = 0.25  # power of the number of rods by which the fastest motion of a chain matters less
IMPLICIT = 2_000.0  # evaluations of radau for each number of the state, about: its matrices are differences

STAGES = 4  # evaluations in a step of rk4
RUNS = 3  # for an accuracy

OPERATIONS, OF_BODIES, OF_DRAG = 410, 80, 80  # of compiled equations for each rod: bare, with body effects, with drag
COMPILE = (0.012, 1.3e-5)  # s, times 1 and operations; without optimisation
LITTLE = 0.1  # s: a fifth of what the first run of a process takes for its imports
COMPILED = (0.05e-6, 4.8e-10)  # s an evaluation, times 1 and operations; without optimisation
PINOCCHIO = (1.8e-6, 0.45e-6)  # s an evaluation, times 1 and rods, called from Python
SPHERICAL = (9e-6, 0.6e-6)
CHAIN = (300e-6, 2.6e-6)
TORQUES, FIELDS = 5e-6, 8e-6  # s an evaluation in Python, where there are any
WRENCHES = (60e-6, 4e-6)  # for each body effect, times 1 and rods


def cheapest_engine(scene: Scene, dynamics: Dynamics, turns: float) -> str:
    """The cheaper of the dynamics' own engine and "compiled", for so many turns of the fastest motion."""
    joints, effects, plainly = len(dynamics.model.joints), dynamics.effects, without_compiling(dynamics.engine)
    if not (compilable(effects, joints) and cyrk.installed()):
        return plainly
    compiling = compile_seconds(effects, joints / 2)
    if compiling < LITTLE:
        return "compiled"
    count = evaluations(scene, turns, joints / 2) * (RUNS if scene.solver.accuracy else 1)
    saved = plain(dynamics) - compiled(effects, joints / 2)
    return "compiled" if compiling < count * saved else plainly


def evaluations(scene: Scene, turns: float, rods: float) -> float:
    """How many evaluations a run takes, within a factor of about two; of methods of lower order than dop853 more."""
    solver = scene.solver
    if solver.step is not None:
        return STAGES * scene.duration / solver.step
    if solver.method == "radau":
        return 4 * rods * IMPLICIT
    tolerance = solver.tolerance or (solver.accuracy or 0.0) / 10  # about what an accuracy takes
    return EVALUATIONS * (1e-4 / tolerance) ** POWER * turns / max(1.0, rods) ** LONG_CHAIN


def compile_seconds(effects: Sequence[Effect], rods: float) -> float:
    """How long compiling takes; the compiler comes with CyRK."""
    return COMPILE[0] + COMPILE[1] * _operations(effects, rods)


def compiled(effects: Sequence[Effect], rods: float) -> float:
    """Seconds of an evaluation in machine code."""
    return COMPILED[0] + COMPILED[1] * _operations(effects, rods)


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
    return first + each * rods + others + bodies * (WRENCHES[0] + WRENCHES[1] * rods)


def _operations(effects: Sequence[Effect], rods: float) -> float:
    bodies = any(isinstance(effect, BodyEffect) for effect in effects)
    drag = any(isinstance(effect, Drag) for effect in effects)
    return rods * (OPERATIONS + OF_BODIES * bodies + OF_DRAG * drag)
