"""Body effects in Pinocchio's terms: from its kinematics to the motion of the bodies, from wrenches to its forces."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from pendpin.bodies import Body, pinocchio
from pendpin.derivations.base import Array
from pendpin.effects import Motion


def external_forces(
    data: Any, bodies: Sequence[Body], joints: Sequence[int], wrench: Callable[[Motion], tuple[Array, Array]]
) -> list[Any]:
    """One pin.Force a joint, in its frame, at its origin, from data whose forward kinematics has run.

    joints are the bodies' places in Pinocchio's model; wrench gives forces N and moments N m about com, (n, 3), in W.
    """
    pin = pinocchio()
    motion = _motion(data, joints)
    out = [pin.Force.Zero() for _ in range(len(data.oMi))]
    for joint, body, R, force, moment in zip(joints, bodies, motion.rotation, *wrench(motion), strict=True):
        linear = R.T @ force
        out[joint] = pin.Force(linear, R.T @ moment + np.cross(body.com, linear))
    return out


def _motion(data: Any, joints: Sequence[int]) -> Motion:
    R = np.array([data.oMi[joint].rotation for joint in joints])
    twists = np.array([data.v[joint].vector for joint in joints])
    velocity, spin = (np.einsum("nij,nj->ni", R, part) for part in (twists[:, :3], twists[:, 3:]))
    return Motion(np.array([data.oMi[joint].translation for joint in joints]), R, velocity, spin)
