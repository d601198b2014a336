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

from typing import NamedTuple

import numpy as np

from pendpin.arrays import Array, applied, dot, outer, symmetric
from pendpin.equations.chain.inertia import ChainInertia

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
    Y: Array  # (3, 3), K^-1 P; 1 / J for the last rod, where K = J
    c: Array  # (3,)
    B: Array  # (3, 3), m h + l A'
    inward: Array  # (3,), |d'|² d


def turning(
    chain: ThinRods | ChainInertia,
    d: Array,
    rate: Array,
    field: Array,
    force: Array | None = None,
    moment: Array | None = None,
) -> Array:
    """omega' = d x d'' (n, 3) in I, rad/s², from unit directions d (n, 3), rates d' (n, 3) in 1/s, and a field (3,) in I.

    force and moment (n, 3), external, in N and N m, the moment about the centre of mass and normal to the rod.
    """
    n, answers = len(d), []
    A, b = np.zeros((3, 3)), np.zeros(3)  # of what hangs on the tip
    for i in reversed(range(n)):
        m, h, length, J = chain.m[i], chain.h[i], chain.l[i], chain.I1[i] + chain.m[i] * chain.h[i] ** 2
        f = m * field + (0.0 if force is None else force[i])
        inward = d[i] * dot(rate[i], rate[i])
        B = m * h * _UNIT + length * A
        P = _UNIT - outer(d[i], d[i])
        Y = _UNIT / J if i == n - 1 else _inverse(J * _UNIT + length**2 * (P @ A @ P)) @ P
        c = h * f + length * (length * applied(A, inward) - b)
        if moment is not None:
            c = c + np.cross(moment[i], d[i])
        answers.append(_Answer(P, Y, c, B, inward))
        through = B @ P @ Y
        A, b = symmetric(m * _UNIT + A - through @ B), applied(through, c) - applied(B, inward) + b - f
    return _outward(chain, d, answers[::-1])


def _inverse(M: Array) -> Array:
    """The inverse of a symmetric (3, 3) matrix, by cofactors."""
    cofactors = np.stack([np.cross(M[1], M[2]), np.cross(M[2], M[0]), np.cross(M[0], M[1])])
    return cofactors / dot(M[0], cofactors[0])


def _outward(chain: ThinRods | ChainInertia, d: Array, answers: list[_Answer]) -> Array:
    """omega' (n, 3) in rad/s², from the support to the last rod."""
    a, out = np.zeros(3), []
    for i, (P, Y, c, B, inward) in enumerate(answers):
        u = applied(Y, c - applied(B, a))
        a = a + chain.l[i] * (applied(P, u) - inward)
        out.append(np.cross(d[i], u))
    return np.stack(out)
