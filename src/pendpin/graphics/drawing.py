"""What a picture of a motion is made of: solids fixed to bodies, the poses of those bodies, and the path of the tip."""

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from pendpin.ground.arrays import Array, Indices, Mask

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
    something leaves, so that the camera looks at the start alone. Raises ValueError where these do not fit together.
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

    def __post_init__(self) -> None:
        n, bodies = self.poses.shape[:2]
        parts = [(self.t, (n,)), (self.poses, (n, bodies, 4, 4)), (self.trail, (n, 3))]
        parts += [(self.velocity, (n, 3)), (self.forces, (n, bodies, 3)), (self.moments, (n, bodies, 3))]
        parts += [(quantity.values, (n,)) for quantity in self.quantities]
        given = [(values, shape) for values, shape in parts if values is not None]
        if n < 1 or bodies < 1 or any(values.shape != shape for values, shape in given):
            raise ValueError(
                f"shapes {[values.shape for values, _ in given]} do not fit {[shape for _, shape in given]}"
            )
        if not all(np.isfinite(values).all() for values, _ in given):
            raise ValueError("a pose, time, force or plotted value is not finite")
        if not all(WORLD <= shape.body < bodies for shape in self.shapes):
            raise ValueError(f"a shape belongs to none of the {bodies} bodies")
        if not 0 < self.extent < np.inf:
            raise ValueError(f"extent {self.extent} is not a length")

    def scaled(self, factor: float) -> "Drawing":
        """The drawing with all lengths times a factor."""
        shapes = tuple(
            replace(shape, size=tuple(factor * x for x in shape.size), placement=_with_lengths(shape.placement, factor))
            for shape in self.shapes
        )
        velocity = None if self.velocity is None else factor * self.velocity
        poses, trail = _with_lengths(self.poses, factor), factor * self.trail
        joints = tuple(j._replace(length=factor * j.length, radius=factor * j.radius) for j in self.joints)
        others = tuple(other.scaled(factor) for other in self.others)
        moved = {"poses": poses, "shapes": shapes, "trail": trail, "velocity": velocity, "joints": joints}
        return replace(self, **moved, extent=factor * self.extent, others=others)


def _with_lengths(poses: Array, factor: float) -> Array:
    """Poses (..., 4, 4) whose translations are multiplied by a factor."""
    out = poses.copy()
    out[..., :3, 3] *= factor
    return out


# --- the path of a point between samples, without corners where it is fast ------------------------------------------


def smooth_trail(drawing: Drawing, per_second: float, most: int) -> tuple[Array, Array]:
    """The trail of a drawing as `smooth` gives it; where its velocity is not known, differences of the points give it."""
    velocity = np.gradient(drawing.trail, drawing.t, axis=0) if drawing.velocity is None else drawing.velocity
    return smooth(drawing.t, drawing.trail, velocity, per_second, most)


def smooth(t: Array, points: Array, velocities: Array, per_second: float, most: int) -> tuple[Array, Array]:
    """Times (m,) and points (m, 3) along a path, from points (n, 3) and velocities (n, 3) at times t (n,).

    Between two samples it is the cubic through both points and velocities, or straight where the samples are too far
    apart for that. It is cut into pieces that turn by TURN and last 1/per_second in s at most, but no more than `most`.
    """
    pieces = np.concatenate([[0.0], np.cumsum(np.maximum(_turns(velocities) / TURN, np.diff(t) * per_second))])
    count = int(min(np.ceil(pieces[-1]) + 1, most))
    places = np.interp(np.linspace(0.0, pieces[-1], max(2, count)), pieces, np.arange(len(t)))
    times = np.interp(places, np.arange(len(t)), t)
    straight = np.stack([np.interp(times, t, x) for x in points.T], -1)
    between = np.minimum(places.astype(int), len(t) - 2)
    curved = _cubic(times, t, points, velocities, between)
    return times, np.where(_resolved(t, points, velocities)[between, None], curved, straight)


def _cubic(times: Array, t: Array, points: Array, velocities: Array, i: Indices) -> Array:
    """Cubics (m, 3) through points and velocities (n, 3) at both ends of the intervals i (m,), at times (m,) in s."""
    span = (t[i + 1] - t[i])[:, None]
    x = (times - t[i])[:, None] / span
    rise = (3 - 2 * x) * x**2 * (points[i + 1] - points[i])
    return points[i] + rise + span * x * (x - 1) * ((x - 1) * velocities[i] + x * velocities[i + 1])


def _turns(velocities: Array) -> Array:
    """The angles in rad between successive velocities (n, 3), (n-1,)."""
    before, after = velocities[:-1], velocities[1:]
    return np.arctan2(np.linalg.norm(np.cross(before, after), axis=-1), (before * after).sum(-1))


def _resolved(t: Array, points: Array, velocities: Array) -> Mask:
    """Which intervals (n-1,) are so short that the cubic stays as near to the samples as these are to one another.

    t (n,) in s, points (n, 3) in m, velocities (n, 3) in m/s.
    """
    steps, spans = np.diff(points, axis=0), np.diff(t)[:, None]
    away = [np.linalg.norm(v * spans - steps, axis=-1) for v in (velocities[:-1], velocities[1:])]
    lengths = np.pad(np.linalg.norm(steps, axis=-1), 1, mode="edge")
    return np.maximum(*away) / 4 <= lengths[:-2] + lengths[1:-1] + lengths[2:]
