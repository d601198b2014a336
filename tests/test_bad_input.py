"""Whatever is fed to pendpin: one readable line that names the place, exit status 1, at once, nothing written."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import bad_runs
import bad_scenes
import bad_urdfs
import pendpin
from bad_input import Case, contents, run_main
from laws import HANG

CASES = [*bad_urdfs.CASES, *bad_scenes.CASES, *bad_runs.CASES]
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


@pytest.mark.parametrize("case", [case for case in CASES if case.name in IN_A_PROCESS], ids=str)
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
