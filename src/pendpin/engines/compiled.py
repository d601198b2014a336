"""An engine's equations as machine code: recorded once on a tape, compiled once for each structure of a scene.

One compilation serves many sets of parameters. `CompiledEquations` belongs to a structure (pendpin.dynamics.compiling keeps
them for the life of the process); `Compiled` is an engine with one set of parameters; a `Block` is what one run passes to
the function, so that runs in several threads share the code and nothing else:
    equations = compiled_equations(engine, effects, start)    # recorded, or from the cache
    equations.function.block(values)                          # values as Parameters lists them: no compiling
"""

import time
from collections.abc import Callable, Hashable
from functools import cached_property
from threading import Lock
from typing import Any

import numpy as np

from pendpin.engines.base import CALLBACK_EVERY, Derivative, Engine, ProgressCallback, Wrapping, count_calls
from pendpin.engines.machine.code import Block, Contents, Function, Values
from pendpin.engines.machine.tape import Recording
from pendpin.ground.arrays import Array


class CompiledEquations:
    """The equations of one structure, recorded and compiled when they are first needed."""

    def __init__(self, record: Callable[[], Recording], tables: int) -> None:
        self._record: Callable[[], Recording] | None = record
        self._recording: Recording | None = None
        self._tables, self._lock = tables, Lock()
        self.series: dict[Hashable, Any] = {}  # what heyoka has compiled of them, by setting

    @property
    def compile_seconds(self) -> float:
        """The s in which the machine code was compiled, in whichever run that was."""
        return self.function.compile_seconds

    @property
    def recording(self) -> Recording:
        """y' on a tape. Raises InputError for an effect that does not run on symbols."""
        with self._lock:
            if self._record is not None:
                self._recording, self._record = self._record(), None  # the engine that it holds goes
            assert self._recording is not None
            return self._recording

    @cached_property
    def function(self) -> Function:
        """y' as machine code."""
        return Function(self.recording, self._tables)


class Compiled(Wrapping):
    """The state, poses and wrenches of another engine, and y' by machine code, with one set of parameters."""

    compiles = True
    symbolic = False

    def __init__(self, base: Engine, equations: CompiledEquations, values: Values, took: float) -> None:
        super().__init__(base)
        self.equations, self.name = equations, f"{base.name}, compiled"
        self._values, self.compile_seconds = values, took

    @property
    def size(self) -> int:
        """How many numbers the state has."""
        return self._contents.sizes.state

    @property
    def function(self) -> Function:
        """y' as machine code."""
        begin = time.thread_time()
        function = self.equations.function  # recorded here, the first time
        self._took(time.thread_time() - begin)
        return function

    def block(self) -> Block:
        """The arguments of the function for one run."""
        return Block(self.function, self._contents, self._took)

    @cached_property
    def _contents(self) -> Contents:
        return self.function.contents(self._values)

    def _took(self, seconds: float) -> None:
        self.compile_seconds += seconds

    def normalise(self, y: Array) -> None:
        """The base engine's, of a state (size,); steps in machine code do it themselves."""
        self.base.normalise(y)

    def accelerate(self, t: float, q: Array, v: Array) -> Array:
        """q'' (nv,) by the base engine, not compiled."""
        return self.base.accelerate(t, q, v)

    def derivative(self, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """y' by machine code, which is compiled here."""
        block, size = self.block(), self.size
        code, state, rates = block.code(), np.zeros(size), np.zeros(size)
        call, arguments = code.call, (rates.ctypes.data, state.ctypes.data, block.address)

        def derivative(dy: Array, t: float, y: Array) -> None:
            state[:] = y
            call(arguments[0], t, arguments[1], arguments[2], None)
            dy[:] = rates

        derivative.needs = block, code  # type: ignore[attr-defined]  # they live as long as the function
        return count_calls(derivative, progress, CALLBACK_EVERY)
