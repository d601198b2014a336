"""Accuracy as the target: random scenes of every kind, every method, and the true error of what is returned.

    python benchmarks/goal.py --count 500 --seed 1 --file goal.jsonl     # continues where the file ends
    python benchmarks/goal.py --file goal.jsonl --table                  # the summary
    python benchmarks/goal.py --replay 17 --seed 1                       # one scene again
    python benchmarks/goal.py --timed --count 3000 --seed 1 --file timed.jsonl   # timed_scenes.py

Scene number i gets pair i of all methods and accuracies, in turn, so that every pair is used equally often. Its true
error is the distance to benchmarks/reference_motion.py. A claim is false if a run is returned whose true error is above the
target; a refusal is avoidable if some tolerance or step of the same method meets the target.
"""

import argparse
import json
import math
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import pendpin as pp
from pendpin import effects as fx
from pendpin.errors import Halted
from pendpin.model.build import build
from pendpin.model.kinematics import chain_length, tip_distance
from pendpin.scene import fixed_methods, method_of
from reference_motion import Reference, reference
from timed_scenes import Timed, timed_case, timed_tips

ACCURACIES = (1e-2, 1e-3, 1e-6, 1e-9)
METHODS = (
    "auto",
    "dop853",
    "rk45",
    "rk23",
    "radau",
    "bdf",
    "lsoda",
    "taylor",
    "gauss2",
    "gauss4",
    "gauss6",
    "rk4",
    "euler",
)
PAIRS = [(method, accuracy) for accuracy in ACCURACIES for method in METHODS]
KINDS = {
    "moderate": 22, "chaotic": 15, "long": 9, "rest": 6, "unstable": 9, "late": 6,
    "scaled": 9, "far": 4, "two samples": 7, "drag": 6, "contacts": 7,
}  # fmt: skip
SHORTER = {
    "euler": 0.2,
    "gauss2": 0.2,
    "rk23": 0.4,
    "gauss4": 0.4,
    "bdf": 0.4,
    "gauss6": 0.5,
    "rk4": 0.5,
}  # what costs much
SMOOTH_ONLY = ("taylor", *fixed_methods())
TRUSTED = 0.01  # of the accuracy: two methods that agree so well are the truth
KNOWN = 1 / 3  # of the accuracy: a reference in more doubt decides nothing
LIMIT = 5.0  # s of processor time, of one accuracy asked
MOST = 1e5  # steps of a setting that is tried after a refusal


def case(seed: int, number: int) -> tuple[str, pp.Scene]:
    """The kind and the scene of a number, with the method and accuracy that are asked."""
    random, (method, accuracy) = Random(f"{seed} {number}"), PAIRS[number % len(PAIRS)]
    kinds = {kind: share for kind, share in KINDS.items() if kind != "contacts" or method not in SMOOTH_ONLY}
    if method == "taylor":
        kinds.pop("drag")
    kind = random.choices(list(kinds), list(kinds.values()))[0]
    scene = _scene(kind, random)
    scene = scene.model_copy(update={"duration": scene.duration * SHORTER.get(method, 1.0)})
    return kind, scene.model_copy(update={"solver": scene.solver.with_settings(method=method, accuracy=accuracy)})


def _scene(kind: str, random: Random) -> pp.Scene:
    size = 10 ** random.uniform(-4, 3) if kind == "scaled" else 1.0
    single = kind in {"long", "unstable", "far"} or (kind == "contacts" and random.random() < 0.6)
    count = 1 if single else 2 if kind in {"chaotic", "contacts"} else random.choice((1, 1, 1, 1, 2, 2, 3))
    rods = [_rod(random, size, kind) for _ in range(count)]
    pace = math.sqrt(size)  # of time with size
    wide = {"chaotic": 3.0, "long": 2.6, "unstable": 0.0, "rest": 0.0}.get(kind, 1.2)
    positions = [random.uniform(-wide, wide) for _ in range(2 * count)]
    velocities = [random.gauss(0, 1) * (wide > 0) / pace for _ in range(2 * count)]
    duration, samples = random.uniform(1, 8), random.choice((31, 61, 101))
    start, effects = 0.0, [fx.Gravity(), *_effects(random, size)]
    match kind:
        case "long":
            duration, samples, effects = 10 ** random.uniform(1.5, 2.5), 301, effects[:1]
        case "unstable":
            positions[0] = math.pi + random.choice((0.0, 0.0, 1e-12, 1e-9, 1e-6, -1e-4))
            duration, effects = random.uniform(1, 15), effects[:1]
        case "rest":
            effects = [fx.Gravity(), *random.choice(([], [_support(random)], [fx.Viscous(coefficient=0.1)]))]
            positions[0] = random.choice((0.0, 1e-9, 1e-5))
        case "late":
            start = 10 ** random.uniform(2, 9)
            effects += [_support(random)]
        case "far":
            positions[0] += 2 * math.pi * round(10 ** random.uniform(1, 8))
            effects = [effect for effect in effects if not isinstance(effect, fx.Spring)]  # wound up, it would spin
        case "two samples":
            samples, duration = random.choice((2, 2, 3, 5)), random.uniform(1, 6)
        case "chaotic":
            duration = random.uniform(3, 10)
        case "drag":
            effects = [effect for effect in effects if not isinstance(effect, fx.Drag)]
            effects += [
                fx.Drag(density=10 ** random.uniform(0, 3), wind=random.choice(((0.0, 0.0, 0.0), (2.0, -1.0, 0.0))))
            ]
        case "contacts":
            effects = effects[:1] + _contacts(random, positions)
            duration = random.uniform(0.5, 4)
    return pp.Scene(
        duration=duration * pace,
        model=pp.Chain(rods=rods),
        start=pp.Start(time=start, positions=positions, velocities=velocities),
        effects=effects,
        solver=pp.Solver(samples=samples),
    )


def _rod(random: Random, size: float, kind: str) -> pp.Rod:
    length = size * random.uniform(0.3, 2.0)
    thin = kind != "contacts" and random.random() < 0.25
    radius = 0.0 if thin else length * random.uniform(0.02, 0.1)
    payload = random.choice((0.0, 0.0, random.uniform(0.1, 5)))
    return pp.Rod(length=length, mass=random.uniform(0.3, 3.0), radius=radius, payload=payload)


def _effects(random: Random, size: float) -> list[fx.Effect]:
    """Smooth ones, each now and then; torques in proportion to weights."""
    some = [
        fx.Viscous(coefficient=random.uniform(0.001, 0.1) * size**1.5),
        fx.Spring(stiffness=random.uniform(0.1, 5) * size, rest=random.uniform(-1, 1)),
        fx.Rotation(latitude=45.0),
        fx.Drag(density=0.0, linear=random.uniform(0.001, 0.1) / math.sqrt(size), diameter=0.05 * size),
        fx.Motor(
            joint="theta_1", amplitude=random.uniform(0.1, 3) * size, frequency=random.uniform(1, 10) / math.sqrt(size)
        ),
    ]
    return [effect for effect in some if random.random() < 0.15]


def _support(random: Random) -> fx.Support:
    return fx.Support(amplitude=(0.05, 0.0, 0.02), frequency=random.uniform(1, 10))


def _contacts(random: Random, positions: list[float]) -> list[fx.Effect]:
    kinetic = random.uniform(0.01, 0.5)
    friction = fx.DryFriction(kinetic=kinetic, static=kinetic * random.choice((1.0, 1.5)))
    upper, lower = (sign * random.uniform(0.2, 1.0) for sign in (1, -1))
    positions[:] = [max(min(x, 0.9 * upper), 0.9 * lower) for x in positions]
    stop = fx.Stop(upper=upper, lower=lower, restitution=random.choice((0.0, 0.5, 1.0)))
    return random.choice(([friction], [stop], [friction, stop]))


# --- one scene ------------------------------------------------------------------------------------------------------


def checked(kind: str, scene: pp.Scene) -> dict[str, Any]:
    """What comes of the accuracy asked, and what is true."""
    solver, length = scene.solver, chain_length(build(scene.model))
    out: dict[str, Any] = {
        "kind": kind,
        "method": solver.method,
        "accuracy": solver.accuracy,
        "rods": len(scene.model.rods),
        "effects": [effect.kind for effect in scene.effects],
    }
    begin = time.process_time()
    try:
        run, out["outcome"] = pp.simulate(scene, progress=patience(LIMIT)), "met"
    except pp.RunError as error:
        run, out["outcome"], out["words"] = error.partial, "refused", str(error)
    out |= {
        "cpu": time.process_time() - begin,
        "used": run.stats.method,
        "setting": run.stats.tolerance or run.stats.step,
    }
    begin, known = time.process_time(), reference(scene, TRUSTED * (solver.accuracy or 0.0))
    out |= {"doubt": float(known.doubt[-1]), "claimed": run.stats.error, "steps": run.stats.steps}
    n = len(run.t)
    out["true"] = float(tip_distance(known.tips[:n], run.tips, length).max()) if n else None
    if out["outcome"] == "refused":
        out["within_reach"] = _within_reach(scene, known, length)
    out["reference_cpu"] = time.process_time() - begin
    return out


def patience(seconds: float) -> Callable[[float], None]:
    """A progress callback that ends a run after so many s of processor time, however busy the machine."""
    end = time.process_time() + seconds

    def check(t: float) -> None:
        if time.process_time() > end:
            raise Halted(f"it takes over {seconds:g} s of processor time")

    return check


def _within_reach(scene: pp.Scene, known: Reference, length: float) -> float | None:
    """A setting of the same method that meets the accuracy, if there is one; only where the reference can tell."""
    accuracy, method = scene.solver.accuracy or 0.0, scene.solver.method
    if not known.doubt[-1] <= KNOWN * accuracy:
        return None
    end = patience(LIMIT)
    for name, setting in _settings(scene, method):
        try:
            run = pp.simulate(scene.by(name, setting), progress=end)
        except pp.PendpinError:
            continue
        if tip_distance(known.tips, run.tips, length).max() <= accuracy:
            return setting
    return None


def _settings(scene: pp.Scene, method: str) -> Iterator[tuple[str, float]]:
    if method in fixed_methods():
        counts = (4**k for k in range(12))
        spacing = scene.times[1]
        yield from ((method, spacing / count) for count in counts if count * (len(scene.times) - 1) <= MOST)
        return
    for name in ("dop853", "taylor") if method == "auto" else (method,):
        yield from ((name, 10.0**-k) for k in range(2, 19, 2) if 10.0**-k >= method_of(name).least_tolerance)


def checked_in_time(case: Timed) -> dict[str, Any]:
    """The same of a scene in which something acts for a short time."""
    solver, length = case.scene.solver, chain_length(build(case.scene.model))
    out: dict[str, Any] = {
        "kind": case.kind,
        "method": solver.method,
        "accuracy": solver.accuracy,
        "within_reach": None,
    }
    begin = time.process_time()
    try:
        run, out["outcome"] = pp.simulate(case.scene, progress=patience(10 * LIMIT)), "met"
    except pp.RunError as error:
        run, out["outcome"], out["words"] = error.partial, "refused", str(error)
    out |= {"cpu": time.process_time() - begin, "used": run.stats.method, "claimed": run.stats.error}
    tips, doubt = timed_tips(case)
    out |= {"doubt": doubt / length, "notes": list(run.stats.notes)}
    out["true"] = float(tip_distance(tips[: len(run.t)], run.tips, length).max())
    if verdict(out) == "refused":  # what a run to the finest tolerance gives is within reach
        fine = pp.simulate(case.scene, method="dop853", tolerance=1e-13)
        near = float(tip_distance(tips, fine.tips, length).max())
        out["within_reach"] = 1e-13 if near <= (solver.accuracy or 0.0) else None
    out["reference_cpu"] = time.process_time() - begin - out["cpu"]
    return out


# --- all of them ----------------------------------------------------------------------------------------------------


def verdict(row: dict[str, Any]) -> str:
    """One word for an outcome."""
    if row["outcome"] == "met":
        if not row["doubt"] <= KNOWN * row["accuracy"]:
            return "met, unknown"
        return "met" if row["true"] <= row["accuracy"] else "FALSE"
    if "it takes over" in row["words"]:
        return "limit"
    return "refused within reach" if row["within_reach"] is not None else "refused"


def table(rows: list[dict[str, Any]]) -> Table:
    """Outcomes by method and by accuracy."""
    verdicts = ("met", "FALSE", "met, unknown", "refused", "refused within reach", "limit")
    out = Table("", *verdicts, "claimed / true, median", "cpu s, median")
    groups = [(key, tuple(sorted({row[key] for row in rows}))) for key in ("method", "kind")]
    groups += [("accuracy", ACCURACIES)] if all(row["accuracy"] in ACCURACIES for row in rows) else []
    for key, values in [*groups, ("all", ("all",))]:
        for value in values:
            some = [row for row in rows if key == "all" or row[key] == value]
            counts = Counter(map(verdict, some))
            good = [row for row in some if verdict(row) == "met" and row["true"]]
            ratio = np.median([row["claimed"] / row["true"] for row in good]) if good else np.nan
            cpu = np.median([row["cpu"] for row in some]) if some else np.nan
            out.add_row(f"{value}", *(str(counts[v] or "") for v in verdicts), f"{ratio:.1f}", f"{cpu:.2f}")
        out.add_section()
    return out


def main() -> None:
    """Run what is missing, print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--file", type=Path, default=Path("goal.jsonl"))
    parser.add_argument("--table", action="store_true")
    parser.add_argument("--replay", type=int)
    parser.add_argument("--timed", action="store_true", help="scenes of timed_scenes.py")
    options = parser.parse_args()
    if options.timed and options.replay is not None:
        print(checked_in_time(timed_case(options.seed, options.replay)))
        return
    if options.replay is not None:
        kind, scene = case(options.seed, options.replay)
        print(scene.model_dump_json(), checked(kind, scene))
        return
    rows = [json.loads(line) for line in options.file.read_text().splitlines()] if options.file.exists() else []
    for number in range(len(rows), 0 if options.table else options.count):
        found = (
            checked_in_time(timed_case(options.seed, number)) if options.timed else checked(*case(options.seed, number))
        )
        rows.append({"number": number, **found})
        with options.file.open("a") as file:
            file.write(json.dumps(rows[-1]) + "\n")
        row = rows[-1]
        print(
            number, row["kind"], row["method"], row["accuracy"], verdict(row), row["claimed"], row["true"], flush=True
        )
    Console(width=140).print(table(rows))


if __name__ == "__main__":
    main()
