"""What the columns of the data measure, in terms of joints and tips."""

from typing import NamedTuple

import numpy as np

from pendpin.arrays import Array
from pendpin.errors import InputError, choices, shown
from pendpin.model.build import Model, find
from pendpin.scene import Data

_AXES = ("x", "y", "z")


class Sensors(NamedTuple):
    """Columns as sums of joint angles (columns, nv) and of tip coordinates (columns, 3 bodies)."""

    angles: Array
    tips: Array

    @property
    def joints(self) -> list[int]:
        """The joints that columns measure, in model order."""
        return np.flatnonzero(self.angles.any(0)).tolist()

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
        else:
            for joint in measured:
                angles[row, model.index(joint, where)] += 1.0
    return Sensors(angles, tips)


def _tip(text: str, model: Model, where: str) -> int:
    link, dot, axis = text.rpartition(".")
    if not dot or axis not in _AXES:
        raise InputError(
            f"{where}: {shown(text)} is no coordinate of a tip: write a link and {choices(_AXES)}: rod_1.y"
        )
    links = tuple(body.link for body in model.bodies)
    alias = {"rod_1": "rod"} if links == ("rod",) else {}
    return 3 * find(links, alias.get(link, link), f"{where}: link") + _AXES.index(axis)
