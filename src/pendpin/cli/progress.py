"""What the commands show on stderr while they work."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def waiting(what: str, hidden: bool) -> Iterator[Callable[[str], None]]:
    """A spinner on stderr, only on a terminal; the function that it returns names what is being done."""
    from rich.console import Console

    console = Console(stderr=True)
    if hidden or not console.is_terminal:
        yield lambda what: None
        return
    with console.status(what) as status:
        yield status.update


@contextmanager
def progress_bar(what: str, end: float, hidden: bool) -> Iterator[Callable[[float], None]]:
    """A progress bar on stderr, only on a terminal."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=hidden or not console.is_terminal) as progress:
        task = progress.add_task(what, total=end)
        yield lambda t: progress.update(task, completed=t)
