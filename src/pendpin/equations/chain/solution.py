"""A chain of rods on universal joints, Newton-Euler: accelerations and every joint's reactions in one solve of O(n).

The derivation is docs/derivation_chain.md. The reactions of all joints are the unknowns; system.py has the equations,
kinematics.py the angles. `solve` takes angles and rates and returns accelerations and reactions.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from pendpin.equations.chain.kinematics import ChainInertia, Joints, above, below, into, rods_first, rods_last
from pendpin.equations.chain.system import Balances, project
from pendpin.ground.arrays import Array, Mask, lapack

AXIAL = 1e-12  # an axial moment on a thin rod below this fraction of the largest moment is rounding


@dataclass(frozen=True)
class ChainSolution:
    """Accelerations and joint reactions of a chain, rod by rod, with the signs and axes of RodSolution."""

    acceleration: Array  # (..., n, 2) rad/s², theta'', phi''
    force: Array  # (..., n, 3) N, on the rod at its joint, in B: R1, R2, -R3
    Mc: Array  # (..., n) N m, along a3
    M3: Array  # (..., n) N m, Mc cos(phi)
    moment: Array  # (..., n, 3) N m, on the rod at its joint, in B: Mc a3 and the joint's torques

    @property
    def wrench(self) -> Array:
        """(..., n, 6): force, then moment at the joint, by the rod above (or the support) on the rod; in B."""
        return np.concatenate([self.force, self.moment], -1)


def solve(
    chain: ChainInertia,
    q: Array,
    v: Array,
    field: Array,
    *,
    torque: Array | None = None,
    force: Array | None = None,
    moment: Array | None = None,
) -> ChainSolution:
    """Accelerations and reactions of a chain, or of a batch of its states.

    Parameters: q, v (..., n, 2) hold theta, phi of each rod in rad and rad/s; field (3,) or (..., 3) is the uniform
    acceleration field in the inertial frame I (z down), m/s²: gravity is (0, 0, 9.81).
    Optional: torque (..., n, 2) about each joint's axes, the generalised forces of theta and phi, on the rod and in
    return on the rod above, N m; force and moment (..., n, 3) on each rod from outside, in I, the moment about the
    centre of mass, N and N m.

    Rods at the end of the chain without axial inertia and axial moment have joints that act as spherical joints:
    all reactions are regular there, also at cos(phi) = 0; only theta'' is not.
    Raises numpy.linalg.LinAlgError where the reactions have no finite values.
    """
    joints, rate = Joints.at(q), rods_last(v)
    omega = joints.omega(rate)
    push, about_G, at_joint, first_spherical = _external(chain, joints, torque, force, moment)
    s_t, s, c_t, c = joints.trig
    drift = rate[0] * (omega[1] - rate[1]) + rate[1] * (c * omega[0] + s * omega[2])
    spherical, states = None, q[..., 0].size // chain.n
    if first_spherical < chain.n:
        spherical = np.tile(np.arange(chain.n) >= first_spherical, states)
    # The balances with their known terms; rods on spherical joints have no spin there, and get it afterwards.
    (o1, o2, o3), trig, own_drift, rods = omega, joints.trig, drift, chain.rods.repeated(states)
    if spherical is not None:
        (o3, own_drift), trig = np.where(spherical, 0.0, [o3, drift]), np.where(spherical, 0.0, trig)
    swing, (I1, I2, I3) = np.array([o1 * o3, o2 * o3, -(o1 * o1 + o2 * o2)]), rods.inertia
    turning = np.array([(I2 - I3) * swing[1], (I3 - I1) * swing[0], (I1 - I2) * (o1 * o2)]) + about_G
    if spherical is not None:
        turning[2, spherical] = 0
    support = -np.reshape(field, (-1, 3)).T
    known = support, push, turning, joints, trig, spherical, swing, own_drift
    x, alpha = project(Balances(rods, rods.inverse, *known))
    if spherical is not None:
        alpha = _add_spin(joints, spherical, omega, drift, alpha)
    # theta'' and phi'': the relative angular acceleration along the joint's two axes
    beside = c * omega[2] - s * omega[0]  # omega . a3, the same above and below the joint
    up = above(alpha, joints.n)
    theta_dd = up[0] - (c * alpha[0] + s * alpha[2]) - rate[1] * beside
    phi_dd = alpha[1] - (c_t * up[1] - s_t * up[2]) + rate[0] * beside
    shape = q.shape[:-1]
    at_joint[0] -= s * x[3]
    at_joint[2] += c * x[3]
    return ChainSolution(
        acceleration=rods_first(np.array([theta_dd, phi_dd]), shape),
        force=rods_first(x[:3], shape),
        Mc=x[3].reshape(shape),
        M3=(c * x[3]).reshape(shape),
        moment=rods_first(at_joint, shape),
    )


def _external(
    chain: ChainInertia, joints: Joints, torque: Array | None, force: Array | None, moment: Array | None
) -> tuple[Any, Any, Array, int]:
    """Loads (3, K) in body frames from outside, given as in `solve`, and the first rod whose joint is spherical, or n.

    Force over mass, m/s²; moment about G, joint torques included, N m; torque of the joint on its rod, N m.
    """
    push, about_G, at_joint, first_spherical = 0.0, 0.0, np.zeros_like(joints.trig[:3]), chain.first_thin
    if force is not None or moment is not None:
        frames = joints.frames()
        if force is not None:
            push = into(frames, rods_last(force)) / np.tile(chain.m, force[..., 0].size // chain.n)
        if moment is not None:
            about_G = into(frames, rods_last(moment))
            axial = np.abs(about_G[2]) > AXIAL * np.abs(about_G).max()
            first_spherical = max(first_spherical, _count_to_last(axial, chain.n))
    if torque is not None:
        tau = rods_last(torque)
        first_spherical = max(first_spherical, _count_to_last((tau != 0).any(0), chain.n))
        s_t, s, c_t, c = joints.trig
        at_joint = np.stack([-tau[0] * c, tau[1], -tau[0] * s])
        about_G = about_G + at_joint
        about_G[0] += below(tau[0], joints.n)
        about_G[1] -= below(tau[1] * c_t, joints.n)
        about_G[2] += below(tau[1] * s_t, joints.n)
    return push, about_G, at_joint, first_spherical


def _count_to_last(marked: Mask, n: int) -> int:
    """Index after the last rod that is marked (K,) in any of the states; 0 if none is."""
    rods = np.flatnonzero(marked.reshape(-1, n).any(0))
    return int(rods[-1]) + 1 if rods.size else 0


def _add_spin(joints: Joints, spherical: Mask, omega: Array, drift: Array, alpha: Array) -> Array:
    """Angular accelerations (3, K) of rods on spherical joints, in the frames that the angles give them, which do spin."""
    # Across the axis the frame's spin adds what leaves b3'' unchanged; along it the universal joint's twist constraint
    # decides, from the support down.
    s_t, s, c_t, c = joints.trig
    a1 = alpha[0] + np.where(spherical, omega[1] * omega[2], 0.0)
    a2 = alpha[1] - np.where(spherical, omega[0] * omega[2], 0.0)
    band = np.zeros((alpha.shape[1], 2))
    band[:, 0] = np.where(spherical, c, 1.0)
    band[:-1, 1] = np.where(spherical, -c_t, 0.0)[1:]
    band[joints.n - 1 :: joints.n, 1] = 0
    rhs = np.where(spherical, drift + s * a1 + s_t * above(a2, joints.n), alpha[2])
    return np.stack([a1, a2, lapack("tbsv")(1, band.T, rhs, lower=1)])
