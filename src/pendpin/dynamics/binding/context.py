"""What effects are bound to: a model, a kind of number, the start of the run; and what all bodies share."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np

from pendpin.dynamics.binding.acting import in_order
from pendpin.dynamics.binding.laws import law, since
from pendpin.dynamics.parameters import GIVEN, Numbers
from pendpin.effects import Bodies, Effect, FieldEffect, FrameEffect, Motion
from pendpin.ground.arrays import Array
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
