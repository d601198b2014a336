"""A run as something that moves: in a notebook, as an HTML page, a GIF or a film."""

import html
from pathlib import Path

from pendpin.errors import InputError, MissingLibrary
from pendpin.graphics.film import write_film
from pendpin.graphics.page import page, write_page
from pendpin.graphics.run_drawing import drawing_of
from pendpin.trajectory import Trajectory

HEIGHT = 600  # pixels, of the player in a notebook
SUFFIXES = (".html", ".gif", ".mp4")


class Animation:
    """The motion of a run. In a notebook it shows itself; `save` writes it."""

    def __init__(self, run: Trajectory) -> None:
        self._run = run

    def save(self, path: str | Path) -> Path:
        """Write it as .html (the player, with nothing else needed), .gif or .mp4, whole or not at all.

        The page's address may end in what it shall show, as in run.html#t=1.5&view=above&speed=5&reactions=on.
        Raises InputError for other names, MissingLibrary for .mp4 without imageio-ffmpeg.
        """
        path = Path(path)
        match path.suffix.lower():
            case ".html":
                return write_page(path, drawing_of(self._run))
            case ".gif" | ".mp4" as suffix:
                return write_film(path, self._run, suffix)
        raise InputError(f"{path}: an animation's name ends in one of: {', '.join(SUFFIXES)}")

    def __repr__(self) -> str:
        run = self._run
        return f"Animation of {run.t[-1] - run.t[0]:g} s: .save('run.html'), .gif or .mp4; a notebook shows it"

    def _repr_html_(self) -> str:
        return frame_of(self._run)


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
        'sandbox="allow-scripts" loading="lazy" title="The motion in 3D"></iframe>'
    )
