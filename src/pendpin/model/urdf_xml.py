"""A URDF's XML: parsed without the tricks that XML allows, its numbers checked, and written again in plain form."""

import re
import sys
from collections.abc import Iterable, Iterator
from xml.etree import ElementTree
from xml.parsers import expat

from pendpin.errors import InputError, did_you_mean, shown
from pendpin.ground.records import LARGEST_SIZE

Element = ElementTree.Element

_BLANK = " \t\r\n"  # other spaces of Unicode do not separate in XML
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_ONLY_COMPARED = {"limit", "axis"}  # or made a unit vector
_KEPT = {  # what Pinocchio gets to see
    "origin": ("xyz", "rpy"),
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "parent": ("link",),
    "child": ("link",),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "effort", "velocity"),
    "dynamics": ("damping", "friction"),
}
_CHILDREN = {  # what the URDF specification knows inside links and joints
    "link": "inertial visual collision",
    "joint": "origin parent child axis calibration dynamics limit mimic safety_controller",
    "inertial": "origin mass inertia",
    "visual": "origin geometry material",
    "collision": "origin geometry verbose",
    "geometry": "box cylinder sphere capsule mesh",
    "material": "color texture",
}
_ATTRIBUTES = {
    **{tag: " ".join(keys) for tag, keys in _KEPT.items()},
    "link": "name type",
    "joint": "name type",
    "mimic": "joint multiplier offset",
    "box": "size",
    "cylinder": "radius length",
    "sphere": "radius",
    "mesh": "filename scale",
    "color": "rgba",
}


def parse(data: bytes) -> Element:
    """The <robot> of a URDF. Raises InputError for anything else."""
    if not data.strip():
        raise InputError("the file is empty")
    try:
        _refuse_doctype(data)
        robot = ElementTree.fromstring(data)
    except (ElementTree.ParseError, expat.ExpatError) as error:
        raise InputError(f"not well-formed XML: {str(error).removeprefix('not well-formed ')}") from None
    except (ValueError, LookupError) as error:  # an encoding that is not known or not text
        raise InputError(f"not readable as XML: {error}") from None
    if robot.tag != "robot":
        if robot.tag == "mujoco":
            raise InputError("it is an MJCF file: Scene(model=pinocchio.buildModelFromMJCF(file)) reads it")
        raise InputError(f"the root element is <{shown(robot.tag)[1:-1]}>; a URDF's is <robot>")
    if any("xacro" in element.tag for element in robot.iter()):
        raise InputError(
            "it is a xacro file: expand it (xacro FILE > robot.urdf) and give pendpin the URDF that comes out"
        )
    return robot


def _refuse_doctype(data: bytes) -> None:
    """Read the text as far as a DOCTYPE, where entities would be declared that grow without bound or read files."""

    def refuse(*_: object) -> None:
        raise InputError("a URDF has no DOCTYPE and no entities; remove them")

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse
    parser.Parse(data, True)


def named(robot: Element, tag: str) -> dict[str, Element]:
    """The elements of one kind by name. Raises InputError where a name is absent or there twice."""
    elements: dict[str, Element] = {}
    for element in robot.findall(tag):
        name = element.get("name", "")
        if not name.strip():
            raise InputError(f"a <{tag}> has no name")
        if name in elements:
            raise InputError(f"two {tag}s are named {shown(name)}")
        elements[name] = element
    return elements


def misspelt(elements: dict[str, Element]) -> Iterator[str]:
    """The unknown names in links or joints that are a slip away from a name of URDF; those of extensions are not."""
    for name, element in elements.items():
        yield from _slips(f"{element.tag} {shown(name)}", element)


def _slips(where: str, element: Element) -> Iterator[str]:
    children, keys = (names.get(element.tag, "").split() for names in (_CHILDREN, _ATTRIBUTES))
    absent = [key for key in keys if key not in element.attrib]  # beside the right name it is an extension
    for key in element.attrib:
        if key not in keys and (hint := _nearest(key, absent)):
            yield f"{where}: {shown(key)} is not an attribute of <{element.tag}>{hint}"
    for child in element:
        if child.tag in children:
            yield from _slips(where, child)
        elif hint := _nearest(child.tag, children):
            yield f"{where}: {shown(child.tag)} is not an element of <{element.tag}>{hint}"


def _nearest(name: str, known: Iterable[str]) -> str:
    """A longer name is another one, such as gear_velocity of a vendor."""
    return did_you_mean(name, (word for word in known if abs(len(word) - len(name)) < 2))


def needed(where: str, element: Element, tag: str) -> Element:
    """The first child of this kind. Raises InputError if there is none."""
    child = element.find(tag)
    if child is None:
        raise InputError(f"{where}: <{element.tag}> has no <{tag}>")
    return child


def has_inertia(link: Element) -> bool:
    """Whether a link has a mass or an inertia other than zero."""
    parts = [*link.iterfind("inertial/mass"), *link.iterfind("inertial/inertia")]
    return any(float(value) for part in parts for value in part.attrib.values())


def number(where: str, element: Element, key: str) -> float:
    """A finite number, which the element then holds in plain form. Raises InputError."""
    text = element.get(key)
    if text is None:
        raise InputError(f"{where}: <{element.tag}> has no {key}")
    value = _read(where, element, key, text.strip(_BLANK))
    element.set(key, repr(value))
    return value


def triple(where: str, element: Element, key: str) -> tuple[float, float, float]:
    """Three finite numbers, which the element then holds in plain form; zeros where the key is absent."""
    x, y, z = numbers(where, element, key, 3) or (0.0, 0.0, 0.0)
    return x, y, z


def numbers(where: str, element: Element, key: str, count: int) -> tuple[float, ...]:
    """This number of finite values, which the element then holds in plain form; none where the key is absent."""
    text = element.get(key)
    if text is None:
        return ()
    parts = [part for part in re.split(f"[{_BLANK}]+", text) if part]
    values = tuple(_read(where, element, key, part) for part in parts)
    if len(values) != count:
        raise InputError(f"{where}: {element.tag} {key}: {shown(text)} is not {count} numbers with spaces between")
    put(element, key, values)
    return values


def put(element: Element, key: str, values: Iterable[float]) -> None:
    """Write numbers into an element, every digit of them."""
    element.set(key, " ".join(repr(float(value)) for value in values))


def _read(where: str, element: Element, key: str, text: str) -> float:
    what = f"{where}: {element.tag} {key}: {shown(text)}"
    if not _NUMBER.fullmatch(text):
        comma = "; it has a comma" if "," in text else ""
        raise InputError(f"{what} is not a number such as 1.5 or 2e-3{comma}")
    value = float(text)
    most = sys.float_info.max if element.tag in _ONLY_COMPARED else LARGEST_SIZE
    if abs(value) > most:
        raise InputError(f"{what} is too large to compute with; the most is {most:.2g}")
    return value


def plain(links: dict[str, Element], joints: dict[str, Element]) -> str:
    """The text of a URDF with these links and joints and nothing else: what was checked is what Pinocchio reads."""
    robot = ElementTree.Element("robot", name="robot")
    for name, link in links.items():
        copy = ElementTree.SubElement(robot, "link", name=name)
        inertial = link.find("inertial")
        if inertial is not None:
            _keep(ElementTree.SubElement(copy, "inertial"), inertial)
    for name, joint in joints.items():
        _keep(ElementTree.SubElement(robot, "joint", name=name, type=joint.get("type", "")), joint)
    return ElementTree.tostring(robot, encoding="unicode")


def _keep(copy: Element, element: Element) -> None:
    for tag, keys in _KEPT.items():
        child = element.find(tag)
        if child is not None:
            ElementTree.SubElement(copy, tag, {key: child.get(key, "") for key in keys if key in child.attrib})
