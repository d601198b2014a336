"""A chain of thin rods with directions as its state: regular at every position (docs/derivation_chain.md, section 8).

A thin rod on a universal joint without joint effects is a spherical pendulum: its direction d = b3 is its complete state.
The equations are those of the chain in the inertial frame I (z down), with three reactions a joint and no angles.
angles.py computes the angles afterwards, continuously through cos(phi) = 0.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pendpin.equations.chain.kinematics import ChainInertia, Joints, above, below, rods_first, rods_last
from pendpin.equations.chain.system import RodLoads, System, empty_band, project
from pendpin.errors import InputError
from pendpin.ground.arrays import Array


class ThinSolution(NamedTuple):
    """Accelerations and reactions of a thin chain, in I."""

    acceleration: Array  # (..., n, 3) 1/s², d''
    force: Array  # (..., n, 3) N, on each rod at its joint; Mc and M3 are 0


def directions(q: Array, v: Array) -> tuple[Array, Array]:
    """Directions d and rates d' (..., n, 3), in I, from angles and rates q, v (..., n, 2)."""
    joints = Joints.at(q)
    relative, turned = joints.relative_omega(rods_last(v)), joints.R.copy()
    omega, n = relative.copy(), joints.n
    for i in range(1, n):  # a run asks for one state: a banded solve would import SciPy's for it
        rods, above = slice(i, None, n), slice(i - 1, None, n)
        turned[..., rods] = np.add.reduce(turned[:, :, None, above] * joints.R[None, ..., rods], 1)
        omega[:, rods] += np.add.reduce(joints.R[..., rods] * omega[:, None, above], 0)
    rate = turned[:, 0] * omega[1] - turned[:, 1] * omega[0]
    return rods_first(turned[:, 2], q.shape[:-1]), rods_first(rate, q.shape[:-1])


def project_to_sphere(d: Array, rate: Array) -> tuple[Array, Array]:
    """The nearest unit directions, and the part of the rates (..., n, 3) that is normal to them."""
    d = d / np.sqrt((d * d).sum(-1, keepdims=True))
    return d, rate - d * (d * rate).sum(-1, keepdims=True)


def solve(
    chain: ChainInertia, d: Array, rate: Array, field: Array, *, force: Array | None = None, moment: Array | None = None
) -> ThinSolution:
    """d'' and reactions of a chain of thin rods (I3 = 0), or of a batch of its states.

    Parameters: d (..., n, 3) and rate (..., n, 3) in 1/s, in I; their parts off the unit sphere are ignored;
    field (3,) or (..., 3) in I, m/s²; force and moment (..., n, 3) on each rod, external, in I, the moment about
    the centre of mass and normal to the rod (an axial moment would need angles), N and N m.
    Raises InputError if a rod has an axial inertia.
    """
    if chain.first_thin:
        raise InputError(
            f"rod {chain.first_thin} has an axial inertia: directions are not its complete state, use angles"
        )
    shape = d.shape[:-1]
    rods = chain.rods.repeated(d[..., 0].size // chain.n)
    e, e_rate = (rods_last(x) for x in project_to_sphere(d, rate))
    push = 0.0 if force is None else rods_last(force) / rods.m
    turning = np.zeros_like(e) if moment is None else np.cross(rods_last(moment), e, axis=0)
    centripetal = -e * np.add.reduce(e_rate * e_rate, 0)
    support = -np.reshape(field, (-1, 3)).T
    x, turn = project(_ThinBalances(rods, rods.inverse[0], support, push, turning, e, centripetal))
    return ThinSolution(rods_first(turn + centripetal, shape), rods_first(x, shape))


@dataclass(frozen=True)
class _ThinBalances(System):
    """A chain on spherical joints: reactions F1, F2, F3; turning is the part of d'' normal to the rod; all in I."""

    d: Array  # (3, K)
    centripetal: Array  # (3, K) 1/s², the part of d'' along the rod

    def gaps(self, linear: Array | float, turn: Array) -> Array:
        """The gaps (K, 3) in m/s²: acceleration of the tip above less that of the base, in I."""
        rods, swing = self.rods, turn + self.centripetal
        tip = above(linear + rods.k * swing, rods.n)
        tip[:, :: rods.n] = self.support
        return np.ascontiguousarray((tip - linear + rods.h * swing).T)

    def loads(self, x: Array) -> RodLoads:
        """Force and turning part of the moment of reactions x (3, K): -(1 - d d^T)(h F + k F of the joint below)."""
        up = below(x, self.rods.n)
        lever = self.rods.h * x + self.rods.k * up
        across = self._across(self._across(lever))  # twice: what rounding leaves along a light rod counts
        return RodLoads(x - up, -across)

    def resistance(self, turn: Array) -> Array:
        """I d'' (3, K) across the rod; along it, where nothing turns, a term that keeps turn at 0."""
        across = self._across(turn)
        return self.rods.inertia[0] * across + (turn - across) / self.inverse

    def bare(self) -> "_ThinBalances":
        """The same chain at rest, without support and loads."""
        return replace(self, support=0 * self.support, centripetal=0 * self.centripetal)

    def _across(self, x: Array) -> Array:
        """The part of vectors (3, K) normal to the rods."""
        return x - self.d * np.add.reduce(self.d * x, 0)

    def band(self) -> Array:
        """The band (6, 3 K): reactions of each joint on its own gap and on the next joint's."""
        rods, d, d_above = self.rods, self.d, above(self.d, self.rods.n)
        excess, excess_above = rods.base[0] - rods.base[2], rods.tip_above[0] - rods.tip_above[2]
        to_next = rods.cross[0] - rods.cross[2]
        band, blocks = empty_band(rods.m.size, 3)
        for column in range(3):
            block = -(excess * d[column]) * d[column:] - (excess_above * d_above[column]) * d_above[column:]
            block[0] += rods.base[0] + rods.tip_above[0]
            blocks[:, column, column:3] = block.T
            block = (to_next * d[column]) * d
            block[column] -= rods.cross[0]
            blocks[:-1, column, 3:] = block[:, :-1].T
        blocks[rods.n - 1 :: rods.n, :, 3:] = 0
        return band
