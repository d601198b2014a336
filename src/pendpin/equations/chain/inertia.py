"""The mass properties of a chain, and the constants that its equations need, computed once per chain."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pendpin.errors import InputError
from pendpin.ground.arrays import Array

# The eliminated system replaces a principal inertia of zero by this fraction of a small inertia of the chain. Refinement
# with the original balances removes its effect (refinement.py); the value only determines the number of passes.
STAND_IN = 1e-7


class Rods(NamedTuple):
    """Constants of K rods in a row, rods on the last axis; the compliances are those of docs/derivation_chain.md."""

    n: int  # rods in a chain; the K rods are K / n copies of it, one for each state of a batch
    m: Array  # (K,) kg
    h: Array  # (K,) m, centre of mass from the joint
    k: Array  # (K,) m, tip from the centre of mass
    inertia: Array  # (3, K) kg m², central
    inverse: Array  # (3, K) its inverse, stand-ins where it is 0
    base: Array  # (3, K) 1/kg, acceleration of the base for a force there, along b1, b2, b3
    cross: Array  # (3, K) 1/kg, acceleration of the base for a force on the tip
    tip_above: Array  # (3, K) 1/kg, acceleration of the tip of the rod above for a force there; 0 for the first
    lever_h: Array  # (2, K) 1/(kg m), h / I2 and h / I1
    lever_k: Array  # (K,) 1/(kg m), k / I1
    lever_above: Array  # (K,) 1/(kg m), k / I2 of the rod above; 0 for the first
    twist: Array  # (4, K) 1/(kg m²), 1/I2 above, 1/I1, 1/I3 above, 1/I3: what the squares of s_t, s, c_t, c go with

    def repeated(self, times: int) -> "Rods":
        """The same chain `times` over, so that a batch of states is one long row."""
        return self if times == 1 else Rods(self.n, *(np.tile(field, times) for field in self[1:]))


@dataclass(frozen=True, eq=False)
class ChainInertia:
    """A chain's rods from the support down, each array (n,): the fields of RodInertia, and where the next joint is.

    A thin rod has I3 = 0, a point mass at the end of a massless rod I1 = I2 = I3 = 0. Values are taken as given: the
    scene has validated them; arrays are copied and frozen. Raises InputError if a rod has I3 = 0 but I1 != I2.
    """

    m: Array  # kg
    h: Array  # m, centre of mass from the joint along b3
    l: Array  # m, next joint from the joint along b3  # noqa: E741
    I1: Array  # kg m², central, about b1
    I2: Array  # kg m², central, about b2
    I3: Array  # kg m², about b3

    def __post_init__(self) -> None:
        for name in ("m", "h", "l", "I1", "I2", "I3"):
            values = np.array(getattr(self, name), dtype=float)
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        odd = np.flatnonzero((self.I3 == 0) & (self.I1 != self.I2))
        if odd.size:
            raise InputError(f"rod {odd[0] + 1}: without axial inertia (I3 = 0), I1 and I2 have to be equal")

    @property
    def n(self) -> int:
        """The number of rods."""
        return len(self.m)

    @property
    def first_thin(self) -> int:
        """Index of the first rod of the thin tail: from it on, no rod has an axial inertia. n if the last one has."""
        thick = np.flatnonzero(self.I3)
        return int(thick[-1]) + 1 if thick.size else 0

    @cached_property
    def rods(self) -> Rods:
        """The constants of the equations."""
        n, m, h, k = self.n, self.m, self.h, self.l - self.h
        inertia = np.array([self.I1, self.I2, self.I3])
        inverse = 1 / np.where(inertia > 0, inertia, self._stand_ins())
        across = inverse[[1, 0]]  # a force along b1 turns the rod about b2, and the other way round
        base, cross, tip = np.tile(1 / m, (3, 3, 1))
        base[:2] += h * h * across
        cross[:2] -= h * k * across
        tip[:2] += k * k * across
        _, above2, above3 = above(inverse, n)
        twist = np.array([above2, inverse[0], above3, inverse[2]])
        levers = h * across[:2], k * inverse[0], above(k, n) * above2
        return Rods(n, m, h, k, inertia, inverse, base, cross, above(tip, n), *levers, twist)

    def _stand_ins(self) -> Array:
        """Substitutes (3, n) in kg m² for zero inertias in the factored matrix: small compared with the rods' own."""
        transverse = STAND_IN * self.m * self.h**2
        axial, thick = np.empty(self.n), np.inf
        for i in reversed(range(self.n)):
            thick = self.I3[i] if self.I3[i] > 0 else thick
            axial[i] = STAND_IN * min(self.I1[i] or transverse[i], thick)
        return np.array([transverse, transverse, axial])


def above(x: Array, n: int) -> Array:
    """For each rod what the rod above it has, x (..., K) shifted down; 0 for the first of each chain of n."""
    y = np.empty_like(x)
    y[..., 1:] = x[..., :-1]
    y[..., ::n] = 0
    return y


def below(x: Array, n: int) -> Array:
    """For each rod what the rod below it has, x (..., K) shifted up; 0 for the last of each chain of n."""
    y = np.empty_like(x)
    y[..., :-1] = x[..., 1:]
    y[..., n - 1 :: n] = 0
    return y
