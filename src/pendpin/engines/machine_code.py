"""Operations on a tape as machine code: LLVM's intermediate language, which machine_compiler.py compiles.

A function has the signature of CyRK's right-hand sides, so that it is called from compiled integrators and from Python:
    void rate(double *dy, double t, double *y, void **block, double *more)
`more` takes the further results of a recording; it is null where they are not wanted.
Its block holds what changes from run to run: see `Block`. Nothing of it is written to a file.

A function is compiled without optimisation first, which takes a fifth of the time, and anew with it once it has been called
often. Both do the same arithmetic: their results agree to the bit (tests/test_compiled_parameters.py).
"""

import ctypes
import struct
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from threading import Lock
from typing import Any

import numpy as np

from pendpin.arrays import Array, address
from pendpin.engines import machine_quadrature
from pendpin.engines.machine_compiler import Code
from pendpin.engines.machine_steps import steps_code
from pendpin.engines.tape import Recording

OPTIMISATION = 2  # of 3; the tape is already simplified
MANY_CALLS = (80_000, 8, 2e8)  # times 1, operations, and 1 over them: from which on optimised code saves what it takes
EVERY = 4096  # calls between two of the progress callback; a power of 2
Callback = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double)  # t -> whether to stop
_HEADER = 2  # cells of a block before its numbers: the count of calls, the progress callback
_TABLE = 3  # cells of a table: addresses of its times and its rows, and how many there are

_BINARY = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
_COMPARED = {"min": "olt", "max": "ogt"}
_INTRINSIC = ("sqrt", "exp", "log", "sin", "cos", "pow")
_DECLARED = """
declare double @llvm.sqrt.f64(double)
declare double @llvm.exp.f64(double)
declare double @llvm.log.f64(double)
declare double @llvm.sin.f64(double)
declare double @llvm.cos.f64(double)
declare double @llvm.pow.f64(double, double)
declare double @tan(double)
declare double @tanh(double)
declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)

define internal i64 @row(ptr %times, i64 %rows, double %t) noinline {
entry:
  br label %look
look:                                             ; the last of the rows that begins at or before t
  %low = phi i64 [ 0, %entry ], [ %low2, %next ]
  %high = phi i64 [ %rows, %entry ], [ %high2, %next ]
  %gap = sub i64 %high, %low
  %more = icmp sgt i64 %gap, 1
  br i1 %more, label %next, label %done
next:
  %sum = add i64 %low, %high
  %middle = lshr i64 %sum, 1
  %at = getelementptr double, ptr %times, i64 %middle
  %begin = load double, ptr %at
  %later = fcmp ogt double %begin, %t
  %low2 = select i1 %later, i64 %low, i64 %middle
  %high2 = select i1 %later, i64 %middle, i64 %high
  br label %look
done:
  ret i64 %low
}
"""


@dataclass(frozen=True, eq=False)
class Table:
    """Numbers over time: a row holds from its own time to the next."""

    times: Array  # (n,) s
    rows: Array  # (n, width)


class Function:
    """The machine code of a recording. It may be used from several threads, with a block for each."""

    def __init__(self, recording: Recording, tables: int = 0) -> None:
        self._tape = tape = recording.tape
        self._places, self._more = ([tape.placed(x) for x in part] for part in (recording.results, recording.more))
        self._needed = tape.needed([*self._places, *self._more])
        self._fixed = tape.fixed_operands([*self._places, *self._more])
        self._tables, self._inputs, self._directions = tables, recording.inputs, recording.directions
        self.size, self.more, self.operations = len(self._places), len(self._more), len(self._needed)
        self._quadratures: dict[Any, str] = {}  # names of functions, by points and weights
        self.text = "\n".join(self._written())
        self._codes: dict[int, Code] = {}  # by level of optimisation
        self._calls, self.compile_seconds, self._lock = 0, 0.0, Lock()

    def code(self, calls: int) -> Code:
        """The code after some further calls, compiled if it was not: optimised once there have been many."""
        first, each, short = MANY_CALLS
        with self._lock:  # a second code in the place of the first would free it while another thread runs it
            self._calls += calls
            level = (
                OPTIMISATION if self._calls > first + each * self.operations + short / max(self.operations, 1) else 0
            )
            if level not in self._codes:
                begin = time.perf_counter()
                self._codes[level] = Code(self.text, level)
                self.compile_seconds += time.perf_counter() - begin
            return self._codes[level]

    def block(self, parameters: Sequence[float], tables: Sequence[Table], compiled: Callable[[float], None]) -> "Block":
        """A block for one set of parameters; `compiled` is called with the time in s that compiling takes."""
        values = self._tape.values(self._fixed, parameters)
        return Block(self, [values[place] for place in self._fixed], tables, self._inputs, compiled)

    def _written(self) -> Iterator[str]:
        yield _DECLARED
        yield "define void @rate(ptr noalias %dy, double %t, ptr noalias %y, ptr %blocks, ptr noalias %more) {"
        yield from _reporting(len(self._places))
        for cell, place in enumerate(self._fixed, _HEADER + _TABLE * self._tables + self._inputs):
            yield from _load(f"v{place}", "block", cell)
        for place in self._needed:
            if not self._tape.fixed[place]:
                yield from self._line(place)
        yield from self._stored("dy", self._places)
        yield "  %wanted = icmp ne ptr %more, null"
        yield "  br i1 %wanted, label %further, label %end\nfurther:"
        yield from self._stored("more", self._more)
        yield "  br label %end\nend:\n  ret void\n}"
        yield steps_code(len(self._places), len(self._more), self._directions)
        if self._quadratures:
            yield machine_quadrature.DECLARED
        for rule, name in self._quadratures.items():
            yield machine_quadrature.quadrature_code(name, *rule)

    def _stored(self, array: str, places: list[int]) -> Iterator[str]:
        for i, place in enumerate(places):
            yield f"  %{array}{i} = getelementptr double, ptr %{array}, i64 {i}"
            yield f"  store double {self._operand(place)}, ptr %{array}{i}"

    def _line(self, place: int) -> Iterator[str]:
        name, *operands = self._tape.operations[place]
        if name == "time":
            yield f"  %v{place} = fsub double %t, 0.0"
        elif name == "state":
            yield from _load(f"v{place}", "y", operands[0])
        elif name == "input":
            yield from _load(f"v{place}", "block", _HEADER + _TABLE * self._tables + operands[0])
        elif name == "row":
            yield from _row(place, self._operand(operands[0]), *operands[1:])
        elif name == "roots":
            *terms, rule = *map(self._operand, operands[:3]), tuple(operands[3:])
            quadrature = self._quadratures.setdefault(rule, f"quadrature{len(self._quadratures)}")
            yield f"  %row{place} = alloca double, i64 {len(operands[4])}"
            yield f"  call void @{quadrature}({', '.join(f'double {x}' for x in terms)}, ptr %row{place})"
        elif name == "entry":
            yield from _load(f"v{place}", f"row{operands[0]}", operands[1])
        else:
            yield from _arithmetic(place, name, [self._operand(x) for x in operands])

    def _operand(self, place: int) -> str:
        name, *operands = self._tape.operations[place]
        return _number(operands[0]) if name == "number" else f"%v{place}"


class Block:
    """The further arguments of a function, at `address`: parameters, tables, its count of calls, a progress callback.

    `inputs` may be written between two calls. `compiled` is called with the time in s that compiling took.
    """

    def __init__(
        self,
        function: Function,
        numbers: Sequence[float],
        tables: Sequence[Table],
        inputs: int,
        compiled: Callable[[float], None],
    ) -> None:
        self.function, self._compiled = function, compiled
        self._kept = [np.ascontiguousarray(part) for table in tables for part in (table.times, table.rows)]
        self._cells = np.zeros(_HEADER + _TABLE * len(tables) + inputs + len(numbers))
        self._whole, self._counted, self._code = self._cells.view(np.int64), 0, None
        for i, table in enumerate(tables):
            addresses = (part.ctypes.data for part in self._kept[2 * i : 2 * i + 2])
            self._whole[_HEADER + _TABLE * i :][:_TABLE] = *addresses, len(table.times)
        self.inputs, cells = np.split(self._cells[_HEADER + _TABLE * len(tables) :], [inputs])
        cells[:] = numbers
        self._pointer = np.array([self._cells.ctypes.data])
        self.address = self._pointer.ctypes.data  # of the address of the cells

    @property
    def calls(self) -> int:
        """How often the function has been called with it."""
        return int(self._whole[0])

    def code(self) -> Code:
        """The machine code, compiled if it was not. It may change from segment to segment; its results do not."""
        (before, self._counted), took = (self._counted, self.calls), self.function.compile_seconds
        self._code = self.function.code(self._counted - before)
        self._compiled(self.function.compile_seconds - took)
        return self._code

    def evaluated(self, t: Array, y: Array) -> tuple[Array, Array]:
        """y' (n, size) and the further results (n, m) at times (n,) and states y (n, size)."""
        t, y = np.ascontiguousarray(t), np.ascontiguousarray(y)
        rates, more = np.empty(y.shape), np.empty((len(y), self.function.more))
        if len(t):
            code = self._code or self.code()
            code.many(len(t), address(t), address(y), self.address, address(rates), address(more))
        return rates, more

    def on_progress(self, callback: Callable[[float], bool]) -> None:
        """Call `callback` with the time at every EVERY-th call; if it returns True, the rates become NaN."""
        self._callback = Callback(callback)
        self._whole[1] = ctypes.cast(self._callback, ctypes.c_void_p).value or 0


def _reporting(results: int) -> Iterator[str]:
    """Count the call, and call the progress callback at every EVERY-th."""
    yield f"""
  %block = load ptr, ptr %blocks
  %before = load i64, ptr %block
  %count = add i64 %before, 1
  store i64 %count, ptr %block
  %part = and i64 %count, {EVERY - 1}
  %due = icmp eq i64 %part, 0
  br i1 %due, label %report, label %go
report:
  %place = getelementptr ptr, ptr %block, i64 1
  %callback = load ptr, ptr %place
  %none = icmp eq ptr %callback, null
  br i1 %none, label %go, label %ask
ask:
  %answer = call i32 %callback(double %t)
  %on = icmp eq i32 %answer, 0
  br i1 %on, label %go, label %stop
stop:
  call void @llvm.memset.p0.i64(ptr %dy, i8 -1, i64 {8 * results}, i1 false)
  ret void
go:"""


def _load(name: str, array: str, cell: int, kind: str = "double") -> Iterator[str]:
    yield f"  %at_{name} = getelementptr double, ptr %{array}, i64 {cell}"
    yield f"  %{name} = load {kind}, ptr %at_{name}"


def _row(place: int, t: str, table: int, width: int) -> Iterator[str]:
    """The address of the row of a table that holds at a time."""
    cell = _HEADER + _TABLE * table
    yield from _load(f"times{place}", "block", cell, "ptr")
    yield from _load(f"rows{place}", "block", cell + 1, "ptr")
    yield from _load(f"many{place}", "block", cell + 2, "i64")
    yield f"  %which{place} = call i64 @row(ptr %times{place}, i64 %many{place}, double {t})"
    yield f"  %first{place} = mul i64 %which{place}, {width}"
    yield f"  %row{place} = getelementptr double, ptr %rows{place}, i64 %first{place}"


def _arithmetic(place: int, name: str, operands: list[str]) -> Iterator[str]:
    both = ", ".join(operands)
    if name in _BINARY:
        yield f"  %v{place} = {_BINARY[name]} double {both}"
    elif name == "neg":
        yield f"  %v{place} = fneg double {both}"
    elif name in _COMPARED:
        yield f"  %c{place} = fcmp {_COMPARED[name]} double {both}"
        yield f"  %v{place} = select i1 %c{place}, double {operands[0]}, double {operands[1]}"
    else:
        function = f"llvm.{name}.f64" if name in _INTRINSIC else name
        yield f"  %v{place} = call double @{function}({', '.join('double ' + x for x in operands)})"


def _number(x: float) -> str:
    return f"0x{struct.unpack('<Q', struct.pack('<d', x))[0]:016X}"
