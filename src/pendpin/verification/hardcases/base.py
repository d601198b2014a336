"""Hard cases: the record of a case, its outcome on one method, and scenes that the cases share."""

import time
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.effects import Effect, Gravity
from pendpin.errors import InputError, Interrupted, MissingLibrary, RunError
from pendpin.ground.arrays import Array
from pendpin.ground.report import Report, Result, Table
from pendpin.motions.simulate import simulate
from pendpin.motions.trajectory import Trajectory
from pendpin.scene import Chain, Rod, Scene, Solver, Start, fixed_methods
from pendpin.verification.claims import Claim, Progress, attempt, collect, describe_broken

Solve = Callable[[Scene], Trajectory]
Settings = Mapping[str, float]  # tolerance, or step in s

G = 9.81  # m/s²
THIN = Chain(rods=(Rod(length=1.0, mass=1.0),))
ROD = Rod(length=1.0, mass=1.0, radius=0.05)
THICK = Chain(rods=(ROD,))
REDUCED = 2 / 3  # m, of the uniform thin rod of 1 m
SWING = float(np.sqrt(G / REDUCED))  # rad/s, its small swings, and the rate at which it leaves the upright


GROUPS = {
    1: "Thin rods through the pole",
    2: "Thick rods past the pole",
    3: "Starts on the pole",
    4: "Fast spin",
    5: "Upright",
    6: "Long horizons",
    7: "Unlike neighbours",
    8: "Long chains",
    9: "Stiff springs and dampers",
    10: "A fast-driven support",
    11: "Sticking, stops and bounces",
    12: "Scales and gravities",
    13: "Times and samples",
    14: "Chaos",
    15: "Symmetry",
}


def settings(**methods: float | None) -> dict[str, Settings]:
    """The setting of each method: a tolerance, or a step in s where it takes one; none for None."""
    kinds = {name: "step" if name in fixed_methods() else "tolerance" for name in methods}
    return {name: {} if value is None else {kinds[name]: value} for name, value in methods.items()}


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
    measure: Callable[[Solve, bool], float]
    beside: Callable[[], Mapping[str, float]] | None = None


def case(
    text: str,
    *,
    bound: float,
    methods: Mapping[str, Settings],
    measure: Callable[[Solve, bool], float],
    beside: Callable[[], Mapping[str, float]] | None = None,
    **numbers: Any,
) -> Case:
    """A case with the texts of catalogue.toml under a name, in which {numbers} are filled in."""
    entry = {"name": text} | catalogue()[text]
    filled: dict[str, Any] = {
        key: value.format(**numbers) if isinstance(value, str) else value for key, value in entry.items()
    }
    return Case(**filled, bound=bound, methods=methods, measure=measure, beside=beside)


def drift_of(make: Callable[[Any], Scene], long: float, short: float) -> Callable[[Solve, bool], float]:
    """A measure: the energy drift in the scene that `make` gives for a duration, in s or in turns."""
    return lambda solve, full: solve(make(long if full else short)).energy().drift


@cache
def catalogue() -> dict[str, dict[str, Any]]:
    """The texts of all cases, by name or by the name of their family."""
    return tomllib.loads((Path(__file__).parent / "catalogue.toml").read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Outcome(Claim):
    """The result of one case on one method."""

    seconds: float
    claimed: bool = True  # False for other algorithms and simulators
    beside: bool = False  # whether it is another algorithm, there to show how it fails
    left_out: bool = False  # whether it needs a library that is not installed

    def __str__(self) -> str:
        return f"{self.case} on {self.method}: {self.failure or f'{self.measured:.3g} is above {self.bound:.3g}'}"

    @property
    def shown(self) -> str:
        """The figure in a table."""
        return "none" if self.measured is None else f"{self.measured:.1e}"

    @property
    def verdict(self) -> str:
        """The outcome in one word."""
        if self.left_out:
            return "left out"
        if self.claimed:
            return super().verdict
        return "holds" if self.ok else "fails, as expected" if self.beside else "fails"


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


def inertia_about_joint(rod: Rod) -> float:
    """Transverse inertia of a rod about its joint, kg m²."""
    m, h, transverse, _, _ = rod.properties
    return transverse + m * h * h


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


def refused(solve: Solve, make_scene: Callable[[], Scene], *words: str) -> float:
    """0 if the scene is refused, or its run ends, with an error of one line that has these words; else 1."""
    try:
        solve(make_scene())
    except Interrupted:
        raise
    except (InputError, RunError) as error:
        said = str(error)
        return float("\n" in said or not all(word in said for word in words))
    return 1.0


def reverse_rates(run: Trajectory, scene: Scene) -> Scene:
    """A scene that starts at the end of a run, with all rates reversed."""
    start = Start(positions=tuple(run.q[-1].tolist()), velocities=tuple((-run.v[-1]).tolist()))
    return scene.model_copy(update={"start": start})


# --- running the catalogue ------------------------------------------------------------------------------------------

FIELDS = ("name", "group", "title", "physics", "why", "figure", "bound", "derivation", "methods")  # of a case, in JSON


@dataclass(frozen=True, repr=False)
class HardReport(Result):
    """The outcomes so far, and their cases."""

    outcomes: tuple[Outcome, ...]
    cases: tuple[Case, ...]
    stopped: bool = False  # True if the user stopped it before the end

    @property
    def broken(self) -> tuple[Outcome, ...]:
        """The claims that did not hold."""
        return tuple(outcome for outcome in self.outcomes if outcome.claimed and not outcome.ok)

    @property
    def fault(self) -> str | None:
        """The broken claims in one line; None if all claims hold."""
        return describe_broken(self.broken)

    def report(self) -> Report:
        """What was measured of each case on each method, which runs failed, and how many claims are broken."""
        cases = ["", *(o.case for o in self.outcomes)]  # each named once
        rows = [
            ("" if o.case == before else o.case, o.method, o.shown, f"{o.bound:.1e}", o.verdict, f"{o.seconds:.2f}")
            for before, o in zip(cases, self.outcomes, strict=False)
        ]
        words = [f"{o.case} on {o.method}: {o.failure}" for o in self.outcomes if o.failure]
        if claims := [o for o in self.outcomes if o.claimed]:
            words.append(f"{len(claims)} claims, {len(self.broken)} broken, {sum(o.seconds for o in claims):.0f} s")
        outcomes = [asdict(o) | {"ok": o.ok, "verdict": o.verdict} for o in self.outcomes]
        described = [{name: getattr(case, name) for name in FIELDS} for case in self.cases]
        data = {"ok": not self.broken, "stopped": self.stopped, "outcomes": outcomes, "cases": described}
        head = ("case", "method", "measured", "bound", "verdict", "seconds")
        return Report((Table(head, rows), *words), data, self.fault)


def catalogue_report(cases: Iterable[Case]) -> Report:
    """The names of hard cases, their titles and bounds."""
    rows = [(case.name, case.title, f"{case.bound:.1e}") for case in cases]
    data = [{name: getattr(case, name) for name in ("name", "title", "figure", "bound")} for case in cases]
    return Report((Table(("case", "what", "bound"), rows),), data)


def reported(cases: Sequence[Case], outcomes_of: Callable[[Case], Iterator[Outcome]]) -> HardReport:
    """The outcomes of all cases; after Ctrl-C those so far."""
    results, stopped = collect(outcome for case in cases for outcome in outcomes_of(case))
    return HardReport(results, tuple(cases), stopped)


def outcomes(case: Case, methods: Sequence[str] | None, full: bool, progress: Progress) -> Iterator[Outcome]:
    """A case on its methods and beside them, or only on those in `methods`."""
    for method in case.methods:
        if methods is None or method in methods:
            progress(f"{case.name} on {method}")
            yield outcome(case, method, full)
    if case.beside is not None and methods is None:
        progress(f"{case.name}, beside")
        begin = time.process_time()
        beside = case.beside()
        seconds = (time.process_time() - begin) / max(len(beside), 1)
        for name, measured in beside.items():
            yield Outcome(case.name, name, measured, case.bound, None, seconds, claimed=False, beside=True)


def outcome(case: Case, method: str, full: bool) -> Outcome:
    """One case on one of its methods, with its setting."""
    setting: dict[str, Any] = dict(case.methods[method])
    return measured(case, method, lambda scene: simulate(scene, method=method, **setting), full)


def measured(case: Case, method: str, solve: Solve, full: bool) -> Outcome:
    """One case solved by `solve`; an error of the run is an outcome too."""
    begin = time.process_time()
    figure, error = attempt(lambda: float(case.measure(solve, full)))  # JSON takes no NumPy numbers
    failure = error and str(error)
    if figure is not None and not isfinite(figure):
        figure, failure = None, "its numbers are not finite"
    missing, seconds = isinstance(error, MissingLibrary), time.process_time() - begin
    return Outcome(case.name, method, figure, case.bound, failure, seconds, claimed=not missing, left_out=missing)
