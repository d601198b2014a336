"""Some samples of a run, and runs one after the other as one."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pendpin.trajectory.trajectory import Trajectory


def samples_of(run: Trajectory, rows: Any) -> Trajectory:
    """The samples of a run at some places, an index of NumPy that leaves an array."""
    return run.with_arrays({name: array[rows] for name, array in run.arrays.items()})


def joined(runs: Sequence[Trajectory]) -> Trajectory:
    """Runs one after the other, each without what the one before has; stats and scene are those of the first."""
    whole = runs[0].with_arrays({name: np.concatenate([run.arrays[name] for run in runs]) for name in runs[0].arrays})
    events = tuple(event for run in runs for event in run.events)
    return replace(whole, held=runs[-1].held, events=events)  # held: from the first instant on
