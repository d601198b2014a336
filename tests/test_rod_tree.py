"""Laws of the balances of trees with hinges: against the chain's balances, the recursion, and Lagrange's equations by hand.

The plain tree of the recursion is written here joint by joint, so the two share neither frames nor conditions.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fifty_digits import TILTED, G, alike, mixed
from laws import law
from pendpin.equations import recursion
from pendpin.equations.chain import solution
from pendpin.equations.rod_tree import RodTree, solve
from pendpin.equations.trees import Tree

FLIP = np.array([1.0, -1.0, -1.0])  # a rod's body frame B to its link frame, and I to W
ROUNDING = 1e-12  # of the largest value; measured up to 1e-14 on 200 trees of this kind


def random_tree(random: np.random.Generator) -> RodTree:
    """Up to 12 rods of similar sizes on joints of all kinds; a second one may hang on the support."""
    n = int(random.integers(1, 13))
    parents = tuple(int(random.integers(-1 if i == 0 or random.random() < 0.1 else 0, max(i, 1))) for i in range(n))
    parents = (-1, *parents[1:])
    length = random.uniform(0.3, 2.0, n)
    kinds = tuple(random.choice(["universal", "x", "y"], n).tolist())
    at = np.array([random.uniform(0.0, length[p]) for p in parents])
    return RodTree(parents, kinds, at, random.uniform(0.1, 3.0, n), length / 2, random.uniform(0.02, 0.1, (n, 3)))


def plain(tree: RodTree) -> tuple[Tree, list[int]]:
    """The tree as revolute joints in link frames, and of each rod the joint that moves it."""
    rows: list[tuple] = []
    moved_by = {-1: -1}
    for i, (parent, kind) in enumerate(zip(tree.parents, tree.kinds, strict=True)):
        axes = {"x": [-np.eye(3)[0]], "y": [-np.eye(3)[1]], "universal": [*-np.eye(3)[:2]]}[kind]
        above, z = moved_by[parent], -tree.at[i] * (parent >= 0)
        for axis in axes[:-1]:  # a massless cross
            rows.append((above, axis, z, 0.0, 0.0, np.zeros(3)))
            above, z = len(rows) - 1, 0.0
        rows.append((above, axes[-1], z, tree.m[i], -tree.h[i], tree.inertia[i]))
        moved_by[i] = len(rows) - 1
    parents, axes, z, m, com, inertia = zip(*rows, strict=True)
    n, along = len(rows), np.array([0.0, 0.0, 1.0])
    places = np.array(z)[:, None] * along, np.array(m), np.array(com)[:, None] * along
    tensors = np.array([np.diag(x) for x in inertia])
    turned = Tree(parents, ("revolute",) * n, np.array(axes), np.tile(np.eye(3), (n, 1, 1)), *places, tensors)
    return turned, [moved_by[i] for i in range(len(tree.m))]


@law(40)
@given(st.integers(0, 2**32))
def test_balances_agree_with_the_recursion(seed: int) -> None:
    """Accelerations and wrenches of random trees under torques and loads from outside, rates up to 10 rad/s."""
    random = np.random.default_rng(seed)
    tree = random_tree(random)
    joints, moved_by = plain(tree)
    states, nv = 3, len(joints.parents)
    q, v, torque = (
        random.uniform(-3, 3, (states, nv)),
        random.uniform(-10, 10, (states, nv)),
        random.normal(size=(3, nv)),
    )
    force, moment = random.normal(size=(2, states, len(tree.m), 3))
    solved = solve(tree, q, v, TILTED, torque, force, moment)

    external = np.zeros((states, nv, 6))
    external[:, moved_by, :3] = force * FLIP
    about_joint = moment + np.cross(tree.h[:, None] * [0.0, 0.0, 1.0], force)
    external[:, moved_by, 3:] = about_joint * FLIP
    a = recursion.accelerations(joints, q, v, TILTED * FLIP, torque, external)
    wrench = recursion.wrenches(joints, q, v, a, TILTED * FLIP, external)[:, moved_by]
    assert np.abs(solved.acceleration - a).max() < ROUNDING * np.abs(a).max()
    assert np.abs(solved.force * FLIP - wrench[..., :3]).max() < ROUNDING * np.abs(wrench).max()
    assert np.abs(solved.moment * FLIP - wrench[..., 3:]).max() < ROUNDING * np.abs(wrench).max()


@pytest.mark.parametrize("chain", [alike(9, 0.05), mixed(6, np.random.default_rng(4)), alike(4, 0.0)])
def test_a_tree_that_is_a_chain_has_the_answers_of_the_chain(chain) -> None:
    """Thick rods and mixed ones, and thin ones, whose substitute inertia the chain refines away and a tree has not."""
    random, n = np.random.default_rng(1), chain.n
    inertia = np.stack([chain.I1, chain.I2, chain.I3], -1)
    above = np.concatenate([[0.0], chain.l[:-1]])
    tree = RodTree(tuple(range(-1, n - 1)), ("universal",) * n, above, chain.m, chain.h, inertia)
    q, v = random.uniform(-1.2, 1.2, (2, 5, 2 * n))
    one = solve(tree, q, v, G)
    other = solution.solve(chain, q.reshape(5, n, 2), v.reshape(5, n, 2), G)
    for ours, theirs in ((one.acceleration, other.acceleration), (one.force, other.force), (one.moment, other.moment)):
        assert np.allclose(ours.ravel(), theirs.ravel(), rtol=1e-9, atol=1e-11 * max(1.0, np.abs(theirs).max()))


@pytest.mark.parametrize("axis", ["x", "y"])
def test_two_hinges_are_lagranges_planar_double_pendulum(axis) -> None:
    """M v' = -dV + the centrifugal terms, in the absolute angles, from L = T - V written down by hand."""
    m1, m2, l1, h1, h2, J1, J2 = 1.3, 0.7, 0.9, 0.5, 0.4, 0.11, 0.06
    inertia = np.array([[J1, J1, 0.01], [J2, J2, 0.0]])
    tree = RodTree((-1, 0), (axis, axis), np.array([0.0, l1]), np.array([m1, m2]), np.array([h1, h2]), inertia)
    q, v = np.array([[0.7, -1.9]]), np.array([[2.0, -3.0]])
    a = solve(tree, q, v, G).acceleration[0]
    (one, two), (one_rate, two_rate), (one_dd, two_dd) = (np.cumsum(x) for x in (q, v, a))
    coupling, g = m2 * l1 * h2, G[2]
    first = (J1 + m1 * h1**2 + m2 * l1**2) * one_dd + coupling * (
        np.cos(one - two) * two_dd + np.sin(one - two) * two_rate**2
    )
    second = (J2 + m2 * h2**2) * two_dd + coupling * (np.cos(one - two) * one_dd - np.sin(one - two) * one_rate**2)
    assert abs(first + (m1 * h1 + m2 * l1) * g * np.sin(one)) < 1e-13 * g
    assert abs(second + m2 * h2 * g * np.sin(two)) < 1e-13 * g


def test_a_balanced_rod_on_a_spinning_arm_turns_by_eulers_equation() -> None:
    """An arm spins about x at s and carries a balanced rod on a hinge about y, at phi: Euler's equation about b2.

    J phi'' = (I3 - J) s^2 sin(phi) cos(phi), and the arm needs no torque; without gravity.
    """
    J, m, h, s, phi = 0.3, 2.0, 0.0, 5.0, 0.6
    arm, rod = [1.0, 1.0, 1.0], [J, J, 0.05]
    tree = RodTree((-1, 0), ("x", "y"), np.zeros(2), np.array([1.0, m]), np.array([0.0, h]), np.array([arm, rod]))
    solved = solve(tree, np.array([[0.4, phi]]), np.array([[-s, 0.0]]), np.zeros(3))
    assert solved.acceleration[0] == pytest.approx([0.0, (0.05 - J) * s**2 * np.sin(phi) * np.cos(phi) / J], rel=1e-14)
