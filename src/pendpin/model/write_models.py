"""A model written for others: a chain as a URDF, any model as MJCF or SDF."""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from pendpin.equations.trees import Tree
from pendpin.errors import InputError
from pendpin.ground.arrays import Array
from pendpin.model.bodies import pinocchio, tree_of
from pendpin.model.build import Model, chain_names
from pendpin.model.urdf import Element, put
from pendpin.scene import Chain

LEAST = "1e-15"  # kg, kg m²: MuJoCo refuses moving bodies with less
POINT = 1e-12  # of a unit vector or a length in m: what rounding may leave of a translation or a rotation
_COLORS = {"steel": "0.48 0.53 0.59 1", "copper": "0.85 0.38 0.17 1"}
_PAYLOAD_RADIUS = 0.03  # of the rod's length, as drawn


def chain_urdf(chain: Chain) -> str:
    """The URDF of rods, along -z: a hinge is a revolute joint, a universal one two with a massless link between."""
    robot = Element("robot", name="chain")
    ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler", boundmass="1e-15", boundinertia="1e-15")
    for name, rgba in _COLORS.items():
        ElementTree.SubElement(ElementTree.SubElement(robot, "material", name=name), "color", rgba=rgba)
    ElementTree.SubElement(robot, "link", name="support")
    names = chain_names(chain.count)
    for rod, above, at, (theta, phi, link) in zip(chain.all_rods, chain.parents, chain.places, names, strict=True):
        parent, z = names[above][2] if above >= 0 else "support", 0.0 - at
        if rod.turns == "universal":
            cross = f"cross{link.removeprefix('rod')}"
            _joint(robot, theta, parent, cross, z, (-1, 0, 0))
            _inertial(ElementTree.SubElement(robot, "link", name=cross), 0.0, 0.0, (0.0, 0.0, 0.0))
            parent, z = cross, 0.0
        own, axis = (theta, (-1, 0, 0)) if rod.turns == "x" else (phi, (0, -1, 0))
        _joint(robot, own, parent, link, z, axis)
        element = ElementTree.SubElement(robot, "link", name=link)
        m, h, *principal = rod.properties
        _inertial(element, m, -h, principal)
        radius = rod.radius or 0.002 * rod.length  # a thin rod is drawn all the same
        _visual(element, -rod.length / 2, "cylinder", radius=radius, length=rod.length)
        if rod.payload:
            _visual(element, -rod.length, "sphere", radius=rod.payload_radius or _PAYLOAD_RADIUS * rod.length)
    return _text(robot)


def _joint(robot: Element, name: str, parent: str, child: str, z: float, axis: Iterable[float]) -> None:
    joint = ElementTree.SubElement(robot, "joint", name=name, type="revolute")
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)
    put(ElementTree.SubElement(joint, "origin"), "xyz", (0, 0, z))
    put(ElementTree.SubElement(joint, "axis"), "xyz", axis)
    ElementTree.SubElement(joint, "limit", lower="-1e9", upper="1e9", effort="1e9", velocity="1e9")


def _inertial(link: Element, mass: float, z: float, principal: Iterable[float]) -> None:
    inertial = ElementTree.SubElement(link, "inertial")
    put(ElementTree.SubElement(inertial, "origin"), "xyz", (0, 0, z))
    put(ElementTree.SubElement(inertial, "mass"), "value", (mass,))
    values = dict(zip(("ixx", "iyy", "izz"), principal, strict=True)) | {"ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
    ElementTree.SubElement(inertial, "inertia", {key: repr(float(value)) for key, value in values.items()})


def _visual(link: Element, z: float, shape: str, **sizes: float) -> None:
    visual = ElementTree.SubElement(link, "visual")
    put(ElementTree.SubElement(visual, "origin"), "xyz", (0, 0, z))
    geometry = ElementTree.SubElement(visual, "geometry")
    ElementTree.SubElement(geometry, shape, {key: repr(float(size)) for key, size in sizes.items()})
    ElementTree.SubElement(visual, "material", name="copper" if shape == "cylinder" else "steel")


# --- a model as MJCF and as SDF, for other engines; URDF is above ---------------------------------------


class _Link(NamedTuple):
    """What one or two joints at one point move."""

    joints: tuple[int, ...]  # in the order in which they turn
    parent: int  # the joint that moves what it hangs on; -1 for the world
    R: Array  # (3, 3), the pose of its frame in the parent's
    r: Array  # (3,) m

    @property
    def body(self) -> int:
        """The joint whose body it is."""
        return self.joints[-1]


def _links(tree: Tree, names: Sequence[str], format_name: str) -> list[_Link]:
    """The bodies with inertia; a massless one between two joints at a point is part of the next. InputError."""
    links, above = [], dict[int, int]()
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
        first = above.get(i, i)
        joints = (first, i) if first != i else (i,)
        links.append(_Link(joints, tree.parents[first], tree.rotations[first], tree.translations[first]))
    return links


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value) + 0.0) for value in np.ravel(np.asarray(values, float)))


def mjcf(model: Model, gravity: Array, damping: Mapping[str, float]) -> str:
    """The model as MJCF, in a field (3,) m/s², with damping N m s/rad by joint. InputError without a mass."""
    from scipy.spatial.transform import Rotation

    tree, names = tree_of(model.pin), model.joints
    links = _links(tree, names, "MJCF")
    root = Element("mujoco", model="pendpin")
    options = {"angle": "radian", "boundmass": LEAST, "boundinertia": LEAST, "autolimits": "false"}
    ElementTree.SubElement(root, "compiler", options)
    flags = ElementTree.SubElement(ElementTree.SubElement(root, "option", gravity=_numbers(gravity)), "flag")
    flags.set("contact", "disable")
    places = {-1: ElementTree.SubElement(root, "worldbody")}
    for link in links:
        body = ElementTree.SubElement(places[link.parent], "body", name=f"moved_by_{names[link.body]}")
        body.set("pos", _numbers(link.r))
        body.set("quat", _numbers(np.roll(Rotation.from_matrix(link.R).as_quat(), 1)))  # w, x, y, z
        I = tree.inertias[link.body]  # noqa: E741
        mass, com = repr(float(tree.masses[link.body])), _numbers(tree.coms[link.body])
        inertial = ElementTree.SubElement(body, "inertial", pos=com, mass=mass)
        if np.count_nonzero(I - np.diag(np.diag(I))):
            inertial.set("fullinertia", _numbers((I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2])))
        else:
            inertial.set("diaginertia", _numbers(np.diag(I)))
        for joint in link.joints:
            kind = "hinge" if tree.kinds[joint] == "revolute" else "slide"
            hinge = ElementTree.SubElement(body, "joint", name=names[joint], type=kind, axis=_numbers(tree.axes[joint]))
            if names[joint] in damping:
                hinge.set("damping", repr(damping[names[joint]]))
        places[link.body] = body
    return _text(root)


def sdf(model: Model, damping: Mapping[str, float]) -> str:
    """The model as SDF 1.9, hung on the world, with viscous damping of joints, N m s/rad, by name.

    Two perpendicular hinges at one point are one universal joint, named by both with __ between. Gravity belongs to an
    SDF world and is not in the model. Raises InputError for a body with no mass or a moment of inertia of 0, and for a
    universal joint with two dampings, of which Drake takes one.
    """
    tree, names = tree_of(model.pin), model.joints
    links = _links(tree, names, "SDF")
    root = Element("sdf", version="1.9")
    out = ElementTree.SubElement(root, "model", name="pendpin")
    link_of = {-1: "world"} | {link.body: f"moved_by_{names[link.body]}" for link in links}
    for link in links:
        if np.linalg.eigvalsh(tree.inertias[link.body]).min() <= 0:
            raise InputError(f"SDF takes no moment of inertia of 0, and joint {names[link.body]} moves such a body")
        element = ElementTree.SubElement(out, "link", name=link_of[link.body])
        pose = ElementTree.SubElement(element, "pose")
        if link.parent >= 0:
            pose.set("relative_to", link_of[link.parent])
        pose.text = _numbers([*link.r, *pinocchio().rpy.matrixToRpy(link.R)])
        inertial = ElementTree.SubElement(element, "inertial")
        ElementTree.SubElement(inertial, "pose").text = _numbers([*tree.coms[link.body], 0, 0, 0])
        ElementTree.SubElement(inertial, "mass").text = repr(float(tree.masses[link.body]))
        inertia = ElementTree.SubElement(inertial, "inertia")
        for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
            cell = ElementTree.SubElement(inertia, f"i{'xyz'[i]}{'xyz'[j]}")
            cell.text = repr(float(tree.inertias[link.body][i, j]))
        joint = ElementTree.SubElement(out, "joint", name="__".join(names[joint] for joint in link.joints))
        joint.set("type", _sdf_kind(tree, link, names, damping))
        ElementTree.SubElement(joint, "parent").text = link_of[link.parent]
        ElementTree.SubElement(joint, "child").text = link_of[link.body]
        for i, tag in zip(link.joints, ("axis", "axis2"), strict=False):
            axis = ElementTree.SubElement(joint, tag)
            ElementTree.SubElement(axis, "xyz").text = _numbers(tree.axes[i])
            if names[i] in damping:
                element = ElementTree.SubElement(ElementTree.SubElement(axis, "dynamics"), "damping")
                element.text = repr(damping[names[i]])
    return _text(root)


def _sdf_kind(tree: Tree, link: _Link, names: Sequence[str], damping: Mapping[str, float]) -> str:
    """SDF's type of joint. Raises InputError for two joints that are no universal one."""
    if len(link.joints) == 1:
        return tree.kinds[link.body]
    if abs(tree.axes[link.joints[0]] @ tree.axes[link.joints[1]]) > POINT:
        raise InputError(f"SDF's universal joint has perpendicular axes; those of {names[link.body]} are not")
    if len({damping.get(names[joint], 0.0) for joint in link.joints}) > 1:
        both = " and ".join(names[joint] for joint in link.joints)
        raise InputError(f"{both} have two dampings, and Drake takes one of SDF's universal joint; MJCF carries both")
    return "universal"


def _text(root: Element) -> str:
    ElementTree.indent(root)
    return f'<?xml version="1.0"?>\n{ElementTree.tostring(root, encoding="unicode")}\n'
