"""What a user's effects declare of how fast they change, with time and with the state."""

import numpy as np

from pendpin.effects import BodyEffect, Effect, FieldEffect, FrameEffect, JointEffect, Torque
from pendpin.effects.pace import Pace
from pendpin.errors import InputError

LAWS = {FrameEffect: "acceleration", FieldEffect: "field", JointEffect: "torques", BodyEffect: "wrench"}


def law_name(effect: Effect) -> str | None:
    """The name of the method by which an effect acts; None for a contact."""
    return next((name for interface, name in LAWS.items() if isinstance(effect, interface)), None)


def owner(effect: Effect, name: str) -> type:
    """The class that defines an attribute of an effect."""
    return next(kind for kind in type(effect).__mro__ if name in vars(kind))


def declared_pace(effect: Effect, start: float, duration: float, negligible: float) -> Pace | None:
    """The pace that an effect declares for a run; None if it does not, or its subclass overrides only how it acts.

    Raises InputError for a pace that cannot be.
    """
    name = law_name(effect)
    assert name is not None
    if not issubclass(owner(effect, "pace"), owner(effect, name)):
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


def changes_with_time(effect: Effect, start: float, duration: float, negligible: float) -> bool:
    """Whether time makes a difference to an effect in a run; one that does not declare it may change."""
    if law_name(effect) is None or (isinstance(effect, FieldEffect) and effect.constant):
        return False
    pace = declared_pace(effect, start, duration, negligible)
    return pace is None or len(pace.corners) > 0 or bool(np.isfinite(pace.shortest).any())


def users_own(effect: Effect) -> bool:
    """Whether an effect acts on positions and rates by a law that is not pendpin's own, and not at instants only."""
    if not isinstance(effect, JointEffect | BodyEffect):
        return False
    name = law_name(effect)
    assert name is not None
    if isinstance(effect, Torque):
        return effect.every is None
    return not owner(effect, name).__module__.startswith("pendpin.")


def declared_smooth(effect: Effect) -> bool | None:
    """Whether a user's own effect declares that it is smooth in positions and rates; None if it does not say."""
    if isinstance(effect, Torque):
        return effect.gradual
    name = law_name(effect)
    assert name is not None
    said = owner(effect, "smooth")
    return effect.smooth if said is not Effect and issubclass(said, owner(effect, name)) else None
