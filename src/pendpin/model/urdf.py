"""Reading a URDF: every number and every connection is checked before Pinocchio sees the text.

Pinocchio's own reader takes broken numbers, lost branches and impossible inertia in silence (docs/pinocchio_notes.md).
"""

import math
import os
import re
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from pendpin.errors import InputError, choices, did_you_mean, inside, not_one_of, shown, shown_path
from pendpin.ground.arrays import Array
from pendpin.ground.files import read_whole
from pendpin.ground.records import LARGEST_SIZE
from pendpin.model.bodies import LEAST_MASS, WrittenJoint, acting_limits, mass_unit, pinocchio
from pendpin.scene import UrdfModel

Element = ElementTree.Element

MAX_BYTES = 8_000_000
MAX_LINKS = 10_000
MAX_DEPTH = 1_000  # links in a row; Pinocchio's reader recurses and dies far below 5,000
MOST_LISTED = 3  # joints in a note
JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed")
_ROUNDING = 1e-3  # of the sum of all three: what numbers written with four digits may miss in the triangle inequality
_NEGATIVE = 1e-9  # of the largest: what rounding may leave below zero
_BLANK = " \t\r\n"  # other spaces of Unicode do not separate in XML
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_NO_LIMIT = {"lower": "-1e300", "upper": "1e300", "effort": "1e300", "velocity": "1e300"}
_SHAPES = ("box", "cylinder", "sphere", "mesh", "capsule")
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_INERTIAL = ("inertial/mass", "inertial/inertia")  # of a link: the elements that hold its mass and its moments
_KNOWN = {  # what the URDF specification knows inside an element, and its attributes
    "link": ("inertial visual collision", "name type"),
    "joint": ("origin parent child axis calibration dynamics limit mimic safety_controller", "name type"),
    "inertial": ("origin mass inertia", ""),
    "visual": ("origin geometry material", ""),
    "collision": ("origin geometry verbose", ""),
    "geometry": ("box cylinder sphere capsule mesh", ""),
    "material": ("color texture", ""),
    "origin": ("", "xyz rpy"),
    "mass": ("", "value"),
    "inertia": ("", "ixx ixy ixz iyy iyz izz"),
    "parent": ("", "link"),
    "child": ("", "link"),
    "axis": ("", "xyz"),
    "limit": ("", "lower upper effort velocity"),
    "dynamics": ("", "damping friction"),
    "mimic": ("", "joint multiplier offset"),
    "box": ("", "size"),
    "cylinder": ("", "radius length"),
    "capsule": ("", "radius length"),
    "sphere": ("", "radius"),
    "mesh": ("", "filename scale"),
    "color": ("", "rgba"),
}
_KEPT = ("origin", "mass", "inertia", "parent", "child", "axis", "limit", "dynamics")  # what Pinocchio gets to see


class Urdf(NamedTuple):
    """A URDF that passed every check, as Pinocchio gets it: continuous joints as revolute ones, axes of unit length."""

    source: str
    text: str
    findings: tuple[str, ...]  # what is implausible, and computed as written
    notes: tuple[str, ...]  # what the file says and pendpin leaves out, for the user to know
    written: tuple[WrittenJoint, ...]  # what it says of the joints that move
    drawn: dict[str, tuple[Array, float]]  # of a link's longest drawn rod: ends (2, 3) m, radius
    unit: float  # kg, of the masses in the text


def content(model: UrdfModel) -> bytes:
    """What the file of a model holds. Raises InputError."""
    with inside(shown_path(model.file)):
        return read_whole(model.file, MAX_BYTES, "a URDF")


def read_urdf(model: UrdfModel) -> Urdf:
    """Read and check the URDF of a model, locked joints made fixed. InputError; what is implausible is a finding."""
    with inside(shown_path(model.file)):
        robot = parse(content(model))
        links, joints = _named(robot, "link"), _named(robot, "joint")
        if not links:
            raise InputError("it has no <link>")
        if len(links) > MAX_LINKS:
            raise InputError(f"it has {len(links)} links; the limit is {MAX_LINKS}")
        for material in robot.findall("material"):
            for color in material.findall("color")[:1]:
                _numbers(f"material {shown(material.get('name', ''))}", color, "rgba", 4, ())
        rods = {name: _read_drawing(f"link {shown(name)}", link) for name, link in links.items()}
        inertias = {name: _read_inertia(f"link {shown(name)}", link) for name, link in links.items()}
        written = {name: _read_joint(name, joint, links) for name, joint in joints.items()}
        above, carrying, moves = _check_tree(links, joints), set[str](), _moving(joints)
        for at in (name for name, link in links.items() if has_inertia(link)):
            while at in above and above[at][0] not in carrying:
                joint, at = above[at]
                carrying.add(joint)
        massless = [name for name in moves if name not in carrying] if carrying.intersection(moves) else []
        notes = _freeze_joints(joints, dict.fromkeys(massless, 0.0) | model.lock, model.mimic)
        moving = tuple(written[name] for name in _moving(joints))
        if not moving:
            raise InputError("no joint of it can move: at least one revolute, continuous or prismatic joint is needed")
        findings = []
        for element in (*links.values(), *joints.values()):
            findings += _slips(f"{element.tag} {shown(element.get('name', ''))}", element)
        if alone := [name for name in massless if name not in model.lock]:
            more = f" and {len(alone) - 6} more" * (len(alone) > 6)
            joint, its, they = ("joint", "its", "it is") if len(alone) == 1 else ("joints", "their", "they are")
            which = f"{joint} {choices(map(shown, alone[:6]))}{more} can move massless links only"
            findings.append(f"{which}: {its} motion is undefined and moves nothing else; {they} locked at 0")
        for name, numbers in inertias.items():
            if reason := _implausible(*numbers):
                says = "no real body has this inertia; accelerations are computed as written"
                findings.append(f"link {shown(name)}: {reason}: {says}")
        names = [mesh.get("filename", "") for link in links.values() for mesh in link.iterfind("visual/geometry/mesh")]
        lost = [name for name in dict.fromkeys(names) if mesh_file(model.file.parent, name) is None]
        if lost:
            many = f"{len(lost)} meshes, {shown(lost[0])} the first, are"
            which = f"mesh {shown(lost[0])} is" if len(lost) == 1 else many
            notes.append(f"{which} not found and will not be drawn")
        unit = mass_unit([mass for mass, _ in inertias.values()], [abs(x).max() for _, x in inertias.values()])
        heavy = (part for link in links.values() for path in _INERTIAL for part in link.iterfind(path))
        for part in heavy if unit != 1.0 else ():
            for key in ("value", *_MOMENTS):
                if key in part.attrib:
                    part.set(key, repr(float(part.attrib[key]) / unit))
        drawn = {name: rod for name, rod in rods.items() if rod is not None}
        return Urdf(shown_path(model.file), _plain(links, joints), tuple(findings), tuple(notes), moving, drawn, unit)


class _Builder(ElementTree.TreeBuilder):
    """Refuses a DOCTYPE, where entities would be declared that grow without bound or read files."""

    def doctype(self, *_: object) -> None:
        """Refuse what may name other files, or grow without bound."""
        raise InputError("a URDF has no DOCTYPE and no entities; remove them")


def parse(data: bytes) -> Element:
    """The <robot> of a URDF. Raises InputError for anything else."""
    if not data.strip():
        raise InputError("the file is empty")
    try:
        robot = ElementTree.fromstring(data, ElementTree.XMLParser(target=_Builder()))
    except ElementTree.ParseError as error:
        raise InputError(f"not well-formed XML: {str(error).removeprefix('not well-formed ')}") from None
    except (ValueError, LookupError) as error:  # an encoding that is not known or not text
        raise InputError(f"not readable as XML: {error}") from None
    if robot.tag == "mujoco":
        raise InputError("it is an MJCF file: Scene(model=pinocchio.buildModelFromMJCF(file)) reads it")
    if robot.tag != "robot":
        raise InputError(f"the root element is <{shown(robot.tag)[1:-1]}>; a URDF's is <robot>")
    if any("xacro" in element.tag for element in robot.iter()):
        reason = "it is a xacro file: expand it (xacro FILE > robot.urdf) and give pendpin the URDF that comes out"
        raise InputError(reason)
    return robot


def _named(robot: Element, tag: str) -> dict[str, Element]:
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


def _needed(where: str, element: Element, tag: str) -> Element:
    """The first child of this kind. Raises InputError if there is none."""
    child = element.find(tag)
    if child is None:
        raise InputError(f"{where}: <{element.tag}> has no <{tag}>")
    return child


def _numbers(
    where: str, element: Element, key: str, count: int, absent: tuple[float, ...] | None = None
) -> tuple[float, ...]:
    """Finite numbers, which the element then holds in plain form; `absent`, if given, where there is no such key."""
    text = element.get(key)
    if text is None:
        if absent is None:
            raise InputError(f"{where}: <{element.tag}> has no {key}")
        return absent
    values = []
    for part in [text.strip(_BLANK)] if count == 1 else re.findall(f"[^{_BLANK}]+", text):
        what = f"{where}: {element.tag} {key}: {shown(part)}"
        if not _NUMBER.fullmatch(part):
            comma = "; it has a comma" if "," in part else ""
            raise InputError(f"{what} is not a number such as 1.5 or 2e-3{comma}")
        # limits are only compared, and an axis becomes a unit vector
        most = sys.float_info.max if element.tag in {"limit", "axis"} else LARGEST_SIZE
        if abs(float(part)) > most:
            raise InputError(f"{what} is too large to compute with; the most is {most:.2g}")
        values.append(float(part))
    if len(values) != count:
        raise InputError(f"{where}: {element.tag} {key}: {shown(text)} is not {count} numbers with spaces between")
    put(element, key, values)
    return tuple(values)


def put(element: Element, key: str, values: Iterable[float]) -> None:
    """Write numbers into an element, every digit of them."""
    element.set(key, " ".join(repr(float(value)) for value in values))


def _plain(links: Mapping[str, Element], joints: Mapping[str, Element]) -> str:
    """The text of a URDF with these links and joints and nothing else: what was checked is what Pinocchio reads."""
    robot = Element("robot", name="robot")
    copies = []
    for name, link in links.items():
        copy, inertial = ElementTree.SubElement(robot, "link", name=name), link.find("inertial")
        if inertial is not None:
            copies.append((ElementTree.SubElement(copy, "inertial"), inertial))
    for name, joint in joints.items():
        copies.append((ElementTree.SubElement(robot, "joint", name=name, type=joint.get("type", "")), joint))
    for copy, element in copies:
        for child in (child for tag in _KEPT if (child := element.find(tag)) is not None):
            known = _KNOWN[child.tag][1].split()
            ElementTree.SubElement(copy, child.tag, {key: child.get(key, "") for key in known if key in child.attrib})
    return ElementTree.tostring(robot, encoding="unicode")


def _slips(where: str, element: Element) -> Iterator[str]:
    """The unknown names in an element that are a slip away from a name of URDF; those of extensions are not."""

    def nearest(name: str, known: Iterable[str]) -> str:  # a longer name is another one: gear_velocity of a vendor
        return did_you_mean(name, (word for word in known if abs(len(word) - len(name)) < 2))

    children, keys = (names.split() for names in _KNOWN.get(element.tag, ("", "")))
    absent = [key for key in keys if key not in element.attrib]  # beside the right name it is an extension
    for key in element.attrib:
        if key not in keys and (hint := nearest(key, absent)):
            yield f"{where}: {shown(key)} is not an attribute of <{element.tag}>{hint}"
    for child in element:
        if child.tag in children:
            yield from _slips(where, child)
        elif hint := nearest(child.tag, children):
            yield f"{where}: {shown(child.tag)} is not an element of <{element.tag}>{hint}"


def _origin(where: str, element: Element) -> tuple[Array, Array]:
    """xyz in m and rpy in rad, (3,) each, of the <origin>; zeros without one."""
    origin = element.find("origin")
    xyz, rpy = ((0.0,) * 3 if origin is None else _numbers(where, origin, key, 3, (0.0,) * 3) for key in ("xyz", "rpy"))
    return np.array(xyz), np.array(rpy)


def _read_drawing(where: str, link: Element) -> tuple[Array, float] | None:
    """The ends (2, 3) m, in the link's frame, and radius of its longest drawn cylinder, capsule or box; None without."""
    rods = []
    for visual in link.findall("visual"):
        xyz, rpy = _origin(f"{where}: visual", visual)
        shape = next(iter(visual.findall("geometry/*")), None)
        if shape is None or shape.tag not in _SHAPES:
            raise InputError(f"{where}: a visual needs a <geometry> with one of: {choices(_SHAPES)}")
        for color in visual.findall("material/color")[:1]:
            _numbers(f"{where}: visual", color, "rgba", 4, ())
        if shape.tag == "mesh":
            if not shape.get("filename"):
                raise InputError(f"{where}: <mesh> has no filename")
            _numbers(where, shape, "scale", 3, ())
            continue
        sizes = list[float]()
        for key in _KNOWN[shape.tag][1].split():
            sizes += _numbers(where, shape, key, 3 if shape.tag == "box" else 1)
            if min(sizes) < 0:
                raise InputError(f"{where}: {shape.tag} {key}: a size is negative")
        radius, length, axis, width = 0.0, 0.0, 2, 0.0
        if shape.tag == "box":
            axis, (_, width, length) = int(np.argmax(sizes)), sorted(sizes)
        elif shape.tag != "sphere":
            radius, length = sizes
            length, width = length + 2 * radius * (shape.tag == "capsule"), 2 * radius
        if length > width:
            half = pinocchio().rpy.rpyToMatrix(rpy)[:, axis] * (length / 2)
            rods.append((length, xyz + np.array([half, -half]), radius))
    return max(rods, key=lambda rod: rod[0])[1:] if rods else None


def has_inertia(link: Element) -> bool:
    """Whether a link has a mass or an inertia other than zero."""
    return any(float(value) for path in _INERTIAL for part in link.iterfind(path) for value in part.attrib.values())


def _read_inertia(where: str, link: Element) -> tuple[float, Array]:
    """The mass in kg and the central inertia (3, 3) kg m², in the axes of <origin>; zeros without <inertial>."""
    inertial = link.find("inertial")
    if inertial is None:
        return 0.0, np.zeros((3, 3))
    _origin(where, inertial)
    mass = _numbers(where, _needed(where, inertial, "mass"), "value", 1)[0]
    if mass < 0:
        raise InputError(f"{where}: mass {mass:g} kg is negative")
    if 0 < mass < LEAST_MASS:
        reason = f"{where}: mass {mass:g} kg is too small to compute with; the least is {LEAST_MASS:g} kg, or 0"
        raise InputError(reason)
    values = _needed(where, inertial, "inertia")
    xx, xy, xz, yy, yz, zz = (_numbers(where, values, key, 1)[0] for key in _MOMENTS)
    return mass, np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _implausible(mass: float, tensor: Array) -> str | None:
    """Why no real body has this mass in kg and inertia (3, 3) kg m², with the numbers; None if one may."""
    size = np.abs(tensor).max() or 1.0
    small, middle, large = np.linalg.eigvalsh(tensor / size)
    slack = _ROUNDING * (abs(small) + abs(middle) + abs(large))
    a, b, c = (f"{value * size:.6g}" for value in (small, middle, large))
    values = f"principal inertia {a}, {b} and {c} kg m²"
    if mass == 0 and tensor.any():
        return f"{values} with a mass of 0"
    if small < -_NEGATIVE:
        return f"{values}, {a} is negative"
    if large > small + middle + slack:
        return f"{values}, {c} > {a} + {b}"
    return None


def mesh_file(folder: Path, filename: str) -> Path | None:
    """The file that a mesh name of a URDF in `folder` means; package://NAME/... is sought in the folders above it."""
    scheme, _, rest = filename.rpartition("://")
    above = [up / rest.lstrip("/") for up in folder.resolve().parents]
    candidates = [folder / rest] if scheme in {"", "file"} else above
    return next(filter(os.path.isfile, candidates), None)  # no file also for names that no file can have


def _moving(joints: Mapping[str, Element]) -> list[str]:
    return [name for name, joint in joints.items() if joint.get("type") != "fixed"]


def _read_joint(name: str, joint: Element, links: Mapping[str, Element]) -> WrittenJoint:
    """What a joint says of its bearing and limits. Continuous ones become revolute: plain angles; axes get unit length."""
    where, kind = f"joint {shown(name)}", joint.get("type", "")
    if kind not in JOINT_TYPES:
        hint = " (write a universal joint as two revolute joints)" if kind in {"universal", "spherical"} else ""
        raise InputError(f"{where}: type {not_one_of(kind, JOINT_TYPES)}{hint}")
    for end in ("parent", "child"):
        link = _needed(where, joint, end).get("link", "")
        if link not in links:
            raise InputError(f"{where}: its {end} link {shown(link)} does not exist")
    _origin(where, joint)
    if kind == "fixed":
        _fix(joint)
        return WrittenJoint(name, 0.0, 0.0, 0.0, 0.0)
    axis, dynamics, limit = joint.find("axis"), joint.find("dynamics"), joint.find("limit")
    if axis is not None:
        xyz = np.array(_numbers(where, axis, "xyz", 3))
        if not xyz.any():
            raise InputError(f"{where}: axis {axis.get('xyz')} has no direction")
        if abs(math.hypot(*xyz) - 1) > 1e-15:
            xyz /= np.abs(xyz).max()  # then neither overflow nor underflow
            put(axis, "xyz", xyz / np.linalg.norm(xyz))
    damping, friction = (
        0.0 if dynamics is None else _numbers(where, dynamics, key, 1, (0.0,))[0] for key in ("damping", "friction")
    )
    if damping < 0 or friction < 0:
        raise InputError(f"{where}: {'damping' if damping < 0 else 'friction'} is negative")
    if kind == "continuous":
        for written in joint.findall("limit"):
            joint.remove(written)
        joint.set("type", "revolute")
        ElementTree.SubElement(joint, "limit", _NO_LIMIT)
        return WrittenJoint(name, damping, friction, *acting_limits(0.0, 0.0))
    if limit is None:
        raise InputError(f"{where}: a {kind} joint needs <limit lower upper effort velocity>")
    for key in ("effort", "velocity"):
        if _numbers(where, limit, key, 1)[0] < 0:
            raise InputError(f"{where}: limit {key} is negative")
    ((lower,), (upper,)) = (_numbers(where, limit, key, 1, (0.0,)) for key in ("lower", "upper"))
    if lower > upper:
        raise InputError(f"{where}: its limits are swapped: lower {lower:g} > upper {upper:g}")
    return WrittenJoint(name, damping, friction, *acting_limits(lower, upper))


def _fix(joint: Element) -> None:
    """Make a fixed joint of one, which has no axis."""
    joint.set("type", "fixed")
    for unused in (*joint.findall("limit"), *joint.findall("axis"), *joint.findall("dynamics")):
        joint.remove(unused)


def _check_tree(links: Mapping[str, Element], joints: Mapping[str, Element]) -> dict[str, tuple[str, str]]:
    """The joint and the link that each link hangs on. Raises InputError for what is not one tree, or is too deep."""
    above: dict[str, tuple[str, str]] = {}
    children: dict[str, list[str]] = defaultdict(list)
    for name, joint in joints.items():
        parent, child = (_needed("", joint, end).get("link", "") for end in ("parent", "child"))
        if child in above:
            both = f"{shown(above[child][0])} and {shown(name)}: a kinematic loop; pendpin takes trees only"
            raise InputError(f"link {shown(child)} hangs on two joints, {both}")
        above[child] = (name, parent)
        children[parent].append(child)
    roots = [link for link in links if link not in above]
    if len(roots) != 1:
        reason = "every link hangs on another: a kinematic loop" if not roots else "several links hang on nothing"
        raise InputError(f"{reason}{': ' if roots else ''}{choices(map(shown, roots), 4)}; a tree has one root")
    level, lost, depth = roots, dict.fromkeys(above), 1
    while level := [child for link in level for child in children[link]]:
        depth += 1
        for link in level:
            del lost[link]
    if lost:
        raise InputError(f"a kinematic loop, cut off from {shown(roots[0])}: {choices(map(shown, lost), 4)}")
    if depth > MAX_DEPTH:
        many = f"too many for Pinocchio's URDF reader, which reads about {MAX_DEPTH}"
        raise InputError(f'{depth} links in a row are {many}; a scene with kind = "chain" takes longer ones')
    return above


Mimic = tuple[str, float, float]  # the joint to be followed: a multiplier times its position, plus an offset


def _freeze_joints(joints: Mapping[str, Element], lock: Mapping[str, float], mimic: str) -> list[str]:
    """Make locked joints fixed ones at their positions (rad, or m for slides); notes on what turns far or mimics another."""
    # Not by pin.buildReducedModel: the text that other engines are given has them fixed too.
    moving, mimics, frozen = _moving(joints), dict[str, Mimic](), dict(lock)
    for name in lock:
        if name not in moving:
            raise InputError(f"model.lock: joint {not_one_of(name, moving)}")
    for name in moving:
        element, where = joints[name].find("mimic"), f"joint {shown(name)}"
        if element is None:
            continue
        if not element.get("joint"):
            raise InputError(f"{where}: <mimic> names no joint")
        (multiplier,), (offset,) = (
            _numbers(where, element, key, 1, (default,)) for key, default in (("multiplier", 1.0), ("offset", 0.0))
        )
        mimics[name] = element.get("joint", ""), multiplier, offset
    follows = {name: shown(master) + " (no joint)" * (master not in joints) for name, (master, *_) in mimics.items()}
    pairs = {name: f"{shown(name)} mimics {master}" for name, master in follows.items() if name not in lock}
    if mimic == "locked":
        frozen = {name: _followed(name, mimics, lock) for name in mimics} | frozen
        pairs = {name: f"{pair} and is locked at {frozen[name]:g}" for name, pair in pairs.items()}
    turned = [name for name, x in lock.items() if abs(x) > 2 * np.pi and joints[name].get("type") != "prismatic"]
    for name, position in frozen.items():
        if position:  # at 0 its origin stays as written, to the last bit
            _move_origin(joints[name], position)
        _fix(joints[name])
    said = [f"model.lock: {shown(x)}: {lock[x]:g} rad is more than a whole turn; locks have no degrees" for x in turned]
    if not pairs:
        return said
    more = f", ... ({len(pairs)} joints)" if len(pairs) > MOST_LISTED else ""
    note = f"joint{'s' * (len(pairs) > 1)} {choices(list(pairs.values())[:MOST_LISTED])}{more}"
    if mimic != "locked":
        they, move, them = ("it", "moves", "it") if len(pairs) == 1 else ("they", "move", "them")
        note += f' in the file, but {they} {move} independently here; mimic = "locked" freezes {them}'
    return [*said, note]


def _followed(name: str, mimics: Mapping[str, Mimic], lock: Mapping[str, float]) -> float:
    """Where a mimic joint stands: where the joint that it follows is locked, or at its zero. Raises InputError."""
    path, slope, position = [name], 1.0, 0.0
    while path[-1] in mimics and path[-1] not in lock:
        master, multiplier, offset = mimics[path[-1]]
        if master in path:
            raise InputError(f"joint {shown(name)}: its mimics form a circle: {choices(map(shown, [*path, master]))}")
        path, position, slope = [*path, master], position + slope * offset, slope * multiplier
    return position + slope * lock.get(path[-1], 0.0)


def _move_origin(joint: Element, position: float) -> None:
    """Turn or shift the origin of a joint by a position about or along its axis, of unit length."""
    pin, (xyz, rpy), axis = pinocchio(), _origin("", joint), joint.find("axis")
    origin = ElementTree.SubElement(joint, "origin") if (given := joint.find("origin")) is None else given
    along = np.array([1.0, 0.0, 0.0] if axis is None else _numbers("", axis, "xyz", 3))
    R = pin.rpy.rpyToMatrix(rpy)
    if joint.get("type") == "prismatic":
        put(origin, "xyz", xyz + R @ along * position)
    else:
        put(origin, "rpy", pin.rpy.matrixToRpy(R @ pin.exp3(along * position)))
