"""The estimate of rounding errors beside the true ones, on exact swings: random angles, and falls from near upright.

    python benchmarks/rounding_estimates.py --count 200 --seed 1

Taylor series at their finest err by rounding alone. The estimate is honest if no true error is above it, and useful if it
is not many times larger. `growth over path` is by how much more than its path a steady swing magnifies errors.
"""

import argparse

import numpy as np
from rich.console import Console
from rich.table import Table

import pendpin as pp
from pendpin import effects as fx
from pendpin.equations import exact
from pendpin.runs.accuracy.estimate import measure_rounding
from pendpin.runs.accuracy.runs import Attempt, Runs
from pendpin.runs.limits import Deadline
from pendpin.runs.preparation import Prepared

RODS = (pp.Rod(length=1.0, mass=1.0, com=1.0, inertia=(0, 0, 0)), pp.Rod(length=1.0, mass=1.0, radius=0.05))
AWAY = (0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3)  # rad, from upright
LINEAR = 0.05  # of the length: larger errors are not in proportion to the shifts


def compared(random: np.random.Generator, upright: bool) -> tuple[float, float, float]:
    """True error, estimate, and growth over the path, of one random swing."""
    if upright:
        angle, duration = (
            np.pi + random.choice((-1, 1)) * random.choice(AWAY) * random.uniform(0.3, 3),
            random.uniform(1, 15),
        )
    else:
        angle, duration = random.uniform(0.3, 2.9), 10 ** random.uniform(1, 3.3)
    rod, tolerance = RODS[random.integers(2)], random.choice((1e-18, 1e-16))
    reduced = (rod.properties.I1 + rod.properties.m * rod.properties.h**2) / (rod.properties.m * rod.properties.h)
    scene = pp.Scene(
        duration=duration,
        model=pp.Chain(rods=[rod]),
        start=pp.Start(positions=[angle, 0.0]),
        effects=[fx.Gravity()],
        solver=pp.Solver(samples=101, method="taylor", accuracy=1e-2),
    )
    runs = Runs(Prepared.of(scene), lambda t: None, Deadline(None))
    scenes = [scene.by("taylor", x) for x in (100 * tolerance, tolerance)]
    coarse, fine = (Attempt(one, one.solver.tolerance or 0.0, runs.run(one)) for one in scenes)
    rounding = measure_rounding(runs, coarse, fine, 1e-2, runs.ruler(fine.run))
    q = exact.planar(angle, 0.0, reduced, 9.81, runs.times)
    truth = exact.direction(np.stack([q, np.zeros_like(q)], -1))
    error = float(np.linalg.norm(fine.run.tips[:, 0] - truth, axis=-1).max())
    return error, rounding.last, rounding.growth / max(rounding.path, 1e-300)


def main() -> None:
    """Print quantiles of the true error over the estimate."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    random = np.random.default_rng(options.seed)
    table = Table("swings", "count", "5 %", "median", "90 %", "98 %", "largest", "growth over path, median", "largest")
    for upright in (False, True):
        rows = np.array([compared(random, upright) for _ in range(options.count // 2)])
        rows = rows[rows[:, 1] < LINEAR]
        ratios = np.quantile(rows[:, 0] / rows[:, 1], (0.05, 0.5, 0.9, 0.98, 1.0))
        growth = np.quantile(rows[:, 2], (0.5, 1.0))
        name = "from near upright" if upright else "of any angle"
        table.add_row(name, str(len(rows)), *(f"{x:.2g}" for x in (*ratios, *growth)))
    Console(width=140).print(table)


if __name__ == "__main__":
    main()
