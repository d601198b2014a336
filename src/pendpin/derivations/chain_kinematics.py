"""A chain's frames, positions, velocities and energies from its angles (docs/derivation_chain.md, sections 1 and 2).

Nothing here loops over the rods: what runs down the chain (frames, angular velocities) is a bidiagonal system of 3 x 3
blocks and is solved forward by LAPACK, what adds up along it (positions) is a cumulative sum. A batch of states is one
long row of rods. Inside this family of modules components come first and rods last, (3, K); outside, rods come
first, (..., n, 3).
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import as_strided
from scipy.linalg import lapack

from pendpin.derivations.base import Array
from pendpin.derivations.chain_inertia import ChainInertia

CHUNK = 1 << 15  # rods handled at once by the functions for pictures and energies, to bound their memory


class Joints(NamedTuple):
    """All joints at one state: sines and cosines of both angles, and the turn from each rod's frame to its parent's."""

    n: int  # rods in a chain
    s_t: Array  # (K,) sin(theta)
    c_t: Array  # (K,)
    s: Array  # (K,) sin(phi)
    c: Array  # (K,)
    R: Array  # (3, 3, K): columns are b1, b2, b3 of the rod in the frame of the rod above (of the first, in I)

    @property
    def links(self) -> Array:
        """(n', 9)"""
        return self.R


def rods_last(x: Array) -> Array:
    """(..., n, i) -> (i, K), contiguous."""
    return np.ascontiguousarray(x.reshape(-1, x.shape[-1]).T)
