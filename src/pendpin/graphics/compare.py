"""Several runs to be compared: their labels, and the distance of their tips."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from pendpin.errors import InputError, shown
from pendpin.ground.arrays import Array, Indices
from pendpin.trajectory import RunRecord

MOST_KEYS = 2  # in which runs differ, in a label
MOST = 4  # runs: the eye tells four colours and dashes apart
DASHES = ("-", (0, (4, 2)), (0, (1, 1.5)), (0, (6, 1.5, 1, 1.5)))  # in a figure: of the first run, the second, ...
Runs = RunRecord | Sequence[RunRecord] | None


def runs_of(run: RunRecord, compare: Runs) -> list[RunRecord]:
    """A run and those it is compared with. Raises InputError for too many, or runs at other times."""
    others = [compare] if isinstance(compare, RunRecord) else [] if compare is None else compare
    if not isinstance(others, Sequence):
        raise InputError(f"compare: {shown(others)} is not a run, nor a list of runs")
    if len(others) >= MOST:
        raise InputError(f"compare: {len(others) + 1} runs are too many for one picture, which holds {MOST}")
    for other in others:
        if not isinstance(other, RunRecord):
            raise InputError(f"compare: a {type(other).__name__} is not a run")
        if len(run.t) and (not len(other.t) or other.t[0] > run.t[-1] or other.t[-1] < run.t[0]):
            raise InputError(
                f"compare: the run from {run.t[0]:g} to {run.t[-1]:g} s has no time in common with another"
            )
    return [run, *others]


def labels_of(runs: Sequence[RunRecord]) -> list[str]:
    """What tells runs apart: their methods and settings, or their scenes, or their places in the list."""
    for one in (
        lambda run: f"{run.stats.method}, {run.stats.setting}",
        lambda run: run.title,
        lambda run: f"{run.title}, {run.stats.method}, {run.stats.setting}",
    ):
        labels = [one(run) for run in runs]
        if len(set(labels)) == len(labels):
            return labels
    return [f"run {i + 1}: {label}" for i, label in enumerate(_different_numbers(runs))]


def _different_numbers(runs: Sequence[RunRecord]) -> list[str]:
    """Of each run the numbers of its scene in which it differs from another, by key path; else its method and setting."""
    tables = [dict(_leaves(run.scene)) for run in runs]
    keys = [
        key
        for key in dict.fromkeys(k for table in tables for k in table)
        if len({repr(t.get(key)) for t in tables}) > 1
    ]
    if not keys:
        return [f"{run.stats.method}, {run.stats.setting}" for run in runs]
    more = f", ... ({len(keys)} numbers)" if len(keys) > MOST_KEYS else ""
    return [", ".join(f"{key} {table.get(key, 'absent')}" for key in keys[:MOST_KEYS]) + more for table in tables]


def _leaves(record: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Every value of a scene as data, by its key path."""
    if isinstance(record, dict):
        for key, value in record.items():
            yield from _leaves(value, f"{path}.{key}" if path else str(key))
    elif isinstance(record, list | tuple):
        for i, value in enumerate(record):
            yield from _leaves(value, f"{path}[{i}]")
    else:
        yield path, record


def rows_within(run: RunRecord, first: RunRecord) -> Indices:
    """The samples of a run in the time of another, indices (k,)."""
    return np.flatnonzero((run.t >= first.t[0]) & (run.t <= first.t[-1]))


def distance(run: RunRecord, first: RunRecord) -> Array:
    """How far the last tips of two runs are apart at the samples of `rows_within`, (k,) in m.

    Where the first run has no sample a cubic spline through its samples gives the tip; its error falls with the fourth
    power of the time between samples.
    """
    from scipy.interpolate import CubicSpline

    rows = rows_within(run, first)
    t, tip = run.t[rows], run.tips[rows, -1]
    at = np.searchsorted(first.t, t)
    if (first.t[np.minimum(at, len(first.t) - 1)] == t).all():
        return np.linalg.norm(tip - first.tips[at, -1], axis=-1)
    once = np.concatenate([[True], np.diff(first.t) > 0])
    return np.linalg.norm(tip - CubicSpline(first.t[once], first.tips[once, -1])(t), axis=-1)
