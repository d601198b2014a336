"""Scenes: what is simulated, as frozen, validated data; read from TOML, described by a JSON schema."""

import re
import tomllib
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, Self, get_args

import numpy as np
from pydantic import Discriminator, Field, SerializeAsAny, Tag, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticKnownError

from pendpin.arrays import Array
from pendpin.effects import AnyEffect, Gravity
from pendpin.equations.base import RodInertia
from pendpin.errors import InputError, choices, inside
from pendpin.files import read_whole
from pendpin.records import LARGEST_SIZE, NotNegative, Number, Positive, Record

AdaptiveMethod = Literal["dop853", "rk45", "rk23", "radau", "bdf", "lsoda"]
FixedMethod = Literal["gauss2", "gauss4", "gauss6", "rk4", "euler"]
Method = Literal["auto", AdaptiveMethod, "taylor", FixedMethod]

FIXED_METHODS = get_args(FixedMethod)
TOLERANCE = 1e-10  # unless another is given

MAX_SCENE_BYTES = 500_000  # more takes Python's TOML reader seconds
MAX_SAMPLES = 2_000_000
MAX_RODS = 100_000
_DEEP_KEY = re.compile(rb"""(?<![\w-])(?:(?:[\w-]+|["'][^"'\n]*["'])[ \t]*\.[ \t]*){50}""")
SAMPLES_PER_SECOND = 60

Size = Annotated[NotNegative, Field(le=LARGEST_SIZE)]


class Rod(Record):
    """A rod in its body frame B: b3 runs along it, from its joint to its tip.

    A uniform cylinder unless `com` or `inertia` say otherwise. Radius 0 is a thin rod; mass 0 with a payload is a
    point mass on a massless rod.
    """

    length: Annotated[Positive, Field(le=LARGEST_SIZE)]  # m
    mass: Size  # kg, without the payload
    radius: Size = 0.0  # m
    com: Annotated[Number, Field(ge=-LARGEST_SIZE, le=LARGEST_SIZE)] | None = Field(
        None, description="centre of mass from the joint along the rod, m; length/2 if absent"
    )
    inertia: tuple[Size, Size, Size] | None = Field(
        None, description="central principal inertia (I1, I2, I3), kg m², without the payload; a uniform rod if absent"
    )
    payload: Size = Field(0.0, description="point mass at the tip, kg")

    @cached_property
    def properties(self) -> RodInertia:
        """Mass, centre of mass and central inertia with the payload folded in (docs/derivation.md)."""
        m, p, length = self.mass, self.payload, self.length
        h = length / 2 if self.com is None else self.com
        transverse = m * (3 * self.radius**2 + length**2) / 12
        I1, I2, I3 = self.inertia or (transverse, transverse, m * self.radius**2 / 2)
        if not p:
            return RodInertia(m, h, I1, I2, I3)
        lever = m * (p / (m + p)) * (length - h) ** 2  # the reduced mass at the distance between the two
        return RodInertia(m + p, h + (length - h) * (p / (m + p)), I1 + lever, I2 + lever, I3)

    @property
    def impossible(self) -> str | None:
        """Why no real body has this inertia (one principal value above the sum of the others), or None."""
        small, middle, large = sorted(self.inertia or (1.0, 1.0, 1.0))
        if large <= (small + middle) * (1 + 1e-12):
            return None
        return f"no real body has this inertia, {large:g} > {small:g} + {middle:g}; the equations hold all the same"

    @model_validator(mode="after")
    def _has_inertia(self) -> Self:
        if self.mass + self.payload == 0:
            raise ValueError("a rod needs a mass or a payload above 0")
        if self.inertia and self.inertia[2] == 0 and self.inertia[0] != self.inertia[1]:
            raise ValueError(f"inertia {list(self.inertia)}: a rod with no inertia about its axis has I1 = I2")
        m, h, I1, I2, _ = self.properties
        about_joint = (I1 + m * h * h, I2 + m * h * h)
        if min(about_joint) < 1 / LARGEST_SIZE or max(about_joint) > LARGEST_SIZE:
            raise ValueError(
                f"the inertia about the joint, {min(about_joint):g} kg m², is out of range (1e-100 to 1e100): "
                "a rod needs a centre of mass away from its joint, or an inertia about it"
            )
        return self


class Chain(Record):
    """Rods hung one below the other, each on a universal joint at the tip of the one before."""

    kind: Literal["chain"] = "chain"
    rods: Annotated[tuple[Rod, ...], Field(min_length=1)]
    copies: Annotated[int, Field(strict=True, ge=1, le=100_000)] = 1

    @property
    def count(self) -> int:
        """How many rods there are with the copies."""
        return len(self.rods) * self.copies

    @property
    def all_rods(self) -> tuple[Rod, ...]:
        """The rods with the copies written out."""
        return self.rods * self.copies

    @model_validator(mode="after")
    def _not_too_many(self) -> Self:
        if self.count > MAX_RODS:
            raise ValueError(f"{self.count} rods, where {MAX_RODS} are the most")
        return self


class UrdfModel(Record):
    """Any URDF tree of revolute, continuous, prismatic and fixed joints."""

    kind: Literal["urdf"] = "urdf"
    path: Path


def _model_branch(value: Any) -> str:
    if isinstance(value, Chain | UrdfModel):
        return f"~{value.kind}"
    return f"~{value.get('kind', '')}" if isinstance(value, dict) else "~no table"


AnyModel = Annotated[Annotated[Chain, Tag("~chain")] | Annotated[UrdfModel, Tag("~urdf")], Discriminator(_model_branch)]
Values = Annotated[
    Annotated[dict[str, Number], Tag("~by name")] | Annotated[tuple[Number, ...], Tag("~in order")],
    Discriminator(lambda value: "~by name" if isinstance(value, dict) else "~in order"),
]


class Start(Record):
    """When and where the motion starts, by joint name (what is left out is 0) or as a full list in model order."""

    time: Number = Field(0.0, description="s; the run goes from here to time + duration")

    positions: Values = Field(default_factory=dict, description="rad, m for prismatic joints")
    velocities: Values = Field(default_factory=dict, description="rad/s, m/s for prismatic joints")


class Solver(Record):
    """How the scene is integrated and how often the motion is recorded.

    A method has a tolerance (relative and absolute, rad and rad/s) or, with fixed steps, a step. It is the largest that
    is taken: the time from sample to sample is cut into equal steps, so that every sample falls on one. An accuracy
    stands for both: the tolerance or step that meets it is found, and with method "auto" the method as well.
    """

    method: Method = "auto"
    engine: Literal["auto", "pinocchio", "chain", "compiled"] = "auto"
    accuracy: Annotated[Positive, Field(le=0.1)] | None = Field(
        None, description="the target: largest tip error over the run, over the chain's length"
    )
    tolerance: Annotated[Number, Field(le=0.1)] | None = Field(
        None, validate_default=True, description=f"for methods without a fixed step; {TOLERANCE:g} if none is given"
    )
    step: Positive | None = Field(
        None, validate_default=True, description=f"s, for methods with a fixed step: {', '.join(FIXED_METHODS)}"
    )
    samples: Annotated[int, Field(strict=True, ge=1, le=MAX_SAMPLES)] | None = Field(
        None, description="evenly spaced output times from 0 to duration, both ends included; 60 a second if absent"
    )

    @field_validator("tolerance")
    @classmethod
    def _tolerance_of(cls, tolerance: float | None, given: ValidationInfo) -> float | None:
        method = given.data.get("method", "")
        if given.data.get("accuracy") is not None:
            return _none_beside_accuracy(tolerance)
        if method in FIXED_METHODS:
            if tolerance is not None:
                raise ValueError(f"{method} takes a step, not a tolerance")
            return None
        least = least_tolerance(method)
        if tolerance is not None and tolerance < least:
            raise PydanticKnownError("greater_than_equal", {"ge": least})
        return TOLERANCE if tolerance is None else tolerance

    @field_validator("step")
    @classmethod
    def _step_of(cls, step: float | None, given: ValidationInfo) -> float | None:
        method = given.data.get("method", "")
        if given.data.get("accuracy") is not None:
            return _none_beside_accuracy(step)
        if method in FIXED_METHODS and step is None:
            raise ValueError(f"{method} takes a step, in s")
        if step is not None and method and method not in FIXED_METHODS:
            raise ValueError(f"{method} takes a tolerance, not a step; these take a step: {choices(FIXED_METHODS)}")
        return step

    def replaced(self, **given: Any) -> Self:
        """The solver with other settings; of its own accuracy, tolerance and step those that no longer fit are left out."""
        method = given.get("method", self.method)
        unfit = {"tolerance" if method in FIXED_METHODS else "step"}
        if "accuracy" in given:
            unfit = {"tolerance", "step"}
        elif "tolerance" in given or "step" in given:
            unfit |= {"accuracy"}
        own = {name: value for name, value in self.model_dump().items() if value is not None and name not in unfit}
        return type(self)(**(own | given))


def least_tolerance(method: str) -> float:
    """The smallest tolerance that a method takes."""
    return 1e-18 if method == "taylor" else 1e-14


def _none_beside_accuracy(value: float | None) -> None:
    if value is not None:
        raise ValueError("accuracy is given, so that this is found; leave one of them out")


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
        count = self.solver.samples or round(SAMPLES_PER_SECOND * self.duration) + 1
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
    installed = Path(__file__).parent / "urdf"
    return installed if installed.is_dir() else Path(__file__).parents[2] / "urdf"


def load_scene(path: str | Path) -> Scene:
    """Read a scene from a TOML file; the files that it names are relative to that file. Raises InputError."""
    path = Path(path)
    with inside(str(path)):
        raw = _read_toml(path)
        raw |= {"model": _placed(raw["model"], "path", path.parent)} if "model" in raw else {}
        if isinstance(raw.get("effects"), list):
            raw["effects"] = [_placed(effect, "csv", path.parent) for effect in raw["effects"]]
        try:
            return Scene(**raw)
        except InputError as error:  # the file's name says enough
            raise InputError(str(error).removeprefix("Scene: ")) from None


def _placed(table: Any, key: str, folder: Path) -> Any:
    """A table whose `key` names a file relative to `folder`, with the whole path; anything else as it is."""
    if isinstance(table, dict) and isinstance(table.get(key), str):
        return table | {key: str(folder / table[key])}
    return table


def _read_toml(path: Path) -> dict[str, Any]:
    data = read_whole(path, MAX_SCENE_BYTES, "a scene")
    if data.lstrip().startswith(b"<"):
        raise InputError("not a TOML scene but XML; a scene names a URDF as [model] kind and path")
    if _DEEP_KEY.search(data):  # Python's TOML reader would take minutes
        raise InputError("not a scene: keys are nested too deep")
    try:
        return tomllib.loads(data.decode("utf-8-sig"))  # a mark at the start, as some editors write, is no fault
    except UnicodeDecodeError as error:
        raise InputError(f"not a TOML file: byte {error.start} is not UTF-8 text") from None
    except RecursionError:
        raise InputError("not a scene: values are nested too deep") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"not a TOML file: {error}") from None
    except ValueError:  # Python's own limit
        raise InputError("not a scene: a whole number has thousands of digits") from None
