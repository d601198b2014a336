"""The run of a scene by its solver: prepared once, integrated, completed by wrenches and energies, and checked."""

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pendpin.dynamics.dynamics import Dynamics
from pendpin.effects.pace import Pace, join_paces
from pendpin.engines import ProgressCallback
from pendpin.errors import Halted, InputError, Interrupted
from pendpin.ground.arrays import Array
from pendpin.ground.records import LARGEST
from pendpin.integrators import Run
from pendpin.integrators.choice import notes_on_stiffness
from pendpin.integrators.grid import count_whole_steps
from pendpin.model.build import start_state
from pendpin.runs.checkpoint import Checkpoint, Saver, identity
from pendpin.runs.integration import IntegrationLoop, integrate_to_end
from pendpin.runs.limits import Deadline, Patience, balanced
from pendpin.runs.motion_with_events import LoopWithEvents
from pendpin.runs.motion_without_events import SmoothLoop
from pendpin.runs.preparation import MACHINE_CODE, EnergyBalance, Prepared, bind_for_run
from pendpin.runs.samples import fill_in
from pendpin.runs.state import Shifts
from pendpin.scene import Scene
from pendpin.trajectory import RunRecord

SHORTER = 3.0  # times: at a corner between two samples steps err as their square, so a run in shorter ones shows it
NEAR_POLE = 0.3  # of cos(phi)
LONG_ENOUGH = 5e-3  # s, of a measurement of the time to complete samples
SLACK = 1.2  # margin on that time
START_OVERFLOWS = f"start: positions, rates, forces or energies beyond {LARGEST:g}, too large to compute with"
TOO_LARGE = f"its numbers grow beyond {LARGEST:g}"
ENERGY_ERROR = "the energy is off by over a tenth of the energy exchanged: take a smaller tolerance or step"


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # what overflows is found, and said
def prepare(scene: Scene, energy_balance: bool, deadline: Deadline) -> Prepared:
    """The scene, ready to be run: bound, its method and engine chosen.

    Raises InputError for a scene that cannot be run; Halted at the deadline, as compiling may take long, with a run of the
    start alone.
    """
    compiles = scene.solver.method == "auto" and scene.solver.engine in MACHINE_CODE  # what the choice is made by
    try:
        prepared = deadline.wait_for(lambda: Prepared.of(scene, energy_balance), compiles)
    except Halted as error:
        dynamics = bind_for_run(scene)
        _finished(scene, dynamics, None, _start_alone(*start_state(dynamics.model, scene.start), error), None)
        raise
    return prepared


@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def run_prepared(
    prepared: Prepared,
    progress: ProgressCallback,
    deadline: Deadline,
    checkpoint: Checkpoint | None = None,
    shifts: Shifts | None = None,
    longest: float = np.inf,
    anyway: bool = False,
    pilot: bool = False,
) -> RunRecord:
    """The motion of a scene at its output times, by its method and tolerance or step.

    Args:
        prepared: the scene.
        progress: called with the time reached, s.
        deadline: of the run with all its samples.
        checkpoint: a file from which the run continues, and in which it is saved.
        shifts: of the state during the motion; its energy is then not checked.
        longest: s, the longest step of a method without a fixed one.
        anyway: a wrong energy is a note, not an error.
        pilot: its samples are computed when they are first asked for, and its energy is not checked.

    Raises:
        InputError: for a scene that its method cannot run.
        RunError: for a run that ends early; `partial` is the run up to there.
    """
    scene, dynamics, saver = prepared.scene, prepared.dynamics, None
    if checkpoint:
        saver = Saver(checkpoint, identity(scene, prepared.balance is not None, dynamics.engine.name))
    reserve = (lambda t: 0.0) if deadline.limit is None else _measure_reserve(prepared)
    patience = Patience(scene.duration, deadline, reserve, progress)
    try:
        loop = deadline.wait_for(lambda: loop_of(prepared, patience, longest), prepared.compiles)
    except Halted as error:
        return _finished(scene, dynamics, None, _start_alone(prepared.q, prepared.v, error), saver)
    run = integrate_to_end(loop, prepared.q, prepared.v, saver, shifts)
    run = replace(run, notes=(*prepared.notes, *notes_on_stiffness(scene, run.steps)))
    if pilot and run.failure is None and (np.abs([run.q, run.v]) <= LARGEST).all():
        return fill_in(scene, dynamics, prepared.balance, run, lazily=True)
    guarded = shifts is None and not anyway  # else the state was changed, or it is to run on with a wrong energy
    trajectory = _finished(scene, dynamics, prepared.balance, run, saver, guarded)
    if not anyway or (count := balanced(trajectory)) == len(trajectory.t):
        return trajectory
    note = f"from t = {trajectory.t[count]:.6g} s on the energy is off by over a tenth of the energy exchanged"
    return replace(trajectory, stats=replace(trajectory.stats, notes=(note, *trajectory.stats.notes)))


def loop_of(prepared: Prepared, progress: ProgressCallback, longest: float = np.inf) -> IntegrationLoop:
    """The loop that integrates a scene, with steps up to `longest` in s: with events where the scene has contacts.

    If that is finite, the run is compared with one that the pace of the effects alone limits: a third of that is the most
    here. Raises InputError for a scene that the method cannot run.
    """
    pace = prepared.timing.pace
    if longest < np.inf:
        pace = join_paces([pace._replace(shortest=np.asarray(pace.shortest) / SHORTER), Pace.even(longest)])
    kind = SmoothLoop if prepared.dynamics.contacts is None else LoopWithEvents
    return kind(prepared, pace, progress)


def _start_alone(q: Array, v: Array, failure: Halted | None = None) -> Run:
    """The start q, v (nv,) as a run that was not integrated."""
    return replace(Run.at_states(np.zeros(1), q[None], v[None]), failure=failure)


def _finished(
    scene: Scene, dynamics: Dynamics, balance: EnergyBalance | None, run: Run, saver: Saver | None, guarded: bool = True
) -> RunRecord:
    """The trajectory of a run that reached its end. Else raises RunError with the good part of the run and a remedy.

    `guarded`: the run ends where the energies do not add up.
    """
    try:
        trajectory = fill_in(scene, dynamics, balance, run)
    except np.linalg.LinAlgError as error:
        run = _solvable(scene, dynamics, balance, run, str(error))
        trajectory = fill_in(scene, dynamics, balance, run)
    if (count := trajectory.sound) == 0:
        raise InputError(START_OVERFLOWS)
    if count < len(run.t):
        run = _cut(scene, run, count, TOO_LARGE)
        trajectory = fill_in(scene, dynamics, balance, run)
    if guarded and (count := balanced(trajectory)) < len(run.t):
        run = _cut(scene, run, count, ENERGY_ERROR)
        trajectory = fill_in(scene, dynamics, balance, run)
    if run.failure is None:
        return trajectory
    end = scene.start.time + scene.duration
    stop = trajectory.t[-1] if run.stop is None else scene.start.time + run.stop.t
    reason = f"the run ended at t = {stop:.10g} s of {end:.10g} s: {run.failure}"
    more = _remedy(dynamics, run) + (saver.note if saver and isinstance(run.failure, Halted) else "")
    raise run.failure.said(reason + more, trajectory)


def _cut(scene: Scene, run: Run, count: int, why: str) -> Run:
    """The run up to so many samples, with the fixed steps up to there; others are not counted by samples."""
    step, short = scene.solver.step, run.cut(count, why)
    return (
        short if step is None else replace(short, steps=min(run.steps, count_whole_steps(scene.times[count - 1], step)))
    )


def _solvable(scene: Scene, dynamics: Dynamics, balance: EnergyBalance | None, run: Run, why: str) -> Run:
    """The run before the first sample at which the equations have no solution. Raises InputError if that is the start."""
    good, bad = 0, len(run.t)
    while bad - good > 1:
        middle = (good + bad) // 2
        try:
            fill_in(scene, dynamics, balance, run.cut(middle, why))
        except np.linalg.LinAlgError:
            bad = middle
        else:
            good = middle
    if good == 0:
        raise InputError(f"start: {why}")
    return _cut(scene, run, good, why)


def _remedy(dynamics: Dynamics, run: Run) -> str:
    """A likely reason of a failure: a thin rod near the pole with a torque about its joint; else the fastest joint."""
    model, (q, v) = dynamics.model, (run.q[-1], run.v[-1]) if run.stop is None else (run.stop.q, run.stop.v)
    if isinstance(run.failure, Interrupted):
        return ""
    if dynamics.engine.on_angles and (rod := model.thin_at_pole(q, NEAR_POLE)):
        return (
            f"; {rod} is thin and near phi = 90 degrees, where nothing resists a torque about theta: give it a radius"
        )
    if str(run.failure) == ENERGY_ERROR:
        return ""
    return f"; fastest there: {model.joints[int(np.argmax(np.abs(v)))]}, at {np.abs(v).max():.3g} (rad/s)"


def _measure_reserve(prepared: Prepared) -> Callable[[float], float]:
    """The measured time in s to complete the samples of a run up to a time t."""
    scene, start = prepared.scene, _start_alone(prepared.q, prepared.v)
    count, seconds, times = 0, 0.0, scene.times
    while seconds < LONG_ENOUGH and count < len(times):
        count = max(1, 4 * count)
        rows = {name: np.repeat(getattr(start, name), count, axis=0) for name in ("t", "q", "v", "work")}
        begin = time.thread_time()  # other processes make no difference
        fill_in(scene, prepared.dynamics, None, replace(start, **rows))
        seconds = time.thread_time() - begin
    return lambda t: SLACK * seconds * max(1.0, np.searchsorted(times, t, "right") / count)
