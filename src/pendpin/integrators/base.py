"""The interface of the integrators."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import Derivative, Engine, ProgressCallback
from pendpin.errors import RunError
from pendpin.ground.arrays import Array
from pendpin.scene import Method, Scene, method_of
from pendpin.trajectory import Event

LEAST_RTOL = 2.3e-14  # SciPy raises smaller ones to 100 times the rounding, with a warning
ROUNDING = 4.0  # units in the last place of a time: lsoda starts no step that is shorter than two of them
SHORTEST = 1e-150  # s, the square of which is still a number that it can divide by
NOT_FINITE = "the acceleration is not a finite number"

# What a method keeps from segment to segment: a named tuple of arrays and numbers, `motion` of the motion in it; or ()
Memory = tuple[Any, ...]


@dataclass(frozen=True)
class StepPlan:
    """What is known of a segment's steps before it is integrated."""

    first: float | None = None  # s, a proposal for the first one
    longest: float = math.inf  # s, the limit for methods without a fixed step
    memory: Memory | None = None  # of the segment before, if there was one
    anew: bool = False  # whether fixed steps are counted from the start of this segment


FREE = StepPlan()


@dataclass(frozen=True)
class Segment:
    """The states at the output times of one segment, and the steps that they took."""

    y: Array  # (n, 2 nv); shorter than the times where the integrator had to stop
    steps: int
    failure: str | None = None  # why the integrator had to stop
    memory: Memory = ()


class Stop(NamedTuple):
    """The last state before an integration had to stop, between two samples."""

    t: float  # s since the start
    q: Array  # (nv,)
    v: Array  # (nv,)


@dataclass(frozen=True, eq=False)
class Run:
    """An integrated motion at the output times that were reached."""

    t: Array  # (n,)
    q: Array  # (n, nv)
    v: Array  # (n, nv)
    torque: Array | None  # (n, nv) N m, what contacts exert on the joints; None without contacts
    work: Array  # (n, accounts) J, what was integrated for the energy_balance; no accounts without one
    steps: int
    evaluations: int
    events: int
    seconds: float
    library: str
    version: str
    compile_seconds: float = 0.0
    failure: RunError | None = None  # why it ended early
    stop: Stop | None = None  # where, if that is after the last sample
    notes: tuple[str, ...] = ()  # what a reader of the run should know
    happened: tuple[Event, ...] = ()  # at the events; t in s since the start

    @classmethod
    def at_states(cls, t: Array, q: Array, v: Array) -> "Run":
        """States q, v (n, nv) at t (n,) that were not integrated."""
        return cls(t, q, v, None, np.zeros((len(t), 0)), 0, 0, 0, 0.0, "", "")

    def cut(self, count: int, why: str) -> "Run":
        """The run up to this number of samples, and why it ends there."""
        torque = None if self.torque is None else self.torque[:count]
        arrays = {"t": self.t[:count], "q": self.q[:count], "v": self.v[:count], "work": self.work[:count]}
        happened = tuple(event for event in self.happened if event.t <= self.t[count - 1])
        return replace(self, **arrays, torque=torque, failure=RunError(why), happened=happened, stop=None)


class Integrator(ABC):
    """A method with its setting; `library` and `version` name the program that does the steps."""

    library: str
    version: str
    compile_seconds: float = 0.0
    step: float | None = None  # s, of a method with a fixed one

    def __init__(self, method: Method, setting: float) -> None:
        """`setting`: the tolerance, or the step in s, whichever the method's record names."""
        self.method, self.setting = method, setting
        self.step = setting if method.setting == "step" else None

    @classmethod
    def for_scene(cls, scene: Scene, dynamics: Dynamics) -> "Integrator":
        """The integrator with the setting of scene.solver, for these dynamics. Raises InputError for what it cannot run."""
        method = method_of(scene.solver.method)
        setting = scene.solver.step if method.setting == "step" else scene.solver.tolerance
        assert setting is not None
        return cls(method, setting)

    def equations(self, engine: Engine, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """The derivative of an engine and a function that counts evaluations. `progress` is called with t and may raise.

        An integrator with its own equations counts those. Raises InputError for an engine that it cannot use.
        """
        return engine.derivative(progress)

    def memory(self, y: Array) -> Memory:
        """What goes from segment to segment beside the state, for a start at y (size,); its shapes never change."""
        return ()

    @abstractmethod
    def integrate(self, derivative: Derivative, y: Array, times: Array, plan: StepPlan = FREE) -> Segment:
        """The states (n, size) at `times` (n,) in s, rising and apart (`states_at`), from y (size,) at times[0]."""

    def states_at(self, derivative: Derivative, y: Array, times: Array, plan: StepPlan = FREE) -> Segment:
        """The states at any times (n,) that do not fall: those no farther apart than rounding share a state."""
        if len(times) > 1 and (times[1:] - times[:-1]).min() > max(ROUNDING * math.ulp(times[-1]), SHORTEST):
            return self.integrate(derivative, y, times, plan)
        apart = [0]  # where they are farther than rounding behind the last such time
        for i, t in enumerate(times.tolist()):
            if t - times[apart[-1]] > max(ROUNDING * math.ulp(t), SHORTEST):
                apart.append(i)
        if len(apart) == 1:
            memory = self.memory(y) if plan.memory is None else plan.memory
            return Segment(np.tile(y, (len(times), 1)), 0, memory=memory)
        segment = self.integrate(derivative, y, times[apart], plan)
        place = np.searchsorted(apart, np.arange(len(times)), "right") - 1
        return replace(segment, y=segment.y[place[place < len(segment.y)]])


def finite_part(states: Array, steps: int, failure: str | None) -> tuple[Array, int, str | None]:
    """The states (n, size) before the first that is not finite, the steps, and the failure."""
    finite = np.isfinite(states)
    if finite.all():
        return states, steps, failure
    return states[: max(1, int(np.argmin(finite.all(1))))], steps, NOT_FINITE  # the first is what was given
