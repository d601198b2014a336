"""What a call costs beside what its physics costs: whole calls of pendpin and the same work by hand, in one process.

    python benchmarks/one_run.py [--starts 5000] [--repetitions 20] [--rows NAME ...]
    python benchmarks/one_run.py --walk docs/contributing/walk.md    # the way of one call through the house, as a page
    python benchmarks/one_run.py --rows planar start mass many sweep --page   # the table of docs/accuracy.md

Times are of the processor, the least of the repetitions, each call warmed up, and its peer's by turns. heyoka by hand is the
planar double pendulum by Lagrange's equations in absolute angles, at pendpin's tolerance, compiled before it is timed.
"""

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

import heyoka as hy
import numpy as np
import pinocchio as pin
import scipy.linalg

import pendpin as pp
from pages import write_between_marks
from pendpin.model.build import build
from pendpin.sweeps.plan import pairs

TOLERANCE, SAMPLES = 1e-9, 201
ROD = pp.Rod(length=1.0, mass=1.0, radius=0.01)
GRAVITY = pp.effects.Gravity()
PACKAGE = Path(pp.__file__).parent
LAB = Path(__file__).parents[1] / "examples/lab"


def chain(rods: int, duration: float, first: float = 1.0, **solver: Any) -> pp.Scene:
    """Rods of 1 m in a row in all, in the plane of theta, let go from rest."""
    rod = ROD if rods < 3 else pp.Rod(length=1 / rods, mass=1 / rods, radius=0.01 / rods)
    return pp.Scene(
        duration=duration,
        model=pp.Chain(rods=[rod], copies=rods),
        start=pp.Start(positions={"theta_1": first}),
        effects=[GRAVITY],
        solver=pp.Solver(**solver),
    )


PLANAR = chain(2, 5.0, 2.0, samples=SAMPLES, tolerance=TOLERANCE)
SHORT = chain(1, 0.1, 0.7, tolerance=TOLERANCE, method="dop853")
HANGING = chain(100, 1.0, 0.0)


def lagrange() -> list[tuple[Any, Any]]:
    """The planar double pendulum of two such rods on heyoka's symbols, by Lagrange, in absolute angles."""
    length, m, h, inertia = 1.0, 1.0, 0.5, (3 * 0.01**2 + 1) / 12
    a, b, u, w = hy.make_vars("a", "b", "u", "w")
    coupling, turn = m * length * h * hy.cos(a - b), m * length * h * hy.sin(a - b)
    first, second = inertia + m * h * h + m * length * length, inertia + m * h * h
    right_a = -turn * w * w - (m * h + m * length) * 9.81 * hy.sin(a)
    right_b = turn * u * u - m * h * 9.81 * hy.sin(b)
    determinant = first * second - coupling * coupling
    u_dot = (second * right_a - coupling * right_b) / determinant
    return [(a, u), (b, w), (u, u_dot), (w, (first * right_b - coupling * right_a) / determinant)]


def by_hand() -> Callable[[], Any]:
    """One motion, at all output times."""
    series, grid = hy.taylor_adaptive(lagrange(), np.zeros(4), tol=TOLERANCE), PLANAR.times

    def run() -> Any:
        series.time, series.state[:] = 0.0, [2.0, 2.0, 0.0, 0.0]
        return series.propagate_grid(grid)[-1]

    return run


def starts(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Planar starts at rest, (count, 4)."""
    q = np.zeros((count, 4))
    q[:, [0, 2]] = np.random.default_rng(0).uniform(-2.0, 2.0, (count, 2))
    return q, np.zeros_like(q)


def batch_by_hand(count: int, width: int = 8) -> Callable[[], Any]:
    """Many motions side by side in vectors."""
    series = hy.taylor_adaptive_batch(lagrange(), np.zeros((4, width)), tol=TOLERANCE)
    grid, (q, _) = np.repeat(PLANAR.times[:, None], width, 1), starts(count)

    def run() -> Any:
        for place in range(0, count, width):
            one = np.resize(q[place : place + width], (width, 4))
            series.set_time(0.0)
            series.state[:] = [one[:, 0], one[:, 0] + one[:, 2], 0 * one[:, 0], 0 * one[:, 0]]
            series.propagate_grid(grid)

    return run


def modes_by_hand() -> Callable[[], Any]:
    """Natural frequencies of the hanging chain: Pinocchio's derivatives, and a symmetric eigenproblem."""
    model = build(HANGING.model).pin.copy()
    model.gravity = pin.Motion(np.array([0.0, 0.0, -9.81, 0.0, 0.0, 0.0]))
    data, zero = model.createData(), np.zeros(model.nv)

    def run() -> Any:
        stiffness = pin.computeRNEADerivatives(model, data, zero, zero, zero)[0]
        mass = pin.crba(model, data, zero)
        mass = np.triu(mass) + np.triu(mass, 1).T
        return np.sqrt(scipy.linalg.eigh((stiffness + stiffness.T) / 2, mass)[0])

    return run


def fit_by_hand() -> Callable[[], Any]:
    """The same swings by scipy.optimize.least_squares around RK4 in Numba, from a guess that is near.

    x'' = -a sin x - b tanh(x'/0.01) - c |x'| x', measured with an offset; every swing has a start of its own.
    """
    import numba
    from scipy.optimize import least_squares

    data = np.genfromtxt(LAB / "single.csv", delimiter=",", names=True)
    swings = [data[data["segment"] == number] for number in np.unique(data["segment"])]

    @numba.njit
    def rate(v: float, x: float, a: float, b: float, c: float) -> float:
        return -a * np.sin(x) - b * np.tanh(v / 0.01) - c * abs(v) * v

    @numba.njit
    def motion(x: float, v: float, a: float, b: float, c: float, h: float, count: int, parts: int) -> np.ndarray:
        out = np.empty(count)
        out[0] = x
        h /= parts
        for i in range(1, count):
            for _ in range(parts):
                k1, l1 = v, rate(v, x, a, b, c)
                k2, l2 = v + h / 2 * l1, rate(v + h / 2 * l1, x + h / 2 * k1, a, b, c)
                k3, l3 = v + h / 2 * l2, rate(v + h / 2 * l2, x + h / 2 * k2, a, b, c)
                k4, l4 = v + h * l3, rate(v + h * l3, x + h * k3, a, b, c)
                x, v = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), v + h / 6 * (l1 + 2 * l2 + 2 * l3 + l4)
            out[i] = x
        return out

    def residuals(z: np.ndarray) -> np.ndarray:
        parts = [
            motion(x, v, *z[:3], float(np.diff(swing["t"]).mean()), len(swing), 4) + z[3] - swing["angle_1"]
            for swing, (x, v) in zip(swings, z[4:].reshape(-1, 2), strict=True)
        ]
        return np.concatenate(parts)

    starts = [[swing["angle_1"][0], (swing["angle_1"][1] - swing["angle_1"][0]) / 0.02] for swing in swings]
    guess = np.concatenate([[64.0, 0.15, 0.01, 0.0], np.ravel(starts)])
    return lambda: least_squares(residuals, guess, x_scale=np.maximum(np.abs(guess), 1e-3))


def rows(count: int) -> dict[str, Callable[[], tuple[str, Callable[[], Any], str, Callable[[], Any]]]]:
    """By name: the work, the call, what stands beside it, and its call."""
    many = starts(min(count, 5000))
    vary = {"start.positions.theta_1": many[0][:, 0], "start.positions.theta_2": many[0][:, 2]}

    def accuracy(work: str, scene: pp.Scene) -> tuple[str, Callable[[], Any], str, Callable[[], Any]]:
        found = pp.simulate(scene, accuracy=1e-6)
        setting = {"step": found.stats.step} if found.stats.step else {"tolerance": found.stats.tolerance}
        return (
            f"accuracy=1e-6, {work}",
            lambda: pp.simulate(scene, accuracy=1e-6),
            f"one run, {found.stats.method}, {found.stats.setting}",
            lambda: pp.simulate(scene, method=found.stats.method, **setting),
        )

    def others(key: str) -> Callable[[], Any]:
        """A run of the next scene: of more than a thread keeps prepared."""
        scenes = cycle([PLANAR.replace({key: value}) for value in np.linspace(1.0, 2.0, 32).tolist()])
        return lambda: pp.simulate(next(scenes))

    laboratory = LAB / "single.toml", LAB / "single.csv"
    return {
        "planar": lambda: ("planar double pendulum, 5 s", lambda: pp.simulate(PLANAR), "heyoka by hand", by_hand()),
        "start": lambda: ("from another start", others("start.positions.theta_1"), "heyoka by hand", by_hand()),
        "mass": lambda: ("with another mass", others("model.rods[0].mass"), "heyoka by hand", by_hand()),
        "many": lambda: (
            f"{count} of them, simulate_many",
            lambda: pp.simulate_many(PLANAR, *many, workers=1),
            "heyoka's batch by hand",
            batch_by_hand(count),
        ),
        "sweep": lambda: (
            f"{count} of them, sweep",
            lambda: pp.sweep(PLANAR, pairs(vary), ["swing"]),
            "heyoka's batch by hand",
            batch_by_hand(count),
        ),
        "short": lambda: ("0.1 s of one rod", lambda: pp.simulate(SHORT), "a call of 1 ms", lambda: time.sleep(0)),
        "accuracy 1": lambda: accuracy("1 rod, 100 s", chain(1, 100.0)),
        "accuracy 2": lambda: accuracy("2 rods, 5 s", chain(2, 5.0)),
        "accuracy 100": lambda: accuracy("100 rods, 0.34 s", chain(100, 0.34)),
        "modes": lambda: ("modes of 100 hanging rods", lambda: pp.modes(HANGING), "Pinocchio, eigh", modes_by_hand()),
        "fit": lambda: (
            "fit of examples/lab/single",
            lambda: pp.fit(*laboratory, "physics"),
            "least_squares by hand",
            fit_by_hand(),
        ),
    }


def seconds(calls: Sequence[Callable[[], Any]], repetitions: int) -> list[float]:
    """The least processor time of each call, made by turns, so that a busy machine slows all of them; after one each."""
    for call in calls:
        call()
    best = [np.inf] * len(calls)
    for _ in range(repetitions):
        for i, call in enumerate(calls):
            begin = time.process_time()
            call()
            best[i] = min(best[i], time.process_time() - begin)
    return best


def walk(call: Callable[[], Any]) -> dict[tuple[str, str], int]:
    """The functions of pendpin that a call enters (file, name), in the order of their first entry."""
    entered: dict[tuple[str, str], int] = {}

    def note(frame: Any, event: str, _: Any) -> None:
        code = frame.f_code
        if event == "call" and code.co_filename.startswith(str(PACKAGE)) and not code.co_name.startswith("<"):
            file = str(Path(code.co_filename).relative_to(PACKAGE))
            entered.setdefault((file, code.co_qualname), len(entered))

    sys.setprofile(note)
    try:
        call()
    finally:
        sys.setprofile(None)
    return entered


def walks() -> dict[str, dict[tuple[str, str], int]]:
    """The walks of two calls, each at its second time."""
    scene = chain(1, 2.0, 0.7)
    calls = {
        'simulate(scene, tolerance=1e-9, method="dop853")': lambda: pp.simulate(scene, tolerance=1e-9, method="dop853"),
        "simulate(scene, accuracy=1e-8)": lambda: pp.simulate(scene, accuracy=1e-8),
    }
    for call in calls.values():
        call()
    return {name: walk(call) for name, call in calls.items()}


def page(entered: dict[tuple[str, str], int], call: str) -> str:
    """The walk of a call as a page."""
    count = Counter(file for file, _ in entered)
    lines = [
        "# The way of one call",
        "",
        f"`{call}` of one rod enters {len(entered)} functions in {len(count)} files at its second time. They are listed by",
        "file, in the order in which the call first comes to each file. `python benchmarks/one_run.py --walk PAGE` writes",
        "this page.",
        "",
        "| file | functions |",
        "|---|---|",
    ]
    for file in count:
        names = ", ".join(f"`{name}`" for path, name in entered if path == file)
        lines.append(f"| `{file}` | {names} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Print the table, or write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--starts", type=int, default=5000)
    parser.add_argument("--repetitions", type=int, default=20)
    parser.add_argument("--rows", nargs="*", default=None)
    parser.add_argument("--walk", type=Path, default=None)
    parser.add_argument("--page", action="store_true", help="write the table of docs/accuracy.md")
    given = parser.parse_args()
    entered = walks()
    if given.walk:
        call = next(iter(entered))
        given.walk.write_text(page(entered[call], call))
        return
    ratios: dict[str, tuple[float, float]] = {}
    for name, row in rows(given.starts).items():
        if given.rows is None or name in given.rows:
            work, call, beside, other = row()
            few = (
                max(1, given.repetitions // 10)
                if name in ("many", "sweep", "accuracy 100", "fit")
                else given.repetitions
            )
            own, peer = seconds((call, other), few)
            ratios[name] = own, own / peer
            ratio = f"{own / peer:6.1f} times" if name != "short" else ""
            print(f"{work:32} {own * 1e3:9.2f} ms   {beside}: {peer * 1e3:.3g} ms {ratio}")
    if given.page:
        words = {
            "planar": f"`simulate` of a scene that ran before in this thread, {ratios['planar'][0] * 1e3:.2g} ms",
            "start": "`simulate` from another start",
            "mass": "`simulate` with another mass",
            "many": f"`simulate_many` of {given.starts:,} starts",
            "sweep": "`sweep` of the same starts, with their swing",
        }
        lines = ["| call | times heyoka by hand |", "|---|---|"]
        lines += [f"| {text} | {ratios[name][1]:.2g} |" for name, text in words.items()]
        write_between_marks(Path(__file__).parents[1] / "docs" / "accuracy.md", "by hand", lines)
    for name, functions in entered.items():
        print(f"{name}: {len(functions)} functions in {len({file for file, _ in functions})} files")


if __name__ == "__main__":
    main()
