"""Three rods in Pinocchio, MuJoCo and Drake, from one URDF text: the same model, the same accelerations.

Pinocchio is the one to compare with; other tests compare it with 50 digits. The states are random, all angles, rates up to
some rad/s. What the text needs so that all three read the same model is said in `urdf_of`.
"""

from importlib.util import find_spec

import numpy as np
import pinocchio as pin
import pytest

missing = [name for name in ("mujoco", "pydrake") if find_spec(name) is None]
pytestmark = pytest.mark.skipif(bool(missing), reason=f"not installed: {', '.join(missing)} (extra `peers`)")

RODS = [(1.0, 1.0, 0.1), (0.7, 2.0, 0.1), (1.3, 0.5, 0.2)]  # length m, mass kg, radius m
STATES = 2 * np.random.default_rng(0).normal(size=(200, 2, 2 * len(RODS)))


# --- the text -------------------------------------------------------------------------------------------------------


def urdf_of(rods):
    """Rods on universal joints, hanging from `support`; to be replaced by pendpin's own writer.

    - The massless link `cross` has an <inertial> of zeros: without one, MuJoCo puts its centre of mass at the link's
      offset from its parent.
    - MuJoCo refuses moving bodies without mass, also zeros; <mujoco><compiler boundmass boundinertia> lets it take the
      least that it takes, 1e-15 kg and kg m². The other two skip this element.
    - No <collision>: the cross is between rods that share a point; they are no neighbours and MuJoCo lets them collide.
    - No massless link at the tip: MuJoCo gives it the bound too, and refuses to fuse it with a rod without radius.
    - `revolute` with wide limits: Pinocchio makes two numbers, cos and sin, of a `continuous` joint.
    """
    text = '<mujoco><compiler boundmass="1e-15" boundinertia="1e-15"/></mujoco><link name="support"/>'
    parent, place = "support", 0.0
    for i, rod in enumerate(rods, start=1):
        text += joint(f"theta_{i}", parent, f"cross_{i}", place, "-1 0 0") + link(f"cross_{i}")
        text += joint(f"phi_{i}", f"cross_{i}", f"rod_{i}", 0.0, "0 -1 0") + link(f"rod_{i}", *rod)
        parent, place = f"rod_{i}", -rod[0]
    return f'<robot name="chain">{text}</robot>'


def joint(name, parent, child, z, axis):
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 {z!r}"/><axis xyz="{axis}"/>'
        '<limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/></joint>'
    )


def link(name, length=0.0, mass=0.0, radius=0.0):
    transverse, axial = mass * (3 * radius**2 + length**2) / 12, mass * radius**2 / 2
    return (
        f'<link name="{name}"><inertial><origin xyz="0 0 {-length / 2!r}"/><mass value="{mass!r}"/>'
        f'<inertia ixx="{transverse!r}" iyy="{transverse!r}" izz="{axial!r}" ixy="0" ixz="0" iyz="0"/>'
        "</inertial></link>"
    )


# --- the simulators -------------------------------------------------------------------------------------------------


def by_pinocchio(text, states):
    model = pin.buildModelFromXML(text)
    data, none = model.createData(), [pin.Force.Zero()] * model.njoints
    return [pin.aba(model, data, q, v, 0 * v, none, pin.Convention.LOCAL).copy() for q, v in states]


def by_mujoco(text, states, massless=True):
    """Accelerations of mj_forward; massless clears what boundmass and boundinertia have put on the crosses."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(text)
    if massless:
        light = model.body_mass <= 1e-15
        model.body_mass[light] = 0
        model.body_inertia[light] = 0
    data, out = mujoco.MjData(model), []
    for q, v in states:
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_forward(model, data)
        assert data.ncon == data.nefc == 0
        out.append(data.qacc.copy())
    return out


def by_drake(text, states):
    """Accelerations of a plant in continuous time."""
    plant, out = drake_plant(text), []
    context = plant.CreateDefaultContext()
    for q, v in states:
        plant.SetPositionsAndVelocities(context, np.concatenate([q, v]))
        out.append(plant.EvalTimeDerivatives(context).get_generalized_velocity().CopyToVector())
    return out


def drake_plant(text):
    """The URDF's first link has to be welded to the world: Drake lets it float."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant = MultibodyPlant(time_step=0.0)
    Parser(plant).AddModelsFromString(text, "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("support"))
    plant.Finalize()
    return plant


def worst(peer, text, states, **settings):
    """The largest relative difference from Pinocchio, state by state."""
    pairs = zip(peer(text, states, **settings), by_pinocchio(text, states), strict=True)
    return max(np.abs(theirs - ours).max() / np.abs(ours).max() for theirs, ours in pairs)


# --- laws -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("peer", [by_mujoco, by_drake])
def test_accelerations_of_three_rods(peer):
    assert worst(peer, urdf_of(RODS), STATES) < 2e-13


def test_mujoco_as_loaded():
    """The 1e-15 kg m² that MuJoCo needs on each cross are seen in the twelfth digit at most."""
    assert worst(by_mujoco, urdf_of(RODS), STATES, massless=False) < 1e-12


@pytest.mark.parametrize("peer", [by_mujoco, by_drake])
def test_thin_rods(peer):
    """Radius 0 loads too; away from the poles, where thin rods have no second inertia, the accelerations agree."""
    states = STATES[:, :, :4] * [[0.3], [1]]
    assert worst(peer, urdf_of([(1.0, 1.0, 0.0), (0.7, 2.0, 0.0)]), states) < 1e-11


def test_names_and_masses():
    """The three see the same joints in the same order, the same mass and the same gravity."""
    import mujoco

    text = urdf_of(RODS)
    plant = drake_plant(text)
    model, other = pin.buildModelFromXML(text), mujoco.MjModel.from_xml_string(text)
    names = list(model.names)[1:]
    assert names == [other.joint(i).name for i in range(other.njnt)]
    assert [f"{name}_q" for name in names] == plant.GetPositionNames(add_model_instance_prefix=False)
    masses = (
        sum(i.mass for i in model.inertias),
        other.body_mass.sum(),
        plant.CalcTotalMass(plant.CreateDefaultContext()),
    )
    np.testing.assert_allclose(masses, 3.5, rtol=1e-14)
    np.testing.assert_array_equal(other.opt.gravity, model.gravity.linear)
    np.testing.assert_array_equal(plant.gravity_field().gravity_vector(), model.gravity.linear)
