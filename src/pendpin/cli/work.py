"""What a command does while it works: it shows what it is doing, and ends at its limit.

A limit of a command that has no run of its own to stop does what Ctrl-C does.
"""

import _thread
import signal
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Annotated

import typer

from pendpin.errors import Halted, Interrupted
from pendpin.ground.arguments import seconds

Limit = Annotated[float | None, typer.Option(min=0, help="Stop after this time in s, and say what it was doing.")]
DOING = {  # by the functions in which a computation may be long and says nothing
    "at_rest": "looking for the rest near the start",
    "_candidates": "looking for further rests",
    "periodic_orbit": "looking for the periodic motion",
    "linearize": "differentiating the motion near a rest",
    "vibrations": "solving for the modes",
    "lyapunov": "integrating the changes of the motion",
}


@dataclass
class Work:
    """What a command is doing."""

    doing: str = "the work"


@contextmanager
def limited(limit: float | None) -> Iterator[Work]:
    """End what is inside after `limit` s of wall time, None for never. Raises Halted, which says what it was doing."""
    work, late = Work(), False
    if limit is None:
        yield work
        return

    def interrupt() -> None:
        nonlocal late
        late = True
        if hasattr(signal, "pthread_kill"):  # which wakes a main thread that waits for others
            signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
        else:
            _thread.interrupt_main()

    timer = threading.Timer(seconds("limit", limit), interrupt)
    timer.daemon = True
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
    if late:
        raise Halted(f"stopped after {limit:g} s (--limit), at: {work.doing}")


@contextmanager
def waiting(what: str, hidden: bool, work: Work | None = None) -> Iterator[Callable[[str], None]]:
    """A spinner on stderr, only on a terminal; the function that it returns names what is being done."""
    from rich.console import Console

    console, work = Console(stderr=True), work or Work()

    def name(doing: str) -> None:
        work.doing = doing

    name(what)
    if hidden or not console.is_terminal:
        yield name
        return
    with console.status(what) as status:

        def show(doing: str) -> None:
            name(doing)
            status.update(doing)

        yield show


@contextmanager
def progress_bar(what: str, end: float, hidden: bool) -> Iterator[Callable[[float], None]]:
    """A progress bar on stderr, only on a terminal."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=hidden or not console.is_terminal) as progress:
        task = progress.add_task(what, total=end)
        yield lambda t: progress.update(task, completed=t)
