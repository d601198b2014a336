"""One rod, Newton-Euler in closed form (docs/derivation.md, section 4)."""

from typing import Any

import numpy as np

from pendpin.equations.base import RodInertia, RodSolution
from pendpin.ground.arrays import Array


def solve(rod: RodInertia, q: Array, v: Array, field: Array, xp: Any = np) -> RodSolution:
    """Accelerations and reactions of a rod on a universal joint.

    The moment balance about the joint, projected on a1, a2 and a3, gives theta'', phi'' and Mc one by one; the force
    balance gives R1, R2, R3. The forms hold for any principal inertia, the thin rod (I3 = 0) included. A thin
    rod's theta'' grows without bound towards cos(phi) = 0: a fault of the angles, not of the motion (section 6).

    Parameters: q, v (..., 2) hold theta, phi in rad and rad/s; field (3,) or (..., 3) is the uniform acceleration
    field in the inertial frame I (z down), m/s²; gravity is (0, 0, 9.81). xp
    brings the functions of the number type (pendpin.equations.base).
    """
    m, h, I1, I2, I3 = rod
    J1, J2 = I1 + m * h**2, I2 + m * h**2  # about the joint
    s_t, c_t = xp.sin(q[..., 0]), xp.cos(q[..., 0])
    s, c = xp.sin(q[..., 1]), xp.cos(q[..., 1])
    dt, dp = v[..., 0], v[..., 1]

    along = s_t * field[..., 1] + c_t * field[..., 2]  # the field along the turned z
    G1 = c * field[..., 0] - s * along
    G2 = c_t * field[..., 1] - s_t * field[..., 2]
    G3 = s * field[..., 0] + c * along

    D = J1 * c**2 + I3 * s**2
    drive = 2 * (J1 - I3) * dt * dp * s + m * h * G2
    theta_dd = drive * c / D
    phi_dd = (m * h * G1 - (J1 - I3) * dt**2 * s * c) / J2

    Mc = -(I3 * s * drive / D + (I3 + J2 - J1) * dt * dp)
    alpha1 = -theta_dd * c + dt * dp * s
    R1 = m * (h * (phi_dd + dt**2 * s * c) - G1)
    R2 = m * (h * (-alpha1 - dt * dp * s) - G2)
    R3 = m * (h * (dp**2 + dt**2 * c**2) + G3)
    return RodSolution(theta_dd, phi_dd, R1, R2, R3, Mc * c, Mc)
