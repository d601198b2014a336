"""Measured swings that are made up, and the scenes that are fitted to them."""

import numpy as np

import pendpin as pp
from pendpin.effects import Gravity
from pendpin.scene import Data

ROD = {"length": 0.2, "mass": 0.1, "radius": 0.005}
NOISE = 5e-5  # rad


def scene_of(rods: int, *effects, data: Data | None = None, duration: float = 2.0, rate: int = 100) -> pp.Scene:
    """A chain of equal rods under gravity and these effects."""
    solver = pp.Solver(samples=round(rate * duration) + 1, tolerance=1e-11)
    chain = pp.Chain(rods=[pp.Rod(**ROD)] * rods)
    return pp.Scene(duration=duration, model=chain, effects=[Gravity(), *effects], solver=solver, data=data)


def swings_of(scene: pp.Scene, *starts: list[float], seed: int = 0) -> dict[str, np.ndarray]:
    """Noisy absolute angles of plane swings from these theta angles at rest, as a table of columns."""
    draw, parts = np.random.default_rng(seed), []
    for segment, start in enumerate(starts):
        positions = [x for angle in start for x in (angle, 0.0)]
        run = pp.simulate(pp.Scene(**scene.given() | {"start": pp.Start(positions=positions)}))
        angles = np.cumsum(run.q[:, ::2], 1)
        angles += draw.normal(0, NOISE, angles.shape)
        columns = {f"a{i + 1}": angles[:, i] for i in range(len(start))}
        parts.append({"t": run.t, "segment": np.full(len(run.t), segment)} | columns)
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


ANGLE = Data(segment="segment", columns={"a1": ("theta",)})
ANGLES = Data(segment="segment", columns={"a1": ("theta_1",), "a2": ("theta_1", "theta_2")})
