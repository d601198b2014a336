"""Sweeps: every case is what a single run gives, whoever runs it and however the sweep is cut or broken off."""

import math
import subprocess
import sys
from functools import partial
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest
from scipy import stats

import pendpin as pp
from laws import HANG
from pendpin import effects as fx
from pendpin.dynamics.compiling import EquationsOfMotion, staying_zero
from pendpin.errors import Interrupted
from pendpin.sweeps import cases, plan
from pendpin.sweeps.cases import Block, Task, run_block, run_case
from pendpin.sweeps.plan import indices, sobol_plan
from pendpin.sweeps.workers import in_threads
from sweep_scenes import KEYS, ROD, scene

pytest.importorskip("xarray")
pytest.importorskip("heyoka")

# --- what a case gives ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("effects", [(), (fx.Gravity(),), (fx.Gravity(), fx.Viscous(coefficient=0.1))])
def test_rods_at_rest_are_swept(count: int, effects: tuple) -> None:
    """Nothing moves, in any case of a sweep: no swing, no turn, and each rod's joint carries what hangs on it."""
    hanging = pp.Scene(duration=1.0, model=pp.Chain(rods=(ROD,) * count), effects=effects)
    names = ["swing", "flip_time", "R3_1.max" if count > 1 else "R3.max"]
    for measures in (names[:2], names):
        found = pp.sweep(hanging, {"model.rods[0].mass": [0.5, 1.0]}, measures)
        assert (found["swing"].values == 0).all()
        assert np.isnan(found["flip_time"].values).all()
    weights = 9.81 * (np.array([0.5, 1.0]) + (count - 1) * ROD.mass)
    np.testing.assert_allclose(found[names[2]].values, weights if effects else 0.0, rtol=1e-15)


@pytest.mark.parametrize(
    ("varied", "chosen"),
    [
        ({"start.positions.theta_1": [0.3, 2.9], "start.velocities.phi_2": [0.0, 1.0]}, scene()),
        ({"model.rods[0].length": [0.5, 1.5], "model.rods[1].mass": [0.1, 2.0]}, scene()),
        (
            {"effects[0].acceleration": [1.0, 20.0], "effects[1].coefficient": [0.01, 0.5]},
            scene(fx.Viscous(coefficient=0.1)),
        ),
        ({"model.rods[0].length": [0.4, 2.0]}, scene(model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]))),
        ({"effects[1].stiffness": [0.5, 8.0]}, scene(fx.Spring(stiffness=1.0), model=pp.Chain(rods=[ROD]))),
    ],
    ids=["start", "model", "effects", "thin", "spring"],
)
def test_a_case_in_vectors_is_the_single_run(varied: dict, chosen: pp.Scene) -> None:
    """To the tolerance, times the growth of errors over two seconds of regular motion."""
    measures = (
        "theta_1.final" if chosen.model.count == 2 else "theta.final",
        "swing",
        "R3.max" if chosen.model.count == 1 else "R3_2.max",
    )
    task = Task(chosen, plan.grid(varied), measures)
    assert task.batch is not None
    found = run_block(task, 0, task.plan.count)
    for i, row in enumerate(task.plan.rows(np.arange(task.plan.count))):
        values, why = run_case(task, row)
        assert (found.why[i], why) == ("", "")
        np.testing.assert_allclose(found.values[i], values, atol=1e-7, rtol=1e-7)


@pytest.mark.parametrize(
    ("effect", "still"),
    [
        (fx.Viscous(coefficient=0.1), (1, 3, 5, 7)),
        (fx.Push(link="rod_2", force=(0.0, 1.0, 0.0)), (1, 3, 5, 7)),
        (fx.Push(link="rod_2", force=(1.0, 0.0, 0.0)), ()),
        (fx.Spring(stiffness=1.0, rest=0.1, joints=["phi_2"]), ()),
        (fx.Rotation(latitude=45.0), ()),
    ],
    ids=["viscous", "in the plane", "out of it", "spring", "rotation"],
)
def test_what_stays_zero_is_not_integrated(effect: fx.Effect, still: tuple[int, ...]) -> None:
    """phi and phi' of a planar motion: Pinocchio's acceleration is 0 there at any theta; and nothing else stays 0."""
    dynamics = pp.bind(scene(effect))
    equations = EquationsOfMotion(dynamics.engine, (fx.Gravity(), effect), 0.0)
    found = staying_zero(equations, (1, 3, 4, 5, 6, 7))  # released at rest
    assert found == still
    random = np.random.default_rng(1)
    phi = np.array([1, 3])
    for _ in range(5):
        q, v = np.insert(random.normal(size=(2, 2)), [1, 2], 0.0, axis=1)
        away = np.abs(dynamics.acceleration(0.0, q, v)[phi]).max()
        assert away <= 1e-13 if still else away > 1e-6


@pytest.mark.parametrize(("target", "reach"), [(1e-4, 3.0), (1e-9, 1.0)])
def test_cases_in_vectors_meet_their_accuracy(target: float, reach: float) -> None:
    """Against series to rounding: the tips at the end, over the length; a case that is left out is simulated on its own."""
    starts = np.random.default_rng(2).uniform(-reach, reach, (20, 2))
    chosen = scene(duration=4.0).replace(solver=pp.Solver(accuracy=target))
    task = Task(chosen, plan.pairs(dict(zip(KEYS, starts.T, strict=True))), ("theta_1.final", "theta_2.final"))
    found = Block(np.full((20, 2), np.nan), np.full(20, "", dtype=object))
    met = np.flatnonzero(task.batch.fill(starts, found))
    assert len(met) >= 15
    exact = pp.sweep(scene(duration=4.0), task.plan, task.measures, method="taylor", tolerance=1e-17)
    known = np.stack([exact[name].values for name in task.measures], -1)[met]
    one, other = (np.exp(1j * np.cumsum(q, -1)) * [1.0, 0.7] for q in (found.values[met], known))
    assert np.abs((one - other).cumsum(-1)).max() <= 1.7 * target


PUSHED = pp.Scene(
    duration=0.5,
    model=pp.Chain(
        rods=[pp.Rod(length=1.0, mass=1.0, radius=0.05), pp.Rod(length=0.7, mass=0.5, payload=0.2, radius=0.03)]
    ),
    start=pp.Start(positions={"theta_1": 0.5, "phi_2": 0.2}),
    effects=[
        fx.Gravity(),
        fx.Viscous(coefficient=0.1),
        fx.Spring(stiffness=1.0, rest=0.1),
        fx.Push(link="rod_1", force=(1.0, 0.5, 0.2)),
        fx.Support(amplitude=(0.1, 0.0, 0.05), frequency=3.0),
    ],
    solver=pp.Solver(samples=11, tolerance=1e-9),
)


@pytest.mark.parametrize(
    "key",
    [
        "effects[0].acceleration",
        "effects[1].coefficient",
        "effects[2].stiffness",
        "effects[2].rest",
        "effects[3].force[1]",
        "effects[4].amplitude[0]",
        "model.rods[0].radius",
        "model.rods[1].payload",
    ],
)
def test_a_number_may_be_0(key: str) -> None:
    """Its equations are others then: such a case is simulated on its own, wherever it stands in the sweep."""
    values = [0.0, 0.1, 0.0, 0.05]
    found = pp.sweep(PUSHED, {key: values}, ["theta_1.min"])["theta_1.min"].values
    own = [pp.simulate(PUSHED.replace({key: x}))["theta_1"].min() for x in values]
    np.testing.assert_allclose(found, own, atol=1e-8)


@pytest.mark.parametrize("values", [[0.0, 1.2], [1.2, 0.0]])
def test_a_case_may_be_less_smooth_than_the_scene(values: list[float]) -> None:
    """A quadratic drag that is 0 in the scene, and in some cases, has corners in others."""
    given = scene(fx.Drag(density=0.0, linear=0.1, diameter=0.02), duration=1.0)
    found = pp.sweep(given, {"effects[1].density": values}, ["theta_1.final"])["theta_1.final"].values
    own = [pp.simulate(given.replace({"effects[1].density": x}))["theta_1"][-1] for x in values]
    np.testing.assert_allclose(found, own, atol=1e-8)


def test_what_has_corners_is_simulated_on_its_own() -> None:
    """Dry friction: no vectors, the same measures."""
    task = Task(scene(fx.DryFriction(kinetic=0.2), duration=1.0), plan.grid({KEYS[0]: [0.5, 1.0]}), ("swing",))
    assert task.batch is None
    found = run_block(task, 0, 2)
    assert list(found.why) == ["", ""]
    assert (found.values[:, 0] >= [0.5, 1.0]).all()


def test_a_sweep_that_is_stopped_does_not_wait_for_its_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """A case that would run for ever ends, one by one and in vectors; what was done before stays."""
    task = Task(scene(fx.DryFriction(kinetic=0.2), duration=1.0), plan.grid({KEYS[0]: [0.5, 1.0]}), ("swing",))
    simulated, asked = cases.run_to_setting, iter([False, True])

    def endless(given: pp.Scene, progress: Any) -> Any:
        while next(asked, True):
            progress(0.0)
        return simulated(given)

    monkeypatch.setattr(cases, "run_to_setting", endless)
    results = in_threads(partial(run_block, task), [(0, 1), (1, 2)], 1)
    assert next(results)[1].why[0] == ""
    results.close()  # returns
    stopped = Event()
    stopped.set()
    many = Task(scene(duration=1e6), plan.grid({KEYS[0]: [0.5, 1.0]}), ("swing",))  # an hour of steps
    assert many.batch is not None
    with pytest.raises(Interrupted):
        run_block(many, 0, 2, stopped)


TAKEN = """
import signal, threading
from pendpin.sweeps.workers import in_threads

def block(begin, end, stopped):
    threading.Timer(0.1, signal.pthread_kill, (threading.get_ident(), signal.SIGINT)).start()
    stopped.wait()

signal.signal(signal.SIGINT, signal.default_int_handler)  # it is off where tests run in the background
try:
    next(in_threads(block, [(0, 1)], 1))
except KeyboardInterrupt:
    print("interrupted")
"""


def test_ctrl_c_ends_a_wait_for_blocks_that_it_does_not_wake() -> None:
    """A signal that a working thread takes leaves the one that waits asleep; it looks all the same, and ends the others.

    In a process of its own: in this one Hypothesis watches the collector, and what is raised in its callback is lost.
    """
    done = subprocess.run([sys.executable, "-c", TAKEN], capture_output=True, text=True, timeout=HANG)
    assert (done.stdout, done.stderr) == ("interrupted\n", "")


def test_flip_times_are_roots() -> None:
    """A planar rod thrown over the top: the time is the elliptic integral, by vectors and by a single run."""
    rate = 7.0  # rad/s at the bottom; over the top of a uniform thin rod of 1 m from sqrt(6 g / l) = 7.67 on: none
    fast = 9.0
    thin = pp.Scene(
        duration=3.0,
        model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]),
        effects=[fx.Gravity()],
        solver=pp.Solver(tolerance=1e-12, samples=7),
    )
    found = pp.sweep(thin, {"start.velocities.theta": [rate, fast]}, "flip_time").flip_time.values
    from scipy.special import ellipk

    k2 = 6 * 9.81 / fast**2  # theta'² = fast² - 6 g sin²(theta / 2), so t(pi) = 2 K(k²) / fast
    assert math.isnan(found[0])
    assert found[1] == pytest.approx(2 * float(ellipk(k2)) / fast, abs=1e-10)
    single, _ = run_case(Task(thin, plan.grid({"start.velocities.theta": [fast]}), ("flip_time",)), np.array([fast]))
    assert single[0] == pytest.approx(found[1], abs=1e-9)


def test_chaos_is_seen() -> None:
    """A double pendulum that tumbles has a positive exponent, and two tolerances part; a small swing has neither."""
    wild = scene(duration=10.0, tolerance=1e-9)
    found = pp.sweep(wild, {KEYS[0]: [0.1, 2.9]}, ["lyapunov", "divergence"], tolerance=1e-9)
    calm, chaotic = found.lyapunov.values
    assert abs(calm) < 0.5
    assert chaotic > 1.0
    assert found.divergence.values[0] < 1e-5


def test_a_function_of_the_run_is_a_measure() -> None:
    """With its own name."""

    def lowest(run: pp.Trajectory) -> float:
        return float(run.tips[..., 2].min())

    found = pp.sweep(scene(), {KEYS[0]: [0.0, 1.0]}, lowest)
    assert found["lowest"].shape == (2,)


# --- what cannot be run ---------------------------------------------------------------------------------------------


def test_what_does_not_settle_has_no_settling_time() -> None:
    """A rod without damping; one whose small swings fall by exp(-c t / 2 J), to 2 % at 2.6 s."""
    free = pp.Scene(model=pp.Chain(rods=[pp.Rod(length=1, mass=1)]), start=pp.Start(positions={"theta": 0.1}))
    free = free.replace(effects=[fx.Gravity()])
    damped = free.replace(effects=[fx.Gravity(), fx.Viscous(coefficient=1.0)])
    durations = {"duration": [5.0, 10.0, 20.0]}
    assert np.isnan(pp.sweep(free, durations, "settling_time").settling_time.values).all()
    times = pp.sweep(damped, durations, "settling_time").settling_time.values
    assert times[1:] == pytest.approx(np.log(50) * 2 / 3, abs=0.9)


def test_a_case_that_cannot_go_on_does_not_touch_its_neighbours() -> None:
    """Bit for bit: one too fast for series stops the vector that it shares with others."""
    speeds = [1.0, 2.0, 1e70, 3.0, 4.0]
    with_it, without = (
        pp.sweep(scene(), {"start.velocities.theta_1": some}, ["theta_1.final", "swing"], method="taylor")
        for some in (speeds, [v for v in speeds if v < 10])
    )
    assert "not a finite number" in with_it.why.values[2]
    for name in ("theta_1.final", "swing"):
        assert math.isnan(with_it[name].values[2])
        np.testing.assert_array_equal(np.delete(with_it[name].values, 2), without[name].values)


def test_a_case_that_cannot_run_is_nan_with_its_reason() -> None:
    """And the others are as they were, the first one or not."""
    found = pp.sweep(scene(), {"model.rods[0].mass": [-2.0, 1.0, -1.0, 2.0]}, "theta_1.final")
    values, why = found["theta_1.final"].values, found.why.values
    np.testing.assert_array_equal(np.isnan(values), [True, False, True, False])
    assert ["mass" in reason for reason in why] == [True, False, True, False]

    def fails(run: pp.Trajectory) -> float:
        return run.q[10**9, 0] if run.q[0, 0] > 0.5 else 1.0 if len(run.t) == 3 else run.no_such_name

    found = pp.sweep(scene(), {KEYS[0]: [0.0, 1.0], "solver.samples": [3, 5]}, ["swing", fails])
    np.testing.assert_array_equal(found.fails.isnull().values, [[False, True], [True, True]])
    assert ["IndexError" in why for why in found.why.values[:, 1]] == [False, True]


@pytest.mark.parametrize("measure", ["swing", "theta_1.max"])
@pytest.mark.parametrize(
    ("key", "values"),
    [("start.positions.theta_1", [1e20, 0.5]), ("effects[1].upper", [0.4, 0.6]), ("model.copies", [3, 2])],
)
def test_any_case_may_be_one_that_cannot_start(key: str, values: list[float], measure: str) -> None:
    """In either order the same value, unit and reason: of angles too large, beyond a stop, or of other joints."""
    start = pp.Start(positions=[0.5, 0.0, 0.2, 0.0] if key == "model.copies" else {"theta_1": 0.5})
    stop = [fx.Stop(joints=["theta_1"], upper=1.0)] if key == "effects[1].upper" else []
    two = pp.Scene(model=pp.Chain(rods=[ROD], copies=2), start=start, effects=[fx.Gravity(), *stop], duration=0.5)
    one, other = (pp.sweep(two, {key: order}, measure) for order in (values, values[::-1]))
    reason, none = one.why.values.tolist()
    assert (reason.startswith("start.positions"), none, other.why.values.tolist()) == (True, "", ["", reason])
    assert np.isnan(one[measure].values).tolist() == [True, False]
    np.testing.assert_array_equal(one[measure].values, other[measure].values[::-1])
    assert one[measure].attrs["units"] == other[measure].attrs["units"] == "rad"


def test_a_quantity_may_be_missing_in_some_cases() -> None:
    """In either order: it is NaN there. One that no case has is refused."""
    one = pp.Scene(model=pp.Chain(rods=[ROD], copies=2), start=pp.Start(positions={"theta_1": 0.5}), duration=0.1)
    for copies in ([2, 3], [3, 2]):
        found = pp.sweep(one, {"model.copies": copies}, "theta_3.max")["theta_3.max"]
        assert np.isnan(found.values).tolist() == [count == 2 for count in copies]
        assert found.attrs["units"] == "rad"
        with pytest.raises(pp.InputError, match="theta_4"):
            pp.sweep(one, {"model.copies": copies}, "theta_4.max")


@pytest.mark.parametrize(
    ("vary", "measure", "says"),
    [
        ({"model.rods[0].lenght": [1.0]}, "swing", "length"),
        ({"start.positions.theta_9": [1.0]}, "swing", "theta_9"),
        ({KEYS[0]: [1.0]}, "swng", "swng"),
        ({KEYS[0]: [1.0]}, "theta_1.maximum", "theta_1.maximum"),
        ({KEYS[0]: [1.0]}, "theta_9.max", "theta_9.* is not a quantity"),
        ({KEYS[0]: [1.0]}, ["swing", "swing"], "given twice"),
        ({"model.rods[0].mass": [-1.0, -2.0]}, "swing", "below 0"),
        ({KEYS[0]: [math.nan]}, "swing", "finite"),
        ({KEYS[0]: []}, "swing", "one or more"),
        ({}, "swing", "nothing is varied"),
        ({KEYS[0]: ["1"]}, "swing", "are not numbers"),
        ({KEYS[0]: [True]}, "swing", "are not numbers"),
        ([KEYS[0]], "swing", "not a mapping"),
        ({3: [1.0]}, "swing", "not a key path"),
        ({KEYS[0]: [1.0]}, [], "nothing is measured"),
        ({KEYS[0]: [1.0]}, 3, "neither a name nor a function"),
        ({KEYS[0]: [1.0]}, type("a/b", (), {}), "cannot name a variable"),
    ],
)
def test_what_is_refused(vary: Any, measure: Any, says: str) -> None:
    """In one line, before anything is run."""
    with pytest.raises(pp.InputError, match=says):
        pp.sweep(scene(), vary, measure)


def test_sampling_and_pairs() -> None:
    """Latin hypercubes have one case in each of n slices of each number; pairs have as many values for each key."""
    spreads = {"a": ("uniform", 0.0, 1.0), "b": ("uniform", -1.0, 3.0)}
    rows = plan.samples(spreads, 16, "latin", seed=1).rows(np.arange(16))
    assert sorted(np.floor(rows[:, 0] * 16)) == list(range(16))
    assert sorted(np.floor((rows[:, 1] + 1) * 4)) == list(range(16))
    with pytest.raises(pp.InputError, match="as many values"):
        plan.pairs({"a": [1.0, 2.0], "b": [1.0]})


def test_axes_on_the_command_line(tmp_path: Path) -> None:
    """FROM:TO:COUNT, or numbers with commas; rows of a file, at least one."""
    axes = plan.read_axes(["a=-1:3:5", "b=2:7:1", "c=1, 4"])
    assert [axes[key].tolist() for key in "abc"] == [[-1, 0, 1, 2, 3], [2], [1, 4]]
    for text in ("a=0:1", "a=0:1:2:3", "a=0:1:x", "a=0:1:0", "a=0:1:2.5"):
        with pytest.raises(pp.InputError, match="FROM:TO:COUNT"):
            plan.read_axes([text])
    cases = tmp_path / "cases.csv"
    cases.write_text("a,b\n1,2\n3,4\n")
    assert plan.cases_of(cases).rows(np.arange(2)).tolist() == [[1, 2], [3, 4]]
    cases.write_text("a,b\n")
    with pytest.raises(pp.InputError, match="no cases"):
        plan.cases_of(cases)
    with pytest.raises(pp.InputError, match="finite"):
        plan.grid({"a": [1.0, np.inf]})


@pytest.mark.parametrize("method", ["latin", "sobol", "random"])
def test_a_seed_gives_its_cases(method: str) -> None:
    """The same again, from 0 on; another seed gives others."""
    spreads = {"a": ("uniform", 0.0, 1.0), "b": ("normal", 0.0, 1.0)}
    zero, again, one = (plan.samples(spreads, 4, method, seed).rows(np.arange(4)) for seed in (0, 0, 1))
    assert np.array_equal(zero, again)
    assert not np.array_equal(zero, one)
    with pytest.raises(pp.InputError, match="seed"):
        plan.samples(spreads, 4, method, -1)


def test_sobol_indices_of_a_known_function() -> None:
    """Y = a + 2 b, both uniform on (0, 1): 1/5 and 4/5 of the variance, alone and in all."""
    spreads = {"a": ("uniform", 0.0, 1.0), "b": ("uniform", 0.0, 1.0)}
    rows = sobol_plan(spreads, 1024)
    found = indices(spreads, rows.values["a"] + 2 * rows.values["b"])
    assert found == indices(spreads, rows.values["a"] + 2 * rows.values["b"])  # its intervals are drawn, from a seed
    for key, share in (("a", 0.2), ("b", 0.8)):
        assert found[key]["first"] == pytest.approx(share, abs=0.03)
        assert found[key]["total"] == pytest.approx(share, abs=0.03)


def test_sobol_indices_are_scipys() -> None:
    """Ishigami's function: the same as scipy.stats.sobol_indices from the same cases; one key alone has the whole."""
    spreads = dict.fromkeys("abc", ("uniform", -math.pi, math.pi))
    a, b, c = sobol_plan(spreads, 256, seed=3).values.values()
    y = np.sin(a) + 7 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a)
    columns = (y - y.mean()).reshape(256, 5).T
    parts = {"f_A": columns[:1], "f_B": columns[-1:], "f_AB": columns[1:-1, None]}
    theirs, ours = stats.sobol_indices(func=parts, n=256), indices(spreads, y)
    np.testing.assert_allclose([ours[key]["first"] for key in "abc"], theirs.first_order, rtol=0, atol=1e-13)
    np.testing.assert_allclose([ours[key]["total"] for key in "abc"], theirs.total_order, rtol=0, atol=1e-13)
    one = {"a": spreads["a"]}
    (alone,) = sobol_plan(one, 2).values.values()
    assert set(indices(one, alone)) == {"a"}
    constant = np.nextafter(1.0, 1.0 + np.sign(a))  # but for its last bit
    assert {share for row in indices(spreads, constant).values() for share in row.values()} == {0.0}


@pytest.mark.slow
def test_kapitzas_tongue() -> None:
    """Upright on a shaken support, over amplitude and frequency: stable within one cell of Floquet's boundary.

    The linear equation x'' = (g - a w² sin(w t)) x / L, L = 2/3 of the length, is stable where the trace of its monodromy
    matrix is within -2 and 2 (M. Abramowitz, I. Stegun, chapter 20).
    """
    from scipy.integrate import solve_ivp

    def stable(a: float, w: float) -> bool:
        rate = lambda t, y: [y[1], (9.81 - a * w * w * np.sin(w * t)) / (2 / 3) * y[0]]  # noqa: E731
        columns = [solve_ivp(rate, (0, 2 * np.pi / w), y, rtol=1e-10, atol=1e-12).y[:, -1] for y in ([1, 0], [0, 1])]
        return bool(abs(columns[0][0] + columns[1][1]) < 2)

    rod = pp.Scene(
        duration=6.0,
        model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]),
        start=pp.Start(positions={"theta": math.pi - 1e-4}),
        effects=[fx.Gravity(), fx.Support(amplitude=(0.0, 0.0, 0.1), frequency=40.0)],
        solver=pp.Solver(tolerance=1e-9, samples=61),
    )
    amplitudes, frequencies = np.linspace(0.05, 0.2, 10), np.linspace(20.0, 80.0, 10)

    def away(run: pp.Trajectory) -> float:
        return float(np.abs(run.q[:, 0] - math.pi).max())

    found = pp.sweep(rod, {"effects[1].amplitude[2]": amplitudes, "effects[1].frequency": frequencies}, away)
    stays = found["away"].values < 0.1
    expected = np.array([[stable(a, w) for w in frequencies] for a in amplitudes])
    for i, j in np.argwhere(stays != expected):  # a neighbour is on the other side
        around = expected[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2]
        assert around.any()
        assert not around.all()
    assert 10 < stays.sum() < 90
