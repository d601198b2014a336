"""What each effect costs: the time of one evaluation of y' with gravity and that effect, over that with gravity alone.

Run it on an idle machine: python benchmarks/effects.py
"""

import time
from platform import machine, python_version

import numpy as np
from rich.console import Console
from rich.table import Table

import pendpin as pp
from pendpin import effects as fx

REPETITIONS = 7
CALLS = 400
ROD = pp.Rod(length=1.0, mass=1.0, radius=0.01)
MODELS = {
    "1 rod, Pinocchio": (pp.Chain(rods=(ROD,)), "pinocchio"),
    "10 rods, Pinocchio": (pp.Chain(rods=(ROD,), copies=10), "pinocchio"),
    "10 rods, chain": (pp.Chain(rods=(ROD,), copies=10), "chain"),
    "1000 rods, chain": (pp.Chain(rods=(ROD,), copies=1000), "chain"),
}
EFFECTS: dict[str, tuple[fx.Effect, ...]] = {
    "gravity alone": (),
    "gravity alone, again": (),
    "viscous": (fx.Viscous(coefficient=0.1),),
    "spring": (fx.Spring(stiffness=1.0),),
    "motor": (fx.Motor(joint="theta_1", amplitude=1.0, frequency=2.0),),
    "push": (fx.Push(link="rod_1", force=(1, 0, 0), point=0.3),),
    "drag": (fx.Drag(wind=(3, 0, 0)),),
    "drag, linear": (fx.Drag(coefficient=0, linear=0.1),),
    "support": (fx.Support(amplitude=(0.1, 0, 0), frequency=5.0),),
    "rotation": (fx.Rotation(latitude=48.85),),
    "all of them": (
        fx.Viscous(coefficient=0.1),
        fx.Spring(stiffness=1.0),
        fx.Drag(wind=(3, 0, 0), linear=0.1, buoyancy=True),
        fx.Support(amplitude=(0.1, 0, 0), frequency=5.0),
        fx.Rotation(latitude=48.85),
    ),
}


def evaluation(model: pp.Chain, engine: str, effects: tuple[fx.Effect, ...]) -> float:
    """Seconds of one evaluation, minimum over repetitions after one warm-up."""
    scene = pp.Scene(model=model, effects=(fx.Gravity(), *effects), solver=pp.Solver(engine=engine))
    dynamics, nv = pp.bind(scene), 2 * model.count
    derivative, _ = dynamics.engine.derivative(lambda t: None)
    random = np.random.default_rng(0)
    y = dynamics.engine.pack(random.uniform(-1, 1, nv), random.uniform(-1, 1, nv))
    dy, calls = np.empty_like(y), max(5, CALLS // model.count)
    seconds = []
    for _ in range(REPETITIONS + 1):
        begin = time.perf_counter()
        for _ in range(calls):
            derivative(dy, 0.3, y)
        seconds.append((time.perf_counter() - begin) / calls)
    return min(seconds[1:])


def main() -> None:
    """Print the table."""
    table = Table("effect", *MODELS, title="one evaluation: microseconds, and over gravity alone")
    bare = {name: evaluation(*model, ()) for name, model in MODELS.items()}
    for effect, effects in EFFECTS.items():
        cells = []
        for name, model in MODELS.items():
            seconds = evaluation(*model, effects)
            cells.append(f"{seconds * 1e6:,.1f}  {seconds / bare[name]:.2f}")
        table.add_row(effect, *cells)
    console = Console()
    console.print(table)
    console.print(f"pendpin {pp.__version__}, NumPy {np.__version__}, Python {python_version()}, {machine()}")


if __name__ == "__main__":
    main()
