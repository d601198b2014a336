"""pendpin beside MuJoCo, Drake and plain SciPy on pin.aba: error against time, on one rod and chains.

    python benchmarks/peers.py [--rods 1 3 10 30 100] [--pictures docs/images] [--thorough]
    python benchmarks/peers.py --pages    # the tables of README.md and docs/accuracy.md too

Times are of the processor, so that other processes matter little. At tip errors of 1e-3, 1e-6 and 1e-9 it prints the best of
pendpin's methods and the best of the others, twice: integration with its sampling alone, and whole calls. A whole call of
pendpin is `simulate` of a scene, with all its results. That of another simulator reads its model from the text of a URDF,
prepares its integrator and returns the positions. Beside them stands `simulate(accuracy=error)`, which finds its method and
setting itself. For one rod the Taylor integrator is compared with heyoka fed with the closed form by hand.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

import pendpin as pp
from pages import write_between_marks
from pendpin.errors import RunError
from pendpin.integrators import uncompiled
from pendpin.scene import builtin_scene
from pendpin.verification.simulators import PeerTask, drake_peers, mujoco_peers, scipy_peers, task_of
from pendpin.verification.work_precision.cost import SAMPLES, cost
from pendpin.verification.work_precision.report import UNCOMPILED, CostReport, time_text

TOP = Path(__file__).parents[1]
ERRORS = (1e-3, 1e-6, 1e-9)
SHOWN = ((1, 1e-6), (3, 1e-6), (3, 1e-9), (100, 1e-6))  # rods and error: the rows of README
MAKERS = {"mujoco": mujoco_peers, "drake": drake_peers, "scipy": scipy_peers}
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


class Best(NamedTuple):
    """The fastest at an error, and its time."""

    name: str
    seconds: float

    @property
    def cell(self) -> str:
        """The two of a table."""
        return f"{self.name} {time_text(self.seconds)}" if self.name else "none"


NONE = Best("", np.inf)  # where nothing reached the error in the time allowed


class Row(NamedTuple):
    """What an error costs."""

    model: str
    rods: int
    error: float
    own: Best  # integration with its sampling
    other: Best
    own_call: Best  # whole calls
    other_call: Best
    by_accuracy: float | None  # s; None where the accuracy was refused

    @property
    def cells(self) -> tuple[str, ...]:
        """Those of a table."""
        bests = (self.own, self.other, self.own_call, self.other_call)
        found = "refused" if self.by_accuracy is None else time_text(self.by_accuracy)
        return (self.model, f"{self.error:.0e}".replace("e-0", "e-"), *(best.cell for best in bests), found)


HEADINGS = (
    "model, time",
    "error",
    "integration: pendpin",
    "integration: others",
    "whole call: pendpin",
    "whole call: others",
    "`simulate(accuracy=error)`",
)


def rows_of(given: pp.Scene, rods: int, report: CostReport) -> list[Row]:
    """A row for each error."""
    task, model = task_of(given), f"{rods} rod{'s' * (rods > 1)}, {report.horizon:.3g} s"

    def own(name: str, setting: float) -> Any:
        scene = given.by(name.removesuffix(UNCOMPILED), setting)
        return pp.simulate(uncompiled(scene) if name.endswith(UNCOMPILED) else scene)

    def other(name: str, setting: float) -> Any:
        return run_elsewhere(name, task, setting)

    return [
        Row(
            model,
            rods,
            error,
            *(Best(*report.best(error, peers)) if report.best(error, peers) else NONE for peers in (False, True)),
            fastest_call(report, error, False, own),
            fastest_call(report, error, True, other),
            by_accuracy(given, error) if error >= report.error else None,
        )
        for error in ERRORS
    ]


def run_elsewhere(name: str, task: PeerTask, setting: float) -> Any:
    """A whole call of another simulator, from the text of the model to the positions."""
    return next(one for one in MAKERS[name.split()[0]](task) if one.name == name).run(setting)


def fastest_call(report: CostReport, error: float, peers: bool, call: Callable[[str, float], Any]) -> Best:
    """The fastest whole call at an error, of all methods whose integration alone does not take longer than one found."""
    curves = [curve for curve in report.curves if curve.peer == peers]
    met = [(*found, curve.name) for curve in curves if (found := curve.setting_and_seconds_at(error))]
    best = NONE
    for setting, alone, name in sorted(met, key=lambda one: one[1]):
        if alone < best.seconds:
            best = min(best, Best(name, seconds(lambda: call(name, setting))), key=lambda one: one.seconds)  # noqa: B023
    return best


def by_accuracy(given: pp.Scene, error: float) -> float | None:
    """s of a run that is asked for its accuracy alone; None where it is refused."""
    try:
        return seconds(lambda: pp.simulate(given, accuracy=error))
    except RunError:
        return None


def seconds(call: Callable[[], Any]) -> float:
    """The least processor time of a call, after one that warms up."""
    call()
    best = np.inf
    for _ in range(REPETITIONS):
        begin = time.process_time()
        call()
        best = min(best, time.process_time() - begin)
    return best


def markdown(rows: list[Row]) -> list[str]:
    """The lines of a table of a page."""
    lines = (" | ".join(cells) for cells in (HEADINGS, ["---"] * len(HEADINGS), *(row.cells for row in rows)))
    return [f"| {line} |" for line in lines]


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
    parser.add_argument("--rods", type=int, nargs="*", default=[1, 3, 10, 30, 100])
    parser.add_argument("--pictures", type=Path)
    parser.add_argument("--thorough", action="store_true", help="all methods at all settings: an hour")
    parser.add_argument("--pages", action="store_true", help="write the tables of README.md and docs/accuracy.md")
    options, console, rows = parser.parse_args(), Console(width=170), list[Row]()
    for rods in options.rods:
        given = scene(rods)
        report = cost(given, peers=True, thorough=options.thorough)
        samples = round((SAMPLES - 1) * report.horizon / given.duration) + 1
        given = given.model_copy(update={"duration": report.horizon}).with_solver(samples=samples)
        found = rows_of(given, rods, report)
        table = Table(*HEADINGS)
        for row in found:
            table.add_row(*row.cells)
        console.print(table)
        console.print(f"error of the reference: {report.error:.0e}, of {' and '.join(report.solutions)}")
        rows += found
        if rods == 1:
            beside_raw_heyoka(console, given)
        if options.pictures:
            report.plot(options.pictures / f"cost_{rods}.png")
        console.print(f"{report.machine}; {report.versions}")
    if options.pages:
        write_between_marks(TOP / "docs" / "accuracy.md", "costs", markdown(rows))
        shown = [row for row in rows if (row.rods, row.error) in SHOWN]
        write_between_marks(TOP / "README.md", "costs", markdown(shown))


if __name__ == "__main__":
    main()
