"""A killed run continues from its file and ends like the uninterrupted one, bit for bit."""

import json
import os
import subprocess
import sys
import time
from dataclasses import fields, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pendpin as pp
from bad_input import ROD as URDF
from bad_input import SCENE, URDF_SCENE, run_main
from bad_runs import Trap
from pendpin import effects as fx
from pendpin.errors import Interrupted
from pendpin.simulation import checkpoint, smooth_motion
from pendpin.simulation.loop import IntegrationLoop
from pendpin.simulation.motion_with_events import LoopWithEvents
from pendpin.simulation.smooth_motion import SmoothLoop
from scenes import scene_of

THICK = (pp.Rod(length=1.0, mass=1.0, radius=0.05), pp.Rod(length=0.7, mass=0.5, radius=0.03))
THIN = (pp.Rod(length=1.0, mass=1.0), pp.Rod(length=0.7, mass=0.5))
CONTACTS = (fx.DryFriction(kinetic=0.05, static=0.07), fx.Stop(lower=-0.8, upper=0.9, restitution=0.6))
needs_heyoka = pytest.mark.skipif(find_spec("heyoka") is None, reason="heyoka is not installed: pip install heyoka")

Setting = dict[str, Any]
METHODS: dict[str, tuple[pp.Scene, Setting]] = {}


def scene(rods=THICK, *effects: fx.Effect, duration=4.0, samples=61, engine="auto") -> pp.Scene:
    """Two rods under gravity and these effects."""
    given = {"q": (0.7, 0.4, -0.3, 0.2), "v": (1.3, -0.8, 0.2, 0.5), "samples": samples, "engine": engine}
    return scene_of(rods, fx.Gravity(), *effects, duration=duration, **given)


METHODS |= {m: (scene(), {"method": m, "tolerance": 1e-9}) for m in ("dop853", "rk45", "rk23", "radau", "bdf", "lsoda")}
METHODS |= {m: (scene(), {"method": m, "step": 0.01}) for m in ("rk4", "gauss2", "gauss4", "gauss6")}
METHODS |= {
    "euler": (scene(), {"method": "euler", "step": 0.002}),
    "taylor": (scene(duration=9.0), {"method": "taylor", "tolerance": 1e-18}),
    "taylor in directions": (scene(THIN, duration=12.0), {"method": "taylor", "tolerance": 1e-15}),
    "energy_balance": (scene(THICK, fx.Viscous(coefficient=0.1)), {"tolerance": 1e-9, "energy_balance": True}),
    "energy_balance of gauss6": (
        scene(THICK, fx.Viscous(coefficient=0.1)),
        {"method": "gauss6", "step": 0.02, "energy_balance": True},
    ),
    "driven": (scene(THICK, fx.Support(amplitude=(0.1, 0.0, 0.2), frequency=7.0)), {"tolerance": 1e-9}),
    "chain engine": (scene(engine="chain", duration=2.0), {"tolerance": 1e-7}),
    "spherical joints": (scene(THIN), {"tolerance": 1e-10}),
    "directions": (scene(THIN, engine="chain", duration=2.0), {"tolerance": 1e-8}),
    "contacts": (scene(THICK, *CONTACTS), {"tolerance": 1e-8}),
    "contacts and energy_balance": (
        scene(THICK, *CONTACTS, fx.Viscous(coefficient=0.02)),
        {"tolerance": 1e-8, "energy_balance": True},
    ),
}
CASES = [
    pytest.param(*integrator, id=n, marks=[needs_heyoka] if "taylor" in n else []) for n, integrator in METHODS.items()
]


class Killed(BaseException):
    """Stands in for kill -9: nothing handles it."""


@pytest.fixture(autouse=True)
def short_segments(monkeypatch: pytest.MonkeyPatch) -> None:
    """Segments of a few dozen evaluations, so that short runs have many."""
    monkeypatch.setattr(smooth_motion, "EVALUATIONS", 160)
    monkeypatch.setattr(smooth_motion, "LEAST_EVALUATIONS", 16)


def killing(loop: type[IntegrationLoop], after: int) -> Any:
    """A loop's `go_on` that is killed in its segment of this number, with the work done and nothing returned."""
    go_on, count = loop.go_on, 0

    def killed(self: IntegrationLoop, done: checkpoint.RunState) -> Any:
        nonlocal count
        result, count = go_on(self, done), count + 1
        if count == after:
            raise Killed
        return result

    return killed


def broken(given: pp.Scene, setting: Setting, path: Path) -> tuple[pp.Trajectory, int]:
    """A run that is killed in its second segment, twice, then in the third from where it is, and so on; and how often."""
    for kills in range(1000):
        with pytest.MonkeyPatch.context() as patch:
            for loop in (SmoothLoop, LoopWithEvents):
                patch.setattr(loop, "go_on", killing(loop, 2 + kills // 2))
            try:
                return pp.simulate(given, **setting, checkpoint=path, every=0), kills
            except Killed:
                assert path.exists()
    raise AssertionError("it never ends")


def assert_same(one: pp.Trajectory, other: pp.Trajectory) -> None:
    """Everything but the time that it took."""
    for field in fields(pp.Trajectory):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if isinstance(a, np.ndarray):
            assert np.array_equal(a, b), field.name
        elif field.name in {"rods", "work"}:
            assert all(map(np.array_equal, *(x.values() if isinstance(x, dict) else x for x in (a, b)))), field.name
    unclocked = [replace(run.stats, seconds=0.0, compile_seconds=0.0) for run in (one, other)]
    assert unclocked[0] == unclocked[1]
    assert (one.joints, one.scene, one.work.keys()) == (other.joints, other.scene, other.work.keys())


@pytest.mark.parametrize(("given", "setting"), CASES)
def test_a_broken_run_is_the_unbroken_one(given: pp.Scene, setting: Setting, tmp_path: Path) -> None:
    """Every integrator, killed again and again at different places: all arrays and all counts."""
    run, kills = broken(given, setting, tmp_path / "run.ckpt")
    assert kills >= 3
    assert_same(run, pp.simulate(given, **setting))


@pytest.mark.parametrize("library", ["CyRK", "scipy"])
def test_a_segment_may_be_shorter_than_a_step(library: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The step that is proposed for it fits into it, which both libraries insist on."""
    if library == "scipy":
        monkeypatch.setitem(sys.modules, "CyRK", None)
    monkeypatch.setattr(smooth_motion, "EVALUATIONS", 1)
    monkeypatch.setattr(smooth_motion, "LEAST_EVALUATIONS", 1)
    assert len(pp.simulate(scene(samples=401, duration=1.0), tolerance=1e-3).t) == 401


def test_an_interrupt_says_how_to_go_on(tmp_path: Path) -> None:
    """Ctrl-C in the middle of a segment: the message says so, and nothing is computed twice."""
    given, path, seen = scene(samples=None, duration=20.0), tmp_path / "run.ckpt", []

    def progress(t: float) -> None:
        seen.append(t)
        if t > 10:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted, match=rf"stopped by the user; {path} holds what is done") as caught:
        pp.simulate(given, progress=progress, checkpoint=path, every=np.inf)
    partial = caught.value.partial
    seen.clear()
    run = pp.simulate(given, progress=seen.append, checkpoint=path)
    assert_same(run, pp.simulate(given))
    assert np.array_equal(run.q[: len(partial.q)], partial.q)
    assert 5 < partial.t[-1] <= min(seen)
    assert run.stats.seconds > partial.stats.seconds


def test_a_finished_run_is_read_again(tmp_path: Path) -> None:
    """The file stays: the same call gives the same result without integrating."""
    path, seen = tmp_path / "run.ckpt", []
    run = pp.simulate(scene(), checkpoint=path)
    assert_same(pp.simulate(scene(), checkpoint=path, progress=seen.append), run)
    assert not seen


def test_a_limit_is_no_end(tmp_path: Path) -> None:
    """A run that takes too long is halted, as often as it likes, and goes on."""
    given, path = scene(samples=None, duration=60.0, engine="pinocchio"), tmp_path / "run.ckpt"  # nothing to compile
    says = f"it takes over 0 s; fastest there: .*; {path} holds what is done: the same run goes on from there$"
    for _ in range(3):
        with pytest.raises(pp.RunError, match=says):
            pp.simulate(given, checkpoint=path, limit=0)
    unbroken = pp.simulate(given, checkpoint=tmp_path / "other.ckpt")
    assert_same(pp.simulate(given, checkpoint=path), unbroken)


def test_a_full_disk_ends_a_run_with_what_is_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was saved before the disk was full is whole, and is gone on from when there is room."""
    path, write, saves = tmp_path / "run.ckpt", checkpoint.write_whole, []

    def full(target: Path, content: Any) -> Path:
        saves.append(target)
        if len(saves) > 3:
            raise pp.InputError(f"{target}: cannot be written: No space left on device")
        return write(target, content)

    monkeypatch.setattr(checkpoint, "write_whole", full)
    with pytest.raises(pp.RunError, match=r"No space left on device; .* holds what is done") as caught:
        pp.simulate(scene(), checkpoint=path, every=0)
    assert len(caught.value.partial.t) > 1
    monkeypatch.undo()
    assert os.listdir(tmp_path) == ["run.ckpt"]


def test_a_run_that_fails_does_not_offer_to_go_on(tmp_path: Path) -> None:
    """Going on would lead to the same place."""
    with pytest.raises(pp.RunError, match="the energy is off by over a tenth") as caught:
        pp.simulate(scene(duration=40.0), method="rk4", step=0.2, checkpoint=tmp_path / "run.ckpt")
    assert "holds what is done" not in str(caught.value)


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
    "no state": (lambda s: {"carried_y": None}, f"{NOT}array 'carried_y' is missing"),
    "short state": (lambda s: {"carried_y": s["carried_y"][1:]}, f"{NOT}array 'carried_y' is float64 (7,), not"),
    "infinite state": (lambda s: {"carried_y": s["carried_y"] + np.inf}, f"{NOT}array 'carried_y' holds NaN or"),
    "whole numbers": (lambda s: {"carried_ahead": np.array(3)}, f"{NOT}array 'carried_ahead' is int64 (), not"),
    "half a step": (lambda s: {"counts": s["counts"] + 0.5}, f"{NOT}array 'counts' holds no counts"),
    "steps below 0": (lambda s: {"counts": -s["counts"]}, f"{NOT}array 'counts' holds no counts"),
    "meta not JSON": (lambda s: {"meta": np.array("{")}, f"{NOT}Expecting property name"),
    "meta of something else": (lambda s: {"meta": np.array('{"format": 1}')}, f"{NOT}it is something else, or of"),
    "meta of nothing": (lambda s: {"meta": np.array('{"checkpoint": 1}')}, f"{OTHER}run is None in it"),
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
    with pytest.raises(pp.InputError, match="checkpoint: an accuracy takes several runs"):
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
    assert run_main(*COMMAND, "--limit", "0") == 1
    assert capfd.readouterr().err.endswith("; run.ckpt holds what is done: the same run goes on from there\n")
    assert len(pp.Trajectory.load("run.npz").t) < 2401
    assert run_main(*COMMAND) == 0
    assert not Path("run.ckpt").exists()
    assert run_main("run", "scene.toml", "--out", "whole.npz") == 0
    assert_same(pp.Trajectory.load("run.npz"), pp.Trajectory.load("whole.npz"))


REFUSED = {
    "the run's own file": (("scene.toml", "--checkpoint", "run.npz"), "run.npz: this name is given twice"),
    "the scene": (("scene.toml", "--checkpoint", "scene.toml"), "scene.toml: this name is given twice"),
    "the URDF": (("urdf.toml", "--checkpoint", "rod.urdf"), "rod.urdf: this name is given twice"),
    "no folder": (("scene.toml", "--checkpoint", "a/b"), "a/b: cannot be written: there is no folder 'a'"),
    "a target": (
        ("scene.toml", "--checkpoint", "c", "--accuracy", "1e-3"),
        "checkpoint: an accuracy takes several runs",
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
        patch.setattr(smooth_motion, "EVALUATIONS", 20_000)
        patch.setattr(smooth_motion, "LEAST_EVALUATIONS", 2_000)
        assert run_main("run", "scene.toml", "--out", "whole.npz") == 0
    assert_same(pp.Trajectory.load("run.npz"), pp.Trajectory.load("whole.npz"))
