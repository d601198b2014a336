"""Cables against closed forms: the error of n rods, and its order, for beams, an elastica, a rope between two points.

    python benchmarks/cables.py [--rods 8 16 32 64]

Euler and Bernoulli's cantilever (tip under a small load, two frequencies), a heavy clamped elastica by SciPy's boundary
value problem, and the catenary's horizontal force. A table on standard output: error times n², the same for every n
where the order is two.
"""

import argparse
import math
import time

import numpy as np
from scipy.integrate import solve_bvp
from scipy.optimize import brentq

import pendpin as pp
from pendpin import effects as fx

EI, LENGTH, MASS = 3.0, 2.0, 0.5  # N m², m, kg/m
LOAD, APART, STIFF = 1e-6, 1.4, 1e7  # N, m, N/m
GRAVITY = 9.81  # m/s²


def beam(n: int, *effects: fx.Effect, **positions: float) -> pp.Scene:
    """A thin beam in n rods."""
    rods = [pp.Rod(length=LENGTH / n, mass=MASS * LENGTH / n, radius=1e-5, copies=n)]
    start = pp.Start(positions=positions)
    return pp.Scene(duration=1.0, model=pp.Chain(rods=rods), effects=effects, start=start)


def place_at_rest(scene: pp.Scene) -> np.ndarray:
    """Where the last tip is at the equilibrium, (3,) m."""
    return pp.simulate(scene.replace(start=pp.Start.at_rest(scene)), duration=0.0, samples=1).tips[0, -1]


def errors(n: int) -> dict[str, float]:
    """The relative errors of n rods."""
    clamped = fx.Bending(stiffness=EI, clamp=(0, 0, -1))
    pushed = beam(n, clamped, fx.Push(link=f"rod_{n}", force=(LOAD, 0, 0), point=LENGTH / n))
    roots = [brentq(lambda x: math.cos(x) * math.cosh(x) + 1, *ends) for ends in ((1, 3), (4, 6))]
    first, _, second, *_ = pp.modes(beam(n, clamped)).hertz
    exact = np.square(roots) * math.sqrt(EI / (MASS * LENGTH**4)) / (2 * math.pi)
    across = place_at_rest(beam(n, fx.Gravity(), fx.Bending(stiffness=EI, clamp=(0, -1, 0)), theta_1=1.4))[1]
    up = math.acos(APART / LENGTH)
    anchor = fx.Anchor(link=f"rod_{n}", point=(0, -APART, 0), stiffness=STIFF)
    v_shape = {"theta_1": math.pi / 2 - up, f"theta_{n // 2 + 1}": 2 * up}
    tip = place_at_rest(beam(n, fx.Gravity(), anchor, **v_shape))
    a = brentq(lambda a: 2 * a * math.sinh(APART / (2 * a)) - LENGTH, 0.1, 50)
    return {
        "tip of a cantilever": place_at_rest(pushed)[0] / (LOAD * LENGTH**3 / (3 * EI)) - 1,
        "its first frequency": first / exact[0] - 1,
        "its second frequency": second / exact[1] - 1,
        "reach of a heavy elastica": across / elastica() - 1,
        "force H of a catenary": STIFF * (tip[1] + APART) / (MASS * GRAVITY * a) - 1,
    }


def elastica() -> float:
    """How far a clamped heavy beam reaches along -y, m."""
    weight = MASS * GRAVITY
    solved = solve_bvp(
        lambda s, y: np.array([y[1], -weight * (LENGTH - s) * np.cos(y[0]) / EI]),
        lambda a, b: np.array([a[0], b[1]]),
        np.linspace(0, LENGTH, 201),
        np.zeros((2, 201)),
        tol=1e-10,
        max_nodes=10**5,
    )
    s = np.linspace(0, LENGTH, 20001)
    return -float(np.trapezoid(np.cos(solved.sol(s)[0]), s))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rods", type=int, nargs="+", default=[8, 16, 32, 64])
    counts = parser.parse_args().rods
    begin = time.process_time()
    table = {n: errors(n) for n in counts}
    print(f"{'error times n²':28}" + "".join(f"{n:>12} rods" for n in counts))
    for name in table[counts[0]]:
        print(f"{name:28}" + "".join(f"{table[n][name] * n * n:17.4f}" for n in counts))
    print(f"{time.process_time() - begin:.1f} s of processor time")


if __name__ == "__main__":
    main()
