"""Uniform accelerations of everything: gravity, a support that moves, a frame that turns."""

from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from pendpin.effects.base import Bodies, BodyEffect, Effect, FieldEffect, FrameEffect, Motion
from pendpin.effects.track import Track, read_track
from pendpin.errors import InputError, inside, shown_path
from pendpin.ground.arrays import Array, applied, cross, unit
from pendpin.ground.records import Direction, FilePath, NotNegative, Number, Positive, Vector

EARTH = 7.292115e-5  # rad/s, Earth's rate of the World Geodetic System 1984


class Gravity(FieldEffect):
    """Uniform gravity: the field is acceleration * direction / |direction|.

    acceleration in m/s² (9.81); direction in the world W, z up ((0, 0, -1)), of any length but zero.
    """

    parameters: ClassVar[tuple[str, ...]] = ("acceleration", "direction")
    strengths: ClassVar[tuple[str, ...]] = ("acceleration",)
    kind: Literal["gravity"] = Field("gravity", description="which effect it is")
    acceleration: NotNegative = Field(9.81, description="m/s²")
    direction: Direction = Field((0.0, 0.0, -1.0), description="in the world W, z up; of any length but 0")

    def with_numbers(self, numbers: Any) -> Self:
        """The effect as it is: the sum of all constant fields is a parameter."""
        return self

    @property
    def constant(self) -> bool:
        return True

    def field(self, t: Any, xp: Any = np) -> Array:
        """The same (3,) vector in m/s², W, at all times."""
        return self.acceleration * unit(self.direction)


class Tracked(Effect):
    """An effect whose course may be a spline through the rows of a CSV file, which must cover the run."""

    columns: ClassVar[tuple[str, ...]]
    csv: FilePath | None = Field(None, description="a CSV file over t in s; relative to the scene file")

    @model_validator(mode="after")
    def _readable(self) -> Self:
        try:
            self.track  # noqa: B018  what is wrong with the file is said when the scene is read
        except InputError as error:
            raise ValueError(str(error)) from None
        return self

    @cached_property
    def track(self) -> Track | None:
        """What the csv holds. Raises InputError where it does not hold these columns."""
        return self._content

    @cached_property
    def _content(self) -> Track | None:
        if self.csv is None:
            return None
        with inside(shown_path(self.csv)):
            return read_track(self.csv, self.columns)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """As a record's; the file is read again only if the update names a csv."""
        if update and "csv" not in update:
            update = {**update, "_content": self._content}
        return super().model_copy(update=update, deep=deep)

    @property
    def _rows(self) -> Array | None:
        """The coefficients of the spline; None without a csv."""
        return self.track and self.track.spline.c

    @property
    def smooth(self) -> bool:
        """False for a spline, which has few derivatives at its rows."""
        return self.csv is None

    @property
    def symbolic(self) -> bool:
        """True: a spline is looked up in a table."""
        return True

    def with_numbers(self, numbers: Any) -> Self:
        """The same effect on other numbers; what a csv holds becomes a table."""
        if self.track is None:
            return super().with_numbers(numbers)
        return self.model_copy(update={"track": self.track.looked_up(numbers)})

    def check(self, begin: float, end: float) -> None:
        """Raises ValueError where the rows of the csv do not reach from `begin` to `end`, in s."""
        if self.csv and self.track and np.isnan(self.track.at(np.array([begin, end]))).any():
            first, last = self.track.ends
            times = f"its times, {first:.9g} to {last:.9g} s, do not cover the run, {begin:.9g} to {end:.9g} s"
            raise ValueError(f"{shown_path(self.csv)}: {times}")

    def since(self, start: float) -> tuple[Effect, float]:
        """The effect with its time counted from `start` in s: a track keeps all digits of its times."""
        if self.track is None:
            return super().since(start)
        return self.model_copy(update={"track": self.track.since(start)}), 0.0


class Support(Tracked, FrameEffect):
    """The pivot is moved: W, whose origin it is, travels over the ground without turning.

    position(t) = amplitude sin(frequency t + phase), in m, rad/s, rad; or a spline through the rows t, x, y, z, in s and
    m, of a CSV file, which must cover the run. Exact, by the equivalence of acceleration and gravity: everything feels
    the field -position''. Positions, velocities and energies of a run are relative to the pivot.
    """

    parameters: ClassVar[tuple[str, ...]] = ("amplitude", "frequency", "phase", "csv")
    strengths: ClassVar[tuple[str, ...]] = ("amplitude", "_rows")
    sinusoidal: ClassVar[bool] = True
    columns: ClassVar[tuple[str, ...]] = ("t", "x", "y", "z")
    kind: Literal["support"] = Field("support", description="which effect it is")
    amplitude: Vector | None = Field(None, description="m, in W")
    frequency: Positive | None = Field(None, description="rad/s")
    phase: Number = Field(0.0, description="rad")
    csv: FilePath | None = Field(None, description="columns t, x, y, z in s and m; relative to the scene file")

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if (self.amplitude is None) == (self.csv is None):
            raise ValueError("a support needs an amplitude and a frequency, or a csv")
        if (self.amplitude is None) != (self.frequency is None):
            raise ValueError("amplitude and frequency go together")
        if self.phase and self.amplitude is None:
            raise ValueError("a phase needs an amplitude and frequency")
        return self

    def position(self, t: Any, xp: Any = np) -> Array:
        """Where the pivot is, (3,) m in W's axes; times (n,) give (n, 3)."""
        return self._course(t, 0, xp)

    def velocity(self, t: Any, xp: Any = np) -> Array:
        return self._course(t, 1, xp)

    def acceleration(self, t: Any, xp: Any = np) -> Array:
        return self._course(t, 2, xp)

    def _course(self, t: Any, order: int, xp: Any) -> Array:
        """A derivative of the position with respect to time."""
        if self.track:
            return self.track.at(t, order)
        frequency, wave = self.frequency or 0.0, xp.cos if order == 1 else xp.sin
        factor = 1.0 if order == 0 else frequency if order == 1 else -(frequency**2)
        return np.multiply.outer(wave(frequency * t + self.phase), np.array(self.amplitude) * factor)


class Rotation(Tracked, BodyEffect):
    """W turns at the rate Omega about an axis through its origin at rest: Coriolis and centrifugal forces.

    The force on a mass element is -(2 Omega x v + Omega x (Omega x r)) dm. The sum over a rigid body is exact: F = -m (2
    Omega x v_G + Omega x (Omega x r_G)) and, about the centre of mass, M = (Omega + 2 omega) x (E Omega). The spread of
    mass is E = integral of r r^T dm = tr(I) / 2 - I (docs/effects.md derives it). Where the rate changes, Euler's force
    -m Omega' x r_G and the moment -I Omega' are added.

    latitude is in degrees, north positive, for the Earth with x east, y north, z up. In its place rate is Omega (3,) in
    rad/s in W; or csv has the rate about `axis` over time, in s and rad/s, and a spline goes through it, as for a crane that
    slews. Gravity turns with W. On the Earth, the centrifugal force at the pivot is part of the local gravity, and
    is not added again.
    """

    parameters: ClassVar[tuple[str, ...]] = ("latitude", "rate")
    strengths: ClassVar[tuple[str, ...]] = ("vector", "_rows")
    columns: ClassVar[tuple[str, ...]] = ("t", "rate")
    kind: Literal["rotation"] = Field("rotation", description="which effect it is")
    sole: ClassVar[str | None] = "W turns about one axis at one rate"
    latitude: Annotated[Number, Field(ge=-90, le=90)] | None = Field(None, description="degrees")
    rate: Vector | None = Field(None, description="rad/s, in W")
    axis: Direction | None = Field(None, description="direction in W of the rate in a csv, of any length but 0")

    @model_validator(mode="after")
    def _one_of_three(self) -> Self:
        if sum(given is not None for given in (self.latitude, self.rate, self.csv)) != 1:
            raise ValueError("a rotation needs a latitude, a rate or a csv, one of them")
        if (self.axis is None) != (self.csv is None):
            raise ValueError("csv and axis go together: a rate over time, and the direction in W about which W turns")
        return self

    @cached_property
    def track(self) -> Track | None:
        """Omega, (3,) rad/s, over time. Raises InputError where the csv does not hold a rate."""
        track = self._content
        return track if track is None or self.axis is None else track.along(unit(self.axis))

    def with_numbers(self, numbers: Any) -> Self:
        """The effect with Omega mapped by `numbers`."""
        if self.track is not None:
            return super().with_numbers(numbers)
        return self.model_copy(update={"latitude": None, "rate": numbers(self.vector)})

    @property
    def axial(self) -> bool:
        """False: inertial forces do not turn a thin rod about its axis."""
        return False

    @property
    def vector(self) -> Any:
        """Omega, (3,) in rad/s, in W; None where it changes with time."""
        if self.track is not None:
            return None
        if self.latitude is None:
            return np.array(self.rate)
        angle = self.latitude * (np.pi / 180)
        return EARTH * np.array([0.0, np.cos(angle), np.sin(angle)])

    def wrench(self, t: Any, bodies: Bodies, motion: Motion, xp: Any = np) -> tuple[Array, Array]:
        omega = motion.fixed(self.vector if self.track is None else self.track.at(t, 0))
        lever = motion.levers(bodies.com)
        r = motion.origin + lever + motion.fixed(motion.pivot)
        v = motion.velocity + cross(motion.spin, lever) + motion.fixed(motion.pivot_velocity)
        force = -bodies.mass[:, None] * cross(omega, 2 * v + cross(omega, r))
        moment = cross(omega + 2 * motion.spin, _spread(bodies, motion, omega))
        if self.track is None:
            return force, moment
        rising = motion.fixed(self.track.at(t, 1))  # Omega', on which I = tr(E) - E acts
        half_trace = np.trace(bodies.inertia, axis1=-2, axis2=-1)[:, None] / 2
        moment = moment - half_trace * rising + _spread(bodies, motion, rising)
        return force - bodies.mass[:, None] * cross(rising, r), moment

    def potential(self, bodies: Bodies, motion: Motion, xp: Any = np) -> Any:
        """Minus half the integral of |Omega x r|² dm, J, of the centrifugal force. None where the rate changes."""
        if (omega := self.vector) is None:
            return None
        at_com = cross(omega, motion.points(bodies.com) + motion.pivot)
        in_links = applied(motion.rotation.mT, omega[None])  # Omega in the link frames
        spread = (in_links * applied(bodies.inertia, in_links)).sum((-2, -1))
        return -((bodies.mass * (at_com**2).sum(-1)).sum(-1) + spread) / 2


def _spread(bodies: Bodies, motion: Motion, omega: Array) -> Array:
    """E Omega, (n, 3), of omega (3,) or (n, 3): E is the integral of r r^T dm about the centre of mass."""
    # It has no part across a thin rod.
    trace = np.trace(bodies.inertia, axis1=-2, axis2=-1)
    E = trace[:, None, None] / 2 * np.eye(3) - bodies.inertia
    R = motion.rotation
    return applied(R, applied(E, applied(R.mT, np.atleast_2d(omega))))
