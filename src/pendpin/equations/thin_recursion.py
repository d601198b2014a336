"""A chain of thin rods in directions by one recursion, for any number: the articulated bodies of spherical joints.

The chain from rod i on, held at its joint, answers the joint's acceleration a with the force F = A a + b on it. With
u the part of d'' normal to the rod, F' = A' a' + b' the force on the next rod and a' = a + l (u - |d'|² d) the
acceleration of the tip, the balances of moments about the joint and of forces are
    J u = P (m h (field - a) + h f - l F') + M x d,    F = m (a + h (u - |d'|² d)) + F' - m field - f,
P = 1 - d d^T, J = I1 + m h²; f and M are external. Solved for u and F they give A and b (docs/derivation_chain.md,
section 8, has the same balances with all reactions as unknowns). K = J + l² P A' P is inverted: positive definite
at every position, so nothing is singular at phi = ±pi/2. A is made symmetric after each rod: what rounding leaves of an
antisymmetric part would grow threefold from rod to rod.
"""

from typing import Any, NamedTuple

import numpy as np

from pendpin.equations.chain.kinematics import ChainInertia
from pendpin.equations.trees import inward, joined, outward
from pendpin.ground.arrays import Array, applied, cross, dot, outer, symmetric

_UNIT = np.eye(3)


class ThinRods(NamedTuple):
    """What the recursion needs of a chain of thin rods, from the support down, each array (n,)."""

    m: Array  # kg
    h: Array  # m, centre of mass from the joint
    l: Array  # m, next joint from the joint  # noqa: E741
    I1: Array  # kg m², central, across the rod


class _Answer(NamedTuple):
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


def turning(
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

    def release(i: int, hanging: _Hanging) -> tuple[_Hanging, _Answer]:
        m, h, length, J = chain.m[i], chain.h[i], chain.l[i], chain.I1[i] + chain.m[i] * chain.h[i] ** 2
        A, b = hanging
        f = m * field + (0.0 if force is None else force[i])
        inward_part = d[i] * dot(rate[i], rate[i])
        B = m * h * _UNIT + length * A
        P = _UNIT - outer(d[i], d[i])
        Y = _inverse(J * _UNIT + length**2 * (P @ A @ P)) @ P
        c = h * f + length * (length * applied(A, inward_part) - b)
        if moment is not None:
            c = c + cross(moment[i], d[i])
        through = B @ P @ Y
        A, b = symmetric(m * _UNIT + A - through @ B), applied(through, c) - applied(B, inward_part) + b - f
        hanging = _Hanging(A, b)
        return hanging, _Answer(P, Y, c, B, hanging, inward_part)

    def move(i: int, a: Array) -> tuple[Array, tuple[Array, Array]]:
        """From the support to the last rod: omega', and the force."""
        P, Y, c, B, (A, b), inward_part = answers[i]
        u = applied(Y, c - applied(B, a))
        return a + chain.l[i] * (applied(P, u) - inward_part), (cross(d[i], u), applied(A, a) + b)

    parents, nothing = range(-1, len(d) - 1), _Hanging(np.zeros((3, 3)), np.zeros(3))
    answers = inward(release, [nothing] * len(d), joined, parents, xp)
    turned, forces = zip(*outward(move, np.zeros(3), parents, xp), strict=True)
    return np.stack(turned), np.stack(forces)


def _inverse(M: Array) -> Array:
    """The inverse of a symmetric (3, 3) matrix, by cofactors."""
    cofactors = np.stack([cross(M[1], M[2]), cross(M[2], M[0]), cross(M[0], M[1])])
    return cofactors * (1 / dot(M[0], cofactors[0]))
