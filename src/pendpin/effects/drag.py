"""Air, or water: the drag of rods across the flow, wind, buoyancy."""

from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, Strict, model_validator

from pendpin.effects.base import Bodies, BodyEffect, Motion
from pendpin.effects.pace import Pace
from pendpin.ground.arrays import Array, cross, dot, weighted_roots
from pendpin.ground.records import NotNegative, Positive, Vector

POINTS = 12  # Gauss-Legendre points in each of the two parts of a rod: at worst 2e-6 of the integral (docs/effects.md)
_TINY = 1e-200  # beside the square of a speed; products with a quotient by it stay numbers


def _graded() -> tuple[Array, Array]:
    """Nodes and weights (POINTS,) on 0 to 1, crowded at 0: those of Gauss-Legendre in the root of the distance."""
    x, weights = np.polynomial.legendre.leggauss(POINTS)
    root = (1 + x) / 2
    return root**2, root * weights


_NODES, _WEIGHTS = _graded()
_MOMENTS = _WEIGHTS * _NODES ** np.arange(3)[:, None]  # (3, POINTS), for the integrals of x^k f(x)


class Drag(BodyEffect):
    """Drag of the flow across each rod, integrated along it from its joint to its tip.

    dF/ds = -(density coefficient diameter |u| / 2 + linear) u, with u the velocity of the rod's point relative to the
    air, the part normal to the rod (the cross-flow principle: Hoerner, Fluid-Dynamic Drag, 1965, chapter III). The
    wind is wind + gust sin(frequency t), over the ground: a moving support carries the rod through it. Buoyancy is
    -density volume gravity at the middle of the rod, which displaces a cylinder.

    density kg/m³, coefficient 1 (1.1: a cylinder at Reynolds numbers of 10³ to 10⁵), linear N s/m per m of rod, wind
    and gust m/s in W, frequency rad/s, diameter m (twice the radius of each rod).
    """

    parameters: ClassVar[tuple[str, ...]] = (
        "density",
        "coefficient",
        "linear",
        "wind",
        "gust",
        "frequency",
        "diameter",
    )
    strengths: ClassVar[tuple[str, ...]] = ("quadratic", "linear", "lift")
    kind: Literal["drag"] = Field("drag", description="which effect it is")
    sole: ClassVar[str | None] = "a scene has one air"
    density: NotNegative = Field(1.225, description="kg/m³")
    coefficient: NotNegative = Field(1.1, description="of drag across the rod, without unit")
    linear: NotNegative = Field(0.0, description="N s/m², linear drag per length of rod")
    wind: Vector = Field((0.0, 0.0, 0.0), description="m/s, in W")
    gust: Vector | None = Field(None, description="m/s, in W, times sin(frequency t)")
    frequency: Positive | None = Field(None, description="rad/s")
    diameter: Positive | None = Field(None, description="m; twice the radius of each rod if absent")
    buoyancy: Annotated[bool, Strict()] = Field(
        False, description="lift the rods by the weight of the air they displace"
    )

    @model_validator(mode="after")
    def _gust_has_a_frequency(self) -> Self:
        if (self.gust is None) != (self.frequency is None):
            raise ValueError("gust and frequency go together")
        return self

    @property
    def quadratic(self) -> float:
        """Density times coefficient, kg/m³."""
        return self.density * self.coefficient

    @property
    def lift(self) -> float:
        """The density of the fluid that lifts the rods, kg/m³; 0 without buoyancy."""
        return self.density * self.buoyancy

    @property
    def resistances(self) -> tuple[str, ...]:
        """The coefficient of the quadratic part, and that of the linear one where it was given."""
        return ("coefficient", "linear") if "linear" in self.model_fields_set else ("coefficient",)

    @property
    def smooth(self) -> bool:
        """False with quadratic drag: |u| u has no second derivative where the flow across a rod vanishes."""
        return self.quadratic == 0

    @property
    def symbolic(self) -> bool:
        """True: |u| u is continuous."""
        return True

    @property
    def axial(self) -> bool:
        """False: what acts on the axis does not turn a rod about it."""
        return False

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        """How fast it changes with time from `begin` to `end`, in s."""
        return Pace.sinusoid(self.frequency)

    def air(self, t: Any, xp: Any = np) -> Array:
        """The velocity of the air over the ground at time t, (3,) in m/s."""
        if self.gust is None or self.frequency is None:
            return np.array(self.wind)
        return np.array(self.wind) + np.array(self.gust) * xp.sin(self.frequency * t)

    def wrench(self, t: Any, bodies: Bodies, motion: Motion, xp: Any = np) -> tuple[Array, Array]:
        """Forces and moments (n, 3) of the air; along a rod the flow is u(s) = u0 + s u1, s from 0 to 1."""
        length = xp.sqrt((bodies.tip**2).sum(-1, keepdims=True))
        rod = motion.levers(bodies.tip / (length + _TINY))  # of length 1
        wind = motion.velocity + motion.fixed(motion.pivot_velocity - self.air(t, xp))
        u0, u1 = cross(rod, cross(wind, rod)), length * cross(motion.spin, rod)
        width = 2 * bodies.radius[:, None] if self.diameter is None else self.diameter
        K0, K1, K2 = (-self.linear / n * length for n in (1, 2, 3))
        if self.quadratic:
            factor = -self.quadratic / 2 * width * length
            K0, K1, K2 = (K + factor * J for K, J in zip((K0, K1, K2), _speed_moments(u0, u1, xp), strict=True))
        force, turn = K0 * u0 + K1 * u1, K1 * u0 + K2 * u1
        if self.buoyancy:
            lift = -self.density * np.pi / 4 * width**2 * length * motion.fixed(motion.gravity)
            force, turn = force + lift, turn + 0.5 * lift
        return force, length * cross(rod, turn) - cross(motion.levers(bodies.com), force)


def _speed_moments(u0: Array, u1: Array, xp: Any) -> tuple[Array, Array, Array]:
    """The integrals of |u|, s |u|, s² |u| for u = u0 + s u1 over s from 0 to 1, each (n, 1).

    By Gauss-Legendre in two parts that meet where |u| is least, with the points crowded there: a corner of |u| is met
    exactly, as in every plane motion, and a rounded corner nearly so.
    """
    C = dot(u1, u1)
    lowest = -dot(u0, u1) / (C + _TINY)
    cut = xp.minimum(xp.maximum(lowest, 0.0), 1.0)
    least, parts = u0 + cut * u1, np.stack([cut, 1.0 - cut])
    squares = parts**2
    # dot(least, u1): exactly 0 where the least is inside. At an end it counts for the part that is there, where it is not
    # negative. It is no max(..., 0): at a rest in wind, with u1 = 0, it has a derivative.
    A, B = dot(least, least), (C + _TINY) * (cut - lowest)
    K0, K1, K2 = weighted_roots(A, 2 * parts * np.stack([-B, B]), squares * C, _NODES, _MOMENTS, xp)
    left, right = squares * K1
    K0, K1, K2 = (parts * K0).sum(0), right - left, (parts * squares * K2).sum(0)  # about the cut
    return K0, cut * K0 + K1, cut * (cut * K0 + 2 * K1) + K2
