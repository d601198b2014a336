"""A limit on commands that have no run of their own to stop: the clock does what Ctrl-C does."""

import _thread
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Timer
from typing import Annotated

import typer

from pendpin.errors import Halted, Interrupted
from pendpin.ground.arguments import seconds

Limit = Annotated[float | None, typer.Option(min=0, help="Stop after this time in s, and say what it was doing.")]
DOING = {  # by the functions in which a computation may be long
    "at_rest": "looking for the rest near the start",
    "_candidates": "looking for further rests",
    "periodic_orbit": "looking for the periodic motion",
    "linearize": "differentiating the motion near a rest",
    "vibrations": "solving for the modes",
    "lyapunov": "integrating the changes of the motion",
}


@contextmanager
def limited(limit: float | None) -> Iterator[None]:
    """End what is inside after `limit` s of wall time, None for never. Raises Halted that says what it was doing."""
    if limit is None:
        yield
        return
    late = False

    def interrupt() -> None:
        nonlocal late
        late = True
        _thread.interrupt_main()

    timer = Timer(seconds("limit", limit), interrupt)
    timer.daemon = True
    timer.start()
    try:
        yield
    except (KeyboardInterrupt, Interrupted) as error:
        if not late:
            raise
        names = [frame.name for frame in traceback.extract_tb(error.__traceback__)]
        doing = next((DOING[name] for name in reversed(names) if name in DOING), "at work")
        raise Halted(f"it takes over {limit:g} s: it was {doing} (--limit)") from None
    finally:
        timer.cancel()
