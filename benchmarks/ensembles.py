"""10,000 starts of the built-in rod over 10 s at a tip error of 1e-9: pendpin beside MuJoCo's rollout.

Run it on an idle machine: python benchmarks/ensembles.py [--starts 10000] [--seconds 5] [--sample 50]
Both run at the coarsest setting that keeps the tips of 50 of the starts, at 60 output times a second, within the error:
a decade of the tolerance, or equal RK4 steps from output to output. MuJoCo has its model without contacts, limits and
whatever else costs time, and without the mass it adds to massless bodies (pendpin.verification.simulators), and its own
pool of threads, in chunks; it runs only as many starts as give a steady figure. Seconds of the processor, which other
loads disturb less, stand beside those on the clock.
"""

import argparse
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import mujoco
import mujoco.rollout
import numpy as np
from rich.console import Console
from rich.table import Table

import pendpin as pp
from pendpin.ground.arrays import Array
from pendpin.model.kinematics import tip_distance
from pendpin.scene import builtin_scene
from pendpin.sweeps.workers import cores
from pendpin.verification.simulators import mujoco_model, mujoco_places, task_of
from pendpin.verification.work_precision.cost import machine

ERROR = 1e-9
SAMPLE = 50  # starts that the error is measured on
REFERENCE = 1e-18
TOLERANCES = (1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
MOST_STEPS = 400  # of RK4 from output to output
GROWTH = 1.1  # from one number of steps to the next that is tried
REPETITIONS = 3


class Took(NamedTuple):
    """The least of some repetitions."""

    starts: int
    wall: float  # s
    processor: float  # s, of all threads

    def rates(self, duration: float, workers: int) -> tuple[str, str]:
        """Simulated seconds per second and core, by the clock and by the processor."""
        simulated = self.starts * duration
        return f"{simulated / self.wall / workers:,.0f}", f"{simulated / self.processor:,.0f}"


def random_starts(count: int) -> tuple[Array, Array]:
    """Angles up to 1 rad and rates up to 1 rad/s, (count, 2) each."""
    q, v = np.random.default_rng(0).uniform(-1, 1, (2, count, 2))
    return q, v


def timed(run: Callable[[], Any], starts: int) -> Took:
    """The least time of some repetitions, on the clock and on the processor."""
    walls, processors = [], []
    for _ in range(REPETITIONS):
        wall, processor = time.perf_counter(), time.process_time()
        run()
        walls.append(time.perf_counter() - wall)
        processors.append(time.process_time() - processor)
    return Took(starts, min(walls), min(processors))


# --- pendpin --------------------------------------------------------------------------------------------------------


def coarsest_tolerance(scene: pp.Scene, q: Array, v: Array, known: Array) -> tuple[float, float]:
    """The first decade that meets the error, and the error."""
    for tolerance in TOLERANCES:
        error = largest(known, pp.simulate_many(scene, q, v, method="taylor", tolerance=tolerance).tips())
        if error <= ERROR:
            return tolerance, error
    raise SystemExit("no tolerance meets the error")


def largest(known: Array, tips: Array) -> float:
    """The largest distance of any tip, over the length of 1 m."""
    return max(float(tip_distance(one, other, 1.0).max()) for one, other in zip(known, tips, strict=True))


# --- MuJoCo ---------------------------------------------------------------------------------------------------------


class Rollout:
    """MuJoCo's rollout of the scene's model by RK4, so many equal steps from output to output."""

    def __init__(self, scene: pp.Scene, steps: int, threads: int) -> None:
        task = task_of(scene)
        self.model, self.steps, self.threads = mujoco_model(mujoco, task), steps, threads
        self.model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
        self.model.opt.timestep = task.interval / steps
        self.places, self.outputs = mujoco_places(self.model, task), len(task.times) - 1
        self.data = [mujoco.MjData(self.model) for _ in range(max(1, threads))]
        self.pool = mujoco.rollout.Rollout(nthread=threads)

    def states(self, q: Array, v: Array, chunk: int | None = None) -> Array:
        """Full states (k, steps, size) from q, v (k, 2)."""
        at_q, at_v = self.places
        start = np.zeros((len(q), mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
        start[:, 1 + at_q], start[:, 1 + self.model.nq + at_v] = q, v  # behind the time
        count = self.steps * self.outputs
        return self.pool.rollout(self.model, self.data, start, nstep=count, chunk_size=chunk)[0]

    def positions(self, q: Array, v: Array) -> Array:
        """q (k, n, 2) at the output times."""
        rows = self.states(q, v)[:, self.steps - 1 :: self.steps, 1 + self.places[0]]
        return np.concatenate([q[:, None], rows], 1)


def coarsest_steps(scene: pp.Scene, many: pp.Ensemble, known: Array) -> tuple[int, float]:
    """The first number of steps between outputs that meets the error, and the error."""
    steps = 1.0
    while steps <= MOST_STEPS:
        rollout = Rollout(scene, round(steps), cores())
        rows = rollout.positions(many.q[:, 0], many.v[:, 0])
        error = largest(known, pp.Ensemble(many.joints, many.t, rows, rows, many.stats, scene).tips())
        if error <= ERROR:
            return round(steps), error
        steps = max(steps + 1, steps * GROWTH)
    raise SystemExit("no step meets the error")


def best_rollout(scene: pp.Scene, steps: int, q: Array, v: Array, seconds: float) -> tuple[Took, int, int]:
    """The best of its settings over about so many seconds: threads and starts in a chunk."""
    found = []
    for threads in sorted({0, cores()}):
        rollout, few = Rollout(scene, steps, threads), 8 * max(1, threads)
        begin = time.process_time()
        rollout.states(q[:few], v[:few])
        pace = (time.process_time() - begin) / few
        count = min(max(few, int(seconds / pace / REPETITIONS)), len(q), 2000)  # whose states fit in memory
        for chunk in (1, max(1, count // (10 * max(1, threads)))):
            took = timed(lambda: rollout.states(q[:count], v[:count], chunk), count)  # noqa: B023
            found.append((took.processor / took.starts, took, threads, chunk))
    _, took, threads, chunk = min(found)
    return took, threads, chunk


def main() -> None:
    """Print the table and the ratio."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--starts", type=int, default=10_000)
    parser.add_argument("--seconds", type=float, default=5.0, help="of MuJoCo's runs at each of its settings")
    parser.add_argument("--sample", type=int, default=SAMPLE, help="starts that the error is measured on")
    given, console, scene = parser.parse_args(), Console(), builtin_scene()
    q, v = random_starts(given.starts)
    few = slice(0, given.sample)
    reference = pp.simulate_many(scene, q[few], v[few], method="taylor", tolerance=REFERENCE)
    known = np.array([alone(scene, *start) for start in zip(q[few], v[few], strict=True)])
    console.print(
        f"the reference's rows are within {largest(known, reference.tips()):.0e} of `simulate` at {REFERENCE:g}"
    )

    table = Table("", "setting", "error", "starts", "per s and core, clock", "per s of processor")
    tolerance, error = coarsest_tolerance(scene, q[few], v[few], known)
    rates = {}
    for workers in sorted({1, cores()}):
        took = timed(lambda: pp.simulate_many(scene, q, v, tolerance=tolerance, workers=workers), len(q))  # noqa: B023
        rates[workers] = len(q) * scene.duration / took.processor
        name, shown = f"pendpin taylor, {workers} threads", took.rates(scene.duration, workers)
        table.add_row(name, f"tolerance {tolerance:g}", f"{error:.1e}", f"{took.starts}", *shown)
    steps, error = coarsest_steps(scene, reference, known)
    took, threads, chunk = best_rollout(scene, steps, q, v, given.seconds)
    other = took.starts * scene.duration / took.processor
    name, shown = f"MuJoCo rollout, {threads} threads, chunks of {chunk}", took.rates(scene.duration, max(1, threads))
    step = scene.times[1] / steps
    table.add_row(name, f"rk4, {step:.2e} s", f"{error:.1e}", f"{took.starts}", *shown)
    console.print(table)
    console.print(
        f"simulated seconds per second of processor time: pendpin over MuJoCo {max(rates.values()) / other:,.0f}"
    )
    console.print(f"{machine()}; mujoco {mujoco.__version__}, heyoka {reference.stats.version}; least of {REPETITIONS}")


def alone(scene: pp.Scene, q: Array, v: Array) -> Array:
    """The tips from one start, by `simulate` at the reference's tolerance."""
    start = pp.Start(positions=tuple(q.tolist()), velocities=tuple(v.tolist()))
    return pp.simulate(scene.model_copy(update={"start": start}), method="taylor", tolerance=REFERENCE).tips


if __name__ == "__main__":
    main()
