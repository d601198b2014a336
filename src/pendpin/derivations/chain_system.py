"""The balances of a chain and the one system behind them (docs/derivation_chain.md, sections 3 to 6).

Unknown are the joints' reactions, four to a joint: F1, F2, F3 and Mc. That the joints hold gives one symmetric positive
definite block-tridiagonal system for them (bandwidth 7). It is factored once; then the balances as they stand, before
anything was eliminated, say what is still missing, and the same factor removes it. That second pass makes the
result independent of how badly the elimination was conditioned, and it makes rods without axial inertia exact, for
which the factored matrix holds a stand-in.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

from pendpin.derivations.base import Array
from pendpin.derivations.chain_inertia import Rods, above, below
from pendpin.derivations.chain_kinematics import Joints

_pbtrf, _pbtrs = get_lapack_funcs(("pbtrf", "pbtrs"), dtype=np.float64)

PASSES = 15  # two are the rule, three to six with thin rods above thick ones; more mean a nearly singular state
ROUNDING = 1e-15, 1e-10  # relative size of a correction: certainly rounding only; rounding if it shrinks no more
NEGLIGIBLE = 1e-20  # relative size of a correction that is not worth a pass
TINY = 1e-300  # keeps a chain at rest without loads from dividing by 0


Mask = NDArray[np.bool_]


class Loads(NamedTuple):
    """What reactions do to the rods: (3, K) each."""

    force: Array  # N
    turning: Array  # N m about G


@dataclass(frozen=True)
class System(ABC):
    """Balances of force and turning of every rod, and joints that hold; accelerations are relative to the field.

    A reaction x has r rows for each joint. Children say which: how reactions load the rods (`loads`), how far the
    joints are from holding at given accelerations (`gaps`), and what the one does to the other (`band`).
    """

    rods: Rods
    inertia: Array  # (3, K) or (K,) kg m², what turning has to overcome
    inverse: Array  # the same inverted, stand-ins where it is 0
    support: Array  # (3, 1) or (3, states) m/s², acceleration of the support in I, less the field
    push: Array | float  # (3, K) m/s², external force over mass
    turning: Array  # (3, K) N m, known, about G

    @abstractmethod
    def gaps(self, linear: Array, turn: Array) -> Array:
        """(K, r): what is missing at each joint, from accelerations linear of G (3, K), m/s², and turn (3, K), 1/s²."""

    @abstractmethod
    def loads(self, x: Array) -> Loads:
        """Force and turning on every rod by the reactions x (r, K) of its own joint and of the next."""

    @abstractmethod
    def band(self) -> Array:
        """The matrix that takes reactions to gaps, in LAPACK's lower band: (2 r, r K), Fortran order."""

    def solve(self) -> tuple[Array, Array]:
        """Reactions (r, K) and turning accelerations (3, K).

        Raises numpy.linalg.LinAlgError where the passes do not settle.
        """
        factor = self._factor()
        x, force, turning, turn = 0.0, 0.0, self.turning, np.zeros_like(self.turning)
        ratio = 1.0
        for attempt in range(PASSES):
            free = turn + self.inverse * (turning - self.inertia * turn)
            change = _apply(factor, self.gaps(force / self.rods.m + self.push, free))
            loads = self.loads(change)
            before, turn = turn, free + self.inverse * loads.turning
            x, force, turning = x + change, force + loads.force, turning + loads.turning
            if attempt:
                last, ratio = ratio, max(self._relative(change[:3], x[:3]), self._relative(turn - before, turn))
                if _settled(last, ratio):
                    return x, turn
        raise np.linalg.LinAlgError("the chain's reactions are not finite: a thin rod takes a moment at cos(phi) = 0")

    def _factor(self) -> Array:
        band = self.band()
        factor, info = _pbtrf(band, lower=1, overwrite_ab=1)
        if info:
            rod = (info - 1) // (len(band) // 2) % self.rods.n + 1
            raise np.linalg.LinAlgError(f"the chain's equations are singular to rounding at joint {rod}")
        return factor

    def _relative(self, change: Array, x: Array) -> float:
        """Size of a change beside the size of x (i, K), the worst of the states."""
        if self.rods.m.size == self.rods.n:  # one state: the quick way
            return float(np.abs(change).max() / (np.abs(x).max() + TINY))
        sizes = [np.abs(y).max(0).reshape(-1, self.rods.n).max(1) + TINY for y in (change, x)]
        return float((sizes[0] / sizes[1]).max())


def _settled(last: float, ratio: float) -> bool:
    """Whether no pass is needed after corrections of these relative sizes; with NaN none helps."""
    expected = ratio * ratio / last  # the next one, if they go on shrinking as they did
    shrinking = ratio > ROUNDING[1] or ratio < last / 4
    return not (ratio > ROUNDING[0] and expected > NEGLIGIBLE and shrinking)


def settle(system: Callable[[Rods], System], candidates: list[Rods]) -> tuple[Array, Array]:
    """The solution with the first of the candidates' stand-ins that settles.

    Raises numpy.linalg.LinAlgError where the reactions have no finite values.
    """
    for rods in candidates[:-1]:
        try:
            return system(rods).solve()
        except np.linalg.LinAlgError:
            continue
    return system(candidates[-1]).solve()


def _apply(factor: Array, gaps: Array) -> Array:
    """The reactions (r, K) that close gaps (K, r)."""
    x, _ = _pbtrs(factor, gaps.reshape(-1, 1), lower=1, overwrite_b=1)
    return np.ascontiguousarray(x.reshape(gaps.shape).T)


def empty_band(K: int, r: int) -> tuple[Array, Array]:
    """A lower band of K joints with r reactions each, all 0, and its blocks: a view (K, r, 2 r), [joint, column, row].

    Rows run over the joint itself and the next one. Only rows on and below the diagonal are to be written.
    """
    band = np.zeros((K, r, 2 * r))  # [joint, column, diagonal]
    blocks = as_strided(band, (K, r, 2 * r), (16 * r * r, 16 * r - 8, 8))
    return band.reshape(r * K, 2 * r).T, blocks


class Axes(NamedTuple):
    """The moment-carrying axis a3 of each joint: (-s, 0, c) in its rod's frame, (0, s_t, c_t) in the frame above.

    All are 0 where the joint is a ball: there Mc is 0 and no twist is handed on.
    """

    trig: Array  # (4, K): s_t, s, c_t, c
    ball: Mask | None  # (K,) None if no joint is a ball


@dataclass(frozen=True)
class Balances(System):
    """A chain on universal joints: reactions F1, F2, F3, Mc; turning is angular acceleration; all in each rod's B."""

    joints: Joints
    axes: Axes
    centripetal: Array  # (3, K) 1/s², omega x (omega x b3)
    drift: Array  # (K,) 1/s², what (alpha - alpha above) . a3 has to be

    def gaps(self, linear: Array, turn: Array) -> Array:
        """Acceleration of the tip above less that of the base, in B, and the twist about a3 that is missing."""
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

    def loads(self, x: Array) -> Loads:
        """Force and moment about G, in B."""
        rods, joints, (s_t, s, c_t, c), F, Mc = self.rods, self.joints, self.axes.trig, x[:3], x[3]
        next_F = below(joints.out_of(F), rods.n)
        moment = np.empty_like(F)
        moment[0] = rods.h * F[1] + rods.k * next_F[1] - s * Mc
        moment[1] = -rods.h * F[0] - rods.k * next_F[0] - below(s_t * Mc, rods.n)
        moment[2] = c * Mc - below(c_t * Mc, rods.n)
        return Loads(F - next_F, moment)

    def band(self) -> Array:
        """Own reactions on own gaps, and on the next joint's."""
        n = self.rods.n
        band, blocks = empty_band(self.rods.m.size, 4)
        self._own(blocks)
        self._next(blocks[:-1])
        blocks[n - 1 :: n, :, 4:] = 0
        return band

    def _own(self, blocks: Array) -> None:
        """Fill the 4 x 4 blocks on the diagonal, below and on their diagonals: one joint's reactions on its own gap."""
        rods, R, (s_t, s, _, _) = self.rods, self.joints.R, self.axes.trig
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
        blocks[:, 3, 3] = twist if self.axes.ball is None else twist + self.axes.ball

    def _next(self, blocks: Array) -> None:
        """Fill the 4 x 4 blocks below the diagonal: a joint's reactions on the gap of the next joint."""
        rods, R, (s_t, s, c_t, c) = self.rods, self.joints.R, self.axes.trig
        np.multiply(-rods.cross[:, None, :-1], R[:, :, 1:], out=blocks[:, :3, 4:7].transpose(1, 2, 0))
        np.multiply((-rods.lever_k * s)[:-1], R[1, :, 1:], out=blocks[:, 3, 4:7].T)
        np.multiply(rods.lever_h[0, :-1], s_t[1:], out=blocks[:, 0, 7])
        np.multiply((-c * rods.inverse[2])[:-1], c_t[1:], out=blocks[:, 3, 7])
