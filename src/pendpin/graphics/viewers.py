"""A run in a viewer that the user has: meshcat's, or Pinocchio's with the meshes of a URDF."""

from typing import Any

import numpy as np

from pendpin.errors import InputError, shown
from pendpin.graphics.meshcat_commands import placed
from pendpin.graphics.page import FRAMES_PER_SECOND, pick
from pendpin.graphics.run_drawing import drawing_of
from pendpin.ground.libraries import optional
from pendpin.model.configurations import configurations
from pendpin.trajectory import RunRecord

KEYS = 2000  # poses of a body at most
GROUP = "pendpin"  # what is shown stands below this path of the viewer
CAMERA = "/Cameras/default/rotated/<object>"
FROM = (1.0, 0.27, 0.72)  # in the camera's axes, in which y is up
AWAY = 1.3  # times as far as the farthest point


def show(run: RunRecord, viewer: Any) -> Any:
    """As `Trajectory.show`; the viewer is returned."""
    if hasattr(viewer, "display") and hasattr(viewer, "model"):
        return _displayed(run, viewer)
    if hasattr(viewer, "set_animation") and hasattr(viewer, "window"):
        return _animated(run, viewer)
    raise InputError(f"show: {shown(viewer)} is neither a meshcat.Visualizer nor Pinocchio's MeshcatVisualizer")


def _displayed(run: RunRecord, viewer: Any) -> Any:
    """Through Pinocchio's visualizer, in real time."""
    rows = pick(run.t, FRAMES_PER_SECOND / 2, KEYS)
    if len(rows) < 2:
        viewer.display(configurations(run, viewer.model)[0])
        return viewer
    viewer.play(configurations(run, viewer.model)[rows], float((run.t[-1] - run.t[0]) / (len(rows) - 1)))
    return viewer


def _animated(run: RunRecord, viewer: Any) -> Any:
    """As an animation of meshcat: the solids of the run, and their poses over time."""
    animation = optional("meshcat.animation", "show", "meshcat")
    drawing = drawing_of(run)
    group = viewer[GROUP]
    group.delete()
    for place, shape in enumerate(drawing.shapes):
        node = _body(group, shape.body)[f"shape_{place}"]
        node.set_object(*_object(shape))
        node.set_transform(placed(shape))
    farthest = np.linalg.norm(np.concatenate([drawing.trail, drawing.poses[:, 0, :3, 3]]), axis=-1).max()
    distance = AWAY * (float(farthest) or 1.0)  # of the camera, which looks at the origin and sees all of it
    for name, value in (("position", [distance * x for x in FROM]), ("near", distance / 100), ("far", 100 * distance)):
        viewer[CAMERA].set_property(name, value)
    rows = pick(drawing.t, FRAMES_PER_SECOND / 2, KEYS)
    film = animation.Animation(default_framerate=FRAMES_PER_SECOND)
    for row in rows:
        with film.at_frame(viewer, round(float(drawing.t[row] - drawing.t[0]) * FRAMES_PER_SECOND)) as frame:
            for body in {shape.body for shape in drawing.shapes if shape.body >= 0}:
                _body(frame[GROUP], body).set_transform(drawing.poses[row, body])
    viewer.set_animation(film, play=True, repetitions=1)
    return viewer


def _body(group: Any, body: int) -> Any:
    return group["world" if body < 0 else f"body_{body}"]


def _object(shape: Any) -> tuple[Any, Any]:
    """A solid as meshcat's geometry and material."""
    import meshcat.geometry as g

    material = g.MeshPhongMaterial(color=shape.color)
    if shape.geometry == "cylinder":
        return g.Cylinder(shape.size[1], shape.size[0]), material
    if shape.geometry == "sphere":
        return g.Sphere(shape.size[0]), material
    if shape.geometry == "box":
        return g.Box(list(shape.size)), material
    kinds = {".obj": g.ObjMeshGeometry, ".stl": g.StlMeshGeometry, ".dae": g.DaeMeshGeometry}
    kind = kinds.get(shape.path[-4:].lower())
    if kind is None:
        raise InputError(f"{shape.path}: a mesh to be shown is one of: {', '.join(kinds)}")
    return kind.from_file(shape.path), material
