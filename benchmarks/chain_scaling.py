"""Time and memory of one evaluation of a chain against its number of rods: accelerations alone in machine code, which
integrates motions, and accelerations with all reactions by other routes.

Each row is measured in a process of its own: peak memory beyond what the process had after its imports, then the
minimum time of repeated calls after a warm-up. Run it on an idle machine:
python benchmarks/chain_scaling.py [--most 100000] [--seconds 2]
"""

import argparse
import multiprocessing
import platform
import resource
import time
from collections.abc import Callable
from importlib.metadata import version

import numpy as np
from rich.console import Console
from rich.table import Table

from pendpin.equations.chain import solution, thin
from pendpin.equations.chain.kinematics import ChainInertia

GRAVITY = np.array([0.0, 0.0, 9.81])  # m/s², in I


def inertia(n: int, radius: float) -> ChainInertia:
    """n rods of 1 m and 1 kg."""
    one = np.ones(n)
    across = one * (3 * radius**2 + 1) / 12
    return ChainInertia(one, one / 2, one, across, across, one * radius**2 / 2)


def state(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Angles and rates (n, 2) of a moderate random state."""
    rng = np.random.default_rng(0)
    return rng.uniform(-1, 1, (n, 2)), rng.uniform(-1, 1, (n, 2))


def by_reactions(n: int) -> Callable[[], object]:
    """The hand-derived O(n) route."""
    rods, (q, v) = inertia(n, 0.01), state(n)
    return lambda: solution.solve(rods, q, v, GRAVITY)


def in_directions(n: int) -> Callable[[], object]:
    """The same for thin rods, with directions as the state."""
    rods, (d, rate) = inertia(n, 0.0), thin.directions(*state(n))
    return lambda: thin.solve(rods, d, rate, GRAVITY)


def by_pinocchio(n: int) -> Callable[[], object]:
    """Pinocchio: aba for the accelerations, rnea for the reactions, two revolute joints per rod."""
    import pinocchio as pin

    rods, (q, v) = inertia(n, 0.01), state(n)
    model, above = pin.Model(), 0
    model.gravity = pin.Motion(np.array([0.0, 0.0, -9.81, 0.0, 0.0, 0.0]))
    for i in range(n):
        place = pin.SE3(np.eye(3), np.array([0.0, 0.0, -1.0 if i else 0.0]))
        above = model.addJoint(above, pin.JointModelRevoluteUnaligned(-1, 0, 0), place, f"theta_{i + 1}")
        axis = pin.JointModelRevoluteUnaligned(0, -1, 0)
        above = model.addJoint(above, axis, pin.SE3.Identity(), f"phi_{i + 1}")
        body = pin.Inertia(rods.m[i], np.array([0, 0, -rods.h[i]]), np.diag([rods.I1[i], rods.I2[i], rods.I3[i]]))
        model.appendBodyToJoint(above, body, pin.SE3.Identity())
    data, q, v, tau = model.createData(), q.ravel(), v.ravel(), np.zeros(2 * n)
    return lambda: pin.rnea(model, data, q, v, pin.aba(model, data, q, v, tau))


def in_machine_code(radius: float) -> Callable[[int], Callable[[], object]]:
    """Compiled equations: y' of the state, as an integrator calls it, for one call."""

    def of_rods(n: int) -> Callable[[], object]:
        from pendpin import Chain, Rod
        from pendpin.dynamics.dynamics import Dynamics
        from pendpin.effects import Gravity
        from pendpin.model.build import build

        model = build(Chain(rods=[Rod(length=1.0, mass=1.0, radius=radius)], copies=max(n, 2)))
        engine = Dynamics(model, (Gravity(),), "compiled", "angles" if radius else "directions").engine
        y = engine.pack(*(x.reshape(-1) for x in state(max(n, 2))))
        block, dy = engine.block(), np.empty_like(y)
        call, given = block.function.code().call, (dy.ctypes.data, 0.0, y.ctypes.data, block.address, None)
        return lambda: (call(*given), block, y, dy)

    return of_rods


ROUTES = {
    "machine code, thick rods": (in_machine_code(0.01), (3, 10, 30, 100, 300, 1000, 10_000, 100_000)),
    "machine code, thin rods": (in_machine_code(0.0), (3, 10, 30, 100, 300, 1000, 10_000, 100_000)),
    "reactions, O(n)": (by_reactions, (10, 100, 1000, 10_000)),
    "directions (thin), O(n)": (in_directions, (10, 100, 1000, 10_000)),
    "Pinocchio aba + rnea": (by_pinocchio, (10, 100, 200)),
}


def peak() -> float:
    """Peak resident memory of this process in MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def measure(route: str, n: int, seconds: float) -> tuple[float, float]:
    """Seconds of one evaluation, and MB that setting up and evaluating took."""
    ROUTES[route][0](1)()  # imports and warm-up
    before = peak()
    evaluate = ROUTES[route][0](n)
    evaluate()
    memory, best, end = peak() - before, np.inf, time.process_time() + seconds
    while time.process_time() < end:
        begin = time.process_time()
        evaluate()
        best = min(best, time.process_time() - begin)
    return best, memory


def main() -> None:
    """Print the table, and how the time per rod grows from 1,000 to 10,000 rods."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--most", type=int, default=100_000, help="rods")
    parser.add_argument("--seconds", type=float, default=2.0, help="of repetitions of each evaluation")
    options = parser.parse_args()
    table = Table(title="one evaluation: accelerations; but for machine code with all reactions")
    for title in ("route", "rods", "us", "us per rod", "MB"):
        table.add_column(title, justify="left" if title == "route" else "right")
    per_rod = {}
    with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as pool:
        for route, (_, sizes) in ROUTES.items():
            for n in (size for size in sizes if size <= options.most):
                seconds, memory = pool.apply(measure, (route, n, options.seconds))
                per_rod[route, n] = seconds / n
                table.add_row(route, f"{n:,}", f"{seconds * 1e6:,.0f}", f"{seconds / n * 1e6:.3f}", f"{memory:,.1f}")
    console = Console()
    console.print(table)
    if ("reactions, O(n)", 10_000) in per_rod:
        growth = per_rod["reactions, O(n)", 10_000] / per_rod["reactions, O(n)", 1000]
        console.print(f"time per rod at 10,000 rods over that at 1,000: {growth:.2f} (bound 1.5)")
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "pin", "llvmlite"))
    console.print(f"{packages}, Python {platform.python_version()}, {platform.machine()}")


if __name__ == "__main__":
    main()
