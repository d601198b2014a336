"""The parts of a chain's equations, for any number of reactions a joint, and how they are solved.

docs/derivation_chain.md, sections 3, 6 and 7. Angular accelerations are eliminated: the system for the reactions is
symmetric, positive definite and block-tridiagonal, and is factored once. The original balances, before the elimination,
give the residuals, and the same factor corrects the solution: the result does not depend on the condition of the
elimination, and is exact for rods without axial inertia, for which the factored system has a substitute. Where this does
not converge (nearly singular states of thin rods), the balances are factored without elimination.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pendpin.equations.chain.kinematics import Joints, Rods, above, below, into
from pendpin.ground.arrays import Array, Mask, lapack

PASSES = 15  # two are the rule, three to six with thin rods above thick ones; more mean a nearly singular state
ROUNDING = 1e-15, 1e-10  # relative size of a correction: certainly rounding only; rounding if it shrinks no more
NEGLIGIBLE = 1e-20  # relative size of a correction that is not worth a pass
LEAST_SIZE = 1e-300  # keeps a chain at rest without loads from dividing by 0


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
    """A lower band of K joints with r reactions each, all 0, and its blocks: a view (K, r, 2 r), [joint, column, row]."""
    # Rows run over the joint itself and the next one. Only rows on and below the diagonal are to be written.
    band = np.zeros((K, r, 2 * r))  # [joint, column, diagonal]
    blocks = np.ndarray((K, r, 2 * r), buffer=band, strides=(16 * r * r, 16 * r - 8, 8))
    return band.reshape(r * K, 2 * r).T, blocks


@dataclass(frozen=True)
class Balances(System):
    """A chain on universal joints: reactions F1, F2, F3, Mc; turning is angular acceleration; all in each rod's B."""

    joints: Joints
    # Of the axis a3 that carries a moment: (-s, 0, c) in its rod's frame, (0, s_t, c_t) in the frame above. All are 0 for a
    # spherical joint: its Mc is 0 and it transmits no twisting moment.
    trig: Array  # (4, K): s_t, s, c_t, c
    spherical: Mask | None  # (K,) None if no joint is spherical
    centripetal: Array  # (3, K) 1/s², omega x (omega x b3)
    drift: Array  # (K,) 1/s², what (alpha - alpha above) . a3 has to be

    def gaps(self, linear: Array | float, turn: Array) -> Array:
        """The gaps (K, 4): acceleration of the tip above less that of the base in B, and the missing twist about a3."""
        rods, joints, (s_t, s, c_t, c) = self.rods, self.joints, self.trig
        swing = self.centripetal.copy()
        swing[0] += turn[1]
        swing[1] -= turn[0]
        tip = above(linear + rods.k * swing, rods.n)
        tip[:, :: rods.n] = self.support
        turned = above(turn, rods.n)
        twist = self.drift + s * turn[0] - c * turn[2] + s_t * turned[1] + c_t * turned[2]
        return np.column_stack([(into(joints.R, tip) - linear + rods.h * swing).T, twist])

    def resistance(self, turn: Array) -> Array:
        return self.rods.inertia * turn

    def bare(self) -> "Balances":
        nothing = np.zeros_like(self.centripetal)
        return replace(self, support=0 * self.support, centripetal=nothing, drift=nothing[0])

    def loads(self, x: Array) -> RodLoads:
        """Force and moment about G of reactions x (4, K), in B."""
        rods, joints, (s_t, s, c_t, c), F, Mc = self.rods, self.joints, self.trig, x[:3], x[3]
        # of the joint below: force in this rod's frame, the parts of Mc on b2 and b3
        up = below(np.concatenate([np.add.reduce(joints.R * F, 1), [s_t * Mc, c_t * Mc]]), rods.n)
        across = rods.h * F[1] + rods.k * up[1] - s * Mc, -rods.h * F[0] - rods.k * up[0] - up[3]
        return RodLoads(F - up[:3], np.array([*across, c * Mc - up[4]]))

    def band(self) -> Array:
        """The band (8, 4 K): reactions of each joint on its own gap and on the next joint's."""
        rods, R, (s_t, s, c_t, c) = self.rods, self.joints.R, self.trig
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
        twist = np.add.reduce(self.trig**2 * rods.twist, 0)
        blocks[:, 3, 3] = twist if self.spherical is None else twist + self.spherical
        below_diagonal = blocks[:-1]  # on the next joint's gap
        np.multiply(-rods.cross[:, None, :-1], R[:, :, 1:], out=below_diagonal[:, :3, 4:7].transpose(1, 2, 0))
        np.multiply((-rods.lever_k * s)[:-1], R[1, :, 1:], out=below_diagonal[:, 3, 4:7].T)
        np.multiply(rods.lever_h[0, :-1], s_t[1:], out=below_diagonal[:, 0, 7])
        np.multiply((-c * rods.inverse[2])[:-1], c_t[1:], out=below_diagonal[:, 3, 7])
        blocks[rods.n - 1 :: rods.n, :, 4:] = 0
        return band


class Step(NamedTuple):
    """One correction of the unknowns, and what its reactions do to the rods."""

    x: Array  # (r, K)
    turn: Array  # (3, K)
    loads: RodLoads


class Eliminated:
    """The reactions alone, by Cholesky: what scipy.linalg.solveh_banded does, with the factor kept."""

    def __init__(self, system: System) -> None:
        self.system = system
        band = system.band()
        self.factor, info = lapack("pbtrf")(band, lower=1, overwrite_ab=1)
        if info:
            rod = (info - 1) // (len(band) // 2) % system.rods.n + 1
            raise np.linalg.LinAlgError(f"the chain's equations are singular to rounding at joint {rod}")

    def step(self, linear: Array | float, turn: Array, lack: Array) -> Step:
        """Turn the rods as if free by lack (3, K), close the gaps, add the turning that these reactions cause."""
        system, free = self.system, self.system.inverse * lack
        gaps = system.gaps(linear, turn + free)
        x, _ = lapack("pbtrs")(self.factor, gaps.reshape(-1, 1), lower=1, overwrite_b=1)
        x = np.ascontiguousarray(x.reshape(gaps.shape).T)
        loads = system.loads(x)
        return Step(x, free + system.inverse * loads.turning, loads)


class Direct:
    """Reactions and turning together, by LU with pivoting: slower by ten, and nothing is divided by an inertia."""

    # The columns of the matrix are residuals of the balances for unit unknowns. The unknowns of a rod enter only its own
    # equations and its neighbours', so every third rod is evaluated at once.

    def __init__(self, system: System) -> None:
        self.system = system
        columns = self._columns(system.bare())
        K, size, _ = columns.shape
        self.width = 2 * size - 1
        rows = np.zeros((K + 2, size))  # the largest entry of each equation, with a rod beyond either end
        for place, largest in enumerate(np.split(np.abs(columns).max(1), 3, 1)):
            np.maximum(rows[place : K + place], largest, out=rows[place : K + place])
        empty = rows[1:-1] == 0  # of spherical joints, whose Mc and spin enter nothing
        columns[:, np.arange(size), size + np.arange(size)] += empty
        self.rows = _scale(rows[1:-1] + empty)  # (K, size)
        columns *= np.pad(self.rows, ((1, 1), (0, 0)))[np.arange(K)[:, None] + np.arange(3)].reshape(K, 1, -1)
        self.cols = _scale(np.abs(columns).max(2))  # (K, size)
        columns *= self.cols[:, :, None]
        band = np.zeros((K, size, 3 * self.width + 1))
        for column in range(size):
            start = 2 * self.width - column - size
            band[:, column, start : start + 3 * size] = columns[:, column]
        self.lu, self.pivots, info = lapack("gbtrf")(
            band.reshape(K * size, -1).T, self.width, self.width, overwrite_ab=1
        )
        if info:
            rod = (info - 1) // size % system.rods.n + 1
            raise np.linalg.LinAlgError(f"the chain's equations are singular at rod {rod}")

    def step(self, linear: Array | float, turn: Array, lack: Array) -> Step:
        """Solve for reactions and turning that remove the gaps and the lack (3, K) together."""
        gaps = self.system.gaps(linear, turn)
        rhs = -np.concatenate([gaps, lack.T], 1) * self.rows
        z, _ = lapack("gbtrs")(self.lu, self.width, self.width, rhs.reshape(-1, 1), self.pivots)
        z = np.ascontiguousarray((z.reshape(rhs.shape) * self.cols).T)
        x, turn = z[: gaps.shape[1]], z[gaps.shape[1] :]
        return Step(x, turn, self.system.loads(x))

    def _columns(self, bare: System) -> Array:
        """[rod, unknown, equation of the rod above, own, of the rod below], (K, size, 3 size)."""
        K = bare.rods.m.size
        r = bare.gaps(0.0, np.zeros((3, K))).shape[1]
        size = r + 3
        columns = np.empty((K, size, 3 * size))
        for unknown in range(size):
            for third in range(3):
                z = np.zeros((size, K))
                z[unknown, third::3] = 1
                loads = bare.loads(z[:r])
                gaps = bare.gaps(loads.force / bare.rods.m, z[r:])
                answer = np.concatenate([gaps, (loads.turning - bare.resistance(z[r:])).T], 1)
                around = np.pad(answer, ((1, 1), (0, 0)))
                rods = np.arange(third, K, 3)
                columns[rods, unknown] = around[rods[:, None] + np.arange(3)].reshape(len(rods), 3 * size)
        return columns


def _scale(largest: Array) -> Array:
    """Powers of two, in the shape (n, k) of `largest`, that bring its entries near 1."""
    return np.exp2(-np.round(np.log2(largest)))


def project(system: System) -> tuple[Array, Array]:
    """Reactions (r, K) and turning accelerations (3, K). Raises LinAlgError where the reactions have no finite values."""
    try:
        return _refined(system, Eliminated(system))
    except np.linalg.LinAlgError:
        return _refined(system, Direct(system))


def _refined(system: System, correction: Eliminated | Direct) -> tuple[Array, Array]:
    """Reactions (r, K) and turning (3, K), corrected with the original balances to rounding."""
    x, force, turning, turn, ratio = 0.0, 0.0, system.turning, np.zeros_like(system.turning), 1.0
    for attempt in range(PASSES):
        linear, lack = force / system.rods.m + system.push, turning - system.resistance(turn)
        step = correction.step(linear, turn, lack)
        x, turn = x + step.x, turn + step.turn
        force, turning = force + step.loads.force, turning + step.loads.turning
        if attempt:
            last, ratio = ratio, _relative(system, linear, step, x, turn)
            expected = ratio * ratio / last  # the next one, if they go on shrinking as they did
            shrinking = ratio > ROUNDING[1] or ratio < last / 4
            if not (ratio > ROUNDING[0] and expected > NEGLIGIBLE and shrinking):  # or NaN
                return x, turn
    rod = int(np.abs(turn).max(0).argmax()) % system.rods.n + 1
    reason = "a thin rod cannot take a moment at cos(phi) = 0, nor may masses differ too much"
    raise np.linalg.LinAlgError(f"no finite reactions at rod {rod}: {reason}")


def _relative(system: System, linear: Array, step: Step, x: Array, turn: Array) -> float:
    """The size of a step relative to x (r, K), turn (3, K) or to the terms that cancel in them; the worst state."""
    # Near equilibrium the rods hardly turn, but their accelerations relative to free fall, linear, do not vanish. Rounding
    # errors are compared with the forces and moments of these accelerations, and with known moments that others balance,
    # such as those of a joint held by friction.
    rods, at_work = system.rods, np.abs(linear).max(0)
    forces = _share(rods.n, step.x[:3], x[:3], rods.m * at_work)
    with np.errstate(over="ignore"):  # levers next to nothing
        turning = at_work / (np.abs(rods.h) + np.abs(rods.k))
        scale = np.abs(system.turning).max(0) / (rods.m * (rods.h**2 + rods.k**2) + rods.inertia[0])
    return max(forces, _share(rods.n, step.turn, turn, np.maximum(turning, scale)))


def _share(n: int, change: Array, x: Array, floor: Array) -> float:
    """Largest entry of change (i, K) over that of x (i, K) and floor (K,), in the worst of the states."""
    top, bottom = np.abs(change).max(0), np.maximum(np.abs(x).max(0), floor)
    return float((top.reshape(-1, n).max(1) / (bottom.reshape(-1, n).max(1) + LEAST_SIZE)).max())
