"""A failed cross-check is exit status 1, whichever command finds it; the files are there all the same."""

from dataclasses import replace
from pathlib import Path

import pytest

import pendpin as pp
from bad_input import run_main
from pendpin.equations.chain import solution
from pendpin.motions.crosschecks.crosscheck import crosscheck_run

FAR = """
duration = 0.1
[model]
kind = "chain"
rods = [{{ length = {0}, mass = 1.0, radius = 1e-3 }}, {{ length = {1}, mass = 1.0, radius = 1e-3 }}]
[start]
positions = {{ theta_1 = 0.7, phi_1 = 0.4 }}
[[effects]]
kind = "gravity"
[solver]
samples = 3
"""


def test_a_broken_cross_check_is_status_1(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd) -> None:
    """A fault of 1e-6 in the chain equations: `check` and `run` both say so in one line."""
    right = solution.solve

    def faulty(*given, **named) -> solution.ChainSolution:
        found = right(*given, **named)
        return replace(found, acceleration=found.acceleration * (1 + 1e-6))

    monkeypatch.setattr(solution, "solve", faulty)
    monkeypatch.chdir(tmp_path)
    Path("scene.toml").write_text(FAR.format(1.0, 0.5))
    assert run_main("check", "scene.toml", "--states", "20") == 1
    assert "BROKEN" in capfd.readouterr().out
    for extra in ((), ("--json",)):
        assert run_main("run", "scene.toml", *extra) == 1
        out, err = capfd.readouterr()
        assert err.startswith("pendpin: the cross-check along the run failed: ")
        assert err.count("\n") == 1
        assert ('"crosscheck_ok": false' if extra else "BROKEN") in out
        assert Path("run.npz").is_file()


def test_equations_that_doubles_do_not_hold_are_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd
) -> None:
    """The other way round the mass matrix is singular: no comparison, no traceback."""
    monkeypatch.chdir(tmp_path)
    Path("scene.toml").write_text(FAR.format(1.0, 1e45))
    assert run_main("check", "scene.toml", "--states", "20") == 1
    assert capfd.readouterr().err.count("\n") == 1


@pytest.mark.parametrize(("light", "radius", "status"), [("1e-8", "1e-3", 0), ("1e-20", "0", 1)])
def test_masses_that_differ_too_much(
    light: str, radius: str, status: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd
) -> None:
    """A run that no second route can check is kept; where the equations have no solution at the start, one line says so."""
    monkeypatch.chdir(tmp_path)
    heavy = f"{1 / float(light):g}"
    text = FAR.format(1.0, 1.0).replace("mass = 1.0", f"mass = {light}", 1).replace("mass = 1.0", f"mass = {heavy}", 1)
    text = text.replace("radius = 1e-3", f"radius = {radius}").replace("duration = 0.1", "duration = 1.0")
    text = text.replace("theta_1 = 0.7, phi_1 = 0.4", "theta_1 = 1.0")
    Path("scene.toml").write_text(text)
    assert run_main("run", "scene.toml") == status
    assert Path("run.npz").is_file() == (status == 0)
    err = capfd.readouterr().err
    assert err.count("\n") == status
    assert status == 0 or "start: no finite reactions at rod 1" in err


@pytest.mark.parametrize("length", [1e-12, 1e-3, 1.0, 1e6, 1e45])
@pytest.mark.parametrize("count", [1, 2])
def test_size_alone_breaks_nothing(length: float, count: int) -> None:
    """Rods of any one size: the routes agree along the run as they do at 1 m."""
    rod = pp.Rod(length=length, mass=1.0, radius=0.05 * length)
    scene = pp.Scene(
        duration=2 * length**0.5,
        model=pp.Chain(rods=(rod,) * count),
        start=pp.Start(positions=(0.7, 0.4) * count),
        effects=(pp.effects.Gravity(),),
        solver=pp.Solver(samples=9),
    )
    report = crosscheck_run(pp.simulate(scene))
    assert report is not None
    assert report.ok, report.fault
