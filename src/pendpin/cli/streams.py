"""The standard streams of the process, whatever it was started with: closed, full, or with nobody at the other end."""

import logging
import os
import sys
from io import TextIOWrapper


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
