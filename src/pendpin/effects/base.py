"""The seams through which a scene's effects enter the dynamics (docs/effects.md).

An effect only ever adds. It is a frozen, validated record of its parameters with one method that is written once over
plain arithmetic: the functions it needs (sqrt, sin, ...) come in as `xp`, so the same lines run on floats and symbols.
"""

from abc import abstractmethod
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pendpin.records import Record

Array = NDArray[Any]  # floats, or symbols in an object array


class Effect(Record):
    """One effect of a scene; a subclass of one of the seams below says how it acts."""

    smooth: ClassVar[bool] = True  # False keeps a scene off the Taylor lane
    kind: Any  # Literal["its name"] in each effect


class FieldEffect(Effect):
    """A uniform acceleration field that acts on every mass."""

    @property
    def constant(self) -> bool:
        """Whether the field is the same at all times: then it is evaluated once, when the scene is bound."""
        return False

    @abstractmethod
    def field(self, t: Any, xp: Any = np) -> Array:
        """The field at time t in s: (3,) in m/s², in the world W."""


class JointEffect(Effect):
    """A torque about joint axes (a force along the axis of a prismatic joint)."""

    joints: tuple[str, ...] | None = None  # names; all if absent

    @abstractmethod
    def torque(self, t: Any, q: Array, v: Array, xp: Any = np) -> Array:
        """Torques (k,) in N m on the k chosen joints, from their positions (rad) and rates (rad/s), each (k,)."""

    def potential(self, q: Array, xp: Any = np) -> Any:
        """Potential energy in J at positions (..., k), shape (...); None for an effect that has none."""
        return None


class Bodies(NamedTuple):
    """The bodies of a model, one row each, in their link frames (for a rod of a chain: z from the tip to the joint)."""

    mass: Array  # (n,) kg
    com: Array  # (n, 3) m, centre of mass from the joint
    inertia: Array  # (n, 3, 3) kg m², central
    tip: Array  # (n, 3) m, far end from the joint
    radius: Array  # (n,) m


class Motion(NamedTuple):
    """Where the bodies are and how they move, in the world W."""

    origin: Array  # (n, 3) m, the joint that moves the body
    rotation: Array  # (n, 3, 3), the link frame's axes as columns
    velocity: Array  # (n, 3) m/s, of the origin
    spin: Array  # (n, 3) rad/s


class BodyEffect(Effect):
    """A force and moment on each body, from its pose and velocity."""

    @abstractmethod
    def wrench(self, t: Any, bodies: Bodies, motion: Motion, xp: Any = np) -> tuple[Array, Array]:
        """Forces (n, 3) in N and moments (n, 3) in N m about the centres of mass, in W, at time t in s."""
