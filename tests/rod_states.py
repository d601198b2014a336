"""States and rods for the laws of one rod, and the terms that enter each quantity."""

import numpy as np
from hypothesis import strategies as st

from pendpin.equations import lagrange
from pendpin.equations.base import RodInertia, RodSolution
from pendpin.ground.arrays import EPS


def between(low, high):
    """Numbers whose products do not underflow: 0, or more than 1e-60."""
    return st.floats(low, high).map(lambda x: x if abs(x) > 1e-60 else 0.0)


def pairs(limit):
    return st.tuples(between(-limit, limit), between(-limit, limit)).map(np.array)


def rods(I3):
    """Any central inertia in kg m²; it need not belong to a real body, the equations do not mind."""
    return st.builds(RodInertia, between(0.1, 10), between(0.1, 2), between(0.01, 2), between(0.01, 2), I3)


thin_rods = st.builds(
    lambda m, h, I1: RodInertia(m, h, I1, I1, 0.0), between(0.1, 10), between(0.1, 2), between(0.0, 2)
)
any_rod = st.one_of(rods(between(1e-6, 2.0)), rods(st.just(0.0)), thin_rods)
angles, rates = pairs(np.pi), pairs(100.0)  # rad, rad/s
fields = st.tuples(*[between(-20, 20)] * 3).map(np.array)  # m/s², in I


def random_states(count, seed=0):
    """Angles and rates (count, 2) over the whole range."""
    random = np.random.default_rng(seed)
    return random.uniform(-np.pi, np.pi, (count, 2)), random.uniform(-100, 100, (count, 2))


def terms(rod, q, v, field):
    """The sums of the absolute terms that enter each quantity, a RodSolution."""
    m, h, I1, I2, I3 = rod
    J1, J2 = I1 + m * h * h, I2 + m * h * h
    (s_t, s), (c_t, c) = np.abs(np.sin(q)).T, np.abs(np.cos(q)).T
    (dt, dp), (gx, gy, gz) = np.abs(v).T, np.abs(field)
    along, G2 = s_t * gy + c_t * gz, c_t * gy + s_t * gz
    G1, G3 = c * gx + s * along, s * gx + c * along
    theta_dd = c * (2 * (J1 + I3) * dt * dp * s + m * h * G2) / (J1 * c**2 + I3 * s**2)
    phi_dd = (m * h * G1 + (J1 + I3) * dt**2 * s * c) / J2
    alpha1, alpha3 = theta_dd * c + dt * dp * s, theta_dd * s + dt * dp * c
    R1 = m * (h * (phi_dd + dt**2 * s * c) + G1)
    R2 = m * (h * (alpha1 + dt * dp * s) + G2)
    R3 = m * (h * (dp**2 + dt**2 * c**2) + G3)
    along_b1 = J1 * alpha1 + (J2 + I3) * dt * dp * s + m * h * G2
    along_b3 = I3 * alpha3 + (J1 + J2) * dt * dp * c
    Mc = s * along_b1 + c * along_b3
    return RodSolution(theta_dd, phi_dd, R1, R2, R3, Mc * c, Mc)


def differences(first, second, sizes):
    """|first - second| / sizes, by quantity, worst state; quantities that either leaves out are left out."""
    return {
        name: np.max(np.abs(a - b) / (size + 1e-300))
        for name, a, b, size in zip(RodSolution._fields, first, second, sizes, strict=True)
        if a is not None and b is not None
    }


def assert_equal(first, second, sizes, roundings):
    """Equal to so many units of rounding (2.2e-16) of the terms."""
    worst = differences(first, second, sizes)
    assert all(value <= roundings * EPS for value in worst.values()), worst


def lagrange_solution(rod, q, v, field):
    """What Lagrange says; the reactions, of which he says nothing, are None."""
    theta_dd, phi_dd = np.moveaxis(lagrange.accelerations(rod, q, v, field), -1, 0)
    return RodSolution(theta_dd, phi_dd, None, None, None, None, None)
