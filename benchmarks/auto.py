"""How good `auto` is: its whole time, compiling included, beside that of the best fixed method and engine, on 24 scenes.

1, 3, 30, 100 rods; bare, damped, drag, moving support, friction, thin; 2 s and 60 s by turns; tolerances 1e-4, 1e-7,
1e-10 by turns. Long chains run for a shorter time (`horizon`). Each choice runs ten times in a process of its own, with
another mass each time, fewer times if these take more than 2 s; heyoka's cache on disk is off. Times are of the
processor; a process has 10 s of it. A fixed choice counts where its tip error is at most three times that of auto, or ten
times its tolerance; errors are against dop853 at 1e-12, or where that takes too long, at the tolerance of the scene.
About 6 minutes of processor time: python benchmarks/auto.py
"""

import argparse
import itertools
import json
import os
import platform
import resource
import subprocess
import sys
import time
from importlib.metadata import version
from statistics import fmean, median
from typing import Any

RODS = (1, 3, 30, 100)
KINDS = ("bare", "damped", "drag", "support", "friction", "thin")
DURATIONS = (2.0, 60.0)
TOLERANCES = (1e-4, 1e-7, 1e-10)
FIXED = (("dop853", "auto"), ("dop853", "compiled"), ("taylor", "auto"), ("lsoda", "compiled"), ("rk45", "compiled"))
RUNS = {1: slice(0, 1), 2: slice(1, 4), 10: slice(7, 10)}  # the first; means, as a clock may tick every 4 ms
LONGEST = 10  # s of processor for a process: a choice that takes longer for its first run is left out


def scene(rods: int, kind: str, duration: float, tolerance: float, choice: tuple[str, str], run: int) -> Any:
    """A chain of 1 m, with a mass of its own for each run."""
    import pendpin as pp
    from pendpin import effects as fx

    more = {
        "damped": (fx.Viscous(coefficient=0.01 / rods**2),),
        "drag": (fx.Drag(wind=(1, 0, 0)),),
        "support": (fx.Support(amplitude=(0.05, 0, 0), frequency=3.0),),
        "friction": (fx.DryFriction(kinetic=0.01 / rods),),
    }
    mass = (1 + 0.01 * run) / rods
    rod = pp.Rod(length=1 / rods, mass=mass, radius=0.0 if kind == "thin" else 0.03 / rods)
    return pp.Scene(
        duration=duration,
        model=pp.Chain(rods=(rod,), copies=rods),
        start=pp.Start(positions={"theta_1": 0.7, "phi_1": 0.4}, velocities={"theta_1": 0.5}),
        effects=(fx.Gravity(), *more.get(kind, ())),
        solver=pp.Solver(method=choice[0], engine=choice[1], tolerance=tolerance, samples=31),
    )


def measured(case: dict[str, Any]) -> dict[str, Any]:
    """In this process: processor seconds of each run, the tips of the first, and what was chosen."""
    import pendpin as pp

    pp.simulate  # noqa: B018  pendpin's own import is no part of a choice
    seconds, first, chosen = [], None, ""
    for run in range(1, max(RUNS) + 1):
        given = scene(case["rods"], case["kind"], case["duration"], case["tolerance"], tuple(case["choice"]), run)
        begin = time.process_time()
        if case["choice"][0] == "taylor" and run == 1:  # its import is part of the choice
            import heyoka

            heyoka.llvm_state.set_diskcache_enabled(False)
        result = pp.simulate(given)
        seconds.append(time.process_time() - begin)
        chosen = f"{result.stats.method} {result.stats.engine}" if run == 1 else chosen
        first = result.tips[:, -1].tolist() if first is None else first
        if sum(seconds) > LONGEST / 5:
            break
    return {"seconds": seconds, "tips": first, "chosen": chosen}


def in_a_process(case: dict[str, Any]) -> dict[str, Any]:
    """The same in a fresh process; "failed" says why there are no times."""
    command = [sys.executable, __file__, "--case", json.dumps(case)]
    found = subprocess.run(command, capture_output=True, text=True)
    if found.returncode == 0:
        return json.loads(found.stdout.splitlines()[-1])
    last = (found.stderr.splitlines() or [""])[-1]
    return {"failed": f"over {LONGEST:g} s" if found.returncode < 0 else last[-150:]}


def apart(one: Any, other: Any) -> float:
    """The largest distance of the tips, over the length of 1 m."""
    import numpy as np

    return float(np.linalg.norm(np.array(one["tips"]) - np.array(other["tips"]), axis=-1).max())


def ratio(one: dict[str, Any], others: list[dict[str, Any]]) -> dict[int, float]:
    """The time of a choice over the least of some others, by the number of the run; a slow one made fewer runs."""
    times = [
        [fmean(found["seconds"][part] or found["seconds"][-1:]) for part in RUNS.values()] for found in (one, *others)
    ]
    return {run: own / min(best) for run, own, *best in zip(RUNS, *times, strict=True)} if others else {}


def row(case: dict[str, Any]) -> tuple[dict[int, float], str]:
    """Auto's time over that of the best fixed choice; what was chosen, and what was best."""
    auto = in_a_process(case | {"choice": ("auto", "auto")})
    if "failed" in auto:
        return {}, f"auto fails: {auto['failed']}"
    truth = in_a_process(case | {"choice": ("dop853", "auto"), "tolerance": 1e-12})
    others = {choice: in_a_process(case | {"choice": choice}) for choice in FIXED}
    truth = others["dop853", "auto"] if "failed" in truth else truth
    others = {choice: found for choice, found in others.items() if "failed" not in found}
    truth = auto if "failed" in truth else truth
    allowed = max(3 * apart(auto, truth), 10 * case["tolerance"])
    good = {choice: found for choice, found in others.items() if apart(found, truth) <= allowed}
    last = [(found["seconds"][-1], " ".join(choice)) for choice, found in good.items()]
    return ratio(auto, list(good.values())), f"{auto['chosen']}; best at last: {min(last, default=(0, 'none'))[1]}"


def horizon(rods: int, kind: str, duration: float) -> float:
    """How long a scene runs, s: long chains for less; with friction hundreds of events in the times that are given here."""
    if kind == "friction" and rods >= 30:
        return 0.15 if rods == 30 else 0.005
    return min(duration, {30: 10.0, 100: 2.0}.get(rods, duration))


def main() -> None:
    """Print a row for each scene, and the median and the worst ratio."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case")
    parser.add_argument("--rods", type=int, nargs="+", choices=RODS, default=RODS)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    options = parser.parse_args()
    if options.case:
        resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST))
        print(json.dumps(measured(json.loads(options.case))))
        return
    table: list[dict[int, float]] = []
    for rods, (j, kind) in itertools.product(options.rods, enumerate(KINDS)):
        if kind not in options.kinds:
            continue
        turn = RODS.index(rods) + j
        case = {"rods": rods, "kind": kind, "tolerance": TOLERANCES[turn % 3]}
        case["duration"] = horizon(rods, kind, DURATIONS[turn % 2])
        ratios, chosen = row(case)
        numbers = " ".join(f"{ratios[run]:5.2f}" if ratios else "    -" for run in RUNS)
        print(f"{rods:3d} {kind:9s}{case['duration']:4g} s {case['tolerance']:6g} {numbers}  {chosen}", flush=True)
        table.extend([ratios] if ratios else [])
    for run in RUNS if table else ():
        numbers = [ratios[run] for ratios in table]
        print(f"run {run}: median {median(numbers):.2f}, worst {max(numbers):.2f} of {len(numbers)} scenes")
    versions = ", ".join(f"{name} {version(name)}" for name in ("pin", "CyRK", "llvmlite", "heyoka", "numpy"))
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, {versions}")


if __name__ == "__main__":
    main()
