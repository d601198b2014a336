"""What a run holds beside positions and rates: accelerations, wrenches, energies and tips at its samples."""

import numpy as np

from pendpin.dynamics.dynamics import Dynamics, reactions
from pendpin.ground.arrays import Array
from pendpin.integrators import Run
from pendpin.integrators.grid import largest_step
from pendpin.model import kinematics
from pendpin.runs.preparation import EnergyBalance
from pendpin.scene import Scene
from pendpin.trajectory import Derived, RunRecord, Stats

PART, LEAST = 1 << 12, 64  # rods, and samples, completed at once: what they need stays in a processor's fast memory


def fill_in(
    scene: Scene, dynamics: Dynamics, balance: EnergyBalance | None, run: Run, lazily: bool = False
) -> RunRecord:
    """Accelerations, wrenches, energies and tips along the run; the reactions of rods when they are asked for.

    `lazily`: the others too, where no work is integrated.
    """
    model, solver, q, works = dynamics.model, scene.solver, run.q, dict[str, Array]()

    def derive() -> Derived:
        size = len(run.t) if model.chain is None else max(LEAST, PART // len(model.rods))
        states = [x for x in (run.t, run.q, run.v, run.torque) if x is not None]
        parts = [complete(dynamics, *(x[i : i + size] for x in states)) for i in range(0, len(run.t), size)]
        columns = parts[0] if len(parts) == 1 else map(np.concatenate, zip(*parts, strict=True))
        a, wrench, kinetic, potentials, tips = columns
        works.update({} if balance is None else balance.close(run.work, potentials))
        return Derived(a, wrench, kinetic, potentials.sum(1), tips, lambda: reactions(model, q, wrench))

    derived = derive if lazily and balance is None else derive()
    return RunRecord(
        joints=model.joints,
        t=scene.start.time + run.t if solver.times is None else scene.clock[: len(run.t)],
        q=q,
        v=run.v,
        derived=derived,
        stats=Stats(
            method=solver.method,
            tolerance=solver.tolerance,
            step=solver.step and largest_step(scene.times, solver.step),
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
        scene=scene.recorded(),
        source=scene,
    )


def complete(dynamics: Dynamics, t: Array, q: Array, v: Array, torque: Array | None = None) -> tuple[Array, ...]:
    """Of states q, v (n, nv) at t (n,): accelerations, wrenches, kinetic energy, potentials and tips.

    In machine code where it serves; where that finds no finite number, the engine's own equations say why.
    """
    model, sampler = dynamics.model, dynamics.sampler
    parts = None if sampler is None else sampler(t, q, v, torque)
    if parts is None:
        parts = (*dynamics.engine.evaluate(t, q, v, torque), *kinematics.poses_and_energy(model, q, v))
    a, wrench, poses, kinetic = parts
    return a, wrench, kinetic, dynamics.potentials_at(q, poses), kinematics.tips(model, poses)
