"""One URDF text that MuJoCo, Drake and Pinocchio read as the same model."""

from xml.etree import ElementTree

from pendpin.errors import InputError
from pendpin.model.read_urdf import read_urdf
from pendpin.model.urdf_xml import Element, has_inertia
from pendpin.model.write_models import chain_urdf
from pendpin.scene import Chain, PinModel, UrdfModel

LEAST = 1e-15  # kg and kg m² of a moving body: what MuJoCo takes
_TENSOR = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def same_for_all(model: Chain | UrdfModel | PinModel) -> tuple[str, str]:
    """The model that pendpin simulates, without what is only drawn and what it leaves out, and the link it hangs on.

    MuJoCo gives every massless body the least that it takes. Where such a link is fixed to another and carries none, it
    is left out; the others say that they have no mass, as MuJoCo would else place its centre apart.
    """
    if isinstance(model, PinModel):
        raise InputError("model: other simulators take a chain of rods or a URDF, and this is a pin.Model")
    robot = ElementTree.fromstring(chain_urdf(model) if isinstance(model, Chain) else read_urdf(model).text)
    for joint in robot.findall("joint"):
        _drop(joint, joint.findall("dynamics"))
    _drop(robot, robot.findall("mujoco"))
    while tips := _massless_tips(robot):
        _drop(robot, tips)
    hanging = {child.get("link") for child in robot.iterfind("joint/child")}
    root = next(name for link in robot.iterfind("link") if (name := link.get("name", "")) not in hanging)
    for link in robot.findall("link"):
        _drop(link, link.findall("visual"))
        if link.get("name") == root:
            _drop(link, link.findall("inertial"))  # it stands still
        elif link.find("inertial") is None:
            inertial = ElementTree.SubElement(link, "inertial")
            ElementTree.SubElement(inertial, "mass", value="0")
            ElementTree.SubElement(inertial, "inertia", dict.fromkeys(_TENSOR, "0"))
    least = {"boundmass": repr(LEAST), "boundinertia": repr(LEAST)}
    ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler", least)
    return ElementTree.tostring(robot, encoding="unicode"), root


def _drop(parent: Element, children: list[Element]) -> None:
    for child in children:
        parent.remove(child)


def _massless_tips(robot: Element) -> list[Element]:
    """The massless links that are fixed to another and carry none, with their joints."""
    carriers = {parent.get("link") for parent in robot.iterfind("joint/parent")}
    fixed = {c.get("link"): joint for joint in robot.iterfind("joint[@type='fixed']") for c in joint.iterfind("child")}
    tips = []
    for link in robot.iterfind("link"):
        name = link.get("name")
        if name in fixed and name not in carriers and not has_inertia(link):
            tips += [link, fixed[name]]
    return tips
