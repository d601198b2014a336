"""Sensitivities against differences of runs: of states, of what follows from them, of extremes, through events."""

from functools import cache

import numpy as np
import pytest

import pendpin as pp
from effect_cases import EFFECTS
from pendpin import effects as fx
from pendpin.integrators import adaptive
from pendpin.motions.variations import list_state_keys
from test_near_motions import ROD, G, scene

SIXTH = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}  # weights of a central difference of sixth order


def by_differences(chosen: pp.Scene, key: str, value: float, name: str) -> np.ndarray:
    """The derivative of a quantity (n,) by a number: a difference of sixth order, off by (2e-3)^6 and 1e-13 / 2e-3."""
    step = 2e-3 * max(1.0, abs(value))

    def at(k: int) -> np.ndarray:
        return pp.simulate(chosen.replace({key: value + k * step}), tolerance=3e-14)[name]

    return sum(w * (at(k) - at(-k)) for k, w in SIXTH.items()) / step


@pytest.mark.parametrize("name", ["theta_2", "phi_1", "R3_1", "tip_x", "kinetic"])
def test_sensitivities_are_those_of_differences(name: str) -> None:
    """Of positions, and of what follows from the state: by a length, a start and an effect's number."""
    chosen = scene(EFFECTS["drag"], EFFECTS["viscous"], tolerance=1e-12)
    values = {
        "model.rods[0].length": 1.0,
        "start.positions[1]": 0.3,
        "effects[2].coefficient": 0.3,
        "effects[0].acceleration": 9.81,
    }
    run = pp.simulate(chosen)
    found = run.sensitivity(list(values), of=name)
    assert found.shape == (21, 4)
    for k, (key, value) in enumerate(values.items()):
        expected = by_differences(chosen, key, value, name)
        assert np.abs(found[:, k] - expected).max() <= 3e-9 * max(1.0, np.abs(expected).max())


@pytest.mark.parametrize("name", ["theta_2", "R3_1", "R3_1.max"])
def test_sensitivities_to_the_time_of_the_start(name: str) -> None:
    """A reaction at a time since the start changes with the effects then, and with the state."""
    chosen = scene(EFFECTS["support"], duration=0.7, tolerance=1e-12).replace({"start.time": 0.4})
    found = pp.simulate(chosen).sensitivity("start.time", of=name)

    def at(k: int) -> np.ndarray | float:
        moved = pp.simulate(chosen.replace({"start.time": 0.4 + k * 1e-3}), tolerance=3e-14)
        return moved[name] if name in moved.names else moved.maximum("R3_1").value

    expected = np.atleast_1d(sum(w * (at(k) - at(-k)) for k, w in SIXTH.items()) / 1e-3)
    assert np.abs(found.ravel() - expected).max() <= 1e-7 * np.abs(expected).max()


def test_transitions_compose() -> None:
    """From 0 to 2 s is from 1 to 2 s after 0 to 1 s, and its columns are the sensitivities to the start."""
    run = pp.simulate(scene(EFFECTS["support"], tolerance=1e-12))
    whole, first, second = (run.state_transition(*ends) for ends in ((0.0, 2.0), (0.0, 0.97), (0.97, 2.0)))
    size = np.abs(first).max() * np.abs(second).max()
    assert np.abs(second @ first - whole).max() <= 1e-9 * size
    keys = list_state_keys(4)
    assert np.abs(run.sensitivity(keys)[-1] - whole).max() <= 1e-9 * size
    assert (run.state_transition(1.0, 1.0) == np.eye(8)).all()


def test_changes_are_integrated_by_scipy_where_cyrk_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same method with the same tolerance, in steps of its own: the same changes within that."""
    run = pp.simulate(scene(tolerance=1e-11))
    by_cyrk = run.state_transition(0.0, 2.0), run.sensitivity("model.rods[0].mass")
    monkeypatch.setattr(adaptive, "cyrk", lambda: None)
    by_scipy = run.state_transition(0.0, 2.0), run.sensitivity("model.rods[0].mass")
    assert all(np.abs(x - y).max() <= 1e-9 * np.abs(x).max() for x, y in zip(by_cyrk, by_scipy, strict=True))


def test_final_and_mean_are_those_of_the_samples() -> None:
    """The final value changes as at the last sample, the mean as the mean of the changes."""
    run = pp.simulate(scene(tolerance=1e-11))
    series = run.sensitivity("model.rods[0].mass", of="R3_1")[:, 0]
    mean, final = (run.sensitivity("model.rods[0].mass", of=f"R3_1.{s}")[0] for s in ("mean", "final"))
    assert final == series[-1]
    assert mean == pytest.approx(np.trapezoid(series, run.t) / 2.0, rel=1e-12)
    alone = pp.simulate(scene(duration=0.0, samples=1))  # the mean of a start alone is its value
    assert alone.sensitivity("model.rods[0].mass", of="R3_1.mean")[0] == pytest.approx(series[0], rel=1e-9)


PLANE = pp.Scene(  # examples/double_pendulum.toml
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.02), pp.Rod(length=0.7, mass=0.6, radius=0.02)]),
    start=pp.Start(positions=(2.2, 0.0, 0.5, 0.0)),
    effects=[G],
    duration=2.0,
)
SPACE = scene(EFFECTS["drag"], EFFECTS["viscous"])
RUBBED = scene(fx.DryFriction(kinetic=0.4), fx.Viscous(coefficient=0.1), q=(1.2, 0.0, -0.9, 0.0), duration=3.0)


EXTREMES = [
    (PLANE, "R3_1.max"),
    (PLANE, "theta_2.min"),
    (PLANE, "tip_z.max"),  # at the start
    (SPACE, "R3_1.max"),
    (SPACE, "R1_2.min"),
    (SPACE, "tip_x.max"),
    (SPACE, "phi_2_rate.max"),
    (SPACE.replace(duration=0.1), "kinetic.max"),  # at the end
    (RUBBED, "theta_2.max"),
    (RUBBED, "theta_1.min"),  # where the joint turns back
]


@cache
def differences(place: int) -> dict[str, float]:
    """The change of an extreme by a length and by a start, by differences of run.maximum."""
    chosen, name = EXTREMES[place]
    quantity, _, statistic = name.partition(".")

    def at(key: str, value: float) -> float:
        run = pp.simulate(chosen.replace({key: value}), tolerance=1e-13)
        return (run.maximum if statistic == "max" else run.minimum)(quantity).value

    h = 1e-4
    return {
        key: (8 * (at(key, x + h) - at(key, x - h)) - at(key, x + 2 * h) + at(key, x - 2 * h)) / (12 * h)
        for key, x in (("model.rods[0].length", 1.0), ("start.positions[0]", chosen.start.positions[0]))
    }


@pytest.mark.parametrize("samples", [12, pytest.param(121, marks=pytest.mark.slow)])
@pytest.mark.parametrize("place", range(len(EXTREMES)), ids=[name for _, name in EXTREMES])
def test_extremes_change_as_those_between_the_samples(place: int, samples: int) -> None:
    """run.sensitivity and differences of run.maximum: the same, however few samples there are."""
    chosen, name = EXTREMES[place]
    right = differences(place)
    found = pp.simulate(chosen, samples=samples, tolerance=1e-11).sensitivity(list(right), of=name)
    right = list(right.values())
    assert found == pytest.approx(right, rel=1e-6, abs=1e-7 * np.abs(right).max() + 1e-9)


def test_a_force_is_linear_in_gravity_at_rest() -> None:
    """A rod that hangs still: R3 = m g, so dR3/dg = m and dR3/dm = g, exactly."""
    chosen = scene(q=(0.0, 0.0), model=pp.Chain(rods=[ROD]))
    found = pp.simulate(chosen).sensitivity(["effects[0].acceleration", "model.rods[0].mass"], of="R3")
    np.testing.assert_allclose(found, np.tile([1.0, 9.81], (21, 1)), rtol=1e-11)


@pytest.mark.parametrize("effect", [
    fx.DryFriction(kinetic=0.4),
    fx.DryFriction(kinetic=0.4, static=0.9),  # a joint that comes loose jumps
    fx.DryFriction(kinetic=0.2, static=0.7, stribeck=0.5),
], ids=["equal", "static", "falling"])  # fmt: skip
def test_derivatives_pass_sticking_and_slipping(effect: fx.DryFriction) -> None:
    """By a length, starts and the numbers of the friction: those of differences of runs that meet the same events.

    A joint that is held forgets its rate; one that comes loose remembers by how much it came loose later.
    """
    chosen = scene(
        effect, fx.Viscous(coefficient=0.1), q=(1.2, 0.0, -0.9, 0.0), duration=3.0, samples=31, tolerance=1e-12
    )
    run = pp.simulate(chosen)
    assert {event.kind for event in run.events} >= {"stick", "slip"}
    values = {"model.rods[0].length": 1.0, "start.positions[0]": 1.2, "effects[1].kinetic": effect.kinetic}
    if effect.static is not None:
        values["effects[1].static"] = effect.static
    rows = run.sensitivity(list(values), of="theta_2")
    for key, row in zip(values, rows.T, strict=True):
        late, early = (pp.simulate(chosen.replace({key: values[key] + h}), tolerance=3e-14) for h in (1e-5, -1e-5))
        right = (late["theta_2"] - early["theta_2"]) / 2e-5  # off by its square, and by 1e-13 / 1e-5
        assert np.abs(row - right).max() < 1e-6 * np.abs(right).max(), key


def test_a_friction_of_0_turns_with_the_motion() -> None:
    """The derivative by a friction that is 0 is that of runs with a little of it, which reverses with every joint."""
    key = "effects[1].kinetic"
    chosen = scene(fx.DryFriction(kinetic=0.0), q=(1.2, 0.0, -0.9, 0.0), duration=3.0, samples=31, tolerance=1e-12)
    none, some, twice = (pp.simulate(chosen.replace({key: x}), tolerance=3e-14)["theta_2"] for x in (0.0, 1e-4, 2e-4))
    right = (4 * some - twice - 3 * none) / 2e-4
    run = pp.simulate(chosen)
    assert all((np.diff(np.sign(run.v[:, joint])) != 0).sum() > 2 for joint in (0, 2))
    assert np.abs(run.sensitivity(key, of="theta_2")[:, 0] - right).max() < 1e-4 * np.abs(right).max()
