"""The exact solutions of equations/exact.py: their own differential equations and invariants, and published values."""

import numpy as np
import pytest
from mpmath import mp, mpf

from pendpin.equations import balances, newton_euler
from pendpin.equations.base import RodInertia
from pendpin.equations.exact import (
    DIGITS,
    direction,
    direction_rate,
    planar,
    planar_at,
    spherical,
    spherical_at,
    turning_heights,
)

G = 9.81  # m/s²
TIMES = [0.0, 0.37, 4.1, 100.0]  # s


@pytest.fixture(autouse=True)
def _digits():
    """Everything here at the digits that the solutions are computed with."""
    with mp.workdps(DIGITS):
        yield


# --- in a plane -----------------------------------------------------------------------------------------------------

SWINGING = [(0.7, 1.3), (-1.2, 0.0), (3.1, 0.0), (0.0, -5.0), (7.0, 0.4), (-20.0, 1.0), (1e-6, 0.0)]
ROUND = [(0.0, 7.0), (1.0, -9.0), (-8.0, 6.9), (3.0, 0.9), (np.pi, 1e-6), (0.3, 200.0)]


def derivatives(x, t):
    """x and its first two derivatives at t by central differences, which at 100 digits are good to 1e-30 relative."""
    h = mpf("1e-15")
    before, now, after = (x(mpf(t) + k * h) for k in (-1, 0, 1))
    return now, (after - before) / (2 * h), (after - 2 * now + before) / h**2


@pytest.mark.parametrize(("angle0", "rate0"), [*SWINGING, *ROUND])
class TestPlanar:
    """x'' = -w² sin(x) with the given start; that has one solution, so this is it."""

    w = mp.sqrt(mpf(G))

    def test_starts_where_it_should(self, angle0, rate0):
        x, rate, _ = derivatives(planar_at(angle0, rate0, self.w), 0)
        assert abs(x - angle0) < 1e-40
        assert abs(rate - rate0) < 1e-20 * (1 + abs(rate0))

    @pytest.mark.parametrize("t", TIMES)
    def test_keeps_the_differential_equation_and_its_energy(self, angle0, rate0, t):
        x, rate, acceleration = derivatives(planar_at(angle0, rate0, self.w), t)
        size = 1 + mpf(rate0) ** 2
        start = mpf(rate0) ** 2 / 2 - self.w**2 * mp.cos(angle0)
        assert abs(acceleration + self.w**2 * mp.sin(x)) < 1e-20 * size
        assert abs(rate**2 / 2 - self.w**2 * mp.cos(x) - start) < 1e-20 * size


@pytest.mark.parametrize(("angle0", "rate0"), ROUND)
def test_a_pendulum_that_goes_round_never_turns_back(angle0, rate0):
    x = planar(angle0, rate0, 1.0, G, np.linspace(0, 20, 150))
    assert np.all(np.diff(x) * np.sign(rate0) > 0)


def test_planar_period():
    """The period of a uniform thin rod of 1 m: 4 sqrt(2 l / 3 g) K(k²), k = sin(x0 / 2)."""
    x0 = 2.0
    period = 4 * mp.sqrt(mpf(2) / 3 / mpf(G)) * mp.ellipk(mp.sin(mpf(x0) / 2) ** 2)
    x = planar_at(x0, 0.0, mp.sqrt(mpf(G) * 3 / 2))
    assert abs(x(period) - x0) < 1e-35
    assert abs(x(period / 2) + x0) < 1e-35
    assert abs(x(period / 4)) < 1e-35


def test_planar_with_exactly_the_energy_of_rest_upside_down():
    """Then sin(x / 2) = tanh(w t): the pendulum nears the top for ever."""
    x = planar_at(0.0, mpf(6), mpf(3))
    for t in map(mpf, (0.0, 0.1, 1.0, 5.0)):
        assert abs(mp.sin(x(t) / 2) - mp.tanh(3 * t)) < 1e-80
    rest = planar_at(0.0, 0.0, mpf(3))
    assert rest(mpf(5)) == 0


def test_planar_next_to_that_energy():
    """On both sides of it the motion is that of the limit, to the difference in energy and its growth exp(3 t)."""
    limit = planar_at(0.0, mpf(6), mpf(3))
    for off in (-(mpf(10) ** -30), mpf(10) ** -30):
        x = planar_at(0.0, 6 + off, mpf(3))
        assert abs(x(mpf(2)) - limit(mpf(2))) < 1e3 * abs(off)


@pytest.mark.parametrize(
    ("t", "x", "y", "digits"), [(10, 0.275087462576, -0.961419205099, 12), (2000, -0.8146030686, -0.5800188278, 10)]
)
def test_iftomm_benchmark_A01(t, x, y, digits):
    """Simple pendulum, 1 m, 9.81 m/s², from rest at x = +1: published positions."""
    angle = planar(np.pi / 2, 0.0, 1.0, G, [t])[0]
    np.testing.assert_allclose((np.sin(angle), -np.cos(angle)), (x, y), rtol=0, atol=0.6 * 10.0**-digits)


# --- on the sphere --------------------------------------------------------------------------------------------------

STARTS = {
    "published": ([np.sin(1), 0, -np.cos(1)], [0, 2 * np.sin(1), 0]),
    "built-in rod": (direction([0.7, 0.4]), direction_rate([0.7, 0.4], [1.3, -0.8])),
    "clockwise": ([0.6, 0.0, -0.8], [0.4, -1.0, 0.3]),
    "high": ([0.6, 0.0, 0.8], [0.8, 0.9, -0.6]),
    "fast": ([0.0, 1.0, 0.0], [30.0, 0.0, 20.0]),
    "nearly planar": ([0.6, 0.0, -0.8], [0.4, 1e-7, 0.3]),
    "planar": ([0.36, 0.48, -0.8], [0.0, 0.0, 0.0]),
    "planar through the top": ([0.0, 0.0, 1.0], [1.0, 2.0, 0.0]),
    "small": ([1e-4, 0.0, -1.0], [0.0, 1e-4, 0.0]),
}
PARAMETERS = pytest.mark.parametrize(("d0", "rate0"), STARTS.values(), ids=STARTS)


def on_the_sphere(d0, rate0):
    """The start that is really taken, in full digits."""
    d0, rate0 = (np.array([mpf(float(x)) for x in part]) for part in (d0, rate0))
    d0 = d0 / mp.sqrt(d0 @ d0)
    return d0, rate0 - (d0 @ rate0) * d0


def motion(d0, rate0, t):
    """Direction, rate and acceleration at t, each (3,), in full digits."""
    at = spherical_at(d0, rate0, mp.sqrt(mpf(G)))
    return derivatives(lambda t: np.array(list(at(t))), t)


@PARAMETERS
class TestSpherical:
    """d'' = -w² (z - (z . d) d) - |d'|² d with the given start; that has one solution, so this is it."""

    def test_starts_where_it_should(self, d0, rate0):
        start, start_rate = on_the_sphere(d0, rate0)
        d, rate, _ = motion(d0, rate0, 0)
        assert max(abs(d - start)) < 1e-40
        assert max(abs(rate - start_rate)) < 1e-20 * (1 + start_rate @ start_rate)

    @pytest.mark.parametrize("t", TIMES[1:])
    def test_keeps_the_differential_equation_and_its_invariants(self, d0, rate0, t):
        start, start_rate = on_the_sphere(d0, rate0)
        d, v, a = motion(d0, rate0, t)
        up, w2, size = np.array([0, 0, 1]), mpf(G), 1 + start_rate @ start_rate
        assert abs(d @ d - 1) < 1e-80
        assert max(abs(a + w2 * (up - d[2] * d) + (v @ v) * d)) < 1e-18 * size
        assert abs(v @ v / 2 + w2 * d[2] - start_rate @ start_rate / 2 - w2 * start[2]) < 1e-18 * size
        assert abs(d[0] * v[1] - d[1] * v[0] - start[0] * start_rate[1] + start[1] * start_rate[0]) < 1e-18 * size


def test_spherical_published_values():
    d0, rate0 = STARTS["published"]
    np.testing.assert_allclose(spherical(d0, rate0, 1.0, G, [10.0])[0, 2], -0.772233237407, rtol=0, atol=1e-12)
    w, z0 = mp.sqrt(mpf(G)), -mp.cos(1)
    z1, z2, z3 = turning_heights(2 * mp.sin(1) ** 2 + w**2 * z0, 2 * mp.sin(1) ** 2, w)
    period = 2 * mp.ellipk((z2 - z1) / (z3 - z1)) / (w * mp.sqrt((z3 - z1) / 2))
    assert abs(period - mpf("1.074123027229")) < 1e-12
    heights = spherical(d0, rate0, 1.0, G, [1.3, 1.3 + float(period), 1.3 + 20 * float(period)])[:, 2]
    np.testing.assert_allclose(heights, heights[0], rtol=0, atol=1e-13)


@pytest.mark.parametrize("inclination", [0.1, 1.0, 1.5])
def test_conical_motion(inclination):
    """At rate² = g / (l cos(inclination)) the direction goes round a cone; doubles miss that start by a rounding."""
    rate = np.sqrt(G / (0.7 * np.cos(inclination)))
    s, c, t = np.sin(inclination), np.cos(inclination), np.array([0.4, 3.0, 20.0])
    d = spherical([s, 0, -c], [0, rate * s, 0], 0.7, G, t)
    expected = np.stack([s * np.cos(rate * t), s * np.sin(rate * t), np.full(3, -c)], -1)
    assert np.max(np.abs(d - expected) / (1 + rate * t[:, None])) < 1e-15


@pytest.mark.parametrize(
    "azimuth", [2.0, *(pytest.param(along, marks=pytest.mark.slow) for along in (0.0, -np.pi / 2))]
)
def test_without_spin_it_is_the_planar_pendulum(azimuth):
    """Also for a start whose rounded spin is not zero: the bob then passes the bottom very close."""
    t, out = np.linspace(0, 5, 20), np.array([np.cos(azimuth), np.sin(azimuth)])
    angle = planar(2.0, 0.3, 1.0, G, t)
    d = spherical([*np.sin(2.0) * out, -np.cos(2.0)], [*0.3 * np.cos(2.0) * out, 0.3 * np.sin(2.0)], 1.0, G, t)
    np.testing.assert_allclose(d[:, :2], np.sin(angle)[:, None] * out, rtol=0, atol=3e-14)
    np.testing.assert_allclose(d[:, 2], -np.cos(angle), rtol=0, atol=3e-14)


def test_a_longer_pendulum_is_a_slower_one():
    d0, rate0 = STARTS["published"]
    t = np.array([0.5, 2.0, 7.0])
    slow = spherical(d0, np.array(rate0) / 2, 4.0, G, 2 * t)
    np.testing.assert_allclose(slow, spherical(d0, rate0, 1.0, G, t), rtol=0, atol=1e-15)


# --- the rod --------------------------------------------------------------------------------------------------------


def test_direction_is_the_rod_and_its_rate_the_derivative():
    random = np.random.default_rng(0)
    q, v = random.uniform(-3, 3, (50, 2)), random.uniform(-9, 9, (50, 2))
    np.testing.assert_allclose(direction(q), balances.frames(q)[..., 2] * [1, -1, -1], rtol=0, atol=1e-15)
    h = 1e-6
    slope = (direction(q + h * v) - direction(q - h * v)) / (2 * h)
    np.testing.assert_allclose(direction_rate(q, v), slope, rtol=0, atol=1e-8)


def test_a_thin_rod_accelerates_like_the_point_mass_at_its_reduced_length():
    """d'' at the start from the exact solution, and from theta'', phi'' of the closed form; also for a payload."""
    rod = RodInertia(2.3, 0.6, 0.21, 0.21, 0.0)
    q, v = np.array([0.7, 0.4]), np.array([1.3, -0.8])
    a = newton_euler.solve(rod, q, v, np.array([0, 0, G]))
    accelerations = np.array([a.theta_dd, a.phi_dd])
    at = spherical_at(direction(q), direction_rate(q, v), mp.sqrt(mpf(rod.m * rod.h * G / (rod.I1 + rod.m * rod.h**2))))
    _, _, found = derivatives(lambda t: np.array(list(at(t))), 0)
    h = 1e-5
    after, before = (direction_rate(q + v * t, v + accelerations * t) for t in (h, -h))
    np.testing.assert_allclose(found.astype(float), (after - before) / (2 * h), rtol=0, atol=2e-8)
