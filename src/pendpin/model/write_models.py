"""A model written for others: a chain as a URDF, any model as MJCF or SDF."""

from collections.abc import Mapping, Sequence
from typing import Any
from xml.etree import ElementTree

import numpy as np

from pendpin.equations.trees import Tree
from pendpin.errors import InputError
from pendpin.ground.arrays import Array
from pendpin.model.bodies import pinocchio
from pendpin.model.build import Model, chain_names
from pendpin.model.urdf import Element
from pendpin.scene import Chain

LEAST = "1e-15"  # kg, kg m²: MuJoCo refuses moving bodies with less
POINT = 1e-12  # of a unit vector or a length in m: what rounding may leave of a translation or a rotation


def _add(parent: Element, tag: str, text: Any = None, **attributes: Any) -> Element:
    """A new element in another; numbers in its text and attributes are written with every digit."""
    element = ElementTree.SubElement(parent, tag, {key: _written(value) for key, value in attributes.items()})
    element.text = None if text is None else _written(text)
    return element


def _written(value: Any) -> str:
    return value if isinstance(value, str) else " ".join(repr(float(number)) for number in np.ravel(value))


def chain_urdf(chain: Chain) -> str:
    """The URDF of rods, along -z: a hinge is a revolute joint, a universal one two with a massless link between."""
    robot = Element("robot", name="chain")
    _add(_add(robot, "mujoco"), "compiler", boundmass=LEAST, boundinertia=LEAST)
    for name, rgba in (("steel", "0.48 0.53 0.59 1"), ("copper", "0.85 0.38 0.17 1")):
        _add(_add(robot, "material", name=name), "color", rgba=rgba)
    _add(robot, "link", name="support")

    def hang(name: str, parent: str, child: str, z: float, axis: Sequence[int]) -> Element:
        """The link `child` on a joint at a height z of its parent."""
        joint = _add(robot, "joint", name=name, type="revolute")
        _add(joint, "parent", link=parent)
        _add(joint, "child", link=child)
        _add(joint, "origin", xyz=(0, 0, z))
        _add(joint, "axis", xyz=axis)
        _add(joint, "limit", lower="-1e9", upper="1e9", effort="1e9", velocity="1e9")
        return _add(robot, "link", name=child)

    names = chain_names(chain.count)
    for rod, above, at, (theta, phi, link) in zip(chain.all_rods, chain.parents, chain.places, names, strict=True):
        parent, z = names[above][2] if above >= 0 else "support", 0.0 - at
        if rod.turns == "universal":
            cross = f"cross{link.removeprefix('rod')}"
            _add_inertial(hang(theta, parent, cross, z, (-1, 0, 0)), 0.0, 0.0, (0.0, 0.0, 0.0))
            parent, z = cross, 0.0
        own, axis = (theta, (-1, 0, 0)) if rod.turns == "x" else (phi, (0, -1, 0))
        element = hang(own, parent, link, z, axis)
        m, h, *principal = rod.properties
        _add_inertial(element, m, -h, principal)
        radius = rod.radius or 0.002 * rod.length  # a thin rod is drawn all the same
        shapes = [("cylinder", "copper", -rod.length / 2, {"radius": radius, "length": rod.length})]
        if rod.payload:
            shapes.append(("sphere", "steel", -rod.length, {"radius": rod.payload_radius or 0.03 * rod.length}))
        for shape, material, height, sizes in shapes:
            visual = _add(element, "visual")
            _add(visual, "origin", xyz=(0, 0, height))
            _add(_add(visual, "geometry"), shape, **sizes)
            _add(visual, "material", name=material)
    return _text(robot)


def _add_inertial(link: Element, mass: float, z: float, principal: Sequence[float]) -> None:
    inertial = _add(link, "inertial")
    _add(inertial, "origin", xyz=(0, 0, z))
    _add(inertial, "mass", value=mass)
    ixx, iyy, izz = principal
    _add(inertial, "inertia", ixx=ixx, iyy=iyy, izz=izz, ixy=0, ixz=0, iyz=0)


# --- a model as MJCF and as SDF, for other engines; URDF is above ---------------------------------------


def _joints_of_bodies(tree: Tree, names: Sequence[str], format_name: str) -> list[tuple[int, ...]]:
    """The one or two joints, in their order, that move each body at one point: no massless body is left. InputError."""
    joints, above = [], dict[int, int]()
    for i, parent in enumerate(tree.parents):
        if parent < 0 or tree.kinds[i] != "revolute" or tree.kinds[parent] != "revolute":
            continue
        massless = tree.masses[parent] == 0 and not tree.inertias[parent].any() and tree.parents.count(parent) == 1
        apart = max(np.abs(tree.translations[i]).max(), np.abs(tree.rotations[i] - np.eye(3)).max())
        if massless and apart <= POINT:
            above[i] = parent
    for i in (i for i in range(len(tree.parents)) if i not in above.values()):
        if not tree.masses[i] > 0:
            raise InputError(f"{format_name} takes no massless body, and joint {names[i]} moves one")
        joints.append((above[i], i) if i in above else (i,))
    return joints


def mjcf(model: Model, gravity: Array, damping: Mapping[str, float]) -> str:
    """The model as MJCF, in a field (3,) m/s², with damping N m s/rad by joint. InputError without a mass."""
    from scipy.spatial.transform import Rotation

    tree, names = model.tree, model.joints
    bodies = _joints_of_bodies(tree, names, "MJCF")
    root = Element("mujoco", model="pendpin")
    _add(root, "compiler", angle="radian", boundmass=LEAST, boundinertia=LEAST, autolimits="false")
    _add(_add(root, "option", gravity=gravity + 0.0), "flag", contact="disable")  # + 0.0 clears the sign of zeros
    places = {-1: _add(root, "worldbody")}
    for joints in bodies:
        first, last = joints[0], joints[-1]
        parent, position = places[tree.parents[first]], tree.translations[first] + 0.0
        quaternion = np.roll(Rotation.from_matrix(tree.rotations[first]).as_quat(), 1) + 0.0  # w, x, y, z
        body = _add(parent, "body", name=f"moved_by_{names[last]}", pos=position, quat=quaternion)
        I = tree.inertias[last] + 0.0  # noqa: E741
        moments = {"diaginertia": np.diag(I)}
        if np.count_nonzero(I - np.diag(np.diag(I))):
            moments = {"fullinertia": (I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2])}
        _add(body, "inertial", pos=tree.coms[last] + 0.0, mass=tree.masses[last], **moments)
        for joint in joints:
            kind = "hinge" if tree.kinds[joint] == "revolute" else "slide"
            damped = {"damping": damping[names[joint]]} if names[joint] in damping else {}
            _add(body, "joint", name=names[joint], type=kind, axis=tree.axes[joint] + 0.0, **damped)
        places[last] = body
    return _text(root)


def sdf(model: Model, damping: Mapping[str, float]) -> str:
    """The model as SDF 1.9, hung on the world, with viscous damping of joints, N m s/rad, by name.

    Two perpendicular hinges at one point are one universal joint, named by both with __ between. Gravity belongs to an
    SDF world and is not in the model. Raises InputError for a body with no mass or a moment of inertia of 0, and for a
    universal joint with two dampings, of which Drake takes one.
    """
    tree, names = model.tree, model.joints
    bodies = _joints_of_bodies(tree, names, "SDF")
    root = Element("sdf", version="1.9")
    out = _add(root, "model", name="pendpin")
    link_of = {-1: "world"} | {last: f"moved_by_{names[last]}" for *_, last in bodies}
    for joints in bodies:
        first, last = joints[0], joints[-1]
        parent, inertia = tree.parents[first], tree.inertias[last]
        if np.linalg.eigvalsh(inertia).min() <= 0:
            raise InputError(f"SDF takes no moment of inertia of 0, and joint {names[last]} moves such a body")
        element = _add(out, "link", name=link_of[last])
        relative = {"relative_to": link_of[parent]} if parent >= 0 else {}
        angles = pinocchio().rpy.matrixToRpy(tree.rotations[first])
        _add(element, "pose", np.array([*tree.translations[first], *angles]) + 0.0, **relative)
        inertial = _add(element, "inertial")
        _add(inertial, "pose", np.array([*tree.coms[last], 0, 0, 0]) + 0.0)
        _add(inertial, "mass", tree.masses[last])
        moments = _add(inertial, "inertia")
        for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
            _add(moments, f"i{'xyz'[i]}{'xyz'[j]}", inertia[i, j])
        kind, own = tree.kinds[first], [names[joint] for joint in joints]
        if len(joints) == 2:
            kind = "universal"
            if abs(tree.axes[first] @ tree.axes[last]) > POINT:
                raise InputError(f"SDF's universal joint has perpendicular axes; those of {own[1]} are not")
            if damping.get(own[0], 0.0) != damping.get(own[1], 0.0):
                two = f"{' and '.join(own)} have two dampings"
                raise InputError(f"{two}, and Drake takes one of SDF's universal joint; MJCF carries both")
        joint = _add(out, "joint", name="__".join(own), type=kind)
        _add(joint, "parent", link_of[parent])
        _add(joint, "child", link_of[last])
        for i, tag in zip(joints, ("axis", "axis2"), strict=False):
            axis = _add(joint, tag)
            _add(axis, "xyz", tree.axes[i] + 0.0)
            if names[i] in damping:
                _add(_add(axis, "dynamics"), "damping", damping[names[i]])
    return _text(root)


def _text(root: Element) -> str:
    ElementTree.indent(root)
    return f'<?xml version="1.0"?>\n{ElementTree.tostring(root, encoding="unicode")}\n'
