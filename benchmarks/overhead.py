"""What pendpin adds to Pinocchio: wall time of a run over (evaluations x one bare pin.aba call).

Run it on an idle machine: python benchmarks/overhead.py [--repetitions 7] [--duration 100]
"""

import argparse
import time

import numpy as np
from rich.console import Console
from rich.table import Table

import pendpin as pp
from pendpin.model.bodies import pinocchio
from pendpin.scene import builtin_scene

REPETITIONS = 7


def chain() -> pp.Scene:
    """Thirty rods, 1 m long in all, let go at a slant."""
    return pp.Scene(
        duration=10.0,
        model=pp.Chain(rods=[pp.Rod(length=1 / 30, mass=1 / 30, radius=0.05 / 30)], copies=30),
        start=pp.Start(positions={"theta_1": 0.5, "phi_1": 0.3}),
        effects=[pp.effects.Gravity()],
    )


def bare_aba(dynamics: pp.Dynamics, repetitions: int, calls: int = 20_000) -> float:
    """Seconds of one pin.aba call from Python, minimum over repetitions."""
    pin, model = pinocchio(), dynamics.model.pin
    aba, data, random = pin.aba, model.createData(), np.random.default_rng(0)
    q, v, tau = random.uniform(-0.7, 0.7, model.nq), random.uniform(-1, 1, model.nv), np.zeros(model.nv)
    best = np.inf
    for _ in range(repetitions):
        begin = time.process_time()
        for _ in range(calls):
            aba(model, data, q, v, tau)
        best = min(best, (time.process_time() - begin) / calls)
    return best


def measured(console: Console, title: str, scene: pp.Scene, repetitions: int) -> None:
    """The ratio for several methods and tolerances."""
    aba = bare_aba(pp.bind(scene), repetitions)
    table = Table("method", "tolerance", "evaluations", "integration, s", "over bare aba")
    for method, tolerance in (("dop853", 1e-6), ("dop853", 1e-9), ("dop853", 1e-12), ("rk45", 1e-9), ("lsoda", 1e-9)):
        runs = [pp.simulate(scene, method=method, tolerance=tolerance).stats for _ in range(repetitions)]
        best = min(runs, key=lambda stats: stats.seconds)
        ratio = best.seconds / (best.evaluations * aba)
        table.add_row(method, f"{tolerance:g}", str(best.evaluations), f"{best.seconds:.4f}", f"{ratio:.2f}")
    console.print(f"{title}: bare aba {aba * 1e6:.2f} us; {best.library} {best.version}, least of {repetitions}")
    console.print(table)


def main() -> None:
    """Print the ratios; the bounds on CyRK are 2.5 for one rod and 1.3 for thirty."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repetitions", type=int, default=REPETITIONS)
    parser.add_argument("--duration", type=float, default=100.0, help="s, of one rod; of thirty a tenth")
    options, console = parser.parse_args(), Console()
    for title, scene, duration in (
        ("the built-in rod", builtin_scene(), options.duration),
        ("30 rods", chain(), options.duration / 10),
    ):
        timed = scene.model_copy(update={"duration": duration})
        measured(console, f"{title}, {duration:g} s", timed, options.repetitions)


if __name__ == "__main__":
    main()
