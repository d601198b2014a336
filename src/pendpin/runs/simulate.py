"""`simulate`: the motion of a scene, by a method and its setting or to a target accuracy."""

from pathlib import Path
from typing import Any

import numpy as np

from pendpin.engines import ProgressCallback
from pendpin.errors import InputError, RunError, say_note
from pendpin.ground.arguments import flag, numbers
from pendpin.ground.arrays import ArrayLike
from pendpin.ground.files import path_of
from pendpin.model.build import build
from pendpin.model.notes import notes
from pendpin.runs.accuracy.target import run_to_accuracy
from pendpin.runs.checkpoint import EVERY, Checkpoint
from pendpin.runs.limits import Deadline
from pendpin.runs.run import run_scene
from pendpin.scene import Scene, chosen_scene
from pendpin.trajectory import Trajectory, samples_of


def simulate(
    scene: Scene | str | Path,
    *,
    duration: float | None = None,
    samples: int | None = None,
    times: ArrayLike | None = None,
    method: str | None = None,
    tolerance: float | None = None,
    step: float | None = None,
    accuracy: float | None = None,
    energy_balance: bool = False,
    progress: ProgressCallback = lambda t: None,
    limit: float | None = None,
    checkpoint: str | Path | None = None,
    every: float = EVERY,
    anyway: bool = False,
) -> Trajectory:
    """Simulate a scene and return its motion at the output times.

    Arguments that are given replace those of the scene and its solver. An input that is allowed and probably a mistake, such
    as angles of many turns, gives a warning (pendpin.errors.Note).

    Args:
        scene: a Scene, or the path of a TOML file.
        duration: s; the scene's if absent, or up to the last of `times`.
        samples: number of evenly spaced output times, both ends included.
        times: output times in place of samples, (n,) s, rising, in the scene's own time: from start.time on.
        method: a method by name, or "auto".
        tolerance: for methods without a fixed step, relative and absolute; rad and rad/s.
        step: s, for methods with a fixed step; the last one may be shorter.
        accuracy: target for the largest distance of a tip from the true motion over the chain's length. The tolerance or
            step that meets it is found, and the method if none is given; `stats` holds them and the estimated error.
        energy_balance: integrate the work of every effect too; see the trajectory's `work`.
        progress: called with the time reached, s.
        limit: s of wall time, after which the call ends; infinity sets no limit. Compiling, all runs for
            an accuracy, and the samples count.
        checkpoint: a file in which the state is saved, whole or not at all, at output times. If it exists, the run
            continues from it, with a result that is equal bit for bit to that of an uninterrupted run. Scene, settings
            and versions must be the same. The file stays when the run has ended: delete it once the result is saved.
        every: s of wall time between two saves.
        anyway: run to the end where the energy goes wrong, as by a poor method; a note in `stats` says from when on.

    Returns:
        The Trajectory.

    Raises:
        InputError: for a scene that cannot be run.
        RunError: for a run that cannot reach its end or its accuracy; `partial` is the Trajectory up to there.
    """
    deadline = Deadline(limit)
    settings = {"method": method, "tolerance": tolerance, "step": step, "accuracy": accuracy}
    energy_balance, anyway = flag("energy_balance", energy_balance), flag("anyway", anyway)
    chosen = varied(scene, duration, samples, times, settings)
    for note in notes(chosen, build(chosen.model)):
        say_note(note, stacklevel=3)
    saved = None if checkpoint is None else Checkpoint(path_of(checkpoint), every)
    try:
        return _asked_for(chosen, run_to_setting(chosen, energy_balance, progress, deadline, saved, anyway))
    except RunError as error:
        error.partial = _asked_for(chosen, error.partial)
        raise


def run_to_setting(
    scene: Scene,
    energy_balance: bool = False,
    progress: ProgressCallback = lambda t: None,
    deadline: Deadline | None = None,
    checkpoint: Checkpoint | None = None,
    anyway: bool = False,
) -> Trajectory:
    """The motion at all of scene.times, to the scene's tolerance, step or accuracy; as `simulate`, which see."""
    deadline = deadline or Deadline(None)
    if scene.solver.accuracy is None:
        return run_scene(scene, energy_balance, progress, deadline, checkpoint, anyway=anyway)
    if anyway:
        raise InputError("anyway: a run with a wrong energy cannot meet an accuracy; give a tolerance or a step")
    if checkpoint:
        raise InputError(
            "checkpoint: an accuracy needs several runs, which a checkpoint cannot hold; give a tolerance or a step"
        )
    return run_to_accuracy(scene, energy_balance, progress, deadline)


def _asked_for(scene: Scene, run: Trajectory) -> Trajectory:
    """The run without the sample at the start if that is not one of the requested times."""
    extra = scene.extra_samples
    return samples_of(run, slice(extra, None)) if extra and len(run.t) > extra else run


def varied(
    scene: Scene | str | Path,
    duration: float | None,
    samples: int | None,
    times: ArrayLike | None,
    solver: dict[str, Any],
) -> Scene:
    """A scene, or that of a file, with other settings and times (n,) in s. Raises InputError where they do not fit."""
    chosen = chosen_scene(scene)
    rising = None if times is None else _to_numbers(times)
    if rising is not None and duration is None:
        duration = max(rising[-1] - chosen.start.time, 0.0)
    fields: dict[str, Any] = {} if duration is None else {"duration": duration}
    settings = solver | {"samples": samples, "times": rising}
    if any(value is not None for value in settings.values()):
        fields["solver"] = chosen.solver.replaced(**settings)
    return chosen.replace(**fields) if fields else chosen


def _to_numbers(times: ArrayLike) -> tuple[float, ...]:
    """Output times as numbers. Raises InputError unless they are (n,) finite numbers, n > 0."""
    array = numbers("times", times)
    if array.ndim != 1 or not len(array) or not np.isfinite(array).all():
        raise InputError(f"times: shape {array.shape}, where (n,) finite numbers are wanted, with at least one")
    return tuple(array.tolist())
