"""Hard cases: the record of a case, and the scenes and measures that families of cases share."""

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.effects import Effect, Gravity
from pendpin.errors import InputError, Interrupted, RunError
from pendpin.ground.arrays import Array
from pendpin.motions.trajectory import Trajectory
from pendpin.scene import Chain, Rod, Scene, Solver, Start, fixed_methods

Solve = Callable[[Scene], Trajectory]
Settings = Mapping[str, float]  # tolerance, or step in s
Measure = Callable[[Solve, bool], float]  # of the full form, or of the short one

G = 9.81  # m/s²
THIN = Chain(rods=(Rod(length=1.0, mass=1.0),))
ROD = Rod(length=1.0, mass=1.0, radius=0.05)
THICK = Chain(rods=(ROD,))
REDUCED = 2 / 3  # m, of the uniform thin rod of 1 m
SWING = float(np.sqrt(G / REDUCED))  # rad/s, its small swings, and the rate at which it leaves the upright


@dataclass(frozen=True)
class Case:
    """One hard case. `measure` solves its scenes, in the full or the short form, and returns the figure that is compared
    with `bound`; `beside` returns the same figure for other algorithms, which make no claim."""

    name: str
    group: int  # of GROUPS
    title: str
    physics: str
    why: str
    figure: str  # what is measured, with its unit
    bound: float
    derivation: str  # where the bound comes from
    methods: Mapping[str, Settings]  # settings by method; "auto" is one of them
    measure: Measure
    beside: Callable[[], Mapping[str, float]] | None = None


# the groups, and the texts of all cases, by name or by the name of their family
CATALOGUE = tomllib.loads((Path(__file__).parent / "catalogue.toml").read_text(encoding="utf-8"))
GROUPS: dict[int, str] = dict(enumerate(CATALOGUE["groups"], start=1))


def case(
    text: str, bound: float, methods: Mapping[str, Settings], measure: Measure, beside: Any = None, **numbers: Any
) -> Case:
    """A case with the texts of catalogue.toml under a name, in which {numbers} are filled in."""
    entry = {"name": text} | CATALOGUE[text]
    texts: dict[str, Any] = {k: part.format(**numbers) if isinstance(part, str) else part for k, part in entry.items()}
    return Case(**texts, bound=bound, methods=methods, measure=measure, beside=beside)


def settings(**methods: float | None) -> dict[str, Settings]:
    """The setting of each method: a tolerance, or a step in s where it takes one; none for None."""
    kinds = {name: "step" if name in fixed_methods() else "tolerance" for name in methods}
    return {name: {} if value is None else {kinds[name]: value} for name, value in methods.items()}


TIGHT = settings(auto=1e-12, taylor=1e-16)


def scene(
    model: Chain,
    *effects: Effect,
    q: Any = (),
    v: Any = (),
    duration: float,
    samples: int | None = None,
    gravity: Gravity | None = Gravity(),  # noqa: B008  frozen
    time: float = 0.0,
) -> Scene:
    """A chain under gravity and other effects; angles and rates that are left out are 0."""
    positions, velocities = (np.pad(np.asarray(x, float), (0, 2 * model.count - len(x))).tolist() for x in (q, v))
    start = Start(time=time, positions=tuple(positions), velocities=tuple(velocities))
    acting = effects if gravity is None else (gravity, *effects)
    return Scene(duration=duration, model=model, start=start, effects=acting, solver=Solver(samples=samples))


def reverse_rates(run: Trajectory, scene: Scene) -> Scene:
    """A scene that starts at the end of a run, with all rates reversed."""
    start = Start(positions=tuple(run.q[-1].tolist()), velocities=tuple((-run.v[-1]).tolist()))
    return scene.model_copy(update={"start": start})


def inertia_about_joint(rod: Rod) -> float:
    """Transverse inertia of a rod about its joint, kg m²."""
    m, h, transverse, _, _ = rod.properties
    return transverse + m * h * h


J = inertia_about_joint(ROD)
HANG = J / (ROD.mass * ROD.properties.h)  # m, the reduced length of the thick rod


def drift_of(make: Callable[[Any], Scene], long: Any, short: Any) -> Measure:
    """The energy drift in the scene that `make` gives for a duration in s, or in turns, or with a number of rods."""
    return lambda solve, full: solve(make(long if full else short)).energy().drift


def tip_errors(run: Trajectory, angles: Array, exact: Array) -> float:
    """The largest distance in m of the tip of a 1 m rod to its exact place, from angles in a plane (n,) in rad."""
    return float(np.abs(2 * np.sin((angles - exact) / 2)).max()) if len(run.t) else np.nan


def departure(run: Trajectory, angle: Array, far: float) -> float:
    """The first time in s at which an angle (n,) in rad exceeds `far`, interpolated in logarithms. RunError if none."""
    beyond = np.abs(angle) > far
    if not beyond.any():
        raise RunError(f"the angle never exceeds {far:g} rad", run)
    i = int(np.argmax(beyond))
    if i == 0:
        return float(run.t[0])
    low, high = np.log(np.maximum(np.abs(angle[i - 1 : i + 1]), 1e-300))
    return float(run.t[i - 1] + (np.log(far) - low) / (high - low) * (run.t[i] - run.t[i - 1]))


def refused(one: str, other: str, *given: Any, **fields: Any) -> Measure:
    """0 if a scene (as of `scene`) is refused, or its run ends, with an error of one line that has both words; else 1."""

    def measure(solve: Solve, full: bool) -> float:
        try:
            solve(scene(*given, **fields))
        except Interrupted:
            raise
        except (InputError, RunError) as error:
            return float("\n" in str(error) or one not in str(error) or other not in str(error))
        return 1.0

    return measure
