"""Where the bodies are: poses of the links and positions of the tips, from a model and its angles."""

import numpy as np

from pendpin.derivations.base import Array
from pendpin.model import Model, pinocchio


def poses(model: Model, q: Array) -> Array:
    """Poses of the links that the joints move, (n, joints, 4, 4) in W, from q (n, nv)."""
    pin = pinocchio()
    data = model.pin.createData()
    out = np.empty((len(q), len(model.joints), 4, 4))
    for sample, angles in zip(out, q, strict=True):
        pin.forwardKinematics(model.pin, data, angles)
        for joint in range(len(model.joints)):
            sample[joint] = data.oMi[joint + 1].homogeneous
    return out


def tips(model: Model, link_poses: Array) -> Array:
    """Positions of the tips, (n, rods, 3) in m in W, from the poses of the links."""
    joints = [tip.joint for tip in model.tips]
    offsets = np.array([tip.offset for tip in model.tips])
    T = link_poses[:, joints]
    return T[..., :3, 3] + np.einsum("nrij,rj->nri", T[..., :3, :3], offsets)
