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
from typing import Any

from pendpin.engines.machine.routines import DECLARED, MANY, STEPS, TRIGONOMETRY, trigonometry_code
from pendpin.errors import MissingLibrary, say_note
from pendpin.ground.libraries import c_functions, version

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
    if os.name == "nt":
        triple += b"-elf"  # the only format that is linked in memory
    return api.GetTargetFromTriple(triple, byref(c_char_p())), triple, name, features


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


Rate = ctypes.CFUNCTYPE(None, c_void_p, ctypes.c_double, c_void_p, c_void_p, c_void_p)  # dy, t, y, block, more
# The first argument is the address of the function; the others are those of the routine.
Many = ctypes.CFUNCTYPE(None, c_void_p, ctypes.c_int64, *[c_void_p] * 5)
Steps = ctypes.CFUNCTYPE(None, c_void_p, c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int64, c_void_p, c_void_p)
_lock, _libraries = Lock(), dict[str, Library]()


class Code:
    """A function, compiled from its text with so many operations: `call` for Python, `address` for compiled integrators."""

    def __init__(self, text: str, operations: int) -> None:
        _routine("many")  # what the text may call
        self._library = Library(text, OPTIMISATION if operations <= LONG else 0)
        self.address = self._library.address("rate")
        self.call = Rate(self.address)

    @property
    def steps(self) -> Callable[..., None]:
        """The steps of rk4 on this function: y, t, h, steps, block, work (5 size); its directions stay unit vectors."""
        return partial(Steps(_routine("steps")), self.address)

    @property
    def many(self) -> Callable[..., None]:
        """The function at many states: n, t (n,), y (n, size), block, dy (n, size), more (n, further results)."""
        return partial(Many(_routine("many")), self.address)


def _routine(name: str) -> int:
    """The address of a routine. Its library lives as long as the process: if two were made, code would lose the first."""
    with _lock:
        if name not in _libraries:
            text = STEPS if name == "steps" else DECLARED + trigonometry_code() + MANY
            library = _libraries[name] = Library(text, OPTIMISATION)
            if name == "many":  # all code can call its sines and cosines
                library._api.AddSymbol(TRIGONOMETRY.encode(), library.address(TRIGONOMETRY))
        return _libraries[name].address(name)
