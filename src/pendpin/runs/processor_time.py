"""Limits in processor time: other processes make no difference."""

import time

from pendpin.engines import ProgressCallback
from pendpin.errors import Halted, Interrupted
from pendpin.runs.simulate import run_to_setting
from pendpin.scene import Scene
from pendpin.trajectory import RunRecord


class Budget:
    """So many s of processor time, from its creation on; infinite ones are no limit."""

    def __init__(self, seconds: float) -> None:
        self._end = time.process_time() + seconds

    @property
    def left(self) -> float:
        """What is left, in s."""
        return self._end - time.process_time()


def halting(seconds: float) -> ProgressCallback:
    """A progress callback that raises Halted after so many s of processor time; the first call starts them."""
    budget: Budget | None = None

    def look(t: float) -> None:
        nonlocal budget
        budget = budget or Budget(seconds)
        if budget.left < 0:
            raise Halted(f"it takes over {seconds:.3g} s")

    return look


def run_within(seconds: float, scene: Scene) -> RunRecord:
    """The run of a scene, or the part of it that takes so many s of processor time beside compiling."""
    try:
        return run_to_setting(scene, progress=halting(seconds))
    except Interrupted:
        raise
    except Halted as error:
        return error.partial
