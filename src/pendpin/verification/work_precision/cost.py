"""Work and precision: every method, and other simulators, over a series of tolerances or steps, from coarse to fine."""

import os
import platform
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from pendpin.engines import Compiled
from pendpin.errors import Halted, InputError, Interrupted, RunError, amount, attempt
from pendpin.ground.arguments import flag, fraction, function, names_in, seconds, whole_number
from pendpin.ground.arrays import EPS, Array
from pendpin.ground.libraries import installed
from pendpin.integrators import FEW_JOINTS, uncompiled
from pendpin.integrators.taylor import equations_with_numbers, start_compiler
from pendpin.model.build import Model, build
from pendpin.model.kinematics import marks, marks_at, scale, tip_distance
from pendpin.runs.preparation import Prepared
from pendpin.runs.simulate import halting, run_to_setting
from pendpin.scene import METHODS, Scene, chosen_scene, fixed_methods
from pendpin.verification import simulators
from pendpin.verification.simulators import Peer
from pendpin.verification.work_precision import references
from pendpin.verification.work_precision.report import ACCURACIES, UNCOMPILED, CostReport, Curve, Point, cost_row

SAMPLES = 201  # output times of a comparison, unless the scene asks for fewer, or for others and it is thorough
KNOWN = 0.1  # of the accuracy: largest error of the reference
LIMIT = 18.0  # s of processor time in all, unless thorough; Python and its libraries start besides
OF_REFERENCE = 1.2  # s of it, at most, for each run of a reference
WORTH = (0.01, 3.0)  # s, and times the cheapest first run: longer runs are not tried, unless thorough
SEVERAL_JOINTS = 6  # from more on, thorough series of taylor take every fourth tolerance
MOST_STEPS = 20  # of a series of steps
GROWTH = 2.0  # of the time from one setting to the next
PATIENCE = 5.0  # times the time that a run is worth: one that takes longer is stopped

Measured = tuple[str, Array, Point]  # library, marks (n, bodies, 3) m, the run, whose error is not known yet


@dataclass(eq=False)
class Series:
    """One method, or one of another simulator, with the runs made so far."""

    curve: Curve  # what was measured
    settings: Iterator[float]  # from coarse to fine
    run: Callable[[float, float], Measured]  # with a setting and the s after which it is stopped
    ended: bool = False

    def first_at(self, error: float) -> float | None:
        """The least s of a first run that meets an error, compiling included."""
        return min((point.first_seconds for point in self.curve.points if point.error <= error), default=None)


def cost(
    scene: Scene | str | Path,
    *,
    methods: Sequence[str] | str | None = None,
    accuracy: float = 1e-9,
    peers: bool = False,
    thorough: bool = False,
    repetitions: int = 3,
    budget: float = 1.0,
    progress: Callable[[str], None] = lambda what: None,
) -> CostReport:
    """Measure error against time: the cheapest method for each accuracy, and its run time (a work-precision diagram).

    The accuracies are 1e-3 to 1e-12 in steps of a thousand, and `accuracy`. The error is the largest distance of any tip
    from its reference during the run, divided by the chain's length. The comparison ends where the reference is off by more
    than a tenth of `accuracy`, as in chaotic motion. All methods take about 20 s of processor time, 40 with `peers`, because
    methods that cannot become the cheapest are stopped, and only the first part of the scene is compared if a reference
    takes long. After Ctrl-C the report holds the rows measured until then.

    Args:
        scene: a Scene, or the path of a TOML file.
        methods: names of methods, run as `simulate` runs them, or such as "dop853 not compiled"; all if absent.
        accuracy: the finest accuracy of interest.
        peers: compare with MuJoCo, Drake and SciPy too.
        thorough: measure all methods at all settings, over the full duration, however long that takes.
        repetitions: runs after a first one; the least time of these counts.
        budget: s; a series ends where its next run would take longer.
        progress: called with the name of the method that is measured.

    Returns:
        The report; its `rows` have the cheapest method for each accuracy.

    Raises:
        InputError: for an unknown method, or where there is no reference.
    """
    scene = chosen_scene(scene)
    methods = None if methods is None else names_in("methods", methods, _all_methods())
    peers, thorough, progress = flag("peers", peers), flag("thorough", thorough), function("progress", progress)
    repetitions, budget = whole_number("repetitions", repetitions, least=0), seconds("budget", budget)
    accuracy = fraction("accuracy", accuracy)
    if KNOWN * accuracy < EPS:
        rounded = f"numbers of 64 bits are rounded to {EPS:.1g} of themselves"
        needed = f"the reference has to be {1 / KNOWN:g} times as accurate"
        raise InputError(f"accuracy: {accuracy:g} is finer than can be measured: {rounded}, and {needed}")
    if peers:
        simulators.peers(scene)  # a scene that one of them does not take is refused before anything is measured
    end = time.process_time() + (np.inf if thorough else LIMIT * (1 + peers))
    progress("the reference")
    if "taylor" in (methods or METHODS):
        start_compiler()  # apart from the reference's series, as a first run of any series needs it
    bench = _prepare_bench(scene, accuracy, thorough, repetitions, budget, progress)
    series = [_series_of_method(bench, method) for method in methods or _suitable_methods(bench)]
    others = [_series_of_peer(bench, peer) for peer in (simulators.peers(bench.scene) if peers else ())]

    contested, interrupted = list[float](), False
    try:
        # from coarse to fine; the time left is shared among the accuracies that can be answered
        accuracies = sorted({*ACCURACIES, accuracy}, reverse=True)
        for i, error in enumerate(accuracies):
            asked = max(sum(other >= bench.known.error for other in accuracies[i:]), 1)
            for some, parts in ((series, asked * (2 if others else 1)), (others, 2 * asked - 1)):
                now = time.process_time()
                bench.compare(some, error, now + (end - now) / parts)
            contested.append(error)
        for one in series + others if thorough else ():
            bench.refine(one, bench.known.error, budget, end)
    except (KeyboardInterrupt, Interrupted):
        interrupted = True
    libraries = ("pendpin", "pin", "numpy", "scipy", "CyRK", "heyoka", "mujoco", "drake")
    known, model, curves = bench.known, bench.model, tuple(one.curve for one in series + others)

    same = {name: getattr(known, name) for name in ("error", "solutions", "duration", "horizon", "halted")}
    return CostReport(
        subject=amount(len(model.rods), "rod") if model.rods else amount(len(model.joints), "joint"),
        curves=curves,
        accuracy=accuracy,
        machine=machine(),
        versions={name: version for name, version in installed(*libraries).items() if version},
        repetitions=repetitions,
        thorough=thorough,
        interrupted=interrupted,
        missing=simulators.missing() if peers else (),
        rows=tuple(cost_row(curves, error, known.error) for error in contested),  # a later point may be better
        **same,
    )


@dataclass(frozen=True, eq=False)
class _Bench:
    """What all series share."""

    scene: Scene  # up to the reference's horizon
    known: references.Reference
    model: Model
    first_step: float  # s, of series of steps
    compiles: bool  # whether methods compile the scene's equations, and can be asked not to
    thorough: bool  # whether every setting is measured, or tolerances only from the error that is wanted on
    repetitions: int
    budget: float  # s: a method whose run takes longer has ended
    progress: Callable[[str], None]

    def refine(self, series: Series, error: float, worth: float, end: float) -> None:
        """Run finer and finer settings until one meets an error, the next takes more than `worth` s, or no time is left.

        `end` is that of the time left, in s of this process's processor time.
        """
        while not series.ended and series.first_at(error) is None and end > time.process_time():
            curve = series.curve
            if curve.points and GROWTH * curve.points[-1].seconds > worth:  # which the next run takes, about
                return
            usable = (x for x in series.settings if self.thorough or curve.kind == "step" or x <= error * (1 + 1e-9))
            if (setting := next(usable, None)) is None:
                series.ended = True
                return
            self.progress(f"{curve.name}, {setting:.1e}")
            begin, stop = time.thread_time(), min(PATIENCE * worth, end - time.process_time())
            result, fault = attempt(partial(series.run, setting, stop))
            if result is None:
                spent = stop if isinstance(fault, Halted) else time.thread_time() - begin
                hopeless = not isinstance(fault, RunError)  # other settings fail as well
                series.ended = hopeless or spent > self.budget
                series.curve = replace(curve, failures=(*curve.failures, str(fault)))
                if spent > worth:
                    return
                continue
            library, tips, point = result
            spent, times, series.ended = point.seconds, [], point.seconds > self.budget
            while len(times) < self.repetitions and spent < worth:  # as many as are worth it; the least time counts
                again, _ = attempt(partial(series.run, setting, PATIENCE * worth))
                times.append(again[2].seconds if again else PATIENCE * worth)
                spent += times[-1]
            off = float(tip_distance(self.known.tips, tips, scale(self.model)).max())  # over the length
            point = replace(point, error=off, seconds=min(times, default=point.seconds))
            series.curve = replace(curve, library=library, points=(*curve.points, point))

    def compare(self, series: Iterable[Series], error: float, end: float) -> None:
        """Every series up to one error until `end`, as far as it is worth it beside the cheapest of them."""
        if error < self.known.error:
            return
        best, (least, times) = np.inf, WORTH
        for one in series:
            worth = self.budget if self.thorough else min(max(least, times * best), self.budget)
            self.refine(one, error, worth, end)
            best = min(best, one.first_at(error) or np.inf)


def _prepare_bench(
    scene: Scene, accuracy: float, thorough: bool, repetitions: int, budget: float, progress: Callable[[str], None]
) -> _Bench:
    samples = scene.solver.samples or (SAMPLES if scene.duration else 1)
    scene = scene.with_solver(method="auto", samples=samples if thorough else min(samples, SAMPLES))
    solutions, limit = (references.SOLUTIONS, np.inf) if thorough else (references.QUICK, OF_REFERENCE)
    known = references.reference(scene, KNOWN * accuracy, solutions, limit)
    scene = scene.sampled(len(known.t), duration=known.horizon)
    pilot = run_to_setting(scene.by("dop853", 1e-3))
    if not thorough:
        references.refuse_other_equations(scene, pilot)
    first_step = scene.duration / max(pilot.stats.steps, len(known.t) - 1, 1)
    compiles = scene.solver.engine == "auto" and "compiled" in pilot.stats.engine
    return _Bench(scene, known, build(scene.model), first_step, compiles, thorough, repetitions, budget, progress)


def _all_methods() -> tuple[str, ...]:
    """All methods, as `simulate` runs them, those that are most often the cheapest first; then without compiling."""
    ranked = sorted(METHODS.values(), key=lambda method: method.price_rank)
    compiled = [method.name for method in ranked if method.machine_code and not method.damps]
    return (*(method.name for method in ranked), *(f"{name}{UNCOMPILED}" for name in compiled))


def _suitable_methods(bench: _Bench) -> Iterator[str]:
    """All methods; unless thorough, without those that take minutes on so many joints before anything can stop them."""
    joints = len(bench.model.joints)
    for name in _all_methods():
        method = METHODS[name.removesuffix(UNCOMPILED)]
        slow = (name == "taylor" and joints > FEW_JOINTS) or (method.implicit and joints > references.LARGE)
        twice = name != method.name and not bench.compiles
        if (bench.thorough or not slow) and not twice:
            yield name


def _series_of_method(bench: _Bench, method: str) -> Series:
    """The series of a method of pendpin."""
    name = method.removesuffix(UNCOMPILED)
    fixed = name in fixed_methods()
    stride = 4 if name == "taylor" and len(bench.model.joints) > SEVERAL_JOINTS else 1
    settings = _settings(bench, fixed, METHODS[name].least_tolerance, stride)

    def run(setting: float, stop: float) -> Measured:
        scene = bench.scene.by(name, setting)
        scene = scene if name == method else uncompiled(scene)
        result = run_to_setting(scene, progress=halting(stop))
        stats, tips = result.stats, marks(bench.model, result.tips, result.q)
        compiles = name == "taylor" or "compiled" in stats.engine
        compiling = max(stats.compile_seconds, _compiled_in(scene)) if compiles else 0.0
        point = Point(setting, np.nan, stats.seconds, stats.steps, stats.evaluations, compiling)
        return f"{stats.library} {stats.version}", tips, point

    return Series(Curve(method, "", "step" if fixed else "tolerance"), settings, run)


def _compiled_in(scene: Scene) -> float:
    """The s in which this process compiled what the scene's method integrates, in whichever run; 0 if it did not."""
    prepared = Prepared.of(scene)  # as for its last run: equations without what stays 0 in the motion are others
    scene, engine = prepared.scene, prepared.dynamics.engine
    if scene.solver.method == "taylor":  # to start heyoka's compiler, and to compile the series
        equations, _ = equations_with_numbers(engine, prepared.dynamics.effects, scene.start.time)
        series = equations.series.get(scene.solver.tolerance)
        return start_compiler() + (series.compile_seconds if series else 0.0)
    return engine.equations.compile_seconds if isinstance(engine, Compiled) else 0.0


def _series_of_peer(bench: _Bench, peer: Peer) -> Series:
    """The series of a method of another simulator."""

    def run(setting: float, stop: float) -> Measured:
        result = peer.run(setting, stop)
        point = Point(setting, np.nan, result.seconds, result.steps, result.evaluations)
        return peer.library, marks_at(bench.model, result.q), point

    curve = Curve(peer.name, peer.library, peer.kind, peer=True)
    return Series(curve, _settings(bench, peer.kind == "step", 1e-14), run)


def _settings(bench: _Bench, fixed: bool, least: float, stride: int = 1) -> Iterator[float]:
    """Steps in s, each half the one before; else decades of tolerance, or every so many, from 0.01 to the least."""
    if fixed:
        return (bench.first_step / 2**k for k in range(MOST_STEPS))
    return (10.0**-k for k in range(2, 19, stride) if 10.0**-k >= least * (1 - 1e-9))


def machine() -> str:
    """The processor, how many there are, and the Python."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(errors="replace").splitlines() if info.is_file() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    name = names[0] if names else platform.processor() or platform.machine()
    return f"{name}, {os.cpu_count()} cores, Python {platform.python_version()}"
