"""What commands write: reports and messages, the files of a run, the run in a browser."""

import logging
import os
import sys
from collections.abc import Iterable, Mapping
from dataclasses import asdict, is_dataclass
from io import TextIOWrapper
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pendpin.ground.report import Report, Table

if TYPE_CHECKING:
    from pendpin.graphics.view import Animation
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
    from pendpin.graphics.style import picture_kind
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


# --- what the commands print on the terminal ------------------------------------------------------------------------

LEAST_WIDTH = 60  # letters: on a narrower terminal the lines of a table go on below
IN_A_FILE = 120  # letters, where the output is not a terminal


def print_report(report: Report, as_json: bool) -> None:
    """Print a report, or its data as JSON."""
    if as_json:
        print_json(report.data)
        return
    for part in report.parts:
        print(part) if isinstance(part, str) else print_table(part)


def print_table(table: Table) -> None:
    """A table on the terminal: names in the first column stay in one piece, and no letter is cut."""
    from rich import box, console
    from rich import table as rich
    from rich.text import Text

    names = not any(" " in row[0] for row in table.rows)
    columns = [rich.Column(title, overflow="fold", no_wrap=i == 0 and names) for i, title in enumerate(table.head)]
    shown = rich.Table(*columns, show_header=any(table.head[1:]), box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for row in table.rows:
        shown.add_row(*map(Text, row))  # without markup, which may be in what users named
    terminal = console.Console()
    known = terminal.is_terminal or "COLUMNS" in os.environ
    terminal.width = max(terminal.width, LEAST_WIDTH) if known else IN_A_FILE
    terminal.print(shown)
    for line in table.left_out:
        print(line)


def print_json(value: Any) -> None:
    """JSON on the terminal; a number that is not finite, which JSON lacks, is null."""
    from json import dumps

    print(dumps(_plain(value), indent=2, default=str))


def _plain(value: Any) -> Any:
    if is_dataclass(value) and not isinstance(value, type):
        value = asdict(value)
    if isinstance(value, Mapping):
        return {str(key): _plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return None if isinstance(value, float) and not isfinite(value) else value


def print_files(files: list[Path], as_json: bool = False) -> None:
    """The files written, a line each; none beside JSON."""
    for file in () if as_json else files:
        print(f"wrote {file}")


# --- the standard streams of the process ----------------------------------------------------------------------------


def prepare_streams() -> None:
    """Make the standard streams safe to use.

    A closed one is opened on the null device, or the next file would take its number and get what is printed; output
    that was closed goes to one that only reads, so that printing fails and is not lost in silence. Letters that the
    terminal lacks are shown by their codes; where matplotlib keeps its cache is not said.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_WRONLY if number == 2 else os.O_RDONLY)  # takes the lowest number that is free
    sys.stdout = sys.stdout or os.fdopen(1, "w", closefd=False)
    sys.stderr = sys.stderr or os.fdopen(2, "w", closefd=False)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    logging.getLogger("matplotlib").setLevel(logging.ERROR)


def say(line: str) -> None:
    """Print a line on stderr, if that takes it."""
    try:
        print(line, file=sys.stderr, flush=True)
    except OSError:
        _drop(2)


def finish_output() -> None:
    """Write out what was printed, or drop it where nobody takes it."""
    try:
        sys.stdout.flush()
    except OSError:
        drop_output()


def drop_output() -> None:
    """Give up what stdout could not take."""
    _drop(1)


def _drop(stream: int) -> None:
    """Let the null device take what is left in a stream, or Python would complain at its end."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, stream)
    os.close(null)
