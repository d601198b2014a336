"""Sensitivities of random scenes against differences of runs in 50 digits: `run.sensitivity` is off by less than 1e-9.

    python benchmarks/sensitivities.py 30 0

Each scene is one rod or two, with gravity and some smooth effects; each of these comes first in turn. The changes of the
state with a number of a rod, a number of an effect and an angle of the start are compared, each with its largest entry. The
runs in 50 digits take the accelerations of the articulated-body recursion on mpmath's numbers, and the extrapolated
midpoint rule of order 14 (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, section II.9).
"""

import argparse
import sys
from collections.abc import Iterator
from functools import partial

import numpy as np

import pendpin as pp
from pendpin import effects as fx
from pendpin.dynamics.binding import Binding
from pendpin.dynamics.compiling import BoundTree
from pendpin.dynamics.parameters import Numbers
from pendpin.equations.base import exact
from pendpin.equations.recursion import accelerations
from pendpin.ground.arguments import number_at
from pendpin.model.build import build, start_state

BOUND = 1e-9
XP = exact(50)
DURATION = 0.1  # s
CLOSE = 1e-7  # two runs of which one has twice as many steps: the better one is off by 2^-14 of what they differ by
SUBSTEPS = (2, 4, 6, 8, 10, 12, 14)
# A central difference of fourth order: its next term is about 1e-14, the rounding of the scene's own numbers over it 1e-12
STEP = 2.0**-12
EFFECTS = {  # each smooth effect, and one of its numbers
    "viscous": (fx.Viscous(coefficient=0.05), "coefficient"),
    "viscous on one": (fx.Viscous(coefficient=0.05, joints=("phi_1",)), "coefficient"),
    "spring": (fx.Spring(stiffness=2.0, rest=0.4), "rest"),
    "sinusoid motor": (fx.Motor(joint="phi_1", torque=0.1, amplitude=0.7, frequency=3.0, phase=0.5), "frequency"),
    "hold": (fx.Motor(joint="theta_1", target=0.5, proportional=3.0, derivative=0.4), "proportional"),
    "push": (fx.Push(link="rod_1", force=(0.3, -0.5, 0.7), point=0.8), "point"),
    "push and torque": (
        fx.Push(link="rod_1", force=(1, 2, 3), torque=(0.1, 0.4, -0.2), amplitude=(0, 1, 0), frequency=2.0),
        "torque[1]",
    ),
    "drag": (fx.Drag(diameter=0.1, wind=(3, -2, 1), linear=0.2, density=3.0), "density"),
    "still air": (fx.Drag(diameter=0.3), "coefficient"),
    "gust and buoyancy": (
        fx.Drag(gust=(4, 0, 1), frequency=2.0, buoyancy=True, density=20.0, diameter=0.05),
        "gust[0]",
    ),
    "support": (fx.Support(amplitude=(0.1, 0.2, -0.3), frequency=5.0, phase=0.3), "frequency"),
    "rotation": (fx.Rotation(rate=(0.7, -1.1, 2.0)), "rate[1]"),
    "earth": (fx.Rotation(latitude=48.85), "latitude"),
}


def random_scene(i: int, seed: int) -> tuple[pp.Scene, list[str]]:
    """Scene i and the key paths of three of its numbers."""
    random, names = np.random.default_rng([seed, i]), list(EFFECTS)
    chosen = [names[i % len(names)], *random.permutation(names)[: random.integers(0, 4)]]
    effects = {EFFECTS[name][0].kind: EFFECTS[name] for name in reversed(chosen)}  # one of each kind, the first one too
    ours = list(effects.values())
    count = int(random.integers(1, 3))
    rods = [
        pp.Rod(length=round(length, 2), mass=round(mass, 2), radius=0.05, payload=0.1)
        for length, mass in random.uniform(0.4, 1.2, (count, 2))
    ]
    angles, rates = random.uniform(-1.2, 1.2, 2 * count), random.uniform(-3, 3, 2 * count)
    start = pp.Start(positions=angles.round(3).tolist(), velocities=rates.round(3).tolist())
    everything = [fx.Gravity(), *(effect for effect, _ in ours)]
    scene = pp.Scene(model=pp.Chain(rods=rods), start=start, duration=DURATION, effects=everything)
    of_rod = random.choice(["length", "mass", "radius", "payload"])
    keys = [f"model.rods[0].{of_rod}", f"effects[{len(ours)}].{ours[-1][1]}", "start.positions[1]"]
    return scene.with_solver(tolerance=1e-12, samples=2), keys


def differences(scene: pp.Scene, keys: list[str]) -> np.ndarray:
    """The changes (2 nv, keys) of the last state with the numbers, from runs in 50 digits."""
    columns, steps = [], steps_for(scene)
    for key in keys:
        value = number_at(scene, key)
        step = STEP * max(abs(value), 0.1)
        ends = {k: last_state(scene.replace({key: value + k * step}), steps) for k in (-2, -1, 1, 2)}
        moved = {k: XP.asarray(value + k * step)[()] for k in ends}  # as rounded
        first, second = ((ends[k] - ends[-k]) / (moved[k] - moved[-k]) for k in (1, 2))
        columns.append(((4 * first - second) / 3).astype(float))
    return np.array(columns).T


def steps_for(scene: pp.Scene) -> int:
    """How many steps the extrapolation takes in a run of a scene, some of which have short times."""
    steps, state = 2, last_state(scene, 1)
    while np.abs(state - (state := last_state(scene, steps))).max() > CLOSE:
        steps *= 2
    return steps


def last_state(scene: pp.Scene, steps: int) -> np.ndarray:
    """The last state (2 nv,) of a scene in 50 digits."""
    model = build(scene.model)
    rates = partial(rates_of_change, BoundTree(Binding(model, scene.effects, numbers=Numbers(XP))))
    y = XP.asarray(np.concatenate(start_state(model, scene.start)))
    h = XP.asarray(DURATION)[()] / steps
    for i in range(steps):
        y = extrapolated(rates, i * h, y, h)
    return y


def rates_of_change(bound: BoundTree, t, y: np.ndarray) -> np.ndarray:
    """The rates (2 nv,) of a state at a time, by the recursion on mpmath's numbers."""
    (q, v), loads = np.split(y, 2), bound.loads
    tau = loads.torque(t, q, v) if loads.torque else None
    field = XP.asarray(loads.field(t))
    return np.concatenate([v, accelerations(bound.tree, q, v, field, tau, bound.external(t, q, v), XP)])


def extrapolated(rates, t, y: np.ndarray, h) -> np.ndarray:
    """The state after h, by midpoint rules with more and more steps, extrapolated to infinitely many (Aitken, Neville)."""
    first, table = rates(t, y), list[np.ndarray]()
    for j, n in enumerate(SUBSTEPS):
        step, before, now = h / n, y, y + h / n * first
        for k in range(1, n):
            before, now = now, before + 2 * step * rates(t + k * step, now)
        row = [(before + now + step * rates(t + h, now)) / 2]
        for k in range(1, j + 1):
            row.append(row[-1] + (row[-1] - table[k - 1]) / ((XP.asarray(n)[()] / SUBSTEPS[j - k]) ** 2 - 1))
        table = row
    return table[-1]


def off(scene: pp.Scene, keys: list[str]) -> np.ndarray:
    """By how much the sensitivities are off, (keys,), over the largest entry of each."""
    found, expected = pp.simulate(scene).sensitivity(keys)[-1], differences(scene, keys)
    return np.abs(found - expected).max(0) / np.maximum(np.abs(expected).max(0), 1e-3)


def main() -> Iterator[float]:
    """Print a line for each scene; yields by how much each is off."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int)
    parser.add_argument("seed", type=int)
    options = parser.parse_args()
    for i in range(options.count):
        scene, keys = random_scene(i, options.seed)
        errors = off(scene, keys)
        kinds = ", ".join(effect.kind for effect in scene.effects[1:])
        print(f"{i:3} {len(scene.model.all_rods)} rods, {kinds}:", *map("{:.1e}".format, errors), flush=True)
        yield float(errors.max())


if __name__ == "__main__":
    largest = max(main())
    print(f"off by at most {largest:.1e} of the largest entry")
    sys.exit(largest > BOUND)
