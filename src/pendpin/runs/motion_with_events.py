"""A motion with contacts, integrated from event to event; held and sliding joints change at events only."""

from dataclasses import replace
from typing import Any

import numpy as np

from pendpin.dynamics.contacts import Contacts, Mode
from pendpin.dynamics.falls import LowFall, falls_of, guards_of, rates_and_mode
from pendpin.effects.pace import Pace
from pendpin.engines import CALLBACK_EVERY, Derivative, ProgressCallback
from pendpin.errors import InputError, RunError
from pendpin.ground.arrays import Array
from pendpin.ground.libraries import version
from pendpin.integrators.adaptive import Adaptive, StateScales
from pendpin.integrators.events import AtRest, Stepper, instant, integrate_to_event
from pendpin.runs.checkpoint import EventState, RunState
from pendpin.runs.integration import IntegrationLoop
from pendpin.runs.preparation import Prepared
from pendpin.trajectory import Event

SAMPLES_A_SEGMENT = 64  # output times of a segment
MOST_AT_ONCE = 200  # events at the same time
LANDED = 2.0  # of the time of a fall: where a segment ends if the joint has not come down, as the forces have changed


class LoopWithEvents(IntegrationLoop):
    """A scene with contacts, integrated from event to event; its state is y = (q, v, work of each account)."""

    def __init__(self, prepared: Prepared, pace: Pace, progress: ProgressCallback) -> None:
        super().__init__(prepared, pace, progress)
        integrator, contacts, self.calls = self.integrator, self.dynamics.contacts, 0
        assert contacts is not None
        assert isinstance(integrator, Adaptive)  # others are refused where they are chosen
        self._block, self._method = integrator.compiled_block(self.engine, self.progress), integrator
        self.contacts: Contacts = replace(contacts, block=self._block)
        self.library, self.version = integrator.event_library, version(integrator.event_library)
        self.scales: Any = None  # the Scales of the whole run, once it has begun: a later beginning keeps them

    def begin(self, q: Array, v: Array) -> RunState:
        """The first sample, from q, v (nv,), after the impacts that are due: none of the start's counts as an event."""
        t, names = float(self.times[0]), self.dynamics.model.joints
        y = np.concatenate([q, v, np.zeros(self.accounts)])
        joints, side = self.contacts.at_stops(q)
        struck = [Event(t, names[joint], "stop") for joint in joints[side * v[joints] < 0]] if t else []
        try:
            self.sample(t, y)
            self.scales = self.scales or self.contacts.scales(self.times, *self._angles(y), self.pace.varies)
            mode = self._meet(t, y)
            if self.sample(t, y):  # after the impacts
                mode = self._meet(t, y)
            works, y[2 * self.nv :] = y[2 * self.nv :].copy(), 0.0
            first = self._rows(y[None], self.times[:1], mode)[0]
        except (RunError, np.linalg.LinAlgError) as error:
            raise InputError(f"start: {error}") from None
        if struck:  # a run that ended at this impact goes on
            y[2 * self.nv :] = works
        last = EventState(t, y, mode, 0, self.records)
        return RunState.at_start(first, len(self.times), last).grown(first[None][:0], last, 0, 0, struck or None)

    def go_on(self, done: RunState) -> tuple[RunState, str | None]:
        """One segment: to the next event, over some output times, or to a corner of the pace."""
        last = done.last
        assert isinstance(last, EventState)
        t, y, mode, at_once, _ = last
        self.recall(last)
        self.progress(t)
        times, counted = self.times[done.n :][:SAMPLES_A_SEGMENT], self._block or self
        before = counted.calls
        if times[0] <= t + instant(t, float(times[-1]) - t):  # at the instant of an event
            return done.grown(self._rows(y[None], times[:1], mode), last, 0, 0), None
        corner, fall = int(self.pace.corners.searchsorted(t, "right")), None
        end = float(min(times[-1:].tolist() + self.pace.corners[corner : corner + 1].tolist()))
        if self.contacts.stops and not all(mode.held.tolist()):
            q, v = self._angles(y)
            fall = falls_of(self.contacts, t, q, v, mode).low(t, q, self.scales, self._method.step_tolerance)
        end = end if fall is None else min(end, t + LANDED * fall.longest)
        scales = self.scales if fall is None else fall.scales
        guards = guards_of(self.contacts, y[: self.nv], mode, scales, self._method.tolerance)
        stepper = self._stepper(float(self.pace.shortest[corner]), mode, fall)
        due = times
        if any(sampled.is_instant(end) for sampled in self.held):  # what is at the end belongs to the next segment
            due = times[times < end - instant(t, end - t)]
        segment = integrate_to_event(stepper, guards.values, guards.floor, t, y, end, due)
        happened: list[Event] | None = None
        rows, failure = self._rows(segment.samples, times[: len(segment.samples)], mode), segment.failure
        at_once = at_once + 1 if segment.t <= t else 0
        if at_once > MOST_AT_ONCE:
            failure = f"{t:g} s after the start there are more than {MOST_AT_ONCE:g} events at once"
        if not failure:
            try:
                y, mode = segment.y.copy(), guards.mode
                if segment.fired is not None:
                    mode = self._meet(segment.t, y, guards.land(*self._angles(y), segment.fired))
                y[self.nv : 2 * self.nv][mode.held] = 0.0
                if segment.fired is not None:
                    changes, names = guards.changes(y[: self.nv], segment.fired, mode.held), self.dynamics.model.joints
                    happened = [Event(float(segment.t), names[joint], kind) for joint, kind in changes]
                if self.sample(segment.t, y):
                    mode = self._meet(segment.t, y)
            except (RunError, np.linalg.LinAlgError) as error:
                failure = str(error)
        following = EventState(float(segment.t), y, mode, at_once, self.records)
        return done.grown(rows, following, segment.steps, counted.calls - before, happened), failure

    def _stepper(self, longest: float, mode: Mode, fall: LowFall | None) -> Stepper:
        """The method, with steps up to `longest` in s; those of a fall are as short as it."""
        if all(mode.held.tolist()):
            return AtRest(longest)
        if self._block:
            self.contacts.enter(mode)
        scales, rate = self.scales, float((self.scales.rate / self.scales.position).max())  # of the motion, 1/s
        work = np.full(self.accounts, (scales.torque * scales.position).max())
        size = np.concatenate([scales.position, scales.rate, work])  # of order one for each number of the state
        sizes = StateScales(size, np.ones(len(size), bool))
        if fall is not None:
            relative = np.append(~fall.joints, np.ones(len(size) - self.nv, bool))
            size = np.concatenate([fall.scales.position, fall.scales.rate, work])
            sizes, rate = StateScales(size, relative), max(rate, 1.0 / fall.shortest)
        return self._method.stepper(sizes, rate, longest, self._derivative(mode))

    def _angles(self, y: Array) -> tuple[Array, Array]:
        """Positions and rates (nv,) of a state y (size,)."""
        return y[: self.nv], y[self.nv : 2 * self.nv]

    def _meet(self, t: float, y: Array, loose: Array | float = 0.0) -> Mode:
        """The mode after the impacts that are due; they change the state y (size,), their loss the energy balance."""
        q, v = self._angles(y)
        after, mode = rates_and_mode(self.contacts, t, q, v, self.scales, loose)
        if self.balance is not None and not np.array_equal(after, v):
            before, then = self.dynamics.energies(np.stack([q, q]), np.stack([v, after]))[0]
            # By stops, or by friction that ends what is left of a rate; with rounding, and bounces too small to count.
            taken = self.contacts.work_of_impacts(q, v, after) or {self.contacts.rubbing[0][1].kind: 0.0}
            taken[next(iter(taken))] += then - before - sum(taken.values())
            for kind, work in taken.items():
                y[2 * self.nv + self.balance.kinds.index(kind)] += work
        v[:] = after
        return mode

    def _derivative(self, mode: Mode) -> Derivative:
        contacts, balance, nv = self.contacts, self.balance, self.nv
        accounts = {} if balance is None else {kind: 2 * nv + i for i, kind in enumerate(balance.kinds)}
        rubs = balance is not None and contacts.friction(np.zeros(nv), mode).any()

        def derivative(dy: Array, t: float, y: Array) -> None:
            self.calls += 1
            if not self.calls % CALLBACK_EVERY:
                self.progress(t)
            dy[:nv] = v = y[nv : 2 * nv]
            dy[nv : 2 * nv], _ = contacts.accelerate(t, y[:nv], v, mode)
            if balance is not None:
                dy[2 * nv :] = balance.powers(t, y[: 2 * nv])
                if rubs:
                    for kind, torque in contacts.friction_by_kind(v, mode.sign):
                        dy[accounts[kind]] += torque @ v

        return derivative

    def _rows(self, states: Array, times: Array, mode: Mode) -> Array:
        """States (n, size) at times (n,), each with the torques (nv,) of the contacts."""
        if not len(states):
            return np.empty((0, states.shape[1] + self.nv))
        q, v, works = np.split(states, [self.nv, 2 * self.nv], axis=1)
        v = np.where(mode.held, 0.0, v)
        # A joint that leaves its stop with the third power of time may pass it at first, by what a step errs.
        states = np.concatenate([q.clip(self.contacts.lower, self.contacts.upper), v, works], 1)
        torques = self.contacts.friction(v, mode) + self.contacts.hold(times, states, mode)
        return np.concatenate([states, torques], 1)
