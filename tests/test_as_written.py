"""A URDF taken at its word: what it writes of its joints acts where it is asked for, and one note says so where not."""

import warnings
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest

import pendpin as pp
from bad_input import ROD, run_main
from pendpin import effects as fx
from pendpin.errors import Note
from pendpin.graphics.report import run_report
from pendpin.graphics.run_drawing import drawing_of
from pendpin.model.bodies import pinocchio
from pendpin.model.notes import leaving

GRAVITY = fx.Gravity()
ROBOTS = ("panda", "ur5", "talos_reduced", "solo12", "allegro_right_hand")
LIMIT = '<limit lower="-3.2" upper="3.2" effort="1000" velocity="1000"/>'


def rod_with(folder: Path, theta: str = "", limit: str = LIMIT) -> Path:
    """The rod of two joints with something more written at theta, and its limits."""
    path = folder / "rod.urdf"
    first, found, rest = ROD.partition("</joint>")
    before, tag, after = first.partition("<limit")
    assert found
    assert tag
    path.write_text(f"{before}{limit}{after.partition('/>')[2]}{theta}{found}{rest}")
    return path


def scene_of(path: Path, *effects: fx.Effect, **fields) -> pp.Scene:
    """A swing of the rod of a file."""
    start = fields.pop("start", pp.Start(positions={"theta": 0.7, "phi": 0.4}, velocities={"theta": 1.3}))
    return pp.Scene(model=pp.UrdfModel(path=path), start=start, effects=(GRAVITY, *effects), duration=3.0, **fields)


def notes_of(scene: pp.Scene) -> tuple[pp.Trajectory, list[str]]:
    """A run and the notes that it gives."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = pp.simulate(scene, energy_balance=True)
    return run, [str(one.message) for one in caught if issubclass(one.category, Note)]


@pytest.mark.parametrize(
    ("written", "limit", "listed"),
    [
        ('<dynamics damping="0.2"/>', LIMIT, [fx.Viscous(coefficient=0.2, joints=("theta",))]),
        ('<dynamics friction="0.3"/>', LIMIT, [fx.DryFriction(kinetic=0.3, joints=("theta",))]),
        ("", '<limit lower="-0.5" upper="0.9" effort="1" velocity="1"/>', []),
    ],
    ids=["damping", "friction", "limits"],
)
def test_as_written_is_what_it_stands_for(written: str, limit: str, listed: list, tmp_path: Path) -> None:
    """The run is that of the effects written out, to the last bit, with the works of their kinds."""
    path = rod_with(tmp_path, written, limit)
    bounds = (-0.5, 0.9) if "-0.5" in limit else (-3.2, 3.2)
    stop = fx.Stop(lower=bounds[0], upper=bounds[1], joints=("theta",))
    short = pp.simulate(scene_of(path, fx.AsWritten()), energy_balance=True)
    long = pp.simulate(scene_of(path, *listed, stop), energy_balance=True)
    assert np.array_equal(short.q, long.q)
    assert {kind: list(work) for kind, work in short.work.items()} == {k: list(w) for k, w in long.work.items()}
    assert pp.Trajectory.load(short.save(tmp_path / "run.npz")) == short
    assert short.imbalance < 1e-8  # the tolerance of the run is 1e-10, over a few swings


def test_each_part_can_be_left_out(tmp_path: Path) -> None:
    """Without damping, friction and limits nothing of the file acts, and the run is that under gravity alone."""
    path = rod_with(tmp_path, '<dynamics damping="0.2" friction="0.3"/>')
    none = fx.AsWritten(damping=False, friction=False, limits=False)
    assert np.array_equal(pp.simulate(scene_of(path, none)).q, pp.simulate(scene_of(path)).q)
    damped = pp.simulate(scene_of(path, fx.AsWritten(friction=False, limits=False)), energy_balance=True)
    assert set(damped.work) == {"gravity", "viscous"}
    assert damped.work["viscous"][-1] < 0


@pytest.mark.parametrize("parts", list(product([False, True], repeat=3)))
def test_the_page_says_what_acts(tmp_path: Path, parts: tuple[bool, bool, bool]) -> None:
    """The parts that are listed and that the file writes, with how many joints have them; nothing where none is listed."""
    path = rod_with(tmp_path, '<dynamics damping="0.2" friction="0.3"/>')
    damping, friction, limits = parts
    listed = fx.AsWritten(damping=damping, friction=friction, limits=limits)
    one, bare = (pp.simulate(scene_of(path, *more), duration=0.01, samples=2) for more in ((listed,), ()))
    rows, none = (dict(run_report(run, "").tables[0].rows) for run in (one, bare))
    words = ("damping of 1 joint", "dry friction of 1 joint", "stops of 1 joint")
    said = [text for text, acts in zip(words, parts, strict=True) if acts]
    assert rows["as written"] == (", ".join(said) or "nothing: the file writes none")
    assert "as written" not in none


def test_one_note_says_what_is_ignored(tmp_path: Path) -> None:
    """It names what does not act, and nothing once it acts."""
    path = rod_with(tmp_path, '<dynamics damping="0.2" friction="0.3"/>')
    _, (note,) = notes_of(scene_of(path))
    assert note.startswith("<dynamics damping> of 'theta', <dynamics friction> of 'theta', <limit> of 'theta': ")
    _, (note,) = notes_of(scene_of(path, fx.AsWritten(friction=False)))
    assert note.startswith("<dynamics friction> of 'theta': ignored")
    assert notes_of(scene_of(path, fx.AsWritten()))[1] == []


def test_a_joint_whose_limits_leave_out_0_begins_at_the_nearer_one(tmp_path: Path) -> None:
    """Unless the start says where: beyond a limit that is refused, as with a stop."""
    path = rod_with(tmp_path, limit='<limit lower="0.3" upper="2" effort="1" velocity="1"/>')
    scene = scene_of(path, fx.AsWritten(), start=pp.Start(positions={"phi": 0.1}))
    run, notes = notes_of(scene)
    assert (run.q[0] == [0.3, 0.1]).all()
    assert notes == ["limits leave out 0, so joints without a start begin at the nearer one: theta at 0.3"]
    assert (run["theta"] >= 0.3).all()
    with pytest.raises(pp.InputError, match=r"start\.positions\.theta: 0 is beyond its stop at 0\.3"):
        pp.simulate(scene.replace(start=pp.Start(positions={"theta": 0.0})))
    assert pp.simulate(scene.replace(effects=(GRAVITY,))).q[0, 0] == 0  # nothing of the limits acts there


def test_a_chain_has_nothing_written() -> None:
    """It is refused in one line, from Python."""
    scene = pp.Scene(model=pp.Chain(rods=(pp.Rod(length=1, mass=1),)), effects=(GRAVITY, fx.AsWritten()))
    with pytest.raises(pp.InputError, match=r"effects\[1\]: as_written is for a URDF"):
        pp.simulate(scene)


def test_on_the_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture) -> None:
    """--as-written adds the effect; the table says what of the file acts; for a chain it is a wrong usage."""
    monkeypatch.chdir(tmp_path)
    path = rod_with(tmp_path, '<dynamics damping="0.2"/>')
    assert run_main("run", "--urdf", str(path), "--as-written", "--duration", "0.5") == 0
    printed = capfd.readouterr()
    assert printed.err == ""
    assert "damping of 1 joint, stops of 1 joint" in printed.out
    assert [effect["kind"] for effect in pp.Trajectory.load("run.npz").scene["effects"]] == ["gravity", "as_written"]
    Path("chain.toml").write_text('duration = 1.0\nmodel = { kind = "chain", rods = [{ length = 1.0, mass = 1.0 }] }\n')
    assert run_main("run", "chain.toml", "--as-written") == 2
    assert run_main("run", "--as-written") == 2


def test_every_command_that_takes_a_urdf_takes_it_as_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture
) -> None:
    """As if the scene listed the effect: nothing written is ignored, and tables name it."""
    monkeypatch.chdir(tmp_path)
    path = rod_with(tmp_path, '<dynamics damping="0.2"/>')
    commands = {
        "check": ["--states", "10"],
        "modes": [],
        "stability": [],
        "effects": [],
        "sweep": ["--vary", "start.positions.theta=0.1,0.2"],
        "cost": ["--methods", "dop853", "--budget", "0.1"],
    }
    for command, options in commands.items():
        assert run_main(command, "--urdf", str(path), "--as-written", *options) == 0
        assert "ignored" not in capfd.readouterr().err
    assert run_main("effects", "--urdf", str(path), "--as-written", "--json") == 0
    assert '"as_written"' in capfd.readouterr().out


SLIDE = """<robot name="slides"><link name="base"/>
<link name="arm"><inertial><origin xyz="0 0 -0.3"/><mass value="2"/>
  <inertia ixx="0.06" iyy="0.06" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="car"><inertial><origin xyz="0.1 0.1 0"/><mass value="2"/>
  <inertia ixx="0.06" iyy="0.06" izz="0.06" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="pin" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="1 0 0"/></joint>
<joint name="lift" type="prismatic"><parent link="arm"/><child link="car"/><axis xyz="{axis}"/>
  <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


@pytest.mark.parametrize("axis", ["0 0 1", "0 1 0"])
def test_a_slide_that_falls_without_end_is_named(tmp_path: Path, axis: str) -> None:
    """A slide that gravity moves at once, or as the arm turns; stops do not act in small motions."""
    file = tmp_path / "slide.urdf"
    file.write_text(SLIDE.format(axis=axis))
    for effects, ask in product(((GRAVITY,), (GRAVITY, fx.AsWritten())), (pp.modes, pp.linearize, pp.Start.at_rest)):
        with pytest.raises(pp.InputError, match=r"no equilibrium: lift slides away; lock it or give it a spring$"):
            ask(pp.Scene(model=pp.UrdfModel(str(file)), effects=effects))


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * ("talos" in name)) for name in ROBOTS])
def test_robots_as_written(name: str) -> None:
    """Two notes at most, energy that closes, and joints that stay within their limits."""
    scene = pp.Scene(model=pp.UrdfModel(name), duration=1.0, effects=(GRAVITY,))
    for effects in ((GRAVITY,), (GRAVITY, fx.AsWritten())):
        run, notes = notes_of(scene.replace(effects=effects))
        assert len(notes) <= 2
        # a few hundred steps, each to a tolerance of 1e-10 of the state; an impact adds its own rounding
        assert run.imbalance < 1e-7
    contacts = pp.bind(scene.replace(effects=(GRAVITY, fx.AsWritten()))).contacts
    assert contacts is not None
    assert (run.q >= contacts.lower).all()
    assert (run.q <= contacts.upper).all()


def test_two_joints_at_their_stops_that_kick_each_other_come_to_rest() -> None:
    """panda's second joint and a finger, both on their stops: bounces below 1e-12 rad end, and the run goes on."""
    scene = pp.Scene(model=pp.UrdfModel("panda"), duration=1.2, effects=(GRAVITY, fx.AsWritten()))
    run = pp.simulate(scene, energy_balance=True)
    assert run.imbalance < 1e-7
    assert len(run.events) < 200  # there were tens of thousands before t = 0.94 s
    assert all(before.t <= after.t for before, after in pairwise(run.events))


@pytest.mark.slow
def test_a_hand_that_settles_on_its_stops_does_not_shake_an_arm_with_friction() -> None:
    """tiago: 21 joints of a hand land while friction holds the arm. Two methods agree, in a few hundred events.

    After 0.2 s they were at 0.073 s, with thousands of events that were 1e-12 s apart. The bound is the looser tolerance
    times the number of events.
    """
    scene = pp.Scene(model=pp.UrdfModel("tiago"), duration=0.2, effects=(GRAVITY, fx.AsWritten()))
    settings = (("dop853", 1e-10), ("rk45", 1e-9))
    one, other = (pp.simulate(scene, method=m, tolerance=tol, energy_balance=True) for m, tol in settings)
    assert max(one.imbalance, other.imbalance) < 1e-9
    assert 100 < len(one.events) < 1000
    assert np.abs(one.tips - other.tips).max() < 1e-9


def test_what_leaves_is_not_followed_by_the_camera() -> None:
    """A finger that nothing holds slides 60 m: the drawing is as large as the robot at its start; a stop keeps it there."""
    scene = pp.Scene(model=pp.UrdfModel("panda"), duration=3.0, effects=(GRAVITY,))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Note)
        free, held = pp.simulate(scene), pp.simulate(scene.replace(effects=(GRAVITY, fx.AsWritten())))
    assert [drawing_of(run).leaves for run in (free, held)] == [True, False]
    assert np.abs(free["panda_finger_joint1"]).max() > 10 * drawing_of(free).extent
    assert drawing_of(free).extent == np.linalg.norm(free.tips[0], axis=-1).max()
    said = leaving(free)
    assert said[-1].endswith(" m, as no stop holds it; with --as-written its limits act")
    assert leaving(held) == ()


def test_many_findings_are_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture
) -> None:
    """The hand has four; with the note on what is ignored there are two lines before the table."""
    monkeypatch.chdir(tmp_path)
    assert run_main("run", "--urdf", "allegro_right_hand", "--duration", "0.1") == 0
    finding, note = capfd.readouterr().err.splitlines()
    assert finding.endswith("; 3 more findings in bind(scene).model.findings")
    assert "ignored" in note


def test_a_pin_model_is_taken_at_its_word(tmp_path: Path) -> None:
    """Its damping, friction and limits are those of the file that it was read from; a note says so where they do not act."""
    path = rod_with(tmp_path, '<dynamics damping="0.2" friction="0.3"/>', LIMIT.replace("3.2", "0.5"))
    start = pp.Start(positions={"theta": 0.4}, velocities={"theta": 1.3})
    of_file = scene_of(path, fx.AsWritten(), start=start)
    of_pin = of_file.replace(model=pinocchio().buildModelFromUrdf(str(path)))
    one, other = pp.simulate(of_file), pp.simulate(of_pin)
    assert np.array_equal(one.q, other.q)
    assert one.events
    assert one.events == other.events
    _, (note,) = notes_of(of_pin.replace(effects=(GRAVITY,)))
    assert note.startswith("<dynamics damping> of 'theta', <dynamics friction> of 'theta', <limit> of 'theta'")


def test_small_motions_as_written_have_its_damping_alone(tmp_path: Path) -> None:
    """Friction and stops act through events and are left out, as when they are listed; damping is that of viscous."""
    path = rod_with(tmp_path, '<dynamics damping="0.2" friction="0.3"/>')
    short, listed = scene_of(path, fx.AsWritten()), scene_of(path, fx.Viscous(coefficient=0.2, joints=("theta",)))
    assert np.array_equal(pp.modes(short).damping_ratio, pp.modes(listed).damping_ratio)
    assert "left out" in str(pp.modes(short))
    with pytest.raises(pp.InputError, match="dry_friction acts at events"):
        pp.lyapunov(short)
