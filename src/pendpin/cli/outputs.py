"""What commands show and write: reports and messages, files, what a command is doing; and how it ends at its limit."""

import logging
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from io import TextIOWrapper
from math import isfinite
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from pendpin.errors import Halted, Interrupted, PendpinError
from pendpin.ground import libraries
from pendpin.ground.arguments import seconds
from pendpin.ground.report import Report, Styled, Table


def refuse_outputs(read: Iterable[Path | None], **written: Path | None) -> None:
    """Refuse, before the work begins, files that cannot be written, are read too, or are named as another format."""
    from pendpin.graphics.style import picture_kind
    from pendpin.ground.files import refuse_other_format, refuse_targets

    suffixes = {"run": (".npz", ".csv"), "html": (".html",), "film": (".gif", ".mp4"), "csv": (".csv",)}
    refuse_targets(filter(None, written.values()), list(filter(None, read)))
    for kind, path in written.items():
        if path and kind == "plot":
            picture_kind(path)
        elif path and kind in suffixes:
            refuse_other_format(path, *suffixes[kind])


# --- what the commands print on the terminal ------------------------------------------------------------------------

LEAST_WIDTH = 60  # letters: on a narrower terminal the lines of a table go on below
LONGEST_WORD = 30  # letters: numbers and names up to this length are not cut, even where a table is then wider
IN_A_FILE = 120  # letters, where the output is not a terminal


def print_report(report: Report, as_json: bool) -> None:
    """Print a report, or its data as JSON."""
    if as_json:
        from json import dumps

        print(dumps(_finite(report.data), indent=2, default=str))
    for part in () if as_json else report.parts:
        if isinstance(part, Styled):
            from rich.console import Console
            from rich.text import Text

            Console().print(Text.assemble(*part.pieces), soft_wrap=True)
        else:
            print(part) if isinstance(part, str) else print_table(part)


@contextmanager
def reported(report: Report, as_json: bool) -> Iterator[list[Path]]:
    """Print a report after the files that are written inside, and their names: the terminal may be closed meanwhile."""
    files = list[Path]()
    try:
        yield files
    finally:  # a file that cannot be written takes no report with it
        print_report(report, as_json)
    print_files(files, as_json)


def print_table(table: Table) -> None:
    """A table on the terminal: numbers and names stay in one piece, and no letter is cut."""
    from rich import box, console
    from rich import table as rich
    from rich.text import Text

    columns = list[rich.Column]()
    for cells in zip(table.head, *table.rows, strict=True):
        lengths = [len(word) for cell in cells for word in cell.split()]
        least = max((length for length in lengths if length <= LONGEST_WORD), default=1)
        columns.append(rich.Column(cells[0], overflow="fold", min_width=least, no_wrap=max(map(len, cells)) == least))
    shown = rich.Table(*columns, show_header=any(table.head[1:]), box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for row in table.rows:
        shown.add_row(*map(Text, row))  # without markup, which may be in what users named
    terminal = console.Console()
    known = terminal.is_terminal or "COLUMNS" in os.environ
    terminal.width = max(terminal.width, LEAST_WIDTH) if known else IN_A_FILE
    terminal.print(shown, crop=False)
    for line in table.left_out:
        print(line)


def _finite(value: Any) -> Any:
    """Data for JSON, which lacks numbers that are not finite: they are null."""
    if isinstance(value, Mapping):
        return {str(key): _finite(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(part) for part in value]
    return None if isinstance(value, float) and not isfinite(value) else value


def finish(fault: str | None, stopped: bool = False) -> None:
    """End a command whose report is printed. Raises KeyboardInterrupt if the user stopped it, PendpinError for a fault."""
    if stopped:
        raise KeyboardInterrupt
    if fault:
        raise PendpinError(fault)


def print_files(files: list[Path], as_json: bool = False) -> None:
    """The files written, a line each; none beside JSON."""
    for file in () if as_json else files:
        print(f"wrote {file}")


# --- what a command does while it works -----------------------------------------------------------------------------
# A limit of a command that has no run of its own to stop does what Ctrl-C does.

DOING = {  # by the functions in which a computation may be long and says nothing
    "at_rest": "looking for the rest near the start",
    "_corrected": "looking for further rests",
    "periodic_orbit": "looking for the periodic motion",
    "linearize": "differentiating the motion near a rest",
    "vibrations": "solving for the modes",
    "lyapunov": "integrating the changes of the motion",
}


@contextmanager
def working(what: str, limit: float | None, hidden: bool) -> Iterator[Callable[[str], None]]:
    """A spinner, and an end at the limit. Yields a function to call with what is being done."""
    with limited(limit) as work, waiting(what, hidden, work) as progress:
        yield progress


@contextmanager
def limited(limit: float | None) -> Iterator[SimpleNamespace]:
    """End what is inside after `limit` s of wall time, None for never. Raises Halted, which says what it was `doing`."""
    work, late = SimpleNamespace(doing="the work"), False
    if limit is None:
        yield work
        return

    def interrupt() -> None:
        nonlocal late
        late = True
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)  # wakes it where it waits for others

    timer = threading.Timer(min(seconds("limit", limit), threading.TIMEOUT_MAX), interrupt)
    timer.daemon = True
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN  # as where a shell runs the command in the background
    if ignored:
        libraries.heed_interrupts()
    try:
        timer.start()
        yield work
    except (KeyboardInterrupt, Interrupted) as error:
        if not late:
            raise
        names = [frame.name for frame in traceback.extract_tb(error.__traceback__)]
        work.doing = next((DOING[name] for name in reversed(names) if name in DOING), work.doing)
    finally:
        timer.cancel()
        if ignored:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
    if late:
        raise Halted(f"stopped after {limit:g} s (--limit), at: {work.doing}")


@contextmanager
def waiting(what: str, hidden: bool, work: SimpleNamespace) -> Iterator[Callable[[str], None]]:
    """A spinner on stderr, only on a terminal. Yields a function to call with what is being done."""
    from rich.console import Console

    console = Console(stderr=True)
    status = None if hidden or not console.is_terminal else console.status(what)

    def name(doing: str) -> None:
        work.doing = doing
        if status:
            status.update(doing)

    name(what)
    with status or nullcontext():
        yield name


@contextmanager
def progress_bar(what: str, end: float, hidden: bool) -> Iterator[Callable[[float], None]]:
    """A progress bar on stderr, only on a terminal."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=hidden or not console.is_terminal) as progress:
        task = progress.add_task(what, total=end)
        yield lambda t: progress.update(task, completed=t)


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
        drop_output(2)


def drop_output(stream: int = 1) -> None:
    """Let the null device take what is left in a stream, or Python would complain at its end."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, stream)
    os.close(null)
