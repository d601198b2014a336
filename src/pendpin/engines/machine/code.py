"""The machine code of equations, recorded and compiled when it is first needed, and what a run passes to it.

A block holds what changes from run to run, so that runs in several threads share the code and nothing else. Nothing of it
is written to a file.
"""

import ctypes
import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property
from threading import RLock
from typing import Any, NamedTuple

import numpy as np

from pendpin.engines.machine.llvm import Code
from pendpin.engines.machine.routines import (
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
    WIDE,
)
from pendpin.engines.machine.tape import Recording
from pendpin.engines.machine.text import Text
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


class Fixed(NamedTuple):
    """What operations on parameters alone come to, and tables: several blocks may share them."""

    numbers: Sequence[float]
    of_rods: Array  # (n, k), those of each of the n rods
    tables: Sequence[Table]


class Function:
    """The equations of one structure as machine code; it may be used from several threads, with a block for each."""

    def __init__(self, record: Callable[[], Recording], tables: int = 0) -> None:
        self._record: Callable[[], Recording] | None = record
        self._recording: Recording | None = None
        self._code: Code | None = None
        self._tables, self._lock, self.compile_seconds = tables, RLock(), 0.0
        self.series: dict[Hashable, Any] = {}  # what heyoka has compiled of them, by setting

    @property
    def recording(self) -> Recording:
        """The equations on a tape. Raises InputError for an effect that does not run on symbols."""
        with self._lock:
            if self._record is not None:
                self._recording, self._record = self._record(), None  # the engine that it holds goes
            assert self._recording is not None
            return self._recording

    @cached_property
    def text(self) -> Text:
        """Its text in LLVM's language; writing it counts as compiling."""
        begin = time.thread_time()
        text = Text(self.recording, self._tables)
        self.compile_seconds += time.thread_time() - begin
        return text

    def code(self) -> Code:
        """The code, compiled if it was not."""
        with self._lock:  # a second code in the place of the first would free it while another thread runs it
            if self._code is None:
                text, begin = self.text, time.thread_time()
                self._code = Code(str(text), len(text.schedule.needed))
                self.compile_seconds += time.thread_time() - begin
            return self._code

    def fixed(self, parameters: Values) -> Fixed:
        """What does not change in a run with one set of parameters."""
        text, tape, rods = self.text, self.recording.tape, parameters.of_rods.shape[1]
        values = tape.values([*text.fixed, *text.fixed_of_rod], parameters.shared, parameters.of_rods)
        rows = [np.broadcast_to(values[place], (tape.lanes[place] or 1, rods)) for place in text.fixed_of_rod]
        of_rods = np.ascontiguousarray(np.concatenate([*rows, np.empty((0, rods))]).T)
        numbers = [x for place in text.fixed for x in (values[place][:, 0] if tape.lanes[place] else (values[place],))]
        return Fixed(numbers, of_rods, parameters.tables)

    def block(self, parameters: Values) -> "Block":
        """A block for one set of parameters."""
        return Block(self, self.fixed(parameters))


class Block:
    """The further arguments of a function, at `address`: parameters, tables, its count of calls, a progress callback.

    `inputs` may be written between two calls. `compiled` is called with the time in s that compiling took.
    """

    def __init__(
        self, function: Function, fixed: Fixed, compiled: Callable[[float], None] = lambda seconds: None
    ) -> None:
        self.function, self._compiled, self._code = function, compiled, None
        (numbers, of_rods, tables), text, recording = fixed, function.text, function.recording
        rods, units = len(of_rods), len(of_rods) if recording.parts else 1
        self.size = recording.size_of(rods)  # how many numbers a state has
        self.more = len(text.more) + rods * len(text.more_of_rod)  # how many further results there are
        self.operations = len(text.schedule.needed) + (rods - 1) * len(text.schedule.loop)  # of an evaluation
        self._scratch = np.empty(rods * text.scratch_of_rod + 2 * WIDE)
        self._kept = [np.ascontiguousarray(part) for table in tables for part in (table.times, table.rows)]
        self._kept += [self._scratch, of_rods]
        first = HEADER + TABLE * len(tables)
        self._cells = np.zeros(first + len(numbers) + units * recording.inputs)
        self._whole = self._cells.view(np.int64)
        self._whole[RODS] = rods
        self._whole[SCRATCH], self._whole[NUMBERS] = self._scratch.ctypes.data, of_rods.ctypes.data
        self._whole[STATE], self._whole[MORE], self._whole[UNITS] = self.size, self.more, units * recording.directions
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
