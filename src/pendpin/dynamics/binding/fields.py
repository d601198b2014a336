"""Fields: a uniform acceleration of all bodies."""

from collections.abc import Callable
from functools import cached_property
from typing import Any

from pendpin.dynamics.binding.context import Bound, Potential, Power, State
from pendpin.dynamics.binding.laws import readable
from pendpin.effects import FieldEffect, Motion
from pendpin.equations.passes import total
from pendpin.ground.arrays import Array
from pendpin.model import kinematics


class BoundField(Bound[FieldEffect]):
    """A field of a scene."""

    @cached_property
    def at(self) -> Callable[[Any], Array]:
        """The field (3,) in m/s² in W at a time."""
        return readable(self.effect, self._where, self._context.xp, self._context.field(self.effect, "field"))

    def power(self) -> Power:
        """As `Bound`."""
        field, bodies, xp = self.at, self._context.bodies, self._context.xp

        def power(state: State) -> Any:
            velocities = state.motion.velocities(bodies.com)
            return total(bodies.mass * (velocities * state.motion.fixed(field(state.t))).sum(-1), xp)

        return power

    def potential(self) -> Potential | None:
        """As `Bound`: of a constant field."""
        if not self.effect.constant:
            return None
        model, field = self._context.model, self.effect.field(0.0)
        return lambda q, poses: kinematics.field_potential(model, poses, field)

    def action(self, q: Array, v: Array, motion: Motion) -> Callable[[float], Array]:
        """As `Bound`."""
        return self.at
