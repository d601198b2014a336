"""Names and short forms that people try first: taken, or answered with what would be right."""

import os
from pathlib import Path

import pytest

import pendpin as pp
from bad_input import run_main
from pendpin import effects as fx
from pendpin.ground.files import folder_of
from pendpin.scene.models import robot_file, robot_files
from pendpin.scene.toml import example_names

ROD = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0),))
URDF = Path(__file__).parents[1] / "urdf" / "universal_rod.urdf"


def damping(t: float, q, v):
    """A torque against the motion."""
    return -2.0 * v


SHORT = {
    "a robot's name": ({"model": "ur5"}, {"model": pp.UrdfModel(name="ur5")}),
    "a path": ({"model": URDF}, {"model": pp.UrdfModel(path=URDF)}),
    "a path as text": ({"model": str(URDF)}, {"model": pp.UrdfModel(path=URDF)}),
    "a kind": ({"model": ROD, "effects": ["gravity"]}, {"model": ROD, "effects": (fx.Gravity(),)}),
    "a function": ({"model": ROD, "effects": [damping]}, {"model": ROD, "effects": (fx.Torque(damping),)}),
}


@pytest.mark.parametrize("name", SHORT)
def test_short_forms_are_the_records_they_stand_for(name: str) -> None:
    """A scene from either is the same."""
    short, full = SHORT[name]
    assert pp.Scene(**short) == pp.Scene(**full)


def test_a_robots_name_stands_for_a_model_in_a_file_too(tmp_path: Path) -> None:
    """A path is relative to the file of the scene."""
    (tmp_path / "rod.urdf").write_text(URDF.read_text())
    for given, model in (("ur5", pp.UrdfModel(name="ur5")), ("rod.urdf", pp.UrdfModel(path=tmp_path / "rod.urdf"))):
        (tmp_path / "scene.toml").write_text(f'model = "{given}"\neffects = ["gravity"]\n')
        assert pp.load_scene(tmp_path / "scene.toml") == pp.Scene(model=model, effects=(fx.Gravity(),))


def test_a_class_in_place_of_an_effect_is_named() -> None:
    """What is missing are the brackets."""
    with pytest.raises(pp.InputError, match=r"effects\[0\]: Gravity is a class: write Gravity\(\.\.\.\)"):
        pp.Scene(model=ROD, effects=[fx.Gravity])


@pytest.mark.parametrize(
    ("tried", "meant"), [("load_urdf", "UrdfModel"), ("simulat", "simulate"), ("Gravity", "effects.Gravity")]
)
def test_names_of_other_packages_lead_to_ours(tried: str, meant: str) -> None:
    """An attribute that is not there names the one that is meant."""
    with pytest.raises(AttributeError, match=f"has no attribute '{tried}'; did you mean '{meant}'"):
        getattr(pp, tried)


def test_the_folder_of_a_robot_is_its_name(capsys: pytest.CaptureFixture) -> None:
    """panda_description is panda; what is unknown leads to the list, a command prints it."""
    assert robot_file("panda_description") == robot_file("panda")
    with pytest.raises(pp.InputError, match=r"did you mean 'panda'\?; `pendpin urdf --list` lists all"):
        robot_file("pandda")
    assert run_main("urdf", "--list") == 0
    assert capsys.readouterr().out.split() == list(robot_files())
    assert run_main("urdf") == 2


@pytest.mark.parametrize("name", example_names())
def test_an_example_works_in_the_folder_where_it_is_printed(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    """It names no path elsewhere; a file that it reads is put beside it, and one of that name stays as it is."""
    monkeypatch.chdir(tmp_path)
    assert run_main("new", name) == 0
    text = capsys.readouterr().out
    Path("my.toml").write_text(text)
    assert os.fspath(Path(pp.__file__).parents[1]) not in text
    scene, example = pp.load_scene("my.toml"), pp.load_scene(folder_of("examples") / f"{name}.toml")
    assert pp.bind(scene).model.joints == pp.bind(example).model.joints
    for mine, given in zip(scene.effects, example.effects, strict=True):
        files = {"csv"} if getattr(given, "csv", None) else set()
        assert mine.model_dump(exclude=files) == given.model_dump(exclude=files)
    for file in set(tmp_path.iterdir()) - {tmp_path / "my.toml"}:
        file.write_text("mine")
        assert run_main("new", name) == 0
        assert file.read_text() == "mine"
        assert "is there already" in capsys.readouterr().err


def test_an_examples_name_in_place_of_a_file_leads_to_new(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture
) -> None:
    """From the command line and from Python; a file of that name is read."""
    monkeypatch.chdir(tmp_path)
    assert run_main("run", "crane") == 1
    assert "`pendpin new crane > crane.toml`" in capfd.readouterr().err
    with pytest.raises(pp.InputError, match="pendpin new crane"):
        pp.load_scene("crane")
    Path("crane").write_text('model = "ur5"\n')
    assert pp.load_scene("crane").model == pp.UrdfModel(name="ur5")


def test_save_as_a_table_names_to_csv(tmp_path: Path) -> None:
    """The error line says which method writes it."""
    run = pp.simulate(pp.Scene(model=ROD, effects=["gravity"], duration=0.1))
    with pytest.raises(pp.InputError, match=r"to_csv\('.*run\.csv'\) writes this run as a table"):
        run.save(tmp_path / "run.csv")
