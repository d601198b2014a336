"""What pendpin adds to Pinocchio: wall time of a run over (evaluations x one bare pin.aba call).

Run it on an idle machine: python benchmarks/overhead.py
"""

import time

import numpy as np
from rich.console import Console
from rich.table import Table

import pendpin as pp
from pendpin.bodies import pinocchio
from pendpin.scene import builtin_scene

REPETITIONS = 7


def bare_aba(dynamics: pp.Dynamics, calls: int = 50_000) -> float:
    """Seconds of one pin.aba call from Python, minimum over repetitions."""
    pin, model = pinocchio(), dynamics.model.pin
    aba, data = pin.aba, model.createData()
    q, v, tau = np.array([0.7, 0.4]), np.array([1.3, -0.8]), np.zeros(2)
    best = np.inf
    for _ in range(REPETITIONS):
        begin = time.perf_counter()
        for _ in range(calls):
            aba(model, data, q, v, tau)
        best = min(best, (time.perf_counter() - begin) / calls)
    return best


def main() -> None:
    """Print the ratio for several methods and tolerances; the bound is 2.5 on CyRK."""
    scene = builtin_scene().model_copy(update={"duration": 100.0})
    aba = bare_aba(pp.bind(scene))
    table = Table(
        "method", "tolerance", "evaluations", "integration, s", "over bare aba", title=f"aba {aba * 1e6:.2f} us"
    )
    for method, tolerance in (("dop853", 1e-9), ("dop853", 1e-12), ("rk45", 1e-9), ("lsoda", 1e-9)):
        runs = [pp.simulate(scene, method=method, tolerance=tolerance).stats for _ in range(REPETITIONS)]
        best = min(runs, key=lambda stats: stats.seconds)
        ratio = best.seconds / (best.evaluations * aba)
        table.add_row(method, f"{tolerance:g}", str(best.evaluations), f"{best.seconds:.4f}", f"{ratio:.2f}")
    console = Console()
    console.print(table)
    console.print(
        f"{best.library} {best.version}, 100 s of the built-in rod, 6001 output times, minimum of {REPETITIONS}"
    )


if __name__ == "__main__":
    main()
