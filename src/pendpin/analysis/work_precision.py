"""Work and precision: every method, and other simulators, over a series of tolerances or steps."""

import os
import platform
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pendpin.analysis.references import Reference, reference
from pendpin.analysis.work_precision_report import CostReport, Curve, Point
from pendpin.arrays import Array
from pendpin.errors import InputError, Interrupted, PendpinError, RunError, choices, one_line
from pendpin.model.build import Model, build
from pendpin.model.kinematics import marks, poses, scale, tip_distance, tips
from pendpin.scene import FIXED_METHODS, Scene, least_tolerance
from pendpin.simulation.simulate import simulate
from pendpin.versions import installed

if TYPE_CHECKING:
    from pendpin.analysis.simulators import Peer

PLAIN = ("taylor", "dop853", "rk45", "rk23", "radau", "bdf", "lsoda", "gauss2", "gauss4", "gauss6", "rk4", "euler")
COMPILED = " compiled"  # after the name of a method: on the compiled engine
METHODS = (*PLAIN, *(f"{name}{COMPILED}" for name in ("dop853", "rk45", "lsoda", "rk4")))
ACCURACY = 1e-9
SAMPLES = 201  # output times of a comparison, unless the scene says how many
KNOWN = 0.1  # of the accuracy: largest error of the reference
REPETITIONS = 3
BUDGET = 1.0  # s, of the slowest run of a method
PATIENCE = 5.0  # times the budget: a run that takes longer is stopped
FEW_JOINTS = 6
MOST_STEPS = 20  # of a series
LIBRARIES = ("pendpin", "pin", "numpy", "scipy", "CyRK", "heyoka", "mujoco", "drake")


@dataclass(frozen=True)
class _Outcome:
    """One run of a series: its tips, or why there are none."""

    tips: Array | None  # (n, rods, 3)
    seconds: float
    steps: int = 0
    evaluations: int = 0
    compile_seconds: float = 0.0
    failure: str | None = None
    hopeless: bool = False  # whether other settings fail as well


@dataclass(frozen=True, eq=False)
class _Bench:
    """What all series share."""

    scene: Scene  # up to the reference's horizon
    known: Reference
    model: Model
    repetitions: int
    budget: float
    progress: Callable[[str], None]
    first_step: float  # s, of series of steps


def cost(
    scene: Scene,
    *,
    methods: Sequence[str] = METHODS,
    accuracy: float = ACCURACY,
    peers: bool = False,
    repetitions: int = REPETITIONS,
    budget: float = BUDGET,
    progress: Callable[[str], None] = lambda what: None,
) -> CostReport:
    """Error against time for the methods of `methods`, and with `peers` for other simulators, on one scene.

    The error is the largest distance of any tip to its reference during the run, divided by the chain's length. The
    comparison ends where the reference is off by more than a tenth of `accuracy`, as in chaotic motion. Each time is the
    least of `repetitions` runs after a first one; a series ends where its next run would take more than `budget` s.
    `progress` is called with the name of what is being measured. An interrupt ends the measurement; the report holds
    what was measured until then. Raises InputError for an unknown method, or where there is no reference.
    """
    for method in methods:
        if method not in METHODS:
            raise InputError(f"methods: {method} is not one of: {choices(METHODS)}")
    if not 0 < accuracy < 1:
        raise InputError(f"accuracy: {accuracy:g} is not between 0 and 1")
    others = _peers(scene) if peers else ()
    progress("the reference")
    bench = _bench(scene, accuracy, repetitions, budget, progress)
    curves, interrupted = [], False
    try:
        for method in methods:
            curves.append(_method_curve(bench, method))
        for peer in _peers(bench.scene) if others else ():
            curves.append(_peer(bench, peer))
    except (KeyboardInterrupt, Interrupted):
        interrupted = True
    known = bench.known
    return CostReport(
        *(_subject(bench.model), tuple(curves), accuracy, known.error, known.solutions, known.duration, known.horizon),
        *(
            machine(),
            {name: version for name, version in installed(*LIBRARIES).items() if version},
            repetitions,
            interrupted,
        ),
    )


def _bench(scene: Scene, accuracy: float, repetitions: int, budget: float, progress: Callable[[str], None]) -> _Bench:
    solver = scene.solver.replaced(method="auto", samples=scene.solver.samples or (SAMPLES if scene.duration else 1))
    scene = scene.model_copy(update={"solver": solver})
    known = reference(scene, KNOWN * accuracy)
    solver = solver.model_copy(update={"samples": len(known.t)})
    scene = scene.model_copy(update={"duration": known.horizon, "solver": solver})
    steps = simulate(scene, method="dop853", tolerance=1e-3).stats.steps
    first_step = scene.duration / max(steps, len(known.t) - 1, 1)
    return _Bench(scene, known, build(scene.model), repetitions, budget, progress, first_step)


def _subject(model: Model) -> str:
    count, name = (len(model.rods), "rod") if model.rods else (len(model.joints), "joint")
    return f"{count} {name}{'s' if count > 1 else ''}"


def _peers(scene: Scene) -> "tuple[Peer, ...]":
    from pendpin.analysis.simulators import peers

    return peers(scene)


# --- series -------------------------------------------------------------------------------------------------------


def _method_curve(bench: _Bench, method: str) -> Curve:
    name = method.removesuffix(COMPILED)
    scene, fixed = bench.scene, name in FIXED_METHODS
    if name != method:
        scene = scene.model_copy(update={"solver": scene.solver.model_copy(update={"engine": "compiled"})})
    library = ""

    def run(setting: float) -> _Outcome:
        nonlocal library
        begin = time.perf_counter()
        try:
            found = simulate(scene.by(name, setting), limit=PATIENCE * bench.budget)
        except Interrupted:
            raise
        except PendpinError as error:
            hopeless = not isinstance(error, RunError)
            return _Outcome(None, time.perf_counter() - begin, failure=one_line(str(error)), hopeless=hopeless)
        stats = found.stats
        library = f"{stats.library} {stats.version}"
        return _Outcome(
            marks(bench.model, found.tips(), found.q),
            stats.seconds,
            stats.steps,
            stats.evaluations,
            stats.compile_seconds,
        )

    settings = _steps(bench.first_step) if fixed else _tolerances(least_tolerance(name), _stride(bench, name))
    points, failures, compiling = _climb(bench, method, settings, run)
    return Curve(method, library, "step" if fixed else "tolerance", points, failures, compiling)


def _peer(bench: _Bench, peer: "Peer") -> Curve:
    def run(setting: float) -> _Outcome:
        found = peer.run(setting, PATIENCE * bench.budget)
        if found.failure is not None:
            return _Outcome(None, found.seconds, failure=found.failure)
        return _Outcome(
            marks(bench.model, tips(bench.model, poses(bench.model, found.q)), found.q),
            found.seconds,
            found.steps,
            found.evaluations,
        )

    settings = _steps(bench.first_step) if peer.kind == "step" else _tolerances(1e-14)
    points, failures, compiling = _climb(bench, peer.name, settings, run)
    return Curve(peer.name, peer.library, peer.kind, points, failures, compiling, peer=True)


def _tolerances(least: float, stride: int = 1) -> Iterator[float]:
    """Decades, or every so many, from 0.01 to the least."""
    yield from (10.0**-k for k in range(2, 19, stride) if 10.0**-k >= least * (1 - 1e-9))


def _stride(bench: _Bench, method: str) -> int:
    """Decades between two tolerances: taylor compiles for each, which takes long for many joints."""
    return 4 if method == "taylor" and len(bench.model.joints) > FEW_JOINTS else 1


def _steps(first: float) -> Iterator[float]:
    yield from (first / 2**k for k in range(MOST_STEPS))


def _climb(
    bench: _Bench, name: str, settings: Iterable[float], run: Callable[[float], _Outcome]
) -> tuple[tuple[Point, ...], tuple[str, ...], float]:
    """The points of a series, why runs failed, and the longest time of compiling."""
    points, failures, compiling, length = [], [], 0.0, scale(bench.model)
    for setting in settings:
        bench.progress(f"{name}, {setting:.1e}")
        found = run(setting)
        compiling = max(compiling, found.compile_seconds)
        if found.tips is None:
            failures.append(found.failure or "")
        else:
            error = float(tip_distance(bench.known.tips, found.tips, length).max())
            points.append(Point(setting, error, _least(bench, found, setting, run), found.steps, found.evaluations))
        if found.hopeless or _enough(bench, points, found.seconds):
            break
    return tuple(points), tuple(failures), compiling


def _least(bench: _Bench, first: _Outcome, setting: float, run: Callable[[float], _Outcome]) -> float:
    """The least time of some repetitions, as many as the budget allows; that of the first run if none."""
    spent, times = first.seconds, []
    while len(times) < bench.repetitions and spent < bench.budget:
        times.append(run(setting).seconds)
        spent += times[-1]
    return min(times, default=first.seconds)


def _enough(bench: _Bench, points: list[Point], seconds: float) -> bool:
    """Whether a series ends: the next run takes too long, or the error has reached that of the reference."""
    if not points:
        return seconds > bench.budget
    growth = points[-1].seconds / points[-2].seconds if len(points) > 1 else 1.0
    return seconds * max(growth, 1.0) > bench.budget or points[-1].error <= bench.known.error


# --- the machine ----------------------------------------------------------------------------------------------------


def machine() -> str:
    """The processor, how many there are, and the Python."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(errors="replace").splitlines() if info.is_file() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    name = names[0] if names else platform.processor() or platform.machine()
    return f"{name}, {os.cpu_count()} cores, Python {platform.python_version()}"
