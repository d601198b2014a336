"""The interfaces through which a scene's effects enter the dynamics (docs/effects.md).

Effects are added. An effect is a frozen, validated record of its parameters with one method that is written once over
plain arithmetic: the functions it needs (sqrt, sin, ...) come in as `xp`, so the same lines run on floats, on numbers
of any precision and on symbols.
"""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Annotated, Any, ClassVar, NamedTuple, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from pendpin.effects.pace import Pace
from pendpin.errors import InputError, shown
from pendpin.ground.arrays import Array, applied, cross
from pendpin.ground.records import Record

LATEST = 340  # digits: more than a time times a frequency can have before its point


class Effect(Record):
    """One effect of a scene; a subclass of one of the interfaces below says how it acts."""

    kind: Any = Field(description="which effect it is")  # Literal["its name"] in each effect
    sole: ClassVar[str | None] = None  # why a scene takes one effect of this kind at most; None where they add up
    parameters: ClassVar[tuple[str, ...]] = ()  # its numbers, which compiled equations take at run time
    strengths: ClassVar[tuple[str, ...]] = ()  # if all of these are 0 or absent, it adds nothing
    together: ClassVar[tuple[str, str] | None] = None  # two parameters of which neither is given without the other
    sinusoidal: ClassVar[bool] = False  # whether time enters by sin(frequency t + phase) alone, if there is a frequency

    @model_validator(mode="after")
    def _both_or_neither(self) -> Self:
        one, other = self.together or ("kind", "kind")
        if (getattr(self, one) is None) != (getattr(self, other) is None):
            raise ValueError(f"{one} and {other} go together")
        return self

    @property
    def smooth(self) -> bool:
        """Whether it has all derivatives and uses no functions but those of xp, as the Taylor method needs."""
        return True

    @property
    def idle(self) -> bool:
        """Whether its strength is 0, so that it adds nothing at any time, in any state; by the class's own strengths."""
        names = vars(type(self)).get("strengths", ())  # a subclass may add what its base does not
        return bool(names) and not any(np.any(getattr(self, name)) for name in names)

    def since(self, start: float) -> tuple["Effect", Any]:
        """An effect and a time in s: at that time and later it does what this one does at `start` and later.

        An early time keeps more digits than a late one: a sinusoid is taken from when it first has the phase of the start.
        """
        frequency: Any = getattr(self, "frequency", None) if self.sinusoidal else None
        if frequency is None or not start:
            return self, start
        from mpmath import mp, mpf

        real = np.real(frequency)  # complex where derivatives by it are wanted (dynamics/derivatives.py)
        with mp.workdps(LATEST):
            early = float(mp.fmod(mpf(start) * mpf(real), 2 * mp.pi) / real)
        if isinstance(frequency, complex):  # frequency early changes with the frequency like frequency start
            return self, early + (start - early) / real * (frequency - real)
        return self, early

    def pace(self, begin: float, end: float, negligible: float) -> Pace | None:
        """How fast the effect changes with time from `begin` to `end`, in s, where positions and rates do not change.

        Changes below `negligible` times the largest value may be left out; `pendpin.effects.pace.STEADY` if time makes no
        difference. None if the effect does not declare it: the run then samples it, and adds a note. Laws of pendpin's own
        need not: they change with time by their `track`, by their `frequency`, or not at all (dynamics/pace.py).
        """
        return None

    @property
    def resistances(self) -> tuple[str, ...]:
        """Its numbers by which it brakes a motion, and nothing else: a fit may free them, and tries it with all at 0."""
        return ()

    @property
    def symbolic(self) -> bool:
        """Whether it uses no functions but those of xp, so that it runs on symbols and can be compiled."""
        return self.smooth

    def with_numbers(self, numbers: Any) -> Self:
        """The effect with each of its `parameters` mapped by `numbers` (pendpin.dynamics.parameters)."""
        return self.model_copy(update={name: numbers(getattr(self, name)) for name in self.parameters})

    def check(self, begin: float, end: float) -> None:
        """Raise ValueError if the effect is not defined from `begin` to `end`, in s."""


class Idle(Effect):
    """In place of an effect of strength 0: the others keep their places in the list."""

    kind: str = Field(description="which effect it stands for")


def returned(what: str, output: Any, shape: tuple[int, ...], kind: type = float) -> Array:
    """What a user's function returned as an array of this shape; one row may be written without its first axis.

    Raises InputError for another shape, and where floats are asked, for a value that is not a real number.
    """
    try:
        numbers = np.asarray(output)
        if kind is float and numbers.dtype.kind not in "biufO":
            raise TypeError
        numbers = np.array(numbers, kind)  # its own: a function may return the same array every time
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what} returned {shown(output)}, which is not an array of numbers") from None
    if numbers.shape != shape and not (shape[0] == 1 and numbers.shape == shape[1:]):
        raise InputError(f"{what} returned shape {numbers.shape}, where {shape} is wanted")
    return numbers.reshape(shape)


class FieldEffect(Effect):
    """A uniform acceleration field that acts on every mass."""

    @property
    def constant(self) -> bool:
        """Whether the field is the same at all times: then it is evaluated once, when the scene is bound."""
        return False

    @abstractmethod
    def field(self, t: Any, xp: Any = np) -> Array:
        """The field at time t in s: (3,) in m/s², in the world W."""


class FrameEffect(FieldEffect):
    """A motion of the origin of W, and so of the pivot, over the ground. W does not turn.

    Positions and velocities are then relative to the pivot, and the equivalence of acceleration and gravity makes the
    motion a uniform field: exact, whatever hangs there.
    """

    @abstractmethod
    def position(self, t: Any, xp: Any = np) -> Array:
        """Where the origin of W is over the ground at time t in s: (3,) in m."""

    @abstractmethod
    def velocity(self, t: Any, xp: Any = np) -> Array:
        """How it moves: (3,) in m/s."""

    @abstractmethod
    def acceleration(self, t: Any, xp: Any = np) -> Array:
        """How it accelerates: (3,) in m/s²."""

    def field(self, t: Any, xp: Any = np) -> Array:
        """Minus the acceleration of the origin of W, (3,) m/s²."""
        return -self.acceleration(t, xp)


class JointEffect(Effect):
    """A torque about joint axes (a force along the axis of a prismatic joint)."""

    @property
    def on(self) -> tuple[str, ...] | None:
        """The names of the k joints that it acts on; all if None."""
        return None

    def of_joints(self, lengths: Array, parents: Sequence[int] | None = None) -> Array | None:
        """Numbers of each angle, (2 n, m), that follow from the lengths (n,) in m of a scene's rods; None if it needs none.

        `parents` are the places (n,) of the rods that they hang on, -1 for the world; None of a chain. Where it gives any,
        `torques` and `potential` get them as `each`, and theta and phi of every rod, (2 n,): the angle that a hinge lacks is
        0.
        """
        return None

    @abstractmethod
    def torques(self, t: Any, q: Array, v: Array, xp: Any = np) -> Array:
        """Torques (k,) in N m on these joints, from their positions (rad) and rates (rad/s), each (k,)."""

    def potential(self, q: Array, xp: Any = np) -> Any:
        """Potential energy in J at positions (..., k), shape (...); None for an effect that has none."""
        return None


class JointNames(Record):
    """A list of joints as a parameter, on which an effect acts."""

    joints: Annotated[tuple[str, ...], Field(min_length=1)] | None = Field(None, description="names; all if absent")

    @field_validator("joints")
    @classmethod
    def _each_once(cls, joints: tuple[str, ...] | None) -> tuple[str, ...] | None:
        for i, name in enumerate(joints or ()):
            if joints and name in joints[:i]:
                raise ValueError(f"{shown(name)} is named twice")
        return joints

    @property
    def on(self) -> tuple[str, ...] | None:
        """The joints of the record; all if None."""
        return self.joints


class OnJoints(JointNames, JointEffect):
    """A joint effect with a list of joints as a parameter."""


class Bodies(NamedTuple):
    """The bodies of a model, one row each, in their link frames (for a rod of a chain: z from the tip to the joint)."""

    mass: Array  # (n,) kg
    com: Array  # (n, 3) m, centre of mass from the joint
    inertia: Array  # (n, 3, 3) kg m², central
    tip: Array  # (n, 3) m, far end from the joint
    radius: Array  # (n,) m
    payload_radius: Array = np.zeros(1)  # (n,) m, of the sphere at the tip; 0 of none

    def of(self, chosen: Array) -> "Bodies":
        """k of the bodies, by their indices (k,)."""
        return Bodies(*(column[chosen] for column in self))

    def along(self, at: Any, absent: Array, xp: Any = np) -> Array:
        """Points (n, 3) m in the link frames, `at` m from the joint towards the tip, or `absent` if none is given."""
        return absent if at is None else self.tip * (at / xp.sqrt((self.tip**2).sum(-1, keepdims=True)))


class Motion(NamedTuple):
    """Where the bodies are and how they move, in the world W, and where W is.

    Compiled equations take what belongs to a body in its own link frame instead: pendpin's own effects pass vectors
    that they are given in W, and those of W, through `fixed`, and answer in the same frames.
    """

    origin: Array  # (n, 3) m, the joint that moves the body
    rotation: Array  # (n, 3, 3), the link frame's axes as columns
    velocity: Array  # (n, 3) m/s, of the origin
    spin: Array  # (n, 3) rad/s
    gravity: Array = np.zeros(3)  # (3,) m/s², the fields that do not come from a motion of W: air feels them too
    pivot: Array = np.zeros(3)  # (3,) m, the origin of W over the ground
    pivot_velocity: Array = np.zeros(3)  # (3,) m/s
    into_links: Callable[[Array], Array] | None = None  # from W, (3,), into the link frames, (n, 3), if these are meant

    def fixed(self, vector: Array) -> Array:
        """A vector (3,) given in W, in the frames of the motion: (3,) or (n, 3)."""
        return vector if self.into_links is None else self.into_links(vector)

    def of(self, chosen: Array) -> "Motion":
        """The motion of k of the bodies, by their indices (k,)."""
        origin, velocity, spin = (part[..., chosen, :] for part in (self.origin, self.velocity, self.spin))
        into = None if self.into_links is None else lambda vector: self.fixed(vector)[chosen]
        rotation = self.rotation[..., chosen, :, :]
        return self._replace(origin=origin, rotation=rotation, velocity=velocity, spin=spin, into_links=into)

    def levers(self, points: Array) -> Array:
        """Vectors (n, 3) given in the link frames, with components in W."""
        return applied(self.rotation, points)

    def points(self, points: Array) -> Array:
        """Where points fixed in the links are, (n, 3) m."""
        return self.origin + self.levers(points)

    def velocities(self, points: Array) -> Array:
        """Velocities of points fixed in the links, (n, 3) m/s."""
        return self.velocity + cross(self.spin, self.levers(points))


class BodyEffect(Effect):
    """A force and moment on each body, from its pose and velocity."""

    @property
    def on(self) -> tuple[str, ...] | None:
        """The names of the n links that it acts on; all with a mass if None."""
        return None

    @property
    def axial(self) -> bool:
        """Whether it may turn a rod about its own axis, or depends on that angle.

        If False, a chain of thin rods moves as on spherical joints, regular everywhere.
        """
        return True

    @abstractmethod
    def wrench(self, t: Any, bodies: Bodies, motion: Motion, xp: Any = np) -> tuple[Array, Array]:
        """Forces (n, 3) in N and moments (n, 3) in N m about the centres of mass, in W, at time t in s."""

    def potential(self, bodies: Bodies, motion: Motion, xp: Any = np) -> Any:
        """Potential energy in J; None for an effect that has none."""
        return None
