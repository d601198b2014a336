"""The power of the effects that have no potential, for the energy balance: on floats and on symbols."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from pendpin.dynamics.binding import Binding
from pendpin.dynamics.binding.acting import in_order
from pendpin.dynamics.binding.context import State
from pendpin.effects import Effect


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


Powered = Callable[[State], list[Any]]  # the power in W for each account


def powers(binding: Binding, accounts: Accounts) -> Powered:
    """The power in W for each account, as a function of the state. Contacts have none here."""
    acts = zip(binding.acts, accounts.places, strict=True)
    parts = [(account, bound.power()) for bound, account in acts if bound and account is not None]

    def each(state: State) -> list[Any]:
        out: list[Any] = [0.0] * len(accounts.kinds)
        for account, power in parts:
            out[account] = out[account] + power(state)
        return out

    return each
