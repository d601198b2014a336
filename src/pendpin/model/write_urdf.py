"""A chain of rods as a URDF.

The text loads to the same model in Pinocchio, MuJoCo and Drake. For MuJoCo, which refuses moving bodies without mass,
it sets the least mass and inertia (1e-15, the twelfth digit of the accelerations of rods of 1 kg and 1 m); the other two
skip that element. The massless links have an <inertial> of zeros, since without one MuJoCo places their centre of mass
elsewhere; there is no <collision>, since MuJoCo would let rods that share a point collide; and no massless link at the
tip, which it would give a mass. Drake users weld the link `support` to the world.
"""

from collections.abc import Iterable
from xml.etree import ElementTree

from pendpin.model.build import chain_names
from pendpin.model.urdf_xml import Element, put
from pendpin.scene import Chain, Rod

_COLORS = {"steel": "0.48 0.53 0.59 1", "copper": "0.85 0.38 0.17 1"}
_PAYLOAD_RADIUS = 0.03  # of the rod's length, as drawn


def chain_urdf(chain: Chain) -> str:
    """The URDF of a chain: for each rod two revolute joints with a massless link between, rods along -z."""
    robot = Element("robot", name="chain")
    ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler", boundmass="1e-15", boundinertia="1e-15")
    for name, rgba in _COLORS.items():
        ElementTree.SubElement(ElementTree.SubElement(robot, "material", name=name), "color", rgba=rgba)
    ElementTree.SubElement(robot, "link", name="support")
    parent, z = "support", 0.0
    for rod, (theta, phi, link) in zip(chain.all_rods, chain_names(chain.count), strict=True):
        cross = f"cross{link.removeprefix('rod')}"
        _joint(robot, theta, parent, cross, z, (-1, 0, 0))
        _inertial(ElementTree.SubElement(robot, "link", name=cross), 0.0, 0.0, (0.0, 0.0, 0.0))
        _joint(robot, phi, cross, link, 0.0, (0, -1, 0))
        _rod(ElementTree.SubElement(robot, "link", name=link), rod)
        parent, z = link, -rod.length
    ElementTree.indent(robot)
    return f'<?xml version="1.0"?>\n{ElementTree.tostring(robot, encoding="unicode")}\n'


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


def _rod(link: Element, rod: Rod) -> None:
    m, h, *principal = rod.properties
    _inertial(link, m, -h, principal)
    radius = rod.radius or 0.002 * rod.length  # a thin rod is drawn all the same
    _visual(link, -rod.length / 2, "cylinder", radius=radius, length=rod.length)
    if rod.payload:
        _visual(link, -rod.length, "sphere", radius=_PAYLOAD_RADIUS * rod.length)


def _visual(link: Element, z: float, shape: str, **sizes: float) -> None:
    visual = ElementTree.SubElement(link, "visual")
    put(ElementTree.SubElement(visual, "origin"), "xyz", (0, 0, z))
    geometry = ElementTree.SubElement(visual, "geometry")
    ElementTree.SubElement(geometry, shape, {key: repr(float(size)) for key, size in sizes.items()})
    ElementTree.SubElement(visual, "material", name="copper" if shape == "cylinder" else "steel")
