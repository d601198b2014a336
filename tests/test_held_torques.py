"""Sampled torques: a function is evaluated at its instants, and its output is held until the next one."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pendpin as pp
from pendpin import effects as fx
from pendpin.errors import Interrupted

EVERY, INSTANTS, DURATION = 0.05, 5, 0.2
ROD = pp.Rod(length=1.0, mass=1.0, radius=0.05)
START = pp.Start(positions=(0.7, 0.4, -0.3, 0.2), velocities=(1.3, -0.8, 0.2, 0.5), time=2.0)
CONTACTS = (fx.DryFriction(kinetic=0.3, static=0.5), fx.Stop(lower=-0.6, upper=0.75, joints=("theta_1",)))
METHODS: dict[str, tuple[dict[str, Any], float]] = {  # settings; what errors of the two runs may add up to
    "dop853": ({"tolerance": 1e-10}, 1e-7),
    "lsoda": ({"tolerance": 1e-10}, 1e-6),
    "radau": ({"tolerance": 1e-9}, 1e-6),
    "gauss4": ({"step": 0.005}, 1e-12),  # the same steps: rounding
    "rk4": ({"step": 0.005}, 1e-12),
}


def law(t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """A controller whose output depends on everything that it is given."""
    return -2.0 * v - 30.0 * q + np.sin(3 * t)


CALLS: list[float] = []  # not in the function: a run knows a function again by what it holds


def noted(t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The same; when it is called is noted."""
    CALLS.append(t)
    return law(t, q, v)


def scene_of(*more: fx.Effect, function: Any = law, every: float = EVERY) -> pp.Scene:
    """Two rods, the second one's phi driven by a sampled torque."""
    effects = (fx.Gravity(), fx.Torque(function, joints=["phi_2"], every=every), *more)
    return pp.Scene(model=pp.Chain(rods=(ROD, ROD)), start=START, effects=effects, duration=DURATION)


def run_of(*more: fx.Effect, **settings: Any) -> pp.Trajectory:
    """Five samples from instant to instant."""
    return pp.simulate(scene_of(*more), samples=21, **settings)


@pytest.mark.parametrize("method", [*METHODS, "dop853 with contacts", "lsoda with contacts"])
def test_a_sampled_torque_is_a_row_of_constant_torques(method: str) -> None:
    """Its output is the function at the instants, to the bit; from instant to instant the run is that under a constant."""
    method, *contacts = method.split()
    (settings, bound), more = METHODS[method], CONTACTS if contacts else ()
    run = run_of(*more, method=method, energy_balance=True, **settings)
    at = np.arange(INSTANTS) * 5
    expected = [law(2.0 + EVERY * i, run.q[k, 3:], run.v[k, 3:]) for i, k in enumerate(at)]  # 2.0: the start's time
    assert np.array_equal(run.held[0], expected)
    assert np.array_equal(run.efforts()["torque"][at, 3:], expected)
    assert run.imbalance < 1e-6  # gauss4 and rk4 with these steps: 1e-8
    for i, k in enumerate(at[:-1]):
        start = pp.Start(positions=tuple(run.q[k]), velocities=tuple(run.v[k]))
        motor = fx.Motor(joint="phi_2", torque=float(expected[i][0]))
        piece = pp.Scene(model=run.source.model, start=start, effects=(fx.Gravity(), motor, *more), duration=EVERY)
        one = pp.simulate(piece.replace({"solver.engine": "pinocchio"}), samples=6, method=method, **settings)
        assert np.abs(one.q - run.q[k : k + 6]).max() < bound
        assert np.abs(one.v - run.v[k : k + 6])[:-1].max() < bound
        assert np.abs(one.a - run.a[k : k + 6])[:-1].max() < 100 * bound  # of angular accelerations up to 100 rad/s²


def test_what_is_asked_of_a_run_later_has_its_outputs(tmp_path: Path) -> None:
    """extend, at, crossings and a saved run take the recorded outputs: the function is not called for them again."""
    settings: dict[str, Any] = {"method": "dop853", "tolerance": 1e-10}
    whole = run_of(**settings)
    half = pp.simulate(scene_of(), duration=DURATION / 2, samples=11, **settings)
    assert np.abs(half.extend(DURATION / 2).q - whole.q).max() < 1e-8
    assert np.array_equal(half.extend(DURATION / 2).held[0][:3], half.held[0])
    loaded = pp.Trajectory.load(whole.save(tmp_path / "run.npz"), scene=scene_of())
    assert loaded == whole
    between = whole.t[3] + 0.004
    assert np.array_equal(loaded.at(between).q, whole.at(between).q)
    crossed = loaded.crossings("phi_2", float(whole["phi_2"][7:9].mean()))
    assert len(crossed.t) >= 1
    dense = pp.simulate(scene_of(), times=[2.0, float(crossed.t[0]), 2.0 + DURATION], **settings)
    assert np.abs(dense.q[1] - crossed.q[0]).max() < 1e-8


def test_a_stopped_run_goes_on_with_what_is_held(tmp_path: Path) -> None:
    """With a checkpoint, bit for bit; the function is called at no other time than the instants still to come."""

    def stop(t: float) -> None:
        if t > 0.12:
            raise KeyboardInterrupt

    CALLS.clear()
    scene = scene_of(CONTACTS[0], function=noted)
    settings: dict[str, Any] = {"method": "dop853", "tolerance": 1e-9, "samples": 200}
    whole = pp.simulate(scene, **settings)
    assert sorted(set(CALLS)) == [2.0 + EVERY * i for i in range(INSTANTS)]
    path = tmp_path / "state.npz"
    with pytest.raises(Interrupted):
        pp.simulate(scene, checkpoint=path, every=0.0, progress=stop, **settings)
    CALLS.clear()
    again = pp.simulate(scene, checkpoint=path, **settings)
    assert again == whole
    assert 2.0 + EVERY not in CALLS


def test_what_no_sampled_torque_can_be() -> None:
    """Refused in one line."""
    with pytest.raises(pp.InputError, match="every and shortest do not go together"):
        fx.Torque(law, every=0.1, shortest=0.1)
    with pytest.raises(pp.InputError, match=r"every = 1e-12 s makes over 5,000,000 instants in 0\.2 s"):
        pp.simulate(scene_of(every=1e-12))
