"""The solids of a model: its rods, or what its URDF shows."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.graphics.drawing import WORLD, Shape
from pendpin.ground.arrays import Array, across, cross
from pendpin.model.bodies import pinocchio
from pendpin.model.build import Model
from pendpin.model.urdf import mesh_file, parse

COPPER, STEEL, BRASS = 0xD9622B, 0x7A8696, 0xE0A23C
THINNEST = 0.006  # of the extent: what is thinner is drawn this thick, as radius
MANY = 20  # rods; of more, thinner ones are drawn, without their joints
DENSITY = 7850.0  # kg/m³, of a payload: steel


def rod_shapes(model: Model, extent: float, payloads: Sequence[float]) -> Iterator[Shape]:
    """Rods, their joints and their payloads in kg; and what they hang from, which is the body after them.

    A joint is a ball, that of a hinge a pin along its axis.
    """
    thick = THINNEST * extent
    many = len(model.bodies) > MANY
    hinges = dict[int, Array]()
    if model.chain is None:
        others = {rod.phi for rod in model.rods if rod.kind == "universal"} | set(np.flatnonzero(model.slides).tolist())
        hinges = {joint: axis for joint, axis in enumerate(model.tree.axes) if joint not in others}
    yield Shape("box", (12 * thick, 12 * thick, thick), _at((0, 0, 3.5 * thick)), STEEL, len(model.bodies))
    for index, (body, payload) in enumerate(zip(model.bodies, payloads, strict=True)):
        radius = max(body.radius, thick * (0.4 if many else 1.0))
        long = any(body.tip)  # a rotor about its own centre is not
        if long:
            yield _stick(np.zeros(3), body.tip, radius, COPPER if index % 2 == 0 else BRASS, index)
        size = min(1.5 * radius, 3 * thick)
        if not (many and long):
            pin = hinges.get(body.joint)
            ball = Shape("sphere", (size,), np.eye(4), STEEL, index)
            yield ball if pin is None else _stick(-2 * size * pin, 2 * size * pin, 0.9 * size, STEEL, index)
        if payload or index == len(model.bodies) - 1:
            ball = min((3 * payload / (4 * math.pi * DENSITY)) ** (1 / 3), math.hypot(*body.tip) / 6)  # m, of steel
            ball = body.payload_radius or max(1.5 * thick, ball)
            yield Shape("sphere", (ball,), _at(body.tip), STEEL, index)


def bracket_shapes(model: Model, extent: float, q: Array) -> Iterator[Shape]:
    """Thin lines of a tree: from rods to joints that hang beside them, and along the ways of slides in q (n, nv)."""
    thin = 0.5 * THINNEST * extent
    tree = model.tree
    places = {body.joint: (index, body.tip) for index, body in enumerate(model.bodies)}
    places[WORLD] = len(model.bodies), np.zeros(3)
    for joint, (parent, place) in enumerate(zip(tree.parents, tree.translations, strict=True)):
        if parent not in places:  # a link without mass has no pose here
            continue
        body, tip = places[parent]
        lines = [(np.clip(place @ tip / (tip @ tip or 1.0), 0.0, 1.0) * tip, place)]
        if model.slides[joint]:
            axis = tree.rotations[joint] @ tree.axes[joint]
            way = q[:, joint]
            lines.append((place + min(way.min(), 0.0) * axis, place + max(way.max(), 0.0) * axis))
        yield from (_stick(*ends, thin, STEEL, body) for ends in lines if math.dist(*ends) > thin)


def _stick(start: Array, end: Array, radius: float, color: int, body: int) -> Shape:
    """A cylinder from one place to another, (3,) m."""
    length = math.hypot(*(end - start))  # the norm of a tiny vector is 0
    z = (end - start) / length
    x = across(z)
    placement = _at((start + end) / 2, np.stack([x, cross(z, x), z], -1))
    return Shape("cylinder", (radius, length), placement, color, body)


def _at(place: Any, rotation: Array | None = None) -> Array:
    """A placement (4, 4) at a place (3,) in m, with a rotation (3, 3) if there is one."""
    placement = np.eye(4)
    placement[:3, 3] = place
    if rotation is not None:
        placement[:3, :3] = rotation
    return placement


def urdf_shapes(path: Path, model: Model) -> Iterator[Shape]:
    """The visuals of a URDF, each fixed to the joint that moves its link; what none moves, to the body after all joints.

    What has no colour of its own has that of a rod, another one for the next body.
    """
    robot = parse(path.read_bytes())  # the model is built: every check has been passed
    materials = {str(material.get("name")): material for material in robot.findall("material")}
    assert model.pin is not None
    frames = {frame.name: frame for frame in model.pin.frames if frame.type == pinocchio().FrameType.BODY}
    tones: dict[int, int] = {}
    for link in robot.findall("link"):
        frame = frames[str(link.get("name"))]
        for visual in link.findall("visual"):
            placement = np.array(frame.placement.homogeneous) @ _origin(visual.find("origin"))
            body = (frame.parentJoint or model.pin.njoints) - 1
            tone = tones.setdefault(body, (COPPER, BRASS)[len(tones) % 2])
            shape = _visual(visual, placement, body, _color(visual, materials, tone), path)
            if shape is not None:
                yield shape


def _visual(visual: Any, placement: Array, body: int, color: int, urdf: Path) -> Shape | None:
    """What is drawn, placed (4, 4); None for a mesh whose file is gone, as the model's notes say."""
    shape = visual.find("geometry")[0]
    if shape.tag == "mesh":
        file = mesh_file(urdf.parent, shape.get("filename"))
        return file and Shape("mesh", _numbers(shape.get("scale", "1 1 1")), placement, color, body, str(file))
    keys = {"box": ("size",), "sphere": ("radius",)}.get(shape.tag, ("radius", "length"))
    size = tuple(number for key in keys for number in _numbers(shape.get(key)))
    return Shape("cylinder" if shape.tag == "capsule" else shape.tag, size, placement, color, body)


def _origin(origin: Any) -> Array:
    """The placement (4, 4) of an <origin>, or none."""
    if origin is None:
        return np.eye(4)
    rotation = pinocchio().rpy.rpyToMatrix(np.array(_numbers(origin.get("rpy", "0 0 0"))))
    return _at(_numbers(origin.get("xyz", "0 0 0")), rotation)


def _color(visual: Any, materials: dict[str, Any], other: int) -> int:
    """The colour of a visual; `other` where it has none."""
    material = visual.find("material")
    if material is not None and material.find("color") is None:
        material = materials.get(str(material.get("name")))
    color = None if material is None else material.find("color")
    if color is None:
        return other
    red, green, blue = (round(255 * min(max(part, 0.0), 1.0)) for part in _numbers(color.get("rgba", "1 1 1 1"))[:3])
    return red << 16 | green << 8 | blue


def _numbers(text: str) -> tuple[float, ...]:
    return tuple(float(part) for part in text.split())
