"""Whatever is fed to pendpin: one readable line that names the place, exit status 1, at once, nothing written."""

import time
from pathlib import Path

import pytest

import bad_runs
import bad_scenes
import bad_urdfs
from bad_input import Case, contents, run_main

CASES = [*bad_urdfs.CASES, *bad_scenes.CASES, *bad_runs.CASES]
MOST_SECONDS = 5.0


@pytest.mark.parametrize("case", CASES, ids=str)
def test_bad_input_ends_in_one_line(
    case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture
) -> None:
    """Each case in this process, with what C libraries print caught as well."""
    case.lay_out(tmp_path)
    monkeypatch.chdir(tmp_path)
    before, begin = contents(tmp_path), time.perf_counter()
    status = run_main(*case.arguments)
    took = time.perf_counter() - begin
    out, err = capfd.readouterr()
    assert status == case.status
    assert out == ""
    assert err.startswith("pendpin: ")
    assert err.endswith("\n")
    assert err.count("\n") == 1
    assert err[:-1].isprintable()
    assert case.says in err
    assert took < MOST_SECONDS
    assert contents(tmp_path) == before
