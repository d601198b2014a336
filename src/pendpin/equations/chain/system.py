"""The parts of a chain's equations, for any number of reactions a joint (docs/derivation_chain.md, section 3)."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pendpin.equations.chain.inertia import Rods
from pendpin.ground.arrays import Array


class RodLoads(NamedTuple):
    """Force and turning moment of reactions on the rods: (3, K) each."""

    force: Array  # N
    turning: Array  # N m about G


@dataclass(frozen=True)
class System(ABC):
    """Balances of force and turning of every rod, and conditions of the joints; accelerations are relative to the field.

    A reaction x has r rows for each joint. Subclasses give the loads of reactions on the rods (`loads`), the residuals of
    the joint conditions at given accelerations (`gaps`), and the matrix from reactions to gaps (`band`). The unknowns are
    the reactions x and the turning accelerations, such that gaps are zero and known turning + loads = resistance.
    """

    rods: Rods
    inverse: Array  # (3, K) or (K,), inverse inertia against turning, stand-ins where the inertia is 0
    support: Array  # (3, 1) or (3, states) m/s², acceleration of the support in I, less the field
    push: Array | float  # (3, K) m/s², external force over mass
    turning: Array  # (3, K) N m, known, about G

    @abstractmethod
    def gaps(self, linear: Array | float, turn: Array) -> Array:
        """The residuals (K, r) at the joints, from accelerations linear of G (3, K), m/s², and turn (3, K), 1/s²."""

    @abstractmethod
    def loads(self, x: Array) -> RodLoads:
        """Force and turning on every rod by the reactions x (r, K) of its own joint and of the next."""

    @abstractmethod
    def resistance(self, turn: Array) -> Array:
        """The turning moment (3, K) in N m that the accelerations turn (3, K) need."""

    @abstractmethod
    def band(self) -> Array:
        """The matrix that takes reactions to gaps, in LAPACK's lower band: (2 r, r K), Fortran order."""

    @abstractmethod
    def bare(self) -> "System":
        """The same without its known terms, so that `gaps` is linear."""


def empty_band(K: int, r: int) -> tuple[Array, Array]:
    """A lower band of K joints with r reactions each, all 0, and its blocks: a view (K, r, 2 r), [joint, column, row].

    Rows run over the joint itself and the next one. Only rows on and below the diagonal are to be written.
    """
    band = np.zeros((K, r, 2 * r))  # [joint, column, diagonal]
    blocks = np.ndarray((K, r, 2 * r), buffer=band, strides=(16 * r * r, 16 * r - 8, 8))
    return band.reshape(r * K, 2 * r).T, blocks
