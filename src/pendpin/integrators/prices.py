"""What a run costs, in seconds of processor, before it is made: the one place for these numbers.

Measured on an AMD EPYC with pin 4.1, CyRK 0.20 and llvmlite 0.50; benchmarks/auto.py shows how good the choices are that
rest on them. A run costs its evaluations; compiled equations cost their compiling too, unless the process has compiled
their structure. A structure that comes again and again is compiled when its runs together have cost as much as
compiling; and at once if compiling costs little beside the start of a process, since most runs are not the last.
"""

from collections.abc import Hashable, Sequence

from pendpin.dynamics.compiling import compilable, known, structure
from pendpin.dynamics.dynamics import Dynamics, compiled_form
from pendpin.effects import BodyEffect, Drag, Effect
from pendpin.engines import AngleEngine, LongChain, Spherical
from pendpin.integrators import machine
from pendpin.scene import Scene

EVALUATIONS = 90.0  # of dop853 at a tolerance of 1e-4 for each turn of the fastest motion; of few rods
POWER = 0.114  # with which they grow as the tolerance falls
LONG_CHAIN = 0.25  # power of the number of rods by which the fastest motion of a chain matters less
IMPLICIT = 2_000.0  # evaluations of radau for each number of the state, about: its matrices are differences

RUNS = 3  # for an accuracy

OPERATIONS, OF_BODIES, OF_DRAG = 410, 190, 310  # of compiled equations for each rod: bare, with body effects, with drag
COMPILE = (0.015, 2.5e-5, 2.5e-9)  # s, times 1, operations and operations²
LITTLE = 0.05  # s: a fifth of what the first run of a process takes for its imports
COMPILED = (0.05e-6, 2e-10)  # s an evaluation, times 1 and operations
PINOCCHIO = (1.8e-6, 0.45e-6)  # s an evaluation, times 1 and rods, called from Python
SPHERICAL = (9e-6, 0.6e-6)
CHAIN = (300e-6, 2.6e-6)
TORQUES, FIELDS = 5e-6, 8e-6  # s an evaluation in Python, where there are any
WRENCHES = (60e-6, 4e-6)  # for each body effect, times 1 and rods

_spent: dict[Hashable, float] = {}  # s, by runs without compiling, for each structure


def cheapest_engine(scene: Scene, dynamics: Dynamics, method: str, turns: float, fresh: bool) -> str:
    """The cheaper of "auto", without compiling, and "compiled", for so many turns of the fastest motion.

    `fresh` chooses as in a fresh process.
    """
    effects, joints = dynamics.effects, len(dynamics.model.joints)
    if not (compilable(effects, joints) and machine.installed()):
        return "auto"
    base, start = compiled_form(dynamics), scene.start.time
    solver, base_tolerance = scene.solver, (scene.solver.accuracy or 0.0) / 10  # about what an accuracy takes
    count = evaluations(method, turns, solver.tolerance or base_tolerance, joints / 2) * (
        RUNS if solver.accuracy else 1
    )
    called, called_compiled = count * plain(dynamics), count * compiled(effects, joints / 2)
    if fresh or not known(base, effects, start):
        compiling = compile_seconds(effects, joints / 2)
        called_compiled += 0.0 if compiling < LITTLE else compiling
    key = structure(base, effects, start)
    before = 0.0 if fresh else _spent.get(key, 0.0)
    if called_compiled < before + called:
        return "compiled"
    _spent[key] = before + called
    return "auto"


def evaluations(method: str, turns: float, tolerance: float, rods: float) -> float:
    """How many evaluations a run takes, within a factor of about two."""
    explicit = EVALUATIONS * (1e-4 / tolerance) ** POWER * turns / max(1.0, rods) ** LONG_CHAIN
    return explicit if method != "radau" else 4 * rods * IMPLICIT


def compile_seconds(effects: Sequence[Effect], rods: float) -> float:
    """How long compiling takes; the compiler comes with CyRK."""
    first, each, square = COMPILE
    count = _operations(effects, rods)
    return first + each * count + square * count**2


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
