"""Integration up to events: the steps of an adaptive method are searched for crossings of guards."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from pendpin.engines import Derivative, Engine, ProgressCallback
from pendpin.engines.machine.code import Block
from pendpin.ground.arrays import Array, Mask
from pendpin.integrators.base import LEAST_RTOL, NOT_FINITE, ROUNDING, SHORTEST, Integrator, return_rates
from pendpin.integrators.first_crossing import Crossing, first_crossing
from pendpin.scene.methods import MULTISTEP, Method

OF_MULTISTEP = 0.01  # of the tolerance: that of BDF and LSODA, which begin anew with order 1 at every event
REFINEMENTS = 4  # of the time of an event, with the state integrated anew
NEAR = 1e-7  # of a step: a correction of the time so small is made without integrating anew
INSTANT = 1e-12  # of a step: times no farther from an event happen with it

Guards = Callable[[Array, Array], Array]  # t (n,), y (n, size) -> (n, m), what an event brings down to 0


class SegmentToEvent(NamedTuple):
    """A segment of motion up to an event or to its end."""

    t: float
    y: Array  # the state there
    samples: Array  # (n, size), the states at the output times on the way
    steps: int
    fired: list[int] | None = None  # which guards came down to 0; None if none did
    failure: str | None = None


class Steps(NamedTuple):
    """Some steps, one after another, with their interpolation; k may be 0 where a failure comes at once."""

    bounds: Array  # (k + 1,) s, where the steps begin and end
    states: Array  # (k + 1, size) there
    inside: Callable[[Array], Array]  # t (n,) -> (n, size)
    failure: str | None = None  # of the step after these


class StateScales(NamedTuple):
    """What errors of the numbers of a state are compared with."""

    size: Array  # (size,), of each number: what is of order one
    relative: Mask  # (size,), whether errors may be larger where the number itself is: not of positions near a stop


class Stepper(ABC):
    """A method with its setting on the equations of one mode."""

    @abstractmethod
    def steps(self, t: float, y: Array, end: float) -> Iterator[Steps]:
        """The steps from y (size,) at t to `end`, s."""

    @abstractmethod
    def state_at(self, t: float, y: Array, end: float) -> Array:
        """The state (size,) at `end`, from y at t, as accurate as a step and not as its interpolation."""


@dataclass(frozen=True)
class AtRest(Stepper):
    """The steps of a state that does not change, no longer than `longest` in s."""

    longest: float

    def steps(self, t: float, y: Array, end: float) -> Iterator[Steps]:
        """Steps of equal length, at y (size,)."""
        bounds = np.linspace(t, end, max(1, int(np.ceil((end - t) / self.longest))) + 1)
        yield Steps(bounds, np.tile(y, (len(bounds), 1)), lambda s: np.tile(y, (len(s), 1)))

    def state_at(self, t: float, y: Array, end: float) -> Array:
        """The same state (size,)."""
        return y


@dataclass(frozen=True, eq=False)
class OnSciPy(Stepper):
    """A method of SciPy; its first step follows from the rates of the motion.

    SciPy has one relative tolerance. Where it must not count for some number, the change of the state since the
    start is integrated.
    """

    method: Method
    tolerance: float
    scales: StateScales
    first_step: float  # s
    longest: float  # s, of a step
    derivative: Derivative

    def steps(self, t: float, y: Array, end: float) -> Iterator[Steps]:
        """The steps of SciPy's solver from y (size,), one at a time."""
        solver, origin = self._solver(t, y, end)
        while solver.status == "running":
            begin, before = solver.t, origin + solver.y
            try:
                failure = solver.step()
            except FloatingPointError:
                failure = NOT_FINITE
            if failure:
                yield Steps(np.array([begin]), before[None], lambda s: np.empty((0, len(y))), failure)
                return
            states = np.stack([before, origin + solver.y])
            yield Steps(np.array([begin, solver.t]), states, _transposed(solver.dense_output(), origin))

    def state_at(self, t: float, y: Array, end: float) -> Array:
        """The state (size,) at the end of the solver's steps."""
        if end <= t:
            return y
        solver, origin = self._solver(t, y, end)
        while solver.status == "running":
            solver.step()
        return origin + solver.y

    def _solver(self, t: float, y: Array, end: float) -> tuple[Any, Array]:
        """SciPy's solver from y (size,) at t to `end`, s, and the origin (size,) from which it counts the state."""
        from scipy import integrate  # late: it takes 0.2 s

        (size, relative), rates, origin = self.scales, return_rates(self.derivative), np.zeros_like(y)
        if not relative.all():
            size, origin = size + np.where(relative, np.abs(y), 0.0), y
        solver = getattr(integrate, self.method.library_name)(
            lambda t, change: rates(t, origin + change),
            t,
            y - origin,
            end,
            rtol=max(self.tolerance, LEAST_RTOL),
            atol=self.tolerance * size,
            max_step=self.longest,
            first_step=min(self.first_step, self.longest, end - t),
        )
        return solver, origin


class EventIntegrator(Integrator):
    """A method with a tolerance whose steps can be searched for events."""

    event_library = "scipy"  # that makes the steps up to events

    def __init__(self, method: Method, setting: float) -> None:
        self.method, self.tolerance = method, setting

    def compiled_for_events(self, engine: Engine, progress: ProgressCallback) -> Block | None:
        """The equations with contacts in machine code; None if the method calls them from Python."""
        return None

    def stepper(self, scales: StateScales, first_step: float, longest: float, derivative: Derivative) -> Stepper:
        """The steps with tolerances relative to scales."""
        return OnSciPy(self.method, self.step_tolerance, scales, first_step, longest, derivative)

    @property
    def step_tolerance(self) -> float:
        """The tolerance of the steps up to an event."""
        if self.method.family == MULTISTEP:
            return max(OF_MULTISTEP * self.tolerance, min(self.tolerance, LEAST_RTOL))
        return self.tolerance

    def first_step(self, rate: float) -> float:
        """The first step in s for a motion with this rate in 1/s."""
        return self.tolerance ** (1 / (self.method.restart_order + 1)) / rate


def _transposed(dense: Callable[[Array], Array], origin: Array) -> Callable[[Array], Array]:
    return lambda t: origin + dense(t).T


def integrate_to_event(
    stepper: Stepper, guards: Guards, floor: Array, t: float, y: Array, end: float, times: Array
) -> SegmentToEvent:
    """Integrate from t to `end` or to the first event; samples at those of `times` (n,), after t, that are reached.

    An event is a time at which a guard falls to 0 and then below -floor (m,). The state is integrated again up to the
    event and the time is corrected with it, so that both have the accuracy of a step and not of its interpolation. An
    output time at the event belongs to the next segment: its sample is the state after the event.
    """
    samples, taken = np.empty((0, len(y))), 0
    for part in stepper.steps(t, y, end):
        event = _event(guards, floor, part)
        count = event.place + 1 if event else len(part.bounds) - 1
        t = before = float(part.bounds[count])
        y, taken = part.states[count], taken + count
        if event:
            t, y = _located(stepper, guards, part, event)
            before = t - instant(t, float(part.bounds[count] - part.bounds[count - 1]))
        due = times[len(samples) : times.searchsorted(before, "left" if event else "right")]
        if len(due):
            samples = np.concatenate([samples, _states_at(part, due)])
        if event:
            return SegmentToEvent(t, y, samples, taken, event.fired)
        if part.failure:
            return SegmentToEvent(t, y, samples, taken, None, part.failure)
    return SegmentToEvent(end, y, samples, taken)


def instant(t: float, length: float) -> float:
    """How far from an event at t, found in a step of a length, times count as its instant, s."""
    return max(INSTANT * length, ROUNDING * math.ulp(t), SHORTEST)


def _event(guards: Guards, floor: Array, part: Steps) -> Crossing | None:
    """The first crossing of a guard (m,) in some steps."""
    if not len(floor) or len(part.bounds) < 2:
        return None
    return first_crossing(lambda t: guards(t, part.inside(t)), part.bounds, floor)


def _states_at(part: Steps, t: Array) -> Array:
    """States (n, size) at times (n,) in some steps; where steps begin and end, those of the method itself."""
    states = part.inside(t)
    place = part.bounds.searchsorted(t)
    exact = part.bounds[place] == t
    states[exact] = part.states[place[exact]]
    return states


def _located(stepper: Stepper, guards: Guards, part: Steps, event: Crossing) -> tuple[float, Array]:
    """The time of an event in some steps and the state (size,) there, by Newton's method and new integrations.

    The last correction is so small that the change of the interpolation serves.
    """
    (begin, end), start, t = part.bounds[event.place :][:2].tolist(), part.states[event.place], event.t
    y = stepper.state_at(begin, start, t)
    for _ in range(REFINEMENTS):
        off = guards(np.array([t]), y[None])[0, event.which]
        better = min(max(t - off / event.slope if event.slope < 0 else t, begin), end)
        if abs(better - t) <= NEAR * (end - begin):
            return better, y + np.subtract(*part.inside(np.array([better, t])))
        if abs(better - t) >= (end - begin) / 2:
            break
        t, y = better, stepper.state_at(begin, start, better)
    return t, y
