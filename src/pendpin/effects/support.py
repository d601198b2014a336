"""Prescribed motion of the pivot."""

from functools import cached_property
from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from pendpin.effects.base import Effect, FrameEffect
from pendpin.effects.pace import Pace
from pendpin.effects.track import Track, read_track
from pendpin.errors import InputError, inside, place_of
from pendpin.ground.arrays import Array
from pendpin.ground.records import FilePath, Number, Positive, Vector


class Support(FrameEffect):
    """The pivot is moved: W, whose origin it is, travels over the ground without turning.

    position(t) = amplitude sin(frequency t + phase), in m, rad/s, rad; or a spline through the rows t, x, y, z, in s and
    m, of a CSV file, which must cover the run. Exact, by the equivalence of acceleration and gravity: everything feels
    the field -position''. Positions, velocities and energies of a run are relative to the pivot.
    """

    parameters: ClassVar[tuple[str, ...]] = ("amplitude", "frequency", "phase", "csv")
    strengths: ClassVar[tuple[str, ...]] = ("amplitude", "_rows")
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
        try:
            self.track  # noqa: B018  what is wrong with the file is said when the scene is read
        except InputError as error:
            raise ValueError(str(error)) from None
        return self

    @cached_property
    def track(self) -> Track | None:
        """The path of the csv. Raises InputError where the file does not hold one."""
        if self.csv is None:
            return None
        with inside(place_of(self.csv)):
            return read_track(self.csv)

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
        """As `Effect.with_numbers`; the path of a csv becomes a table."""
        if self.track is None:
            return super().with_numbers(numbers)
        return self.model_copy(update={"track": self.track.looked_up(numbers)})

    def check(self, begin: float, end: float) -> None:
        """Raises ValueError where the rows of the csv do not reach from `begin` to `end`, in s."""
        if self.csv and self.track and np.isnan(self.track.position(np.array([begin, end]))).any():
            raise ValueError(
                f"{place_of(self.csv)}: its times, {self.track.start:.9g} to {self.track.end:.9g} s, do not cover the run, "
                f"{begin:.9g} to {end:.9g} s"
            )

    def since(self, start: float) -> tuple[Effect, float]:
        """The support with its time counted from `start` in s: a track keeps all digits of its times."""
        if self.track is None:
            return super().since(start)
        return self.model_copy(update={"track": self.track.since(start)}), 0.0

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        """How fast it changes with time from `begin` to `end`, in s."""
        return self.track.pace(begin, end, negligible) if self.track else Pace.sinusoid(self.frequency)

    def position(self, t: Any, xp: Any = np) -> Array:
        """Where the pivot is, (3,) m in W's axes; times (n,) give (n, 3)."""
        if self.track:
            return self.track.position(t)
        return self._wave(xp.sin(self._angle(t)), 1.0)

    def velocity(self, t: Any, xp: Any = np) -> Array:
        """How it moves, (3,) m/s."""
        if self.track:
            return self.track.velocity(t)
        return self._wave(xp.cos(self._angle(t)), self.frequency)

    def acceleration(self, t: Any, xp: Any = np) -> Array:
        """How it accelerates, (3,) m/s²."""
        if self.track:
            return self.track.acceleration(t)
        return self._wave(xp.sin(self._angle(t)), -((self.frequency or 0.0) ** 2))

    def _angle(self, t: Any) -> Any:
        return (self.frequency or 0.0) * t + self.phase

    def _wave(self, value: Any, factor: Any) -> Array:
        """A function of time along the amplitude, (..., 3)."""
        return np.multiply.outer(value, np.array(self.amplitude) * factor)
