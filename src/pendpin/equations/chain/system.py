"""The parts of a chain's equations, for any number of reactions a joint (docs/derivation_chain.md, section 3)."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pendpin.equations.chain.kinematics import Joints, Rods, above, below
from pendpin.ground.arrays import Array, Mask


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


class Axes(NamedTuple):
    """The moment-carrying axis a3 of each joint: (-s, 0, c) in its rod's frame, (0, s_t, c_t) in the frame above.

    All are 0 for a spherical joint: its Mc is 0 and it transmits no twisting moment.
    """

    trig: Array  # (4, K): s_t, s, c_t, c
    spherical: Mask | None  # (K,) None if no joint is spherical


@dataclass(frozen=True)
class Balances(System):
    """A chain on universal joints: reactions F1, F2, F3, Mc; turning is angular acceleration; all in each rod's B."""

    joints: Joints
    axes: Axes
    centripetal: Array  # (3, K) 1/s², omega x (omega x b3)
    drift: Array  # (K,) 1/s², what (alpha - alpha above) . a3 has to be

    def gaps(self, linear: Array | float, turn: Array) -> Array:
        """The gaps (K, 4): acceleration of the tip above less that of the base in B, and the missing twist about a3."""
        rods, joints, (s_t, s, c_t, c) = self.rods, self.joints, self.axes.trig
        swing = self.centripetal.copy()
        swing[0] += turn[1]
        swing[1] -= turn[0]
        tip = above(linear + rods.k * swing, rods.n)
        tip[:, :: rods.n] = self.support
        turned = above(turn, rods.n)
        out = np.empty((turn.shape[1], 4))
        out[:, :3] = (joints.into(tip) - linear + rods.h * swing).T
        out[:, 3] = self.drift + s * turn[0] - c * turn[2] + s_t * turned[1] + c_t * turned[2]
        return out

    def resistance(self, turn: Array) -> Array:
        """I alpha (3, K), N m."""
        return self.rods.inertia * turn

    def bare(self) -> "Balances":
        """The same chain at rest, without support and loads."""
        nothing = np.zeros_like(self.centripetal)
        return replace(self, support=0 * self.support, centripetal=nothing, drift=nothing[0])

    def loads(self, x: Array) -> RodLoads:
        """Force and moment about G of reactions x (4, K), in B."""
        rods, joints, (s_t, s, c_t, c), F, Mc = self.rods, self.joints, self.axes.trig, x[:3], x[3]
        up = np.empty((5, Mc.size))  # of the joint below: force in this rod's frame, the parts of Mc on b2 and b3
        up[:3] = joints.out_of(F)
        np.multiply(s_t, Mc, out=up[3])
        np.multiply(c_t, Mc, out=up[4])
        up = below(up, rods.n)
        moment = np.empty_like(F)
        moment[0] = rods.h * F[1] + rods.k * up[1] - s * Mc
        moment[1] = -rods.h * F[0] - rods.k * up[0] - up[3]
        moment[2] = c * Mc - up[4]
        return RodLoads(F - up[:3], moment)

    def band(self) -> Array:
        """The band (8, 4 K): reactions of each joint on its own gap and on the next joint's."""
        rods, R, (s_t, s, c_t, c) = self.rods, self.joints.R, self.axes.trig
        band, blocks = empty_band(rods.m.size, 4)
        weighted = rods.tip_above[:, None] * R
        for column in range(3):
            force = np.add.reduce(R[:, column:] * weighted[:, None, column], 0)
            force[0] += rods.base[column]
            blocks[:, column, column:3] = force.T
        lever = rods.lever_above * s_t
        blocks[:, 0, 3] = lever * R[0, 0]
        blocks[:, 1, 3] = -rods.lever_h[1] * s
        blocks[:, 2, 3] = lever * R[0, 2]
        twist = np.add.reduce(self.axes.trig**2 * rods.twist, 0)
        blocks[:, 3, 3] = twist if self.axes.spherical is None else twist + self.axes.spherical
        below_diagonal = blocks[:-1]  # on the next joint's gap
        np.multiply(-rods.cross[:, None, :-1], R[:, :, 1:], out=below_diagonal[:, :3, 4:7].transpose(1, 2, 0))
        np.multiply((-rods.lever_k * s)[:-1], R[1, :, 1:], out=below_diagonal[:, 3, 4:7].T)
        np.multiply(rods.lever_h[0, :-1], s_t[1:], out=below_diagonal[:, 0, 7])
        np.multiply((-c * rods.inverse[2])[:-1], c_t[1:], out=below_diagonal[:, 3, 7])
        blocks[rods.n - 1 :: rods.n, :, 4:] = 0
        return band
