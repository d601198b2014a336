"""A mass matrix with negative inertia in it: whether it is positive definite at all positions, by bounds."""

from typing import Any

import numpy as np

from pendpin.ground.arrays import TINY, Array
from pendpin.model.bodies import twist_of

ROUNDING = 1e-12  # of the numbers in an inertia: what rounding may leave below zero
ROTATION = slice(3, 6)  # of a twist (v, omega)


def always_positive(model: Any) -> bool:
    """True if a pin.Model's mass matrix is known to be positive definite at all positions; False if it is not known.

    From the leaves to the root: a joint moves a, the inertia (6, 6) of its body and a bound of what hangs on it. Where the
    joint moves so that the energy is least, b = a - a S S^T a / (S^T a S) is left, which is not below -n |omega|². That
    bound is the same at all positions, about all points. All S^T a S > 0 is enough.
    """
    missing = np.zeros(model.njoints)  # n kg m², of what hangs on each joint
    for joint in reversed(range(1, model.njoints)):
        a, S = np.array(model.inertias[joint].matrix()), twist_of(model.joints[joint])
        a[ROTATION, ROTATION] -= missing[joint] * np.eye(3)
        moved = a @ S
        if not S @ moved > ROUNDING * np.abs(a).max():
            return False
        parent, below = model.parents[joint], _missing(a - np.outer(moved, moved) / (S @ moved))
        if parent and not np.isfinite(below):
            return False
        missing[parent] += below
    return True


def _missing(b: Array) -> float:
    """The least n in kg m² at which b (6, 6) + n |omega|² is not negative; inf if there is none."""
    linear, mixed, turning = b[:3, :3], b[:3, ROTATION], b[ROTATION, ROTATION]
    values, axes = np.linalg.eigh(linear)
    small = values < ROUNDING * max(np.abs(linear).max(), TINY)
    coupling = axes.T @ mixed
    negative = (values < -ROUNDING * np.abs(linear).max()).any()
    if negative or np.abs(coupling[small]).max(initial=0.0) > ROUNDING * np.abs(b).max():
        return np.inf
    rest = turning - coupling[~small].T @ (coupling[~small] / values[~small, None])
    least = float(np.linalg.eigvalsh(rest)[0])
    return max(0.0, -least) + ROUNDING * float(np.abs(turning).max()) * (least < 0)
