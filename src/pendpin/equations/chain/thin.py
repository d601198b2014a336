"""A chain of thin rods with directions as its state: regular at every position (docs/derivation_chain.md, section 8).

A thin rod on a universal joint without joint effects is a spherical pendulum: its direction d = b3 is its complete state.
The equations are those of the chain in the inertial frame I (z down), with three reactions a joint and no angles.
The angles, rates and accelerations are computed from directions afterwards, continuously through cos(phi) = 0 (section 9).
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pendpin.equations.chain.kinematics import ChainInertia, Joints, above, below, into, rods_first, rods_last
from pendpin.equations.chain.system import RodLoads, System, empty_band, project
from pendpin.errors import InputError
from pendpin.ground.arrays import Array, Mask, cross


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
        turned[..., rods] = _product(turned[..., above], joints.R[..., rods])
        omega[:, rods] += into(joints.R[..., rods], omega[:, above])
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
    turning = np.zeros_like(e) if moment is None else cross(rods_last(moment), e, axis=0)
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


# --- angles from directions --------------------------------------------------------------------------------------------

POLE = 1e-8  # |cos(phi)| below which theta, theta' follow from d', d''; above it from d, d'; the errors are equal there
RESTING = 1e-12  # of the rates of the rod and of the one above: a rod that passes a pole no faster rests there
PASS = 1e-6  # rad: a rod that comes so close to a pole passes through it
PARTS, REFINEMENTS = 8, 8  # of an interval that is too long, how often


class Reading(NamedTuple):
    """The angles of a run in directions."""

    q: Array  # (k, n, 2) rad, theta, phi, continuous from sample to sample
    v: Array  # (k, n, 2) rad/s
    across: Array  # (k, n), |cos(phi)|
    a: Array | None  # (k, n, 2) rad/s², if d'' is given; where |cos(phi)| < POLE theta'' has no value, and is 0


class _Turning(NamedTuple):
    """A rod's frame, angular velocity and acceleration, the latter two in that frame; samples last, for speed."""

    frame: Array  # (3, 3, k), columns b1, b2, b3 in I
    omega: Array  # (3, k)
    alpha: Array  # (3, k); 0 unless d'' is given


def read(d: Array, rate: Array, acceleration: Array | None = None, previous: Array | None = None) -> Reading:
    """Angles of samples d, d', d'' (k, n, 3), in I, rising in time; previous (n, 2) are the angles just before.

    Each rod's angles are relative to the frame of the rod above, which they build in turn. Of the two pairs that mean
    the same direction, (theta, phi) and (theta + pi, pi - phi), the one nearest to the sample before is taken; the very
    first sample, without previous, has |phi| <= pi/2. Without d'' rates at a pole are 0.
    """
    k, n, _ = d.shape
    q, v, a, across = *np.empty((3, k, n, 2)), np.empty((k, n))
    above = _Turning(np.eye(3)[..., None], np.zeros((3, 1)), np.zeros((3, 1)))
    for i in range(n):
        own, own_rate = (np.ascontiguousarray(x[:, i].T) for x in (d, rate))
        u, u_rate = own, own_rate  # seen from the rod above, in its frame
        if i:
            u = into(above.frame, own)
            u_rate = into(above.frame, own_rate) - cross(above.omega, u, axis=0)
        q[:, i] = _angles(above, u, u_rate, own_rate, None if previous is None else previous[i]).T
        joint = Joints.at(q[:, i : i + 1])
        s_t, s, c_t, c = joint.trig  # at a pole (c = 0) u' does not show theta', which is taken as 0
        along_theta = (c_t * u_rate[1] - s_t * u_rate[2]) / np.where(np.abs(c) < POLE, np.inf, c)
        rates = np.array([along_theta, c * u_rate[0] - s * (s_t * u_rate[1] + c_t * u_rate[2])])
        if acceleration is not None:
            above, rates, a[:, i].T[:] = _accelerated(above, joint, rates, np.ascontiguousarray(acceleration[:, i].T))
        elif i + 1 < n:
            omega = into(joint.R, above.omega) + joint.relative_omega(rates)
            above = _Turning(_product(above.frame, joint.R), omega, above.alpha)
        v[:, i], across[:, i] = rates.T, np.abs(c)
    return Reading(q, v, across, None if acceleration is None else a)


def unresolved(t: Array, reading: Reading) -> Mask:
    """The intervals (k - 1,) between samples at t (k,) in which a rod turns by over half its distance to a pole."""
    # In such an interval theta may change by any amount; more samples are needed.
    across = reading.across
    speed = np.sqrt(reading.v[..., 1] ** 2 + (reading.v[..., 0] * across) ** 2)
    turn = np.maximum(speed[1:], speed[:-1]) * np.diff(t)[:, None]
    return np.asarray(((turn > np.minimum(across[1:], across[:-1]) / 2) & (turn > PASS)).any(1))


def refined(t: Array, d: Array, rate: Array, kept: Array, chosen: Mask) -> tuple[Array, Array, Array, Array]:
    """Samples at t (k,), with PARTS - 1 more in each chosen interval (k - 1,), and where those of `kept` are among them."""
    # d, d' (k, n, 3) are interpolated by a cubic on the sphere.
    i, s = np.flatnonzero(chosen), (np.arange(1, PARTS) / PARTS)[:, None, None, None]
    h = (t[i + 1] - t[i])[:, None, None]
    d0, d1, r0, r1 = d[i], d[i + 1], h * rate[i], h * rate[i + 1]
    a, b = 3 * (d1 - d0) - 2 * r0 - r1, 2 * (d0 - d1) + r0 + r1
    more = d0 + s * (r0 + s * (a + s * b))  # (parts - 1, chosen, n, 3)
    slope = (r0 + s * (2 * a + 3 * s * b)) / h
    size = np.linalg.norm(more, axis=-1, keepdims=True)
    more, slope = more / size, slope / size
    slope = slope - more * (more * slope).sum(-1, keepdims=True)
    times = t[i] + s[..., 0, 0] * h[:, 0, 0]
    t, d, rate = (np.concatenate([x, y.reshape(-1, *x.shape[1:])]) for x, y in ((t, times), (d, more), (rate, slope)))
    order = np.argsort(t, kind="stable")
    return t[order], d[order], rate[order], np.argsort(order, kind="stable")[kept]


def _product(A: Array, B: Array) -> Array:
    """A B, of matrices (3, 3, k)."""
    return np.add.reduce(A[:, :, None] * B, 1)


def _angles(above: _Turning, u: Array, u_rate: Array, rate: Array, start: Array | None) -> Array:
    """theta, phi (2, k) of one rod over all samples, from u, u' seen from the rod above, and d', (3, k) each."""
    across = np.sqrt(u[1] ** 2 + u[2] ** 2)  # |cos(phi)|; three times as fast as hypot
    theta = np.arctan2(u[1], u[2])
    if (pole := across < POLE).any():
        speed = np.hypot(u_rate[1], u_rate[2])
        moving = speed > RESTING * (np.linalg.norm(rate, axis=0) + np.linalg.norm(above.omega, axis=0))
        theta = np.where(pole & moving, np.arctan2(u_rate[1], u_rate[2]), theta)
        for sample in np.flatnonzero(pole & ~moving):  # of a rod that rests at a pole, from the sample before
            if sample:
                theta[sample] = theta[sample - 1]
            elif start is not None:
                theta[sample] = start[0]
    # The pairs that follow on each other, from pairs with |phi| <= pi/2: the other pair is nearer to the sample before where
    # theta changes by over pi less the larger |phi|.
    pairs = np.array([theta, np.arctan2(u[0], across)])
    begin = pairs[:, 0] if start is None else start
    turned = np.cos(begin[1]) < 0
    theta, phi = np.concatenate([_other(begin) if turned else begin, pairs.T.ravel()]).reshape(-1, 2).T
    size = np.abs(_wrapped(phi))
    nearer = np.abs(_wrapped(np.diff(theta))) + np.maximum(size[1:], size[:-1]) > np.pi
    other = (np.cumsum(nearer) + turned) % 2 == 1
    out = np.column_stack([begin, np.where(other, _other(pairs), pairs)])
    return (out - 2 * np.pi * np.cumsum(np.round(np.diff(out, prepend=out[:, :1]) / (2 * np.pi)), 1))[:, 1:]


def _other(pair: Array) -> Array:
    """The other angles (2, ...) of the same directions."""
    return np.array([pair[0] + np.pi, np.pi - pair[1]])


def _wrapped(angle: Array) -> Array:
    """The same angles (n,) in [-pi, pi] rad."""
    return angle - 2 * np.pi * np.round(angle / (2 * np.pi))


def _accelerated(above: _Turning, joint: Joints, rates: Array, acceleration: Array) -> tuple[_Turning, Array, Array]:
    """How a rod turns, and its angles' rates, at a pole too, and accelerations (2, k), from d'' (3, k) in I."""
    (_, s, _, c), frame = joint.trig, _product(above.frame, joint.R)
    e1, e2, _ = into(frame, acceleration)
    p, pa = into(joint.R, above.omega), into(joint.R, above.alpha)
    pole, phi_d = np.abs(c) < POLE, rates[1]
    o2 = phi_d + p[1]
    moving = np.abs(phi_d) > RESTING * (np.abs(p).sum(0) + np.abs(o2) + np.sqrt(np.abs(e1) + np.abs(e2)))
    # at cos(phi) = 0 the limit of theta', which d' does not show but d'' does; 0 for a rod at rest
    bend = e2 + pa[0] - (o2 + phi_d) * p[2]
    at_pole = np.where(moving, -s * bend / np.where(moving, 2 * phi_d, 1.0), 0.0)
    theta_d = np.where(pole, at_pole, rates[0])
    rates = np.array([theta_d, phi_d])
    w1, _, w3 = joint.relative_omega(rates)
    o1, o3 = p[0] + w1, p[2] + w3
    a1, a2 = o2 * o3 - e2, e1 - o1 * o3
    rho = a1 - pa[0] - o2 * w3 + o3 * phi_d
    theta_dd = np.where(pole, 0.0, (theta_d * phi_d * s - rho) / np.where(pole, 1.0, c))
    phi_dd = a2 - pa[1] - o3 * w1 + o1 * w3
    a3 = pa[2] + o1 * phi_d - o2 * w1 - theta_dd * s - theta_d * phi_d * c
    return _Turning(frame, np.array([o1, o2, o3]), np.array([a1, a2, a3])), rates, np.array([theta_dd, phi_dd])
