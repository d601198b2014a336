"""Energies of chains, for the laws of their equations."""

import numpy as np

from pendpin.equations.chain import kinematics
from pendpin.equations.chain.kinematics import ChainInertia


def energy(chain: ChainInertia, q: np.ndarray, v: np.ndarray, field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Kinetic and potential energy (...) in J; the potential of the uniform field (3,), in I, is 0 at the support."""
    moving = kinematics.motion(chain, q, v)
    return kinematics.kinetic_energy(chain, moving), -(chain.m * (moving.centres @ field)).sum(-1)


def thin_energy(
    chain: ChainInertia, d: np.ndarray, rate: np.ndarray, field: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The same for directions d, d' (..., n, 3) of thin rods."""
    (centres, _), (velocities, _) = (kinematics.place_along(chain, x) for x in (d, rate))
    kinetic = chain.m * (velocities**2).sum(-1) + chain.I1 * (rate**2).sum(-1)
    return 0.5 * kinetic.sum(-1), -(chain.m * (centres @ field)).sum(-1)
