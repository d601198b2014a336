"""Integration with events: an adaptive method of SciPy, whose steps are searched for crossings of guards."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from pendpin.arrays import Array, Mask
from pendpin.engines import Derivative
from pendpin.integrators.adaptive import LEAST_RTOL, NOT_FINITE, returning
from pendpin.integrators.crossings import Crossing, first_crossing

ORDERS = {"DOP853": 8, "RK45": 5, "RK23": 3, "Radau": 5, "BDF": 1, "LSODA": 1}  # of a method's first step
REFINEMENTS = 4  # of the time of an event, with the state integrated anew
CONVERGED = 1e-13  # of a step: largest correction of the time in the last refinement
INSTANT = 1e-12  # of a step: times no farther from an event happen with it

Guards = Callable[[Array, Array], Array]  # t (n,), y (n, size) -> (n, m), what an event brings down to 0


@dataclass(frozen=True, eq=False)
class SegmentToEvent:
    """A segment of motion up to an event or to its end."""

    t: float
    y: Array  # the state there
    samples: Array  # (n, size), the states at the output times on the way
    steps: int
    fired: Mask | None = None  # which guards came down to 0; None if none did
    failure: str | None = None


@dataclass(frozen=True, eq=False)
class Method:
    """A method of SciPy with its tolerance, and the equations that it integrates; None where the state stays at rest."""

    name: str
    tolerance: float
    scales: Array  # (size,), of each number of the state: what is of order one
    rate: float  # 1/s, the same of the motion
    longest: float  # s, of a step
    derivative: Derivative | None

    def start(self, t: float, y: Array, end: float) -> Any:
        """SciPy's solver from y (size,) at t to `end`, s; its first step follows from the rates of the motion."""
        assert self.derivative is not None
        first_step = self.tolerance ** (1 / (ORDERS[self.name] + 1)) / self.rate
        from scipy import integrate  # late: it takes 0.2 s

        return getattr(integrate, self.name)(
            returning(self.derivative),
            t,
            y,
            end,
            rtol=max(self.tolerance, LEAST_RTOL),
            atol=self.tolerance * self.scales,
            max_step=self.longest,
            first_step=min(first_step, self.longest, end - t),
        )

    def state_at(self, t: float, y: Array, end: float) -> Array:
        """The state (size,) at `end`, from y at t, as accurate as a step and not as its interpolation."""
        if self.derivative is None or end <= t:
            return y
        solver = self.start(t, y, end)
        while solver.status == "running":
            solver.step()
        return solver.y


@dataclass(frozen=True, eq=False)
class _Step:
    begin: float
    y: Array  # (size,) at its begin
    end: float
    inside: Callable[[Array], Array]  # t (n,) -> (n, size)
    failure: str | None = None


def integrate_to_event(
    method: Method, guards: Guards, floor: Array, t: float, y: Array, end: float, times: Array
) -> SegmentToEvent:
    """Integrate from t to `end` or to the first event; samples at those of `times` (n,), after t, that are reached.

    An event is a time at which a guard falls to 0 and then below -floor (m,). The state is integrated again up to the
    event and the time is corrected with it, so that both have the accuracy of a step and not of its interpolation. An
    output time at the event belongs to the next segment: its sample is the state after the event.
    """
    samples, steps = np.empty((0, len(y))), 0
    for step in _steps(method, t, y, end):
        if step.failure:
            return SegmentToEvent(step.begin, step.y, samples, steps, None, step.failure)
        steps += 1
        event = _event(guards, floor, step)
        t, y = _located(method, guards, step, event) if event else (step.end, step.inside(np.array([step.end]))[0])
        before = t - instant(t, step.end - step.begin) if event else t
        due = times[len(samples) : np.searchsorted(times, before, "left" if event else "right")]
        samples = np.concatenate([samples, step.inside(due)])
        if event:
            return SegmentToEvent(t, y, samples, steps, event.fired)
    return SegmentToEvent(end, y, samples, steps)


def instant(t: float, length: float) -> float:
    """How far from an event at t, found in a step of a length, times count as its instant, s."""
    return max(INSTANT * length, 4 * float(np.spacing(abs(t))))


def _event(guards: Guards, floor: Array, step: _Step) -> Crossing | None:
    """The first crossing of a guard (m,) in a step."""
    if not len(floor):
        return None
    return first_crossing(lambda t: guards(t, step.inside(t)), step.begin, step.end, floor)


def _steps(method: Method, t: float, y: Array, end: float) -> Iterator[_Step]:
    """The steps from y (size,) at t to `end`, s, each with its interpolation."""
    if method.derivative is None:
        count = max(1, int(np.ceil((end - t) / method.longest)))
        for begin, stop in zip(*(np.linspace(t, end, count + 1)[i : count + i] for i in (0, 1)), strict=True):
            yield _Step(float(begin), y, float(stop), lambda s: np.broadcast_to(y, (len(s), len(y))))
        return
    solver = method.start(t, y, end)
    while solver.status == "running":
        begin, before = solver.t, solver.y.copy()
        try:
            failure = solver.step()
        except FloatingPointError:
            failure = NOT_FINITE
        dense = None if failure else solver.dense_output()
        yield _Step(begin, before, solver.t, _inside(dense, solver.t, solver.y), failure)


def _inside(dense: Any, end: float, y: Array) -> Callable[[Array], Array]:
    """The interpolation of a step, (n, size) at times (n,), with the state at its end as it is."""

    def inside(t: Array) -> Array:
        states = dense(t).T
        states[t == end] = y
        return states

    return inside


def _located(method: Method, guards: Guards, step: _Step, event: Crossing) -> tuple[float, Array]:
    """The time of an event in a step and the state (size,) there, by Newton's method and new integrations."""
    t, length = event.t, step.end - step.begin
    y = method.state_at(step.begin, step.y, t)
    for _ in range(REFINEMENTS):
        off = guards(np.array([t]), y[None])[0, event.which]
        shift = -off / event.slope if event.slope < 0 else 0.0
        better = min(max(t + shift, step.begin), step.end)
        if not CONVERGED * length < abs(better - t) < length / 2:
            break
        t, y = better, method.state_at(step.begin, step.y, better)
    return t, y
