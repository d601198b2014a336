"""Laws of scenes: users' effects, the time of the start, short runs, tracks."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.sweeps.significance import significance
from pendpin.verification.work_precision.references import reference
from test_scene_laws import CONTACTS, LEAN, METHODS, ROD, SMOOTH, START, TWO, same_bits

# --- effects that do not run on symbols -----------------------------------------------------------------------------


def own(act: Any) -> fx.JointEffect:
    """A torque of a user's own, by any function; `smooth` is left at its default."""

    class Own(fx.JointEffect):
        kind: Literal["own"] = "own"

        def torques(self, t: Any, q: Any, v: Any, xp: Any = np) -> Any:
            return act(q, v)

    return Own()


@pytest.mark.parametrize(
    "act",
    [
        lambda q, v: -abs(v) * v,
        lambda q, v: np.where(v < 0, 1.0, -1.0),
        lambda q, v: -v if v[0] > 0 else v,
        lambda q, v: -(q % 3.0),
        lambda q, v: -np.sin(q),
        lambda q, v: np.where(v == 0, 0.0, -v),
        lambda q, v: -v if v[0] != 0 else q,
        lambda q, v: np.array([float(v[0]), 0.0]),
    ],
    ids=["abs", "<", "if", "%", "np.sin", "==", "!=", "float"],
)
@pytest.mark.parametrize("options", [{"method": "taylor"}, {"engine": "compiled"}], ids=["taylor", "compiled"])
def test_an_effect_that_does_not_run_on_symbols_says_so(act: Any, options: dict[str, Any]) -> None:
    """One line that names the effect and what to write."""
    pytest.importorskip("heyoka")
    pytest.importorskip("llvmlite")
    scene = pp.Scene(duration=0.1, model=pp.Chain(rods=(ROD,)), effects=(fx.Gravity(), own(act)))
    named = scene.model_copy(update={"solver": pp.Solver(**options)})
    with pytest.raises(pp.InputError, match=r"effects\[1\]: own does not run on symbols \(.*`smooth` be False$"):
        pp.simulate(named)


def test_where_nothing_is_named_effects_run_without_symbols() -> None:
    """An effect of a user's own stays in Python, for a tolerance and for an accuracy."""
    scene = pp.Scene(duration=0.1, model=pp.Chain(rods=(ROD,)), effects=(fx.Gravity(), own(lambda q, v: -np.sin(q))))
    for options in ({"tolerance": 1e-8}, {"accuracy": 1e-6}):
        assert pp.simulate(scene, **options).stats.engine == "pinocchio"


# --- the time of the start ------------------------------------------------------------------------------------------


@LEAN
@given(st.sampled_from([0.1, -7.3, 100.0, 3.6e4, 1.7e9]), st.sampled_from([0.05, 0.4]), st.booleans())
def test_a_late_start_changes_nothing_but_the_clock(late: float, duration: float, touching: bool) -> None:
    """Where nothing depends on the time: every number of a run, a cross-check, an ensemble, the significance of effects."""
    effects = (fx.Gravity(), fx.Viscous(coefficient=0.05), *CONTACTS[: 4 * touching])
    early = pp.Scene(duration=duration, model=TWO, start=START, effects=effects, solver=pp.Solver(samples=4))
    then = early.model_copy(update={"start": START.model_copy(update={"time": late})})
    one, other = (pp.simulate(scene, energy_balance=True) for scene in (early, then))
    assert np.array_equal(other.t, late + one.t)
    same_bits(replace(one, t=other.t), other)
    assert pp.crosscheck(early, states=3) == pp.crosscheck(then, states=3)
    many = [pp.simulate_many(scene, [[0.1, 0.2, 0.3, 0.4]], [[0.0] * 4], workers=1) for scene in (early, then)]
    assert np.array_equal(many[0].q, many[1].q)


@pytest.mark.parametrize("late", [100.0, -7.3])
def test_significance_and_references_do_not_see_the_clock(late: float) -> None:
    """What effects change, and how far they are compared, is the same after a late start."""
    early = pp.Scene(
        duration=0.5, model=pp.Chain(rods=(ROD,)), start=pp.Start(positions=(0.3, 0.4)), effects=SMOOTH[:1]
    )
    then = early.model_copy(update={"start": early.start.model_copy(update={"time": late})})
    one, other = (significance(scene) for scene in (early, then))
    assert one.horizon == other.horizon == 0.5
    assert [row.change for row in one.rows] == [row.change for row in other.rows]
    known = [reference(scene, 1e-9) for scene in (early, then)]
    assert np.array_equal(known[0].t, known[1].t)
    assert np.array_equal(known[0].tips, known[1].tips)


# --- short runs -----------------------------------------------------------------------------------------------------


@LEAN
@given(st.floats(-100, -1).map(lambda power: 10.0**power), st.sampled_from(METHODS))
def test_any_duration_is_run(duration: float, method: dict[str, Any]) -> None:
    """However short: two samples at least, the last at the end, where a free rod has turned as far as its rates say."""
    step = {"step": duration} if "step" in method else {}
    scene = pp.Scene(duration=duration, model=pp.Chain(rods=(ROD,)), start=pp.Start(velocities=(2.0, 0.0)))
    run = pp.simulate(scene, **method | step)
    assert len(run.t) >= 2
    assert run.t[-1] == duration
    assert run.stats.steps > 0
    assert run.q[-1, 0] == pytest.approx(2.0 * duration, rel=1e-9)


def test_a_pendulum_of_a_micrometre_swings() -> None:
    """Its period is 1.6 ms: a run of 8 ms is one of five swings, as one of a metre is in 8 s, and can be drawn."""
    runs = [
        pp.simulate(
            pp.Scene(
                duration=8 * size**0.5,
                model=pp.Chain(rods=(pp.Rod(length=size, mass=1.0, radius=0.05 * size),)),
                start=pp.Start(positions=(0.5, 0.2)),
                effects=(fx.Gravity(),),
                solver=pp.Solver(samples=samples),
            ),
            tolerance=1e-12,
        )
        for size, samples in ((1.0, 2), (1e-6, None))
    ]
    assert len(runs[1].t) == 2
    assert np.abs(runs[0].q[-1] - runs[1].q[-1]).max() < 1e-7
    assert runs[1].energy().drift < 1e-9


def test_one_sample_of_a_duration_is_refused() -> None:
    """It would be the start alone, and no run."""
    with pytest.raises(pp.InputError, match=r"solver\.samples: 1 is the start alone"):
        pp.Scene(duration=1.0, model=TWO, solver=pp.Solver(samples=1))
    assert len(pp.simulate(pp.Scene(duration=0.0, model=TWO, solver=pp.Solver(samples=1))).t) == 1


# --- tracks ---------------------------------------------------------------------------------------------------------


@law(50)
@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e3), st.integers(2, 9))
def test_a_track_covers_the_run_that_it_was_made_for(begin: float, duration: float, rows: int) -> None:
    """Its last time is written as the user computes it, the run's is begin + duration: rounding is no gap."""
    for end in (begin + duration, float(np.nextafter(begin + duration, -np.inf)), float(f"{begin + duration:.15g}")):
        times = np.linspace(begin, end, rows)
        if not (np.diff(times) > 1e-9 * abs(begin)).all():
            return
        with TemporaryDirectory() as folder:
            path = Path(folder) / "track.csv"
            path.write_text("".join(f"{t!r},{i * i * 1e-2},0,{i * 1e-2}\n" for i, t in enumerate(times.tolist())))
            support = fx.Support(csv=path)
            support.check(begin, begin + duration)
            assert np.isfinite(support.acceleration(begin + duration)).all()
            with pytest.raises(ValueError, match="do not cover the run"):
                support.check(begin, begin + duration * 1.001)
            with pytest.raises(ValueError, match="do not cover the run"):
                support.check(begin - duration * 0.001, begin + duration)


def test_a_track_from_01_to_03() -> None:
    """0.1 + 0.2 is more than 0.3."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "track.csv"
        path.write_text("".join(f"{t},{t * t},0,0\n" for t in (0.1, 0.15, 0.2, 0.25, 0.3)))
        model, start = pp.Chain(rods=(ROD,)), pp.Start(time=0.1, positions=(0.3, 0.4))
        run = pp.simulate(pp.Scene(duration=0.2, model=model, start=start, effects=(fx.Support(csv=path),)))
    assert run.t[-1] == 0.1 + 0.2
    assert np.isfinite(run.a).all()
