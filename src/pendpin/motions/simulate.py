"""`simulate`: the motion of a scene, as a Trajectory."""

from pathlib import Path

from pendpin.engines import ProgressCallback
from pendpin.errors import RunError, say_note
from pendpin.ground.arguments import flag, function
from pendpin.ground.arrays import ArrayLike
from pendpin.ground.files import path_of
from pendpin.model.build import build
from pendpin.model.notes import notes
from pendpin.motions.trajectory import Trajectory
from pendpin.runs.checkpoint import EVERY, Checkpoint
from pendpin.runs.limits import Deadline
from pendpin.runs.preparation import known_notes
from pendpin.runs.simulate import run_to_setting, varied
from pendpin.scene import Scene
from pendpin.trajectory import RunRecord, samples_of


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
    deadline, progress = Deadline(limit), function("progress", progress)
    settings = {"method": method, "tolerance": tolerance, "step": step, "accuracy": accuracy}
    energy_balance, anyway = flag("energy_balance", energy_balance), flag("anyway", anyway)
    chosen = varied(scene, duration, samples, times, settings)
    model = build(chosen.model)
    for note in known_notes.look_up((model, chosen), lambda: notes(chosen, model)):
        say_note(note, stacklevel=3)
    saved = None if checkpoint is None else Checkpoint(path_of(checkpoint), every)
    try:
        return _with_asked_samples(chosen, run_to_setting(chosen, energy_balance, progress, deadline, saved, anyway))
    except RunError as error:
        error.partial = _with_asked_samples(chosen, error.partial)
        raise


def _with_asked_samples(scene: Scene, record: RunRecord) -> Trajectory:
    """The run without the sample at the start if that is not one of the requested times."""
    extra = scene.extra_samples
    return Trajectory.of(samples_of(record, slice(extra, None)) if extra and len(record.t) > extra else record)
