"""A scene: what is simulated, as frozen, validated data, described by a JSON schema."""

from pathlib import Path
from typing import Self

import numpy as np
from pydantic import SerializeAsAny, model_validator

from pendpin.arrays import Array
from pendpin.effects import AnyEffect, Gravity
from pendpin.records import NotNegative, Record
from pendpin.scene.models import AnyModel, UrdfModel
from pendpin.scene.solver import FIXED_METHODS, MAX_SAMPLES, Solver
from pendpin.scene.start import Start

SAMPLES_PER_SECOND = 60


class Scene(Record):
    """A model, where it starts, the effects that act on it, and for how long. No effect is on unless it is listed."""

    duration: NotNegative = 10.0  # s
    model: AnyModel
    start: Start = Start()
    effects: tuple[SerializeAsAny[AnyEffect], ...] = ()
    solver: Solver = Solver()

    @property
    def times(self) -> Array:
        """The output times, (n,) in s since the start: evenly spaced from 0 to duration, both ends included."""
        least = 2 if self.duration else 1
        count = self.solver.samples or max(least, round(SAMPLES_PER_SECOND * self.duration) + 1)
        return np.linspace(0.0, self.duration, count)

    def by(self, method: str, setting: float) -> Self:
        """The scene with a method and its setting, a tolerance or a step. Raises InputError where they do not fit."""
        name = "step" if method in FIXED_METHODS else "tolerance"
        return self.model_copy(update={"solver": self.solver.replaced(method=method, **{name: setting})})

    @model_validator(mode="after")
    def _samples_fit(self) -> Self:
        if self.solver.samples is None and self.duration * SAMPLES_PER_SECOND >= MAX_SAMPLES:
            raise ValueError(
                f"{self.duration:g} s at 60 samples a second are more than {MAX_SAMPLES}; set solver.samples"
            )
        if self.duration == 0 and (self.solver.samples or 1) > 1:
            raise ValueError("a duration of 0 has 1 sample; leave solver.samples out")
        if self.duration and self.solver.samples == 1:
            raise ValueError("solver.samples: 1 is the start alone; a run has 2 or more, or a duration of 0")
        if (np.diff(self.start.time + self.times) <= 0).any():
            raise ValueError(f"start.time: samples so close together are the same double at {self.start.time:g} s")
        return self

    @model_validator(mode="after")
    def _effects_last(self) -> Self:
        for i, effect in enumerate(self.effects):
            try:
                effect.check(self.start.time, self.start.time + self.duration)
            except ValueError as error:
                raise ValueError(f"effects[{i}]: {error}") from None
        return self


def builtin_scene() -> Scene:
    """The scene of a command that is given none: the rod of urdf/universal_rod.urdf under gravity, 10 s."""
    return Scene(
        duration=10.0,
        model=UrdfModel(path=urdf_folder() / "universal_rod.urdf"),
        start=Start(positions={"theta": 0.7, "phi": 0.4}, velocities={"theta": 1.3, "phi": -0.8}),
        effects=(Gravity(),),
    )


def urdf_folder() -> Path:
    """Where the URDFs that come with pendpin are: in the installed package, or at the top of a checkout."""
    installed = Path(__file__).parents[1] / "urdf"
    return installed if installed.is_dir() else Path(__file__).parents[3] / "urdf"
