"""A motion in a viewer: live in the browser, served to this machine only; in meshcat's or Pinocchio's own."""

import os
import socketserver
import sys
import threading
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler
from typing import Any, cast

import numpy as np

from pendpin.errors import InputError, shown
from pendpin.graphics.drawing import Drawing
from pendpin.graphics.page import FRAMES_PER_SECOND, page, pick, placed
from pendpin.graphics.run_drawing import drawing_of
from pendpin.ground.libraries import optional
from pendpin.model.kinematics import configurations
from pendpin.trajectory import RunRecord

KEYS = 2000  # poses of a body at most
GROUP = "pendpin"  # what is shown stands below this path of the viewer
CAMERA = "/Cameras/default/rotated/<object>"
FROM = (1.0, 0.27, 0.72)  # in the camera's axes, in which y is up
AWAY = 1.3  # times as far as the farthest point
ADDRESS = "127.0.0.1"


def serve(
    drawing: Drawing,
    report: str = "",
    *,
    port: int = 0,
    ready: Callable[[str], object] = lambda url: None,
    duration: float | None = None,
    open_browser: bool = False,
) -> None:
    """Show a drawing live at http://127.0.0.1:port/ until Ctrl-C, or for `duration` s.

    Only this machine can reach it. Port 0 means any free one. `ready` is called with the address once it answers; every
    browser that opens it sees the whole motion. Raises InputError where the port is taken or not allowed.
    """
    content = page(drawing, report, live=True).encode(errors="replace")
    end = None if duration is None else time.monotonic() + duration
    with _listen(port, content) as server:
        url = f"http://{ADDRESS}:{server.server_address[1]}/"
        try:
            ready(url)
            if open_browser:
                _open(url)
            while end is None or time.monotonic() < end:
                server.handle_request()
        except KeyboardInterrupt:
            pass  # the usual end


class _Server(socketserver.ThreadingTCPServer):
    daemon_threads = True  # a slow browser does not hold up the end
    allow_reuse_address = os.name == "posix"  # elsewhere it would let two programs share a port
    timeout = 0.25  # s, between looks at the clock
    content: bytes

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that went away is no error."""
        if not isinstance(sys.exception(), ConnectionError | TimeoutError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    timeout = 10.0  # s, for a request to arrive

    def do_GET(self) -> None:
        """Answer `/` with the page and `/alive` with nothing, and only to a browser of this machine."""
        server = cast(_Server, self.server)
        port = server.server_address[1]
        if self.headers.get("Host") not in {f"{ADDRESS}:{port}", f"localhost:{port}"}:
            self._answer(403, b"")  # a foreign name that was made to point here
        elif self.path == "/":
            self._answer(200, server.content)
        elif self.path == "/alive":
            self._answer(204, b"")
        else:
            self._answer(404, b"")

    def _answer(self, status: int, content: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", "text/html; charset=utf-8")
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.send_header("X-Frame-Options", "DENY")
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing: the terminal belongs to the command."""


def _listen(port: int, content: bytes) -> _Server:
    if not 0 <= port <= 65535:
        raise InputError(f"port {port} is not between 0 and 65535")
    try:
        server = _Server((ADDRESS, port), _Handler)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"port {port} of {ADDRESS}: {reason}; choose another, or 0 for any free one") from None
    server.content = content
    return server


def _open(url: str) -> None:
    """Open the user's browser, where there is a screen; a browser in the terminal would take the terminal over."""
    import webbrowser

    if sys.platform in {"win32", "darwin"} or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        threading.Thread(target=webbrowser.open, args=(url,), daemon=True).start()


# --- a run in a viewer that the user has: meshcat's, or Pinocchio's with the meshes of a URDF -----------------------


def show(run: RunRecord, viewer: Any) -> Any:
    """Show a run in a viewer (Trajectory.show); the viewer is returned."""
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
