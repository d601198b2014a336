"""A world that turns: the Earth, or a centrifuge."""

from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from pendpin.effects.base import Bodies, BodyEffect, Motion
from pendpin.effects.pace import STEADY, Pace
from pendpin.ground.arrays import Array, applied, cross
from pendpin.ground.records import Number, Vector

EARTH = 7.292115e-5  # rad/s, Earth's rate of the World Geodetic System 1984


class Rotation(BodyEffect):
    """W turns at the constant rate Omega about an axis through its origin at rest: Coriolis and centrifugal forces.

    The force on a mass element is -(2 Omega x v + Omega x (Omega x r)) dm. The sum over a rigid body is exact: F = -m (2
    Omega x v_G + Omega x (Omega x r_G)) and, about the centre of mass, M = (Omega + 2 omega) x (E Omega). The spread of
    mass is E = integral of r r^T dm = tr(I) / 2 - I (docs/effects.md derives it).

    latitude is in degrees, north positive, for the Earth with x east, y north, z up. In its place rate is Omega (3,) in
    rad/s in W. Gravity turns with W. On the Earth, the centrifugal force at the pivot is part of the local gravity, and
    is not added again.
    """

    parameters: ClassVar[tuple[str, ...]] = ("latitude", "rate")
    strengths: ClassVar[tuple[str, ...]] = ("vector",)
    kind: Literal["rotation"] = Field("rotation", description="which effect it is")
    sole: ClassVar[str | None] = "W turns about one axis at one rate"
    latitude: Annotated[Number, Field(ge=-90, le=90)] | None = Field(None, description="degrees")
    rate: Vector | None = Field(None, description="rad/s, in W")

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if (self.latitude is None) == (self.rate is None):
            raise ValueError("a rotation needs a latitude or a rate, one of them")
        return self

    def with_numbers(self, numbers: Any) -> Self:
        """The effect with Omega mapped by `numbers`."""
        return self.model_copy(update={"latitude": None, "rate": numbers(self.vector)})

    @property
    def axial(self) -> bool:
        """False: inertial forces do not turn a thin rod about its axis."""
        return False

    @property
    def vector(self) -> Array:
        """Omega, (3,) in rad/s, in W."""
        return self._vector(np)

    def _vector(self, xp: Any) -> Array:
        if self.latitude is None:
            return np.array(self.rate)
        if isinstance(self.latitude, float):
            angle, xp = np.radians(self.latitude), np  # numbers of the scene are doubles whatever the equations run on
        else:
            angle = self.latitude * (np.pi / 180)
        return EARTH * np.array([0.0, xp.cos(angle), xp.sin(angle)])

    def wrench(self, t: Any, bodies: Bodies, motion: Motion, xp: Any = np) -> tuple[Array, Array]:
        """Coriolis and centrifugal forces (n, 3) N and moments (n, 3) N m about the centres of mass, W."""
        omega, lever = motion.fixed(self._vector(xp)), motion.levers(bodies.com)
        r = motion.origin + lever + motion.fixed(motion.pivot)
        v = motion.velocity + cross(motion.spin, lever) + motion.fixed(motion.pivot_velocity)
        force = -bodies.mass[:, None] * cross(omega, 2 * v + cross(omega, r))
        return force, cross(omega + 2 * motion.spin, _spread(bodies, motion, omega))

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        """Time makes no difference: the rate is constant."""
        return STEADY

    def potential(self, bodies: Bodies, motion: Motion, xp: Any = np) -> Any:
        """J, of the centrifugal force: minus half the integral of |Omega x r|² dm."""
        omega = self.vector
        at_com = cross(omega, motion.points(bodies.com) + motion.pivot)
        in_links = applied(motion.rotation.swapaxes(-1, -2), omega[None])  # Omega in the link frames
        spread = (in_links * applied(bodies.inertia, in_links)).sum((-2, -1))
        return -((bodies.mass * (at_com**2).sum(-1)).sum(-1) + spread) / 2


def _spread(bodies: Bodies, motion: Motion, omega: Array) -> Array:
    """E Omega, (n, 3), of omega (3,) or (n, 3): E is the integral of r r^T dm about the centre of mass.

    It has no part across a thin rod.
    """
    trace = np.trace(bodies.inertia, axis1=-2, axis2=-1)
    E = trace[:, None, None] / 2 * np.eye(3) - bodies.inertia
    R = motion.rotation
    return applied(R, applied(E, applied(R.swapaxes(-1, -2), np.atleast_2d(omega))))
