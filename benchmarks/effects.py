"""What each effect costs: an evaluation of y' with gravity and that effect, over one with gravity alone, as a run makes it.

Two tables: machine code, and the engine without compiling, one call from Python. Processor time, of compiled runs that of
the integration over its evaluations; bare and effect take turns, and the least of several counts. On an idle machine:
python benchmarks/effects.py [--rods 1 3 10 30] [--repetitions 9]
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from platform import machine, python_version

import numpy as np
from rich.console import Console
from rich.table import Table

import pendpin as pp
from pendpin import effects as fx
from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import Compiled
from pendpin.integrators.adaptive import Adaptive
from pendpin.scene import method_of

REPETITIONS = 9
RODS = (1, 3, 10, 30)
BARE = "gravity alone"
TRACK = Path(__file__).parents[1] / "examples" / "crane_trolley.csv"


def effects(rods: int) -> dict[str, tuple[fx.Effect, ...]]:
    """The effects beside gravity, for a chain of so many rods."""
    first = "theta_1" if rods > 1 else "theta"
    link = "rod_1" if rods > 1 else "rod"
    return {
        BARE: (),
        "gravity alone, again": (),
        "viscous": (fx.Viscous(coefficient=0.01),),
        "spring": (fx.Spring(stiffness=0.1),),
        "motor": (fx.Motor(joint=first, amplitude=0.1, frequency=2.0),),
        "push": (fx.Push(link=link, force=(0.1, 0, 0), amplitude=(0, 0.1, 0), frequency=2.0, point=0.3 / rods),),
        "drag": (fx.Drag(wind=(3, 0, 0)),),
        "drag, gust, buoyancy": (fx.Drag(wind=(3, 0, 0), gust=(1, 0, 0), frequency=2.0, buoyancy=True),),
        "drag, linear": (fx.Drag(coefficient=0, linear=0.1),),
        "support": (fx.Support(amplitude=(0.1, 0, 0), frequency=5.0),),
        "support, csv": (fx.Support(csv=TRACK),),
        "rotation": (fx.Rotation(latitude=48.85),),
    }


def scene(rods: int, others: tuple[fx.Effect, ...]) -> pp.Scene:
    """A chain of 1 m and 1 kg in all, let go at a slant."""
    rod = pp.Rod(length=1 / rods, mass=1 / rods, radius=0.02 / rods)
    return pp.Scene(
        duration=10.0 / rods,
        model=pp.Chain(rods=(rod,), copies=rods),
        start=pp.Start(positions={"theta_1": 0.5, "phi_1": 0.3}),
        effects=(fx.Gravity(), *others),
    )


def in_a_run(given: pp.Scene) -> Callable[[], float]:
    """A function that returns the seconds of an evaluation in a run of dop853 on the compiled engine."""
    dynamics = Dynamics(pp.bind(given).model, given.effects, "compiled")
    assert isinstance(dynamics.engine, Compiled)
    integrator = Adaptive(method_of("dop853"), 1e-9, in_machine_code=True)
    derivative, count = integrator.equations(dynamics.engine, lambda t: None)
    y = dynamics.engine.pack(*start(given))
    times = np.array([0.0, given.duration])

    def seconds() -> float:
        before, begin = count(), time.process_time()
        integrator.integrate(derivative, y, times)
        return (time.process_time() - begin) / (count() - before)

    return seconds


def called(given: pp.Scene) -> Callable[[], float]:
    """A function that returns the seconds of an evaluation called from Python, not compiled."""
    engine = pp.bind(given).engine
    derivative, _ = engine.derivative(lambda t: None)
    y = engine.pack(*start(given))
    dy, calls = np.empty_like(y), 100

    def seconds() -> float:
        begin = time.process_time()
        for _ in range(calls):
            derivative(dy, 0.3, y)
        return (time.process_time() - begin) / calls

    return seconds


def start(given: pp.Scene) -> np.ndarray:
    """The angles and rates of the start, (2, nv)."""
    state = np.zeros((2, 2 * len(given.model.rods) * given.model.copies))
    state[0, :2] = list(given.start.positions.values())
    return state


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rods", type=int, nargs="+", default=RODS)
    parser.add_argument("--repetitions", type=int, default=REPETITIONS)
    options = parser.parse_args()
    console = Console(width=120)
    kinds = {
        "compiled, in a run": in_a_run,
        "not compiled, called from Python": called,
    }
    for title, measure in kinds.items():
        table = Table(
            "effect", *(f"{rods} rods" for rods in options.rods), title=f"{title}: us an evaluation, over gravity alone"
        )
        columns = {
            rods: least({name: measure(scene(rods, acts)) for name, acts in effects(rods).items()}, options.repetitions)
            for rods in options.rods
        }
        for name in effects(1):
            found = ((column[name], column[BARE]) for column in columns.values())
            table.add_row(name, *(f"{one * 1e6:.3g}  {one / bare:.2f}" for one, bare in found))
        console.print(table)
    console.print(f"pendpin {pp.__version__}, NumPy {np.__version__}, Python {python_version()}, {machine()}")


def least(measures: dict[str, Callable[[], float]], repetitions: int) -> dict[str, float]:
    """The least of several measurements of each, by turns."""
    rounds = [{name: measure() for name, measure in measures.items()} for _ in range(repetitions)]
    return {name: min(found[name] for found in rounds) for name in measures}


if __name__ == "__main__":
    main()
