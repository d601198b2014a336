"""Particular starts: a steady cone stays one, an equilibrium keeps its place; others are refused or noted."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin.errors import Note
from pendpin.model.build import build, start_state
from pendpin.scene import unit_of_key

GRAVITY = pp.effects.Gravity()
SLENDER = {  # no inertia about the axis
    "thin": pp.Rod(length=1.0, mass=1.0),
    "point mass": pp.Rod(length=2.0, mass=0.0, payload=3.0),
    "own inertia": pp.Rod(length=1.0, mass=2.0, com=0.8, inertia=(0.3, 0.3, 0.0)),
}


def scene_of(rod: pp.Rod, *effects: pp.effects.Effect) -> pp.Scene:
    """A scene of one rod for 100 s, to rounding."""
    solver = pp.Solver(method="taylor", tolerance=1e-15, samples=201)
    return pp.Scene(model=pp.Chain(rods=[rod]), effects=effects or [GRAVITY], duration=100.0, solver=solver)


@pytest.mark.parametrize("name", SLENDER)
@pytest.mark.parametrize("angle", [0.01, -0.5, 1.4])
def test_a_cone_stays_one(name: str, angle: float) -> None:
    """Over 100 s its angle does not change by 1e-12 rad, nor does its turning."""
    scene = scene_of(SLENDER[name])
    run = pp.simulate(scene.replace(start=pp.Start.conical(scene, angle)))
    assert np.abs(run["swing"] - abs(angle)).max() < 1e-12
    m, h, inertia, *_ = SLENDER[name].properties
    rate = np.sqrt(9.81 * m * h / ((inertia + m * h**2) * np.cos(angle)))
    turned = np.unwrap(np.arctan2(run["tip_y"], run["tip_x"]), period=2 * np.pi)
    expected = (turned[0] + rate * run.t - turned + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(expected).max() < 1e-11


@pytest.mark.parametrize(("radius", "angle"), [(0.01, 0.5), (0.05, 0.5), (0.01, 1.4)])
def test_a_thick_rod_nods_as_much_as_the_docstring_says(radius: float, angle: float) -> None:
    """Energy forbids it a steady cone: the spin about its axis changes round the circle. Large nods are noted."""
    rod = pp.Rod(length=1.0, mass=1.0, radius=radius)
    scene = scene_of(rod).replace(duration=10.0)
    m, h, inertia, _, axial = rod.properties
    said = axial / (inertia + m * h**2) * np.sin(angle) * np.tan(angle) ** 2
    run = pp.simulate(scene.replace(start=pp.Start.conical(scene, angle)))
    assert 0.3 * said < np.abs(run["swing"] - angle).max() < 3 * said


def test_a_cone_that_is_none() -> None:
    """What nods much is noted; other scenes and angles are refused."""
    thick = scene_of(pp.Rod(length=1.0, mass=1.0, radius=0.3))
    with pytest.warns(Note, match="no steady cone"):
        pp.Start.conical(thick, 1.0)
    thin = scene_of(SLENDER["thin"])
    tilted = pp.effects.Gravity(direction=(0.1, 0.0, -1.0))
    for scene, angle, says in [
        (thin, 0.0, "not between"),
        (thin, np.pi / 2, "not between"),
        (thin, "0.5", "not between"),
        (thin.replace(effects=[]), 0.5, "gravity straight down"),
        (thin.replace(effects=[tilted]), 0.5, "gravity straight down"),
        (thin.replace({"model.copies": 2}), 0.5, "one rod"),
    ]:
        with pytest.raises(pp.InputError, match=says):
            pp.Start.conical(scene, angle)


def rods() -> st.SearchStrategy[pp.Rod]:
    """Rods of moderate sizes."""
    sizes = {"length": st.floats(0.1, 3.0), "mass": st.floats(0.1, 10.0), "radius": st.sampled_from([0.0, 0.01, 0.1])}
    return st.builds(pp.Rod, **sizes)


@law(8)
@given(st.lists(rods(), min_size=1, max_size=3), st.floats(-1.2, 1.2), st.floats(-1.2, 1.2), st.floats(0.5, 20.0))
def test_a_chain_at_rest_hangs_along_gravity(chain: list[pp.Rod], theta: float, phi: float, g: float) -> None:
    """Whichever way it points: all tips are on one line, and nothing accelerates."""
    down = np.array([np.sin(phi), -np.sin(theta) * np.cos(phi), -np.cos(theta) * np.cos(phi)])
    gravity = pp.effects.Gravity(acceleration=g, direction=tuple(down.tolist()))
    scene = pp.Scene(model=pp.Chain(rods=chain), effects=[gravity], duration=0.0)
    run = pp.simulate(scene.replace(start=pp.Start.at_rest(scene)))
    far = np.cumsum([rod.length for rod in chain])
    np.testing.assert_allclose(run.tips[0], far[:, None] * down, atol=1e-8 * far[-1])
    assert np.abs(run.a).max() < 1e-8 * g / min(rod.length for rod in chain)


def test_rest_between_springs_and_wind_and_beyond_stops() -> None:
    """A spring holds a rod where its torque is gravity's; one that a stop would hold is refused."""
    spring = pp.effects.Spring(stiffness=20.0, rest=1.0, joints=["theta"])
    scene = scene_of(pp.Rod(length=1.0, mass=1.0, radius=0.02), GRAVITY, spring)
    angle = pp.Start.at_rest(scene).positions["theta"]
    assert 20.0 * (1.0 - angle) == pytest.approx(9.81 / 2 * np.sin(angle), rel=1e-9)
    stop = pp.effects.Stop(lower=-0.5, upper=0.5, joints=["theta"])
    with pytest.raises(pp.InputError, match=r"theta is beyond its stop at 0\.5: start there, with start"):
        pp.Start.at_rest(scene.replace(effects=[GRAVITY, spring, stop]))
    stop = pp.effects.Stop(lower=-0.5, upper=0.5, joints=["phi"])
    for rest in (1.0, -1.0):
        held = [pp.effects.Spring(stiffness=20.0, rest=at, joints=[on]) for at, on in ((rest, "phi"), (0.2, "theta"))]
        with pytest.raises(pp.InputError, match=f"phi is beyond its stop at {rest / 2:g}: "):
            pp.Start.at_rest(scene.replace(effects=[GRAVITY, *held, stop]))


def test_a_start_is_one_wherever_it_comes_from() -> None:
    """A start that a user writes equals that of a scene file, and hashes alike; one that was found is of the same class."""
    mine = pp.Start(positions={"theta": 0.3})
    scene = pp.Scene(model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]), start={"positions": {"theta": 0.3}})
    assert mine == scene.start
    assert scene.start == mine
    assert hash(mine) == hash(scene.start)
    assert scene == scene.replace(start=mine)
    assert mine != pp.Start(positions={"theta": 0.4})
    assert type(pp.Start.at_rest(scene)) is pp.Start


@pytest.mark.parametrize("unit", ["radians", "degrees"])
@pytest.mark.parametrize("part", ["positions", "velocities"])
def test_a_number_of_a_start_is_in_the_unit_that_is_said(unit: Any, part: str) -> None:
    """Of angles and of their rates, in both units: the number, in this unit, is the one with which the run begins."""
    scene = pp.Scene(model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.1)]), start=pp.Start(unit=unit))
    key = f"start.{part}.phi"
    q, v = start_state(build(scene.model), scene.replace({key: 2.0}).start)
    said = {"rad": 1.0, "degrees": np.pi / 180}[unit_of_key(key, scene).removesuffix("/s")]
    assert unit_of_key(key, scene).endswith("/s") == (part == "velocities")
    assert (q if part == "positions" else v).tolist() == pytest.approx([0.0, 2.0 * said])


def test_a_rope_whose_ends_are_one_above_the_other_hangs_in_a_loop() -> None:
    """Straight down is a rest too, which is left: the loop has less energy, is in one plane, and its halves hang alike."""
    rope = pp.Chain(rods=[pp.Rod(length=0.5, mass=0.1, radius=0.01, copies=12)])
    anchor = pp.effects.Anchor(link="rod_12", point=(0.0, 0.0, -2.0), stiffness=1e4)
    scene = pp.Scene(duration=0.0, model=rope, effects=[GRAVITY, anchor])
    straight, loop = (pp.simulate(scene.replace(start=start)) for start in (pp.Start(), pp.Start.at_rest(scene)))
    assert loop.potential[0] < straight.potential[0] / 10
    assert np.abs(loop.a).max() < 1e-6  # of 1e5 rad/s², the anchor's pull at the start
    tips = loop.tips[0]
    assert np.linalg.svd(tips, compute_uv=False)[2] < 1e-6
    assert np.linalg.svd(tips, compute_uv=False)[1] > 0.01
    assert pp.modes(scene.replace(start=pp.Start.at_rest(scene))).stable


def test_a_stiff_anchor_is_reached_by_softer_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a tenth of the steps the search alone fails; a rope under an anchor 1 mm beside the vertical hangs at it."""
    monkeypatch.setattr("pendpin.motions.special_starts.MOST", 100)
    rope = pp.Chain(rods=[pp.Rod(length=0.375, mass=0.3, radius=0.01, copies=8)])
    point = (0.001, 0.0, -0.5)
    scene = pp.Scene(
        duration=0.0,
        model=rope,
        effects=[GRAVITY, pp.effects.Anchor(link="rod_8", point=point, stiffness=1e5)],
    )
    run = pp.simulate(scene.replace(start=pp.Start.at_rest(scene)))
    assert np.abs(run.a).max() < 1e-5  # of 1e6 rad/s² at the start
    assert np.linalg.norm(run.tips[0, -1] - point) < 0.3 * 8 * 9.81 / 1e5  # the anchor carries less than the weight
