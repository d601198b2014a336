"""The recursions of Newton-Euler and of the articulated body on trees of joints (trees.py), for any number type.

Written once over plain arithmetic: the same lines run on floats, mpmath's numbers and heyoka's symbols. After
R. Featherstone, Rigid Body Dynamics Algorithms (2008), chapters 5 and 7, with three differences that save digits and
symbols:

- every vector is taken in the frame of the joint it belongs to, as a pair of 3-vectors, and accelerations are those of
  points of the link, not spatial ones;
- the forces at zero joint acceleration come from Newton-Euler first; the articulated bodies then carry no velocities;
- matrices that are symmetric, or have a zero row, in exact arithmetic are made so after each joint. That saves about one
  digit at 60 rods; for joints of more degrees of freedom it would save all of them (docs/pinocchio_notes.md, section 2).
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pendpin.equations.chain.kinematics import ChainInertia
from pendpin.equations.trees import Joint, Tree, inward, joints_at, outward
from pendpin.ground.arrays import (
    Array,
    applied,
    centripetal,
    cross,
    dot,
    gyroscopic,
    outer,
    skew,
    symmetric,
)

_UNIT = np.eye(3)


class _LinkMotion(NamedTuple):
    """How a link moves, in its joint's frame; accelerations are less the field."""

    omega: Array  # (..., 3) rad/s
    alpha: Array  # (..., 3) rad/s²
    a: Array  # (..., 3) m/s², of the joint's origin
    K: Array  # (..., 3, 3) 1/s², the point at x from the origin accelerates by a + K x


class _Wrench(NamedTuple):
    force: Array  # (..., 3) N
    moment: Array  # (..., 3) N m, about the joint's origin


class _Body(NamedTuple):
    """A link with all that hangs on it: first = A first' + B second' + bias, second = B^T first' + C second' + bias."""

    # First and second stand for moment and force, the primes for alpha and a; `_swapped` exchanges the roles.

    A: Array  # (..., 3, 3), symmetric
    B: Array  # (..., 3, 3)
    C: Array  # (..., 3, 3), symmetric
    first: Array  # (..., 3)
    second: Array  # (..., 3)


class _Answer(NamedTuple):
    """A released joint: its link's acceleration along the axis is drive - first . first' - second . second'."""

    drive: Array  # (..., 1)
    first: Array  # (..., 3), normal to the axis
    second: Array  # (..., 3)
    inertia: Array  # (..., 1) kg m², that the joint moves


def wrenches(
    tree: Tree, q: Array, v: Array, a: Array, field: Array, external: Array | None = None, xp: Any = np
) -> Array:
    """Force and moment by each joint's parent on its child, (..., n, 6) in N and N m: Newton-Euler, tip to base.

    At the joint's origin, in the joint's frame, force first. q, v, a (..., n) in rad, rad/s, rad/s² (m for slides);
    field (3,) or (..., 3) is the uniform acceleration field in the base frame, m/s²; external (..., n, 6) acts on the
    links, at the same points and in the same frames as the answer.
    """
    tree, signs, joints = joints_at(tree, q, xp)
    needed = _inertial(tree, joints, signs * v, signs * a, field, external, xp)

    def pass_on(i: int, wrench: _Wrench) -> tuple[_Wrench, Array]:
        force = applied(joints[i].R, wrench.force)
        moment = applied(joints[i].R, wrench.moment) + cross(joints[i].r, force)
        return _Wrench(force, moment), np.concatenate(wrench, -1)

    return np.stack(inward(pass_on, needed, tree.parents, xp), -2)


def along_axes(tree: Tree, wrench: Array) -> Array:
    """The torques (..., n) in N m about the joints' axes, forces in N along those of slides, in wrenches (..., n, 6)."""
    turns = np.array([kind == "revolute" for kind in tree.kinds])
    return (np.where(turns[:, None], wrench[..., 3:], wrench[..., :3]) * tree.axes).sum(-1)


def accelerations(
    tree: Tree, q: Array, v: Array, field: Array, tau: Array | None = None, external: Array | None = None, xp: Any = np
) -> Array:
    """Joint accelerations (..., n) in rad/s² (m/s² for slides) under joint torques tau (..., n) in N m (N for slides).

    The rest as in `wrenches`. A joint that moves no inertia divides by zero: nan or inf on floats, ZeroDivisionError on
    mpmath's numbers.
    """
    return accelerate_or_hold(tree, q, v, field, [None] * len(tree.parents), tau, external, xp)[0]


def accelerate_or_hold(
    tree: Tree,
    q: Array,
    v: Array,
    field: Array,
    held: Sequence[Any],
    tau: Array | None = None,
    external: Array | None = None,
    xp: Any = np,
) -> tuple[Array, Array]:
    """Joint accelerations (..., n), and the torques (..., n) that hold joints at their rates; else as `accelerations`.

    held (n,) is 1 for a joint that is held, 0 for one that is free, None for one that is never held: the articulated body
    of a held joint goes to its parent as it is.
    """
    tree, signs, joints = joints_at(tree, q, xp)
    torques = np.zeros(len(joints)) if tau is None else signs * tau
    needed = _inertial(tree, joints, signs * v, np.zeros(len(joints)), field, external, xp)
    bodies = []  # each link as a body, with its wrench at zero joint acceleration
    for m, com, inertia, wrench in zip(tree.masses, tree.coms, tree.inertias, needed, strict=True):
        bodies.append(_Body(_about_origin(m, com, inertia), skew(m * com), m * _UNIT, wrench.moment, wrench.force))

    def release(i: int, body: _Body) -> tuple[_Body, _Answer]:
        # a slide exchanges the roles of moment and force, of turning and of moving
        turns, tau = joints[i].turns, torques[..., i : i + 1]
        rest, answer = _release(joints[i], body if turns else _swapped(body), tau)
        rest = rest if turns else _swapped(rest)
        if held[i] is not None:
            rest = _Body(*(held[i] * x + (1 - held[i]) * y for x, y in zip(body, rest, strict=True)))
        return _seen_from_parent(joints[i], rest), answer

    def move(i: int, parent: tuple[Array, Array]) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """From the base to the tips: alpha and a beyond those at zero joint acceleration; the joint's own, its torque."""
        joint, answer, to_child = joints[i], answers[i], joints[i].R.mT
        alpha, a = parent
        alpha, a = applied(to_child, alpha), applied(to_child, a + cross(alpha, joint.r))
        first, second = (alpha, a) if joint.turns else (a, alpha)
        along = answer.drive - dot(answer.first, first) - dot(answer.second, second)
        carried = dot(joint.axis, first)
        qdd, torque = along - carried, np.zeros_like(along)
        if held[i] is not None:
            torque, qdd = -held[i] * answer.inertia * qdd, (1 - held[i]) * qdd
            along = carried + qdd
        first = applied(joint.across, first) + joint.axis * along
        return (first, second) if joint.turns else (second, first), (qdd, torque)

    answers = inward(release, bodies, tree.parents, xp)
    moved = outward(move, (np.zeros(3), np.zeros(3)), tree.parents, xp)
    a, holding = (np.concatenate(parts, -1) for parts in zip(*moved, strict=True))
    return signs * a, signs * holding


def _inertial(
    tree: Tree, joints: list[Joint], v: Array, acceleration: Array, field: Array, external: Any, xp: Any
) -> list[_Wrench]:
    """The force and moment that each link needs for v and acceleration (..., n), less the external ones (..., n, 6)."""

    def move(i: int, parent: _LinkMotion) -> tuple[_LinkMotion, _Wrench]:
        """A link's motion from its parent's, and force = m a_G, moment = J alpha + omega x (J omega) + m com x a."""
        joint, to_child, rate, qdd = joints[i], joints[i].R.mT, v[..., i, None], acceleration[..., i, None]
        omega, alpha = applied(to_child, parent.omega), applied(to_child, parent.alpha)
        a = applied(to_child, parent.a + applied(parent.K, joint.r))
        coriolis = cross(omega, joint.axis) * rate
        if joint.turns:
            omega, alpha = omega + joint.axis * rate, alpha + coriolis + joint.axis * qdd
        else:
            a = a + 2 * coriolis + joint.axis * qdd
        K = skew(alpha) + centripetal(omega)
        m, com = tree.masses[i], tree.coms[i]
        lever, J = m * com, _about_origin(m, com, tree.inertias[i])
        force = m * a + applied(K, lever)
        moment = applied(J, alpha) + gyroscopic(J, omega) + cross(lever, a)
        if external is not None:
            force, moment = force - external[..., i, :3], moment - external[..., i, 3:]
        return _LinkMotion(omega, alpha, a, K), _Wrench(force, moment)

    return outward(move, _LinkMotion(np.zeros(3), np.zeros(3), -field, np.zeros((3, 3))), tree.parents, xp)


def _release(joint: Joint, body: _Body, tau: Array) -> tuple[_Body, _Answer]:
    """The body as its parent feels it through the joint, and the answer of the joint to torque tau (..., 1)."""
    axis, across = joint.axis, joint.across
    column = applied(body.A, axis)
    inertia = dot(axis, column)
    inverse = 1 / inertia  # one division, and products
    drive = (tau - dot(axis, body.first)) * inverse
    first, second = applied(across, column), applied(body.B.mT, axis)
    answer = _Answer(drive, first * inverse, second * inverse, inertia)
    # Made symmetric at every joint: left to rounding, the two halves grow apart from rod to rod, by 1e12 over 60 rods on
    # spherical joints (docs/pinocchio_notes.md, 2).
    rest = _Body(
        symmetric(across @ body.A @ across - outer(first, answer.first)),
        across @ body.B - outer(first, answer.second),
        symmetric(body.C - outer(second, answer.second)),
        applied(across, body.first) + first * drive + axis * tau,
        body.second + second * drive,
    )
    return rest, answer


def _seen_from_parent(joint: Joint, body: _Body) -> _Body:
    """The same body, turned into the parent's frame and moved to the parent's origin."""
    R, x = joint.R, skew(joint.r)
    A, C = symmetric(R @ (R @ body.A).mT), symmetric(R @ (R @ body.C).mT)
    B = R @ (R @ body.B.mT).mT
    moved = B + x @ C
    force = applied(R, body.second)
    moment = applied(R, body.first) + cross(joint.r, force)
    return _Body(symmetric(A - B @ x + x @ moved.mT), moved, C, moment, force)


def _swapped(body: _Body) -> _Body:
    """The body with first and second exchanged."""
    return _Body(body.C, body.B.mT, body.A, body.second, body.first)


def _about_origin(m: Any, com: Array, inertia: Array) -> Array:
    """The inertia (3, 3) in kg m² about the joint's origin, from the central one."""
    return inertia - m * (skew(com) @ skew(com))


# --- thin rods in directions: the articulated bodies of spherical joints ----------------------------------------------
#
# The chain from rod i on, held at its joint, answers the joint's acceleration a with the force F = A a + b on it. With
# u the part of d'' normal to the rod, F' = A' a' + b' the force on the next rod and a' = a + l (u - |d'|² d) the
# acceleration of the tip, the balances of moments about the joint and of forces are
#     J u = P (m h (field - a) + h f - l F') + M x d,    F = m (a + h (u - |d'|² d)) + F' - m field - f,
# P = 1 - d d^T, J = I1 + m h²; f and M are external. Solved for u and F they give A and b (docs/derivation_chain.md,
# section 8, has the same balances with all reactions as unknowns). K = J + l² P A' P is inverted: positive definite
# at every position, so nothing is singular at phi = ±pi/2. A is made symmetric after each rod: what rounding leaves of an
# antisymmetric part would grow threefold from rod to rod.


class ThinRods(NamedTuple):
    """What the recursion needs of a chain of thin rods, from the support down, each array (n,)."""

    m: Array  # kg
    h: Array  # m, centre of mass from the joint
    l: Array  # m, next joint from the joint  # noqa: E741
    I1: Array  # kg m², central, across the rod


class _ThinAnswer(NamedTuple):
    """How a rod turns with its joint's acceleration a: u = P Y (c - B a)."""

    P: Array  # (3, 3)
    Y: Array  # (3, 3), K^-1 P
    c: Array  # (3,)
    B: Array  # (3, 3), m h + l A'
    hanging: "_Hanging"  # the chain from the rod on
    inward: Array  # (3,), |d'|² d


class _Hanging(NamedTuple):
    """The force F = A a + b on a joint from which a chain hangs."""

    A: Array  # (3, 3), symmetric
    b: Array  # (3,)


def thin_turning(
    chain: ThinRods | ChainInertia,
    d: Array,
    rate: Array,
    field: Array,
    force: Array | None = None,
    moment: Array | None = None,
    xp: Any = np,
) -> tuple[Array, Array]:
    """omega' = d x d'' (n, 3) in I, rad/s², and the force (n, 3) in N on each rod at its joint.

    From unit directions d (n, 3), rates d' (n, 3) in 1/s, and a field (3,) in I; force and moment (n, 3), external, in N
    and N m, the moment about the centre of mass and normal to the rod.
    """

    def release(i: int, hanging: _Hanging) -> tuple[_Hanging, _ThinAnswer]:
        m, h, length, J = chain.m[i], chain.h[i], chain.l[i], chain.I1[i] + chain.m[i] * chain.h[i] ** 2
        A, b = hanging
        f = m * field + (0.0 if force is None else force[i])
        inward_part = d[i] * dot(rate[i], rate[i])
        B = m * h * _UNIT + length * A
        P = _UNIT - outer(d[i], d[i])
        M = J * _UNIT + length**2 * (P @ A @ P)  # symmetric: its inverse, by cofactors
        cofactors = np.stack([cross(M[1], M[2]), cross(M[2], M[0]), cross(M[0], M[1])])
        Y = cofactors * (1 / dot(M[0], cofactors[0])) @ P
        c = h * f + length * (length * applied(A, inward_part) - b)
        if moment is not None:
            c = c + cross(moment[i], d[i])
        through = B @ P @ Y
        A, b = symmetric(m * _UNIT + A - through @ B), applied(through, c) - applied(B, inward_part) + b - f
        hanging = _Hanging(A, b)
        return hanging, _ThinAnswer(P, Y, c, B, hanging, inward_part)

    def move(i: int, a: Array) -> tuple[Array, tuple[Array, Array]]:
        """From the support to the last rod: omega', and the force."""
        P, Y, c, B, (A, b), inward_part = answers[i]
        u = applied(Y, c - applied(B, a))
        return a + chain.l[i] * (applied(P, u) - inward_part), (cross(d[i], u), applied(A, a) + b)

    parents, nothing = range(-1, len(d) - 1), _Hanging(np.zeros((3, 3)), np.zeros(3))
    answers = inward(release, [nothing] * len(d), parents, xp)
    turned, forces = zip(*outward(move, np.zeros(3), parents, xp), strict=True)
    return np.stack(turned), np.stack(forces)
