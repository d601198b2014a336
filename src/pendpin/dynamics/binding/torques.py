"""Torques about the joints' axes, forces along those of slides."""

from collections.abc import Callable
from functools import cached_property, partial
from typing import Any

import numpy as np

from pendpin.dynamics.binding.acting import chosen_joints
from pendpin.dynamics.binding.context import Bound, Potential, Power
from pendpin.dynamics.binding.laws import law, readable, since
from pendpin.effects import JointEffect, Motion
from pendpin.equations.passes import total
from pendpin.errors import InputError
from pendpin.ground.arrays import Array

Torque = Callable[[Any, Array, Array], Array]  # t, q, v (nv,) -> (nv,)


class BoundTorque(Bound[JointEffect]):
    """A joint effect of a scene."""

    @cached_property
    def at(self) -> Torque:
        """The torques (nv,) in N m at a time and q, v (nv,)."""
        context = self._context
        torque = since(context.start, self.effect, self._on_joints(), context.numbers)
        return readable(self.effect, self._where, context.xp, torque)

    def _on_joints(self) -> Torque:
        """Its law, which knows its own joints, on those of the model."""
        model, numbers = self._context.model, self._context.numbers
        torques, nv = law(self.effect, "torques", self._context.xp, numbers), len(model.joints)
        if self._each is not None:
            torques = partial(torques, each=numbers.joints(self._each))
        if self.effect.on is None:
            return torques
        chosen = chosen_joints(model, self.effect.on, self._where)
        if numbers.by_rod:
            share = numbers.joints(np.isin(np.arange(nv), chosen))
            return lambda t, q, v: share * torques(t, q, v)

        def torque(t: Any, q: Array, v: Array) -> Array:
            some = torques(t, q[chosen], v[chosen])
            tau = np.zeros(nv, some.dtype)
            tau[chosen] = some
            return tau

        return torque

    @cached_property
    def _each(self) -> Array | None:
        """What the law takes from the rods' lengths, a row for each joint; None if it takes nothing. Raises InputError."""
        chain = self._context.model.chain
        each = self.effect.of_joints(np.ones(1) if chain is None else chain.l)
        if each is not None and chain is None:
            raise InputError(f"{self._where}: {self.effect.kind} acts between rods: it needs a chain")
        return each

    def power(self) -> Power:
        """As `Bound`."""
        torque, xp = self.at, self._context.xp
        return lambda state: total(torque(state.t, state.q, state.v) * state.v, xp)

    def potential(self) -> Potential | None:
        """As `Bound`."""
        chosen = chosen_joints(self._context.model, self.effect.on, self._where)
        given = {} if self._each is None else {"each": self._each}
        return self._where_offered(lambda q, poses: self.effect.potential(q[:, chosen], **given))

    def action(self, q: Array, v: Array, motion: Motion) -> Callable[[float], Array]:
        """As `Bound`."""
        return lambda t: self.at(t, q, v)
