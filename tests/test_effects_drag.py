"""Air drag against its closed forms."""

import mpmath
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import pendpin as pp
from effect_cases import on_both, planar, states
from laws import law
from pendpin import effects as fx
from pendpin.effects.drag import _speed_moments
from test_effects import largest

# --- drag, in closed form -------------------------------------------------------------------------------------------


def test_linear_drag_is_a_viscous_joint_for_one_rod() -> None:
    """A rod turning in theta: the moment of linear drag is -linear l³/3 theta'."""
    rod = pp.Chain(rods=(pp.Rod(length=1.3, mass=1.0, radius=0.05),))
    t, q, v = states(2)
    q[:, 1] = v[:, 1] = 0
    drag = on_both(rod, (fx.Drag(coefficient=0, linear=0.4),), t, q, v)[0]
    joint = on_both(rod, (fx.Viscous(coefficient=0.4 * 1.3**3 / 3, joints=("theta",)),), t, q, v)[0]
    assert largest(drag - joint) < 1e-14


@pytest.mark.parametrize("upper", [1.0, 0.4])
def test_a_hanging_chain_carries_the_linear_drag_of_a_cross_wind(upper: float) -> None:
    """Newton's law of all rods: the support's force and the wind's, linear W l on each, are what moves the centres."""
    rods, linear, wind = (
        (pp.Rod(length=upper, mass=1.0, radius=0.05), pp.Rod(length=0.7, mass=0.4, radius=0.02)),
        0.4,
        2.5,
    )
    drag = fx.Drag(coefficient=0, linear=linear, wind=(0.0, wind, 0.0))
    dynamics = pp.bind(pp.Scene(model=pp.Chain(rods=rods), effects=(fx.Gravity(), drag)))
    a, force = (
        dynamics.acceleration(0.0, np.zeros(4), np.zeros(4)),
        dynamics.wrenches(0.0, np.zeros(4), np.zeros(4))[0, :3],
    )
    ahead = -np.array([upper / 2 * a[0], upper * a[0] + 0.35 * (a[0] + a[2])])  # m/s², along y: theta is clockwise
    total = sum(rod.mass * y for rod, y in zip(rods, ahead, strict=True))
    assert force[1] + linear * wind * (upper + 0.7) == pytest.approx(total, rel=1e-12)
    assert force[2] == pytest.approx(1.4 * 9.81, rel=1e-12)


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


@law(25)
@given(
    where=st.floats(-0.5, 1.5),
    aside=st.floats(-12, 1).map(lambda x: 10**x),
    slope=st.floats(-6, 3).map(lambda x: 10**x),
    along=st.booleans(),
)
@example(where=0.3, aside=1e-2, slope=1.0, along=False)  # 2e-6 off by two dozen Gauss points
@example(where=0.0, aside=1e-12, slope=1.0, along=True)
def test_moments_of_a_flow_in_space_are_exact(where: float, aside: float, slope: float, along: bool) -> None:
    """The integrals of s^n |u| against quadrature in 30 digits, split finely where the flow turns round: to rounding."""
    u1 = slope * np.array([1.0, 0.0, 0.0])
    u0 = -where * u1 + slope * aside * np.array([float(along) / 3, 1.0, -0.5])
    with mpmath.workdps(30):
        rows = [[mpmath.mpf(float(x)) for x in u] for u in (u0, u1)]

        def speed(s):
            return mpmath.sqrt(sum((a + s * b) ** 2 for a, b in zip(*rows, strict=True)))

        least = where - aside * along / 3
        near = [least + sign * aside * 10**k for k in range(14) for sign in (-1, 1)]
        cuts = sorted({0, 1, *(x for x in [least, *near] if 0 < x < 1)})
        exact = [float(mpmath.quad(lambda s, n=n: s**n * speed(s), cuts)) for n in range(3)]
    found = [moment.item() for moment in _speed_moments(u0[None], u1[None], np)]
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-14 * exact[0])


@pytest.mark.parametrize(
    ("density", "wind"), [pytest.param(800.0, (1.0, 0.0, 0.0), marks=pytest.mark.slow), (300.0, (-0.4, 2.0, 1.0))]
)
def test_a_promise_holds_in_a_cross_wind(density: float, wind: tuple) -> None:
    """A driven rod in a liquid that flows across it, so that the flow turns round along the rod; in space.

    Against Lagrange's equations, written here with 300 Gauss points crowded where the flow is least, by SciPy at 1e-13.
    """
    rod, torque, spring, damper = pp.Rod(length=1.0, mass=3.0, radius=0.03), 300.0, 30.0, 0.1
    effects = (
        fx.Gravity(),
        fx.Motor(joint="theta", torque=torque),
        fx.Drag(density=density, wind=wind),
        fx.Spring(stiffness=spring, joints=("phi",)),
        fx.Viscous(coefficient=damper, joints=("phi",)),
    )
    start = pp.Start(positions={"phi": 0.3}, velocities={"theta": 10.0, "phi": -1.0})
    scene = pp.Scene(duration=2.0, model=pp.Chain(rods=(rod,)), start=start, effects=effects)
    run = pp.simulate(scene, accuracy=1e-10, samples=11)
    J, I3 = rod.properties.I1 + 3.0 * 0.25, rod.properties.I3
    x, weights = np.polynomial.legendre.leggauss(300)

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        b, v = y[1], y[2:]
        (sa, sb), (ca, cb) = np.sin(y[:2]), np.cos(y[:2])
        axes = np.array([[0.0, -ca * cb, sa * cb], [cb, sa * sb, ca * sb]])  # of the rod's direction, by both angles
        along = np.array([sb, -sa * cb, -ca * cb])
        across = np.array(wind) - along * (along @ wind)
        turning = v @ axes
        cut = min(max(turning @ across / (turning @ turning), 0.0), 1.0)
        pieces = [(cut * (1 - ((1 + x) / 2) ** 2), cut), (cut + (1 - cut) * ((1 + x) / 2) ** 2, 1 - cut)]
        load = np.zeros(2)
        for s, length in pieces:
            u = s[:, None] * turning - across
            pull = -density * 1.1 * 0.06 / 2 * np.linalg.norm(u, axis=1)[:, None] * u
            load += axes @ ((weights * (1 + x) / 2 * length * s) @ pull)
        gravity = -3.0 * 9.81 * 0.5 * np.array([sa * cb, ca * sb])
        load += [*gravity + np.array([torque, -spring * b - damper * v[1]])]
        M = J * cb**2 + I3 * sb**2
        twist = (J - I3) * cb * sb
        return np.array([*v, (load[0] + 2 * twist * v[0] * v[1]) / M, (load[1] - twist * v[0] ** 2) / J])

    y = np.concatenate([run.q[0], run.v[0]])
    exact = solve_ivp(rate, (0.0, 2.0), y, "DOP853", run.t, rtol=1e-13, atol=1e-13).y[:2].T
    tips = np.stack([np.sin(exact[:, 1]), *(-np.cos(exact[:, 1]) * f(exact[:, 0]) for f in (np.sin, np.cos))], -1)
    assert largest(run.tips[:, 0] - tips) <= run.stats.error + 1e-11


def test_quadratic_drag_in_still_air() -> None:
    """A rod turning in theta without gravity: theta' = theta0' / (1 + k theta0' t), k = rho C D l⁴ / 8 J."""
    rod = pp.Rod(length=1.2, mass=0.8, radius=0.03)
    drag = fx.Drag(density=1.2, coefficient=1.1)
    run = planar((drag,), rod, (0.2, 5.0), 4.0)
    J = 0.8 * ((3 * 0.03**2 + 1.2**2) / 12 + 0.36)
    k = 1.2 * 1.1 * 0.06 * 1.2**4 / (8 * J)
    assert largest(run.v[:, 0] - 5.0 / (1 + 5.0 * k * run.t)) < 1e-11
    assert largest(run.q[:, 0] - 0.2 - np.log1p(5.0 * k * run.t) / k) < 1e-11
