"""The equations of a scene as machine code, kept for the life of the process: one compilation for each structure.

A structure is what remains of a scene when its numbers are taken out: joints, kinds of effects, which numbers are 0.
"""

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from functools import partial
from threading import Lock

import numpy as np

from pendpin.dynamics.acting import plain_arithmetic
from pendpin.dynamics.parameters import Parameters
from pendpin.dynamics.symbols import MOTION, Asked, parameters_of, record, records_by_rod, staying_zero
from pendpin.effects import Effect
from pendpin.engines import Compiled, Engine, Function, Moving, Values
from pendpin.engines.machine import llvm
from pendpin.engines.machine.tape import Recording
from pendpin.errors import InputError
from pendpin.ground.arrays import Array
from pendpin.model.build import Model

MOST_WRITTEN_OUT = 200  # joints, of equations that are not a loop over rods
MOST_KNOWN = 128  # structures that are kept; the one that was not asked for longest goes
MOST_SHORTENED = 10  # joints, up to which equations are written out so that what stays 0 is left out of them
_known: OrderedDict[Hashable, Function] = OrderedDict()
_still: OrderedDict[Hashable, tuple[int, ...]] = OrderedDict()  # by structure and zeros at the start
_lock = Lock()


def compilable(model: Model, effects: Sequence[Effect]) -> bool:
    """Whether `auto` compiles a scene: llvmlite is there, and all effects are pendpin's own and run on symbols."""
    few = model.alike or len(model.joints) <= MOST_WRITTEN_OUT
    return few and plain_arithmetic(effects) and llvm.installed()


def compile_engine(engine: Engine, effects: Sequence[Effect], start: float, asked: Asked = MOTION) -> Compiled:
    """An engine with its equations compiled, at times since `start` in s.

    Raises InputError for what has no symbols, MissingLibrary without llvmlite.
    """
    llvm.require('solver.engine: "compiled"')
    for i, effect in enumerate(effects):
        if not effect.symbolic:
            raise InputError(
                f"effects[{i}]: {effect.kind} does not run on symbols, as compiled equations must; "
                'use solver.engine = "auto"'
            )
    begin = time.thread_time()
    by_rod = not isinstance(engine, Moving) and records_by_rod(engine, effects)
    if not by_rod and len(engine.model.joints) > MOST_WRITTEN_OUT:
        raise InputError(
            f'solver.engine: "compiled" takes up to {MOST_WRITTEN_OUT} joints, and longer chains with built-in effects, on '
            "joints of one kind"
        )
    equations, parameters = equations_of(engine, effects, start, asked, by_rod)
    base, still = (engine.base, engine.still) if isinstance(engine, Moving) else (engine, ())
    return Compiled(base, still, equations, Values.of(parameters), time.thread_time() - begin)


def in_motion(engine: Engine, effects: Sequence[Effect], start: float, q: Array, v: Array) -> Engine:
    """The engine for motions from q, v (nv,): without the numbers of its state that stay 0, where there are such."""
    zero = tuple(np.flatnonzero(engine.pack(q, v) == 0).tolist())
    if not zero or len(q) > MOST_SHORTENED or not plain_arithmetic(effects):
        return engine
    key = parameters_of(engine, effects, start).structure, zero
    with _lock:
        still = _still.get(key)
    if still is None:
        still = staying_zero(engine, effects, start, zero)
        with _lock:
            _still[key] = still = (
                () if len(still) == len(engine.pack(q, v)) else still
            )  # nothing moves: keep the whole state
            while len(_still) > MOST_KNOWN:
                _still.popitem(last=False)
    return Moving(engine, still) if still else engine


def equations_of(
    engine: Engine, effects: Sequence[Effect], start: float, asked: Asked = MOTION, by_rod: bool = False
) -> tuple[Function, Parameters]:
    """The equations of an engine's state with effects that run on symbols, and the values of their parameters.

    `by_rod`: those of one rod of a chain, which are loops as machine code.
    """
    engine, still = (engine.base, engine.still) if isinstance(engine, Moving) else (engine, ())
    parameters = parameters_of(engine, effects, start, asked, by_rod)
    write = partial(record, engine, effects, start, still, asked, by_rod)
    return look_up((parameters.structure, still), write, parameters), parameters


def look_up(key: Hashable, record: Callable[[], Recording], parameters: Parameters) -> Function:
    """The equations of a structure, new ones if they are not known."""
    with _lock:
        equations = _known.get(key)
        if equations is None:
            equations = _known[key] = Function(record, len(parameters.tables))
        _known.move_to_end(key)
        while len(_known) > MOST_KNOWN:
            _known.popitem(last=False)
    return equations
