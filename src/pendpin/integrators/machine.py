"""The adaptive methods on compiled equations, without a call from Python: CyRK's loops call the machine code themselves.

CyRK has this interface for Numba (CyRK.nb.numba_solver); no Numba function is compiled here.
"""

import ctypes
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np

from pendpin.arrays import Array
from pendpin.engines import Derivative, Engine, ProgressCallback
from pendpin.integrators.adaptive import NAMES, finite_part
from pendpin.integrators.base import FREE, Integrator, Segment, StepPlan
from pendpin.versions import version

_ARGUMENTS = 25  # of CyRK's solver in C, as of 0.20
_MEGABYTES = 2000  # that its output may take
_NO_LIMIT = 1e300  # s, on the size of a step


class AdaptiveInMachineCode(Integrator):
    """As `Adaptive`, on equations in machine code; only if `available` is true."""

    library = "CyRK"

    def __init__(self, method: str, tolerance: float) -> None:
        from CyRK.cy.pyhelpers import find_ode_method_int

        self._method, self._tolerance = int(find_ode_method_int(NAMES[method])), np.array([tolerance])
        self._error: BaseException | None = None
        self.version = version(self.library)

    def equations(self, engine: Engine, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """The equations of a compiled engine, which the loops call directly."""
        self._block, self._progress = engine.block(), progress
        self._block.watched(self._stop)
        return engine.derivative(progress)[0], lambda: self._block.calls

    def integrate(self, derivative: Derivative, y: Array, times: Array, plan: StepPlan = FREE) -> Segment:
        """The states (n, size), within the tolerance a step, with no call of `derivative`."""
        self._error = None
        first_step = min(plan.first or 0.0, (times[-1] - times[0]) / 2, plan.longest)
        y, times = np.ascontiguousarray(y), np.ascontiguousarray(times)
        states, steps, failure = self._solved(y, times, first_step, plan.longest)
        if self._error is not None:
            raise self._error
        return Segment(*finite_part(states, steps, failure))

    def _stop(self, t: float) -> bool:
        """Call the progress callback with t; an exception is raised after CyRK has returned."""
        try:
            self._progress(t)
        except BaseException as error:
            self._error = error
        return self._error is not None

    def _solved(self, y: Array, times: Array, first_step: float, longest: float) -> tuple[Array, int, str | None]:
        """The states (n, size), the steps and the failure, from y (size,) at `times` (n,) in s, by CyRK."""
        api, tolerance = _api(), self._tolerance.ctypes.data
        found = api.c_numba_cysolve_ivp(
            *(self._block.function.address, times[0], times[-1], y.ctypes.data, len(y), self._method, 0, 0),
            *(self._block.address, ctypes.sizeof(ctypes.c_void_p), 0, _MEGABYTES, False),
            *(times.ctypes.data, len(times), None, None, 0, tolerance, 1, tolerance, 1),
            *(min(longest, _NO_LIMIT), first_step, False),
        )
        try:
            count, size = api.c_get_size(found), api.c_get_num_dy(found)
            states = np.ctypeslib.as_array(api.c_get_y_ptr(found), (count, size)).copy() if count else y[None].copy()
            return states, api.c_get_steps(found), None if api.c_get_success(found) else _message(api, found)
        finally:
            api.c_free(found)


def _message(api: Any, found: int) -> str:
    text = ctypes.create_string_buffer(256)
    api.c_get_msg_buf(found, ctypes.addressof(text), len(text))
    return text.value.decode()


@cache
def _api() -> Any:
    """CyRK's functions in C; None if their signature is another."""
    try:
        from CyRK.nb import numba_solver
    except ImportError:
        return None
    known = len(getattr(getattr(numba_solver, "solve_func_sig", None), "_argtypes_", ())) == _ARGUMENTS
    return numba_solver if known else None


def installed() -> bool:
    """Whether CyRK is there, without importing it."""
    return find_spec("CyRK") is not None


def available() -> bool:
    """Whether CyRK's loops accept the address of a compiled function."""
    return _api() is not None
