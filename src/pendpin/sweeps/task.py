"""What a sweep is: a scene, the cases, the measures; and what is refused before anything is run."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pendpin.errors import InputError, RunError, inside, shown
from pendpin.ground.arrays import Array
from pendpin.ground.libraries import VERSION, installed
from pendpin.motions.trajectory import Trajectory
from pendpin.runs.simulate import run_to_setting
from pendpin.scene import Scene, unit_of_key
from pendpin.sweeps.measures import Function, Measure, measure
from pendpin.sweeps.plan import RESERVED, Plan, short_names
from pendpin.trajectory.columns import unit_of

TRIED = 33  # cases, at most, until one has numbers that can be had
LOOSER = 100.0  # times the tolerance, for what compares two runs
LIBRARIES = ("pin", "numpy", "scipy", "CyRK", "heyoka")
EXTRA = "xarray zarr cloudpickle dask distributed"  # the libraries of a sweep
LARGEST_COUNT = 2.0**53


@dataclass(frozen=True, eq=False)
class Task:
    """A sweep, as it is given to whoever runs a part of it."""

    scene: Scene
    plan: Plan
    measures: tuple[str | Function, ...]
    units: Mapping[str, str] = field(default_factory=dict)  # of varied numbers and measures, where they have one

    @cached_property
    def chosen(self) -> tuple[Measure, ...]:
        """The measures."""
        return tuple(measure(given) for given in self.measures)

    @cached_property
    def columns(self) -> list[slice]:
        """Where the numbers of each measure are in a row of all of them."""
        ends = np.cumsum([m.size for m in self.chosen]).tolist()
        return [slice(end - m.size, end) for m, end in zip(self.chosen, ends, strict=True)]

    @property
    def two(self) -> bool:
        """Whether a measure compares two runs."""
        return any(m.two for m in self.chosen)

    def __getstate__(self) -> dict:
        """What is sent to another process: what is given, and nothing that follows from it."""
        return {"scene": self.scene, "plan": self.plan, "measures": self.measures, "units": self.units}

    def __setstate__(self, state: dict) -> None:
        self.__dict__.update(state)


class Block(NamedTuple):
    """The measures of c cases."""

    values: Array  # (c, numbers of all measures); NaN where a case could not be run or has none
    why: Array  # (c,) of text: why a case could not be run, "" where it could

    @classmethod
    def empty(cls, cases: int, numbers: int) -> "Block":
        """Without any measure yet."""
        return cls(np.full((cases, numbers), np.nan), np.full(cases, "", dtype=object))


def versions() -> dict[str, str | None]:
    """The versions on which the bits of a result depend."""
    return {"pendpin": VERSION} | installed(*LIBRARIES)


def checked(task: Task) -> Task:
    """The task with its units. Raises InputError for keys or measures that no case could have."""
    scene, names = typical(task), [m.name for m in task.chosen]
    varied = dict(zip(short_names(task.plan.keys), task.plan.keys, strict=True))
    units = {name: unit for name, key in varied.items() if (unit := unit_of_key(key, scene))}
    units |= {m.name: m.unit for m in task.chosen if m.unit}
    for i, name in enumerate(names):
        if name in names[:i] or name in RESERVED or name in varied:
            why = (
                "given twice; give one of them as a function of another name"
                if name in names[:i]
                else "a name of the result"
            )
            raise InputError(f"measure: {name} is {why}")
        if not name or name.startswith((".", "__")) or "/" in name:
            raise InputError(f"measure: {shown(name)} cannot name a variable: give the function another __name__")
    lengths = dict[str, int]()
    for dimension, length in (pair for m in task.chosen for pair in m.dims):
        if lengths.setdefault(dimension, length) != length or dimension in varied or dimension in RESERVED:
            raise InputError(
                f"measure: two dimensions are called {dimension}; give one of them another name, or both one length"
            )
    if series := {m.name: m.series for m in task.chosen if m.series}:
        at_start = {"duration": 0.0, "solver": scene.solver.model_copy(update={"samples": None, "times": None})}
        try:
            run = Trajectory.of(run_to_setting(scene.model_copy(update=at_start)))
        except RunError:
            return replace(task, units=units)  # every case will say why
        with inside("measure"):
            units = {name: unit_of(run, quantity) for name, quantity in series.items() if len(run[quantity])} | units
    return replace(task, units=units)


def typical(task: Task) -> Scene:
    """The scene of a case whose numbers can be had: the last one, else one before. Raises InputError if there is none."""
    places, errors = np.unique(np.linspace(0, task.plan.count - 1, TRIED).astype(int))[::-1], list[InputError]()
    for row in task.plan.rows(places):
        try:
            return set_numbers(task.scene, task.plan.keys, row)
        except InputError as error:
            errors.append(error)
    raise errors[-1]


def set_numbers(scene: Scene, keys: Sequence[str], row: Array) -> Scene:
    """The scene with these numbers (keys,) at their key paths. Raises InputError for a key that names no number."""
    whole = [int(x) if x.is_integer() and abs(x) < LARGEST_COUNT else x for x in row.tolist()]  # a count takes no float
    try:
        return scene.replace(dict(zip(keys, whole, strict=True)))
    except InputError as error:
        raise InputError(str(error).removeprefix("Scene: ")) from None
