"""Trees of revolute and prismatic joints, for any number type: their joints' poses, and how what they move moves.

`xp` has the functions of the number type (pendpin.equations.base).
"""

from collections.abc import Callable, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from pendpin.ground.arrays import Array, applied, cross, dot, skew

Step = Callable[[int, Any], tuple[Any, Any]]  # a joint, and what arrives there -> what it passes on, its result


def outward(step: Step, base: Any, parents: Sequence[int], xp: Any = np) -> list[Any]:
    """The results of a step at every joint, each from what its parent passes on; `base` for those with parent -1."""
    own = getattr(xp, "outward", None)
    return own(step, base, parents) if own else [result for _, result in outward_steps(step, base, parents)]


def outward_steps(step: Step, base: Any, parents: Sequence[int]) -> list[tuple[Any, Any]]:
    """What each joint passes on, and its result."""
    done: list[tuple[Any, Any]] = []
    for i, parent in enumerate(parents):
        done.append(step(i, done[parent][0] if parent >= 0 else base))
    return done


def inward(step: Step, own: Sequence[Any], parents: Sequence[int], xp: Any = np) -> list[Any]:
    """The results of a step at every joint, from the sum of its `own` and of what its children pass on."""
    recorded = getattr(xp, "inward", None)
    return recorded(step, own, parents) if recorded else [result for _, result in inward_steps(step, own, parents)]


def inward_steps(step: Step, own: Sequence[Any], parents: Sequence[int]) -> list[tuple[Any, Any]]:
    """What each joint passes on, and its result."""
    arriving, done = list(own), list[Any](own)
    for i in reversed(range(len(arriving))):
        done[i] = step(i, arriving[i])
        if parents[i] >= 0:
            arriving[parents[i]] = add(arriving[parents[i]], done[i][0])
    return done


def add(one: Any, other: Any) -> Any:
    """The sum of two numbers or arrays, or of two named tuples of them: what arrives from two children."""
    return one._make(x + y for x, y in zip(one, other, strict=True)) if hasattr(one, "_make") else one + other


def total(x: Array, xp: Any = np) -> Any:
    """The sum of numbers (n,), of all joints or bodies."""
    own = getattr(xp, "total", None)
    return own(x) if own else np.sum(x)


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


class Joint(NamedTuple):
    """A joint at its position: the pose of its frame in the parent's frame."""

    turns: bool
    axis: Array  # (3,)
    across: Array  # (3, 3), the projector normal to the axis: exact zeros where the axis is a coordinate axis
    R: Array  # (..., 3, 3), from the joint's frame to the parent's
    r: Array  # (..., 3) m, the joint's origin in the parent's frame


def prepared(tree: Tree, xp: Any) -> tuple[Tree, Array]:
    """The tree in the numbers of xp, and the signs (n,) that turn its axes to the positive side (fewer minus signs)."""
    # Axes and rotations, which come rounded to doubles, are made unit and orthogonal to the digits of xp: else the tree
    # would not keep its energy to them.
    largest = np.take_along_axis(tree.axes, np.abs(tree.axes).argmax(-1)[:, None], -1)
    signs = np.where(largest < 0, -1.0, 1.0)
    axes, R, *others = (xp.asarray(x) for x in (tree.axes * signs + 0.0, *tree[3:]))  # + 0.0 clears the sign of zeros
    for _ in range(3):  # Newton: 16, 32, 64, 128 digits
        axes = axes * (3 - dot(axes, axes)) / 2
        R = R @ (3 * _UNIT - R.mT @ R) / 2
    return Tree(tree.parents, tree.kinds, axes, R, *others), signs[:, 0]


def joints_at(tree: Tree, q: Array, xp: Any) -> tuple[Tree, Array, list[Joint]]:
    """The tree and the signs as `prepared`, and the joints at positions q (..., n) in rad, m for slides."""
    tree, signs = prepared(tree, xp)
    q = signs * q
    sin, cos = xp.sin(q), xp.cos(q)
    joints = []
    for i, kind in enumerate(tree.kinds):
        axis, R, r = tree.axes[i], tree.rotations[i], tree.translations[i]
        along = np.outer(axis, axis)
        across, turns = _UNIT - along, kind == "revolute"
        if turns:
            R = R @ (along + cos[..., i, None, None] * across + sin[..., i, None, None] * skew(axis))
        else:
            r = r + q[..., i, None] * (R @ axis)
        joints.append(Joint(turns, axis, across, R, r))
    return tree, signs, joints


def place_joints(tree: Tree, q: Array, xp: Any = np) -> list[tuple[Array, Array]]:
    """The pose of what each joint moves at q (..., n), in the base: axes (..., 3, 3) and origin (..., 3) in m."""
    _, _, joints = joints_at(tree, q, xp)
    batch = q.shape[:-1]

    def pose(i: int, above: tuple[Array, Array]) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        R, r = above
        placed = R @ joints[i].R, r + applied(R, joints[i].r)
        return placed, placed

    base = np.broadcast_to(_UNIT, (*batch, 3, 3)), np.zeros((*batch, 3))
    return outward(pose, base, tree.parents, xp)


def motions(tree: Tree, q: Array, v: Array, xp: Any = np) -> tuple[Array, Array, Array, Array]:
    """What joints move at q, v (..., n), in the base: origins (..., n, 3) m, axes (..., n, 3, 3), velocities, spins."""
    R, origin = zip(*place_joints(tree, q, xp), strict=True)
    R, (_, velocity, spin, _) = np.stack(R, -3), motions_in_links(tree, q, v, xp)
    return np.stack(origin, -2), R, applied(R, velocity), applied(R, spin)


def motions_in_links(
    tree: Tree, q: Array, v: Array, xp: Any = np
) -> tuple[Array, Array, Array, Callable[[Array], Array]]:
    """The motions of all links, in the frame of what each joint moves: origin (..., n, 3) m, its velocity and spin.

    q, v are (..., n). And a function that turns a vector (3,) of the base frame into each of these frames, (n, 3), of one
    state: few operations for each.
    """
    tree, signs, joints = joints_at(tree, q, xp)
    rates = signs * v

    def move(i: int, parent: tuple[Array, ...]) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        joint, (origin, velocity, spin) = joints[i], parent
        at_joint = (origin + joint.r, velocity + cross(spin, joint.r), spin)
        origin, velocity, spin = (applied(joint.R.mT, x) for x in at_joint)
        own = joint.axis * rates[..., i, None]
        moving = (origin, velocity, spin + own) if joint.turns else (origin, velocity + own, spin)
        return moving, moving

    def into_links(vector: Array) -> Array:
        def turn(i: int, parent: Array) -> tuple[Array, Array]:
            turned = applied(joints[i].R.mT, parent)
            return turned, turned

        return np.stack(outward(turn, vector, tree.parents, xp))

    links = outward(move, (np.zeros((*q.shape[:-1], 3)),) * 3, tree.parents, xp)
    origin, velocity, spin = (np.stack(part, -2) for part in zip(*links, strict=True))
    return origin, velocity, spin, into_links
