"""Body effects in Pinocchio's terms: from its kinematics to the motion of the bodies, from wrenches to its forces."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from pendpin.arrays import Array, cross
from pendpin.effects import Motion
from pendpin.model.bodies import Body, pinocchio


def external_forces(
    data: Any, bodies: Sequence[Body], joints: Sequence[int], wrench: Callable[[Motion], tuple[Array, Array]]
) -> list[Any]:
    """One pin.Force a joint, in its frame, at its origin, from data whose forward kinematics has run.

    joints are the bodies' places in Pinocchio's model; wrench gives forces N and moments N m about com, (n, 3), in W.
    """
    pin, motion = pinocchio(), motion_of(data, joints)
    R, com = motion.rotation, np.array([body.com for body in bodies])
    linear, angular = ((part[:, None] @ R)[:, 0] for part in wrench(motion))  # R^T x
    out = [pin.Force.Zero()] * len(data.oMi)
    for joint, both in zip(joints, np.concatenate([linear, angular + cross(com, linear)], -1), strict=True):
        out[joint] = pin.Force(both)
    return out


def motion_of(data: Any, joints: Sequence[int]) -> Motion:
    """The motion of bodies from data whose forward kinematics has run; joints are their places in the model."""
    R = np.array([data.oMi[joint].rotation for joint in joints])
    twists = np.array([data.v[joint].vector for joint in joints]).reshape(-1, 2, 3)
    velocity, spin = (twists @ R.swapaxes(-1, -2)).swapaxes(0, 1)  # R x
    return Motion(np.array([data.oMi[joint].translation for joint in joints]), R, velocity, spin)
