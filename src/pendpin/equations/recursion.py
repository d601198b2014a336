"""Trees of revolute and prismatic joints: the recursions of Newton-Euler and of the articulated body, for any number.

Written once over plain arithmetic: the same lines run on floats, mpmath's numbers and heyoka's symbols; `xp` has the
functions of the number type (pendpin.equations.numbers). After R. Featherstone, Rigid Body Dynamics
Algorithms (2008), chapters 5 and 7, with three differences that save digits and symbols:

- every vector is taken in the frame of the joint it belongs to, as a pair of 3-vectors, and accelerations are those of
  points of the link, not spatial ones;
- the forces at zero joint acceleration come from Newton-Euler first; the articulated bodies then carry no velocities;
- matrices that are symmetric, or have a zero row, in exact arithmetic are made so after each joint. That saves about one
  digit at 60 rods; for joints of more degrees of freedom it would save all of them (docs/pinocchio_notes.md, section 2).
"""

from collections.abc import Callable, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from pendpin.arrays import Array, applied, centripetal, dot, gyroscopic, outer, skew, symmetric, transposed

_UNIT = np.eye(3)


class Tree(NamedTuple):
    """A tree of n joints of one degree of freedom, each with the link it moves; parents come before their children."""

    parents: tuple[int, ...]  # index of the parent joint, -1 for the base
    kinds: tuple[Literal["revolute", "prismatic"], ...]
    axes: Array  # (n, 3), unit vectors in the joint's frame
    rotations: Array  # (n, 3, 3), from the joint's frame at zero to the parent joint's
    translations: Array  # (n, 3) m, the joint's origin in the parent joint's frame
    masses: Array  # (n,) kg
    coms: Array  # (n, 3) m, centre of mass from the joint's origin, joint's frame
    inertias: Array  # (n, 3, 3) kg m², about the centre of mass, joint's frame


class _Joint(NamedTuple):
    """A joint at its position: the pose of its frame in the parent's frame."""

    parent: int
    turns: bool
    axis: Array  # (3,)
    across: Array  # (3, 3), the projector normal to the axis: exact zeros where the axis is a coordinate axis
    R: Array  # (..., 3, 3), from the joint's frame to the parent's
    r: Array  # (..., 3) m, the joint's origin in the parent's frame


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
    """A link with all that hangs on it: first = A first' + B second' + bias, second = B^T first' + C second' + bias.

    First and second stand for moment and force, the primes for alpha and a; `_swapped` exchanges the roles.
    """

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
    tree, signs = _prepared(tree, xp)
    joints = _joints(tree, signs * q, xp)
    carried = _inertial(tree, joints, signs * v, signs * a, field, external)
    for i, joint in reversed(list(enumerate(joints))):
        if joint.parent >= 0:
            force = applied(joint.R, carried[i].force)
            moment = applied(joint.R, carried[i].moment) + np.cross(joint.r, force)
            parent = carried[joint.parent]
            carried[joint.parent] = _Wrench(parent.force + force, parent.moment + moment)
    return np.stack([np.concatenate(wrench, -1) for wrench in carried], -2)


def accelerations(
    tree: Tree, q: Array, v: Array, field: Array, tau: Array | None = None, external: Array | None = None, xp: Any = np
) -> Array:
    """Joint accelerations (..., n) in rad/s² (m/s² for slides) under joint torques tau (..., n) in N m (N for slides).

    The rest as in `wrenches`. A joint that moves no inertia divides by zero: nan or inf on floats, ZeroDivisionError on
    mpmath's numbers.
    """
    return with_held_joints(tree, q, v, field, [None] * len(tree.parents), tau, external, xp)[0]


def with_held_joints(
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
    tree, signs = _prepared(tree, xp)
    joints = _joints(tree, signs * q, xp)
    torques = np.zeros(len(joints)) if tau is None else signs * tau
    needed = _inertial(tree, joints, signs * v, np.zeros(len(joints)), field, external)
    bodies = [_rigid(tree, i, wrench) for i, wrench in enumerate(needed)]
    answers: dict[int, _Answer] = {}
    for i, joint in reversed(list(enumerate(joints))):
        rest, answers[i] = _released(joint, bodies[i], torques[..., i : i + 1])
        if held[i] is not None:
            rest = _Body(*(held[i] * x + (1 - held[i]) * y for x, y in zip(bodies[i], rest, strict=True)))
        if joint.parent >= 0:
            bodies[joint.parent] = _joined(bodies[joint.parent], _seen_from_parent(joint, rest))
    a, holding = _outward(joints, answers, held)
    return signs * a, signs * holding


def motions(tree: Tree, q: Array, v: Array, xp: Any = np) -> tuple[Array, Array, Array, Array]:
    """What each joint moves, in the base frame: origin (n, 3) m, axes (n, 3, 3), its velocity and spin (n, 3)."""
    tree, signs = _prepared(tree, xp)
    zero = np.zeros(3)
    moving: dict[int, tuple[Array, ...]] = {-1: (zero, _UNIT, zero, zero)}
    for i, (joint, rate) in enumerate(zip(_joints(tree, signs * q, xp), signs * v, strict=True)):
        origin, R, velocity, spin = moving[joint.parent]
        lever, axis = applied(R, joint.r), applied(R @ joint.R, joint.axis) * rate
        velocity = velocity + np.cross(spin, lever)
        turned = (velocity, spin + axis) if joint.turns else (velocity + axis, spin)
        moving[i] = (origin + lever, R @ joint.R, *turned)
    origin, R, velocity, spin = (np.stack(part) for part in zip(*(moving[i] for i in range(len(q))), strict=True))
    return origin, R, velocity, spin


def motions_in_links(
    tree: Tree, q: Array, v: Array, xp: Any = np
) -> tuple[Array, Array, Array, Callable[[Array], Array]]:
    """As `motions`, in the frame of what each joint moves: origin (n, 3) m, its velocity and spin (n, 3).

    And a function that turns a vector (3,) of the base frame into each of these frames, (n, 3): few operations for each.
    """
    tree, signs = _prepared(tree, xp)
    joints, rates = _joints(tree, signs * q, xp), signs * v
    moving: dict[int, tuple[Array, ...]] = {-1: (np.zeros(3),) * 3}
    for i, joint in enumerate(joints):
        origin, velocity, spin = moving[joint.parent]
        at_joint = (origin + joint.r, velocity + np.cross(spin, joint.r), spin)
        origin, velocity, spin = (applied(transposed(joint.R), x) for x in at_joint)
        own = joint.axis * rates[i]
        moving[i] = (origin, velocity, spin + own) if joint.turns else (origin, velocity + own, spin)

    def into_links(vector: Array) -> Array:
        turned = {-1: vector}
        for i, joint in enumerate(joints):
            turned[i] = applied(transposed(joint.R), turned[joint.parent])
        return np.stack([turned[i] for i in range(len(joints))])

    origin, velocity, spin = (np.stack(part) for part in zip(*(moving[i] for i in range(len(joints))), strict=True))
    return origin, velocity, spin, into_links


# --- Newton-Euler ---------------------------------------------------------------------------------------------------


def _prepared(tree: Tree, xp: Any) -> tuple[Tree, Array]:
    """The tree in the numbers of xp, and the signs (n,) that turn its axes to the positive side (fewer minus signs).

    Axes and rotations, which come rounded to doubles, are made unit and orthogonal to the digits of xp: else the tree
    would not keep its energy to them.
    """
    largest = np.take_along_axis(tree.axes, np.abs(tree.axes).argmax(-1)[:, None], -1)
    signs = np.where(largest < 0, -1.0, 1.0)
    axes, R, *others = (xp.asarray(x) for x in (tree.axes * signs + 0.0, *tree[3:]))  # + 0.0 clears the sign of zeros
    for _ in range(3):  # Newton: 16, 32, 64, 128 digits
        axes = axes * (3 - dot(axes, axes)) / 2
        R = R @ (3 * _UNIT - transposed(R) @ R) / 2
    return Tree(tree.parents, tree.kinds, axes, R, *others), signs[:, 0]


def _joints(tree: Tree, q: Array, xp: Any) -> list[_Joint]:
    """The joints at positions q (..., n) in rad, m for slides."""
    sin, cos = xp.sin(q), xp.cos(q)
    joints = []
    for i, (parent, kind) in enumerate(zip(tree.parents, tree.kinds, strict=True)):
        axis, R, r = tree.axes[i], tree.rotations[i], tree.translations[i]
        along = np.outer(axis, axis)
        across = _UNIT - along
        if kind == "revolute":
            turn = along + cos[..., i, None, None] * across + sin[..., i, None, None] * skew(axis)
            joints.append(_Joint(parent, True, axis, across, R @ turn, r))
        else:
            joints.append(_Joint(parent, False, axis, across, R, r + q[..., i, None] * (R @ axis)))
    return joints


def _inertial(tree: Tree, joints: list[_Joint], v: Array, a: Array, field: Array, external: Any) -> list[_Wrench]:
    """The force and moment that each link needs for v, a (..., n), less the external ones (..., n, 6)."""
    moving = {-1: _LinkMotion(np.zeros(3), np.zeros(3), -field, np.zeros((3, 3)))}
    out = []
    for i, joint in enumerate(joints):
        moving[i] = _moved(joint, moving[joint.parent], v[..., i, None], a[..., i, None])
        needed = _newton_euler(tree.masses[i], tree.coms[i], tree.inertias[i], moving[i])
        if external is not None:
            needed = _Wrench(needed.force - external[..., i, :3], needed.moment - external[..., i, 3:])
        out.append(needed)
    return out


def _moved(joint: _Joint, parent: _LinkMotion, v: Array, qdd: Array) -> _LinkMotion:
    """The motion of a link from that of its parent; v, qdd (..., 1) of its joint."""
    to_child = transposed(joint.R)
    omega, alpha = applied(to_child, parent.omega), applied(to_child, parent.alpha)
    a = applied(to_child, parent.a + applied(parent.K, joint.r))
    coriolis = np.cross(omega, joint.axis) * v
    if joint.turns:
        omega, alpha = omega + joint.axis * v, alpha + coriolis + joint.axis * qdd
    else:
        a = a + 2 * coriolis + joint.axis * qdd
    return _LinkMotion(omega, alpha, a, skew(alpha) + centripetal(omega))


def _newton_euler(m: Any, com: Array, inertia: Array, motion: _LinkMotion) -> _Wrench:
    """force = m a_G; moment = J alpha + omega x (J omega) + m com x a, J (3, 3) about the joint's origin, com (3,)."""
    lever, J = m * com, _about_origin(m, com, inertia)
    force = m * motion.a + applied(motion.K, lever)
    moment = applied(J, motion.alpha) + gyroscopic(J, motion.omega) + np.cross(lever, motion.a)
    return _Wrench(force, moment)


# --- articulated bodies ---------------------------------------------------------------------------------------------


def _rigid(tree: Tree, i: int, needed: _Wrench) -> _Body:
    """One link as a body; `needed` is its wrench at zero joint acceleration."""
    m, com = tree.masses[i], tree.coms[i]
    J = _about_origin(m, com, tree.inertias[i])
    return _Body(J, skew(m * com), m * _UNIT, needed.moment, needed.force)


def _released(joint: _Joint, body: _Body, tau: Array) -> tuple[_Body, _Answer]:
    """The body as its parent feels it through the joint, and the answer of the joint to torque tau (..., 1)."""
    if not joint.turns:
        rest, answer = _released_first(joint, _swapped(body), tau)
        return _swapped(rest), answer
    return _released_first(joint, body, tau)


def _released_first(joint: _Joint, body: _Body, tau: Array) -> tuple[_Body, _Answer]:
    """The same for a joint about its axis, with its torque tau (n,); a slide exchanges first and second."""
    axis, across = joint.axis, joint.across
    column = applied(body.A, axis)
    inertia = dot(axis, column)
    drive = (tau - dot(axis, body.first)) / inertia
    first, second = applied(across, column), applied(transposed(body.B), axis)
    answer = _Answer(drive, first / inertia, second / inertia, inertia)
    rest = _Body(
        symmetric(across @ body.A @ across - outer(first, answer.first)),
        across @ body.B - outer(first, answer.second),
        symmetric(body.C - outer(second, answer.second)),
        applied(across, body.first) + first * drive + axis * tau,
        body.second + second * drive,
    )
    return rest, answer


def _seen_from_parent(joint: _Joint, body: _Body) -> _Body:
    """The same body, turned into the parent's frame and moved to the parent's origin."""
    R, x = joint.R, skew(joint.r)
    A, C = symmetric(R @ transposed(R @ body.A)), symmetric(R @ transposed(R @ body.C))
    B = R @ transposed(R @ transposed(body.B))
    moved = B + x @ C
    force = applied(R, body.second)
    moment = applied(R, body.first) + np.cross(joint.r, force)
    return _Body(symmetric(A - B @ x + x @ transposed(moved)), moved, C, moment, force)


def _outward(joints: list[_Joint], answers: dict[int, _Answer], held: Sequence[Any]) -> tuple[Array, Array]:
    """Joint accelerations (..., n) beyond those at zero qdd, from the base to the tips, and holding torques (..., n)."""
    moving = {-1: (np.zeros(3), np.zeros(3))}  # alpha and a of each link
    out, holding = [], []
    for i, joint in enumerate(joints):
        answer, to_child = answers[i], transposed(joint.R)
        alpha, a = moving[joint.parent]
        alpha, a = applied(to_child, alpha), applied(to_child, a + np.cross(alpha, joint.r))
        first, second = (alpha, a) if joint.turns else (a, alpha)
        along = answer.drive - dot(answer.first, first) - dot(answer.second, second)
        carried = dot(joint.axis, first)
        qdd, torque = along - carried, np.zeros_like(along)
        if held[i] is not None:
            torque, qdd = -held[i] * answer.inertia * qdd, (1 - held[i]) * qdd
            along = carried + qdd
        out.append(qdd)
        holding.append(torque)
        first = applied(joint.across, first) + joint.axis * along
        moving[i] = (first, second) if joint.turns else (second, first)
    return np.concatenate(out, -1), np.concatenate(holding, -1)


def _joined(one: _Body, other: _Body) -> _Body:
    """The sum of two bodies."""
    return _Body(*(x + y for x, y in zip(one, other, strict=True)))


def _swapped(body: _Body) -> _Body:
    """The body with first and second exchanged."""
    return _Body(body.C, transposed(body.B), body.A, body.second, body.first)


def _about_origin(m: Any, com: Array, inertia: Array) -> Array:
    """The inertia (3, 3) in kg m² about the joint's origin, from the central one."""
    return inertia - m * (skew(com) @ skew(com))
