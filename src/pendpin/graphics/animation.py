"""A run as something that moves: in a notebook, as an HTML page, a GIF or a film."""

import html
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

import numpy as np

from pendpin.arrays import Array
from pendpin.errors import InputError, MissingLibrary
from pendpin.files import write_whole
from pendpin.graphics.page import page, write_page
from pendpin.graphics.run_drawing import drawing_of
from pendpin.trajectory import Trajectory

FRAMES_PER_SECOND = 25
MOST_FRAMES = 1500
SIZE = 4.8  # inches, of a film, square
DPI = 100
HEIGHT = 420  # pixels, of the player in a notebook
AZIMUTH, ELEVATION = np.radians(30.0), np.radians(15.0)  # of the eye of a film
SUFFIXES = (".html", ".gif", ".mp4")


class Animation:
    """The motion of a run. In a notebook it shows itself; `save` writes it."""

    def __init__(self, run: Trajectory) -> None:
        self._run = run

    def save(self, path: str | Path) -> Path:
        """Write it as .html (the player, with nothing else needed), .gif or .mp4, whole or not at all.

        Raises InputError for other names, MissingLibrary for .mp4 without imageio-ffmpeg.
        """
        path = Path(path)
        match path.suffix.lower():
            case ".html":
                return write_page(path, drawing_of(self._run))
            case ".gif" | ".mp4" as suffix:
                return _write_film(path, self._run, suffix)
        raise InputError(f"{path}: an animation's name ends in one of: {', '.join(SUFFIXES)}")

    def __repr__(self) -> str:
        run = self._run
        return f"Animation of {run.t[-1] - run.t[0]:g} s: .save('run.html'), .gif or .mp4; a notebook shows it"

    def _repr_html_(self) -> str:
        return frame_of(self._run)


def animate(run: Trajectory) -> Animation:
    """As `Trajectory.animate`."""
    return Animation(run)


def frame_of(run: Trajectory) -> str:
    """The player of a run as a frame for a notebook; what stands in its way, where it cannot be drawn."""
    if not len(run.t):
        return ""
    try:
        content = page(drawing_of(run))
    except (InputError, MissingLibrary) as error:
        return f"<p>{html.escape(str(error))}</p>"
    return (
        f'<iframe srcdoc="{html.escape(content)}" style="width: 100%; height: {HEIGHT}px; border: 1px solid #ddd" '
        'sandbox="allow-scripts"></iframe>'
    )


# --- films ----------------------------------------------------------------------------------------------------------


def _write_film(path: Path, run: Trajectory, suffix: str) -> Path:
    """Draw the rods frame by frame, seen from a little above, in real time or faster."""
    from tempfile import TemporaryDirectory

    from matplotlib import rc_context
    from matplotlib.animation import FFMpegWriter, PillowWriter

    settings: Any = {} if suffix == ".gif" else {"animation.ffmpeg_path": _ffmpeg()}
    figure, draw, count = _film(run)
    with rc_context(settings), TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        writer = (PillowWriter if suffix == ".gif" else FFMpegWriter)(fps=FRAMES_PER_SECOND)
        film = Path(folder, f"film{suffix}")
        with writer.saving(figure, str(film), DPI):
            for frame in range(count):
                draw(frame)
                writer.grab_frame()
        return write_whole(path, lambda file: _copy(film, file))


def _copy(film: Path, file: IO[bytes]) -> None:
    file.write(film.read_bytes())


def _ffmpeg() -> str:
    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError:
        raise MissingLibrary(
            "a film as .mp4 needs imageio-ffmpeg: pip install imageio-ffmpeg; .gif needs nothing"
        ) from None
    return get_ffmpeg_exe()


def _film(run: Trajectory) -> tuple[Any, Callable[[int], None], int]:
    """A figure, what draws a frame on it, and how many frames there are."""
    from matplotlib.figure import Figure

    span = run.t[-1] - run.t[0]
    count = int(min(max(2.0, span * FRAMES_PER_SECOND), MOST_FRAMES, len(run.t)))
    rows = np.linspace(0, len(run.t) - 1, count).round().astype(int)
    chains = np.concatenate([np.zeros((count, 1, 3)), run.tip[rows]], 1)
    x, y = _seen(chains)
    reach = 1.08 * max(float(np.abs(np.stack([x, y])).max()), 1e-9)
    figure = Figure(figsize=(SIZE, SIZE))
    axes = figure.add_axes((0.02, 0.02, 0.96, 0.9))
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", xticks=[], yticks=[])
    axes.plot([0], [0], marker="s", color="#7a8696", markersize=8)
    trail = axes.plot([], [], color="#2b6cb0", linewidth=0.8, alpha=0.6)[0]
    rods = axes.plot(
        [], [], color="#d9622b", linewidth=2.5, marker="o" if run.tip.shape[1] <= 20 else "", markersize=4
    )[0]
    clock = axes.set_title("")

    def draw(frame: int) -> None:
        rods.set_data(x[frame], y[frame])
        trail.set_data(x[: frame + 1, -1], y[: frame + 1, -1])
        clock.set_text(f"t = {run.t[rows[frame]]:.2f} s")

    return figure, draw, count


def _seen(points: Array) -> tuple[Array, Array]:
    """Points (..., 3) in W as the eye sees them, to the right and up, without perspective."""
    x, y, z = np.moveaxis(points, -1, 0)
    right, depth = np.cos(AZIMUTH) * x + np.sin(AZIMUTH) * y, -np.sin(AZIMUTH) * x + np.cos(AZIMUTH) * y
    return right, np.cos(ELEVATION) * z + np.sin(ELEVATION) * depth
