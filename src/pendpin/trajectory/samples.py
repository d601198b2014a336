"""Some samples of a run, and runs one after the other as one."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pendpin.trajectory.parts import Reactions
from pendpin.trajectory.reading import ARRAYS
from pendpin.trajectory.trajectory import Trajectory


def samples_of(run: Trajectory, rows: Any) -> Trajectory:
    """The samples of a run at some places, an index of NumPy that leaves an array."""
    arrays = {name: getattr(run, name)[rows] for name in ARRAYS}
    reactions = run.rod_reactions and Reactions(*(array[rows] for array in run.rod_reactions))
    return replace(run, **arrays, rod_reactions=reactions, work={kind: work[rows] for kind, work in run.work.items()})


def joined(runs: Sequence[Trajectory]) -> Trajectory:
    """Runs one after the other, each without what the one before has; stats and scene are those of the first."""
    arrays: dict[str, Any] = {name: np.concatenate([getattr(run, name) for run in runs]) for name in ARRAYS}
    if runs[0].rod_reactions is not None:
        columns = zip(*(run.reactions() for run in runs), strict=True)
        arrays["rod_reactions"] = Reactions(*(np.concatenate(parts) for parts in columns))
    work = {kind: np.concatenate([run.work[kind] for run in runs]) for kind in runs[0].work}
    held = runs[-1].held  # from the first instant on
    return replace(runs[0], **arrays, work=work, held=held, events=tuple(event for run in runs for event in run.events))
