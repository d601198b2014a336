"""From a scene's effects and a model to one function for each interface, built once from the effects that there are.

Every function takes its arithmetic from `xp`, as the effects do. Sums have a fixed order, so that the order of
the list changes no bit.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.acting import chosen_bodies, chosen_joints, in_order, plain_arithmetic, refuse_seconds
from pendpin.dynamics.parameters import GIVEN, Numbers
from pendpin.effects import (
    Bodies,
    BodyEffect,
    Drag,
    Effect,
    FieldEffect,
    FrameEffect,
    JointEffect,
    Motion,
    Motor,
    Push,
    Support,
)
from pendpin.effects.base import returned
from pendpin.engines import Loads
from pendpin.errors import InputError, PendpinError, shown
from pendpin.model.build import Model

WRENCH = "a force", "a moment"
LATEST = 340  # digits: more than a time times a frequency can have before its point
Torque = Callable[[float, Array, Array], Array]  # t, q, v (nv,) -> (nv,)
Wrench = Callable[[Any, Motion], tuple[Array, Array]]  # force, moment about com, (bodies, 3)


def bind_loads(
    model: Model, effects: Sequence[Effect], xp: Any = np, start: float = 0.0, numbers: Numbers = GIVEN
) -> Loads:
    """What the effects add, interface by interface, at times since `start` in s.

    `numbers` maps the numbers of model and effects, for instance to parameters of a tape. Raises InputError for a
    joint or link that the model lacks, and for a second effect of a kind of which a scene takes one.
    """
    refuse_seconds(effects)
    constant, varying = np.zeros(3), list[Any]()
    torques: list[Torque] = []
    wrenches: list[Wrench] = []
    bodies: Bodies | None = None
    for effect, where in in_order(effects):
        if isinstance(effect, FieldEffect) and effect.constant:
            constant = constant + law(effect, "field")(0.0)
        elif isinstance(effect, FieldEffect):
            varying.append(_readable(effect, where, xp, field_since(start, effect, "field", xp, numbers)))
        elif isinstance(effect, JointEffect):
            torque = joint_torque(model, effect, where, xp, numbers)
            torques.append(_readable(effect, where, xp, since(start, effect, torque, numbers)))
        elif isinstance(effect, BodyEffect):
            bodies = bodies or Bodies(*map(numbers.bodies, bodies_of(model)))
            wrench = body_wrench(model, effect, where, xp, numbers, bodies)
            wrenches.append(_readable(effect, where, xp, since(start, effect, wrench, numbers)))
    complete = surroundings(effects, xp, start, numbers)
    return Loads(
        numbers(constant),
        _total(varying),
        _total(torques),
        *_in_place(_total_wrench(wrenches), complete, plain_arithmetic(effects)),
        axial=any(effect.axial for effect in effects if isinstance(effect, BodyEffect)),
    )


def _readable(effect: Effect, where: str, xp: Any, function: Any) -> Any:
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


def law(effect: Effect, name: str, xp: Any = np, numbers: Numbers = GIVEN) -> Callable[..., Any]:
    """A method of an effect, by its name. That of a user's own class gets copies, and what it returns is checked."""
    method = partial(getattr(numbers.effect(effect), name), xp=xp)
    if type(effect).__module__.startswith("pendpin."):
        return method
    what, kind = f"effects: {effect.kind}: its {name}", float if xp is np else object

    def checked(t: Any, *state: Any) -> Any:
        found = method(t, *map(_copy, state))
        if name != "wrench":
            return returned(what, found, state[0].shape if state else (3,), kind)
        if not isinstance(found, tuple | list) or len(found) != len(WRENCH):
            raise InputError(f"{what} returned {shown(found)}, where {' and '.join(WRENCH)} are wanted")
        return tuple(returned(what, part, state[0].com.shape, kind) for part in found)

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
    early = numbers(_in_first_period(start, effect))
    return lambda t, *state: function(early + t, *state)


def field_since(
    start: float, effect: FieldEffect, name: str, xp: Any = np, numbers: Numbers = GIVEN
) -> Callable[[float], Array]:
    """A function of time of a field, by its name, as a function t -> (3,) of the time since `start`, s."""
    moved, early = effect.since(start)
    function = law(moved, name, xp, numbers)
    return since(start, effect, function, numbers) if early else function


def _in_first_period(start: float, effect: Effect) -> Any:
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


def joint_torque(model: Model, effect: JointEffect, where: str, xp: Any = np, numbers: Numbers = GIVEN) -> Torque:
    """The torques (nv,) in N m of one effect, as a function of t in s and q, v (nv,)."""
    torques, nv = law(effect, "torques", xp, numbers), len(model.joints)
    if effect.on is None:
        return torques
    chosen = chosen_joints(model, effect.on, where)
    if numbers.by_rod:
        share = numbers.joints(np.isin(np.arange(nv), chosen))
        return lambda t, q, v: share * torques(t, q, v)

    def torque(t: float, q: Array, v: Array) -> Array:
        found = torques(t, q[chosen], v[chosen])
        tau = np.zeros(nv, found.dtype)
        tau[chosen] = found
        return tau

    return torque


def body_wrench(
    model: Model, effect: BodyEffect, where: str, xp: Any = np, numbers: Numbers = GIVEN, bodies: Bodies | None = None
) -> Wrench:
    """Force (n, 3) in N and moment (n, 3) in N m of one effect on all n bodies, in W, as a function of t and motion."""
    _refuse_no_point(model, effect, where)
    bodies, wrench = bodies or bodies_of(model), law(effect, "wrench", xp, numbers)
    if effect.on is None:
        return lambda t, motion: wrench(t, bodies, motion)
    chosen = chosen_bodies(model, effect.on, where)
    if numbers.by_rod:
        share = numbers.bodies(np.isin(np.arange(len(model.bodies)), chosen)[:, None])
        return lambda t, motion: tuple(share * part for part in wrench(t, bodies, motion))
    some, n = bodies.of(chosen), len(bodies.mass)

    def scattered(found: Array) -> Array:
        out = np.zeros((*found.shape[:-2], n, 3), found.dtype)
        out[..., chosen, :] = found
        return out

    def on_some(t: float, motion: Motion) -> tuple[Array, Array]:
        force, moment = wrench(t, some, motion.of(chosen))
        return scattered(force), scattered(moment)

    return on_some


def _refuse_no_point(model: Model, effect: BodyEffect, where: str) -> None:
    """Raise InputError for a push at a point of a body that has no tip, and so no direction to measure it along."""
    if isinstance(effect, Push) and effect.point is not None:
        body = model.bodies[chosen_bodies(model, effect.on, where)[0]]
        if not body.tip.any():
            raise InputError(
                f"{where}.point: link {shown(body.link)} has no tip to measure it along; give it one in model.tips"
            )


def bodies_of(model: Model) -> Bodies:
    """The bodies of a model as arrays, one row each."""
    rows = [(body.mass, body.com, body.inertia, body.tip, body.radius) for body in model.bodies]
    return Bodies(*(np.array(column) for column in zip(*rows, strict=True)))


def surroundings(
    effects: Sequence[Effect], xp: Any = np, start: float = 0.0, numbers: Numbers = GIVEN
) -> Callable[[float, Motion], Motion]:
    """A function that completes a motion, at a time since `start`, by what all bodies share: gravity, and where W is.

    It takes times (k,) with motions (k, n, ...) too, if the effects are `plain_arithmetic`.
    """
    ordered = [effect for effect, _ in in_order(effects)]
    frames = [effect for effect in ordered if isinstance(effect, FrameEffect)]
    fields = [effect for effect in ordered if isinstance(effect, FieldEffect) and not isinstance(effect, FrameEffect)]
    steady = numbers(sum((effect.field(0.0) for effect in fields if effect.constant), np.zeros(3)))
    varying = [field_since(start, effect, "field", xp, numbers) for effect in fields if not effect.constant]
    positions = [field_since(start, effect, "position", xp, numbers) for effect in frames]
    velocities = [field_since(start, effect, "velocity", xp, numbers) for effect in frames]

    def complete(t: float, motion: Motion) -> Motion:
        motion = motion._replace(gravity=sum((_shared(field(t)) for field in varying), steady))
        if not frames:
            return motion
        pivot, velocity = (sum((_shared(part(t)) for part in parts), np.zeros(3)) for parts in (positions, velocities))
        return motion._replace(pivot=pivot, pivot_velocity=velocity)

    return complete


def _shared(vector: Array) -> Array:
    """A vector (3,) that all bodies share; (k, 1, 3) of such (k, 3)."""
    return vector[:, None] if vector.ndim > 1 else vector


def _in_place(
    wrench: Wrench | None, complete: Callable[[Any, Motion], Motion], together: bool
) -> tuple[Wrench | None, Callable[[Array, Motion], tuple[Array, Array]] | None]:
    """The wrench as a function of t and a motion without surroundings, and the same at many states if they go together."""
    if wrench is None:
        return None, None

    def many(t: Array, motion: Motion) -> tuple[Array, Array]:
        force, moment = wrench(t[:, None, None], complete(t, motion))
        return np.broadcast_to(force, motion.origin.shape), np.broadcast_to(moment, motion.origin.shape)

    return lambda t, motion: wrench(t, complete(t, motion)), many if together else None


def _total(functions: list[Any]) -> Any:
    """One function that adds the values of several; None for none."""
    if len(functions) < 2:
        return functions[0] if functions else None
    first, *others = functions
    return lambda *args: sum((function(*args) for function in others), first(*args))


def _total_wrench(functions: list[Wrench]) -> Wrench | None:
    """One function that adds forces and moments (n, 3) of several; None for none."""
    if len(functions) < 2:
        return functions[0] if functions else None

    def total(t: float, motion: Motion) -> tuple[Array, Array]:
        forces, moments = zip(*(function(t, motion) for function in functions), strict=True)
        return sum(forces, np.zeros(3)), sum(moments, np.zeros(3))

    return total
