"""Running a scene with its solver: the lane goes over the output times, stretch by stretch; the motion is filled in."""

import time

import numpy as np

from pendpin import kinematics
from pendpin.contacts import check_start
from pendpin.derivations.base import Array
from pendpin.dynamics import Dynamics, bind, reactions
from pendpin.engines import Watch
from pendpin.errors import InputError, RunError
from pendpin.guards import Patience, balanced
from pendpin.hybrid import Hybrid
from pendpin.ledger import Ledger
from pendpin.model import start_state
from pendpin.records import LARGEST
from pendpin.scene import Scene
from pendpin.solvers import Lane, Run, automatic, lane_for
from pendpin.trajectory import Stats, Trajectory

EVALUATIONS_A_STRETCH = 20_000
FIRST_STRETCH = 1  # output times
NEAR_POLE = 0.3  # of cos(phi)
START_OVERFLOWS = f"start: positions, rates, forces or energies beyond {LARGEST:g}, too large to compute with"
TOO_LARGE = f"its numbers grow beyond {LARGEST:g}"
OFF_THE_BOOKS = "the energy no longer adds up, by over a tenth of what has moved: take a smaller tolerance or step"


class Interrupted(RunError):
    """The run was stopped by the user."""


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # what overflows is found, and said
def run_scene(scene: Scene, ledger: bool, watch: Watch, limit: float | None = None) -> Trajectory:
    """The motion of a scene by its method and tolerance or step; as `simulate`, which see."""
    dynamics = bind(scene)
    q, v = start_state(dynamics.model, scene.start)
    _refuse_overflow(scene, dynamics, q, v)
    if scene.solver.method == "auto":
        solver = scene.solver.replaced(method=automatic(dynamics, q, v, scene.duration))
        scene = scene.model_copy(update={"solver": solver})
    lane = lane_for(scene, dynamics)
    books = Ledger(dynamics, scene.effects) if ledger else None
    patience = Patience(scene.duration, limit, watch)
    if dynamics.contacts is None:
        run = _drive(lane, dynamics, books, q, v, scene.times, patience)
    else:
        check_start(dynamics.contacts, dynamics.model, q)
        run = Hybrid(dynamics, books, lane).drive(q, v, scene.times, patience)
    return _told(scene, dynamics, books, run)


def _told(scene: Scene, dynamics: Dynamics, books: Ledger | None, run: Run) -> Trajectory:
    """The trajectory of a run that came to its end; else RunError with the good part of it."""
    trajectory = _fill_in(scene, dynamics, books, run)
    if trajectory.sound == 0:
        raise InputError(START_OVERFLOWS)
    for count, why in ((trajectory.sound, TOO_LARGE), (balanced(trajectory), OFF_THE_BOOKS)):
        if count < len(run.t):
            run = run.cut(count, why)
            trajectory = _fill_in(scene, dynamics, books, run)
    if run.failure is None:
        return trajectory
    end = scene.start.time + scene.duration
    reason = f"the run ended at t = {trajectory.t[-1]:.10g} s of {end:.10g} s: {run.failure}"
    raise (Interrupted if run.interrupted else RunError)(reason + _remedy(dynamics, run), trajectory)


def _remedy(dynamics: Dynamics, run: Run) -> str:
    """What may be behind a failure: a thin rod near the pole that something turns about its joint; the fastest joint."""
    model, v = dynamics.model, np.abs(run.v[-1])
    if run.interrupted or run.failure == OFF_THE_BOOKS:
        return ""
    if model.chain is not None:
        near = (np.abs(np.cos(run.q[-1, 1::2])) < NEAR_POLE) & (model.chain.I3 == 0)
        if near.any():
            rod = model.rods[int(np.argmax(near))].link
            return f"; {rod} is thin and near phi = 90 degrees, where nothing resists a torque about theta: give it a radius"
    return f"; fastest there: {model.joints[int(np.argmax(v))]}, at {v.max():.3g} (rad/s)"


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
        except RunError as error:
            failure = str(error)
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
        t=scene.start.time + run.t,
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
