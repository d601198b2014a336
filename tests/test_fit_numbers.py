"""Fits: free numbers and their coordinates, and swings as they are read and cut."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import pendpin as pp
from fit_scenes import ANGLE, ANGLES, ROD, scene_of
from pendpin.effects import Drag, DryFriction, Viscous
from pendpin.errors import RunError
from pendpin.fitting.data import (
    FEWEST,
    MOST_SAMPLES,
    Swing,
    batch,
    cut_pieces,
    read_swings,
    sensors_of,
    spread_of,
    thin_out,
)
from pendpin.fitting.parameters import combinations, free_parameters, substitute
from pendpin.fitting.problem import bind_pendulum
from pendpin.model.build import build
from pendpin.scene import Chain, Data

STRIBECK = DryFriction(kinetic=1e-3, static=1.5e-3, stribeck=5.0)
SCENE = scene_of(2, Viscous(coefficient=1e-4), STRIBECK, Drag(diameter=0.02, linear=0.1))
PHYSICS = [f"model.rods[{i}].{name}" for i in (0, 1) for name in ("com", *(f"inertia[{k}]" for k in range(3)))]
FRICTION = ["effects[1].coefficient", *(f"effects[2].{name}" for name in ("kinetic", "static", "stribeck"))]
DRAG = ["effects[3].coefficient", "effects[3].linear"]


def test_short_forms_stand_for_their_numbers() -> None:
    """Lengths only of rods that carry another; static friction and speed with Stribeck, linear drag if given."""
    assert list(free_parameters(SCENE, "physics").keys) == [*PHYSICS, "model.rods[0].length", *FRICTION, *DRAG]
    assert list(free_parameters(SCENE, "friction").keys) == FRICTION + DRAG
    plain = scene_of(1, DryFriction(kinetic=1e-3), Drag(diameter=0.02))
    assert list(free_parameters(plain, "friction").keys) == ["effects[1].kinetic", "effects[2].coefficient"]
    assert "model.rods[0].length" not in free_parameters(plain, "physics").keys
    many = pp.Scene(**plain.given() | {"model": Chain(rods=[pp.Rod(**ROD)], copies=2)})
    assert "model.rods[0].length" in free_parameters(many, "physics").keys


def test_each_number_is_named_once_in_its_order() -> None:
    """Whatever repeats it, in one text or several."""
    keys = free_parameters(SCENE, ["friction, model.rods[1].com", "effects[1].coefficient", "model.rods[1].com"]).keys
    assert list(keys) == [*FRICTION, *DRAG, "model.rods[1].com"]


def test_the_start_is_the_guess_and_gradients_are_its_slopes() -> None:
    """Central differences at random coordinates; absent numbers are those of a uniform rod."""
    free = free_parameters(SCENE, "physics")
    rod = SCENE.model.rods[0].properties
    assert free.values(free.start) == pytest.approx(free.guess, rel=1e-14)
    assert free.guess[:4] == pytest.approx([rod.h, rod.I1, rod.I2, rod.I3], rel=1e-14)
    assert free.guess[-5:] == pytest.approx([1e-3, 1.5e-3, 5.0, SCENE.effects[3].coefficient, 0.1], rel=1e-14)
    z = free.start + 0.1 * np.random.default_rng(0).random(len(free.start))
    slopes = np.array([(free.values(z + h) - free.values(z - h)) / 2e-5 for h in 1e-5 * np.eye(len(z))]).T
    assert free.gradients(z) == pytest.approx(slopes, abs=1e-8, rel=1e-7)


def test_coordinates_know_what_they_are() -> None:
    """Speeds of Stribeck friction, and what takes energy."""
    free = free_parameters(SCENE, "physics, effects[0].direction[1]")
    rows = {key: np.flatnonzero(free.transform[row]).tolist() for row, key in enumerate(free.keys)}
    assert np.flatnonzero(free.is_stribeck_speed).tolist() == rows["effects[2].stribeck"]
    dissipation = {column for key in FRICTION + DRAG for column in rows[key]}
    assert set(np.flatnonzero(free.dissipation(SCENE)).tolist()) == dissipation
    assert not free_parameters(SCENE, [*PHYSICS, "effects[2].kinetic"]).is_stribeck_speed.any()


@given(st.integers(0, 2**32 - 1))
def test_whatever_the_coordinates_the_scene_is_one(seed: int) -> None:
    """Within their bounds: no negative friction, static above kinetic, a real body, a positive length."""
    free = free_parameters(SCENE, "physics")
    draw = np.random.default_rng(seed)
    lower, upper = np.maximum(free.lower, free.start - 3), np.minimum(free.upper, free.start + 3)
    z = draw.uniform(lower, upper)
    z = np.where(draw.random(len(z)) < 0.2, lower, z)
    values = dict(zip(free.keys, free.values(z).tolist(), strict=True))
    changed = substitute(SCENE, free.keys, free.values(z))
    assert changed.effects[2].static >= changed.effects[2].kinetic >= 0
    assert changed.model.rods[1].inertia == tuple(values[f"model.rods[1].inertia[{k}]"] for k in range(3))
    assert changed.model.rods[0].length == values["model.rods[0].length"] > 0


def test_single_numbers_have_the_bounds_of_their_scene() -> None:
    """An inertia between difference and sum of the others; kinetic below static, static above; a direction has none."""
    rod = pp.Rod(**ROD, inertia=(3e-4, 2e-4, 4e-4))
    scene = pp.Scene(**SCENE.given() | {"model": Chain(rods=[rod])})

    def bounds(key: str) -> list[float]:
        free = free_parameters(scene, key)
        return [*free.values(np.maximum(free.lower, -700)), *free.values(np.minimum(free.upper, 700))]

    assert bounds("model.rods[0].inertia[1]") == pytest.approx([1e-4, 7e-4])
    assert bounds("effects[2].kinetic") == pytest.approx([0, 1.5e-3])
    assert bounds("effects[2].static")[0] == pytest.approx(1e-3)
    assert bounds("effects[1].coefficient") == [0, 700]
    assert bounds("effects[0].direction[1]") == [-700, 700]
    assert bounds("model.rods[0].length")[0] == pytest.approx(0, abs=1e-300)


def test_a_thin_rod_keeps_no_inertia_about_itself() -> None:
    """Its three inertias have one coordinate; a thick one's have three."""
    thin = scene_of(1).replace({"model.rods[0].radius": 0.0})
    free = free_parameters(thin, "model.rods[0].inertia")
    assert free.transform.shape == (3, 1)
    assert free.values(free.start * 2) == pytest.approx(2 * free.guess, rel=1e-12)
    assert free_parameters(scene_of(1), "model.rods[0].inertia").transform.shape == (3, 3)
    for length in np.random.default_rng(0).uniform(0.1, 2, 50).tolist():  # rounding is no inertia either
        rod = pp.Rod(length=length, mass=0.3, inertia=(length / 7, length / 7 * (1 + 1e-15), length / 7 * 1e-15))
        scene = pp.Scene(**thin.given() | {"model": Chain(rods=[rod])})
        assert free_parameters(scene, "model.rods[0].inertia").transform.shape == (3, 1)


@settings(max_examples=5)
@given(st.integers(0, 2**32 - 1))
def test_combinations_are_ratios_of_energies(seed: int) -> None:
    """Of unequal rods: the first moment and the inertia of each with all below it are what lifts and what turns it alone.

    Their slopes are those of their values, along any direction.
    """
    draw = np.random.default_rng(seed)
    rods = [pp.Rod(length=a, mass=b, radius=0.05 * c, com=0.4 * a) for a, b, c in draw.uniform(0.2, 2, (3, 3)).tolist()]
    friction = Viscous(coefficient=float(draw.uniform(0.1, 1)))
    scene = pp.Scene(**SCENE.given() | {"model": Chain(rods=rods), "effects": [SCENE.effects[0], friction]})
    energy, still = pp.bind(scene).energy, np.zeros(6)
    inertia, moment = np.zeros(3), np.zeros(3)
    for i in range(3):
        alone = np.zeros(6)
        alone[2 * i : 2 * i + 4 : 2] = [1, -1][: 3 - i]  # the joint below turns back
        inertia[i] = 2 * energy(still, alone)[0]
        moment[i] = (energy(np.pi * alone, still)[1] - energy(still, still)[1]) / (2 * 9.81)
    lengths, parts = inertia / moment, moment / moment[2]
    expected = [lengths[0], parts[0], lengths[1], parts[1], lengths[2], friction.coefficient / moment[2]]

    free = free_parameters(scene, "physics")
    along = draw.normal(size=len(free.start))
    known: Any = SimpleNamespace(
        scale=along, enough=True, determined=lambda slope: True, error=lambda slope: slope @ along
    )
    found, above, below = (
        combinations(scene, free, free.start + step * along, known, {"effects[1].coefficient"})
        for step in (0, 1e-4, -1e-4)
    )
    assert [one.value for one in found] == pytest.approx(expected, rel=1e-9)
    assert [one.unit for one in found] == ["m", "", "m", "", "m", ""]
    slopes = [(one.value - other.value) / 2e-4 for one, other in zip(above, below, strict=True)]
    assert [one.error for one in found] == pytest.approx(slopes, rel=1e-4, abs=1e-6)


# --- swings ---------------------------------------------------------------------------------------------------------


def swing_of(samples: int, spacing: float = 0.01) -> Swing:
    t = np.arange(samples) * spacing
    return Swing("1", t, np.sin(t)[:, None] + [0.0, 1.0], np.arange(samples), "sample", 0)


@example(121, 0.1)  # 12 pieces of 0.1 s, in doubles 9e-17 s more
@given(st.integers(8, 500), st.floats(0.05, 10))
def test_pieces_are_the_swing(samples: int, longest: float) -> None:
    """Together they are the swing; none is longer than asked unless samples are few; sizes differ by one at most.

    Longer by 1e-9 of it is not longer: the number of pieces is rounded down by as much, against the rounding of times.
    """
    swing = swing_of(samples)
    pieces = cut_pieces(swing, longest)
    assert np.concatenate([piece.t for piece in pieces]).tolist() == swing.t.tolist()
    assert np.concatenate([piece.y for piece in pieces]).tolist() == swing.y.tolist()
    sizes = [len(piece.t) for piece in pieces]
    assert max(sizes) - min(sizes) <= 1
    assert min(sizes) >= FEWEST
    few = (samples // (len(pieces) + 1)) < FEWEST
    assert few or max(piece.t[-1] - piece.t[0] for piece in pieces) <= longest * (1 + 1e-9)
    assert len(pieces) == 1 or (swing.t[-1] / (len(pieces) - 1)) > longest * (1 - 1e-6)


def test_a_batch_is_padded_with_nothing() -> None:
    """Pieces side by side: where one is over, its last time again and no number."""
    swings = [swing_of(20), swing_of(9, 0.02)]
    found = batch(swings, np.inf)
    assert found.swing.tolist() == [0, 1]
    assert found.t.shape == (20, 2)
    assert found.y.shape == (20, 2, 2)
    assert found.t[:, 0].tolist() == swings[0].t.tolist()
    assert found.t[:, 1].tolist() == [*swings[1].t, *[swings[1].t[8]] * 11]
    assert found.y[:9, :, 1].tolist() == swings[1].y.tolist()
    assert np.isnan(found.y[9:, :, 1]).all()


def test_many_samples_are_spared_only_as_far_as_they_follow_the_motion() -> None:
    """Every second of twice as many; not where samples would be too far apart; few are left alone."""
    swing, few = swing_of(2 * MOST_SAMPLES), swing_of(MOST_SAMPLES)
    thinned, kept = thin_out([swing, few], 1.0)
    assert thinned.t.tolist() == swing.t[::2].tolist()
    assert len(kept.t) == MOST_SAMPLES
    assert len(thin_out([swing_of(MOST_SAMPLES + 2)], 1.0)[0].t) == MOST_SAMPLES // 2 + 1
    assert len(thin_out([swing], 0.015)[0].t) == 2 * MOST_SAMPLES
    assert len(thin_out([swing], 0.005)[0].t) == 2 * MOST_SAMPLES


def table_of(y: np.ndarray) -> dict:
    return {"t": np.arange(len(y)) * 0.01, "segment": np.ones(len(y)), "a1": y}


def test_columns_are_in_radians_and_metres() -> None:
    """Angles in degrees are turned, tips are not; empty samples go, cells without a number, or masked, are counted."""
    y = np.array([[0.1 * k, 0.2 * k] for k in range(12)])
    y[3] = np.nan
    y[5, 1] = np.nan
    data = Data(columns={"a": ("theta",), "b": "rod.y"}, unit="degrees")
    (swing,) = read_swings({"t": np.arange(12) * 0.1, "a": y[:, 0], "b": y[:, 1]}, data)
    assert swing.missing == 3
    assert swing.rows.tolist() == [1, 2, 3, *range(5, 13)]
    kept = np.delete(y, 3, 0)
    assert swing.y[:, 0] == pytest.approx(np.radians(kept[:, 0]), rel=1e-14)
    assert swing.y[:, 1].tolist()[:3] == kept[:3, 1].tolist()
    assert np.isnan(swing.y[4, 1])
    assert spread_of([swing])[0] == pytest.approx(np.radians(kept[:, 0]).std(), rel=1e-12)
    masked = np.ma.array(np.nan_to_num(y, nan=999.0), mask=np.isnan(y))
    (same,) = read_swings({"t": np.arange(12) * 0.1, "a": masked[:, 0], "b": masked[:, 1]}, data)
    assert np.array_equal(same.y, swing.y, equal_nan=True)


@pytest.mark.parametrize(("jump", "refused"), [(5.5, False), (-5.5, False), (5.8, True), (-5.8, True)])
def test_an_angle_that_jumps_by_nearly_a_turn_was_wrapped(jump: float, refused: bool) -> None:
    """From nine tenths of a turn, 5.65 rad, up and down."""
    y = np.sin(np.arange(20) / 5)
    y[10:] += jump - (y[10] - y[9])
    if refused:
        with pytest.raises(pp.InputError, match=r"sample 11, column a1: it jumps by a turn before 0\.1 s"):
            read_swings(table_of(y), ANGLE)
    else:
        assert len(read_swings(table_of(y), ANGLE)) == 1


def test_a_segment_needs_eight_samples() -> None:
    """Eight are enough."""
    assert len(read_swings(table_of(np.sin(np.arange(8.0))), ANGLE)[0].t) == FEWEST == 8
    with pytest.raises(pp.InputError, match="has 7 samples; a segment needs 8 at least"):
        read_swings(table_of(np.sin(np.arange(7.0))), ANGLE)


def test_a_time_that_comes_twice_is_refused() -> None:
    """With the sample and its time."""
    table = table_of(np.sin(np.arange(20) / 5))
    table["t"][7] = table["t"][6]
    with pytest.raises(pp.InputError, match=r"sample 8, column t: 0\.06 s does not come after 0\.06 s"):
        read_swings(table, ANGLE)


@pytest.mark.parametrize(("same", "refused"), [(7, False), (8, True)])
def test_shared_samples_are_refused(same: int, refused: bool) -> None:
    """Seven may be chance; those of a pendulum at rest are no motion."""
    y, other = np.sin(np.arange(20) / 3), np.cos(np.arange(20) / 3)
    other[:same] = y[:same]
    both = {
        name: np.concatenate([one, two])
        for (name, one), two in zip(table_of(y).items(), table_of(other).values(), strict=True)
    }
    both["segment"] = np.repeat([1, 2], 20)
    if refused:
        with pytest.raises(pp.InputError, match="segments 1 and 2 share 8 samples; leave them out of one"):
            read_swings(both, ANGLE)
    else:
        assert [swing.name for swing in read_swings(both, ANGLE)] == ["1", "2"]
    rest = both | {"a1": np.concatenate([y, other]) * np.tile(np.arange(20) >= 12, 2)}
    rest["a1"][20:] *= 1.1
    assert len(read_swings(rest, ANGLE)) == 2


def test_two_columns_are_two_angles() -> None:
    """Each in its place, as the table names them."""
    t = np.arange(10) * 0.1
    (swing,) = read_swings({"segment": np.ones(10), "a2": 2 * t, "a1": t, "t": t}, ANGLES)
    assert swing.y.tolist() == np.column_stack([t, 2 * t]).tolist()


def test_a_motion_depends_on_its_numbers_and_its_start_alone() -> None:
    """Not on motions before it, nor on one that was too long; what is asked for again is not integrated again."""
    scene = scene_of(1, DryFriction(kinetic=1e-3), data=ANGLE)
    free, sensors = free_parameters(scene, "friction"), sensors_of(ANGLE, build(scene.model))
    pendulum = bind_pendulum(scene, free, sensors, 0.0, scene.duration, 0.05)
    times, start = scene.times, np.array([1.0, 0.0])
    q, by = pendulum.at(free.start).move(start, times)
    bound = pendulum.at(2 * free.start)
    assert pendulum.at(2 * free.start) is bound
    bound = pendulum.at(free.start)
    with pytest.raises(RunError, match="too many evaluations"):
        replace(bound, pendulum=replace(pendulum, pace=1e6), moved={}).move(np.array([1.0, 1e5]), times)
    bound.move(np.array([3.0, 0.2]), times)
    again, by_again = bound.move(start, times)
    np.testing.assert_array_equal(again, q)
    np.testing.assert_array_equal(by_again, by)
    calls, many = bound.variations.equations.block.calls, np.ones((1, 10_000))
    bound.move(start, times)
    assert bound.variations.equations.block.calls == calls
    assert np.isfinite(bound.accelerate(np.zeros(10_000), many, many)[0]).all()
