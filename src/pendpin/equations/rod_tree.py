"""A tree of rods on universal joints and hinges, Newton-Euler: accelerations and every joint's reactions in one solve.

The derivation is docs/derivation_chain.md, section 10. Nothing is eliminated: accelerations of all rods and reactions of
all joints are the unknowns of one sparse system, over a batch of states at once. Time and memory grow with the rods.
"""

from typing import Any, Literal, NamedTuple

import numpy as np

from pendpin.equations.balances import frames
from pendpin.ground.arrays import Array, Mask, applied, cross

JointKind = Literal["universal", "x", "y"]  # a hinge is named by its axis: theta turns about x, phi about y
BATCH = 1 << 12  # rods solved at once
REFINEMENTS = 2  # as many as the rounding of a factor with pivoting needs
_ABOUT = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  # alpha -> alpha x b3
_CARRIED = {
    "universal": np.zeros((3, 2)),
    "x": np.eye(3)[:, 1:],
    "y": np.eye(3)[:, ::2],
}  # the axes of a hinge's moments


class TreeSolution(NamedTuple):
    """Accelerations of the angles, and what each rod's joint exerts on it; n rods."""

    acceleration: Array  # (..., nv) rad/s², rod by rod: theta'', phi'', those that its joint has
    force: Array  # (..., n, 3) N, at the joint, in B: R1, R2, -R3
    moment: Array  # (..., n, 3) N m, at the joint, in B: what it carries, and its torques


class RodTree(NamedTuple):
    """Rods that hang on each other, parents before their children."""

    parents: tuple[int, ...]  # the rod that each hangs on, -1 for the support
    kinds: tuple[JointKind, ...]
    at: Array  # (n,) m, along the parent, of the joint; not read at the support
    m: Array  # (n,) kg
    h: Array  # (n,) m, centre of mass from the joint along b3
    inertia: Array  # (n, 3) kg m², central, about b1, b2, b3

    @property
    def angles(self) -> Mask:
        """Which of theta, phi each joint has, (n, 2); in this order they are the nv angles."""
        return np.array([(kind != "y", kind != "x") for kind in self.kinds])


def solve(
    tree: RodTree,
    q: Array,
    v: Array,
    field: Array,
    torque: Array | None = None,
    force: Array | None = None,
    moment: Array | None = None,
) -> TreeSolution:
    """Accelerations and reactions of a tree at states q, v (states, nv) in rad and rad/s.

    field (3,) is the uniform acceleration field in the inertial frame I (z down), m/s². torque (states, nv) in N m are the
    generalised forces of the angles, on the rod and in return on what it hangs on; force N and moment N m about the centre
    of mass (states, n, 3) act on the rods from outside, given in each rod's own frame B.
    A thin rod needs cos(phi) != 0. Raises numpy.linalg.LinAlgError where the system is singular.
    """
    rods, size = len(tree.parents), max(1, BATCH // len(tree.parents))
    torque = np.zeros_like(q) if torque is None else torque
    force, moment = (np.zeros((len(q), rods, 3)) if x is None else x for x in (force, moment))
    given = q, v, torque, force, moment
    parts = [_solve(tree, field, *(x[i : i + size] for x in given)) for i in range(0, len(q), size)]
    return TreeSolution(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _solve(tree: RodTree, field: Array, q: Array, v: Array, torque: Array, force: Array, moment: Array) -> TreeSolution:
    """The same of few states."""
    states, n, parents = len(q), len(tree.m), np.array(tree.parents)
    hung, above = parents >= 0, np.maximum(parents, 0)
    angle, rate, tau = np.zeros((3, states, n, 2))
    angle[:, tree.angles], rate[:, tree.angles], tau[:, tree.angles] = q, v, torque
    R = frames(angle)  # in the frame of what the rod hangs on
    down = R.mT
    s, c, zero, one = np.sin(angle[..., 1]), np.cos(angle[..., 1]), np.zeros((states, n)), np.ones((states, n))
    a1, a2 = np.stack([c, zero, s], -1), np.stack([zero, one, zero], -1)

    # Angular velocities from the support down, what of alpha does not come from the angles' accelerations, and swings.
    own = rate[..., 1:] * a2 - rate[..., :1] * a1
    omega = own.copy()
    for i in np.flatnonzero(hung):
        omega[:, i] += applied(down[:, i], omega[:, above[i]])
    drift = rate[..., 1:] * cross(omega, a2) - rate[..., :1] * cross(omega - own, a1)
    inward = cross(omega, cross(omega, np.broadcast_to([0.0, 0.0, 1.0], omega.shape)))
    arm = np.where(hung, tree.at - tree.h[above], 0.0)[:, None]  # m, from the centre of mass above
    support = np.where(hung[:, None], arm * inward[:, above], -field)

    # The joints' conditions J (a, alpha) = gap: no gap between the rods, no turning about the axes that carry a moment.
    universal = np.all(tree.angles, 1)[:, None, None]
    a3 = np.stack([cross(a1, a2), np.zeros_like(a1)], -1)
    carried = np.where(universal, a3, np.array([_CARRIED[kind] for kind in tree.kinds]))  # (states, n, 3, 2)
    of_rod, of_above = np.zeros((2, states, n, 5, 6))
    of_rod[..., :3, :3], of_rod[..., :3, 3:] = np.eye(3), -tree.h[:, None, None] * _ABOUT
    of_rod[..., 3:, 3:] = carried.mT
    of_above[..., :3, :3], of_above[..., :3, 3:] = -down, -down @ (arm[..., None] * _ABOUT)
    of_above[..., 3:, 3:] = -carried.mT @ down
    of_above[:, ~hung] = 0
    gap = np.concatenate([tree.h[:, None] * inward + applied(down, support), applied(carried.mT, drift)], -1)

    # The balances M (a, alpha) = J^T reactions + loads; a torque acts on the rod, and in return on what it hangs on.
    at_joint = tau[..., 1:] * a2 - tau[..., :1] * a1
    about_G = moment + at_joint - cross(omega, tree.inertia * omega)
    np.subtract.at(about_G.swapaxes(0, 1), above[hung], applied(R, at_joint)[:, hung].swapaxes(0, 1))
    loads = np.concatenate([force, about_G], -1)
    moving, reactions = _solve_sparse(tree, np.stack([of_rod, of_above], 2), loads, gap)

    alpha = moving[..., 3:]
    turned = alpha - drift - np.where(hung[:, None], applied(down, alpha[:, above]), 0.0)
    accelerations = np.stack([-(a1 * turned).sum(-1), turned[..., 1]], -1)[:, tree.angles]
    return TreeSolution(accelerations, reactions[..., :3], applied(carried, reactions[..., 3:]) + at_joint)


def _solve_sparse(tree: RodTree, conditions: Array, loads: Array, gap: Array) -> tuple[Array, Array]:
    """The accelerations (states, n, 6) and reactions (states, n, 5) from balances and conditions."""
    # conditions (states, n, 2, 5, 6) of each joint, on the accelerations of its rod and of the rod above; loads
    # (states, n, 6), gap (states, n, 5). A universal joint has four conditions: its fifth reaction is 0.
    from scipy.sparse import bmat, bsr_array, diags_array
    from scipy.sparse.linalg import splu

    (states, n), rod = gap.shape[:2], np.arange(len(tree.m))
    places = np.stack([rod, np.maximum(tree.parents, 0)], -1) + n * np.arange(states)[:, None, None]
    blocks = conditions.reshape(-1, 5, 6), places.ravel(), 2 * np.arange(states * n + 1)
    J = bsr_array(blocks, shape=(gap.size, loads.size))
    mass = np.concatenate([np.repeat(tree.m[:, None], 3, 1), tree.inertia], -1)
    none = np.zeros((n, 5))
    none[:, 4] = np.all(tree.angles, 1)
    K: Any = bmat(
        [[diags_array(np.tile(mass.ravel(), states)), -J.T], [J, diags_array(np.tile(none.ravel(), states))]], "csc"
    )
    rhs = np.concatenate([loads.ravel(), gap.ravel()])

    # Rows and columns are brought near 1 by powers of two, then factored with pivoting and corrected.
    K.eliminate_zeros()
    rows = np.exp2(-np.round(np.log2(np.abs(K).max(1).toarray().ravel())))
    scaled = diags_array(rows) @ K
    columns = np.exp2(-np.round(np.log2(np.abs(scaled).max(0).toarray().ravel())))
    try:
        factor = splu((scaled @ diags_array(columns)).tocsc())
    except RuntimeError:
        raise np.linalg.LinAlgError("the tree's equations are singular at some state") from None
    x = np.zeros_like(rhs)
    for _ in range(1 + REFINEMENTS):
        x += columns * factor.solve(rows * (rhs - K @ x))
    return x[: loads.size].reshape(loads.shape), x[loads.size :].reshape(gap.shape)
