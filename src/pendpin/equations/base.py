"""What the routes share: a rod's inertia, its columns among the joints, the names of the answers. No equations live here."""

from functools import cache
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from pendpin.ground.arrays import Array

JOINTS = 2  # of a rod on a universal joint
THETA, PHI = slice(0, None, JOINTS), slice(1, None, JOINTS)  # their columns in a chain: theta_1, phi_1, theta_2, ...


def split_by_rod(x: Array) -> Array:
    """Numbers (..., nv) of a chain's joints as (..., rods, 2): theta and phi of each rod."""
    return x.reshape(*x.shape[:-1], x.shape[-1] // JOINTS, JOINTS)


class RodInertia(NamedTuple):
    """A rod's mass properties in its body frame B (b3 from the joint to the tip), payload already folded in."""

    m: float  # kg
    h: float  # m, centre of mass from the joint along b3
    I1: float  # kg m², central, about b1
    I2: float  # kg m², central, about b2
    I3: float  # kg m², about b3


class RodSolution(NamedTuple):
    """Accelerations and joint reactions of one rod, one entry per state.

    Reactions act on the rod at its joint: R1 along b1, R2 along b2, R3 along -b3 (tension positive), the moment Mc
    along a3 = a1 x a2, and M3 = Mc cos(phi), its b3 component.
    """

    theta_dd: Array  # rad/s²
    phi_dd: Array  # rad/s²
    R1: Array  # N
    R2: Array  # N
    R3: Array  # N
    M3: Array  # N m
    Mc: Array  # N m


FUNCTIONS = ("sqrt", "exp", "log", "sin", "cos", "tan", "tanh")


@cache
def exact(digits: int) -> Any:
    """mpmath's numbers of `digits` decimal digits, in object arrays; `asarray` takes floats over without rounding.

    The precision belongs to the namespace, not to the process: several can be used side by side.
    Raises ImportError without mpmath.
    """
    import mpmath

    context = mpmath.mp.clone()
    context.dps = digits
    functions = {name: np.frompyfunc(getattr(context, name), 1, 1) for name in FUNCTIONS}
    convert = np.frompyfunc(context.mpf, 1, 1)
    functions["asarray"] = lambda x: np.asarray(convert(np.asarray(x)), dtype=object)
    return SimpleNamespace(minimum=np.minimum, maximum=np.maximum, **functions)
