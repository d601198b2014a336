"""Nonsense in effects: one line that names the place, exit status 1, nothing written."""

from pathlib import Path

import pytest

import pendpin as pp
from bad_input import SCENE, contents, run_main
from pendpin import effects as fx

TRACK = "t, x, y, z\n" + "".join(f"{i / 10}, 0, 0, {i * i / 100}\n" for i in range(11))

EFFECTS = {
    "no coefficient": ('"viscous"', "effects[1].coefficient: missing"),
    "negative viscosity": ('"viscous"\ncoefficient = -0.1', "effects[1].coefficient: -0.1 is below 0"),
    "infinite viscosity": ('"viscous"\ncoefficient = inf', "effects[1].coefficient: inf is not a finite number"),
    "unknown joint": (
        '"viscous"\ncoefficient = 1\njoints = ["knee"]',
        "effects[1]: joint 'knee' is not one of: theta, phi",
    ),
    "joint twice": ('"viscous"\ncoefficient = 1\njoints = ["phi", "phi"]', "effects[1].joints: 'phi' is named twice"),
    "joint by both names": (
        '"viscous"\ncoefficient = 1\njoints = ["phi", "phi_1"]',
        "effects[1]: a joint is named twice: 'phi', 'phi_1'",
    ),
    "no joints": (
        '"viscous"\ncoefficient = 1\njoints = []',
        "effects[1].joints: 0 values, where at least 1 are wanted",
    ),
    "joints as text": ('"viscous"\ncoefficient = 1\njoints = "phi"', "effects[1].joints: 'phi' is not a list"),
    "negative spring": ('"spring"\nstiffness = -1', "effects[1].stiffness: -1 is below 0"),
    "motor without joint": ('"motor"\ntorque = 1', "effects[1].joint: missing"),
    "motor on an unknown joint": (
        '"motor"\njoint = "elbow"\ntorque = 1',
        "effects[1]: joint 'elbow' is not one of: theta,",
    ),
    "idle motor": ('"motor"\njoint = "phi"', "effects[1]: a motor needs a torque, an amplitude and frequency, or"),
    "motor that does both": (
        '"motor"\njoint = "phi"\ntorque = 1\ntarget = 0.1',
        "effects[1]: torque and target",
    ),
    "motor without frequency": ('"motor"\njoint = "phi"\namplitude = 1', "amplitude and frequency go together"),
    "motor at rest": ('"motor"\njoint = "phi"\namplitude = 1\nfrequency = 0', "effects[1].frequency: 0 is not above 0"),
    "motor without gain": ('"motor"\njoint = "phi"\ntarget = 1', "effects[1]: a target needs a proportional gain"),
    "unstable motor": ('"motor"\njoint = "phi"\nproportional = -1', "effects[1].proportional: -1 is below 0"),
    "motor with a lost phase": (
        '"motor"\njoint = "phi"\ntorque = 1\nphase = 1',
        "effects[1]: a phase needs an amplitude",
    ),
    "push without link": ('"push"', "effects[1].link: missing"),
    "unknown link": ('"push"\nlink = "rod_9"', "effects[1]: link 'rod_9' is not one of: rod"),
    "nan push": ('"push"\nlink = "rod"\nforce = [0, nan, 0]', "effects[1].force[1]: nan is not a finite number"),
    "push of two numbers": ('"push"\nlink = "rod"\nforce = [0, 1]', "effects[1].force[2]: missing"),
    "push without frequency": ('"push"\nlink = "rod"\namplitude = [1, 0, 0]', "amplitude and frequency go together"),
    "nan wind": ('"drag"\nwind = [nan, 0, 0]', "effects[1].wind[0]: nan is not a finite number"),
    "negative density": ('"drag"\ndensity = -1', "effects[1].density: -1 is below 0"),
    "no diameter": ('"drag"\ndiameter = 0', "effects[1].diameter: 0 is not above 0"),
    "gust without frequency": ('"drag"\ngust = [1, 0, 0]', "effects[1]: gust and frequency go together"),
    "frequency without gust": ('"drag"\nfrequency = 1', "effects[1]: gust and frequency go together"),
    "buoyancy as number": ('"drag"\nbuoyancy = 1', "effects[1].buoyancy: 1"),
    "idle support": ('"support"', "effects[1]: a support needs an amplitude and a frequency, or a csv"),
    "support that does both": ('"support"\namplitude = [1, 0, 0]\ncsv = "track.csv"', "effects[1]: a support needs an"),
    "support without frequency": (
        '"support"\namplitude = [1, 0, 0]',
        "effects[1]: amplitude and frequency go together",
    ),
    "support with a lost phase": ('"support"\ncsv = "track.csv"\nphase = 1', "effects[1]: a phase needs an amplitude"),
    "support by no file": ('"support"\ncsv = "gone.csv"', "gone.csv: cannot be read: No such file or directory"),
    "support by a folder": ('"support"\ncsv = "."', ": cannot be read: it is a folder, not a file"),
    "support by a number": ('"support"\ncsv = 3', "effects[1].csv: 3 is not a path"),
    "no rotation": ('"rotation"', "effects[1]: a rotation needs a latitude, a rate or a csv, one of them"),
    "rotation twice": (
        '"rotation"\nlatitude = 4\nrate = [0, 0, 1]',
        "effects[1]: a rotation needs a latitude, a rate or a csv, one of them",
    ),
    "beyond the pole": ('"rotation"\nlatitude = 91', "effects[1].latitude: 91 is above 90"),
    "rate as number": ('"rotation"\nrate = 3', "effects[1].rate: 3 is not a list of 3 numbers"),
}

TRACKS = {
    "empty": ("", "0 rows, where at least 2 are wanted"),
    "one row": ("0, 0, 0, 0\n", "1 row, where at least 2 are wanted"),
    "text": (TRACK.replace("0.3, 0, 0", "0.3, none, 0"), "line 5: x: 'none' is not a number"),
    "decimal comma": (
        TRACK.replace("0.3, 0, 0", "0,3, 0, 0"),
        "line 5: 5 values instead of 4 between commas: t, x, y, z",
    ),
    "semicolons": (TRACK.replace(",", ";"), "line 1: 1 value instead of 4 between commas: t, x, y, z"),
    "other columns": (TRACK.replace("t, x, y, z", "t, z, y, x"), "line 1: the columns are t, z, y, x, where t, x"),
    "missing cell": (TRACK.replace("0.3, 0, 0", "0.3, 0, "), "line 5: y is missing"),
    "missing column": (
        TRACK.replace("0.3, 0, 0", "0.3, 0"),
        "line 5: 3 values instead of 4 between commas: t, x, y, z",
    ),
    "nan": (TRACK.replace("0.3, 0, 0", "0.3, 0, nan"), "line 5: y: 'nan' is not a finite number"),
    "beyond a double": (TRACK.replace("0.3, 0, 0", "0.3, 0, 1e400"), "line 5: y: '1e400' is not a finite number"),
    "times that go back": (TRACK.replace("0.3, 0, 0", "0.15, 0, 0"), "line 5: t = 0.15 does not come after 0.2"),
    "a time twice": (TRACK.replace("0.3, 0, 0", "0.2, 0, 0"), "line 5: t = 0.2 does not come after 0.2"),
    "a gap in time": (
        TRACK + "9, 0, 0, 0\n",
        "nothing between t = 1 and 9, where a row comes every 0.1 s",
    ),
    "starts late": ("0.01, 0, 0, 0\n1, 0, 0, 0\n", "its times, 0.01 to 1 s, do not cover the run, 0 to 0.1 s"),
    "ends early": ("0, 0, 0, 0\n0.09, 0, 0, 0\n", "its times, 0 to 0.09 s, do not cover the run, 0 to 0.1 s"),
    "huge": (TRACK.replace("0.3, 0, 0", "0.3, 0, 1e308"), "y: '1e308' is beyond 1e+150"),
    "binary": (bytes(range(256)), "not a CSV file: byte 128 is not UTF-8 text"),
    "a spreadsheet": (b"PK\x03\x04" + bytes(99), "line 1: 1 value instead of 4"),
}


def refused(tmp_path: Path, scene: str, capfd: pytest.CaptureFixture, monkeypatch: pytest.MonkeyPatch) -> str:
    """What `pendpin run` says of a scene: one line, and nothing is written."""
    (tmp_path / "scene.toml").write_text(scene)
    monkeypatch.chdir(tmp_path)
    before = contents(tmp_path)
    assert run_main("run", "scene.toml") == 1
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("pendpin: scene.toml: ")
    assert err.count("\n") == 1
    assert err[:-1].isprintable()
    assert contents(tmp_path) == before
    return err


@pytest.mark.parametrize(("effect", "says"), EFFECTS.values(), ids=EFFECTS)
def test_nonsense(tmp_path: Path, effect: str, says: str, capfd, monkeypatch) -> None:
    """A faulty effect after gravity."""
    (tmp_path / "track.csv").write_text(TRACK)
    assert says in refused(tmp_path, f"{SCENE}[[effects]]\nkind = {effect}\n", capfd, monkeypatch)


@pytest.mark.parametrize(("track", "says"), TRACKS.values(), ids=TRACKS)
def test_a_bad_file_of_positions(tmp_path: Path, track: str | bytes, says: str, capfd, monkeypatch) -> None:
    """A faulty CSV beside the scene."""
    (tmp_path / "track.csv").write_bytes(track.encode() if isinstance(track, str) else track)
    said = refused(tmp_path, f'{SCENE}[[effects]]\nkind = "support"\ncsv = "track.csv"\n', capfd, monkeypatch)
    assert "effects[1]: track.csv: " in said
    assert says in said


def test_a_file_of_positions_is_relative_to_the_scene(tmp_path: Path) -> None:
    """Wherever the command runs; spaces, comments and a byte order mark do no harm."""
    (tmp_path / "track.csv").write_text("\ufeff" + TRACK.replace("0.3,", "\n# half way\n 0.3 ,"))
    (tmp_path / "scene.toml").write_text(f'{SCENE}[[effects]]\nkind = "support"\ncsv = "track.csv"\n')
    scene = pp.load_scene(tmp_path / "scene.toml")
    assert pp.bind(scene).loads.field(0.05) == pytest.approx([0, 0, -9.81 - 2])
    again = pp.Scene(**scene.model_dump(mode="json"))
    assert pp.bind(again).loads.field(0.05) == pytest.approx([0, 0, -9.81 - 2])


def test_a_run_beyond_the_file_does_not_go_on(tmp_path: Path) -> None:
    """Where a copy of the scene lasts longer than its positions, the run is refused: a table ends with its file."""
    (tmp_path / "track.csv").write_text(TRACK)
    (tmp_path / "scene.toml").write_text(f'{SCENE}[[effects]]\nkind = "support"\ncsv = "track.csv"\n')
    scene = pp.load_scene(tmp_path / "scene.toml").model_copy(update={"duration": 3.0})
    for engine in ("pinocchio", "compiled"):
        with pytest.raises(pp.InputError, match=r"effects\[\d\]: "):
            pp.simulate(scene.with_solver(engine=engine))


@pytest.mark.parametrize("at", [1.0 + 1e-9, -1e-9])
def test_an_anchor_holds_a_point_of_its_rod(at: float) -> None:
    """A place beyond the ends is refused with the length of the rod; both ends are places."""
    held = fx.Anchor(link="rod", point=(0.0, 0.0, -1.0), stiffness=1.0, at=round(at))
    scene = pp.Scene(model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]), effects=[fx.Gravity(), held])
    pp.bind(scene)
    with pytest.raises(pp.InputError, match=r"effects\[1\].at: .* m is beyond the ends of rod, 0 to 1 m"):
        pp.bind(scene.replace({"effects[1].at": at}))


def test_a_torque_of_other_arguments_is_refused() -> None:
    """When it is made, with what it takes; what takes any number, or more that have values of their own, is taken."""
    with pytest.raises(pp.InputError, match=r"it is called as f\(t, q, v\), and takes \(t, q\)"):
        fx.Torque(lambda t, q: q)
    fx.Torque(lambda *given: given[1])
    fx.Torque(lambda t, q, v, gain=2.0: -gain * v)
