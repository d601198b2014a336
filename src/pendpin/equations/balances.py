"""One rod, the six balances of force and moment solved as one 6 x 6 linear system (docs/derivation.md, section 3)."""

import numpy as np

from pendpin.equations.base import RodInertia, RodSolution
from pendpin.ground.arrays import Array


def frames(q: Array) -> Array:
    """Body axes as columns, components in the inertial frame I: (..., 3, 3), from angles q (..., 2) in rad."""
    (s_t, s), (c_t, c) = np.moveaxis(np.sin(q), -1, 0), np.moveaxis(np.cos(q), -1, 0)
    zero = np.zeros_like(s)
    b1 = np.stack([c, -s_t * s, -c_t * s], -1)
    b2 = np.stack([zero, c_t, -s_t], -1)
    b3 = np.stack([s, s_t * c, c_t * c], -1)
    return np.stack([b1, b2, b3], -1)


def system(rod: RodInertia, q: Array, v: Array, field: Array) -> tuple[Array, Array]:
    """Matrix (..., 6, 6) and right-hand side (..., 6) of the balances, rows: force on b1, b2, b3, moment about G.

    The unknowns are theta'', phi'', R1, R2, R3, Mc. Units: N and N m in the rows; q, v, field as in `solve`.
    """
    s, c = np.sin(q[..., 1]), np.cos(q[..., 1])
    dt, dp = v[..., 0], v[..., 1]
    inertia = np.array([rod.I1, rod.I2, rod.I3])
    b3 = np.array([0.0, 0.0, 1.0])
    zero, one = np.zeros_like(s), np.ones_like(s)

    omega = np.stack([-dt * c, dp, -dt * s], -1)
    bias = np.stack([dt * dp * s, zero, -dt * dp * c], -1)  # omega' less the terms in theta'', phi''
    unit_accelerations = (np.stack([-c, zero, -s], -1), np.stack([zero, one, zero], -1))
    a3 = np.stack([-s, zero, c], -1)

    A = np.zeros((*s.shape, 6, 6), dtype=s.dtype)
    for column, alpha in enumerate(unit_accelerations):
        A[..., :3, column] = rod.m * rod.h * np.cross(alpha, b3)
        A[..., 3:, column] = inertia * alpha
    for column, force in enumerate(np.diag([1.0, 1.0, -1.0]), start=2):
        A[..., :3, column] = -force
        A[..., 3:, column] = rod.h * np.cross(b3, force)
    A[..., 3:, 5] = -a3

    field_B = np.einsum("...ji,...j->...i", frames(q), field)
    centripetal = np.cross(omega, np.cross(omega, b3))
    force = rod.m * field_B - rod.m * rod.h * (np.cross(bias, b3) + centripetal)
    moment = -inertia * bias - np.cross(omega, inertia * omega)
    return A, np.concatenate([force, moment], -1)


def solve(rod: RodInertia, q: Array, v: Array, field: Array) -> RodSolution:
    """Accelerations and reactions from the six balances.

    m a_G = R1 b1 + R2 b2 - R3 b3 + m field and I omega' + omega x (I omega) = (-h b3) x R + Mc a3, in B. Rows and
    columns are scaled to unit size first, so that the solve is as accurate for a thin rod as for a thick one.
    q, v (..., 2) in rad and rad/s; field (3,) in I, m/s². Raises numpy.linalg.LinAlgError where the system is
    singular (thin rod at cos(phi) = 0).
    """
    A, rhs = system(rod, q, v, field)
    rows = np.abs(A).max(-1, keepdims=True)
    A, rhs = A / rows, rhs / rows[..., 0]
    columns = np.abs(A).max(-2, keepdims=True)
    x = np.linalg.solve(A / columns, rhs[..., None])[..., 0] / columns[..., 0, :]
    theta_dd, phi_dd, R1, R2, R3, Mc = np.moveaxis(x, -1, 0)
    return RodSolution(theta_dd, phi_dd, R1, R2, R3, Mc * np.cos(q[..., 1]), Mc)
