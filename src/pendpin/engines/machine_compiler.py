"""The machine code of a function, and of the loops around it, which a process compiles once."""

import ctypes
from collections.abc import Callable
from functools import cache, partial
from threading import Lock

from pendpin.engines.llvm import Library
from pendpin.engines.machine_lines import DECLARED
from pendpin.engines.machine_steps import MANY, STEPS, Many, Steps
from pendpin.engines.machine_trigonometry import TRIGONOMETRY, trigonometry_code

OPTIMISATION = 2  # of 3; the tape is already simplified
LONG = 4000  # operations without a loop, beyond which optimising takes over 0.15 s: its time grows with their square
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
