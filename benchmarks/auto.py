"""How good `auto` is: its whole time, compiling included, beside that of the best fixed method and engine, on 36 scenes.

1, 2, 3, 10, 30, 100 rods; bare, damped, drag, moving support, friction, thin; 2 s and 60 s by turns; tolerances 1e-4,
1e-7, 1e-10 by turns. Each choice runs ten times in a process of its own, with another mass each time; heyoka's cache on
disk is off. Times are of the processor. A fixed choice counts where its tip error is at most three times that of auto, or
ten times its tolerance; errors are against dop853 at 1e-12. Run it on an idle machine: python benchmarks/auto.py
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from statistics import median
from typing import Any

RODS = (1, 2, 3, 10, 30, 100)
KINDS = ("bare", "damped", "drag", "support", "friction", "thin")
DURATIONS = (2.0, 60.0)
TOLERANCES = (1e-4, 1e-7, 1e-10)
FIXED = (("dop853", "auto"), ("dop853", "compiled"), ("taylor", "auto"), ("lsoda", "compiled"), ("rk45", "compiled"))
RUNS = (1, 2, 10)
LONGEST = 20.0  # s of processor: a choice that takes longer for one run is left


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
        first = result.tips()[:, -1].tolist() if first is None else first
        if seconds[-1] > LONGEST / 10:
            break
    return {"seconds": seconds, "tips": first, "chosen": chosen}


def in_a_process(case: dict[str, Any]) -> dict[str, Any] | None:
    """The same in a fresh process; None where the choice does not take the scene, or takes too long."""
    command = [sys.executable, __file__, "--case", json.dumps(case)]
    try:
        found = subprocess.run(command, capture_output=True, text=True, timeout=6 * LONGEST, check=True)
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired):
        return None
    return json.loads(found.stdout.splitlines()[-1])


def apart(one: Any, other: Any) -> float:
    """The largest distance of the tips, over the length of 1 m."""
    import numpy as np

    return float(np.linalg.norm(np.array(one["tips"]) - np.array(other["tips"]), axis=-1).max())


def ratios(case: dict[str, Any]) -> tuple[str, str, dict[int, float]]:
    """What auto chose, what was best, and auto's time over that of the best of each run."""
    truth = in_a_process(case | {"choice": ("dop853", "auto"), "tolerance": 1e-12})
    auto = in_a_process(case | {"choice": ("auto", "auto")})
    others = {choice: in_a_process(case | {"choice": choice}) for choice in FIXED}
    if auto is None or truth is None:
        return "failed", "", {}
    allowed = max(3 * apart(auto, truth), 10 * case["tolerance"])
    good = {choice: found for choice, found in others.items() if found and apart(found, truth) <= allowed}
    out: dict[int, float] = {}
    for run in RUNS:
        times = [found["seconds"][min(run, len(found["seconds"])) - 1] for found in good.values()]
        own = auto["seconds"][min(run, len(auto["seconds"])) - 1]
        if times:
            out[run] = own / min(times)
    best = min(good, key=lambda choice: good[choice]["seconds"][0]) if good else ("", "")
    return auto["chosen"], " ".join(best), out


def main() -> None:
    """Print a row for each scene, and the median and the worst ratio."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case")
    parser.add_argument("--rods", type=int, nargs="+", choices=RODS, default=RODS[:-1], help="all but 100 if absent")
    options = parser.parse_args()
    if options.case:
        print(json.dumps(measured(json.loads(options.case))))
        return
    rows: dict[int, list[float]] = {run: [] for run in RUNS}
    for rods in options.rods:
        for j, kind in enumerate(KINDS):
            turn = RODS.index(rods) + j
            case = {"rods": rods, "kind": kind, "duration": DURATIONS[turn % 2], "tolerance": TOLERANCES[turn % 3]}
            if rods >= 30 and case["duration"] > 2:
                case["duration"] = 2.0 if rods == 100 else 10.0
            chosen, best, found = ratios(case)
            for run, ratio in found.items():
                rows[run].append(ratio)
            numbers = "  ".join(f"{found[run]:5.2f}" if run in found else "    -" for run in RUNS)
            what = f"{rods:3d} {kind:9s}{case['duration']:4g} s {case['tolerance']:7g}"
            print(f"{what}  {numbers}  {chosen:35s} best at first: {best}", flush=True)
    for run, ratio in rows.items():
        if ratio:
            print(f"run {run}: median {median(ratio):.2f}, worst {max(ratio):.2f} of {len(ratio)} scenes")
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")


if __name__ == "__main__":
    main()
