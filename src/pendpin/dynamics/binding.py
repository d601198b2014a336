"""The effects of a scene on a model: each through its interface, and the sum of what they exert, built once.

One class for each interface says what an effect exerts, its power and its potential. Every function takes its arithmetic
from `xp`, as the effects do; times count from the start. Sums have a fixed order (`in_order`), so that the order of a
scene's list changes no bit.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple, Self

import numpy as np

from pendpin.dynamics.acting import chosen_bodies, chosen_joints, in_order, law, plain_arithmetic
from pendpin.dynamics.parameters import GIVEN, Numbers
from pendpin.effects import Bodies, BodyEffect, Effect, FieldEffect, FrameEffect, JointEffect, Motion, Push
from pendpin.effects.base import returned
from pendpin.engines import GivenTorque, Loads
from pendpin.equations.trees import total
from pendpin.errors import InputError, PendpinError, shown
from pendpin.ground.arrays import Array
from pendpin.model import kinematics
from pendpin.model.build import Model

Potential = Callable[[Array, Array], Any]  # q (n, nv), poses (n, bodies, 4, 4) -> J (n,)
Power = Callable[["State"], Any]  # in W
Powered = Callable[["State"], list[Any]]  # the power in W for each account
Wrench = Callable[[Any, Motion], tuple[Array, Array]]  # force N, moment N m about com, (bodies, 3)


class State(NamedTuple):
    """A state of a model, q and v (nv,) at t in s since the start."""

    t: Any
    q: Array
    v: Array
    motion: Callable[[], Motion]  # of the bodies, computed once and only if it is needed


class Accounts(NamedTuple):
    """The kinds of effects whose work a run integrates."""

    kinds: tuple[str, ...]
    places: tuple[int | None, ...]  # of each effect, in the order of `in_order`; None if it has a potential

    @classmethod
    def of(cls, effects: Sequence[Effect], potentials: Sequence[Any]) -> Self:
        """One for each kind of effect; `potentials` in the order of `in_order`, None for an effect without one."""
        ordered = [effect.kind for effect, _ in in_order(effects)]
        kinds, pairs = tuple(dict.fromkeys(ordered)), zip(ordered, potentials, strict=True)
        return cls(kinds, tuple(kinds.index(kind) if potential is None else None for kind, potential in pairs))


@dataclass(eq=False)
class Binding:
    """The effects of a scene on a model, on one kind of number; times count from `start` in s.

    `numbers` maps the numbers of model and effects, for instance to parameters of a tape. Raises InputError for a joint or
    link that the model lacks, and for a second effect of a kind of which a scene takes one.
    """

    model: Model
    effects: Sequence[Effect]
    start: float = 0.0
    numbers: Numbers = GIVEN

    @cached_property
    def bodies(self) -> Bodies:
        """The bodies of the model."""
        return Bodies(*map(self.numbers.per_rod, self.model.body_arrays))

    @cached_property
    def acts(self) -> list["Bound | None"]:
        """Each effect, in the order of `in_order`; None for one that acts through events."""
        first: dict[str, int] = {}
        for i, effect in enumerate(self.effects):
            if effect.sole is not None and (before := first.setdefault(effect.sole, i)) != i:
                second = f"effects[{i}]: a second {effect.kind} beside effects[{before}]"
                raise InputError(f"{second}; {effect.sole}: put both into one")
        return [self.bound(effect, where) for effect, where in in_order(self.effects)]

    def bound(self, effect: Effect, where: str) -> "Bound | None":
        """One effect, whose key path is `where`; None for one that acts through events."""
        if isinstance(effect, FieldEffect):
            return BoundField(self, effect, where)
        if isinstance(effect, JointEffect):
            return BoundTorque(self, effect, where)
        return BoundWrench(self, effect, where) if isinstance(effect, BodyEffect) else None

    @cached_property
    def loads(self) -> Loads:
        """What the effects add, interface by interface."""
        constant, varying, torques, wrenches = np.zeros(3), list[Any](), list[GivenTorque](), list[Wrench]()
        for bound in self.acts:
            if isinstance(bound, BoundField) and bound.effect.constant:
                constant = constant + law(bound.effect, "field")(0.0)
            elif isinstance(bound, BoundField):
                varying.append(bound.at)
            elif isinstance(bound, BoundTorque):
                torques.append(bound.at)
            elif isinstance(bound, BoundWrench):
                wrenches.append(bound.at)
        complete = self.complete

        def wrench(t: Any, motion: Motion) -> tuple[Array, Array]:
            completed = complete(t, motion)
            forces, moments = zip(*(function(t, completed) for function in wrenches), strict=True)
            return sum(forces, np.zeros(3)), sum(moments, np.zeros(3))

        return Loads(
            self.numbers(constant),
            _total(varying),
            _total(torques),
            wrench if wrenches else None,
            axial=any(effect.axial for effect in self.effects if isinstance(effect, BodyEffect)),
        )

    def powers(self, accounts: Accounts) -> Powered:
        """The power in W for each account, as a function of the state. Contacts have none here."""
        acts = zip(self.acts, accounts.places, strict=True)
        parts = [(account, bound.power()) for bound, account in acts if bound and account is not None]

        def each(state: State) -> list[Any]:
            out: list[Any] = [0.0] * len(accounts.kinds)
            for account, power in parts:
                out[account] = out[account] + power(state)
            return out

        return each

    def law(self, effect: Effect, name: str) -> Callable[..., Any]:
        """A method of an effect, by its name, as a function of the time since the start: late times then lose no digits."""
        moved, early = effect.since(self.start)
        function = law(moved, name, self.numbers)
        if not early:
            return function
        early = self.numbers(early)
        return lambda t, *state, **given: function(early + t, *state, **given)

    @cached_property
    def complete(self) -> Callable[[Any, Motion], Motion]:
        """A function that completes a motion, at a time, by what all bodies share: gravity, and where W is."""
        fields = [effect for effect, _ in in_order(self.effects) if isinstance(effect, FieldEffect)]
        frames = [effect for effect in fields if isinstance(effect, FrameEffect)]
        fields = [effect for effect in fields if not isinstance(effect, FrameEffect)]
        steady = self.numbers(sum((effect.field(0.0) for effect in fields if effect.constant), np.zeros(3)))
        sums = {"gravity": ([self.law(effect, "field") for effect in fields if not effect.constant], steady)}
        if frames:
            sums["pivot"] = [self.law(effect, "position") for effect in frames], np.zeros(3)
            sums["pivot_velocity"] = [self.law(effect, "velocity") for effect in frames], np.zeros(3)

        def complete(t: Any, motion: Motion) -> Motion:
            given = dict[str, Any]()
            for name, (functions, first) in sums.items():
                given[name] = sum((function(t) for function in functions), first)
            return motion._replace(**given)

        return complete


def _total(functions: list[Any]) -> Any:
    """One function that adds the values of several; None for none."""
    if len(functions) < 2:
        return functions[0] if functions else None
    first, *others = functions
    return lambda *args: sum((function(*args) for function in others), first(*args))


@dataclass(eq=False)
class Bound(ABC):
    """One effect on a model; `where` is its key path. A child says by `at` what it exerts through one interface."""

    binding: Binding
    effect: Any
    where: str

    def _named(self, function: Any) -> Any:
        """A law whose errors on numbers other than NumPy's floats are one line that names the effect."""
        if self.binding.numbers.xp is np:
            return function

        def named(*state: Any) -> Any:
            try:
                return function(*state)
            except PendpinError:
                raise
            except Exception as error:
                remedy = "write it with + - * / ** and the functions of xp, or let its property `smooth` be False"
                reason = f"{self.where}: {self.effect.kind} does not run on symbols ({error}): {remedy}"
                raise InputError(reason) from None

        return named

    @abstractmethod
    def power(self) -> Power:
        """Its power in W, as a function of the state."""

    @abstractmethod
    def potential(self) -> Potential | None:
        """Its potential (n,) in J; None if it has none."""

    def _where_offered(self, potential: Potential) -> Potential | None:
        """The potential, or None if its value is None; the shape of a user's own is checked."""
        model, what = self.binding.model, f"effects: {self.effect.kind}: its potential"
        q = np.zeros((1, len(model.joints)))
        with np.errstate(all="ignore"):
            if potential(q, kinematics.poses(model, q)) is None:
                return None
        if type(self.effect).__module__.startswith("pendpin."):
            return potential
        return lambda q, poses: returned(what, potential(q, poses), (len(q),))


class BoundField(Bound):
    """A field of a scene: a uniform acceleration of all bodies."""

    effect: FieldEffect

    @cached_property
    def at(self) -> Callable[[Any], Array]:
        """The field (3,) in m/s² in W at a time."""
        return self._named(self.binding.law(self.effect, "field"))

    def power(self) -> Power:
        """The sum of m v . field over the bodies, W."""
        field, bodies, xp = self.at, self.binding.bodies, self.binding.numbers.xp

        def power(state: State) -> Any:
            motion = state.motion()
            velocities = motion.velocities(bodies.com)
            return total(bodies.mass * (velocities * motion.fixed(field(state.t))).sum(-1), xp)

        return power

    def potential(self) -> Potential | None:
        """The potential of a constant field, J."""
        if not self.effect.constant:
            return None
        model, field = self.binding.model, self.effect.field(0.0)
        return lambda q, poses: kinematics.field_potential(model, poses, field)


class BoundTorque(Bound):
    """A joint effect of a scene: torques about the joints' axes, forces along those of slides."""

    effect: JointEffect

    @cached_property
    def at(self) -> GivenTorque:
        """The torques (nv,) in N m at a time and q, v (nv,)."""
        model, numbers, each = self.binding.model, self.binding.numbers, self._each
        torques: Any = self.binding.law(self.effect, "torques")
        nv = len(model.joints)
        if each is not None:
            torques = partial(torques, each=numbers.per_rod(each))
        if self._angles is not None:  # the law is of every rod's theta and phi, and some rods have one of them
            angles = self._angles[: 2 if numbers.by_rod else None]
            return self._named(lambda t, *state: torques(t, *(_spread(x, angles, len(angles)) for x in state))[angles])
        if self.effect.on is None:
            return self._named(torques)
        chosen = chosen_joints(model, self.effect.on, self.where)
        if numbers.by_rod:
            share = numbers.per_rod(np.isin(np.arange(nv), chosen))
            return self._named(lambda t, q, v: share * torques(t, q, v))
        return self._named(lambda t, q, v: _spread(torques(t, q[chosen], v[chosen]), chosen, nv))

    @cached_property
    def _each(self) -> Array | None:
        """What the law takes from the rods' lengths, a row for each angle; None if it takes nothing. Raises InputError."""
        model = self.binding.model
        if model.rod_tree is not None:
            return self.effect.of_joints(model.lengths, model.rod_tree.parents)
        if self.effect.of_joints(np.ones(1)) is not None:
            raise InputError(f"{self.where}: {self.effect.kind} acts between rods: it needs a chain")
        return None

    @property
    def _angles(self) -> Any:
        """Which of theta and phi every rod has, (2 n,), where the law is of both and some rod has one; else None."""
        tree = self.binding.model.rod_tree
        return None if self._each is None or tree is None or tree.angles.all() else tree.angles.ravel()

    def power(self) -> Power:
        """torque . v, W."""
        torque, xp = self.at, self.binding.numbers.xp
        return lambda state: total(torque(state.t, state.q, state.v) * state.v, xp)

    def potential(self) -> Potential | None:
        """The potential that the effect offers, J."""
        chosen, angles = chosen_joints(self.binding.model, self.effect.on, self.where), self._angles
        given: Any = {} if self._each is None else {"each": self._each}
        of_law = (lambda q: q[:, chosen]) if angles is None else (lambda q: _spread(q, angles, len(angles)))
        return self._where_offered(lambda q, poses: self.effect.potential(of_law(q), **given))


def _spread(x: Array, places: Array, size: int, axis: int = -1) -> Array:
    """Numbers at their places along an axis of this size, 0 elsewhere: as the angle that a hinge lacks."""
    shape = list(x.shape)
    shape[axis] = size
    out = np.zeros(shape, x.dtype)
    out.swapaxes(axis, -1)[..., places] = x.swapaxes(axis, -1)
    return out


class BoundWrench(Bound):
    """A body effect of a scene: forces and moments. Motions are those that the binding has completed."""

    effect: BodyEffect

    @cached_property
    def at(self) -> Wrench:
        """Force (n, 3) in N and moment (n, 3) in N m on all n bodies, in W, at a time and a motion."""
        model, numbers = self.binding.model, self.binding.numbers
        if isinstance(self.effect, Push) and self.effect.point is not None:
            body = model.bodies[chosen_bodies(model, self.effect.on, self.where)[0]]
            if not body.tip.any():
                which = f"{self.where}.point: link {shown(body.link)}"
                raise InputError(f"{which} has no tip to measure it along; give it one in model.tips")
        bodies, wrench = self.binding.bodies, self.binding.law(self.effect, "wrench")
        if self.effect.on is None:
            return self._named(lambda t, motion: wrench(t, bodies, motion))
        chosen = chosen_bodies(model, self.effect.on, self.where)
        if numbers.by_rod:
            share = numbers.per_rod(np.isin(np.arange(len(model.bodies)), chosen)[:, None])
            return self._named(lambda t, motion: tuple(share * part for part in wrench(t, bodies, motion)))
        some, n = bodies.of(chosen), len(bodies.mass)
        return self._named(
            lambda t, motion: tuple(_spread(x, chosen, n, -2) for x in wrench(t, some, motion.of(chosen)))
        )

    def power(self) -> Power:
        """The sum of F . v + M . omega over the bodies, W."""
        complete, bodies, xp, wrench = self.binding.complete, self.binding.bodies, self.binding.numbers.xp, self.at

        def power(state: State) -> Any:
            motion = state.motion()
            force, moment = wrench(state.t, complete(state.t, motion))
            return total(force * motion.velocities(bodies.com) + moment * motion.spin, xp)

        return power

    def potential(self) -> Potential | None:
        """The potential that the effect offers, J. It may depend on gravity and on where W is: None where these change."""
        if not all(effect.constant for effect in self.binding.effects if isinstance(effect, FieldEffect)):
            return None
        chosen = chosen_bodies(self.binding.model, self.effect.on, self.where)
        bodies, rest = self.binding.model.body_arrays.of(chosen), np.zeros((len(chosen), 3))

        def at(poses: Array) -> Any:
            poses = poses[..., chosen, :, :]
            motion = Motion(poses[..., :3, 3], poses[..., :3, :3], rest, rest)
            return self.effect.potential(bodies, self.binding.complete(0.0, motion))

        def potential(q: Array, poses: Array) -> Any:
            if plain_arithmetic([self.effect]):
                return at(poses)
            values = [at(pose) for pose in poses]
            return None if values[0] is None else np.array([np.sum(value) for value in values], float)

        return self._where_offered(potential)
