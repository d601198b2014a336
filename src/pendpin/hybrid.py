"""Driving a scene with contacts: from event to event, each leg with its own joints held and sliding."""

import time
from dataclasses import dataclass, field
from importlib.metadata import version

import numpy as np

from pendpin.contacts import Contacts, Mode
from pendpin.derivations.base import Array
from pendpin.engines import Watch
from pendpin.errors import RunError
from pendpin.solvers import Run
from pendpin.solvers.events import leg

SAMPLES_A_LEG = 64  # output times between two looks at the clock
MOST_AT_ONCE = 200  # events without time going on


@dataclass
class _Progress:
    """What has been done; it grows from leg to leg."""

    q: list[Array] = field(default_factory=list)
    v: list[Array] = field(default_factory=list)
    torque: list[Array] = field(default_factory=list)
    steps: int = 0
    events: int = 0
    calls: int = 0


def drive(
    contacts: Contacts, q: Array, v: Array, times: Array, method: str, tolerance: float, watch: Watch
) -> Run:
    """Integrate over `times` from q, v (nv,). What is done is kept when the run fails or is interrupted."""
    done, begin, failure, interrupted = _Progress(), time.perf_counter(), None, False
    try:
        failure = _legs(contacts, q, v, times, method, tolerance, watch, done)
    except KeyboardInterrupt:
        failure, interrupted = "stopped by the user", True
    except RunError as error:
        failure = str(error)
    seconds, n = time.perf_counter() - begin, len(done.torque)
    arrays = (np.array(x[:n]) for x in (done.q, done.v, done.torque))
    counts = (done.steps, done.calls, done.events, seconds)
    return Run(times[:n], *arrays, *counts, "scipy", version("scipy"), failure, interrupted)


def _legs(
    contacts: Contacts, q: Array, v: Array, times: Array, method: str, tolerance: float, watch: Watch, done: _Progress
) -> str | None:
    t, nv, at_once = float(times[0]), len(q), 0
    v = contacts.strike(q, v, t)
    mode = contacts.choose(t, q, v)
    _keep(contacts, np.concatenate([q, v])[None], times[:1], mode, done)
    while len(done.q) < len(times):
        watch(t)
        ahead = times[len(done.q) :][:SAMPLES_A_LEG]
        y = np.concatenate([q, np.where(mode.held, 0.0, v)])
        found = leg(_derivative(contacts, mode, done), _margins(contacts, mode), t, y, ahead, method, tolerance)
        _keep(contacts, found.samples, ahead[: len(found.samples)], mode, done)
        done.steps += found.steps
        if found.failure:
            return found.failure
        at_once = at_once + 1 if found.t <= t else 0
        if at_once > MOST_AT_ONCE:
            return f"events at t = {t:g} s do not come to an end"
        t, q, v = found.t, found.y[:nv], found.y[nv:]
        if found.fired is not None:
            done.events += 1
            q, v = contacts.land(q, v, found.fired, mode)
            v = contacts.strike(q, v, t)
            mode = contacts.choose(t, q, v)
    return None


def _derivative(contacts: Contacts, mode: Mode, done: _Progress):
    nv = len(contacts.kinetic)

    def derivative(dy: Array, t: float, y: Array) -> None:
        done.calls += 1
        dy[:nv] = y[nv:]
        dy[nv:], _ = contacts.accelerate(t, y[:nv], y[nv:], mode)

    return derivative


def _margins(contacts: Contacts, mode: Mode):
    nv = len(contacts.kinetic)
    return lambda t, y: contacts.margins(t, y[:nv], y[nv:], mode)


def _keep(contacts: Contacts, states: Array, times: Array, mode: Mode, done: _Progress) -> None:
    """Note the states at output times, with the torques of the contacts there."""
    nv = states.shape[1] // 2
    for t, y in zip(times, states, strict=True):
        q, v = y[:nv], np.where(mode.held, 0.0, y[nv:])
        _, holding = contacts.accelerate(t, q, v, mode)
        done.q.append(q)
        done.v.append(v)
        done.torque.append(contacts.friction(mode) + holding)
