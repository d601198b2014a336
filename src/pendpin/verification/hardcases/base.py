"""Hard cases: the record of a case, its scenes and texts, and the measures that families of cases share.

Each scene is a file of scenes/, which `pendpin run` takes too; catalogue.toml has the texts and the methods.
"""

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.equations.exact import planar
from pendpin.errors import RunError, attempt
from pendpin.ground.arrays import Array
from pendpin.motions.trajectory import Trajectory
from pendpin.scene import Rod, Scene, load_scene

Solve = Callable[[Scene], Trajectory]
Settings = Mapping[str, float]  # tolerance, or step in s
Figure = Callable[[Trajectory], float]
Measure = Callable[[Solve, bool], float]  # of the full form, or of the short one

G = 9.81  # m/s²
MOST_EXACT = 1000  # samples, and one, that are compared with an exact solution
ROD = Rod(length=1.0, mass=1.0, radius=0.05)  # the thick rod of many scenes; a thin one is as long and as heavy
REDUCED = 2 / 3  # m, of the uniform thin rod of 1 m
SWING = float(np.sqrt(G / REDUCED))  # rad/s, its small swings, and the rate at which it leaves the upright


@dataclass(frozen=True)
class Case:
    """One hard case. `measure` solves its scenes, in full or in short, and returns the figure to compare with `bound`."""

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


# the groups, and the texts and methods of all cases, by name or by the name of their family
FOLDER = Path(__file__).parent
CATALOGUE = tomllib.loads((FOLDER / "catalogue.toml").read_text(encoding="utf-8"))
GROUPS: dict[int, str] = dict(enumerate(CATALOGUE["groups"], start=1))


def scene(name: str, changes: Mapping[str, Any] | None = None) -> Scene:
    """The scene of a file of scenes/, with other values at key paths."""
    return load_scene(FOLDER / "scenes" / f"{name}.toml").replace(changes)


def drift(run: Trajectory) -> float:
    """The energy drift of a run."""
    return run.energy().drift


def case(
    text: str,
    bound: float,
    figure: Figure = drift,
    short: Mapping[str, Any] | None = None,
    measure: Measure | None = None,
    **numbers: Any,
) -> Case:
    """A case with the entry of catalogue.toml under a name, in which {numbers} are filled in.

    Its figure is that of the run of its scene, whose short form has other values at key paths; or it has a measure.
    """
    entry = {"name": text} | CATALOGUE[text]
    filled: dict[str, Any] = {k: part.format(**numbers) if isinstance(part, str) else part for k, part in entry.items()}
    measure = measure or (lambda solve, full: figure(solve(scene(filled["name"], None if full else short))))
    return Case(**filled, bound=bound, measure=measure)


def start_of(scene: Scene) -> tuple[Array, Array]:
    """The angles and rates (nv,) at which a scene starts that lists all of them."""
    return np.array(tuple(scene.start.positions)), np.array(tuple(scene.start.velocities))


def start_at(scene: Scene, q: Array, v: Array) -> Scene:
    """A scene with other angles and rates at its start, (nv,) each."""
    return scene.replace({"start.positions": q.tolist(), "start.velocities": v.tolist()})


def inertia_about_joint(rod: Rod) -> float:
    """Transverse inertia of a rod about its joint, kg m²."""
    m, h, transverse, _, _ = rod.properties
    return transverse + m * h * h


J = inertia_about_joint(ROD)
HANG = J / (ROD.mass * ROD.properties.h)  # m, the reduced length of the thick rod


def largest(values: Array) -> float:
    """The largest size of an array's numbers."""
    return float(np.abs(values).max())


def plane_swing(angle: float, reduced: float, joint: int = 0, rate: float = 0.0, g: float = G) -> Figure:
    """The error in m of a rod of a reduced length in m that swings by one joint, from an angle and rate, rad and rad/s."""

    def error(run: Trajectory) -> float:
        some = slice(None, None, max(1, len(run.t) // MOST_EXACT))  # an exact angle takes a millisecond
        exact = planar(angle, rate, reduced, g, run.t[some])
        return float(np.abs(2 * np.sin((run.q[some, joint] - exact) / 2)).max()) if len(run.t) else np.nan

    return error


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


def refused(name: str, one: str, other: str) -> Measure:
    """0 if a scene is refused, or its run ends, with an error of one line that has both words; else 1."""

    def measure(solve: Solve, full: bool) -> float:
        _, error = attempt(lambda: solve(scene(name)))
        return float(error is None or "\n" in str(error) or one not in str(error) or other not in str(error))

    return measure
