"""LLVM's intermediate language compiled in memory, for this processor (llvmlite)."""

import ctypes
from functools import cache
from typing import Any

from pendpin.engines.machine_steps import Many, Steps

OPTIMISATION = 2  # of 3; the tape is already simplified
LONG = 4000  # operations without a loop, beyond which optimising takes over 0.15 s: its time grows with their square
Rate = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


class Code:
    """A function, compiled from its text with so many operations.

    `call` is for Python, `address` for compiled integrators, `steps` of rk4, `many` evaluates many states.
    """

    def __init__(self, text: str, operations: int) -> None:
        self._library = compile_text(text, OPTIMISATION if operations <= LONG else 0)
        self.address = self._library.get_function_address("rate")
        self.call = Rate(self.address)
        self.steps = Steps(self._library.get_function_address("steps"))
        self.many = Many(self._library.get_function_address("many"))


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
def _initialised() -> None:
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
