"""A path over time, read from a CSV file of positions and splined."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.effects.pace import STEADY, Pace
from pendpin.errors import InputError, amount, shown
from pendpin.ground.arrays import Array
from pendpin.ground.files import number_in, read_whole, text_of
from pendpin.ground.records import LARGEST

MAX_BYTES = 5_000_000  # more takes seconds
DEGREE = 5  # of the spline: accelerations with two continuous derivatives
ROUNDING = 2e-13  # of positions: what it makes of their differences, with a margin
ROWS = 4  # in a step where the track moves: it sees what any of them does, and the shortest pulse has as many
ULPS = 64  # of times: what they may be off by when written with 15 digits, or as a start plus a duration
DIGITS = 60  # of times, before they are counted from the first row
LONGEST_GAP = 50  # median intervals; what a spline does in a longer one has nothing to do with the motion


@dataclass(frozen=True, eq=False)
class Track:
    """Positions (3,) in m over time in s, and their derivatives.

    At one time or many, NaN outside. The spline counts its time from the first row, whose own
    time is kept with all its digits: a track of the year 2026 in seconds since 1970 is as good as one from 0.
    """

    first: Decimal  # s, of the first row
    length: float  # s
    spline: Any  # scipy's PPoly: positions (n, 3) at times (n,) since the first row

    @property
    def ends(self) -> tuple[float, float]:
        """The times of the first and the last row in s."""
        return float(self.first), float(self.first + Decimal(self.length))

    def along(self, axis: Array) -> "Track":
        """A course of one number, in m or another unit, along an axis (3,)."""
        from scipy.interpolate import PPoly

        return replace(self, spline=PPoly(self.spline.c * axis, self.spline.x))

    def since(self, start: float) -> "Track":
        """The same track with its time counted from `start` in s."""
        with localcontext(prec=DIGITS):
            return replace(self, first=self.first - Decimal(start))

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        """How fast the velocity changes from `begin` to `end`, in s, but for `negligible` of its largest departure."""
        # A rod's rates follow the velocity of its support: what is negligible in this is so in them, however rough the
        # acceleration. Between two rows the velocity is a polynomial; at a row its fourth derivative jumps. A step h over a
        # jump J is off by up to J h^4 / 24. Where this matters even for steps from row to row, the integration restarts at
        # the row; elsewhere steps are short enough, and wherever the track moves they are at most `ROWS` rows long.
        begins = self._own(np.array([begin, end]))
        knots = np.unique(np.clip(self.spline.x, *begins))
        gaps, middles = np.diff(knots), (knots[:-1] + knots[1:]) / 2
        if not len(gaps):
            return STEADY
        velocity = self.spline(knots, 1)
        rounding = ROUNDING * np.abs(self.spline(knots)).max() / gaps
        floor = negligible * np.abs(velocity - velocity.mean(0)).max() + rounding  # of each gap
        accelerations = np.abs(self.spline(np.stack([knots[:-1], middles, knots[1:]]), 2)).max((0, 2))
        moves = accelerations * gaps > floor
        jumps = np.abs(np.diff(self.spline(middles, DEGREE), axis=0)).max(1)  # at the knots inside
        with np.errstate(divide="ignore"):
            negligible_jumps = math.factorial(DEGREE - 1) * np.maximum(floor[:-1], floor[1:]) / jumps
        crossing = negligible_jumps ** (1 / (DEGREE - 1))  # s, the longest step over each knot
        steps = np.minimum(ROWS * gaps, np.minimum(np.append(crossing, np.inf), np.append(np.inf, crossing)))
        corner = (crossing < np.minimum(gaps[:-1], gaps[1:])) | (moves[:-1] != moves[1:])
        first = np.flatnonzero(np.append(True, corner))
        shortest = np.minimum.reduceat(np.where(moves, np.maximum(steps, gaps), np.inf), first)
        return Pace(knots[1:-1][corner] - begins[0] + begin, shortest)

    def at(self, t: Array, order: int = 0) -> Array:
        """Where it is at times (...) in s, (..., 3) in m, or a derivative of that, m/s^order."""
        return self.spline(self._own(t), order)

    def _own(self, t: Array) -> Array:
        """Times (n,) in s since the first row; those outside by no more than rounding are put on the first or last row."""
        start, rest, rounding = self._origin
        local = np.subtract(t, start) - rest
        inside = np.minimum(np.maximum(local, 0.0), self.length)
        return np.where(np.abs(local - inside) <= rounding, inside, np.nan)

    @cached_property
    def _origin(self) -> tuple[float, float, float]:
        """The time of the first row, what that double leaves out, and what rounding the times themselves may have, in s."""
        start, end = self.ends
        with localcontext(prec=DIGITS):
            rest = float(self.first - Decimal(start))
        return start, rest, ULPS * float(np.spacing(max(abs(start), abs(end))))

    def looked_up(self, numbers: Any) -> "LookedUp":
        """The same path, its pieces looked up in a table of `numbers` (pendpin.dynamics.parameters)."""
        begins, coefficients = self.spline.x[:-1], self.spline.c.transpose(1, 0, 2)
        pieces = np.concatenate([begins[:, None], coefficients.reshape(len(begins), -1)], 1)
        start, rest, _ = self._origin
        return LookedUp(numbers.table(begins, pieces), numbers(start), numbers(rest))


@dataclass(frozen=True, eq=False)
class LookedUp:
    """A track whose time and numbers may be symbols."""

    row: Callable[[Any], Array]  # time since the first row -> when its piece begins, and coefficients, highest first
    start: Any  # s, of the first row
    rest: Any  # s, what that number leaves out

    def at(self, t: Any, order: int = 0) -> Array:
        """A derivative (3,) of the position at time t in s, m/s^order."""
        local = t - self.start - self.rest
        begin, *coefficients = self.row(local)
        powers, s = np.array(coefficients).reshape(-1, 3), local - begin
        degree, out = len(powers) - 1, np.zeros(3)
        for i, coefficient in enumerate(powers[: degree + 1 - order]):
            out = out * s + coefficient * float(math.perm(degree - i, order))
        return out


def read_track(path: Path, columns: tuple[str, ...]) -> Track:
    """The course in a CSV file: columns such as t, x, y, z in s and m, under a line with these names or none.

    The spline through the positions is of degree 5, with fewer than six positions the polynomial through all of them.
    Blank lines and lines that start with # are skipped. Raises InputError with the line where the file is not a track.
    """
    from scipy.interpolate import PPoly, make_interp_spline

    rows = list(_rows(text_of(read_whole(path, MAX_BYTES, "a CSV over time"), "CSV"), columns))
    if len(rows) < 2:
        raise InputError(f"{amount(len(rows), 'row')}, where at least 2 are wanted")
    first = rows[0][0]
    with localcontext(prec=DIGITS):
        t = np.array([float(time - first) for time, *_ in rows])  # s since the first row
    steps = np.diff(t)
    longest, usual = int(np.argmax(steps)), np.median(steps)
    if steps[longest] > LONGEST_GAP * usual:
        begin, end = float(first) + t[longest], float(first) + t[longest + 1]
        gap = f"nothing between t = {begin:.9g} and {end:.9g}, where a row comes every {usual:.3g} s"
        raise InputError(f"{gap}; a spline cannot fill that gap")
    with np.errstate(all="ignore"):
        try:
            positions = np.array([position for _, *position in rows])
            splines = [PPoly.from_spline(make_interp_spline(t, x, k=min(DEGREE, len(t) - 1))) for x in positions.T]
        except ValueError as error:
            raise InputError(f"no spline goes through its positions: {error}") from None
    spline = PPoly(np.stack([column.c for column in splines], -1), splines[0].x)
    if not (np.isfinite(spline.c).all() and np.isfinite(spline.derivative(2).c).all()):
        raise InputError("its positions are too large, or too close in time, for accelerations")
    return Track(first, float(t[-1]), spline)


def _rows(text: str, columns: tuple[str, ...]) -> Iterator[tuple[Any, ...]]:
    """The time of each row, with all its digits, and its other numbers."""
    before, heading = None, True
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        cells = tuple(cell.strip() for cell in line.split(","))
        first, heading = heading, False
        if first and cells == columns:
            continue
        if len(cells) != len(columns):
            many = f"{amount(len(cells), 'value')} instead of {len(columns)} between commas"
            raise InputError(f"line {number}: {many}: {', '.join(columns)}")
        if first and not any(letter.isdigit() for letter in line):
            are, wanted = ", ".join(cells), ", ".join(columns)
            raise InputError(f"line {number}: the columns are {are}, where {wanted} are wanted")
        _, *position = (_value(f"line {number}: {name}", cell) for name, cell in zip(columns, cells, strict=True))
        time = Decimal(cells[0])
        if before is not None and not float(time - before) > 0:
            raise InputError(f"line {number}: t = {time:.15g} does not come after {before:.15g}")
        before = time
        yield time, *position


def _value(where: str, cell: str) -> float:
    """The number in a cell. Raises InputError for one that is missing, not finite or too large."""
    if not cell:
        raise InputError(f"{where} is missing")
    value = math.nan if "_" in cell else number_in(where, cell)
    if not abs(value) <= LARGEST:
        why = f"beyond {LARGEST:g}" if math.isfinite(value) else "not a finite number"
        raise InputError(f"{where}: {shown(cell)} is {why}")
    return value
