"""Motion in a moving and turning world, computed in the inertial frame by formulas of its own.

In the inertial frame a point at r in W is at Q(t) (s(t) + r): s is the motion of the support, Q the rotation at the rate
Omega about an axis through the inertial origin. Nothing here knows of Coriolis or centrifugal forces.
"""

from collections.abc import Callable, Sequence

import numpy as np
import sympy as sp
from mpmath import mp, mpf
from scipy.integrate import solve_ivp

T = sp.Symbol("t")


def rotation(Omega: Sequence[float]) -> sp.Matrix:
    """Q(t), by Rodrigues' formula."""
    rate = sp.sqrt(sum(sp.Float(x, 30) ** 2 for x in Omega))
    if rate == 0:
        return sp.eye(3)
    x, y, z = (sp.Float(w, 30) / rate for w in Omega)
    K = sp.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return sp.eye(3) + sp.sin(rate * T) * K + (1 - sp.cos(rate * T)) * K * K


def sinusoid(amplitude: Sequence[float], frequency: float, phase: float) -> sp.Matrix:
    """s(t)."""
    return sp.Matrix([sp.Float(a, 30) for a in amplitude]) * sp.sin(frequency * T + phase)


def point_mass(Q: sp.Matrix, s: sp.Matrix, length: float, gravity: float, r0, v0, t: np.ndarray) -> np.ndarray:
    """Positions in W relative to the pivot, (n, 3), of a point mass on a massless rod; r0, v0 (3,) at t = 0, in W.

    Cartesian coordinates x in the inertial frame, x'' = g + lambda (x - p), |x - p| = length.
    """
    p, g = Q * s, Q * sp.Matrix([0, 0, -gravity])
    at = sp.lambdify(T, (p, p.diff(T), p.diff(T, 2), g, Q, Q.diff(T)))

    def known(time: float) -> list[np.ndarray]:
        return [np.array(x, float).squeeze() for x in at(time)]

    def derivative(time: float, y: np.ndarray) -> np.ndarray:
        p, dp, ddp, g, _, _ = known(time)
        d, dd = y[:3] - p, y[3:] - dp
        pull = -(d @ (g - ddp) + dd @ dd) / length**2
        return np.concatenate([y[3:], g + pull * d])

    p, dp, _, _, Q0, dQ0 = known(0.0)
    start = np.concatenate([p + Q0 @ r0, dp + dQ0 @ r0 + Q0 @ v0])
    found = solve_ivp(derivative, (0, t[-1]), start, "DOP853", t, rtol=1e-13, atol=1e-14)
    out = []
    for time, x in zip(t, found.y[:3].T, strict=True):
        p, _, _, _, Q, _ = known(time)
        out.append(Q.T @ (x - p))
    return np.array(out)


def rigid_rod(Q: sp.Matrix, s: sp.Matrix, inertia: Sequence, gravity: float, q0, v0, t: np.ndarray) -> np.ndarray:
    """theta, phi (n, 2) of a rod by d'Alembert's principle: m (r'' - g) . dr + H' . dturn = 0, in the inertial frame.

    inertia is m, h, I1, I2, I3, the last three about the centre of mass; q0, v0 (2,) at t = 0.
    """
    m, h, *principal = inertia
    theta, phi, *rates = sp.symbols("theta phi dtheta dphi a b")
    B = Q * _frame(sp, theta, phi)
    r = Q * s + h * B[:, 2]

    def rate(x: sp.Matrix) -> sp.Matrix:
        """d/dt, with a, b for the second derivatives."""
        by = zip((theta, phi, *rates[:2]), rates, strict=True)
        return sum((x.diff(symbol) * speed for symbol, speed in by), x.diff(T))

    spin = B.T * rate(B)
    H = B * sp.diag(*principal) * sp.Matrix([spin[2, 1], spin[0, 2], spin[1, 0]])
    turns = [x.diff(angle) * B.T for x, angle in ((B, theta), (B, phi))]
    turns = [sp.Matrix([x[2, 1], x[0, 2], x[1, 0]]) for x in turns]
    force = m * (rate(rate(r)) - Q * sp.Matrix([0, 0, -gravity]))
    at = sp.lambdify((T, theta, phi, *rates), (force, rate(H), r.diff(theta), r.diff(phi), *turns), cse=True)

    def left(*state: float) -> np.ndarray:
        force, moment, *ways = (np.array(x, float)[:, 0] for x in at(*state))
        return np.array([force @ ways[k] + moment @ ways[2 + k] for k in (0, 1)])

    def derivative(time: float, y: np.ndarray) -> np.ndarray:
        rest = left(time, *y, 0.0, 0.0)
        M = np.stack([left(time, *y, *unit) - rest for unit in np.eye(2)], -1)
        return np.concatenate([y[2:], -np.linalg.solve(M, rest)])

    return solve_ivp(derivative, (0, t[-1]), [*q0, *v0], "DOP853", t, rtol=1e-13, atol=1e-14).y[:2].T


def _frame(xp, theta, phi):
    """b1, b2, b3 as columns, in W: theta clockwise about x, then phi about the turned y, b3 down at zero angles."""
    matrix = xp.Matrix if xp is sp else mp.matrix
    s_t, c_t, s, c = xp.sin(theta), xp.cos(theta), xp.sin(phi), xp.cos(phi)
    return matrix([[c, 0, s], [s_t * s, -c_t, -s_t * c], [c_t * s, s_t, -c_t * c]])


Path = Callable[[mpf], list[tuple[mp.matrix, mp.matrix]]]


def residual(Q: sp.Matrix, s: sp.Matrix, rods: Sequence, gravity: float, t: float, q, v, a) -> tuple:
    """What is left of d'Alembert's principle for a chain: sum of (m (r'' - g) . dr + H' . dturn), for each joint.

    rods has m, h, I1, I2, I3, length; q, v, a are (n, 2). Returns that and the sum of the sizes of its terms, (2 n,).
    Every derivative is a central difference, at 60 digits.
    """
    with mp.workdps(60):
        time, step = mpf(t), mpf("1e-15")
        Q, s = sp.lambdify(T, Q, "mpmath"), sp.lambdify(T, s, "mpmath")
        q, v, a = (np.vectorize(lambda x: mpf(float(x)), otypes=[object])(x) for x in (q, v, a))

        def moving(tau: mpf) -> list[tuple[mp.matrix, mp.matrix]]:
            return _bodies(Q(time + tau), s(time + tau), rods, q + v * tau + a * tau**2 / 2)

        before, now, after = (moving(k * step) for k in (-1, 0, 1))
        g = Q(time) * mp.matrix([0, 0, -mpf(gravity)])
        paths = zip(rods, before, now, after, strict=True)
        forces = [rod[0] * ((y[1] - 2 * n[1] + x[1]) / step**2 - g) for rod, x, n, y in paths]
        early, late = (_momenta(moving, k * step, step, rods) for k in (-1, 1))
        moments = [(y - x) / (2 * step) for x, y in zip(early, late, strict=True)]
        total, sizes = [], []
        for joint in np.ndindex(*q.shape):
            terms = _virtual(Q(time), s(time), rods, q, joint, step, forces, moments, now)
            total.append(mp.fsum(terms))
            sizes.append(mp.fsum(abs(x) for x in terms))
        return np.array(total, float), np.array(sizes, float)


def _bodies(Q, s, rods, q) -> list[tuple[mp.matrix, mp.matrix]]:
    """Frame and centre of mass of each rod in the inertial frame."""
    out, joint, above = [], Q * s, Q * mp.diag([1, -1, -1])
    for (_, h, _, _, _, length), (theta, phi) in zip(rods, q, strict=True):
        B = above * mp.diag([1, -1, -1]) * _frame(mp, theta, phi)
        out.append((B, joint + h * B[:, 2]))
        joint, above = joint + length * B[:, 2], B
    return out


def _turn(before: mp.matrix, now: mp.matrix, after: mp.matrix, step: mpf) -> mp.matrix:
    """Angular velocity from three frames, in the inertial frame."""
    W = (after - before) / (2 * step) * now.T
    return mp.matrix([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]]) / 2


def _momenta(moving: Path, tau: mpf, step: mpf, rods) -> list[mp.matrix]:
    """Angular momentum of each rod about its centre of mass."""
    before, now, after = (moving(tau + k * step) for k in (-1, 0, 1))
    out = []
    for rod, x, n, y in zip(rods, before, now, after, strict=True):
        B = n[0]
        inertia = mp.diag([mpf(float(principal)) for principal in rod[2:5]])
        out.append(B * inertia * (B.T * _turn(x[0], B, y[0], step)))
    return out


def _virtual(Q, s, rods, q, joint, step, forces, moments, now) -> list[mpf]:
    ends = []
    for sign in (-1, 1):
        moved = q.copy()
        moved[joint] += sign * step
        ends.append(_bodies(Q, s, rods, moved))
    terms = []
    for force, moment, x, n, y in zip(forces, moments, *(ends[:1]), now, *(ends[1:]), strict=True):
        dr, turn = (y[1] - x[1]) / (2 * step), _turn(x[0], n[0], y[0], step)
        terms += [(force.T * dr)[0], (moment.T * turn)[0]]
    return terms
