"""A pin.Model of one's own as pendpin computes with it: each joint one plain angle or slide, no gravity of its own."""

from typing import Any

import numpy as np

from pendpin.errors import InputError, shown
from pendpin.model.bodies import append_body, pinocchio, twist_of
from pendpin.model.urdf_written import WrittenJoint, limits


def plain_copy(value: Any) -> Any:
    """A pin.Model with the same joints as revolute and prismatic ones, links and frames. Raises InputError for others."""
    pin = pinocchio()
    if value.njoints < 2:
        raise InputError("model: the pin.Model has no joint")
    model = pin.Model()
    model.name, model.gravity = value.name, pin.Motion.Zero()
    for i in range(1, value.njoints):
        name = value.names[i]
        joint = _joint(value.joints[i], name)
        model.addJoint(value.parents[i], joint, value.jointPlacements[i], name)
        body = value.inertias[i]
        if not np.isfinite([body.mass, *body.lever, *np.ravel(body.inertia)]).all() or body.mass < 0:
            raise InputError(
                f"model: what joint {shown(name)} moves has the mass {body.mass:g} kg, or inertia that is not finite"
            )
        append_body(model, i, body)
    for frame in list(value.frames)[1:]:
        if frame.type != pin.FrameType.JOINT:
            model.addFrame(pin.Frame(frame.name, frame.parentJoint, 0, frame.placement, frame.type), False)
    return model


def _joint(joint: Any, name: str) -> Any:
    """A joint as a revolute or prismatic one about the same axis."""
    pin = pinocchio()
    if joint.nv == 1:
        slide, turn = np.split(twist_of(joint), 2)
        if slide.any() != turn.any():
            return pin.JointModelRevoluteUnaligned(*turn) if turn.any() else pin.JointModelPrismaticUnaligned(*slide)
    raise InputError(
        f"model: joint {shown(name)} is a {joint.shortname()}; pendpin takes revolute, continuous and prismatic joints "
        "(a universal joint as two revolute ones)"
    )


def written_joints(value: Any) -> tuple[WrittenJoint, ...]:
    """The damping, dry friction and position limits that a pin.Model carries; continuous joints have no limits."""
    return tuple(_written(value, joint, value.names[joint.id]) for joint in list(value.joints)[1:])


def _written(value: Any, joint: Any, name: str) -> WrittenJoint:
    v, q = joint.idx_v, joint.idx_q
    lower, upper = (value.lowerPositionLimit[q], value.upperPositionLimit[q]) if joint.nq == 1 else (0.0, 0.0)
    return WrittenJoint(name, value.damping[v], value.friction[v], *limits(lower, upper))
