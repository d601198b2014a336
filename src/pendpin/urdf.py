"""Reading a URDF: every number and every connection is checked before Pinocchio sees the text.

Pinocchio's own reader takes broken numbers, lost branches and impossible inertia in silence (docs/pinocchio_notes.md).
"""

import math
import re
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from pendpin.errors import InputError, choices, shown

Element = ElementTree.Element

MAX_BYTES = 8_000_000
MAX_DEPTH = 1_000  # links in a row; Pinocchio's reader recurses and dies far below 5,000
JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_ROUNDING = 1e-3  # of the trace: what numbers written with four digits may miss in the triangle inequality


@dataclass(frozen=True)
class Urdf:
    """A URDF that passed every check, as Pinocchio gets it: continuous joints as revolute ones, axes of unit length."""

    source: str
    text: str
    moving_joints: tuple[str, ...]
    not_applied: tuple[str, ...]  # what the file says and pendpin leaves out, for the user to know


def read_urdf(path: Path) -> Urdf:
    """Read and check a URDF file. Raises InputError: file, place and reason in one line."""
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise InputError(f"{shown(str(path))}: cannot be read: {error}") from None
    if len(data) > MAX_BYTES:
        raise InputError(f"{path}: larger than the {MAX_BYTES // 1_000_000} MB that a URDF may have")
    try:
        return _Checker(str(path), path.parent).check(data)
    except RecursionError:
        raise InputError(f"{path}: not a URDF: elements are nested too deep") from None


class _Checker:
    """The checks of one file; each raises InputError through `fail`, which adds the file's name."""

    def __init__(self, source: str, folder: Path) -> None:
        self.source, self.folder = source, folder

    def fail(self, what: str) -> InputError:
        return InputError(f"{self.source}: {what}")

    def check(self, data: bytes) -> Urdf:
        robot = self.parse(data)
        links = self.named(robot, "link")
        joints = self.named(robot, "joint")
        if not links:
            raise self.fail("it has no <link>")
        for name, link in links.items():
            self.link(f"link {shown(name)}", link)
        for name, joint in joints.items():
            self.joint(f"joint {shown(name)}", joint, links)
        self.tree(links, joints)
        moving = tuple(name for name, joint in joints.items() if joint.get("type") != "fixed")
        if not moving:
            raise self.fail("no joint of it can move: at least one revolute, continuous or prismatic joint is needed")
        ignored = self.not_applied(joints)
        for joint in joints.values():
            _make_plain(joint)
        return Urdf(self.source, ElementTree.tostring(robot, encoding="unicode"), moving, ignored)

    def parse(self, data: bytes) -> Element:
        if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
            raise self.fail("a URDF has no DOCTYPE and no entities; remove them")
        try:
            robot = ElementTree.fromstring(data)
        except ElementTree.ParseError as error:
            raise self.fail(f"not well-formed XML: {error}") from None
        except (ValueError, LookupError) as error:  # an encoding that is not known or not text
            raise self.fail(f"not readable as XML: {error}") from None
        if robot.tag != "robot":
            raise self.fail(f"the root element is <{shown(robot.tag)[1:-1]}>; a URDF's is <robot>")
        if any("xacro" in element.tag for element in robot.iter() if isinstance(element.tag, str)):
            raise self.fail("it is a xacro file; run xacro first and give pendpin the URDF that comes out")
        robot.set("name", robot.get("name") or "robot")
        return robot

    def named(self, robot: Element, tag: str) -> dict[str, Element]:
        found: dict[str, Element] = {}
        for element in robot.findall(tag):
            name = element.get("name", "").strip()
            if not name:
                raise self.fail(f"a <{tag}> has no name")
            if name in found:
                raise self.fail(f"two {tag}s are named {shown(name)}")
            found[name] = element
        return found

    def number(self, where: str, element: Element, key: str) -> float:
        text = element.get(key)
        if text is None:
            raise self.fail(f"{where}: <{element.tag}> has no {key}")
        return self.finite(f"{where}: {element.tag} {key}", text)

    def finite(self, what: str, text: str) -> float:
        if not _NUMBER.fullmatch(text.strip()):
            raise self.fail(f"{what}: {shown(text)} is not a number such as 1.5 or 2e-3")
        value = float(text)
        if not math.isfinite(value):
            raise self.fail(f"{what}: {shown(text)} is beyond double precision")
        return value

    def triple(self, where: str, element: Element | None, key: str) -> tuple[float, ...]:
        """Three numbers of an element; zeros where the element or the key is absent, as URDF has it."""
        if element is None or element.get(key) is None:
            return 0.0, 0.0, 0.0
        texts = element.get(key, "").split()
        if len(texts) != 3:
            raise self.fail(f"{where}: {element.tag} {key}: {shown(element.get(key))} is not three numbers")
        return tuple(self.finite(f"{where}: {element.tag} {key}", text) for text in texts)

    def origin(self, where: str, element: Element) -> None:
        for key in ("xyz", "rpy"):
            self.triple(where, element.find("origin"), key)

    def link(self, where: str, link: Element) -> None:
        for visual in link.findall("visual"):
            self.origin(f"{where}: visual", visual)
            self.geometry(where, visual.find("geometry"))
        inertial = link.find("inertial")
        if inertial is not None:
            self.inertial(where, inertial)

    def inertial(self, where: str, inertial: Element) -> None:
        self.origin(where, inertial)
        parts = {tag: inertial.find(tag) for tag in ("mass", "inertia")}
        for tag, element in parts.items():
            if element is None:
                raise self.fail(f"{where}: <inertial> has no <{tag}>")
        mass = self.number(where, _given(parts["mass"]), "value")
        if mass < 0:
            raise self.fail(f"{where}: mass {mass:g} kg is negative")
        keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        xx, xy, xz, yy, yz, zz = (self.number(where, _given(parts["inertia"]), key) for key in keys)
        self.possible(where, mass, np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))

    def possible(self, where: str, mass: float, inertia: np.ndarray) -> None:
        small, middle, large = np.linalg.eigvalsh(inertia)
        slack = _ROUNDING * (abs(small) + abs(middle) + abs(large))
        values = f"principal inertia {small:.6g}, {middle:.6g}, {large:.6g} kg m²"
        if small < -1e-9 * max(abs(large), abs(small)):
            raise self.fail(f"{where}: {values}: none may be negative")
        if large > small + middle + slack:
            raise self.fail(f"{where}: {values}: no real body has one above the sum of the others")
        if mass == 0 and large > 0:
            raise self.fail(f"{where}: {values} with a mass of 0: a massless link has no inertia")

    def geometry(self, where: str, geometry: Element | None) -> None:
        shape = None if geometry is None else next(iter(geometry), None)
        keys = {"box": "size", "cylinder": "radius length", "sphere": "radius", "mesh": "filename", "capsule": ""}
        if shape is None or shape.tag not in keys:
            raise self.fail(f"{where}: a visual needs a <geometry> with one of: {choices(keys)}")
        if shape.tag == "mesh":
            mesh_file(self.folder, shape.get("filename", ""), f"{self.source}: {where}")
            return
        for key in keys[shape.tag].split():
            sizes = self.triple(where, shape, key) if shape.tag == "box" else (self.number(where, shape, key),)
            if min(sizes) < 0:
                raise self.fail(f"{where}: {shape.tag} {key}: a size is negative")

    def joint(self, where: str, joint: Element, links: dict[str, Element]) -> None:
        kind = joint.get("type", "")
        if kind not in JOINT_TYPES:
            hint = " (write a universal joint as two revolute joints)" if kind in {"universal", "spherical"} else ""
            raise self.fail(f"{where}: type {shown(kind)} is not one of: {choices(JOINT_TYPES)}{hint}")
        if joint.find("mimic") is not None:
            raise self.fail(f"{where}: <mimic> ties it to another joint; pendpin takes trees of free joints only")
        for end in ("parent", "child"):
            element = joint.find(end)
            name = None if element is None else element.get("link")
            if name not in links:
                raise self.fail(f"{where}: its {end} link {shown(name)} does not exist")
        self.origin(where, joint)
        if kind == "fixed":
            return
        axis = joint.find("axis")
        if axis is not None and math.hypot(*self.triple(where, axis, "xyz")) < 1e-6:
            raise self.fail(f"{where}: axis {shown(axis.get('xyz'))} has no direction")
        self.limits(where, joint, kind)
        for key in ("damping", "friction"):
            dynamics = joint.find("dynamics")
            if dynamics is not None and dynamics.get(key) is not None and self.number(where, dynamics, key) < 0:
                raise self.fail(f"{where}: {key} is negative")

    def limits(self, where: str, joint: Element, kind: str) -> None:
        limit = joint.find("limit")
        if kind == "continuous":
            return
        if limit is None:
            raise self.fail(f"{where}: a {kind} joint needs <limit lower upper effort velocity>")
        values = {key: self.number(where, limit, key) for key in ("effort", "velocity")}
        for key in ("lower", "upper"):
            values[key] = self.number(where, limit, key) if limit.get(key) is not None else 0.0
        if values["lower"] > values["upper"]:
            raise self.fail(f"{where}: its limits are swapped: lower {values['lower']:g} > upper {values['upper']:g}")

    def tree(self, links: dict[str, Element], joints: dict[str, Element]) -> None:
        parents: dict[str, tuple[str, str]] = {}
        for name, joint in joints.items():
            parent, child = (_given(joint.find(end)).get("link", "") for end in ("parent", "child"))
            if child in parents:
                raise self.fail(
                    f"link {shown(child)} hangs on two joints, {shown(parents[child][0])} and {shown(name)}: "
                    "a kinematic loop; pendpin takes trees only"
                )
            parents[child] = (name, parent)
        roots = [link for link in links if link not in parents]
        if len(roots) != 1:
            reason = "every link hangs on another: a kinematic loop" if not roots else "several links hang on nothing"
            raise self.fail(f"{reason}{': ' if roots else ''}{choices(map(shown, roots[:4]))}; a tree has one root")
        self.reach(roots[0], parents)

    def reach(self, root: str, parents: dict[str, tuple[str, str]]) -> None:
        children: dict[str, list[str]] = defaultdict(list)
        for child, (_, parent) in parents.items():
            children[parent].append(child)
        level, reached, depth = [root], 1, 1
        while level := [child for link in level for child in children[link]]:
            reached, depth = reached + len(level), depth + 1
        if reached <= len(parents):
            raise self.fail(f"{len(parents) + 1 - reached} links are cut off from {shown(root)}: a kinematic loop")
        if depth > MAX_DEPTH:
            raise self.fail(
                f"{depth} links hang in a row, and Pinocchio's URDF reader survives about {MAX_DEPTH}; "
                'a scene with kind = "chain" takes longer ones'
            )

    def not_applied(self, joints: dict[str, Element]) -> tuple[str, ...]:
        notes = []
        for name, joint in joints.items():
            dynamics = joint.find("dynamics")
            for key in () if dynamics is None else ("damping", "friction"):
                value = float(_given(dynamics).get(key, "0"))
                if value:
                    notes.append(f"joint {shown(name)}: <dynamics {key}={value:g}> is not applied")
        return tuple(notes)


def mesh_file(folder: Path, filename: str, where: str) -> Path:
    """The file that a mesh name of a URDF in `folder` means; package://NAME/... is sought in the folders above it.

    Raises InputError, beginning with `where`, if there is none.
    """
    scheme, _, rest = filename.rpartition("://")
    candidates = [folder / rest] if scheme in {"", "file"} else [above / rest for above in folder.resolve().parents]
    for candidate in candidates:
        if candidate.is_file():
            return candidate
    raise InputError(f"{where}: mesh {shown(filename)} is not found")


def _given(element: Element | None) -> Element:
    assert element is not None  # checked before
    return element


def _make_plain(joint: Element) -> None:
    """Continuous joints become revolute ones, so that every joint has one plain angle; axes get unit length."""
    if joint.get("type") == "continuous":
        joint.set("type", "revolute")
        for limit in joint.findall("limit"):
            joint.remove(limit)
        ElementTree.SubElement(joint, "limit", lower="-1e300", upper="1e300", effort="1e300", velocity="1e300")
    axis = joint.find("axis")
    if axis is not None and axis.get("xyz") and joint.get("type") != "fixed":
        xyz = np.array([float(x) for x in axis.get("xyz", "").split()])
        length = np.linalg.norm(xyz)
        if abs(length - 1) > 1e-15:
            axis.set("xyz", " ".join(repr(float(x)) for x in xyz / length))
