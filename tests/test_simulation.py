"""Runs against exact solutions and published values, and the laws that every run keeps."""

import gc
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import Engine
from pendpin.equations.exact import planar, spherical
from pendpin.runs.preparation import known_dynamics, known_runs
from pendpin.scene import builtin_scene
from scenes import scene_of

GRAVITY = (pp.effects.Gravity(),)
THIN = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0),))
POINT = pp.Chain(rods=(pp.Rod(length=1.0, mass=0.0, payload=1.0),))
THICK = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.1),))
METHODS = ("dop853", "rk45", "rk23", "radau", "bdf", "lsoda")


def swing(model: pp.Chain, duration: float, q=(0.7, 0.4), v=(1.3, -0.8), samples: int | None = None) -> pp.Scene:
    """One rod under gravity."""
    return scene_of(model, *GRAVITY, q=q, v=v, duration=duration, tolerance=1e-12, samples=samples)


def test_energy_is_kept_over_100_s() -> None:
    """The built-in rod at tolerance 1e-12: relative drift under 1e-9."""
    run = pp.simulate(builtin_scene().model_copy(update={"duration": 100.0}), tolerance=1e-12)
    assert run.energy().drift < 1e-9


@pytest.mark.parametrize(("q", "v", "axis"), [((0.9, 0.0), (0.5, 0.0), 0), ((0.0, 1.2), (0.0, -0.3), 1)])
def test_planar_swing_is_the_elliptic_one(q: tuple, v: tuple, axis: int) -> None:
    """theta alone, or phi alone: the exact angle of a thin rod; tip error under 1e-8 m over 100 s."""
    run = pp.simulate(swing(THIN, 100.0, q, v, samples=201))
    angle = planar(q[axis], v[axis], 2 / 3, 9.81, run.t)
    error = 2 * np.sin(np.abs(run.q[:, axis] - angle) / 2)  # times the length of 1 m
    assert error.max() < 1e-8
    assert np.abs(run.q[:, 1 - axis]).max() == 0


def test_spherical_swing_is_the_elliptic_one() -> None:
    """A thin rod is a spherical pendulum of length 2l/3: tip error under 1e-8 m over 100 s."""
    run = pp.simulate(swing(THIN, 100.0, samples=201))
    (s_t, s), (c_t, c) = np.sin(run.q[0]), np.cos(run.q[0])
    (dt, dp) = run.v[0]
    direction = np.array([s, -s_t * c, -c_t * c])
    rate = np.array([c * dp, -c_t * c * dt + s_t * s * dp, s_t * c * dt + c_t * s * dp])
    exact = spherical(direction, rate, 2 / 3, 9.81, run.t[::10])
    assert np.linalg.norm(run.tips[::10, 0] - exact, axis=-1).max() < 1e-8


def test_iftomm_benchmark_a01() -> None:
    """IFToMM A01: 1 kg at 1 m, g 9.81, from x = +1 at rest; x, y at 10 s as published."""
    run = pp.simulate(swing(POINT, 10.0, (np.pi / 2, 0.0), (0.0, 0.0), samples=2))
    x, y = -run.tips[-1, 0, 1], run.tips[-1, 0, 2]  # theta swings in the plane of y and z
    assert x == pytest.approx(0.275087462576, abs=2e-10)
    assert y == pytest.approx(-0.961419205099, abs=2e-10)


@pytest.mark.parametrize("method", METHODS)
def test_every_method_arrives_at_the_same_place(method: str) -> None:
    """Each adaptive method, at a tolerance it can carry, within what its order allows."""
    reference = pp.simulate(swing(THICK, 2.0), tolerance=1e-13)
    run = pp.simulate(swing(THICK, 2.0), method=method, tolerance=1e-8)
    assert np.abs(run.tips - reference.tips).max() < 2e-5
    assert run.stats.method == method
    assert run.stats.evaluations > run.stats.steps > 0


@pytest.mark.parametrize("method", METHODS)
def test_scipy_runs_the_methods_where_cyrk_is_missing(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without CyRK the same methods run on SciPy and give the same motion."""
    with_cyrk = pp.simulate(swing(THICK, 2.0), method=method, tolerance=1e-9)
    monkeypatch.setitem(__import__("sys").modules, "CyRK", None)
    known_runs.known.clear()  # which method runs was decided with CyRK there
    without = pp.simulate(swing(THICK, 2.0), method=method, tolerance=1e-9)
    assert (with_cyrk.stats.library, without.stats.library) == ("CyRK", "scipy")
    assert np.abs(with_cyrk.tips - without.tips).max() < 2e-6


def numbers(most: float) -> st.SearchStrategy[float]:
    """Numbers of a start: below 1e-140 the norm of dop853's error underflows, and a run may end in one line."""
    return st.floats(-most, most).map(lambda x: x if abs(x) > 1e-140 else 0.0)


@law(15)
@given(numbers(1.4), numbers(1.4), numbers(5), numbers(5))
def test_running_back_returns_to_the_start(theta: float, phi: float, dtheta: float, dphi: float) -> None:
    """Reversibility: forward 1 s, the rates reversed, forward 1 s again."""
    there = pp.simulate(swing(THICK, 1.0, (theta, phi), (dtheta, dphi)))
    back = pp.simulate(swing(THICK, 1.0, tuple(there.q[-1]), tuple(-there.v[-1])))
    assert np.allclose(back.q[-1], (theta, phi), atol=1e-8, rtol=0)
    assert np.allclose(back.v[-1], (-dtheta, -dphi), atol=1e-7, rtol=0)


def test_without_effects_nothing_acts() -> None:
    """No gravity unless it is listed: a rod at rest stays, exactly."""
    scene = pp.Scene(duration=1.0, model=THICK, start=pp.Start(positions={"theta": 1.0, "phi": 0.5}))
    run = pp.simulate(scene)
    assert (run.q == run.q[0]).all()
    assert (run.wrench == 0).all()


def test_output_times_are_those_asked_for() -> None:
    """samples counts both ends; 60 a second and one more if absent; a duration of 0 has one."""
    assert (pp.simulate(swing(THICK, 1.0, samples=5)).t == [0, 0.25, 0.5, 0.75, 1]).all()
    assert len(pp.simulate(swing(THICK, 1.0)).t) == 61
    at_once = pp.simulate(swing(THICK, 0.0))
    assert at_once.t.tolist() == [0.0]
    assert at_once.q.tolist() == [[0.7, 0.4]]


def test_an_interrupt_keeps_what_is_done() -> None:
    """Ctrl-C in the middle: the error carries the run up to there."""
    seen = []

    def progress(t: float) -> None:
        seen.append(t)
        if t > 50:
            raise KeyboardInterrupt

    with pytest.raises(pp.RunError, match="stopped by the user") as caught:
        pp.simulate(swing(THICK, 100.0), progress=progress)
    partial = caught.value.partial
    assert 10 < partial.t[-1] <= seen[-1]
    assert partial.stats.stopped == "stopped by the user"
    assert partial.energy().drift < 1e-9


# --- what is kept from run to run -----------------------------------------------------------------------------------


def test_a_run_does_not_depend_on_those_before() -> None:
    """Scenes that differ in one number, by turns: each gives the bits that it gives where nothing is known."""
    first = swing(THICK, 1.0)
    changes: list[dict[str, object]] = [
        {},
        {"model.rods[0].mass": 2.0},
        {"start.positions": (0.7, 0.0)},
        {"start.time": 3.0},
        {"solver.tolerance": 1e-6},
        {"solver.method": "rk45"},
        {"solver.engine": "pinocchio"},
        {"duration": 0.5},
        {"effects[0].acceleration": 1.62},
    ]
    scenes, alone = [first.replace(change) for change in changes], []
    for scene in scenes:
        known_runs.known.clear()
        known_dynamics.known.clear()
        alone.append(pp.simulate(scene))
    for _ in range(2):
        for scene, run in zip(scenes, alone, strict=True):
            again = pp.simulate(scene)
            assert again == run
            assert (again.stats.steps, again.stats.evaluations) == (run.stats.steps, run.stats.evaluations)


def test_what_a_user_changes_is_seen_by_the_next_run(tmp_path: Path) -> None:
    """A function that returns other numbers, a file with other rows: nothing of them is kept."""
    strength, track = [1.0], tmp_path / "track.csv"
    torque = pp.effects.Torque(function=lambda t, q, v: strength * np.cos(q[:1]), joints=["theta"], steady=True)
    runs = []
    for size in (1.0, -1.0):
        strength[0] = size
        track.write_text("t,x,y,z\n" + "".join(f"{t / 4},0,{size * (t / 4) ** 2},0\n" for t in range(9)))
        for effect in (torque, pp.effects.Support(csv=track)):
            runs.append(pp.simulate(swing(THICK, 1.0, (0.0, 0.0), (0.0, 0.0)).replace(effects=[*GRAVITY, effect])))
    for one, other in zip(
        runs[:2], runs[2:], strict=True
    ):  # a mirrored torque or acceleration, from rest straight down
        assert np.abs(one.q).max() > 0.1
        assert np.abs(one.q + other.q).max() < 1e-11


def test_runs_in_threads_share_nothing() -> None:
    """The same scene in four threads at once, again and again: each run is that of one thread alone."""
    scene = swing(THICK, 2.0)
    alone = pp.simulate(scene)
    with ThreadPoolExecutor(4) as pool:
        assert all(run == alone for run in pool.map(lambda _: pp.simulate(scene), range(24)))


def kinds(root: type) -> set[type]:
    """A class and all that derive from it."""
    return {root}.union(*map(kinds, root.__subclasses__()))


ENGINES = kinds(Dynamics) | kinds(Engine)  # a set: isinstance of a million objects takes seconds


@pytest.mark.parametrize("method", ["auto", "taylor", "gauss4", "rk4", *METHODS])
@pytest.mark.parametrize("stop", [False, True])
def test_a_run_leaves_no_engine_behind(method: str, stop: bool) -> None:
    """What was bound for a run is freed with it, without a search for circles: Pinocchio's data of 60 rods are 250 MB."""
    if stop and method in ("taylor", "gauss4", "rk4"):
        pytest.skip("it takes no stops")
    if stop and method in ("bdf", "lsoda"):
        pytest.skip("SciPy's own objects are circles, and hold the equations")
    effects = (*GRAVITY, pp.effects.Stop(lower=-0.19, upper=0.3)) if stop else GRAVITY
    setting = {"step": 0.01} if method in ("gauss4", "rk4") else {}

    def engines_after_a_run() -> int:
        scene = scene_of(
            (pp.Rod(length=0.1, mass=0.1, radius=0.01),) * 2, *effects, q=(0.2, 0.0, 0.1, 0.1), duration=0.3
        )
        run = pp.simulate(scene, method=method, samples=5, **setting)
        run.at([0.1])
        run.crossings("theta_1")
        return sum(type(thing) in ENGINES for thing in gc.get_objects())

    gc.collect(1)
    gc.freeze()  # what other tests have left is not looked through: a second, each time
    gc.disable()
    try:
        engines_after_a_run()  # what is made once in a process
        before = engines_after_a_run()
        assert engines_after_a_run() <= before
    finally:
        gc.enable()
