"""A run as something that moves: in a notebook, as an HTML page, a GIF or a film."""

import html
from pathlib import Path

from pendpin.errors import InputError, MissingLibrary
from pendpin.graphics.compare import Runs, runs_of
from pendpin.graphics.drawing import Drawing
from pendpin.graphics.film import write_film
from pendpin.graphics.ghosts import compared_drawing
from pendpin.graphics.page import compressed, page, write_page
from pendpin.graphics.report import Check, report_of
from pendpin.ground.files import path_of
from pendpin.trajectory import RunRecord

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
        return compared_drawing(self._runs), report_of(self._runs, self._check)

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
