"""The rounding scale of a quantity: the sum of the absolute terms in it, to which rounding errors are relative."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from pendpin.arrays import Array
from pendpin.equations.base import RodInertia, RodSolution
from pendpin.model.bodies import mass_matrix, pinocchio, tree_of, with_gravity
from pendpin.model.build import Model


def rod_scale(rod: RodInertia, q: Array, v: Array, field: Array, solution: RodSolution) -> RodSolution:
    """The sum of the absolute terms that enter each quantity of one rod, from states (n, 2) and the field (3,) in I.

    Taken from the balances of docs/derivation.md, section 3, with the absolute value of every product of components.
    """
    m, h, I1, I2, I3 = rod._replace(h=abs(rod.h))
    J1, J2 = I1 + m * h * h, I2 + m * h * h
    (s_t, s), (c_t, c) = np.abs(np.sin(q)).T, np.abs(np.cos(q)).T
    dt, dp = np.abs(v).T
    gx, gy, gz = np.abs(field)
    along = s_t * gy + c_t * gz
    G1, G2, G3 = c * gx + s * along, c_t * gy + s_t * gz, s * gx + c * along
    alpha1 = np.abs(solution.theta_dd) * c + dt * dp * s
    alpha2 = np.abs(solution.phi_dd)
    alpha3 = np.abs(solution.theta_dd) * s + dt * dp * c

    theta_dd = c * (2 * (J1 + I3) * dt * dp * s + m * h * G2) / (J1 * c**2 + I3 * s**2)
    phi_dd = (m * h * G1 + (J1 + I3) * dt**2 * s * c) / J2
    R1 = m * (h * (alpha2 + dt**2 * s * c) + G1)
    R2 = m * (h * (alpha1 + dt * dp * s) + G2)
    R3 = m * (h * (dp**2 + dt**2 * c**2) + G3)
    moment1 = J1 * alpha1 + (I3 + J2) * dt * dp * s + m * h * G2
    moment3 = I3 * alpha3 + (J1 + J2) * dt * dp * c
    Mc = s * moment1 + c * moment3
    return RodSolution(theta_dd, phi_dd, R1, R2, R3, Mc * c, Mc)


ONE_PRODUCT = 0.01  # of a term: one rounding, where the bound of a comparison allows some hundred


class TreeScale(NamedTuple):
    """For states of a tree, (n, joints) each."""

    acceleration: Array  # |M^-1| times the terms of each joint's equation: its condition is in it
    force: Array  # N
    moment: Array  # N m


def tree_scale(model: Model, field: Array, q: Array, v: Array, a: Array) -> TreeScale:
    """The rounding scales of a tree's equations, from q, v, accelerations (n, nv) and the field (3,) in W.

    A joint's equation is the moment (the force, for a slide) along its axis: its terms are, over the bodies beyond it,
    mass times the norms of field and acceleration with their levers, and inertia times angular acceleration and squared
    rate. In Pinocchio's spatial vectors m v x v enters as well, with v the velocity of the joint's origin; it vanishes
    but for one rounding. |M^-1| bounds the effect of rounding errors in these terms on the accelerations, and |W M^-1|
    that on a joint's wrench, with W the wrenches for unit accelerations.
    """
    model = replace(model, pin=with_gravity(model.pin, np.zeros(3)))  # accelerations carry it, where it enters
    tree = tree_of(model.pin)
    below = _below(tree.parents)
    slides = np.array([kind == "prismatic" for kind in tree.kinds])
    rows = [_state_scale(model, tree.parents, below, slides, field, *state) for state in zip(q, v, a, strict=True)]
    return TreeScale(*(np.array(column) for column in zip(*rows, strict=True)))


def _below(parents: tuple[int, ...]) -> Array:
    """(n, n): 1 where body k hangs on joint j, or is moved by it."""
    below = np.eye(len(parents))
    for child in reversed(range(len(parents))):
        if parents[child] >= 0:
            below[parents[child]] += below[child]
    return below


def _largest_above(parents: tuple[int, ...], x: Array) -> Array:
    """The largest of each body's own value (n,) and those of the bodies it hangs on: rounding goes down the tree."""
    out = x.copy()
    for child, parent in enumerate(parents):
        if parent >= 0:
            out[child] = max(out[child], out[parent])
    return out


def _state_scale(
    model: Model, parents: tuple[int, ...], below: Array, slides: Array, field: Array, q: Array, v: Array, a: Array
) -> TreeScale:
    """The sizes at one state q, v, a (nv,) in a field (3,) in m/s²; below (n, n) and slides (nv,) say who hangs on whom."""
    pin = pinocchio()
    data = pin.Data(model.pin)  # pyright: ignore[reportOptionalMemberAccess]
    pin.forwardKinematics(model.pin, data, q, v, a)
    inertias = list(model.pin.inertias)[1:]  # pyright: ignore[reportOptionalMemberAccess]
    mass, inertia, lever = np.array([(i.mass, np.linalg.norm(i.inertia), np.linalg.norm(i.lever)) for i in inertias]).T
    twist = np.array([x.vector for x in data.v])[1:]
    bend = np.array([x.vector for x in data.a])[1:]
    vectors = (twist[:, :3], twist[:, 3:], bend[:, 3:], bend[:, :3] + np.cross(twist[:, 3:], twist[:, :3]))
    speed, rate, alpha, origin = (_largest_above(parents, np.linalg.norm(x, axis=1)) for x in vectors)
    weight = mass * (np.linalg.norm(field) + origin + (alpha + rate**2) * lever)
    at = np.array([x.translation for x in data.oMi])[1:]
    centres = np.array([x.act(i.lever) for x, i in zip(list(data.oMi)[1:], inertias, strict=True)])
    reach = np.linalg.norm(centres[None] - at[:, None], axis=-1)
    turning = inertia * (alpha + rate**2) + ONE_PRODUCT * mass * speed**2
    own = np.where(slides, below @ weight, (below * reach) @ weight + below @ turning)
    inverse = _inverse(mass_matrix(model.pin, q))
    through = (np.abs(_unit_wrenches(model.pin, data, below, q) @ inverse) @ own).reshape(-1, 2, 3)
    force, moment = np.linalg.norm(through, axis=-1).T
    return TreeScale(np.abs(inverse) @ own, force + below @ weight, moment + (below * reach) @ weight + below @ turning)


def _unit_wrenches(model: Any, data: Any, below: Array, q: Array) -> Array:
    """W (6 joints, nv): the joints' wrenches for a unit acceleration of each joint, at rest and without gravity.

    Of two joints, all that hangs on the lower one moves with the upper one: its inertia is taken in W, then seen from
    the joint of the wrench.
    """
    twists = pinocchio().computeJointJacobians(model, data, q).reshape(6, -1)  # in W; (6,) of one joint
    places, inertias = list(data.oMi)[1:], list(model.inertias)[1:]
    moved = np.tensordot(below, [x.act(i).matrix() for x, i in zip(places, inertias, strict=True)], 1) @ twists
    own = np.einsum("kik->ik", moved)
    force, moment = np.split(np.where(below.T[:, None] > 0, moved, below[:, None] * own), 2, 1)  # (joints, 3, nv)
    moment = moment - np.cross(np.array([x.translation for x in places])[:, :, None], force, axis=1)
    into = np.array([x.rotation.T for x in places])
    return np.concatenate([into @ force, into @ moment], 1).reshape(-1, model.nv)


def _inverse(M: Array) -> Array:
    """The inverse of a mass matrix (nv, nv), with its rows and columns scaled to 1 on the diagonal."""
    scale = 1 / np.sqrt(np.diag(M))
    return scale[:, None] * np.linalg.inv(scale[:, None] * M * scale) * scale
