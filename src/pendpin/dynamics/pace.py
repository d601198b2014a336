"""How fast the effects of a scene change during a run: where the integration restarts, and its longest steps.

An effect declares its pace, and whether it is smooth with the state, or it is sampled.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pendpin.dynamics.binding import Binding, BoundField, BoundWrench
from pendpin.dynamics.dynamics import Dynamics
from pendpin.effects import BodyEffect, Effect, FieldEffect, FrameEffect, JointEffect, Torque
from pendpin.effects.pace import STEADY, Pace, join_paces, measure_pace, remove_jumps
from pendpin.errors import InputError, shown
from pendpin.ground.arrays import Array

LAWS = {FrameEffect: "acceleration", FieldEffect: "field", JointEffect: "torques", BodyEffect: "wrench"}
SAMPLES = 4096  # of an effect that does not declare its pace: intervals over the run
NEGLIGIBLE = 1e-10  # of an effect, for methods without a tolerance
LEAST = 1e-12  # of an effect: differences below may be rounding
WHOLE = 1e-6  # tolerance down to which a step may take all of the shortest time
# of dop853, the highest of those that take tolerances: its steps become shorter as this root of the tolerance
ORDER = 8


class Paces(NamedTuple):
    """The paces of a scene's effects in a run, in s since its start."""

    pace: Pace  # of all effects at once
    fastest: tuple[tuple[str, float], ...]  # each effect, and its shortest time in s
    sampled: tuple[tuple[str, str], ...]  # each effect that does not declare its pace, and by which name it can

    def notes(self, duration: float, step: float | None) -> tuple[str, ...]:
        """Notes on a run of `duration` s, with a fixed step in s if it has one."""
        notes = [
            f"{name} does not declare how fast it changes with time: it was sampled every {duration / SAMPLES:.3g} s, "
            f"and shorter changes may be missed; give it a `{declared}`"
            for name, declared in self.sampled
        ]
        for name, shortest in self.fastest:
            if step is not None and step > shortest:
                notes.append(f"{name} changes within {shortest:.3g} s: take a smaller step than {step:g} s")
        return tuple(notes)


def paces_of(
    dynamics: Dynamics, effects: Sequence[Effect], q: Array, v: Array, duration: float, tolerance: float | None
) -> Paces:
    """The pace of a scene's effects over a run from q, v (nv,), of `duration` s."""
    paces, fastest, sampled = [], [], []
    for i, effect in enumerate(effects if duration else ()):
        name = f"effects[{i}] ({effect.kind})"
        pace = declared_pace(effect, dynamics.start, duration, tolerance or NEGLIGIBLE)
        if pace is None:
            sampled.append((name, "shortest` or `steady" if isinstance(effect, Torque) else "pace"))
            if (i, duration) not in dynamics.sampled_effects:  # kept for the further runs of a search
                dynamics.sampled_effects[i, duration] = _sample(dynamics, effects, i, q, v, duration)
            t, places, others = dynamics.sampled_effects[i, duration]
            jumps = Pace(places, np.full(len(places) + 1, np.inf))
            pace = join_paces([measure_pace(t, others, max(tolerance or NEGLIGIBLE, LEAST)), jumps])
        paces.append(pace)
        fastest.append((name, float(np.min(pace.shortest))))
    joined = join_paces(paces)
    if tolerance is not None and tolerance < WHOLE:  # else two tolerances pass a pulse in the same steps, and agree
        joined = joined._replace(shortest=joined.shortest * (tolerance / WHOLE) ** (1 / ORDER))
    return Paces(joined, tuple(fastest), tuple(sampled))


def _sample(
    dynamics: Dynamics, effects: Sequence[Effect], i: int, q: Array, v: Array, duration: float
) -> tuple[Array, Array, Array]:
    """One effect at even times t (n,): t, the times of its jumps (j,), and its values (n, k) less these jumps."""
    # They are those at three states: the start q, v (nv,) and one on either side of it, as an effect may act on one side
    # only, and not at rest; no direction of the joints is special.
    binding = Binding(dynamics.model, effects, dynamics.start)
    bound: Any = binding.bound(effects[i], f"effects[{i}]")
    away = np.sin(1.0 + np.arange(len(q)))
    states = [(q + side * away, v + side * away) for side in (0.0, 1.0, -1.0)]
    motions = [dynamics.engine.motion(dynamics.engine.pack(*state)) for state in states]

    def values(time: float) -> Array:
        if isinstance(bound, BoundWrench):
            wrenches = [bound.at(time, binding.complete(time, motion)) for motion in motions]
            exerted = [np.concatenate(wrench).ravel() for wrench in wrenches]
        else:
            exerted = [bound.at(time) if isinstance(bound, BoundField) else bound.at(time, *state) for state in states]
        return np.nan_to_num(np.concatenate(exerted))

    t = np.linspace(0.0, duration, SAMPLES + 1)
    return t, *remove_jumps(values, t, np.array([values(float(time)) for time in t]), NEGLIGIBLE)


def owner(effect: Effect, name: str) -> type:
    """The class that defines an attribute of an effect."""
    return next(kind for kind in type(effect).__mro__ if name in vars(kind))


def law_owner(effect: Effect) -> type | None:
    """The class that says how an effect acts; None for a contact."""
    return next((owner(effect, name) for interface, name in LAWS.items() if isinstance(effect, interface)), None)


def declared_pace(effect: Effect, start: float, duration: float, negligible: float) -> Pace | None:
    """The pace of an effect in a run; None if the class with its law declares none. InputError for one that cannot be."""
    (moved, early), declares, law = effect.since(start), owner(effect, "pace"), law_owner(effect)
    if law is None or (isinstance(effect, FieldEffect) and effect.constant):
        return STEADY
    if declares is Effect and law.__module__.startswith("pendpin."):
        track, frequency = getattr(moved, "track", None), getattr(moved, "frequency", None)
        half_period = np.inf if frequency is None else np.pi / frequency
        pace = track.pace(early, early + duration, negligible) if track else Pace.even(half_period)
    else:
        pace = moved.pace(early, early + duration, negligible) if issubclass(declares, law) else None
    if pace is None:
        return None
    if not isinstance(pace, Pace):
        right = "return a Pace, such as Pace.even(x) for a change within x s"
        raise InputError(f"{effect.kind}: its pace returned {shown(pace)}; {right}")
    corners, shortest = np.asarray(pace.corners, float), np.asarray(pace.shortest, float)
    rises = corners.ndim == 1 and np.isfinite(corners).all() and (np.diff(corners) > 0).all()
    if not rises or shortest.shape != (len(corners) + 1,) or not (shortest > 0).all():
        given = f"corners {corners.tolist()} and shortest times {shortest.tolist()}"
        right = "corners have to rise, shortest times to be above 0, one more than corners"
        raise InputError(f"{effect.kind}: its pace has {given}: {right}")
    return Pace(corners - early, shortest)


def changes_with_time(effect: Effect, start: float, duration: float, negligible: float) -> bool:
    """Whether time makes a difference to an effect in a run; one that does not declare it may change."""
    pace = declared_pace(effect, start, duration, negligible)
    return pace is None or pace.varies


def declared_smooth(effect: Effect) -> bool | None:
    """Whether a user's own law declares that it is smooth in positions and rates; None if it does not say.

    True of what is pendpin's own, and of what acts at instants only.
    """
    if isinstance(effect, Torque):
        return effect.gradual if effect.every is None else True
    law = law_owner(effect)
    if law is None or isinstance(effect, FieldEffect) or law.__module__.startswith("pendpin."):
        return True
    declares = owner(effect, "smooth")
    return effect.smooth if declares is not Effect and issubclass(declares, law) else None
