"""A path over time, read from a CSV file of positions and splined."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pendpin.arrays import Array
from pendpin.errors import InputError, shown
from pendpin.files import read_whole
from pendpin.records import LARGEST

COLUMNS = ("t", "x", "y", "z")
MAX_BYTES = 5_000_000  # more takes seconds
DEGREE = 5  # of the spline: accelerations with two continuous derivatives
LONGEST_GAP = 50  # median intervals; what a spline does in a longer one has nothing to do with the motion


@dataclass(frozen=True, eq=False)
class Track:
    """Positions (3,) in m over time in s, and their derivatives.

    Each function takes one time or many, and is NaN outside.
    """

    start: float
    end: float
    position: Callable[[Array], Array]
    velocity: Callable[[Array], Array]
    acceleration: Callable[[Array], Array]


def read_track(path: Path) -> Track:
    """The path in a CSV file: columns t, x, y, z in s and m, under a line with these names or none.

    The spline through the positions is of degree 5, with fewer than six positions the polynomial through all of them.
    Blank lines and lines that start with # are skipped. Raises InputError with the line where the file is no such.
    """
    text = read_whole(path, MAX_BYTES, "a CSV of positions")
    try:
        rows = np.array(list(_rows(text.decode("utf-8-sig"))))
    except UnicodeDecodeError as error:
        raise InputError(f"not a CSV file: byte {error.start} is not UTF-8 text") from None
    if len(rows) < 2:
        raise InputError(f"{len(rows)} positions, where at least 2 are wanted")
    _refuse_gaps(rows[:, 0])
    return _splined(rows[:, 0], rows[:, 1:])


def _rows(text: str) -> Iterator[tuple[float, ...]]:
    before, first = -math.inf, True
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        cells = tuple(cell.strip() for cell in line.split(","))
        if first and cells == COLUMNS:
            first = False
            continue
        first = False
        row = _row(number, cells)
        if not row[0] > before:
            raise InputError(f"line {number}: t = {row[0]:.15g} does not come after {before:.15g}")
        before = row[0]
        yield row


def _row(number: int, cells: tuple[str, ...]) -> tuple[float, ...]:
    if len(cells) != len(COLUMNS):
        raise InputError(f"line {number}: {len(cells)} values, where 4 are wanted: t, x, y, z")
    return tuple(_value(number, name, cell) for name, cell in zip(COLUMNS, cells, strict=True))


def _value(number: int, name: str, cell: str) -> float:
    if not cell:
        raise InputError(f"line {number}: {name} is missing")
    try:
        value = math.nan if "_" in cell else float(cell)
    except ValueError:
        raise InputError(f"line {number}: {name}: {shown(cell)} is not a number") from None
    if not math.isfinite(value):
        raise InputError(f"line {number}: {name}: {shown(cell)} is not a finite number")
    if abs(value) > LARGEST:
        raise InputError(f"line {number}: {name}: {shown(cell)} is beyond {LARGEST:g}")
    return value


def _refuse_gaps(t: Array) -> None:
    steps = np.diff(t)
    longest = int(np.argmax(steps))
    if steps[longest] > LONGEST_GAP * np.median(steps):
        raise InputError(
            f"nothing between t = {t[longest]:.9g} and {t[longest + 1]:.9g}, where a row comes every "
            f"{np.median(steps):.3g} s: a spline cannot fill that gap"
        )


def _splined(t: Array, positions: Array) -> Track:
    from scipy.interpolate import PPoly, make_interp_spline

    with np.errstate(all="ignore"):
        try:
            columns = [PPoly.from_spline(make_interp_spline(t, x, k=min(DEGREE, len(t) - 1))) for x in positions.T]
        except ValueError as error:
            raise InputError(f"no spline goes through its positions: {error}") from None
    spline = PPoly(np.stack([column.c for column in columns], -1), columns[0].x, extrapolate=False)
    velocity, acceleration = spline.derivative(1), spline.derivative(2)
    if not (np.isfinite(spline.c).all() and np.isfinite(acceleration.c).all()):
        raise InputError("its positions are too large, or too close in time, for accelerations")
    return Track(float(t[0]), float(t[-1]), spline, velocity, acceleration)
