"""What would be uploaded: the README as a registry shows it, what the wheel and the sdist hold, and the versions named."""

import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from email import message_from_bytes
from html.parser import HTMLParser
from pathlib import Path

import pytest
from readme_renderer import markdown

TOP = Path(__file__).parents[1]
PROJECT = tomllib.loads((TOP / "pyproject.toml").read_text())["project"]
README = (TOP / "README.md").read_text()


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The wheel and the sdist, built without the network by the libraries of the extra `dev`."""
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-d", str(folder)], cwd=TOP, check=True, capture_output=True
    )
    (wheel,), (sdist,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    return {"wheel": wheel, "sdist": sdist}


class _Targets(HTMLParser):
    """The addresses that links and pictures of a page lead to."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note the address of a link or picture."""
        self.addresses += [str(value) for key, value in attrs if key in ("href", "src")]


def _metadata(wheel: Path):
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        return message_from_bytes(archive.read(name))


def test_the_readme_of_a_registry_has_no_dead_link(built: dict[str, Path]) -> None:
    """Rendered as a registry does it: every address is whole, or a place on the page; all sentences are there."""
    description = str(_metadata(built["wheel"]).get_payload())
    page = markdown.render(description)
    assert page, "a registry would show it as plain text"
    for address in _Targets(page).addresses:
        assert re.match("https?://|#", address), f"{address} leads nowhere outside the repository"
    assert "](" not in re.sub(r"\]\(https?:[^)]*\)", "", description), "half a link is left"
    headings = re.findall("^#+ .*$", README, re.M)
    assert re.findall("^#+ .*$", description, re.M) == headings


def test_the_wheel_holds_what_runs(built: dict[str, Path]) -> None:
    """The modules, the example scenes with their data, the URDF; no executed notebook."""
    with zipfile.ZipFile(built["wheel"]) as archive:
        names = set(archive.namelist())
    tracked = {path for path in TOP.rglob("*") if path.is_file()}
    modules = {f"pendpin/{path.relative_to(TOP / 'src/pendpin')}" for path in tracked if path.suffix == ".py"
               and path.is_relative_to(TOP / "src/pendpin")}  # fmt: skip
    scenes = {f"pendpin/examples/{path.relative_to(TOP / 'examples')}" for path in (TOP / "examples").rglob("*.toml")}
    assert modules | scenes | {"pendpin/py.typed", "pendpin/urdf/universal_rod.urdf"} <= names
    assert not [name for name in names if name.endswith(".ipynb")]


def test_the_sdist_holds_what_its_tests_import(built: dict[str, Path]) -> None:
    """Beside the tests the benchmarks, examples and docs that they read, and what a build needs."""
    with tarfile.open(built["sdist"]) as archive:
        folders = {name.split("/", 2)[1] for name in archive.getnames()}
    here = {"src", "tests", "benchmarks", "docs", "examples", "urdf", ".ci", ".github", "pyproject.toml", "README.md"}
    assert here | {"LICENSE", "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "SECURITY.md"} <= folders


def test_one_version_and_one_list_of_pythons() -> None:
    """README, classifiers, requires-python and the workflow name the same Pythons; CITATION and CHANGELOG the version."""
    from pendpin.ground.versions import VERSION

    (tested,) = re.findall(r"tested on ([\d., and]+), on Linux", README)
    pythons = re.findall(r"3\.\d+", tested)
    named = [line.rsplit(" ", 1)[1] for line in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", line)]
    workflow = (TOP / ".github/workflows/package.yml").read_text()
    assert pythons == named == re.findall(r'"(3\.\d+)"', workflow)
    assert PROJECT["requires-python"] == f">={pythons[0]}"
    assert f"\nversion: {VERSION}\n" in (TOP / "CITATION.cff").read_text()
    assert re.search(rf"^## {re.escape(VERSION)} \(\d{{4}}-\d\d-\d\d\)$", (TOP / "CHANGELOG.md").read_text(), re.M)
