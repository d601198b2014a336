"""Which effects a scene needs: what each one changes, and what it costs."""

import timeit
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import partial
from time import process_time

import numpy as np

from pendpin.dynamics.dynamics import bind
from pendpin.effects import ContactEffect, Drag, Effect, Rotation, Viscous
from pendpin.engines import Compiled
from pendpin.errors import attempt
from pendpin.ground.arguments import fraction
from pendpin.ground.arrays import Array
from pendpin.ground.report import Report, Result, Table
from pendpin.model.build import build, start_state
from pendpin.model.kinematics import marks, scale, tip_distance
from pendpin.runs.simulate import run_within
from pendpin.scene import Chain, Rod, Scene
from pendpin.trajectory import RunRecord

CHAOTIC = "later the motion is not known to this accuracy"
LARGE = "more would take long, as --thorough does"
TOLERANCE, FINEST = 1e-4, 1e-11  # of the runs compared: times the accuracy, and at least
FINER = 0.01  # times that: of the run that shows their error
THINNER = 0.1  # radius of the rods whose thickness counts for nothing: what it changes goes with its square
MARGIN = 0.1  # of the accuracy: where two runs of the same scene differ by more, the comparison ends
SMALL_DAMPING = 1e-4  # N m s/rad per N m of the heaviest rod's weight times its lever: a good bearing
LATITUDE = 45.0  # degrees
CALLS, MANY, REPETITIONS = 20, 100, 9  # of an evaluation from Python, in machine code
BUDGET = 0.5  # s of processor time for each of the runs compared, beside compiling
SAMPLES = 201  # output times at most, at which tips are compared


@dataclass(frozen=True)
class EffectRow:
    """What one effect changes and costs."""

    effect: str
    listed: bool  # True if the scene has the effect; False if it was added for the comparison
    change: float  # largest distance between the tips with and without it, divided by the chain's length
    added: float | None  # time of an evaluation, over that without it; None for friction and stops: they act at events
    verdict: str


@dataclass(frozen=True, repr=False)
class EffectsReport(Result):
    """The effects of a scene at an accuracy, compared from the start to `horizon`."""

    rows: tuple[EffectRow, ...]
    accuracy: float
    duration: float  # s, of the scene
    horizon: float  # s, end of the comparison; shorter than `duration` in chaotic motion and in large models
    why: str = ""  # it ends before the scene does

    def report(self) -> Report:
        rows = []
        for row in self.rows:
            change = f"{float(f'{100 * row.change:.2g}'):g} %"  # two digits, without an exponent
            added = "" if row.added is None else f"+{row.added:.0%}"
            rows.append((row.effect, "yes" if row.listed else "no", change, added, row.verdict))
        words = ["A tip's largest distance with and without the effect, in per cent of the chain's length."]
        words.append(f"An effect is needed if it moves a tip by more than {100 * self.accuracy:g} %.")
        if any(not row.listed for row in self.rows):
            words.append("Effects that the scene lacks were tried with example numbers; yours may differ.")
        if self.horizon < self.duration:
            words.append(f"compared up to {self.horizon:.3g} s of {self.duration:g} s: {self.why}")
        head = ("effect", "in the scene", "moves a tip by", "time added", "verdict")
        return Report((Table(head, rows), *words), asdict(self))


def significance(scene: Scene, accuracy: float = 1e-3, thorough: bool = False) -> EffectsReport:
    """How much every effect of a scene changes the motion, and how much some effects that it lacks would change it.

    The comparison ends where two runs of the same scene, at two tolerances, differ by more than a tenth of the accuracy, as
    in chaotic motion, and, unless `thorough`, where a run has taken half a second of processor time. InputError, RunError.
    """
    accuracy = fraction("accuracy", accuracy)
    scene = scene.sampled(min(len(scene.times), SAMPLES))
    budget = np.inf if thorough else BUDGET
    tolerance = max(TOLERANCE * accuracy, FINEST)
    base = run_within(budget, scene.by("auto", tolerance))
    affordable = _shorten(scene, len(base.t))
    finer = run_within(2 * budget, affordable.by("auto", FINER * tolerance))
    off = _measure_distance(scene, base, finer) > MARGIN * accuracy
    compared = _shorten(affordable, int(np.argmax(np.append(off, True))))
    whole = compared.duration == scene.duration
    why = "" if whole else CHAOTIC if off.any() else LARGE
    rows = []
    for name, listed, effect, other in _list_variants(compared):
        run, error = attempt(partial(run_within, 2 * budget, other.by("auto", tolerance)))  # without notes
        if run is None:
            rows.append(EffectRow(name, listed, float("nan"), None, f"not compared: {error}"))
            continue
        change = float(_measure_distance(compared, base, run).max())
        added = None
        if effect is not None and not isinstance(effect, ContactEffect):  # time of an evaluation, both on one engine
            engine = min({one.source.solver.engine for one in (base, run)} - {"compiled"}, default="compiled")
            more, less = (_measure_evaluation(one, engine) for one in ((base, run) if listed else (run, base)))
            added = max(more / less - 1, 0.0) if less else 0.0  # a clock may not have moved
        verdict = "needed" if change > accuracy else "not needed"
        verdict += "" if whole else f" up to {compared.duration:.2g} s"
        rows.append(EffectRow(name, listed, change, added, verdict))
    return EffectsReport(tuple(rows), accuracy, scene.duration, compared.duration, why)


def _shorten(scene: Scene, count: int) -> Scene:
    """The scene up to the last of this number of output times, at least to the first."""
    count = max(count, 1)
    return scene.sampled(count, duration=float(scene.times[count - 1]))


def _list_variants(scene: Scene) -> Iterator[tuple[str, bool, Effect | None, Scene]]:
    """The scene without each of its effects, and with each of the candidates that it lacks; None: it is not an effect."""
    for i, effect in enumerate(scene.effects):
        others = *scene.effects[:i], *scene.effects[i + 1 :]
        yield effect.kind, True, effect, scene.model_copy(update={"effects": others})
    bodies, candidates = bind(scene).model.bodies, list[tuple[str, Effect]]()
    if any(body.radius > 0 for body in bodies):
        candidates.append(("drag in still air", Drag()))
    candidates.append((f"Earth's rotation, for example at {LATITUDE:g} degrees", Rotation(latitude=LATITUDE)))
    damping = SMALL_DAMPING * max(body.mass * 9.81 * float(np.linalg.norm(body.com)) for body in bodies)
    if damping:  # 0 for bodies on their axes
        candidates.append((f"viscous joints, for example {damping:.2g} N m s/rad", Viscous(coefficient=damping)))
    for name, effect in candidates:
        if effect.kind not in {own.kind for own in scene.effects}:
            yield name, False, effect, scene.model_copy(update={"effects": (*scene.effects, effect)})
    if isinstance(scene.model, Chain) and any(rod.radius and rod.inertia is None for rod in scene.model.rods):
        thin = tuple(Rod(**rod.model_dump() | {"radius": THINNER * rod.radius}) for rod in scene.model.rods)
        model = Chain(rods=thin, copies=scene.model.copies)
        dragged = any(isinstance(effect, Drag) and effect.diameter is None for effect in scene.effects)
        name = "thickness of the rods, with their drag" if dragged else "thickness of the rods"
        yield name, True, None, scene.model_copy(update={"model": model})


def _measure_distance(scene: Scene, one: RunRecord, other: RunRecord) -> Array:
    """How far two runs are apart, over the length, at the samples (n,) of the scene that both have."""
    model, count = build(scene.model), min(len(one.t), len(other.t), len(scene.times))
    here, there = (marks(model, run.tips, run.q)[:count] for run in (one, other))
    return tip_distance(here, there, scale(model))


def _measure_evaluation(run: RunRecord, engine: str) -> float:
    """Seconds of one evaluation of the right-hand side of a run on an engine: the least of some repetitions."""
    dynamics = bind(run.source.with_solver(engine=engine))
    y = dynamics.engine.pack(*start_state(dynamics.model, run.source.start))
    if isinstance(dynamics.engine, Compiled):
        call = partial(dynamics.engine.block().evaluated, np.zeros(MANY), np.tile(y, (MANY, 1)))
        return min(timeit.repeat(call, timer=process_time, repeat=REPETITIONS, number=1)) / MANY
    derivative, _ = dynamics.engine.derivative(lambda t: None)
    call = partial(derivative, np.empty_like(y), 0.0, y)
    return min(timeit.repeat(call, timer=process_time, repeat=REPETITIONS, number=CALLS)) / CALLS
