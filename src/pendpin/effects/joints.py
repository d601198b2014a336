"""Torques about joint axes: viscous damping, springs, motors. For prismatic joints read N for N m and m for rad."""

from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from pendpin.effects.base import JointEffect, OnJoints
from pendpin.effects.pace import STEADY, Pace
from pendpin.ground.arrays import Array
from pendpin.ground.records import NotNegative, Number, Positive


class Viscous(OnJoints):
    """Damping in proportion to the rate: tau = -coefficient q'.

    coefficient in N m s/rad. In a lubricated bearing; it matters if the damping of a free swing matters.
    """

    parameters: ClassVar[tuple[str, ...]] = ("coefficient",)
    strengths: ClassVar[tuple[str, ...]] = ("coefficient",)
    kind: Literal["viscous"] = Field("viscous", description="which effect it is")
    coefficient: NotNegative = Field(description="N m s/rad")

    @property
    def resistances(self) -> tuple[str, ...]:
        """The coefficient."""
        return ("coefficient",)

    def torques(self, t: Any, q: Array, v: Array, xp: Any = np) -> Array:
        """-coefficient v, (k,) N m."""
        return -self.coefficient * v

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        """Time makes no difference."""
        return STEADY


class Spring(OnJoints):
    """A linear spring at the joint: tau = -stiffness (q - rest), potential stiffness (q - rest)² / 2.

    stiffness in N m/rad, rest in rad, the same for all its joints.
    """

    parameters: ClassVar[tuple[str, ...]] = ("stiffness", "rest")
    strengths: ClassVar[tuple[str, ...]] = ("stiffness",)
    kind: Literal["spring"] = Field("spring", description="which effect it is")
    stiffness: NotNegative = Field(description="N m/rad")
    rest: Number = Field(0.0, description="rad")

    def torques(self, t: Any, q: Array, v: Array, xp: Any = np) -> Array:
        """-stiffness (q - rest), (k,) N m."""
        return -self.stiffness * (q - self.rest)

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        """Time makes no difference."""
        return STEADY

    def potential(self, q: Array, xp: Any = np) -> Any:
        """stiffness (q - rest)² / 2, summed over the joints, J; q is (n, nv) in rad."""
        return self.stiffness / 2 * ((q - self.rest) ** 2).sum(-1)


_DRIVE = ("torque", "amplitude", "frequency", "phase")
_HOLD = ("target", "proportional", "derivative")


class Motor(JointEffect):
    """A motor on one joint: a given torque, or a controller that holds the joint.

    torque + amplitude sin(frequency t + phase), in N m, N m, rad/s, rad; or
    -proportional (q - target) - derivative q', in N m/rad, rad, N m s/rad. Absent numbers are 0.
    """

    parameters: ClassVar[tuple[str, ...]] = (*_DRIVE, *_HOLD)
    strengths: ClassVar[tuple[str, ...]] = ("torque", "amplitude", "proportional", "derivative")
    kind: Literal["motor"] = Field("motor", description="which effect it is")
    joint: str = Field(description="name of the joint")
    torque: Number | None = Field(None, description="N m")
    amplitude: Number | None = Field(None, description="N m")
    frequency: Positive | None = Field(None, description="rad/s")
    phase: Number | None = Field(None, description="rad")
    target: Number | None = Field(None, description="rad")
    proportional: NotNegative | None = Field(None, description="N m/rad")
    derivative: NotNegative | None = Field(None, description="N m s/rad")

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        given = [name for name in (*_DRIVE, *_HOLD) if getattr(self, name) is not None]
        drive, hold = ([name for name in names if name in given] for names in (_DRIVE, _HOLD))
        if drive and hold:
            raise ValueError(
                f"{drive[0]} and {hold[0]} exclude each other: a motor has a torque or a controller; list two motors"
            )
        if not given:
            raise ValueError("a motor needs a torque, an amplitude and frequency, or a proportional and target")
        if (self.amplitude is None) != (self.frequency is None):
            raise ValueError("amplitude and frequency go together")
        if self.phase is not None and self.amplitude is None:
            raise ValueError("a phase needs an amplitude and frequency")
        if self.target is not None and self.proportional is None:
            raise ValueError("a target needs a proportional gain")
        return self

    @property
    def on(self) -> tuple[str, ...]:
        """The driven joint."""
        return (self.joint,)

    @property
    def holds(self) -> bool:
        """Whether it is a controller."""
        return self.proportional is not None or self.derivative is not None

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        """How fast it changes with time from `begin` to `end`, in s."""
        return Pace.sinusoid(self.frequency)

    def torques(self, t: Any, q: Array, v: Array, xp: Any = np) -> Array:
        """The given torque, or that of the controller, (1,) N m."""
        if self.holds:
            return -(self.proportional or 0.0) * (q - (self.target or 0.0)) - (self.derivative or 0.0) * v
        steady = self.torque or 0.0
        if self.frequency is None:
            return np.array([steady])
        return np.array([steady + (self.amplitude or 0.0) * xp.sin(self.frequency * t + (self.phase or 0.0))])
