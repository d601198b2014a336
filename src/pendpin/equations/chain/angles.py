"""Angles, rates and accelerations of a chain from its directions (docs/derivation_chain.md, section 9)."""

from typing import NamedTuple

import numpy as np

from pendpin.arrays import Array, Mask

POLE = 1e-8  # |cos(phi)| below which theta, theta' follow from d', d''; above it from d, d'; the errors are equal there
RESTING = 1e-12  # of the rates of the rod and of the one above: a rod that passes a pole no faster rests there
PASS = 1e-6  # rad: a rod that comes so close to a pole passes through it
PARTS, REFINEMENTS = 8, 8  # of an interval that is too long, how often


class Reading(NamedTuple):
    """The angles of a run in directions."""

    q: Array  # (k, n, 2) rad, theta, phi, continuous from sample to sample
    v: Array  # (k, n, 2) rad/s
    a: Array  # (k, n, 2) rad/s²; theta'' is 0 where |cos(phi)| < POLE, for it has no value there


class _Turning(NamedTuple):
    """A rod's frame, angular velocity and acceleration, the latter two in that frame; samples last, for speed."""

    frame: Array  # (3, 3, k), columns b1, b2, b3 in I
    omega: Array  # (3, k)
    alpha: Array  # (3, k)


def read(d: Array, rate: Array, acceleration: Array, previous: Array | None = None) -> Reading:
    """Angles of samples d, d', d'' (k, n, 3), in I, rising in time; previous (n, 2) are the angles just before.

    Each rod's angles are relative to the frame of the rod above, which they build in turn. Of the two pairs that mean
    the same direction, (theta, phi) and (theta + pi, pi - phi), the one nearest to the sample before is taken; the very
    first sample, without previous, has |phi| <= pi/2.
    """
    k, n, _ = d.shape
    q, v, a = np.empty((k, n, 2)), np.empty((k, n, 2)), np.empty((k, n, 2))
    above = _Turning(np.broadcast_to(np.eye(3)[..., None], (3, 3, k)), np.zeros((3, k)), np.zeros((3, k)))
    for i in range(n):
        start = None if previous is None else previous[i]
        direction, speed, bend = (np.ascontiguousarray(x[:, i].T) for x in (d, rate, acceleration))
        pair = _angles(above, direction, speed, start)
        above, rates, accelerations = _rates(above, pair, speed, bend)
        q[:, i], v[:, i], a[:, i] = pair.T, rates.T, accelerations.T
    return Reading(q, v, a)


def unresolved(t: Array, reading: Reading) -> Mask:
    """The intervals (k - 1,) between samples at t (k,) in which a rod turns by over half its distance to a pole.

    In such an interval theta may change by any amount; more samples are needed.
    """
    across = np.abs(np.cos(reading.q[..., 1]))
    speed = np.hypot(reading.v[..., 1], reading.v[..., 0] * across)
    turn = np.maximum(speed[1:], speed[:-1]) * np.diff(t)[:, None]
    return np.asarray(((turn > np.minimum(across[1:], across[:-1]) / 2) & (turn > PASS)).any(1))


def refined(t: Array, d: Array, rate: Array, kept: Array, chosen: Mask) -> tuple[Array, Array, Array, Array]:
    """Samples at t (k,), with PARTS - 1 more in each chosen interval (k - 1,), and where those of `kept` are among them.

    d, d' (k, n, 3) are interpolated by a cubic on the sphere.
    """
    i, s = np.flatnonzero(chosen), (np.arange(1, PARTS) / PARTS)[:, None, None, None]
    h = (t[i + 1] - t[i])[:, None, None]
    d0, d1, r0, r1 = d[i], d[i + 1], h * rate[i], h * rate[i + 1]
    a, b = 3 * (d1 - d0) - 2 * r0 - r1, 2 * (d0 - d1) + r0 + r1
    more = d0 + s * (r0 + s * (a + s * b))  # (parts - 1, chosen, n, 3)
    slope = (r0 + s * (2 * a + 3 * s * b)) / h
    size = np.linalg.norm(more, axis=-1, keepdims=True)
    more, slope = more / size, slope / size
    slope = slope - more * (more * slope).sum(-1, keepdims=True)
    times = t[i] + s[..., 0, 0] * h[:, 0, 0]
    t, d, rate = (np.concatenate([x, y.reshape(-1, *x.shape[1:])]) for x, y in ((t, times), (d, more), (rate, slope)))
    order = np.argsort(t, kind="stable")
    return t[order], d[order], rate[order], np.argsort(order, kind="stable")[kept]


def _into(frames: Array, x: Array) -> Array:
    """Components of vectors (3, k) in frames (3, 3, k) whose columns are the axes."""
    return np.add.reduce(frames * x[:, None], 0)


def _angles(above: _Turning, d: Array, rate: Array, start: Array | None) -> Array:
    """theta, phi (2, k) of one rod over all samples, from d, d' (3, k)."""
    u = _into(above.frame, d)
    across = np.hypot(u[1], u[2])  # |cos(phi)|
    theta = np.arctan2(u[1], u[2])
    if (pole := across < POLE).any():
        u_rate = _into(above.frame, rate) - np.cross(above.omega, u, axis=0)
        speed = np.hypot(u_rate[1], u_rate[2])
        moving = speed > RESTING * (np.linalg.norm(rate, axis=0) + np.linalg.norm(above.omega, axis=0))
        theta = np.where(pole & moving, np.arctan2(u_rate[1], u_rate[2]), theta)
        theta = _theta_at_rest(theta, pole & ~moving, start)
    return _continuous(theta, np.arctan2(u[0], across), start)


def _theta_at_rest(theta: Array, resting: Mask, start: Array | None) -> Array:
    """theta (k,), of a rod that rests at a pole from the sample before."""
    theta = theta.copy()
    for sample in np.flatnonzero(resting):
        if sample:
            theta[sample] = theta[sample - 1]
        elif start is not None:
            theta[sample] = start[0]
    return theta


def _continuous(theta: Array, phi: Array, start: Array | None) -> Array:
    """The pairs (2, k) that follow on each other, from pairs (k,) with |phi| <= pi/2."""
    if start is not None:
        theta, phi = np.append(start[0], theta), np.append(start[1], phi)
    same = np.abs(_wrapped(np.diff(theta))) + np.abs(_wrapped(np.diff(phi)))
    other = np.abs(_wrapped(np.diff(theta) + np.pi)) + np.abs(_wrapped(np.pi - phi[1:] - phi[:-1]))
    turned = np.append(0, np.cumsum(other < same) % 2)
    pairs = np.unwrap(np.array([theta + np.pi * turned, np.where(turned, np.pi - phi, phi)]))
    return pairs if start is None else pairs[:, 1:]


def _wrapped(angle: Array) -> Array:
    """The same angles (n,) in [-pi, pi] rad."""
    return angle - 2 * np.pi * np.round(angle / (2 * np.pi))


def _rates(above: _Turning, q: Array, rate: Array, acceleration: Array) -> tuple[_Turning, Array, Array]:
    """How a rod turns, and its angles' rates and accelerations (2, k), from d' and d'' (3, k) in I."""
    (s_t, s), (c_t, c) = np.sin(q), np.cos(q)
    R = np.array([[c, np.zeros_like(s), s], [-s_t * s, c_t, s_t * c], [-c_t * s, -s_t, c_t * c]])
    frame = np.add.reduce(above.frame[:, :, None] * R, 1)
    d1, d2, _ = _into(frame, rate)
    e1, e2, _ = _into(frame, acceleration)
    p, pa = _into(R, above.omega), _into(R, above.alpha)
    pole = np.abs(c) < POLE
    safe_c = np.where(pole, 1.0, c)
    o1, o2 = -d2, d1
    phi_d = o2 - p[1]
    moving = np.abs(phi_d) > RESTING * (np.abs(p).sum(0) + np.abs(o1) + np.abs(o2))
    at_pole = _theta_rate_at_pole(s, phi_d, o2, p[2], e2 + pa[0], moving)
    theta_d = np.where(pole, at_pole, (p[0] - o1) / safe_c)
    w1, w3 = -theta_d * c, -theta_d * s
    o3 = p[2] + w3
    a1, a2 = o2 * o3 - e2, e1 - o1 * o3
    rho = a1 - pa[0] - o2 * w3 + o3 * phi_d
    theta_dd = np.where(pole, 0.0, (theta_d * phi_d * s - rho) / safe_c)
    phi_dd = a2 - pa[1] - o3 * w1 + o1 * w3
    a3 = pa[2] + o1 * phi_d - o2 * w1 - theta_dd * s - theta_d * phi_d * c
    turning = _Turning(frame, np.array([o1, o2, o3]), np.array([a1, a2, a3]))
    return turning, np.array([theta_d, phi_d]), np.array([theta_dd, phi_dd])


def _theta_rate_at_pole(s: Array, phi_d: Array, o2: Array, p3: Array, bend: Array, moving: Mask) -> Array:
    """The limit of theta' (n,) in rad/s at cos(phi) = 0, where d' does not show it but d'' does; 0 for a rod at rest."""
    return np.where(moving, -s * (bend - (o2 + phi_d) * p3) / np.where(moving, 2 * phi_d, 1.0), 0.0)
