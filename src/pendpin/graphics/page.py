"""A drawing as one HTML page that plays by itself: meshcat's viewer, the scene in meshcat's commands, and a player.

Nothing of meshcat's Python side is imported: that would start ZeroMQ. Its viewer reads the same commands from the page.
"""

import base64
import gzip
import html
import importlib.util
import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pendpin.errors import InputError, MissingLibrary, choices, inside
from pendpin.graphics.drawing import WORLD, Drawing, Shape, smooth
from pendpin.ground.arrays import Array
from pendpin.ground.files import fill_template, read_whole, write_whole
from pendpin.model.bodies import pinocchio
from pendpin.trajectory.columns import NOTHING

THINNEST = 0.002  # radius of the thinnest solid, over the extent of the drawing: about 2 pixels
SHADOWS = 500  # shapes that still throw shadows: beyond that they cost more than they show
MESH_BYTES = 100_000_000  # of one mesh; the page holds all of it
MESHES = {".obj": "obj", ".stl": "stl", ".dae": "dae"}
LIGHTS = ("PointLightNegativeX", "PointLightPositiveX", "AmbientLight", "FillLight")  # made for scenes of 1 m


# What the browser lets the page do: run what stands in it. It reaches nothing, or its own server if it is live.
INLINE = "script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; worker-src blob:"
SCRIPTS = ("scene.js", "arrows.js", "frames.js", "plots.js", "player.js")  # in this order
FRAMES_PER_SECOND = 60  # at most: what a screen shows
POSES = 105_000  # key poses in a page at most, 19 bytes each: of 1,000 rods, a page below 5 MB with 17 frames a second
DRAWN = (1e-3, 1e4)  # m, extents that a browser draws as they are; its numbers have 24 bits
LEAST_FRAMES = 600  # where the samples give as many: a run of less than 10 s is looked at slowly
TRAIL_POINTS = 30_000  # at most
PLOTTED = 400_000  # numbers of all curves in a page at most, 2 bytes each
LEAST_PLOTTED = 600  # of a curve, where the samples give as many
LEVELS = 65535  # of a plotted number, between the least and the largest of its curve
GHOSTS = (0x009E73, 0xCC79A7, 0x56B4E9)  # colours of further runs


def write_page(path: str | Path, drawing: Drawing, report: str = "") -> Path:
    """Write the page of a drawing, whole or not at all. Raises InputError where the path or a mesh refuses."""
    text = page(drawing, report)
    return write_whole(Path(path), lambda file: file.write(text.encode(errors="replace")))


def page(drawing: Drawing, report: str = "", *, live: bool = False) -> str:
    """The page of a drawing: self-contained HTML that plays in real time and never touches the network.

    It shows what its address asks for after a #: t=1.5 (s; paused there), view=above, speed=5, reactions=on, frames=on.
    A `report`, HTML to be trusted, stands below the player. A `live` page asks the server it came from now and then
    whether it is still there. Raises InputError for a mesh that cannot be read.
    """
    shown, network = contents(drawing) | {"live": live}, "'self'" if live else "'none'"
    parts = {
        "policy": f"default-src 'none'; connect-src {network}; {INLINE}",
        "title": html.escape(drawing.title),
        "style": fill_template("pendpin.graphics", "player/player.css"),
        "licenses": _viewer("main.min.js.LICENSE.txt"),
        "viewer": _viewer("main.min.js"),
        "drawing": json.dumps(shown, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),  # ends no script
        "report": report,
        "script": "\n".join(fill_template("pendpin.graphics", f"player/{name}") for name in SCRIPTS),
    }
    return fill_template("pendpin.graphics", "player/page.html", **parts)


def compress(text: str) -> str:
    """A page that unpacks itself in the browser: a third of its size, for notebooks, which hold many."""
    packed = base64_of(gzip.compress(text.encode(errors="replace"), mtime=0))
    return (
        '<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>pendpin</title><script>'
        f'const packed = Uint8Array.from(atob("{packed}"), (c) => c.charCodeAt(0));'
        'const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));'
        "new Response(stream).text().then((page) => { document.open(); document.write(page); document.close(); });"
        "</script></html>"
    )


def contents(drawing: Drawing) -> dict[str, Any]:
    """What the player reads, for JSON: meshcat's commands, key poses of the bodies that are seen, trails and curves."""
    drawing = _stand_still(drawing)
    if not DRAWN[0] <= drawing.extent <= DRAWN[1]:
        drawing = drawing.scaled(1 / drawing.extent)
    motion, bodies, joints = _motion(drawing, drawing.t[0]), _bodies(drawing), []
    for joint in drawing.joints:  # with the places of its bodies among those that are seen; None for what does not move
        body, above = (bodies.index(one) if one in bodies else None for one in (joint.body, joint.above))
        places: dict[str, Any] = {"body": body, "above": above}
        joints.append(joint._asdict() | places | {"axes": joint.axes.tolist(), "base": joint.base.tolist()})
    ghosts = [
        _motion(_stand_still(other), drawing.t[0]) | {"solids": solids(other, _bodies(other), color)}
        for other, color in zip(drawing.others, GHOSTS, strict=False)
    ]
    # meshcat's commands that set the stage and put the shapes on it, those of bodies[i] in a group named body_i
    sky = {"top_color": [0.98, 0.985, 0.99], "bottom_color": [0.90, 0.92, 0.945]}
    settings = [("/Background", key, color) for key, color in sky.items()]
    settings += [(path, "visible", False) for path in ("/Grid", "/Axes", *(f"/Lights/{name}" for name in LIGHTS))]
    commands = [{"type": "set_property", "path": path, "property": key, "value": x} for path, key, x in settings]
    commands += [{"type": "set_object", "path": "/pendpin/bodies", "object": solids(drawing, bodies)}]
    whole = {"commands": commands, "extent": float(drawing.extent), "leaves": drawing.leaves}
    whole |= {"start": float(drawing.t[0]), "joints": joints, "ghosts": ghosts, "notes": drawing.notes}
    return motion | whole


def _bodies(drawing: Drawing) -> list[int]:
    return sorted({shape.body for shape in drawing.shapes} - {WORLD}) or [0]


def _motion(drawing: Drawing, zero: float) -> dict[str, Any]:
    """Key poses, forces, trail and curves of a motion, at times from `zero` s on."""
    bodies = _bodies(drawing)
    duration = float(drawing.t[-1] - drawing.t[0])
    rate = max(FRAMES_PER_SECOND, LEAST_FRAMES / duration)
    keys = pick(drawing.t, rate, POSES // len(bodies))
    poses = drawing.poses[keys][:, bodies]
    trail_times, trail = smooth(drawing.t, drawing.trail, drawing.velocity, rate, TRAIL_POINTS)
    forces, moments = (_fractions(loads, keys, bodies) for loads in (drawing.forces, drawing.moments))
    rounding = NOTHING * drawing.extent * forces["largest"] if forces else 0.0  # of the forces: no moments are shown
    rows = pick(drawing.t, np.inf, max(LEAST_PLOTTED, PLOTTED // max(1, len(drawing.quantities))))
    if max(float(np.abs(x).max()) for x in (drawing.t - zero, trail, poses[..., :3, 3])) > np.finfo("f4").max:
        raise InputError(f"times or lengths beyond {np.finfo('f4').max:.2g} s or m cannot be drawn in a browser")
    quantities = []
    for quantity in drawing.quantities:  # its samples in LEVELS from its least to its largest value
        low, high = float(quantity.values.min()), float(quantity.values.max())
        middle = (low + high) / 2
        least = 1e-9 * max(abs(low), abs(high)) or 1.0  # what varies by less is a straight line
        low, high = min(low, middle - least), max(high, middle + least)
        data = base64_of((LEVELS * ((quantity.values[rows] - low) / (high - low))).round().astype("<u2").tobytes())
        quantities.append({"name": quantity.name, "unit": quantity.unit, "low": low, "high": high, "data": data})
    return {
        "label": drawing.label,
        "duration": duration,
        "bodies": len(bodies),
        "support": bodies.index(drawing.support) if drawing.support in bodies else None,
        "times": _floats(drawing.t[keys] - zero),
        "positions": _integers(poses[..., :3, 3].swapaxes(0, 1)),
        "quaternions": _integers(quaternions(poses[..., :3, :3]).swapaxes(0, 1)),
        "forces": forces,
        "moments": moments if moments and moments["largest"] > rounding else None,
        "trail": {"times": _floats(trail_times - zero), "points": _integers(trail)},
        "curves": {"times": _floats(drawing.t[rows] - zero), "quantities": quantities},
        "plots": [{"title": plot.title, "curves": [c._asdict() for c in plot.curves]} for plot in drawing.plots],
    }


def _fractions(vectors: Array | None, keys: NDArray[np.intp], bodies: list[int]) -> dict[str, Any] | None:
    """Vectors (n, bodies, 3) at some times over the largest of them; None where there are none but 0."""
    largest = 0.0 if vectors is None else float(np.linalg.norm(vectors[keys][:, bodies], axis=-1).max())
    if vectors is None or not largest > 0:
        return None
    return {"largest": largest, **_integers(vectors[keys][:, bodies].swapaxes(0, 1) / largest)}


def _stand_still(drawing: Drawing) -> Drawing:
    """The drawing, or, of a single pose, one that stands still for a second."""
    if len(drawing.t) > 1:
        return drawing
    arrays = {name: getattr(drawing, name) for name in ("poses", "trail", "forces", "moments")}
    twice = {name: None if given is None else np.repeat(given, 2, axis=0) for name, given in arrays.items()}
    quantities = tuple(quantity._replace(values=np.repeat(quantity.values, 2)) for quantity in drawing.quantities)
    return replace(drawing, t=drawing.t[0] + np.array([0.0, 1.0]), velocity=None, quantities=quantities, **twice)


def pick(t: Array, per_second: float, most: int) -> NDArray[np.intp]:
    """Indices (k,) of times t (n,) in s to keep, evenly spread, both ends among them: `per_second`, and `most`, at most."""
    wanted = int(min(len(t), max(2, (t[-1] - t[0]) * per_second + 1), max(2, most)))
    return np.unique(np.linspace(0, len(t) - 1, wanted).round().astype(np.intp))


def quaternions(rotations: Array) -> Array:
    """Quaternions (n, bodies, 4), order x, y, z, w, of rotations (n, bodies, 3, 3), without jumps of sign along n."""
    make = pinocchio().Quaternion  # SciPy's take 0.25 s to import
    q = np.array([make(R).coeffs() for R in rotations.reshape(-1, 3, 3)]).reshape(*rotations.shape[:2], 4)
    turned = np.where((q[1:] * q[:-1]).sum(axis=-1) < 0, -1.0, 1.0)
    q[1:] *= np.cumprod(turned, axis=0)[..., None]
    return q


def _floats(values: Array) -> str:
    """Values (...) as numbers of 32 bits, in text."""
    return base64_of(values.astype("<f4").tobytes())


def _integers(values: Array) -> dict[str, Any]:
    """Values (...) as whole numbers of 16 bits, in text, and what one of them is worth."""
    scale = float(np.abs(values).max(initial=0.0)) / 32767 or 1.0
    return {"scale": scale, "data": base64_of((values / scale).round().astype("<i2").tobytes())}


@cache
def _viewer(name: str) -> str:
    spec = importlib.util.find_spec("meshcat")
    if spec is None or not spec.submodule_search_locations:
        raise MissingLibrary("pictures in 3D need meshcat's viewer: pip install meshcat")
    return Path(spec.submodule_search_locations[0], "viewer", "dist", name).read_text(encoding="utf-8")


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
        look = {"color": tone, "specular": 0x202020, "shininess": 40, "side": 2}  # both: meshes may be turned about
        material = materials.setdefault(tone, {"uuid": f"color_{tone:06x}", "type": "MeshPhongMaterial"} | look)
        solid = {"type": "Mesh", "geometry": geometries[key]["uuid"], "material": material["uuid"]}
        placement = shape.placement  # three.js's cylinders lie along y, and its meshes get their scale here
        if shape.geometry == "cylinder":
            placement = placement @ np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
        elif shape.geometry == "mesh":
            placement = placement @ np.diag([*shape.size, 1.0])
        matrix = [round(float(x), 9) for x in placement.T.flat]
        groups[shape.body].append(solid | {"castShadow": shadows, "matrix": matrix})
    names = {body: f"body_{i}" for i, body in enumerate(bodies)} | {WORLD: "world"}
    children = [{"type": "Group", "uuid": names[b], "name": names[b], "children": x} for b, x in groups.items()]
    return {
        "metadata": {"version": 4.5, "type": "Object"},
        "geometries": list(geometries.values()),
        "materials": list(materials.values()),
        "object": {"type": "Group", "uuid": "solids", "name": "solids", "children": children},
    }


def _geometry(shape: Shape, thinnest: float) -> dict[str, Any]:
    if shape.geometry == "mesh":
        path = Path(shape.path)
        kind = MESHES.get(path.suffix.lower())
        if kind is None:
            raise InputError(f"{path}: a mesh to be drawn is one of: {choices(MESHES)}")
        with inside(str(path)):
            data = read_whole(path, MESH_BYTES, "a mesh")
        if kind == "dae":  # meshcat joins the parts of a file: they need the same attributes, places and normals
            data = re.sub(rb"semantic=([\"'])(?:TEXCOORD|COLOR)\1", rb"semantic=\1LEFT_OUT\1", data)
        content = {"base64": base64_of(data)} if kind == "stl" else {"data": data.decode(errors="replace")}
        return {"type": "_meshfile_geometry", "format": kind, "name": path.name} | content
    if shape.geometry == "box":
        return {"type": "BoxGeometry"} | dict(zip(("width", "height", "depth"), shape.size, strict=True))
    radius = max(shape.size[0], thinnest)
    if shape.geometry == "sphere":
        return {"type": "SphereGeometry", "radius": radius, "widthSegments": 24, "heightSegments": 16}
    ends = {"radiusTop": radius, "radiusBottom": radius}
    return {"type": "CylinderGeometry"} | ends | {"height": shape.size[1], "radialSegments": 24}


def base64_of(data: bytes) -> str:
    """Bytes as text of 64 letters, as a page holds them."""
    return base64.b64encode(data).decode("ascii")
