"""The effects of a scene that act, in a fixed order; the joints and links that they name; the law of each."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from pendpin.dynamics.as_written import expand_as_written
from pendpin.dynamics.held_torques import HeldTorque
from pendpin.dynamics.parameters import GIVEN, Numbers
from pendpin.effects import (
    Bodies,
    BodyEffect,
    ContactEffect,
    Drag,
    Effect,
    Idle,
    JointEffect,
    Motion,
    Motor,
    Push,
    Support,
    Torque,
)
from pendpin.effects.base import returned
from pendpin.errors import InputError, PendpinError, find, shown
from pendpin.ground.arrays import Indices
from pendpin.model.build import Model

WRENCH = "a force", "a moment"
LATEST = 340  # digits: more than a time times a frequency can have before its point


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

    It is that of the names of their classes, then of the numbers in their fields, as text. Every sum over effects uses this
    order, so that the order of a scene's list changes no bit.
    """
    acts = [(effect, f"effects[{i}]") for i, effect in enumerate(effects) if not isinstance(effect, Idle)]
    return sorted(acts, key=lambda pair: _order(pair[0])) if len(acts) > 1 else acts


def _order(effect: Effect) -> tuple[str, ...]:
    fields = (getattr(effect, name) for name in type(effect).model_fields)
    return (type(effect).__name__, *map(_without_imaginary_parts, fields))


def _without_imaginary_parts(value: Any) -> str:
    """A value as text; a number that derivatives.py makes complex has the place of the real one."""
    if isinstance(value, tuple):
        return f"({', '.join(map(_without_imaginary_parts, value))})"
    return repr(value.real) if isinstance(value, complex) else repr(value)


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


# --- the law of one effect, as a function of the time since the start of the run ------------------------------------


def law(effect: Effect, name: str, xp: Any = np, numbers: Numbers = GIVEN) -> Callable[..., Any]:
    """A method of an effect, by its name. That of a user's own class gets copies, and what it returns is checked."""
    method = partial(getattr(numbers.effect(effect), name), xp=xp)
    if type(effect).__module__.startswith("pendpin."):
        return method
    what, kind = f"effects: {effect.kind}: its {name}", float if xp is np else object

    def checked(t: Any, *state: Any) -> Any:
        output = method(t, *map(_copy, state))
        if name != "wrench":
            return returned(what, output, state[0].shape if state else (3,), kind)
        if not isinstance(output, tuple | list) or len(output) != len(WRENCH):
            raise InputError(f"{what} returned {shown(output)}, where {' and '.join(WRENCH)} are wanted")
        return tuple(returned(what, part, state[0].com.shape, kind) for part in output)

    return checked


def _copy(part: Any) -> Any:
    """A copy of an array, or of each array in bodies or a motion: a law that works in place changes no state."""
    if isinstance(part, Bodies | Motion):
        return part._make(map(_copy, part))
    return part.copy() if isinstance(part, np.ndarray) else part


def since(start: float, effect: Effect, function: Any, numbers: Numbers = GIVEN) -> Any:
    """A function of time of one effect, as a function of the time since `start` in s: late times then lose no digits."""
    if not start:
        return function
    early = numbers(_reduce_to_first_period(start, effect))
    return lambda t, *state: function(early + t, *state)


def _reduce_to_first_period(start: float, effect: Effect) -> Any:
    """The time at which a sinusoid first has the phase that it has at `start`, in s; for other effects `start`."""
    if not start or not isinstance(effect, Drag | Motor | Push | Support) or effect.frequency is None:
        return start
    from mpmath import mp, mpf

    frequency = np.real(effect.frequency)  # complex where derivatives by it are wanted (varied.py)
    with mp.workdps(LATEST):
        early = float(mp.fmod(mpf(start) * mpf(frequency), 2 * mp.pi) / frequency)
    if isinstance(effect.frequency, complex):  # frequency early changes with the frequency like frequency start
        return early + (start - early) / frequency * (effect.frequency - frequency)
    return early


def readable(effect: Effect, where: str, xp: Any, function: Any) -> Any:
    """A function of an effect; what it does not do on numbers other than NumPy's floats is said in one line."""
    if xp is np:
        return function

    def named(*state: Any) -> Any:
        try:
            return function(*state)
        except PendpinError:
            raise
        except Exception as error:
            raise InputError(
                f"{where}: {effect.kind} does not run on symbols ({error}): write it with + - * / ** and the functions "
                "of xp, or let its property `smooth` be False"
            ) from None

    return named
