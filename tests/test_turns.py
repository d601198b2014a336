"""Thin rods are carried in directions; their angles count every turn, however few samples show it."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.engines import AngleEngine
from pendpin.equations.chain.thin import refined
from pendpin.runs import integration

METHODS: tuple[dict[str, Any], ...] = (
    {"tolerance": 1e-11},
    {"method": "radau", "tolerance": 1e-8},
    {"method": "lsoda", "tolerance": 1e-10},
    {"method": "rk4", "step": 2e-4},
    {"method": "taylor", "tolerance": 1e-15},
)


def thin(count: int) -> pp.Chain:
    """Rods of no radius, of 1 m and 1 kg."""
    return pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0),), copies=count)


@law(15)
@given(st.floats(-300, 300), st.booleans(), st.sampled_from([2, 3, 7, None]), st.sampled_from(METHODS))
def test_a_free_rod_turns_as_fast_as_it_does(rate: float, about_phi: bool, samples: int | None, how: Any) -> None:
    """Nothing acts: the angle is the rate times the time, over hundreds of radians between samples."""
    axis = int(about_phi)
    velocities = np.eye(2)[axis] * rate
    scene = pp.Scene(
        duration=0.6, model=thin(1), start=pp.Start(velocities=tuple(velocities)), solver=pp.Solver(samples=samples)
    )
    run = pp.simulate(scene, **how)
    assert np.abs(run.q - np.outer(run.t, velocities)).max() < 1e-3 * (1 + abs(rate))


@law(10)
@given(st.integers(1, 3), st.integers(0, 2**32 - 1), st.sampled_from([1.0, 5.0, 30.0]))
def test_angles_do_not_depend_on_the_samples(count: int, seed: int, fast: float) -> None:
    """Any chain of thin rods, thrown at will, through poles and near them: 2 samples or 61, the last angles are the same."""
    random = np.random.default_rng(seed)
    q, v = random.uniform(-3, 3, 2 * count), random.normal(0, fast, 2 * count)
    start = pp.Start(positions=tuple(q.tolist()), velocities=tuple(v.tolist()))
    ends = []
    for samples in (2, 5, 61):
        solver = pp.Solver(samples=samples, tolerance=1e-12)
        run = pp.simulate(
            pp.Scene(duration=0.3, model=thin(count), start=start, effects=(fx.Gravity(),), solver=solver)
        )
        ends.append(run.q[-1])
    near = np.abs(np.cos(ends[-1][1::2])).min()  # theta is as uncertain as this is small
    assert np.abs(ends[0] - ends[-1]).max() * near < 1e-5
    assert np.abs(ends[1] - ends[-1]).max() * near < 1e-5


@law(8)
@given(st.integers(1, 2), st.floats(0.2, 1.0), st.floats(5, 60), st.sampled_from([2, 31]))
def test_directions_and_angles_count_alike(count: int, tilt: float, rate: float, samples: int) -> None:
    """A chain that whirls about x, off the poles: integrated in its angles, and read from its directions."""
    start = pp.Start(
        positions=(0.3, tilt) + (0.1, 0.2) * (count - 1), velocities=(rate, 0.0) + (1.0, 0.0) * (count - 1)
    )
    runs = []
    for effects in ((), (fx.Viscous(coefficient=1e-30),)):
        scene = pp.Scene(
            duration=0.4, model=thin(count), start=start, effects=effects, solver=pp.Solver(samples=samples)
        )
        runs.append(pp.simulate(scene, tolerance=1e-13))
        assert isinstance(pp.bind(scene).engine, AngleEngine) == bool(effects)
    if np.abs(np.cos(runs[1].q[:, 1::2])).min() > 0.05:
        assert np.abs(runs[0].q - runs[1].q).max() < 1e-5


@pytest.mark.parametrize("how", METHODS, ids=lambda how: how.get("method", "auto"))
def test_segments_may_end_between_samples(how: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Two thin rods over poles, with 2 and with 41 samples: in segments of 50 states as in one."""
    start = pp.Start(positions=(0.4, 1.2, -0.3, 0.2), velocities=(9.0, 3.0, -4.0, 12.0))
    ends = []
    for numbers, samples in (
        (integration.NUMBERS, 41),
        (integration.NUMBERS, 2),
        (600, 2),
        (600, 41),
    ):
        monkeypatch.setattr(integration, "NUMBERS", numbers)
        scene = pp.Scene(duration=1.0, model=thin(2), start=start, effects=(fx.Gravity(),))
        run = pp.simulate(scene, samples=samples, **how)
        assert run.t.tolist() == np.linspace(0, 1, samples).tolist()
        ends.append(run.q[-1])
    assert np.ptp(ends, 0).max() < 1e-4


def test_turns_are_counted_however_many_there_are() -> None:
    """Four hundred thousand radians between two samples: more states than one segment holds."""
    pytest.importorskip("heyoka")
    scene = pp.Scene(duration=1400.0, model=thin(1), start=pp.Start(velocities=(300.0, 0.0)))
    run = pp.simulate(scene, samples=2, method="taylor", tolerance=1e-15)
    assert run.q[-1] == pytest.approx([420_000.0, 0.0], abs=1e-4)


@pytest.mark.parametrize("how", [METHODS[0], METHODS[-1]], ids=["auto", "taylor"])
def test_too_many_turns_to_count_are_refused(how: dict[str, Any]) -> None:
    """At once, and not after as many steps; NaN and inf never come out."""
    scene = pp.Scene(duration=10.0, model=thin(1), start=pp.Start(velocities=(1e12, 0.0)))
    with pytest.raises(pp.PendpinError, match=r"t = 0 s of 10 s: .* take more samples"):
        pp.simulate(scene, samples=2, **how)


def test_ensembles_count_turns() -> None:
    """Side by side as well, with no more than the first and the last sample."""
    pytest.importorskip("heyoka")
    scene = pp.Scene(duration=1.0, model=thin(1), solver=pp.Solver(samples=2))
    rates = np.array([[250.0, 0.0], [0.0, -120.0], [3.0, 0.0]])
    many = pp.simulate_many(scene, np.zeros((3, 2)), rates, workers=1)
    assert many.stats.method == "taylor"
    assert np.abs(many.q[:, -1] - rates).max() < 1e-6


def test_directions_between_samples_are_of_fourth_order() -> None:
    """A turn on a small circle, whose direction and rate are known at any time."""

    def turning(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        d = np.stack([0.6 * np.cos(t), 0.6 * np.sin(t), np.full_like(t, 0.8)], -1)[:, None]
        return d, np.cross([0.0, 0.0, 1.0], d)

    errors = []
    for h in (0.2, 0.1):
        t = np.array([0.3, 0.3 + h])
        times, d, rate, kept = refined(t, *turning(t), np.arange(2), np.array([True]))
        assert times[kept].tolist() == t.tolist()
        right, right_rate = turning(times)
        errors.append((np.abs(d - right).max(), np.abs(rate - right_rate).max()))
    assert np.log2(np.divide(*errors)) == pytest.approx([4, 3], abs=0.3)
