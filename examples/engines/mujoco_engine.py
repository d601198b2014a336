"""MuJoCo in a folder of `pendpin reference`: copy this file there as engine.py, then run pytest."""

import mujoco
import numpy as np


def compute(folder, joints, q, v):
    """Accelerations, mass matrix, energies, and the wrench of the last joint of each body."""
    model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY.value
    model.body_inertia[model.body_inertia <= 1e-15] = 0.0  # what MuJoCo adds to rods without axial inertia
    data = mujoco.MjData(model)
    at_q = [model.joint(name).qposadr[0] for name in joints]
    at_v = [model.joint(name).dofadr[0] for name in joints]
    data.qpos[at_q], data.qvel[at_v] = q, v
    mujoco.mj_forward(model, data)
    mujoco.mj_rnePostConstraint(model, data)
    full = np.empty((model.nv, model.nv))
    if hasattr(data, "qM"):  # before MuJoCo 4
        mujoco.mj_fullM(model, full, data.qM)
    else:
        mujoco.mj_fullM(model, data, full)
    return {
        "a": data.qacc[at_v],
        "mass_matrix": full[np.ix_(at_v, at_v)],
        "wrench": wrenches(model, data, joints),
        "kinetic": data.energy[1],
        "potential": data.energy[0],
    }


def wrenches(model, data, joints):
    """Force and moment at the body's origin, in its frame, (nv, 6); NaN for a joint that is not the last of its body."""
    out = np.full((len(joints), 6), np.nan)
    for row, name in enumerate(joints):
        body = model.joint(name).bodyid[0]
        last = model.body_jntadr[body] + model.body_jntnum[body] - 1
        if model.joint(name).id != last:
            continue
        moment, force = np.split(data.cfrc_int[body], 2)
        arm = data.subtree_com[model.body_rootid[body]] - data.xpos[body]
        R = data.xmat[body].reshape(3, 3)
        out[row] = np.concatenate([R.T @ force, R.T @ (moment + np.cross(arm, force))])
    return out
