"""Driving a scene with contacts: from event to event, each leg with its own joints held and sliding."""

import time
from importlib.metadata import version

import numpy as np

from pendpin import kinematics
from pendpin.contacts import Mode
from pendpin.derivations.base import Array
from pendpin.dynamics import Dynamics
from pendpin.effects import DryFriction, Stop
from pendpin.engines import WATCH_EVERY, Derivative, Watch
from pendpin.errors import InputError, RunError
from pendpin.ledger import Ledger
from pendpin.solvers import Adaptive, Lane, Run
from pendpin.solvers.events import leg

SAMPLES_A_LEG = 64  # output times between two looks at the clock
MOST_AT_ONCE = 200  # events without time going on


class Hybrid:
    """A run with contacts, growing from leg to leg; what it holds is good at any moment."""

    def __init__(self, dynamics: Dynamics, books: Ledger | None, lane: Lane) -> None:
        assert dynamics.contacts is not None
        assert isinstance(lane, Adaptive)
        self.model, self.contacts, self.books = dynamics.model, dynamics.contacts, books
        self.lane, self.nv = lane, len(dynamics.model.joints)
        self.states: list[Array] = []  # (q, v, work) at the output times
        self.torques: list[Array] = []
        self.steps = self.events = self.calls = 0

    def drive(self, q: Array, v: Array, times: Array, watch: Watch) -> Run:
        """Integrate over `times` from q, v (nv,). What is done is kept when the run fails or is interrupted."""
        begin, failure, interrupted = time.perf_counter(), None, False
        try:
            failure = self._legs(q, v, times, watch)
        except KeyboardInterrupt:
            failure, interrupted = "stopped by the user", True
        except (RunError, np.linalg.LinAlgError) as error:
            failure = str(error)
        if not self.torques and not interrupted:
            raise InputError(f"start: {failure}")
        n, nv, seconds = len(self.torques), self.nv, time.perf_counter() - begin
        states, torques = np.array(self.states[:n]), np.array(self.torques)
        counts = (self.steps, self.calls, self.events, seconds)
        arrays = (states[:, :nv], states[:, nv : 2 * nv], torques, states[:, 2 * nv :])
        return Run(times[:n], *arrays, *counts, "scipy", version("scipy"), failure, interrupted)

    def _legs(self, q: Array, v: Array, times: Array, watch: Watch) -> str | None:
        t, at_once = float(times[0]), 0
        y = self._struck(t, np.concatenate([q, v, np.zeros(len(self.books.kinds) if self.books else 0)]))
        mode = self.contacts.choose(t, *self._angles(y))
        self._keep(y[None], times[:1], mode)
        while len(self.states) < len(times):
            watch(t)
            ahead = times[len(self.states) :][:SAMPLES_A_LEG]
            found = leg(
                self._derivative(mode, watch), self._margins(mode), t, y, ahead, self.lane.method, self.lane.tolerance
            )
            self._keep(found.samples, ahead[: len(found.samples)], mode)
            self.steps += found.steps
            if found.failure:
                return found.failure
            at_once = at_once + 1 if found.t <= t else 0
            if at_once > MOST_AT_ONCE:
                return f"events at t = {t:g} s do not come to an end"
            t, y = found.t, found.y.copy()
            if found.fired is not None:
                self.events += 1
                y[: 2 * self.nv] = np.concatenate(self.contacts.land(*self._angles(y), found.fired, mode))
                y = self._struck(t, y)
                mode = self.contacts.choose(t, *self._angles(y))
            y[self.nv : 2 * self.nv][mode.held] = 0.0
        return None

    def _angles(self, y: Array) -> tuple[Array, Array]:
        return y[: self.nv], y[self.nv : 2 * self.nv]

    def _struck(self, t: float, y: Array) -> Array:
        """The state after the impacts that are due, and their loss in the books."""
        q, v = self._angles(y)
        after = self.contacts.strike(q, v, t)
        out = y.copy()
        out[self.nv : 2 * self.nv] = after
        if self.books is not None and not np.array_equal(after, v):
            energies = kinematics.kinetic_energy(self.model, np.stack([q, q]), np.stack([v, after]))
            out[2 * self.nv + self.books.kinds.index(_kind(Stop))] += energies[1] - energies[0]
        return out

    def _derivative(self, mode: Mode, watch: Watch) -> Derivative:
        contacts, books, nv = self.contacts, self.books, self.nv
        friction = contacts.friction(mode)
        rubs = books is not None and friction.any()
        account = 2 * nv + books.kinds.index(_kind(DryFriction)) if books is not None and rubs else 0

        def derivative(dy: Array, t: float, y: Array) -> None:
            self.calls += 1
            if not self.calls % WATCH_EVERY:
                watch(t)
            dy[:nv] = y[nv : 2 * nv]
            dy[nv : 2 * nv], _ = contacts.accelerate(t, y[:nv], y[nv : 2 * nv], mode)
            if books is not None:
                dy[2 * nv :] = books.powers(t, y[: 2 * nv])
                if rubs:
                    dy[account] += friction @ y[nv : 2 * nv]

        return derivative

    def _margins(self, mode: Mode):
        return lambda t, y: self.contacts.margins(t, *self._angles(y), mode)

    def _keep(self, states: Array, times: Array, mode: Mode) -> None:
        """Note the states at output times, with the torques of the contacts there."""
        for t, y in zip(times, states.copy(), strict=True):
            y[self.nv : 2 * self.nv][mode.held] = 0.0
            _, holding = self.contacts.accelerate(t, *self._angles(y), mode)
            self.states.append(y)
            self.torques.append(self.contacts.friction(mode) + holding)


def _kind(effect: type[DryFriction] | type[Stop]) -> str:
    return effect.model_fields["kind"].default
