"""Air, or water: the drag of rods across the flow, wind, buoyancy."""

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.polynomial.polynomial import polyval
from pydantic import Field, Strict

from pendpin.effects.base import Bodies, BodyEffect, Motion
from pendpin.ground.arrays import Array, cross, dot
from pendpin.ground.records import NotNegative, Positive, Vector

_TINY = 1e-300
_STILL = 1e-150  # m/s, added to flows: air at rest against a rod has no speed to divide by
_TAKEN_TURN = 1 - 2.0**-53  # the largest w below; at 1 the flow vanishes on the rod, and log is multiplied by 0
_SMALL = 0.1  # w, below which series have no rounding error of the closed form to fear
_TERMS = np.arange(13.0)  # of these series: the next one is 1e-17
_BETA = 2 / ((2 * _TERMS + 3) * (2 * _TERMS + 5))
_GAMMA = 16 * (_TERMS + 1) / ((2 * _TERMS + 3) * (2 * _TERMS + 5) * (2 * _TERMS + 7))
_BETA_AT_SMALL, _GAMMA_AT_SMALL = (polyval(_SMALL, series) for series in (_BETA, _GAMMA))


class Drag(BodyEffect):
    """Drag of the flow across each rod, integrated along it from its joint to its tip.

    dF/ds = -(density coefficient diameter |u| / 2 + linear) u, with u the velocity of the rod's point relative to the
    air, the part normal to the rod (the cross-flow principle: Hoerner, Fluid-Dynamic Drag, 1965, chapter III). The
    wind is wind + gust sin(frequency t), over the ground: a moving support carries the rod through it. Buoyancy is
    -density volume gravity at the middle of the rod, which displaces a cylinder. A payload with a radius is a sphere at the
    tip: F = -density payload_coefficient pi r² |u| u / 2, and it displaces its own volume.

    density kg/m³, linear N s/m per m of rod, wind and gust m/s in W, frequency rad/s, diameter m (twice the radius of each
    rod). The coefficients, without a unit, are those of a cylinder and of a sphere at Reynolds numbers of 10³ to 10⁵.
    """

    parameters: ClassVar[tuple[str, ...]] = (
        *("density", "coefficient", "linear", "wind", "gust", "frequency", "diameter", "payload_coefficient"),
    )
    strengths: ClassVar[tuple[str, ...]] = ("quadratic", "linear", "lift", "on_spheres")
    together: ClassVar[tuple[str, str] | None] = ("gust", "frequency")
    sinusoidal: ClassVar[bool] = True
    kind: Literal["drag"] = Field("drag", description="which effect it is")
    sole: ClassVar[str | None] = "a scene has one air"
    density: NotNegative = Field(1.225, description="kg/m³")
    coefficient: NotNegative = Field(1.1, description="of drag across the rod, without unit")
    linear: NotNegative = Field(0.0, description="N s/m², linear drag per length of rod")
    wind: Vector = Field((0.0, 0.0, 0.0), description="m/s, in W")
    gust: Vector | None = Field(None, description="m/s, in W, times sin(frequency t)")
    frequency: Positive | None = Field(None, description="rad/s")
    diameter: Positive | None = Field(None, description="m; twice the radius of each rod if absent")
    payload_coefficient: NotNegative = Field(0.47, description="of a payload's sphere, where it has a radius")
    buoyancy: Annotated[bool, Strict()] = Field(False, description="the weight of the air they displace lifts the rods")

    @property
    def quadratic(self) -> float:
        """Density times coefficient, kg/m³."""
        return self.density * self.coefficient

    @property
    def on_spheres(self) -> float:
        """Density times the coefficient of payloads, kg/m³; 0 where that is not given, as in a scene without spheres."""
        return self.density * self.payload_coefficient * ("payload_coefficient" in self.model_fields_set)

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
        return self.quadratic == 0 and self.on_spheres == 0

    @property
    def symbolic(self) -> bool:
        """True: |u| u is continuous."""
        return True

    @property
    def axial(self) -> bool:
        """False: what acts on the axis does not turn a rod about it."""
        return False

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
        moment = length * cross(rod, turn) - cross(motion.levers(bodies.com), force)
        if not np.any(bodies.payload_radius):
            return force, moment
        # the spheres at the tips
        flow, sphere = wind + cross(motion.spin, motion.levers(bodies.tip)), bodies.payload_radius[:, None]
        area, volume = np.pi * sphere**2, 4 / 3 * np.pi * sphere**3
        ball = -self.density * self.payload_coefficient / 2 * area * xp.sqrt(dot(flow, flow)) * flow
        if self.buoyancy:
            ball = ball - self.density * volume * motion.fixed(motion.gravity)
        return force + ball, moment + cross(motion.levers(bodies.tip - bodies.com), ball)


def _speed_moments(u0: Array, u1: Array, xp: Any) -> tuple[Array, Array, Array]:
    """The integrals of |u|, s |u|, s² |u| for u = u0 + s u1 over s from 0 to 1, each (n, 1), to rounding."""
    # In closed form (docs/effects.md derives it): S is the sum of the speeds at both ends, d their difference over S, w the
    # square of |u1| / S, and e = w - d². Then, about the middle of the rod,
    #     K0 = S (1/2 - e (2/3 + w beta) / 4),  M1 = S d (1/12 + e beta / 8),  M2 = S (1/24 - e beta / 16 + e² gamma / 64),
    # with two functions of w, which only the derivative at w = 1, flow that vanishes on the rod, makes infinite: beta and
    # gamma by their series up to `_SMALL`, and what the closed form adds beyond. That loses digits towards w = 0, the series
    # need many terms towards 1; neither minimum nor maximum asks a symbol for its value.
    end, C = u0 + u1, dot(u1, u1)
    S = xp.sqrt(dot(u0, u0)) + xp.sqrt(dot(end, end))
    inverse = 1 / (S + _STILL)
    d, w = (C + 2 * dot(u0, u1)) * inverse * inverse, C * inverse * inverse
    e, w = w - d * d, xp.minimum(w, _TAKEN_TURN)
    low, high = xp.minimum(w, _SMALL), xp.maximum(w, _SMALL)
    root, inverse, left = xp.sqrt(high), 1 / high, 1 - high
    atanh = 0.5 * xp.log((1 + root) * (1 + root) / left)
    beta = (1 / 3 - left * inverse * (atanh * root * inverse - 1)) * inverse
    gamma = ((5 - high) * beta - 2 / 3) * inverse
    beta, gamma = polyval(low, _BETA) + (beta - _BETA_AT_SMALL), polyval(low, _GAMMA) + (gamma - _GAMMA_AT_SMALL)
    K0 = S * (0.5 - e * (1 / 6 + w * beta / 4))
    M1, M2 = S * d * (1 / 12 + e * beta / 8), S * (1 / 24 - e * beta / 16 + e * e * gamma / 64)
    return K0, M1 + K0 / 2, M2 + M1 + K0 / 4
