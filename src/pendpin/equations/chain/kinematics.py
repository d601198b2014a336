"""A chain's frames, positions, velocities and energies from its angles (docs/derivation_chain.md, sections 1 and 2).

Nothing here loops over rods: what propagates down the chain (frames, angular velocities) is a bidiagonal system of 3 x 3
blocks, solved forwards by LAPACK; what adds up along it (positions) is a cumulative sum. A batch of states is one long
row of rods. Within this family of modules components come first and rods last, (3, K), K = states times rods; what
users see has rods first, (..., n, 3).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pendpin.errors import InputError
from pendpin.ground.arrays import Array, lapack

# The eliminated system replaces a principal inertia of zero by this fraction of a small inertia of the chain. Refinement
# with the original balances removes its effect (system.py); the value only determines the number of passes.
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
        # substitutes (3, n) in kg m² for zero inertias in the factored matrix: small compared with the rods' own
        transverse = STAND_IN * m * h**2
        axial, thick = np.empty(n), np.inf
        for i in reversed(range(n)):
            thick = self.I3[i] if self.I3[i] > 0 else thick
            axial[i] = STAND_IN * min(self.I1[i] or transverse[i], thick)
        inverse = 1 / np.where(inertia > 0, inertia, np.array([transverse, transverse, axial]))
        across = inverse[[1, 0]]  # a force along b1 turns the rod about b2, and the other way round
        base, cross, tip = np.tile(1 / m, (3, 3, 1))
        base[:2] += h * h * across
        cross[:2] -= h * k * across
        tip[:2] += k * k * across
        _, above2, above3 = above(inverse, n)
        twist = np.array([above2, inverse[0], above3, inverse[2]])
        levers = h * across[:2], k * inverse[0], above(k, n) * above2
        return Rods(n, m, h, k, inertia, inverse, base, cross, above(tip, n), *levers, twist)


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


class Positions(NamedTuple):
    """Where the rods are, in the inertial frame I (z down)."""

    frames: Array  # (..., n, 3, 3), columns b1, b2, b3
    centres: Array  # (..., n, 3) m, centres of mass
    tips: Array  # (..., n, 3) m


class ChainMotion(NamedTuple):
    """Where the rods of a chain are and how they move, in I except for omega."""

    frames: Array  # (..., n, 3, 3), columns b1, b2, b3
    centres: Array  # (..., n, 3) m, centres of mass
    tips: Array  # (..., n, 3) m
    omega: Array  # (..., n, 3) rad/s, in each rod's own frame B
    centre_velocities: Array  # (..., n, 3) m/s
    tip_velocities: Array  # (..., n, 3) m/s


class Joints(NamedTuple):
    """All joints at one state: sines and cosines of their angles, and each rod's frame in that of the rod above it."""

    n: int  # rods in a chain
    trig: Array  # (4, K): sin(theta), sin(phi), cos(theta), cos(phi)
    R: Array  # (3, 3, K), columns b1, b2, b3 with components in the frame above; in I for the first rod

    @classmethod
    def at(cls, q: Array) -> "Joints":
        """From angles q (..., n, 2) in rad: R = Rx(-theta) Ry(phi)."""
        angles = rods_last(q)
        s_t, s, c_t, c = trig = np.concatenate([np.sin(angles), np.cos(angles)])
        R = np.array([[c, np.zeros_like(c), s], [-s_t * s, c_t, s_t * c], [-c_t * s, -s_t, c_t * c]])
        return cls(q.shape[-2], trig, R)

    def propagated(self, own: Array) -> Array:
        """Solve x_i = R_i^T x_(i-1) + own_i from the support down, for r vectors at once: (r, 3, K)."""
        if self.n == 1:
            return own
        r, _, K = own.shape
        band = np.zeros((K, 3, 6))  # [i, column, diagonal]: LAPACK's lower band, a column after the other
        blocks = np.ndarray((K, 3, 6), buffer=band, strides=(18 * 8, 5 * 8, 8))  # the same as [i, column, row]
        blocks[:-1, :, 3:] = -self.R[:, :, 1:].transpose(2, 0, 1)
        blocks[self.n - 1 :: self.n, :, 3:] = 0
        rhs = own.transpose(0, 2, 1).reshape(r, 3 * K)
        x, _ = lapack("tbtrs")(band.reshape(3 * K, 6).T, rhs.T, uplo="L", diag="U")
        return np.ascontiguousarray(x.T.reshape(r, K, 3).transpose(0, 2, 1))

    def frames(self) -> Array:
        """Every rod's axes in I: (3, 3, K), columns b1, b2, b3."""
        if self.n == 1:
            return self.R
        turns = np.zeros_like(self.R)
        turns[..., :: self.n] = self.R[..., :: self.n]
        return self.propagated(turns)

    def relative_omega(self, rate: Array) -> Array:
        """Angular velocity of each rod relative to the rod above it, in its own frame, (3, K); rate (2, K) in rad/s."""
        _, s, _, c = self.trig
        return np.array([-rate[0] * c, rate[1], -rate[0] * s])

    def omega(self, rate: Array) -> Array:
        """Angular velocity of each rod, in its own frame, (3, K) rad/s; rate (2, K) in rad/s."""
        return self.propagated(self.relative_omega(rate)[None])[0]


def into(frames: Array, x: Array) -> Array:
    """Components of vectors (3, K) in frames (3, 3, K) whose columns are the axes."""
    return np.add.reduce(frames * x[:, None], 0)


def rods_last(x: Array) -> Array:
    """(..., n, i) -> (i, K), contiguous."""
    return np.ascontiguousarray(x.reshape(-1, x.shape[-1]).T)


def rods_first(x: Array, shape: tuple[int, ...]) -> Array:
    """(i, K) -> shape + (i,), a view; shape is (..., n)."""
    return x.T.reshape(*shape, len(x))


def place_along(chain: ChainInertia, x: Array) -> tuple[Array, Array]:
    """Centres of mass and tips (..., n, 3) from directions x (..., n, 3); from rates of directions, velocities."""
    steps = chain.l[:, None] * x
    tips = np.cumsum(steps, -2) if chain.n > 1 else steps
    return tips - (chain.l - chain.h)[:, None] * x, tips


def positions(chain: ChainInertia, q: Array) -> Positions:
    """Frames, centres of mass and tips for angles q (..., n, 2) in rad."""
    return _place_rods(chain, Joints.at(q).frames(), q.shape[:-1])


def motion(chain: ChainInertia, q: Array, v: Array) -> ChainMotion:
    """Positions and velocities for angles q and rates v (..., n, 2) in rad and rad/s."""
    joints, shape = Joints.at(q), q.shape[:-1]
    frames, omega = joints.frames(), joints.omega(rods_last(v))
    direction_rates = rods_first(frames[:, 0] * omega[1] - frames[:, 1] * omega[0], shape)
    velocities = place_along(chain, direction_rates)
    return ChainMotion(*_place_rods(chain, frames, shape), rods_first(omega, shape), *velocities)


def kinetic_energy(chain: ChainInertia, moving: ChainMotion) -> Array:
    """Kinetic energy (...) in J of a motion."""
    inertia = np.stack([chain.I1, chain.I2, chain.I3], -1)
    velocity, omega = moving.centre_velocities, moving.omega
    translation = chain.m * np.einsum("...ni,...ni->...n", velocity, velocity)
    return 0.5 * (translation + np.einsum("ni,...ni,...ni->...n", inertia, omega, omega)).sum(-1)


def _place_rods(chain: ChainInertia, frames: Array, shape: tuple[int, ...]) -> Positions:
    """The positions of rods with frames (3, 3, K); shape is (..., n)."""
    frames = frames.transpose(2, 0, 1).reshape(*shape, 3, 3)
    return Positions(frames, *place_along(chain, frames[..., 2]))
