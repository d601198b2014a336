"""From a run to what is drawn: the solids of its model, their poses over time, the trail of the last tip."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.arrays import Array
from pendpin.errors import InputError
from pendpin.graphics.drawing import WORLD, Drawing, Shape
from pendpin.model import kinematics
from pendpin.model.bodies import Body, pinocchio
from pendpin.model.build import Model, build
from pendpin.model.read_urdf import mesh_file
from pendpin.model.urdf_xml import parse
from pendpin.scene import Scene, UrdfModel
from pendpin.trajectory import Trajectory

COPPER, STEEL, BRASS = 0xD9622B, 0x7A8696, 0xE0A23C
THINNEST = 0.006  # of the extent: what is thinner is drawn this thick, as radius


def drawing_of(trajectory: Trajectory) -> Drawing:
    """The drawing of a run. Raises InputError where the run's model cannot be built again, as when its URDF is gone."""
    scene = trajectory.source or Scene(
        model=trajectory.scene.get("model")
    )  # effects may be gone: a user's own class, a file
    model = build(scene.model)
    if model.joints != trajectory.joints or len(model.bodies) != trajectory.tip.shape[1]:
        raise InputError("the run does not fit its model, which has changed since, or another has its name")
    points = trajectory.tip.reshape(-1, 3)
    extent = float(np.linalg.norm(points, axis=-1).max()) or 1.0
    if isinstance(scene.model, UrdfModel):
        poses, shapes = kinematics.joint_poses(model, trajectory.q), tuple(_urdf_shapes(scene.model.file, model))
    else:
        poses, shapes = kinematics.poses(model, trajectory.q), ()
    if not any(shape.body != WORLD for shape in shapes):
        poses, shapes = kinematics.poses(model, trajectory.q), tuple(_rod_shapes(model, extent))
    return Drawing(trajectory.title, trajectory.t - trajectory.t[0], poses, shapes, trajectory.tip[:, -1], extent)


def _rod_shapes(model: Model, extent: float) -> Iterator[Shape]:
    thick = THINNEST * extent
    many = len(model.bodies) > 20
    yield Shape("box", (12 * thick, 12 * thick, thick), _at(0, 0, 3.5 * thick), STEEL, WORLD)
    for index, body in enumerate(model.bodies):
        radius = max(body.radius, thick * (0.4 if many else 1.0))
        long = any(body.tip)  # a rotor about its own centre is not
        if long:
            yield _rod(body, index, radius, COPPER if index % 2 == 0 else BRASS)
        if not (many and long):
            yield Shape("sphere", (1.5 * radius,), np.eye(4), STEEL, index)
    if model.bodies:
        yield Shape("sphere", (1.5 * thick,), _at(*model.bodies[-1].tip), STEEL, len(model.bodies) - 1)


def _rod(body: Body, index: int, radius: float, color: int) -> Shape:
    length = math.hypot(*body.tip)  # the norm of a tiny vector is 0
    placement = np.eye(4)
    placement[:3, :3] = _frame_along(body.tip / length)
    placement[:3, 3] = body.tip / 2
    return Shape("cylinder", (radius, length), placement, color, index)


def _frame_along(z: Array) -> Array:
    """A rotation whose third axis is the unit vector z."""
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(z, x), z], float).T


def _at(x: float, y: float, z: float) -> Array:
    placement = np.eye(4)
    placement[:3, 3] = x, y, z
    return placement


def _urdf_shapes(path: Path, model: Model) -> Iterator[Shape]:
    """The visuals of a URDF, each fixed to the joint that moves its link."""
    robot = parse(path.read_bytes())  # the model is built: every check has been passed
    materials = {str(material.get("name")): material for material in robot.findall("material")}
    assert model.pin is not None
    frames = {frame.name: frame for frame in model.pin.frames if frame.type == pinocchio().FrameType.BODY}
    for link in robot.findall("link"):
        frame = frames[str(link.get("name"))]
        for visual in link.findall("visual"):
            placement = np.array(frame.placement.homogeneous) @ _origin(visual.find("origin"))
            shape = _visual(visual, placement, frame.parentJoint - 1, _color(visual, materials), path)
            if shape is not None:
                yield shape


def _visual(visual: Any, placement: Array, body: int, color: int, urdf: Path) -> Shape | None:
    """What is drawn; None for a mesh whose file is gone, as the model's notes say."""
    shape = visual.find("geometry")[0]
    if shape.tag == "mesh":
        file = mesh_file(urdf.parent, shape.get("filename"))
        return file and Shape("mesh", _numbers(shape.get("scale", "1 1 1")), placement, color, body, str(file))
    keys = {"box": ("size",), "sphere": ("radius",)}.get(shape.tag, ("radius", "length"))
    size = tuple(number for key in keys for number in _numbers(shape.get(key)))
    return Shape("cylinder" if shape.tag == "capsule" else shape.tag, size, placement, color, body)


def _origin(origin: Any) -> Array:
    placement = np.eye(4)
    if origin is not None:
        rpy = np.array(_numbers(origin.get("rpy", "0 0 0")))
        placement[:3, :3] = pinocchio().rpy.rpyToMatrix(rpy)
        placement[:3, 3] = _numbers(origin.get("xyz", "0 0 0"))
    return placement


def _color(visual: Any, materials: dict[str, Any]) -> int:
    material = visual.find("material")
    if material is not None and material.find("color") is None:
        material = materials.get(str(material.get("name")))
    color = None if material is None else material.find("color")
    if color is None:
        return COPPER
    red, green, blue = (round(255 * min(max(part, 0.0), 1.0)) for part in _numbers(color.get("rgba", "1 1 1 1"))[:3])
    return red << 16 | green << 8 | blue


def _numbers(text: str) -> tuple[float, ...]:
    return tuple(float(part) for part in text.split())
