"""What is drawn of a run, by its laws: payloads, the path of the tip, any size."""

import base64
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.collections import QuadMesh

import pendpin as pp
from laws import HANG
from pendpin.fitting.report import interrupt
from pendpin.graphics.drawing import TURN, Shape, smooth
from pendpin.graphics.page import DRAWN, _integers, contents
from pendpin.graphics.run_drawing import drawing_of
from pendpin.graphics.view import _project
from pendpin.sweeps.figure import describe_empty_cells, draw_map
from pendpin.sweeps.plan import samples
from swinging import swinging


@given(
    st.floats(1e-3, 1e3),
    st.floats(0.0, 1e9),
    st.floats(0.0, 2.0),
)
def test_a_payload_is_no_larger_than_a_third_of_its_rod(length: float, payload: float, radius: float) -> None:
    model = pp.Chain(rods=[pp.Rod(length=length, mass=1.0, radius=radius * length, payload=payload)])
    drawing = drawing_of(pp.simulate(pp.Scene(duration=0, model=model, effects=[pp.effects.Gravity()])))
    balls = [shape for shape in drawing.shapes if shape.geometry == "sphere"]
    assert len(balls) == 2
    assert all(2 * ball.size[0] <= length / 3 * (1 + 1e-12) for ball in balls)


@given(st.floats(0.05, 2.0), st.integers(8, 60), st.floats(0.1, 100.0))
def test_a_fast_tip_leaves_no_corners(turn: float, samples: int, rate: float) -> None:
    """On a circle the cubic is off by less than turn^4 / 384 of its radius (de Boor), and its pieces turn by TURN."""
    angle = turn * np.arange(samples)
    t = angle / rate
    points = np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
    velocities = rate * np.stack([-np.sin(angle), np.cos(angle), 0 * angle], -1)
    times, path = smooth(t, points, velocities, 1.0, 30_000)
    assert (times[0], times[-1]) == pytest.approx((t[0], t[-1]))
    off = turn**4 / 384
    assert np.abs(np.linalg.norm(path, axis=-1) - 1).max() <= off + 1e-9
    pieces = np.diff(path, axis=0)
    cosines = (
        (pieces[1:] * pieces[:-1]).sum(-1) / np.linalg.norm(pieces[1:], axis=-1) / np.linalg.norm(pieces[:-1], axis=-1)
    )
    assert np.arccos(np.clip(cosines, -1, 1)).max() <= TURN * (1 + turn**2)


def test_samples_too_far_apart_are_joined_by_straight_lines() -> None:
    """Once round between two samples: no cubic knows the way, and none may leave the samples' neighbourhood."""
    t = np.arange(20.0)
    angle = (2 * np.pi + 0.1) * t
    points = np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
    velocities = (2 * np.pi + 0.1) * np.stack([-np.sin(angle), np.cos(angle), 0 * angle], -1)
    _, path = smooth(t, points, velocities, 60.0, 30_000)
    assert np.linalg.norm(path, axis=-1).max() <= 1 + 1e-12


@pytest.mark.parametrize("factor", [1e-40, 1e-3, 1e5, 1e60])
def test_any_size_is_drawn_alike(factor: float) -> None:
    """A browser computes with 24 bits and a range of 1e38: sizes that do not fit are drawn as if 1 m long."""
    one, other = contents(swinging()), contents(swinging().scaled(factor))
    assert DRAWN[0] <= other["extent"] <= DRAWN[1]
    for name in ("positions", "quaternions"):
        assert other[name]["data"] == one[name]["data"]
    assert other["trail"]["points"]["scale"] / other["extent"] == pytest.approx(one["trail"]["points"]["scale"])


@given(st.integers(0, 2**32 - 1), st.floats(1e-6, 1e6))
def test_a_film_is_seen_from_afar(seed: int, size: float) -> None:
    """Without perspective: the axes to the right and up are at right angles and as long as in space, up is upwards."""
    points = size * np.random.default_rng(seed).normal(size=(5, 3))
    right, up = _project(np.eye(3)).T
    assert np.array([right @ right, up @ up, right @ up]) == pytest.approx([1, 1, 0], abs=1e-15)
    assert up[2] > 0.9
    np.testing.assert_allclose(_project(points), points @ np.stack([right, up], 1), rtol=1e-12, atol=1e-13 * size)


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=9), st.sampled_from([0.0, 1e-30, 1.0, 1e30]))
def test_a_page_holds_numbers_to_one_part_in_65534(values: list[float], size: float) -> None:
    """Of the largest of them: read back from its text, each is there to half a step, and 0 is 0."""
    numbers = size * np.array(values)
    numbers[np.abs(numbers) < 1e-300] = 0.0  # a part of what is smaller is no float
    written = _integers(numbers)
    read = written["scale"] * np.frombuffer(base64.b64decode(written["data"]), "<i2")
    assert np.abs(read - numbers).max() <= np.abs(numbers).max() / 65534 * (1 + 1e-9)
    assert (read[numbers == 0] == 0).all()


@pytest.mark.slow
def test_the_drawn_frames_are_those_of_the_computation(tmp_path: Path) -> None:
    """The drawing of the derivation compares its rods' ends with pendpin's tips before it draws."""
    script = Path(__file__).parents[1] / "examples/draw_frames.py"
    subprocess.run([sys.executable, script, tmp_path], check=True, timeout=HANG, capture_output=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["frames.png", "frames_chain.png"]


@given(st.lists(st.integers(2, 20), min_size=1, max_size=5), st.floats(1e-3, 10.0))
def test_a_fit_is_drawn_with_the_gaps_of_its_data(lengths: list[int], step: float) -> None:
    """Every sample is drawn, in its place, and no line leads across a gap."""
    t, start = [], 0.0
    for length in lengths:
        t += [start + step * i for i in range(length)]
        start = t[-1] + 50 * step
    values = np.arange(len(t), dtype=float)
    at, drawn = interrupt(np.array(t), values)
    present = np.isfinite(drawn)
    np.testing.assert_array_equal(drawn[present], values)
    np.testing.assert_array_equal(at[present], t)
    together = present[1:] & present[:-1]  # most samples are a step apart: each motion has more of these than gaps
    assert (np.diff(at)[together] < 2 * step).all()


def test_a_map_says_what_its_empty_cells_are() -> None:
    """A pendulum that is not thrown does not turn over, and the map says in how long."""
    pytest.importorskip("xarray")
    scene = pp.Scene(duration=0.5, model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]), effects=[pp.effects.Gravity()])
    keys = {"start.positions.theta_1": [0.1, 0.2], "start.positions.phi_1": [0.0, 0.1]}
    found = pp.sweep(scene, keys, measure=["flip_time"])
    assert describe_empty_cells("flip_time", found) == "did not turn over in 0.5 s"


def short_swing() -> pp.Scene:
    """A rod that is let go for a tenth of a second."""
    rod, start = (
        pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.02)]),
        pp.Start(positions={"theta": 0.5, "phi": 0.1}),
    )
    return pp.Scene(duration=0.1, model=rod, start=start, effects=[pp.effects.Gravity()])


@pytest.mark.parametrize("at_random", [False, True])
def test_a_line_goes_over_the_first_number_that_varies(at_random: bool) -> None:
    """In steps or at random: the axis has its name and its unit, the points are those of the table."""
    pytest.importorskip("xarray")
    spreads = {"model.rods[0].length": ("uniform", 0.5, 2.0), "start.positions.phi": ("uniform", 0.0, 0.3)}
    varied: Any = samples(spreads, 5, "latin", seed=0) if at_random else {"model.rods[0].length": [0.5, 0.7, 2.0]}
    table = pp.sweep(short_swing(), varied, "swing")
    ax = draw_map(table).axes[0]
    assert ax.get_xlabel() == "model.rods[0].length (m)"
    assert ax.get_ylabel() == "swing (rad)"
    np.testing.assert_array_equal(ax.lines[0].get_xdata(), table["length"].values)
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), table["swing"].values)


def test_a_map_has_the_cells_of_its_table() -> None:
    """A panel for each value of the first number, in its order; the second number to the right, the third upwards."""
    pytest.importorskip("xarray")
    lengths, thetas, phis = [0.5, 0.7, 2.0], [0.1, 0.4], [0.0, 0.2, 0.3, 0.5]
    varied = {"model.rods[0].length": lengths, "start.positions.theta": thetas, "start.positions.phi": phis}
    table = pp.sweep(short_swing(), varied, "swing")
    figure = draw_map(table)
    assert figure.get_size_inches()[0] > 4 * len(lengths)
    panels = [ax for ax in figure.axes if ax.get_title("left")]
    assert [ax.get_title("left") for ax in panels] == [f"model.rods[0].length (m) = {x:.4g}" for x in lengths]
    for ax, values in zip(panels, table["swing"].values, strict=True):
        mesh = next(x for x in ax.collections if isinstance(x, QuadMesh))
        np.testing.assert_array_equal(np.reshape(mesh.get_array(), (4, 2)), values.T)
        corners = mesh.get_coordinates()
        for edges, centres in ((corners[0, :, 0], thetas), (corners[:, 0, 1], phis)):
            assert np.digitize(centres, edges).tolist() == list(range(1, len(edges)))
    assert [ax.get_xlabel() for ax in panels] == ["theta (rad)"] * 3
    assert panels[0].get_ylabel() == "phi (rad)"
    assert [mesh.norm.vmin for ax in panels for mesh in ax.collections[:1]] == [table["swing"].values.min()] * 3


def test_a_quantity_that_one_run_lacks_is_left_out() -> None:
    """Of a run with friction the energy drift, and the legend says so; by name it is asked of the first run."""
    rod, start = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)]), pp.Start(positions=[0.5, 0.1])
    free = pp.Scene(duration=0.2, model=rod, start=start, effects=[pp.effects.Gravity()])
    rubbed = free.replace(effects=(*free.effects, pp.effects.Viscous(coefficient=0.1)))
    one, other = (pp.simulate(scene, samples=5) for scene in (free, rubbed))
    figure = one.plot("energy_drift", compare=other)
    assert "run 2 has none" in [line.get_label() for line in figure.axes[0].lines]
    with pytest.raises(pp.InputError, match="has no potential"):
        other.plot("energy_drift", compare=one)


TREE = """<robot name="tree"><link name="base"/>
<link name="arm"><inertial><origin xyz="0 0 -0.3"/><mass value="2"/>
  <inertia ixx="0.06" iyy="0.06" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link><link name="hand"/>
<link name="car"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="finger"><inertial><origin xyz="0 0 -0.1"/><mass value="0.2"/>
  <inertia ixx="0.001" iyy="0.001" izz="0.0001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="pin" type="continuous"><parent link="base"/><child link="arm"/><origin xyz="0.2 0 0.1"/>
  <axis xyz="1 0 0"/></joint>
<joint name="weld" type="fixed"><parent link="arm"/><child link="hand"/><origin xyz="0 0 -0.6" rpy="0 0 0.3"/></joint>
<joint name="slide" type="prismatic"><parent link="hand"/><child link="car"/><origin rpy="0.4 0 0"/><axis xyz="0 1 0"/>
  <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="knuckle" type="continuous"><parent link="hand"/><child link="finger"/><origin xyz="0.1 0 0.2"/>
  <axis xyz="1 0 0"/></joint></robot>"""


def test_a_tree_without_visuals_holds_together(tmp_path: Path) -> None:
    """Every joint lies on a stick of the body it hangs on, through welds and beside rods, wherever a slide goes."""
    file = tmp_path / "tree.urdf"
    file.write_text(TREE)
    start = pp.Start(positions={"pin": 0.3, "knuckle": 1.0})
    scene = pp.Scene(duration=0.5, model=pp.UrdfModel(str(file)), start=start, effects=[pp.effects.Gravity()])
    run = pp.simulate(scene, samples=16)
    assert np.ptp(run["slide"]) > 0.1
    drawing = drawing_of(run)
    sticks = [shape for shape in drawing.shapes if shape.geometry == "cylinder"]
    hanging = ((0, 3), (1, 0), (2, 0))  # bodies, and what each hangs on: the support, and the arm
    for body, above in hanging:
        for pose, holder in zip(drawing.poses[:, body], drawing.poses[:, above], strict=True):
            place = (np.linalg.inv(holder) @ pose)[:, 3]
            assert min(_distance(stick, place) for stick in sticks if stick.body == above) < 1e-12  # m, rounding


def test_a_hinge_is_a_pin_along_its_axis(tmp_path: Path) -> None:
    """A cylinder along x, centred at the joint; what a slide or a universal joint moves has a ball there."""
    file = tmp_path / "tree.urdf"
    file.write_text(TREE)
    run = pp.simulate(pp.Scene(duration=0.0, model=pp.UrdfModel(str(file)), effects=[pp.effects.Gravity()]))
    for body, joint in enumerate(run.joints):
        own = (x for x in drawing_of(run).shapes if x.body == body and not x.placement[:3, 3].any())
        shapes = [(x.geometry, abs(x.placement[0, 2])) for x in own]
        assert shapes == [("sphere", 0.0) if joint == "slide" else ("cylinder", 1.0)]
    rod = drawing_of(pp.simulate(pp.Scene(duration=0.0, model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]))))
    assert [x.geometry for x in rod.shapes] == ["box", "cylinder", "sphere", "sphere"]
    about_y = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, joint="hinge", axis="y")])
    pin = drawing_of(pp.simulate(pp.Scene(duration=0.0, model=about_y))).shapes[2]
    assert (pin.geometry, abs(pin.placement[1, 2])) == ("cylinder", 1.0)


def _distance(stick: Shape, place: np.ndarray) -> float:
    """From the axis of a stick to a place (4,), in m."""
    x, y, z, _ = np.linalg.inv(stick.placement) @ place
    return float(np.hypot(np.hypot(x, y), max(abs(z) - stick.size[1] / 2, 0.0)))
