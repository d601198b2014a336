"""Running a scene: the lane is driven over the output times, stretch by stretch, and the motion is filled in."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pendpin.derivations.base import Array
from pendpin.dynamics import Dynamics, bind, reactions
from pendpin.errors import RunError
from pendpin.kinematics import poses, tips
from pendpin.model import start_state
from pendpin.scene import Scene, Solver
from pendpin.solvers import Adaptive, Lane
from pendpin.trajectory import Stats, Trajectory

EVALUATIONS_A_STRETCH = 20_000
FIRST_STRETCH = 16  # output times

Watch = Callable[[float], None]


class Interrupted(RunError):
    """The run was stopped by the user."""


def simulate(
    scene: Scene, *, method: str | None = None, tolerance: float | None = None, watch: Watch = lambda t: None
) -> Trajectory:
    """The motion of a scene at its output times.

    method and tolerance stand in for those of scene.solver. `watch` is called with the time reached, for progress.
    Raises InputError for a scene that cannot be run, RunError for a run that cannot reach its end: the error's
    `partial` is the Trajectory up to there.
    """
    wanted = {"method": method, "tolerance": tolerance}
    chosen = {name: value for name, value in wanted.items() if value is not None}
    solver = Solver(**(scene.solver.model_dump() | chosen))
    scene = scene.model_copy(update={"solver": solver})
    dynamics = bind(scene)
    q, v = start_state(dynamics.model, scene.start)
    lane = Adaptive(solver.method, solver.tolerance)
    run = _drive(lane, dynamics, np.concatenate([q, v]), scene.times, watch)
    trajectory = _fill_in(scene, dynamics, lane, run)
    if run.failure is None:
        return trajectory
    reason = f"the run ended at t = {run.t[-1]:g} s of {scene.duration:g} s: {run.failure}"
    raise (Interrupted if run.interrupted else RunError)(reason, trajectory)


@dataclass(frozen=True)
class _Run:
    """What the lane has done."""

    t: Array
    y: Array
    steps: int
    evaluations: int
    seconds: float
    failure: str | None
    interrupted: bool


def _drive(lane: Lane, dynamics: Dynamics, y: Array, times: Array, watch: Watch) -> _Run:
    """Integrate over `times` in stretches of about EVALUATIONS_A_STRETCH, so that what is done is kept."""
    derivative, evaluations = dynamics.derivative(watch)
    states, steps, failure, interrupted = y[None], 0, None, False
    first_step, size = None, FIRST_STRETCH
    begin = time.perf_counter()
    while len(states) < len(times) and failure is None and not interrupted:
        before, span = evaluations(), times[len(states) - 1 :][: size + 1]
        try:
            stretch = lane.integrate(derivative, states[-1], span, first_step)
        except KeyboardInterrupt:
            failure, interrupted = "stopped by the user", True
            continue
        states = np.concatenate([states, stretch.y[1:]])
        steps, failure = steps + stretch.steps, stretch.failure
        first_step = (span[-1] - span[0]) / max(stretch.steps, 1)
        size = max(1, size * EVALUATIONS_A_STRETCH // max(evaluations() - before, 1))
    seconds = time.perf_counter() - begin
    return _Run(times[: len(states)], states, steps, evaluations(), seconds, failure, interrupted)


def _fill_in(scene: Scene, dynamics: Dynamics, lane: Lane, run: _Run) -> Trajectory:
    """Accelerations, wrenches, energies and tips along the run."""
    nv = run.y.shape[1] // 2
    q, v = run.y[:, :nv].copy(), run.y[:, nv:].copy()
    rows = [_sample(dynamics, t, *state) for t, *state in zip(run.t, q, v, strict=True)]
    a, wrench, energy = (np.array(column) for column in zip(*rows, strict=True))
    solver = scene.solver
    counts = (run.steps, run.evaluations, run.seconds, 0.0)
    stats = Stats(solver.method, solver.tolerance, *counts, lane.library, lane.version, run.failure)
    return Trajectory(
        joints=dynamics.model.joints,
        t=run.t,
        q=q,
        v=v,
        a=a,
        wrench=wrench,
        kinetic=energy[:, 0],
        potential=energy[:, 1],
        tip=tips(dynamics.model, poses(dynamics.model, q)),
        rods=reactions(dynamics.model, q, wrench),
        stats=stats,
        scene=scene.model_dump(mode="json"),
    )


def _sample(dynamics: Dynamics, t: float, q: Array, v: Array) -> tuple[Array, Array, tuple[float, float]]:
    return dynamics.acceleration(t, q, v), dynamics.wrenches(t, q, v), dynamics.energy(q, v)
