"""The adaptive methods, embedded Runge-Kutta and multistep: on CyRK where it is installed, else on SciPy.

On compiled equations CyRK's C++ loop calls the machine code itself: no step calls Python.
"""

import ctypes
from collections.abc import Callable, Generator, Iterator
from contextlib import suppress
from ctypes import c_bool, c_double, c_int, c_size_t, c_void_p
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import Derivative, Engine, ProgressCallback
from pendpin.engines.machine import llvm
from pendpin.engines.machine.llvm import Block
from pendpin.ground.arrays import Array, Mask
from pendpin.ground.libraries import c_functions, is_there, say_unused, version
from pendpin.integrators.base import FREE, LEAST_RTOL, NOT_FINITE, Integrator, Segment, StepPlan, finite_part
from pendpin.integrators.events import Stepper, Steps, integrate_to_event
from pendpin.scene import METHODS, Method, Scene, method_of
from pendpin.scene.methods import MULTISTEP

OF_MULTISTEP = 0.01  # of the tolerance: that of BDF and LSODA, which begin anew with order 1 at every event
FEWEST = 2.0  # first steps
WINDOW = 12_000.0  # first steps times operations: how far the first of the steps up to an event go
GROWTH = 3.0  # from these steps to the next: a search costs as much as some steps
_MEGABYTES = 2000  # that CyRK's output may take
_NO_LIMIT = 1e300  # s, on the size of a step


class StateScales(NamedTuple):
    """What errors of the numbers of a state are compared with."""

    size: Array  # (size,), of each number: what is of order one
    relative: Mask  # (size,), whether errors may be larger where the number itself is: not of positions near a stop


class Adaptive(Integrator):
    """A method of CyRK and SciPy with one tolerance, relative and absolute (rad, rad/s) alike, up to events too."""

    # With `in_machine_code` its equations are those of a compiled engine, and CyRK's loops call them directly.

    def __init__(self, method: Method, setting: float, in_machine_code: bool = False) -> None:
        super().__init__(method, setting)
        self.tolerance, self._in_machine_code, self._progress = setting, in_machine_code, _Progress(lambda t: None)
        self.library = "CyRK"
        if not in_machine_code:
            try:
                from CyRK import pysolve_ivp

                self._cyrk_solve = pysolve_ivp
            except ImportError:
                self.library = "scipy"
        self.version = version(self.library)
        # the program that makes the steps up to events
        self.event_library = "CyRK" if in_machine_code and method.family != MULTISTEP else "scipy"

    @classmethod
    def for_scene(cls, scene: Scene, dynamics: Dynamics) -> "Adaptive":
        """The method with the scene's tolerance; its loop in machine code where the equations are compiled."""
        assert scene.solver.tolerance is not None
        in_machine_code = dynamics.engine.compiles and cyrk() is not None
        return cls(method_of(scene.solver.method), scene.solver.tolerance, in_machine_code)

    def equations(self, engine: Engine, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """The derivative and its count; in machine code those of the engine's block."""
        block = self.compiled_block(engine, progress)
        return engine.derivative(progress) if block is None else (derivative_of(block), lambda: block.calls)

    def integrate(self, derivative: Derivative, y: Array, times: Array, plan: StepPlan = FREE) -> Segment:
        """The states (n, size) by CyRK or SciPy, within the tolerance a step; in machine code without `derivative`."""
        times, tolerance = np.ascontiguousarray(times), self.tolerance
        if self._in_machine_code:
            self._progress.error, both = None, np.array([tolerance])
            call = Call(self.method.library_name, self.block, both, both, plan.first or 0.0, plan.longest)
            solution = call.solved(y, times[0], times[-1], times)
            self._progress.raise_error()
            return Segment(*finite_part(solution.states(y), solution.steps, solution.failure))
        first_step = plan.first and min(plan.first, (times[-1] - times[0]) / 2, plan.longest)
        if self.library == "CyRK":
            # Radau without a Jacobian: ABA's derivatives saved 25 % with SciPy and nothing with CyRK (docs/accuracy.md).
            setting = {"rtol": tolerance, "atol": tolerance, "first_step": first_step or 0.0, "max_step": plan.longest}
            method, span = self.method.library_name, (times[0], times[-1])
            result = self._cyrk_solve(
                derivative, span, np.ascontiguousarray(y), method=method, t_eval=times, pass_dy_as_arg=True, **setting
            )
            states = np.array(result.y).T.copy() if np.size(result.y) else np.array(y[None])  # it may fail at once
            failure = None if result.success else result.message.rstrip(".")
            return Segment(*finite_part(states, result.steps_taken, failure))
        scales = StateScales(np.ones(len(y)), np.ones(len(y), bool))
        stepper = OnSciPy(self.method, tolerance, scales, first_step, plan.longest, derivative)
        return Segment(*finite_part(*_without_events(stepper, y, times)))

    def compiled_block(self, engine: Engine, progress: ProgressCallback) -> Block | None:
        """The equations of a compiled engine; None if the method calls them from Python."""
        if not self._in_machine_code:
            return None
        self.block, self._progress = engine.block(), _Progress(progress)
        answers = self._progress.answers()
        next(answers)
        self.block.on_progress(answers.send)
        return self.block

    def stepper(self, scales: StateScales, rate: float, longest: float, derivative: Derivative) -> Stepper:
        """The steps with tolerances relative to scales: by CyRK where a method of one step runs in machine code.

        `rate`, of the motion in 1/s, gives the first step; that of a multistep method is of order 1.
        """
        first_step = self.tolerance ** (1 / ((self.method.order or 1.0) + 1)) / rate
        if self.event_library == "scipy":
            return OnSciPy(self.method, self.step_tolerance, scales, first_step, longest, derivative)
        self._progress.error = None
        atol, rtol = self.tolerance * scales.size, np.maximum(self.tolerance * scales.relative, LEAST_RTOL)
        call = Call(self.method.library_name, self.block, rtol, atol, first_step, longest)
        return InMachineCode(call, self._progress.raise_error)

    @property
    def step_tolerance(self) -> float:
        """The tolerance of the steps up to an event."""
        if self.method.family == MULTISTEP:
            return max(OF_MULTISTEP * self.tolerance, min(self.tolerance, LEAST_RTOL))
        return self.tolerance


@dataclass
class _Progress:
    """The progress callback of a run, and what it raised; apart from the method: a cycle would keep Pinocchio's data."""

    callback: ProgressCallback
    error: BaseException | None = None

    def raise_error(self) -> None:
        """Raise what the callback has raised."""
        if self.error is not None:
            raise self.error

    def answers(self) -> Generator[bool, float, None]:
        """Call the callback with each t that is sent; an exception is raised after CyRK has returned."""
        # A function that CyRK calls would begin outside its `try`, and Python raises there what Ctrl-C left pending.
        while True:
            try:
                while True:
                    t = yield self.error is not None
                    if self.error is None:
                        self.callback(t)
            except GeneratorExit:
                return
            except BaseException as error:
                self.error = error


def derivative_of(block: Block) -> Derivative:
    """The equations of a block, called from Python."""

    def derivative(dy: Array, t: float, y: Array) -> None:
        dy[:] = block.evaluated(np.array([t]), y[None])[0][0]

    return derivative


@dataclass(frozen=True, eq=False)
class OnSciPy(Stepper):
    """A method of SciPy; its first step follows from the rates of the motion."""

    method: Method
    tolerance: float
    scales: StateScales
    first_step: float | None  # s; SciPy chooses one if it is None
    longest: float  # s, of a step
    derivative: Derivative

    def steps(self, t: float, y: Array, end: float) -> Iterator[Steps]:
        from scipy import integrate  # late: it takes 0.2 s

        (size, relative), origin = self.scales, np.zeros_like(y)  # the origin is that from which SciPy counts the state
        if not relative.all():  # SciPy has one relative tolerance: the change of the state is integrated
            size, origin = size + np.where(relative, np.abs(y), 0.0), y

        def rates(t: float, change: Array) -> Array:
            dy = np.empty_like(y)
            self.derivative(dy, t, origin + change)
            if not np.isfinite(dy).all():  # RK45 and DOP853 hang on NaN at the start, and LSODA returns it as a success
                raise FloatingPointError
            return dy

        first_step = self.first_step and min(self.first_step, self.longest, end - t)
        tolerances: Any = {"rtol": max(self.tolerance, LEAST_RTOL), "atol": self.tolerance * size}
        limits, failure = {"first_step": first_step, "max_step": self.longest}, None
        begin, before = t, y
        try:
            solver = getattr(integrate, self.method.library_name)(rates, t, y - origin, end, **tolerances, **limits)
            while solver.status == "running" and not (failure := solver.step()):
                states, dense = np.stack([before, origin + solver.y]), cache(solver.dense_output)
                yield Steps(np.array([begin, solver.t]), states, lambda s, dense=dense: origin + dense()(s).T)
                begin, before = solver.t, states[1]
        except FloatingPointError:
            failure = NOT_FINITE
        if failure:
            yield Steps(np.array([begin]), before[None], lambda s: np.empty((0, len(y))), failure)


@dataclass(frozen=True, eq=False)
class InMachineCode(Stepper):
    """A method of CyRK on equations in machine code, in their present mode."""

    call: "Call"
    raised: Callable[[], None]  # raises what the progress callback raised
    ahead: float = 0.0  # s, how far the first of the steps go at least

    def steps(self, t: float, y: Array, end: float) -> Iterator[Steps]:
        """Steps from y (size,), some at a time, more and more: those behind an event are made in vain."""
        call, span = self.call, max(FEWEST, WINDOW / self.call.block.operations) * self.call.first_step
        span = max(span, self.ahead)
        while t < end:
            stop = end if end - t < 2 * span else t + span
            solution = call.solved(y, t, stop, dense=True)
            self.raised()
            states, _, failure = finite_part(solution.states(y), 0, solution.failure)
            bounds = solution.times(t)[: len(states)]
            if failure and len(bounds) > 1:  # the good ones again: after a failure CyRK does not interpolate
                solution = call.solved(y, t, bounds[-1], dense=True)
            yield Steps(bounds, states, solution.inside, failure)
            if failure:
                return
            call, span = call._replace(first_step=float(np.diff(bounds).max())), GROWTH * span
            t, y = float(bounds[-1]), states[-1]

    def state_at(self, t: float, y: Array, end: float) -> Array:
        """The state (size,) at `end`, by CyRK's loop."""
        return self.call.solved(y, t, end).states(y)[-1] if end > t else y


def block_stepper(
    block: Block, rtol: float, atol: Array, first_step: float, longest: float, raised: Callable[[], None], ahead: float
) -> Stepper:
    """The steps of DOP853 on a block's equations within rtol, atol (size,); `raised` raises what its callback wants to."""
    if cyrk() is not None:
        return InMachineCode(Call("DOP853", block, np.array([rtol]), atol, first_step, longest), raised, ahead)
    scales = StateScales(atol / rtol, np.ones(len(atol), bool))
    return OnSciPy(METHODS["dop853"], rtol, scales, first_step, longest, derivative_of(block))


def block_states(block: Block, rtol: float, atol: Array, longest: float, y: Array, times: Array) -> Array:
    """The states (n, size) of a block's equations at times (n,) by DOP853, from y (size,); fewer where it stops."""
    if times[-1] == times[0]:
        return np.repeat(y[None], len(times), 0)
    times = np.ascontiguousarray(times)
    if cyrk() is not None:
        return (
            Call("DOP853", block, np.array([rtol]), atol, 0.0, longest).solved(y, times[0], times[-1], times).states(y)
        )
    scales = StateScales(atol / rtol, np.ones(len(y), bool))
    stepper = OnSciPy(METHODS["dop853"], rtol, scales, None, longest, derivative_of(block))
    return _without_events(stepper, y, times)[0]


def _without_events(stepper: Stepper, y: Array, times: Array) -> tuple[Array, int, str | None]:
    """The states (n, size) at times (n,) by SciPy's steps, how many steps they take, and why they stop early."""
    end = integrate_to_event(stepper, lambda t, y: y[:, :0], np.empty(0), times[0], y, times[-1], times[1:])
    return np.concatenate([y[None], end.samples]), end.steps, end.failure


# --- CyRK's solver in C++, without importing CyRK: that imports Numba, 0.17 to 0.3 s where a first run takes 0.1 s ---
#
# CyRK documents nbsolve2_ivp, which Numba compiles for each caller, and no way to its solver without that import (0.20: the
# module that holds the addresses imports the package). So its functions are found by their C++ names, which spell out the
# types of the arguments: a CyRK with another interface is not used, and a note says so. The numbers of the methods are
# those of the versions named in SERIES.

SERIES = "0.20."
# The places of CyRK's enum ODEMethod, which no exported function tells: a new series has to be looked at before it is used.
PLACES = {"RK23": 3, "RK45": 4, "DOP853": 5, "BDF": 6, "LSODA": 7, "Radau": 8}

_RATE_TIMES_STATE = (c_void_p, c_double, c_double, c_void_p, c_size_t)
_SIZES = (c_int, c_size_t, c_size_t, c_void_p, c_size_t, c_size_t, c_size_t, c_bool)
_OUTPUT_EVENTS = (c_void_p, c_size_t, c_void_p, c_void_p, c_size_t)
_TOLERANCES_STEPS = (c_void_p, c_size_t, c_void_p, c_size_t, c_double, c_double, c_bool)
# As `nm -D --defined-only` prints them for CyRK's nb/numba_c_api*.so. The letters behind a function's name are the types of
# its arguments (c++filt writes them out), so that a changed argument changes the name, and the symbol is not found.
_NAMES: dict[str, tuple[str, Any, tuple[Any, ...]]] = {  # C++ name, type of the result, types of the arguments
    "solve": (
        "_Z17numba_cysolve_ivpPFvPddS_PcPFvS0_dS_S0_EEddS_m9ODEMethodmmS0_mmmbS_mS2_P5EventmS_mS_mddb",
        c_void_p,
        _RATE_TIMES_STATE + _SIZES + _OUTPUT_EVENTS + _TOLERANCES_STEPS,
    ),
    "free": ("_Z13cysolver_freePv", None, (c_void_p,)),
    "success": ("_Z20cysolver_get_successPv", c_bool, (c_void_p,)),
    "steps": ("_Z24cysolver_get_steps_takenPv", c_size_t, (c_void_p,)),
    "size": ("_Z17cysolver_get_sizePv", c_size_t, (c_void_p,)),
    "times": ("_Z18cysolver_get_t_ptrPv", c_void_p, (c_void_p,)),
    "states": ("_Z18cysolver_get_y_ptrPv", c_void_p, (c_void_p,)),
    "inside": ("_Z28cysolver_call_call_vectorizePvPKdmPd", c_int, (c_void_p, c_void_p, c_size_t, c_void_p)),
    "message": ("_Z27cysolver_get_message_bufferPvPcm", None, (c_void_p, c_void_p, c_size_t)),
}


@cache
def cyrk() -> Any:
    """The functions by the names above; None if this CyRK, or this processor, does not have them: with a note, once."""
    if not is_there("CyRK"):
        return None
    installed, reason = version("CyRK"), "this processor has no AVX2"
    *_, features = llvm.processor()
    if b"-avx2" not in features.split(b","):  # which CyRK for x86 needs; others have no such feature to lack
        reason = f"pendpin uses CyRK {SERIES}x: pip install 'CyRK=={SERIES}*'"
        with suppress(OSError, AttributeError, ValueError):
            if installed.startswith(SERIES):
                return c_functions("CyRK", "nb/numba_c_api.*.so", _NAMES)
    say_unused(f"CyRK {installed}", reason)
    return None


class Call(NamedTuple):
    """The arguments of CyRK's solver that stay the same."""

    method: str
    block: Block
    rtol: Array  # (1,) or (size,)
    atol: Array  # (1,) or (size,)
    first_step: float
    longest: float

    def solved(self, y: Array, t: float, end: float, times: Array | None = None, dense: bool = False) -> "Solution":
        """The solution from y (size,) at t to `end`, at `times` (n,) or where the steps end."""
        y = np.ascontiguousarray(y)
        first_step = min(self.first_step, (end - t) / 2, self.longest)  # CyRK refuses more than a half
        at = (None, 0) if times is None else (times.ctypes.data, len(times))
        pointer = cyrk().solve(
            *(self.block.function.code().address, t, end, y.ctypes.data, len(y), PLACES[self.method], 0, 0),
            *(self.block.address, ctypes.sizeof(ctypes.c_void_p), 0, _MEGABYTES, dense),
            *(*at, None, None, 0),
            *(self.rtol.ctypes.data, len(self.rtol), self.atol.ctypes.data, len(self.atol)),
            *(min(self.longest, _NO_LIMIT), first_step, False),
        )
        return Solution(pointer, len(y))


class Solution:
    """What CyRK returned; it lives as long as this object."""

    def __init__(self, pointer: int, size: int) -> None:
        self._pointer, self._api, self._size = pointer, cyrk(), size
        self._count = self._api.size(pointer)  # of states
        self.steps: int = self._api.steps(pointer)
        self.failure: str | None = None
        if not self._api.success(pointer):
            text = ctypes.create_string_buffer(256)
            self._api.message(pointer, ctypes.addressof(text), len(text))
            self.failure = text.value.decode().rstrip(".")

    def __del__(self) -> None:
        self._api.free(self._pointer)

    def times(self, start: float) -> Array:
        """The times (n,) in s of the states; of the start alone where there are none."""
        return self._copied(self._api.times, self._count) if self._count else np.array([start])

    def states(self, y: Array) -> Array:
        """The states (n, size); the start y (size,) alone where there are none."""
        return self._copied(self._api.states, self._count, self._size) if self._count else y[None].copy()

    def inside(self, t: Array) -> Array:
        """The interpolation of the steps, (n, size) at times (n,)."""
        t, out = np.ascontiguousarray(t), np.empty((len(t), self._size))
        if len(t):
            self._api.inside(self._pointer, t.ctypes.data, len(t), out.ctypes.data)
        return out

    def _copied(self, pointer: Callable[[int], int], *shape: int) -> Array:
        """A copy of the array at a pointer."""
        out = np.empty(shape)
        ctypes.memmove(out.ctypes.data, pointer(self._pointer), out.nbytes)
        return out
