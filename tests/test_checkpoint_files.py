"""Checkpoints as files: those that are refused, and the command that saves and continues."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pendpin as pp
from bad_input import ROD as URDF
from bad_input import SCENE, URDF_SCENE, run_main
from pendpin.runs import integration
from pendpin.runs.checkpoint import FORMAT
from run_files import Trap
from test_checkpoint import assert_same, scene

# --- files that are refused -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> dict[str, np.ndarray]:
    """The arrays of a checkpoint of `scene()`."""
    path = tmp_path_factory.mktemp("saved") / "run.ckpt"
    pp.simulate(scene(), checkpoint=path)
    with np.load(path) as file:
        return dict(file)


def with_meta(saved: dict[str, np.ndarray], change: Any) -> np.ndarray:
    """The meta of a checkpoint with something changed in what it says of the run."""
    meta = json.loads(str(saved["meta"]))
    change(meta["run"])
    return np.array(json.dumps(meta))


NOT = "not a checkpoint that pendpin saved (delete it or name another file): "
OTHER = "the checkpoint of another run: "
CHANGED: dict[str, tuple[Any, str]] = {
    "objects": (lambda s: {"samples": np.array([Trap()], dtype=object)}, f"{NOT}array 'samples' holds no plain"),
    "no samples": (lambda s: {"samples": None}, f"{NOT}array 'samples' is missing"),
    "samples of no shape": (lambda s: {"samples": np.float64(1)}, f"{NOT}0 samples, where 1 to 61 are wanted"),
    "too many samples": (lambda s: {"samples": np.zeros((62, 8))}, f"{NOT}62 samples, where 1 to 61 are wanted"),
    "narrow samples": (lambda s: {"samples": s["samples"][:, 1:]}, f"{NOT}array 'samples' is float64 (61, 7), not"),
    "nan": (lambda s: {"samples": s["samples"] * np.nan}, f"{NOT}array 'samples' holds NaN"),
    "no state": (lambda s: {"last.y": None}, f"{NOT}array 'last.y' is missing"),
    "short state": (lambda s: {"last.y": s["last.y"][1:]}, f"{NOT}array 'last.y' is float64 (7,), not"),
    "infinite state": (lambda s: {"last.y": s["last.y"] + np.inf}, f"{NOT}array 'last.y' holds NaN or"),
    "whole numbers": (lambda s: {"last.most": np.array(3)}, f"{NOT}array 'last.most' is int64 (), not"),
    "half a step": (lambda s: {"counts": s["counts"] + 0.5}, f"{NOT}array 'counts' holds no counts"),
    "steps below 0": (lambda s: {"counts": -s["counts"]}, f"{NOT}array 'counts' holds no counts"),
    "meta not JSON": (lambda s: {"meta": np.array("{")}, f"{NOT}Expecting property name"),
    "meta of something else": (lambda s: {"meta": np.array('{"format": 1}')}, f"{NOT}it is something else, or of"),
    "meta of nothing": (lambda s: {"meta": np.array(json.dumps({"checkpoint": FORMAT}))}, f"{OTHER}run is None in it"),
    "another tolerance": (
        lambda s: {"meta": with_meta(s, lambda run: run["scene"]["solver"].update(tolerance=1e-6))},
        f"{OTHER}scene.solver.tolerance is 1e-06 in it, 1e-10 here; delete it or name another file",
    ),
    "another scene": (
        lambda s: {"meta": with_meta(s, lambda run: run["scene"]["effects"].append({}))},
        f"{OTHER}scene.effects is [",
    ),
    "a longer rod": (
        lambda s: {"meta": with_meta(s, lambda run: run["scene"]["model"]["rods"][1].update(length=2.0))},
        f"{OTHER}scene.model.rods[1].length is 2.0 in it, 0.7 here; delete it or name another file",
    ),
    "with an energy balance": (
        lambda s: {"meta": with_meta(s, lambda run: run.update(energy_balance=True))},
        f"{OTHER}energy_balance is True in it, False here; delete it or name another file",
    ),
    "an older NumPy": (
        lambda s: {"meta": with_meta(s, lambda run: run["versions"].update(numpy="1.0"))},
        f"{OTHER}versions.numpy is '1.0' in it, {np.__version__!r} here; delete it or name another file",
    ),
    "an older pendpin": (
        lambda s: {"meta": with_meta(s, lambda run: run["versions"].update(pendpin="0.0"))},
        f"{OTHER}versions.pendpin is '0.0' in it, {pp.__version__!r} here; delete it or name another file",
    ),
}
BYTES: dict[str, tuple[Any, str]] = {
    "empty": (lambda data: b"", f"{NOT}File is not a zip file"),
    "text": (lambda data: b"samples\n", f"{NOT}File is not a zip file"),
    "truncated": (lambda data: data[: len(data) // 2], f"{NOT}File is not a zip file"),
    "a byte changed": (lambda data: data[:900] + bytes([data[900] ^ 1]) + data[901:], f"{NOT}Bad CRC-32"),
}


def assert_refused(path: Path, says: str) -> None:
    """In one line with the file's name, and the file is left as it is."""
    before = path.read_bytes()
    with pytest.raises(pp.InputError) as caught:
        pp.simulate(scene(), checkpoint=path)
    assert str(caught.value).startswith(f"{path}: {says}")
    assert str(caught.value).isprintable()
    assert path.read_bytes() == before


@pytest.mark.parametrize(("change", "says"), CHANGED.values(), ids=CHANGED)
def test_what_is_no_part_of_this_run_is_refused(change: Any, says: str, saved: dict, tmp_path: Path) -> None:
    """Arrays that are missing, or of another kind, shape or run."""
    path = tmp_path / "run.npz"
    np.savez(path, **{name: array for name, array in (saved | change(saved)).items() if array is not None})
    assert_refused(path, says)


@pytest.mark.parametrize(("change", "says"), BYTES.values(), ids=BYTES)
def test_a_damaged_file_is_refused(change: Any, says: str, saved: dict, tmp_path: Path) -> None:
    """Whatever happened to its bytes."""
    path = tmp_path / "run.npz"
    np.savez(path, **saved)
    path.write_bytes(change(path.read_bytes()))
    assert_refused(path, says)


def test_what_counts_is_what_a_named_file_holds(tmp_path: Path) -> None:
    """A URDF that was moved is the same scene; one that was changed is another."""
    one, other, path = tmp_path / "one.urdf", tmp_path / "other.urdf", tmp_path / "run.ckpt"
    one.write_text(URDF)
    run = pp.simulate(pp.Scene(model=pp.UrdfModel(path=one), duration=0.1), checkpoint=path)
    one.rename(other)
    again = pp.simulate(pp.Scene(model=pp.UrdfModel(path=other), duration=0.1), checkpoint=path)
    assert np.array_equal(again.q, run.q)
    other.write_text(URDF.replace('value="1.0"', 'value="1.1"'))
    with pytest.raises(pp.InputError, match=r"another run: scene.model.path is 'sha256 \w+' in it, 'sha256"):
        pp.simulate(pp.Scene(model=pp.UrdfModel(path=other), duration=0.1), checkpoint=path)


@pytest.mark.parametrize("every", [-1.0, float("nan")])
def test_nonsense_is_refused(every: float, tmp_path: Path) -> None:
    """Before anything is done."""
    with pytest.raises(pp.InputError, match=r"every: .* is not a number of seconds, 0 or above"):
        pp.simulate(scene(), checkpoint=tmp_path / "run.ckpt", every=every)
    with pytest.raises(pp.InputError, match="checkpoint: an accuracy"):
        pp.simulate(scene(), checkpoint=tmp_path / "run.ckpt", accuracy=1e-3)
    assert not os.listdir(tmp_path)


# --- the command ----------------------------------------------------------------------------------------------------

COMMAND = ("run", "scene.toml", "--checkpoint", "run.ckpt")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where a command runs: with a scene and a URDF."""
    monkeypatch.chdir(tmp_path)
    Path("scene.toml").write_text(SCENE.replace("duration = 0.1", "duration = 40.0"))
    Path("urdf.toml").write_text(URDF_SCENE)
    Path("rod.urdf").write_text(URDF)
    return tmp_path


def test_the_command_goes_on_and_cleans_up(folder: Path, capfd: pytest.CaptureFixture) -> None:
    """Halted, the file stays and the closing line names it; done, it is gone and the run is the unbroken one."""
    assert run_main("run", "scene.toml", "--out", "whole.npz") == 0
    assert run_main(*COMMAND, "--limit", "0") == 1
    assert capfd.readouterr().err.endswith("; run.ckpt holds the run so far; the same command resumes it\n")
    assert len(pp.Trajectory.load("run.npz").t) < 2401
    assert run_main(*COMMAND) == 0
    assert not Path("run.ckpt").exists()
    assert_same(pp.Trajectory.load("run.npz"), pp.Trajectory.load("whole.npz"))


REFUSED = {
    "the run's own file": (("scene.toml", "--checkpoint", "run.npz"), "run.npz: this name is given twice"),
    "the scene": (("scene.toml", "--checkpoint", "scene.toml"), "scene.toml: this name is given twice"),
    "the URDF": (("urdf.toml", "--checkpoint", "rod.urdf"), "rod.urdf: this name is given twice"),
    "no folder": (("scene.toml", "--checkpoint", "a/b"), "a/b: cannot be written: there is no folder 'a'"),
    "a target": (
        ("scene.toml", "--checkpoint", "c", "--accuracy", "1e-3"),
        "checkpoint: an accuracy",
    ),
}


@pytest.mark.parametrize(("arguments", "says"), REFUSED.values(), ids=REFUSED)
def test_the_command_refuses(arguments: tuple, says: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    """In one line, before the work."""
    before = sorted(os.listdir())
    assert run_main("run", *arguments) == 1
    (line,) = capfd.readouterr().err.splitlines()
    assert says in line
    assert sorted(os.listdir()) == before


@pytest.mark.slow  # at random moments on the clock
def test_kill_9(folder: Path) -> None:
    """Processes killed by the system at random moments after their first save; the last one ends as one alone does."""
    Path("scene.toml").write_text(
        SCENE.replace("duration = 0.1", "duration = 600.0").replace("1e-8", "1e-12\nsamples = 3001")
    )
    command = [sys.executable, "-c", "from pendpin.cli import main; main()", *COMMAND, "--every", "0.05"]
    environment = os.environ | {"PYTHONPATH": str(Path(pp.__file__).parents[1])}
    random, kills = np.random.default_rng(), 0
    for longest in (0.02, 0.3, 0.3):
        before = os.stat("run.ckpt").st_mtime_ns if Path("run.ckpt").exists() else 0
        with subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL) as process:
            while process.poll() is None:
                if Path("run.ckpt").exists() and os.stat("run.ckpt").st_mtime_ns != before:
                    time.sleep(random.uniform(0, longest))
                    process.kill()
                    break
                time.sleep(0.002)
        kills += process.returncode != 0
        if process.returncode == 0:
            break
    assert kills > 0
    if process.returncode:
        assert subprocess.run(command, env=environment, stdout=subprocess.DEVNULL, check=False).returncode == 0
    assert not Path("run.ckpt").exists()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(integration, "EVALUATIONS", 20_000)
        patch.setattr(integration, "LEAST_EVALUATIONS", 2_000)
        assert run_main("run", "scene.toml", "--out", "whole.npz") == 0
    assert_same(pp.Trajectory.load("run.npz"), pp.Trajectory.load("whole.npz"))
