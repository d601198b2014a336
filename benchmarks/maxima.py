"""The largest values of forces against dense runs: run.maximum and run.minimum of random scenes.

    python benchmarks/maxima.py [queries] [seed]      # 300, 0

A query asks a run of few or many samples for the largest or least value of a random quantity, mostly of a force. The judge
is a run of the same scene at a tolerance 100 times tighter with 20,001 samples, and 1,001 more beside the largest of them.
The answer may be off by the difference of both runs, and by what a quantity changes between
two dense samples beside an event. run.at at the time of the answer has its value.
"""

import runpy
import sys
from collections import Counter
from pathlib import Path
from random import Random
from typing import NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

import pendpin as pp

DENSE = 20_001
TIGHTER = 0.01  # times the run's tolerance, or 0.5 times its step
CLOSE = 1_001  # samples between the neighbours of its largest one
OFF = 1e-6  # of the quantity's size: what may lie between these
FURTHER = 5.0  # times the largest difference of both runs at 61 times
FORCES = 0.7  # of the queries
SIZES = ("dop853", "rk45", "radau", "lsoda", "gauss4", "taylor")
instants = runpy.run_path(str(Path(__file__).parent / "instants.py"))


class Query(NamedTuple):
    """A question to a run, and the run that judges."""

    kind: str
    run: pp.Trajectory
    dense: pp.Trajectory
    name: str
    largest: bool


def query_of(seed: int, number: int) -> Query:
    """The query of a number."""
    random = Random(f"{seed} {number} maxima")
    while True:
        kind = random.choice(instants["KINDS"])
        how = dict(instants["SETTINGS"][random.choice(SIZES)])
        if kind in instants["TOUCHING"] or kind == "drag":
            how = {"method": "dop853", "tolerance": 1e-9}
        scene = instants["scene_of"](kind, random)
        scene = scene.model_copy(update={"duration": min(scene.duration, 3.0)})
        finer = {key: (0.5 if key == "step" else TIGHTER) * x for key, x in how.items() if key != "method"}
        if "tolerance" in finer:
            finer["tolerance"] = max(finer["tolerance"], 1e-13)
        try:
            run = pp.simulate(scene, samples=random.choice((2, 5, 13, 61, 181, 601)), **how)
            dense = pp.simulate(scene, samples=DENSE, **(how | finer))
        except pp.PendpinError:
            continue
        forces = [name for name in run.names if name[:2] in ("R1", "R2", "R3", "M3", "Mc") or "acc" in name]
        names = forces if random.random() < FORCES else run.names[1:]
        return Query(kind, run, dense, random.choice(names), random.random() < 0.5)


def fault(query: Query) -> str:
    """What is wrong with the answer; "" where nothing is."""
    sign = 1.0 if query.largest else -1.0
    answer = (query.run.maximum if query.largest else query.run.minimum)(query.name)
    t, x = query.dense.t, sign * query.dense[query.name]
    k, size = int(np.argmax(x)), float(np.abs(x).max())
    close = np.linspace(t[max(k - 1, 0)], t[min(k + 1, len(t) - 1)], CLOSE)
    top = max(float(x[k]), float((sign * query.dense.at(close)[query.name]).max()))
    beside = [e.t for e in query.dense.events if abs(e.t - t[k]) < 3 * (t[1] - t[0])]
    near, some = x[max(k - 3, 0) : k + 4], slice(1, None, DENSE // 60)
    gap = float(np.abs(query.run.at(t[some])[query.name] - query.dense[query.name][some]).max())
    slack = OFF * size + FURTHER * gap + 1e-13 + (float(np.abs(np.diff(near)).max()) if beside else 0.0)
    again = float(query.run.at(answer.t)[query.name][0])
    if abs(again - answer.value) > 1e-9 * size:
        return f"run.at says {again:.9g}, not {answer.value:.9g}"
    if beside or abs(sign * answer.value - top) <= slack:
        return "" if sign * answer.value >= float(x[k]) - slack else f"{answer.value:.9g} is below {sign * x[k]:.9g}"
    return f"{answer.value:.9g} at {answer.t:.9g} s; the dense run says {sign * top:.9g} at {t[k]:.9g} s"


def main(queries: int = 300, seed: int = 0) -> None:
    """Print the table; exit status 1 where anything is wrong."""
    asked, wrong = Counter[str](), list[str]()
    for number in range(queries):
        query = query_of(seed, number)
        asked[query.kind] += 1
        if said := fault(query):
            what = f"{'largest' if query.largest else 'least'} {query.name}"
            wrong.append(
                f"{number}: {query.kind}, {query.run.stats.method}, {len(query.run.t)} samples, {what}: {said}"
            )
    table = Table("kind", "queries")
    for kind, count in asked.items():
        table.add_row(kind, str(count))
    Console().print(table)
    print(*wrong, f"{len(wrong)} wrong", sep="\n")
    sys.exit(int(bool(wrong)))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
