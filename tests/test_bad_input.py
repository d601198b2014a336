"""Whatever is fed to pendpin: one readable line that names the place, exit status 1, at once, nothing written."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import bad_runs
import bad_scenes
import bad_trees
import bad_urdfs
import pendpin
import pendpin as pp
from bad_input import Case, contents, run_main
from laws import HANG
from pendpin.scene import builtin_scene

CASES = [*bad_urdfs.CASES, *bad_scenes.CASES, *bad_runs.CASES, *bad_trees.CASES]
IN_A_PROCESS = [  # where a crash or a word from a C library would show
    "urdf: 5,000 links in a row",
    "urdf: two parents",
    "urdf: nan mass, to check",
    "scene: nested 10,000 deep",
    "plot: pickled object array",
    "view: claims 2^62 numbers",
    "out: a folder that refuses",
    "usage: option",
]
MOST_CALLS = 30_000_000  # of functions, and returns: a few seconds; 11 million for a URDF of 5,000 links


def assert_refused(case: Case, status: int, out: str, err: str) -> None:
    """One line of printable text on stderr that says what the case wants said."""
    assert status == case.status
    assert out == ""
    assert err.startswith("pendpin: ")
    assert err.endswith("\n")
    assert err[:-1].isprintable()
    assert case.is_said(err), (case.facts, err)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_bad_input_ends_in_one_line(
    case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture
) -> None:
    """Each case in this process, with what C libraries print caught as well."""
    case.lay_out(tmp_path)
    monkeypatch.chdir(tmp_path)
    before = contents(tmp_path)
    assert_refused(case, run_main(*case.arguments), *capfd.readouterr())
    assert contents(tmp_path) == before


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=str)
def test_bad_input_ends_at_once(case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a few seconds, whatever the file claims; its work is counted, so that no busy machine matters."""
    case.lay_out(tmp_path)
    monkeypatch.chdir(tmp_path)
    calls = 0

    def count(*_: object) -> None:
        nonlocal calls
        calls += 1

    sys.setprofile(count)
    try:
        status = run_main(*case.arguments)
    finally:
        sys.setprofile(None)
    assert status == case.status
    assert calls < MOST_CALLS


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, marks=[pytest.mark.slow] * (case.name not in IN_A_PROCESS[::2]))
        for case in CASES
        if case.name in IN_A_PROCESS
    ],
    ids=str,
)
def test_bad_input_in_a_process_of_its_own(case: Case, tmp_path: Path) -> None:
    """Some cases as the user runs them."""
    case.lay_out(tmp_path)
    before = contents(tmp_path)
    done = subprocess.run(
        [sys.executable, "-c", "from pendpin.cli import main; main()", *case.arguments],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(Path(pendpin.__file__).parents[1])},
        capture_output=True,
        text=True,
        timeout=HANG,
        check=False,
    )
    assert_refused(case, done.returncode, done.stdout, done.stderr)
    assert contents(tmp_path) == before


def test_processes_are_among_the_cases() -> None:
    """The names above are names of cases, and no two cases share one."""
    names = [case.name for case in CASES]
    assert set(IN_A_PROCESS) <= set(names)
    assert len(set(names)) == len(names) >= 60


def test_unknown_keys_are_listed_in_one_order() -> None:
    """Whatever the order in which they are given: that of a scene that was changed is its own."""
    said = []
    for keys in (("torque", "amplitude", "frequency", "phase"), ("phase", "frequency", "amplitude", "torque")):
        with pytest.raises(pendpin.InputError) as caught:
            pendpin.Scene(effects=[{"kind": "gravity"} | dict.fromkeys(keys, 1.0)])
        said.append(str(caught.value))
    assert said[0] == said[1]
    assert "effects[0].amplitude: unknown key" in said[0]


ODD = {  # what a call was given, and what is said of it
    "load_scene": (lambda: pp.load_scene(3), "3 is not the path of a file"),
    "load_scene of no name": (lambda: pp.load_scene(""), "the name of the file is empty"),
    "Scene.save": (lambda: builtin_scene().save(3), "3 is not the path of a file"),
    "Scene.replace": (lambda: builtin_scene().replace(3), "3 is not a mapping of key paths"),
    "Scene.duration": (lambda: setattr(builtin_scene(), "duration", 3), "scene.replace(duration=...) gives another"),
    "Scene(model=Rod)": (lambda: pp.Scene(model=pp.Rod(length=1, mass=1)), "write model=Chain(rods=[Rod(...)])"),
    "Scene(model=[])": (lambda: pp.Scene(model=[]), "write model=Chain(rods=[...])"),
    "UrdfModel": (lambda: pp.UrdfModel(3), "3 is neither the path of a URDF nor the name of a robot"),
    "validate": (lambda: pp.validate(3), "3 is not a list of cases"),
    "cost": (lambda: pp.cost(None), "None is not a Scene, nor the path of a scene file"),
    "plot": (lambda: pp.Trajectory.load("run.npz").plot("theta", ax=3), "3 is not a matplotlib Axes"),
    "modes.plot": (lambda: pp.modes(builtin_scene()).plot(ax=3), "3 is not a matplotlib Axes"),
    "load": (lambda: pp.Trajectory.load("run.npz", scene=3), "3 is not a Scene"),
    "progress": (lambda: pp.simulate(builtin_scene(), progress=None), "None is not a function"),
    "diagnose text": (lambda: pp.diagnose(" "), "holds no equation"),
    "diagnose number": (lambda: pp.diagnose(3), "3 holds no equation"),
    "xacro": (lambda: pp.simulate(pp.Scene(model=pp.UrdfModel("robot.xacro"), duration=0.1)), "expand it"),
    "MJCF": (lambda: pp.simulate(pp.Scene(model=pp.UrdfModel("robot.xml"), duration=0.1)), "buildModelFromMJCF(file)"),
}


@pytest.mark.parametrize("name", ODD)
def test_what_a_call_cannot_use_is_said_in_one_line(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As an InputError that says what would be right, whatever class the value has."""
    monkeypatch.chdir(tmp_path)
    pp.simulate(builtin_scene(), duration=0.1, samples=3).save("run.npz")
    Path("robot.xml").write_text("<mujoco><worldbody/></mujoco>")
    Path("robot.xacro").write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="m"/></robot>'
    )
    call, says = ODD[name]
    with pytest.raises(pp.InputError) as caught:
        call()
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_measure_that_fails_in_every_case_is_an_error() -> None:
    """With its reason, and the cases; where it fails in some, they say why."""

    def broken(run: pp.Trajectory) -> float:
        return 1 / int(run.t[-1] > 0.15)

    with pytest.raises(pp.RunError, match=r"broken: ZeroDivisionError.*, in every case") as caught:
        pp.sweep(builtin_scene(), {"duration": [0.1, 0.12]}, broken)
    assert caught.value.partial["why"].shape == (2,)
    some = pp.sweep(builtin_scene(), {"duration": [0.1, 0.2]}, broken)
    assert [bool(reason) for reason in some["why"].values] == [True, False]


def test_nothing_to_draw_and_uneven_points_are_said_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd
) -> None:
    """A figure of costs without a run; Sobol' points whose number is not a power of 2: no line of SciPy's source."""
    monkeypatch.chdir(tmp_path)
    stop = pp.effects.Stop(lower=-1.0, upper=1.0)
    rod = pp.Chain(rods=[pp.Rod(length=1, mass=1, radius=0.05)])
    pp.Scene(model=rod, effects=[pp.effects.Gravity(), stop], duration=0.1).save("stops.toml")
    assert run_main("cost", "stops.toml", "--methods", "taylor", "--plot", "cost.png") == 1
    assert re.fullmatch(r"pendpin: .*no method could be measured: .*\n", capfd.readouterr().err)
    vary = ("--vary", "start.positions.theta=0.1:0.5", "--sample", "3", "--sampling", "sobol")
    assert run_main("sweep", "stops.toml", *vary) == 0
    assert (
        capfd.readouterr().err
        == "pendpin: note: 3 points of a Sobol' sequence are not evenly spread: take a power of 2\n"
    )
