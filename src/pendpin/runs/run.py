"""The run of a scene by its solver: prepared once, integrated, completed by wrenches and energies, and checked."""

import time
from bisect import bisect_left
from dataclasses import replace
from functools import partial

import numpy as np

from pendpin.dynamics.dynamics import Dynamics, reactions
from pendpin.effects.pace import Pace, join_paces
from pendpin.engines import ProgressCallback
from pendpin.errors import Halted, InputError, Interrupted
from pendpin.ground.arrays import Array
from pendpin.ground.records import LARGEST
from pendpin.integrators import Run
from pendpin.integrators.choice import notes_on_stiffness
from pendpin.integrators.fixed import count_whole_steps, largest_step
from pendpin.model.build import start_state
from pendpin.model.kinematics import tips as tips_of
from pendpin.runs.checkpoint import Checkpoint, Shifts, how_to_resume, identity
from pendpin.runs.integration import IntegrationLoop, SmoothLoop, integrate_to_end
from pendpin.runs.limits import Deadline, Patience
from pendpin.runs.motion_with_events import LoopWithEvents
from pendpin.runs.preparation import MACHINE_CODE, EnergyBalance, Prepared, bind_for_run
from pendpin.scene import Scene
from pendpin.trajectory import Derived, RunRecord, Stats, exchanged
from pendpin.trajectory.parts import ROUNDING

SHORTER = 3.0  # times shorter steps of a run for comparison: an error at a corner grows as their square, so it shows
NEAR_POLE = 0.3  # of cos(phi)
LONG_ENOUGH = 5e-3  # s, of a measurement of the time to complete samples
SLACK = 1.2  # margin on that time
PART, LEAST = 1 << 12, 64  # rods, and samples, completed at once: what they need stays in a processor's fast memory
OFF = 0.1  # of the energy exchanged: largest energy error of a valid run
START_OVERFLOWS = f"start: positions, rates, forces or energies beyond {LARGEST:g}, too large to compute with"
TOO_LARGE = f"its numbers grow beyond {LARGEST:g}"
ENERGY_ERROR = "the energy is off by over a tenth of the energy exchanged: take a smaller tolerance or step"


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # what overflows is found, and said
def prepare(scene: Scene, energy_balance: bool, deadline: Deadline) -> Prepared:
    """The scene, bound, its method and engine chosen. InputError; Halted at the deadline, as compiling may take long."""
    compiles = scene.solver.method == "auto" and scene.solver.engine in MACHINE_CODE  # what the choice is made by
    try:
        return deadline.wait_for(lambda: Prepared.of(scene, energy_balance), compiles)
    except Halted as error:
        dynamics = bind_for_run(scene)
        start = Prepared(scene, dynamics, dynamics, *start_state(dynamics.model, scene.start), None)
        _finish(start, _start_alone(start, failure=error))
        raise


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

    `longest`: s, of a step. `anyway`: a wrong energy is a note, not an error; with `shifts` of the state it is not checked.
    `pilot`: samples are computed when they are first asked for, and the energy is not checked.
    Raises InputError for a scene that its method cannot run; RunError with the run up to where it ends early.
    """
    scene, dynamics = prepared.scene, prepared.dynamics
    if checkpoint:
        checkpoint.run = identity(scene, prepared.balance is not None, dynamics.engine.name)
    reserve = 0.0 if deadline.limit is None else SLACK * _measure_completion(prepared)
    reserved = lambda t: reserve and reserve * max(1, int(np.searchsorted(scene.times, t, "right")))  # noqa: E731
    patience = Patience(scene.duration, deadline, reserved, progress)
    try:
        compiles = dynamics.engine.compiles or scene.solver.method == "taylor"
        loop = deadline.wait_for(lambda: loop_of(prepared, patience, longest, shifts), compiles)
    except Halted as error:
        return _finish(replace(prepared, balance=None), _start_alone(prepared, failure=error), checkpoint)
    run = integrate_to_end(loop, prepared.q, prepared.v, checkpoint)
    run = replace(run, notes=(*prepared.notes, *notes_on_stiffness(scene, run.steps)))
    if pilot and run.failure is None and (np.abs([run.q, run.v]) <= LARGEST).all():
        return fill_in(scene, dynamics, prepared.balance, run, lazy=True)
    guarded = shifts is None and not anyway  # else the state was changed, or it is to run on with a wrong energy
    record = _finish(prepared, run, checkpoint, guarded)
    if not anyway or (count := balanced(record)) == len(record.t):
        return record
    note = f"from t = {record.t[count]:.6g} s on the energy is off by over a tenth of the energy exchanged"
    return replace(record, stats=replace(record.stats, notes=(note, *record.stats.notes)))


def loop_of(
    prepared: Prepared, progress: ProgressCallback, longest: float = np.inf, shifts: Shifts | None = None
) -> IntegrationLoop:
    """The loop that integrates a scene, with events where it has contacts. InputError for what its method cannot run."""
    pace = prepared.paces.pace
    if longest < np.inf:  # s, of a run for comparison: its steps are also shorter than the effects' pace allows
        pace = join_paces([pace._replace(shortest=np.asarray(pace.shortest) / SHORTER), Pace.even(longest)])
    kind = SmoothLoop if prepared.dynamics.contacts is None else LoopWithEvents
    loop = kind(prepared, pace, progress)
    loop.shifts = shifts
    return loop


def _start_alone(prepared: Prepared, count: int = 1, failure: Halted | None = None) -> Run:
    """The start as a run that was not integrated, `count` times."""
    q, v = (np.tile(x, (count, 1)) for x in (prepared.q, prepared.v))
    return replace(Run.at_states(np.zeros(count), q, v), failure=failure)


def _measure_completion(prepared: Prepared) -> float:
    """The measured processor time in s to complete one sample of a run, once what completes them is compiled."""
    count, seconds, most = 0, 0.0, len(prepared.scene.times)
    fill_in(prepared.scene, prepared.dynamics, None, _start_alone(prepared))  # not measured: the first call compiles
    while seconds < LONG_ENOUGH and count < most:
        count, begin = max(1, 4 * count), time.thread_time()  # other processes make no difference
        fill_in(prepared.scene, prepared.dynamics, None, _start_alone(prepared, count))
        seconds = time.thread_time() - begin
    return seconds / count


def _finish(prepared: Prepared, run: Run, checkpoint: Checkpoint | None = None, guarded: bool = True) -> RunRecord:
    """The record of a run, `guarded` where it ends once energies do not add up; before its end RunError with a remedy."""

    def cut(count: int, why: str) -> Run:  # with the fixed steps up to there; others are not counted by samples
        step, short = scene.solver.step, run.cut(count, why)
        steps = run.steps if step is None else min(run.steps, count_whole_steps(scene.times[count - 1], step))
        return replace(short, steps=steps)

    def fails(count: int, why: str) -> bool:
        try:
            fill(run.cut(count, why))
        except np.linalg.LinAlgError:
            return True
        return False

    scene, fill = prepared.scene, partial(fill_in, prepared.scene, prepared.dynamics, prepared.balance)
    try:
        record = fill(run)
    except np.linalg.LinAlgError as error:  # the equations have no solution at a sample: the run ends before it
        why = str(error)
        good = bisect_left(range(1, len(run.t)), True, key=lambda count: fails(count, why))
        if good == 0:
            raise InputError(f"start: {why}") from None
        run = cut(good, why)
        record = fill(run)
    if (count := record.sound) == 0:
        raise InputError(START_OVERFLOWS)
    if count < len(run.t):
        record = fill(run := cut(count, TOO_LARGE))
    if guarded and (count := balanced(record)) < len(run.t):
        record = fill(run := cut(count, ENERGY_ERROR))
    if run.failure is None:
        return record
    end = scene.start.time + scene.duration
    stop = record.t[-1] if run.stop is None else scene.start.time + run.stop.t
    reason = f"the run ended at t = {stop:.10g} s of {end:.10g} s: {run.failure}"
    resumable = how_to_resume(checkpoint.path) if checkpoint and isinstance(run.failure, Halted) else ""
    raise type(run.failure)(reason + _remedy(prepared.dynamics, run) + resumable, record)


def _remedy(dynamics: Dynamics, run: Run) -> str:
    """A likely reason of a failure: a thin rod near the pole with a torque about its joint; else the fastest joint."""
    model, (q, v) = dynamics.model, (run.q[-1], run.v[-1]) if run.stop is None else (run.stop.q, run.stop.v)
    if isinstance(run.failure, Interrupted):
        return ""
    if dynamics.engine.on_angles and (rod := model.thin_at_pole(q, NEAR_POLE)):
        where = "near phi = 90 degrees, where nothing resists a torque about theta"
        return f"; {rod} is thin and {where}: give it a radius"
    if str(run.failure) == ENERGY_ERROR:
        return ""
    return f"; fastest there: {model.joints[int(np.argmax(np.abs(v)))]}, at {np.abs(v).max():.3g} (rad/s)"


# --- what a run holds beside positions and rates ---------------------------------------------------------------------


def fill_in(scene: Scene, dynamics: Dynamics, balance: EnergyBalance | None, run: Run, lazy: bool = False) -> RunRecord:
    """Accelerations, wrenches, energies and tips along a run; reactions when asked for, if `lazy` all but work."""
    model, solver, q, works = dynamics.model, scene.solver, run.q, dict[str, Array]()

    def derive() -> Derived:
        size = len(run.t) if model.chain is None else max(LEAST, PART // len(model.rods))
        states = [x for x in (run.t, run.q, run.v, run.torque) if x is not None]
        parts = list[tuple[Array, ...]]()
        for i in range(0, len(run.t), size):
            a, wrench, poses, kinetic = dynamics.sample(*(x[i : i + size] for x in states))
            parts.append((a, wrench, kinetic, dynamics.potentials_at(q[i : i + size], poses), tips_of(model, poses)))
        whole = parts[0] if len(parts) == 1 else map(np.concatenate, zip(*parts, strict=True))
        a, wrench, kinetic, potentials, tips = whole
        works.update({} if balance is None else balance.close(run.work, potentials))
        return Derived(a, wrench, kinetic, potentials.sum(1), tips, lambda: reactions(model, q, wrench))

    derived = derive if lazy and balance is None else derive()
    return RunRecord(
        joints=model.joints,
        t=scene.start.time + run.t if solver.times is None else scene.clock[: len(run.t)],
        q=q,
        v=run.v,
        derived=derived,
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
        work=works,
        scene={} if lazy else scene.recorded(),
        source=scene,
    )


def balanced(record: RunRecord) -> int:
    """The number of samples up to which the energy is off by at most OFF of the energy exchanged until then."""
    so_far, errors = np.maximum.accumulate, list[tuple[Array, Array]]()  # each with its scale, (n,) J
    kinetic, potential = record.kinetic, record.potential
    if record.stats.conservative:
        total = kinetic + potential
        errors.append((so_far(np.abs(total - total[0])), exchanged(kinetic, potential)))
    if works := record.work.values():
        errors.append((so_far(np.abs(record.unbalanced)), exchanged(kinetic, *works)))
    if not any((error > OFF * scale).any() for error, scale in errors):
        return len(record.t)
    # Where nothing is exchanged, rounding counts: that of the terms of a potential energy, which round also where they
    # cancel, as in a horizontal rod. Its scale takes longer than all the rest.
    force, moment = (np.linalg.norm(x, axis=-1).max(1) for x in np.split(record.wrench, 2, -1))
    least = ROUNDING * so_far(moment + force * np.linalg.norm(record.tips, axis=-1).max(1, initial=0.0))
    bad = np.any([error > OFF * np.maximum(scale, least) for error, scale in errors], 0)
    return int(np.flatnonzero(~bad)[-1]) + 1  # not the first that is bad: a run from rest exchanges little at first
