"""Drake in a folder of `pendpin reference`: copy this file there as engine.py, then run pytest."""

import json
from xml.etree import ElementTree

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant


def compute(folder, joints, q, v):
    """Accelerations, mass matrix, wrenches and kinetic energy, from the URDF.

    Drake's potential energy counts what is fixed to the world too, so it is not compared.
    """
    plant = load(folder)
    order = [plant.GetJointByName(name) for name in joints]
    at_q, at_v = ([getattr(joint, name)() for joint in order] for name in ("position_start", "velocity_start"))
    context = plant.CreateDefaultContext()
    positions, velocities = np.empty(len(q)), np.empty(len(v))
    positions[at_q], velocities[at_v] = q, v
    plant.SetPositions(context, positions)
    plant.SetVelocities(context, velocities)
    a = plant.EvalTimeDerivatives(context).get_generalized_velocity().CopyToVector()
    reactions = plant.get_reaction_forces_output_port().Eval(context)
    wrench = [reactions[int(joint.index())] for joint in order]
    return {
        "a": a[at_v],
        "mass_matrix": plant.CalcMassMatrix(context)[np.ix_(at_v, at_v)],
        "wrench": np.array([np.concatenate([w.translational(), w.rotational()]) for w in wrench]),
        "kinetic": plant.CalcKineticEnergy(context),
    }


def load(folder):
    """The model, its root welded to the world, in the field of gravity of the reference."""
    if not (folder / "model.urdf").exists():  # nor does Drake read the MJCF to the same mass matrix
        raise ValueError("no model.urdf: engines ignore a URDF's damping; compare this folder by mujoco_engine.py")
    text = (folder / "model.urdf").read_text()
    robot = ElementTree.fromstring(text)
    children = {child.get("link") for child in robot.iter("child")}
    (root,) = [link.get("name") for link in robot.findall("link") if link.get("name") not in children]
    plant = MultibodyPlant(time_step=0.0)
    Parser(plant).AddModelsFromString(text, "urdf")
    if root != "world":  # which is the world to Drake; it lets any other root float
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(root))
    gravity = json.loads((folder / "reference.json").read_text())["conventions"]["gravity"]
    plant.mutable_gravity_field().set_gravity_vector(gravity)
    plant.Finalize()
    return plant
