"""What the columns of the data measure, in terms of joints and tips."""

from typing import NamedTuple

import numpy as np

from pendpin.errors import InputError, choices, shown
from pendpin.ground.arrays import Array
from pendpin.model import kinematics
from pendpin.model.build import Model, find
from pendpin.scene import Data

_AXES = ("x", "y", "z")
SENSITIVE = 1e-9  # m/rad


class Sensors(NamedTuple):
    """Columns as sums of joint angles (columns, nv) and of tip coordinates (columns, 3 bodies)."""

    angles: Array
    tips: Array
    joints: list[int]  # those that columns measure, in model order: of tips, those that move one from the zero position

    def of(self, joints: tuple[int, ...]) -> Array:
        """Columns as sums of the outputs of equations with these joints: their angles, then tips if any is measured."""
        angles = self.angles[:, list(joints)]
        return np.hstack([angles, self.tips]) if self.tips.any() else angles


def sensors_of(table: Data, model: Model) -> Sensors:
    """What the columns of a scene's [data] table measure. Raises InputError for joints and links the model lacks."""
    angles = np.zeros((len(table.columns), len(model.joints)))
    tips = np.zeros((len(table.columns), 3 * len(model.bodies)))
    for row, (name, measured) in enumerate(table.columns.items()):
        where = f"data.columns.{name}"
        if isinstance(measured, str):
            tips[row, _tip(measured, model, where)] = 1.0
        elif not measured:
            raise InputError(f"{where}: it names no joint")
        elif len(set(measured)) < len(measured):
            raise InputError(f"{where}: it names a joint twice")
        else:
            for joint in measured:
                angles[row, model.index(joint, where)] += 1.0
    measured = angles.any(0) | (np.abs(tips @ _tips_by_joints(model)) > SENSITIVE).any(0)
    return Sensors(angles, tips, np.flatnonzero(measured).tolist())


def _tips_by_joints(model: Model) -> Array:
    """The derivatives (3 bodies, nv) of the tips by the joints' positions, at zero."""
    step, ends = 1e-6, np.array([[*body.tip, 1.0] for body in model.bodies])
    moved = [kinematics.poses(model, side * step * np.eye(len(model.joints))) for side in (1.0, -1.0)]
    plus, minus = ((poses @ ends[:, :, None])[:, :, :3, 0].reshape(len(poses), -1) for poses in moved)
    return (plus - minus).T / (2 * step)


def _tip(text: str, model: Model, where: str) -> int:
    link, dot, axis = text.rpartition(".")
    if not dot or axis not in _AXES:
        raise InputError(
            f"{where}: {shown(text)} is not a coordinate of a tip; write a link and {choices(_AXES)}, such as rod_1.y, "
            f"or a joint in brackets: [{shown(text)}]"
        )
    links = tuple(body.link for body in model.bodies)
    alias = {"rod_1": "rod"} if links == ("rod",) else {}
    return 3 * find(links, alias.get(link, link), f"{where}: link") + _AXES.index(axis)
