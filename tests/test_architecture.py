"""Imports point one way: a module uses only lower rows, and siblings on a row do not know each other."""

import ast
from pathlib import Path

import pytest

import pendpin

PACKAGE = Path(pendpin.__file__).parent
ROWS = [
    {"errors"},
    {"files", "processes", "records"},
    {"derivations", "effects", "trajectory"},
    {"urdf_xml"},
    {"scene", "urdf"},
    {"bodies"},
    {"model"},
    {"urdf_chain"},
    {"kinematics"},
    {"engines"},
    {"binding", "symbolic"},
    {"contacts"},
    {"dynamics"},
    {"ledger", "solvers", "explain", "guards"},
    {"checkpoint"},
    {"driving"},
    {"hybrid", "side_by_side", "stretches"},
    {"runs"},
    {"goal"},
    {"simulation"},
    {"references", "cost_report", "peers"},
    {"routes", "sizes"},
    {"crosschecks", "relevance", "costs", "hardcases", "ensemble"},
    {"drawing", "plot"},
    {"cost_plot"},
    {"page", "scenery"},
    {"view"},
    {"console", "terminal"},
    {"cli"},
]
ROW_OF = {room: row for row, rooms in enumerate(ROWS) for room in rooms}
MODULES = [path for path in sorted(PACKAGE.rglob("*.py")) if path.name != "__init__.py" or path.parent != PACKAGE]


def room(path: Path) -> str:
    """The first part of a module's path inside the package."""
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


def imported(path: Path) -> set[str]:
    """The rooms of pendpin that a file imports, anywhere in it."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
            names.update(f"{node.module}.{alias.name}" for alias in node.names if node.module == "pendpin")
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
    return {name.split(".")[1] for name in names if name.startswith("pendpin.")}


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_point_down(path: Path) -> None:
    """Every import of pendpin's own reaches a lower row, or stays in the room."""
    home = room(path)
    for other in imported(path) - {home}:
        assert ROW_OF[other] < ROW_OF[home], f"{home} imports {other}"


@pytest.mark.parametrize("path", sorted((PACKAGE / "derivations").glob("*.py")), ids=lambda p: p.name)
def test_hand_routes_do_not_know_pinocchio(path: Path) -> None:
    """No derivation imports Pinocchio: the routes stay independent."""
    imports = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Import | ast.ImportFrom)]
    assert not any("pinocchio" in ast.unparse(node) for node in imports)


def test_hand_routes_do_not_know_each_other() -> None:
    """Each route for one rod imports the shared names only."""
    for name in ("newton_euler", "balances", "lagrange"):
        tree = ast.parse((PACKAGE / "derivations" / f"{name}.py").read_text())
        own = {
            node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and "pendpin" in str(node.module)
        }
        assert own == {"pendpin.derivations.base"}
