"""The power of the effects that have no potential, for the energy balance: on floats and on symbols."""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.acting import in_order
from pendpin.dynamics.binding import bodies_of, body_wrench, field_since, joint_torque, since, surroundings
from pendpin.dynamics.parameters import GIVEN, Numbers
from pendpin.effects import Bodies, BodyEffect, Effect, FieldEffect, JointEffect, Motion
from pendpin.equations.passes import total
from pendpin.model.build import Model


class Accounts(NamedTuple):
    """The kinds of effects whose work a run integrates."""

    kinds: tuple[str, ...]
    places: tuple[int | None, ...]  # of each effect, in the order of `in_order`; None if it has a potential


def accounts_of(effects: Sequence[Effect], potentials: Sequence[Any]) -> Accounts:
    """An account for each kind of effect; `potentials` in the order of `in_order`, None for an effect without one."""
    ordered = [effect for effect, _ in in_order(effects)]
    kinds = tuple(dict.fromkeys(effect.kind for effect in ordered))
    moving = [
        None if potential is not None else kinds.index(effect.kind)
        for effect, potential in zip(ordered, potentials, strict=True)
    ]
    return Accounts(kinds, tuple(moving))


class State:
    """A state of a model: t in s since the start, q and v (nv,), and the motion of the bodies, computed if it is needed."""

    def __init__(self, t: Any, q: Array, v: Array, motion: Callable[[], Motion]) -> None:
        self.t, self.q, self.v, self._motion = t, q, v, motion

    @cached_property
    def motion(self) -> Motion:
        """Poses and velocities of the bodies."""
        return self._motion()


Power = Callable[[State], Any]  # in W
Powered = Callable[[State], list[Any]]  # the same for each account


def powers(
    model: Model, effects: Sequence[Effect], accounts: Accounts, start: float, xp: Any = np, numbers: Numbers = GIVEN
) -> Powered:
    """The power in W for each account, as a function of the state. Contacts have none here."""
    ordered, complete = in_order(effects), surroundings(effects, xp, start, numbers)
    bodies = Bodies(*map(numbers.bodies, bodies_of(model)))
    found: list[tuple[int, Power]] = []
    for (effect, where), account in zip(ordered, accounts.places, strict=True):
        if account is not None and (power := _power(model, effect, where, start, complete, bodies, xp, numbers)):
            found.append((account, power))

    def each(state: State) -> list[Any]:
        out: list[Any] = [0.0] * len(accounts.kinds)
        for account, power in found:
            out[account] = out[account] + power(state)
        return out

    return each


def _power(
    model: Model,
    effect: Effect,
    where: str,
    start: float,
    complete: Callable[[float, Motion], Motion],
    bodies: Bodies,
    xp: Any,
    numbers: Numbers,
) -> Power | None:
    """The power in W of one effect; None for one that acts through events."""
    if isinstance(effect, JointEffect):
        torque = since(start, effect, joint_torque(model, effect, where, xp, numbers), numbers)
        return lambda state: total(torque(state.t, state.q, state.v) * state.v, xp)
    if isinstance(effect, FieldEffect):
        field = field_since(start, effect, "field", xp, numbers)

        def of_field(state: State) -> Any:
            velocities = state.motion.velocities(bodies.com)
            return total(bodies.mass * (velocities * state.motion.fixed(field(state.t))).sum(-1), xp)

        return of_field
    if not isinstance(effect, BodyEffect):
        return None
    wrench = since(start, effect, body_wrench(model, effect, where, xp, numbers, bodies), numbers)

    def power(state: State) -> Any:
        force, moment = wrench(state.t, complete(state.t, state.motion))
        return total(force * state.motion.velocities(bodies.com) + moment * state.motion.spin, xp)

    return power
