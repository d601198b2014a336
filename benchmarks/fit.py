"""Fits of synthetic swings whose truth is known: how often estimates and intervals are right, and what a fit costs.

    nice -n 10 python benchmarks/fit.py 100 0 fit.jsonl      # so many random rods and doubles of a seed, 3 segments each

Each is simulated by `simulate` with random numbers, measured with the noise of an encoder and fitted from guesses that
are off by up to 30 %. With the scale of mass known (one first moment is not free) all free numbers are determined. Results
go to a file, line by line; the same command goes on where it was stopped.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import pendpin as pp
from pendpin.effects import Drag, DryFriction, Gravity, Viscous
from pendpin.errors import PendpinError
from pendpin.scene import Data

NOISE = 5e-5  # rad
RATE = 200  # samples a second


def random_case(draw: np.random.Generator) -> tuple[pp.Scene, pp.Scene, list[str], dict[str, np.ndarray]]:
    """The truth, the guess, what is free, and three measured swings."""
    rods = int(draw.integers(1, 3))
    truth = _scene(draw, rods)
    free = [f"model.rods[{i}].inertia" for i in range(rods)] + [f"model.rods[{i}].com" for i in range(rods - 1)]
    free += ["effects[1].coefficient", "effects[2].kinetic", "effects[3].coefficient"]
    parts = [_measured(draw, truth, rods, k) for k in range(3)]
    table = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return truth, _guess(draw, truth), free, table


def _scene(draw: np.random.Generator, rods: int) -> pp.Scene:
    size = [
        pp.Rod(length=draw.uniform(0.15, 0.5), mass=draw.uniform(0.05, 0.5), radius=draw.uniform(0.004, 0.01))
        for _ in range(rods)
    ]
    size = [pp.Rod(**rod.given() | {"com": rod.properties.h, "inertia": rod.properties[2:]}) for rod in size]
    torque = sum(rod.mass * 9.81 * rod.length for rod in size)
    joints = ["theta"] if rods == 1 else [f"theta_{i + 1}" for i in range(rods)]
    return pp.Scene(
        duration=4.0,
        model=pp.Chain(rods=size),
        effects=[
            Gravity(),
            Viscous(coefficient=torque * 10 ** draw.uniform(-4, -3)),
            DryFriction(kinetic=torque * 10 ** draw.uniform(-4, -3)),
            Drag(diameter=0.02, coefficient=draw.uniform(0.5, 2)),
        ],
        solver=pp.Solver(samples=4 * RATE + 1),
        data=Data(segment="segment", columns={f"a{i}": tuple(joints[: i + 1]) for i in range(rods)}),
    )


def _measured(draw: np.random.Generator, truth: pp.Scene, rods: int, segment: int) -> dict[str, np.ndarray]:
    q, v = (draw.uniform(-size, size, 2 * rods) * np.tile([1, 0], rods) for size in (1.0, 3.0))
    start = pp.Start(positions=q.tolist(), velocities=v.tolist())
    run = pp.simulate(pp.Scene(**truth.given() | {"start": start}))
    angles = np.cumsum(run.q[:, ::2], 1) + draw.normal(0, NOISE, (len(run.t), rods))
    return {"t": run.t, "segment": np.full(len(run.t), segment)} | {f"a{i}": angles[:, i] for i in range(rods)}


def _guess(draw: np.random.Generator, truth: pp.Scene) -> pp.Scene:
    """The truth with its numbers off by up to 30 %, but for the last rod's centre of mass, which gives the scale."""
    assert isinstance(truth.model, pp.Chain)
    off = lambda: draw.uniform(0.7, 1.3)  # noqa: E731
    rods = []
    for i, rod in enumerate(truth.model.rods):
        factor, moved = off(), off() if i + 1 < truth.model.count else 1.0
        rods.append(pp.Rod(**rod.given() | {"com": rod.com * moved, "inertia": [x * factor for x in rod.inertia]}))
    g, viscous, dry, drag = truth.effects
    effects = [g, Viscous(coefficient=viscous.coefficient * off()), DryFriction(kinetic=dry.kinetic * off())]
    effects.append(Drag(**drag.given() | {"coefficient": drag.coefficient * off()}))
    return pp.Scene(**truth.given() | {"model": pp.Chain(rods=rods), "effects": effects})


def true_value(scene: pp.Scene, key: str) -> float:
    """The number at a key path of the truth."""
    from pendpin.fitting.parameters import free_parameters

    return float(free_parameters(scene, [key]).guess[0])


def scored(seed: int, case: int) -> dict[str, Any]:
    """One case: each free number's deviation from the truth in standard errors, and what the fit cost."""
    truth, guess, free, table = random_case(np.random.default_rng([seed, case]))
    begin = time.process_time()
    try:
        found = pp.fit(guess, table, free)
    except PendpinError as error:
        return {"case": case, "failed": str(error)}
    seconds, right = time.process_time() - begin, dict.fromkeys(found.errors, 0.0)
    right |= {key: true_value(truth, key) for key in right if not key.startswith("data.")}  # zeros are 0
    z = {key: (found.values[key] - right[key]) / error for key, error in found.errors.items()}
    return {"case": case, "rods": len(truth.model.rods), "seconds": seconds, "explained": found.explained, "z": z}


def summary(rows: list[dict[str, Any]]) -> str:
    """How estimates and intervals did in all cases."""
    good = [row for row in rows if "z" in row]
    size = np.abs([x for row in good for x in row["z"].values()])
    seconds, explained = [row["seconds"] for row in good], sum(row["explained"] for row in good)
    return (
        f"{len(good)} fits of {len(rows)}, {explained} explained, {len(size)} numbers\n"
        f"within 3 standard errors {np.mean(size < 3):.3f}, 95 % intervals cover {np.mean(size < 1.96):.3f}\n"
        f"seconds (CPU): median {np.median(seconds):.1f}, most {max(seconds):.1f}"
    )


def main() -> None:
    """Print how estimates and intervals did; cases that the file of results holds are not run again."""
    count, seed = int(sys.argv[1]), int(sys.argv[2])
    file = Path(sys.argv[3])
    rows = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    for case in sorted(set(range(count)) - {row["case"] for row in rows}):
        rows.append(scored(seed, case))
        with file.open("a") as out:
            out.write(json.dumps(rows[-1]) + "\n")
        print(rows[-1], flush=True)
    print(summary(rows))


if __name__ == "__main__":
    main()
