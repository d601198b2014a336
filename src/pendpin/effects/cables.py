"""What makes a chain of rods a cable: bending stiffness between neighbours, and springs that hold points of it."""

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, Field

from pendpin.effects.base import Bodies, BodyEffect, JointEffect, Motion
from pendpin.effects.pace import STEADY, Pace
from pendpin.ground.arrays import Array, cross
from pendpin.ground.records import NotNegative, Number, Vector

_FOLDED = 2.0**-60  # added to cos²(alpha / 2): a rod folded back exactly has a finite moment, and others that of before
_HALVINGS = 3  # of the angle: the series then sees at most sin²(180°/16), and no kink below 180°
_TERMS = np.array([1.0])
for _k in range(1, 13):  # of asin(x)/x in powers of x²: the next one is below 1e-20 there
    _TERMS = np.append(_TERMS, _TERMS[-1] * (2 * _k - 1) ** 2 / (2 * _k * (2 * _k + 1)))


def _refuse_no_direction(vector: Vector | None) -> Vector | None:
    if vector is not None and not any(vector):
        raise ValueError("a clamp of length 0 has no direction")
    return vector


class Bending(JointEffect):
    """Bending stiffness between each rod and the rod that it hangs on, as of a beam that is cut into rigid pieces.

    The moment M = EI alpha / l acts between two rods about the normal of both axes, with the angle alpha between them and
    the mean l of their lengths. Its potential is EI alpha² / (2 l), regular when the rods are straight. With `clamp`, a
    direction in W, rods that hang on the world are held towards it with half their own length: the beam is clamped at the
    support. A hinge bends about the axis that it has: the moment is minus the potential's derivative by its angle.

    A rod that is folded back on its neighbour, alpha = 180 degrees, feels a moment without a direction.
    n rods bend as a beam does, but for a part of 1/(2 n²).

    stiffness is EI in N m²: Young's modulus times the second moment of area, pi r⁴ / 4 of a round section.
    """

    parameters: ClassVar[tuple[str, ...]] = ("stiffness",)
    strengths: ClassVar[tuple[str, ...]] = ("stiffness",)
    kind: Literal["bending"] = Field("bending", description="which effect it is")
    stiffness: NotNegative = Field(description="EI, N m²")
    clamp: Annotated[Vector, AfterValidator(_refuse_no_direction)] | None = Field(
        None, description="direction in W to which rods on the world are clamped, of any length but 0"
    )

    def of_joints(self, lengths: Array, parents: Sequence[int] | None = None) -> Array:
        """For each angle of n rods of these lengths in m: 1/l and the direction (3,) of no moment, (2 n, 4).

        In the frame in which the rod hangs, it lies along -z at zero angles.
        """
        each = np.zeros((len(lengths), 4), np.result_type(lengths, float))
        above = np.arange(-1, len(lengths) - 1) if parents is None else np.array(parents)
        hung = above >= 0
        each[hung, 0], each[:, 3] = 2 / (lengths[hung] + lengths[above[hung]]), -1.0
        if self.clamp is not None:
            direction = np.array(self.clamp) / np.abs(self.clamp).max()  # so that no square overflows
            each[~hung, 0], each[~hung, 1:] = 2 / lengths[~hung], direction / np.linalg.norm(direction)
        return np.repeat(each, 2, axis=0)

    def torques(self, t: Any, q: Array, v: Array, xp: Any = np, each: Array | None = None) -> Array:
        """-dV/dq, (2 n,) N m, of angles q (2 n,) rad and what `of_joints` gives."""
        assert each is not None
        s, c = xp.sin(q), xp.cos(q)
        (s1, s2), (c1, c2) = (s[0::2], s[1::2]), (c[0::2], c[1::2])
        inverse, x, y, z = each[0::2].T
        w, u = _half_angle_squares(s1, c1, s2, c2, x, y, z)
        factor = self.stiffness * inverse * _asin_over_x(w, u, xp) / xp.sqrt(u + _FOLDED)  # alpha / sin(alpha)
        out = np.zeros(q.shape, np.result_type(factor, q))
        out[0::2] = factor * c2 * (z * s1 - y * c1)
        out[1::2] = factor * (x * c2 + s2 * (y * s1 + z * c1))
        return out

    def potential(self, q: Array, xp: Any = np, each: Array | None = None) -> Any:
        """EI alpha² / (2 l), summed over the joints, J; q is (..., 2 n) in rad."""
        assert each is not None
        s, c = xp.sin(q), xp.cos(q)
        inverse, *direction = each[0::2].T
        w, u = _half_angle_squares(s[..., 0::2], c[..., 0::2], s[..., 1::2], c[..., 1::2], *direction)
        return (2 * self.stiffness * inverse * w * _asin_over_x(w, u, xp) ** 2).sum(-1)

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        """Time makes no difference."""
        return STEADY


def _half_angle_squares(s1: Any, c1: Any, s2: Any, c2: Any, x: Any, y: Any, z: Any) -> tuple[Any, Any]:
    """The squares of sine and cosine of alpha / 2, from those of theta and phi and the direction (x, y, z) of no moment.

    A quarter of the squares of difference and sum of two unit vectors: both without cancellation, and never below 0.
    """
    dx, dy, dz = s2, -s1 * c2, -c1 * c2
    return (
        ((dx - x) ** 2 + (dy - y) ** 2 + (dz - z) ** 2) * 0.25,
        ((dx + x) ** 2 + (dy + y) ** 2 + (dz + z) ** 2) * 0.25,
    )


def _asin_over_x(w: Any, u: Any, xp: Any) -> Any:
    """asin(x) / x of w = x² = 1 - u, smooth at 0: by halved angles, sin²(a/2) = sin²(a) / (2 (1 + cos(a)))."""
    scale = 1.0
    for _ in range(_HALVINGS):
        twice = 2 * (1 + xp.sqrt(u))
        w, scale = w / twice, scale * 2 / xp.sqrt(twice)
        u = 1 - w
    series = _TERMS[-1]
    for term in _TERMS[-2::-1]:
        series = series * w + term
    return scale * series


class Anchor(BodyEffect):
    """A spring and a damper from a point of one rod to a point of the world W.

    F = stiffness (point - r) - damping r', with r the place of the rod's point `at` m from its joint, its tip if absent.
    The spring has no length of its own. W moves with a moving support, and so does the point.

    stiffness in N/m, damping in N s/m, point in m.
    """

    parameters: ClassVar[tuple[str, ...]] = ("point", "stiffness", "damping", "at")
    strengths: ClassVar[tuple[str, ...]] = ("stiffness", "damping")
    kind: Literal["anchor"] = Field("anchor", description="which effect it is")
    link: str = Field(description="name of the rod: rod_1, rod_2, ...")
    point: Vector = Field(description="m, in W")
    stiffness: NotNegative = Field(description="N/m")
    damping: NotNegative = Field(0.0, description="N s/m")
    at: Number | None = Field(None, description="m along the rod from its joint; its tip if absent")

    @property
    def on(self) -> tuple[str, ...]:
        """The link that is held."""
        return (self.link,)

    @property
    def axial(self) -> bool:
        """False: a force on the axis does not turn a rod about it."""
        return False

    @property
    def resistances(self) -> tuple[str, ...]:
        """The damping."""
        return ("damping",)

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        """Time makes no difference."""
        return STEADY

    def wrench(self, t: Any, bodies: Bodies, motion: Motion, xp: Any = np) -> tuple[Array, Array]:
        """The force (1, 3) N and its moment (1, 3) N m about the centre of mass, W."""
        held = place_on_rod(bodies, self.at, xp)
        away = motion.points(held) - motion.fixed(np.array(self.point))
        force = -self.stiffness * away - self.damping * motion.velocities(held)
        return force, cross(motion.levers(held - bodies.com), force)

    def potential(self, bodies: Bodies, motion: Motion, xp: Any = np) -> Any:
        """stiffness / 2 times the square of the distance, J; None with damping."""
        if self.damping:
            return None
        away = motion.points(place_on_rod(bodies, self.at, xp)) - np.array(self.point)
        return self.stiffness / 2 * (away**2).sum((-2, -1))


def place_on_rod(bodies: Bodies, at: Any, xp: Any) -> Array:
    """A point (n, 3) in the link frames, `at` m from the joint towards the tip; the tip if None."""
    return bodies.tip if at is None else bodies.tip * (at / xp.sqrt((bodies.tip**2).sum(-1, keepdims=True)))
