"""The cross-check agrees where it must and finds what is broken."""

import inspect
import json
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import pendpin as pp
from bad_input import run_main
from pendpin.equations import balances, lagrange, newton_euler
from pendpin.equations.chain import solution
from pendpin.ground.report import FEW
from pendpin.motions.crosschecks.crosscheck import compare
from pendpin.scene import builtin_scene

RODS = {
    "thin": pp.Rod(length=1.0, mass=1.0),
    "thick": pp.Rod(length=1.0, mass=1.0, radius=0.3),
    "own inertia": pp.Rod(length=1.0, mass=1.0, com=0.7, inertia=(0.3, 0.2, 0.05), payload=0.5),
    "behind the joint": pp.Rod(length=1.0, mass=2.0, com=-0.3, inertia=(0.2, 0.25, 0.1)),
}
GRAVITY = (pp.effects.Gravity(),)


def scene_of(rod: pp.Rod, *effects: pp.effects.Effect) -> pp.Scene:
    """A scene of one rod."""
    return pp.Scene(model=pp.Chain(rods=(rod,)), effects=effects or GRAVITY)


@pytest.mark.parametrize("name", RODS)
def test_all_routes_agree(name: str) -> None:
    """Every pair of routes, every quantity, on rods of every kind."""
    report = pp.crosscheck(scene_of(RODS[name]), states=500, seed=1)
    assert report.ok, report.worst
    assert report.worst.relative < 2e-15  # a few roundings; the bound of the command is 1e-13
    assert set(report.routes) == {"pinocchio", "chain", "recursion", "newton-euler", "balances", "lagrange"}


@pytest.mark.parametrize("name", RODS)
@pytest.mark.parametrize("rate", [1e-300, 1e-290, 1e-200, 1e-160, 1e-150])
def test_routes_agree_where_squares_underflow(name: str, rate: float) -> None:
    """Differences of rates near the smallest double are compared with terms of that size, not with squares that are 0."""
    scene = pp.Scene(model=pp.Chain(rods=[RODS[name]] * 2), effects=(pp.effects.Viscous(coefficient=0.1),))
    report = compare(pp.bind(scene), np.zeros((1, 4)), rate * np.eye(4)[3:], {}, in_50_digits=1)
    assert report.ok, report.fault
    assert report.worst.relative < 1e-15


def test_the_built_in_urdf_agrees() -> None:
    """The URDF that comes with pendpin, through the recognised universal joint."""
    assert pp.crosscheck(builtin_scene(), states=2000, seed=3).ok


def test_gravity_in_any_direction() -> None:
    """The routes take a field that is not vertical."""
    tilted = pp.effects.Gravity(acceleration=3.7, direction=(0.3, -0.5, -0.8))
    assert pp.crosscheck(scene_of(RODS["thick"], tilted), states=500).ok


@pytest.mark.parametrize("joint", ["universal", "hinge"])
@pytest.mark.parametrize("branched", [False, True])
def test_forces_on_bodies_have_their_moments(joint: str, branched: bool) -> None:
    """Wind on every rod and a push beside the centre of mass, with a torque: in a row of rods and where two hang on one."""
    rod = {"mass": 1.0, "radius": 0.02, "joint": joint}
    rods = [pp.Rod(length=length, **rod) for length in (1.0, 0.7)]
    rods.append(pp.Rod(length=0.4, **rod, **({"hangs_on": "rod_1", "at": 0.6} if branched else {})))
    effects = (
        *GRAVITY,
        pp.effects.Drag(density=50.0, wind=(3.0, 1.0, -2.0)),
        pp.effects.Push(link="rod_2", force=(2.0, -1.0, 3.0), torque=(0.2, 0.3, -0.1), point=0.1),
    )
    report = pp.crosscheck(pp.Scene(model=pp.Chain(rods=rods), effects=effects), states=20)
    assert report.ok, report.worst
    assert ("tree" in report.routes) == (branched or joint == "hinge")


def test_moments_are_there_where_the_rod_is_thick() -> None:
    """M3 and Mc vanish for a thin rod only, and are the balances' own there."""
    q, v = np.array([0.3, 0.4]), np.array([2.0, -3.0])
    for name, zero in (("thin", True), ("thick", False)):
        found = newton_euler.solve(RODS[name].properties, q, v, np.array([0, 0, 9.81]))
        assert (found.M3 == 0 and found.Mc == 0) == zero


NAMES = {"newton_euler": "newton-euler", "balances": "balances", "lagrange": "lagrange"}
BREAKS = [
    (newton_euler, "2 * (J1 - I3)", "(J1 - I3)", "theta_dd"),
    (newton_euler, "m * h * G1 - (J1 - I3)", "m * h * G1 + (J1 - I3)", "phi_dd"),
    (newton_euler, "dp**2 + dt**2 * c**2", "dp**2 - dt**2 * c**2", "R3"),
    (newton_euler, "phi_dd + dt**2 * s * c", "phi_dd - dt**2 * s * c", "R1"),
    (newton_euler, "-alpha1 - dt * dp * s", "-alpha1 + dt * dp * s", "R2"),
    (newton_euler, "I3 + J2 - J1", "I3 + J1 - J1", "Mc"),
    (balances, "np.cross(omega, inertia * omega)", "np.cross(inertia * omega, omega)", "Mc"),
    (balances, "np.diag([1.0, 1.0, -1.0])", "np.diag([1.0, -1.0, -1.0])", "R2"),
    (lagrange, "0.5 * slope", "slope", "phi_dd"),
    (lagrange, "c2 * (rod.I1 + about_joint)", "c2 * (rod.I1 + 2 * about_joint)", "theta_dd"),
]


ASYMMETRIC = """
[model]
kind = "chain"
rods = [{ length = 1.0, mass = 1.0, com = 0.4, inertia = [0.3, 0.2, 0.15] }]
[[effects]]
kind = "gravity"
"""


@pytest.fixture
def broken(module: ModuleType, right: str, wrong: str) -> Iterator[None]:
    """A route with one sign or factor changed, for the time of a test."""
    source, sound = inspect.getsource(module), dict(vars(module))
    assert source.count(right) == 1
    exec(source.replace(right, wrong), vars(module))
    yield
    vars(module).update(sound)


@pytest.mark.usefixtures("broken")
@pytest.mark.parametrize(("module", "right", "wrong", "quantity"), BREAKS)
def test_a_broken_route_fails_the_check(module, quantity: str, tmp_path: Path, capsys: Any) -> None:
    """One sign or factor changed in one route: `pendpin check` exits 1, names the quantity and the route."""
    (tmp_path / "scene.toml").write_text(ASYMMETRIC)
    assert run_main("check", str(tmp_path / "scene.toml"), "--states", "50", "--json") == 1
    out, err = capsys.readouterr()
    assert json.loads(out)["ok"] is False
    who, _, what = err.partition(" disagrees in ")
    assert who == f"pendpin: {NAMES[module.__name__.rpartition('.')[2]]}"
    assert quantity in what.partition(";")[0].split(", ")


def test_a_user_route_that_is_wrong_is_found() -> None:
    """The user's own equations are compared in the quantities they give, and no others."""

    def mine(rod, q, v, field):
        return {"phi_dd": 1.001 * newton_euler.solve(rod, q, v, field).phi_dd}

    report = pp.crosscheck(builtin_scene(), states=100, routes={"mine": mine})
    broken = [row for row in report.rows if not row.ok]
    assert all(row.quantity == "phi_dd" and "mine" in (row.first, row.second) for row in broken)
    assert len(broken) == len(report.routes)  # against each other route, and the reference_route
    assert {row.quantity for row in report.rows if "mine" in (row.first, row.second)} == {"phi_dd"}


@pytest.mark.parametrize("count", [3, 10])
@pytest.mark.parametrize(("part", "quantity"), [("acceleration", "acceleration"), ("force", "R3"), ("moment", "Mc")])
def test_a_small_fault_in_the_chain_equations_is_found(
    count: int, part: str, quantity: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One part in 1e8 off, on mixed rods: the sizes that differences are held against do not hide it."""
    random, solve = np.random.default_rng(count), solution.solve

    def faulty(*args, **given) -> solution.ChainSolution:
        found = solve(*args, **given)
        return replace(found, **{part: getattr(found, part) * (1 + 1e-8)})

    monkeypatch.setattr(solution, "solve", faulty)
    sizes = zip(10 ** random.uniform(-1, 0.5, count), 10 ** random.uniform(-1, 1, count), strict=True)
    rods = tuple(pp.Rod(length=length, mass=mass, radius=0.05) for length, mass in sizes)
    report = pp.crosscheck(pp.Scene(model=pp.Chain(rods=rods), effects=GRAVITY), states=10)
    assert report.fault is not None
    assert report.fault.startswith("chain disagrees")
    assert quantity in report.fault.partition(";")[0]


def test_a_route_that_answers_nan_is_broken() -> None:
    """NaN never passes for agreement."""
    report = pp.crosscheck(builtin_scene(), states=10, routes={"nan": lambda rod, q, v, g: {"R1": np.full(10, np.nan)}})
    assert not report.ok
    assert np.isnan(report.worst.relative)


def _fifty() -> pp.Scene:
    return pp.Scene(model=pp.Chain(rods=(RODS["thick"],), copies=50), effects=GRAVITY)


@pytest.mark.parametrize(("make", "routes"), [(builtin_scene, 5), (_fifty, 3)], ids=["one rod", "fifty rods"])
def test_the_matrix_fits_a_terminal(make, routes: int) -> None:
    """A line for each route, a column for each quantity, the worst figure in each cell, the verdict in words."""
    report = pp.crosscheck(make(), states=5)
    head, *lines = report.report().tables[0].lines()
    assert max(map(len, [head, *lines])) <= 80
    assert head.split() == list(dict.fromkeys(row.quantity for row in report.rows))
    table = {line.split()[0]: line.split()[1:] for line in lines[:routes]}
    assert tuple(table) == report.routes
    for route, cells in table.items():
        for quantity, cell in zip(head.split(), cells, strict=True):
            found = [
                r.relative
                for r in report.rows
                if r.quantity == quantity and {r.first, r.second} == {route, "50 digits"}
            ]
            assert cell == (f"{max(found):.0e}" if found else "-")
    assert f"All {routes} routes agree" in str(report)
    assert len(repr(report)) < 1000


def test_the_matrix_of_all_routes_is_shown_whole() -> None:
    """Every route of one rod, and any two of them, in the representation of a notebook's cell too."""
    report = pp.crosscheck(builtin_scene(), states=5)
    (matrix,) = report.report().tables
    assert matrix.rows[-1][0] == "any two"
    assert all(line in repr(report) for line in matrix.lines())


def test_the_matrix_marks_what_is_broken() -> None:
    """In its cell, in the verdict, and short however many routes there are."""
    mine = {f"own route number {i}": lambda rod, q, v, g: {"R1": np.full(5, np.nan)} for i in range(30)}
    report = pp.crosscheck(builtin_scene(), states=5, routes=mine)
    assert "!nan" in str(report)
    assert "BROKEN" in str(report)
    assert "disagree in R1" in repr(report)
    assert len(repr(report)) < 1000
    (matrix,) = report.report().tables
    assert max(map(len, matrix.lines())) <= 80
    assert f"... and {len(matrix.rows) - FEW} more" in repr(report)


@pytest.mark.parametrize(
    ("routes", "said"),
    [
        (5, "routes: 5 is not a mapping"),
        ({"own": 5}, "is not a mapping of names to functions"),
        ({"own": lambda *given: 5}, "routes: own returns 5, not a mapping"),
        ({"own": lambda *given: {"R1": [1.0, 2.0]}}, "routes: own: R1 has 2 values for 3 states"),
        ({"own": lambda *given: {"R1": "x"}}, "routes: own: R1: 'x' are not numbers"),
    ],
)
def test_routes_that_are_none_are_refused(routes, said: str) -> None:
    """In one line that names the route and the quantity."""
    with pytest.raises(pp.InputError, match=re.escape(said)):
        pp.crosscheck(builtin_scene(), states=3, routes=routes)
