"""The adaptive methods on compiled equations, without a call from Python: CyRK's loops call the machine code themselves.

CyRK has this interface for Numba; no Numba function is compiled here.
"""

import ctypes
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pendpin.engines import Derivative, Engine, ProgressCallback
from pendpin.engines.machine.code import Block
from pendpin.ground.arrays import Array, address
from pendpin.ground.libraries import version
from pendpin.integrators import cyrk
from pendpin.integrators.base import FREE, LEAST_RTOL, Segment, StepPlan, finite_part
from pendpin.integrators.events import EventIntegrator, OnSciPy, StateScales, Stepper, Steps
from pendpin.scene import METHODS, Method
from pendpin.scene.methods import MULTISTEP

_MEGABYTES = 2000  # that its output may take
FEWEST = 2.0  # first steps
WINDOW = 12_000.0  # first steps times operations: how far the first of the steps up to an event go
GROWTH = 3.0  # from these steps to the next: a search costs as much as some steps
_NO_LIMIT = 1e300  # s, on the size of a step


class AdaptiveInMachineCode(EventIntegrator):
    """The adaptive methods on equations in machine code; only if `available` is true."""

    library = "CyRK"

    def __init__(self, method: Method, setting: float) -> None:
        super().__init__(method, setting)
        self._method, self._tolerance = cyrk.METHODS[method.library_name], np.array([setting])
        self._progress = _Progress(lambda t: None)
        self.version = version(self.library)
        self.event_library = self.library if method.family != MULTISTEP else "scipy"

    def equations(self, engine: Engine, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """The equations of a compiled engine, which the loops call directly."""
        block = self.compiled_for_events(engine, progress)

        def derivative(dy: Array, t: float, y: Array) -> None:
            dy[:] = block.evaluated(np.array([t]), y[None])[0][0]

        block.code()  # compiled here
        return derivative, lambda: block.calls

    def integrate(self, derivative: Derivative, y: Array, times: Array, plan: StepPlan = FREE) -> Segment:
        """The states (n, size), within the tolerance a step, with no call of `derivative`."""
        self._progress.error = None
        code, tolerance, times = self.block.code(), self._tolerance, np.ascontiguousarray(times)
        call = Call(self._method, code.address, self.block, tolerance, tolerance, plan.first or 0.0, plan.longest)
        solution = call.solved(y, times[0], times[-1], times)
        self._progress.raise_error()
        return Segment(*finite_part(solution.states(y), solution.steps, solution.failure))

    def compiled_for_events(self, engine: Engine, progress: ProgressCallback) -> Block:
        """The equations of a compiled engine."""
        self.block, self._progress = engine.block(), _Progress(progress)
        answers = self._progress.answers()
        next(answers)
        self.block.on_progress(answers.send)
        return self.block

    def stepper(self, scales: StateScales, first_step: float, longest: float, derivative: Derivative) -> Stepper:
        """The steps with tolerances relative to scales: of methods of one step by CyRK."""
        if self.method.family == MULTISTEP:
            return super().stepper(scales, first_step, longest, derivative)
        self._progress.error = None
        atol, rtol = self.tolerance * scales.size, np.maximum(self.tolerance * scales.relative, LEAST_RTOL)
        call = Call(self._method, self.block.code().address, self.block, rtol, atol, first_step, longest)
        return InMachineCode(call, self._progress.raise_error)


@dataclass
class _Progress:
    """The progress callback of a run, and what it raised.

    It stands apart from the method: a block that refers to the method which refers to the block would stay in memory, and
    Pinocchio's data with it.
    """

    callback: ProgressCallback
    error: BaseException | None = None

    def raise_error(self) -> None:
        """Raise what the callback has raised."""
        if self.error is not None:
            raise self.error

    def answers(self) -> Generator[bool, float, None]:
        """Call the callback with each t that is sent; an exception is raised after CyRK has returned.

        A function that CyRK calls would begin outside its `try`, and Python raises there what Ctrl-C left pending.
        """
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


@dataclass(frozen=True, eq=False)
class InMachineCode(Stepper):
    """A method of CyRK on equations in machine code, in their present mode."""

    call: "Call"
    raised: Callable[[], None]  # raises what the progress callback raised

    def steps(self, t: float, y: Array, end: float) -> Iterator[Steps]:
        """Steps from y (size,), some at a time, more and more: those behind an event are made in vain."""
        call, span = self.call, max(FEWEST, WINDOW / self.call.block.operations) * self.call.first_step
        while t < end:
            stop = end if end - t < 2 * span else t + span
            part = self._part(call, t, y, stop)
            yield part
            if part.failure:
                return
            call, span = call._replace(first_step=float(np.diff(part.bounds).max())), GROWTH * span
            t, y = float(part.bounds[-1]), part.states[-1]

    def _part(self, call: "Call", t: float, y: Array, end: float) -> Steps:
        """All steps from y (size,) at t to `end`; the good ones again after a failure, when CyRK does not interpolate."""
        solution = call.solved(y, t, end, dense=True)
        self.raised()
        states, _, failure = finite_part(solution.states(y), 0, solution.failure)
        bounds = solution.times(t)[: len(states)]
        if failure and len(bounds) > 1:
            solution = call.solved(y, t, bounds[-1], dense=True)
        return Steps(bounds, states, solution.inside, failure)

    def state_at(self, t: float, y: Array, end: float) -> Array:
        """The last state (size,)."""
        return self.call.solved(y, t, end).states(y)[-1] if end > t else y


def block_stepper(
    block: Block, rtol: float, atol: Array, first_step: float, longest: float, raised: Callable[[], None]
) -> Stepper:
    """The steps of DOP853 on the equations of a block up to events, within rtol and atol (size,): by CyRK, else by SciPy.

    `raised` raises what the block's progress callback wants to raise.
    """
    if available():
        call = Call(cyrk.METHODS["DOP853"], block.code().address, block, np.array([rtol]), atol, first_step, longest)
        return InMachineCode(call, raised)

    def derivative(dy: Array, t: float, y: Array) -> None:
        dy[:] = block.evaluated(np.array([t]), y[None])[0][0]

    scales = StateScales(atol / rtol, np.ones(len(atol), bool))
    return OnSciPy(METHODS["dop853"], rtol, scales, first_step, longest, derivative)


class Call(NamedTuple):
    """The arguments of CyRK's solver that stay the same."""

    method: int
    address: int
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
        pointer = cyrk.library().solve(
            *(self.address, t, end, address(y), len(y), self.method, 0, 0),
            *(self.block.address, ctypes.sizeof(ctypes.c_void_p), 0, _MEGABYTES, dense),
            *(*at, None, None, 0),
            *(address(self.rtol), len(self.rtol), address(self.atol), len(self.atol)),
            *(min(self.longest, _NO_LIMIT), first_step, False),
        )
        return Solution(pointer, len(y))


class Solution:
    """What CyRK returned; it lives as long as this object."""

    def __init__(self, pointer: int, size: int) -> None:
        self._found, self._api, self._size = pointer, cyrk.library(), size
        self._count = self._api.size(pointer)  # of states
        self.failure: str | None = None
        if not self._api.success(pointer):
            text = ctypes.create_string_buffer(256)
            self._api.message(pointer, ctypes.addressof(text), len(text))
            self.failure = text.value.decode().rstrip(".")

    def __del__(self) -> None:
        self._api.free(self._found)

    @property
    def steps(self) -> int:
        """How many steps there were."""
        return self._api.steps(self._found)

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
            self._api.inside(self._found, address(t), len(t), address(out))
        return out

    def _copied(self, pointer: Callable[[int], int], *shape: int) -> Array:
        """A copy of the array at a pointer."""
        out = np.empty(shape)
        ctypes.memmove(address(out), pointer(self._found), out.nbytes)
        return out


def available() -> bool:
    """Whether CyRK's loops accept the address of a compiled function."""
    return cyrk.library() is not None
