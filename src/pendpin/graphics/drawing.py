"""What a picture of a motion is made of: solids fixed to bodies, the poses of those bodies, and the path of the tip."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from pendpin.errors import InputError, moment, shown
from pendpin.ground.arguments import leaves
from pendpin.ground.arrays import Array, Indices
from pendpin.trajectory import RunRecord

TURN = 0.1  # rad: two straight pieces in a row turn by about that
Geometry = Literal["cylinder", "sphere", "box", "mesh"]

WORLD = -1  # as `Shape.body`: fixed in W


@dataclass(frozen=True, eq=False)
class Shape:
    """One solid, fixed to a body.

    size, in m: cylinder (radius, length along its z), sphere (radius,), box (x, y, z); for a mesh the three scale
    factors of the file at `path` (.obj, .stl or .dae). placement is the (4, 4) pose of the solid in the body's frame,
    color is 0xRRGGBB, body an index into `Drawing.poses`, or WORLD.
    """

    geometry: Geometry
    size: tuple[float, ...]
    placement: Array
    color: int
    body: int
    path: str = ""


class Quantity(NamedTuple):
    """One quantity against time: its name, its unit ("" of a ratio) and its values (n,)."""

    name: str
    unit: str
    values: Array


class Curve(NamedTuple):
    """One curve of a plot: the quantity, what it is called there, its colour, and what is subtracted from it."""

    name: str
    label: str
    color: str
    minus: float = 0.0


class Plot(NamedTuple):
    """Several curves together, all of them of one unit."""

    title: str
    curves: tuple[Curve, ...]


class Joint(NamedTuple):
    """A joint to be looked at closely: the body that it moves, and the one that it hangs on (WORLD: none that moves).

    axes and base, both (3, 3), are frames as columns, one in each of the two bodies' frames, which coincide where all angles
    are 0: b1, b2, b3 of a rod on a universal joint, else x, y, z. length and radius are those of the body, in m.
    """

    name: str
    body: int
    above: int
    axes: Array
    base: Array
    length: float
    radius: float
    universal: bool


@dataclass(frozen=True, eq=False)
class Drawing:
    """A motion to be shown, in the world frame W (z up).

    t (n,) in s, rising; poses (n, bodies, 4, 4) of the bodies, one or more; trail (n, 3) in m, the path of the tip, and
    its velocity (n, 3) in m/s; extent in m, the size of the whole, which sets how thick the thinnest lines are. Where
    known: forces (n, bodies, 3) in N and moments (n, bodies, 3) in N m, of the joints on the bodies, at their origins;
    quantities to be plotted, and plots of several of them; joints to be looked at; `support`, the body from which the others
    hang; notes to be shown; a label that tells this motion from `others`, which are drawn with it as ghosts; whether
    something leaves, so that the camera looks at the start alone.
    """

    title: str
    t: Array
    poses: Array
    shapes: tuple[Shape, ...]
    trail: Array
    extent: float
    velocity: Array | None = None
    forces: Array | None = None
    moments: Array | None = None
    quantities: tuple[Quantity, ...] = ()
    plots: tuple[Plot, ...] = ()
    joints: tuple[Joint, ...] = ()
    support: int | None = None
    notes: tuple[str, ...] = ()
    label: str = ""
    others: tuple["Drawing", ...] = ()
    leaves: bool = False

    def scaled(self, factor: float) -> "Drawing":
        """The drawing with all lengths times a factor."""
        lengths = np.ones((4, 4))
        lengths[:3, 3] = factor  # of a pose
        sizes = [tuple(factor * length for length in shape.size) for shape in self.shapes]
        placed = zip(self.shapes, sizes, strict=True)
        return replace(
            self,
            poses=lengths * self.poses,
            shapes=tuple(replace(shape, size=size, placement=lengths * shape.placement) for shape, size in placed),
            trail=factor * self.trail,
            velocity=None if self.velocity is None else factor * self.velocity,
            joints=tuple(j._replace(length=factor * j.length, radius=factor * j.radius) for j in self.joints),
            extent=factor * self.extent,
            others=tuple(other.scaled(factor) for other in self.others),
        )


def smooth(t: Array, points: Array, velocities: Array | None, per_second: float, most: int) -> tuple[Array, Array]:
    """Times (m,) and points (m, 3) along a path, from points (n, 3) and velocities (n, 3), if known, at times t (n,), s.

    Cubics, straight where samples are far apart, in at most `most` pieces that turn by TURN and last 1/per_second s.
    """
    slopes: Array = np.asarray(np.gradient(points, t, axis=0)) if velocities is None else velocities
    before, after, spans, steps = slopes[:-1], slopes[1:], np.diff(t)[:, None], np.diff(points, axis=0)
    turns = np.arctan2(np.linalg.norm(np.cross(before, after), axis=-1), (before * after).sum(-1))  # rad
    pieces = np.concatenate([[0.0], np.cumsum(np.maximum(turns / TURN, np.diff(t) * per_second))])
    count = int(min(np.ceil(pieces[-1]) + 1, most))
    places = np.interp(np.linspace(0.0, pieces[-1], max(2, count)), pieces, np.arange(len(t)))
    times = np.interp(places, np.arange(len(t)), t)
    straight = np.stack([np.interp(times, t, x) for x in points.T], -1)

    i = np.minimum(places.astype(int), len(t) - 2)  # the interval of each time
    span = spans[i]
    x = (times - t[i])[:, None] / span
    rise = (3 - 2 * x) * x**2 * (points[i + 1] - points[i])
    curved = points[i] + rise + span * x * (x - 1) * ((x - 1) * slopes[i] + x * slopes[i + 1])

    # the cubic stays as near to the samples as these are to one another where an interval is short
    away = [np.linalg.norm(v * spans - steps, axis=-1) for v in (before, after)]
    lengths = np.pad(np.linalg.norm(steps, axis=-1), 1, mode="edge")
    short = np.maximum(*away) / 4 <= lengths[:-2] + lengths[1:-1] + lengths[2:]
    return times, np.where(short[i, None], curved, straight)


MOST_KEYS = 2  # in which runs differ, in a label
MOST = 4  # runs: the eye tells four colours and dashes apart
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
            span = f"from {moment(run.t[0])} to {moment(run.t[-1])} s"
            raise InputError(f"compare: the run {span} has no time in common with another")
    return [run, *others]


def labels_of(runs: Sequence[RunRecord]) -> list[str]:
    """What tells runs apart: methods and settings, scenes, or both; else the numbers of the scenes that differ."""
    methods = [f"{run.stats.method}, {run.stats.setting}" for run in runs]
    titles = [run.title for run in runs]
    for labels in (methods, titles, [f"{title}, {how}" for title, how in zip(titles, methods, strict=True)]):
        if len(set(labels)) == len(labels):
            return labels
    tables = [leaves(run.scene) for run in runs]
    keys = [k for k in dict.fromkeys(k for table in tables for k in table) if len({repr(t.get(k)) for t in tables}) > 1]
    more = f", ... ({len(keys)} numbers)" if len(keys) > MOST_KEYS else ""
    numbers = [", ".join(f"{key} {table.get(key, 'absent')}" for key in keys[:MOST_KEYS]) + more for table in tables]
    return [f"run {i + 1}: {label}" for i, label in enumerate(numbers if keys else methods)]


def distance(run: RunRecord, first: RunRecord) -> tuple[Indices, Array]:
    """The samples (k,) of a run in the time of another, and how far their last tips are apart then, m, by a cubic spline."""
    from scipy.interpolate import CubicSpline

    rows = np.flatnonzero((run.t >= first.t[0]) & (run.t <= first.t[-1]))
    t, tip = run.t[rows], run.tips[rows, -1]
    at = np.searchsorted(first.t, t)
    if (first.t[np.minimum(at, len(first.t) - 1)] == t).all():
        return rows, np.linalg.norm(tip - first.tips[at, -1], axis=-1)
    once = np.concatenate([[True], np.diff(first.t) > 0])
    return rows, np.linalg.norm(tip - CubicSpline(first.t[once], first.tips[once, -1])(t), axis=-1)
