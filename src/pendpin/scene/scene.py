"""A scene: what is simulated, as frozen, validated data, described by a JSON schema."""

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, SerializeAsAny, Tag, model_validator
from pydantic_core import PydanticSerializationError

from pendpin.effects import AnyEffect, Effect, Gravity, has_kind
from pendpin.errors import InputError, KeyPath, inside, shown, written
from pendpin.ground.arguments import nested, parsed
from pendpin.ground.arrays import Array
from pendpin.ground.files import folder_of, path_of, write_whole
from pendpin.ground.records import FrozenDict, NotNegative, Number, Positive, Record
from pendpin.scene.methods import MAX_SAMPLES, Solver, fixed_methods
from pendpin.scene.models import AnyModel, UrdfModel
from pendpin.scene.toml import MAX_SCENE_BYTES, example_names, read_toml, scene_text

Values = Annotated[
    Annotated[dict[str, Number], AfterValidator(FrozenDict), Tag("~by name")]
    | Annotated[tuple[Number, ...], Tag("~in order")],
    Discriminator(lambda value: "~by name" if isinstance(value, dict | set) else "~in order"),  # a set has no order
]


class Start(Record):
    """When and where the motion starts, by joint name (what is left out is 0) or as a full list in model order."""

    time: Number = Field(0.0, description="s; the run goes from here to time + duration")
    positions: Values = Field(default_factory=FrozenDict, description="rad, or degrees; m for prismatic joints")
    velocities: Values = Field(default_factory=FrozenDict, description="rad/s, or degrees/s; m/s for prismatic joints")
    unit: Literal["radians", "degrees"] = Field("radians", description="of the angles and their rates")

    @classmethod
    def at_state(cls, time: float, q: Array, v: Array) -> Self:
        """The start at a time in s from positions and velocities (nv,), rad and rad/s (m and m/s for slides)."""
        return cls(time=time, positions=tuple(q.tolist()), velocities=tuple(v.tolist()))

    def __eq__(self, other: object) -> bool:
        """Whether both hold the same values; pendpin.Start, a subclass with constructors, equals this record."""
        return isinstance(other, Start) and vars(self) == vars(other)

    def __hash__(self) -> int:
        return hash((self.time, self.positions, self.velocities, self.unit))


_Measured = Annotated[
    Annotated[tuple[str, ...], Tag("~joints")] | Annotated[str, Tag("~tip")],
    Discriminator(lambda given: "~tip" if isinstance(given, str) else "~joints"),
]
_Offsets = Annotated[
    Annotated[Literal["free", "zero"], Tag("~word")]
    | Annotated[dict[str, Number], AfterValidator(FrozenDict), Tag("~table")],
    Discriminator(lambda given: "~table" if isinstance(given, dict) else "~word"),
]


class Data(Record):
    """How measured swings are read from a CSV file, for a fit: which column measures what.

    A column measures the sum of the joints listed (an absolute angle is a sum), or one coordinate of a tip in W, in m,
    as "rod_1.y". Each column has a zero of its own, which the fit finds unless `offsets` says otherwise.
    """

    time: str = Field("t", description="the column of times, s")
    segment: str | None = Field(None, description="the column that tells independent swings apart; one swing if absent")
    columns: Annotated[dict[str, _Measured], Field(min_length=1), AfterValidator(FrozenDict)] = Field(
        description='by column: the joints whose angles add up to it, or the coordinate of a tip, as "rod_1.y"'
    )
    unit: Literal["radians", "degrees"] = Field("radians", description="of the angles")
    offsets: _Offsets = Field("free", description="zeros of the columns: free, zero, or each in `unit` (m for tips)")
    noise: Positive | None = Field(None, description="rad, standard deviation of the sensors; estimated if absent")

    def in_si(self, column: str) -> tuple[float, str]:
        """What one of the column's unit is in rad or m, and the name of its unit."""
        if isinstance(self.columns[column], str):
            return 1.0, "m"
        return (math.pi / 180, "degrees") if self.unit == "degrees" else (1.0, "rad")


SAMPLES_PER_SECOND = 60


class Scene(Record):
    """A model, its start, the effects that act on it, and a duration. Only listed effects act."""

    title: str = Field("", description="what figures and pages call it; what moves and what acts if absent")
    duration: NotNegative = Field(10.0, description="s")
    model: AnyModel = Field(description="what moves: a chain of rods, a URDF")
    start: Start = Field(Start(), description="when, where and how fast the motion starts; at rest at 0 if absent")
    effects: tuple[SerializeAsAny[AnyEffect], ...] = Field((), description="what acts; nothing if absent")
    solver: Solver = Field(Solver(), description="how the motion is integrated and recorded")
    data: Data | None = Field(None, description="how measured swings are read, for a fit; none if absent")

    @property
    def times(self) -> Array:
        """The times at which the motion is recorded, (n,) in s since the start, from 0.

        Evenly spaced from 0 to duration, both ends included; or solver.times, after 0 where they leave it out.
        """
        if self.solver.times is not None:
            return self.clock - self.start.time
        least = 2 if self.duration else 1
        count = self.solver.samples or max(least, round(SAMPLES_PER_SECOND * self.duration) + 1)
        return np.linspace(0.0, self.duration, count)

    @property
    def clock(self) -> Array:
        """The same times in the scene's own time, which begins at start.time, (n,) in s."""
        if self.solver.times is not None:
            return np.concatenate([[self.start.time] * self.extra_samples, self.solver.times])
        return self.start.time + self.times

    @property
    def extra_samples(self) -> int:
        """How many of the times, at the start, are not among those asked for (0 or 1)."""
        return int(self.solver.times is not None and self.solver.times[0] != self.start.time)

    def replace(self, changes: Mapping[str, Any] | None = None, /, **fields: Any) -> Self:
        """The scene with other values: by key path, `{"model.rods[0].mass": 2.0}`, and by field, `duration=5.0`.

        It is checked like a new scene. Raises InputError as the constructor does, and for a path that leads nowhere.
        """
        data = self.given() | fields
        if not isinstance(changes, Mapping | None):
            reason = f"changes: {shown(changes)} is not a mapping of key paths to values; or write duration=5.0"
            raise InputError(reason)
        for path, value in (changes or {}).items():
            name, *rest = parsed(path)
            first = str(name)
            where = {} if first in Scene.model_fields else self.model_dump()
            if places := [place for place, _ in nested(where) if place[-1] == first]:
                others = f" (or {len(places) - 1} more of that name)" * (len(places) > 1)
                raise InputError(f"{path}: unknown key; did you mean {written((*places[0], *rest))}{others}?")
            before = data.get(first, getattr(self, first) if first in Scene.model_fields else None)
            data[first] = changed(before, tuple(rest), value, (first,)) if first in Scene.model_fields else value
        return type(self)(**data)

    def save(self, path: str | Path) -> Path:
        """Write the scene to a TOML file, from which load_scene reads an equal one; whole or not at all.

        Raises InputError where the path refuses, and for a function or an effect of one's own, which TOML cannot hold.
        """
        path = path_of(path)
        with inside(str(path)):
            text = scene_text(self, path.absolute().parent).encode("utf-8", "surrogatepass")
            if len(text) > MAX_SCENE_BYTES:
                most = f"a scene file has {MAX_SCENE_BYTES / 1e6:g} at most"
                raise InputError(f"this scene needs {len(text) / 1e6:.3g} MB; {most}")
        return write_whole(path, lambda file: file.write(text))

    def recorded(self) -> dict[str, Any]:
        """The scene as the plain data that a run is saved with. Raises InputError if a file cannot hold it."""
        try:
            return self.model_dump(mode="json")
        except PydanticSerializationError:
            pass
        for i, effect in enumerate(self.effects):
            for name in type(effect).model_fields:
                try:
                    effect.model_dump(mode="json", include={name})
                except PydanticSerializationError:
                    kind = type(getattr(effect, name)).__name__
                    remedy = f"give {type(effect).__name__} a field_serializer for it (pydantic)"
                    raise InputError(f"effects[{i}].{name}: a {kind} cannot be saved with the run: {remedy}") from None
        raise InputError("scene: it holds what no file can")

    def by(self, method: str, setting: float) -> Self:
        """The scene with a method and its setting, a tolerance or a step. Raises InputError where they do not fit."""
        return self.with_solver(method=method, **{"step" if method in fixed_methods() else "tolerance": setting})

    def with_solver(self, **settings: Any) -> Self:
        """The scene with other settings of its solver (Solver.with_settings)."""
        return self.model_copy(update={"solver": self.solver.with_settings(**settings)})

    def sampled(
        self, samples: int | None, times: tuple[float, ...] | None = None, duration: float | None = None
    ) -> Self:
        """The scene with other output times, and another duration in s if given; nothing is checked again."""
        solver = self.solver.model_copy(update={"samples": samples, "times": times})
        return self.model_copy(update={"solver": solver, "duration": self.duration if duration is None else duration})

    @model_validator(mode="after")
    def _samples_fit(self) -> Self:
        if self.solver.times is not None:
            begin, end = self.start.time, self.start.time + self.duration
            for t in (self.solver.times[0], self.solver.times[-1]):
                if not 0 <= t - begin <= self.duration:
                    raise ValueError(f"solver.times: {t:.15g} s is outside the run, {begin:.15g} to {end:.15g} s")
        elif self.solver.samples is None and self.duration * SAMPLES_PER_SECOND >= MAX_SAMPLES:
            reason = f"{self.duration:g} s at 60 samples a second are more than {MAX_SAMPLES}; set solver.samples"
            raise ValueError(reason)
        if self.duration == 0 and (self.solver.samples or 1) > 1:
            raise ValueError("a duration of 0 has 1 sample; leave solver.samples out")
        if self.duration and self.solver.samples == 1:
            raise ValueError("solver.samples: 1 is the start alone; a run has 2 or more, or a duration of 0")
        if (np.diff(self.clock) <= 0).any():
            reason = f"start.time: two samples are the same double at {self.start.time:g} s; take fewer samples"
            raise ValueError(reason)
        self.refuse_short_effects()
        return self

    def refuse_short_effects(self) -> None:
        """Raise ValueError for an effect that ends before the run, as a file of positions: a copy may last longer."""
        for i, effect in enumerate(self.effects):
            try:
                effect.check(self.start.time, self.start.time + self.duration)
            except ValueError as error:
                raise ValueError(f"effects[{i}]: {error}") from None


def builtin_scene() -> Scene:
    """The scene of a command that is given none: the rod of urdf/universal_rod.urdf under gravity, 10 s."""
    return Scene(
        title="A rod on a universal joint",
        duration=10.0,
        model=UrdfModel(path=folder_of("urdf") / "universal_rod.urdf"),
        start=Start(positions={"theta": 0.7, "phi": 0.4}, velocities={"theta": 1.3, "phi": -0.8}),
        effects=(Gravity(),),
    )


def changed(value: Any, path: KeyPath, new: Any, place: KeyPath = ()) -> Any:
    """Nested data with one value replaced; records on the way become tables. InputError where the path leads nowhere."""
    if not path:
        return new
    key, rest = path[0], path[1:]
    here = (*place, key)
    if isinstance(value, Record | dict) and isinstance(key, int):
        raise InputError(f"{written(here)}: {written(place)} is a table of names, not a list")
    if isinstance(value, Record):
        if key in type(value).model_fields:
            new = changed(getattr(value, str(key)), rest, new, here)
        fields = value.given() | {str(key): new}
        if not isinstance(value, Effect) or has_kind(value):
            return fields
        with inside(written(place)):
            return type(value)(**fields)  # of a user's own class: no table could name it
    if isinstance(value, dict):
        return value | {key: changed(value.get(key), rest, new, here)}
    if isinstance(value, tuple | list):
        if not isinstance(key, int) or key >= len(value):
            there = f"from [0] to [{len(value) - 1}]" if len(value) > 1 else "[0] alone" if value else "empty"
            raise InputError(f"{written(here)}: {written(place)} is a list of {len(value)}: {there}")
        return [*value[:key], changed(value[key], rest, new, here), *value[key + 1 :]]
    if value is None and isinstance(key, str):  # a table that was left out
        return {key: changed(None, rest, new, here)}
    why = "nothing is given there" if value is None else f"{value!r} has no parts"
    raise InputError(f"{written(here)}: {written(place)}: {why}; set {written(place)} as a whole")


# --- scenes from TOML files and from runs ---------------------------------------------------------------------------


def load_scene(path: str | Path) -> Scene:
    """Read a scene from a TOML file; the files that it names are relative to that file. Raises InputError."""
    path = path_of(path)
    if str(path) in example_names() and not path.exists():
        raise InputError(f"{path}: no such file; `pendpin new {path} > {path}.toml` writes the example of that name")
    with inside(str(path)):
        raw = read_toml(path)
        if not raw:
            raise InputError("it is empty; `pendpin new` prints a scene to start from")
        try:
            return Scene(**raw)
        except InputError as error:  # the file's name says enough
            raise InputError(str(error).removeprefix("Scene: ")) from None


def chosen_scene(scene_or_path: Scene | str | Path) -> Scene:
    """A scene as it is, or that of a file. Raises InputError for anything else."""
    scene = load_scene(scene_or_path) if isinstance(scene_or_path, str | Path) else scene_or_path
    if not isinstance(scene, Scene):
        raise InputError(f"scene: {shown(scene_or_path)} is not a Scene, nor the path of a scene file")
    return scene


def scene_of(run: Any) -> Scene:
    """The scene of a run. Raises InputError where a saved run's scene holds what no file can."""
    if isinstance(run.source, Scene):
        return run.source
    try:
        return Scene(**run.scene)
    except InputError as error:
        advice = "give it, as Trajectory.load(path, scene=scene)"
        raise InputError(f"the run's scene cannot be built again: {error}; {advice}") from None


# --- the units of a scene's numbers ---------------------------------------------------------------------------------

# the unit with which the description of a field begins, such as "m" in "m, from the joint to the tip"
_UNIT = re.compile(r"(?:kg|m|s|N|rad|degrees)[²³]?(?:[ /](?:kg|m|s|N|rad)[²³]?)*(?!\w)")


def unit_of_key(key: str, scene: Scene) -> str:
    """The unit of a number at a key path, as the description of its field says it; "" where that has none."""
    unit, value = "", scene
    for part in parsed(key):
        if isinstance(value, Record) and part in type(value).model_fields:
            given = _UNIT.match(type(value).model_fields[part].description or "")
            unit, value = given[0] if given else "", getattr(value, part)
        elif isinstance(value, tuple) and isinstance(part, int) and part < len(value):
            value = value[part]
    in_degrees = key.startswith("start.") and scene.start.unit == "degrees"
    return unit.replace("rad", "degrees") if in_degrees else unit
