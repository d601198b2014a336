"""What commands write: the files of a run, and the run in a browser."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pendpin.graphics.animation import Animation
    from pendpin.motions.trajectory import Trajectory

SUFFIXES = {
    "run": (".npz", ".csv"),
    "html": (".html",),
    "film": (".gif", ".mp4"),
    "csv": (".csv",),
}  # by what is written


def refuse_outputs(read: Iterable[Path | None], **written: Path | None) -> None:
    """Refuse, before the work begins, files that cannot be written, that are read too, or are named as another format.

    What is written is a plot, html, film, csv or run; what has another name here may have any suffix.
    """
    from pendpin.graphics.figure import picture_kind
    from pendpin.ground.files import refuse_other_format, refuse_targets

    refuse_targets(filter(None, written.values()), list(filter(None, read)))
    for kind, path in written.items():
        if path and kind == "plot":
            picture_kind(path)
        elif path and kind in SUFFIXES:
            refuse_other_format(path, *SUFFIXES[kind])


def write_run(trajectory: "Trajectory", out: Path, plot: Path | None, html: Path | None) -> list[Path]:
    """The files of a run: its numbers first, then the figure and the page where they are asked for."""
    from pendpin.graphics.figure import save_plot

    files = [trajectory.to_csv(out) if out.suffix.lower() == ".csv" else trajectory.save(out)]
    if plot:
        files.append(save_plot(trajectory, plot))
    if html:
        files.append(trajectory.animate().save(html))
    return files


def show_live(animation: "Animation") -> None:
    """Show the motion of a run in a browser until Ctrl-C."""
    from pendpin.graphics.view import serve

    drawing, report = animation.drawing_and_report()
    serve(drawing, report, ready=lambda url: print(f"{url}  (Ctrl-C ends it)", flush=True), open_browser=True)
