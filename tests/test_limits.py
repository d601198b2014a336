"""A limit is a limit of the whole call: compiling, every run, and completing the samples. No clock is read here."""

import itertools
import json
import re
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from itertools import count
from threading import Event
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pendpin as pp
from laws import HANG
from pendpin.dynamics import compiling
from pendpin.effects import Gravity
from pendpin.errors import Halted, Interrupted
from pendpin.ground import libraries
from pendpin.runs import limits, run
from pendpin.runs.integration import SmoothLoop
from pendpin.runs.motion_with_events import LoopWithEvents
from pendpin.stability.sections import bifurcation, crossing, portrait, strobe
from pendpin.sweeps.significance import significance
from pendpin.verification.hardcases import CASES, run_case

ROD = pp.Rod(length=1.0, mass=1.0, radius=0.05)
METHODS: dict[str, dict[str, float]] = {"dop853": {}, "taylor": {}, "gauss4": {"step": 0.01}, "rk4": {"step": 0.01}}


class Clock:
    """A clock that advances only on request."""

    def __init__(self) -> None:
        self.now = 0.0

    def perf_counter(self) -> float:
        """The time of the wall, s."""
        return self.now

    thread_time = process_time = perf_counter


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """A clock in place of the real one, where limits are kept."""
    found = Clock()
    monkeypatch.setattr(limits, "time", found)
    monkeypatch.setattr(run, "time", found)
    return found


def swing(**changed: Any) -> pp.Scene:
    """One rod under gravity for 10 s."""
    given: dict[str, Any] = {"model": pp.Chain(rods=(ROD,)), "start": pp.Start(positions=(0.7, 0.4))}
    return pp.Scene(**given | {"effects": (pp.effects.Gravity(),)} | changed)


@pytest.mark.parametrize(("integrating", "completing"), [(0.3, 0.0), (0.0, 0.01), (0.05, 0.005)])
def test_what_is_integrated_can_be_completed_in_time(
    clock: Clock, monkeypatch: pytest.MonkeyPatch, integrating: float, completing: float
) -> None:
    """Every evaluation and every completed sample takes time: the call ends before its limit of 1 s, with what there is."""
    fill = run.fill_in

    def slow(scene: Any, dynamics: Any, balance: Any, done: Any) -> Any:
        clock.now += completing * len(done.t)
        return fill(scene, dynamics, balance, done)

    def tick(t: float) -> None:
        clock.now += integrating

    monkeypatch.setattr(run, "fill_in", slow)
    with pytest.raises(Halted, match="it takes over 1 s") as caught:
        pp.simulate(swing(duration=300.0), limit=1.0, progress=tick)
    assert clock.now <= 1.0 + integrating + 0.02  # the start is completed in any case
    assert len(caught.value.partial.t) >= 1


def test_compiling_is_not_a_cost_of_every_sample(clock: Clock, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first completion compiles for 0.5 s, and 601 samples take 0.06 s: a run of 1 s has time for both."""
    fill, first = run.fill_in, iter([0.5])

    def slow(scene: Any, dynamics: Any, balance: Any, done: Any) -> Any:
        clock.now += next(first, 0.0) + 1e-4 * len(done.t)
        return fill(scene, dynamics, balance, done)

    monkeypatch.setattr(run, "fill_in", slow)
    assert len(pp.simulate(swing(duration=10.0), limit=1.0).t) == 601
    assert 0.5 < clock.now < 1.0


def test_a_run_that_is_stopped_before_its_second_sample_can_be_shown() -> None:
    """It has events, and one sample: that is its largest value, and its table."""
    effects = (pp.effects.Gravity(), pp.effects.Stop(joints=("theta",), lower=-0.3, upper=0.3, restitution=0.9))
    scene = swing(duration=1e4, effects=effects, start=pp.Start(positions=(0.2, 0.4), velocities=(1.0, 0.0)))
    looks = iter(range(200))

    def stop(t: float) -> None:
        if next(looks, None) is None:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        pp.simulate(scene, samples=2, progress=stop)
    run = pp.Trajectory.of(caught.value.partial)
    assert len(run.t) == 1 < len(run.events)
    assert run.maximum("theta") == (0.2, 0.0)
    assert not len(run.crossings("theta").t)
    assert run.summary()["farthest sideways"].time == 0.0
    assert run.summary().remark.startswith("those of the 1 sample: the run ended early")  # nothing more is integrated


STOPPED: dict[str, Callable[[pp.Scene], object]] = {
    "summary": lambda scene: pp.simulate(scene, samples=6).summary(),
    "crossings": lambda scene: pp.simulate(scene, samples=6).crossings("theta"),
    "accuracy": lambda scene: pp.simulate(scene.with_solver(tolerance=None), accuracy=1e-4),
    "significance": lambda scene: significance(scene),
    "portrait": lambda scene: portrait(
        scene.with_solver(method="gauss4", step=0.05), crossing("theta", of="phi", count=2, skip=0), 2, -1.0
    ),
    "bifurcation": lambda scene: bifurcation(
        scene, "effects[1].kinetic", [0.1, 0.2], strobe(0.5, of="theta", count=3, skip=0)
    ),
    "sweep": lambda scene: pp.sweep(scene, {"start.positions[0]": [0.1, 0.2]}, "swing"),
    "closely": lambda scene: pp.sweep(scene.with_solver(samples=4), {"start.positions[0]": [0.1, 0.2]}, "R3.max"),
    "orbit": lambda scene: pp.periodic_orbit(scene),
}


@pytest.mark.parametrize("name", STOPPED)
def test_ctrl_c_is_no_failure_of_a_run(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """Work of many runs notes a run that fails and goes on to the next; the user's Ctrl-C, in any of them, ends the work."""
    scene = swing(duration=2.0, effects=(Gravity(), pp.effects.DryFriction(kinetic=0.1)))
    smooth = {
        "closely": (Gravity(), pp.effects.Viscous(coefficient=0.1)),
        "portrait": (Gravity(),),
        "orbit": (Gravity(),),
    }
    scene = scene.replace(effects=smooth.get(name, scene.effects))
    stop = SimpleNamespace(segments=itertools.count(), at=np.inf)
    for kind in (SmoothLoop, LoopWithEvents):

        def go_on(*given: Any, go_on: Any = kind.go_on) -> Any:
            if next(stop.segments) >= stop.at:
                raise KeyboardInterrupt
            return go_on(*given)

        monkeypatch.setattr(kind, "go_on", go_on)
    STOPPED[name](scene)
    whole = next(stop.segments)
    assert whole
    for stop.at in {0, whole // 3, 2 * whole // 3, whole - 1}:
        stop.segments = itertools.count()
        with pytest.raises((Interrupted, KeyboardInterrupt)):
            STOPPED[name](scene)


@pytest.mark.parametrize("options", [{"method": "taylor"}, {"solver": pp.Solver(engine="compiled")}])
def test_compiling_is_in_the_limit(monkeypatch: pytest.MonkeyPatch, options: dict[str, Any]) -> None:
    """Equations that are not compiled at the limit are not waited for; the start is what there is."""
    pytest.importorskip("heyoka")
    late, work = Event(), libraries.Thread.run
    monkeypatch.setattr(libraries.Thread, "run", lambda thread: late.wait() and work(thread))
    effects = (pp.effects.Gravity(), pp.effects.Spring(stiffness=1.5))  # not compiled by another test
    scene = swing(effects=effects, **{key: value for key, value in options.items() if key == "solver"})
    with pytest.raises(Halted, match="while compiling") as caught:
        pp.simulate(scene, limit=1e-9, **{key: value for key, value in options.items() if key == "method"})
    assert caught.value.partial.q.tolist() == [[0.7, 0.4]]
    late.set()
    for thread in libraries.abandoned:
        thread.join()


LEFT = """
import atexit, sys, threading
from pendpin.ground import libraries
thread = threading.Thread(target=threading.Event().wait, daemon=True)  # compiles for ever
thread.start()
libraries.abandoned.append(thread)
atexit.register(thread.join)
sys.argv = ["pendpin", *sys.argv[1:]]
from pendpin.cli import main
main()
"""


@pytest.mark.parametrize(("arguments", "status"), [(("schema",), 0), (("run", "none.toml"), 1)])
def test_the_command_does_not_wait_for_what_its_limit_has_left(arguments: tuple[str, ...], status: int) -> None:
    """A process that has given up a computation ends: its output is whole, its exit status its own."""
    done = subprocess.run([sys.executable, "-c", LEFT, *arguments], capture_output=True, text=True, timeout=HANG)
    assert done.returncode == status
    assert json.loads(done.stdout) if not status else done.stderr.startswith("pendpin: none.toml")


FOR_EVER = """
import os, signal, sys, threading
from pendpin.ground.libraries import abandoned, wait_for

def compile_for_ever():
    taker = {"waits": threading.main_thread(), "computes": threading.current_thread()}[sys.argv[1]]
    threading.Timer(0.1, signal.pthread_kill, (taker.ident, signal.SIGINT)).start()
    threading.Event().wait()

signal.signal(signal.SIGINT, signal.default_int_handler)  # it is off where tests run in the background
try:
    wait_for(compile_for_ever)
except KeyboardInterrupt:
    print("interrupted", abandoned[-1].is_alive(), flush=True)
    os._exit(0)
"""


@pytest.mark.parametrize("taker", ["waits", "computes"])
def test_ctrl_c_does_not_wait_for_a_compiler(taker: str) -> None:
    """It ends the wait for what heeds no signal, which goes on in its thread; without a signal there is the result.

    So it does whichever thread the system gives the signal to: one that computes does not wake the one that waits.
    In a process of its own: in this one Hypothesis watches the collector, and what is raised in its callback is lost.
    """
    assert libraries.wait_for(lambda: 3) == 3
    with pytest.raises(ZeroDivisionError):
        libraries.wait_for(lambda: 1 / 0)
    done = subprocess.run([sys.executable, "-c", FOR_EVER, taker], capture_output=True, text=True, timeout=HANG)
    assert (done.stdout, done.stderr) == ("interrupted True\n", "")


def test_recording_is_in_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Equations are recorded where the deadline is looked at, whether the scene or `auto` compiles them."""
    pytest.importorskip("llvmlite")
    waited: list[bool] = []

    def wait_for(deadline: Any, compute: Any, long: bool) -> Any:
        waited.append(long)
        if long:
            raise Halted("at once")
        return compute()

    def record(*given: Any) -> None:
        raise AssertionError

    monkeypatch.setattr(limits.Deadline, "wait_for", wait_for)
    monkeypatch.setattr(compiling.EquationsOfMotion, "record", record)
    monkeypatch.setattr(compiling, "_known", libraries.Recent(10))
    for solver in (pp.Solver(engine="compiled", method="dop853"), pp.Solver()):
        with pytest.raises(Halted):
            pp.simulate(swing(solver=solver), limit=1.0)
    assert waited == [False, True, True]  # to prepare and to run; with "auto" to choose the method


def test_a_fault_while_compiling_is_the_same_with_a_limit() -> None:
    """What raises in the thread raises in the call."""
    pytest.importorskip("heyoka")
    many = swing(model=pp.Chain(rods=(ROD,), copies=12), start=pp.Start())
    says = []
    for limit in (None, 1000.0):
        with pytest.raises(pp.InputError) as caught:
            pp.simulate(many, method="taylor", limit=limit)
        says.append(str(caught.value))
    assert says[0] == says[1]


def test_a_run_that_waits_for_the_processor_goes_on(clock: Clock, monkeypatch: pytest.MonkeyPatch) -> None:
    """Hours of the wall in which others had the processor end nothing; processor time without progress does."""
    used = 0.0
    monkeypatch.setattr(clock, "process_time", lambda: used)
    patience = limits.Patience(10.0, limits.Deadline(None), lambda t: 0.0, lambda t: None)
    for t in np.linspace(0.0, 1e-9, 100):
        clock.now += 3600.0
        patience(float(t))
    used = 2 * limits.WINDOW
    with pytest.raises(Halted, match="the rest would take about"):
        patience(1e-9)


def test_times_are_differences_of_a_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of one that shows a million s, and a microsecond more at each reading: nothing that is timed takes a second."""
    readings = count(1_000_000_000_000)
    for name in ("thread_time", "process_time"):
        monkeypatch.setattr(time, name, lambda: next(readings) * 1e-6)
    scene = pp.Scene(duration=0.1, model=pp.Chain(rods=[ROD]), effects=[Gravity()], solver=pp.Solver(samples=3))
    runs = [pp.simulate(scene, method=method, **setting) for method, setting in METHODS.items()]
    runs.append(pp.simulate_many(scene, np.full((4, 2), 0.3), np.zeros((4, 2))))
    times = [x for run in runs for x in (run.stats.seconds, run.stats.seconds + run.stats.compile_seconds)]
    points = [point for curve in pp.cost(scene, methods=["dop853"]).curves for point in curve.points]
    assert points
    times += [x for point in points for x in (point.seconds, point.seconds + point.compile_seconds)]
    case = replace(CASES["thin-pole"], measure=lambda solve, full: 0.0)
    times.append(run_case(case, next(iter(case.methods)), full=False).seconds)
    assert min(times) > 0
    assert max(times) < 1


def test_an_ample_limit_changes_nothing() -> None:
    """The same numbers with and without, one rod and compiled equations."""
    for scene in (swing(duration=1.0), swing(duration=1.0, solver=pp.Solver(engine="compiled"))):
        assert pp.simulate(scene, limit=1e6) == pp.simulate(scene)


def test_runs_are_compared_by_what_they_hold(tmp_path: Any) -> None:
    """A run equals itself, its copy from a file and a second run; not one of another scene; equal ones hash alike."""
    one = pp.simulate(swing(duration=1.0), energy_balance=True)
    again = pp.simulate(swing(duration=1.0), energy_balance=True)
    loaded = pp.Trajectory.load(one.save(tmp_path / "run.npz"))
    assert one == one
    assert one == again == loaded
    assert len({one, again, loaded}) == 1
    other = pp.simulate(swing(duration=1.0, start=pp.Start(positions=(0.7, np.nextafter(0.4, 1)))))
    assert one != other
    assert one != pp.simulate(swing(duration=1.0))  # without works
    assert one != "a run"
    assert one in [other, again]


# --- where a run stopped --------------------------------------------------------------------------------------------

BLOWS_UP = 0.5  # s


def growing(samples: int | None) -> pp.Scene:
    """A rod that a torque drives by its rate cubed: v = 1 / sqrt(1 - 2 t) has no value at BLOWS_UP."""
    inertia = ROD.properties.I1 + ROD.properties.m * ROD.properties.h**2
    torque = pp.effects.Torque(lambda t, q, v: np.clip(inertia * v**3, -1e200, 1e200), joints=["theta"])
    start, solver = pp.Start(velocities=(1.0, 0.0)), pp.Solver(samples=samples)
    return swing(duration=4.0, start=start, effects=(torque,), solver=solver)


@pytest.mark.parametrize("method", ["rk23", "lsoda", "radau", "bdf"])
@pytest.mark.parametrize("samples", [2, *(pytest.param(n, marks=pytest.mark.slow) for n in (3, None))])
def test_a_failure_names_its_own_time_and_rate(method: str, samples: int | None) -> None:
    """However few the samples: not the last of them is named, but where the steps became too short."""
    with pytest.raises(
        pp.RunError, match=r"the run ended at t = \S+ s of 4 s: .*; fastest there: theta, at "
    ) as caught:
        pp.simulate(growing(samples), method=method, tolerance=1e-8)
    words = str(caught.value).split()
    t, rate = float(words[words.index("=") + 1]), float(words[-2])
    assert t == pytest.approx(BLOWS_UP, abs=1e-3)
    assert rate > 100.0
    assert caught.value.partial.t[-1] <= t


def test_a_run_that_stalls_keeps_its_samples_and_names_the_place(clock: Clock, monkeypatch: pytest.MonkeyPatch) -> None:
    """Patience that ends inside a segment: the samples before that are integrated again, and the place is named."""
    stalls = 3.2
    monkeypatch.setattr(clock, "process_time", lambda: clock.now)
    monkeypatch.setattr(
        limits, "LONGEST", 4 * limits.WINDOW
    )  # s: 3 s of the run in a window are fast enough, 0.1 s are not

    def tick(t: float) -> None:
        clock.now += 0.6 * limits.WINDOW * (t > stalls)

    scene = swing(duration=10.0, solver=pp.Solver(engine="pinocchio", method="rk23", tolerance=1e-10))
    with pytest.raises(Halted, match="it advanced") as caught:
        pp.simulate(scene, progress=tick)
    whole = pp.simulate(scene).q
    words, partial = str(caught.value).split(), caught.value.partial
    assert float(words[words.index("=") + 1]) == pytest.approx(stalls, abs=0.5)
    assert stalls - 0.5 < partial.t[-1] < 10.0
    np.testing.assert_allclose(partial.q, whole[: len(partial.t)], rtol=0, atol=1e-6)


@pytest.mark.parametrize(("days", "refused"), [(0.9, False), (1.1, True), (30.0, True)])
def test_the_longest_rest_of_a_run_is_a_day(days: float, refused: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """86,400 s of processor at the pace of the last window, on a clock of the test; the days in the message are those."""
    now = 0.0
    monkeypatch.setattr(limits.time, "process_time", lambda: now)
    took = 2 * limits.WINDOW
    patience = limits.Patience(days * 86_400 / took + 1.0, limits.Deadline(None), lambda t: 0.0, lambda t: None)
    patience(0.0)
    now = took
    if not refused:
        patience(1.0)
        return
    with pytest.raises(limits.Stalled, match=re.escape(f"the rest would take about {days:.0e} days")):
        patience(1.0)
