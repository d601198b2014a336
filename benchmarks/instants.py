"""The instants of runs against dense searches: crossings of random scenes, flip times by every method.

    python benchmarks/instants.py [queries] [cells] [seed]      # 500, 200, 0

A query asks a random run for a random quantity at a level: anywhere, or within 1e-10 to 0.1 of the quantity's range of a
turning point, often the first or the last of the run. The judge takes the run at thousands of times, looks closer where
the quantity turns near the level, and asks whether the sign of the quantity at each of them is the one that the crossings
found say. How far two ways to the same instant of the run differ is measured: a quantity nearer to the level than that may
be on either side. A cell is a double pendulum let go at rest; its flip time is asked of every method at 2 to 601 samples.
All must be within three times the spread that the sweep states of the first passage in a dense run at 1e-13.
"""

import math
import sys
from collections import Counter
from random import Random
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

import pendpin as pp
from pendpin import effects as fx

Array = np.ndarray
DENSE = 1500  # times at which the judge takes a run
CLOSER = 41  # times about each turn near the level, in each of ROUNDS
ROUNDS = 3
ROUNDING = 2.0**-46  # of a quantity's size
NOISE = 10.0  # times the difference that four of five instants do not exceed
CUT = 10.0  # times that for fixed steps, which every instant asked cuts
EVENT = 1e-6  # s, about an event: it is as uncertain as the tolerance
KINDS = ("rod", "thin", "two rods", "two thin rods", "drag", "motor", "support", "upright", "late", "friction", "stops")
TOUCHING = ("friction", "stops")
SETTINGS: dict[str, dict[str, Any]] = {
    **{method: {"method": method, "tolerance": 1e-9} for method in ("dop853", "rk45", "radau", "bdf", "lsoda")},
    "rk23": {"method": "rk23", "tolerance": 1e-6},
    "taylor": {"method": "taylor", "tolerance": 1e-13},
    "rk4": {"method": "rk4", "step": 0.004},
    "gauss4": {"method": "gauss4", "step": 0.01},
    "euler": {"method": "euler", "step": 0.002},
}
SMOOTH_ONLY = ("taylor", "rk4", "gauss4", "euler")
SAMPLES = (2, 3, 5, 7, 11, 13, 31, 61, 601)


class Query(NamedTuple):
    """A question to a run."""

    kind: str
    run: pp.Trajectory
    name: str
    level: float
    direction: int


# --- crossings ------------------------------------------------------------------------------------------------------


def query_of(seed: int, number: int) -> Query:
    """The query of a number."""
    random = Random(f"{seed} {number}")
    while True:
        kind = random.choice(KINDS)
        allowed = [
            m for m in SETTINGS if not ((kind in TOUCHING and m in SMOOTH_ONLY) or (kind == "drag" and m == "taylor"))
        ]
        how = SETTINGS[random.choice(allowed)]
        try:
            run = pp.simulate(scene_of(kind, random), samples=random.choice(SAMPLES), **how)
        except pp.PendpinError:
            continue
        name = random.choice((*run.joints, *run.joints, *(f"{x}_rate" for x in run.joints), *run.names[1:]))
        t = np.linspace(run.t[0], run.t[-1], DENSE)
        level = level_of(run.at(t)[name], random)
        if level is not None:
            return Query(kind, run, name, level, random.choice((0, 0, 1, -1)))


def scene_of(kind: str, random: Random) -> pp.Scene:
    """A scene of a kind, of up to 8 s."""
    thin = kind in {"thin", "two thin rods"}
    count = 2 if kind.startswith("two") else 1 + (random.random() < 0.3)
    rods = [
        pp.Rod(length=random.uniform(0.3, 1.5), mass=random.uniform(0.3, 3), radius=0.0 if thin else 0.03)
        for _ in range(count)
    ]
    planar = random.random() < 0.3
    q, v = ([random.gauss(0, 1) * (not planar or i % 2 == 0) for i in range(2 * count)] for _ in range(2))
    more: dict[str, fx.Effect] = {
        "drag": fx.Drag(diameter=0.1),
        "motor": fx.Motor(joint=f"phi{'_1' * (count > 1)}", amplitude=2.0, frequency=7.0),
        "support": fx.Support(amplitude=(0.1, 0.0, 0.05), frequency=5.0),
        "friction": fx.DryFriction(kinetic=0.3, static=0.5),
        "stops": fx.Stop(lower=-0.7, upper=0.5, restitution=random.choice((0.0, 0.6, 1.0))),
    }
    if kind == "upright":
        q[0], v[0] = math.pi + random.choice((0.0, 1e-9, -1e-3)), 0.0
    if kind == "stops":
        q = [max(min(x, 0.45), -0.65) for x in q]
    start = pp.Start(time=1e4 if kind == "late" else 0.0, positions=tuple(q), velocities=tuple(v))
    effects = (fx.Gravity(), *([more[kind]] if kind in more else []))
    return pp.Scene(duration=random.uniform(0.2, 8.0), model=pp.Chain(rods=rods), start=start, effects=effects)


def level_of(x: Array, random: Random) -> float | None:
    """A level for a quantity with values (n,): anywhere, at its first or last value, or near a turn; None if it rests."""
    span = float(np.ptp(x))
    if span < 1e-9 * max(1.0, float(np.abs(x).max())):
        return None
    turns = np.flatnonzero((x[1:-1] - x[:-2]) * (x[2:] - x[1:-1]) < 0) + 1
    where = random.choice(("anywhere", "end", "turn", "turn", "first turn", "last turn"))
    if where == "anywhere" or (where != "end" and not len(turns)):
        return float(x.min() + random.uniform(-0.05, 1.05) * span)
    if where == "end":
        return float(x[random.choice((0, -1))])
    turn = int(
        turns[0] if where == "first turn" else turns[-1] if where == "last turn" else random.choice(turns.tolist())
    )
    peak = _extreme(x[turn - 1 : turn + 2])
    inside = 1.0 if x[turn - 1] > x[turn] else -1.0
    return float(peak + inside * span * random.choice((-1, 1, 1, 1)) * 10 ** random.uniform(-10, -1))


def _extreme(x: Array) -> float:
    """The turning value of the parabola through three values (3,) at even times."""
    bend, slope = x[0] - 2 * x[1] + x[2], (x[2] - x[0]) / 2
    return float(x[1] - slope**2 / (2 * bend)) if bend else float(x[1])


def faults(query: Query) -> list[str]:
    """What is wrong with the crossings of a query."""
    run, name, level = query.run, query.name, query.level
    found = run.crossings(name, level).t
    wrong = _of_direction(query, found)
    middle = (found[1:] + found[:-1]) / 2
    t, f = _dense(run, name, level, middle[np.diff(found) > 4 * np.spacing(np.abs(found[1:]))])
    sides = (-1.0) ** np.searchsorted(found, t, "right")
    near = np.zeros(len(t), bool)
    for event in run.events:
        near |= np.abs(t - event.t) < EVENT
    certain = (np.abs(f) > noise(run, name, level, t, f)) & ~near & ~np.isin(t, found)
    sides *= np.sign(f) * certain
    if (sides > 0).any() and (sides < 0).any():
        few = sides == (-1.0 if (sides < 0).sum() < (sides > 0).sum() else 1.0)
        few &= _asked_alone(run, name, level, t, f, few)
        where = [f"{x:.9g} s: {y:.2g}" for x, y in zip(t[few], f[few], strict=True)][:3]
        wrong += [f"wrong side at {few.sum()} of {len(t)} times, {where}"] * bool(where)
    return wrong


def _asked_alone(run: pp.Trajectory, name: str, level: float, t: Array, f: Array, few: Array) -> Array:
    """Whether offsets are the same where a time is all that is asked of the run: of up to 20 of some."""
    same = np.zeros(len(t), bool)
    for i in np.flatnonzero(few)[:20]:
        same[i] = NOISE * abs(run.at(t[i : i + 1])[name][0] - level - f[i]) < abs(f[i])
    return same


def _of_direction(query: Query, found: Array) -> list[str]:
    """What is wrong with the crossings one way: they have to be among all, but for times between which only noise is."""
    run, name, level = query.run, query.name, query.level
    if not query.direction:
        return []
    one, other = (run.crossings(name, level, d).t for d in (query.direction, -query.direction))
    both = np.sort(np.concatenate([one, other]))
    if len(both) != len(found):
        return [f"{len(one)} one way and {len(other)} the other are not {len(found)}"]
    t, f = _dense(run, name, level, np.unique((both + found) / 2))
    apart = np.abs(both - found) > 1e-6 * (run.t[-1] - run.t[0])
    off = np.abs(f[np.searchsorted(t, (both + found)[apart] / 2)])
    far = off > noise(run, name, level, t, f)
    return [f"one way, {far.sum()} are not among those both ways"] if far.any() else []


def _dense(run: pp.Trajectory, name: str, level: float, more: Array) -> tuple[Array, Array]:
    """Times (k,) and offsets from the level, denser where the quantity turns near it."""
    t = np.unique(np.concatenate([np.linspace(run.t[0], run.t[-1], DENSE), run.t, more]))
    f = run.at(t)[name] - level
    for _ in range(ROUNDS):
        a, b, c = np.abs(f[:-2]), np.abs(f[1:-1]), np.abs(f[2:])
        same = (np.sign(f[:-2]) == np.sign(f[1:-1])) & (np.sign(f[2:]) == np.sign(f[1:-1]))
        turns = np.flatnonzero(same & (b <= a) & (b <= c) & (b <= 2 * (a + c - 2 * b)))[:200]
        ends = np.concatenate([[0] * (len(f) > 1), turns, turns + 1, [len(t) - 2] * (len(f) > 1)]).astype(int)
        shares = np.arange(1, CLOSER) / CLOSER
        new = (t[ends, None] + (t[ends + 1] - t[ends])[:, None] * shares).reshape(-1)
        new = np.setdiff1d(new, t)
        if not len(new):
            break
        t, f = np.concatenate([t, new]), np.concatenate([f, run.at(new)[name] - level])
        order = np.argsort(t)
        t, f = t[order], f[order]
    return t, f


def noise(run: pp.Trajectory, name: str, level: float, t: Array, f: Array) -> float:
    """How much two ways to the same instant differ: from the sample before, with many times or few; and into a sample."""
    some = np.unique(np.linspace(1, len(t) - 2, 30).astype(int))
    apart = np.abs(run.at(t[some])[name] - level - f[some])
    before = np.nextafter(run.t[1:], -np.inf)[:100]
    into = np.abs(run.at(np.unique(before))[name] - run[name][1:][:100][: len(np.unique(before))])
    size = max(abs(level), float(np.abs(f).max()))
    cut = CUT if run.stats.step else 1.0
    return cut * NOISE * max(float(np.quantile(apart, 0.8)), float(np.quantile(into, 0.8))) + ROUNDING * size


# --- flip times -----------------------------------------------------------------------------------------------------


def flips(cells: int, seed: int, samples: tuple[int, ...] = (2, 3, 11, 601)) -> tuple[Counter[str], list[str]]:
    """Answers that are right by method, and what is wrong."""
    random = Random(seed)
    across = max(1, round(math.sqrt(cells)))
    one, two = ([random.uniform(-3, 3) for _ in range(n)] for n in (across, -(-cells // across)))
    rods = (pp.Rod(length=1.0, mass=1.0, radius=0.02), pp.Rod(length=0.8, mass=0.7, radius=0.02))
    scene = pp.Scene(duration=2.5, model=pp.Chain(rods=rods), effects=(fx.Gravity(),))
    keys = {f"start.positions.theta_{i}": values for i, values in ((1, one), (2, two))}
    exact = np.array([[first_passage(scene, x, y) for y in two] for x in one])
    right: Counter[str] = Counter()
    wrong: list[str] = []
    for method, how in SETTINGS.items():
        for count in samples:
            solver = scene.solver.with_settings(samples=count, **how)
            out = pp.sweep(scene.model_copy(update={"solver": solver}), keys, ["flip_time", "flip_time.spread"])
            answer, spread = out["flip_time"].values, out["flip_time.spread"].values
            off = np.where(np.isnan(answer) & np.isnan(exact), 0.0, np.nan_to_num(np.abs(answer - exact), nan=np.inf))
            bad = (off > 3 * spread + 1e-7) & np.isfinite(spread)
            right[method] += int((~bad).sum())
            wrong += [
                f"{method}, {count} samples, from ({one[i]:.9g}, {two[j]:.9g}): {answer[i, j]:.9g}, spread "
                f"{spread[i, j]:.2g}; true {exact[i, j]:.9g}"
                for i, j in np.argwhere(bad)
            ]
    return right, wrong


def first_passage(scene: pp.Scene, one: float, two: float) -> float:
    """The first time at which a sum of angles passes an odd multiple of pi, in a dense run; NaN if none does."""
    start = pp.Start(positions={"theta_1": one, "theta_2": two})
    run = pp.simulate(scene.replace(start=start), method="dop853", tolerance=1e-13, samples=1001)
    first = []
    for joints in ([0], [0, 2]):
        angle = CubicHermiteSpline(run.t, run.q[:, joints].sum(1), run.v[:, joints].sum(1))
        top = np.cos(angle(run.t) / 2)
        i = np.flatnonzero(top[1:] * top[:-1] < 0)[:1]
        first += [brentq(lambda t, angle=angle: np.cos(angle(t) / 2), *run.t[k : k + 2], xtol=1e-14) for k in i]
    return min(first, default=math.nan)


def main(queries: int = 500, cells: int = 200, seed: int = 0) -> None:
    """Print the tables; exit status 1 where anything is wrong."""
    asked: Counter[str] = Counter()
    crossings: Counter[str] = Counter()
    wrong: list[str] = []
    for number in range(queries):
        query = query_of(seed, number)
        asked[query.kind] += 1
        crossings[query.kind] += len(query.run.crossings(query.name, query.level).t)
        how = f"{number}: {query.kind}, {query.run.stats.method}, {len(query.run.t)} samples, {query.name}"
        wrong += [f"{how} at {query.level!r}: {fault}" for fault in faults(query)]
    table = Table("kind", "queries", "crossings")
    for kind in asked:
        table.add_row(kind, str(asked[kind]), str(crossings[kind]))
    right, bad = flips(cells, seed) if cells else (Counter[str](), list[str]())
    table.add_section()
    for method in right:
        table.add_row(f"flips, {method}", str(right[method]), "")
    Console().print(table)
    print(*wrong, *bad, f"{len(wrong) + len(bad)} wrong", sep="\n")
    sys.exit(int(bool(wrong or bad)))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:4]))
