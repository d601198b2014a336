"""From a scene's effects and a model to the sum of what they exert, built once from the effects that there are.

Every function takes its arithmetic from `xp`, as the effects do. Sums have a fixed order, so that the order of
the list changes no bit.
"""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np

from pendpin.dynamics.binding.acting import in_order, law, plain_arithmetic, refuse_seconds
from pendpin.dynamics.binding.bound import Bound, BoundField, BoundTorque, BoundWrench, Context, State, Wrench
from pendpin.effects import BodyEffect, Effect, FieldEffect, JointEffect, Motion
from pendpin.engines import Loads
from pendpin.ground.arrays import Array


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


Powered = Callable[[State], list[Any]]  # the power in W for each account


class Binding(Context):
    """The effects of a scene on a model.

    Raises InputError for a joint or link that the model lacks, and for a second effect of a kind of which a scene takes
    one.
    """

    @cached_property
    def acts(self) -> list[Bound | None]:
        """Each effect, in the order of `in_order`; None for one that acts through events."""
        refuse_seconds(self.effects)
        return [self.bound(effect, where) for effect, where in in_order(self.effects)]

    def bound(self, effect: Effect, where: str) -> Bound | None:
        """One effect, whose key path is `where`; None for one that acts through events."""
        if isinstance(effect, FieldEffect):
            return BoundField(self, effect, where)
        if isinstance(effect, JointEffect):
            return BoundTorque(self, effect, where)
        return BoundWrench(self, effect, where) if isinstance(effect, BodyEffect) else None

    @cached_property
    def loads(self) -> Loads:
        """What the effects add, interface by interface."""
        constant, varying, torques, wrenches = np.zeros(3), list[Any](), list[Any](), list[Wrench]()
        for bound in self.acts:
            if isinstance(bound, BoundField) and bound.effect.constant:
                constant = constant + law(bound.effect, "field")(0.0)
            elif isinstance(bound, BoundField):
                varying.append(bound.at)
            elif isinstance(bound, BoundTorque):
                torques.append(bound.at)
            elif isinstance(bound, BoundWrench):
                wrenches.append(bound.at)
        complete, wrench = self.complete, _total_wrench(wrenches)
        return Loads(
            self.numbers(constant),
            _total(varying),
            _total(torques),
            wrench and (lambda t, motion: wrench(t, complete(t, motion))),
            _vectorise(wrench, complete) if wrench and plain_arithmetic(self.effects) else None,
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


def _vectorise(
    wrench: Wrench, complete: Callable[[Any, Motion], Motion]
) -> Callable[[Array, Motion], tuple[Array, Array]]:
    """The wrench at times (k,) and motions (k, n, ...)."""

    def many(t: Array, motion: Motion) -> tuple[Array, Array]:
        force, moment = wrench(t[:, None, None], complete(t, motion))
        return np.broadcast_to(force, motion.origin.shape), np.broadcast_to(moment, motion.origin.shape)

    return many


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
