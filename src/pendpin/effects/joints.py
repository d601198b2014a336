"""Torques about joint axes: viscous damping, springs, motors. For prismatic joints read N for N m and m for rad."""

import inspect
from collections.abc import Callable
from functools import partial
from hashlib import sha256
from types import MethodType
from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, field_serializer, model_validator

from pendpin.effects.base import JointEffect, OnJoints, returned
from pendpin.effects.pace import STEADY, Pace
from pendpin.errors import InputError, shown
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


# --- a torque that is a function: a controller, a table, any law of one's own ---------------------------------------


class Torque(OnJoints):
    """Torques about some joints from a function of time and state: Torque(lambda t, q, v: -2.0 * v, joints=["theta_1"]).

    The function gets t in s and the positions and rates (k,) of these joints, in rad and rad/s, and returns their
    torques (k,) in N m. It is called with floats, once an evaluation: a scene with one is not compiled, and is not
    written to a file. How fast it changes cannot be seen from outside: declare `steady` or `shortest`, and `gradual`,
    or a note says what was assumed.

    `every` in s makes it a sampled torque, as of a digital controller: the function is called at t = 0, every, 2 every, ...
    after the start, and its output is held until the next instant. A step of the integration ends at each.
    """

    kind: Literal["torque"] = Field("torque", description="which effect it is")
    function: Callable[..., Any] = Field(description="f(t, q, v) -> torques (k,), N m", repr=False)
    steady: bool = Field(False, description="time makes no difference to it")
    shortest: Positive | None = Field(None, description="s, the shortest time in which it changes at rest")
    gradual: bool | None = Field(None, description="it changes with positions and rates as slowly as the motion does")

    every: Positive | None = Field(None, description="s, between two instants at which it is sampled; held in between")

    @model_validator(mode="after")
    def _one_pace(self) -> Self:
        declared = [name for name in ("steady", "shortest", "gradual") if getattr(self, name) not in (None, False)]
        if self.every is not None and declared:
            raise ValueError(
                f"every and {declared[0]} do not go together: what is sampled changes at its instants only"
            )
        return self

    @classmethod
    def from_one(cls, function: Callable[..., Any]) -> dict[str, Any]:
        """The function, which needs no name."""
        return {"function": function}

    @property
    def smooth(self) -> bool:
        """False: what a function does is not known, and it takes no symbols."""
        return False

    def pace(self, begin: float, end: float, negligible: float) -> Pace | None:
        """As declared; None if it is not."""
        if self.steady:
            return STEADY
        return None if self.shortest is None else Pace.even(self.shortest)

    def torques(self, t: Any, q: Array, v: Array, xp: Any = np) -> Array:
        """The torques that the function returns, (k,) N m. Raises InputError if that is not k finite numbers."""
        output = self.function(t, q.copy(), v.copy())
        torques = returned("effects: Torque: its function", output, q.shape)
        if not np.isfinite(torques).all():
            raise InputError(f"effects: Torque: its function returned {shown(output)} at t = {t:.10g} s")
        return torques

    @field_serializer("function")
    def _named(self, function: Callable[..., Any]) -> str:
        """What a record of a run says of the function: its name, and what tells it from another."""
        name = getattr(function, "__qualname__", type(function).__name__)
        return f"{name} {sha256(_identity(function).encode()).hexdigest()[:16]}"


def _identity(function: Any) -> str:
    """The source of a function and the values that it holds, by which a saved run knows it again."""
    if isinstance(function, partial):
        return repr((_identity(function.func), function.args, function.keywords))
    if isinstance(function, MethodType):
        return repr((_identity(function.__func__), vars(function.__self__)))
    if not inspect.isfunction(function):
        return repr((_source(type(function)), vars(function) if hasattr(function, "__dict__") else function))
    held = [repr(cell.cell_contents) for cell in function.__closure__ or ()]
    return repr((_source(function), held, function.__defaults__, function.__kwdefaults__))


def _source(thing: Any) -> str:
    """The source of a function or class; where there is none, as of what was typed at a prompt, a name of this process."""
    try:
        return inspect.getsource(thing)
    except (OSError, TypeError):
        return f"{thing.__qualname__} {id(thing)}"
