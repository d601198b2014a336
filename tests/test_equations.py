"""Laws that the hand-derived routes for one rod have to keep, in numbers; the routes against each other and Pinocchio.

A difference is measured against the sum of the absolute terms that enter the quantity (`terms`): rounding errors are
proportional to those, not to a result in which they cancel.
"""

import mpmath
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rounding
from laws import law
from pendpin.equations import balances, lagrange, newton_euler
from pendpin.equations.base import RodInertia, RodSolution
from pendpin.ground.arrays import EPS
from rod_states import (
    angles,
    any_rod,
    assert_equal,
    fields,
    lagrange_solution,
    random_states,
    rates,
    terms,
    thin_rods,
)

ROUTES = {"newton-euler": newton_euler.solve, "six balances": balances.solve}
GRAVITY = np.array([0.0, 0.0, 9.81])  # m/s², in the inertial frame I, z down
LINK_FROM_BODY = np.array([1.0, -1.0, -1.0])  # signs of the components: the link frame is B with y and z negated


# --- Pinocchio ------------------------------------------------------------------------------------------------------


def pinocchio_model(rod, field):
    """Two revolute joints at one point, a massless link between them, the rod along -z of its link frame."""
    model = pin.Model()
    model.gravity = pin.Motion(LINK_FROM_BODY * field, np.zeros(3))
    theta = model.addJoint(0, pin.JointModelRevoluteUnaligned(-1, 0, 0), pin.SE3.Identity(), "theta")
    phi = model.addJoint(theta, pin.JointModelRevoluteUnaligned(0, -1, 0), pin.SE3.Identity(), "phi")
    body = pin.Inertia(rod.m, np.array([0, 0, -rod.h]), np.diag([rod.I1, rod.I2, rod.I3]))
    model.appendBodyToJoint(phi, body, pin.SE3.Identity())
    return model


def pinocchio_solution(rod, q, v, field):
    """ABA's accelerations and RNEA's wrench at the second joint, in B; the moment's part along a3, and what is left."""
    model = pinocchio_model(rod, field)
    data = model.createData()
    a, wrench = np.empty_like(q), np.empty((len(q), 6))
    for i in range(len(q)):
        a[i] = pin.aba(model, data, q[i], v[i], np.zeros(2))
        pin.rnea(model, data, q[i], v[i], a[i])
        wrench[i] = data.f[2].vector
    force, moment = LINK_FROM_BODY * wrench[:, :3], LINK_FROM_BODY * wrench[:, 3:]
    a3 = np.stack([-np.sin(q[:, 1]), np.zeros(len(q)), np.cos(q[:, 1])], -1)
    Mc = np.einsum("ij,ij->i", a3, moment)
    solution = RodSolution(a[:, 0], a[:, 1], force[:, 0], force[:, 1], -force[:, 2], Mc * a3[:, 2], Mc)
    return solution, moment - Mc[:, None] * a3


# --- routes against each other --------------------------------------------------------------------------------------


def eliminated(rod, q, v, field, found):
    """What solving six equations adds to the terms: |A^-1| |A| |x| (Skeel), a RodSolution; A, x as in `balances`."""
    (A,), x = balances.system(rod, q, v, field)[0], np.ravel([*found[:5], found.Mc])
    theta_dd, phi_dd, R1, R2, R3, Mc = np.abs(np.linalg.inv(A)) @ (np.abs(A) @ np.abs(x))
    return RodSolution(theta_dd, phi_dd, R1, R2, R3, Mc * np.abs(np.cos(q[0, 1])), Mc)


@law(300)
@given(any_rod, angles, rates, fields)
def test_six_balances_vs_newton_euler(rod, q, v, field):
    state = rod, q[None], v[None], field
    closed = newton_euler.solve(*state)
    sizes = [one + other for one, other in zip(terms(*state), eliminated(*state, closed), strict=True)]
    assert_equal(balances.solve(*state), closed, sizes, roundings=50)


@law(300)
@given(any_rod, angles, rates, fields)
def test_lagrange_vs_newton_euler(rod, q, v, field):
    state = rod, q[None], v[None], field
    assert_equal(lagrange_solution(*state), newton_euler.solve(*state), terms(*state), roundings=20)


@law(200)
@given(any_rod, angles, rates, fields)
def test_pinocchio_vs_newton_euler(rod, q, v, field):
    state = rod, q[None], v[None], field
    found, _ = pinocchio_solution(*state)
    closed = newton_euler.solve(*state)
    a, F, M = in_spatial_vectors(*state, closed)
    spatial = RodSolution(*a, F, F, F, M, M)
    sizes = [one + other for one, other in zip(terms(*state), spatial, strict=True)]
    assert_equal(found, closed, sizes, roundings=100)


def in_spatial_vectors(rod, q, v, field, found):
    """The terms of Pinocchio's algorithms, where nothing is factored out beforehand: of a (2,), force and moment."""
    a = np.ravel([found.theta_dd, found.phi_dd])
    entering = rounding.terms(pinocchio_model(rod, field), q[0], v[0], a)
    return entering.acceleration, entering.force[1], entering.moment[1]


@pytest.mark.parametrize("distance", 10.0 ** np.arange(-12, 0))
@pytest.mark.parametrize("I3", [0.0, 5e-5])
def test_routes_agree_up_to_the_pole(distance, I3):
    q, v = random_states(100)
    q[:, 1] = np.pi / 2 * np.sign(q[:, 1]) + distance
    state = RodInertia(1.0, 0.5, 1 / 12, 1 / 12, I3), q, v, GRAVITY
    closed, sizes = newton_euler.solve(*state), terms(*state)
    assert_equal(balances.solve(*state), closed, sizes, roundings=50)
    assert_equal(lagrange_solution(*state), closed, sizes, roundings=20)
    assert_equal(pinocchio_solution(*state)[0], closed, sizes, roundings=200)


@pytest.mark.parametrize("solve", [*ROUTES.values(), lagrange_solution], ids=[*ROUTES, "lagrange"])
def test_any_leading_shape_gives_the_same_numbers(solve):
    q, v = random_states(6)
    rod = RodInertia(2.0, 0.7, 0.3, 0.2, 0.05)
    flat = solve(rod, q, v, GRAVITY)
    blocks = solve(rod, q.reshape(2, 3, 2), v.reshape(2, 3, 2), GRAVITY)
    single = solve(rod, q[4], v[4], GRAVITY)
    for a, b, c in zip(flat, blocks, single, strict=True):
        if a is not None:
            np.testing.assert_allclose(np.ravel(b), a, rtol=1e-13)
            np.testing.assert_allclose(c, a[4], rtol=1e-13)
            assert np.shape(b) == (2, 3)
            assert np.shape(c) == ()


@pytest.mark.parametrize("solve", [newton_euler.solve, lagrange_solution], ids=["newton-euler", "lagrange"])
def test_a_field_may_differ_from_state_to_state(solve):
    q, v = random_states(5)
    field = np.random.default_rng(1).normal(size=(5, 3))
    rod = RodInertia(2.0, 0.7, 0.3, 0.2, 0.05)
    together = solve(rod, q, v, field)
    for i in range(5):
        alone = solve(rod, q[i], v[i], field[i])
        assert all(a is None or abs(a[i] - b) <= 1e-12 * abs(b) for a, b in zip(together, alone, strict=True))


# --- the joint's moment and power -----------------------------------------------------------------------------------


@law(200)
@given(any_rod, angles, rates, fields)
def test_pinocchio_finds_the_moment_along_a3_alone(rod, q, v, field):
    state = rod, q[None], v[None], field
    _, rest = pinocchio_solution(*state)
    sizes = terms(*state)
    along = (rod.I1 + rod.I2 + rod.I3 + 2 * rod.m * rod.h**2) * np.sum(v**2) + rod.m * rod.h * np.abs(field).sum()
    assert np.max(np.abs(rest)) <= 100 * EPS * (along + sizes.Mc[0] + rod.I1 * sizes.theta_dd[0])


@pytest.mark.parametrize("solve", ROUTES.values(), ids=ROUTES)
def test_reactions_do_no_work(solve):
    """Their power is M . omega, for the joint stands still; along b3 alone the same moment would have some."""
    q, v = random_states(200)
    s, c = np.sin(q[:, 1]), np.cos(q[:, 1])
    omega = np.stack([-v[:, 0] * c, v[:, 1], -v[:, 0] * s], -1)  # in B
    found = solve(RodInertia(2.0, 0.7, 0.3, 0.2, 0.05), q, v, GRAVITY)
    moment = np.stack([-found.Mc * s, np.zeros(200), found.M3], -1)  # Mc a3
    power = np.einsum("ij,ij->i", moment, omega)
    along_b3 = found.M3 * omega[:, 2]
    assert np.max(np.abs(power) / np.abs(along_b3)) < 4 * EPS
    assert np.median(np.abs(along_b3)) > 100  # W


@law(200)
@given(any_rod, angles, rates, fields, st.sampled_from([*ROUTES.values(), lagrange_solution]))
def test_energy_is_conserved(rod, q, v, field, solve):
    """dT/dt + dV/dt = 0 by a complex step, which takes no difference and loses no digits."""
    a = np.array(solve(rod, q[None], v[None], field)[:2])[:, 0]
    step = 1e-100
    moved = q + 1j * step * v, v + 1j * step * a
    kinetic_rate = lagrange.kinetic(rod, *moved).imag / step
    potential_rate = lagrange.potential(rod, moved[0], field).imag / step
    sizes, J = terms(rod, q[None], v[None], field), lagrange.mass_matrix(rod, q)
    inertial = np.abs(v) @ J @ np.array([sizes.theta_dd[0], sizes.phi_dd[0]])
    centrifugal = np.abs(v).max() ** 3 * abs(rod.I1 + rod.m * rod.h**2 + rod.I3)
    field_power = rod.m * rod.h * np.abs(v).sum() * np.abs(field).sum()
    assert abs(kinetic_rate + potential_rate) <= 20 * EPS * (inertial + centrifugal + field_power)


# --- exact answers --------------------------------------------------------------------------------------------------


@given(thin_rods, angles, rates, fields)
def test_the_moment_of_a_thin_rod_is_exactly_zero(rod, q, v, field):
    found = newton_euler.solve(rod, q, v, field)
    assert found.Mc == 0
    assert found.M3 == 0


@pytest.mark.parametrize("solve", ROUTES.values(), ids=ROUTES)
@given(rod=any_rod, field=fields.filter(lambda f: np.linalg.norm(f) > 0.1))
@law(100)
def test_a_rod_that_hangs_at_rest_bears_its_weight(solve, rod, field):
    strength = np.linalg.norm(field)
    q = np.array([[np.arctan2(field[1], field[2]), np.arctan2(field[0], np.hypot(field[1], field[2]))]])  # b3 along it
    found = solve(rod, q, np.zeros((1, 2)), field)
    weight, moment, c = rod.m * strength, rod.m * rod.h * strength, np.abs(np.cos(q[:, 1]))
    (J1, J2), I3 = np.array([rod.I1, rod.I2]) + rod.m * rod.h**2, rod.I3
    theta_dd = rod.m * rod.h * np.hypot(field[1], field[2]) * c / (J1 * c**2 + I3 * (1 - c**2))
    sizes = RodSolution(theta_dd, moment / J2, weight, weight, weight, moment, moment)  # of what cancels
    assert_equal(found, RodSolution(0.0, 0.0, 0.0, 0.0, weight, 0.0, 0.0), sizes, roundings=10)


@pytest.mark.parametrize("solve", ROUTES.values(), ids=ROUTES)
def test_a_turning_rod_without_a_field_pulls_with_its_centripetal_force(solve):
    """A steady turn about a principal axis: phi' alone, or theta' alone at phi = 0. R3 = m h rate²."""
    found = solve(
        RodInertia(2.0, 0.5, 0.3, 0.2, 0.05), np.array([[0.4, 1.1], [0.4, 0.0]]), 3 * np.eye(2)[::-1], 0 * GRAVITY
    )
    np.testing.assert_allclose(found.R3, 9.0, rtol=4 * EPS)
    for zero in (found.theta_dd, found.phi_dd, found.R1, found.R2, found.Mc):
        np.testing.assert_allclose(zero, 0.0, atol=1e-15)


def cone(inclination, rate, t):
    """Angles of a rod that goes round the vertical at a constant inclination and rate: b3 in I is (s, s_t c, c_t c)."""
    x = mpmath.sin(inclination) * mpmath.cos(rate * t)
    y = mpmath.sin(inclination) * mpmath.sin(rate * t)
    return mpmath.atan2(y, mpmath.cos(inclination)), mpmath.asin(x)


@pytest.mark.parametrize("solve", [*ROUTES.values(), lagrange_solution], ids=[*ROUTES, "lagrange"])
@pytest.mark.parametrize("inclination", [0.01, 0.8, 1.5])
def test_conical_motion_of_a_thin_rod(solve, inclination):
    """rate² = m h g / (J cos(inclination)); the force on it is m (a_G - field), turned into B."""
    rod = RodInertia(1.3, 0.45, 0.07, 0.07, 0.0)
    with mpmath.workdps(40):
        rate = mpmath.sqrt(rod.m * rod.h * 9.81 / ((rod.I1 + rod.m * rod.h**2) * mpmath.cos(inclination)))
        for t in (0.1, 0.9, 2.7):
            q, v, a = (
                np.array([float(mpmath.diff(lambda x, i=i: cone(inclination, rate, x)[i], t, n)) for i in (0, 1)])
                for n in (0, 1, 2)
            )
            found = RodSolution(*(x if x is None else x[None] for x in solve(rod, q, v, GRAVITY)))
            toward_axis = -rod.m * rod.h * float(rate) ** 2 * np.sin(inclination)
            angle = float(rate * t)
            force = np.array([toward_axis * np.cos(angle), toward_axis * np.sin(angle), -rod.m * 9.81])
            R1, R2, minus_R3 = force @ balances.frames(q)
            size = np.linalg.norm(force)  # which the turn into B rounds
            sizes = terms(rod, q[None], v[None], GRAVITY)._replace(R1=size, R2=size, R3=size)
            assert_equal(found, RodSolution(*a, R1, R2, -minus_R3, 0.0, 0.0), sizes, roundings=20)


# --- a published check of the wrench's convention -------------------------------------------------------------------

SPIN, MASS, LENGTH, G = 5.0, 1.5, 2.0, 10.0  # rad/s, kg, m, m/s²


@pytest.mark.parametrize("angle", [0.0, 1.0, -2.5])
def test_drake_spinning_rod_in_pinocchio(angle):
    """Drake's SpinningRodTest: a thin rod turns about the vertical z axis of a pin at its end, 5 rad/s.

    The pin's frame on the rod has z up and the rod along +y. There the pin pulls it in with m w² l/2 = 37.5 N along
    -y, bears its weight, 15 N along z, and holds it level with 15 N x 1 m about x: force first, at the joint's origin,
    in the child joint's frame, whatever the angle.
    """
    model = pin.Model()
    model.gravity = pin.Motion(np.array([0, 0, -G]), np.zeros(3))
    joint = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "pin")
    across = MASS * LENGTH**2 / 12
    body = pin.Inertia(MASS, np.array([0, LENGTH / 2, 0]), np.diag([across, 0.0, across]))
    model.appendBodyToJoint(joint, body, pin.SE3.Identity())
    data = model.createData()
    a = pin.aba(model, data, np.array([angle]), np.array([SPIN]), np.zeros(1))
    pin.rnea(model, data, np.array([angle]), np.array([SPIN]), a)
    np.testing.assert_allclose(a, 0, atol=1e-15)
    np.testing.assert_allclose(data.f[1].vector, [0, -37.5, 15, 15, 0, 0], rtol=4 * EPS, atol=1e-14)


@pytest.mark.parametrize("angle", [0.0, 1.0, -2.5])
def test_drake_spinning_rod_on_the_two_joints(angle):
    """The same rod on the universal joint, theta held at 90 degrees by a torque: phi's axis is then the vertical.

    In the link frame of pendpin the rod lies along -z and up is -y, so Drake's (x, y, z) read (-x, -z, -y) there; in B
    they are R1 = 0, R2 = 15 N (up), R3 = 37.5 N (tension), and theta's motor has to hold the moment about x.
    """
    rod = RodInertia(MASS, LENGTH / 2, MASS * LENGTH**2 / 12, MASS * LENGTH**2 / 12, 0.0)
    model = pinocchio_model(rod, np.array([0, 0, G]))
    data = model.createData()
    torque = pin.rnea(model, data, np.array([np.pi / 2, angle]), np.array([0, SPIN]), np.zeros(2))
    drake = np.array([-data.f[2].linear[[0, 2, 1]], -data.f[2].angular[[0, 2, 1]]]).ravel()
    np.testing.assert_allclose(drake, [0, -37.5, 15, 15, 0, 0], rtol=4 * EPS, atol=1e-13)
    np.testing.assert_allclose(torque, [15 * np.cos(angle), 0], rtol=8 * EPS, atol=1e-13)
