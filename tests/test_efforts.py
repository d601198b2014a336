"""What each effect exerts on each joint, and runs as labelled arrays."""

from pathlib import Path

import numpy as np
import pytest

import pendpin as pp
from pendpin import effects as fx
from pendpin.model.bodies import pinocchio

ROD = pp.Rod(length=1.0, mass=1.0, radius=0.05)
START = pp.Start(positions=(0.7, 0.4, -0.3, 0.2), velocities=(1.3, -0.8, 0.2, 0.5))
EFFECTS = {
    "fields": (fx.Gravity(), fx.Support(amplitude=(0.1, 0.0, 0.05), frequency=5.0)),
    "joints": (fx.Gravity(), fx.Viscous(coefficient=0.3), fx.Spring(stiffness=2.0, joints=("phi_1",))),
    "bodies": (
        fx.Gravity(),
        fx.Drag(wind=(3, -2, 1)),
        fx.Push(link="rod_2", force=(0.3, -0.5, 0.7), torque=(0.1, 0, 0)),
    ),
    "a function": (fx.Gravity(), fx.Torque(lambda t, q, v: -2.0 * v, steady=True, gradual=True)),
}


def run_of(*effects: fx.Effect, **fields) -> pp.Trajectory:
    """Two rods for half a second."""
    chain = pp.Chain(rods=(ROD, ROD))
    return pp.simulate(pp.Scene(model=chain, start=START, effects=effects, duration=0.5, **fields), samples=11)


def inverse_dynamics(run: pp.Trajectory) -> np.ndarray:
    """RNEA without gravity, (n, nv)."""
    pin, model = pinocchio(), pp.bind(run.source).model.pin.copy()
    model.gravity = pin.Motion.Zero()
    data = model.createData()
    return np.array([pin.rnea(model, data, *state) for state in zip(run.q, run.v, run.a, strict=True)])


@pytest.mark.parametrize("name", EFFECTS)
def test_efforts_add_up_to_the_inverse_dynamics(name: str) -> None:
    """d'Alembert: all generalised forces together are what the motion needs, to rounding of torques of order 10."""
    run = run_of(*EFFECTS[name])
    found = run.efforts()
    assert set(found) == {effect.kind for effect in EFFECTS[name]}
    needed = inverse_dynamics(run)
    assert np.abs(sum(found.values()) - needed).max() < 1e-11 * np.abs(needed).max()


def test_the_effort_of_a_torque_is_its_output() -> None:
    """As of viscous damping: minus the coefficient times the rates."""
    assert np.array_equal(run_of(*EFFECTS["a function"]).efforts()["torque"], -2.0 * run_of(*EFFECTS["a function"]).v)
    run = run_of(fx.Gravity(), fx.Viscous(coefficient=0.3))
    assert np.array_equal(run.efforts()["viscous"], -0.3 * run.v)


def test_contacts_give_what_is_left() -> None:
    """Sliding friction is the kinetic torque against the rate; a joint that is held gets what holds it, up to the static."""
    run = run_of(fx.Gravity(), fx.DryFriction(kinetic=0.4, static=0.5))
    contacts, sliding = run.efforts()["contacts"], np.abs(run.v) > 1e-6
    torques = np.abs(inverse_dynamics(run)).max()
    assert np.abs(contacts + 0.4 * np.sign(run.v))[sliding].max() < 1e-10 * torques
    assert np.abs(contacts).max() <= 0.5 + 1e-10 * torques


def test_efforts_are_quantities_by_name(tmp_path: Path) -> None:
    """The same numbers as of `efforts`, with units, in plots and in tables that name them; others stay as they are."""
    run = run_of(*EFFECTS["joints"])
    found, name = run.efforts(), "effort_spring_phi_1"
    for kind, values in found.items():
        for joint, column in zip(run.joints, values.T, strict=True):
            assert np.array_equal(run[f"effort_{kind}_{joint}"], column)
    assert not [each for each in run.names if each.startswith("effort_")]
    assert run.plot(name).axes[0].get_ylabel() == f"{name} (N m)"
    assert run.to_csv(tmp_path / "two.csv", name, "R3_1").read_text().splitlines()[0] == f"t,{name},R3_1"
    frame = run.to_pandas(name)
    assert np.array_equal(frame[name], found["spring"][:, 1])
    assert frame.attrs["units"] == {"t": "s", name: "N m"}
    with pytest.raises(pp.InputError, match=r"did you mean .effort_spring_phi_2"):
        run["effort_spring_phi_3"]


def test_a_run_as_labelled_arrays(tmp_path: Path) -> None:
    """The same numbers by name, with units; in pandas the units are in attrs."""
    xarray = pytest.importorskip("xarray")
    run = run_of(fx.Gravity())
    found = run.to_xarray()
    assert isinstance(found, xarray.Dataset)
    assert np.array_equal(found.q.sel(joint="phi_2"), run["phi_2"])
    assert np.array_equal(found.tips.sel(rod=2, axis="z"), run["tip_z"])
    assert np.array_equal(found.R3.sel(rod=1), run["R3_1"])
    assert all("units" in found[name].attrs for name in (*found.data_vars, "t"))
    frame = run.to_pandas()
    assert set(frame.attrs["units"]) == {"t", *frame.columns}
    assert frame.attrs["units"]["theta_1_rate"] == "rad/s"


def test_tips_of_a_robot_are_over_its_links(tmp_path: Path) -> None:
    """By the names of its file; where that is gone, by numbers."""
    pytest.importorskip("xarray")
    path = tmp_path / "arm.urdf"
    path.write_text(Path(pp.UrdfModel("ur5").file).read_text())
    run = pp.simulate(pp.Scene(model=pp.UrdfModel(path), effects=(fx.Gravity(),), duration=0.1), samples=3)
    saved = run.save(tmp_path / "run.npz")
    tips = run.to_xarray().tips
    assert np.array_equal(tips.sel(link="forearm_link"), run.tips[:, list(tips.link).index("forearm_link")])
    assert "rod" not in tips.dims
    path.unlink()
    assert pp.Trajectory.load(saved).to_xarray().link.to_numpy().tolist() == list(range(1, tips.sizes["link"] + 1))
