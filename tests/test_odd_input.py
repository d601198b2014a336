"""Odd but legal: what looks strange and is right works, to the last file, without a word on stderr."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import pendpin
from bad_input import ROD, SCENE, URDF_SCENE, Case, contents, edited, run_main
from laws import HANG
from odd_input import CASES, NAMED_CASES
from pendpin import Scene, Trajectory, simulate
from pendpin.errors import Note
from pendpin.model.build import build
from pendpin.scene import UrdfModel, builtin_scene

SLIPS = ("large angle", "no effects", "the least", "inverted")  # what is probably a slip


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to run in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("case", CASES, ids=str)
def test_odd_input_runs(case: Case, folder: Path, capfd: pytest.CaptureFixture) -> None:
    """Each case runs without an error, and what is saved can be read: finite numbers in the shapes they should have."""
    case.lay_out(folder)
    status = run_main(*case.arguments)
    said = capfd.readouterr().err.splitlines()
    assert status == 0
    assert all(line.startswith(("pendpin: note: ", "pendpin: finding: ")) for line in said)
    assert bool(said) == any(word in str(case) for word in SLIPS)
    assert Trajectory.load("run.npz").a.shape[1] == 2


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=[pytest.mark.slow] * bool(i % 4)) for i, case in enumerate(NAMED_CASES)], ids=str
)
def test_odd_names_are_drawn(case: Case, folder: Path, capfd: pytest.CaptureFixture) -> None:
    """Names of joints that mean something to matplotlib, rich, HTML or the terminal."""
    case.lay_out(folder)
    before = set(contents(folder))
    status = run_main(*case.arguments, "--plot", "run.png", "--html", "run.html")
    assert (status, capfd.readouterr().err) == (0, "")
    assert set(contents(folder)) - before == {"run.npz", "run.png", "run.html"}


def test_markup_in_the_name_of_an_output(folder: Path, capfd: pytest.CaptureFixture) -> None:
    """The table shows names of files letter by letter."""
    (folder / "scene.toml").write_text(SCENE)
    (folder / "a[").mkdir()
    assert run_main("run", "scene.toml", "--out", "a[/red].npz") == 0
    assert "a[/red].npz" in capfd.readouterr().out


def test_link_as_output_stays_a_link(folder: Path) -> None:
    """What a symbolic link points to is written."""
    (folder / "scene.toml").write_text(SCENE)
    (folder / "link.npz").symlink_to("real.npz")
    assert run_main("run", "scene.toml", "--out", "link.npz") == 0
    assert (folder / "link.npz").is_symlink()
    assert (folder / "real.npz").is_file()


MASS, INERTIA, AXIS = '<mass value="1.0"/>', 'ixx="0.0834"', '<axis xyz="0 -1 0"/>'
VISUAL = '<cylinder radius="0.01" length="1.0"/>'
IMPLAUSIBLE = {
    "negative": (INERTIA, 'ixx="-0.0834"', "principal inertia -0.0834, 0.0002 and 0.0834 kg m², -0.0834 is negative"),
    "indefinite": ('ixy="0"', 'ixy="0.1"', "principal inertia -0.0166, 0.0002 and 0.1834 kg m², -0.0166 is negative"),
    "off the triangle": (
        'izz="0.0002"',
        'izz="0.3"',
        "principal inertia 0.0834, 0.0834 and 0.3 kg m², 0.3 > 0.0834 + 0.0834",
    ),
    "off by far": ('izz="0.0002"', 'izz="1e99"', "principal inertia 0.0834, 0.0834 and 1e+99 kg m²"),
    "massless": (MASS, '<mass value="0"/>', "principal inertia 0.0002, 0.0834 and 0.0834 kg m² with a mass of 0"),
}
NOTED = {
    "mimic": (
        AXIS,
        f'{AXIS}<mimic joint="theta"/>',
        "joint 'phi' mimics 'theta' in the file",
    ),
    "mimic of a stranger": (
        AXIS,
        f'{AXIS}<mimic joint="x"/>',
        "joint 'phi' mimics 'x' (no joint) in the file",
    ),
    "missing mesh": (
        VISUAL,
        '<mesh filename="package://a/b.stl"/>',
        "mesh 'package://a/b.stl' is not found",
    ),
    "endless mesh name": (VISUAL, f'<mesh filename="{"m" * 9000}"/>', "mesh 'mmm"),
}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * bool(place % 3)) for place, name in enumerate(IMPLAUSIBLE)],
    ids="urdf: {}".format,
)
def test_implausible_inertia_is_a_finding(name: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    """Link, numbers, and what follows, in one line; the run goes on; --strict refuses it with the same words."""
    old, new, says = IMPLAUSIBLE[name]
    (folder / "rod.urdf").write_text(edited(ROD, (old, new)))
    (folder / "scene.toml").write_text(URDF_SCENE)
    assert run_main("run", "scene.toml", "--html", "run.html", "--plot", "run.png") == 0
    (line,) = capfd.readouterr().err.splitlines()
    first, _, others = line.partition("; 1 more finding")
    assert first.startswith(f"pendpin: finding: link 'rod': {says}")
    assert first.endswith("no real body has this inertia; accelerations are computed as written")
    for command in (("run", "scene.toml"), ("check", "--urdf", "rod.urdf")):
        assert run_main(*command, "--strict") == 1
        (refused,) = capfd.readouterr().err.splitlines()
        more = " (the first of 2 findings)" * bool(others)
        assert refused.endswith(f"{first.removeprefix('pendpin: finding: ')}{more}; --strict refuses this")


@pytest.mark.parametrize(
    "command", [("effects",), ("cost", "--methods", "rk45", "--accuracy", "1e-4", "--budget", "0")]
)
def test_other_commands_print_findings_too(
    command: tuple[str, ...], folder: Path, capfd: pytest.CaptureFixture
) -> None:
    """What is odd in a model is said by every command that computes with it."""
    old, new, says = IMPLAUSIBLE["negative"]
    (folder / "rod.urdf").write_text(edited(ROD, (old, new)))
    (folder / "scene.toml").write_text(URDF_SCENE)
    assert run_main(command[0], "scene.toml", *command[1:]) == 0
    line, *_ = capfd.readouterr().err.splitlines()
    assert line.startswith(f"pendpin: finding: link 'rod': {says}")


@pytest.mark.parametrize("name", NOTED, ids="urdf: {}".format)
def test_what_a_urdf_says_and_pendpin_leaves_out_is_noted(
    name: str, folder: Path, capfd: pytest.CaptureFixture
) -> None:
    """In one line; the run goes on and is drawn, and --strict takes it."""
    old, new, says = NOTED[name]
    (folder / "rod.urdf").write_text(edited(ROD, (old, new)))
    (folder / "scene.toml").write_text(URDF_SCENE)
    assert run_main("run", "scene.toml", "--html", "run.html", "--strict") == 0
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith(f"pendpin: note: {says}")


def test_impossible_inertia_is_taken_with_a_finding(folder: Path, capfd: pytest.CaptureFixture) -> None:
    """A scene's own inertia may be that of no real body: the equations hold, and the user gets a finding."""
    (folder / "scene.toml").write_text(edited(SCENE, ("radius = 0.01", "inertia = [0.3, 0.2, 0.05]")))
    assert run_main("run", "scene.toml") == 0
    assert capfd.readouterr().err.startswith("pendpin: finding: model.rods[0].inertia: no real body has this inertia")


def test_damping_is_noted(folder: Path, capfd: pytest.CaptureFixture) -> None:
    """A note names what a URDF says and pendpin leaves out."""
    (folder / "scene.toml").write_text(URDF_SCENE)
    (folder / "rod.urdf").write_text(edited(ROD, ("</joint>", '<dynamics damping="0.5" friction="0"/></joint>')))
    assert run_main("run", "scene.toml") == 0
    said = "<dynamics damping> of 'theta': ignored; the effect as_written (--as-written, effects.AsWritten()) lets them act"
    assert capfd.readouterr().err == f"pendpin: note: {said}\n"


def test_default_axis_is_x(folder: Path) -> None:
    """A joint without <axis> turns about x, as URDF has it."""
    placed = {}
    for name, axis in {"none": "", "x": '<axis xyz="1 0 0"/>'}.items():
        path = folder / f"{name}.urdf"
        path.write_text(edited(ROD, ('<axis xyz="-1 0 0"/>', axis), ('<axis xyz="0 -1 0"/>', '<axis xyz="0 1 0"/>')))
        model = build(UrdfModel(path=path)).pin
        assert model is not None
        placed[name] = str(model.joints[1])
    assert placed["none"] == placed["x"]


def test_numbers_reach_pinocchio_to_the_last_digit(folder: Path) -> None:
    """What was written is what is computed with."""
    (folder / "rod.urdf").write_text(
        edited(ROD, ('"0 0 -0.5"', '"0.1 5e-324 -0.3333333333333333"'), ('value="1.0"', 'value="1e-7"'))
    )
    model = build(UrdfModel(path=folder / "rod.urdf")).pin
    assert model is not None
    inertia = model.inertias[2]
    assert inertia.mass == 1e-7
    assert np.array_equal(inertia.lever, [0.1, 5e-324, -0.3333333333333333])


@pytest.mark.parametrize("variables", [{"LC_ALL": "C", "PYTHONIOENCODING": "ascii"}, {"TERM": "dumb", "COLUMNS": "3"}])
def test_poor_surroundings(variables: dict[str, str], folder: Path) -> None:
    """No home, no display, a terminal of letters only: the run is made and the table printed."""
    (folder / "scène 角.toml").write_text(SCENE)
    surroundings = {k: v for k, v in os.environ.items() if k not in {"HOME", "DISPLAY"}} | variables
    surroundings["PYTHONPATH"] = str(Path(pendpin.__file__).parents[1])
    command = [
        sys.executable,
        "-c",
        "from pendpin.cli import main; main()",
        "run",
        "scène 角.toml",
        "--out",
        "角.npz",
    ]
    done = subprocess.run(command, env=surroundings, capture_output=True, timeout=HANG, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    assert (folder / "角.npz").is_file()


@pytest.mark.parametrize("in_notebook", [False, True])
def test_a_note_has_the_place_of_the_call(in_notebook: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """As Python's warnings do; in a notebook it has none, because cells are not files."""
    monkeypatch.delitem(sys.modules, "ipykernel", raising=False)
    if in_notebook:
        monkeypatch.setitem(sys.modules, "ipykernel", sys)
    with pytest.warns(Note) as said:
        simulate(Scene(model=builtin_scene().model, duration=0.01), samples=2)
    assert {note.filename for note in said} == {"pendpin" if in_notebook else __file__}
