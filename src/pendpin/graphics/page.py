"""A drawing as one HTML page that plays by itself: meshcat's viewer, the scene in meshcat's commands, and a player.

Nothing of meshcat's Python side is imported: that would start ZeroMQ. Its viewer reads the same commands from the page.
"""

import base64
import html
import importlib.util
import json
import re
from dataclasses import replace
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pendpin.arrays import Array
from pendpin.errors import InputError, MissingLibrary, choices, inside
from pendpin.files import read_whole, write_whole
from pendpin.graphics.drawing import WORLD, Drawing, Shape

FRAMES_PER_SECOND = 60  # at most: what a screen shows
POSES = 200_000  # key poses in a page at most, 19 bytes each; with more bodies a page has fewer frames
TRAIL_POINTS = 10_000  # at most
THINNEST = 0.002  # radius of the thinnest solid, over the extent of the drawing: about 2 pixels
SHADOWS = 500  # shapes that still throw shadows: beyond that they cost more than they show
MESH_BYTES = 100_000_000  # of one mesh; the page holds all of it
MESHES = {".obj": "obj", ".stl": "stl", ".dae": "dae"}

SKY = {"top_color": [0.98, 0.985, 0.99], "bottom_color": [0.90, 0.92, 0.945]}


def write_page(path: str | Path, drawing: Drawing) -> Path:
    """Write the page of a drawing, whole or not at all. Raises InputError where the path or a mesh refuses."""
    text = page(drawing)
    return write_whole(Path(path), lambda file: file.write(text.encode(errors="replace")))


def page(drawing: Drawing, *, live: bool = False) -> str:
    """The page of a drawing: self-contained HTML that plays in real time and never touches the network.

    It shows one instant, paused, where its address ends in #t=1.5 (s). A `live` page asks the server it came from now
    and then whether it is still there. Raises InputError for a mesh that cannot be read.
    """
    parts = {
        "policy": _policy(live),
        "title": html.escape(drawing.title),
        "style": _own("player.css"),
        "licenses": _viewer("main.min.js.LICENSE.txt"),
        "viewer": _viewer("main.min.js"),
        "drawing": _json(contents(drawing) | {"live": live}),
        "scene": _own("scene.js"),
        "player": _own("player.js"),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], _own("page.html"))


def _json(value: Any) -> str:
    """JSON that may stand in a page; NaN, which a browser would not read, raises ValueError."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def contents(drawing: Drawing) -> dict[str, Any]:
    """What the player reads, for JSON: meshcat's commands, key poses of the bodies that are seen, and the trail."""
    drawing = _lasting(drawing)
    bodies = sorted({shape.body for shape in drawing.shapes} - {WORLD}) or [0]
    keys = pick(drawing.t, FRAMES_PER_SECOND, POSES // len(bodies))
    poses = drawing.poses[keys][:, bodies]
    path = pick(drawing.t, FRAMES_PER_SECOND, TRAIL_POINTS)
    start, end = drawing.t[0], drawing.t[-1]
    return {
        "commands": commands(drawing, bodies),
        "start": float(start),
        "duration": float(end - start),
        "extent": float(drawing.extent),
        "bodies": len(bodies),
        "times": _floats(drawing.t[keys] - start),
        "positions": _integers(poses[..., :3, 3].swapaxes(0, 1)),
        "quaternions": _integers(quaternions(poses[..., :3, :3]).swapaxes(0, 1)),
        "trail": {"times": _floats(drawing.t[path] - start), "points": _floats(drawing.trail[path])},
    }


def _lasting(drawing: Drawing) -> Drawing:
    """The drawing, or, of a single pose, one that stands still for a second."""
    if len(drawing.t) > 1:
        return drawing
    twice = {name: np.repeat(getattr(drawing, name), 2, axis=0) for name in ("poses", "trail")}
    return replace(drawing, t=drawing.t[0] + np.array([0.0, 1.0]), **twice)


def pick(t: Array, per_second: float, most: int) -> NDArray[np.intp]:
    """Indices of samples to keep, evenly spread, first and last among them: at most `per_second`, at most `most`."""
    wanted = min(len(t), int((t[-1] - t[0]) * per_second) + 2, max(2, most))
    return np.unique(np.linspace(0, len(t) - 1, wanted).round().astype(np.intp))


def quaternions(rotations: Array) -> Array:
    """Quaternions (n, bodies, 4), order x, y, z, w, of rotations (n, bodies, 3, 3), without jumps of sign along n."""
    from scipy.spatial.transform import Rotation

    q = Rotation.from_matrix(rotations.reshape(-1, 3, 3)).as_quat().reshape(*rotations.shape[:2], 4)
    turned = np.where((q[1:] * q[:-1]).sum(axis=-1) < 0, -1.0, 1.0)
    q[1:] *= np.cumprod(turned, axis=0)[..., None]
    return q


def commands(drawing: Drawing, bodies: list[int]) -> list[dict[str, Any]]:
    """meshcat's commands that set the stage and put the shapes on it, those of `bodies[i]` in a group named body_i."""
    hidden = ["/Grid", "/Axes", *(f"/Lights/{name}" for name in _LIGHTS)]
    return [
        *(_property("/Background", key, color) for key, color in SKY.items()),
        *(_property(path, "visible", False) for path in hidden),
        {"type": "set_object", "path": "/pendpin/bodies", "object": _solids(drawing, bodies)},
    ]


_LIGHTS = ("PointLightNegativeX", "PointLightPositiveX", "AmbientLight", "FillLight")  # made for scenes of 1 m


def _property(path: str, key: str, value: Any) -> dict[str, Any]:
    return {"type": "set_property", "path": path, "property": key, "value": value}


def _solids(drawing: Drawing, bodies: list[int]) -> dict[str, Any]:
    """All shapes as one three.js object: a group per body, equal geometries and materials held once."""
    geometries: dict[Any, dict[str, Any]] = {}
    materials: dict[int, dict[str, Any]] = {}
    groups: dict[int, list[dict[str, Any]]] = {body: [] for body in [*bodies, WORLD]}
    shadows = len(drawing.shapes) <= SHADOWS
    for shape in drawing.shapes:
        key = (shape.geometry, shape.size, shape.path)
        if key not in geometries:
            geometries[key] = {"uuid": f"geometry_{len(geometries)}"} | _geometry(shape, THINNEST * drawing.extent)
        material = materials.setdefault(shape.color, _material(shape.color))
        solid = {
            "type": "Mesh",
            "geometry": geometries[key]["uuid"],
            "material": material["uuid"],
            "castShadow": shadows,
        }
        groups[shape.body].append(solid | {"matrix": _matrix(shape)})
    names = {body: f"body_{i}" for i, body in enumerate(bodies)} | {WORLD: "world"}
    return {
        "metadata": {"version": 4.5, "type": "Object"},
        "geometries": list(geometries.values()),
        "materials": list(materials.values()),
        "object": _group("solids", [_group(names[body], solids) for body, solids in groups.items()]),
    }


def _group(name: str, children: list[dict[str, Any]]) -> dict[str, Any]:
    return {"type": "Group", "uuid": name, "name": name, "children": children}


def _matrix(shape: Shape) -> list[float]:
    """The placement as three.js reads it, column by column, with what turns its solids into ours."""
    placement = shape.placement
    if shape.geometry == "cylinder":  # three.js has it along y
        placement = placement @ np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    if shape.geometry == "mesh":
        placement = placement @ np.diag([*shape.size, 1.0])
    return [round(float(x), 9) for x in placement.T.flat]


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
    content = {"base64": _base64(data)} if kind == "stl" else {"data": data.decode(errors="replace")}
    return {"type": "_meshfile_geometry", "format": kind} | content


def _floats(values: Array) -> str:
    if (np.abs(values) > np.finfo("f4").max).any():
        raise InputError(f"times or lengths beyond {np.finfo('f4').max:.2g} s or m cannot be drawn in a browser")
    return _base64(values.astype("<f4").tobytes())


def _integers(values: Array) -> dict[str, Any]:
    """Values as whole numbers of 16 bits, and what one of them is worth."""
    scale = float(np.abs(values).max(initial=0.0)) / 32767 or 1.0
    return {"scale": scale, "data": _base64((values / scale).round().astype("<i2").tobytes())}


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")


def _policy(live: bool) -> str:
    """What the browser lets the page do: run what stands in it, and reach nothing, or its own server if live."""
    inline = "script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; worker-src blob:"
    return f"default-src 'none'; connect-src {chr(39)}{'self' if live else 'none'}{chr(39)}; {inline}"


def _own(name: str) -> str:
    return resources.files("pendpin").joinpath("graphics", "player", name).read_text(encoding="utf-8")


@cache
def _viewer(name: str) -> str:
    spec = importlib.util.find_spec("meshcat")
    if spec is None or not spec.submodule_search_locations:
        raise MissingLibrary("pictures in 3D need meshcat's viewer: pip install meshcat")
    return Path(spec.submodule_search_locations[0], "viewer", "dist", name).read_text(encoding="utf-8")
