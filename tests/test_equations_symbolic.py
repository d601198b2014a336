"""The code's closed forms against equations derived here from rotation matrices, for general I1, I2, I3, m, h, field.

No formula is copied from the code: the derivations differentiate the frames symbolically, and the code's own functions
run on symbols. NumPy calls x.sin() on what an object array holds, so an angle with a method `sin` is all that takes.
Every difference has to come out as exactly 0.
"""

from functools import cache

import numpy as np
import pytest
import sympy as sp

from pendpin.equations import balances, lagrange, newton_euler
from pendpin.equations.base import RodInertia


class Angle(sp.Symbol):
    """A symbol that numpy.sin and numpy.cos accept."""

    def sin(self):
        """What numpy.sin calls."""
        return sp.sin(self)

    def cos(self):
        """What numpy.cos calls."""
        return sp.cos(self)


theta, phi = coordinates = sp.Matrix([Angle("theta", real=True), Angle("phi", real=True)])
rates = sp.Matrix(sp.symbols("theta_d phi_d", real=True))
accelerations = sp.Matrix(sp.symbols("theta_dd phi_dd", real=True))
R1, R2, R3, Mc = reactions = sp.Matrix(sp.symbols("R1 R2 R3 Mc", real=True))
g = sp.Matrix(sp.symbols("g_x g_y g_z", real=True))  # the field, components in the inertial frame
rod = RodInertia(*sp.symbols("m h I1 I2 I3", positive=True))
inertia = sp.diag(rod.I1, rod.I2, rod.I3)

TRIGONOMETRY = [sp.sin(x) ** 2 + sp.cos(x) ** 2 - 1 for x in coordinates]  # a Gröbner basis of what holds among them
FUNCTIONS = [f(x) for x in coordinates for f in (sp.sin, sp.cos)]


def normal(expression):
    """The normal form of a polynomial in the sines and cosines: equal polynomials have the same, zero has 0."""
    return sp.reduced(sp.expand(expression), TRIGONOMETRY, *FUNCTIONS)[1]


def is_zero(expression):
    """Whether a fraction, or every entry of a matrix of them, is identically 0."""
    entries = expression if isinstance(expression, sp.MatrixBase) else [expression]
    return all(normal(sp.numer(sp.together(entry))) == 0 for entry in entries)


# --- the code, run on symbols ---------------------------------------------------------------------------------------

Q, V, FIELD = (np.array([coordinates.flat()]), np.array([rates.flat()]), np.array(g.flat()))  # one state: (1, 2)


def exact(array):
    """A result for the one state as a matrix of exact numbers: the code's 0.5 and 1.0 become rationals."""
    return sp.Matrix(np.asarray(array)[0]).applyfunc(lambda entry: sp.nsimplify(entry, rational=True))


@cache
def closed_form():
    """theta'', phi'', R1, R2, R3, M3, Mc as pendpin.equations.newton_euler has them."""
    return exact(np.stack(newton_euler.solve(rod, Q, V, FIELD), -1))


def closed_form_of(*names):
    """Some of them, by the names of RodSolution."""
    fields = newton_euler.RodSolution._fields
    return sp.Matrix([closed_form()[fields.index(name)] for name in names])


# --- the derivations, from the frames -------------------------------------------------------------------------------


def d_dt(expression):
    """Time derivative of a matrix by the chain rule; coordinates, rates and accelerations are plain symbols."""
    moving = zip([*coordinates, *rates], [*rates, *accelerations], strict=True)
    return sum((sp.diff(expression, x) * x_d for x, x_d in moving), sp.zeros(*expression.shape))


def turn(axis, angle):
    """Rotation matrix by Rodrigues' formula."""
    K = sp.Matrix(axis).hat()
    return sp.eye(3) + sp.sin(angle) * K + (1 - sp.cos(angle)) * K * K


@cache
def frame():
    """Body axes as columns in the inertial frame: clockwise about x, then counter-clockwise about the turned y."""
    return turn((1, 0, 0), -theta) * turn((0, 1, 0), phi)


@cache
def omega():
    """Angular velocity in B, from frame^T d(frame)/dt = [omega x]."""
    return (frame().T * d_dt(frame())).applyfunc(normal).vee()


@cache
def position():
    """The centre of mass from the joint, in the inertial frame."""
    return frame() * sp.Matrix([0, 0, rod.h])


@cache
def kinetic():
    """Kinetic energy: half m v² and half omega . I omega."""
    velocity = d_dt(position())
    return normal(rod.m * velocity.dot(velocity) + omega().dot(inertia * omega())) / 2


@cache
def potential():
    """Potential of the field."""
    return normal(-rod.m * g.dot(position()))


@cache
def lagrange_residuals():
    """d/dt dL/dq' - dL/dq for the two angles."""
    L = sp.Matrix([kinetic() - potential()])
    return (d_dt(L.jacobian(rates).T) - L.jacobian(coordinates).T).applyfunc(normal)


@cache
def balance_residuals():
    """m a_G less the forces, and the rate of the angular momentum about G less the moments; six rows, in B."""
    R, joint_from_G = frame(), sp.Matrix([0, 0, -rod.h])
    a1, a2 = sp.Matrix([1, 0, 0]), turn((1, 0, 0), -theta) * sp.Matrix([0, 1, 0])
    force = sp.Matrix([R1, R2, -R3])
    linear = rod.m * (d_dt(d_dt(position())) - g) - R * force
    angular = d_dt(R * inertia * omega()) - R * joint_from_G.cross(force) - Mc * a1.cross(a2)
    return sp.Matrix([R.T * linear, R.T * angular]).applyfunc(normal)


def linear_system(residuals, unknowns):
    """Matrix and right-hand side of residuals that are linear in the unknowns."""
    return residuals.jacobian(unknowns), -residuals.subs(dict.fromkeys(unknowns, 0))


@cache
def derived_lagrange():
    """theta'', phi'' from Lagrange's equations."""
    M, rhs = linear_system(lagrange_residuals(), accelerations)
    return M.LUsolve(rhs)


@cache
def derived_newton_euler():
    """theta'', phi'', R1, R2, R3, Mc from the six balances."""
    A, rhs = linear_system(balance_residuals(), [*accelerations, *reactions])
    return A.LUsolve(rhs)


# --- the proofs -----------------------------------------------------------------------------------------------------


def test_body_axes_in_the_code_are_the_two_turns():
    assert is_zero(exact(balances.frames(Q)) - frame())


def test_energies_in_the_code_are_those_of_the_frames():
    assert is_zero(exact(lagrange.kinetic(rod, Q, V)[:, None])[0] - kinetic())
    assert is_zero(exact(lagrange.potential(rod, Q, FIELD)[:, None])[0] - potential())


def test_mass_matrix_in_the_code_is_the_second_derivative_of_the_kinetic_energy():
    assert is_zero(exact(lagrange.mass_matrix(rod, Q)) - sp.hessian(kinetic(), rates.flat()))


def test_lagrange_in_the_code_solves_the_derived_equations():
    assert is_zero(exact(lagrange.accelerations(rod, Q, V, FIELD)) - derived_lagrange())


def test_lagrange_derived_equals_newton_euler_in_the_code():
    assert is_zero(closed_form_of("theta_dd", "phi_dd") - derived_lagrange())


def test_six_by_six_in_the_code_is_the_derived_system():
    A, rhs = linear_system(balance_residuals(), [*accelerations, *reactions])
    code_A, code_rhs = balances.system(rod, Q, V, FIELD)
    assert is_zero(exact(code_A) - A)
    assert is_zero(exact(code_rhs) - rhs)


def test_six_by_six_has_one_solution_unless_a_thin_rod_is_at_its_pole():
    A, _ = linear_system(balance_residuals(), [*accelerations, *reactions])
    J1, J2 = rod.I1 + rod.m * rod.h**2, rod.I2 + rod.m * rod.h**2
    assert is_zero(A.det() - J2 * (J1 * sp.cos(phi) ** 2 + rod.I3 * sp.sin(phi) ** 2))


@pytest.mark.parametrize("row", range(6), ids=["theta_dd", "phi_dd", "R1", "R2", "R3", "Mc"])
def test_newton_euler_in_the_code_solves_the_derived_balances(row):
    names = ("theta_dd", "phi_dd", "R1", "R2", "R3", "Mc")
    assert is_zero(closed_form_of(names[row]) - sp.Matrix([derived_newton_euler()[row]]))


def test_M3_is_the_b3_component_of_the_moment():
    M3, moment = closed_form_of("M3", "Mc")
    a3 = sp.Matrix([1, 0, 0]).cross(turn((1, 0, 0), -theta) * sp.Matrix([0, 1, 0]))
    assert is_zero(M3 - moment * (frame().T * a3)[2])


def test_energy_is_conserved_at_the_accelerations_of_the_code():
    rate = d_dt(sp.Matrix([kinetic() + potential()]))
    assert is_zero(rate.subs(dict(zip(accelerations, closed_form_of("theta_dd", "phi_dd"), strict=True))))


def test_the_moment_of_a_thin_rod_is_zero():
    assert is_zero(closed_form_of("Mc", "M3").subs({rod.I3: 0, rod.I2: rod.I1}))


@pytest.mark.parametrize("wrong", [-1, 2, sp.Rational(999, 1000)])
@pytest.mark.parametrize("row", range(6))
def test_a_wrong_sign_or_factor_is_seen(row, wrong):
    right = sp.Matrix([*closed_form_of("theta_dd", "phi_dd", "R1", "R2", "R3", "Mc")])
    right[row] *= wrong
    assert not is_zero(right - derived_newton_euler())
