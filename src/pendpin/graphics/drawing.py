"""What a picture of a motion is made of: solids fixed to bodies, the poses of those bodies, and the path of the tip."""

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from pendpin.ground.arrays import Array

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
