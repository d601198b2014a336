"""LLVM's intermediate language compiled in memory, for this processor (llvmlite)."""

import ctypes
from collections.abc import Callable
from functools import cache, partial
from typing import Any

from pendpin.engines.machine_lines import DECLARED
from pendpin.engines.machine_steps import MANY, STEPS, Many, Steps
from pendpin.engines.machine_trigonometry import TRIGONOMETRY, trigonometry_code

OPTIMISATION = 2  # of 3; the tape is already simplified
LONG = 4000  # operations without a loop, beyond which optimising takes over 0.15 s: its time grows with their square
Rate = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


class Code:
    """A function, compiled from its text with so many operations.

    `call` is for Python, `address` for compiled integrators, `steps` of rk4, `many` evaluates many states.
    """

    def __init__(self, text: str, operations: int) -> None:
        _provide_trigonometry()
        self._library = compile_text(text, OPTIMISATION if operations <= LONG else 0)
        self.address = self._library.get_function_address("rate")
        self.call = Rate(self.address)

    @property
    def steps(self) -> Callable[..., None]:
        """The loop over steps of rk4, on this function."""
        return partial(_function("steps", STEPS, Steps), self.address)

    @property
    def many(self) -> Callable[..., None]:
        """The loop over many states, on this function."""
        return partial(_function("many", MANY, Many), self.address)


def compile_text(code: str, optimisation: int = OPTIMISATION) -> Any:
    """The code in memory, for this processor. Its functions live as long as what is returned."""
    import llvmlite.binding as llvm

    machine = _machine(optimisation)  # first: it starts LLVM
    return llvm.create_mcjit_compiler(llvm.parse_assembly(code), machine)


def _machine(optimisation: int) -> Any:
    import llvmlite.binding as llvm

    _initialised()
    target, features = llvm.Target.from_default_triple(), llvm.get_host_cpu_features().flatten()
    return target.create_target_machine(cpu=llvm.get_host_cpu_name(), features=features, opt=optimisation, jit=True)


@cache
def _function(name: str, text: str, signature: Any) -> Any:
    """A function by its name in a text, compiled once for the life of the process."""
    library = compile_text(text)
    function = signature(library.get_function_address(name))
    function.library = library  # it lives as long as the function
    return function


@cache
def _provide_trigonometry() -> Any:
    """Let all code that is compiled afterwards call the sines and cosines; what is returned lives as long as the process."""
    import llvmlite.binding as llvm

    library = compile_text(DECLARED + trigonometry_code())
    llvm.add_symbol(TRIGONOMETRY, library.get_function_address(TRIGONOMETRY))
    return library


@cache
def _initialised() -> None:
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
