"""What commands write: the files of a run, and the run in a browser."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pendpin.trajectory import Trajectory

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
    from pendpin.files import refuse_other_format, refuse_targets
    from pendpin.graphics.figure import picture_kind

    refuse_targets(filter(None, written.values()), list(filter(None, read)))
    for kind, path in written.items():
        if path and kind == "plot":
            picture_kind(path)
        elif path and kind in SUFFIXES:
            refuse_other_format(path, *SUFFIXES[kind])


def write_run(trajectory: "Trajectory", out: Path, plot: Path | None, html: Path | None) -> list[Path]:
    """The files of a run: its numbers first, then the figure and the page where they are asked for."""
    files = [trajectory.to_csv(out) if out.suffix.lower() == ".csv" else trajectory.save(out)]
    if plot:
        files.append(save_plot(trajectory, plot))
    if html:
        files.append(write_animation(trajectory, html))
    return files


def save_plot(
    trajectory: "Trajectory", path: Path, names: tuple[str, ...] = (), compare: Sequence["Trajectory"] = ()
) -> Path:
    """Write the figure of a run, or of quantities of it, with others on the same axes. Raises InputError."""
    from pendpin.graphics.compare import runs_of
    from pendpin.graphics.figure import save_plot

    return save_plot(trajectory, path, names, runs_of(trajectory, compare)[1:])


def write_animation(trajectory: "Trajectory", path: Path, compare: Sequence["Trajectory"] = ()) -> Path:
    """Write the animation of a run, with others as ghosts: a film, or a page with the report on them. Raises InputError."""
    return trajectory.animate(compare).save(path)


def show_run(trajectory: "Trajectory", compare: Sequence["Trajectory"] = ()) -> None:
    """Show a run in a browser until Ctrl-C, with others as ghosts."""
    from pendpin.crosschecks.crosscheck import verdict_along
    from pendpin.graphics.compare import runs_of
    from pendpin.graphics.ghosts import compared_drawing
    from pendpin.graphics.report import report_of
    from pendpin.graphics.view import serve

    runs = runs_of(trajectory, compare)
    drawing, report = compared_drawing(runs), report_of(runs, verdict_along)
    serve(drawing, report, ready=lambda url: print(f"{url}  (Ctrl-C ends it)", flush=True), open_browser=True)
