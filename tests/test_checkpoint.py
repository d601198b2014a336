"""A killed run continues from its file and ends like the uninterrupted one, bit for bit."""

import os
import sys
from dataclasses import fields, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pendpin as pp
from pendpin import effects as fx
from pendpin.errors import Interrupted
from pendpin.runs import checkpoint, integration
from pendpin.runs.checkpoint import RunState
from pendpin.runs.integration import IntegrationLoop, SmoothLoop
from pendpin.runs.motion_with_events import LoopWithEvents
from scenes import scene_of

THICK = (pp.Rod(length=1.0, mass=1.0, radius=0.05), pp.Rod(length=0.7, mass=0.5, radius=0.03))
THIN = (pp.Rod(length=1.0, mass=1.0), pp.Rod(length=0.7, mass=0.5))
CONTACTS = (fx.DryFriction(kinetic=0.05, static=0.07), fx.Stop(lower=-0.8, upper=0.9, restitution=0.6))
needs_heyoka = pytest.mark.skipif(find_spec("heyoka") is None, reason="heyoka is not installed: pip install heyoka")

Setting = dict[str, Any]
METHODS: dict[str, tuple[pp.Scene, Setting]] = {}


def scene(rods=THICK, *effects: fx.Effect, duration=4.0, samples=61, engine="auto") -> pp.Scene:
    """Two rods under gravity and these effects."""
    given = {"q": (0.7, 0.4, -0.3, 0.2), "v": (1.3, -0.8, 0.2, 0.5), "samples": samples, "engine": engine}
    return scene_of(rods, fx.Gravity(), *effects, duration=duration, **given)


METHODS |= {m: (scene(), {"method": m, "tolerance": 1e-9}) for m in ("dop853", "rk45", "rk23", "radau", "bdf", "lsoda")}
METHODS |= {m: (scene(duration=2.0), {"method": m, "step": 0.01}) for m in ("rk4", "gauss2", "gauss4", "gauss6")}
METHODS |= {
    "euler": (scene(), {"method": "euler", "step": 0.002}),
    "taylor": (scene(duration=9.0), {"method": "taylor", "tolerance": 1e-18}),
    "taylor in directions": (scene(THIN, duration=12.0), {"method": "taylor", "tolerance": 1e-15}),
    "energy_balance": (scene(THICK, fx.Viscous(coefficient=0.1)), {"tolerance": 1e-9, "energy_balance": True}),
    "energy_balance of gauss6": (
        scene(THICK, fx.Viscous(coefficient=0.1), duration=2.0),
        {"method": "gauss6", "step": 0.02, "energy_balance": True},
    ),
    "driven": (scene(THICK, fx.Support(amplitude=(0.1, 0.0, 0.2), frequency=7.0)), {"tolerance": 1e-9}),
    "chain engine": (scene(engine="chain", duration=1.0), {"tolerance": 1e-7}),
    "spherical joints": (scene(THIN), {"tolerance": 1e-10}),
    "between samples": (scene(THIN, duration=9.0, samples=3), {"tolerance": 1e-8}),
    "directions": (scene(THIN, engine="chain", duration=1.0), {"tolerance": 1e-8}),
    "contacts": (scene(THICK, *CONTACTS), {"tolerance": 1e-8}),
    "contacts and energy_balance": (
        scene(THICK, *CONTACTS, fx.Viscous(coefficient=0.02)),
        {"tolerance": 1e-8, "energy_balance": True},
    ),
}
CASES = [
    pytest.param(*integrator, id=n, marks=[needs_heyoka] if "taylor" in n else []) for n, integrator in METHODS.items()
]


class Killed(BaseException):
    """Stands in for kill -9: nothing handles it."""


@pytest.fixture(autouse=True)
def short_segments(monkeypatch: pytest.MonkeyPatch) -> None:
    """Segments of a few dozen evaluations, so that short runs have many."""
    monkeypatch.setattr(integration, "EVALUATIONS", 160)
    monkeypatch.setattr(integration, "LEAST_EVALUATIONS", 16)
    monkeypatch.setattr(integration, "NUMBERS", 600)


def killing(loop: type[IntegrationLoop], after: int) -> Any:
    """A loop's `go_on` that is killed in its segment of this number, with the work done and nothing returned."""
    go_on, count = loop.go_on, 0

    def killed(self: IntegrationLoop, done: RunState) -> Any:
        nonlocal count
        result, count = go_on(self, done), count + 1
        if count == after:
            raise Killed
        return result

    return killed


def broken(given: pp.Scene, setting: Setting, path: Path) -> tuple[pp.Trajectory, int]:
    """A run that is killed in its second segment, twice, then in the third from where it is, and so on; and how often."""
    for kills in range(1000):
        with pytest.MonkeyPatch.context() as patch:
            for loop in (SmoothLoop, LoopWithEvents):
                patch.setattr(loop, "go_on", killing(loop, 2 + kills // 2))
            try:
                return pp.simulate(given, **setting, checkpoint=path, every=0), kills
            except Killed:
                assert path.exists()
    raise AssertionError("it never ends")


def assert_same(one: pp.Trajectory, other: pp.Trajectory) -> None:
    """Everything but the time that it took."""
    for field in fields(pp.Trajectory):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if isinstance(a, np.ndarray):
            assert np.array_equal(a, b), field.name
        elif field.name in {"rods", "work"}:
            assert all(map(np.array_equal, *(x.values() if isinstance(x, dict) else x for x in (a, b)))), field.name
    unclocked = [replace(run.stats, seconds=0.0, compile_seconds=0.0) for run in (one, other)]
    assert unclocked[0] == unclocked[1]
    assert (one.joints, one.scene, one.work.keys()) == (other.joints, other.scene, other.work.keys())
    assert one.events == other.events


@pytest.mark.parametrize(("given", "setting"), CASES)
def test_a_broken_run_is_the_unbroken_one(given: pp.Scene, setting: Setting, tmp_path: Path) -> None:
    """Every integrator, killed again and again at different places: all arrays and all counts."""
    run, kills = broken(given, setting, tmp_path / "run.ckpt")
    assert kills >= 3
    assert_same(run, pp.simulate(given, **setting))


@pytest.mark.parametrize("library", ["CyRK", "scipy"])
def test_a_segment_may_be_shorter_than_a_step(library: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The step that is proposed for it fits into it, which both libraries insist on."""
    if library == "scipy":
        monkeypatch.setitem(sys.modules, "CyRK", None)
    monkeypatch.setattr(integration, "EVALUATIONS", 1)
    monkeypatch.setattr(integration, "LEAST_EVALUATIONS", 1)
    assert len(pp.simulate(scene(samples=401, duration=1.0), tolerance=1e-3).t) == 401


def test_an_interrupt_says_how_to_go_on(tmp_path: Path) -> None:
    """Ctrl-C in the middle of a segment: the message says so, and nothing is computed twice."""
    given, path, seen = scene(samples=None, duration=20.0), tmp_path / "run.ckpt", []

    def progress(t: float) -> None:
        seen.append(t)
        if t > 10:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted, match=rf"stopped by the user; {path} holds") as caught:
        pp.simulate(given, progress=progress, checkpoint=path, every=np.inf)
    partial = caught.value.partial
    seen.clear()
    run = pp.simulate(given, progress=seen.append, checkpoint=path)
    assert_same(run, pp.simulate(given))
    assert np.array_equal(run.q[: len(partial.q)], partial.q)
    assert 5 < partial.t[-1] <= min(seen)
    assert run.stats.seconds > partial.stats.seconds


def test_a_finished_run_is_read_again(tmp_path: Path) -> None:
    """The file stays: the same call gives the same result without integrating."""
    path, seen = tmp_path / "run.ckpt", []
    run = pp.simulate(scene(), checkpoint=path)
    assert_same(pp.simulate(scene(), checkpoint=path, progress=seen.append), run)
    assert not seen


def test_a_limit_is_no_end(tmp_path: Path) -> None:
    """A run that takes too long is halted, as often as it likes, and goes on."""
    given, path = scene(samples=None, duration=60.0, engine="pinocchio"), tmp_path / "run.ckpt"  # nothing to compile
    says = f"it takes over 0 s, compiling included; fastest there: .*; {path} holds .*$"
    for _ in range(3):
        with pytest.raises(pp.RunError, match=says):
            pp.simulate(given, checkpoint=path, limit=0)
    unbroken = pp.simulate(given, checkpoint=tmp_path / "other.ckpt")
    assert_same(pp.simulate(given, checkpoint=path), unbroken)


def test_a_full_disk_ends_a_run_with_what_is_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was saved before the disk was full is whole, and is gone on from when there is room."""
    path, write, saves = tmp_path / "run.ckpt", checkpoint.write_whole, []

    def full(target: Path, content: Any) -> Path:
        saves.append(target)
        if len(saves) > 3:
            raise pp.InputError(f"{target}: cannot be written: No space left on device")
        return write(target, content)

    monkeypatch.setattr(checkpoint, "write_whole", full)
    with pytest.raises(pp.RunError, match=r"No space left on device; .* holds the run so far") as caught:
        pp.simulate(scene(), checkpoint=path, every=0)
    assert len(caught.value.partial.t) > 1
    monkeypatch.undo()
    assert os.listdir(tmp_path) == ["run.ckpt"]


def test_a_run_that_fails_does_not_offer_to_go_on(tmp_path: Path) -> None:
    """Going on would lead to the same place."""
    with pytest.raises(pp.RunError, match="the energy is off by over a tenth") as caught:
        pp.simulate(scene(duration=40.0), method="rk4", step=0.2, checkpoint=tmp_path / "run.ckpt")
    assert "holds the run so far" not in str(caught.value)
