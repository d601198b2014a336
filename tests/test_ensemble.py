"""Many starts at once: each row is the start's own motion, and who runs beside it does not matter."""

import os
from contextlib import closing

import numpy as np
import pytest

import pendpin as pp
from pendpin.effects import Gravity, Stop
from pendpin.ground.arrays import Array
from pendpin.runs.batches import SAMPLES_AT_ONCE
from pendpin.scene import Scene, builtin_scene
from pendpin.sweeps import workers as pools
from pendpin.sweeps.workers import in_processes

ROD = builtin_scene().model_copy(update={"duration": 3.0})
THIN = pp.Scene(duration=2.0, model=pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0),), copies=2), effects=(Gravity(),))
STOPPED = ROD.model_copy(
    update={"duration": 1.0, "effects": (Gravity(), Stop(lower=-0.9, upper=0.9, joints=("theta",)))}
)


def starts(count: int, joints: int = 2) -> tuple[Array, Array]:
    """Positions and rates (count, joints), up to 0.8 rad and rad/s."""
    q, v = np.random.default_rng(1).uniform(-0.8, 0.8, (2, count, joints))
    return q, v


def alone(scene: Scene, q: Array, v: Array, method: str, tolerance: float) -> pp.Trajectory:
    """The motion from one start, by `simulate`."""
    start = pp.Start(time=scene.start.time, positions=tuple(q.tolist()), velocities=tuple(v.tolist()))
    return pp.simulate(scene.model_copy(update={"start": start}), method=method, tolerance=tolerance)


LATER = ROD.replace({"solver.times": (0.5, 1.9)})


@pytest.mark.parametrize("scene", [ROD, THIN, LATER], ids=["rod", "thin chain", "times without the start"])
def test_rows_are_simulate_of_their_starts(scene: Scene) -> None:
    """At 1e-15 truncation is below rounding: eps a step, 200 steps at most, grown fivefold by the motion, is 2e-13.

    Rates are up to 10 rad/s, and an angle near the pole magnifies what the tip does up to 10 times.
    """
    q, v = starts(20, 2 * len(pp.bind(scene).model.rods))
    many = pp.simulate_many(scene, q, v, method="taylor", tolerance=1e-15)
    for place in (0, 7, 19):
        one = alone(scene, q[place], v[place], "taylor", 1e-15)
        assert np.abs(many.tips([place])[0] - one.tips).max() < 2e-13
        assert np.abs(many.q[place] - one.q).max() < 2e-12
        assert np.abs(many.v[place] - one.v).max() < 2e-11
        assert np.array_equal(many.t, one.t)
    assert many.stats.method == "taylor"
    assert not many.stats.failures


@pytest.mark.parametrize("samples", [2, 3, 4, SAMPLES_AT_ONCE + 1, SAMPLES_AT_ONCE + 2])
def test_any_number_of_samples_is_of_the_same_motion(samples: int) -> None:
    """The last state is that of two samples, and what is between is on the way: each sample has its own time."""
    q, v = starts(3)
    scene = ROD.model_copy(update={"duration": 1.0})
    ends, many = (
        pp.simulate_many(scene.with_solver(samples=count), q, v, method="taylor", tolerance=1e-15)
        for count in (2, samples)
    )
    assert many.q.shape == (3, samples, 2)
    assert np.abs(many.q[:, -1] - ends.q[:, -1]).max() < 1e-12
    assert np.abs(np.diff(many.q, axis=1)).max() < 4 / (samples - 1)
    assert np.abs(np.diff(many.q, axis=1)).max(2).min() > 1e-9
    step = many.t[1]
    slope = (many.q[:, 1:] - many.q[:, :-1]) / step - (many.v[:, 1:] + many.v[:, :-1]) / 2
    assert np.abs(slope).max() < 40 * step**2


def test_neighbours_and_workers_do_not_matter() -> None:
    """Bit for bit: every integrator of a vector does its own arithmetic, with steps of its own."""
    q, v = starts(37)
    order = np.random.default_rng(2).permutation(37)
    many, shuffled = pp.simulate_many(ROD, q, v), pp.simulate_many(ROD, q[order], v[order], workers=1)
    few = pp.simulate_many(ROD, q[:3], v[:3])
    assert np.array_equal(many.q[order], shuffled.q)
    assert np.array_equal(many.v[order], shuffled.v)
    assert np.array_equal(many.q[:3], few.q)
    assert many.stats.steps == shuffled.stats.steps


def test_processes_and_series_agree() -> None:
    """At tolerances of 1e-12 both are within 1e-10: measured errors of dop853 are 20 times its tolerance."""
    q, v = starts(4)
    series = pp.simulate_many(ROD, q, v, tolerance=1e-12)
    processes = pp.simulate_many(ROD, q, v, method="dop853", tolerance=1e-12, workers=2)
    assert (series.stats.method, processes.stats.method) == ("taylor", "dop853")
    assert np.abs(series.tips() - processes.tips()).max() < 1e-10
    assert processes.stats.evaluations > processes.stats.steps > 0


def test_one_by_one_is_simulate() -> None:
    """A scene that the series do not take gets, bit for bit, what `simulate` gives."""
    q, v = starts(2)
    many = pp.simulate_many(STOPPED, q, v, tolerance=1e-8, workers=1)
    one = alone(STOPPED, q[1], v[1], "dop853", 1e-8)
    assert np.array_equal(many.q[1], one.q)
    assert np.array_equal(many.v[1], one.v)


def test_a_start_that_cannot_begin_is_named() -> None:
    """Beyond a stop, or too fast to compute with: NaN from the first sample on; the others are not touched."""
    q, v = starts(4)
    beyond = np.array([[0.1, 0.0], [1.2, 0.0]])
    many = pp.simulate_many(STOPPED, beyond, np.zeros((2, 2)), workers=1)
    assert list(many.stats.failures) == [1]
    assert "beyond its stop" in many.stats.failures[1]
    assert np.isnan(many.q[1]).all()
    assert np.isfinite(many.q[0]).all()
    fast = v.copy()
    fast[2] = 1e120
    many, calm = pp.simulate_many(ROD, q, fast, workers=1), pp.simulate_many(ROD, q, v, workers=1)
    assert list(many.stats.failures) == [2]
    assert "too large" in many.stats.failures[2]
    assert np.isnan(many.q[2]).all()
    others = [0, 1, 3]
    assert np.abs(many.q[others] - calm.q[others]).max() < 1e-8  # one by one, from segment to segment


@pytest.mark.parametrize("setting", [("rk4", 0.05), ("taylor", 0.1)])
def test_a_start_that_ends_early_is_named(setting: tuple[str, float]) -> None:
    """A setting too coarse for one start of two: `simulate` says where and why it ends, and so does its row."""
    scene = ROD.model_copy(update={"duration": 20.0}).by(*setting)
    q, v = np.array([[0.1, 0.0], [0.7, 0.4]]), np.array([[0.0, 0.0], [80.0, 50.0]])
    many = pp.simulate_many(scene, q, v, workers=1)
    start = pp.Start(positions=tuple(q[1].tolist()), velocities=tuple(v[1].tolist()))
    with pytest.raises(pp.RunError) as caught:
        pp.simulate(scene.model_copy(update={"start": start}))
    reached = len(caught.value.partial.t)
    assert many.stats.failures == {1: str(caught.value)}
    assert np.array_equal(many.q[1, :reached], caught.value.partial.q)
    assert np.isnan(many.q[1, reached:]).all()
    assert np.isfinite(many.q[0]).all()


@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_an_interrupt_keeps_what_is_done(method: str) -> None:
    """Interrupted, with the rows that are done; the rest is NaN and named."""
    q, v = starts(40)

    def stop(done: int) -> None:
        if done:
            raise KeyboardInterrupt

    with pytest.raises(pp.RunError, match="stopped by the user") as caught:
        pp.simulate_many(ROD, q, v, method=method, workers=1, progress=stop)
    partial = caught.value.partial
    done = np.isfinite(partial.q).all((1, 2))
    assert 0 < done.sum() < 40
    assert sorted(partial.stats.failures) == list(np.flatnonzero(~done))


NONE = np.zeros((1, 2))


@pytest.mark.parametrize(
    ("q", "v", "given", "said"),
    [
        (np.zeros((0, 2)), np.zeros((0, 2)), {}, "at least one start"),
        (np.zeros(2), NONE, {}, r"positions: shape \(2,\)"),
        (np.zeros((3, 3)), NONE, {}, r"positions: shape \(3, 3\), where \(starts, 2\) is wanted"),
        (np.zeros((3, 2)), NONE, {}, "velocities: 1 starts, where positions have 3"),
        ([[0.0, np.nan]], NONE, {}, r"positions\[0\]: phi is nan"),
        (NONE, [[np.inf, 0.0]], {}, r"velocities\[0\]: theta is inf"),
        ([[1e10, 0.0]], NONE, {}, r"positions\[0\]: theta is 1e\+10"),
        ([[0.0], [0.0, 1.0]], NONE, {}, "rows of different lengths"),
        ([["a", "b"]], NONE, {}, "not an array of numbers"),
        (None, NONE, {}, "not an array of numbers"),
        (np.zeros((10**6, 2)), np.zeros((10**6, 2)), {}, "5.79 GB"),
        (NONE, NONE, {"workers": 0}, "workers: 0"),
        (NONE, NONE, {"workers": 1.5}, "workers: 1.5"),
        (NONE, NONE, {"method": "gauss4", "tolerance": 1e-3}, "gauss4 takes a step"),
        (NONE, NONE, {"method": "magic"}, "magic"),
    ],
)
def test_nonsense_is_refused(q: object, v: object, given: dict, said: str) -> None:
    """In one line that names the argument."""
    with pytest.raises(pp.InputError, match=said) as caught:
        pp.simulate_many(ROD, q, v, **given)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("scene", [STOPPED, ROD], ids=["stops", "no stops"])
def test_no_process_starts_unless_workers_ask_for_it(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """A process would run a plain script again; with `workers` it may."""

    def refused(*_: object) -> None:
        raise AssertionError("a process was asked for")

    monkeypatch.setattr(pools, "ProcessPoolExecutor", refused)
    scene = scene.model_copy(update={"duration": 0.1}).with_solver(method="dop853")
    many = pp.simulate_many(scene, *starts(5))
    assert np.isfinite(many.q).all()
    assert many.stats.workers == 1
    with pytest.raises(AssertionError, match="a process was asked for"):
        pp.simulate_many(scene, *starts(5), workers=2)


@pytest.mark.slow
def test_processes_end_when_nobody_listens() -> None:
    """Those that wait or work stop with the iterator; none is left behind."""
    with closing(in_processes(_number, [(i, i + 1) for i in range(40)], 2)) as results:
        seen = {next(results)[1] for _ in range(4)}
    assert os.getpid() not in seen
    for process in seen:
        with pytest.raises(ProcessLookupError):
            os.kill(process, 0)


def test_a_process_that_dies_is_said() -> None:
    """In one line, with what may be behind it."""
    with pytest.raises(pp.RunError, match="ended unexpectedly"):
        list(in_processes(_die, [(1, 2), (2, 3)], 2))


def _number(begin: int, end: int) -> int:
    return os.getpid()


def _die(begin: int, end: int) -> None:
    os._exit(3)
