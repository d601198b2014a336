"""Reading a URDF: every number and every connection is checked before Pinocchio sees the text.

Pinocchio's own reader takes broken numbers, lost branches and impossible inertia in silence (docs/pinocchio_notes.md).
"""

import math
import os
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from pendpin.errors import InputError, choices, inside, not_one_of, place_of, shown
from pendpin.ground.arrays import Array
from pendpin.ground.files import read_whole
from pendpin.model.bodies import LEAST_MASS, mass_unit
from pendpin.model.urdf_joints import WrittenJoint, freeze_joints, massless_finding, massless_joints, written_joints
from pendpin.model.urdf_xml import Element, misspelt, named, needed, number, numbers, parse, plain, put, triple
from pendpin.scene import UrdfModel

_ROUNDING = 1e-3  # of the sum of all three: what numbers written with four digits may miss in the triangle inequality
_NEGATIVE = 1e-9  # of the largest: what rounding may leave below zero
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_AS_WRITTEN = "no real body has this inertia; accelerations are computed as written"
MAX_BYTES = 8_000_000
MAX_LINKS = 10_000
MAX_DEPTH = 1_000  # links in a row; Pinocchio's reader recurses and dies far below 5,000
JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed")
_NO_LIMIT = {"lower": "-1e300", "upper": "1e300", "effort": "1e300", "velocity": "1e300"}
_ROUND = "radius length"
_SIZES = {"box": "size", "cylinder": _ROUND, "sphere": "radius", "mesh": "filename", "capsule": _ROUND}


@dataclass(frozen=True)
class Urdf:
    """A URDF that passed every check, as Pinocchio gets it: continuous joints as revolute ones, axes of unit length."""

    source: str
    text: str
    moving_joints: tuple[str, ...]
    findings: tuple[str, ...]  # what is implausible, and computed as written
    notes: tuple[str, ...]  # what the file says and pendpin leaves out, for the user to know
    written: tuple[WrittenJoint, ...]  # what it says of the joints that move
    shapes: dict[str, "RodShape"]  # the longest that each link is drawn with
    unit: float  # kg, of the masses in the text


class RodShape(NamedTuple):
    """A cylinder, capsule or box, longer than wide, that a link is drawn with, in the link's frame."""

    xyz: tuple[float, float, float]  # m, its centre
    rpy: tuple[float, float, float]  # rad
    axis: int  # of its own axes, the one along it
    radius: float  # m; 0 for a box
    length: float  # m


def content(model: UrdfModel) -> bytes:
    """What the file of a model holds. Raises InputError."""
    with inside(place_of(model.file)):
        return read_whole(model.file, MAX_BYTES, "a URDF")


def read_urdf(model: UrdfModel) -> Urdf:
    """Read and check the URDF of a model, its locked joints made fixed ones.

    Raises InputError: file, place and reason in one line. What is implausible, but leaves equations that can be solved,
    is a finding.
    """
    with inside(place_of(model.file)):
        return _checked(model, parse(content(model)))


def _checked(model: UrdfModel, robot: Element) -> Urdf:
    links, joints = named(robot, "link"), named(robot, "joint")
    if not links:
        raise InputError("it has no <link>")
    if len(links) > MAX_LINKS:
        raise InputError(f"it has {len(links)} links; the limit is {MAX_LINKS}")
    for material in robot.findall("material"):
        _check_color(f"material {shown(material.get('name', ''))}", material)
    for name, link in links.items():
        _check_link(f"link {shown(name)}", link)
    for name, joint in joints.items():
        _check_joint(f"joint {shown(name)}", joint, links)
    _check_tree(links, joints)
    massless = massless_joints(links, joints)
    notes = freeze_joints(joints, dict.fromkeys(massless, 0.0) | model.lock, model.mimic)
    moving = tuple(name for name, joint in joints.items() if joint.get("type") != "fixed")
    if not moving:
        raise InputError("no joint of it can move: at least one revolute, continuous or prismatic joint is needed")
    findings = massless_finding([name for name in massless if name not in model.lock])
    notes, written = (*notes, *_missing_meshes(links, model.file.parent)), written_joints(joints)
    for joint in joints.values():
        _make_plain(joint)
    drawn = {name: longest for name, link in links.items() if (longest := _longest_shape(link))}
    findings = (*misspelt(links), *misspelt(joints), *findings, *inertia_findings(links))
    unit = use_mass_unit(links)
    return Urdf(place_of(model.file), plain(links, joints), moving, findings, notes, written, drawn, unit)


# --- links ----------------------------------------------------------------------------------------------------------


def _check_link(where: str, link: Element) -> None:
    for visual in link.findall("visual"):
        _check_origin(f"{where}: visual", visual)
        _check_geometry(where, visual.find("geometry"))
        _check_color(f"{where}: visual", visual.find("material"))
    inertial = link.find("inertial")
    if inertial is not None:
        _check_origin(where, inertial)
        check_inertial(where, inertial)


def _longest_shape(link: Element) -> RodShape | None:
    """The longest shape of a link's drawing that is longer than wide; None where there is none."""
    shapes = []
    for visual in link.findall("visual"):
        geometry, origin = visual.find("geometry"), visual.find("origin")
        shape = None if geometry is None else next(iter(geometry), None)
        xyz, rpy = ((0.0, 0.0, 0.0) if origin is None else triple("", origin, key) for key in ("xyz", "rpy"))
        if shape is not None and shape.tag in {"cylinder", "capsule"}:
            radius = number("", shape, "radius")
            length = number("", shape, "length") + 2 * radius * (shape.tag == "capsule")
            shapes.append((RodShape(xyz, rpy, 2, radius, length), 2 * radius))
        elif shape is not None and shape.tag == "box":
            sides = triple("", shape, "size")
            axis = max(range(3), key=sides.__getitem__)
            shapes.append((RodShape(xyz, rpy, axis, 0.0, sides[axis]), sorted(sides)[1]))
    rods = (shape for shape, width in shapes if shape.length > width)
    return max(rods, key=lambda shape: shape.length, default=None)


def _check_origin(where: str, element: Element) -> None:
    origin = element.find("origin")
    if origin is not None:
        for key in ("xyz", "rpy"):
            triple(where, origin, key)


def _check_geometry(where: str, geometry: Element | None) -> None:
    shape = None if geometry is None else next(iter(geometry), None)
    if shape is None or shape.tag not in _SIZES:
        raise InputError(f"{where}: a visual needs a <geometry> with one of: {choices(_SIZES)}")
    if shape.tag == "mesh":
        if not shape.get("filename"):
            raise InputError(f"{where}: <mesh> has no filename")
        numbers(where, shape, "scale", 3)
        return
    for key in _SIZES[shape.tag].split():
        if shape.get(key) is None:
            raise InputError(f"{where}: <{shape.tag}> has no {key}")
        sizes = triple(where, shape, key) if shape.tag == "box" else (number(where, shape, key),)
        if min(sizes) < 0:
            raise InputError(f"{where}: {shape.tag} {key}: a size is negative")


def _check_color(where: str, material: Element | None) -> None:
    color = None if material is None else material.find("color")
    if color is not None:
        numbers(where, color, "rgba", 4)


def _missing_meshes(links: dict[str, Element], folder: Path) -> tuple[str, ...]:
    """One note on the meshes that are not there."""
    names = [mesh.get("filename", "") for link in links.values() for mesh in link.iterfind("visual/geometry/mesh")]
    missing = [name for name in dict.fromkeys(names) if mesh_file(folder, name) is None]
    if not missing:
        return ()
    one = len(missing) == 1
    which = f"mesh {shown(missing[0])} is" if one else f"{len(missing)} meshes, {shown(missing[0])} the first, are"
    return (f"{which} not found and will not be drawn",)


def mesh_file(folder: Path, filename: str) -> Path | None:
    """The file that a mesh name of a URDF in `folder` means; package://NAME/... is sought in the folders above it."""
    scheme, _, rest = filename.rpartition("://")
    above = [up / rest.lstrip("/") for up in folder.resolve().parents]
    candidates = [folder / rest] if scheme in {"", "file"} else above
    return next(filter(os.path.isfile, candidates), None)  # no file also for names that no file can have


# --- joints ---------------------------------------------------------------------------------------------------------


def _check_joint(where: str, joint: Element, links: dict[str, Element]) -> None:
    kind = joint.get("type", "")
    if kind not in JOINT_TYPES:
        hint = " (write a universal joint as two revolute joints)" if kind in {"universal", "spherical"} else ""
        raise InputError(f"{where}: type {not_one_of(kind, JOINT_TYPES)}{hint}")
    for end in ("parent", "child"):
        name = needed(where, joint, end).get("link", "")
        if name not in links:
            raise InputError(f"{where}: its {end} link {shown(name)} does not exist")
    _check_origin(where, joint)
    if kind != "fixed":
        _check_motion(where, joint, kind)


def _check_motion(where: str, joint: Element, kind: str) -> None:
    axis, dynamics = joint.find("axis"), joint.find("dynamics")
    if axis is not None and axis.get("xyz") is None:
        raise InputError(f"{where}: <axis> has no xyz")
    if axis is not None and not any(triple(where, axis, "xyz")):
        raise InputError(f"{where}: axis {axis.get('xyz')} has no direction")
    for key in ("damping", "friction"):
        if dynamics is not None and dynamics.get(key) is not None and number(where, dynamics, key) < 0:
            raise InputError(f"{where}: {key} is negative")
    if kind != "continuous":
        _check_limits(where, joint, kind)


def _check_limits(where: str, joint: Element, kind: str) -> None:
    limit = joint.find("limit")
    if limit is None:
        raise InputError(f"{where}: a {kind} joint needs <limit lower upper effort velocity>")
    for key in ("effort", "velocity"):
        if number(where, limit, key) < 0:
            raise InputError(f"{where}: limit {key} is negative")
    lower, upper = (number(where, limit, key) if limit.get(key) is not None else 0.0 for key in ("lower", "upper"))
    if lower > upper:
        raise InputError(f"{where}: its limits are swapped: lower {lower:g} > upper {upper:g}")


def _make_plain(joint: Element) -> None:
    """Continuous joints become revolute ones, so that every joint has one plain angle; axes get unit length."""
    kind, axis = joint.get("type"), joint.find("axis")
    if kind in {"fixed", "continuous"}:
        for unused in joint.findall("limit") + (joint.findall("axis") + joint.findall("dynamics")) * (kind == "fixed"):
            joint.remove(unused)
    if kind == "continuous":
        joint.set("type", "revolute")
        ElementTree.SubElement(joint, "limit", _NO_LIMIT)
    if kind != "fixed" and axis is not None:
        xyz = np.array(triple("", axis, "xyz"))
        if abs(math.hypot(*xyz) - 1) > 1e-15:
            xyz /= np.abs(xyz).max()  # then neither overflow nor underflow
            put(axis, "xyz", xyz / np.linalg.norm(xyz))


# --- the tree -------------------------------------------------------------------------------------------------------


def _check_tree(links: dict[str, Element], joints: dict[str, Element]) -> None:
    parents: dict[str, tuple[str, str]] = {}
    for name, joint in joints.items():
        parent, child = (needed("", joint, end).get("link", "") for end in ("parent", "child"))
        if child in parents:
            raise InputError(
                f"link {shown(child)} hangs on two joints, {shown(parents[child][0])} and {shown(name)}: "
                "a kinematic loop; pendpin takes trees only"
            )
        parents[child] = (name, parent)
    roots = [link for link in links if link not in parents]
    if len(roots) != 1:
        reason = "every link hangs on another: a kinematic loop" if not roots else "several links hang on nothing"
        raise InputError(f"{reason}{': ' if roots else ''}{choices(map(shown, roots[:4]))}; a tree has one root")
    _check_reach(roots[0], parents)


def _check_reach(root: str, parents: dict[str, tuple[str, str]]) -> None:
    children: dict[str, list[str]] = defaultdict(list)
    for child, (_, parent) in parents.items():
        children[parent].append(child)
    level, lost, depth = [root], dict.fromkeys(parents), 1
    while level := [child for link in level for child in children[link]]:
        depth += 1
        for link in level:
            del lost[link]
    if lost:
        links = choices(map(shown, list(lost)[:4])) + ", ..." * (len(lost) > 4)
        raise InputError(f"a kinematic loop, cut off from {shown(root)}: {links}")
    if depth > MAX_DEPTH:
        raise InputError(
            f"{depth} links in a row are too many for Pinocchio's URDF reader, which reads about {MAX_DEPTH}; "
            'a scene with kind = "chain" takes longer ones'
        )


# --- the inertia of a URDF's links: numbers that are broken are refused, numbers that no real body has are findings ---


def check_inertial(where: str, inertial: Element) -> None:
    """Raise InputError where <inertial> lacks a number, has one that is none, or a negative mass."""
    mass = number(where, needed(where, inertial, "mass"), "value")
    if mass < 0:
        raise InputError(f"{where}: mass {mass:g} kg is negative")
    if 0 < mass < LEAST_MASS:
        raise InputError(
            f"{where}: mass {mass:g} kg is too small to compute with; the least is {LEAST_MASS:g} kg, or 0"
        )
    _tensor(inertial, where)


def inertia_findings(links: dict[str, Element]) -> Iterator[str]:
    """What is implausible in the inertia of links that passed the check: link, numbers, and what follows."""
    for name, link in links.items():
        inertial = link.find("inertial")
        reason = None if inertial is None else _implausible(inertial)
        if reason:
            yield f"link {shown(name)}: {reason}: {_AS_WRITTEN}"


def _implausible(inertial: Element) -> str | None:
    tensor, mass = _tensor(inertial), float(needed("", inertial, "mass").get("value", ""))
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


def use_mass_unit(links: dict[str, Element]) -> float:
    """Write masses and inertias in a unit in which Pinocchio adds them up; returns the unit in kg."""
    inertials = [link.find("inertial") for link in links.values()]
    parts = [needed("", inertial, tag) for inertial in inertials if inertial is not None for tag in ("mass", "inertia")]
    moments = [abs(float(part.get(key, "0"))) for part in parts[1::2] for key in _MOMENTS]
    unit = mass_unit([float(mass.get("value", "")) for mass in parts[::2]], moments)
    for part in parts if unit != 1.0 else ():
        for key in ("value", *_MOMENTS):
            if key in part.attrib:
                part.set(key, repr(float(part.attrib[key]) / unit))
    return unit


def _tensor(inertial: Element, where: str = "") -> Array:
    """The central inertia (3, 3) kg m², in the axes of <origin>."""
    values = needed(where, inertial, "inertia")
    xx, xy, xz, yy, yz, zz = (number(where, values, key) for key in _MOMENTS)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
