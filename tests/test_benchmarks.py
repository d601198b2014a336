"""Every script of benchmarks/ runs, in a small form, and says by its status that all is well."""

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from shlex import split
from shutil import copy

import pytest

TOP = Path(__file__).parents[1]
FOLDER = TOP / "benchmarks"
PATIENCE = 600  # s, so that none hangs for ever
MODULES = {"pages", "planting", "reference_equations", "reference_motion", "timed_scenes"}  # imported, run nothing
ONE_ROD = 1  # seed of fit.py whose first case is one rod, which is cheaper than two
SMALL = {
    "agreement": "--quick",
    "auto": "--rods 1 --kinds bare",
    "cables": "--rods 4",
    "chain_scaling": "--most 10 --seconds 0.01",
    "doctor": "--mutations 3 --rewritings 3",
    "effects": "--rods 1 --repetitions 1",
    "ensembles": "--starts 20 --seconds 0.05 --sample 4",
    "events": "1 0",
    "fit": f"1 {ONE_ROD} fit.jsonl",
    "fit_coverage": "2 coverage.jsonl --sizes '2 x 400' --noises 0.5",
    "goal": "--count 2 --seed 1 --file goal.jsonl",
    "hard_cases": "hard.json peers.json .",
    "instants": "2 1 2",
    "interrupts": "'run dop853' 'sweep in vectors' --after 1",
    "maxima": "2 1",
    "kill": "1 1",
    "kill_sweeps": "1 1 40",
    "letters": "--texts 14",
    "long_runs": "--swings 100",
    "modes": "--rods 3",
    "mutants": "2 mutants.jsonl --modules trajectory/record.py --tests trajectory --hypothesis-profile few",
    "one_run": "--starts 16 --repetitions 1 --rows planar many short",
    "overhead": "--repetitions 1 --duration 10",
    "peers": "--rods 1",
    "rounding_estimates": "--count 4",
    "sensitivities": "1 1",
    "strangers": "--sources",
    "sections": "--short",
    "sweep": "--starts 20 --sample 4",
    "trees": "--trees 2 --states 2 --rods 2",
}
OTHERS = {"ensembles": "mujoco", "peers": "mujoco", "sweep": "mujoco"}  # what a script needs beside the extra dev


def run(folder: Path, *command: str) -> str:
    """What a command prints; it has to end with status 0."""
    environment = os.environ | {"PYTHONPATH": str(TOP / "src")}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


def test_none_is_left_out() -> None:
    """A new script comes with its small form."""
    assert set(SMALL) | MODULES == {path.stem for path in FOLDER.glob("*.py")}


@pytest.mark.slow
def test_faults_are_planted_in_every_room() -> None:
    """Every folder of the package has faults; every fault that once was not noticed has its place."""
    code = (
        "from mutants import *; print(len(planted())); print(*{x.module for x in faults_of(SOURCE, all_modules(), 0)})"
    )
    count, modules = run(FOLDER, sys.executable, "-c", code).splitlines()
    assert int(count) > 15
    rooms = {path.name for path in (TOP / "src" / "pendpin").iterdir() if (path / "__init__.py").exists()}
    assert rooms <= {module.split("/")[0] for module in modules.split()}


def test_a_fault_is_planted_in_functions_that_the_collector_does_not_list() -> None:
    """conftest.py freezes what is there once the tests are read: a fault has to be in those functions all the same."""
    code = (
        "import gc; from mutants import *; from pendpin.runs.limits import Deadline; right = Deadline.check.__code__; "
        "gc.freeze(); exchange_code(faults_of(SOURCE, ['runs/limits.py'], 0)[0]); print(Deadline.check.__code__ is right)"
    )
    assert run(FOLDER, sys.executable, "-c", code) == "False\n"


def test_no_script_hides_a_library() -> None:
    """A script's folder is the first place where Python looks for what the script imports."""
    names = {path.stem for path in FOLDER.glob("*.py")}
    places = [place for place in sys.path if place and Path(place).resolve() not in (FOLDER, Path.cwd(), TOP / "tests")]
    hidden = [name for name in names for place in places if (Path(place) / f"{name}.py").exists()]
    hidden += [name for name in names for place in places if (Path(place) / name / "__init__.py").exists()]
    assert not hidden


@pytest.mark.slow
@pytest.mark.parametrize("name", SMALL)
def test_a_script_runs(name: str, tmp_path: Path) -> None:
    """In an empty folder."""
    if (other := OTHERS.get(name)) and find_spec(other) is None:
        pytest.skip(f"{other} is not installed: CI's last step installs it")
    if name == "hard_cases":
        hard = [sys.executable, "-m", "pendpin", "hard", "thin-pole", "--json"]
        (tmp_path / "hard.json").write_text(run(tmp_path, *hard))
        copy(tmp_path / "hard.json", tmp_path / "peers.json")
        for page in ("hard_cases.md", "hard_cases_catalogue.md"):
            copy(TOP / "docs" / page, tmp_path)
    run(tmp_path, sys.executable, str(FOLDER / f"{name}.py"), *split(SMALL[name]))
