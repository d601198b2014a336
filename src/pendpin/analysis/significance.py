"""Which effects a scene needs: what each one changes, and what it costs."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from pendpin.analysis.work_precision.processor_time import run_within
from pendpin.arrays import Array
from pendpin.dynamics.dynamics import bind
from pendpin.effects import Drag, Effect, Rotation, Viscous
from pendpin.engines import Compiled
from pendpin.errors import InputError, PendpinError, brief
from pendpin.model.build import build, start_state
from pendpin.model.kinematics import marks, scale, tip_distance
from pendpin.scene import Chain, Rod, Scene
from pendpin.trajectory import Trajectory

CHAOTIC = "later the motion is not known to this accuracy"
LARGE = "more would take long, as --thorough does"
TOLERANCES = (1e-9, 1e-11)  # of the runs compared, and of the run that shows their error
MARGIN = 0.1  # of the accuracy: where two runs of the same scene differ by more, the comparison ends
SMALL_DAMPING = 1e-4  # N m s/rad per N m of the heaviest rod's weight times its lever: a good bearing
LATITUDE = 45.0  # degrees
CALLS, MANY, REPETITIONS = 40, 400, 5  # of an evaluation from Python, in machine code
BUDGET = 0.5  # s of processor time for each of the runs compared, beside compiling
SAMPLES = 201  # output times at most, at which tips are compared


@dataclass(frozen=True)
class EffectRow:
    """What one effect changes and costs."""

    effect: str
    listed: bool  # True if the scene has the effect; False if it was added for the comparison
    change: float  # largest distance between the tips with and without it, divided by the chain's length
    share: float | None  # of an evaluation's time; None where that has no meaning
    verdict: str


@dataclass(frozen=True, repr=False)
class EffectsReport:
    """The effects of a scene at an accuracy, compared from the start to `horizon`."""

    rows: tuple[EffectRow, ...]
    accuracy: float
    duration: float  # s, of the scene
    horizon: float  # s, end of the comparison; shorter than `duration` in chaotic motion and in large models
    why: str = ""  # it ends before the scene does

    def __repr__(self) -> str:
        rows = "; ".join(f"{row.effect}: {row.verdict}, changes {row.change:.1e}" for row in self.rows)
        return brief(f"Effects at an accuracy of {self.accuracy:g}: {rows}")


def significance(scene: Scene, accuracy: float = 1e-3, thorough: bool = False) -> EffectsReport:
    """How much every effect of a scene changes the motion, and how much some effects that it lacks would change it:
    drag, Earth's rotation, viscous joints, the thickness of its rods.

    The change is the largest distance between the tips with and without the effect during the run, divided by the
    chain's length. The comparison ends where two runs of the same scene, at two tolerances, differ by more than a tenth
    of the accuracy, as in chaotic motion, and, unless `thorough`, where a run has taken half a second of processor time.
    Raises InputError for an accuracy that is not between 0 and 1, and what `simulate` raises.
    """
    if not 0 < accuracy < 1:
        raise InputError(f"accuracy: {accuracy:g} is not between 0 and 1")
    samples = min(scene.solver.samples or SAMPLES, SAMPLES) if len(scene.times) > SAMPLES else None
    scene = scene.with_solver(samples=samples)
    budget = np.inf if thorough else BUDGET
    base = run_within(budget, scene.by("auto", TOLERANCES[0]))
    affordable = _cut(scene, len(base.t))
    finer = run_within(2 * budget, affordable.by("auto", TOLERANCES[1]))
    length = scale(build(scene.model))
    off = tip_distance(_marks(scene, base)[: len(finer.t)], _marks(scene, finer), length) > MARGIN * accuracy
    compared = _cut(affordable, int(np.argmax(np.append(off, True))))
    whole = compared.duration == scene.duration
    why = "" if whole else CHAOTIC if off.any() else LARGE
    cost, rows = _evaluation(base), []
    for name, listed, other in _variants(compared):
        change, share, problem = _change(listed, other, compared, base, cost, 2 * budget)
        verdict = problem or _verdict(listed, change, accuracy) + ("" if whole else f" up to {compared.duration:.2g} s")
        rows.append(EffectRow(name, listed, change, share, verdict))
    return EffectsReport(tuple(rows), accuracy, scene.duration, compared.duration, why)


def _cut(scene: Scene, count: int) -> Scene:
    """The scene up to the last of so many of its output times, of the first at least."""
    return scene.with_solver(samples=max(count, 1)).model_copy(
        update={"duration": float(scene.times[max(count - 1, 0)])}
    )


def _variants(scene: Scene) -> Iterator[tuple[str, bool, Scene]]:
    """The scene without each of its effects, and with each of the candidates that it lacks."""
    for i, effect in enumerate(scene.effects):
        yield effect.kind, True, _with(scene, *scene.effects[:i], *scene.effects[i + 1 :])
    kinds = {effect.kind for effect in scene.effects}
    for name, effect in _candidates(scene):
        if effect.kind not in kinds:
            yield name, False, _with(scene, *scene.effects, effect)
    if isinstance(scene.model, Chain) and any(rod.radius and rod.inertia is None for rod in scene.model.rods):
        thin = tuple(Rod(**rod.model_dump() | {"radius": 0.0}) for rod in scene.model.rods)
        model = Chain(rods=thin, copies=scene.model.copies)
        yield "thickness of the rods", True, scene.model_copy(update={"model": model})


def _candidates(scene: Scene) -> Iterator[tuple[str, Effect]]:
    bodies = bind(scene).model.bodies
    if any(body.radius > 0 for body in bodies):
        yield "drag in still air", Drag()
    yield f"Earth's rotation at {LATITUDE:g} degrees", Rotation(latitude=LATITUDE)
    coefficient = SMALL_DAMPING * max(body.mass * 9.81 * float(np.linalg.norm(body.com)) for body in bodies)
    if coefficient:  # 0 for bodies on their axes
        yield f"viscous joints, {coefficient:.2g} N m s/rad", Viscous(coefficient=coefficient)


def _with(scene: Scene, *effects: Effect) -> Scene:
    return scene.model_copy(update={"effects": effects})


def _change(
    listed: bool, other: Scene, scene: Scene, base: Trajectory, cost: float, budget: float
) -> tuple[float, float | None, str]:
    """What another scene changes against the base run, its share of an evaluation, and why it is not compared if it is not.

    `cost` is that of an evaluation of the scene, s.
    """
    try:
        run = run_within(budget, other.by("auto", TOLERANCES[0]))  # what it leaves out is no slip: no notes
    except PendpinError as error:
        return float("nan"), None, f"not compared: {error}"
    count = min(len(run.t), len(scene.times))
    change = float(
        tip_distance(_marks(scene, base)[:count], _marks(scene, run)[:count], scale(build(scene.model))).max()
    )
    if other.effects == scene.effects:
        return change, None, ""
    more, less = (cost, _evaluation(run)) if listed else (_evaluation(run), cost)
    return change, max(1 - less / more, 0.0) if more else 0.0, ""  # a clock may not have moved


def _marks(scene: Scene, run: Trajectory) -> Array:
    """The points that are compared (n, points, 3), m."""
    return marks(build(scene.model), run.tips(), run.q)


def _verdict(listed: bool, change: float, accuracy: float) -> str:
    if change > accuracy:
        return "needed" if listed else "needed, but not listed"
    return "not needed at this accuracy"


def _evaluation(run: Trajectory) -> float:
    """Seconds of one evaluation of the right-hand side of a run, on its engine: the least of some repetitions."""
    dynamics = bind(run.source)
    y = dynamics.engine.pack(*start_state(dynamics.model, run.source.start))
    if isinstance(dynamics.engine, Compiled):
        block, many = dynamics.engine.block(), (np.zeros(MANY), np.tile(y, (MANY, 1)))
        return min(_seconds(lambda: block.evaluated(*many)) for _ in range(REPETITIONS)) / MANY
    derivative, _ = dynamics.engine.derivative(lambda t: None)

    def calls() -> None:
        for _ in range(CALLS):
            derivative(np.empty_like(y), 0.0, y)

    return min(_seconds(calls) for _ in range(REPETITIONS)) / CALLS


def _seconds(call: Callable[[], object]) -> float:
    begin = time.process_time()
    call()
    return time.process_time() - begin
