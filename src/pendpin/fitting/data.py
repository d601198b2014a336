"""Measured swings: read from a CSV as the scene's [data] table says, in pieces, each with a start of its own."""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pendpin.errors import InputError, amount, choices, did_you_mean, inside, shown
from pendpin.ground.arrays import Array
from pendpin.ground.files import csv_table, number_in, read_whole
from pendpin.model import kinematics
from pendpin.model.build import Model
from pendpin.scene import Data
from pendpin.trajectory.columns import AXES

MOST_BYTES = 200_000_000
SENSITIVE = 1e-9  # m/rad: a joint that moves a tip by less does not
FEWEST = 8  # samples of a segment
MOST_SAMPLES = 20_000  # of a segment that says no more with more of them
ONE_PERCENT = 0.01  # of the spread of a column: samples that differ by less are at rest
RESTS = 1e-6  # of the largest spread of a column: one that moves less is rounding, as phi is of a swing in a plane
_JUMP = 0.9 * 2 * math.pi  # rad from one sample to the next: the angle was wrapped


class Swing(NamedTuple):
    """One uninterrupted motion."""

    name: str
    t: Array  # (m,) s, rising
    y: Array  # (m, columns) rad or m; NaN where a sensor gave nothing
    rows: Array  # (m,) the line of each sample in its file, or its number
    source: str  # what these count, as "lab.csv: line"
    missing: int  # cells without a number

    def __repr__(self) -> str:
        return f"Swing {shown(self.name)}: {amount(len(self.t), 'sample')}"

    def part(self, chosen: Any) -> "Swing":
        """The swing with the samples at some places."""
        return self._replace(t=self.t[chosen], y=self.y[chosen], rows=self.rows[chosen])


class Batch(NamedTuple):
    """P pieces of swings, padded to the longest: M times."""

    swing: Array  # (P,) which swing a piece is of
    t: Array  # (M, P) s; the last time again where a piece is over
    y: Array  # (M, columns, P); NaN where there is nothing
    longest: float  # s: swings are cut into pieces no longer than this


def read_swings(data: Any, table: Data) -> tuple[Swing, ...]:
    """The swings of a CSV file, several, or a mapping of columns; read ones stay. InputError with file, line and column."""
    if isinstance(data, str | Path):
        with inside(str(data)):
            names, rows = csv_table(read_whole(Path(data), MOST_BYTES, "measured data"))
            places = {name: names.index(name) for name in _pick_columns(names, table)}
            cells = dict[str, Array]()
            for name, i in places.items():
                column = list[Any]()
                for line, row in rows:
                    if name == table.segment:
                        column.append(row[i].strip())
                    elif row[i].strip() or name == table.time:
                        column.append(number_in(f"line {line}, column {name}", row[i]))
                    else:
                        column.append(math.nan)  # where a sensor gave nothing
                cells[name] = np.array(column)
            return _swings(cells, table, np.array([line for line, _ in rows]), f"{data}: line")
    if isinstance(data, Swing):
        return (data,)
    if isinstance(data, Sequence):
        if not data:
            raise InputError("data: there are no files of swings: give the path of one at least")
        swings = tuple(swing for one in data for swing in read_swings(one, table))
        _refuse_twice(swings)
        return swings
    if not hasattr(data, "keys"):
        raise InputError(f"data: {shown(data)} is not the path of a CSV file, nor a table of columns")
    with inside("data"):
        columns = {name: np.ma.asarray(data[name]) for name in _pick_columns(list(data.keys()), table)}
        count = columns[table.time].size
        for name, values in columns.items():
            if values.ndim != 1:
                raise InputError(f"{name} is not a column of numbers: it has {values.ndim} dimensions")
            if values.size != count:
                raise InputError(f"{name} has {values.size} values, {table.time} has {count}")
        return _swings(columns, table, np.arange(1, count + 1), "sample")


def spread_of(swings: Sequence[Swing]) -> Array:
    """The standard deviation of each column (columns,), rad or m; of one that rests, RESTS of the largest."""
    deviation = np.nanstd(np.concatenate([swing.y for swing in swings]), 0)
    return np.maximum(deviation, RESTS * deviation.max(initial=0.0))


def thin_out(swings: Sequence[Swing], spacing: float) -> tuple[Swing, ...]:
    """Swings of more than `MOST_SAMPLES` with every so many of their samples, these being up to `spacing` in s apart."""
    thinned = []
    for swing in swings:
        thin = min(math.ceil(len(swing.t) / MOST_SAMPLES), int(spacing / float(np.median(np.diff(swing.t)))))
        thinned.append(swing.part(slice(None, None, max(1, thin))))
    return tuple(thinned)


def cut_pieces(swing: Swing, longest: float) -> tuple[Swing, ...]:
    """A swing cut into pieces of equal lengths, none longer than `longest` in s."""
    count = max(1, math.ceil((swing.t[-1] - swing.t[0]) / longest - 1e-9))
    count = min(count, max(1, len(swing.t) // FEWEST))
    edges = np.round(np.linspace(0, len(swing.t), count + 1)).astype(int)
    return tuple(swing.part(slice(a, b)) for a, b in pairwise(edges))


def batch(swings: Sequence[Swing], longest: float) -> Batch:
    """The swings in pieces of at most `longest` s, side by side."""
    cut = [(k, piece) for k, s in enumerate(swings) for piece in cut_pieces(s, longest)]
    most = max(len(piece.t) for _, piece in cut)
    t, y = np.empty((most, len(cut))), np.full((most, swings[0].y.shape[1], len(cut)), np.nan)
    for place, (_, piece) in enumerate(cut):
        count = len(piece.t)
        t[:, place] = np.pad(piece.t, (0, most - count), mode="edge")
        y[:count, :, place] = piece.y
    return Batch(np.array([k for k, _ in cut]), t, y, longest)


def _pick_columns(names: list[str], table: Data) -> list[str]:
    """The columns that a [data] table wants, of those there are. Raises InputError."""
    if not names:
        raise InputError("there are no columns")
    wanted = [table.time, *([table.segment] if table.segment else []), *table.columns]
    for name in wanted:
        if name not in names:
            free = [name for name in names if name not in wanted] or names
            column = f"columns = {{ {shown(free[-1])} = [...] }}"
            written = f"time = {shown(names[0])}" if name == table.time else column
            hint = did_you_mean(name, names) or f"; [data] says which are read, as in {written}"
            raise InputError(f"there is no column {shown(name)} among: {choices(names, 20)}{hint}")
    return wanted


def _swings(columns: Mapping[str, Array], table: Data, numbers: Array, source: str) -> tuple[Swing, ...]:
    """The swings of columns (N,), angles turned to rad; tips stay in m. `numbers` (N,) count the samples of `source`."""
    counted = source.rpartition(": ")[2]
    try:
        t, *y = (np.ma.asarray(columns[name], float).filled(np.nan) for name in (table.time, *table.columns))
        y = np.array(y).T
    except (TypeError, ValueError):
        raise InputError("a column holds something other than numbers, or columns differ in length") from None
    if not np.isfinite(t).all():
        raise InputError(f"{counted} {numbers[np.argmin(np.isfinite(t))]}, column {table.time}: no time")
    if np.isinf(y).any():
        row, column = np.argwhere(np.isinf(y))[0]
        raise InputError(f"{counted} {numbers[row]}, column {list(table.columns)[column]}: an infinite number")
    angles = np.array([not isinstance(measured, str) for measured in table.columns.values()])
    if table.unit == "degrees":
        y = np.where(angles, np.radians(y), y)
    labels = np.asarray(columns[table.segment]).astype(str) if table.segment else np.full(len(t), "1")
    swings = []
    for name in dict.fromkeys(labels.tolist()):
        rows = np.flatnonzero((labels == name) & ~np.isnan(y).all(1))  # where a sensor gave something
        missing = int(np.isnan(y[labels == name]).sum())
        swings.append(Swing(name, t[rows], y[rows], numbers[rows], source, missing))
        _refuse_odd(swings[-1], table, angles, counted)
    if not swings:
        raise InputError("no samples")
    _refuse_twice(swings)
    return tuple(swings)


def _refuse_twice(swings: Sequence[Swing]) -> None:
    """Refuse swings that share samples of a motion: these would count twice in the errors."""
    rows = np.concatenate([np.column_stack([swing.y, swing.t]) for swing in swings])  # (N, columns + 1)
    order = np.lexsort(rows.T)
    same = np.flatnonzero((np.diff(rows[order], axis=0) == 0).all(1))
    if len(same) < FEWEST or not (rows[order[same]].std(0) > ONE_PERCENT * np.nanstd(rows, axis=0))[:-1].any():
        return  # few by chance, or many at rest
    names = np.repeat([swing.name for swing in swings], [len(swing.t) for swing in swings])
    one, other = names[order[same[0] : same[0] + 2]]
    raise InputError(f"segments {one} and {other} share {len(same)} samples; leave them out of one")


def _refuse_odd(swing: Swing, table: Data, angles: Array, counted: str) -> None:
    """Refuse a swing too short, with times that fall, or with wrapped angles; `angles` (columns,) are no tips."""
    where = f"segment {swing.name}"
    if len(swing.t) < FEWEST:
        raise InputError(f"{where} has {amount(len(swing.t), 'sample')}; a segment needs {FEWEST} at least")
    if (late := np.diff(swing.t) <= 0).any():
        i = int(np.argmax(late))
        other = "" if table.segment else "; where another swing begins there, name a column of segments in [data]"
        order = f"{swing.t[i + 1]:.10g} s does not come after {swing.t[i]:.10g} s"
        raise InputError(f"{counted} {swing.rows[i + 1]}, column {table.time}: {order}{other}")
    for k, name in enumerate(table.columns):
        seen = ~np.isnan(swing.y[:, k])
        jumps = np.abs(np.diff(swing.y[seen, k])) > _JUMP
        if angles[k] and jumps.any():
            at = int(np.flatnonzero(seen)[1:][int(np.argmax(jumps))])
            jump = f"it jumps by a turn before {swing.t[at]:g} s; unwrap the angle, or check data.unit"
            raise InputError(f"{counted} {swing.rows[at]}, column {name}: {jump}")


# --- what the columns measure ---------------------------------------------------------------------------------------


class Sensors(NamedTuple):
    """Columns as sums of joint angles (columns, nv) and of tip coordinates (columns, 3 bodies)."""

    angles: Array
    tips: Array
    joints: list[int]  # those that columns measure, in model order: of tips, those that move one from the zero position


def sensors_of(table: Data, model: Model) -> Sensors:
    """What the columns of a scene's [data] table measure. Raises InputError for joints and links the model lacks."""
    angles = np.zeros((len(table.columns), len(model.joints)))
    tips = np.zeros((len(table.columns), 3 * len(model.bodies)))
    for row, (name, measured) in enumerate(table.columns.items()):
        where = f"data.columns.{name}"
        if isinstance(measured, str):
            text, dot, axis = measured.rpartition(".")
            if not dot or axis not in AXES:
                right = f"a link and {choices(AXES)}, such as rod_1.y, or a joint in brackets: [{shown(measured)}]"
                raise InputError(f"{where}: {shown(measured)} is not a coordinate of a tip; write {right}")
            tips[row, 3 * model.body(text, where) + AXES.index(axis)] = 1.0
        elif not measured:
            raise InputError(f"{where}: it names no joint")
        elif len(set(measured)) < len(measured):
            raise InputError(f"{where}: it names a joint twice")
        else:
            for joint in measured:
                angles[row, model.index(joint, where)] += 1.0
    step = 1e-6  # of central differences of the tips (3 bodies,) by the joints' positions, at zero
    plus, minus = (tips_at(model, side * step * np.eye(len(model.joints))) for side in (1.0, -1.0))
    measured = angles.any(0) | (np.abs(tips @ ((plus - minus).T / (2 * step))) > SENSITIVE).any(0)
    return Sensors(angles, tips, np.flatnonzero(measured).tolist())


def tips_at(model: Model, q: Array) -> Array:
    """The tips (M, 3 bodies) in m of a model at q (M, nv)."""
    return kinematics.tips(model, kinematics.poses(model, q)).reshape(len(q), -1)
