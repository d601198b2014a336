"""Forces and moments on the bodies."""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from pendpin.dynamics.binding.acting import chosen_bodies, plain_arithmetic
from pendpin.dynamics.binding.context import Bound, Potential, Power, State, bodies_of
from pendpin.dynamics.binding.laws import law, readable, since
from pendpin.effects import BodyEffect, Motion, Push
from pendpin.equations.passes import total
from pendpin.errors import InputError, shown
from pendpin.ground.arrays import Array

Wrench = Callable[[Any, Motion], tuple[Array, Array]]  # force N, moment N m about com, (bodies, 3)


class BoundWrench(Bound[BodyEffect]):
    """A body effect of a scene. Motions are those that the context has completed."""

    @cached_property
    def at(self) -> Wrench:
        """Force (n, 3) in N and moment (n, 3) in N m on all n bodies, in W, at a time and a motion."""
        context = self._context
        wrench = since(context.start, self.effect, self._on_bodies(), context.numbers)
        return readable(self.effect, self._where, context.xp, wrench)

    def _on_bodies(self) -> Wrench:
        """Its law, which knows its own bodies, on those of the model."""
        model, numbers = self._context.model, self._context.numbers
        if isinstance(self.effect, Push) and self.effect.point is not None:
            body = model.bodies[chosen_bodies(model, self.effect.on, self._where)[0]]
            if not body.tip.any():
                raise InputError(
                    f"{self._where}.point: link {shown(body.link)} has no tip to measure it along; give it one in model.tips"
                )
        bodies, wrench = self._context.bodies, law(self.effect, "wrench", self._context.xp, numbers)
        if self.effect.on is None:
            return lambda t, motion: wrench(t, bodies, motion)
        chosen = chosen_bodies(model, self.effect.on, self._where)
        if numbers.by_rod:
            share = numbers.bodies(np.isin(np.arange(len(model.bodies)), chosen)[:, None])
            return lambda t, motion: tuple(share * part for part in wrench(t, bodies, motion))
        some, n = bodies.of(chosen), len(bodies.mass)

        def scattered(rows: Array) -> Array:
            out = np.zeros((*rows.shape[:-2], n, 3), rows.dtype)
            out[..., chosen, :] = rows
            return out

        def on_some(t: Any, motion: Motion) -> tuple[Array, Array]:
            force, moment = wrench(t, some, motion.of(chosen))
            return scattered(force), scattered(moment)

        return on_some

    def power(self) -> Power:
        """As `Bound`."""
        complete, bodies, xp, wrench = self._context.complete, self._context.bodies, self._context.xp, self.at

        def power(state: State) -> Any:
            force, moment = wrench(state.t, complete(state.t, state.motion))
            return total(force * state.motion.velocities(bodies.com) + moment * state.motion.spin, xp)

        return power

    def potential(self) -> Potential | None:
        """As `Bound`.

        It may look at gravity and at where W is: where these change with time, it has no potential.
        """
        if not self._context.steady:
            return None
        chosen = chosen_bodies(self._context.model, self.effect.on, self._where)
        bodies, rest = bodies_of(self._context.model).of(chosen), np.zeros((len(chosen), 3))

        def at(poses: Array) -> Any:
            poses = poses[..., chosen, :, :]
            motion = Motion(poses[..., :3, 3], poses[..., :3, :3], rest, rest)
            return self.effect.potential(bodies, self._context.complete(0.0, motion))

        def potential(q: Array, poses: Array) -> Any:
            if plain_arithmetic([self.effect]):
                return at(poses)
            values = [at(pose) for pose in poses]
            return None if values[0] is None else np.array([np.sum(value) for value in values], float)

        return self._where_offered(potential)

    def action(self, q: Array, v: Array, motion: Motion) -> Callable[[float], Array]:
        """As `Bound`."""
        return lambda t: np.concatenate(self.at(t, self._context.complete(t, motion))).ravel()
