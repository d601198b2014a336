"""Forces at a point of one rod: a given one, and a spring to a point of the world."""

from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from pendpin.effects.base import Bodies, BodyEffect, Motion
from pendpin.ground.arrays import Array, cross
from pendpin.ground.records import NotNegative, Number, Positive, Vector

ZERO: Vector = (0.0, 0.0, 0.0)


class OnLink(BodyEffect):
    """A body effect on one rod."""

    link: str = Field(description="name of the rod: rod_1, rod_2, ...")

    @property
    def on(self) -> tuple[str, ...]:
        return (self.link,)


class Push(OnLink):
    """A force at a point of one rod, and a torque, in directions of the world W.

    F = force + amplitude sin(frequency t), at `point`, and `torque`. force and amplitude in N, torque in N m, frequency
    in rad/s; point in m along the rod from its joint, the centre of mass if absent.
    """

    parameters: ClassVar[tuple[str, ...]] = ("force", "torque", "point", "amplitude", "frequency")
    strengths: ClassVar[tuple[str, ...]] = ("force", "torque", "amplitude")
    together: ClassVar[tuple[str, str] | None] = ("amplitude", "frequency")
    sinusoidal: ClassVar[bool] = True
    kind: Literal["push"] = Field("push", description="which effect it is")
    force: Vector = Field(ZERO, description="N, in W")
    torque: Vector = Field(ZERO, description="N m, in W")
    point: Number | None = Field(None, description="m along the rod from the joint; the centre of mass if absent")
    amplitude: Vector | None = Field(None, description="N, in W, times sin(frequency t)")
    frequency: Positive | None = Field(None, description="rad/s")

    @property
    def axial(self) -> bool:
        """True with a torque; a force on the axis does not turn a rod about it."""
        return any(self.torque)

    def wrench(self, t: Any, bodies: Bodies, motion: Motion, xp: Any = np) -> tuple[Array, Array]:
        force = np.array(self.force)
        if self.frequency is not None and self.amplitude is not None:
            force = force + np.array(self.amplitude) * xp.sin(self.frequency * t)
        force, moment = (np.atleast_2d(motion.fixed(x)) for x in (force, np.array(self.torque)))
        if self.point is not None:
            moment = moment + cross(motion.levers(bodies.along(self.point, bodies.com, xp) - bodies.com), force)
        return force, moment

    def potential(self, bodies: Bodies, motion: Motion, xp: Any = np) -> Any:
        """The potential -force . r of a constant force in J, zero at the origin of W; None for others."""
        if self.frequency is not None or any(self.torque):
            return None
        return -(motion.points(bodies.along(self.point, bodies.com, xp)) @ np.array(self.force))[..., 0]


class Anchor(OnLink):
    """A spring and a damper from a point of one rod to a point of the world W.

    F = stiffness (point - r) - damping r', with r the place of the rod's point `at` m from its joint, its tip if absent.
    The spring has no length of its own. W moves with a moving support, and so does the point.

    stiffness in N/m, damping in N s/m, point in m.
    """

    parameters: ClassVar[tuple[str, ...]] = ("point", "stiffness", "damping", "at")
    strengths: ClassVar[tuple[str, ...]] = ("stiffness", "damping")
    kind: Literal["anchor"] = Field("anchor", description="which effect it is")
    point: Vector = Field(description="m, in W")
    stiffness: NotNegative = Field(description="N/m")
    damping: NotNegative = Field(0.0, description="N s/m")
    at: Number | None = Field(None, description="m along the rod from its joint; its tip if absent")

    @property
    def axial(self) -> bool:
        """False: a force on the axis does not turn a rod about it."""
        return False

    @property
    def resistances(self) -> tuple[str, ...]:
        return ("damping",)

    def wrench(self, t: Any, bodies: Bodies, motion: Motion, xp: Any = np) -> tuple[Array, Array]:
        held = bodies.along(self.at, bodies.tip, xp)
        away = motion.points(held) - motion.fixed(np.array(self.point))
        force = -self.stiffness * away - self.damping * motion.velocities(held)
        return force, cross(motion.levers(held - bodies.com), force)

    def potential(self, bodies: Bodies, motion: Motion, xp: Any = np) -> Any:
        """stiffness / 2 times the square of the distance, J; None with damping."""
        if self.damping:
            return None
        away = motion.points(bodies.along(self.at, bodies.tip, xp)) - np.array(self.point)
        return self.stiffness / 2 * (away**2).sum((-2, -1))
