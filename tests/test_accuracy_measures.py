"""What a search for an accuracy measures and chooses, against exact values: paths, gaps, times, settings."""

import math
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin.ground.arrays import EPS
from pendpin.model.build import build
from pendpin.runs.accuracy.estimate import RoundingError, _run_like, bound_rounding
from pendpin.runs.accuracy.runs import (
    Ruler,
    Runs,
    choose_length,
    choose_places,
    list_alternatives,
    refine_by_step,
    refine_by_tolerance,
)
from pendpin.runs.accuracy.thresholds import INSTABILITY, ROUNDING, SAMPLE
from pendpin.runs.limits import Deadline
from pendpin.runs.run import prepare
from pendpin.scene.methods import method_of

RATE = 2.0  # rad/s
SLIDE = """<robot name="slide"><link name="base"/><link name="car"><inertial><mass value="2"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="x" type="prismatic">
<parent link="base"/><child link="car"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"""


def spinning(duration: float = 3.0, begin: float = 0.0, length: float = 2.0, rate: float = RATE, **solver) -> pp.Scene:
    """A rod that turns at a constant rate, without gravity."""
    return pp.Scene(
        duration=duration,
        model=pp.Chain(rods=[pp.Rod(length=length, mass=1.0, radius=0.1)]),
        start=pp.Start(time=begin, velocities={"theta": rate}),
        effects=(pp.effects.Gravity(acceleration=0.0),),
        solver=pp.Solver(**({"method": "dop853", "tolerance": 1e-10, "samples": 7} | solver)),
    )


def runs_of(scene: pp.Scene) -> Runs:
    return Runs(prepare(scene, False, Deadline(None)), lambda t: None, Deadline(None))


def ruler_of(scene: pp.Scene, length: float, samples: int) -> Ruler:
    return Ruler(build(scene.model), length, np.arange(samples))


# --- what is measured along a run -----------------------------------------------------------------------------------


@pytest.mark.parametrize("begin", [0.0, 50.0])
@pytest.mark.parametrize(("length", "rate"), [(0.5, RATE), (2.0, RATE), (2.0, 1e-4), (2.0, 1e3)])
def test_the_path_of_a_spinning_tip(begin: float, length: float, rate: float) -> None:
    """Its speed and path, in lengths, at any rate, whenever the run begins; the tip is up to 2 lengths from its start."""
    scene = spinning(duration=6 / rate, begin=begin, length=length, rate=rate)
    run, ruler = pp.simulate(scene), ruler_of(scene, length, 7)
    assert ruler.measure_speeds(run) == pytest.approx(np.full(7, rate), rel=1e-6)
    assert bound_rounding(np.zeros(7), 1.0, run, ruler).path == pytest.approx(6.0, rel=1e-6)
    assert ruler.measure_extent(run) == pytest.approx(2 * max(abs(np.sin(np.linspace(0, 6, 7) / 2))), rel=1e-8)


def test_rounding_is_in_proportion_to_the_gap_of_a_shift() -> None:
    """Twice the gap, or half the shift: twice the growth; at 0 the rounding of the path is left, and it grows with it."""
    run = pp.simulate(spinning())
    gap, units, ruler = np.linspace(0.0, 1e-6, 7), 1e4, ruler_of(spinning(), 2.0, 7)
    still, once, twice, half = (
        bound_rounding(x, n, run, ruler)
        for x, n in ((0 * gap, units), (gap, units), (2 * gap, units), (gap, units / 2))
    )
    np.testing.assert_allclose(twice.error - still.error, 2 * (once.error - still.error), rtol=1e-9)
    np.testing.assert_array_equal(twice.error, half.error)
    assert once.growth == pytest.approx(1e-6 / (units * EPS))
    assert still.error[0] == EPS
    path = still.error - EPS
    np.testing.assert_allclose(path, path[-1] * run.t / 3.0, rtol=1e-6)
    assert still.last == still.error[-1]
    least = ROUNDING.start_units + ROUNDING.step_units * math.sqrt(run.stats.steps)
    assert once.last - still.last == pytest.approx(1e-6 / units * least)


@pytest.mark.parametrize("start", [(0.0, 0.4, 1.3, 0.0), (0.5, 0.0, -1.0, 0.7), (0.0, -0.3, -0.2, 0.4)])
def test_a_shift_moves_every_joint_and_has_mirror_images(start: tuple[float, float, float, float]) -> None:
    """Positions too that begin at 0; none beyond the farthest. A start in mirror image is shifted in mirror image."""
    scene = spinning(duration=1.0).replace(effects=(pp.effects.Gravity(),))
    units, shifted = 1e3, list[np.ndarray]()
    for side in (1.0, -1.0):
        q0, v0 = np.split(side * np.array(start), 2)
        scene = scene.replace(start=pp.Start(positions=q0.tolist(), velocities=v0.tolist()))
        run, own = pp.simulate(scene), runs_of(scene)
        fake: Any = SimpleNamespace(
            start=(q0, v0), dynamics=own.dynamics, times=own.times, run=lambda other, shifts: other
        )
        other: Any = _run_like(fake, scene, run, units)
        q, v = np.array(other.start.positions), np.array(other.start.velocities)
        assert (q != q0).all()
        assert (v != v0).all()
        assert (np.abs(q) <= np.abs(run.q).max(0)).all()
        assert np.abs(q - q0).max() <= (units + 1) * EPS * np.abs(run.q).max()
        shifted.append(np.concatenate([q, v]))
    assert shifted[1] == pytest.approx(-shifted[0], rel=1e-15)


def test_a_gap_that_is_not_linear_has_no_bound() -> None:
    """Beyond a twentieth of the length shifts say nothing; at it they still do."""
    run = pp.simulate(spinning())
    gap = np.full(7, ROUNDING.linear)
    gap[4:] = np.nextafter(ROUNDING.linear, 1)
    error = bound_rounding(gap, 1e4, run, ruler_of(spinning(), 2.0, 7)).error
    assert np.isfinite(error[:4]).all()
    assert np.isinf(error[4:]).all()


def test_what_is_magnified_grows_faster_than_a_steady_motion() -> None:
    """40 times the path; and only where the error is larger than the target."""
    for growth, magnified in ((39.0 * 7, False), (41.0 * 7, True)):
        found = RoundingError(np.array([0.0, 1e-6]), growth, 7.0)
        assert INSTABILITY.steady_growth == 40
        assert found.magnified_beyond(0.9e-6) == magnified
        assert not found.magnified_beyond(1.1e-6)


def test_gaps_never_fall() -> None:
    """Two rods that part and meet again: 2 sin(x / 2) of the angle x between them, to its largest; inf after an end."""
    one, other = (pp.simulate(spinning(samples=9, duration=8.0, rate=rate)) for rate in (0.0, math.pi / 4))
    angles = np.minimum(math.pi / 4 * np.arange(9), math.pi)
    ruler = ruler_of(spinning(), 2.0, 9)
    assert ruler.measure_gap(one, other) == pytest.approx(2 * np.sin(angles / 2), abs=1e-8)
    short = pp.simulate(spinning(samples=3, duration=2.0, rate=math.pi / 4))
    found = ruler.measure_gap(one, short)
    assert found[:3] == pytest.approx(2 * np.sin(angles[:3] / 2), abs=1e-8)
    assert np.isinf(found[3:]).all()


def test_a_slide_is_measured_by_its_way(tmp_path: Path) -> None:
    """A chain by the sum of its rods, wherever it is; a slide, which has no length, by how far it gets."""
    scene = spinning()
    assert choose_length(build(scene.model), pp.simulate(scene).tips) == 2.0
    file = tmp_path / "slide.urdf"
    file.write_text(SLIDE)
    start = pp.Start(positions={"x": -0.5}, velocities={"x": 1.0})
    run = pp.simulate(pp.Scene(duration=3.0, model=pp.UrdfModel(path=file), start=start))
    assert choose_length(build(run.source.model), run.tips) == pytest.approx(2.5, rel=1e-9)


# --- where runs are compared ----------------------------------------------------------------------------------------


@law(50)
@given(st.integers(2, 200), st.sampled_from([0.0, 7.0]))
def test_runs_are_compared_at_64_intervals_or_more(samples: int, begin: float) -> None:
    """By halving: fewer than twice as many, unless there are more output times; evenly between those, which are kept."""
    scene = spinning(begin=begin, samples=samples)
    times = runs_of(scene).times
    count = len(times) - 1
    assert count % (samples - 1) == 0
    assert count >= SAMPLE.intervals
    assert count < 2 * SAMPLE.intervals or count == samples - 1
    np.testing.assert_allclose(times, np.linspace(0, 3.0, count + 1), rtol=1e-14)


@pytest.mark.parametrize("begin", [0.0, 7.0])
def test_uneven_output_times_are_cut_evenly(begin: float) -> None:
    """Each interval into as many equal ones."""
    given_times = (0.0, 0.5, 2.0, 3.0)
    scene = spinning(begin=begin, samples=None, times=tuple(begin + t for t in given_times))
    runs = runs_of(scene)
    every = runs.every
    assert 64 <= 3 * every < 128
    exact = np.concatenate([np.linspace(a, b, every + 1)[:-1] for a, b in pairwise(given_times)])
    np.testing.assert_allclose(runs.times, np.append(exact, 3.0), atol=1e-14)
    run = runs.run(scene)
    assert runs.keep_output_times(run).t == pytest.approx(np.add(begin, given_times))


# --- settings -------------------------------------------------------------------------------------------------------


@law(200)
@given(
    st.sampled_from(["rk4", "euler", "gauss2", "gauss4", "gauss6"]),
    st.integers(1, 300),
    st.floats(0.01, 1e4),
    st.floats(1e-3, 10.0),
)
def test_finer_steps_are_the_longest_that_are_fine_enough(
    method: str, count: int, factor: float, spacing: float
) -> None:
    """Whole parts of the spacing of samples, an error smaller by the factor, 4 at least: one part less is too few."""
    refinement = refine_by_step(method, np.array([0.0, spacing]), 1)
    finer = refinement.finer(spacing / count, factor)
    parts = spacing / finer
    order, wanted = method_of(method).order, max(factor, 4.0)
    assert order
    assert parts == pytest.approx(round(parts), rel=1e-12)
    assert parts >= count + 1 - 1e-9
    assert (parts / count) ** order >= wanted * (1 - 1e-6)
    assert round(parts) == count + 1 or ((parts - 1) / count) ** order <= wanted


@law(100)
@given(st.integers(1, 100_000), st.floats(-100, 100), st.lists(st.floats(0.01, 3.0), min_size=1, max_size=6))
def test_first_steps_are_as_many_as_wanted(wanted: int, begin: float, gaps: list[float]) -> None:
    """Over the whole run, wherever its times begin; a part of the largest spacing, and one part less is too few."""
    times = begin + np.concatenate([[0.0], np.cumsum(gaps)])
    span, largest = times[-1] - times[0], np.diff(times).max()
    first = refine_by_step("rk4", times, wanted).first
    parts = round(largest / first)
    assert first == pytest.approx(largest / parts, rel=1e-12)
    assert span / first >= wanted * (1 - 1e-9)
    assert parts == 1 or span / largest * (parts - 1) < wanted * (1 + 1e-9)


@pytest.mark.parametrize(
    ("seconds", "words"), [(50 * 86_400, "50 days"), (100 * 60, "100 minutes"), (47 * 3600, "47 hours"), (119, "119 s")]
)
def test_too_many_steps_are_said_in_a_unit_that_one_reads(seconds: float, words: str) -> None:
    """Two of a unit at least."""
    text = refine_by_step("rk4", np.array([0.0, 1.0]), 1).describe_too_many(2e8, seconds)
    assert text.startswith(f"rk4 is of order 4 and would take about 2e+08 steps, about {words};")
    assert refine_by_tolerance("dop853", 1e-9).describe_too_many(2e8, seconds).endswith(words)  # not in its own place


@pytest.mark.parametrize("method", ["dop853", "radau", "taylor"])
def test_tolerances_are_relative_to_the_angles(method: str) -> None:
    """Of ten turns and more by the decade: an error of 1e-6 of a hundred rad is 1e-8 of them."""
    plain, near, far = (refine_by_tolerance(method, 1e-6, turned).first for turned in (1.0, 9.9, 120.0))
    assert plain == near == pytest.approx(100 * far)
    for accuracy in (1e-3, 1e-6, 1e-9):
        refinement = refine_by_tolerance(method, accuracy)
        finer = refinement.finer(refinement.first, 50.0)
        assert refinement.first / finer >= 50 * (1 - 1e-9)
        assert finer >= refinement.least
    assert refinement.finer(refinement.least, 100.0) == refinement.least


def test_a_power_series_keeps_to_few_tolerances() -> None:
    """Each is compiled: the next is finer by the least power of 100 that is enough."""
    refinement = refine_by_tolerance("taylor", 1e-6)
    ratios = [refinement.first / refinement.finer(refinement.first, factor) for factor in (2.0, 100.0, 101.0, 1e4)]
    assert ratios == pytest.approx([1e2, 1e2, 1e4, 1e4], rel=1e-12)


def test_other_methods_are_those_that_were_not_tried() -> None:
    """Two explicit ones where equations are not stiff; none where the scene names its method."""
    scene = spinning(method="auto", tolerance=None, accuracy=1e-6)
    tried = {
        name: [other.solver.method for other in list_alternatives(scene, runs_of(scene.with_solver(method=name)))]
        for name in ("taylor", "dop853", "rk45")
    }
    assert tried == {"taylor": ["dop853", "rk45"], "dop853": ["rk45"], "rk45": ["dop853"]}
    rk4 = spinning(method="rk4", tolerance=None, accuracy=1e-6)
    assert not [*list_alternatives(rk4, runs_of(rk4))]


@law(60)
@given(count=st.integers(1, 20_000))
def test_few_of_many_samples_are_compared(count: int) -> None:
    """All of up to 128, with the first and the last; of more as many, in every part of the run, at no regular distance."""
    places = choose_places(count)
    assert places[0] == 0
    assert places[-1] == count - 1
    assert (np.diff(places) > 0).all()
    if count <= SAMPLE.most:
        assert len(places) == count
        return
    assert SAMPLE.most / 2 <= len(places) <= SAMPLE.most + 1
    assert np.diff(places).max() <= 2 * count / SAMPLE.most + 1


@pytest.mark.parametrize("periods", [100, 128, 257])
def test_no_period_of_a_motion_falls_in_with_the_places(periods: int) -> None:
    """A distance that swings so many times in a run of 12,801 samples is seen to nine tenths, whatever its phase."""
    x = 2 * np.pi * periods * choose_places(12_801) / 12_800
    assert min(np.abs(np.sin(x + phase)).max() for phase in np.linspace(0, np.pi, 50)) > 0.9
