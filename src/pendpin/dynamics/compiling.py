"""The equations of a scene as machine code, kept for the life of the process: one compilation for each structure.

A structure is what remains of a scene when its numbers are taken out: joints, kinds of effects, which numbers are 0.
"""

import time
from collections import OrderedDict
from collections.abc import Hashable, Sequence
from functools import partial
from importlib.util import find_spec
from threading import Lock

from pendpin.dynamics.acting import plain_arithmetic
from pendpin.dynamics.parameters import Parameters
from pendpin.dynamics.symbols import MOTION, Asked, parameters_of, record
from pendpin.effects import Effect
from pendpin.engines import Compiled, CompiledEquations, Engine
from pendpin.errors import InputError, MissingLibrary

MAX_COMPILED = 200  # joints: a hundred rods compile in some four seconds
MOST_KNOWN = 128  # structures that are kept; the one that was not asked for longest goes
_known: OrderedDict[Hashable, CompiledEquations] = OrderedDict()
_lock = Lock()


def compilable(effects: Sequence[Effect], joints: int) -> bool:
    """Whether `auto` may compile a scene: llvmlite is there, and all effects are pendpin's own and run on symbols."""
    return plain_arithmetic(effects) and joints <= MAX_COMPILED and find_spec("llvmlite") is not None


def compiled(engine: Engine, effects: Sequence[Effect], start: float, asked: Asked = MOTION) -> Compiled:
    """An engine with its equations compiled, at times since `start` in s.

    Raises InputError for what has no symbols, MissingLibrary without llvmlite.
    """
    if find_spec("llvmlite") is None:
        raise MissingLibrary("solver.engine: \"compiled\" needs llvmlite: pip install 'pendpin[fast]'")
    if len(engine.model.joints) > MAX_COMPILED:
        raise InputError(f'solver.engine: "compiled" takes up to {MAX_COMPILED // 2} rods, or {MAX_COMPILED} joints')
    for i, effect in enumerate(effects):
        if not effect.symbolic:
            raise InputError(
                f"effects[{i}]: {effect.kind} does not run on symbols, as solver.engine: compiled needs it; "
                'take solver.engine = "auto"'
            )
    begin = time.perf_counter()
    equations, parameters = equations_of(engine, effects, start, asked=asked)
    return Compiled(engine, equations, parameters.values, parameters.tables, time.perf_counter() - begin)


def equations_of(
    engine: Engine, effects: Sequence[Effect], start: float, still: tuple[int, ...] = (), asked: Asked = MOTION
) -> tuple[CompiledEquations, Parameters]:
    """The equations of an engine's state with effects that run on symbols, and the values of their parameters.

    The places `still` of the state are 0.
    """
    parameters = parameters_of(engine, effects, start, asked)
    key = (parameters.structure, still)
    with _lock:
        found = _known.get(key)
        if found is None:
            found = _known[key] = CompiledEquations(
                partial(record, engine, effects, start, still, asked), len(parameters.tables)
            )
        _known.move_to_end(key)
        while len(_known) > MOST_KNOWN:
            _known.popitem(last=False)
    return found, parameters
