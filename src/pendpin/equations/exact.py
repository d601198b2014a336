"""Exact motions of a pendulum under gravity, from Jacobi's elliptic functions at 100 digits.

A thin rod on a universal joint moves its direction like a point mass on a massless rod of the reduced length
(I1 + m h²) / (m h): for a uniform rod of length l that is 2 l / 3. Rates are those at t = 0; g in m/s².
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from mpmath import mp, mpf

from pendpin.ground.arrays import Array

Real = Any  # a number of mpmath, which gives no types
Vector = Any  # a column of them
Function = Callable[[Real], Real]

DIGITS = 100  # costs no more than 20; results keep at least 20, as a double root or a near miss of the pole may take 80
NO_SPIN = mpf("1e-40")  # of w: less angular momentum moves the mass out of its plane by less than 1e-20


def planar(angle0: float, rate0: float, reduced_length: float, g: float, t: Array) -> np.ndarray:
    """Angle from the downward vertical at times t, (n,) in rad, unwrapped; rate0 in rad/s."""
    with mp.workdps(DIGITS):
        angle = planar_at(angle0, rate0, mp.sqrt(mpf(g) / mpf(reduced_length)))
        return np.array([float(angle(mpf(float(x)))) for x in np.atleast_1d(t)])


def spherical(direction0: Array, rate0: Array, reduced_length: float, g: float, t: Array) -> np.ndarray:
    """Unit direction to the mass at times t, (n, 3) in W, z up; direction0 and rate0 (3,), 1/s, made unit and normal."""
    with mp.workdps(DIGITS):
        direction = spherical_at(direction0, rate0, mp.sqrt(mpf(g) / mpf(reduced_length)))
        return np.array([[float(x) for x in direction(mpf(float(x)))] for x in np.atleast_1d(t)])


def direction(q: Array) -> np.ndarray:
    """The rod's direction in W, (..., 3), from pendpin's angles (..., 2)."""
    s_t, s, c_t, c = _sines(q)
    return np.stack([s, -s_t * c, -c_t * c], -1)


def direction_rate(q: Array, v: Array) -> np.ndarray:
    """Its derivative, (..., 3) in 1/s, from angles and rates (..., 2)."""
    s_t, s, c_t, c = _sines(q)
    dt, dp = np.moveaxis(np.asarray(v, float), -1, 0)
    return np.stack([c * dp, s_t * s * dp - c_t * c * dt, c_t * s * dp + s_t * c * dt], -1)


def _sines(q: Array) -> tuple[np.ndarray, ...]:
    """sin(theta), sin(phi), cos(theta), cos(phi), each (...), of angles q (..., 2) in rad."""
    theta, phi = np.moveaxis(np.asarray(q, float), -1, 0)
    return np.sin(theta), np.sin(phi), np.cos(theta), np.cos(phi)


def planar_at(angle0: float, rate0: float, w: Real) -> Function:
    """x(t) with x'' = -w² sin(x), in mpmath numbers: sin(x/2) = k sn(w t + u0, k) where it swings, k < 1."""
    # k² = sin²(x0/2) + (x0' / 2w)² is the energy over that of rest upside down; above 1 the pendulum goes round.
    turns = mp.nint(mpf(angle0) / (2 * mp.pi))
    x0, v0 = mpf(angle0) - 2 * mp.pi * turns, mpf(rate0) / (2 * w)
    m, middle = mp.sin(x0 / 2) ** 2 + v0**2, 2 * mp.pi * turns
    if v0 == 0 and m in (0, 1):  # at rest, hanging or upside down
        return lambda t: middle + x0
    if m < 1:
        u0 = mp.ellipf(mp.atan2(mp.sin(x0 / 2), v0), m)
        return lambda t: middle + 2 * mp.asin(mp.sqrt(m) * mp.ellipfun("sn", w * t + u0, m=m))
    if m > 1:
        u0, rate = mp.ellipf(x0 / 2, 1 / m), mp.sign(v0) * mp.sqrt(m) * w
        return lambda t: middle + 2 * amplitude(rate * t + u0, 1 / m)
    u0 = mp.asinh(mp.tan(x0 / 2))  # exactly the energy of rest upside down, where it comes to rest after infinite time
    return lambda t: middle + 2 * mp.atan(mp.sinh(mp.sign(v0) * w * t + u0))


def amplitude(u: Real, m: Real) -> Real:
    """Jacobi's am(u), unwrapped: the inverse of ellipf(am, m)."""
    K = mp.ellipk(m)
    half_turns = mp.nint(u / (2 * K))
    u -= 2 * K * half_turns  # am lies within a quarter turn
    return mp.pi * half_turns + mp.asin(mp.ellipfun("sn", u, m=m))


def spherical_at(direction0: Array, rate0: Array, w: Real) -> Callable[[Real], Vector]:
    """The direction (3,) at a time, in mpmath numbers; w² = g / reduced length."""
    # Height and azimuth separate: z(t) from Jacobi's sn, the azimuth from integrals of the third kind. Without angular
    # momentum about the vertical it is the planar pendulum.
    d0, rate0 = mp.matrix([mpf(float(x)) for x in direction0]), mp.matrix([mpf(float(x)) for x in rate0])
    d0 /= mp.norm(d0)
    rate0 -= mp.fdot(d0, rate0) * d0
    spin = d0[0] * rate0[1] - d0[1] * rate0[0]
    return _planar_direction(d0, rate0, w) if abs(spin) < NO_SPIN * w else _round_the_vertical(d0, rate0, w)


def _planar_direction(d0: Vector, rate0: Vector, w: Real) -> Callable[[Real], Vector]:
    away = d0 if d0[0] or d0[1] else rate0  # gives the plane
    length = mp.hypot(away[0], away[1]) or mpf(1)
    ex, ey = away[0] / length, away[1] / length
    out = d0[0] * ex + d0[1] * ey
    rate = -(rate0[0] * ex + rate0[1] * ey) * d0[2] + rate0[2] * out
    angle = planar_at(mp.atan2(out, -d0[2]), rate, w)

    def at(t: Real) -> Vector:
        x = angle(t)
        return mp.matrix([mp.sin(x) * ex, mp.sin(x) * ey, -mp.cos(x)])

    return at


def _round_the_vertical(d0: Vector, rate0: Vector, w: Real) -> Callable[[Real], Vector]:
    """z = z1 + (z2 - z1) sn², and the azimuth from h = (1 - z²) azimuth'."""
    h = d0[0] * rate0[1] - d0[1] * rate0[0]
    z1, z2, z3 = turning_heights(mp.fdot(rate0, rate0) / 2 + w**2 * d0[2], h, w)
    m, speed = (z2 - z1) / (z3 - z1), w * mp.sqrt((z3 - z1) / 2)
    low, high = (mp.sqrt(max(x, mpf(0))) for x in (d0[2] - z1, z2 - d0[2]))
    am0 = mp.atan2(low, high if rate0[2] >= 0 else -high)
    swept = azimuth_integral(z1, z2, m)
    u0, azimuth0 = mp.ellipf(am0, m), mp.atan2(d0[1], d0[0]) - h / speed * swept(am0)

    def at(t: Real) -> Vector:
        am = amplitude(speed * t + u0, m)
        z = z1 + (z2 - z1) * mp.sin(am) ** 2
        azimuth, out = azimuth0 + h / speed * swept(am), mp.sqrt((1 - z) * (1 + z))
        return mp.matrix([out * mp.cos(azimuth), out * mp.sin(azimuth), z])

    return at


def azimuth_integral(z1: Real, z2: Real, m: Real) -> Function:
    """Integral of du / (1 - z²) with z = z1 + (z2 - z1) sn²(u, m), as a function of am(u), from 0."""

    def within_a_quarter_turn(am: Real) -> Real:
        above = mp.ellippi((z2 - z1) / (1 - z1), am, m) / (1 - z1)
        below = mp.ellippi((z1 - z2) / (1 + z1), am, m) / (1 + z1)
        return (above + below) / 2

    half_turn = 2 * within_a_quarter_turn(mp.pi / 2)

    def integral(am: Real) -> Real:
        half_turns = mp.nint(am / mp.pi)
        return half_turn * half_turns + within_a_quarter_turn(am - mp.pi * half_turns)

    return integral


def turning_heights(energy: Real, h: Real, w: Real) -> list[Real]:
    """The roots z1 <= z2 <= 1 <= z3 of z'² = 2 (energy - w² z)(1 - z²) - h², all real."""
    roots = mp.polyroots([2 * w**2, -2 * energy, -2 * w**2, 2 * energy - h**2], maxsteps=500, extraprec=500)
    return sorted(mp.re(root) for root in roots)
