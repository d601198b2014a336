"""A double pendulum and a small sweep of it, for the tests of sweeps."""

from pathlib import Path

import numpy as np

import pendpin as pp
from pendpin import effects as fx

ROD = pp.Rod(length=1.0, mass=1.0, radius=0.02)
TWO = pp.Chain(rods=[ROD, pp.Rod(length=0.7, mass=0.6, radius=0.02)])
KEYS = ("start.positions.theta_1", "start.positions.theta_2")


def scene(*effects: fx.Effect, model: pp.Chain = TWO, duration: float = 2.0, **solver) -> pp.Scene:
    """Two rods under gravity and these effects, released at 1 rad and -0.5 rad."""
    solver = {"tolerance": 1e-10, "samples": 21} | solver
    start = pp.Start(positions={"theta_1": 1.0, "theta_2": -0.5} if model.count == 2 else {"theta": 1.0})
    acting = (fx.Gravity(), *effects)
    return pp.Scene(duration=duration, model=model, start=start, effects=acting, solver=pp.Solver(**solver))


def numbers(found) -> dict[str, np.ndarray]:
    """The arrays of a result, by name."""
    return {str(name): found[name].values for name in found.data_vars}


def assert_same(one, other) -> None:
    """Bit for bit."""
    for name, values in numbers(one).items():
        np.testing.assert_array_equal(values, other[name].values, err_msg=name)


def small(out: Path | None = None, **options):
    """A sweep of 24 cases."""
    varied = {KEYS[0]: np.linspace(-3, 3, 6), KEYS[1]: np.linspace(-2, 2, 4)}
    return pp.sweep(scene(duration=1.0), varied, ["flip_time", "swing"], out=out, **options)


def stop_after(count: int):
    """Progress that presses Ctrl-C when so many cases are done."""

    def stop(done: int, _: int) -> None:
        if done >= count:
            raise KeyboardInterrupt

    return stop
