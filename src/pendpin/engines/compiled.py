"""Engines on the state of another: without the numbers that stay 0, and with y' by machine code."""

import time
from collections.abc import Callable
from functools import cached_property

import numpy as np

from pendpin.effects import Motion
from pendpin.engines.base import CALLBACK_EVERY, Derivative, Engine, ProgressCallback, Sample, count_calls
from pendpin.engines.machine.code import Block, Fixed, Function, Values
from pendpin.ground.arrays import Array


class Wrapping(Engine):
    """An engine on the state of another, its base, which does what a subclass does not do itself."""

    def __init__(self, base: Engine) -> None:
        super().__init__(base.model, base.loads)
        self.base, self.name, self.on_angles = base, base.name, base.on_angles

    def whole(self, y: Array) -> Array:
        """The base engine's states (..., size) from its own."""
        return y

    def pack(self, q: Array, v: Array) -> Array:
        return self.base.pack(q, v)

    def unpack(self, t: Array, y: Array, near: Array) -> tuple[Array, Array]:
        return self.base.unpack(t, self.whole(y), near)

    def density(self, y: Array) -> float:
        return self.base.density(self.whole(y))

    def project(self, y: Array) -> Array:
        return self.base.project(self.whole(y))

    def motion(self, y: Array) -> Motion:
        return self.base.motion(self.whole(y))

    def evaluate(self, t: Array, q: Array, v: Array, torque: Array | None = None) -> Sample:
        return self.base.evaluate(t, q, v, torque)


class Moving(Wrapping):
    """Another engine without the numbers of its state that stay 0 in a motion, as phi does in a plane of theta.

    Only motions that begin with these numbers 0 can be integrated.
    """

    def __init__(self, base: Engine, still: tuple[int, ...]) -> None:
        super().__init__(base)
        self.symbolic, self.still = base.symbolic, still
        self._size = len(base.pack(*np.zeros((2, len(base.model.joints)))))
        self.places = np.setdiff1d(np.arange(self._size), still)

    def pack(self, q: Array, v: Array) -> Array:
        """What moves of the state (size,) at q, v (nv,). Raises ValueError for a state in which more moves."""
        y = self.base.pack(q, v)
        if y[list(self.still)].any():
            raise ValueError("the motion leaves the plane for which its equations were written")
        return y[self.places]

    def whole(self, y: Array) -> Array:
        """The base engine's states (..., size), from what moves of them."""
        states = np.zeros((*y.shape[:-1], self._size))
        states[..., self.places] = y
        return states

    def project(self, y: Array) -> Array:
        """What moves of the base engine's projection (size,)."""
        return super().project(y)[self.places]

    def derivative(self, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """y' by the base engine."""
        function, calls = self.base.derivative(progress)
        rates = np.empty(self._size)

        def derivative(dy: Array, t: float, y: Array) -> None:
            function(rates, t, self.whole(y))
            dy[:] = rates[self.places]

        return derivative, calls


class Compiled(Wrapping):
    """The state, poses and wrenches of another engine, and y' by machine code, with one set of parameters.

    Many engines share the `equations` of one structure (pendpin.dynamics.compiling keeps them); each run has its block.
    """

    compiles = True
    symbolic = False

    def __init__(self, base: Engine, equations: Function, values: Values, took: float) -> None:
        super().__init__(base)
        self.equations, self.name = equations, f"{base.name}, compiled"
        self._values, self.compile_seconds = values, took

    def _took(self, seconds: float) -> None:
        self.compile_seconds += seconds

    @cached_property
    def _fixed(self) -> Fixed:
        begin = time.thread_time()
        _ = self.equations.text  # recorded here, the first time
        self._took(time.thread_time() - begin)
        return self.equations.fixed(self._values)

    @property
    def size(self) -> int:
        """How many numbers the state has."""
        return self.equations.recording.size_of(len(self._fixed.of_rods))

    def block(self) -> Block:
        """The arguments of the function for one run."""
        return Block(self.equations, self._fixed, self._took)

    def normalise(self, y: Array) -> None:
        """The base engine's, of a state (size,); steps in machine code do it themselves."""
        self.base.normalise(y)

    def accelerate(self, t: float, q: Array, v: Array) -> Array:
        """q'' (nv,) by the base engine, not compiled."""
        return self.base.accelerate(t, q, v)

    def derivative(self, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """y' by machine code, which is compiled here."""
        block, size = self.block(), self.size
        code, state, rates = block.code(), np.zeros(size), np.zeros(size)
        call, arguments = code.call, (rates.ctypes.data, state.ctypes.data, block.address)

        def derivative(dy: Array, t: float, y: Array) -> None:
            state[:] = y
            call(arguments[0], t, arguments[1], arguments[2], None)
            dy[:] = rates

        derivative.needs = block, code  # type: ignore[attr-defined]  # they live as long as the function
        return count_calls(derivative, progress, CALLBACK_EVERY)
