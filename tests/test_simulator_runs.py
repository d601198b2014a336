"""Runs of a scene in MuJoCo, Drake and SciPy: they come to pendpin's motion as their order and tolerance say.

pendpin's own run, a Taylor series to rounding, is the one to compare with; other tests compare it with exact solutions.
"""

from importlib.util import find_spec

import numpy as np
import pytest

import pendpin as pp
import pendpin.verification.simulators
from pendpin.scene import Solver, builtin_scene
from pendpin.verification.hardcases import hard
from pendpin.verification.simulators import peers

missing = [name for name in ("mujoco", "pydrake") if find_spec(name) is None]
pytestmark = pytest.mark.skipif(bool(missing), reason=f"not installed: {', '.join(missing)} (extra `peers`)")

GRAVITY = (pp.effects.Gravity(),)
ORDERS = {"mujoco rk4": 4, "mujoco euler": 1, "mujoco implicitfast": 1, "drake rk5 fixed": 5}
CONTROLLED = ("drake rk5", "drake rk3", "scipy dop853", "scipy rk45", "scipy lsoda", "scipy radau")

# Branches, names and axes out of order; joints that slide, that have limits and damping; a massless tip; a tilted body.
TREE = """<robot name="tree"><link name="{root}"/>
<link name="zed"><inertial><origin xyz="0.1 0.02 -0.3" rpy="0.2 0.3 0"/><mass value="1"/>
  <inertia ixx="0.02" iyy="0.03" izz="0.025" ixy="0.001" ixz="0" iyz="0.002"/></inertial></link>
<link name="a"><inertial><origin xyz="0 0 -0.2"/><mass value="0.5"/>
  <inertia ixx="0.01" iyy="0.01" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="b"><inertial><origin xyz="0 0.1 -0.2"/><mass value="0.7"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="frame"/><link name="tool"/>
<joint name="z" type="continuous"><parent link="{root}"/><child link="zed"/><axis xyz="1 1 0"/>
  <dynamics damping="3" friction="1"/></joint>
<joint name="last" type="revolute"><parent link="zed"/><child link="b"/><origin xyz="0 0 -0.5" rpy="0.1 0 0"/>
  <axis xyz="0 1 0"/><limit lower="-0.1" upper="0.1" effort="1" velocity="1"/></joint>
<joint name="alpha" type="prismatic"><parent link="zed"/><child link="a"/><origin xyz="0 0.2 -0.5" rpy="0.1 0 0"/>
  <axis xyz="0.6 0 0.8"/><limit lower="-0.1" upper="0.1" effort="1" velocity="1"/></joint>
<joint name="f1" type="fixed"><parent link="a"/><child link="frame"/><origin xyz="0 0 -0.3"/></joint>
<joint name="f2" type="fixed"><parent link="frame"/><child link="tool"/><origin xyz="0 0 -0.3" rpy="1 0 0"/></joint>
</robot>"""


def chain(count, duration=2.0, samples=21, start=None, effects=GRAVITY, **rod):
    """So many rods; radius 0.1 of the length unless the rod says otherwise."""
    start = start or pp.Start(positions=[0.7, 0.4] + [0.3, -0.2] * (count - 1), velocities=[1.3, -0.8] * count)
    model = pp.Chain(rods=(pp.Rod(**({"length": 1.0, "mass": 1.0, "radius": 0.1} | rod)),), copies=count)
    return pp.Scene(duration=duration, model=model, start=start, effects=effects, solver=Solver(samples=samples))


def tree(folder, root):
    path = folder / "tree.urdf"
    path.write_text(TREE.format(root=root))
    start = pp.Start(positions={"z": 0.9, "last": 0.3, "alpha": -0.3}, velocities={"z": 1.0, "last": 2.0})
    return pp.Scene(duration=0.5, model=pp.UrdfModel(path=path), start=start, effects=GRAVITY)


def error(run, reference):
    np.testing.assert_array_equal(run.t, reference.t)
    return np.abs(run.q - reference.q).max()


# --- right, and as right as asked -----------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_peers_come_to_pendpins_motion(count):
    """Fixed steps: the error falls with the order. Error control: four decades of tolerance gain three of error."""
    scene = chain(count)
    reference = pp.simulate(scene, method="taylor", tolerance=1e-18)
    found = {peer.name: peer for peer in peers(scene)}
    assert set(found) == {*ORDERS, *CONTROLLED}
    for name, order in ORDERS.items():
        coarse, fine = (error(found[name].run(step), reference) for step in (1e-2, 5e-3))
        assert found[name].kind == "step"
        assert np.log2(coarse / fine) == pytest.approx(order, abs=0.2), name
    for name in CONTROLLED:
        coarse, fine = (error(found[name].run(tolerance), reference) for tolerance in (1e-6, 1e-10))
        assert found[name].kind == "tolerance"
        assert fine < 1e-3 * coarse, name


def test_counts_and_repeats():
    """A run is the same when it is made again, and counts: 20 intervals of 10 steps, four evaluations each."""
    for peer in peers(chain(1)):
        setting = 1e-2 if peer.kind == "step" else 1e-6
        first, again = peer.run(setting), peer.run(setting)
        np.testing.assert_array_equal(first.q, again.q)
        assert (first.steps, first.evaluations) == (again.steps, again.evaluations)
        assert first.evaluations > 0
        assert first.seconds > 0
        if peer.name == "mujoco rk4":
            assert (first.steps, first.evaluations) == (200, 800)
        if peer.name == "drake rk5 fixed":  # no slivers left by rounding
            assert (first.steps, first.evaluations) == (200, 1400)


# --- the same scene -------------------------------------------------------------------------------------------------


def agree(scene, within):
    """Every peer, to what a first-order method reaches with steps of 0.5 ms."""
    reference = pp.simulate(scene, method="dop853", tolerance=1e-13)
    for peer in peers(scene):
        assert error(peer.run(5e-4 if peer.kind == "step" else 1e-8), reference) < within, peer.name


def test_the_built_in_urdf():
    agree(builtin_scene().model_copy(update={"duration": 1.0}), 5e-3)


@pytest.mark.parametrize("root", ["base", "world"])
def test_a_tree_by_joint_names(tmp_path, root, caplog):
    """Joints are matched by name: a wrong order would be off by 0.6 at the start. Damping and limits do not act."""
    agree(tree(tmp_path, root), 5e-3)
    assert not caplog.records  # nor does a library complain of the text


def test_thin_rods_point_masses_and_any_gravity():
    """Radius 0, massless rods with a payload, and gravity that is the sum of two effects and not along z."""
    pull = (pp.effects.Gravity(direction=(1, 0, -1)), pp.effects.Gravity(acceleration=2.0, direction=(0, 1, 0)))
    start = pp.Start(positions={"theta_1": 0.4, "phi_2": 0.2})
    agree(chain(2, 0.5, radius=0.0, start=start, effects=pull), 5e-3)
    agree(chain(2, 0.5, radius=0.0, mass=0.0, payload=1.0, start=start), 5e-3)
    agree(chain(2, 0.5, start=start, effects=()), 5e-3)


def test_a_duration_of_zero():
    for peer in peers(chain(1, 0.0, 1)):
        run = peer.run(1e-3)
        np.testing.assert_array_equal(run.q, [[0.7, 0.4]])


# --- what ends early, and what is refused ---------------------------------------------------------------------------


def test_a_run_that_blows_up_is_a_failure(tmp_path, monkeypatch):
    """Steps far too long: MuJoCo would reset the state and note it in a file, Drake's fixed steps would go on with NaN."""
    monkeypatch.chdir(tmp_path)
    scene = chain(5, 20.0, 41, pp.Start(velocities={"theta_1": 20.0, "phi_2": 30.0}), length=0.2, radius=0.01)
    for peer in peers(scene):
        if peer.kind == "step":
            with pytest.raises(pp.RunError, match="it got to") as caught:
                peer.run(0.1)
            run = caught.value.partial
            assert "\n" not in str(caught.value)
            assert len(run.t) == len(run.q) < 41
            assert np.isfinite(run.q).all()
    assert not list(tmp_path.iterdir())


def test_a_run_stops_when_its_time_is_up():
    for peer in peers(chain(1)):
        with pytest.raises(pp.RunError) as caught:
            peer.run(1e-6, limit=0.0)
        assert str(caught.value) == "took over 0 s; it got to 0 s", peer.name
        np.testing.assert_array_equal(caught.value.partial.q, [[0.7, 0.4]])


def test_long_chains_are_compared_without_pinocchio():
    """200 rods are too many for its memory; the others have pendpin's accelerations, else this would be refused."""
    assert {peer.name for peer in peers(chain(200))} == {name for name in {*ORDERS, *CONTROLLED} if "scipy" not in name}


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (chain(1, effects=(*GRAVITY, pp.effects.Viscous(coefficient=0.1))), "effects[1]: viscous: other simulators"),
        (chain(1, inertia=(1.0, 1.0, 5.0)), "model: mujoco does not load it"),
        (chain(1, length=1e-3, mass=1e-6, radius=1e-6), "model: mujoco makes another model of it"),
    ],
    ids=["effect", "impossible", "tiny"],
)
def test_refused(scene, reason):
    with pytest.raises(pp.InputError) as caught:
        peers(scene)
    assert str(caught.value).startswith(reason)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("setting", [0.0, -1.0, np.nan, np.inf])
def test_refused_settings(setting):
    for peer in peers(chain(1)):
        with pytest.raises(pp.InputError, match=f"{peer.name}: {peer.kind} .* is not a positive number"):
            peer.run(setting)


def test_missing_libraries_are_named(monkeypatch):
    """What is installed is compared; what is missing is named with the command that brings it."""
    monkeypatch.setattr(
        pendpin.verification.simulators, "find_spec", lambda module: None if module == "pydrake" else module
    )
    assert {peer.name.split()[0] for peer in peers(chain(1))} == {"mujoco", "scipy"}
    with pytest.raises(pp.MissingLibrary, match="drake is not installed: pip install"):
        hard(peers=True)


# --- what verification/simulators.py says of Drake ------------------------------------------------------------------


def test_drake_keeps_the_derivative_of_a_rejected_step():
    """To notice when Drake corrects it: whether results are cached changes them, once a step has been rejected."""
    from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig

    from pendpin.verification.simulators import drake_plant, set_drake

    task = pendpin.verification.simulators.task_of(chain(3))
    plant = drake_plant(task)

    def end(caching):
        simulator = Simulator(plant)
        ApplySimulatorConfig(
            SimulatorConfig(integration_scheme="runge_kutta5", use_error_control=True, accuracy=1e-9), simulator
        )
        context, integrator = simulator.get_mutable_context(), simulator.get_mutable_integrator()
        set_drake(plant, context, task, task.q, task.v)
        if not caching:
            context.DisableCaching()
        integrator.request_initial_step_size_target(0.1)
        simulator.AdvanceTo(0.2)
        assert integrator.get_num_step_shrinkages_from_error_control() > 0
        return plant.GetPositions(context)

    assert np.abs(end(caching=True) - end(caching=False)).max() > 1e-9
