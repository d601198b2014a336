"""The motion of a scene, by a method and its setting or to a target accuracy."""

import time
from pathlib import Path
from typing import Any

from pendpin.engines import ProgressCallback
from pendpin.errors import Halted, InputError, Interrupted
from pendpin.ground.arguments import numbers
from pendpin.ground.arrays import ArrayLike
from pendpin.runs.accuracy.target import run_to_accuracy
from pendpin.runs.checkpoint import Checkpoint
from pendpin.runs.limits import Deadline
from pendpin.runs.run import prepare, run_prepared
from pendpin.scene import Scene, chosen_scene
from pendpin.trajectory import RunRecord


def run_to_setting(
    scene: Scene,
    energy_balance: bool = False,
    progress: ProgressCallback = lambda t: None,
    deadline: Deadline | None = None,
    checkpoint: Checkpoint | None = None,
    anyway: bool = False,
) -> RunRecord:
    """The motion at all of scene.times, to the scene's tolerance, step or accuracy."""
    deadline = deadline or Deadline(None)
    if scene.solver.accuracy is None:
        return run_prepared(prepare(scene, energy_balance, deadline), progress, deadline, checkpoint, anyway=anyway)
    if anyway:
        raise InputError("anyway: a run with a wrong energy cannot meet an accuracy; give a tolerance or a step")
    if checkpoint:
        reason = "an accuracy needs several runs, which a checkpoint cannot hold; give a tolerance or a step"
        raise InputError(f"checkpoint: {reason}")
    return run_to_accuracy(scene, energy_balance, progress, deadline)


def varied(
    scene: Scene | str | Path,
    duration: float | None,
    samples: int | None,
    times: ArrayLike | None,
    solver: dict[str, Any],
) -> Scene:
    """A scene, or that of a file, with other settings and times (n,) in s. Raises InputError where they do not fit."""
    chosen, rising = chosen_scene(scene), None
    if times is not None:
        array = numbers("times", times, finite=True)
        if array.ndim != 1 or not len(array):
            raise InputError(f"times: shape {array.shape}, where (n,) numbers are wanted, with at least one")
        rising = tuple(array.tolist())
        duration = max(rising[-1] - chosen.start.time, 0.0) if duration is None else duration
    fields: dict[str, Any] = {} if duration is None else {"duration": duration}
    settings = solver | {"samples": samples, "times": rising}
    if any(value is not None for value in settings.values()):
        fields["solver"] = chosen.solver.with_settings(**settings)
    return chosen.replace(**fields) if fields else chosen


# --- limits in processor time: other processes make no difference ----------------------------------------------------


def halting(seconds: float) -> ProgressCallback:
    """A progress callback that raises Halted after so many s of processor time; the first call starts them."""
    end = float("inf")

    def look(t: float) -> None:
        nonlocal end
        end = min(end, (now := time.process_time()) + seconds)
        if now > end:
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
