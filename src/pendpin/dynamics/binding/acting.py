"""The effects of a scene that act, in a fixed order, and the joints and links that they name."""

from collections.abc import Sequence

import numpy as np
from pydantic import BaseModel

from pendpin.dynamics.as_written import expand_as_written
from pendpin.dynamics.held_torques import HeldTorque
from pendpin.effects import BodyEffect, ContactEffect, Drag, Effect, Idle, JointEffect, Torque
from pendpin.errors import InputError, find, shown
from pendpin.ground.arrays import Indices
from pendpin.model.build import Model


def acting(model: Model, effects: Sequence[Effect]) -> tuple[Effect, ...]:
    """The effects of a scene, with `Idle` in place of each of strength 0: these change no bit of a run.

    In place of an as_written there is what it stands for, in place of a sampled Torque one that can hold.

    Raises InputError for a joint or link that the model lacks, whatever the strength.
    """
    acts = list(expand_as_written(model, effects))
    for i, effect in enumerate(acts):
        where = f"effects[{i}]"
        if isinstance(effect, Drag) and any(body.payload_radius for body in model.bodies):
            acts[i] = effect = effect.model_copy(update={"payload_coefficient": effect.payload_coefficient})
        if isinstance(effect, Torque) and effect.every is not None:
            acts[i] = HeldTorque.of(effect, chosen_joints(model, effect.on, where))
        elif effect.idle:
            if isinstance(effect, JointEffect | ContactEffect):
                chosen_joints(model, effect.joints if isinstance(effect, ContactEffect) else effect.on, where)
            elif isinstance(effect, BodyEffect):
                chosen_bodies(model, effect.on, where)
            acts[i] = Idle(kind=effect.kind)
    return tuple(acts)


def in_order(effects: Sequence[Effect]) -> list[tuple[Effect, str]]:
    """The effects that act, with their key paths, in an order that does not depend on that of the list.

    Every sum over effects uses this order, so that the order of a scene's list changes no bit.
    """
    acts = [(effect, f"effects[{i}]") for i, effect in enumerate(effects) if not isinstance(effect, Idle)]
    return sorted(acts, key=lambda pair: BaseModel.__repr__(pair[0])) if len(acts) > 1 else acts


def refuse_seconds(effects: Sequence[Effect]) -> None:
    """Raise InputError for a second effect of a kind that does not add up with another of its kind."""
    first: dict[str, int] = {}
    for i, effect in enumerate(effects):
        if effect.sole is not None and (before := first.setdefault(effect.sole, i)) != i:
            raise InputError(
                f"effects[{i}]: a second {effect.kind} beside effects[{before}]; {effect.sole}: put both into one"
            )


def chosen_joints(model: Model, names: Sequence[str] | None, where: str) -> Indices:
    """The indices (k,) of joints in model order, of all if None. Raises InputError for one unknown or given twice."""
    if names is None:
        return np.arange(len(model.joints))
    chosen = [model.index(name, where) for name in names]
    if len(set(chosen)) < len(chosen):
        raise InputError(f"{where}: a joint is named twice: {', '.join(map(shown, names))}")
    return np.array(chosen, dtype=np.intp)


def chosen_bodies(model: Model, names: Sequence[str] | None, where: str) -> Indices:
    """The indices (k,) of links among the bodies, all if None; a single rod may be called rod_1. Raises InputError."""
    if names is None:
        return np.arange(len(model.bodies))
    links = tuple(body.link for body in model.bodies)
    alias = {"rod_1": "rod"} if links == ("rod",) else {}
    return np.array([find(links, alias.get(name, name), f"{where}: link") for name in names], dtype=np.intp)


def plain_arithmetic(effects: Sequence[Effect]) -> bool:
    """Whether the effects are pendpin's own and run on symbols: they then take many states at once too."""
    return built_in(effects) and all(effect.symbolic for effect in effects)


def built_in(effects: Sequence[Effect]) -> bool:
    """Whether all laws are pendpin's own: whether others run on symbols, or jump, their authors may never have asked.

    What is held from instant to instant jumps nowhere else.
    """
    are_ours = (type(effect).__module__.startswith("pendpin.") for effect in effects)
    return all(are_ours) and not any(isinstance(effect, Torque) and effect.every is None for effect in effects)
