"""What a sweep costs: over simulate_many, with one worker and two, with other blocks, beside MuJoCo and a loop of SciPy.

Run it: python benchmarks/sweep.py [--starts 8000] [--sample 50]
All times are of the processor, of children too: others may be busy.
Starts of the built-in rod, 10 s, its final angle measured; the tolerance is the coarsest decade at which the tips of
50 starts are within 1e-9 (as benchmarks/ensembles.py finds it). MuJoCo and SciPy run as many starts as take a few seconds.
"""

import argparse
import resource
from collections.abc import Callable
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.integrate import solve_ivp

import pendpin as pp
from ensembles import SAMPLE, Rollout, alone, coarsest_steps, coarsest_tolerance, random_starts
from pendpin.dynamics.dynamics import bind
from pendpin.scene import builtin_scene
from pendpin.sweeps import plan
from pendpin.sweeps import sweep as sweeps
from pendpin.sweeps.workers import cores
from pendpin.verification.work_precision.cost import machine

KEYS = tuple(f"start.{what}.{name}" for what in ("positions", "velocities") for name in ("theta", "phi"))
BLOCKS = (16, 64, 256, 1024, 4096)
SCIPY_STARTS = 20
ROLLOUTS = 100  # starts of MuJoCo
SCIPY_TOLERANCE = 1e-12  # at which DOP853 is within 1e-9 after 10 s


def clock() -> float:
    """Processor time of this process and of its children that have ended, s."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def clocked(run: Callable[[], Any]) -> float:
    """The least processor time of three runs, s."""
    times = []
    for _ in range(3):
        begin = clock()
        run()
        times.append(clock() - begin)
    return min(times)


def scipy_seconds(scene: pp.Scene, q: np.ndarray, v: np.ndarray) -> float:
    """One start by a plain loop of solve_ivp on pin.aba, s."""
    import pinocchio

    model = bind(scene).model.pin.copy()
    model.gravity.linear = np.array([0.0, 0.0, -9.81])
    data, tau = model.createData(), np.zeros(2)

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[2:], pinocchio.aba(model, data, y[:2], y[2:], tau)])

    begin = clock()
    for start in zip(q, v, strict=True):
        solve_ivp(rate, (0.0, scene.duration), np.concatenate(start), method="DOP853", rtol=1e-12, atol=1e-12)
    return (clock() - begin) / len(q)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--starts", type=int, default=8_000)
    parser.add_argument("--sample", type=int, default=SAMPLE, help="starts that the error is measured on")
    given, console, scene = parser.parse_args(), Console(), builtin_scene()
    q, v = random_starts(given.starts)
    few = slice(0, given.sample)
    known = np.array([alone(scene, *start) for start in zip(q[few], v[few], strict=True)])
    tolerance, error = coarsest_tolerance(scene, q[few], v[few], known)
    short = scene.model_copy(update={"solver": scene.solver.with_settings(tolerance=tolerance, samples=2)})
    cases = plan.pairs(dict(zip(KEYS, np.concatenate([q, v], 1).T, strict=True)))
    simulated = given.starts * scene.duration

    table = Table("", "setting", "simulated s per s of processor", "time over the first")
    first = clocked(lambda: pp.simulate_many(short, q, v, tolerance=tolerance, workers=1))
    table.add_row("simulate_many, one thread", f"{tolerance:g}, error {error:.1e}", f"{simulated / first:,.0f}", "1")

    def measured(name: str, setting: str, **options: Any) -> None:
        took = clocked(lambda: pp.sweep(short, cases, "theta.final", **options))
        table.add_row(name, setting, f"{simulated / took:,.0f}", f"{took / first:.2f}")

    found = sweeps._block_size
    for size in BLOCKS:
        sweeps._block_size = lambda task, workers, size=size: size
        measured("sweep, one thread", f"blocks of {size}", workers=1)
    sweeps._block_size = found
    measured("sweep, one thread", "blocks as chosen", workers=1)
    measured(f"sweep, {cores()} threads", "blocks as chosen")
    measured("sweep, 2 processes", "blocks as chosen, with their start", workers=2)

    many = pp.simulate_many(scene, q[few], v[few], method="taylor", tolerance=1e-18)
    steps, mujoco_error = coarsest_steps(scene, many, known)
    rollout = Rollout(scene, steps, 0)
    rolled = min(ROLLOUTS, given.starts)
    rate = rolled * scene.duration / clocked(lambda: rollout.states(q[:rolled], v[:rolled]))
    table.add_row("MuJoCo rollout", f"RK4, {steps} steps an output, {mujoco_error:.1e}", f"{rate:,.0f}", "")
    each = scipy_seconds(scene, q[:SCIPY_STARTS], v[:SCIPY_STARTS])
    table.add_row("loop of SciPy DOP853 on pin.aba", f"{SCIPY_TOLERANCE:g}", f"{scene.duration / each:,.0f}", "")
    console.print(table)
    console.print(machine())


if __name__ == "__main__":
    main()
