"""The pages' commands and Python, and the examples of the reference, run as written."""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import pendpin as pp
from laws import HANG
from pendpin.scene import METHODS

TOP = Path(__file__).parents[1]
RUN = [*sorted((TOP / "docs" / "how-to").glob("*.md")), TOP / "docs" / "trees.md"]  # others take minutes
EXAMPLES = sorted((TOP / "docs" / "reference" / "api_examples").glob("*.py"))


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty folder with the example scenes, and `pendpin` on the path."""
    (tmp_path / "examples").symlink_to(TOP / "examples")
    command = tmp_path / "bin" / "pendpin"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m pendpin "$@"\n')
    command.chmod(0o755)
    monkeypatch.setenv("PATH", f"{command.parent}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.chdir(tmp_path)
    before = dict(METHODS)
    yield tmp_path
    METHODS.clear()  # a page may add a method of its own
    METHODS.update(before)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt" or not shutil.which("bash"), reason="the commands are those of a shell")
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("page", RUN, ids=[page.stem for page in RUN])
def test_the_page_runs(page: Path, checkout: Path) -> None:
    """Its Python and its commands, block after block, in one folder with the scenes that it prints."""
    names: dict = {}
    shutil.copy(checkout / "examples" / "crane_trolley.csv", checkout)
    for name, scene in re.findall(r"^```toml\n# (\S+\.toml)\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE):
        (checkout / name).write_text(scene)
    for language, block in re.findall(r"^```(python|sh)\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE):
        if language == "python":
            exec(block, names)  # our own text
        else:
            done = subprocess.run(["bash", "-euc", block], cwd=checkout, capture_output=True, text=True, timeout=HANG)
            assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("example", EXAMPLES, ids=[example.stem for example in EXAMPLES])
def test_the_example_runs(example: Path, checkout: Path) -> None:
    """Of a public name, shown on its page of the reference."""
    exec(example.read_text(), {})  # our own text


def test_every_public_name_has_an_example() -> None:
    """On its page of the reference, and no example is of a name that is gone."""
    assert {example.stem for example in EXAMPLES} == set(pp.__all__)


# A page's column shows 79 characters. A printed equation is one line, and so is a robot written as XML.
COLUMN = 79
CODE = {"python", "sh", "console", "toml", "{code-cell}"}
LONG_LINES = {"pinocchio_notes.md": "<", "derivation.md": "\\[", "doctor.md": '"balance'}
PAGES = [path for path in sorted((TOP / "docs").rglob("*.md")) if "gallery" not in path.parts]


@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_code_fits_its_column(page: Path) -> None:
    """Blocks of code and of commands on a page of the documentation."""
    for language, block in re.findall(r"^```(\S+)[^\n]*\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE):
        if language in CODE:
            kept = LONG_LINES.get(page.name)
            long = [line for line in block.splitlines() if len(line) > COLUMN and not (kept and kept in line)]
            assert not long, long


SCRIPTS = [*sorted((TOP / "docs" / "gallery_scripts").glob("*.py")), *EXAMPLES]


@pytest.mark.parametrize("script", SCRIPTS, ids=[script.stem for script in SCRIPTS])
def test_a_shown_script_fits_its_column(script: Path) -> None:
    """Scripts of the gallery and examples of the reference; the prose between blocks is wrapped by the page."""
    text = script.read_text()
    prose = r'\A"""[^"]*"""|^# %%.*\n(?:#.*\n)*'
    code = re.sub(prose, "", text, flags=re.MULTILINE)
    assert not [line for line in code.splitlines() if len(line) > COLUMN]


def test_no_property_begins_with_a_colon_sentence() -> None:
    """On the reference's pages what stands before a colon in a property's first line is taken for its type."""
    for name in pp.__all__:
        for key, value in vars(getattr(pp, name)).items():
            if isinstance(value, property) and not key.startswith("_"):
                first = (value.__doc__ or "").split("\n")[0]
                assert ":" not in first, f"{name}.{key}: {first}"


def test_every_picture_is_shown() -> None:
    """By a page or by the README."""
    text = "\n".join(path.read_text() for path in [TOP / "README.md", *PAGES])
    hidden = [path.name for path in (TOP / "docs" / "images").glob("*.png") if f"images/{path.name})" not in text]
    assert not hidden
