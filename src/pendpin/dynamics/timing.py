"""How fast the effects of a scene change during a run: where the integration restarts, and its longest steps."""

import dis
from collections.abc import Callable, Sequence
from functools import cache
from types import CodeType, MethodType
from typing import Any, NamedTuple

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.binding import body_wrench, field_since, joint_torque, since, surroundings
from pendpin.dynamics.dynamics import Dynamics
from pendpin.effects import BodyEffect, Effect, FieldEffect, FrameEffect, JointEffect, Torque
from pendpin.effects.pace import Pace, intervals_for, measured, together
from pendpin.errors import InputError

SAMPLES = intervals_for(1024)  # of an effect that cannot say how fast it changes: intervals over the run
NEGLIGIBLE = 1e-10  # of an effect, for methods without a tolerance


class Timing(NamedTuple):
    """The pace of a run, in s since its start."""

    pace: Pace  # of all effects at once
    fastest: tuple[tuple[str, float], ...]  # each effect that changes with time, and its shortest time in s
    sampled: tuple[str, ...]  # the effects that could not say

    def notes(self, duration: float, step: float | None) -> tuple[str, ...]:
        """Notes on a run of `duration` s, with a fixed step in s if it has one."""
        said = [
            f"{name} does not declare how fast it changes with time: it was sampled every {duration / SAMPLES:.3g} s, "
            "and shorter changes may be missed; give it a `pace`"
            for name in self.sampled
        ]
        said += [
            f"{name} changes within {shortest:.3g} s: take a smaller step than {step:g} s"
            for name, shortest in self.fastest
            if step is not None and step > shortest
        ]
        return tuple(said)


def timing(
    dynamics: Dynamics, effects: Sequence[Effect], q: Array, v: Array, duration: float, tolerance: float | None
) -> Timing:
    """The pace of a scene's effects over a run from q, v (nv,), of `duration` s."""
    paces, fastest, sampled = [], [], []
    for i, effect in enumerate(effects):
        name, function = f"effects[{i}] ({effect.kind})", _METHODS.get(_interface(effect))
        if function is None or not duration or not _reads_time(effect, function):
            continue
        pace = _declared(effect, function, dynamics.start, duration, tolerance or NEGLIGIBLE)
        if pace is None:
            sampled.append(name)
            pace = _sampled(dynamics, effects, i, q, v, duration, tolerance or NEGLIGIBLE)
        paces.append(pace)
        fastest.append((name, float(np.min(pace.shortest))))
    return Timing(together(paces), tuple(fastest), tuple(sampled))


_METHODS = {FrameEffect: "acceleration", FieldEffect: "field", JointEffect: "torques", BodyEffect: "wrench"}


def _interface(effect: Effect) -> type[Effect] | None:
    """The interface of an effect that depends on time; None for a contact."""
    return next((interface for interface in _METHODS if isinstance(effect, interface)), None)


def _owner(effect: Effect, name: str) -> type:
    """The class that defines a method of an effect."""
    return next(kind for kind in type(effect).__mro__ if name in vars(kind))


def _reads_time(effect: Effect, name: str) -> bool:
    """Whether the code of an effect's method, or of the function of a Torque, reads the time."""
    given = isinstance(effect, Torque)
    function = effect.function if given else vars(_owner(effect, name))[name]
    code, behind_self = getattr(function, "__code__", None), not given or isinstance(function, MethodType)
    return code is None or _reads(code, int(behind_self))


@cache
def _reads(code: CodeType, place: int) -> bool:
    """Whether a function's code reads an argument, by its place; one without it, such as f(*args), may."""
    return code.co_argcount <= place or any(s.argval == code.co_varnames[place] for s in dis.get_instructions(code))


def _declared(effect: Effect, name: str, start: float, duration: float, negligible: float) -> Pace | None:
    """The pace that an effect declares; None if a subclass overrides the method but not its pace."""
    if not issubclass(_owner(effect, "pace"), _owner(effect, name)):
        return None
    moved, early = effect.since(start)
    pace = moved.pace(early, early + duration, negligible)
    if pace is None:
        return None
    corners, shortest = np.asarray(pace.corners, float), np.asarray(pace.shortest, float)
    rises = corners.ndim == 1 and np.isfinite(corners).all() and (np.diff(corners) > 0).all()
    if not rises or shortest.shape != (len(corners) + 1,) or not (shortest > 0).all():
        raise InputError(
            f"{effect.kind}: its pace has corners {corners.tolist()} and shortest times {shortest.tolist()}: corners have "
            "to rise, shortest times to be above 0, one more than corners"
        )
    return Pace(corners - early, shortest)


def _sampled(
    dynamics: Dynamics, effects: Sequence[Effect], i: int, q: Array, v: Array, duration: float, negligible: float
) -> Pace:
    """The pace of one effect from its values at two states: the start q, v (nv,) and one away from it."""
    t, away = np.linspace(0.0, duration, SAMPLES + 1), np.sin(1.0 + np.arange(len(q)))
    values = _values(dynamics, effects, i)
    samples = [[values(time, q, v), values(time, q + away, v + away)] for time in t]
    return measured(t, np.nan_to_num(np.array(samples, float).reshape(len(t), -1)), negligible)


def _values(dynamics: Dynamics, effects: Sequence[Effect], i: int) -> Callable[[float, Array, Array], Any]:
    """What an effect exerts at a time since the start and a state q, v (nv,)."""
    effect, start, model, where = effects[i], dynamics.start, dynamics.model, f"effects[{i}]"
    if isinstance(effect, FieldEffect):
        field = field_since(start, effect, "field")
        return lambda t, q, v: field(t)
    if isinstance(effect, JointEffect):
        return since(start, effect, joint_torque(model, effect, where))
    assert isinstance(effect, BodyEffect)
    wrench, complete = since(start, effect, body_wrench(model, effect, where)), surroundings(effects, start=start)
    engine = dynamics.engine
    return lambda t, q, v: wrench(t, complete(t, engine.motion(engine.pack(q, v))))
