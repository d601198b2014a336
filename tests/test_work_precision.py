"""What accuracy costs: the references disagree where one is broken, errors fall along every ladder, words fit numbers."""

import json
from dataclasses import replace
from importlib.util import find_spec
from itertools import combinations
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import pendpin as pp
from bad_input import contents, run_main
from pendpin import effects as fx
from pendpin.analysis import simulators
from pendpin.analysis.work_precision import cost as work_precision
from pendpin.analysis.work_precision import processor_time, references
from pendpin.analysis.work_precision.cost import cost
from pendpin.analysis.work_precision.figure import save_cost_plot
from pendpin.analysis.work_precision.references import by_elliptic_functions, by_runge_kutta, by_series, reference
from pendpin.analysis.work_precision.report import CostReport, CostRow, Curve, Point
from pendpin.engines import Compiled
from pendpin.model.build import build
from pendpin.model.kinematics import tip_distance
from scenes import scene_of

needs_heyoka = pytest.mark.skipif(find_spec("heyoka") is None, reason="not installed: heyoka")
THIN, THICK = pp.Rod(length=1.0, mass=1.0), pp.Rod(length=1.0, mass=1.0, radius=0.05)
START = pp.Start(positions={"theta_1": 0.7, "phi_1": 0.4}, velocities={"theta_1": 1.3, "phi_1": -0.8})


def scene(*rods: pp.Rod, duration: float = 2.0, effects: tuple = (fx.Gravity(),), start: pp.Start = START) -> pp.Scene:
    return scene_of(rods, *effects, duration=duration, samples=41).replace(start=start)


def test_plain_methods_keep_the_engine_of_the_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every run of a curve has solver.engine as the scene has it; the curves named `compiled` have their own."""
    pytest.importorskip("llvmlite")
    engines = set()

    def simulate(scene: pp.Scene, **given: Any) -> pp.Trajectory:
        engines.add((scene.solver.method, scene.solver.engine))
        return pp.simulate(scene, **given)

    monkeypatch.setattr(work_precision, "run_to_setting", simulate)
    for engine in ("chain", "pinocchio"):
        given = scene(THICK, duration=0.2)
        given = given.model_copy(update={"solver": given.solver.replaced(engine=engine)})
        cost(given, methods=["rk45", "radau", "rk4 compiled"], repetitions=1, budget=0.0)
        assert engines == {("dop853", engine), ("rk45", engine), ("radau", engine), ("rk4", "compiled")}
        engines.clear()


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

    def faulty(given, model, length, limit):
        return broken(heavier.model_copy(update={"solver": given.solver}), model, length, limit)

    with pytest.raises(pp.InputError, match="one of them is wrong"):
        reference(whole, 1e-10, (faulty, other))


def replace_gravity(given: pp.Scene, acceleration: float) -> pp.Scene:
    return given.model_copy(update={"effects": (fx.Gravity(acceleration=acceleration),)})


@needs_heyoka
def test_chaos_has_a_horizon() -> None:
    """The horizon of a fast double pendulum is some seconds, and shorter for a finer accuracy; the report says so."""
    wild = scene(THICK, THICK, duration=40.0, start=pp.Start(positions=[2.0, 0.3, -1.0, 0.5], velocities=[3, 1, -2, 4]))
    near, far = (reference(wild, error) for error in (1e-10, 1e-4))
    assert 0 < near.horizon < far.horizon < 40.0
    assert near.error <= 1e-10 < far.error <= 1e-4


def test_without_a_second_family_there_is_no_reference() -> None:
    with pytest.raises(pp.InputError, match="two families of methods, and only 1"):
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
        return replace(
            found, stats=replace(found.stats, seconds=seconds, compile_seconds=0.1 * ("compiled" in str(given)))
        )

    monkeypatch.setattr(processor_time, "time", clock)
    monkeypatch.setattr(work_precision, "run_to_setting", run)
    monkeypatch.setattr(work_precision, "_compiled_in", lambda scene: 0.0)
    return clock


# --- ladders --------------------------------------------------------------------------------------------------------


@needs_heyoka
def test_errors_fall_along_every_ladder(counted: Clock) -> None:
    """Over eight decades of error and more for the adaptive methods of high order; each with its points and counts."""
    methods = ("taylor", "dop853", "lsoda", "radau", "rk4", "dop853 compiled", "rk4 compiled", "gauss6")
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
    assert curve_of(report, "dop853").compile_seconds == 0 < curve_of(report, "dop853 compiled").compile_seconds
    np.testing.assert_allclose(
        [point.error for point in curve_of(report, "rk4 compiled").points[:4]],
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
    answered: list[CostRow] = []
    report = cost(scene(THICK), accuracy=1e-8, repetitions=1, answered=answered.append)
    assert tuple(answered) == report.rows
    assert [row.accuracy for row in answered] == [1e-3, 1e-6, 1e-8, 1e-9, 1e-12]
    for row in answered:
        taken = next(point for point in curve_of(report, row.method).points if point.setting == row.setting)
        assert taken.error <= row.accuracy
        assert row.first_seconds == row.seconds + COMPILING * ("compiled" in row.method)
        assert row.method in row.take
        assert row.take in repr(report)
    assert len(repr(report)) < 1000


@needs_heyoka
def test_what_is_left_out_is_not_the_cheapest(counted: Clock) -> None:
    """A quick report takes a fraction of the work of a thorough one and names no dearer run, up to a tolerance's decade."""
    methods = ["dop853 compiled", "lsoda compiled", "dop853", "rk45", "rk4"]
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
    assert "more takes long" in " ".join(report.words)
    assert report.rows[0].seconds
    assert all(row.seconds or row.why for row in report.rows)
    counted.every = 1.0
    with pytest.raises(pp.InputError, match="the first output time takes too long"):
        cost(scene(THICK, duration=1000.0))


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


# --- the report -----------------------------------------------------------------------------------------------------


def curve(name: str, *points: tuple[float, float], peer: bool = False) -> Curve:
    return Curve(name, "", "tolerance", tuple(Point(1e-3, error, time, 1, 1) for error, time in points), peer=peer)


REPORT = CostReport(
    subject="2 rods",
    curves=(
        curve("cheap", (1e-2, 1e-3), (1e-4, 1e-2), (1e-6, 1e-1)),
        curve("fine", (1e-2, 2e-2), (1e-8, 2e-2 * 10**0.6)),
        curve("other", (1e-1, 1.0), (1e-4, 1.0), peer=True),
    ),
    accuracy=1e-6,
    error=1e-9,
    solutions=("one", "other"),
    duration=20.0,
    horizon=5.0,
    machine="",
    versions={},
    repetitions=3,
)


def test_times_between_the_points() -> None:
    """In proportion of logarithms; never beyond the finest point; a dearer and coarser point counts for nothing."""
    cheap, fine = REPORT.curves[:2]
    assert cheap.seconds_at(1e-3) == pytest.approx(10**-2.5)
    assert cheap.seconds_at(0.5) == 1e-3
    assert cheap.seconds_at(1e-7) is None
    worse = replace(cheap, points=(*cheap.points, Point(1e-9, 1e-3, 5.0, 1, 1)))
    assert worse.seconds_at(1e-5) == cheap.seconds_at(1e-5)
    assert fine.seconds_at(1e-7) == pytest.approx(2e-2 * 10**0.5)


def test_the_words_say_what_the_numbers_say() -> None:
    words = " ".join(REPORT.words)
    assert "Compared up to 5 s of 20 s" in words
    assert "Error of the reference: 1e-09, the difference of one and other." in words
    assert f"1e-06 costs {20 * 10**0.4:.3g} ms with fine; the next digit costs {10**0.1:.2f} times as much" in words
    assert "From 1e-01 to 1e-05 the cheapest is cheap." in words
    assert "From 1e-06 to 1e-08 the cheapest is fine." in words
    assert "At 1e-04: cheap 10 ms, other 1 s, 100 times as long." in words
    assert "At 1e-06: fine" in words
    assert "no other simulator reaches it" in words


@needs_heyoka
def test_the_command(
    counted: Clock, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    """A table with words, JSON with every point, a figure; a bad name is refused in one line."""
    monkeypatch.chdir(tmp_path)
    short = ["--methods", "taylor,dop853", "--budget", "0.1"]
    assert run_main("cost", *short) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split("  ")[0] == "accuracy"
    assert [line.split()[0] for line in lines[1:5]] == ["0.001", "1e-06", "1e-09", "1e-12"]
    assert run_main("cost", *short, "--thorough", "--plot", "cost.png") == 0
    assert "1e-09 costs" in capsys.readouterr().out
    assert (tmp_path / "cost.png").read_bytes().startswith(b"\x89PNG")
    assert run_main("cost", *short, "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert {curve["name"] for curve in found["curves"]} == {"taylor", "dop853"}
    assert found["error"] < 1e-10
    assert [row["accuracy"] for row in found["rows"]] == [1e-3, 1e-6, 1e-9, 1e-12]
    assert run_main("cost", "--methods", "magic") == 1
    assert "'magic' is not one of" in capsys.readouterr().err


def test_the_figure_is_written_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every picture can be read to its end; one that fails half way leaves the old file as it was, and no other."""
    from matplotlib.figure import Figure
    from matplotlib.image import imread

    drawing = ElementTree.parse(save_cost_plot(REPORT, tmp_path / "cost.svg")).getroot()
    lines = [
        group for group in drawing.iter("{http://www.w3.org/2000/svg}g") if group.get("id", "").startswith("line2d")
    ]
    assert len(lines) > len(REPORT.curves)
    picture = imread(save_cost_plot(REPORT, tmp_path / "cost.png"))
    assert picture.shape == (744, 1200, 4)
    assert len(np.unique(picture.reshape(-1, 4), axis=0)) > 20
    before = contents(tmp_path)

    def fail(_: Figure, file: Any, **options: Any) -> None:
        file.write(b"half a picture")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Figure, "savefig", fail)
    for name in ("cost.svg", "cost.png", "new.pdf"):
        with pytest.raises(pp.InputError, match=f"{name}: cannot be written: No space left on device"):
            save_cost_plot(REPORT, tmp_path / name)
    assert contents(tmp_path) == before


@needs_heyoka
def test_a_simulator_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """The others are compared all the same; SciPy is always there."""
    monkeypatch.setattr(simulators, "MODULES", {"mujoco": "no_such_module", "drake": "nor_this"})
    found = simulators.peers(scene(THICK))
    assert {peer.name.split()[0] for peer in found} == {"scipy"}
    words = " ".join(replace(REPORT, missing=simulators.missing()).words)
    assert "Not among the others: mujoco, drake, not installed" in words


def test_reference_solutions_are_independent(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a rod that all of them take, no two integrate by the same method, nor on the same equations, and all agree."""
    used: dict[str, set[tuple[str, str]]] = {}

    def recorded(*given, **options) -> pp.Trajectory:
        run = pp.simulate(*given, **options)
        used.setdefault(name, set()).add((run.stats.method, run.stats.engine))
        return run

    monkeypatch.setattr(processor_time, "run_to_setting", recorded)
    model, found = build(scene(THIN).model), {}
    for maker in references.SOLUTIONS:
        name = maker.__name__
        found[name] = maker(scene(THIN), model, 1.0, np.inf)
    assert len(found) == 4
    assert by_elliptic_functions.__name__ not in used  # it is no integration at all
    for one, other in combinations(used.values(), 2):
        assert not {method for method, _ in one} & {method for method, _ in other}
    assert len({engine for runs in used.values() for _, engine in runs}) > 1
    for one, other in combinations(found.values(), 2):
        known = (one.doubt + other.doubt).max() + one.rounding + other.rounding
        assert tip_distance(one.tips, other.tips, 1.0).max() <= references.CONTRADICTION * known
