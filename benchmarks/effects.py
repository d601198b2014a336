"""What each effect costs: an evaluation of y' with gravity and that effect, over one with gravity alone, as a run makes it.

On the compiled engine, which `auto` takes for all but short runs: processor time of the integration over its evaluations,
and of one call from Python on the engine without compiling. Run it on an idle machine: python benchmarks/effects.py
"""

import time
from pathlib import Path
from platform import machine, python_version

import numpy as np
from rich.console import Console
from rich.table import Table

import pendpin as pp
from pendpin import effects as fx
from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import Compiled
from pendpin.integrators.machine import AdaptiveInMachineCode

REPETITIONS = 7
RODS = (1, 3, 10, 30)
TRACK = Path(__file__).parents[1] / "examples" / "crane_trolley.csv"


def effects(rods: int) -> dict[str, tuple[fx.Effect, ...]]:
    """The effects beside gravity, for a chain of so many rods."""
    first = "theta_1" if rods > 1 else "theta"
    link = "rod_1" if rods > 1 else "rod"
    return {
        "gravity alone": (),
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


def in_a_run(given: pp.Scene) -> float:
    """Seconds of an evaluation in a run of dop853 on the compiled engine; the least of some."""
    dynamics = Dynamics(pp.bind(given).model, given.effects, "compiled")
    assert isinstance(dynamics.engine, Compiled)
    integrator = AdaptiveInMachineCode("dop853", 1e-9)
    derivative, count = integrator.equations(dynamics.engine, lambda t: None)
    nv = len(dynamics.model.joints)
    q = np.zeros(nv)
    q[:2] = 0.5, 0.3
    y, times, best = dynamics.engine.pack(q, np.zeros(nv)), np.array([0.0, given.duration]), np.inf
    for _ in range(REPETITIONS):
        before, begin = count(), time.process_time()
        integrator.integrate(derivative, y, times)
        best = min(best, (time.process_time() - begin) / (count() - before))
    return best


def called(given: pp.Scene) -> float:
    """Seconds of an evaluation called from Python, not compiled; the least of some."""
    engine = pp.bind(given).engine
    derivative, _ = engine.derivative(lambda t: None)
    nv = len(engine.model.joints)
    y = engine.pack(*np.random.default_rng(0).uniform(-1, 1, (2, nv)))
    dy, calls, best = np.empty_like(y), 100, np.inf
    for _ in range(REPETITIONS):
        begin = time.process_time()
        for _ in range(calls):
            derivative(dy, 0.3, y)
        best = min(best, (time.process_time() - begin) / calls)
    return best


def main() -> None:
    """Print the two tables."""
    console = Console(width=120)
    for title, measure in (("compiled, in a run", in_a_run), ("not compiled, called from Python", called)):
        table = Table(
            "effect", *(f"{rods} rods" for rods in RODS), title=f"{title}: us an evaluation, over gravity alone"
        )
        bare = {rods: measure(scene(rods, ())) for rods in RODS}
        for name in effects(1):
            found = {rods: measure(scene(rods, effects(rods)[name])) for rods in RODS}
            table.add_row(name, *(f"{found[rods] * 1e6:.3g}  {found[rods] / bare[rods]:.2f}" for rods in RODS))
        console.print(table)
    console.print(f"pendpin {pp.__version__}, NumPy {np.__version__}, Python {python_version()}, {machine()}")


if __name__ == "__main__":
    main()
