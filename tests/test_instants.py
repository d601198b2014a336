"""The instants of a run: any times inside it, however close to its samples."""

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin.errors import Note
from pendpin.motions.continuation import Continuation
from pendpin.motions.search import Changes, find_instants

GRAVITY = pp.effects.Gravity()
STOP = pp.effects.Stop(lower=-0.5, upper=0.9, restitution=0.6)
THICK = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.05),))
THIN = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0),))
TOLERANT = ("dop853", "rk45", "rk23", "radau", "bdf", "lsoda")
SETTINGS: dict[str, dict[str, Any]] = {
    **{method: {"method": method, "tolerance": 1e-8} for method in TOLERANT},
    **{method: {"method": method, "step": 0.01} for method in ("rk4", "gauss4")},
    "euler": {"method": "euler", "step": 0.001},
    "taylor": {"method": "taylor", "tolerance": 1e-12},
}


def swinging(model: pp.Chain, *effects: pp.effects.Effect, begin: float = 0.0, duration: float = 2.0) -> pp.Scene:
    """One rod thrown in both planes."""
    start = pp.Start(time=begin, positions=(0.7, 0.4), velocities=(1.3, -0.8))
    return pp.Scene(model=model, effects=(GRAVITY, *effects), start=start, duration=duration)


# --- times as close as rounding ---------------------------------------------------------------------------------------

CLOSE = st.lists(
    st.tuples(st.integers(0, 30), st.sampled_from([0, 1, 2, 3, 4, 5, 9, 100, 10**6])), min_size=1, max_size=9
)


def close_to(times: np.ndarray, near: list[tuple[int, int]]) -> np.ndarray:
    """Times (n,), and others so many units in the last place above some of them, rising."""
    more = [times[i % len(times)] + units * np.spacing(times[i % len(times)]) for i, units in near]
    return np.unique(np.clip(np.concatenate([times, more]), times[0], times[-1]))


@pytest.mark.parametrize("method", SETTINGS)
@pytest.mark.parametrize(
    "scene", [swinging(THICK), swinging(THIN), swinging(THICK, STOP)], ids=["thick", "thin", "stop"]
)
def test_times_that_were_asked_before_give_the_same_bits(method: str, scene: pp.Scene, monkeypatch) -> None:
    """Pieces are kept: a time gives what it gave before, as it would alone, and is not integrated again."""
    if STOP in scene.effects and method not in TOLERANT:
        pytest.skip("this method meets no stops")
    if method == "taylor":
        pytest.importorskip("heyoka")
    run = pp.simulate(scene, samples=9, **SETTINGS[method])
    some, others = np.linspace(0.1, 1.9, 17), np.linspace(0.05, 1.95, 12)
    more, alone = Continuation(run), Continuation(run).at(some)
    more.at(others)
    first = more.at(some)
    monkeypatch.setattr(Continuation, "piece", None)
    for again in (first, more.at(some)):
        for name in ("t", "q", "v", "a", "wrench"):
            np.testing.assert_array_equal(getattr(again, name), getattr(alone, name))
        assert (again.stats.steps, again.stats.evaluations) == (alone.stats.steps, alone.stats.evaluations)


@pytest.mark.parametrize("method", SETTINGS)
@law(4)
@given(near=CLOSE, thin=st.booleans(), stops=st.booleans(), begin=st.sampled_from([0.0, -3.7, 11.3]))
@example(near=[(3, 1)], thin=False, stops=False, begin=0.0)
@example(near=[(0, 5)], thin=False, stops=True, begin=0.0)
@example(near=[(0, 1), (0, 2), (0, 3), (30, 0)], thin=True, stops=False, begin=-3.7)
def test_a_time_may_be_as_close_to_a_sample_as_rounding(
    method: str, near: list[tuple[int, int]], thin: bool, stops: bool, begin: float
) -> None:
    """Asked for afterwards or beforehand: the states there differ by what moves in so short a time, and by tolerances."""
    if method == "taylor":
        pytest.importorskip("heyoka")
    contacts = (STOP,) if stops and method in TOLERANT else ()
    scene = swinging(THIN if thin else THICK, *contacts, begin=begin)
    run = pp.simulate(scene, samples=31, **SETTINGS[method])
    times = close_to(run.t, near)
    for other in (
        run.at(times),
        run.at(times[~np.isin(times, run.t[1:])]),
        pp.simulate(scene, times=times, **SETTINGS[method]),
    ):
        place = np.abs(other.t[:, None] - run.t).argmin(1)
        assert np.abs(other.q - run.q[place]).max() < (1e-4 if method == "euler" else 1e-6)
        assert np.isfinite(other.v).all()


def test_times_of_a_plain_range() -> None:
    """A tenth of a second added up is one unit in the last place off the samples."""
    run = pp.simulate(swinging(THICK, duration=10.0), accuracy=1e-8)
    times = np.arange(0, 10, 0.1)
    assert np.abs(run.at(times).q - run.q[np.abs(times[:, None] - run.t).argmin(1)]).max() < 1e-12


@pytest.mark.parametrize("method", SETTINGS)
def test_a_first_sample_may_come_as_soon_as_numbers_allow(method: str) -> None:
    """From the least number above 0 on."""
    if method == "taylor":
        pytest.importorskip("heyoka")
    times = [0.0, 5e-324, 1e-300, 1e-160, 1e-100, 1e-17, 1e-16, 0.1]
    run = pp.simulate(swinging(THIN), times=times, **SETTINGS[method])
    whole = pp.simulate(swinging(THIN), times=[0.0, 0.1], **SETTINGS[method])
    assert np.abs(run.q[:-1] - run.q[0]).max() < 1e-15
    assert np.abs(run.q[-1] - whole.q[-1]).max() < 1e-5


# --- where a quantity crosses a level -------------------------------------------------------------------------------


def test_what_is_rounding_is_not_searched(asked: list[int]) -> None:
    """Where a quantity stays at its level but for rounding, thousands of times tell no more than a few."""
    rods = (pp.Rod(length=1.0, mass=2.0, com=-0.3, inertia=(0.2, 0.25, 0.1)), pp.Rod(length=1.0, mass=1.0))
    start = pp.Start(positions=(np.pi, 1e-160, 0.0, -np.pi / 2))
    scene = pp.Scene(duration=0.5, model=pp.Chain(rods=rods), start=start, effects=(GRAVITY,))
    run = pp.simulate(scene, method="radau", tolerance=1e-6, samples=7)
    found = run.crossings("theta_1", np.pi)
    assert (np.abs(found["theta_1"] - np.pi) < 1e-12).all()
    assert sum(asked) < 10_000  # thirteen million once


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many times runs are asked for, each time that they are."""
    asked, at = list[int](), Continuation.at
    monkeypatch.setattr(Continuation, "at", lambda self, t: asked.append(len(t)) or at(self, t))
    return asked


def test_events_do_not_multiply_the_samples(asked: list[int]) -> None:
    """Two samples and 11 events: the pieces between events are cut as their steps need, not each as the whole run."""
    hard = pp.effects.Stop(lower=-0.3, upper=0.7, restitution=0.95)
    run = pp.simulate(swinging(THICK, hard, duration=6.0), method="dop853", tolerance=1e-9, samples=2)
    assert len(run.crossings("theta", 0.3).t) == len(run.events) == 11
    assert sum(asked) < 10 * run.stats.steps  # 18 once; with more events it was an error to have so few samples


def test_the_angles_of_a_pole_are_not_searched(asked: list[int]) -> None:
    """A thin rod hangs at its pole: which angles say so is rounding, at any scale of time."""
    start = pp.Start(positions=(0.0, np.pi / 2), velocities=(1.0, 0.0))
    side = pp.effects.Gravity(direction=(1.0, 0.0, 0.0))
    run = pp.simulate(pp.Scene(duration=1.0, model=THIN, start=start, effects=(side,)), method="dop853", samples=7)
    run.crossings("R3", 9.0)
    assert sum(asked) < 100 * len(run.t)  # an error once: 13 samples were too few for a run of 7 steps


def test_crossings_of_fixed_steps_are_on_the_level() -> None:
    """Two samples tell little of the run: those in between are at ends of steps, and do not change what comes behind."""
    run = pp.simulate(swinging(THICK, duration=3.0), method="euler", step=0.002, samples=2)
    found = run.crossings("R1", 0.1)
    assert len(found.t) > 2
    for t in found.t:
        assert abs(run.at([t])["R1"][0] - 0.1) < 1e-11  # 1e-6 once


@pytest.mark.parametrize(
    "number",
    [9, 17, 98, pytest.param(12, marks=pytest.mark.slow)],  # 98, across events, once missed a pair
)
def test_crossings_are_those_of_a_dense_search(number: int) -> None:
    """Queries of benchmarks/instants.py."""
    benchmark = runpy.run_path(str(Path(__file__).parents[1] / "benchmarks" / "instants.py"))
    assert benchmark["faults"](benchmark["query_of"](0, number)) == []


@pytest.mark.parametrize("begin", [pytest.param(1.7e9, marks=pytest.mark.slow), 1e12])
@pytest.mark.parametrize("rubs", [True, False], ids=["friction", "stop"])
def test_a_late_run_has_the_crossings_of_one_from_0_on(rubs: bool, begin: float) -> None:
    """Of crossings and extremes, where doubles are farther apart than events and samples beside them would be."""
    effect = pp.effects.DryFriction(kinetic=0.3) if rubs else pp.effects.Stop(lower=-0.2, upper=0.3, restitution=0.8)
    rod = pp.Rod(length=1.0, mass=1.0, joint="hinge")
    start = pp.Start(positions=(0.5 if rubs else 0.25,))
    scene = pp.Scene(model=pp.Chain(rods=(rod,)), duration=5.0, start=start, effects=(GRAVITY, effect))
    early, late = pp.simulate(scene), pp.simulate(scene.replace({"start.time": begin}))
    assert early.events
    one, two = (run.crossings("theta", 0.05).t for run in (early, late))
    assert len(one) == len(two) == (3 if rubs else 7)
    # doubles: two for an instant, one for the label of an event, one to subtract
    assert np.abs(two - begin - one).max() <= 4 * np.spacing(begin)
    for name in ("theta", "theta_rate"):
        for a, b in ((early.maximum(name), late.maximum(name)), (early.minimum(name), late.minimum(name))):
            # a rate of 1 rad/s and an acceleration of 10 rad/s², where it jumps, at a double beside the right time
            assert b.value == pytest.approx(a.value, abs=1e-9 + 20 * np.spacing(begin))


def test_samples_a_few_doubles_apart_change_no_crossing() -> None:
    """They tell no polynomial, so that the run is sampled where they are near."""
    even = 3.0 + np.linspace(0.0, 2.0, 61)
    times = np.unique(np.concatenate([even, *(even[20:30] + k * np.spacing(even[20:30]) for k in (1, 2, 3, 5, 9))]))
    scene = swinging(THICK, pp.effects.DryFriction(kinetic=0.3), begin=3.0)
    one, two = (pp.simulate(scene, times=tuple(t), tolerance=1e-10) for t in (even, times))
    for name in ("theta", "theta_rate", "R3"):
        level = float(one[name].mean())
        assert one.crossings(name, level).t == pytest.approx(two.crossings(name, level).t, abs=1e-8)
        assert one.maximum(name).value == pytest.approx(two.maximum(name).value, abs=1e-8)


# --- the instant in an interval, of functions of time alone -------------------------------------------------------------


class Clock:
    """In the place of a run: its state is the time, and it notes which times are asked for."""

    def __init__(self) -> None:
        self.asked = list[np.ndarray]()

    def at(self, times: np.ndarray) -> np.ndarray:
        self.asked.append(times)
        return times


ROOT = 1.2345678901234567
FUNCTIONS = {
    "line": lambda t: t - ROOT,
    "cubic": lambda t: (t - ROOT) ** 3 + 1e-3 * (t - ROOT),
    "falling": lambda t: np.exp(-t) - np.exp(-ROOT),
    "steep": lambda t: np.arctan(1e6 * (t - ROOT)),
    "flat": lambda t: (t - ROOT) ** 5,
    "root": lambda t: np.sign(t - ROOT) * np.sqrt(np.abs(t - ROOT)),
    "jump": lambda t: np.where(t < ROOT, -1.0, 1e-2),
    "high jump": lambda t: np.where(t < ROOT, -1e-2, 1.0),
}


@pytest.mark.parametrize("name", FUNCTIONS)
@law(20)
@given(begin=st.sampled_from([0.0, 1.0, ROOT - 1e-9]), end=st.sampled_from([ROOT + 1e-12, 1.3, 40.0]))
def test_an_instant_is_found_to_rounding(name: str, begin: float, end: float) -> None:
    """By few looks at times inside the interval; of a jump, just after it."""
    function, clock = FUNCTIONS[name], Clock()
    ends = [np.array([x]) for x in (begin, end, function(np.array(begin)), function(np.array(end)))]
    (found,) = find_instants(clock, function, Changes(*ends))  # type: ignore[arg-type]
    times = np.concatenate(clock.asked)
    assert (times > begin).all()
    assert (times < end).all()
    if name.endswith("jump"):
        assert ROOT <= found <= min(end, ROOT + 2e-13 * max(end - begin, ROOT))
        behind = (
            0.9e-13 * max(end - begin, ROOT) if name == "high jump" else 0.0
        )  # it is the end before that is nearer to 0
        assert found == end or found >= ROOT + behind
        assert len(times) <= 60
    else:
        assert abs(found - ROOT) <= 4 * np.spacing(ROOT)
        assert len(times) <= {"flat": 70, "root": 60, "steep": 60, "cubic": 22}.get(name, 14)


def test_a_zero_beside_the_begin_of_its_interval_is_no_jump() -> None:
    """However small the quantity is there, and however large at the end: its zero is found to rounding."""
    (found,) = find_instants(
        Clock(),
        lambda t: (t - 1.0) - 1.03e-14,
        Changes(*np.array([[1.0], [2.0], [-1.03e-14], [1.0]])),  # type: ignore[arg-type]
    )
    assert abs(found - 1.0 - 1.03e-14) <= 2 * np.spacing(1.0)


# --- the instants of events -------------------------------------------------------------------------------------------


def knocking(rods: int) -> pp.Scene:
    """Rods whose first and last joints have stops and friction; two come to rest on the way."""
    small, random = rods > 5, np.random.default_rng(rods)
    first, last = ("theta_1", f"phi_{rods}") if rods > 1 else ("theta", "phi")
    rod = pp.Rod(length=0.1, mass=0.05, radius=0.02) if small else pp.Rod(length=1.0, mass=1.0, radius=0.02)
    stop = pp.effects.Stop(lower=-0.3, upper=0.4, restitution=0.5, joints=[first, last])
    rubbing = pp.effects.DryFriction(kinetic=0.05, joints=[last if rods == 1 else "phi_1"])
    positions, velocities = random.uniform(-0.2, 0.3, 2 * rods), random.uniform(-2, 2, 2 * rods)
    start = pp.Start(time=3.7, positions=tuple(positions.tolist()), velocities=tuple(velocities.tolist()))
    model = pp.Chain(rods=(rod,) * rods)
    return pp.Scene(model=model, effects=(GRAVITY, stop, rubbing), start=start, duration=0.29 if small else 3.0)


@pytest.mark.parametrize(("rods", "tolerance"), [(1, 1e-8), (1, 1e-4), (2, 1e-8), (2, 1e-5), (20, 1e-8)])
def test_at_the_instant_of_an_event_the_run_is_behind_it(rods: int, tolerance: float) -> None:
    """After a stop a joint leaves its limit, one that sticks is still, one that turns is pulled as just behind the event.

    Just before the event it moves towards the limit, or moves at all.
    """
    run = pp.simulate(knocking(rods), tolerance=tolerance)
    assert len(run.events) >= 5
    for t, joint, kind in run.events:
        i, alone = run.joints.index(joint), [e.t for e in run.events if 0 < abs(e.t - t) < 1e-6] == []
        before, at = np.nextafter(t, 0), run.at(t)
        rate = at.v[0, i]
        if kind == "stop":
            away = -np.sign(at.q[0, i] - 0.05)
            assert rate * away >= 0
            assert not alone or run.at(before).v[0, i] * away < 0
        if kind == "stick":
            assert rate == 0
            assert not alone or run.at(before).v[0, i] != 0
        if kind == "reverse" and alone:
            sides = run.at([t - 1e-8, t, t + 1e-8]).a[:, i]
            assert abs(sides[1] - sides[2]) < 0.1 * abs(sides[0] - sides[2])


# --- the largest value ------------------------------------------------------------------------------------------------


# 0: a support's path by gauss4 in 20,000 samples; 45: one by lsoda
@pytest.mark.parametrize("number", [pytest.param(0, marks=pytest.mark.slow), 3, 5, 9, 17, 45])
def test_the_largest_value_is_that_of_a_dense_run(number: int) -> None:
    """Queries of benchmarks/maxima.py, of few samples and many."""
    benchmark = runpy.run_path(str(Path(__file__).parents[1] / "benchmarks" / "maxima.py"))
    assert benchmark["fault"](benchmark["query_of"](0, number)) == ""


def test_extremes_of_a_rod_in_a_plane_are_exact() -> None:
    """Let go at an angle: R3 is g m (3 - 2 cos(angle)) of a point mass at the bottom; the angle's least is its opposite."""
    start = pp.Start(positions={"theta": 1.0})
    bob = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, com=1.0, inertia=(0.0, 0.0, 0.0)),))
    scene = pp.Scene(model=bob, effects=(GRAVITY,), start=start, duration=3.0)
    run = pp.simulate(scene, method="dop853", tolerance=1e-12, samples=5)
    assert run.maximum("R3").value == pytest.approx(9.81 * (3 - 2 * np.cos(1.0)), rel=1e-10)
    assert run.minimum("R3") == pytest.approx((9.81 * np.cos(1.0), run.minimum("R3").t), rel=1e-10)
    assert run.minimum("theta").value == pytest.approx(-1.0, abs=1e-10)
    assert abs(run.at(run.minimum("theta").t)["theta_rate"][0]) < 1e-4  # a time is known as well as the root of a value
    assert run.maximum("t").value == run.maximum("t").t == 3.0


@pytest.mark.parametrize("method", SETTINGS)
def test_extremes_of_a_rod_on_a_spring_are_exact(method: str) -> None:
    """By every method, of a fixed step too: a cosine of an amplitude of 0.5 rad, between a few samples."""
    rod = THICK.rods[0]
    stiffness = rod.properties.I1 + rod.mass * rod.length**2 / 4  # one rad/s
    start = pp.Start(positions={"theta": 0.3}, velocities={"theta": 0.4})
    spring = pp.effects.Spring(stiffness=stiffness, joints=("theta",))
    run = pp.simulate(
        pp.Scene(model=THICK, effects=(spring,), start=start, duration=5.0), samples=7, **SETTINGS[method]
    )
    error = 1e-3 if method == "euler" else 1e-6
    for found, value, t in (
        (run.maximum("theta"), 0.5, np.arctan2(0.4, 0.3)),
        (run.minimum("theta"), -0.5, np.arctan2(0.4, 0.3) + np.pi),
        (run.minimum("theta_rate"), -0.5, np.arctan2(0.4, 0.3) + np.pi / 2),
    ):
        assert found.value == pytest.approx(value, abs=error)
        assert found.t == pytest.approx(t, abs=2 * error**0.5)


def test_the_side_of_an_impact() -> None:
    """The least rate is just before the impact, the largest just behind it: e times as large, the other way."""
    stop = pp.effects.Stop(lower=0.2, upper=0.9, restitution=0.6, joints=["theta"])
    start = pp.Start(time=2.0, positions={"theta": 0.5}, velocities={"theta": 0.0})
    scene = pp.Scene(model=THICK, effects=(GRAVITY, stop), start=start, duration=0.5)
    run = pp.simulate(scene, tolerance=1e-10, samples=7)
    (event,) = run.events
    before, behind = run.minimum("theta_rate"), run.maximum("theta_rate")
    assert (before.t, behind.t) == (np.nextafter(event.t, 0), event.t)
    assert behind.value == pytest.approx(-0.6 * before.value, rel=1e-9)
    assert run.at(before.t)["theta_rate"][0] == before.value
    with pytest.warns(Note, match="not defined at 1 impact;"):
        run.maximum("R3")


def test_beside_a_stop_a_rod_sticks_when_it_sticks() -> None:
    """Not a ten-millionth of the run sooner, where the run is sampled: there it slides on, within a bounce too small."""
    rod, limits = pp.Rod(length=1.0, mass=1.0, joint="hinge"), pp.effects.Stop(lower=-2.0, upper=2.0)
    effects = (GRAVITY, pp.effects.DryFriction(kinetic=0.3), limits)
    scene = pp.Scene(model=pp.Chain(rods=(rod,)), duration=5.0, start=pp.Start(positions=(0.5,)), effects=effects)
    run = pp.simulate(scene, tolerance=1e-10)
    event = run.events[-1]
    assert event.kind == "stick"
    sliding, held = run.at([np.nextafter(event.t, 0), event.t])["theta_acceleration"]
    assert (sliding, held) == (pytest.approx(-0.953, abs=1e-3), 0.0)
    *_, instant = run.crossings("theta_acceleration", sliding / 2).t
    assert event.t <= instant <= event.t + 2e-13 * event.t  # how far behind a jump its instant is


def test_the_force_of_a_load_that_is_stopped_is_not_that_of_a_sample(tmp_path: Path) -> None:
    """Its support falls and stands still: sixty samples a second show a fraction of the largest force."""
    t = np.linspace(0, 1, 101)
    table = np.column_stack([t, 0 * t, 0 * t, -6 * np.minimum(t, 0.5)])
    np.savetxt(tmp_path / "drop.csv", table, delimiter=",", header="t,x,y,z", comments="")
    rods = (pp.Rod(length=0.5, mass=1.0, radius=0.01),) * 5 + (pp.Rod(length=0.5, mass=1.0, payload=200.0),)
    effects = (GRAVITY, pp.effects.Support(csv=tmp_path / "drop.csv"))
    scene = pp.Scene(model=pp.Chain(rods=rods), effects=effects, start={"positions": {"phi_1": 0.05}}, duration=1.0)
    run = pp.simulate(scene, tolerance=1e-10, samples=61)
    largest = run.maximum("R3_1")
    times = np.unique(np.concatenate([np.linspace(0, 1, 5001), largest.t + np.linspace(-2e-4, 2e-4, 2001)]))
    dense = pp.simulate(scene, tolerance=1e-11, times=times)["R3_1"]
    assert largest.value == pytest.approx(dense.max(), rel=1e-4)
    assert run["R3_1"].max() < 0.5 * largest.value


@pytest.mark.parametrize("rod", [{"joint": "hinge"}, {}, {"radius": 0.05}], ids=["hinge", "thin", "thick"])
@pytest.mark.parametrize("tolerance", [1e-8, 1e-12])
def test_the_swing_of_a_rod_that_passes_a_pole_is_exact(rod: dict, tolerance: float) -> None:
    """At a pole the angle to the vertical has a corner, in every turn: half a turn at the top, 0 at the bottom."""
    model = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, **rod),))
    turning = pp.Start(positions={"theta": 1.0}, velocities={"theta": 9.0})
    run = pp.simulate(pp.Scene(model=model, duration=4.0, start=turning, effects=(GRAVITY,)), tolerance=tolerance)
    assert len(run.crossings("theta", 3 * np.pi).t) == 1  # it passes both poles more than once
    exact = max(
        tolerance, 1e-10
    )  # a pole is passed at another time from another sample on; 1e-6 once, at any tolerance
    assert np.pi - exact <= run.maximum("swing").value <= np.pi
    assert 0.0 <= run.minimum("swing").value <= exact


@pytest.mark.parametrize("rods", [1, 3])
def test_a_run_that_dry_friction_holds_crosses_nothing(rods: int):
    """Its accelerations are rounding, 1e-15, and no reason for samples between its own."""
    joints = {"theta": 0.3, "phi": -0.2} if rods == 1 else {"theta_1": 0.3, "phi_1": -0.2, "theta_3": 0.1}
    chain = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.01),) * rods)
    held = (pp.effects.Gravity(), pp.effects.DryFriction(kinetic=40.0, static=90.0))
    scene = pp.Scene(model=chain, duration=80.0, start=pp.Start(positions=joints), effects=held)
    run = pp.simulate(scene)
    assert not run.v.any()
    assert len(run.crossings(run.joints[0]).t) == 0


@pytest.mark.parametrize(
    ("method", "lower"),
    [
        *(("radau", 0.0), ("radau", 0.3), ("dop853", 0.3), ("lsoda", 0.3)),
        *(
            pytest.param(method, lower, marks=pytest.mark.slow)
            for method, lower in (("radau", 0.1), ("dop853", 0.0), ("dop853", 0.1), ("lsoda", 0.0), ("lsoda", 0.1))
        ),
    ],
)
def test_a_joint_that_leaves_its_stop_does_not_cross_it(method: str, lower: float):
    """It rests on the stop and leaves it with the third power of time, which a step meets with an error."""
    stop = pp.effects.Stop(lower=lower, upper=3.0, joints=["theta"])
    motor = pp.effects.Motor(joint="theta", amplitude=4.0, frequency=2.0)
    scene = pp.Scene(
        duration=10.0,
        model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]),
        start=pp.Start(positions={"theta": lower}),
        effects=[pp.effects.Gravity(), stop, motor],
    )
    run = pp.simulate(scene, method=method)
    assert sum(event.kind == "release" for event in run.events) == 4
    assert not len(run.crossings("theta", lower).t)
    assert 0 <= run.minimum("theta").value - lower < 1e-12  # to which the least value is resolved


def test_levels_and_directions_may_be_numbers_of_numpy() -> None:
    """A level taken from an array crosses where Python's number does."""
    rod = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)])
    run = pp.simulate(pp.Scene(duration=2.0, model=rod, effects=["gravity"], start=pp.Start(positions={"theta": 1.0})))
    of_numpy = run.crossings("theta", np.int64(0), np.int64(-1))
    assert len(of_numpy.t)
    assert np.array_equal(of_numpy.t, run.crossings("theta", 0.0, -1).t)
