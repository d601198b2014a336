"""Printed numbers: tables, reports and pages are read back as numbers, and are those of the objects that they show."""

import base64
import html
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pendpin as pp
from bad_input import run_main
from pendpin.cli.inputs import MOST_NOTES, SceneInput
from pendpin.cli.outputs import print_report
from pendpin.effects import Gravity, Stop, Viscous
from pendpin.graphics.page import contents
from pendpin.graphics.report import page_report, run_report
from pendpin.graphics.run_drawing import drawing_of
from pendpin.ground.report import FEW, Report, Table
from pendpin.model.build import build
from pendpin.model.kinematics import scale
from pendpin.scene import builtin_scene
from pendpin.stability.linearize import stability
from pendpin.stability.lyapunov import Lyapunov
from pendpin.sweeps.figure import sweep_report
from pendpin.sweeps.significance import EffectRow, EffectsReport
from pendpin.trajectory.columns import unit_of
from pendpin.verification.agreement import AgreementReport, Comparison, published_cases, validate
from pendpin.verification.hardcases import CASES, HardReport, Outcome, catalogue_report
from pendpin.verification.work_precision.report import CostReport, CostRow, Curve, Point, cost_row, draw_cost

UNITS = {"s": 1.0, "ms": 1e-3, "µs": 1e-6}
MOST_EVENTS = 5  # in the list, here
NUMBER = r"[-+]?(?:\d+\.?\d*(?:e[-+]?\d+)?|nan|inf)"
DIGITS = 5e-3  # of a number with three digits


def numbers(text: str) -> list[float]:
    """All numbers in a text."""
    return [float(x) for x in re.findall(rf"(?<![\w.]){NUMBER}", text)]


def seconds(text: str) -> float:
    """A time with its unit."""
    value, unit = re.search(rf"({NUMBER}) (s|ms|µs)(?!\w)", text).groups()
    return float(value) * UNITS[unit]


def column(table: Table, title: str) -> list[str]:
    """The cells below a title."""
    place = list(table.head).index(title)
    return [cells[place] for cells in table.rows]


def rows_of(report: Report) -> dict[str, str]:
    """A table of two columns."""
    return dict(report.tables[0].rows)


def close(digits: float = DIGITS, **more: Any) -> Any:
    """How far a printed number may be off."""
    return lambda value: pytest.approx(value, rel=digits, **more)


def swing(*effects: Any, **given: Any) -> pp.Scene:
    """A rod that swings."""
    rod = pp.Chain(rods=[pp.Rod(length=1.0, mass=2.0, radius=0.05)])
    start = pp.Start(positions={"theta": 0.7, "phi": 0.4})
    return pp.Scene(model=rod, start=start, effects=[Gravity(), *effects], **given)


# --- reports and their printers -------------------------------------------------------------------------------------


def test_a_table_is_printed_alike(capsys: pytest.CaptureFixture, monkeypatch: pytest.MonkeyPatch) -> None:
    """As text, as HTML and on the terminal the cells of a table are the same, in the same places."""
    monkeypatch.setenv("COLUMNS", "120")
    rows = [("one", "1.5", "3.25 s"), ("<two>", "-2e-05", "4 ms")]
    report = Report(["before", Table(("name", "value", "time"), rows, more=3), "after & all"], {"x": float("nan")})
    print_report(report, as_json=False)
    terminal = [line.rstrip() for line in capsys.readouterr().out.splitlines() if "─" not in line]
    text = str(report).splitlines()
    for lines in (text, terminal):
        assert lines[0] == "before"
        assert [tuple(re.split(r"\s{2,}", line)) for line in lines[1:4]] == [("name", "value", "time"), *rows]
        assert lines[4:] == ["... and 3 more", "after & all"]
    page = report._repr_html_()
    cells = [html.unescape(cell) for cell in re.findall(r"<t[dh]>(.*?)</t[dh]>", page)]
    assert cells == ["name", "value", "time", *rows[0], *rows[1]]
    assert [html.unescape(part) for part in re.findall("<p>(.*?)</p>", page)] == [
        "before",
        "... and 3 more",
        "after & all",
    ]
    print_report(report, as_json=True)
    assert '"x": null' in capsys.readouterr().out


def test_rows_that_are_left_out_are_counted() -> None:
    """In a representation, and in a table that was cut already."""
    table = Table(("n",), [(str(i),) for i in range(FEW + 4)], more=5)
    assert table.first(FEW).more == 4 + 5
    assert table.first(FEW).rows == table.rows[:FEW]
    assert table.first(100) == table
    assert repr(Report([table], None)).splitlines()[-1] == "... and 9 more"
    assert repr(Report([table], None, "broken")).startswith("broken\n")


def test_notes_that_are_left_out_are_counted(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    """Before a table: the first finding and the number of others, the first notes and the number of others."""
    model = SimpleNamespace(findings=["a", "b", "c"])
    monkeypatch.setattr("pendpin.model.build.build", lambda _: model)
    monkeypatch.setattr("pendpin.model.notes.notes", lambda *_: [f"note of {i}" for i in range(MOST_NOTES + 3)])
    with SceneInput(swing(), None, None, strict=False).noted():
        pass
    first, *others, last = capsys.readouterr().err.splitlines()
    assert numbers(first) == [len(model.findings) - 1]
    assert (len(others), numbers(last)) == (MOST_NOTES, [3])


# --- what a run says ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("effects", [(), (Viscous(coefficient=0.3),)], ids=["conservative", "damped"])
@pytest.mark.parametrize("balance", [False, True])
def test_the_rows_of_a_run_are_its_numbers(effects: tuple, balance: bool) -> None:
    """On the terminal and on the page; the works add up to the change of the kinetic energy, with its sign."""
    run = pp.simulate(swing(*effects, duration=0.2), samples=21, energy_balance=balance)
    page = page_report([run], lambda _: "checked")
    on_page = {
        html.unescape(name): html.unescape(cell) for name, cell in re.findall(r"<th>(.*?)</th><td>(.*?)</td>", page)
    }
    change = run.kinetic[-1] - run.kinetic[0]
    assert change > 0.1  # it falls
    for rows in (rows_of(run_report(run, "checked")), on_page):
        assert numbers(rows["method"])[:1] == [run.stats.tolerance]
        steps, evaluations, time = numbers(rows["cost"])
        assert (steps, evaluations) == (run.stats.steps, run.stats.evaluations)
        assert time == pytest.approx(run.stats.seconds, abs=6e-5)
        assert rows["cross-check"] == "checked"
        total = run.energy().total
        if run.stats.conservative:
            assert numbers(rows["energy drift"])[0] == close(0.06)(run.energy().drift)
        elif not balance:
            assert numbers(rows["energy change"])[0] == close(1e-5)(total[-1] - total[0])
        if balance:
            works = {kind: numbers(rows[f"work of {kind}"])[0] for kind in run.work}
            assert works == {kind: close(1e-5)(work[-1]) for kind, work in run.work.items()}
            assert numbers(rows["kinetic energy"])[0] == close(1e-5)(change)
            assert sum(works.values()) == pytest.approx(numbers(rows["kinetic energy"])[0], rel=1e-4)
            assert numbers(rows["energy balance off by"])[0] == pytest.approx(run.imbalance, rel=0.06)
    for name, figure in run.summary().items():
        assert numbers(on_page[name])[0] == close(1e-5, abs=1e-300)(figure.value)
        assert figure.time is None or close(1e-5)(figure.time) == numbers(on_page[name])[1]
    assert run_report(run, "").data["summary"]["largest swing"]["value"] == run.summary()["largest swing"].value


TWO = pp.Chain(rods=[pp.Rod(length=1.0, mass=2.0, radius=0.05), pp.Rod(length=0.5, mass=1.0, radius=0.02)])


@pytest.fixture(scope="module")
def double() -> pp.Trajectory:
    """Two rods that swing in space."""
    return pp.simulate(swing(duration=0.5).replace(model=TWO, start=pp.Start(positions=[0.7, 0.4, -0.3, 0.9])))


def test_the_lines_of_a_figure_are_the_quantities_of_the_run(double: pp.Trajectory) -> None:
    """By the names in its legends: each panel, and each rod in it."""
    exact = {"kinetic": double.kinetic, "potential*": double.potential - double.potential.min()}
    exact |= {"energy": double.kinetic + exact["potential*"]} | {name: double[name] for name in double.joints}
    by_rod = {"tension R3 (N)": double.reactions().R3, "moment M3 (N m)": double.reactions().M3}
    seen = set()
    for ax in double.plot().axes:
        for line in ax.lines:
            name, unit = str(line.get_label()), ax.get_ylabel()
            if name.startswith("rod"):
                np.testing.assert_array_equal(line.get_ydata(), by_rod[unit][:, int(name[-1]) - 1])
            elif name in exact:
                np.testing.assert_array_equal(line.get_ydata(), exact[name])
            seen |= {(unit, name)} if name.startswith("rod") or name in exact else set()
    assert len(seen) == 3 + 4 + 2 * len(by_rod)


def test_the_curves_of_a_page_are_the_quantities_of_the_run(
    double: pp.Trajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To one level in 65,535; the potential is drawn from its least; how many quantities are left out is said."""
    drawn = contents(drawing_of(double))
    for curve in drawn["curves"]["quantities"]:
        levels = np.frombuffer(base64.b64decode(curve["data"]), "<u2") / 65535
        shown = curve["low"] + (curve["high"] - curve["low"]) * levels
        np.testing.assert_allclose(shown, double[curve["name"]], atol=(curve["high"] - curve["low"]) / 65535)
        assert curve["unit"] == unit_of(double, curve["name"])
    energies = next(plot["curves"] for plot in drawn["plots"] if plot["title"].startswith("Energy"))
    least = double.potential.min()
    assert {c["name"]: c["minus"] for c in energies} == {"kinetic": 0.0, "potential": least, "energy": least}
    assert drawing_of(double).notes == ()
    monkeypatch.setattr("pendpin.graphics.run_drawing.MOST_QUANTITIES", 7)
    assert numbers(drawing_of(double).notes[0]) == [7, len(double.names) - 1]


def test_the_answers_of_a_run_are_those_of_its_motion() -> None:
    """The largest swing and what is left of it after half the time, if that is less, from the samples of the run itself."""
    run = pp.simulate(swing(Viscous(coefficient=0.3), duration=4.0), samples=4001)
    rows = rows_of(run_report(run, ""))
    first, _, later = numbers(rows["largest swing"])
    bodies = np.degrees(run["swing"])
    assert first == close(1e-5)(bodies.max())
    assert later == close(1e-3)(bodies[len(run.t) // 2 :].max())
    assert numbers(rows["R3 largest"])[0] == close(1e-4)(run["R3"].max())
    rising = pp.simulate(swing(duration=0.3).replace(start=pp.Start(velocities={"theta": 1.0})))
    assert "after half the time" not in rows_of(run_report(rising, ""))["largest swing"]  # which is the largest of all


def test_an_accuracy_is_printed_as_asked_and_estimated() -> None:
    """And the time with all runs that the search made."""
    run = pp.simulate(swing(duration=0.5), accuracy=1e-5, samples=11)
    rows = rows_of(run_report(run, ""))
    estimated, asked = numbers(rows["accuracy"])
    assert estimated == close(0.06)(run.stats.error)
    assert asked == 1e-5
    assert numbers(rows["cost"])[3] == pytest.approx(run.stats.all_seconds, abs=6e-5)


def test_events_are_listed_and_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """As many as there are: those in the list, and those that are left out."""
    monkeypatch.setattr("pendpin.graphics.report.MOST_EVENTS", MOST_EVENTS)
    run = pp.simulate(
        swing(Stop(lower=-0.3, upper=0.75, restitution=1.0, joints=("theta",)), duration=40.0), samples=101
    )
    assert len(run.events) > MOST_EVENTS
    (listed,) = re.findall(r"<th>events</th><td>(.*?)</td>", page_report([run]))
    counts, *lines, rest = listed.split("<br>")
    assert sum(map(int, re.findall(r"\d+", counts))) == len(run.events)
    assert [numbers(line)[0] for line in lines] == [close(1e-5)(event.t) for event in run.events[:MOST_EVENTS]]
    assert rest == f"and {len(run.events) - MOST_EVENTS} more"


# --- stability ------------------------------------------------------------------------------------------------------


def test_modes_in_print_are_the_modes() -> None:
    """Two units of one frequency, damping, how many directions; the lines that are left out."""
    chain = pp.Chain(rods=[pp.Rod(length=0.1, mass=0.1, radius=0.01)], copies=30)
    found = pp.modes(pp.Scene(model=chain, effects=[Gravity(), Viscous(coefficient=1e-4)]))
    np.testing.assert_allclose(found.hertz * 2 * np.pi, found.omega, rtol=1e-14)
    table, whole = found.report().tables[0], found.report(None).tables[0]
    assert len(table.rows) + table.more == len(whole.rows)
    assert whole.more == 0
    assert f"... and {table.more} more; all: pendpin modes --all, or report(None) in Python" in str(found)
    assert sum(map(int, column(whole, "directions"))) == len(found.omega)
    place = 0
    for cells in whole.rows:
        mode, omega, hertz, damping, directions, _ = cells
        assert int(numbers(mode)[0]) == place + 1
        assert float(omega) == close(1e-6)(found.omega[place])
        assert float(hertz) == close(1e-5)(found.omega[place] / 6.283185307179586)
        assert float(damping) == close(1e-3)(found.damping_ratio[place])
        place += int(directions)


def test_rests_in_print_have_their_slowest_swing_and_fastest_growth() -> None:
    """Those of the modes: two routes from the scene to the numbers; upright the growth is that of the same pendulum."""
    chain = pp.Chain(rods=[pp.Rod(length=0.5, mass=1.0, radius=0.02)], copies=2)
    scene = pp.Scene(model=chain, effects=[Gravity()])
    found, lowest = stability(scene), pp.modes(scene).omega.min()
    (table,) = found.report().tables
    for rest, cells in zip(found.rests, table.rows, strict=True):
        swings = np.abs(rest.eigenvalues.imag)
        swings = swings[swings > 1e-6]
        _, verdict, growth, slowest = cells
        assert verdict == ("stable" if rest.stable else "unstable")
        assert float(growth) == close(1e-5, abs=1e-12)(0.0 if rest.stable else rest.eigenvalues.real.max())
        assert (float(slowest) if slowest else None) == (close(1e-5)(swings.min()) if len(swings) else None)
        if rest.stable:
            assert float(slowest) == close(1e-5)(lowest)
    kicked = Lyapunov(np.array([1.5, -0.25]), np.array([0.01, 0.02]), np.zeros((2, 2)), np.array([3.0, 7.0]))
    (exponents,) = kicked.report().tables
    assert [[float(cell) for cell in cells] for cells in exponents.rows] == [[1.5, 0.01], [-0.25, 0.02]]
    assert numbers(kicked.report().sentences[0]) == [7.0, 1.25]


# --- tools ----------------------------------------------------------------------------------------------------------


def test_effects_in_print_are_in_per_cent() -> None:
    """Of the chain's length, and of the time of an evaluation."""
    rows = (EffectRow("gravity", True, 1.2345, 0.25, "needed"), EffectRow("drag", False, 0.00067, None, "not needed"))
    report = EffectsReport(rows, 1e-3, 10.0, 4.0, "it is chaotic").report()
    (table,) = report.tables
    assert [float(cell.removesuffix(" %")) / 100 for cell in column(table, "moves a tip by")] == [1.2, 0.0067 / 10]
    assert column(table, "time added") == ["+25%", ""]
    assert column(table, "in the scene") == ["yes", "no"]
    assert numbers(report.sentences[-1]) == [4.0, 10.0]


def curve(name: str, kind: str, *points: tuple[float, float, float], **more: Any) -> Curve:
    """Points of setting, error and seconds."""
    listed = tuple(Point(setting, error, time, 12, 34, 0.5 * time) for setting, error, time in points)
    return Curve(name, "", kind, listed, **more)


COST = CostReport(
    subject="1 rod",
    curves=(
        curve("dop853", "tolerance", (1e-4, 1e-4, 2.5e-4), (1e-8, 1e-7, 3.1e-3)),
        curve("rk4", "step", (0.05, 1e-3, 1.2e-3), (0.01, 1e-6, 2.3)),
        curve("mujoco", "step", (0.05, 1e-3, 4.2e-3), (0.01, 1e-6, 7.5), peer=True),
    ),
    accuracy=1e-6,
    error=1e-9,
    solutions=("one", "other"),
    duration=20.0,
    horizon=5.0,
    machine="a machine",
    versions={"pendpin": "1"},
    repetitions=3,
)


def test_costs_in_print_are_what_was_measured() -> None:
    """Every time with its unit, every setting: a step has one, a tolerance has none."""
    rows = tuple(cost_row(COST.curves, accuracy, COST.error) for accuracy in (1e-3, 1e-6, 1e-12))
    accuracies, methods = replace(COST, rows=rows).report().tables
    for shown, measured in zip(accuracies.rows, rows, strict=True):
        assert float(shown[0]) == measured.accuracy
        if measured.setting is None:
            assert shown[1] == measured.why
            assert not any(shown[2:])
            continue
        assert shown[1].startswith(f"{measured.method}, {measured.kind} ")
        assert shown[1].endswith(" s") == (measured.kind == "step")
        assert numbers(shown[1].removeprefix(measured.method))[0] == close(0.06)(measured.setting)
        assert seconds(shown[2]) == close()(measured.first_seconds)
        assert seconds(shown[3]) == close()(measured.seconds)
        assert seconds(shown[4]) == close()(measured.peer_seconds)
        assert numbers(shown[4])[-1] == close()(measured.peer_seconds / measured.seconds)
    single = replace(rows[0], once="rk4, step 5.0e-02 s", once_seconds=0.0456)
    assert seconds(replace(COST, rows=(single,)).report().tables[0].rows[0][-1].partition(": ")[2]) == 0.0456
    for shown, measured in zip(methods.rows, COST.curves, strict=True):
        for title, cell in zip(methods.head[1:-3], shown[1:-3], strict=True):
            at = measured.seconds_at(float(title))
            assert cell == "" if at is None else seconds(cell) == close()(at)
        point = measured.point_at(COST.accuracy)
        assert numbers(shown[-3])[0] == close(0.06)(point.setting)
        assert shown[-3].endswith(" s") == (measured.kind == "step")
        assert [int(cell) for cell in shown[-2:]] == [point.steps, point.evaluations]
    (compiling,) = (line for line in COST.report().sentences if line.startswith("Compiling"))
    assert seconds(compiling.partition("dop853")[2]) == close()(COST.curves[0].compile_seconds)


def test_sentences_on_costs_say_what_was_measured() -> None:
    """How many repetitions, over which time, and the factor of one more digit; in the figure, its mean over six digits."""
    quick = replace(COST, thorough=False).report().sentences
    (digit,) = (line for line in quick if line.startswith("One more digit"))
    best = [min(c.seconds_at(error) or np.inf for c in COST.curves if not c.peer) for error in (1e-6, 1e-7)]
    assert numbers(digit) == [1e-6, 1e-7, close()(best[1] / best[0])]
    assert numbers(quick[-1].partition("Processor times of")[2]) == [5.0, COST.repetitions]
    assert numbers(quick[0])[:2] == [COST.horizon, COST.duration]
    bars = draw_cost(COST).axes[1].patches
    curves = {"pendpin": COST.curves[0], "MuJoCo": COST.curves[2]}
    for bar, curve in zip(bars, reversed(curves.values()), strict=True):
        times = [time for k in range(3, 10) if (time := curve.seconds_at(10.0**-k)) is not None]
        assert np.log(bar.get_width()) == pytest.approx(np.diff(np.log(times)).mean(), rel=1e-9)


@pytest.mark.parametrize(
    ("value", "text"), [(1.234, "1.23 s"), (0.1234, "123 ms"), (1.5e-3, "1.5 ms"), (2e-5, "20 µs")]
)
def test_times_have_the_unit_that_suits_them(value: float, text: str) -> None:
    """From microseconds to seconds."""
    shown = CostReport.report(replace(COST, rows=(CostRow(1e-3, "rk4", "step", 0.1, value, value),)))
    assert shown.tables[0].rows[0][2:4] == (text, text)


def test_cross_checks_in_print_are_the_worst_rows() -> None:
    """A cell is the worst of its rows, a line of a pair is that pair."""
    report = pp.crosscheck(builtin_scene(), states=6)
    whole = report.report(every_pair=True)
    pairs, matrix = whole.tables
    (against,) = re.findall("each route against (.*?) at ", whole.sentences[0])
    for shown, measured in zip(pairs.rows, report.rows, strict=True):
        assert shown[:3] == (measured.quantity, measured.place, f"{measured.first} / {measured.second}")
        assert float(shown[3]) == close(0.06)(measured.relative)
        assert float(shown[4]) == pytest.approx(measured.ulps, abs=0.06)
        assert int(shown[5]) == measured.state
    for shown in matrix.rows[:-1]:
        for quantity, cell in zip(matrix.head[1:], shown[1:], strict=True):
            some = [
                r.relative for r in report.rows if r.quantity == quantity and {r.first, r.second} == {shown[0], against}
            ]
            assert cell == "-" if not some else float(cell) == close(0.6, abs=1e-300)(max(some))
    worst = max((r for r in report.rows if against in (r.first, r.second)), key=lambda r: r.relative)
    name = worst.first if worst.second == against else worst.second
    (farthest,) = (line for line in report.report().sentences if line.startswith("Farthest"))
    assert name in farthest
    assert numbers(farthest.partition(name)[2])[0] == pytest.approx(worst.ulps, abs=0.06)


def test_hard_cases_and_published_ones_in_print() -> None:
    """Figure, bound, verdict and time of each outcome; differences with their units; how many are broken."""
    good = Outcome("thin-pole", "rk4", 1.5e-9, 2e-8, None, 1.25)
    bad = Outcome("thin-pole", "euler", 3e-3, 2e-8, None, 2.5)
    failed = Outcome("cone-100", "rk4", None, 1e-5, "it failed", 0.5)
    peer = Outcome("cone-100", "mujoco", 1e-2, 1e-5, None, 40.25, claimed=False)
    report = HardReport((good, bad, failed, peer), (CASES["thin-pole"],)).report()
    (table,) = report.tables
    assert [cells[0] for cells in table.rows] == ["thin-pole", "", "cone-100", ""]
    assert column(table, "measured") == ["1.5e-09", "3.0e-03", "none", "1.0e-02"]
    assert [float(cell) for cell in column(table, "bound")] == [2e-8, 2e-8, 1e-5, 1e-5]
    assert column(table, "verdict") == ["ok", "BROKEN", "BROKEN", "fails"]
    assert [float(cell) for cell in column(table, "seconds")] == [1.25, 2.5, 0.5, 40.25]
    assert numbers(report.sentences[-1]) == [3, 2, 4]  # claims, broken, seconds
    (listed,) = catalogue_report().tables
    assert {name: float(bound) for name, _, bound in listed.rows} == {
        name: pytest.approx(case.bound, rel=0.06) for name, case in CASES.items()
    }
    near = Comparison("case", "rk4", 1e-7, 1e-6, None, "a book", "angle", "rad")
    far = Comparison("case", "euler", 2e-6, 1e-6, None, "a book", "angle", "rad")
    report = AgreementReport((near, far), ("case by taylor: no",)).report()
    (cells,) = report.tables[0].rows
    assert cells == ("case", "angle", "1.0e-06 rad", "2.0e-06 rad", "euler", "BROKEN")
    assert numbers(report.sentences[-1]) == [2, 1]


def test_a_claimed_accuracy_widens_a_bound_by_its_part_of_the_length() -> None:
    """The bound of a place is what is published, and the error that the run estimates of itself, times the length."""
    name = next(
        name
        for name, case in published_cases().items()
        if any(q.of in ("tip", "centre of mass") for q in case.quantities)
        and abs(scale(build(case.scene.model)) - 1) > 0.05
    )
    case = published_cases()[name]
    run = pp.simulate(case.scene, times=case.times, accuracy=case.accuracy)
    for found in validate([name], ["accuracy"]).comparisons:
        quantity = next(q for q in case.quantities if q.name == found.quantity)
        more = run.stats.error * scale(build(case.scene.model)) if quantity.of in ("tip", "centre of mass") else 0.0
        assert found.bound == pytest.approx(quantity.bound + more, rel=1e-9)


def test_a_sweep_in_print_has_the_range_of_its_measures() -> None:
    """Least, median and most; how many have no value, and why; the reasons that are left out."""
    found = pp.sweep(
        swing(duration=0.3), {"start.positions.theta": [0.1, 0.2, 0.6], "model.rods[0].mass": [1.0, -1.0]}, "swing"
    )
    report = sweep_report(found)
    ((_, *figures),) = report.tables[0].rows
    good = found["swing"].values[np.isfinite(found["swing"].values)]
    assert [float(x) for x in figures] == [close(1e-5)(x) for x in (good.min(), np.median(good), good.max(), 3)]
    assert numbers(report.sentences[0])[:2] == [6, 3]
    assert int(report.sentences[1].split(" x ")[0]) == 3
    assert report.fault is None
    seven = found.copy(deep=True)
    seven["why"].values[...] = np.array([f"reason {i}" for i in range(6)]).reshape(3, 2)
    assert sweep_report(seven).sentences[-1] == "  ... and 1 more reasons"
    assert "reason 0" in sweep_report(seven).fault


def test_a_command_prints_what_its_json_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    """One command through its whole way: the table of modes beside its JSON."""
    monkeypatch.chdir(tmp_path)
    swing().save("rod.toml")
    assert run_main("modes", "rod.toml", "--json") == 0
    omega = re.findall(r"[\d.]+", capsys.readouterr().out.partition("damping_ratio")[0])
    assert run_main("modes", "rod.toml") == 0
    (line,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("1"))
    assert numbers(line.partition("   ")[2])[0] == close(1e-6)(float(omega[0]))
