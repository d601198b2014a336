"""Positions of a run as Pinocchio's own functions take them."""

from typing import Any

import numpy as np

from pendpin.errors import InputError, did_you_mean, shown
from pendpin.ground.arrays import Array
from pendpin.model.bodies import pinocchio
from pendpin.trajectory import RunRecord


def configurations(run: RunRecord, pin_model: Any) -> Array:
    """As `Trajectory.configurations`: a joint of the model that the run lacks stands where it is locked, or at neutral.

    Raises InputError for a model that is not a pin.Model, and for a joint of the run that the model lacks, or has in
    another kind.
    """
    pin = pinocchio()
    if not isinstance(pin_model, pin.Model):
        raise InputError(f"configurations: {shown(pin_model)} is not a pin.Model")
    names = list(pin_model.names)[1:]
    if lost := [name for name in run.joints if name not in names]:
        raise InputError(f"configurations: the pin.Model has no joint {shown(lost[0])}{did_you_mean(lost[0], names)}")
    out = np.tile(pin.neutral(pin_model), (len(run.t), 1))
    places = {name: run.q[:, j] for j, name in enumerate(run.joints)}
    places |= {name: np.full(len(run.t), float(at)) for name, at in (run.scene["model"].get("lock") or {}).items()}
    for joint, name in enumerate(names, 1):
        if name in places:
            first, size = pin_model.idx_qs[joint], pin_model.nqs[joint]
            out[:, first : first + size] = _numbers(places[name], size, name)
    return out


def _numbers(angle: Array, size: int, name: str) -> Array:
    """The numbers of one joint, (n, size): an angle or slide, or the cosine and sine of an angle."""
    if size == 1:
        return angle[:, None]
    if size != 2:
        raise InputError(f"configurations: joint {shown(name)} takes {size} numbers in the pin.Model, and 1 in the run")
    return np.stack([np.cos(angle), np.sin(angle)], -1)
