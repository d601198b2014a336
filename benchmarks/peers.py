"""pendpin beside MuJoCo, Drake and plain SciPy on pin.aba: error against time, on one rod and chains of 3, 10 and 30.

Times are of the processor, so that other processes matter little.
python benchmarks/peers.py [--rods 1 3 10 30] [--pictures docs/images] [--thorough]
It prints, at tip errors of 1e-3, 1e-6 and 1e-9, the best of pendpin's methods, the best of the others, and the ratio of
their times; and for one rod the Taylor integrator beside heyoka fed with the closed form by hand.
"""

import argparse
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

import pendpin as pp
from pendpin.scene import builtin_scene
from pendpin.verification.work_precision.cost import cost
from pendpin.verification.work_precision.figure import save_cost_plot
from pendpin.verification.work_precision.report import CostReport, time_text

ERRORS = (1e-3, 1e-6, 1e-9)
REPETITIONS = 5
LONG = 100  # rods: over a second their motion is chaotic, and nine digits of it are nobody's


def scene(rods: int) -> pp.Scene:
    """The built-in rod over 100 s; or a straight chain, 1 m long in all, let go at a slant: 10 s, of long ones 0.34 s."""
    if rods == 1:
        return builtin_scene().model_copy(update={"duration": 100.0})
    rod = pp.Rod(length=1 / rods, mass=1 / rods, radius=0.05 / rods)
    return pp.Scene(
        duration=10.0 if rods < LONG else 0.34,
        model=pp.Chain(rods=[rod], copies=rods),
        start=pp.Start(positions={"theta_1": 0.5, "phi_1": 0.3}),
        effects=[pp.effects.Gravity()],
    )


def compared(console: Console, rods: int, report: CostReport) -> None:
    """The best integrator and the best other, and their ratio, at each error."""
    table = Table(
        "error",
        "pendpin",
        "time",
        "others",
        "time",
        "ratio",
        title=f"{rods} rod{'s' * (rods > 1)}, {report.horizon:g} s",
    )
    for error in ERRORS:
        own, other = report.best(error), report.best(error, peers=True)
        cells = [
            cell for found in (own, other) for cell in ((found[0], time_text(found[1])) if found else ("none", ""))
        ]
        table.add_row(f"{error:g}", *cells, f"{other[1] / own[1]:.3g}" if own and other else "")
    console.print(table)
    console.print(
        f"error of the reference: {report.error:.0e}, the difference of {report.solutions[0]} and {report.solutions[1]}"
    )


def raw_heyoka(given: pp.Scene, tolerance: float, samples: int) -> float:
    """Seconds of heyoka on the closed form of one rod, written out by hand, over the same output times."""
    import heyoka as hy

    m, length, radius, g = 1.0, 1.0, 0.01, 9.81  # as in urdf/universal_rod.urdf
    h, J, I3 = length / 2, m * (3 * radius**2 + length**2) / 12 + m * length**2 / 4, m * radius**2 / 2
    theta, phi, u, w = hy.make_vars("theta", "phi", "u", "w")
    s, c = hy.sin(phi), hy.cos(phi)
    equations = [
        (theta, u),
        (phi, w),
        (u, (2 * (J - I3) * u * w * s - m * g * h * hy.sin(theta)) * c / (J * c * c + I3 * s * s)),
        (w, -((J - I3) * u * u * c + m * g * h * hy.cos(theta)) * s / J),
    ]
    series = hy.taylor_adaptive(equations, np.zeros(4), tol=tolerance, high_accuracy=tolerance < 1e-15)
    times, best = np.linspace(0, given.duration, samples), np.inf
    for _ in range(REPETITIONS):
        series.time, series.state[:] = 0.0, [0.7, 0.4, 1.3, -0.8]
        begin = time.process_time()
        series.propagate_grid(times)
        best = min(best, time.process_time() - begin)
    return best


def beside_raw_heyoka(console: Console, given: pp.Scene) -> None:
    """The Taylor integrator's time over that of heyoka alone."""
    table = Table("tolerance", "pendpin", "heyoka alone", "ratio", title="one rod, 100 s, 201 output times")
    given = given.model_copy(update={"solver": pp.Solver(samples=201)})
    for tolerance in (1e-9, 1e-12, 1e-15, 1e-18):
        own = min(pp.simulate(given.by("taylor", tolerance)).stats.seconds for _ in range(REPETITIONS))
        raw = raw_heyoka(given, tolerance, 201)
        table.add_row(f"{tolerance:g}", time_text(own), time_text(raw), f"{own / raw:.2f}")
    console.print(table)


def main() -> None:
    """Print the comparisons, and write a figure of each where a folder is given."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rods", type=int, nargs="*", default=[1, 3, 10, 30])
    parser.add_argument("--pictures", type=Path)
    parser.add_argument("--thorough", action="store_true", help="all methods at all settings: an hour")
    options, console = parser.parse_args(), Console(width=110)
    for rods in options.rods:
        given = scene(rods)
        report = cost(given, peers=True, thorough=options.thorough)
        compared(console, rods, report)
        if rods == 1:
            beside_raw_heyoka(console, given)
        if options.pictures:
            save_cost_plot(report, options.pictures / f"cost_{rods}.png", short=True)
    console.print(f"{report.machine}; {report.versions}")


if __name__ == "__main__":
    main()
