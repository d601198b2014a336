"""The interface of the engines, what they get from the effects of a scene, and engines on the state of another."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pendpin.effects import Motion
from pendpin.engines.machine.llvm import Block, Function, Values
from pendpin.errors import InputError
from pendpin.ground.arrays import Array, Indices
from pendpin.model.build import Model

Derivative = Callable[[Array, float, Array], None]  # f(dy, t, y) fills dy
GivenTorque = Callable[[float, Array, Array], Array]  # t, q, v -> (nv,) N m, or N for slides
ProgressCallback = Callable[[float], None]

CALLBACK_EVERY = 64  # evaluations between two calls of the progress callback: near a pole of a thin rod one takes 3 ms
CALLBACK_EVERY_QUICK = 2048  # for those of a few us, whose progress is judged over longer intervals
ROUNDING = 1e-14  # of a number that stays 0, relative to the state, where angles were computed from it


class Sample(NamedTuple):
    """Accelerations and wrenches at n states."""

    acceleration: Array  # (n, nv)
    wrench: Array  # (n, joints, 6)


@dataclass(frozen=True, eq=False)
class Loads:
    """The sum of the effects of a scene, by interface; None for an interface that the scene does not use."""

    constant: Array  # (3,) m/s², W: the sum of the constant fields
    varying: Callable[[float], Array] | None = None  # t -> (3,) m/s², W: the sum of the others
    torque: GivenTorque | None = None
    wrench: Callable[[float, Motion], tuple[Array, Array]] | None = None  # force N, moment N m about com, (n, 3), W
    axial: bool = False  # whether wrenches may turn a rod about its own axis, or ask how far it has turned

    def wrenches(self, t: Array, motion: Motion) -> tuple[Array, Array]:
        """Forces and moments (k, n, 3) as `wrench`, at times (k,) and states (k, n, ...) of the motion."""
        assert self.wrench is not None
        states = zip(t, *motion[:4], strict=True)
        force, moment = zip(*(self.wrench(time, Motion(*state)) for time, *state in states), strict=True)
        return np.array(force), np.array(moment)

    def field(self, t: float) -> Array:
        """The sum of all uniform fields at time t, (3,) m/s², W."""
        return self.constant if self.varying is None else self.constant + self.varying(t)

    def fields(self, t: Array) -> Array:
        """The same at times (k,): (k, 3), or (3,) where it is constant."""
        return self.constant if self.varying is None else np.array([self.field(time) for time in t])


class Engine(ABC):
    """One way to compute a model's motion, with its own state y and its own equations."""

    name: str
    compile_seconds: float = 0.0
    compiles = False  # whether its equations are machine code
    on_angles = False  # whether its state is y = (q, v), so that phi = ±pi/2 is singular for thin rods

    def __init__(self, model: Model, loads: Loads) -> None:
        self.model, self.loads = model, loads

    @property
    def size(self) -> int:
        """How many numbers a state has."""
        return len(self.pack(*np.zeros((2, len(self.model.joints)))))

    @abstractmethod
    def pack(self, q: Array, v: Array) -> Array:
        """The engine's state y from positions and velocities (nv,)."""

    @abstractmethod
    def unpack(self, t: Array, y: Array, near: Array) -> tuple[Array, Array]:
        """Positions and velocities (n, nv) from states y (n, size) at t (n,); `near` (nv,): positions at the first."""

    def density(self, y: Array) -> float:
        """The states per second that `unpack` needs to count all turns, by states y (n, size); 0 where y holds angles."""
        return 0.0

    @abstractmethod
    def project(self, y: Array) -> Array:
        """A state (size,) projected to its constraints, such as unit directions."""

    def normalise(self, y: Array) -> None:
        """Make directions and quaternions of a state (size,) unit again, in place: after every step of a fixed size."""
        return

    @abstractmethod
    def derivative(self, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """f(dy, t, y) that fills dy, and a function that counts its calls; `progress` is called with t and may raise."""

    def block(self) -> Block:
        """The arguments of the machine code for one run, where the engine `compiles`. Raises InputError elsewhere."""
        raise InputError('solver.engine: only "compiled" has equations in machine code')

    @abstractmethod
    def motion(self, y: Array) -> Motion:
        """Poses and velocities of the n bodies at a state y (size,)."""

    @abstractmethod
    def evaluate(self, t: Array, q: Array, v: Array, torque: Array | None = None) -> Sample:
        """Accelerations and joint wrenches at times (n,) and states (n, nv), with joint torques (n, nv) added."""

    def accelerate(self, t: float, q: Array, v: Array) -> Array:
        """q'' (nv,) at one state, the array the caller's own; engines override it where `evaluate` takes much longer."""
        return self.evaluate(np.array([t]), q[None], v[None]).acceleration[0]


class AngleEngine(Engine):
    """An engine whose state is y = (q, v)."""

    on_angles = True

    def pack(self, q: Array, v: Array) -> Array:
        return np.concatenate([q, v])

    def unpack(self, t: Array, y: Array, near: Array) -> tuple[Array, Array]:
        nv = len(self.model.joints)
        return y[:, :nv].copy(), y[:, nv:].copy()

    def project(self, y: Array) -> Array:
        return y  # angles have no constraints

    @abstractmethod
    def accelerate(self, t: float, q: Array, v: Array, torque: Array | None = None) -> Array:
        """q'' (nv,) at one state, with joint torques (nv,) added."""

    @abstractmethod
    def compliance(self, q: Array, joints: Indices) -> Array:
        """Columns of the inverse mass matrix, (nv, k): accelerations for a unit torque on each of k joints."""


def count_calls(
    function: Derivative, progress: ProgressCallback, every: int = CALLBACK_EVERY
) -> tuple[Derivative, Callable[[], int]]:
    """A derivative that counts its calls and calls `progress` with t at every `every`-th of them."""
    calls = 0

    def derivative(dy: Array, t: float, y: Array) -> None:
        nonlocal calls
        calls += 1
        if not calls % every:
            progress(t)
        function(dy, t, y)

    return derivative, lambda: calls


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
        most = np.abs(y[list(self.still)]).max(initial=0.0)
        if most > ROUNDING * np.abs(y).max(initial=0.0):  # a sample's own angles were computed, and are rounded
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
    torques (nv,), by functions of Python, go with every call: such equations are called from Python. They lack what a
    `Moving` engine lacks.
    """

    def __init__(
        self, engine: Engine, equations: Function, values: Values, seconds: float, given: GivenTorque | None = None
    ) -> None:
        super().__init__(*((engine.base, engine.still) if isinstance(engine, Moving) else (engine, ())))
        self._given, self.compiles = given, given is None
        self.equations, self.name = equations, f"{engine.name}, compiled"
        self._values, self.compile_seconds = values, seconds

    @cached_property
    def _fixed(self) -> tuple[list[float], Array]:
        return self.equations.evaluate_fixed(self._values)  # once for all its runs: a twentieth of a short one

    def block(self) -> Block:
        """The arguments of the machine code for one run, which is compiled here."""
        took = self.equations.compile_seconds
        block = Block(self.equations, self._fixed, self._values.tables)
        self.equations.code()
        self.compile_seconds += self.equations.compile_seconds - took
        return block

    def derivative(self, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        block, given, nv = self.block(), self._given, len(self.model.joints)
        code, state, rates = self.equations.code(), np.zeros(block.size), np.zeros(block.size)
        state_at, rates_at, block_at = state.ctypes.data, rates.ctypes.data, block.address

        def derivative(dy: Array, t: float, y: Array) -> None:  # block and code live as long as it
            state[:] = y
            if given is not None:
                block.inputs[:] = given(t, y[:nv], y[nv:])
            code.call(rates_at, t, state_at, block_at, None)
            dy[:] = rates

        return count_calls(derivative, progress, CALLBACK_EVERY_QUICK)
