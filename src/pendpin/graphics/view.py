"""A run that moves: in a notebook, as an HTML page or a film, live in a browser, in meshcat's or Pinocchio's viewer."""

import html
import os
import sys
import threading
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from pendpin.errors import InputError, MissingLibrary, shown
from pendpin.graphics.drawing import Drawing, Runs, labels_of, runs_of, smooth
from pendpin.graphics.page import FRAMES_PER_SECOND as PAGE_RATE
from pendpin.graphics.page import compress, page, pick, solids, write_page
from pendpin.graphics.report import Check, page_report
from pendpin.graphics.run_drawing import compared_drawing, drawing_of, ends_of
from pendpin.graphics.style import COLORS, plain_name
from pendpin.ground.arrays import Array
from pendpin.ground.files import path_of, write_whole
from pendpin.ground.libraries import optional
from pendpin.model.kinematics import configurations
from pendpin.trajectory import RunRecord

HEIGHT = 600  # pixels, of the player in a notebook


class Animation:
    """The motion of a run. In a notebook it shows itself; `save` writes it."""

    def __init__(self, run: RunRecord, compare: Runs = None, check: Check | None = None) -> None:
        self._runs = runs_of(run, compare)
        self._check = check  # a cross-check along a run, for the report

    def save(self, path: str | Path) -> Path:
        """Write it as .html (the player, with nothing else needed), .gif or .mp4, whole or not at all.

        The page holds a report on the run below the player. Its address may end in what it shall show, as in
        run.html#t=1.5&view=above&speed=5&reactions=on&frames=on.
        Raises InputError for other names, MissingLibrary for .mp4 without imageio-ffmpeg.
        """
        path = path_of(path)
        suffix = path.suffix.lower()
        if suffix == ".html":
            return write_page(path, *self.drawing_and_report())
        if suffix not in (".gif", ".mp4"):
            raise InputError(f"{path}: an animation's name ends in one of: .html, .gif, .mp4")
        # a film, in real time or faster
        from tempfile import TemporaryDirectory

        from matplotlib import rc_context
        from matplotlib.animation import FFMpegWriter, PillowWriter

        settings: Any = {"text.usetex": False}
        if suffix == ".mp4":
            encoder = optional("imageio_ffmpeg", "a film as .mp4", "imageio-ffmpeg (or write a .gif)")
            settings["animation.ffmpeg_path"] = encoder.get_ffmpeg_exe()
        with rc_context(settings), TemporaryDirectory() as folder, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            figure, draw, count = _film(self._runs)
            writer = (PillowWriter if suffix == ".gif" else FFMpegWriter)(fps=FILM_RATE)
            film = Path(folder, f"film{suffix}")
            with writer.saving(figure, str(film), dpi=100):
                for frame in range(count):
                    draw(frame)
                    writer.grab_frame()
            return write_whole(path, lambda file: file.write(film.read_bytes()))

    def drawing_and_report(self) -> tuple[Drawing, str]:
        """What a page of it shows: the motion, and the report on the run as HTML."""
        return compared_drawing(self._runs), page_report(self._runs, self._check)

    def __repr__(self) -> str:
        run = self._runs[0]
        return f"Animation of {run.t[-1] - run.t[0]:g} s: .save('run.html'), .gif or .mp4; a notebook shows it"

    def _repr_html_(self) -> str:
        return frame_of(*self._runs)


def frame_of(*runs: RunRecord) -> str:
    """The player of a run, or of several, as a frame for a notebook; the reason where it cannot be drawn."""
    if not len(runs[0].t):
        return ""
    try:
        content = compress(page(compared_drawing(runs)))
    except (InputError, MissingLibrary) as error:
        return f"<p>{html.escape(str(error))}</p>"
    return (
        f'<iframe srcdoc="{html.escape(content)}" style="width: 100%; height: {HEIGHT}px; border: 1px solid #ddd" '
        'sandbox="allow-scripts" loading="lazy" title="The motion in 3D"></iframe>'
    )


# --- a run as a film: a GIF or an MP4 of its rods, drawn by matplotlib, seen from a little above --------------------

FILM_RATE, MOST_FRAMES = 25, 1500  # frames a second, and in all
MOST_DOTS = 20  # joints that are drawn
PATH_POINTS, PATH_RATE = 20_000, 60  # of the path: at most, and in a second at least
AZIMUTH, ELEVATION = np.radians(30.0), np.radians(15.0)  # of the eye


def _film(runs: Sequence[RunRecord]) -> tuple[Any, Callable[[int], None], int]:
    """A figure, what draws a frame on it, and how many frames there are: the first run, the others as ghosts."""
    from matplotlib.figure import Figure

    run = runs[0]
    rows = pick(run.t, FILM_RATE, MOST_FRAMES)
    times, path = run.t, run.tips[:, -1]
    if len(times) > 1:
        drawing = drawing_of(run)
        times, path = smooth(drawing.t, drawing.trail, drawing.velocity, PATH_RATE, PATH_POINTS)
    path = _project(path)
    all_ends = [_project(ends_of(one)) for one in runs]  # (n, bodies, 2, 2); below as a line (n, 3 bodies, 2) with gaps
    lines = [np.insert(ends, 2, np.nan, axis=2).reshape(len(ends), -1, 2) for ends in all_ends]

    points = np.concatenate([*(one.reshape(-1, 2) for one in all_ends), path])
    middle, reach = (points.min(0) + points.max(0)) / 2, 0.55 * max(float(np.ptp(points, axis=0).max()), 1e-9)
    figure = Figure(figsize=(4.8, 4.8))
    axes = figure.add_axes((0.0, 0.0, 1.0, 0.92))
    axes.set(xlim=middle[0] + [-reach, reach], ylim=middle[1] + [-reach, reach], aspect="equal")
    axes.set_axis_off()
    figure.suptitle(plain_name(run.title, 50), fontsize=11, y=0.985)
    trail = axes.plot([], [], color=COLORS[0], linewidth=0.8, alpha=0.7)[0]
    colors = (COLORS[1], COLORS[2], COLORS[3], COLORS[5])[: len(runs)]
    ghosts = [axes.plot([], [], color=color, linewidth=2.5, alpha=0.5)[0] for color in colors[1:]]
    dots = {"marker": "o" if all_ends[0].shape[1] <= MOST_DOTS else "", "markersize": 4}
    rods = axes.plot([], [], color=colors[0], linewidth=2.5, **dots)[0]
    pivot = axes.plot([], [], marker="s", color="#7a8696", markersize=8)[0]
    for i, (label, color) in enumerate(zip(labels_of(runs)[::-1], colors[::-1], strict=True) if len(runs) > 1 else ()):
        axes.text(0.03, 0.02 + 0.045 * i, plain_name(label), color=color, fontsize=9, transform=axes.transAxes)
    clock = axes.text(0.5, 0.99, "", transform=axes.transAxes, ha="center", va="top")

    def draw(frame: int) -> None:
        row = rows[frame]
        for ghost, other, line in zip(ghosts, runs[1:], lines[1:], strict=True):
            ghost.set_data(*line[max(0, np.searchsorted(other.t, run.t[row], "right") - 1)].T)
        rods.set_data(*lines[0][row].T)
        pivot.set_data(*all_ends[0][row, :1, 0].T)
        trail.set_data(*path[: np.searchsorted(times, run.t[row], "right")].T)
        clock.set_text(f"t = {run.t[row]:.2f} s")

    return figure, draw, len(rows)


def _project(points: Array) -> Array:
    """Points (..., 3) in W as the eye sees them, (..., 2) to the right and up, without perspective."""
    x, y, z = np.moveaxis(points, -1, 0)
    right, depth = np.cos(AZIMUTH) * x + np.sin(AZIMUTH) * y, -np.sin(AZIMUTH) * x + np.cos(AZIMUTH) * y
    return np.stack([right, np.cos(ELEVATION) * z + np.sin(ELEVATION) * depth], -1)


# --- a drawing live in the browser, served to this machine only -----------------------------------------------------

ADDRESS = "127.0.0.1"
PATIENCE: float | None = 10.0  # s, for a request to arrive


def serve(drawing: Drawing, ready: Callable[[str], object], report: str = "", open_browser: bool = False) -> None:
    """Show a drawing live to this machine alone, until Ctrl-C; `ready` gets the address once it answers."""
    with _server(page(drawing, report, live=True).encode(errors="replace")) as server:
        url = f"http://{ADDRESS}:{server.server_address[1]}/"
        try:
            ready(url)
            screen = any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY"))) or sys.platform == "darwin"
            if open_browser and screen:  # a browser in the terminal would take the terminal over
                import webbrowser

                threading.Thread(target=webbrowser.open, args=(url,), daemon=True).start()
            server.serve_forever(poll_interval=0.25)  # s, as a wait is not always woken by Ctrl-C
        except KeyboardInterrupt:
            pass  # the usual end


def _server(content: bytes) -> Any:
    """A server of one page at a free port. Its modules are imported here: they take as long as all that a page needs."""
    from http.server import BaseHTTPRequestHandler
    from socketserver import ThreadingTCPServer

    class Server(ThreadingTCPServer):
        daemon_threads = True  # a slow browser does not hold up the end

        def handle_error(self, request: Any, client_address: Any) -> None:
            """A browser that went away is no error."""
            if not isinstance(sys.exception(), ConnectionError | TimeoutError):
                super().handle_error(request, client_address)

    class Handler(BaseHTTPRequestHandler):
        timeout = PATIENCE

        def do_GET(self) -> None:
            """Answer `/` with the page and `/alive` with nothing, and only to a browser of this machine."""
            port = cast(Server, self.server).server_address[1]
            status, answer = 404, b""
            if self.headers.get("Host") not in {f"{ADDRESS}:{port}", f"localhost:{port}"}:
                status = 403  # a foreign name that was made to point here
            elif self.path == "/":
                status, answer = 200, content
            elif self.path == "/alive":
                status = 204
            self.send_response(status)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.send_header("Content-Length", str(len(answer)))
            self.send_header("Cache-Control", "no-store")
            self.send_header("Cross-Origin-Resource-Policy", "same-origin")
            self.send_header("X-Frame-Options", "DENY")
            self.end_headers()
            self.wfile.write(answer)

        def log_message(self, format: str, *args: Any) -> None:
            """Say nothing: the terminal belongs to the command."""

    return Server((ADDRESS, 0), Handler)


# --- a run in a viewer that the user has: meshcat's, or Pinocchio's with the meshes of a URDF -----------------------

KEYS = 2000  # poses of a body at most
GROUP = "pendpin"  # what is shown stands below this path of the viewer
FROM = (1.0, 0.27, 0.72)  # in the camera's axes, in which y is up
AWAY = 1.3  # times as far as the farthest point


def show(run: RunRecord, viewer: Any) -> Any:
    """Show a run in a viewer (Trajectory.show); the viewer is returned."""
    if hasattr(viewer, "display") and hasattr(viewer, "model"):  # Pinocchio's, in real time
        rows, moving = pick(run.t, PAGE_RATE / 2, KEYS), configurations(run, viewer.model)
        if len(rows) < 2:
            viewer.display(moving[0])
        else:
            viewer.play(moving[rows], float((run.t[-1] - run.t[0]) / (len(rows) - 1)))
        return viewer
    if not (hasattr(viewer, "set_animation") and hasattr(viewer, "window")):
        raise InputError(f"show: {shown(viewer)} is neither a meshcat.Visualizer nor Pinocchio's MeshcatVisualizer")
    # as an animation of meshcat: the solids of the run, and their poses over time
    animation = optional("meshcat.animation", "show", "meshcat")
    drawing = drawing_of(run)
    group = viewer[GROUP]
    group.delete()
    for place, shape in enumerate(drawing.shapes):  # as the page has them
        carrier = "world" if shape.body < 0 else f"body_{shape.body}"
        one, path = replace(drawing, shapes=(shape,)), group[carrier][f"shape_{place}"].path.lower()
        command = {"type": "set_object", "path": path, "object": solids(one, [max(shape.body, 0)])}
        viewer.window.send(SimpleNamespace(lower=lambda command=command: command))
    farthest = np.linalg.norm(np.concatenate([drawing.trail, drawing.poses[:, 0, :3, 3]]), axis=-1).max()
    distance = AWAY * (float(farthest) or 1.0)  # of the camera, which looks at the origin and sees all of it
    for name, value in (("position", [distance * x for x in FROM]), ("near", distance / 100), ("far", 100 * distance)):
        viewer["/Cameras/default/rotated/<object>"].set_property(name, value)
    film = animation.Animation(default_framerate=PAGE_RATE)
    for row in pick(drawing.t, PAGE_RATE / 2, KEYS):
        with film.at_frame(viewer, round(float(drawing.t[row] - drawing.t[0]) * PAGE_RATE)) as frame:
            for body in {shape.body for shape in drawing.shapes if shape.body >= 0}:
                frame[GROUP][f"body_{body}"].set_transform(drawing.poses[row, body])
    viewer.set_animation(film, play=True, repetitions=1)
    return viewer
