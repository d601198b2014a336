"""Body effects in Pinocchio's terms: from its kinematics to the motion of the bodies, from wrenches to its forces."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from pendpin.effects import Motion
from pendpin.ground.arrays import Array, cross
from pendpin.model.bodies import Body, pinocchio

Wrench = Callable[[Motion], tuple[Array, Array]]  # force N and moment N m about com, (n, 3), W


def external_forces(
    model: Any, data: Any, q: Array, v: Array, com: Array, joints: Sequence[int], wrench: Wrench
) -> list[Any]:
    """One pin.Force a joint, in its frame, at its origin, at Pinocchio's q (nq,) and v (nv,).

    com (n, 3) m are the bodies' centres of mass, joints their places in Pinocchio's model; wrench gives forces N and
    moments N m about com, (n, 3), in W.
    """
    pinocchio().forwardKinematics(model, data, q, v)
    motion = motion_of(data, joints)
    return forces(turn_into_joint_frames(com, motion, *wrench(motion)), joints, len(data.oMi))


def turn_into_joint_frames(com: Array, motion: Motion, force: Array, moment: Array) -> Array:
    """Forces and moments (..., n, 3) in W about the centres of mass com (n, 3) as wrenches (..., n, 6) of the joints.

    Those are about the joints' origins, in the joints' frames, in which com is given too.
    """
    linear, angular = ((part[..., None, :] @ motion.rotation)[..., 0, :] for part in (force, moment))  # R^T x
    return np.concatenate([linear, angular + cross(com, linear)], -1)


def forces(wrenches: Array, joints: Sequence[int], count: int) -> list[Any]:
    """One pin.Force for each of `count` joints of Pinocchio's model, from wrenches (n, 6) on those at `joints`."""
    pin = pinocchio()
    out = [pin.Force.Zero()] * count
    for joint, wrench in zip(joints, wrenches, strict=True):
        out[joint] = pin.Force(wrench)
    return out


def motion_of(data: Any, joints: Sequence[int]) -> Motion:
    """The motion of bodies from data whose forward kinematics has run; joints are their places in the model."""
    R = np.array([data.oMi[joint].rotation for joint in joints])
    twists = np.array([data.v[joint].vector for joint in joints]).reshape(-1, 2, 3)
    velocity, spin = (twists @ R.swapaxes(-1, -2)).swapaxes(0, 1)  # R x
    return Motion(np.array([data.oMi[joint].translation for joint in joints]), R, velocity, spin)


def centres_of(bodies: Sequence[Body]) -> Array:
    """The centres of mass of bodies, (n, 3) m, in their link frames."""
    return np.array([body.com for body in bodies])


def joints_of(bodies: Sequence[Body]) -> list[int]:
    """The places of bodies in Pinocchio's model on revolute and prismatic joints."""
    return [body.joint + 1 for body in bodies]
