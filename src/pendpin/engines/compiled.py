"""Engines on the state of another: without the numbers that stay 0, and with y' by machine code."""

from collections.abc import Callable
from functools import cached_property

import numpy as np

from pendpin.effects import Motion
from pendpin.engines.base import (
    CALLBACK_EVERY_QUICK,
    Derivative,
    Engine,
    GivenTorque,
    ProgressCallback,
    Sample,
    count_calls,
)
from pendpin.engines.machine.llvm import Block, Function, Values
from pendpin.ground.arrays import Array


class Moving(Engine):
    """Another engine, its base, without the numbers of its state that stay 0 in a motion, as phi does in a plane.

    Only motions that begin with these numbers 0 can be integrated. All else is computed by the base, on whole states.
    """

    def __init__(self, base: Engine, still: tuple[int, ...]) -> None:
        super().__init__(base.model, base.loads)
        self.base, self.still, self.name, self.on_angles = base, still, base.name, base.on_angles
        self._whole_size = base.size
        self.places = np.delete(np.arange(self._whole_size), list(still))

    def whole(self, y: Array) -> Array:
        """The base engine's states (..., size), from what moves of them."""
        states = np.zeros((*y.shape[:-1], self._whole_size))
        states[..., self.places] = y
        return states

    def pack(self, q: Array, v: Array) -> Array:
        """What moves of the state (size,) at q, v (nv,). Raises ValueError for a state in which more moves."""
        y = self.base.pack(q, v)
        if y[list(self.still)].any():
            raise ValueError("the motion leaves the plane for which its equations were written")
        return y[self.places]

    def unpack(self, t: Array, y: Array, near: Array) -> tuple[Array, Array]:
        return self.base.unpack(t, self.whole(y), near)

    def density(self, y: Array) -> float:
        return self.base.density(self.whole(y))

    def project(self, y: Array) -> Array:
        return self.base.project(self.whole(y))[self.places]

    def normalise(self, y: Array) -> None:
        if not self.still:  # else the state has no whole directions
            self.base.normalise(y)

    def motion(self, y: Array) -> Motion:
        return self.base.motion(self.whole(y))

    def evaluate(self, t: Array, q: Array, v: Array, torque: Array | None = None) -> Sample:
        return self.base.evaluate(t, q, v, torque)

    def accelerate(self, t: float, q: Array, v: Array) -> Array:
        return self.base.accelerate(t, q, v)

    def derivative(self, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """The base's rates of the whole state, of which those that move are kept."""
        function, calls = self.base.derivative(progress)
        rates = np.empty(self._whole_size)

        def derivative(dy: Array, t: float, y: Array) -> None:
            function(rates, t, self.whole(y))
            dy[:] = rates[self.places]

        return derivative, calls


class Compiled(Moving):
    """The state, poses and wrenches of another engine, and y' by machine code, with one set of parameters.

    Many engines share the `equations` of one structure (dynamics/compiling.py keeps them); each run has its block. `given`
    torques (nv,), by functions of Python, go with every call: such equations are called from Python.
    """

    def __init__(
        self,
        base: Engine,
        still: tuple[int, ...],
        equations: Function,
        values: Values,
        seconds: float,
        given: GivenTorque | None = None,
    ) -> None:
        super().__init__(base, still)
        self._given, self.compiles = given, given is None
        self.equations, self.name = equations, f"{base.name}, compiled"
        self._values, self.compile_seconds = values, seconds

    @cached_property
    def _fixed(self) -> tuple[list[float], Array]:
        return self.equations.evaluate_fixed(self._values)  # once for all its runs: a twentieth of a short one

    def block(self) -> Block:
        """The arguments of the machine code for one run, which is compiled here."""
        took = self.equations.compile_seconds
        block = Block(self.equations, self._fixed, self._values.tables)
        block.code()
        self.compile_seconds += self.equations.compile_seconds - took
        return block

    def derivative(self, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """y' by machine code."""
        block = self.block()
        code, state, rates = block.code(), np.zeros(block.size), np.zeros(block.size)
        call, arguments = code.call, (rates.ctypes.data, state.ctypes.data, block.address)
        given, nv = self._given, len(self.model.joints)

        def derivative(dy: Array, t: float, y: Array) -> None:
            state[:] = y
            if given is not None:
                block.inputs[:] = given(t, y[:nv], y[nv:])
            call(arguments[0], t, arguments[1], arguments[2], None)
            dy[:] = rates

        derivative.needs = block, code  # type: ignore[attr-defined]  # they live as long as the function
        return count_calls(derivative, progress, CALLBACK_EVERY_QUICK)
