"""What rounding can do to accelerations and wrenches of a tree: the bounds of comparisons of two algorithms.

An algorithm sums terms: masses times the norms of accelerations and the field, times levers; inertias times angular
accelerations and squared rates; in spatial vectors also m v x v, which vanishes; torques and wrenches from outside. Each
sum is off by a few eps of its terms' norms, and |M^-1| turns that into accelerations. Where an algorithm refers
everything to the origin of the world, as Pinocchio's WORLD convention does, the levers are those from there.
"""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

ROUNDINGS = 20  # for each joint: turning by a matrix, moving to another origin and adding take about so many


class Terms(NamedTuple):
    """Sums of absolute terms, (nv,) each."""

    acceleration: np.ndarray  # rad/s² (m/s² for slides): |M^-1| times the terms of each joint's equation
    force: np.ndarray  # N, in each joint's wrench at given accelerations
    moment: np.ndarray  # N m


def terms(model, q, v, a, tau=None, external=None, world=False) -> Terms:
    """The terms at a state (nv,) with its accelerations, torques (nv,) and wrenches (nv, 6) on the links."""
    data = model.createData()
    pin.forwardKinematics(model, data, q, v, a)
    at = np.array([place.translation for place in data.oMi])[1:]
    below = _below([parent - 1 for parent in list(model.parents)[1:]])
    force, moment = _of_links(model, data, at, below, world)
    if external is not None:
        force = force + np.linalg.norm(external[:, :3], axis=1)
        moment = moment + np.linalg.norm(external[:, 3:], axis=1)
    distance = np.linalg.norm(at, axis=1)
    apart = distance[:, None] + distance if world else np.linalg.norm(at[:, None] - at, axis=-1)
    forces, moments = below @ force, (below * apart) @ force + below @ moment
    slides = np.array(["P" in joint.shortname() for joint in list(model.joints)[1:]])
    own = np.where(slides, forces, moments) + (0 if tau is None else np.abs(tau))
    return Terms(np.abs(_inverse(model, data, q)) @ own, forces, moments)


def _of_links(model, data, at, below, world):
    """Each link's force (n,) N and moment (n,) N m about its joint, with every product counted by its norms."""
    inertias = list(model.inertias)[1:]
    mass, lever, inertia = np.array([(i.mass, _norm(i.lever), _norm(i.inertia)) for i in inertias]).T
    twist, bend = (np.array([x.vector for x in rows])[1:] for rows in (data.v, data.a))
    classical = bend[:, :3] + np.cross(twist[:, 3:], twist[:, :3])
    velocity, rate, alpha, a = (
        below.T @ np.linalg.norm(x, axis=1) for x in (twist[:, :3], twist[:, 3:], bend[:, 3:], classical)
    )
    if world:
        lever, a = lever + np.linalg.norm(at, axis=1), a + (alpha + rate**2) * np.linalg.norm(at, axis=1)
    force = mass * (_norm(model.gravity.linear) + a + velocity * rate + (alpha + rate**2) * lever)
    return force, lever * force + inertia * (alpha + rate**2) + mass * velocity**2


def _below(parents):
    """(n, n): 1 where link k hangs on joint j, or is moved by it."""
    below = np.eye(len(parents))
    for child in reversed(range(len(parents))):
        if parents[child] >= 0:
            below[parents[child]] += below[child]
    return below


def _inverse(model, data, q):
    """The inverse mass matrix (nv, nv), scaled to a unit diagonal where it is inverted."""
    M = np.triu(pin.crba(model, data, q))
    M += np.triu(M, 1).T
    scale = 1 / np.sqrt(np.diag(M))
    return scale[:, None] * np.linalg.inv(scale[:, None] * M * scale) * scale


def _norm(x):
    return float(np.linalg.norm(x))
