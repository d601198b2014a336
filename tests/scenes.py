"""The builder of scenes that the tests share."""

from collections.abc import Sequence

import numpy as np

import pendpin as pp
from pendpin import effects as fx


def scene_of(
    rods: pp.Chain | Sequence[pp.Rod],
    *effects: fx.Effect,
    q=(),
    v=(),
    duration: float = 2.0,
    time: float = 0.0,
    **solver,
) -> pp.Scene:
    """A chain, or these rods, under these effects; angles in rad and rates in rad/s that are left out are 0."""
    model = rods if isinstance(rods, pp.Chain) else pp.Chain(rods=rods)
    pad = np.zeros(2 * model.count)
    positions, velocities = (np.append(given, pad[len(given) :]) for given in (q, v))
    start = pp.Start(time=time, positions=positions, velocities=velocities)
    return pp.Scene(duration=duration, model=model, start=start, effects=effects, solver=pp.Solver(**solver))


def run_of(*effects: fx.Effect, model: pp.Chain, tolerance: float = 1e-11, **given) -> pp.Trajectory:
    """The run of such a scene."""
    return pp.simulate(scene_of(model, *effects, tolerance=tolerance, **given))
