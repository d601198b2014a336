"""Fits, costs and the significance of effects from special states: rest, right angles, upright, strength 0, no gravity."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import pendpin as pp
from pendpin import effects as fx
from pendpin.fitting.report import Fit
from pendpin.scene import Data
from pendpin.sweeps.significance import significance
from test_crosschecks import RODS

UP = np.pi  # rad
NONE = (fx.Gravity(acceleration=0.0), fx.Viscous(coefficient=0.0), fx.Drag(density=0.0))
SPECIAL: dict[str, tuple[str, dict[str, float], dict[str, float], tuple[Any, ...]]] = {  # rod, angles, rates, effects
    "at rest": ("thick", {}, {}, (fx.Gravity(),)),
    "upright": ("thin", {"theta": -UP}, {}, (fx.Gravity(),)),
    "at a pole": ("thin", {"phi": UP / 2}, {}, (fx.Gravity(),)),
    "hardly moving": ("thick", {"theta": 1e-300, "phi": -0.0}, {"phi": 1e-300}, (fx.Gravity(),)),
    "horizontal": ("thick", {"theta": UP / 2}, {}, (fx.Gravity(),)),
    "horizontal about phi": ("thick", {"phi": -UP / 2}, {}, (fx.Gravity(),)),
    "one joint": ("thick", {}, {"theta": -1.0}, (fx.Gravity(),)),
    "strength 0": ("thick", {"theta": 0.3}, {}, NONE),
    "nothing": ("thick", {"theta": 0.3}, {"theta": 1.0}, ()),
}
PLANE = [name for name in SPECIAL if name.startswith(("horizontal", "one"))]


def scene_of(name: str) -> pp.Scene:
    """The special scene of a name, from t = -3 s on."""
    rod, positions, velocities, effects = SPECIAL[name]
    start = pp.Start(time=-3.0, positions=positions, velocities=velocities)
    return pp.Scene(duration=1.0, model=pp.Chain(rods=[RODS[rod]]), effects=effects, start=start)


def fit_itself(scene: pp.Scene, *free: str) -> Fit:
    """A fit of the scene to both angles of its own motion."""
    run = pp.simulate(scene, samples=101)
    table = Data(columns={"theta": ("theta",), "phi": ("phi",)})
    return pp.fit(scene.replace(data=table), {name: run[name] for name in ("t", "theta", "phi")}, free=free)


CALLS: dict[str, Callable[[pp.Scene], Any]] = {
    "fit": lambda scene: fit_itself(scene, "model.rods[0].mass"),
    "cost": lambda scene: pp.cost(scene, methods=["dop853", "rk4"], accuracy=1e-6, repetitions=1, budget=0.05),
    "significance": significance,
}


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("name", SPECIAL)
@pytest.mark.filterwarnings("error::RuntimeWarning", "ignore::pendpin.errors.Note")
def test_special_scenes_are_answered_or_refused_in_one_line(name: str, call: str) -> None:
    """No warning of numpy, no other error."""
    try:
        said = str(CALLS[call](scene_of(name)))
    except pp.PendpinError as error:
        said = str(error).replace("\n", "two lines")
    assert said
    assert "two lines" not in said


@pytest.mark.parametrize("name", PLANE)
def test_a_column_that_rests_does_not_outweigh_those_that_move(name: str) -> None:
    """Both angles of a swing in a plane: one is 0 throughout, and gravity is found from the other."""
    found = fit_itself(scene_of(name), "effects[0].acceleration")
    assert found.scene.effects[0].acceleration == pytest.approx(9.81, abs=1e-6)
    assert found.errors["effects[0].acceleration"] < 1e-6
    assert max(found.train.rms.values()) < 1e-9


@pytest.mark.parametrize("rate", [0.0, 1e-300, -0.3])
def test_a_thin_rod_turns_at_its_pole_in_any_batch(rate: float) -> None:
    """Angles are singular there: in vectors one flipped at 17 us, at another strength of gravity not."""
    pytest.importorskip("xarray")
    pytest.importorskip("heyoka")
    start = pp.Start(positions=(0.3, UP / 2, 0.0, 0.2), velocities=(rate, 0.0, 0.0, 0.0))
    model = pp.Chain(rods=[RODS["thin"]] * 2)
    scene = pp.Scene(duration=0.3, model=model, effects=(fx.Gravity(),), start=start, solver=pp.Solver(samples=2))
    flips = [
        pp.sweep(scene, {"effects[0].acceleration": [9.81, 5.0]}, "flip_time", **setting).flip_time.values
        for setting in ({}, {"method": "dop853", "tolerance": 1e-10})
    ]
    np.testing.assert_allclose(*flips, rtol=0, atol=1e-6)
