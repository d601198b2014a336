"""Given forces and torques on one rod."""

from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from pendpin.effects.base import Bodies, BodyEffect, Motion
from pendpin.effects.pace import Pace
from pendpin.ground.arrays import Array, cross
from pendpin.ground.records import Number, Positive, Vector

ZERO: Vector = (0.0, 0.0, 0.0)


class Push(BodyEffect):
    """A force at a point of one rod, and a torque, in directions of the world W.

    F = force + amplitude sin(frequency t), at `point`, and `torque`. force and amplitude in N, torque in N m, frequency
    in rad/s; point in m along the rod from its joint, the centre of mass if absent.
    """

    parameters: ClassVar[tuple[str, ...]] = ("force", "torque", "point", "amplitude", "frequency")
    strengths: ClassVar[tuple[str, ...]] = ("force", "torque", "amplitude")
    kind: Literal["push"] = Field("push", description="which effect it is")
    link: str = Field(description="name of the rod: rod_1, rod_2, ...")
    force: Vector = Field(ZERO, description="N, in W")
    torque: Vector = Field(ZERO, description="N m, in W")
    point: Number | None = Field(None, description="m along the rod from the joint; the centre of mass if absent")
    amplitude: Vector | None = Field(None, description="N, in W, times sin(frequency t)")
    frequency: Positive | None = Field(None, description="rad/s")

    @model_validator(mode="after")
    def _amplitude_has_a_frequency(self) -> Self:
        if (self.amplitude is None) != (self.frequency is None):
            raise ValueError("amplitude and frequency go together")
        return self

    @property
    def on(self) -> tuple[str, ...]:
        """The pushed link."""
        return (self.link,)

    @property
    def axial(self) -> bool:
        """True with a torque; a force on the axis does not turn a rod about it."""
        return any(self.torque)

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        """How fast it changes with time from `begin` to `end`, in s."""
        return Pace.sinusoid(self.frequency)

    def wrench(self, t: Any, bodies: Bodies, motion: Motion, xp: Any = np) -> tuple[Array, Array]:
        """The force (1, 3) N and its moment (1, 3) N m about the centre of mass, W."""
        force = np.array(self.force)
        if self.frequency is not None and self.amplitude is not None:
            force = force + np.array(self.amplitude) * xp.sin(self.frequency * t)
        force, moment = (np.atleast_2d(motion.fixed(x)) for x in (force, np.array(self.torque)))
        if self.point is not None:
            moment = moment + cross(motion.levers(self._point(bodies, xp) - bodies.com), force)
        return force, moment

    def potential(self, bodies: Bodies, motion: Motion, xp: Any = np) -> Any:
        """The potential -force . r of a constant force in J, zero at the origin of W; None for others."""
        if self.frequency is not None or any(self.torque):
            return None
        return -(motion.points(self._point(bodies, xp)) @ np.array(self.force))[..., 0]

    def _point(self, bodies: Bodies, xp: Any) -> Array:
        """Where the force acts, (1, 3) m in the link frame."""
        if self.point is None:
            return bodies.com
        return bodies.tip * (self.point / xp.sqrt((bodies.tip**2).sum(-1, keepdims=True)))
