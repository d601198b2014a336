"""What accuracy costs: the references disagree where one is broken, errors fall along every ladder, words fit numbers."""

import json
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pendpin as pp
from bad_input import run_main
from pendpin import effects as fx
from pendpin.dynamics import compiling
from pendpin.engines import Compiled
from pendpin.ground.libraries import Recent
from pendpin.integrators import taylor
from pendpin.runs import preparation
from pendpin.runs import simulate as runs_by_setting
from pendpin.verification.work_precision import cost as work_precision
from pendpin.verification.work_precision import references
from pendpin.verification.work_precision.cost import cost
from pendpin.verification.work_precision.references import by_elliptic_functions, by_runge_kutta, by_series, reference
from pendpin.verification.work_precision.report import CostReport, Curve
from scenes import scene_of

needs_heyoka = pytest.mark.skipif(find_spec("heyoka") is None, reason="not installed: heyoka")
THIN, THICK = pp.Rod(length=1.0, mass=1.0), pp.Rod(length=1.0, mass=1.0, radius=0.05)
START = pp.Start(positions={"theta_1": 0.7, "phi_1": 0.4}, velocities={"theta_1": 1.3, "phi_1": -0.8})


def scene(*rods: pp.Rod, duration: float = 2.0, effects: tuple = (fx.Gravity(),), start: pp.Start = START) -> pp.Scene:
    return scene_of(rods, *effects, duration=duration, samples=41).replace(start=start)


# --- references -----------------------------------------------------------------------------------------------------


@needs_heyoka
@pytest.mark.parametrize(
    ("given", "families"),
    [
        (scene(THIN), ("elliptic functions", "power series")),
        (scene(THICK, start=pp.Start(positions={"theta_1": 2.0})), ("elliptic functions", "power series")),
        (scene(THICK, start=pp.Start(positions={"phi_1": -1.0})), ("elliptic functions", "power series")),
        (scene(THICK), ("power series", "Runge-Kutta")),
        (scene(THIN, THICK, effects=(fx.Gravity(), fx.Viscous(coefficient=0.1))), ("power series", "Runge-Kutta")),
        (scene(THICK, effects=(fx.Gravity(), fx.Drag())), ("Runge-Kutta", "collocation")),
        (scene(THICK, effects=(fx.Gravity(), fx.DryFriction(kinetic=0.1))), ("Runge-Kutta", "collocation")),
    ],
)
def test_two_families_agree(given: pp.Scene, families: tuple[str, str]) -> None:
    """Every reference comes from two families of methods, which agree to what was asked for over the whole run."""
    found = reference(given, 1e-9)
    assert found.horizon == given.duration
    assert found.error <= 1e-9
    assert all(solution.startswith(family) for solution, family in zip(found.solutions, families, strict=True))


@needs_heyoka
@pytest.mark.parametrize("fault", [1e-9, 1e-6, 1e-2])
@pytest.mark.parametrize("broken", [by_elliptic_functions, by_series, by_runge_kutta])
def test_a_broken_reference_is_refused(broken, fault: float) -> None:
    """A gravity that is off by a share of 1e-9 in one of the two: they contradict each other, and nothing is compared."""
    whole, other = scene(THIN), by_series if broken is by_runge_kutta else by_runge_kutta
    heavier = replace_gravity(whole, 9.81 * (1 + fault))

    def faulty(given, limit):
        return broken(heavier.model_copy(update={"solver": given.solver}), limit)

    with pytest.raises(pp.InputError, match="one of them is wrong"):
        reference(whole, 1e-10, (faulty, other))


def replace_gravity(given: pp.Scene, acceleration: float) -> pp.Scene:
    return given.model_copy(update={"effects": (fx.Gravity(acceleration=acceleration),)})


@pytest.mark.slow
@needs_heyoka
def test_chaos_has_a_horizon() -> None:
    """The horizon of a fast double pendulum is some seconds, and shorter for a finer accuracy; the report says so."""
    wild = scene(THICK, THICK, duration=40.0, start=pp.Start(positions=[2.0, 0.3, -1.0, 0.5], velocities=[3, 1, -2, 4]))
    near, far = (reference(wild, error) for error in (1e-10, 1e-4))
    assert 0 < near.horizon < far.horizon < 40.0
    assert near.error <= 1e-10 < far.error <= 1e-4


def test_without_a_second_family_there_is_no_reference() -> None:
    with pytest.raises(pp.InputError, match=r"two families of methods.*only 1"):
        reference(scene(THICK), 1e-9, (by_elliptic_functions, by_runge_kutta))


# --- a clock that counts work -----------------------------------------------------------------------------------


COMPILING = 0.05  # s


class Clock:
    """Processor time that advances by 2 us with each evaluation of a measured run, and by `every` s with each look at it."""

    def __init__(self) -> None:
        self.now, self.every = 0.0, 0.0

    def process_time(self) -> float:
        """The processor time, s."""
        self.now += self.every
        return self.now


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """Runs whose seconds are counts of evaluations, 2 us each, so that a ladder ends at the same rung on any machine."""
    clock = Clock()

    def run(*given, **options) -> pp.Trajectory:
        found = pp.simulate(*given, **options)
        seconds = 2e-6 * (found.stats.evaluations + 1)
        clock.now += seconds
        compiling = COMPILING * ("compiled" in found.stats.engine)
        return replace(found, stats=replace(found.stats, seconds=seconds, compile_seconds=compiling))

    monkeypatch.setattr(runs_by_setting, "time", clock)
    monkeypatch.setattr(work_precision, "run_to_setting", run)
    monkeypatch.setattr(work_precision, "_compiled_in", lambda scene: 0.0)
    return clock


def test_a_method_is_measured_as_it_is_run(counted: Clock, monkeypatch: pytest.MonkeyPatch) -> None:
    """A plain name runs what `simulate` runs under it, on the engine that the scene names or that is chosen."""
    engines, run_to_setting = set(), work_precision.run_to_setting

    def run(scene: pp.Scene, **given: Any) -> pp.Trajectory:
        result = run_to_setting(scene, **given)
        engines.add((scene.solver.method, result.stats.engine))
        return result

    monkeypatch.setattr(work_precision, "run_to_setting", run)
    for engine in ("auto", "chain", "pinocchio"):
        given = scene(THICK, duration=0.2).with_solver(engine=engine)
        cost(given, methods=["rk45", "radau", "rk45 not compiled"], repetitions=0)
        plain = {(name, pp.simulate(given, method=name).stats.engine) for name in ("dop853", "rk45", "radau")}
        called = "chain" if engine == "chain" else "pinocchio"
        assert engines == plain | {("rk45", pp.simulate(given.with_solver(engine=called), method="rk45").stats.engine)}
        engines.clear()


# --- ladders --------------------------------------------------------------------------------------------------------


@needs_heyoka
def test_errors_fall_along_every_ladder(counted: Clock) -> None:
    """Over eight decades of error and more for the adaptive methods of high order; each with its points and counts."""
    methods = ("taylor", "dop853", "lsoda", "radau", "rk4", "dop853 not compiled", "rk4 not compiled", "gauss6")
    report = cost(scene(THICK), methods=methods, accuracy=1e-9, thorough=True, repetitions=1, budget=0.3)
    assert [curve.name for curve in report.curves] == list(methods)
    for curve in report.curves:
        errors = np.array([point.error for point in curve.points if point.error > 3 * report.error])
        assert len(errors) >= 3
        assert errors[-1] < 1e-3 * errors[0]
        assert all(point.steps > 0 and point.evaluations > 0 and point.seconds > 0 for point in curve.points)
    for name in ("taylor", "dop853", "lsoda"):
        errors = [point.error for point in curve_of(report, name).points]
        assert min(errors) < 1e-8 * max(errors)
    assert curve_of(report, "dop853 not compiled").compile_seconds == 0 < curve_of(report, "dop853").compile_seconds
    np.testing.assert_allclose(
        [point.error for point in curve_of(report, "rk4 not compiled").points[:4]],
        [point.error for point in curve_of(report, "rk4").points[:4]],
        rtol=1e-4,
    )


def curve_of(report: CostReport, name: str) -> Curve:
    return next(curve for curve in report.curves if curve.name == name)


def test_a_method_that_fails_says_why(counted: Clock) -> None:
    report = cost(
        scene(THICK, effects=(fx.Gravity(), fx.Drag())),
        methods=["taylor", "dop853"],
        thorough=True,
        repetitions=1,
        budget=0.2,
    )
    taylor, dop853 = report.curves
    assert not taylor.points
    assert "drag is not smooth" in taylor.failures[0] or "needs heyoka" in taylor.failures[0]
    assert dop853.points


# --- answers --------------------------------------------------------------------------------------------------------


@needs_heyoka
def test_each_accuracy_is_answered(counted: Clock) -> None:
    """Rows come from coarse to fine, each run that they name meets its accuracy, and the report repeats them."""
    report = cost(scene(THICK), methods=("taylor", "dop853", "gauss6", "rk4"), accuracy=1e-8, repetitions=1)
    assert [row.accuracy for row in report.rows] == [1e-3, 1e-6, 1e-8, 1e-9, 1e-12]
    for row in report.rows:
        taken = next(point for point in curve_of(report, row.method).points if point.setting == row.setting)
        assert taken.error <= row.accuracy
        assert row.first_seconds == row.seconds + curve_of(report, row.method).compile_seconds
        assert row.method in row.take
        assert row.take in repr(report)
    assert len(repr(report)) < 1000


@needs_heyoka
def test_what_is_left_out_is_not_the_cheapest(counted: Clock) -> None:
    """A quick report takes a fraction of the work of a thorough one and names no dearer run, up to a tolerance's decade."""
    methods = ["dop853", "lsoda", "dop853 not compiled", "rk45", "rk4"]
    quick, took = cost(scene(THICK), methods=methods), counted.now
    whole = cost(scene(THICK), methods=methods, thorough=True, repetitions=0, budget=0.2)
    assert took < (counted.now - took) / 2
    assert not quick.thorough
    for row in quick.rows:
        best = whole.best(row.accuracy)
        assert row.seconds is not None
        assert best is not None
        assert row.seconds <= 1.5 * best[1]


def test_a_quick_report_ends_in_time(counted: Clock) -> None:
    """Each look at the clock costs time: fewer runs are made, a part of the scene is compared, and the report says so."""
    counted.every = every = 0.1
    report = cost(scene(THICK, duration=100.0), methods=["dop853"])
    assert counted.now < work_precision.LIMIT + 4 * work_precision.OF_REFERENCE + 20 * every
    assert report.halted
    assert report.horizon < 100.0
    assert "--thorough" in " ".join(report.words)
    assert report.rows[0].seconds
    assert all(row.seconds or row.why for row in report.rows)
    counted.every = 1.0
    with pytest.raises(pp.InputError, match="the first output time takes too long"):
        cost(scene(THICK, duration=1000.0))


@needs_heyoka
@pytest.mark.parametrize(
    "positions", [{"theta_1": 0.7}, {"theta_1": 0.7, "phi_2": 0.4}], ids=["in a plane", "in space"]
)
def test_a_first_run_counts_its_compiling_whichever_run_that_was(
    positions: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the second report on a scene nothing is compiled: its first runs count what the process has stored."""
    pytest.importorskip("llvmlite")
    functions = Recent[Any](10)
    monkeypatch.setattr(compiling, "_known", functions)
    preparation.known_runs.known.clear()
    preparation.known_dynamics.known.clear()
    given = scene(THICK, THICK, duration=0.2, start=pp.Start(positions=positions))
    for _ in range(2):
        report = cost(given, methods=["taylor", "dop853", "dop853 not compiled"], repetitions=1)
        for point in curve_of(report, "taylor").points:
            stored = [
                function.series[point.setting].compile_seconds
                for function in functions.known.values()
                if function.series
            ]
            least = taylor.start_compiler() + min(stored)
            assert point.first_seconds - point.seconds >= least * (1 - 1e-9) > 0
        for point in curve_of(report, "dop853").points:
            stored = [function.compile_seconds for function in functions.known.values() if function.compile_seconds]
            assert point.first_seconds - point.seconds >= min(stored) * (1 - 1e-9) > 0
        assert curve_of(report, "dop853 not compiled").compile_seconds == 0


def test_machine_code_of_other_equations_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A quick reference is made on the compiled recursion alone: if that differs from Pinocchio, nothing is compared."""
    pytest.importorskip("llvmlite")
    run, right = pp.simulate(scene(THICK)), Compiled.derivative
    references.refuse_other_equations(scene(THICK), run)

    def wrong(engine: Compiled, progress: Any) -> Any:
        derivative, count = right(engine, progress)

        def scaled(dy: np.ndarray, t: float, y: np.ndarray) -> None:
            derivative(dy, t, y)
            dy *= 1 + 1e-8

        return scaled, count

    monkeypatch.setattr(Compiled, "derivative", wrong)
    with pytest.raises(pp.InputError, match=r"compiled and pinocchio differ by 1\.0e-08"):
        references.refuse_other_equations(scene(THICK), run)


@needs_heyoka
def test_the_command(
    counted: Clock, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    """A table with words, JSON with every point, a figure; a bad name is refused in one line."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")  # wide enough for headings of one line
    short = ["--methods", "taylor,dop853", "--budget", "0.1"]
    assert run_main("cost", *short) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if line.strip()]
    assert lines[0].split("  ")[0].strip() == "accuracy"
    assert [line.split()[0] for line in lines[1:6] if line.strip(" ─━-")][:4] == ["0.001", "1e-06", "1e-09", "1e-12"]
    assert run_main("cost", *short, "--thorough", "--plot", "cost.png") == 0
    assert "1e-09 costs" in capsys.readouterr().out
    assert (tmp_path / "cost.png").read_bytes().startswith(b"\x89PNG")
    assert run_main("cost", *short, "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert {curve["name"] for curve in found["curves"]} == {"taylor", "dop853"}
    assert found["error"] < 1e-10
    assert [row["accuracy"] for row in found["rows"]] == [1e-3, 1e-6, 1e-9, 1e-12]
    assert run_main("cost", "--methods", "magic") == 2
    assert "'magic' is not one of" in capsys.readouterr().err
