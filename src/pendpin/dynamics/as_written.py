"""The effect as_written in a model: viscous damping, dry friction and stops from the numbers of its URDF."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from pendpin.effects import AsWritten, DryFriction, Effect, Idle, Stop, Viscous
from pendpin.errors import InputError
from pendpin.model.build import Model
from pendpin.model.urdf_joints import WrittenJoint, homes


def expand_as_written(model: Model, effects: Sequence[Effect]) -> tuple[Effect, ...]:
    """The effects with those that an as_written stands for.

    The first of them takes its place, the others come at the end: every other effect keeps its place in the list.
    Raises InputError where the model has no file that could have written any.
    """
    out, more = list(effects), list[Effect]()
    for i, effect in enumerate(effects):
        if isinstance(effect, AsWritten):
            if model.written is None:
                raise InputError(f"effects[{i}]: as_written is for a URDF; this model has no <dynamics> and no <limit>")
            first, *rest = _effects_of(effect, model.written) or [Idle(kind=effect.kind)]
            out[i] = first
            more += rest
    return (*out, *more)


def move_home(model: Model, effects: Sequence[Effect]) -> Model:
    """The model with its joints, where a start says nothing of them, inside the limits that act as written."""
    moved = homes(model.written or (), effects)
    return replace(model, home=np.array([moved.get(joint, 0.0) for joint in model.joints])) if moved else model


def _effects_of(effect: AsWritten, joints: Sequence[WrittenJoint]) -> list[Effect]:
    """One effect for each number, or pair of limits, that some of the joints share."""
    effects = list[Effect]()
    if effect.damping:
        by_value = _grouped(joints, lambda joint: (joint.damping,) if joint.damping else None)
        effects += [Viscous(coefficient=damping, joints=names) for (damping,), names in by_value.items()]
    if effect.friction:
        by_value = _grouped(joints, lambda joint: (joint.friction,) if joint.friction else None)
        effects += [DryFriction(kinetic=friction, joints=names) for (friction,), names in by_value.items()]
    if effect.limits:
        by_value = _grouped(joints, _limits)
        effects += [Stop(lower=lower, upper=upper, joints=names) for (lower, upper), names in by_value.items()]
    return effects


def _limits(joint: WrittenJoint) -> tuple[float | None, ...] | None:
    both = tuple(x if math.isfinite(x) else None for x in (joint.lower, joint.upper))
    return both if any(x is not None for x in both) else None


def _grouped(joints: Sequence[WrittenJoint], key: Callable[[WrittenJoint], tuple | None]) -> dict[tuple, list[str]]:
    """The names of the joints by what the key makes of them; without those of which it makes None."""
    groups = dict[tuple, list[str]]()
    for joint in joints:
        if (value := key(joint)) is not None:
            groups.setdefault(value, []).append(joint.name)
    return groups
