"""A drawing as meshcat's commands: what its viewer is sent before anything moves."""

import base64
import re
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError, choices, inside
from pendpin.graphics.drawing import WORLD, Drawing, Shape
from pendpin.ground.arrays import Array
from pendpin.ground.files import read_whole

THINNEST = 0.002  # radius of the thinnest solid, over the extent of the drawing: about 2 pixels
SHADOWS = 500  # shapes that still throw shadows: beyond that they cost more than they show
MESH_BYTES = 100_000_000  # of one mesh; the page holds all of it
MESHES = {".obj": "obj", ".stl": "stl", ".dae": "dae"}

SKY = {"top_color": [0.98, 0.985, 0.99], "bottom_color": [0.90, 0.92, 0.945]}


def commands(drawing: Drawing, bodies: list[int]) -> list[dict[str, Any]]:
    """meshcat's commands that set the stage and put the shapes on it, those of `bodies[i]` in a group named body_i."""
    hidden = ["/Grid", "/Axes", *(f"/Lights/{name}" for name in _LIGHTS)]
    return [
        *(_property("/Background", key, color) for key, color in SKY.items()),
        *(_property(path, "visible", False) for path in hidden),
        {"type": "set_object", "path": "/pendpin/bodies", "object": solids(drawing, bodies)},
    ]


_LIGHTS = ("PointLightNegativeX", "PointLightPositiveX", "AmbientLight", "FillLight")  # made for scenes of 1 m


def _property(path: str, key: str, value: Any) -> dict[str, Any]:
    return {"type": "set_property", "path": path, "property": key, "value": value}


def solids(drawing: Drawing, bodies: list[int], color: int | None = None) -> dict[str, Any]:
    """All shapes as one three.js object: a group per body, equal geometries and materials held once; in one colour."""
    geometries: dict[Any, dict[str, Any]] = {}
    materials: dict[int, dict[str, Any]] = {}
    groups: dict[int, list[dict[str, Any]]] = {body: [] for body in [*bodies, WORLD]}
    shadows = len(drawing.shapes) <= SHADOWS
    for shape in drawing.shapes:
        key = (shape.geometry, shape.size, shape.path)
        if key not in geometries:
            geometries[key] = {"uuid": f"geometry_{len(geometries)}"} | _geometry(shape, THINNEST * drawing.extent)
        tone = shape.color if color is None else color
        material = materials.setdefault(tone, _material(tone))
        solid = {
            "type": "Mesh",
            "geometry": geometries[key]["uuid"],
            "material": material["uuid"],
            "castShadow": shadows,
        }
        groups[shape.body].append(solid | {"matrix": [round(float(x), 9) for x in placed(shape).T.flat]})
    names = {body: f"body_{i}" for i, body in enumerate(bodies)} | {WORLD: "world"}
    return {
        "metadata": {"version": 4.5, "type": "Object"},
        "geometries": list(geometries.values()),
        "materials": list(materials.values()),
        "object": _group("solids", [_group(names[body], parts) for body, parts in groups.items()]),
    }


def _group(name: str, children: list[dict[str, Any]]) -> dict[str, Any]:
    return {"type": "Group", "uuid": name, "name": name, "children": children}


def placed(shape: Shape) -> Array:
    """The placement (4, 4) of three.js's solid: its cylinders lie along y, its meshes get their scale here."""
    if shape.geometry == "cylinder":
        return shape.placement @ np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    return shape.placement @ np.diag([*shape.size, 1.0]) if shape.geometry == "mesh" else shape.placement


def _material(color: int) -> dict[str, Any]:
    return {
        "uuid": f"color_{color:06x}",
        "type": "MeshPhongMaterial",
        "color": color,
        "specular": 0x202020,
        "shininess": 40,
        "side": 2,  # both: meshes may have their faces turned about
    }


def _geometry(shape: Shape, thinnest: float) -> dict[str, Any]:
    if shape.geometry == "mesh":
        return _mesh_file(Path(shape.path))
    if shape.geometry == "box":
        return {"type": "BoxGeometry"} | dict(zip(("width", "height", "depth"), shape.size, strict=True))
    radius = max(shape.size[0], thinnest)
    if shape.geometry == "sphere":
        return {"type": "SphereGeometry", "radius": radius, "widthSegments": 24, "heightSegments": 16}
    length = shape.size[1]
    return {
        "type": "CylinderGeometry",
        "radiusTop": radius,
        "radiusBottom": radius,
        "height": length,
        "radialSegments": 24,
    }


def _mesh_file(path: Path) -> dict[str, Any]:
    kind = MESHES.get(path.suffix.lower())
    if kind is None:
        raise InputError(f"{path}: a mesh to be drawn is one of: {choices(MESHES)}")
    with inside(str(path)):
        data = read_whole(path, MESH_BYTES, "a mesh")
    if kind == "dae":  # meshcat joins the parts of a file, which must then have the same attributes: places and normals
        data = re.sub(rb"semantic=([\"'])(?:TEXCOORD|COLOR)\1", rb"semantic=\1LEFT_OUT\1", data)
    content = {"base64": base64_of(data)} if kind == "stl" else {"data": data.decode(errors="replace")}
    return {"type": "_meshfile_geometry", "format": kind} | content


def base64_of(data: bytes) -> str:
    """Bytes as text."""
    return base64.b64encode(data).decode("ascii")
