"""Running a scene with its solver: its motion is integrated, its wrenches and energies are computed, and it is checked."""

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pendpin.dynamics.binding.acting import built_in
from pendpin.dynamics.binding.contacts import check_start
from pendpin.dynamics.dynamics import Dynamics, bind, reactions
from pendpin.effects.pace import Pace, join_paces
from pendpin.engines import ProgressCallback
from pendpin.errors import Halted, InputError, Interrupted
from pendpin.ground.arrays import Array
from pendpin.ground.records import LARGEST
from pendpin.integrators import Run, automatic
from pendpin.integrators.grid import count_whole_steps, largest_step
from pendpin.integrators.taylor import Taylor
from pendpin.model import kinematics
from pendpin.model.build import start_state
from pendpin.runs.checkpoint import Checkpoint, FileSaver, RunState, Saver, identity
from pendpin.runs.energy_balance import EnergyBalance
from pendpin.runs.integration import integrate_to_end, task_of
from pendpin.runs.limits import Deadline, Patience, balanced
from pendpin.runs.motion_with_events import loop_of
from pendpin.scene import Scene, method_of
from pendpin.trajectory import Derived, Reactions, RunRecord, Stats

PART, LEAST = 1 << 12, 64  # rods, and samples, completed at once: what they need stays in a processor's fast memory
AUTOMATIC = ("auto", "compiled")  # engines with which samples are computed in machine code
NEAR_POLE = 0.3  # of cos(phi)
LONG_ENOUGH = 5e-3  # s, of a measurement of the time to complete samples
SLACK = 1.2  # margin on that time
START_OVERFLOWS = f"start: positions, rates, forces or energies beyond {LARGEST:g}, too large to compute with"
TOO_LARGE = f"its numbers grow beyond {LARGEST:g}"
ENERGY_ERROR = "the energy is off by over a tenth of the energy exchanged: take a smaller tolerance or step"


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # what overflows is found, and said
def run_scene(
    scene: Scene,
    energy_balance: bool,
    progress: ProgressCallback,
    deadline: Deadline,
    checkpoint: Checkpoint | None = None,
    between: Callable[[RunState], RunState] | None = None,
    longest: float = np.inf,
    anyway: bool = False,
    bound: Dynamics | None = None,
) -> RunRecord:
    """The motion of a scene by its method and tolerance or step; as `simulate`, and `between` as in the loop, which see.

    `longest` in s limits the steps of a method without a fixed one. `anyway`: a wrong energy is a note, not an error.
    `bound`: the dynamics of the scene, if it is bound already.
    """
    dynamics = bound or bind_for_run(scene)
    q, v = start_state(dynamics.model, scene.start)
    start = Run.at_states(np.zeros(1), q[None], v[None])  # the first sample
    _refuse_overflow(dynamics, start)
    if dynamics.contacts is not None:
        check_start(dynamics.contacts, dynamics.model, q)
    saver = Saver()
    compiles = dynamics.engine.compiles
    try:
        deadline.wait_for(lambda: dynamics.engine.derivative(progress) if compiles else None, compiles)
        scene, dynamics = _choose_method(scene, dynamics, q, v, energy_balance)
        if checkpoint:
            saver = FileSaver(checkpoint, identity(scene, energy_balance, dynamics.engine.name))
        patience = Patience(scene.duration, deadline, _reserve(scene, dynamics, start, deadline), progress)
        task, pace_of_run = task_of(scene, dynamics, q, v, energy_balance, patience)
        task = replace(task, pace=join_paces([task.pace, Pace.even(longest)]))
        compiles = dynamics.engine.compiles or isinstance(task.integrator, Taylor)
        loop = deadline.wait_for(lambda: loop_of(task), compiles)
    except Halted as error:
        return _finished(scene, dynamics, None, replace(start, failure=error), saver.note)
    method, notes = scene.solver.method, pace_of_run.notes(scene.duration, scene.solver.step)
    if method_of(method).damps and not built_in(scene.effects):  # a difference across a jump looks like a fast decay
        jumps = f"{method} may be wrong where a function of your own jumps, as sign(v) does: compare with dop853"
        notes = (jumps, *notes)
    run = replace(integrate_to_end(loop, q, v, saver, between), notes=notes)
    guarded = between is None and not anyway  # else something changed the state, or it is to run on with a wrong energy
    trajectory = _finished(scene, dynamics, task.balance, run, saver.note, guarded)
    if not anyway or (count := balanced(trajectory)) == len(trajectory.t):
        return trajectory
    note = f"from t = {trajectory.t[count]:.6g} s on the energy is off by over a tenth of the energy exchanged"
    return replace(trajectory, stats=replace(trajectory.stats, notes=(note, *trajectory.stats.notes)))


def bind_for_run(scene: Scene) -> Dynamics:
    """The dynamics of a scene; samples are computed in machine code unless the scene names another engine."""
    try:
        scene.refuse_short_effects()
    except ValueError as error:
        raise InputError(str(error)) from None
    dynamics = bind(scene)
    if scene.solver.engine in AUTOMATIC:
        dynamics.use_compiled_samples()
    return dynamics


def _choose_method(
    scene: Scene, dynamics: Dynamics, q: Array, v: Array, energy_balance: bool
) -> tuple[Scene, Dynamics]:
    """The scene with a method and an engine in place of "auto", and its dynamics in their form; q, v (nv,)."""
    method, engine = automatic(scene, dynamics, q, v, energy_balance)
    if (method, engine) == (scene.solver.method, scene.solver.engine):
        return scene, dynamics
    changed = scene.with_solver(method=method, engine=engine)
    if engine == "compiled" and scene.solver.engine == "auto":
        return changed, dynamics.in_machine_code
    return changed, bind_for_run(changed) if method == "taylor" else dynamics


def _finished(
    scene: Scene, dynamics: Dynamics, balance: EnergyBalance | None, run: Run, note: str, guarded: bool = True
) -> RunRecord:
    """The trajectory of a run that reached its end. Else raises RunError with the good part of the run and a remedy.

    `guarded`: the run ends where the energies do not add up.
    """
    try:
        trajectory = fill_in(scene, dynamics, balance, run)
    except np.linalg.LinAlgError as error:
        run = _solvable(scene, dynamics, balance, run, str(error))
        trajectory = fill_in(scene, dynamics, balance, run)
    if trajectory.sound == 0:
        raise InputError(START_OVERFLOWS)
    for check, why in ((lambda run: run.sound, TOO_LARGE), (balanced, ENERGY_ERROR))[: 1 + guarded]:
        if (count := check(trajectory)) < len(run.t):
            run = _cut(scene, run, count, why)
            trajectory = fill_in(scene, dynamics, balance, run)
    if run.failure is None:
        return trajectory
    end = scene.start.time + scene.duration
    stop = trajectory.t[-1] if run.stop is None else scene.start.time + run.stop.t
    reason = f"the run ended at t = {stop:.10g} s of {end:.10g} s: {run.failure}"
    more = _remedy(dynamics, run) + (note if isinstance(run.failure, Halted) else "")
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


def _reserve(scene: Scene, dynamics: Dynamics, start: Run, deadline: Deadline) -> Callable[[float], float]:
    """The time in s to complete the samples up to a time t; measured if the run has a limit, else 0."""
    if deadline.limit is None:
        return lambda t: 0.0
    count, seconds, times = 0, 0.0, scene.times
    while seconds < LONG_ENOUGH and count < len(times):
        count = max(1, 4 * count)
        rows = {name: np.repeat(getattr(start, name), count, axis=0) for name in ("t", "q", "v", "work")}
        begin = time.thread_time()  # other processes make no difference
        fill_in(scene, dynamics, None, replace(start, **rows))
        seconds = time.thread_time() - begin
    return lambda t: SLACK * seconds * max(1.0, np.searchsorted(times, t, "right") / count)


def _refuse_overflow(dynamics: Dynamics, start: Run) -> None:
    """Raise InputError for a start whose forces and energies cannot be computed."""
    try:
        results = _completed(dynamics, start.t, start.q, start.v)
    except np.linalg.LinAlgError as error:
        raise InputError(f"start: {error}") from None
    if not all(np.abs(x).max(initial=0.0) <= LARGEST for x in (start.q, start.v, *results)):  # False for NaN
        raise InputError(START_OVERFLOWS)


def fill_in(scene: Scene, dynamics: Dynamics, balance: EnergyBalance | None, run: Run) -> RunRecord:
    """Accelerations, wrenches, energies and tips along the run."""
    model, solver = dynamics.model, scene.solver
    size = len(run.t) if model.chain is None else max(LEAST, PART // model.chain.n)
    states = [x for x in (run.t, run.q, run.v, run.torque) if x is not None]
    parts = [_completed(dynamics, *(x[i : i + size] for x in states)) for i in range(0, len(run.t), size)]
    a, wrench, kinetic, potentials, tips, *rods = map(np.concatenate, zip(*parts, strict=True))
    return RunRecord(
        joints=model.joints,
        t=scene.clock[: len(run.t)],
        q=run.q,
        v=run.v,
        derived=Derived(a, wrench, kinetic, potentials.sum(1), tips, Reactions(*rods) if rods else None),
        stats=Stats(
            method=solver.method,
            tolerance=solver.tolerance,
            step=largest_step(scene.times, solver.step),
            steps=run.steps,
            evaluations=run.evaluations,
            events=run.events,
            seconds=run.seconds,
            compile_seconds=run.compile_seconds,
            engine=dynamics.engine.name,
            library=run.library,
            version=run.version,
            conservative=dynamics.conservative,
            stopped=None if run.failure is None else str(run.failure),
            notes=run.notes,
        ),
        events=tuple(event._replace(t=scene.start.time + event.t) for event in run.happened),
        held=tuple(x.until(float(run.t[-1])) for x in dynamics.sampled_torques if x.recorded),
        work={} if balance is None else balance.close(run.work, potentials),
        scene=scene.recorded(),
        source=scene,
    )


def _completed(dynamics: Dynamics, t: Array, q: Array, v: Array, torque: Array | None = None) -> tuple[Array, ...]:
    """Of states q, v (n, nv) at t (n,): accelerations, wrenches, kinetic energy, potentials, tips and reactions.

    In machine code where it serves; where that finds no finite number, the engine's own equations say why.
    """
    model, sampler = dynamics.model, dynamics.sampler
    parts = None if sampler is None else sampler(t, q, v, torque)
    if parts is None or not all(np.isfinite(part).all() for part in parts):
        parts = (*dynamics.engine.evaluate(t, q, v, torque), *kinematics.poses_and_energy(model, q, v))
    a, wrench, poses, kinetic = parts
    rods = reactions(model, q, wrench) or ()
    return a, wrench, kinetic, dynamics.potentials_at(q, poses), kinematics.tips(model, poses), *rods
