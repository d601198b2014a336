"""The interface of the integration loops: a run is integrated segment by segment, and can be saved after each."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.dynamics import Dynamics
from pendpin.dynamics.timing import Timing, timing
from pendpin.effects.pace import Pace
from pendpin.engines import ProgressCallback
from pendpin.errors import RunError
from pendpin.integrators import Integrator, Run, integrator_for
from pendpin.scene import Scene
from pendpin.simulation.checkpoint import RunState
from pendpin.simulation.energy_balance import EnergyBalance


@dataclass(frozen=True, eq=False)
class Task:
    """What is integrated, by what, and at which times."""

    integrator: Integrator
    dynamics: Dynamics
    balance: EnergyBalance | None
    times: Array  # (n,) s since the start
    progress: ProgressCallback
    pace: Pace


def task_of(
    scene: Scene, dynamics: Dynamics, q: Array, v: Array, energy_balance: bool, progress: ProgressCallback
) -> tuple[Task, Timing]:
    """The task of a scene from q, v (nv,), and how fast its effects change. Raises InputError for an unfit method."""
    pace = timing(dynamics, dynamics.effects, q, v, scene.duration, scene.solver.tolerance)
    balance = EnergyBalance(dynamics) if energy_balance else None
    return Task(integrator_for(scene, dynamics), dynamics, balance, scene.times, progress, pace.pace), pace


class IntegrationLoop(ABC):
    """The integration of a scene over its output times; `library` and `version` name the integrating program."""

    library: str
    version: str
    first_segment = 1  # output times of it, as long as nothing is known of what they cost

    def __init__(self, task: Task) -> None:
        self.integrator, self.dynamics, self.balance = task.integrator, task.dynamics, task.balance
        self.times, self.progress, self.pace = task.times, task.progress, task.pace
        self.engine = task.balance.engine if task.balance else task.dynamics.engine  # that is integrated
        self.held = task.dynamics.held
        for one in self.held:
            one.begin(task.dynamics.start, float(self.times[-1]))
        self.nv, self.accounts = len(task.dynamics.model.joints), len(task.balance.kinds) if task.balance else 0

    @abstractmethod
    def begin(self, q: Array, v: Array) -> RunState:
        """The first sample, at q, v (nv,). Raises InputError for a start that cannot be integrated."""

    @abstractmethod
    def go_on(self, done: RunState) -> tuple[RunState, str | None]:
        """The state one segment later, and why the run has to end there, or None. The result depends on `done` only.

        Raises RunError or LinAlgError if the segment cannot be integrated.
        """

    def sampled_at(self, t: float) -> bool:
        """Whether t in s is an instant of a sampled torque."""
        return any(one.is_instant(t) for one in self.held)

    def sample(self, t: float, y: Array) -> bool:
        """Evaluate the sampled torques whose instant t in s is; whether there are any. y begins with q, v (2 nv,)."""
        due = [one for one in self.held if one.is_instant(t)]
        for one in due:
            one.sample(t, y[: self.nv], y[self.nv : 2 * self.nv])
        return bool(due)

    def held_arrays(self) -> dict[str, Array]:
        """The outputs of the sampled torques, for the state of a run: all states share them."""
        return {f"held_{i}": one.record for i, one in enumerate(self.held)}

    def hold_on(self, carried: dict[str, Array]) -> None:
        """Go on with what the sampled torques held in a state of the run."""
        for i, one in enumerate(self.held):
            one.recall(float(carried["t"]), carried[f"held_{i}"])

    def outcome(self, done: RunState, error: RunError | None) -> Run:
        """The run as far as it was integrated, and why it ended early, if it did."""
        for one in self.held:
            one.finish()
        ends = np.cumsum([self.nv, self.nv, self.accounts])
        q, v, work, torque = map(np.ascontiguousarray, np.split(done.samples, ends, 1))
        arrays = (self.times[: done.n], q, v, torque if torque.shape[1] else None, work)
        compiling = self.integrator.compile_seconds + self.engine.compile_seconds
        counts = (done.steps, done.evaluations, done.events, done.seconds)
        run = Run(*arrays, *counts, self.library, self.version, compiling)
        return replace(run, failure=error, happened=tuple(done.log[: done.logged]))
