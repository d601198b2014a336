"""Published results: pendpin agrees with each within its bound, and a planted error in any part of it is noticed."""

from collections.abc import Callable
from dataclasses import replace
from json import loads
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

import pendpin as pp
from pendpin.cli import main
from pendpin.scene import METHODS
from pendpin.verification import agreement as module
from pendpin.verification.agreement import TO_ACCURACY, USUAL, agreement_page, published_cases, validate

CASES = published_cases()
QUICK = ("dop853", "rk4")
MANY_STEPS = 200_000  # of a fixed size: the slow test takes them
RUNS = [name for name, case in CASES.items() if case.quantities and not (case.frequencies or case.stability)]


@pytest.mark.parametrize("name", CASES)
def test_pendpin_agrees_with_the_published_numbers(name: str) -> None:
    """By an adaptive method and one with a fixed step, and at the claimed accuracy."""
    case = CASES[name]
    steps = max(0.0, *case.times) / case.settings.get("rk4", USUAL["rk4"])
    left_out = (*case.leave_out, *(["rk4"] if steps > MANY_STEPS else []))
    report = validate([name], [method for method in (*QUICK, TO_ACCURACY) if method not in left_out])
    assert not report.broken, report.fault


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_every_method_agrees_with_the_published_numbers(name: str) -> None:
    """All methods that a case does not leave out."""
    report = validate([name])
    assert not report.broken, report.fault
    ran, missing = {row.method for row in report.comparisons}, "heyoka" in "".join(report.left_out)
    methods = len(METHODS) + 1 - len(CASES[name].leave_out) - missing if CASES[name].quantities else 0
    near = bool(CASES[name].frequencies) + bool(CASES[name].stability)  # by the linear model, by the multipliers
    assert len(ran) == methods + near


def changed(run: pp.Trajectory, **arrays: Any) -> pp.Trajectory:
    """The run with other arrays."""
    states = {name: arrays.pop(name) for name in ("q", "v") if name in arrays}
    return replace(run, derived=run.derived._replace(**arrays), **states)


PLANTED: dict[str, Callable[[pp.Trajectory], pp.Trajectory]] = {
    "reactions of the opposite sign": lambda run: changed(run, wrench=-run.wrench),
    "moments for forces": lambda run: changed(run, wrench=np.roll(run.wrench, 3, axis=2)),
    "forces off by 1 in 1,000": lambda run: changed(run, wrench=1.001 * run.wrench),
    "angles counted the other way": lambda run: changed(run, q=-run.q),
    "angles off by 1e-3 of themselves": lambda run: changed(run, q=1.001 * run.q),
    "the two angles exchanged": lambda run: changed(run, q=run.q[:, ::-1]),
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_error_in_a_result_breaks_three_cases(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A wrong sign, factor or frame of what a run returns is noticed by at least three cases."""
    right = pp.simulate
    monkeypatch.setattr(module, "simulate", lambda *given, **options: PLANTED[name](right(*given, **options)))
    broken = {row.case for row in validate(RUNS, ["dop853"]).broken}
    assert len(broken) >= 3, broken


WRONG: dict[str, Callable[[pp.Scene], dict[str, Any]]] = {
    "gravity off by 1e-4": lambda scene: {
        f"effects[{i}].acceleration": effect.acceleration * 1.0001
        for i, effect in enumerate(scene.effects)
        if isinstance(effect, pp.effects.Gravity)
    },
    "gravity the other way": lambda scene: {
        f"effects[{i}].direction": tuple(-x for x in effect.direction)
        for i, effect in enumerate(scene.effects)
        if isinstance(effect, pp.effects.Gravity)
    },
    "inertia about the joint, not the centre of mass": lambda scene: (
        {
            f"model.rods[{i}].inertia": tuple(x + rod.properties.m * rod.properties.h**2 for x in rod.properties[2:])
            for i, rod in enumerate(scene.model.rods)
            if rod.inertia
        }
        if isinstance(scene.model, pp.Chain)
        else {}
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_planted_error_in_a_scene_breaks_three_cases(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Wrong numbers in the equations are noticed by at least three cases."""
    right = pp.simulate
    wrong = lambda scene, **options: right(scene.replace(WRONG[name](scene)), **options)  # noqa: E731
    monkeypatch.setattr(module, "simulate", wrong)
    broken = {row.case for row in validate(RUNS, ["dop853"]).broken}
    assert len(broken) >= 3, broken


def test_the_conical_motion_is_its_closed_form() -> None:
    """The numbers in the file are those of omega² = g / (L cos(alpha)), in 40 digits."""
    quantity = CASES["conical"].quantities[0]
    with mp.workdps(40):
        alpha, length = mpf("0.5"), mpf(2) / 3
        omega = mp.sqrt(mpf("9.81") / (length * mp.cos(alpha)))
        for t, x, y, z in quantity.values:
            phase = omega * mpf(t)
            exact = (mp.sin(alpha) * mp.sin(phase), -mp.sin(alpha) * mp.cos(phase), -mp.cos(alpha))
            assert max(abs(float(a) - b) for a, b in zip(exact, (x, y, z), strict=True)) < 1e-15
    assert CASES["conical"].scene.start.velocities["phi"] == pytest.approx(float(mp.sin(alpha) * omega), rel=1e-15)


def test_what_is_left_out_names_a_method_and_a_reason() -> None:
    """No case leaves a method out in silence, and none misspells one."""
    for case in CASES.values():
        assert set(case.leave_out) <= set(METHODS)
        assert set(case.settings) <= set(METHODS)
        assert all(len(reason) > 10 for reason in case.leave_out.values())


def test_a_difference_is_taken_at_the_published_times() -> None:
    """Also if the run has other samples: the largest difference of a run moved by d is d."""
    case = CASES["iftomm-a01"]
    run = pp.simulate(case.scene, times=(0.0, 0.3, 1.0, 100.0, 1000.0, 2000.0), method="taylor", tolerance=1e-16)
    moved = changed(run, q=np.where(run.t[:, None] == 100.0, run.q + 1e-3, run.q))
    assert case.quantities[0].difference(run) < 1e-9
    assert case.quantities[0].difference(moved) == pytest.approx(1e-3, rel=0.05)


def command(*arguments: str, monkeypatch: pytest.MonkeyPatch) -> int:
    """The exit status of `pendpin validate` with these arguments."""
    monkeypatch.setattr("sys.argv", ["pendpin", "validate", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    return int(ended.value.code or 0)


@pytest.mark.parametrize("most", [1e-9, np.nan, None])
def test_the_worst_method_differs_most_or_failed(most: float | None) -> None:
    """Wherever it stands among others, of which one does not differ at all."""
    for measured in ((most, 0.0, 1e-12), (0.0, most, 1e-12), (1e-12, 0.0, most)):
        rows = [module.Comparison("case", "rk4", x, 1.0, None, "source", "angle", "rad") for x in measured]
        assert [row.measured for row in module.AgreementReport(tuple(rows)).worst] == [most]


def test_json_holds_the_six_fields_of_each_comparison(monkeypatch, capfd) -> None:
    """Case, source, quantity, bound, difference, holds."""
    assert command("drake-rod", "--methods", "dop853", "--json", monkeypatch=monkeypatch) == 0
    rows = loads(capfd.readouterr().out)
    assert len(rows) == 2
    assert all({"case", "source", "quantity", "bound", "difference", "holds"} <= set(row) for row in rows)
    assert all(row["holds"] is True and row["difference"] <= row["bound"] for row in rows)


def test_a_broken_case_ends_with_status_1(monkeypatch, capfd) -> None:
    """One line names the case, the quantity and both numbers."""
    right = pp.simulate

    def doubled(*given: Any, **options: Any) -> pp.Trajectory:
        run = right(*given, **options)
        return changed(run, wrench=2 * run.wrench)

    monkeypatch.setattr(module, "simulate", doubled)
    assert command("drake-rod", "--methods", "dop853", monkeypatch=monkeypatch) == 1
    said = capfd.readouterr().err
    assert "drake-rod, force on the rod, by dop853: 37.5 N is above 1e-09" in said


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(("no-such",), "'no-such' is not one of: acheson"), (("adams-1", "--methods", "dop835"), "did you mean 'dop853'")],
)
def test_unknown_names_are_refused(arguments, words, monkeypatch, capfd) -> None:
    """One line with the choices."""
    assert command(*arguments, monkeypatch=monkeypatch) == 1
    said = capfd.readouterr().err
    assert said.count("\n") == 1
    assert words in said


def test_the_list_names_every_case_with_its_source(monkeypatch, capfd) -> None:
    """As a table and as JSON."""
    assert command("--list", "--json", monkeypatch=monkeypatch) == 0
    assert {row["case"] for row in loads(capfd.readouterr().out)} == set(CASES)


def test_the_page_holds_tables_sources_and_pictures() -> None:
    """One file without links to a network."""
    report = validate(["drake-rod", "adams-3"], ["dop853"])
    text = agreement_page(report)
    assert all(name in text for name in ("drake-rod", "adams-3", "<svg", "projectchrono/chrono"))
    assert "<script" not in text


def test_ctrl_c_keeps_the_comparisons_so_far(monkeypatch, capfd) -> None:
    """The table so far, and the exit status of an interrupt."""
    right, calls = pp.simulate, []

    def stopping(*given: Any, **options: Any) -> pp.Trajectory:
        calls.append(1)
        if len(calls) > 1:
            raise KeyboardInterrupt
        return right(*given, **options)

    monkeypatch.setattr(module, "simulate", stopping)
    assert command("drake-rod", "--methods", "dop853,rk45", monkeypatch=monkeypatch) == 130
    assert "2 comparisons" in capfd.readouterr().out
