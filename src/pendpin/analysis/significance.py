"""Which effects a scene needs: what each one changes, and what it costs."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.dynamics import bind
from pendpin.effects import Drag, Effect, Rotation, Viscous
from pendpin.errors import InputError, PendpinError, brief
from pendpin.model.build import build, start_state
from pendpin.model.kinematics import marks, scale, tip_distance
from pendpin.scene import Chain, Rod, Scene
from pendpin.simulation.simulate import run_to_setting
from pendpin.trajectory import Trajectory

TOLERANCES = (1e-9, 1e-11)  # of the runs compared, and of the run that shows their error
MARGIN = 0.1  # of the accuracy: where two runs of the same scene differ by more, the comparison ends
SMALL_DAMPING = 1e-4  # N m s/rad per N m of the heaviest rod's weight times its lever: a good bearing
LATITUDE = 45.0  # degrees
CALLS, REPETITIONS = 40, 5
SAMPLES = 201  # output times at most, at which tips are compared


@dataclass(frozen=True)
class Row:
    """What one effect changes and costs."""

    effect: str
    listed: bool  # True if the scene has the effect; False if it was added for the comparison
    change: float  # largest distance between the tips with and without it, divided by the chain's length
    share: float | None  # of an evaluation's time; None where that has no meaning
    verdict: str


@dataclass(frozen=True, repr=False)
class EffectsReport:
    """The effects of a scene at an accuracy, compared from the start to `horizon`."""

    rows: tuple[Row, ...]
    accuracy: float
    duration: float  # s, of the scene
    horizon: float  # s, end of the comparison; shorter than `duration` in chaotic motion

    def __repr__(self) -> str:
        rows = "; ".join(f"{row.effect}: {row.verdict}, changes {row.change:.1e}" for row in self.rows)
        return brief(f"Effects at an accuracy of {self.accuracy:g}: {rows}")


def significance(scene: Scene, accuracy: float = 1e-3) -> EffectsReport:
    """How much every effect of a scene changes the motion, and how much some effects that it lacks would change it:
    drag, Earth's rotation, viscous joints, the thickness of its rods.

    The change is the largest distance between the tips with and without the effect during the run, divided by the
    chain's length. The comparison ends where two runs of the same scene, at two tolerances, differ by more than a tenth
    of the accuracy, as in chaotic motion. Raises InputError for an accuracy that is not between 0 and 1, and what
    `simulate` raises.
    """
    if not 0 < accuracy < 1:
        raise InputError(f"accuracy: {accuracy:g} is not between 0 and 1")
    samples = min(scene.solver.samples or SAMPLES, SAMPLES) if len(scene.times) > SAMPLES else None
    scene = scene.with_solver(samples=samples)
    base, finer = (run_to_setting(scene.by("auto", tolerance)) for tolerance in TOLERANCES)
    length = scale(build(scene.model))
    good = int(
        np.argmax(np.append(tip_distance(_marks(scene, base), _marks(scene, finer), length) > MARGIN * accuracy, True))
    )
    horizon = float(scene.times[max(good - 1, 0)])
    solver = scene.solver.model_copy(update={"samples": max(good, 1)})
    compared = scene.model_copy(update={"duration": horizon, "solver": solver})
    cost = _evaluation(scene)
    rows = [_row(name, listed, other, compared, base, accuracy, cost) for name, listed, other in _variants(compared)]
    return EffectsReport(tuple(rows), accuracy, scene.duration, horizon)


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


def _row(name: str, listed: bool, other: Scene, scene: Scene, base: Trajectory, accuracy: float, cost: float) -> Row:
    """What another scene changes against the base run; `cost` is that of an evaluation of the scene, s."""
    try:
        run = run_to_setting(other.by("auto", TOLERANCES[0]))  # what it leaves out is no slip: no notes
    except PendpinError as error:
        return Row(name, listed, float("nan"), None, f"not compared: {error}")
    length = scale(build(scene.model))
    change = float(tip_distance(_marks(scene, base)[: len(run.t)], _marks(scene, run), length).max())
    share = None
    if other.effects != scene.effects:
        more, less = (cost, _evaluation(other)) if listed else (_evaluation(other), cost)
        share = max(1 - less / more, 0.0)
    return Row(name, listed, change, share, _verdict(listed, change, accuracy))


def _marks(scene: Scene, run: Trajectory) -> Array:
    """The points that are compared (n, points, 3), m."""
    return marks(build(scene.model), run.tips(), run.q)


def _verdict(listed: bool, change: float, accuracy: float) -> str:
    if change > accuracy:
        return "needed" if listed else "needed, but not listed"
    return "not needed at this accuracy"


def _evaluation(scene: Scene) -> float:
    """Seconds of one evaluation of the scene's right-hand side, the least of some repetitions."""
    dynamics = bind(scene)
    y = dynamics.engine.pack(*start_state(dynamics.model, scene.start))
    derivative, _ = dynamics.engine.derivative(lambda t: None)
    return min(_seconds(lambda: derivative(np.empty_like(y), 0.0, y)) for _ in range(REPETITIONS))


def _seconds(call: Callable[[], None]) -> float:
    begin = time.perf_counter()
    for _ in range(CALLS):
        call()
    return (time.perf_counter() - begin) / CALLS
