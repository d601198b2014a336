"""Methods with a fixed step, the baseline of games and robot simulators: classical Runge-Kutta and semi-implicit Euler.

The step asked is the step made, wherever the samples are. A sample inside a step is computed by a shorter step of the same
method from the end of the last full one, which then continues as if the sample had not been: it has the order of the method.
The last step of a run may so be shorter.
"""

import math
from abc import abstractmethod
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pendpin.engines import Derivative, Engine, ProgressCallback
from pendpin.errors import InputError
from pendpin.ground.arrays import Array
from pendpin.integrators.base import FREE, NOT_FINITE, Integrator, Segment, StepPlan, finite_part

LOOK_EVERY = 1024  # steps between two checks that the numbers are finite
NEAR = 1e-9  # of a step: a sample so near to the end of a step is there

Advance = Callable[[float, float, int], None]  # t, h, steps: advances a state in place by `steps` steps of h
Step = Callable[[float, float], None]  # the same for one step


def count_equal_steps(interval: float, step: float) -> int:
    """How many equal steps of at most `step` make an interval, both in s."""
    # 2.1 / 0.3 is 7.000000000000001, and the time between two samples at 60 Hz often is 1/60 s and a rounding: what rounding
    # has put above a whole number is that number, not one step more.
    return max(1, math.ceil(interval / step * (1 - 1e-9)))


def count_whole_steps(interval: float, step: float) -> int:
    """How many whole steps fit into an interval, both in s."""
    return math.floor(interval / step + NEAR)


def largest_step(times: Array, step: float | None) -> float | None:
    """The largest step over output times (n,) in s: the one asked, or all of a shorter run; None if none is asked."""
    return None if step is None else min(step, float(times[-1] - times[0]) or step)


class GridPlace(NamedTuple):
    """Where the stored state of a method with fixed steps is, on steps of one size that are counted from an origin.

    It is at the end of a step; or inside one, behind a corner of what acts, from which it goes on to that end.
    """

    origin: float = 0.0  # s
    steps: int = -1  # whole ones since then; -1 before the first step of a run
    offset: float = 0.0  # s, behind the origin

    def enter(self, t: float, plan: StepPlan) -> tuple["GridPlace", bool]:
        """Where a segment from t in s begins, and whether t was behind the stored state, inside a step."""
        place = GridPlace(t, 0, 0.0) if self.steps < 0 else self
        inside = t != place.origin + place.offset
        return (place._replace(offset=t - place.origin) if plan.anew and inside else place), inside

    def go_to(self, t: float, step: float) -> tuple["GridPlace", list[tuple[float, int, float]], tuple[float, float]]:
        """How to reach a sample at t in s by steps of a size in s: the place after it, and the steps.

        These are blocks of equal steps (start, count, length): as long as asked, to the rounding of the times of samples, or
        shorter after a corner. Then one shorter step (start, length), of length 0 where a block ends at the sample.
        """
        # Differences are taken from the origin: beside a late time a short one, as that of a pulse, would lose its digits.
        (origin, done, offset), blocks = self, list[tuple[float, int, float]]()
        elapsed = t - origin
        count = max(done, count_whole_steps(elapsed, step))
        at_end = count > done and abs(elapsed - count * step) <= NEAR * step
        end = elapsed if at_end else count * step
        if count > done and offset > done * step:  # behind a corner
            first = end if count == done + 1 else (done + 1) * step
            blocks.append((origin + offset, 1, first - offset))
            done, offset = done + 1, first
        if steps := count - done:
            blocks.append((origin + offset, steps, (end - offset) / steps if at_end else step))
            done, offset = count, end
        if at_end:
            return GridPlace(t, 0, 0.0), blocks, (origin + offset, 0.0)
        return GridPlace(origin, done, offset), blocks, (origin + offset, max(elapsed - offset, 0.0))


def last_step_end(times: Array, step: float) -> int:
    """The last of the output times (n,) in s of a run, rising, at which one of its steps of this size in s ends."""
    place, last = GridPlace(float(times[0]), 0), 0
    for sample, t in enumerate(times.tolist()):
        place, _, _ = place.go_to(t, step)
        last = sample if place.origin == t else last
    return last


class FixedMemory(NamedTuple):
    """What a method with a fixed step keeps from segment to segment."""

    place: GridPlace
    state: Array  # (size,), at the end of the last step


class FixedStep(Integrator):
    """A method with a fixed step; samples inside a step are computed by a shorter one."""

    library, version = "numpy", np.__version__

    def memory(self, y: Array) -> FixedMemory:
        return FixedMemory(GridPlace(), np.array(y))

    def integrate(self, derivative: Derivative, y: Array, times: Array, plan: StepPlan = FREE) -> Segment:
        memory = plan.memory or self.memory(y)
        assert isinstance(memory, FixedMemory)
        place, inside = memory.place.enter(float(times[0]), plan)
        states, steps = np.full((len(times), len(y)), np.nan), 0
        whole = np.array(y if plan.anew or not inside else memory.state)
        part = whole.copy()
        advance, finish = self.advancing(derivative, whole), self.advancing(derivative, part)
        states[0] = y
        for sample, t in enumerate(times[1:].tolist(), 1):
            place, blocks, (last, left) = place.go_to(t, self.setting)
            for start, count, step in blocks:
                for done in range(0, count, LOOK_EVERY):
                    if done and not np.isfinite(whole).all():
                        return Segment(*finite_part(states, steps + done, NOT_FINITE))
                    advance(start + done * step, step, min(LOOK_EVERY, count - done))
                steps += count
            part[:] = whole
            if left:
                finish(last, left, 1)
            states[sample] = part
        return Segment(*finite_part(states, steps, None), FixedMemory(place, whole))

    def advancing(self, derivative: Derivative, y: Array) -> Advance:
        """A function that advances y (size,), in place, by some steps from t."""
        step = self.stepping(derivative, y)

        def advance(t: float, h: float, steps: int) -> None:
            for i in range(steps):
                step(t + i * h, h)

        return advance

    @abstractmethod
    def stepping(self, derivative: Derivative, y: Array) -> Step:
        """A function that advances y (size,), in place, by one step from t to t + h."""


class RungeKutta4(FixedStep):
    """The classical method of four stages, order 4 (W. Kutta 1901), on any engine's state; compiled on a compiled engine."""

    def equations(self, engine: Engine, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """The engine's derivative, and its block, in which a compiled loop counts calls too."""
        derivative, calls = engine.derivative(progress)
        self._block, self._progress = engine.block() if engine.compiles else None, progress
        self._normalise = engine.normalise
        return derivative, lambda: calls() + (self._block.calls if self._block else 0)

    def advancing(self, derivative: Derivative, y: Array) -> Advance:
        block = self._block
        if block is None or len(y) != block.size:
            return super().advancing(derivative, y)
        steps, work = block.function.code().steps, np.empty(5 * len(y))

        def advance(t: float, h: float, count: int) -> None:
            steps(y.ctypes.data, t, h, count, block.address, work.ctypes.data)
            self._progress(t)

        return advance

    def stepping(self, derivative: Derivative, y: Array) -> Step:
        """A classical Runge-Kutta step of y (size,); unit vectors in it stay unit vectors, however a run is cut."""
        normalise = self._normalise
        k1, k2, k3, k4, inner = np.empty((5, len(y)))

        def stage(k: Array, t: float, before: Array, h: float) -> None:
            np.multiply(before, h, out=inner)
            np.add(y, inner, out=inner)
            derivative(k, t, inner)

        def advance(t: float, h: float) -> None:
            derivative(k1, t, y)
            stage(k2, t + h / 2, k1, h / 2)
            stage(k3, t + h / 2, k2, h / 2)
            stage(k4, t + h, k3, h)
            y[:] += h / 6 * (k1 + 2 * (k2 + k3) + k4)
            normalise(y)

        return advance


class SemiImplicitEuler(FixedStep):
    """v += h a(t, q, v), then q += h v with the new v: order 1, on angles (also called symplectic Euler)."""

    def equations(self, engine: Engine, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """The derivative of an engine whose state is (q, v). Raises InputError for another engine."""
        if not engine.on_angles:
            raise InputError("solver.method: euler needs angles as the state: leave solver.engine out")
        self._nv = len(engine.model.joints)
        return engine.derivative(progress)

    def stepping(self, derivative: Derivative, y: Array) -> Step:
        """A step of y (size,): v, then q with the new v; further integrated quantities are advanced with v."""
        dy, nv = np.empty_like(y), self._nv
        q, v, others, rates = y[:nv], y[nv : 2 * nv], y[nv:], dy[nv:]

        def advance(t: float, h: float) -> None:
            derivative(dy, t, y)
            others[:] += h * rates
            q[:] += h * v

        return advance
