"""Imports point one way: a folder uses only the rows above it, and folders on one row do not know each other."""

import ast
from collections import Counter
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "src/pendpin"  # as written, not as installed: a wheel has the examples inside
ROWS = [  # the ground first
    {"errors"},
    {"ground"},
    {"effects", "equations"},
    {"scene", "trajectory"},
    {"model"},
    {"engines"},
    {"dynamics"},
    {"integrators"},
    {"runs"},
    {"graphics"},
    {"motions"},
    {"doctor", "fitting", "stability", "sweeps", "verification"},  # the tools
    {"cli"},
    {"__main__"},
]
ROW_OF = {room: row for row, rooms in enumerate(ROWS) for room in rooms}
MODULES = [path for path in sorted(PACKAGE.rglob("*.py")) if path.name != "__init__.py" or path.parent != PACKAGE]


def room(path: Path) -> str:
    """The folder of a module, or the module itself where it lies at the top."""
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


def imported(text: str) -> set[str]:
    """The rooms of pendpin that a module's text imports, anywhere in it; "" for the package itself."""
    names = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom):
            assert not node.level, "imports are absolute"
            if node.module == "pendpin":
                names.update(f"pendpin.{alias.name}" for alias in node.names)
            else:
                names.add(node.module or "")
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
    return {name.partition(".")[2].partition(".")[0] for name in names if f"{name}.".startswith("pendpin.")}


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_point_down(path: Path) -> None:
    """Every import of pendpin's own reaches a row above in the table, or stays in the folder."""
    home = room(path)
    for other in imported(path.read_text()) - {home}:
        assert other in ROW_OF, f"{home} imports {other or 'the whole package'}, which is no room of the house"
        assert ROW_OF[other] < ROW_OF[home], f"{home} imports {other}"


def test_every_form_of_import_is_seen() -> None:
    """So that none gets round the rows."""
    forms = ("import pendpin.cli", "from pendpin.cli import main", "from pendpin import cli", "import pendpin.cli as c")
    assert all(imported(form) == {"cli"} for form in forms)
    assert imported("import pendpin") == {""}
    assert not imported("import pendpins, numpy")


def test_no_room_is_a_fifth_of_the_house() -> None:
    """Each folder has a sentence at its head, no room of the table holds a fifth of the lines, few files lie at the top."""
    folders = [path for path in [PACKAGE, *PACKAGE.rglob("*")] if path.is_dir() and list(path.glob("*.py"))]
    for folder in folders:
        assert ast.get_docstring(ast.parse((folder / "__init__.py").read_text())), folder
    lines = Counter[str]()
    for path in MODULES:
        lines[room(path)] += path.read_text().count("\n")
    assert max(lines.values()) < 0.2 * lines.total(), lines.most_common(1)
    assert {path.stem for path in PACKAGE.glob("*.py")} <= {"__init__", *ROW_OF}


@pytest.mark.parametrize("path", sorted((PACKAGE / "equations").rglob("*.py")), ids=lambda p: p.name)
def test_hand_routes_do_not_know_pinocchio(path: Path) -> None:
    """No equation imports Pinocchio: the routes stay independent."""
    imports = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Import | ast.ImportFrom)]
    assert not any("pinocchio" in ast.unparse(node) for node in imports)


def test_hand_routes_do_not_know_each_other() -> None:
    """Each route for one rod imports the shared names only."""
    for name in ("newton_euler", "balances", "lagrange"):
        tree = ast.parse((PACKAGE / "equations" / f"{name}.py").read_text())
        own = {
            node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and "pendpin" in str(node.module)
        }
        assert own == {"pendpin.ground.arrays", "pendpin.equations.base"}


def test_the_clock_on_the_wall_is_read_where_a_person_waits() -> None:
    """What is reported or compared is processor time; limits and saves are times of the wall.

    So is the wait for a thread (libraries).
    """
    reads = ("perf_counter", "monotonic", "time.time(", "datetime.now")
    found = {path.stem for path in MODULES if any(read in path.read_text() for read in reads)}
    assert found == {"limits", "checkpoint", "libraries"}


def test_one_import_by_name() -> None:
    """Only the class of a method is imported by its name, from its own folder."""
    by_name = [path for path in MODULES if 'import_module(f"pendpin' in path.read_text()]
    assert [path.name for path in by_name] == ["choice.py"]


def test_no_circle_among_files() -> None:
    """No file imports itself by way of others, wherever the import stands: a plan of the imports has an order."""
    parts = {path: path.relative_to(PACKAGE.parent).with_suffix("").parts for path in MODULES}
    names = {path: ".".join(part).removesuffix(".__init__") for path, part in parts.items()}
    graph: dict[str, set[str]] = {}
    for path, name in names.items():
        nodes = ast.walk(ast.parse(path.read_text()))
        pairs = [
            (node.module, alias.name) for node in nodes if isinstance(node, ast.ImportFrom) for alias in node.names
        ]
        modules = {f"{module}.{part}" if f"{module}.{part}" in names.values() else module for module, part in pairs}
        graph[name] = {str(module) for module in modules if module in names.values()}
    TopologicalSorter(graph).prepare()  # raises CycleError, which names the files of a circle
