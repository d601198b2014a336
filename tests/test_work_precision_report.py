"""The report of work and precision, its sentences and its figure."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import pendpin as pp
from bad_input import contents
from pendpin.graphics.style import PALE
from pendpin.model.kinematics import tip_distance
from pendpin.runs import simulate as runs_by_setting
from pendpin.verification import simulators
from pendpin.verification.work_precision import references
from pendpin.verification.work_precision.references import by_elliptic_functions
from pendpin.verification.work_precision.report import CostReport, Curve, Point, cost_row, draw_cost
from test_work_precision import THICK, THIN, needs_heyoka, scene

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
    steps = tuple(Point(step, step**4, 1e-3 / step, 1, 1) for step in (0.1, 0.05, 0.01))  # of order 4
    assert Curve("rk4", "", "step", steps).setting_and_seconds_at(1e-6) == pytest.approx((10**-1.5, 10**-1.5))


def test_the_words_say_what_the_numbers_say() -> None:
    words = " ".join(REPORT.words)
    assert "Compared up to 5 s of 20 s" in words
    assert "Error of the reference: 1e-09, the difference of one and other." in words
    assert f"1e-06 costs {20 * 10**0.4:.3g} ms with fine; the next digit costs {10**0.1:.2f} times as much" in words
    assert "From 1e-01 to 1e-04 the cheapest is cheap." in words  # of the runs that were made: as the table
    assert "From 1e-05 to 1e-08 the cheapest is fine." in words
    for decade in REPORT.decades:
        taken = cost_row(REPORT.curves, decade, REPORT.error).method
        assert f"At {decade:.0e}: {taken} " in words or not taken
    assert "At 1e-04: cheap 10 ms, other 1 s, 100 times as long." in words
    assert "At 1e-06: fine" in words
    assert "no other simulator reaches it" in words


def test_a_row_without_a_run_says_why() -> None:
    """What refused the methods, where none ran; the time, where one did."""
    refused = Curve("taylor", "", "tolerance", (), failures=("taylor takes no stops",))
    slow = curve("rk4", (1e-2, 1.0))
    assert cost_row([refused], 1e-3, 0.0).take == "taylor takes no stops"
    assert cost_row([refused, slow], 1e-3, 0.0).take == "no method reaches it in the time allowed"


def test_the_figure_names_every_method_that_it_draws() -> None:
    """In colour in the legend, pale at its end; a method without an error that the reference can tell is not there."""
    pale = (
        curve("slow", (1e-2, 1.0), (1e-4, 2.0)),
        curve("point", (1e-2, 1.0)),
        curve("wrong", (2.0, 1.0), (3.0, 2.0)),
    )
    axes = draw_cost(replace(REPORT, curves=REPORT.curves + pale)).axes[0]
    assert {text.get_text() for text in axes.texts} & {"slow", "point", "wrong", "other"} == {"slow", "point", "other"}
    assert len([line for line in axes.lines if line.get_color() == PALE]) == 3
    assert axes.get_legend_handles_labels()[1] == ["fine", "cheap"]


def test_the_table_has_no_empty_column() -> None:
    """A fastest method for a single run, and other simulators, have a column where there are any."""
    row = cost_row(REPORT.curves, 1e-3, REPORT.error)
    other = {"peer": "mujoco rk4", "peer_seconds": 1.0}, {"once": "rk4", "once_seconds": 1e-3}
    for more in ({}, *other, other[0] | other[1]):
        table = replace(REPORT, thorough=False, rows=(replace(row, **more),)).report().tables[0]
        assert all(len(cells) == len(table.head) and all(cells) for cells in table.rows)


def test_the_figure_is_written_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every picture can be read to its end; one that fails half way leaves the old file as it was, and no other."""
    from matplotlib.figure import Figure
    from matplotlib.image import imread

    drawing = ElementTree.parse(REPORT.plot(tmp_path / "cost.svg")).getroot()
    lines = [
        group for group in drawing.iter("{http://www.w3.org/2000/svg}g") if group.get("id", "").startswith("line2d")
    ]
    assert len(lines) > len(REPORT.curves)
    picture = imread(REPORT.plot(tmp_path / "cost.png"))
    assert picture.shape == (744, 1440, 4)
    assert len(np.unique(picture.reshape(-1, 4), axis=0)) > 20
    before = contents(tmp_path)

    def fail(_: Figure, file: Any, **options: Any) -> None:
        file.write(b"half a picture")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Figure, "savefig", fail)
    for name in ("cost.svg", "cost.png", "new.pdf"):
        with pytest.raises(pp.InputError, match=f"{name}: cannot be written: No space left on device"):
            REPORT.plot(tmp_path / name)
    assert contents(tmp_path) == before


@needs_heyoka
def test_a_simulator_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """The others are compared all the same; SciPy is always there."""
    monkeypatch.setattr(simulators, "MODULES", {"mujoco": "no_such_module", "drake": "nor_this"})
    found = simulators.peers(scene(THICK))
    assert {peer.name.split()[0] for peer in found} == {"scipy"}
    words = " ".join(replace(REPORT, missing=simulators.missing()).words)
    assert "mujoco, drake" in words


def test_reference_solutions_are_independent(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a rod that all of them take, no two integrate by the same method, nor on the same equations, and all agree."""
    used: dict[references.Maker, set[tuple[str, str]]] = {}

    def recorded(*given, **options) -> pp.Trajectory:
        run = pp.simulate(*given, **options)
        used.setdefault(maker, set()).add((run.stats.method, run.stats.engine))
        return run

    monkeypatch.setattr(runs_by_setting, "run_to_setting", recorded)
    found = {}
    for maker in references.SOLUTIONS:
        found[maker] = maker(scene(THIN), np.inf)
    assert len(found) == 4
    assert by_elliptic_functions not in used  # it is no integration at all
    for one, other in combinations(used.values(), 2):
        assert not {method for method, _ in one} & {method for method, _ in other}
    assert len({engine for runs in used.values() for _, engine in runs}) > 1
    for one, other in combinations(found.values(), 2):
        known = (one.doubt + other.doubt).max() + one.rounding + other.rounding
        assert tip_distance(one.tips, other.tips, 1.0).max() <= references.CONTRADICTION * known


def test_no_point_is_advised_that_another_beats() -> None:
    """In error and in time: of random points of three methods the row of an accuracy is the cheapest that meets it."""
    random = np.random.default_rng(5)
    for _ in range(200):
        curves = [curve(str(i), *map(tuple, 10.0 ** random.uniform(-9, 0, (6, 2)))) for i in range(3)]
        points = [point for one in curves for point in one.points]
        found = cost_row(curves, 1e-5, 0.0)
        meeting = [point for point in points if point.error <= 1e-5]
        assert found.seconds == (min(point.seconds for point in meeting) if meeting else None)
