"""Published cases as data: where the numbers come from, the scene that should give them, and how they are compared."""

import tomllib
from functools import cache
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from pendpin.dynamics.vibrations import matrices, vibrations
from pendpin.errors import InputError, inside, not_one_of
from pendpin.ground.arrays import Array
from pendpin.ground.keypaths import number_at
from pendpin.ground.records import Number, Positive, Record
from pendpin.model import kinematics
from pendpin.model.build import build, start_state
from pendpin.motions.periodic import periodic_orbit
from pendpin.motions.trajectory import Trajectory
from pendpin.scene import Scene

FOLDER = Path(__file__).parent / "cases"
WINDOW = 0.02  # of a published bound of stability: where the verdict is looked for to change
HALVINGS = 40  # of that window: 2e-2 to a rounding


class Published(Record):
    """What a published quantity needs in any case."""

    name: str = Field(description="what the source publishes")
    unit: str = Field(description="its unit")
    bound: Positive = Field(description="in that unit: how far the published numbers themselves may be off")
    because: str = Field(description="where the bound comes from")


class Frequencies(Published):
    """Natural frequencies in rad/s of small motions about the scene's start, a rest."""

    values: tuple[Number, ...] = Field(description="the published numbers, rising")
    every: int = Field(1, description="how many modes share each of them: 2 where both directions are alike")

    def compute(self, scene: Scene) -> Array:
        """The lowest natural frequencies of the scene, as many as are published."""
        q, v = start_state(build(scene.model), scene.start)
        omega = vibrations(matrices(scene, q, v, np.zeros(len(q)))).omega
        return omega[:: self.every][: len(self.values)]


class StabilityBounds(Published):
    """Values of a number of the scene at which its periodic motion becomes stable, or unstable."""

    values: tuple[Number, ...] = Field(description="the published numbers, rising")
    key: str = Field(description="the key path of the number")

    def compute(self, scene: Scene) -> Array:
        """Where the multipliers of the scene's motion leave the unit circle, next to each published value."""
        number_at(scene, self.key)

        def is_stable(value: float) -> bool:
            return periodic_orbit(scene.replace({self.key: value})).stable

        def find_change(value: float) -> float:
            low, high = (1 - WINDOW) * value, (1 + WINDOW) * value
            before, after = is_stable(low), is_stable(high)
            if before == after:
                return float("nan")  # no change of stability is near
            for _ in range(HALVINGS):
                middle = (low + high) / 2
                low, high = (middle, high) if is_stable(middle) == before else (low, middle)
            return (low + high) / 2

        return np.array([find_change(value) for value in self.values])


class Quantity(Published):
    """One published quantity: what it is in a run, in whose axes, and its values at some times."""

    of: Literal["angle", "rate", "centre of mass", "tip", "force", "moment"] = Field(description="what it is in a run")
    at: str = Field(description="the joint of an angle, rate, force or moment; the link of a centre of mass or tip")
    frame: Literal["world", "parent", "child"] = Field("world", description="of forces and moments")
    on: Literal["child", "parent"] = Field("child", description="what a force or moment acts on")
    axes: tuple[tuple[Number, Number, Number], ...] = Field(
        ((1, 0, 0), (0, 1, 0), (0, 0, 1)), description="the source's axes, in pendpin's frame"
    )
    offset: Number = Field(0.0, description="added to an angle, rad")
    columns: tuple[str, ...] = Field(description="the source's names of the components")
    values: tuple[tuple[Number, ...], ...] = Field(description="rows: the time in s, then a number for each column")

    @property
    def times(self) -> Array:
        """When the values were published, (k,) s."""
        return np.array(self.values)[:, 0]

    @property
    def published(self) -> Array:
        """The published numbers (k, columns)."""
        return np.array(self.values)[:, 1:]

    def observed(self, run: Trajectory) -> Array:
        """The same quantity of a run at its samples, in the source's axes: (n, columns)."""
        axes = np.array(self.axes, float)
        match self.of:
            case "angle":
                return run[self.at][:, None] + self.offset
            case "rate":
                return run[f"{self.at}_rate"][:, None]
            case "force":
                return run.express(self.at, self.frame, on=self.on)[:, :3] @ axes.T
            case "moment":
                return run.express(self.at, self.frame, on=self.on)[:, 3:] @ axes.T
            case _:
                return _place(run, self.at, self.of) @ axes.T


def _place(run: Trajectory, link: str, of: str) -> Array:
    """The centre of mass or the tip of a link, (n, 3) m in W."""
    model = build(run.source.model)
    names = [body.link for body in model.bodies]
    if link not in names:
        raise InputError(f"at: {not_one_of(link, names)}")
    body = model.bodies[names.index(link)]
    point = np.array([*(body.tip if of == "tip" else body.com), 1.0])
    return kinematics.poses(model, run.q)[:, names.index(link), :3] @ point


class Case(Record):
    """A published case: its source, its scene and what is compared."""

    title: str = Field(description="the motion in a few words")
    source: str = Field(description="the citation, with its repository and file or its pages")
    origin: str = Field(description="which program or formula gave the numbers")
    note: str = Field("", description="what is particular about the case")
    settings: dict[str, Positive] = Field(default_factory=dict, description="tolerances and steps other than the usual")
    leave_out: dict[str, str] = Field(
        default_factory=dict, description="methods that cannot run it, each with the reason"
    )
    accuracy: Annotated[Positive, Field(le=0.1)] = Field(
        1e-9, description="the target of the run whose own claim is tested"
    )
    scene: Scene = Field(description="the scene whose run is compared")
    quantities: tuple[Quantity, ...] = Field((), description="what is compared along the motion")
    frequencies: tuple[Frequencies, ...] = Field((), description="natural frequencies that are compared")
    stability: tuple[StabilityBounds, ...] = Field((), description="bounds of stability that are compared")

    @model_validator(mode="after")
    def _something_is_compared(self) -> Self:
        if not (self.quantities or self.frequencies or self.stability):
            raise ValueError("nothing is compared: give quantities, frequencies or stability")
        return self

    @property
    def times(self) -> tuple[float, ...]:
        """The start, and every time at which something was published, s."""
        published = np.concatenate([[0.0], *(quantity.times for quantity in self.quantities)])
        return tuple(np.unique(published).tolist())


@cache
def published_cases() -> dict[str, Case]:
    """All cases, by the names of their files."""
    return {path.stem: read_case(path) for path in sorted(FOLDER.glob("*.toml"))}


def read_case(path: Path) -> Case:
    """The case in a TOML file; a URDF that its scene names is relative to the file. Raises InputError."""
    raw = tomllib.loads(path.read_text(encoding="utf-8"))
    model = raw["scene"]["model"]
    if "path" in model:
        model["path"] = path.parent / model["path"]
    with inside(path.name):
        return Case(**raw)
