"""Real robots: what Pinocchio loads is what is computed; joints that are locked, mimic others or move nothing."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from bad_input import ROD, URDF_SCENE, edited, run_main
from pendpin.dynamics.acting import acting
from pendpin.ground.arrays import EPS
from pendpin.model.build import Model, build
from pendpin.scene import models as named
from robots import compare, robot, robot_files
from rounding import ROUNDINGS, terms

GRAVITY = (pp.effects.Gravity(),)
# a cause each: continuous joints, mimic, inertia off the triangle and negative ones, massless fingers, m v x v
FEW = ("anymal-kinova", "panda", "allegro_left_hand", "tiago_no_hand", "romeo", "bolt", "double_pendulum_continuous")
TREE = """<robot name="tree">
  <link name="base"/>
  <joint name="a" type="revolute">
    <parent link="base"/><child link="one"/><origin xyz="0.1 -0.2 0.3" rpy="0.3 {pitch!r} -0.7"/><axis xyz="1 2 -1"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/>
  </joint>
  <link name="one">{inertial}</link>
  <joint name="b" type="{kind}">
    <parent link="one"/><child link="two"/><origin xyz="0.4 0.5 -0.6" rpy="1 {pitch!r} 0.2"/><axis xyz="-0.3 1 0.2"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/>{tied}
  </joint>
  <link name="two">{inertial}</link>
  <joint name="c" type="continuous">
    <parent link="two"/><child link="three"/><origin xyz="-0.3 0.2 0.1" rpy="-1 0.4 0.3"/><axis xyz="0 0 5"/>
  </joint>
  <link name="three">{inertial}</link>
</robot>
"""
INERTIAL = """<inertial><origin xyz="0.1 0.2 -0.3" rpy="0.1 0.2 0.3"/><mass value="1.5"/>
  <inertia ixx="0.2" ixy="0.01" ixz="-0.02" iyy="0.3" iyz="0.03" izz="0.25"/></inertial>"""


def tree(folder: Path, kind: str = "revolute", tied: str = "", pitch: float = 0.5, **options) -> Model:
    """Three joints in a row, the second of which is locked in most tests."""
    path = folder / "tree.urdf"
    path.write_text(TREE.format(kind=kind, tied=tied, pitch=pitch, inertial=INERTIAL))
    return build(pp.UrdfModel(path=path, **options))


def test_an_axis_has_the_length_of_one(tmp_path: Path) -> None:
    """Whatever a file says of its length; one that has it, but for rounding, is the one of the file to the last bit."""
    path, draw = tmp_path / "axes.urdf", np.random.default_rng(0)
    for size in (1.0, *draw.uniform(1e-3, 1e3, 20), 1e-300, 1e300):
        written = draw.normal(size=3)
        written *= size / np.linalg.norm(written)
        text = " ".join(map(repr, written.tolist()))
        path.write_text(TREE.format(kind="revolute", tied="", pitch=0.5, inertial=INERTIAL).replace("1 2 -1", text))
        (axis, *_) = build(pp.UrdfModel(path=path)).tree.axes
        np.testing.assert_allclose(axis, written / size, rtol=0 if size == 1 else 1e-15)
        assert np.linalg.norm(axis) == pytest.approx(1, abs=1e-15)


# --- 66 robots ------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_every_robot_is_taken() -> None:
    """All 66 well-formed files with a moving joint, with findings for those that no real body can be behind."""
    models = {path: build(pp.UrdfModel(path=path)) for path in robot_files()}
    assert len(models) == 66
    odd = {path.stem for path, model in models.items() if model.findings}
    assert {"allegro_left_hand", "romeo_small", "pr2", "hyq_no_sensors", "go1", "icub", "tiago", "bolt"} <= odd
    assert not [finding for model in models.values() for finding in model.findings if "did you mean" in finding]
    assert not {"ur5_robot", "talos_reduced", "panda", "double_pendulum", "solo12"} & odd


@pytest.mark.parametrize("name", FEW)
def test_what_pinocchio_loads_is_what_is_computed(name: str) -> None:
    """ABA on the file as Pinocchio reads it, RNEA's wrenches at all joints, the recursion: within rounding."""
    assert max(compare(robot(name), states=3)[1:]) < ROUNDINGS


@pytest.mark.slow
@pytest.mark.parametrize("path", robot_files(), ids=lambda path: path.stem)
def test_what_pinocchio_loads_is_what_is_computed_on_all(path: Path) -> None:
    """The same on every robot, with 50 digits beside it; and the routes of `pendpin check` agree."""
    assert max(compare(path, states=10, digits=True)[1:]) < ROUNDINGS
    report = pp.crosscheck(pp.Scene(model=pp.UrdfModel(path=path), effects=GRAVITY), states=50)
    assert report.ok, report.fault


@pytest.mark.parametrize("name", FEW)
def test_every_kind_of_robot_runs(name: str) -> None:
    """A tenth of a second under gravity, and the energy stays."""
    model = pp.UrdfModel(path=robot(name))
    start = pp.Start(positions=[0.2] * len(build(model).joints))
    scene = pp.Scene(duration=0.1, model=model, start=start, effects=GRAVITY, solver=pp.Solver(samples=3))
    assert pp.simulate(scene).energy().drift < 1e-7


# --- locked joints --------------------------------------------------------------------------------------------------


angle = st.floats(-4, 4)


@given(
    kind=st.sampled_from(["revolute", "continuous", "prismatic"]), at=angle, state=st.tuples(angle, angle, angle, angle)
)
@pytest.mark.parametrize("pitch", [0.5, np.pi / 2], ids=["any", "gimbal lock"])
def test_a_locked_joint_is_one_that_is_held(
    pitch: float, kind: str, at: float, state: tuple, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """The others accelerate as in the whole model with the torque at that joint that keeps it still."""
    folder = tmp_path_factory.getbasetemp()
    whole, locked = tree(folder, kind, pitch=pitch).pin, tree(folder, kind, pitch=pitch, lock={"b": at}).pin
    assert whole is not None
    assert locked is not None
    assert list(locked.names)[1:] == ["a", "c"]
    for model in (whole, locked):
        model.gravity.linear = np.array([0, 0, -9.81])
    others, q, v = [0, 2], np.array(state[:2]), np.array(state[2:])
    q_whole, v_whole, data = np.array([q[0], at, q[1]]), np.array([v[0], 0.0, v[1]]), whole.createData()
    M = pin.crba(whole, data, q_whole)[np.ix_(others, others)]
    M = np.triu(M) + np.triu(M, 1).T
    held = np.linalg.solve(M, -pin.nonLinearEffects(whole, data, q_whole, v_whole)[others])
    found = pin.aba(locked, locked.createData(), q, v, np.zeros(2))
    # the condition of M is at most 1e3 here, and the origin goes by way of three angles
    bound = 3 * ROUNDINGS * EPS * (1 + abs(at)) * terms(locked, q, v, found).acceleration
    assert np.all(np.abs(found - held) < bound + np.linalg.cond(M) * 20 * EPS * np.abs(held).max())


def test_what_is_fixed_says_to_what_and_a_lock_of_many_turns_is_noted(tmp_path: Path) -> None:
    """An effect on a link that a lock has fixed names the link that moves it; 30 may be degrees, of a slide it is not."""
    locked = tree(tmp_path, lock={"b": 30.0})
    assert locked.notes == ("model.lock: 'b': 30 rad is more than a whole turn; locks have no degrees",)
    for link, said in (("two", "is fixed to 'one': name that link"), ("base", "does not move")):
        with pytest.raises(pp.InputError, match=f"effects.0.: link '{link}' {said}"):
            acting(locked, [pp.effects.Push(link=link)])  # of no strength
    assert not tree(tmp_path, "prismatic", lock={"b": 30.0}).notes


def test_locked_at_zero_nothing_is_rounded(tmp_path: Path) -> None:
    """The placements are those that Pinocchio itself gives the joint at 0, to the last bit."""
    whole, locked = tree(tmp_path).pin, tree(tmp_path, lock={"b": 0.0}).pin
    assert whole is not None
    assert locked is not None
    expected = whole.jointPlacements[2] * whole.jointPlacements[3]
    assert locked.jointPlacements[2] == expected


MIMIC = '<mimic joint="{}" multiplier="{}" offset="{}"/>'


@pytest.mark.parametrize(
    ("options", "joints", "at"),
    [
        ({}, ("a", "b", "c"), None),
        ({"mimic": "free"}, ("a", "b", "c"), None),
        ({"mimic": "locked"}, ("a", "c"), 0.25),
        ({"mimic": "locked", "lock": {"a": 0.5}}, ("c",), 0.25 - 2 * 0.5),
        ({"mimic": "locked", "lock": {"b": 1.5}}, ("a", "c"), 1.5),
        ({"mimic": "free", "lock": {"b": 1.5}}, ("a", "c"), 1.5),
    ],
)
def test_mimic_joints_are_free_or_locked(options: dict, joints: tuple, at: float | None, tmp_path: Path) -> None:
    """Locked where the joint that they follow is locked, or at its 0; what is locked by name comes first."""
    model = tree(tmp_path, tied=MIMIC.format("a", -2, 0.25), **options)
    assert model.joints == joints
    explicit = "b" in options.get("lock", {})
    assert len(model.notes) == (0 if explicit else 1)
    if at is not None:
        same = tree(tmp_path, lock={"b": at} | options.get("lock", {}))
        assert model.pin is not None
        assert same.pin is not None
        assert list(model.pin.jointPlacements) == list(same.pin.jointPlacements)
    if at is not None and not explicit:
        assert model.notes[0].endswith(f"is locked at {at:g}")


REFUSED = {
    "unknown": ("lock = { elbow = 1 }", "model.lock: joint 'elbow' is not one of: theta, phi"),
    "fixed": ("lock = { mount = 1 }", "model.lock: joint 'mount' is not one of: theta, phi"),
    "all": ("lock = { theta = 0, phi = 0.1 }", "no joint of it can move"),
    "far": ("lock = { theta = 1e12 }", "model.lock.theta: 1000000000000.0 is above 1000000000"),
    "nan": ("lock = { theta = nan }", "model.lock.theta: "),
    "text": ('lock = { theta = "1" }', "model.lock.theta: "),
    "a list": ("lock = [0.1]", "model.lock: "),
    "mimic": ('mimic = "loose"', "model.mimic: 'loose' is not one of: free, locked"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_locks_that_make_no_sense_are_refused(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture
) -> None:
    """In one line with the key's path, exit status 1."""
    given, says = REFUSED[name]
    monkeypatch.chdir(tmp_path)
    Path("rod.urdf").write_text(ROD)
    Path("scene.toml").write_text(edited(URDF_SCENE, ('path = "rod.urdf"', f'path = "rod.urdf", {given}')))
    assert run_main("run", "scene.toml") == 1
    (line,) = capfd.readouterr().err.splitlines()
    assert says in line


def test_two_joints_that_mimic_each_other_cannot_be_locked(tmp_path: Path) -> None:
    """Free they are all the same."""
    path = tmp_path / "rod.urdf"
    both = [('<axis xyz="-1 0 0"/>', MIMIC.format("phi", 1, 0)), ('<axis xyz="0 -1 0"/>', MIMIC.format("theta", 1, 0))]
    path.write_text(edited(ROD, *((axis, axis + mimic) for axis, mimic in both)))
    (note,) = (note for note in build(pp.UrdfModel(path=path)).notes if "mimics" in note)
    assert "'theta' mimics 'phi', 'phi' mimics 'theta' in the file" in note
    with pytest.raises(pp.InputError, match="joint 'theta': its mimics form a circle: 'theta', 'phi', 'theta'"):
        build(pp.UrdfModel(path=path, mimic="locked"))


def test_locks_on_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture
) -> None:
    """--lock and --mimic stand in for those of the scene, and go with --urdf; for a chain they make no sense."""
    monkeypatch.chdir(tmp_path)
    Path("rod.urdf").write_text(ROD)
    Path("scene.toml").write_text(edited(URDF_SCENE, ("start.positions = [0.7, 0.4]", "start.positions = [0.7]")))
    assert run_main("run", "scene.toml", "--lock", "phi=0.5", "--out", "one.npz") == 0
    assert pp.Trajectory.load("one.npz").joints == ("theta",)
    assert run_main("run", "--urdf", "rod.urdf", "--lock", "theta=1", "--mimic", "locked", "--out", "two.npz") == 0
    assert pp.Trajectory.load("two.npz").joints == ("phi",)
    assert run_main("check", "--urdf", "rod.urdf", "--lock", "theta=1", "--states", "5") == 0
    capfd.readouterr()
    for arguments, says in (
        (("run", "scene.toml", "--lock", "phi"), "'phi' is not NAME=POSITION, such as elbow=0.5"),
        (("check", "--urdf", "rod.urdf", "--mimic", "x"), "mimic: 'x' is not one of: free, locked"),
        (("run", "scene.toml", "--urdf", "rod.urdf"), "give a scene or a URDF, not both"),
    ):
        assert run_main(*arguments) == 2
        assert says in capfd.readouterr().err


# --- joints without inertia -----------------------------------------------------------------------------------------


def test_joints_that_move_massless_links_are_locked_with_a_finding(tmp_path: Path) -> None:
    """What hangs there moves nothing else: the rest accelerates as without it."""
    path, finger = (
        tmp_path / "rod.urdf",
        '<link name="finger"/><joint name="finger" type="continuous">{}</joint></robot>',
    )
    path.write_text(edited(ROD, ("</robot>", finger.format('<parent link="tip"/><child link="finger"/>'))))
    model = build(pp.UrdfModel(path=path))
    assert model.joints == ("theta", "phi")
    says = (
        "joint 'finger' can move massless links only: its motion is undefined and moves nothing else; it is locked at 0"
    )
    assert model.findings == (says,)
    assert build(pp.UrdfModel(path=path, lock={"finger": 1.0})).findings == ()
    (tmp_path / "bare.urdf").write_text(ROD)
    bare = build(pp.UrdfModel(path=tmp_path / "bare.urdf"))
    assert model.pin is not None
    assert bare.pin is not None
    assert list(model.pin.inertias) == list(bare.pin.inertias)


def test_a_start_without_inertia_is_refused(tmp_path: Path) -> None:
    """iCub's neck at its zero: three axes, and a head that is a point above them."""
    scene = pp.Scene(duration=0.1, model=pp.UrdfModel(path=robot("icub")), effects=GRAVITY)
    with pytest.raises(pp.InputError, match=r"start\.positions: singular mass matrix: joint 'neck_\w+'.*or lock it"):
        pp.simulate(scene)
    model = pp.UrdfModel(path=robot("icub"), lock={"neck_roll": 0.0})
    assert pp.simulate(scene.model_copy(update={"model": model})).energy().drift < 1e-7


@pytest.mark.parametrize(
    ("right", "slip", "where"),
    [
        ("<axis ", "<axsi ", "joint 'b': 'axsi' is not an element of <joint>"),
        ("<origin ", "<orgin ", "link 'two': 'orgin' is not an element of <inertial>"),
        ('lower="', 'lowr="', "joint 'b': 'lowr' is not an attribute of <limit>"),
    ],
)
def test_a_slip_in_a_name_is_a_finding(right: str, slip: str, where: str, tmp_path: Path) -> None:
    """Names that are far from those of URDF, or beside the right one, are extensions."""
    assert not tree(tmp_path, tied='<gearing K="1"/>').findings
    text = (tmp_path / "tree.urdf").read_text().replace(' velocity="', ' gear_velocity="2" upper_="3" velocity="')
    path = tmp_path / "slip.urdf"
    path.write_text(text.replace(right, slip))
    findings = build(pp.UrdfModel(path=path)).findings
    known = "".join(filter(str.isalpha, right))
    assert f"{where}; did you mean '{known}'?" in findings


@pytest.mark.parametrize("scale", [1.0, 1e-12])
def test_an_extension_beside_a_mass_says_nothing(scale: float, tmp_path: Path) -> None:
    """Its words are read as no number, where a unit of mass is chosen too."""
    inertia = "".join(f' {name}="{scale * value:g}"' for name, value in (("ixx", 0.1), ("iyy", 0.1), ("izz", 0.01)))
    inertial = f'<mass value="{scale:g}"/><inertia{inertia} ixy="0" ixz="0" iyz="0"/>'
    joint = '<joint name="j" type="continuous"><parent link="base"/><child link="arm"/></joint>'
    masses = []
    for name, extension in (("plain", ""), ("own", '<density value="unknown"/>')):
        path = tmp_path / f"{name}.urdf"
        link = f'<link name="arm"><inertial>{extension}{inertial}</inertial></link>'
        path.write_text(f'<robot name="r"><link name="base"/>{link}{joint}</robot>')
        masses.append(build(pp.UrdfModel(path=path)).pin.inertias[1].mass)
    assert masses[0] == masses[1] > 0


def test_every_robot_is_found_by_its_name() -> None:
    """Each URDF of example-robot-data by one name at least."""
    assert {"ur5", "panda", "talos_reduced", "double_pendulum", "anymal_b"} <= named.robot_files().keys()
    assert pp.UrdfModel("ur5").file.name == "ur5_robot.urdf"


def test_a_robot_is_not_written_as_a_urdf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd) -> None:
    """`pendpin urdf` writes chains; the line for a robot's name says which command takes it."""
    monkeypatch.chdir(tmp_path)
    assert run_main("urdf", "ur5") == 1
    assert capfd.readouterr().err.endswith("pendpin run --urdf ur5 runs it\n")
