"""A slice of the campaign of random scenes; and its judgement sees what it is there to see."""

import os
import re
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

import pendpin as pp
import random_scenes
from laws import HANG
from pendpin.effects import JointEffect
from pendpin.engines import Revolute
from pendpin.runs import limits, run
from random_scenes import FAULT, keep, outcome, outcomes
from scene_effects import KINDS
from scene_generator import ENGINES, METHODS, RODS, Case, case_of

pytestmark = pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")  # workers fork

SEED, COUNT = 2026, 60
LIMIT, TICK = 0.2, 0.01  # s of a scene, and what each look at the clock takes of them: a count of looks, on any machine
SWING = Case(
    {
        "duration": 1.0,
        "model": {"kind": "chain", "rods": [{"length": 1.0, "mass": 1.0, "radius": 0.02}]},
        "start": {"positions": {"theta": 1.0}},
        "effects": [{"kind": "gravity"}],
        "solver": {"method": "dop853", "samples": 11},
    },
    True,
    HANG,
)


class Wrong(JointEffect):
    """A spring of 1 N m/rad whose potential is too large by a millionth, or whatever `act` does."""

    kind: Literal["wrong"] = "wrong"
    act: Any = None

    def torques(self, t: Any, q: Any, v: Any, xp: Any = np) -> Any:
        """As `JointEffect.torques`."""
        return -q if self.act is None else self.act(q)

    def potential(self, q: Any, xp: Any = np) -> Any:
        """As `JointEffect.potential`."""
        return (1 + 1e-6) / 2 * (q**2).sum(-1)


def swing(*effects: Any, **changed: Any) -> Case:
    """One rod that swings, with other effects."""
    return SWING._replace(scene=SWING.scene | {"effects": [*SWING.scene["effects"], *effects]} | changed)


class Looks:
    """A clock that goes on by TICK whenever somebody looks."""

    def __init__(self) -> None:
        self.now = 0.0

    def perf_counter(self) -> float:
        """The time, s."""
        self.now += TICK
        return self.now

    thread_time = process_time = perf_counter


@pytest.mark.parametrize("count", [COUNT // 4, pytest.param(COUNT, marks=pytest.mark.slow)])
def test_no_fault_in_a_slice(count: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every scene ends in a run whose energy balances or in one line; most in a run. What takes long is stopped."""
    clock = Looks()
    monkeypatch.setattr(limits, "time", clock)
    monkeypatch.setattr(run, "time", clock)
    found = [outcome(case_of(SEED, number, tmp_path)._replace(limit=LIMIT)) for number in range(count)]
    assert [result for result in found if result.kind == FAULT] == []
    assert {"balanced", "stopped"} <= {result.kind for result in found} or count < COUNT


def test_scenes_are_of_every_kind_and_come_from_their_seed_alone(tmp_path: Path) -> None:
    """All effects, methods, engines and numbers of rods are among them; the same number is the same scene."""
    cases = [case_of(SEED, number, tmp_path) for number in range(600)]
    assert cases[500] == case_of(SEED, 500, tmp_path)
    effects = [effect for case in cases for effect in case.scene["effects"]]
    assert {effect["kind"] for effect in effects} == {"gravity", *KINDS}
    assert any("csv" in effect for effect in effects)
    assert {case.scene["solver"]["method"] for case in cases} == set(METHODS)
    assert {case.scene["solver"]["engine"] for case in cases} == set(ENGINES)
    assert {pp.Chain(**case.scene["model"]).count for case in cases} == set(RODS)


@pytest.mark.parametrize(
    ("case", "kind"),
    [
        (swing(), "balanced"),
        (swing({"kind": "viscous", "coefficient": 0.1})._replace(energy_balance=False), "no balance"),
        (swing(solver={"method": "euler", "step": 0.01, "samples": 11}), "coarse"),
        (swing(duration=-1.0), "refused"),
        (swing(solver={"method": "rk4", "step": 1.0, "samples": 11}, duration=50.0), "stopped"),
        (swing(Wrong()), FAULT),
        (swing(Wrong(act=lambda q: 1 / 0)), FAULT),
    ],
    ids=["balanced", "no balance", "coarse", "refused", "stopped", "a wrong potential", "an exception"],
)
def test_outcomes(case: Case, kind: str) -> None:
    """What each outcome stands for; a potential that is off by a millionth is seen."""
    assert outcome(case).kind == kind


def test_numbers_that_are_not_finite_are_a_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wherever they are in the run."""
    run = pp.simulate(pp.Scene(**SWING.scene))
    monkeypatch.setattr(
        pp, "simulate", lambda *_, **__: run.with_arrays({**run.arrays, "wrench": run.wrench * np.nan}), raising=False
    )
    assert outcome(SWING).kind == FAULT


def _spin() -> None:
    while True:
        pass


@pytest.mark.parametrize(
    ("act", "words"),
    [
        pytest.param(_spin, "no end", marks=pytest.mark.slow),
        (lambda: os._exit(3), "ended with 3"),
        (lambda: os.kill(os.getpid(), signal.SIGKILL), "ended with -9"),
        (lambda: os.write(2, b"a word from C"), "stderr"),
    ],
    ids=["hang", "exit", "crash", "noise"],
)
def test_what_happens_to_a_worker_is_a_fault(
    act: Callable[[], object], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A hang, an end, a crash, a word on stderr; and the next scene has a worker again."""
    reference_route = random_scenes.outcome

    def acting(case: Case) -> random_scenes.Outcome:
        if case == case_of(SEED, 0, tmp_path):
            act()
        return reference_route(SWING)

    monkeypatch.setattr(random_scenes, "outcome", acting)
    monkeypatch.setattr(random_scenes, "LATE", 0.2 if act is _spin else HANG)
    first, second = (result for _, result in outcomes(range(2), SEED, tmp_path))
    assert first.kind == FAULT
    assert words in first.words
    assert act is _spin or second.kind == "balanced"


def test_a_fault_is_kept_as_a_scene_that_can_be_run_again(tmp_path: Path) -> None:
    """The file holds the scene to the last bit, with its csv."""
    (tmp_path / "files").mkdir()
    for number in range(40):
        keep(SEED, number, tmp_path, outcome(SWING)._replace(kind=FAULT, words="off"))
        try:
            scene = pp.Scene(**case_of(SEED, number, tmp_path / "files").scene)
        except pp.InputError:
            continue
        assert pp.load_scene(tmp_path / f"fault_{SEED}_{number}.toml") == scene


# --- what the campaign found ----------------------------------------------------------------------------------------


def test_books_begin_after_the_impacts_at_the_start() -> None:
    """What a stop takes from a joint that sets out into it is gone before the first sample."""
    case = swing(
        {"kind": "stop", "upper": 1.0, "joints": ["theta"]},
        start={"positions": {"theta": 1.0}, "velocities": {"theta": 2.0, "phi": 1.0}},
    )
    run = pp.simulate(pp.Scene(**case.scene), energy_balance=True)
    assert run.work["stop"][0] == 0
    assert run.imbalance < 1e-9


@pytest.mark.parametrize("engine", ["auto", "pinocchio", "chain"])
def test_a_lane_that_fails_at_once_leaves_no_states_to_read(engine: str) -> None:
    """No states of an engine are no positions and no rates."""
    thin = {"kind": "chain", "rods": [{"length": 1.0, "mass": 1.0}], "copies": 3}
    dynamics = pp.bind(pp.Scene(model=thin, solver={"engine": engine}))  # pyright: ignore[reportArgumentType]
    none = dynamics.engine.pack(np.zeros(6), np.zeros(6))[None][:0]
    q, v = dynamics.engine.unpack(np.empty(0), none, np.zeros(6))
    assert q.shape == v.shape == (0, 6)


@pytest.mark.parametrize("solver", [{"engine": "chain"}, {"method": "gauss6", "step": 0.002}], ids=["chain", "gauss6"])
def test_slow_equations_look_at_the_clock_often(solver: dict[str, Any]) -> None:
    """Where an evaluation takes milliseconds, the progress callback is called about every hundred of them."""
    seen: list[float] = []
    run = pp.simulate(pp.Scene(**swing(solver=solver).scene), progress=seen.append)
    assert len(seen) > run.stats.evaluations / 200


@pytest.mark.parametrize("step", [5.0, 7.0, 10.0, 20.0])
def test_a_late_start_and_the_time_of_a_failure(step: float) -> None:
    """What is said about a failure does not mix two clocks: whether or not the stage equations have a solution there."""
    start = {"time": 1e6, "positions": {"theta": 1.0, "phi": 1.0}, "velocities": {"theta": 30.0}}
    solver = {"method": "gauss4", "step": step, "samples": 2}
    with pytest.raises(pp.RunError, match=r"t = 1000000 s of 1000020 s: ") as error:
        pp.simulate(pp.Scene(**swing(duration=20.0, start=start, solver=solver).scene))
    since = re.findall(r"([\d.e+]+) s after the start", str(error.value))
    assert all(0 <= float(seconds) <= 20 for seconds in since)


def test_a_rod_held_by_friction_alone_has_reactions() -> None:
    """Nothing but the Earth's rotation acts, and is balanced to the last digit: what remains is rounding, no motion."""
    found = outcome(
        SWING._replace(
            scene={
                "duration": 1.0,
                "model": {"kind": "chain", "rods": [{"length": 1.0, "mass": 0.6}]},
                "start": {"positions": {"theta": -0.18, "phi": -0.04}},
                "effects": [{"kind": "rotation", "latitude": -90.0}, {"kind": "dry_friction", "kinetic": 0.4}],
                "solver": {"method": "rk23", "engine": "chain", "samples": 3},
            }
        )
    )
    assert found.kind == "balanced", found.words


@pytest.mark.parametrize("duration", [1e-300, 1e-14])
def test_a_thin_rod_that_rests_at_a_pole_keeps_its_angles(duration: float) -> None:
    """It moves along with the rod above; what is left of its own rate is rounding, and no theta is read from that."""
    start = pp.Start(positions=(0.01, 0.17, 0.8, np.pi / 2), velocities=(-1.8, 4.0, 0.0, 0.0))
    model = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0),), copies=2)
    run = pp.simulate(pp.Scene(model=model, start=start, duration=duration, solver=pp.Solver(samples=5)))
    assert np.abs(run.q - run.q[0]).max() < 1e-12
    assert np.abs(run.v - run.v[0]).max() < 1e-10
    assert np.ptp(run.kinetic) < 1e-12 * run.kinetic[0]


def test_a_run_keeps_what_is_before_a_sample_without_a_solution(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where accelerations at a sample have no finite values, the run ends with the sample before it, and says why."""
    evaluate = Revolute.evaluate

    def singular(engine: Revolute, t: Any, *state: Any) -> Any:
        if (t > 0.55).any():
            raise np.linalg.LinAlgError("no finite reactions")
        return evaluate(engine, t, *state)

    monkeypatch.setattr(Revolute, "evaluate", singular)
    with pytest.raises(pp.RunError, match=r"ended at t = 0.5 s of 1 s: no finite reactions") as error:
        pp.simulate(pp.Scene(**SWING.scene).with_solver(engine="pinocchio"))
    assert np.allclose(error.value.partial.t, np.linspace(0, 0.5, 6))
