"""The machine code of equations, recorded and compiled when it is first needed, and what a run passes to it.

A block holds what changes from run to run, so that runs in several threads share the code and nothing else. Nothing of it
is written to a file. LLVM is called by the functions of llvmlite's library, without importing llvmlite: the documented
interface, llvmlite.binding, was tried in its place, and a first run of one rod took 69 ms instead of 49, one of 30 rods 161
instead of 144 (processor time, six processes each), all in the import. The arguments are those of the versions named in
SERIES; another llvmlite is not used, and a note says so.
"""

import ctypes
import platform
import sys
import time
from collections.abc import Callable, Hashable, Sequence
from ctypes import POINTER, byref, c_bool, c_char_p, c_double, c_int, c_int64, c_uint64, c_void_p
from functools import cache, cached_property, partial
from threading import Lock, RLock
from typing import Any, NamedTuple

import numpy as np

from pendpin.engines.machine import routines
from pendpin.engines.machine.routines import CALLBACK, CALLS, HEADER, RODS, TABLE, TRIGONOMETRY, WIDE
from pendpin.engines.machine.tape import Recording
from pendpin.engines.machine.text import Text
from pendpin.errors import MissingLibrary
from pendpin.ground.arrays import Array
from pendpin.ground.libraries import c_functions, is_there, say_unused, version

OPTIMISATION = 2  # of 3; the tape is already simplified
LONG = 4000  # operations without a loop, beyond which optimising takes over 0.15 s: its time grows with their square
SERIES = "0.50."
REMEDY = f"pip install 'llvmlite=={SERIES}*'"
_TEXT = POINTER(c_char_p)
# Without the prefix LLVMPY_ of llvmlite's exports. C names do not tell the types of arguments: SERIES stands for them.
_NAMES: dict[str, tuple[Any, tuple[Any, ...]]] = {  # type of the result, types of the arguments
    "InitializeNativeTarget": (c_int, ()),
    "InitializeNativeAsmPrinter": (c_int, ()),
    "GetDefaultTargetTriple": (None, (_TEXT,)),
    "GetHostCPUName": (None, (_TEXT,)),
    "GetHostCPUFeatures": (c_int, (_TEXT,)),
    "GetTargetFromTriple": (c_void_p, (c_char_p, _TEXT)),
    "CreateTargetMachine": (c_void_p, (c_void_p, *[c_char_p] * 3, c_int, *[c_char_p] * 2, c_int, c_int, c_char_p)),
    "ContextCreate": (c_void_p, ()),
    "ContextDispose": (None, (c_void_p,)),
    "ParseAssembly": (c_void_p, (c_void_p, c_char_p, _TEXT)),
    "CreateMCJITCompiler": (c_void_p, (c_void_p, c_void_p, c_bool, _TEXT)),
    "DisposeExecutionEngine": (None, (c_void_p,)),
    "GetFunctionAddress": (c_uint64, (c_void_p, c_char_p)),
    "AddSymbol": (None, (c_char_p, c_void_p)),
    "DisposeString": (None, (c_void_p,)),
}


@cache
def installed() -> bool:
    """Whether llvmlite is there in a version of this series; a note, once a process, about another one."""
    if not is_there("llvmlite"):
        return False
    found = version("llvmlite")
    if not found.startswith(SERIES):
        say_unused(f"llvmlite {found}", f"pendpin compiles with llvmlite {SERIES}x: {REMEDY}")
    return found.startswith(SERIES)


def require(what: str) -> None:
    """Raise MissingLibrary for what needs llvmlite where it is not installed."""
    if not installed():
        raise MissingLibrary(f"{what} needs llvmlite {SERIES}x: {REMEDY}")


@cache
def _api() -> Any:
    """The functions by the names above. Raises MissingLibrary."""
    require("what takes derivatives")
    names = {name: (f"LLVMPY_{name}", *types) for name, types in _NAMES.items()}
    return c_functions("llvmlite", "binding/*llvmlite.*", names)


@cache
def processor() -> tuple[int, bytes, bytes, bytes]:
    """This processor, for which LLVM compiles: the target, its triple, name and features (as +avx2, -sse4a)."""
    api, texts = _api(), []
    api.InitializeNativeTarget()
    api.InitializeNativeAsmPrinter()
    for write in (api.GetDefaultTargetTriple, api.GetHostCPUName, api.GetHostCPUFeatures):
        out = c_char_p()
        write(byref(out))
        texts.append(out.value or b"")
        api.DisposeString(out)
    triple, name, features = texts
    return api.GetTargetFromTriple(triple, byref(c_char_p())), triple, name, features


class Library:
    """Functions compiled in memory from LLVM's language, for this processor, as long as this object lives."""

    # Threads may compile at the same time: each library has a context of its own.

    def __init__(self, text: str, optimisation: int) -> None:
        self._context = self._engine = None  # until there are some to dispose of
        self._api = api = _api()
        self._context = api.ContextCreate()
        error = c_char_p()
        module = api.ParseAssembly(self._context, text.encode(), byref(error))
        if not module or error.value:
            raise RuntimeError(f"LLVM refuses the code: {error.value!r}")
        own_memory = platform.machine().lower() in {"arm64", "aarch64"}  # where LLVM's own places code too far apart
        target, triple, name, features = processor()
        settings = target, triple, name, features, optimisation, b"default", b"jitdefault", False, True, b""
        machine = api.CreateTargetMachine(*settings)  # the compiler owns it
        self._engine = api.CreateMCJITCompiler(module, machine, own_memory, byref(error))
        if not self._engine:
            raise RuntimeError(f"LLVM cannot compile: {error.value!r}")

    def __del__(self) -> None:
        if sys.is_finalizing() or not self._context:
            return
        if self._engine:
            self._api.DisposeExecutionEngine(self._engine)
        self._api.ContextDispose(self._context)

    def address(self, name: str) -> int:
        """The address of a function; at the first call all are compiled."""
        return self._api.GetFunctionAddress(self._engine, name.encode())


Rate = ctypes.CFUNCTYPE(None, c_void_p, c_double, c_void_p, c_void_p, c_void_p)  # dy, t, y, block, more
# The first argument is the address of the function; the others are those of the routine.
Many = ctypes.CFUNCTYPE(None, c_void_p, c_int64, *[c_void_p] * 5)
Steps = ctypes.CFUNCTYPE(None, c_void_p, c_void_p, c_double, c_double, c_int64, c_void_p, c_void_p)
Callback = ctypes.CFUNCTYPE(c_int, c_double)  # t -> whether to stop
_lock, _libraries = Lock(), dict[str, Library]()


class Code:
    """A function, compiled from its text with so many operations: `call` for Python, `address` for compiled integrators."""

    def __init__(self, text: str, operations: int) -> None:
        many = Many(_routine("many"))  # it comes first, with what the text may call
        self._library = Library(text, OPTIMISATION if operations <= LONG else 0)
        self.address = self._library.address("rate")
        self.call = Rate(self.address)
        # the function at many states: n, t (n,), y (n, size), block, dy (n, size), more (n, further results)
        self.many: Callable[..., None] = partial(many, self.address)

    @property
    def steps(self) -> Callable[..., None]:
        """The steps of rk4 on this function: y, t, h, steps, block, work (5 size); its directions stay unit vectors."""
        return partial(Steps(_routine("steps")), self.address)


def _routine(name: str) -> int:
    """The address of "steps" or "many". Its library lives as long as the process: code would lose the first of two."""
    with _lock:
        if name == "steps" and name not in _libraries:
            _libraries[name] = Library(routines.STEPS, OPTIMISATION)
        elif name not in _libraries:  # with the sines and cosines that it and all code may call
            text = routines.DECLARED + routines.trigonometry_code() + routines.MANY
            library = _libraries[name] = Library(text, OPTIMISATION)
            library._api.AddSymbol(TRIGONOMETRY.encode(), library.address(TRIGONOMETRY))
        return _libraries[name].address(name)


class Table(NamedTuple):
    """Numbers over time: a row holds from its own time to the next."""

    times: Array  # (n,) s
    rows: Array  # (n, width)


class Values(NamedTuple):
    """The values of parameters, and tables."""

    shared: Sequence[float]
    of_rods: Array  # (k, n), of each of the n rods; (0, n) where there are none
    tables: Sequence[Table]


class Function:
    """The equations of one structure as machine code; it may be used from several threads, with a block for each."""

    def __init__(self, record: Callable[[], Recording], tables: int = 0) -> None:
        self._recording: Recording | Callable[[], Recording] = record
        self._code: Code | None = None
        self._tables, self._lock, self.compile_seconds = tables, RLock(), 0.0
        self.series: dict[Hashable, Any] = {}  # what heyoka has compiled of them, by setting

    @property
    def recording(self) -> Recording:
        """The equations on a tape. Raises InputError for an effect that does not run on symbols."""
        with self._lock:
            if not isinstance(self._recording, Recording):
                self._recording = self._recording()  # the function goes, and with it the engine that it holds
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
                self._code = Code("\n".join(text.lines()), len(text.schedule.needed))
                self.compile_seconds += time.thread_time() - begin
            return self._code

    def evaluate_fixed(self, parameters: Values) -> tuple[list[float], Array]:
        """What operations on parameters alone come to: numbers, and (n, k) those of each of the n rods."""
        text, tape, rods = self.text, self.recording.tape, parameters.of_rods.shape[1]
        values = tape.values(text.needed_for_fixed, parameters.shared, parameters.of_rods)
        rows = [np.broadcast_to(values[place], (tape.lanes[place] or 1, rods)) for place in text.fixed_of_rod]
        of_rods = np.ascontiguousarray(np.concatenate([*rows, np.empty((0, rods))]).T)
        numbers = [x for place in text.fixed for x in (values[place][:, 0] if tape.lanes[place] else (values[place],))]
        return numbers, of_rods

    def block(self, parameters: Values) -> "Block":
        """A block for one set of parameters."""
        return Block(self, self.evaluate_fixed(parameters), parameters.tables)


class Block:
    """The further arguments of a function, at `address`: parameters, tables, its count of calls, a progress callback."""

    # `inputs` may be written between two calls.

    def __init__(self, function: Function, fixed: tuple[list[float], Array], tables: Sequence[Table]) -> None:
        self.function = function
        (numbers, of_rods), text, recording = fixed, function.text, function.recording
        rods, units = len(of_rods), len(of_rods) if recording.parts else 1
        self.size = recording.state_size(rods)  # how many numbers a state has
        self.more = len(text.more) + rods * len(text.more_of_rod)  # how many further results there are
        self.operations = len(text.schedule.needed) + (rods - 1) * len(text.schedule.loop)  # of an evaluation
        self._scratch = np.empty(rods * text.scratch_of_rod + 2 * WIDE)
        self._kept = [np.ascontiguousarray(part) for table in tables for part in (table.times, table.rows)]
        self._kept += [self._scratch, of_rods]
        first = HEADER + TABLE * len(tables)
        self._cells = np.zeros(first + len(numbers) + units * recording.inputs)
        self._whole = self._cells.view(np.int64)
        memory, lengths = (self._scratch.ctypes.data, of_rods.ctypes.data), (self.size, self.more)
        self._whole[RODS:HEADER] = rods, *memory, *lengths, units * recording.directions  # as in routines.py
        for i, table in enumerate(tables):
            addresses = (part.ctypes.data for part in self._kept[2 * i : 2 * i + 2])
            self._whole[HEADER + TABLE * i :][:TABLE] = *addresses, len(table.times)
        behind = first + len(numbers)
        self._cells[first:behind], self.inputs = numbers, self._cells[behind:]
        self._pointer = np.array([self._cells.ctypes.data])
        self.address = self._pointer.ctypes.data  # of the address of the cells

    @property
    def calls(self) -> int:
        """How often the function has been called with it."""
        return int(self._whole[CALLS])

    def evaluated(self, t: Array, y: Array) -> tuple[Array, Array]:
        """y' (n, size) and the further results (n, m) at times (n,) and states y (n, size)."""
        t, y = np.ascontiguousarray(t), np.ascontiguousarray(y)
        rates, more = np.empty(y.shape), np.empty((len(y), self.more))
        if len(t):
            many = self.function.code().many
            many(len(t), t.ctypes.data, y.ctypes.data, self.address, rates.ctypes.data, more.ctypes.data)
        return rates, more

    def on_progress(self, callback: Callable[[float], bool]) -> None:
        """Call `callback` with the time at every EVERY-th call; if it returns True, the rates become NaN."""
        self._callback = Callback(callback)
        self._whole[CALLBACK] = ctypes.cast(self._callback, c_void_p).value or 0
