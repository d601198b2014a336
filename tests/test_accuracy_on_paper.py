"""The search for an accuracy over methods on paper, whose errors, steps and growth of rounding are given exactly."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin.effects import Effect, Gravity, Torque
from pendpin.ground.arrays import EPS, Array
from pendpin.model.build import Model, build
from pendpin.model.kinematics import poses, tips
from pendpin.runs.accuracy import runs as accuracy_runs
from pendpin.runs.accuracy.estimate import measure_rounding, measure_rounding_of_lost_run
from pendpin.runs.accuracy.runs import Attempt, Runs
from pendpin.runs.accuracy.target import run_to_accuracy
from pendpin.runs.batches import Cases, Motions
from pendpin.runs.limits import Deadline
from pendpin.runs.preparation import Prepared
from pendpin.scene.methods import method_of
from pendpin.sweeps.cases import Ladder
from pendpin.trajectory import Derived, RunRecord, samples_of
from pendpin.trajectory.parts import Stats

START, RATE, END = 1.0, 0.5, 2.0  # rad, rad/s, s
UNIT = EPS * (START + RATE * END)  # of rounding, of the largest angle
ROD = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.1)])


@dataclass
class Paper:
    """Takes the place of integration: theta turns evenly, but for errors that grow in proportion to the time."""

    error: Callable[[str, float], float]  # rad, at the end, of a method and its tolerance or step
    growth: float = 1.0  # by the end, of a shift of the start
    steps: Callable[[str, float], int] = lambda method, setting: int(100 * setting ** (-1 / 6))
    closer: float = 0.0  # rad, what other output times change at the end
    rate: float = RATE
    until: float = END  # s, where every run ends early
    asked: list[tuple[str, float, bool]] = field(default_factory=list)  # method, setting, whether the start is shifted
    longest: list[float] = field(default_factory=list)  # s, of runs with short steps
    samples: int = 65

    def __call__(self, prepared: Prepared, *_: Any, longest: float = np.inf, **options: Any) -> RunRecord:
        scene = prepared.scene
        method, setting = scene.solver.method, scene.solver.step or scene.solver.tolerance or 0.0
        start = scene.start.positions
        shift = start[0] - START if isinstance(start, tuple) else 0.0
        self.asked.append((method, setting, bool(shift)))
        if np.isfinite(longest):
            self.longest.append(longest)
        since = scene.times
        part = since / END
        error = self.error(method, setting) + self.closer * (len(since) > self.samples)
        theta = START + self.rate * since + shift * self.growth**part + error * part
        q = np.stack([theta, np.zeros_like(theta)], -1)
        v = np.full_like(q, self.rate) * [1, 0]
        return samples_of(
            trajectory(scene, q, v, self.steps(method, setting)), slice(0, int((since <= self.until).sum()))
        )

    def count(self, method: str, setting: float) -> int:
        """How many runs there were with a setting."""
        return sum(one[:2] == (method, setting) for one in self.asked)


def trajectory(scene: pp.Scene, q: Array, v: Array, steps: int) -> RunRecord:
    """A run with these states; what no search looks at is 0."""
    n, model = len(q), build(scene.model)
    solver = scene.solver
    stats = Stats(
        method=solver.method,
        tolerance=None if solver.step else solver.tolerance,
        step=solver.step,
        steps=steps,
        evaluations=steps,
        seconds=1e-6 * steps,
        compile_seconds=0.0,
        library="",
        version="",
        events=0,
        engine="paper",
    )
    return RunRecord(
        joints=model.joints,
        t=scene.clock,
        q=q,
        v=v,
        derived=Derived(0 * q, np.zeros((n, 2, 6)), np.zeros(n), np.zeros(n), tips(model, poses(model, q)), None),
        stats=stats,
        scene=scene.model_dump(mode="json"),
        source=scene,
    )


@pytest.fixture
def search(monkeypatch: pytest.MonkeyPatch) -> Callable[..., RunRecord]:
    """The result of the search of a target by a method on paper."""

    def run(paper: Paper, method: str, target: float, *effects: Effect) -> RunRecord:
        monkeypatch.setattr(accuracy_runs, "run_prepared", paper)
        return run_to_accuracy(scene_of(method, target, *effects), False, lambda t: None, Deadline(None))

    return run


def scene_of(method: str, target: float, *effects: Effect) -> pp.Scene:
    return pp.Scene(
        duration=END,
        model=ROD,
        start=pp.Start(positions={"theta": START}, velocities={"theta": RATE}),
        effects=effects or [Gravity()],
        solver=pp.Solver(method=method, accuracy=target, samples=65),
    )


def true_error(run: RunRecord, rate: float = RATE) -> float:
    """The tip's distance at the end from where it should be."""
    return float(2 * abs(np.sin((run.q[-1, 0] - START - rate * END) / 2)))


def scattered(method: str, size: float, seed: int) -> Callable[[str, float], float]:
    """An error of the method's order in its setting, off that law by up to the scatter that is known of it."""
    order, scatter = (
        (method_of(method).order or 1.0) if method_of(method).setting == "step" else 1.0,
        method_of(method).scatter,
    )

    def error(name: str, setting: float) -> float:
        if name != method:
            return 0.01 * setting
        draw = np.random.default_rng([seed, int(-1e6 * math.log(setting)) % 2**31])
        return size * setting**order * scatter ** draw.uniform(-0.5, 0.5)

    return error


# --- what is claimed -------------------------------------------------------------------------------------------------


@law(80)
@given(
    method=st.sampled_from(["dop853", "rk45", "radau", "bdf", "lsoda", "rk4", "gauss4"]),
    size=st.floats(-2, 2.5).map(lambda x: 10**x),
    digits=st.floats(2, 8),
    seed=st.integers(0, 999),
)
def test_every_method_on_paper_meets_its_target(method: str, size: float, digits: float, seed: int) -> None:
    """The claim is between the true error and the target, after few runs, and the last run is not finer than it need be."""
    target, paper = 10**-digits, Paper(scattered(method, size, seed))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(accuracy_runs, "run_prepared", paper)
        run = run_to_accuracy(scene_of(method, target), False, lambda t: None, Deadline(None))
    assert true_error(run) <= run.stats.error <= target
    assert run.stats.method == method
    assert 3 <= len(paper.asked) <= 7
    assert run.stats.step or true_error(run) >= 1e-7 * target  # a step is a part of the spacing of samples
    settings = [setting for name, setting, shifted in paper.asked if name == method and not shifted]
    assert settings == sorted(settings, reverse=True)


def test_the_claim_of_an_exact_power_law(search) -> None:
    """Errors in proportion to the tolerance: the claim is a little above the last one."""
    paper = Paper(lambda method, tolerance: tolerance)
    run = search(paper, "rk45", 1e-6)
    tolerances = [setting for _, setting, _ in paper.asked]
    assert tolerances == pytest.approx([1e-4, 1e-6, run.stats.tolerance])
    assert run.stats.tolerance <= 1e-7
    assert true_error(run) == pytest.approx(run.stats.tolerance, rel=1e-6)
    fall = (1e-6 / run.stats.tolerance) ** 0.7  # at least; the one before was the whole promise
    assert run.stats.error == pytest.approx((1e-4 - 1e-6) * 1.5 / (100 - 1.5) * 1.5 / fall, rel=3e-3)


def test_runs_of_the_same_steps_that_are_far_apart_are_not_the_same(search) -> None:
    """It is the gap at the end that counts: no run but the finest is compared with another method."""
    odd = lambda tolerance: round(math.log10(tolerance)) % 4 > 1  # noqa: E731
    paper = Paper(
        lambda method, tolerance: 0.3 if method == "dop853" and odd(tolerance) else 0.0, steps=lambda *_: 1000
    )
    with pytest.raises(pp.RunError, match="is not met"):
        search(paper, "dop853", 1e-2)
    other = next(i for i, (method, *_) in enumerate(paper.asked) if method != "dop853")
    assert ("dop853", method_of("dop853").least_tolerance, False) in paper.asked[:other]


def test_runs_that_do_not_change_are_compared_with_another_method(search) -> None:
    """Denser samples are tried three times; then ten times the distance of the other method is claimed."""
    paper = Paper(lambda method, tolerance: 0.0 if method == "dop853" else 1e-5, steps=lambda *_: 1000)
    run = search(paper, "dop853", 1e-3)
    assert run.stats.error == pytest.approx(10 * 1e-5, rel=1e-6)
    assert [method for method, *_ in paper.asked if method != "dop853"] == ["rk45"]
    with pytest.raises(pp.RunError, match="finer settings give the same run"):
        search(
            Paper(lambda method, tolerance: 0.0 if method == "dop853" else 0.5, steps=lambda *_: 1000), "dop853", 1e-3
        )


# --- rounding --------------------------------------------------------------------------------------------------------


def rounding_of(paper: Paper, target: float, lost: bool = False) -> Any:
    """What is measured beside a run at 1e-8, of one at 1e-12; or of a run that is lost."""
    scene = scene_of("dop853", target)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(accuracy_runs, "run_prepared", paper)
        runs = Runs(Prepared.of(scene), lambda t: None, Deadline(None))
        coarse, fine = (Attempt(tried, x, runs.run(tried)) for x in (1e-8, 1e-12) for tried in [scene.by("dop853", x)])
        if lost:
            return measure_rounding_of_lost_run(runs, fine, target, runs.ruler(fine.run))
        return measure_rounding(runs, coarse, fine, target, runs.ruler(fine.run))


@law(40)
@given(power=st.floats(0, 12), digits=st.floats(1.5, 9), steps=st.integers(1, 10**6))
def test_rounding_is_what_the_motion_magnifies(power: float, digits: float, steps: int) -> None:
    """Units of the start and of sqrt(steps), times the growth; beside it that of the path, and one unit.

    Where shifts of 1e5 units are too large, smaller ones are tried, down to a twentieth of the length over the target.
    """
    growth, target = 10.0**power, 10.0**-digits
    units = 4 + 0.3 * math.sqrt(steps)
    for times in (1e5, 0.05 / target):
        if times * units * UNIT * growth < 0.05:
            break
    else:
        return
    near = 1e-5 + 2 / (times * units)  # the shift itself is rounded
    found = rounding_of(Paper(lambda *_: 0.0, growth, steps=lambda *_: steps), target)
    magnified = 2 * math.sin(times * units * UNIT * growth / 2) / times
    assert found.last == pytest.approx(EPS * (1 + 4 * RATE * END) + magnified, rel=near)
    assert found.growth == pytest.approx(magnified / (units * EPS), rel=near)
    assert found.path == pytest.approx(RATE * END, rel=1e-6)
    times = min(1e5, 0.05 / target)
    near = 1e-5 + 2 / (times * units)
    lost = rounding_of(Paper(lambda *_: 0.0, growth, steps=lambda *_: steps), target, lost=True)
    magnified = 2 * math.sin(times * units * UNIT * growth / 2) / times
    assert lost.last == pytest.approx(magnified, rel=near)
    assert lost.growth == pytest.approx(magnified / (units * EPS), rel=near)
    assert (np.diff(found.error) >= 0).all()


def test_a_motion_beyond_rounding_is_refused_after_few_runs(search) -> None:
    """Runs that have nothing in common, and rounding that grows a thousand times beyond the target: no setting helps."""
    paper = Paper(lambda method, tolerance: 0.7 * abs(math.sin(1e3 * math.log(tolerance))), growth=1e11)
    with pytest.raises(pp.RunError, match="rounding errors of the start and of the steps grow") as caught:
        search(paper, "rk45", 1e-8)
    assert len(paper.asked) <= 8
    assert paper.count("rk45", method_of("rk45").least_tolerance) == 0
    assert caught.value.partial.stats.error > 1e-8


@pytest.mark.parametrize("method", ["rk45", "rk4"])
def test_coarse_runs_that_are_lost_are_asked_once_what_rounding_does(search, method: str) -> None:
    """It does little: the search goes on until the runs are fine enough, and meets its target."""
    lost = 1e-5 if method == "rk45" else 0.002
    order = 1 if method == "rk45" else 4

    def error(name: str, setting: float) -> float:
        return (
            0.01 * setting
            if name != method
            else setting**order
            if setting < lost
            else 0.5 + 0.5 * math.sin(1e3 / setting)
        )

    paper = Paper(error, growth=2.0)
    run = search(paper, method, 1e-5)
    assert true_error(run) <= run.stats.error <= 1e-5
    assert paper.count("dop853", 1e-12) <= (2 if method == "rk4" else 0)
    assert paper.count(method, 1e-12) == 0


def test_runs_that_end_early_are_refused_with_the_time_up_to_which_they_are_right(search) -> None:
    """That of the last sample there is; no error is claimed."""
    with pytest.raises(pp.RunError, match=r"the run does not reach its end and it is met up to t = 1 s$") as caught:
        search(Paper(lambda method, tolerance: 0.01 * tolerance, until=1.0), "rk45", 1e-6)
    assert caught.value.partial.stats.error is None
    assert caught.value.partial.t[-1] == 1.0


# --- further evidence ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("power", [0, 4, 6, 9])
def test_implicit_steps_are_compared_where_errors_grow(search, power: int) -> None:
    """With explicit ones whose tolerance, magnified, is a thousandth of the target; not where these have none so small."""
    growth, target = 10.0**power, 1e-5
    paper = Paper(lambda method, tolerance: 1e-6 * tolerance, growth)
    run = search(paper, "radau", target)
    others = [setting for method, setting, _ in paper.asked if method == "dop853"]
    finest = 1e-3 * target / (growth * (4 + 0.3 * math.sqrt(run.stats.steps)) + 1 + 4 * RATE * END)
    if power == 0 or finest < 1e-13:
        assert others == []
    else:
        assert others == [pytest.approx(min(finest, run.stats.tolerance), rel=0.6)]


def test_another_method_that_gives_another_motion_denies_a_claim(search) -> None:
    """Of implicit steps of a motion that magnifies errors a thousand times."""
    paper = Paper(lambda method, tolerance: 1e-6 * tolerance if method == "radau" else 0.1, growth=1e3)
    with pytest.raises(pp.RunError, match="another method gives another motion"):
        search(paper, "radau", 1e-5)


def test_an_unstable_motion_is_run_with_other_steps(search) -> None:
    """Four times the distance of a run with other output times is claimed, and a thousandth of the target at the least."""
    near = Paper(lambda method, tolerance: 0.1 * tolerance, 1e7, closer=2e-6)
    assert search(near, "dop853", 1e-5).stats.error == pytest.approx(4 * 2e-6, rel=0.3)
    steady = Paper(lambda method, tolerance: 0.1 * tolerance, 1.0, closer=2e-6)
    assert search(steady, "dop853", 1e-5).stats.error < 2e-6
    quiet = Paper(lambda method, tolerance: 1e-9 * tolerance, 1e4)
    assert search(quiet, "dop853", 0.1).stats.error == pytest.approx(1e-4, rel=1e-6)


def test_what_hardly_moves_is_compared_with_another_method(search) -> None:
    """A motion of less than its target says nothing by its runs; a larger one does."""
    for rate, compared in ((1e-5, True), (1e-2, False)):
        paper = Paper(lambda method, tolerance: 1e-3 * tolerance, rate=rate)
        search(paper, "dop853", 1e-4)
        assert any(method != "dop853" for method, *_ in paper.asked) == compared


# --- effects of a user's own -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("declared", [{}, {"gradual": False}, {"gradual": True}])
def test_what_may_be_narrow_is_looked_at_with_short_steps(search, declared: dict[str, bool]) -> None:
    """Once, in a 4,096th of the run; not where the effect declares that it is smooth. Twice its distance counts."""
    paper = Paper(lambda method, tolerance: 1e-9 * tolerance)
    run = search(paper, "dop853", 1e-5, Torque(lambda t, q, v: -0.1 * v, joints=["theta"], **declared))
    assert paper.longest == ([] if declared.get("gradual") else [pytest.approx(END / 4096)])
    assert run.stats.error < 1e-5


# --- many cases side by side -----------------------------------------------------------------------------------------


class Series(dict):
    """Series on paper: each case errs by its own factor times the tolerance, in proportion to the square of the time."""

    def __init__(self, tolerance: float, factors: Array, model: Model) -> None:
        self.tolerance, self.factors, self.model = tolerance, factors, model

    def run(self, cases: Cases, times: Array) -> Motions:
        places = cases.parameters[:, 0].astype(int)
        error = self.factors[places] * self.tolerance
        theta = START + RATE * times + error[:, None] * (times / END) ** 2
        q = np.stack([theta, np.zeros_like(theta)], -1)
        empty = np.full(len(places), np.nan)
        return Motions([self.model] * len(places), times, q, np.full_like(q, RATE), empty, np.zeros(len(places)))


def test_cases_side_by_side_are_each_met_by_their_errors_at_the_end() -> None:
    """At once, with finer series, or not at all: what is returned is within the target wherever it is said to be."""
    target, model = 1e-6, build(ROD)
    factors = np.array([0.0, 0.1, 1.0, 10.0, 1e3, 1e4, 1e5, 1e12])
    ladder = Ladder(scene_of("taylor", target), lambda tolerance: Series(tolerance, factors, model))
    tolerances = [series.tolerance for series in ladder.series]
    assert tolerances == pytest.approx([1e-5, 1e-7, 1e-9, 1e-11, 1e-13])
    n = len(factors)
    rest, numbers = np.zeros((n, 2)), np.arange(n)[:, None].astype(float)
    cases = Cases([model] * n, rest, rest, numbers, np.zeros(n), rest)
    finest, looser, met = ladder.run(cases)
    assert met.tolist() == [False, True, True, True, True, True, True, False]  # runs that are equal say nothing
    off = [np.abs(motions.q[:, -1, 0] - START - RATE * END) for motions in (finest, looser)]
    expected = factors * [1e-9, 1e-9, 1e-9, 1e-9, 1e-11, 1e-13, 1e-13, 1e-13]
    assert (off[0][met] <= target).all()
    assert off[1][1:7] == pytest.approx(100 * off[0][1:7], rel=1e-3)
    assert len(finest.t) == 65
    assert off[0][1:7] == pytest.approx(expected[1:7], rel=1e-3)
    for i in range(n):  # whatever its neighbours
        alone = ladder.run(cases.some(np.array([i])))
        assert alone[2].tolist() == [met[i]]
        np.testing.assert_array_equal(alone[0].q[0], finest.q[i])
