"""The hard cases: every one in its short form on every method that it claims, and what the catalogue promises."""

from importlib.util import find_spec
from json import loads

import pytest

from pendpin import effects as fx
from pendpin.cli import main
from pendpin.errors import InputError, Interrupted
from pendpin.motions.trajectory import simulate
from pendpin.scene import load_scene
from pendpin.verification import hardcases
from pendpin.verification.hardcases import CASES, hard, run_case
from pendpin.verification.hardcases.base import FOLDER, GROUPS, Case, scene

CLAIMS = [(case, method) for case in CASES.values() for method in case.methods]
CHEAP = "no-duration"
LONG = ("pole-torque-thin",)  # steps become short on the way to the pole


@pytest.mark.parametrize(
    ("case", "method"),
    [
        pytest.param(
            case, method, id=f"{case.name}-{method}", marks=[pytest.mark.slow] * (method != "auto" or case.name in LONG)
        )
        for case, method in CLAIMS
    ],
)
def test_a_hard_case_is_within_its_bound(case: Case, method: str) -> None:
    """What was measured is at most the bound that was derived for it."""
    if method == "taylor" and find_spec("heyoka") is None:
        pytest.skip("heyoka is not installed: pip install heyoka")
    found = run_case(case, method, full=False)
    assert found.ok, f"{found.failure or found.measured} against {found.bound}: {case.figure}"


def test_the_catalogue_is_whole() -> None:
    """Every group has a case, every case claims "auto", and all say what they are."""
    assert {case.group for case in CASES.values()} == set(GROUPS)
    for case in CASES.values():
        assert "auto" in case.methods
        assert case.bound >= 0
        assert all((case.title, case.physics, case.why, case.figure, case.derivation))


def test_every_scene_can_be_loaded() -> None:
    """Each file of scenes/ is a scene that `pendpin run` takes, and has the name of its case."""
    paths = sorted((FOLDER / "scenes").glob("*.toml"))
    assert {path.stem for path in paths} - set(CASES) == {"scale"}  # which two cases compare with theirs
    assert {path.stem for path in paths if not load_scene(path).duration} == {"no-duration", "one-sample"}


@pytest.mark.skipif(not (find_spec("mujoco") and find_spec("pydrake")), reason="pip install mujoco drake")
def test_other_simulators_run_the_same_cases() -> None:
    """Beside "auto", without claims: all of them start and stop; none falls from the pole with a thin rod's spin."""
    found = hard([CHEAP, "pole-spin-thin", "late"], peers=True)  # "late" is not for them
    assert not found.broken
    held = {(row.case, row.method.split(",")[0]): row.ok for row in found.outcomes}
    methods = ("auto", "MuJoCo RK4", "Drake RK5", "SciPy DOP853")
    assert held == {
        (name, method): name == CHEAP or method == "auto" for name in (CHEAP, "pole-spin-thin") for method in methods
    }


SINUSOIDS = {
    "motor": fx.Motor(joint="theta", amplitude=100.0, frequency=1e3),
    "push": fx.Push(link="rod", amplitude=(0.0, 100.0, 0.0), frequency=1e3),
    "drag": fx.Drag(gust=(0.0, 30.0, 0.0), frequency=1e3),
    "support": fx.Support(amplitude=(0.0, 1e-4, 0.0), frequency=1e3),
}


@pytest.mark.parametrize("effect", SINUSOIDS.values(), ids=SINUSOIDS)
@pytest.mark.parametrize("energy_balance", [False, True], ids=["", "energy_balance"])
def test_sinusoids_are_smooth_at_late_times(effect: fx.Effect, energy_balance: bool) -> None:
    """At t = 1e9 s doubles are 1e-7 s apart: a force that is taken there jumps, and steps collapse."""
    early, late = (
        simulate(
            scene("late-driven", {"start.time": time}).replace(effects=(fx.Gravity(), effect)),
            tolerance=1e-12,
            energy_balance=energy_balance,
        ).stats.steps
        for time in (0.0, 1e9)
    )
    assert late < 1.5 * early


def run(*arguments: str, monkeypatch: pytest.MonkeyPatch) -> int:
    """The exit status of `pendpin hard` with these arguments."""
    monkeypatch.setattr("sys.argv", ["pendpin", "hard", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    return int(ended.value.code or 0)


def with_bound(bound: float) -> dict[str, Case]:
    """The catalogue with another bound for the cheap case, which measures 0."""
    fields = {**CASES[CHEAP].__dict__, "bound": bound, "methods": {"auto": {}}}
    return CASES | {CHEAP: Case(**fields)}


def test_all_is_well(monkeypatch, capfd) -> None:
    """A table with a row for each method, and exit status 0."""
    assert run(CHEAP, "--short", monkeypatch=monkeypatch) == 0
    printed = capfd.readouterr()
    assert printed.out.count(" ok ") == len(CASES[CHEAP].methods)
    assert not printed.err


def test_a_broken_bound_is_named(monkeypatch, capfd) -> None:
    """Exit status 1 and one line with the case, the method and both numbers; the table is printed all the same."""
    monkeypatch.setattr(hardcases, "CASES", with_bound(-1.0))
    assert run(CHEAP, "--short", monkeypatch=monkeypatch) == 1
    printed = capfd.readouterr()
    assert "BROKEN" in printed.out
    assert printed.err == f"pendpin: broken: {CHEAP} on auto: 0 is above -1\n"


def test_json_has_all(monkeypatch, capfd) -> None:
    """Outcomes and cases with all their fields."""
    assert run(CHEAP, "pole-spin-thick", "--short", "--json", monkeypatch=monkeypatch) == 0
    found = loads(capfd.readouterr().out)
    assert found["ok"] is True
    assert found["stopped"] is False
    fields = {
        "case",
        "method",
        "measured",
        "bound",
        "seconds",
        "failure",
        "claimed",
        "ok",
        "verdict",
        "left_out",
    }
    assert all(set(row) == fields and row["ok"] is True for row in found["outcomes"])
    case, _ = found["cases"]
    assert set(case) == {"name", "group", "title", "physics", "why", "figure", "bound", "derivation", "methods"}


def test_an_unknown_case_is_refused(monkeypatch, capfd) -> None:
    """One line with the choices."""
    assert run("no-such-case", monkeypatch=monkeypatch) == 1
    said = capfd.readouterr().err
    assert said.count("\n") == 1
    assert "'no-such-case' is not one of: thin-pole, " in said


def stop(*_: object) -> float:
    """What Ctrl-C does between runs."""
    raise KeyboardInterrupt


def interrupt(*_: object) -> float:
    """What Ctrl-C does inside a run."""
    raise Interrupted("stopped by the user")


@pytest.mark.parametrize("way", [stop, interrupt])
def test_ctrl_c_keeps_what_is_done(way, monkeypatch, capfd) -> None:
    """The table so far, one line, and the exit status of an interrupt."""
    after = Case(**{**CASES["one-sample"].__dict__, "measure": way})
    monkeypatch.setattr(hardcases, "CASES", CASES | {"one-sample": after})
    assert run(CHEAP, "one-sample", "--short", monkeypatch=monkeypatch) == 130
    printed = capfd.readouterr()
    assert printed.out.count(" ok ") == len(CASES[CHEAP].methods)
    assert printed.err == "pendpin: stopped by the user\n"


def test_a_run_that_fails_is_an_outcome() -> None:
    """The outcome holds the error of a case; the other cases run."""
    failing = Case(**{**CASES[CHEAP].__dict__, "measure": refuse})
    found = run_case(failing, "auto", full=False)
    assert (found.measured, found.failure, found.verdict) == (None, "no such thing", "BROKEN")


def refuse(*_: object) -> float:
    """A case that cannot be run."""
    raise InputError("no such thing")
