"""How fast the effects of a scene change during a run: where the integration restarts, and its longest steps."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.binding import Binding
from pendpin.dynamics.declared import declared_pace, law_name
from pendpin.dynamics.dynamics import Dynamics
from pendpin.effects import Effect, FieldEffect, Torque
from pendpin.effects.pace import Pace, intervals_for, measured, together, without_jumps

SAMPLES = intervals_for(1024)  # of an effect that does not declare its pace: intervals over the run
NEGLIGIBLE = 1e-10  # of an effect, for methods without a tolerance


class Timing(NamedTuple):
    """The pace of a run, in s since its start."""

    pace: Pace  # of all effects at once
    fastest: tuple[tuple[str, float], ...]  # each effect that changes with time, and its shortest time in s
    sampled: tuple[tuple[str, str], ...]  # each effect that does not declare its pace, and by which name it can

    def notes(self, duration: float, step: float | None) -> tuple[str, ...]:
        """Notes on a run of `duration` s, with a fixed step in s if it has one."""
        said = [
            f"{name} does not declare how fast it changes with time: it was sampled every {duration / SAMPLES:.3g} s, "
            f"and shorter changes may be missed; give it a `{declared}`"
            for name, declared in self.sampled
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
        if law_name(effect) is None or not duration or (isinstance(effect, FieldEffect) and effect.constant):
            continue
        name = f"effects[{i}] ({effect.kind})"
        pace = declared_pace(effect, dynamics.start, duration, tolerance or NEGLIGIBLE)
        if pace is None:
            sampled.append((name, "shortest` or `steady" if isinstance(effect, Torque) else "pace"))
            pace = _sampled(dynamics, effects, i, q, v, duration, tolerance or NEGLIGIBLE)
        paces.append(pace)
        fastest.append((name, float(np.min(pace.shortest))))
    return Timing(together(paces), tuple(fastest), tuple(sampled))


def _sampled(
    dynamics: Dynamics, effects: Sequence[Effect], i: int, q: Array, v: Array, duration: float, negligible: float
) -> Pace:
    """The pace of one effect from its values at three states: the start q, v (nv,) and one on either side of it.

    An effect may act on one side only, and not at rest; no direction of the joints is special. Where it jumps, the
    integration restarts at the jump itself.
    """
    away = np.sin(1.0 + np.arange(len(q)))
    acting = [action(dynamics, effects, i, q + side * away, v + side * away) for side in (0.0, 1.0, -1.0)]

    def values(time: float) -> Array:
        return np.nan_to_num(np.concatenate([act(time) for act in acting]))

    t = np.linspace(0.0, duration, SAMPLES + 1)
    samples = np.array([values(float(time)) for time in t])
    places, others = without_jumps(values, t, samples, negligible)
    return together([measured(t, others, negligible), Pace(places, np.full(len(places) + 1, np.inf))])


def action(dynamics: Dynamics, effects: Sequence[Effect], i: int, q: Array, v: Array) -> Callable[[float], Array]:
    """What one of the effects exerts at a state q, v (nv,), flat, as a function of the time since the start in s."""
    bound = Binding(dynamics.model, effects, start=dynamics.start).bound(effects[i], f"effects[{i}]")
    assert bound is not None
    return bound.action(q, v, dynamics.engine.motion(dynamics.engine.pack(q, v)))
