"""Body effects in Pinocchio's terms: from its kinematics to the motion of the bodies, from wrenches to its forces."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from pendpin.arrays import Array, cross
from pendpin.effects import Motion
from pendpin.model.bodies import Body, pinocchio

Wrench = Callable[[Motion], tuple[Array, Array]]  # force N and moment N m about com, (n, 3), W


def external_forces(
    model: Any, data: Any, q: Array, v: Array, bodies: Sequence[Body], joints: Sequence[int], wrench: Wrench
) -> list[Any]:
    """One pin.Force a joint, in its frame, at its origin, at Pinocchio's q (nq,) and v (nv,).

    joints are the bodies' places in Pinocchio's model; wrench gives forces N and moments N m about com, (n, 3), in W.
    """
    pin = pinocchio()
    pin.forwardKinematics(model, data, q, v)
    motion = motion_of(data, joints)
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


def joints_of(bodies: Sequence[Body]) -> list[int]:
    """The places of bodies in Pinocchio's model on revolute and prismatic joints."""
    return [body.joint + 1 for body in bodies]
