"""What acts in a scene: which engine, which interfaces of effects, and what one evaluation calls."""

from collections.abc import Iterator

import numpy as np

from pendpin.dynamics.dynamics import Dynamics
from pendpin.effects import BodyEffect, ContactEffect, FieldEffect, Idle, JointEffect
from pendpin.trajectory import Stats


def explain(dynamics: Dynamics, stats: Stats) -> tuple[str, ...]:
    """Lines of text for a person, in the order in which an evaluation goes; `stats` of the run, which chose its engine."""
    return tuple(_lines(dynamics, stats))


def _lines(dynamics: Dynamics, stats: Stats) -> Iterator[str]:
    model, loads, effects = dynamics.model, dynamics.loads, dynamics.effects
    yield f"{len(model.joints)} joints, {len(model.bodies)} bodies; method: {stats.method}; engine: {stats.engine}"
    constant = [e.kind for e in effects if isinstance(e, FieldEffect) and e.constant]
    yield f"constant fields: {_names(constant)}, summed once: {np.array2string(loads.constant, precision=6)} m/s²"
    varying = [e for e in effects if isinstance(e, FieldEffect) and not e.constant]
    yield from _interface("fields that vary with time", varying)
    for effect in effects:
        if isinstance(effect, JointEffect):
            yield f"joint torques: {effect.kind} on {_names(effect.on or model.joints)}"
    wrenches = [e for e in effects if isinstance(e, BodyEffect)]
    yield from _interface("body wrenches, from the poses and velocities of all bodies", wrenches)
    for effect in effects:
        if isinstance(effect, ContactEffect):
            yield f"events: {effect.kind} on {_names(effect.joints or model.joints)}"
    yield from _interface("of strength 0, left out", [e for e in effects if isinstance(e, Idle)])
    one = stats.method == "taylor" or "compiled" in stats.engine
    yield f"an evaluation calls: {'one compiled function of all this' if one else ', '.join(_calls(dynamics))}"


def _interface(title: str, effects: list) -> Iterator[str]:
    if effects:
        yield f"{title}: {_names([effect.kind for effect in effects])}"


def _calls(dynamics: Dynamics) -> Iterator[str]:
    loads = dynamics.loads
    if loads.varying is not None:
        yield "the fields that vary with time"
    if loads.torque is not None:
        yield "the joint torques"
    if loads.wrench is not None:
        yield "the kinematics of the bodies and the wrenches on them"
    yield "one solve for the accelerations"
    if dynamics.contacts is not None:
        yield "another one for the torques that hold joints, if any are held"


def _names(names) -> str:
    shown = list(names)
    return ", ".join(shown[:6]) + (f", ... ({len(shown)} in all)" if len(shown) > 6 else "") if shown else "none"
