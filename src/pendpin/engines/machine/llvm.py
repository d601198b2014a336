"""LLVM by the functions of llvmlite's library, without importing llvmlite.

The documented interface, llvmlite.binding, was tried in its place: a first run of one rod took 69 ms instead of 49, one of
30 rods 161 instead of 144 (processor time, six processes each), all in the import. The arguments are those of the versions
named in SERIES; another llvmlite is not used, and a note says so.
"""

import ctypes
import os
import platform
import sys
from collections.abc import Callable
from ctypes import POINTER, byref, c_bool, c_char_p, c_int, c_uint64, c_void_p
from functools import cache, partial
from importlib.util import find_spec
from threading import Lock
from typing import Any, NamedTuple

from pendpin.engines.machine.lines import DECLARED, TRIGONOMETRY, number, trigonometry_code
from pendpin.engines.machine.text import MORE, STATE, UNITS
from pendpin.errors import MissingLibrary, say_note
from pendpin.ground.libraries import c_functions, version

OFF = 1e-14  # of the square of a direction: below, it is left as it is, and the divisions' rounding does not add up

# The first argument is the address of the function; then
# y, t, h, steps, block, work (5 size): moves y on from t by `steps` steps of h; its directions stay unit vectors
Steps = ctypes.CFUNCTYPE(
    None,
    *(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_double),
    *(ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p),
)

# n, t (n,), y (n, size), block, dy (n, size), more (n, further results)
Many = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int64, *[ctypes.c_void_p] * 5)


def _whole(name: str, cell: int) -> str:
    """A whole number of a block."""
    return f"""
  %{name}_at = getelementptr i64, ptr %cells, i64 {cell}
  %{name} = load i64, ptr %{name}_at"""


MANY = f"""
define void @many(ptr %rate, i64 %n, ptr %t, ptr %y, ptr %block, ptr %dy, ptr %more) {{
entry:
  %cells = load ptr, ptr %block{_whole("size", STATE)}{_whole("size_more", MORE)}
  br label %next
next:
  %i = phi i64 [ 0, %entry ], [ %after, %next ]
  %row = mul i64 %i, %size
  %row_more = mul i64 %i, %size_more
  %at = getelementptr double, ptr %t, i64 %i
  %time = load double, ptr %at
  %state = getelementptr double, ptr %y, i64 %row
  %rates = getelementptr double, ptr %dy, i64 %row
  %further = getelementptr double, ptr %more, i64 %row_more
  call void %rate(ptr %rates, double %time, ptr %state, ptr %block, ptr %further)
  %after = add i64 %i, 1
  %again = icmp slt i64 %after, %n
  br i1 %again, label %next, label %done
done:
  ret void
}}
"""

STEPS = f"""
declare double @llvm.sqrt.f64(double)

define internal void @along(i64 %size, ptr %out, ptr %y, double %h, ptr %k) {{ ; out = y + h k
entry:
  br label %next
next:
  %i = phi i64 [ 0, %entry ], [ %after, %next ]
  %from = getelementptr double, ptr %y, i64 %i
  %rate = getelementptr double, ptr %k, i64 %i
  %to = getelementptr double, ptr %out, i64 %i
  %value = load double, ptr %from
  %slope = load double, ptr %rate
  %change = fmul double %h, %slope
  %sum = fadd double %value, %change
  store double %sum, ptr %to
  %after = add i64 %i, 1
  %more = icmp slt i64 %after, %size
  br i1 %more, label %next, label %done
done:
  ret void
}}

define internal void @unit(i64 %units, ptr %y) {{                             ; each of the first vectors of 3
entry:
  %some = icmp slt i64 0, %units
  br i1 %some, label %next, label %done
next:
  %i = phi i64 [ 0, %entry ], [ %after, %next ]
  %from = mul i64 %i, 3
  %px = getelementptr double, ptr %y, i64 %from
  %py = getelementptr double, ptr %px, i64 1
  %pz = getelementptr double, ptr %px, i64 2
  %x = load double, ptr %px
  %y1 = load double, ptr %py
  %z = load double, ptr %pz
  %xx = fmul double %x, %x
  %yy = fmul double %y1, %y1
  %zz = fmul double %z, %z
  %xy = fadd double %xx, %yy
  %xyz = fadd double %xy, %zz
  %off = fsub double %xyz, 1.0
  %above = fcmp ogt double %off, {number(OFF)}
  %below = fcmp olt double %off, {number(-OFF)}
  %far = or i1 %above, %below
  %root = call double @llvm.sqrt.f64(double %xyz)
  %length = select i1 %far, double %root, double 1.0
  %ux = fdiv double %x, %length
  %uy = fdiv double %y1, %length
  %uz = fdiv double %z, %length
  store double %ux, ptr %px
  store double %uy, ptr %py
  store double %uz, ptr %pz
  %after = add i64 %i, 1
  %more = icmp slt i64 %after, %units
  br i1 %more, label %next, label %done
done:
  ret void
}}

define void @steps(ptr %rate, ptr %y, double %t, double %h, i64 %count, ptr %block, ptr %k1) {{
entry:
  %cells = load ptr, ptr %block{_whole("size", STATE)}{_whole("units", UNITS)}
  %k2 = getelementptr double, ptr %k1, i64 %size
  %k3 = getelementptr double, ptr %k2, i64 %size
  %k4 = getelementptr double, ptr %k3, i64 %size
  %inner = getelementptr double, ptr %k4, i64 %size
  %half = fmul double %h, 0.5
  %sixth = fdiv double %h, 6.0
  br label %next
next:
  %i = phi i64 [ 0, %entry ], [ %after, %next ]
  %many = sitofp i64 %i to double
  %gone = fmul double %many, %h
  %begin = fadd double %t, %gone
  %middle = fadd double %begin, %half
  %end = fadd double %begin, %h
  call void %rate(ptr %k1, double %begin, ptr %y, ptr %block, ptr null)
  call void @along(i64 %size, ptr %inner, ptr %y, double %half, ptr %k1)
  call void %rate(ptr %k2, double %middle, ptr %inner, ptr %block, ptr null)
  call void @along(i64 %size, ptr %inner, ptr %y, double %half, ptr %k2)
  call void %rate(ptr %k3, double %middle, ptr %inner, ptr %block, ptr null)
  call void @along(i64 %size, ptr %inner, ptr %y, double %h, ptr %k3)
  call void %rate(ptr %k4, double %end, ptr %inner, ptr %block, ptr null)
  call void @along(i64 %size, ptr %k2, ptr %k2, double 1.0, ptr %k3)
  call void @along(i64 %size, ptr %k1, ptr %k1, double 2.0, ptr %k2)
  call void @along(i64 %size, ptr %k1, ptr %k1, double 1.0, ptr %k4)
  call void @along(i64 %size, ptr %y, ptr %y, double %sixth, ptr %k1)
  call void @unit(i64 %units, ptr %y)
  %after = add i64 %i, 1
  %more = icmp slt i64 %after, %count
  br i1 %more, label %next, label %done
done:
  ret void
}}
"""


# --- LLVM by the functions of llvmlite's library --------------------------------------------------------------------

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
    if find_spec("llvmlite") is None:
        return False
    found = version("llvmlite")
    if not found.startswith(SERIES):
        say_note(
            f"llvmlite {found} is not used, and runs take about 8 times as long: pendpin compiles with llvmlite {SERIES}x: "
            f"{REMEDY}",
            stacklevel=3,
        )
    return found.startswith(SERIES)


def require(what: str) -> None:
    """Raise MissingLibrary for what needs llvmlite where it is not installed."""
    if not installed():
        raise MissingLibrary(f"{what} needs llvmlite {SERIES}x: {REMEDY}")


class Library:
    """Functions compiled in memory from LLVM's intermediate language, for this processor; they live as long as this object.

    Threads may compile at the same time: each library has a context of its own.
    """

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
        machine = api.CreateTargetMachine(*settings)  # the compiler takes it over
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

    def provide(self, name: str) -> None:
        """Let all code that is compiled afterwards call a function of this library, which has to live as long."""
        self._api.AddSymbol(name.encode(), self.address(name))


class Processor(NamedTuple):
    """What LLVM compiles for."""

    target: int
    triple: bytes
    name: bytes
    features: bytes  # as +avx2, -sse4a


@cache
def processor() -> Processor:
    """This processor."""
    api = _api()
    api.InitializeNativeTarget()
    api.InitializeNativeAsmPrinter()

    def read(function: Any) -> bytes:
        """What a function writes."""
        out = c_char_p()
        function(byref(out))
        value = out.value or b""
        api.DisposeString(out)
        return value

    triple, name, features = map(read, (api.GetDefaultTargetTriple, api.GetHostCPUName, api.GetHostCPUFeatures))
    if os.name == "nt":
        triple += b"-elf"  # the only format that is linked in memory
    return Processor(api.GetTargetFromTriple(triple, byref(c_char_p())), triple, name, features)


@cache
def _api() -> Any:
    """The functions by the names above. Raises MissingLibrary."""
    require("what takes derivatives")
    names = {name: (f"LLVMPY_{name}", *types) for name, types in _NAMES.items()}
    return c_functions("llvmlite", "binding/*llvmlite.*", names)


# --- the machine code of a function, and of the loops around it, which a process compiles once ----------------------


Rate = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
_lock = Lock()


class Code:
    """A function, compiled from its text with so many operations.

    `call` is for Python, `address` for compiled integrators, `steps` of rk4, `many` evaluates many states.
    """

    def __init__(self, text: str, operations: int) -> None:
        _once(_common)  # what the text may call
        self._library = Library(text, OPTIMISATION if operations <= LONG else 0)
        self.address = self._library.address("rate")
        self.call = Rate(self.address)

    @property
    def steps(self) -> Callable[..., None]:
        """The loop over steps of rk4, on this function."""
        return partial(Steps(_once(_steps).address("steps")), self.address)

    @property
    def many(self) -> Callable[..., None]:
        """The loop over many states, on this function."""
        return partial(Many(_once(_common).address("many")), self.address)


def _once(compile_library: Callable[[], Library]) -> Library:
    """A library that lives as long as the process; if two were made, code that calls the first would lose it."""
    with _lock:
        return compile_library()


@cache
def _common() -> Library:
    """Sines and cosines, which all code can call, and the loop over many states."""
    library = Library(DECLARED + trigonometry_code() + MANY, OPTIMISATION)
    library.provide(TRIGONOMETRY)
    return library


@cache
def _steps() -> Library:
    return Library(STEPS, OPTIMISATION)
