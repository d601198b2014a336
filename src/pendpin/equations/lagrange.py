"""One rod, Lagrange's equations (docs/derivation.md, section 5): accelerations, no reactions."""

import numpy as np

from pendpin.equations.base import RodInertia
from pendpin.ground.arrays import Array


def mass_matrix(rod: RodInertia, q: Array) -> Array:
    """Mass matrix M(q) (..., 2, 2) in kg m², from T = v M v / 2; q (..., 2) in rad."""
    s2, c2 = np.sin(q[..., 1]) ** 2, np.cos(q[..., 1]) ** 2
    about_joint = rod.m * rod.h * rod.h
    M11 = c2 * (rod.I1 + about_joint) + s2 * rod.I3
    M22 = np.full_like(M11, rod.I2 + about_joint)
    return np.stack([M11, M22], -1)[..., None] * np.eye(2, dtype=int)


def kinetic(rod: RodInertia, q: Array, v: Array) -> Array:
    """Kinetic energy T (...) in J."""
    return 0.5 * np.einsum("...i,...ij,...j->...", v, mass_matrix(rod, q), v)


def potential(rod: RodInertia, q: Array, field: Array) -> Array:
    """Potential V = -m h field . b3 (...) in J of a uniform field (3,) given in I, zero with G at the joint."""
    s_t, c_t = np.sin(q[..., 0]), np.cos(q[..., 0])
    s, c = np.sin(q[..., 1]), np.cos(q[..., 1])
    return -rod.m * rod.h * (s * field[..., 0] + c * (s_t * field[..., 1] + c_t * field[..., 2]))


def accelerations(rod: RodInertia, q: Array, v: Array, field: Array) -> Array:
    """theta'', phi'' (..., 2) in rad/s² from d/dt dT/dv - dT/dq + dV/dq = 0.

    M is diagonal and depends on phi only, so each equation gives its own acceleration. q, v (..., 2) in rad and rad/s;
    field (3,) in I, m/s².
    """
    M = mass_matrix(rod, q)
    s_t, c_t = np.sin(q[..., 0]), np.cos(q[..., 0])
    s, c = np.sin(q[..., 1]), np.cos(q[..., 1])
    slope = -2 * s * c * (rod.I1 + rod.m * rod.h * rod.h - rod.I3)  # dM11/dphi
    dV_dtheta = -rod.m * rod.h * c * (c_t * field[..., 1] - s_t * field[..., 2])
    dV_dphi = -rod.m * rod.h * (c * field[..., 0] - s * (s_t * field[..., 1] + c_t * field[..., 2]))
    theta_dd = -(slope * v[..., 0] * v[..., 1] + dV_dtheta) / M[..., 0, 0]
    phi_dd = (0.5 * slope * v[..., 0] ** 2 - dV_dphi) / M[..., 1, 1]
    return np.stack([theta_dd, phi_dd], -1)
