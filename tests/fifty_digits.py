"""Chains to test with, and the reference_route of the chain equations: the ten balances of every rod, solved in 50 digits.

Written in the inertial frame I with nothing eliminated beforehand, so that it shares no step with what it checks.
"""

from itertools import pairwise

import mpmath as mp
import numpy as np

from pendpin.equations.chain.kinematics import ChainInertia

G = np.array([0.0, 0.0, 9.81])  # m/s², in I
TILTED = np.array([0.4, -0.3, 9.7])  # m/s²


def rods(m, length, radius):
    J = m * (3 * radius**2 + length**2) / 12
    return ChainInertia(m, length / 2, length, J, J, m * radius**2 / 2)


def alike(n, radius):
    return rods(np.ones(n), np.ones(n), np.full(n, radius))


def mixed(n, rng, thin=0.0):
    """Masses over four decades, lengths over three, radii down to a thousandth of the length, some rods thin."""
    length = 10 ** rng.uniform(-2, 1, n)
    radius = length * 10 ** rng.uniform(-3, 0, n) * (rng.uniform(size=n) >= thin)
    return rods(10 ** rng.uniform(-2, 2, n), length, radius)


def thin_tail(n, rng):
    return rods(10 ** rng.uniform(-1, 1, n), 10 ** rng.uniform(-1, 1, n), np.where(np.arange(n) < n // 2, 0.05, 0.0))


def point_masses(n, rng):
    zero, length = np.zeros(n), 10 ** rng.uniform(-1, 1, n)
    return ChainInertia(10 ** rng.uniform(-1, 1, n), length, length, zero, zero, zero)


def state(n, rng, reach=1.2):
    return rng.uniform(-reach, reach, (n, 2)), rng.normal(size=(n, 2))


KINDS = {
    "ordinary": lambda n, rng: alike(n, 1.0),
    "slender": lambda n, rng: alike(n, 0.01),
    "mixed": mixed,
    "thin among mixed": lambda n, rng: mixed(n, rng, thin=0.5),
    "thin above thick": lambda n, rng: rods(np.ones(n), np.ones(n), np.where(np.arange(n) < n - 1, 0.0, 0.05)),
    "thin tail": thin_tail,
    "all thin": lambda n, rng: alike(n, 0.0),
    "point masses": point_masses,
}


def vector(x):
    return mp.matrix([mp.mpf(float(t)) for t in x])


def cross(a, b):
    return mp.matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def tilde(a):
    return mp.matrix([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def fifty_digit_frames(q, v):
    """Per rod: axes b (columns), a1, omega, and the part of alpha - alpha_above that the rates alone cause."""
    B, omega, out = mp.eye(3), mp.zeros(3, 1), []
    for (theta, phi), (theta_d, phi_d) in zip(q, v, strict=True):
        theta, phi, theta_d, phi_d = (mp.mpf(float(x)) for x in (theta, phi, theta_d, phi_d))
        s_t, c_t, s, c = mp.sin(theta), mp.cos(theta), mp.sin(phi), mp.cos(phi)
        a1, omega_above = B[:, 0], omega
        B = B * mp.matrix([[c, 0, s], [-s_t * s, c_t, s_t * c], [-c_t * s, -s_t, c_t * c]])
        omega = omega_above - theta_d * a1 + phi_d * B[:, 1]
        bias = -theta_d * cross(omega_above, a1) + phi_d * cross(omega, B[:, 1])
        out.append((B, a1, omega, bias))
    return out


def fifty_digits(rods, q, v, field, torque=None, force=None, moment=None):
    """theta'', phi'' (n, 2), F (n, 3) in B and Mc (n,), as arrays of mpmath numbers."""
    with mp.workdps(50):
        n, frames, rows = rods.n, fifty_digit_frames(q, v), []
        for i in range(n):
            rows += joint_rows(rods, frames, i, vector(field)) + rod_rows(rods, frames, i, torque, force, moment)
        x = eliminate(rows, 10 * n)
        F = [[dot(frames[i][0][:, k], x[10 * i : 10 * i + 3]) for k in range(3)] for i in range(n)]
        Mc = [x[10 * i + 3] for i in range(n)]
        alpha = [mp.zeros(3, 1)] + [mp.matrix(x[10 * i + 4 : 10 * i + 7]) for i in range(n)]
        relative = [b - a - frame[3] for (a, b), frame in zip(pairwise(alpha), frames, strict=True)]
        a = [[-dot(r, frame[1]), dot(r, frame[0][:, 1])] for r, frame in zip(relative, frames, strict=True)]
        return np.array(a), np.array(F), np.array(Mc)


def joint_rows(rods, frames, i, field):
    """Base of rod i and tip of rod i - 1 accelerate alike; the relative turning has no part along a3."""
    B, a1, omega, bias = frames[i]
    h, a3 = mp.mpf(rods.h[i]), cross(a1, B[:, 1])
    down = tilde(h * B[:, 2])
    known = h * cross(omega, cross(omega, B[:, 2]))
    rows = [{10 * i + 7 + k: mp.mpf(1), **{10 * i + 4 + j: down[k, j] for j in range(3)}} for k in range(3)]
    twist = {10 * i + 4 + j: a3[j] for j in range(3)}
    if i:
        k_above, (C, _, w, _) = mp.mpf(rods.l[i - 1]) - mp.mpf(rods.h[i - 1]), frames[i - 1]
        known += k_above * cross(w, cross(w, C[:, 2]))
        up = tilde(k_above * C[:, 2])
        for k in range(3):
            rows[k] |= {10 * i - 3 + k: mp.mpf(-1)} | {10 * i - 6 + j: up[k, j] for j in range(3)}
        twist |= {10 * i - 6 + j: -a3[j] for j in range(3)}
    else:
        known -= field
    return [(rows[k], known[k]) for k in range(3)] + [(twist, dot(bias, a3))]


def rod_rows(rods, frames, i, torque, force, moment):
    """Moment about G and force on rod i, accelerations relative to the field."""
    B, _, omega, _ = frames[i]
    m, h, k = mp.mpf(rods.m[i]), mp.mpf(rods.h[i]), mp.mpf(rods.l[i]) - mp.mpf(rods.h[i])
    inertia = B * mp.diag([mp.mpf(x[i]) for x in (rods.I1, rods.I2, rods.I3)]) * B.T
    known = -cross(omega, inertia * omega) + (vector(moment[i]) if moment is not None else mp.zeros(3, 1))
    turning = [{10 * i + 4 + j: inertia[r, j] for j in range(3)} for r in range(3)]
    moving = [{10 * i + 7 + r: m} for r in range(3)]
    for joint, sign, lever in ((i, 1, -h), (i + 1, -1, k)):
        if joint == rods.n:
            continue
        C, a1, _, _ = frames[joint]
        arm, a3 = tilde(lever * B[:, 2]), cross(a1, C[:, 1])
        for r in range(3):
            turning[r] |= {10 * joint + j: -sign * arm[r, j] for j in range(3)} | {10 * joint + 3: -sign * a3[r]}
            moving[r][10 * joint + r] = mp.mpf(-sign)
        if torque is not None:
            known += sign * (C[:, 1] * float(torque[joint][1]) - a1 * float(torque[joint][0]))
    push = vector(force[i]) if force is not None else mp.zeros(3, 1)
    return [(turning[r], known[r]) for r in range(3)] + [(moving[r], push[r]) for r in range(3)]


def eliminate(rows, size, reach=24):
    """Gauss with row pivoting on rows ({column: value}, right-hand side) whose entries lie near the diagonal."""
    rows = list(rows)
    for p in range(size):
        best = max(range(p, min(size, p + reach)), key=lambda r: abs(rows[r][0].get(p, 0)))
        rows[p], rows[best] = rows[best], rows[p]
        pivot, rhs = rows[p]
        for r in range(p + 1, min(size, p + reach)):
            row, other = rows[r]
            if factor := row.pop(p, 0) / pivot[p]:
                for column, value in pivot.items():
                    if column != p:
                        row[column] = row.get(column, 0) - factor * value
                rows[r] = row, other - factor * rhs
    x = [mp.mpf(0)] * size
    for p in reversed(range(size)):
        row, rhs = rows[p]
        x[p] = (rhs - sum(value * x[column] for column, value in row.items() if column != p)) / row[p]
    return x


def error(x, exact):
    """Largest error beside the largest value; absolute where all is 0."""
    with mp.workdps(50):
        difference = max(abs(mp.mpf(float(a)) - b) for a, b in zip(np.ravel(x), np.ravel(exact), strict=True))
        scale = max(abs(b) for b in np.ravel(exact))
        return float(difference / scale) if scale > 1e-30 else float(difference)
