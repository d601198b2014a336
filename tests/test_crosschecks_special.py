"""Routes agree on states in which components vanish: what is left of those is rounding, and no alarm."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.dynamics.dynamics import bind
from pendpin.model.build import build
from pendpin.motions.crosschecks.crosscheck import CheckReport, compare, crosscheck_run
from test_crosschecks import RODS

G = 9.80665  # m/s²
AXES = [tuple(sign * row) for row in np.eye(3) for sign in (1.0, -1.0)]
directions = st.sampled_from([*AXES, (1.0, 1.0, 0.0), (-0.0, -1.0, 1.0), (1.0, -1.0, 1.0)])
angles = st.sampled_from([0.0, -0.0, np.pi / 2, -np.pi / 2, np.pi, -np.pi, 1e-300, np.pi / 4, 0.3])  # rad
rates = st.sampled_from([0.0, -0.0, 1.0, -1.0, 1e-300, 1e-160, -1e-155, 1e-8, 100.0])  # rad/s
quarter_turns = st.sampled_from([x.as_matrix() for x in Rotation.create_group("O")])
any_turns = st.tuples(*[st.floats(-3, 3)] * 3).map(lambda x: Rotation.from_rotvec(x).as_matrix())
turns = st.one_of(quarter_turns, any_turns)


def compared(scene: pp.Scene, q: list[float], v: list[float]) -> CheckReport:
    """All routes at one state, and in 50 digits."""
    return compare(bind(scene), np.array([q]), np.array([v]), {}, in_50_digits=1)


@law(40)
@given(st.sampled_from(sorted(RODS)), st.integers(1, 3), directions, st.data())
def test_routes_agree_where_components_of_chains_vanish(
    name: str, count: int, down: tuple, data: st.DataObject
) -> None:
    """Chains at rest, with one joint moving, at right angles, with rates whose squares underflow; gravity along any axis."""
    model = pp.Chain(rods=(RODS[name],) * count)
    scene = pp.Scene(model=model, effects=[fx.Gravity(acceleration=G, direction=down)])
    n = 2 * count
    q, v = (data.draw(st.lists(numbers, min_size=n, max_size=n)) for numbers in (angles, rates))
    if name == "thin":  # at its poles theta moves nothing
        q[1::2] = [phi if abs(np.cos(phi)) > 1e-6 else 1.0 for phi in q[1::2]]
    report = compared(scene, q, v)
    assert report.ok, report.fault


def rod_on(base: np.ndarray, rods: pp.Chain) -> pin.Model:
    """The same rods, hung on a base that is turned by a matrix (3, 3)."""
    model = pin.Model(build(rods).pin)
    first = model.jointPlacements[1]
    model.jointPlacements[1] = pin.SE3(base @ first.rotation, first.translation)
    return model


@law(40)
@given(st.sampled_from(sorted(RODS)), turns, st.integers(0, 2), st.sampled_from([1.0, -1.0]), st.data())
def test_gravity_along_an_axis_of_a_turned_joint(name: str, base, axis: int, sign: float, data: st.DataObject) -> None:
    """One component of gravity is left in the joint's frame; the others are 0 but for the rounding of the turn."""
    rods = pp.Chain(rods=(RODS[name],) * data.draw(st.integers(1, 2)))
    down = fx.Gravity(acceleration=G, direction=tuple(sign * base[:, axis]))
    scene = pp.Scene(model=rod_on(base, rods), effects=(down,))
    n = 2 * rods.count
    v = data.draw(st.lists(rates, min_size=n, max_size=n))
    report = compared(scene, [0.0] * n, v)
    assert report.ok, report.fault


def condition(model: pin.Model, q: np.ndarray) -> float:
    """The condition of the mass matrix."""
    M = np.triu(pin.crba(model, model.createData(), q))
    return float(np.linalg.cond(M + np.triu(M, 1).T))


joint = st.tuples(st.sampled_from(["P", "R", "R"]), st.integers(0, 2), quarter_turns)


@law(40)
@given(st.lists(joint, min_size=1, max_size=5), directions, st.data())
def test_routes_agree_on_trees_of_axes_in_any_order(joints: list, down: tuple, data: st.DataObject) -> None:
    """Joints about and along x, y and z in any order, branches, centres of mass on axes: most components vanish."""
    model, branch = pin.Model(), [0]  # a joint hangs on one of the branch before it
    for number, (kind, axis, turn) in enumerate(joints):
        parent = data.draw(st.sampled_from(branch))
        branch = [*branch[: branch.index(parent) + 1], number + 1]
        place = pin.SE3(turn, np.array(data.draw(st.sampled_from([(0.0, 0.0, 0.0), *AXES]))))
        model.addJoint(parent, getattr(pin, f"JointModel{kind}{'XYZ'[axis]}")(), place, f"joint_{number}")
        centre = np.array(data.draw(st.sampled_from(AXES))) / 2
        model.appendBodyToJoint(number + 1, pin.Inertia(1.0, centre, np.diag([0.2, 0.3, 0.4])), pin.SE3.Identity())
    n = len(joints)
    q, v = (data.draw(st.lists(numbers, min_size=n, max_size=n)) for numbers in (angles, rates))
    assume(
        all(condition(model, np.array(at)) < 1e6 for at in (q, np.sin(1.0 + np.arange(n))))
    )  # two joints of one motion
    report = compared(pp.Scene(model=model, effects=(fx.Gravity(acceleration=G, direction=down),)), q, v)
    assert report.ok, report.fault


@pytest.mark.parametrize("force", [1e-300, 1.0, 1e12])
def test_loads_that_cancel_count_with_their_size(force: float) -> None:
    """A pull along hanging rods is carried by the joints, and accelerates nothing: its rounding is no fault."""
    for axis in AXES:
        pull = fx.Push(link="rod_2", force=tuple(force * np.array(axis)))
        scene = pp.Scene(model=pp.Chain(rods=(RODS["thick"],) * 2), effects=(fx.Gravity(), pull))
        for q in ([0.0] * 4, [np.pi, 0.0, 0.0, 0.0], [np.pi / 2, 0.0, 0.0, 0.0], [0.0, np.pi / 2, 0.0, 1e-9]):
            report = compared(scene, q, [0.0] * 4)
            assert report.ok, report.fault


UNIVERSAL = """<robot name="universal"><link name="base"/><link name="cross"/>
<link name="rod"><inertial><origin xyz="0 0 -2"/><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0.04" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="theta" type="continuous"><parent link="base"/><child link="cross"/><origin rpy="{}"/>
<axis xyz="-1 0 0"/></joint>
<joint name="phi" type="continuous"><parent link="cross"/><child link="rod"/><axis xyz="0 -1 0"/></joint></robot>"""


TILTED = pin.rpy.matrixToRpy(pin.exp3(np.pi / 2 * np.array([2**-0.5, -(2**-0.5), 0.0])))


@pytest.mark.parametrize("roll_pitch_yaw", [(np.pi / 2, 0.0, 0.0), (0.0, np.pi / 2, 0.0), tuple(TILTED)])
def test_a_run_from_a_published_start_without_pull_along_the_rod(roll_pitch_yaw: tuple, tmp_path: Path) -> None:
    """ADAMS' three starts of a universal joint: at rest, the joint turned by 90 degrees, gravity normal to the rod."""
    (tmp_path / "rod.urdf").write_text(UNIVERSAL.format(" ".join(map(str, roll_pitch_yaw))))
    scene = pp.Scene(duration=1, model=pp.UrdfModel(path=tmp_path / "rod.urdf"), effects=(fx.Gravity(acceleration=G),))
    report = crosscheck_run(pp.simulate(scene))
    assert report is not None
    assert report.ok, report.fault


def test_samples_at_a_pole_of_a_thin_rod_are_left_out() -> None:
    """Three thin rods that start with two of them at their poles, where the mass matrix is singular."""
    start = pp.Start(positions=(0.0, 0.0, 0.0, np.pi / 2, np.pi / 2, 0.1))
    scene = pp.Scene(duration=0.5, model=pp.Chain(rods=(RODS["thin"],) * 3), effects=(fx.Gravity(),), start=start)
    report = crosscheck_run(pp.simulate(scene))
    assert report is not None
    assert report.ok, report.fault
    assert crosscheck_run(pp.simulate(scene, duration=0.0)) is None
