"""A run as something that moves: in a notebook, as an HTML page, a GIF or a film."""

import html
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError, MissingLibrary
from pendpin.graphics.drawing import Drawing, smooth_trail
from pendpin.graphics.page import compressed, page, pick, write_page
from pendpin.graphics.panels import Runs, labels_of, runs_of
from pendpin.graphics.report import Check, page_report
from pendpin.graphics.run_drawing import compared_drawing, drawing_of, ends_of
from pendpin.graphics.style import COLORS, plain_name
from pendpin.ground.arrays import Array
from pendpin.ground.files import path_of, write_whole
from pendpin.ground.libraries import optional
from pendpin.trajectory import RunRecord

FFMPEG = ("imageio_ffmpeg", "a film as .mp4", "imageio-ffmpeg (or write a .gif)")
FRAMES_PER_SECOND = 25
MOST_FRAMES = 1500
MOST_DOTS = 20  # joints that are drawn
PATH_POINTS = 20_000  # at most
PATH_RATE = 60  # of them in a second, at least
SIZE = 4.8  # inches, square
DPI = 100
HEIGHT = 600  # pixels, of the player in a notebook
SUFFIXES = (".html", ".gif", ".mp4")


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
        match path.suffix.lower():
            case ".html":
                return write_page(path, *self.drawing_and_report())
            case ".gif" | ".mp4" as suffix:
                return write_film(path, self._runs, suffix)
        raise InputError(f"{path}: an animation's name ends in one of: {', '.join(SUFFIXES)}")

    def drawing_and_report(self) -> tuple[Drawing, str]:
        """What a page of it shows: the motion, and the report on the run as HTML."""
        return compared_drawing(self._runs), page_report(self._runs, self._check)

    def __repr__(self) -> str:
        run = self._runs[0]
        return f"Animation of {run.t[-1] - run.t[0]:g} s: .save('run.html'), .gif or .mp4; a notebook shows it"

    def _repr_html_(self) -> str:
        return frame_of(*self._runs)


def frame_of(*runs: RunRecord) -> str:
    """The player of a run, or of several, as a frame for a notebook; what stands in its way, where it cannot be drawn."""
    if not len(runs[0].t):
        return ""
    try:
        content = compressed(page(compared_drawing(runs)))
    except (InputError, MissingLibrary) as error:
        return f"<p>{html.escape(str(error))}</p>"
    return (
        f'<iframe srcdoc="{html.escape(content)}" style="width: 100%; height: {HEIGHT}px; border: 1px solid #ddd" '
        'sandbox="allow-scripts" loading="lazy" title="The motion in 3D"></iframe>'
    )


# --- a run as a film: a GIF or an MP4 of its rods, drawn by matplotlib, seen from a little above --------------------


AZIMUTH, ELEVATION = np.radians(30.0), np.radians(15.0)  # of the eye


def write_film(path: Path, runs: Sequence[RunRecord], suffix: str) -> Path:
    """Write a film as .gif or .mp4, in real time or faster: the first run, the others as ghosts.

    Raises MissingLibrary for .mp4 without imageio-ffmpeg.
    """
    from tempfile import TemporaryDirectory

    from matplotlib import rc_context
    from matplotlib.animation import FFMpegWriter, PillowWriter

    settings: Any = {} if suffix == ".gif" else {"animation.ffmpeg_path": optional(*FFMPEG).get_ffmpeg_exe()}
    settings["text.usetex"] = False
    with rc_context(settings), TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        figure, draw, count = _film(runs)
        writer = (PillowWriter if suffix == ".gif" else FFMpegWriter)(fps=FRAMES_PER_SECOND)
        film = Path(folder, f"film{suffix}")
        with writer.saving(figure, str(film), DPI):
            for frame in range(count):
                draw(frame)
                writer.grab_frame()
        return write_whole(path, lambda file: file.write(film.read_bytes()))


def _film(runs: Sequence[RunRecord]) -> tuple[Any, Callable[[int], None], int]:
    """A figure, what draws a frame on it, and how many frames there are."""
    from matplotlib.figure import Figure

    run = runs[0]
    rows = pick(run.t, FRAMES_PER_SECOND, MOST_FRAMES)
    (times, path), all_ends = _path(run), [_seen(ends_of(one)) for one in runs]
    ends, bodies = all_ends[0], all_ends[0].shape[1]
    lines, *others = map(_lines, all_ends)
    points = np.concatenate([*(one.reshape(-1, 2) for one in all_ends), path])
    middle, reach = (points.min(0) + points.max(0)) / 2, 0.55 * max(float(np.ptp(points, axis=0).max()), 1e-9)
    figure = Figure(figsize=(SIZE, SIZE))
    axes = figure.add_axes((0.0, 0.0, 1.0, 0.92))
    axes.set(xlim=middle[0] + [-reach, reach], ylim=middle[1] + [-reach, reach], aspect="equal")
    axes.set_axis_off()
    figure.suptitle(plain_name(run.title, 50), fontsize=11, y=0.985)
    trail = axes.plot([], [], color=COLORS[0], linewidth=0.8, alpha=0.7)[0]
    colors = (COLORS[2], COLORS[3], COLORS[5])
    ghosts = [
        axes.plot([], [], color=color, linewidth=2.5, alpha=0.5)[0] for _, color in zip(others, colors, strict=False)
    ]
    rods = axes.plot([], [], color=COLORS[1], linewidth=2.5, marker="o" if bodies <= MOST_DOTS else "", markersize=4)[0]
    pivot = axes.plot([], [], marker="s", color="#7a8696", markersize=8)[0]
    for i, (label, color) in enumerate(
        zip(labels_of(runs)[::-1], (COLORS[1], *colors)[len(runs) - 1 :: -1], strict=True)
    ):
        if others:
            axes.text(0.03, 0.02 + 0.045 * i, plain_name(label), color=color, fontsize=9, transform=axes.transAxes)
    clock = axes.text(0.5, 0.99, "", transform=axes.transAxes, ha="center", va="top")

    def draw(frame: int) -> None:
        row = rows[frame]
        for ghost, other, line in zip(ghosts, runs[1:], others, strict=True):
            ghost.set_data(*line[max(0, np.searchsorted(other.t, run.t[row], "right") - 1)].T)
        rods.set_data(*lines[row].T)
        pivot.set_data(*ends[row, :1, 0].T)
        trail.set_data(*path[: np.searchsorted(times, run.t[row], "right")].T)
        clock.set_text(f"t = {run.t[row]:.2f} s")

    return figure, draw, len(rows)


def _lines(ends: Array) -> Array:
    """Ends (n, bodies, 2, 2) as the points of one line (n, 3 bodies, 2) with gaps: bodies are separate."""
    gaps = np.full((*ends.shape[:2], 1, 2), np.nan)
    return np.concatenate([ends, gaps], axis=2).reshape(len(ends), -1, 2)


def _path(run: RunRecord) -> tuple[Array, Array]:
    """The path of the tip as it is seen: times (m,) in s and points (m, 2)."""
    if len(run.t) < 2:
        return run.t, _seen(run.tips[:, -1])
    times, path = smooth_trail(drawing_of(run), PATH_RATE, PATH_POINTS)
    return times, _seen(path)


def _seen(points: Array) -> Array:
    """Points (..., 3) in W as the eye sees them, (..., 2) to the right and up, without perspective."""
    x, y, z = np.moveaxis(points, -1, 0)
    right, depth = np.cos(AZIMUTH) * x + np.sin(AZIMUTH) * y, -np.sin(AZIMUTH) * x + np.cos(AZIMUTH) * y
    return np.stack([right, np.cos(ELEVATION) * z + np.sin(ELEVATION) * depth], -1)
