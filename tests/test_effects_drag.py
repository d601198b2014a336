"""Air drag against its closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from effect_cases import on_both, planar, states
from laws import law
from pendpin import effects as fx
from pendpin.effects.drag import _speed_moments
from test_effects import largest, random_motion

# --- drag, in closed form -------------------------------------------------------------------------------------------


def test_linear_drag_is_a_viscous_joint_for_one_rod() -> None:
    """A rod turning in theta: the moment of linear drag is -linear l³/3 theta'."""
    rod = pp.Chain(rods=(pp.Rod(length=1.3, mass=1.0, radius=0.05),))
    t, q, v = states(2)
    q[:, 1] = v[:, 1] = 0
    drag = on_both(rod, (fx.Drag(coefficient=0, linear=0.4),), t, q, v)[0]
    joint = on_both(rod, (fx.Viscous(coefficient=0.4 * 1.3**3 / 3, joints=("theta",)),), t, q, v)[0]
    assert largest(drag - joint) < 1e-14


@law(100)
@given(
    st.floats(-3, 3),
    st.floats(-2, 2).map(lambda x: 10**x),
    st.sampled_from([-1.0, 1.0]),
    st.tuples(*[st.floats(-1, 1)] * 2),
)
def test_moments_of_a_flow_in_a_line_are_exact(where: float, slope: float, sign: float, turned: tuple) -> None:
    """Of |a + b s| over a rod: polynomials on either side of where it is 0, if that is on the rod; in any direction."""
    direction = np.array(
        [[np.cos(turned[0]) * np.cos(turned[1]), np.sin(turned[0]), np.cos(turned[0]) * np.sin(turned[1])]]
    )
    a, b = -sign * slope * where, sign * slope
    found = _speed_moments(a * direction, b * direction, np)

    def signed(n: int, low: float, high: float) -> float:
        return abs(sum(c * (high**k - low**k) / k for c, k in ((a, n + 1), (b, n + 2))))

    cut = min(max(where, 0.0), 1.0)
    for n, moment in enumerate(found):
        exact = signed(n, 0.0, cut) + signed(n, cut, 1.0)
        assert moment.item() == pytest.approx(exact, rel=1e-12, abs=1e-14 * (abs(a) + abs(b)))


def test_the_gauss_points_meet_a_rounded_kink() -> None:
    """Force and moment against adaptive quadrature, with the flow turning round along the rod: within 2e-6."""
    from scipy.integrate import quad

    drag, worst = fx.Drag(density=2.0, coefficient=1.0, diameter=1.0), 0.0
    for aside in (0.0, 1e-3, 1e-2, 0.05, 0.2, 1.0):
        bodies = random_motion(1)[0]._replace(com=np.zeros((1, 3)), tip=np.array([[0, 0, -1.0]]))
        flat = [np.zeros((1, 3)), np.eye(3)[None], np.array([[-0.3, aside, 7.0]]), np.array([[0, -1.0, 0.5]])]
        force, moment = drag.wrench(0.0, bodies, fx.Motion(*flat))

        def pull(s: float, power: int, axis: int, y: float = aside) -> float:
            return -(s**power) * np.hypot(s - 0.3, y) * (s - 0.3, y)[axis]

        expected = [quad(pull, 0, 1, args, points=[0.3], epsabs=1e-13)[0] for args in np.ndindex(2, 2)]
        found = [force[0, 0], force[0, 1], -moment[0, 1], moment[0, 0]]
        worst = max(worst, largest(np.subtract(found, expected)) / largest(np.array(expected)))
    assert worst < 2e-6


def test_quadratic_drag_in_still_air() -> None:
    """A rod turning in theta without gravity: theta' = theta0' / (1 + k theta0' t), k = rho C D l⁴ / 8 J."""
    rod = pp.Rod(length=1.2, mass=0.8, radius=0.03)
    drag = fx.Drag(density=1.2, coefficient=1.1)
    run = planar((drag,), rod, (0.2, 5.0), 4.0)
    J = 0.8 * ((3 * 0.03**2 + 1.2**2) / 12 + 0.36)
    k = 1.2 * 1.1 * 0.06 * 1.2**4 / (8 * J)
    assert largest(run.v[:, 0] - 5.0 / (1 + 5.0 * k * run.t)) < 1e-11
    assert largest(run.q[:, 0] - 0.2 - np.log1p(5.0 * k * run.t) / k) < 1e-11
