"""Operations on a tape as machine code: LLVM's intermediate language, which llvm.py compiles.

A function has the signature of CyRK's right-hand sides, so that it is called from compiled integrators and from Python:
    void rate(double *dy, double t, double *y, void **block, double *more)
`more` takes the further results of a recording; it is null where they are not wanted.
Its block holds what changes from run to run: see `Block`. Nothing of it is written to a file.

Equations of a chain are loops over its rods (text.py): the same code is for any number of rods.
"""

import ctypes
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from threading import Lock
from typing import Any, NamedTuple

import numpy as np

from pendpin.engines.machine.lines import WIDE
from pendpin.engines.machine.llvm import Code
from pendpin.engines.machine.tape import Recording
from pendpin.engines.machine.text import (
    CALLBACK,
    CALLS,
    HEADER,
    MORE,
    NUMBERS,
    RODS,
    SCRATCH,
    STATE,
    TABLE,
    UNITS,
    Places,
    Text,
)
from pendpin.ground.arrays import Array, address

Callback = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double)  # t -> whether to stop


@dataclass(frozen=True, eq=False)
class Table:
    """Numbers over time: a row holds from its own time to the next."""

    times: Array  # (n,) s
    rows: Array  # (n, width)


class Values(NamedTuple):
    """The values of parameters, and tables."""

    shared: Sequence[float]
    of_rods: Array  # (k, n), of each of the n rods; (0, n) where there are none
    tables: Sequence[Table]

    @classmethod
    def of(cls, parameters: Any) -> "Values":
        """Those that Parameters (pendpin.dynamics.parameters) lists."""
        return cls(parameters.values, parameters.values_of_rods, parameters.tables)


class Sizes(NamedTuple):
    """How many numbers there are."""

    state: int
    more: int
    inputs: int
    directions: int
    scratch: int  # that loops leave for later ones
    operations: int  # of an evaluation


class Contents(NamedTuple):
    """What does not change in a block: several may share it."""

    sizes: Sizes
    numbers: Sequence[float]  # what operations on parameters alone come to
    of_rods: Array  # (n, k), those of the parameters of each of the n rods
    tables: Sequence[Table]


class Function:
    """The machine code of a recording. It may be used from several threads, with a block for each."""

    def __init__(self, recording: Recording, tables: int = 0) -> None:
        self._recording, self._places = recording, Places.of(recording)
        self._layout = Text(recording, tables, self._places)
        self.text = str(self._layout)
        self._code: Code | None = None
        self.compile_seconds, self._lock = 0.0, Lock()

    def code(self) -> Code:
        """The code, compiled if it was not."""
        with self._lock:  # a second code in the place of the first would free it while another thread runs it
            if self._code is None:
                begin = time.thread_time()
                self._code = Code(self.text, len(self._layout.schedule.needed))
                self.compile_seconds += time.thread_time() - begin
            return self._code

    def sizes(self, rods: int) -> Sizes:
        """How many numbers a block holds, for a chain of `rods` rods."""
        places, schedule, chain = self._places, self._layout.schedule, bool(self._recording.parts)
        return Sizes(
            state=self._recording.size_of(rods),
            more=len(places.more) + rods * len(places.more_of_rod),
            inputs=(rods if chain else 1) * self._recording.inputs,
            directions=(rods if chain else 1) * self._recording.directions,
            scratch=rods * self._layout.scratch_of_rod + 2 * WIDE,
            operations=len(schedule.needed) + (rods - 1) * len(schedule.loop),
        )

    def contents(self, parameters: Values) -> "Contents":
        """What a block holds for one set of parameters."""
        fixed, fixed_of_rod, rods = self._layout.fixed, self._layout.fixed_of_rod, parameters.of_rods.shape[1]
        tape = self._recording.tape
        values = tape.values([*fixed, *fixed_of_rod], parameters.shared, parameters.of_rods)
        rows = [np.broadcast_to(values[place], (tape.lanes[place] or 1, rods)) for place in fixed_of_rod]
        of_rods = np.ascontiguousarray(np.concatenate([*rows, np.empty((0, rods))]).T)
        shared = [x for place in fixed for x in (values[place][:, 0] if tape.lanes[place] else (values[place],))]
        return Contents(self.sizes(rods), shared, of_rods, parameters.tables)

    def block(self, parameters: Values, compiled: Callable[[float], None] = lambda seconds: None) -> "Block":
        """A block for one set of parameters; `compiled` gets the s that compiling takes."""
        return Block(self, self.contents(parameters), compiled)


class Block:
    """The further arguments of a function, at `address`: parameters, tables, its count of calls, a progress callback.

    `inputs` may be written between two calls. `compiled` is called with the time in s that compiling took.
    """

    def __init__(self, function: Function, contents: Contents, compiled: Callable[[float], None]) -> None:
        self.function, self._compiled = function, compiled
        sizes, numbers, of_rods, tables = contents
        self.size, self.more, self.operations = sizes.state, sizes.more, sizes.operations
        self._scratch = np.empty(sizes.scratch)
        self._kept = [np.ascontiguousarray(part) for table in tables for part in (table.times, table.rows)]
        self._kept += [self._scratch, of_rods]
        first = HEADER + TABLE * len(tables)
        self._cells = np.zeros(first + len(numbers) + sizes.inputs)
        self._whole, self._code = self._cells.view(np.int64), None
        self._whole[RODS] = len(of_rods)
        self._whole[SCRATCH], self._whole[NUMBERS] = self._scratch.ctypes.data, of_rods.ctypes.data
        self._whole[STATE], self._whole[MORE], self._whole[UNITS] = sizes.state, sizes.more, sizes.directions
        for i, table in enumerate(tables):
            addresses = (part.ctypes.data for part in self._kept[2 * i : 2 * i + 2])
            self._whole[HEADER + TABLE * i :][:TABLE] = *addresses, len(table.times)
        cells, self.inputs = np.split(self._cells[first:], [len(numbers)])
        cells[:] = numbers
        self._pointer = np.array([self._cells.ctypes.data])
        self.address = self._pointer.ctypes.data  # of the address of the cells

    @property
    def calls(self) -> int:
        """How often the function has been called with it."""
        return int(self._whole[CALLS])

    def code(self) -> Code:
        """The machine code, compiled if it was not."""
        if self._code is None:
            took = self.function.compile_seconds
            self._code = self.function.code()
            self._compiled(self.function.compile_seconds - took)
        return self._code

    def evaluated(self, t: Array, y: Array) -> tuple[Array, Array]:
        """y' (n, size) and the further results (n, m) at times (n,) and states y (n, size)."""
        t, y = np.ascontiguousarray(t), np.ascontiguousarray(y)
        rates, more = np.empty(y.shape), np.empty((len(y), self.more))
        if len(t):
            self.code().many(len(t), address(t), address(y), self.address, address(rates), address(more))
        return rates, more

    def on_progress(self, callback: Callable[[float], bool]) -> None:
        """Call `callback` with the time at every EVERY-th call; if it returns True, the rates become NaN."""
        self._callback = Callback(callback)
        self._whole[CALLBACK] = ctypes.cast(self._callback, ctypes.c_void_p).value or 0
