"""What would be uploaded: the README as a registry shows it, what the wheel and the sdist hold, and the versions named."""

import os
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

import pendpin as pp

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
    """The modules, the tables of the doctor, the example scenes with their data, the URDF; no executed notebook."""
    with zipfile.ZipFile(built["wheel"]) as archive:
        names = set(archive.namelist())
    tracked = {path for path in TOP.rglob("*") if path.is_file()}
    modules = {f"pendpin/{path.relative_to(TOP / 'src/pendpin')}" for path in tracked
               if path.suffix in (".py", ".md", ".toml") and path.is_relative_to(TOP / "src/pendpin")}  # fmt: skip
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
    from pendpin.ground.libraries import VERSION

    (tested,) = re.findall(r"tested on ([\d., and]+), on Linux", README)
    pythons = re.findall(r"3\.\d+", tested)
    named = [line.rsplit(" ", 1)[1] for line in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", line)]
    workflow = (TOP / ".github/workflows/package.yml").read_text()
    assert pythons == named == re.findall(r'"(3\.\d+)"', workflow)
    assert PROJECT["requires-python"] == f">={pythons[0]}"
    assert f"\nversion: {VERSION}\n" in (TOP / "CITATION.cff").read_text()
    assert re.search(rf"^## {re.escape(VERSION)} \(\d{{4}}-\d\d-\d\d\)$", (TOP / "CHANGELOG.md").read_text(), re.M)


WITHOUT = """
import sys
from importlib import util
EXTRAS = {extras}
real = util.find_spec
util.find_spec = lambda name, *given: None if name.partition(".")[0] in EXTRAS else real(name, *given)
class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in EXTRAS:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Missing())
from pendpin.cli import main
for arguments in {commands}:
    sys.argv = ["pendpin", *arguments]
    try:
        main()
    except SystemExit as end:
        status = end.code
    print("status", status, flush=True)
    print("pendpin: end", file=sys.stderr, flush=True)
"""
EXTRAS = (
    "CyRK",
    "heyoka",
    "llvmlite",
    "mujoco",
    "pydrake",
    "xarray",
    "zarr",
    "numcodecs",
    "dask",
    "distributed",
    "cloudpickle",
)
EXTRAS += ("sympy", "pandas", "imageio_ffmpeg")
ANSWERS = {  # what a bare install says: nothing on stderr, or what is missing and how it is installed
    "run --duration 0.1": "",
    "run --duration 0.1 --accuracy 1e-4": "",
    "run --duration 0.1 --method taylor": "needs heyoka: pip install heyoka",
    "check --states 3": "",
    "cost --duration 0.1 --methods rk45": "",
    "effects --set duration=0.1": "",
    "hard --short thin-pole": "",
    "modes": "needs llvmlite",
    "stability": "needs llvmlite",
    "stability --lyapunov --set duration=0.1": "needs llvmlite",
    "section --at theta=0.1 --of phi --count 1": "",
    "bifurcation --vary effects[0].acceleration=9:10:2 --strobe 0.1 --of theta --count 1 --skip 1": "",
    "validate acheson": "",
    "validate conical --methods dop853": "",
    "reference scene.toml --out folder": "",
    "doctor text.md": "needs sympy: pip install sympy",
    "fit scene.toml swing.csv": "needs llvmlite",
    "sweep --vary duration=0.1:0.2:2": "needs xarray: pip install",
    "map store.zarr": "there is no store of a sweep",
    "plot run.npz": "",
    "view run.npz --html run.html": "",
    "view run.npz --film run.mp4": "needs imageio_ffmpeg: pip install",
    "urdf scene.toml": "",
    "new single_rod": "",
    "schema": "",
}


@pytest.mark.slow
def test_every_command_on_a_bare_install(tmp_path: Path) -> None:
    """An answer, or one line that names the library and how it is installed: never a traceback."""
    from pendpin.cli.app import app

    names = {command.name or command.callback.__name__ for command in app.registered_commands if command.callback}
    assert names == {line.split()[0] for line in ANSWERS}
    rod, gravity = pp.Rod(length=1, mass=1, radius=0.05), pp.effects.Gravity()
    scene = pp.Scene(model=pp.Chain(rods=[rod]), effects=[gravity], data={"columns": {"a": ["theta"]}}, duration=0.1)
    scene.save(tmp_path / "scene.toml")
    swing = pp.simulate(scene.replace({"start.positions.theta": 0.3}), duration=3.0, samples=200)
    rows = [f"{t},{a}" for t, a in zip(swing.t.tolist(), swing["theta"].tolist(), strict=True)]
    (tmp_path / "swing.csv").write_text("\n".join(["t,a", *rows]))
    (tmp_path / "text.md").write_text(r"$\ddot\theta = -\frac{g}{l}\sin\theta$")
    code = WITHOUT.format(extras=EXTRAS, commands=[line.split() for line in ANSWERS])
    environment = os.environ | {"MPLBACKEND": "Agg"}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, env=environment)
    statuses = [int(line.split()[1]) for line in done.stdout.splitlines() if line.startswith("status ")]
    said = [part.strip() for part in done.stderr.split("pendpin: end")][:-1]
    assert len(statuses) == len(said) == len(ANSWERS), done.stderr
    for (command, says), status, text in zip(ANSWERS.items(), statuses, said, strict=True):
        assert status == bool(says), (command, text)
        assert says in text, (command, text)
        assert "Traceback" not in text, (command, text)
        assert len([line for line in text.splitlines() if "note:" not in line]) == bool(says), (command, text)
