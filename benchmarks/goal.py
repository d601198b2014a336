"""Accuracy as a target: random smooth scenes, the true error of what is returned, and its time over the cheapest setting.

Run it on an idle machine: python benchmarks/target.py [--scenes 30] [--seed 1]
"""

import argparse
from collections.abc import Iterator

import numpy as np
from rich.console import Console
from rich.table import Table

import pendpin as pp
from pendpin import effects as fx
from pendpin.model.build import build
from pendpin.model.kinematics import apart, reach
from pendpin.trajectory import Trajectory

ACCURACIES = (1e-4, 1e-7, 1e-10)
SAMPLES = 101


def random_scene(random: np.random.Generator) -> pp.Scene:
    """One to three rods, thin or thick, let go with moderate angles and rates; some with damping, springs, a motor, air."""
    rods = [_rod(random) for _ in range(random.integers(1, 4))]
    n = 2 * len(rods)
    positions, velocities = random.uniform(-0.8, 0.8, n), random.uniform(-1.0, 1.0, n)
    some = [
        fx.Viscous(coefficient=float(random.uniform(0.001, 0.1))),
        fx.Spring(stiffness=float(random.uniform(0.1, 5))),
        fx.Support(amplitude=(0.05, 0.0, 0.02), frequency=float(random.uniform(1, 10))),
        fx.Rotation(latitude=45.0),
        fx.Drag(density=0.0, linear=float(random.uniform(0.001, 0.1)), diameter=0.05),
    ]
    chosen = [effect for effect in some if random.random() < 0.2]
    return pp.Scene(
        duration=float(random.uniform(2, 8)),
        model=pp.Chain(rods=rods),
        start=pp.Start(positions=positions.tolist(), velocities=velocities.tolist()),
        effects=[fx.Gravity(), *chosen],
        solver=pp.Solver(samples=SAMPLES),
    )


def _rod(random: np.random.Generator) -> pp.Rod:
    length = float(random.uniform(0.3, 2.0))
    radius = 0.0 if random.random() < 0.3 else float(random.uniform(0.02, 0.1)) * length
    return pp.Rod(length=length, mass=float(random.uniform(0.3, 3.0)), radius=radius)


def ladder(scene: pp.Scene, truth: np.ndarray, length: float) -> Iterator[tuple[float, float]]:
    """Error and seconds (the least of two) of every setting of the methods that may be the cheapest."""
    for method, exponents in (("taylor", range(2, 17)), ("dop853", range(2, 15)), ("lsoda", range(3, 15))):
        for k in exponents:
            try:
                runs = [pp.simulate(scene.by(method, 10.0**-k)) for _ in range(2)]
            except pp.PendpinError:
                continue
            yield error_of(runs[0], truth, length), min(run.stats.seconds for run in runs)


def error_of(run: Trajectory, truth: np.ndarray, length: float) -> float:
    """The largest tip distance to the truth over the run, over the chain's length."""
    return float(apart(truth, run.tips(), length).max())


def main() -> None:
    """Print the true errors and the time over the cheapest setting, of what is run alone and with its pilots."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=30)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    random, console = np.random.default_rng(options.seed), Console()
    table = Table("scene", "rods", "asked", "method", "estimated", "true", "ms", "with pilots", "cheapest", "ratio")
    ratios, misses = [], 0
    for i in range(options.scenes):
        scene = random_scene(random)
        length = reach(build(scene.model))
        truth = pp.simulate(scene, method="taylor", tolerance=1e-18).tips()
        settings = list(ladder(scene, truth, length))
        for accuracy in ACCURACIES:
            run = pp.simulate(scene, accuracy=accuracy)
            again = pp.simulate(scene, accuracy=accuracy)  # after a first, as the ladder's
            stats, true = run.stats, error_of(run, truth, length)
            cheapest = min(seconds for error, seconds in settings if error <= accuracy)
            spent = min(stats.all_seconds or 0.0, again.stats.all_seconds or 0.0)
            ratios.append(spent / cheapest)
            misses += true > accuracy
            numbers = [1e3 * x for x in (min(stats.seconds, again.stats.seconds), spent, cheapest)]
            rods = str(len(run.joints) // 2)
            table.add_row(
                *(str(i), rods, f"{accuracy:g}", stats.method, f"{stats.error:.1e}", f"{true:.1e}"),
                *(f"{number:.2f}" for number in numbers),
                f"{ratios[-1]:.2f}",
            )
    console.print(table)
    console.print(
        f"{misses} of {len(ratios)} miss what was asked; time with pilots over the cheapest setting: median ", end=""
    )
    console.print(f"{np.median(ratios):.2f}, largest {max(ratios):.2f}")


if __name__ == "__main__":
    main()
