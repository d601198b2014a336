"""The measure `attractor`: basins against runs of one's own, cell by cell; rests and rotations; what has not settled."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from bad_input import run_main
from pendpin import effects as fx
from pendpin.sweeps.attractors import number_attractors

pytest.importorskip("zarr")

POINT = pp.Chain(rods=[pp.Rod(length=1.0, mass=0.0, payload=1.0, joint="hinge")])
PERIOD = 3 * np.pi
START, RATE = "start.positions.theta", "start.velocities.theta"


def driven(amplitude: float, periods: float = 80.0) -> pp.Scene:
    """The damped driven pendulum x'' + x'/2 + sin x = amplitude cos(2 t/3)."""
    effects = [
        fx.Gravity(acceleration=1.0),
        fx.Viscous(coefficient=0.5),
        fx.Motor(joint="theta", amplitude=amplitude, frequency=2 / 3),
    ]
    return pp.Scene(model=POINT, effects=effects, duration=periods * PERIOD, solver=pp.Solver(tolerance=1e-9))


def cycle_of(scene: pp.Scene) -> tuple[int, int, np.ndarray]:
    """By a run of one's own: after how many periods the motion repeats, its turns, and its points (n, 3)."""
    run = pp.simulate(scene, times=PERIOD * np.arange(50, 81))
    states = np.stack([np.cos(run["theta"]), np.sin(run["theta"]), run["theta_rate"]], 1)
    length = next(n for n in range(1, 16) if np.abs(states[-1] - states[-1 - n]).max() < 1e-5)
    return length, round((run["theta"][-1] - run["theta"][-1 - length]) / (2 * np.pi)), states[-length:]


@pytest.mark.parametrize(
    ("amplitude", "kinds"), [(1.07, {(2, 0)}), (1.0809, {(3, 0), (4, 0)}), (1.35, {(1, -1), (1, 1)})]
)
def test_basins_are_those_of_runs_of_ones_own(amplitude: float, kinds: set[tuple[int, int]]) -> None:
    """Cells of one number end on one cycle, cells of two on two; twins in mirror image are apart."""
    scene, values = driven(amplitude), {START: [-2.0, 0.4, 1.9], RATE: [-1.0, 0.1, 1.5]}
    data = pp.sweep(scene, values, ["attractor"])
    own = [cycle_of(scene.replace(dict(zip(values, cell, strict=True)))) for cell in product(*values.values())]
    assert {(n, turns) for n, turns, _ in own} == kinds
    numbers = data["attractor"].values.ravel()
    assert not np.isnan(numbers).any()
    for (one, (n, turns, points)), (other, (m, others, those)) in product(zip(numbers, own, strict=True), repeat=2):
        away = np.abs(points[:, None] - those[None]).max(-1).min(1).max()
        assert (one == other) == ((n, turns) == (m, others) and away < 1e-3)
    kind = {int(text.split(":")[0]): text for text in data["attractor"].attrs["attractors"]}
    for number, (n, turns, _) in zip(numbers, own, strict=True):
        words = f"rotation, {turns:+}" if turns else f"cycle of {n} periods"
        assert words in kind[int(number)]


@given(st.lists(st.sampled_from([-3.0, -1e-9, -0.0, 0.0, 1e-9, 0.4, 3.0]), min_size=1, max_size=3))
def test_a_rest_is_named_by_its_angles(angles: list[float]) -> None:
    """Of any joints; an angle of rounding is 0, whatever its sign."""
    row = np.concatenate([[1.0], 0 * np.array(angles), np.cos(angles), np.sin(angles), 0 * np.array(angles)])
    numbers, (words,) = number_attractors(row[None])
    assert numbers.tolist() == [1]
    assert words == f"1: fixed point at ({', '.join(f'{x:.3g}' if abs(x) > 1e-6 else '0' for x in angles)})"


def test_rests_and_rotations_without_a_drive() -> None:
    """A constant torque below the weight's: one rest, one rotation; neither the order of cells nor samples matter."""
    effects = [fx.Gravity(acceleration=1.0), fx.Viscous(coefficient=0.1), fx.Motor(joint="theta", torque=0.4)]
    scene = pp.Scene(model=POINT, effects=effects, duration=400.0, solver=pp.Solver(samples=6001))
    data = pp.sweep(scene, {START: [0.3, 2.0], RATE: [0.0, 5.0]}, ["attractor"])
    rest, turning = data["attractor"].attrs["attractors"]
    assert rest == f"1: fixed point at ({np.arcsin(0.4):.3g})"
    assert turning == "2: rotation, +1 turns"
    ends = [
        [pp.simulate(scene.replace({START: x, RATE: v}), samples=2)["theta_rate"][-1] for v in (0.0, 5.0)]
        for x in (0.3, 2.0)
    ]
    np.testing.assert_array_equal(data["attractor"], 1 + (np.array(ends) > 1.0))


def test_three_wells() -> None:
    """A bob in three wells of springs' potentials: each cell is at the rest where its own run ends."""
    wells = [fx.Spring(stiffness=0.2), fx.Viscous(coefficient=0.3)]
    scene = pp.Scene(model=POINT, effects=[fx.Gravity(acceleration=2.0), *wells], duration=150.0)
    starts = np.linspace(-9.0, 9.0, 7)
    data = pp.sweep(scene, {START: starts}, ["attractor(1.0)"])
    ends = [pp.simulate(scene.replace({START: x}), samples=2)["theta"][-1] for x in starts]
    numbers = data["attractor"].values
    assert len(set(numbers)) == 3
    for (one, end), (other, there) in product(zip(numbers, ends, strict=True), repeat=2):
        assert (one == other) == (abs(np.sin((end - there) / 2)) < 1e-3)


def test_what_has_not_settled_has_no_number(tmp_path, monkeypatch, capsys) -> None:
    """Chaos, and a motion that is too short: NaN, which the map's report and legend say; the store keeps the same."""
    monkeypatch.chdir(tmp_path)
    driven(1.15).save("chaos.toml")
    vary = ("--vary", f"{START}=-1:1:3", "--vary", f"{RATE}=0:1:2", "--measure", "attractor")
    assert run_main("sweep", "chaos.toml", *vary, "--out", "map.zarr") == 0
    assert run_main("map", "map.zarr", "--plot", "map.png") == 0
    assert "attractor: 6 of 6 cases did not settle" in capsys.readouterr().out
    assert (tmp_path / "map.png").exists()
    driven(1.07).save("cycle.toml")
    assert run_main("sweep", "cycle.toml", *vary, "--out", "cycles.zarr", "--plot", "cycles.png") == 0
    assert "1: cycle of 2 periods" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("attractor(0)", r"give a period in s above 0, as in attractor\(9.42\)"),
        ("attractor(nan)", "give a period in s above 0"),
        ("attractor(-1)", "give a period in s above 0"),
        ("attractor()", "give a period in s above 0"),
        ("attractor(2", "give a period in s above 0"),
        ("attractor(a)", "give a period in s above 0"),
        ("attractor.spread", "the numbers of attractors have no difference"),
        ("atractor", "did you mean 'attractor'"),
        ("attractor(1e3)", "attractor looks at 9 periods of 1000 s at least; give the scene 9000 s or more"),
    ],
)
def test_what_cannot_be_is_refused(name: str, said: str) -> None:
    with pytest.raises(pp.InputError, match=said):
        pp.sweep(driven(1.0), {START: [0.0, 1.0]}, [name])


def test_two_drives_need_a_period() -> None:
    two = (*driven(1.0).effects, fx.Motor(joint="theta", amplitude=0.1, frequency=0.7))
    with pytest.raises(pp.InputError, match="not driven by one frequency; give its period"):
        pp.sweep(driven(1.0).replace(effects=two), {START: [0.0]}, ["attractor"])
