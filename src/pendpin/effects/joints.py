"""Torques about joint axes: damping, springs, bending, motors, functions. For prismatic joints read N for N m, m for rad."""

import inspect
from collections.abc import Callable, Sequence
from functools import partial
from hashlib import sha256
from types import MethodType
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.polynomial.polynomial import polyval
from pydantic import Field, field_serializer, model_validator

from pendpin.effects.base import JointEffect, OnJoints, returned
from pendpin.effects.pace import STEADY, Pace
from pendpin.errors import InputError, shown
from pendpin.ground.arrays import Array, unit
from pendpin.ground.records import Direction, NotNegative, Number, Positive


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
        return ("coefficient",)

    def torques(self, t: Any, q: Array, v: Array, xp: Any = np) -> Array:
        """-coefficient v, (k,) N m."""
        return -self.coefficient * v


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

    def potential(self, q: Array, xp: Any = np) -> Any:
        """stiffness (q - rest)² / 2, summed over the joints, J; q is (n, nv) in rad."""
        return self.stiffness / 2 * ((q - self.rest) ** 2).sum(-1)


_FOLDED = 2.0**-60  # added to cos²(alpha / 2): a rod folded back exactly has a finite moment, and others that of before
_HALVINGS = 3  # of the angle: the series then sees at most sin²(180°/16), and no corner below 180°
_TERMS = np.array([1.0])
for _k in range(1, 13):  # of asin(x)/x in powers of x²: the next one is below 1e-20 there
    _TERMS = np.append(_TERMS, _TERMS[-1] * (2 * _k - 1) ** 2 / (2 * _k * (2 * _k + 1)))


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
    stiffness: NotNegative = Field(description="N m², EI")
    clamp: Direction | None = Field(None, description="direction in W, not 0, to which rods on the world are clamped")

    def of_joints(self, lengths: Array, parents: Sequence[int] | None = None) -> Array:
        """For each angle of n rods of these lengths in m: 1/l and the direction (3,) of no moment, (2 n, 4).

        In the frame in which the rod hangs, it lies along -z at zero angles.
        """
        direction = np.zeros(3) if self.clamp is None else unit(self.clamp)
        each = np.zeros((len(lengths), 4), np.result_type(lengths, direction))
        above = np.arange(-1, len(lengths) - 1) if parents is None else np.array(parents)
        hung = above >= 0
        each[hung, 0], each[:, 3] = 2 / (lengths[hung] + lengths[above[hung]]), -1.0
        if self.clamp is not None:
            each[~hung, 0], each[~hung, 1:] = 2 / lengths[~hung], direction
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


def _half_angle_squares(s1: Any, c1: Any, s2: Any, c2: Any, x: Any, y: Any, z: Any) -> tuple[Any, Any]:
    """The squares of sine and cosine of alpha / 2, from those of theta and phi and the direction (x, y, z) of no moment."""
    # A quarter of the squares of difference and sum of two unit vectors: both without cancellation, and never below 0.
    dx, dy, dz = s2, -s1 * c2, -c1 * c2
    difference, total = ((dx - x) ** 2 + (dy - y) ** 2 + (dz - z) ** 2), ((dx + x) ** 2 + (dy + y) ** 2 + (dz + z) ** 2)
    return difference * 0.25, total * 0.25


def _asin_over_x(w: Any, u: Any, xp: Any) -> Any:
    """asin(x) / x of w = x² = 1 - u, smooth at 0: by halved angles, sin²(a/2) = sin²(a) / (2 (1 + cos(a)))."""
    scale = 1.0
    for _ in range(_HALVINGS):
        twice = 2 * (1 + xp.sqrt(u))
        w, scale = w / twice, scale * 2 / xp.sqrt(twice)
        u = 1 - w
    return scale * polyval(w, _TERMS)


_DRIVE = ("torque", "amplitude", "frequency", "phase")
_HOLD = ("target", "proportional", "derivative")


class Motor(JointEffect):
    """A motor on one joint: a given torque, or a controller that holds the joint.

    torque + amplitude sin(frequency t + phase), in N m, N m, rad/s, rad; or
    -proportional (q - target) - derivative q', in N m/rad, rad, N m s/rad. Absent numbers are 0.
    """

    parameters: ClassVar[tuple[str, ...]] = (*_DRIVE, *_HOLD)
    strengths: ClassVar[tuple[str, ...]] = ("torque", "amplitude", "proportional", "derivative")
    together: ClassVar[tuple[str, str] | None] = ("amplitude", "frequency")
    sinusoidal: ClassVar[bool] = True
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
            both = f"{drive[0]} and {hold[0]} exclude each other"
            raise ValueError(f"{both}: a motor has a torque or a controller; list two motors")
        if not given:
            raise ValueError("a motor needs a torque, an amplitude and frequency, or a proportional and target")
        if self.phase is not None and self.amplitude is None:
            raise ValueError("a phase needs an amplitude and frequency")
        if self.target is not None and self.proportional is None:
            raise ValueError("a target needs a proportional gain")
        return self

    @property
    def on(self) -> tuple[str, ...]:
        return (self.joint,)

    def torques(self, t: Any, q: Array, v: Array, xp: Any = np) -> Array:
        """The given torque, or that of the controller, (1,) N m."""
        if self.proportional is not None or self.derivative is not None:
            return -(self.proportional or 0.0) * (q - (self.target or 0.0)) - (self.derivative or 0.0) * v
        steady = self.torque or 0.0
        if self.frequency is None:
            return np.array([steady])
        return np.array([steady + (self.amplitude or 0.0) * xp.sin(self.frequency * t + (self.phase or 0.0))])


class Torque(OnJoints):
    """Torques about some joints from a function of time and state: Torque(lambda t, q, v: -2.0 * v, joints=["theta_1"]).

    The function gets t in s and the positions and rates (k,) of these joints, in rad and rad/s, and returns their
    torques (k,) in N m. It is called with floats, once an evaluation, beside the machine code of all else; a scene with
    one is not written to a file. How fast it changes cannot be seen from outside: declare `steady` or `shortest`, and
    `gradual`, or a note says what was assumed.

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
            raise ValueError(f"every and {declared[0]} do not go together: what is sampled changes at instants only")
        try:
            form = inspect.signature(self.function)
        except (TypeError, ValueError):  # of a function in C, which does not say what it takes
            return self
        try:
            form.bind(0.0, None, None)
        except TypeError:
            raise ValueError(f"function: it is called as f(t, q, v), and takes {form}") from None
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
    """The source of a function or class; without one, as of what is typed at a prompt, a name of this process."""
    try:
        return inspect.getsource(thing)
    except (OSError, TypeError):
        return f"{thing.__qualname__} {id(thing)}"
