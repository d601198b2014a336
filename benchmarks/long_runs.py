"""A hundred thousand swings: how the energy error of the Gauss and Taylor methods grows.

The energy of a symplectic method oscillates with the step's error and does not drift: what is left in the means over
windows is rounding, which grows like sqrt(t) where it is random. python benchmarks/long_runs.py [--swings 100000]
(gauss4 takes about a quarter of an hour)
"""

import argparse

import numpy as np
from rich.console import Console
from rich.table import Table

import pendpin as pp
from pendpin import Trajectory

PERIOD = 2 * np.pi * np.sqrt(2 / (3 * 9.81))  # s, of small swings of a thin rod of 1 m
WINDOWS = 10
CASES = (("taylor", 1e-18), ("gauss6", PERIOD / 40), ("gauss4", PERIOD / 20), ("gauss2", PERIOD / 20))


def scene(swings: int) -> pp.Scene:
    """A rod in three dimensions, sampled at uneven phases."""
    return pp.Scene(
        duration=swings * PERIOD,
        model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.05)]),
        start=pp.Start(positions={"theta_1": 0.7, "phi_1": 0.4}, velocities={"theta_1": 1.3, "phi_1": -0.8}),
        effects=[pp.effects.Gravity()],
        solver=pp.Solver(samples=int(swings * 0.7) + 1),
    )


def errors(run: Trajectory) -> np.ndarray:
    """(E - E0) over the largest kinetic energy, at the output times."""
    total = run.energy().total
    return (total - total[0]) / run.kinetic.max()


def main() -> None:
    """Print, window by window, the mean and the largest energy error, and how the mean walks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--swings", type=int, default=100_000)
    parser.add_argument("--methods", nargs="*", default=[name for name, _ in CASES])
    options = parser.parse_args()
    table = Table("method", "setting", "steps", "s", *(f"{(i + 1) * 100 // WINDOWS} %" for i in range(WINDOWS)))
    for method, setting in CASES:
        if method not in options.methods:
            continue
        run = pp.simulate(scene(options.swings).by(method, setting))
        windows = np.array_split(errors(run)[1:], WINDOWS)
        row = (method, run.stats.setting, str(run.stats.steps), f"{run.stats.seconds:.1f}")
        table.add_row(*row, *(f"{np.abs(window).max():.1e}" for window in windows))
        walk = [window.mean() - windows[0].mean() for window in windows]
        table.add_row("", "mean, less the first", "", "", *(f"{step:+.0e}" for step in walk))
    console = Console(width=200)
    console.print(f"largest energy error in each tenth of {options.swings} swings, over the largest kinetic energy")
    console.print(table)


if __name__ == "__main__":
    main()
