"""Quantities of a chain (tension, spin, angular momentum, the swing of its load) and pictures of a rope, by their laws."""

import math
from pathlib import Path

import numpy as np
import pytest

import pendpin as pp
from pendpin import effects as fx
from pendpin.graphics.run_drawing import plots_of
from pendpin.model import kinematics
from pendpin.model.build import build
from pendpin.trajectory import RunRecord
from test_cables import LENGTH, MIXED, beam, still

# --- quantities -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def moving() -> pp.Trajectory:
    """Four rods of three kinds, thick and with a sphere, that swing freely; a sample each millisecond."""
    q, v = np.random.default_rng(2).uniform(-0.6, 0.6, (2, 8)).tolist()
    scene = still(MIXED, fx.Gravity()).replace(start=pp.Start(positions=q, velocities=v))
    return pp.simulate(scene, tolerance=1e-12, samples=1001)


def rate(run: pp.Trajectory, x: np.ndarray) -> np.ndarray:
    """d/dt of series x (n, ...) by differences of sixth order, without three samples at either end."""
    return (45 * (x[4:-2] - x[2:-4]) - 9 * (x[5:-1] - x[1:-5]) + x[6:] - x[:-6]) / (60 * (run.t[1] - run.t[0]))


def test_tension_is_the_force_along_the_rod_at_its_upper_end(moving: pp.Trajectory) -> None:
    """From the wrench of the joint in W, projected on the rod between its two ends."""
    ends = np.concatenate([np.zeros((len(moving.t), 1, 3)), moving.tips], 1)
    for k, rod in enumerate(MIXED.all_rods):
        up = (ends[:, k] - ends[:, k + 1]) / rod.length
        force = moving.express(f"phi_{k + 1}", frame="world")[:, :3]
        tension = (up * force).sum(1)
        np.testing.assert_allclose(moving[f"tension_{k + 1}"], tension, rtol=0, atol=1e-12 * np.abs(force).max())
    assert np.array_equal(moving["tension_2"], moving["R3_2"])


def test_omega_is_the_rate_of_the_orientation(moving: pp.Trajectory) -> None:
    """B^T dB/dt of each rod's axes in W, by differences: their error is h^6, and rounding over h."""
    poses = kinematics.poses(build(MIXED), moving.q)
    for k in range(4):
        axes = poses[:, k, :3, :3] * [1, -1, -1]  # b1, b2, b3
        turn = axes[3:-3].swapaxes(1, 2) @ rate(moving, axes)
        omega = np.stack([turn[:, 2, 1], turn[:, 0, 2], turn[:, 1, 0]], -1)
        np.testing.assert_allclose(moving.omega[3:-3, k], omega, rtol=0, atol=1e-7)
        assert np.array_equal(moving[f"omega2_{k + 1}"], moving.omega[:, k, 1])


def test_the_moment_of_gravity_changes_the_angular_momentum(moving: pp.Trajectory) -> None:
    """About the support, with the moment Mc of the support on rods that have a radius."""
    model = build(MIXED)
    poses = kinematics.poses(model, moving.q)
    moment = moving.express("theta_1", frame="world")[:, 3:]
    for k, body in enumerate(model.bodies):
        centre = poses[:, k, :3, :3] @ body.com + poses[:, k, :3, 3]
        moment = moment + np.cross(centre, [0, 0, -9.81 * body.mass])
    momentum = np.stack([moving[f"angular_momentum_{axis}"] for axis in "xyz"], -1)
    np.testing.assert_allclose(rate(moving, momentum), moment[3:-3], rtol=0, atol=1e-8 * np.abs(moment).max())


def test_the_load_swings_as_the_line_from_the_support() -> None:
    """A straight chain swings as its first rod; another one by the line to its tip, also between samples."""
    rods = [pp.Rod(length=0.5, mass=0.0, payload=1e-9), pp.Rod(length=1.5, mass=0.0, payload=3.0)]
    for theta, phi in ((0.3, 0.0), (0.0, -2.0), (0.4, 0.7)):
        run = pp.simulate(still(pp.Chain(rods=rods), theta_1=theta, phi_1=phi), duration=0.0, samples=1)
        assert math.cos(run["swing"][0]) == pytest.approx(math.cos(theta) * math.cos(phi), abs=1e-14)
    run = pp.simulate(still(MIXED, fx.Gravity(), theta_1=0.3), tolerance=1e-11, samples=15)
    dense = run.at(np.linspace(0, 1, 2001))
    assert run.minimum("swing").value == pytest.approx(dense["swing"].min(), abs=1e-3)
    assert run.maximum("swing").value >= dense["swing"].max() - 1e-12


def test_quantities_of_a_chain_are_in_every_table(moving: pp.Trajectory, tmp_path: Path) -> None:
    """By name, as a Dataset with units, from a file; a record alone and a robot have none."""
    few = moving.at(moving.t[::200])
    table, loaded = few.to_xarray(), pp.Trajectory.load(few.save(tmp_path / "run.npz"))
    for name, column in (("tension", "tension_3"), ("omega1", "omega1_3")):
        assert np.array_equal(table[name].sel(rod=3), few[column])
        assert np.array_equal(loaded[column], few[column])
    assert np.array_equal(table.angular_momentum.sel(axis="y"), few["angular_momentum_y"])
    assert (table.swing.units, table.omega3.units, table.angular_momentum.units) == ("rad", "rad/s", "kg m²/s")
    record = RunRecord(**{name: getattr(few, name) for name in RunRecord.__dataclass_fields__})
    assert record.names == few.names
    with pytest.raises(pp.InputError, match=r"Trajectory\.of\(record\)"):
        record["omega1_1"]
    robot = pp.simulate(pp.Scene(model=pp.UrdfModel(name="double_pendulum"), duration=0.1), samples=2)
    assert not {"swing", "omega1_1", "angular_momentum_x"} & set(robot.names)
    with pytest.raises(pp.InputError, match="not a chain of rods"):
        _ = robot.omega


def test_quantities_of_a_chain_have_derivatives(moving: pp.Trajectory) -> None:
    """By a start and by a length, against differences of runs."""
    scene = still(MIXED, fx.Gravity(), theta_1=0.3, phi_2=0.2)
    run = pp.simulate(scene, tolerance=1e-12, samples=5)
    for key, value in (("start.positions.theta_1", 0.3), ("model.rods[1].length", 0.7)):
        up, down = (pp.simulate(scene.replace({key: value + h}), tolerance=1e-12, samples=5) for h in (1e-4, -1e-4))
        for name in ("swing", "omega2_2", "angular_momentum_x"):
            difference = (up[name] - down[name]) / 2e-4
            np.testing.assert_allclose(run.sensitivity([key], name)[:, 0], difference, rtol=0, atol=1e-5)


# --- pictures of a rope -----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def rope() -> pp.Trajectory:
    """Fourteen rods on a support that shakes."""
    shaken = fx.Support(amplitude=(0.1, 0.0, 0.0), frequency=3.0)
    return pp.simulate(still(beam(14), fx.Gravity(), shaken, theta_1=0.9, phi_1=0.2), tolerance=1e-7, samples=41)


def test_the_figure_of_a_rope(rope: pp.Trajectory) -> None:
    """Offset, swing and tension over time; shapes at eight instants end at the tips; tension over arc length is R3."""
    figure = rope.plot()
    time, (shape, along, path) = figure.axes[:-3], figure.axes[-3:]
    assert [ax.get_ylabel() for ax in time] == ["tip's offset (m)", "swing (rad)", "tension R3 (N)", "energy (J)"]
    assert [text.get_text() for text in time[3].get_legend().get_texts()][:3] == ["kinetic", "potential*", "energy"]
    lines = {line.get_label(): line.get_ydata() for ax in time for line in ax.lines}
    assert np.array_equal(lines["y"], rope["tip_y"])
    assert np.array_equal(lines["largest in the rope"], rope.reactions().R3.max(1))
    ropes = [line for line in shape.lines if len(line.get_xdata()) == 15]
    assert [line.get_label() for line in ropes] == [f"{t:.4g} s" for t in rope.t[[0, 6, 11, 17, 23, 29, 34, 40]]]
    assert np.array_equal(ropes[-1].get_xydata()[1:], rope.tips[-1][:, 1:])
    peak = int(rope.reactions().R3.max(1).argmax())
    assert f"{rope.t[peak]:.4g} s, peak" in [line.get_label() for line in along.lines]
    for line in along.lines:
        row = int(np.abs(rope.t - float(line.get_label().split()[0])).argmin())
        assert np.array_equal(line.get_ydata(), rope.reactions().R3[row])
    np.testing.assert_allclose(along.lines[0].get_xdata(), LENGTH / 14 * np.arange(14), atol=1e-12)
    assert shape.get_title(loc="left") == "shape of the rope, relative to the support"
    assert path.get_title(loc="left") == "path of the tip relative to the support,\nfrom above"


def test_a_rope_is_more_than_twelve_rods_and_its_page_begins_with_it(rope: pp.Trajectory) -> None:
    """Twelve rods have the figure of rods; nothing is relative where nothing moves."""
    titles = [plot.title for plot in plots_of(rope)]
    assert titles[:3] == ["Tip's offset from the support", "Swing of the line to the tip", "Tension R3, 3 of 14 rods"]
    assert all(curve.name in rope for plot in plots_of(rope) for curve in plot.curves)
    rods = pp.simulate(still(beam(12), fx.Gravity(), theta_1=0.9), tolerance=1e-6, samples=5)
    assert plots_of(rods)[0].title.startswith("Energy")
    assert [ax.get_title(loc="left") for ax in rods.plot().axes[-3:]] == [
        "path of the tip, from above",
        "from the front",
        "from the side",
    ]


def test_pictures_of_ropes_that_hang_still_or_are_compared(rope: pp.Trajectory, tmp_path: Path) -> None:
    """One sample, a rope between two points, two runs together, a file: each has its figure, without doubled names."""
    straight = pp.simulate(still(beam(13), fx.Gravity()), duration=0.0, samples=1)
    assert len(straight.plot().axes) == 8
    held = fx.Anchor(link="rod_14", point=(0, -1.4, 0), stiffness=1e5, damping=10.0)
    up = math.acos(0.7)
    between = still(beam(14), fx.Gravity(), held, theta_1=math.pi / 2 - up, theta_8=2 * up)
    assert "swing (rad)" not in [ax.get_ylabel() for ax in pp.simulate(between, samples=9, tolerance=1e-6).plot().axes]
    loaded = pp.Trajectory.load(rope.save(tmp_path / "run.npz"))
    assert "relative to the support" in loaded.plot().axes[-1].get_title(loc="left")
    both = rope.plot(compare=loaded).axes[-2].get_legend().get_texts()
    assert [text.get_text() for text in both].count("at any time") == 1
