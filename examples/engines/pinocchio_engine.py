"""Plain Pinocchio in a folder of `pendpin reference`: copy this file there as engine.py, then run pytest."""

import json

import numpy as np
import pinocchio as pin


def compute(folder, joints, q, v):
    """Accelerations, mass matrix, wrenches and energies, in the order of the joints in reference.json."""
    if not (folder / "model.urdf").exists():
        raise ValueError("no model.urdf: Pinocchio ignores a URDF's damping; compare this folder by mujoco_engine.py")
    model = pin.buildModelFromUrdf(str(folder / "model.urdf"))
    gravity = json.loads((folder / "reference.json").read_text())["conventions"]["gravity"]
    model.gravity = pin.Motion(np.array(gravity), np.zeros(3))
    data, order = model.createData(), [model.getJointId(name) for name in joints]
    at = [model.joints[joint].idx_v for joint in order]
    own_q, own_v = np.empty(model.nq), np.empty(model.nv)
    own_q[at], own_v[at] = q, v
    a = pin.aba(model, data, own_q, own_v, np.zeros(model.nv)).copy()
    pin.rnea(model, data, own_q, own_v, a)
    wrench = np.array([data.f[joint].vector for joint in order])
    upper = np.triu(pin.crba(model, data, own_q))
    return {
        "a": a[at],
        "mass_matrix": (upper + np.triu(upper, 1).T)[np.ix_(at, at)],
        "wrench": wrench,
        "kinetic": pin.computeKineticEnergy(model, data, own_q, own_v),
        "potential": pin.computePotentialEnergy(model, data, own_q),
    }
