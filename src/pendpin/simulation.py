"""Running a scene: the lane is driven over the output times, stretch by stretch, and the motion is filled in."""

import time

import numpy as np

from pendpin import kinematics
from pendpin.contacts import check_start
from pendpin.derivations.base import Array
from pendpin.dynamics import Dynamics, bind, reactions
from pendpin.engines import Watch
from pendpin.errors import InputError, RunError
from pendpin.hybrid import Hybrid
from pendpin.ledger import Ledger
from pendpin.model import start_state
from pendpin.records import LARGEST
from pendpin.scene import Scene
from pendpin.solvers import Lane, Run, lane_for
from pendpin.trajectory import Stats, Trajectory

EVALUATIONS_A_STRETCH = 20_000
FIRST_STRETCH = 1  # output times
NEAR_POLE = 0.3  # of cos(phi)
START_OVERFLOWS = f"start: positions, rates, forces or energies beyond {LARGEST:g}, too large to compute with"


class Interrupted(RunError):
    """The run was stopped by the user."""


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # what overflows is found, and said
def simulate(
    scene: Scene,
    *,
    method: str | None = None,
    tolerance: float | None = None,
    step: float | None = None,
    ledger: bool = False,
    watch: Watch = lambda t: None,
) -> Trajectory:
    """The motion of a scene at its output times.

    method, tolerance and step stand in for those of scene.solver; `ledger` books the work of every effect along the way, in
    the trajectory's `work`. `watch` is called with the time reached, for progress.
    Raises InputError for a scene that cannot be run, RunError for a run that cannot reach its end: the error's
    `partial` is the Trajectory up to there.
    """
    wanted = {"method": method, "tolerance": tolerance, "step": step}
    solver = scene.solver.replaced(**{name: value for name, value in wanted.items() if value is not None})
    scene = scene.model_copy(update={"solver": solver})
    dynamics = bind(scene)
    lane = lane_for(scene, dynamics)
    q, v = start_state(dynamics.model, scene.start)
    _refuse_overflow(scene, dynamics, q, v)
    books = Ledger(dynamics, scene.effects) if ledger else None
    if dynamics.contacts is None:
        run = _drive(lane, dynamics, books, q, v, scene.times, watch)
    else:
        check_start(dynamics.contacts, dynamics.model, q)
        run = Hybrid(dynamics, books, lane).drive(q, v, scene.times, watch)
    trajectory = _fill_in(scene, dynamics, books, run)
    if trajectory.sound == 0:
        raise InputError(START_OVERFLOWS)
    if trajectory.sound < len(run.t):
        run = run.cut(trajectory.sound, f"its numbers grow beyond {LARGEST:g}")
        trajectory = _fill_in(scene, dynamics, books, run)
    if run.failure is None:
        return trajectory
    reason = f"the run ended at t = {run.t[-1]:g} s of {scene.duration:g} s: {run.failure}{_remedy(dynamics, run)}"
    raise (Interrupted if run.interrupted else RunError)(reason, trajectory)


def _remedy(dynamics: Dynamics, run: Run) -> str:
    """What may be behind a failure: a thin rod near the pole that something turns about its joint."""
    chain = dynamics.model.chain
    if run.interrupted or chain is None:
        return ""
    near = (np.abs(np.cos(run.q[-1, 1::2])) < NEAR_POLE) & (chain.I3 == 0)
    if not near.any():
        return ""
    rod = dynamics.model.rods[int(np.argmax(near))].link
    return f"; {rod} is thin and near phi = 90 degrees, where nothing resists a torque about theta: give it a radius"


def _refuse_overflow(scene: Scene, dynamics: Dynamics, q: Array, v: Array) -> None:
    """Raise InputError for a start whose forces and energies cannot be computed."""
    first = Run(np.zeros(1), q[None], v[None], None, np.zeros((1, 0)), 0, 0, 0, 0.0, "", "")
    try:
        sound = _fill_in(scene, dynamics, None, first).sound
    except np.linalg.LinAlgError as error:
        raise InputError(f"start: {error}") from None
    if not sound:
        raise InputError(START_OVERFLOWS)


def _drive(lane: Lane, dynamics: Dynamics, books: Ledger | None, q: Array, v: Array, times: Array, watch: Watch) -> Run:
    """Integrate over `times` in stretches of about EVALUATIONS_A_STRETCH, so that what is done is kept."""
    engine = dynamics.engine
    derivative, evaluations = lane.equations(engine, watch)
    y, q, v = engine.pack(q, v), q[None], v[None]
    size, work = len(y), np.zeros((1, 0))
    if books is not None:
        derivative, work = books.booked(derivative, size), np.zeros((1, len(books.kinds)))
    steps, failure, interrupted, first_step, ahead = 0, None, False, None, FIRST_STRETCH
    begin = time.perf_counter()
    while len(q) < len(times) and failure is None and not interrupted:
        before, span = evaluations(), times[len(q) - 1 :][: ahead + 1]
        try:
            stretch = lane.integrate(derivative, np.concatenate([y, work[-1]]), span, first_step)
        except KeyboardInterrupt:
            failure, interrupted = "stopped by the user", True
            continue
        except np.linalg.LinAlgError as error:
            failure = f"{error}; a rod with a radius has no such place"
            continue
        more_q, more_v = engine.unpack(span[1 : len(stretch.y)], stretch.y[1:, :size], q[-1])
        q, v, y = np.concatenate([q, more_q]), np.concatenate([v, more_v]), engine.settle(stretch.y[-1, :size])
        work = np.concatenate([work, stretch.y[1:, size:]])
        steps, failure = steps + stretch.steps, stretch.failure
        first_step = (span[-1] - span[0]) / max(stretch.steps, 1)
        ahead = max(1, ahead * EVALUATIONS_A_STRETCH // max(evaluations() - before, 1))
    seconds = time.perf_counter() - begin
    carried = (lane.library, lane.version, failure, interrupted, lane.compile_seconds)
    return Run(times[: len(q)], q, v, None, work, steps, evaluations(), 0, seconds, *carried)


def _fill_in(scene: Scene, dynamics: Dynamics, books: Ledger | None, run: Run) -> Trajectory:
    """Accelerations, wrenches, energies and tips along the run."""
    model, solver = dynamics.model, scene.solver
    a, wrench = dynamics.engine.evaluate(run.t, run.q, run.v, run.torque)
    poses = kinematics.poses(model, run.q)
    return Trajectory(
        joints=model.joints,
        t=run.t,
        q=run.q,
        v=run.v,
        a=a,
        wrench=wrench,
        kinetic=kinematics.kinetic_energy(model, run.q, run.v),
        potential=dynamics.potential(run.q, poses),
        tip=kinematics.tips(model, poses),
        rods=reactions(model, run.q, wrench),
        stats=Stats(
            *(solver.method, solver.tolerance, solver.step),
            *(run.steps, run.evaluations, run.events, run.seconds, run.compile_seconds),
            *(dynamics.engine.name, run.library, run.version, dynamics.conservative, run.failure),
        ),
        work={} if books is None else books.close(run.work, run.q, poses),
        scene=scene.model_dump(mode="json"),
    )
