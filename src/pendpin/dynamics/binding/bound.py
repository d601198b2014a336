"""One effect on a model, through its interface: what it exerts, its power, its potential; times count from the start."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Any, Generic, TypeVar

import numpy as np

from pendpin.dynamics.binding.acting import (
    chosen_bodies,
    chosen_joints,
    in_order,
    law,
    plain_arithmetic,
    readable,
    since,
)
from pendpin.dynamics.parameters import GIVEN, Numbers
from pendpin.effects import Bodies, BodyEffect, Effect, FieldEffect, FrameEffect, JointEffect, Motion, Push
from pendpin.equations.trees import total
from pendpin.errors import InputError, shown
from pendpin.ground.arrays import Array, Mask
from pendpin.model import kinematics
from pendpin.model.build import Model

Effective = TypeVar("Effective", bound=Effect)
Potential = Callable[[Array, Array], Any]  # q (n, nv), poses (n, bodies, 4, 4) -> J (n,)


class Context:
    """A model and the effects on it, on one kind of number; times count from `start` in s.

    `numbers` maps the numbers of model and effects, for instance to parameters of a tape.
    """

    def __init__(
        self, model: Model, effects: Sequence[Effect], xp: Any = np, start: float = 0.0, numbers: Numbers = GIVEN
    ) -> None:
        self.model, self.effects, self.xp, self.start, self.numbers = model, effects, xp, start, numbers

    @cached_property
    def bodies(self) -> Bodies:
        """The bodies of the model."""
        return Bodies(*map(self.numbers.bodies, bodies_of(self.model)))

    @cached_property
    def complete(self) -> Callable[[Any, Motion], Motion]:
        """A function that completes a motion, at a time, by what all bodies share: gravity, and where W is.

        It takes times (k,) with motions (k, n, ...) too, if the effects are `plain_arithmetic`.
        """
        fields = [effect for effect, _ in in_order(self.effects) if isinstance(effect, FieldEffect)]
        frames = [effect for effect in fields if isinstance(effect, FrameEffect)]
        fields = [effect for effect in fields if not isinstance(effect, FrameEffect)]
        steady = self.numbers(sum((effect.field(0.0) for effect in fields if effect.constant), np.zeros(3)))
        varying = [self.field(effect, "field") for effect in fields if not effect.constant]
        positions = [self.field(effect, "position") for effect in frames]
        velocities = [self.field(effect, "velocity") for effect in frames]

        def complete(t: Any, motion: Motion) -> Motion:
            motion = motion._replace(gravity=sum((_shared(field(t)) for field in varying), steady))
            if not frames:
                return motion
            pivot, velocity = (sum((_shared(x(t)) for x in parts), np.zeros(3)) for parts in (positions, velocities))
            return motion._replace(pivot=pivot, pivot_velocity=velocity)

        return complete

    @property
    def steady(self) -> bool:
        """Whether what all bodies share does not change with time."""
        return all(effect.constant for effect in self.effects if isinstance(effect, FieldEffect))

    def field(self, effect: FieldEffect, name: str) -> Callable[[Any], Array]:
        """A function of time of a field, by its name, as a function t -> (3,)."""
        moved, early = effect.since(self.start)
        function = law(moved, name, self.xp, self.numbers)
        return since(self.start, effect, function, self.numbers) if early else function


class State:
    """A state of a model: t in s since the start, q and v (nv,), and the motion of the bodies, computed if it is needed."""

    def __init__(self, t: Any, q: Array, v: Array, motion: Callable[[], Motion]) -> None:
        self.t, self.q, self.v, self._motion = t, q, v, motion

    @cached_property
    def motion(self) -> Motion:
        """Poses and velocities of the bodies."""
        return self._motion()


Power = Callable[[State], Any]  # in W


class Bound(ABC, Generic[Effective]):
    """One effect on a model; `where` is its key path. A child says what it exerts through one interface."""

    def __init__(self, context: Context, effect: Effective, where: str) -> None:
        self.effect, self._where, self._context = effect, where, context

    @abstractmethod
    def power(self) -> Power:
        """Its power in W, as a function of the state."""

    @abstractmethod
    def potential(self) -> Potential | None:
        """Its potential (n,) in J; None if it has none."""

    @abstractmethod
    def action(self, q: Array, v: Array, motion: Motion) -> Callable[[float], Array]:
        """What it exerts in one state, flat, as a function of time."""

    def _where_offered(self, potential: Potential) -> Potential | None:
        """The potential, or None if its value is None."""
        model = self._context.model
        q = np.zeros((1, len(model.joints)))
        with np.errstate(all="ignore"):
            return None if potential(q, kinematics.poses(model, q)) is None else potential


def _shared(vector: Array) -> Array:
    """A vector (3,) that all bodies share; (k, 1, 3) of such (k, 3)."""
    return vector[:, None] if vector.ndim > 1 else vector


def bodies_of(model: Model) -> Bodies:
    """The bodies of a model as arrays, one row each."""
    rows = [(body.mass, body.com, body.inertia, body.tip, body.radius, body.payload_radius) for body in model.bodies]
    return Bodies(*(np.array(column) for column in zip(*rows, strict=True)))


# --- fields: a uniform acceleration of all bodies -------------------------------------------------------------------


class BoundField(Bound[FieldEffect]):
    """A field of a scene."""

    @cached_property
    def at(self) -> Callable[[Any], Array]:
        """The field (3,) in m/s² in W at a time."""
        return readable(self.effect, self._where, self._context.xp, self._context.field(self.effect, "field"))

    def power(self) -> Power:
        field, bodies, xp = self.at, self._context.bodies, self._context.xp

        def power(state: State) -> Any:
            velocities = state.motion.velocities(bodies.com)
            return total(bodies.mass * (velocities * state.motion.fixed(field(state.t))).sum(-1), xp)

        return power

    def potential(self) -> Potential | None:
        if not self.effect.constant:
            return None
        model, field = self._context.model, self.effect.field(0.0)
        return lambda q, poses: kinematics.field_potential(model, poses, field)

    def action(self, q: Array, v: Array, motion: Motion) -> Callable[[float], Array]:
        return self.at


# --- torques about the joints' axes, forces along those of slides ---------------------------------------------------


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
            of_rods = numbers.bodies(self._each.reshape(len(model.rods), -1))
            torques = self._on_rods(partial(torques, each=of_rods.reshape(-1, self._each.shape[-1])))
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
        """What the law takes from the rods' lengths, a row for each angle; None if it takes nothing. Raises InputError."""
        model = self._context.model
        if model.rod_tree is not None:
            return self.effect.of_joints(model.lengths, model.rod_tree.parents)
        if self.effect.of_joints(np.ones(1)) is not None:
            raise InputError(f"{self._where}: {self.effect.kind} acts between rods: it needs a chain")
        return None

    def _on_rods(self, torques: Torque) -> Torque:
        """A law of every rod's theta and phi as one of the model's joints, where some rods have one of them."""
        if not self._hinged:
            return torques

        def of_joints(t: Any, q: Array, v: Array) -> Array:
            return torques(t, self._of_rods(q), self._of_rods(v))[self._angles]

        return of_joints

    @property
    def _angles(self) -> Mask:
        """Which of theta and phi there are, (2 n,), of all rods; of one rod if equations are by rod."""
        tree, kept = self._context.model.rod_tree, slice(2 if self._context.numbers.by_rod else None)
        return np.ones(0, bool) if tree is None else tree.angles.ravel()[kept]

    @property
    def _hinged(self) -> bool:
        """Whether the law is of every rod's two angles, and some rod has one."""
        return self._each is not None and not self._angles.all()

    def _of_rods(self, x: Array) -> Array:
        """Numbers (..., nv) of the joints as those of every rod's theta and phi, (..., 2 n): 0 of what a hinge lacks."""
        out = np.zeros((*x.shape[:-1], len(self._angles)), x.dtype)
        out[..., self._angles] = x
        return out

    def power(self) -> Power:
        torque, xp = self.at, self._context.xp
        return lambda state: total(torque(state.t, state.q, state.v) * state.v, xp)

    def potential(self) -> Potential | None:
        chosen = chosen_joints(self._context.model, self.effect.on, self._where)
        given: Any = {} if self._each is None else {"each": self._each}
        of_rods = self._of_rods if self._hinged else lambda q: q[:, chosen]
        return self._where_offered(lambda q, poses: self.effect.potential(of_rods(q), **given))

    def action(self, q: Array, v: Array, motion: Motion) -> Callable[[float], Array]:
        return lambda t: self.at(t, q, v)


# --- forces and moments on the bodies -------------------------------------------------------------------------------


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
        complete, bodies, xp, wrench = self._context.complete, self._context.bodies, self._context.xp, self.at

        def power(state: State) -> Any:
            force, moment = wrench(state.t, complete(state.t, state.motion))
            return total(force * state.motion.velocities(bodies.com) + moment * state.motion.spin, xp)

        return power

    def potential(self) -> Potential | None:
        # it may look at gravity and at where W is: where these change with time, it has no potential
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
        return lambda t: np.concatenate(self.at(t, self._context.complete(t, motion))).ravel()
