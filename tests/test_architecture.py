"""Imports point one way: a folder uses only the rows above it, and folders on one row do not know each other."""

import ast
from pathlib import Path

import pytest

from pendpin.late import HOMES, from_above

PACKAGE = Path(__file__).parents[1] / "src/pendpin"  # as written, not as installed: a wheel has the examples inside
ROWS = [  # the ground first
    {"errors", "versions"},
    {"arrays", "files", "keypaths", "late"},
    {"records"},
    {"effects", "equations"},
    {"scene", "trajectory"},
    {"model"},
    {"engines"},
    {"dynamics"},
    {"integrators"},
    {"simulation", "graphics"},
    {"analysis"},
    {"cli"},
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


def test_folders_are_few_and_small() -> None:
    """At most 14 files a folder, each folder with a sentence at its head, and few files at the top."""
    folders = [path for path in [PACKAGE, *PACKAGE.rglob("*")] if path.is_dir() and list(path.glob("*.py"))]
    for folder in folders:
        assert len(list(folder.glob("*.py"))) <= 15, folder  # 14 and __init__.py
        assert ast.get_docstring(ast.parse((folder / "__init__.py").read_text())), folder
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
        assert own == {"pendpin.arrays", "pendpin.equations.base"}


def test_what_lower_rooms_ask_of_higher_ones_stands_in_one_table() -> None:
    """Each entry of the table is there, and no other module imports its own by name at run time."""
    assert all(callable(from_above(name)) for name in HOMES)
    by_name = [path for path in MODULES if 'import_module(f"pendpin' in path.read_text()]
    assert [path.name for path in by_name] == ["late.py"]
