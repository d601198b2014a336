"""Fits: exact motions, synthetic truth found again within its errors, what cannot be told."""

import json
import re
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
import pytest
from scipy.signal import lfilter

import pendpin as pp
from fit_scenes import ANGLE, ANGLES, NOISE, ROD, scene_of, swings_of
from pendpin.cli import main
from pendpin.effects import Anchor, Drag, DryFriction, Effect, Gravity, OnJoints, Viscous
from pendpin.effects.pace import STEADY, Pace
from pendpin.fitting import explain_residual
from pendpin.fitting.data import batch, read_swings, sensors_of
from pendpin.fitting.fitting import fixed_offsets, prepare
from pendpin.fitting.parameters import free_parameters, substitute
from pendpin.fitting.problem import LOST, Bound, bind_pendulum
from pendpin.ground.records import NotNegative
from pendpin.model.build import build
from pendpin.scene import Data


@pytest.mark.parametrize(
    ("rods", "effects", "start"),
    [
        (1, (DryFriction(kinetic=1e-3, static=2e-3, stribeck=5.0), Viscous(coefficient=1e-4), Drag()), [1.5]),
        (2, (DryFriction(kinetic=1e-2, static=1.2e-2),), [1.0, -0.5]),
        pytest.param(2, (DryFriction(kinetic=3e-4), Drag(diameter=0.02)), [1.0, -1.0], marks=pytest.mark.slow),
    ],
)
def test_motions_agree_with_simulate(rods: int, effects, start: list[float]) -> None:
    """Sliding, sticking and coming loose included: below 1e-7 rad. The derivatives are those of neighbouring runs."""
    scene = scene_of(rods, *effects, rate=400)
    free, sensors = free_parameters(scene, "physics"), sensors_of(ANGLE if rods == 1 else ANGLES, build(scene.model))
    pendulum = bind_pendulum(scene, free, sensors, 0.0, scene.duration, 0.05)
    assert pendulum.moving == tuple(2 * i for i in range(rods))  # phi stays at rest
    begin = np.array([*start, *[0.0] * rods])
    q, by = pendulum.at(free.start).move(begin, scene.times)
    positions = [x for angle in start for x in (angle, 0.0)]
    run = pp.simulate(pp.Scene(**scene.given() | {"start": pp.Start(positions=positions)}))
    assert np.abs(q - run.q).max() < 1e-7
    for direction, change_by in enumerate(by[: len(free.start)]):
        z = np.zeros(len(free.start))
        z[direction] = 1e-5 * (1.0 if free.positive[direction] else free.start[direction])
        late, early = (pendulum.at(free.start + side * z).move(begin, scene.times)[0] for side in (1, -1))
        change = 2 * z.sum() * change_by  # of third order in z, and by the tolerance
        assert np.abs(late - early - change).max() < 1e-3 * np.abs(change).max() + 1e-8


@pytest.fixture(scope="module")
def single() -> tuple[pp.Scene, dict[str, np.ndarray]]:
    """A rod with friction and drag, and three of its swings."""
    effects = (Viscous(coefficient=5e-5), DryFriction(kinetic=1e-4), Drag(diameter=0.02))
    truth = scene_of(1, *effects, data=ANGLE, duration=3.0)
    return truth, swings_of(truth, [1.2], [0.8], [0.5])


def test_the_truth_is_within_its_errors(single) -> None:
    """Free numbers, from guesses 20 % off; the zeros of the sensors are 0. Four standard errors: one in 16,000."""
    truth, table = single
    free = ["model.rods[0].inertia", "effects[1].coefficient", "effects[2].kinetic", "effects[3].coefficient"]
    right = free_parameters(truth, free)
    guess = substitute(truth, right.keys, 1.2 * right.guess)
    fit = pp.fit(guess, table, free, hold_out=table)
    assert fit.explained, fit.verdict
    assert set(fit.undetermined) == {"model.rods[0].inertia[1]", "model.rods[0].inertia[2]"}  # no part in a plane swing
    for key, true in zip(right.keys, right.guess, strict=True):
        if key in fit.errors:
            assert abs(fit.values[key] - true) < 4 * fit.errors[key], key
            assert fit.errors[key] < 0.1 * true
    assert abs(fit.values["data.offsets.a1"]) < 4 * fit.errors["data.offsets.a1"]
    assert fit.hold_out is not None
    assert fit.train.rms["a1"] == pytest.approx(NOISE, rel=0.1)
    assert fit.hold_out.rms["a1"] < 3 * NOISE
    assert "The model explains the data" in str(fit)


def test_zeros_are_in_the_unit_of_the_data(single, tmp_path: Path) -> None:
    """Of data in degrees in degrees, 2 of them here; the fitted scene, read from its file, has the same model and zeros."""
    truth, table = single
    table = table | {"a1": table["a1"] + np.radians(2.0)}
    turned = truth.replace({"data.unit": "degrees"})
    fits = [
        pp.fit(scene, table | {"a1": table["a1"] * factor}, "effects[1].coefficient")
        for scene, factor in ((truth, 1.0), (turned, 180 / np.pi))
    ]
    key, zeros = "data.offsets.a1", [fixed_offsets(prepare(fit.scene, table, "friction", False)) for fit in fits]
    assert fits[1].values[key] == pytest.approx(2.0, abs=4 * fits[1].errors[key])
    assert [fit.values[key] for fit in fits] == pytest.approx(np.array([1, 180 / np.pi]) * zeros[0], rel=1e-6)
    assert [fit.errors[key] for fit in fits] == pytest.approx(
        np.array([1, 180 / np.pi]) * fits[0].errors[key], rel=1e-4
    )
    assert zeros[1] == pytest.approx(zeros[0], rel=1e-6)
    assert pp.load_scene(fits[1].scene.save(tmp_path / "fitted.toml")) == fits[1].scene
    assert f"{fits[1].errors[key]:.2g} degrees" in str(fits[1])
    assert f"rms a1 {np.degrees(fits[1].train.rms['a1']):.3g} degrees" in str(fits[1])


def test_a_free_swing_shows_no_scale_of_mass(single) -> None:
    """Of physics nothing is determined but ratios: these are right within their errors, and nothing else has one."""
    truth, table = single
    fit = pp.fit(truth, table, "physics")
    assert set(fit.errors) == {"data.offsets.a1"}
    reduced, *rest = fit.combinations
    m, h, inertia, *_ = truth.model.rods[0].properties
    assert abs(reduced.value - (inertia + m * h * h) / (m * h)) < 4 * reduced.error
    assert [c.name.split(" / ")[0] for c in rest] == [k for k in fit.values if k.startswith("effects")]


def test_a_wrong_model_is_noticed(single) -> None:
    """Drag that is missing; a single rod for a double pendulum, which is far off."""
    truth, table = single
    without = pp.Scene(**truth.given() | {"effects": truth.effects[:-1]})
    assert "cannot explain" in pp.fit(without, table, "physics").verdict
    double = swings_of(scene_of(2, data=ANGLES), [0.5, -0.3])
    assert "cannot explain the data at all" in pp.fit(truth, double, "physics").verdict


def test_a_rhythm_below_the_noise_is_a_missing_effect() -> None:
    """Residuals that are no larger than the noise, but neither white nor of one correlation time."""
    truth = scene_of(1, Viscous(coefficient=2e-4), data=ANGLE, duration=3.0)
    table = swings_of(truth, [0.8], [0.5])
    beating = table | {"a1": table["a1"] + 7e-5 * np.sin(2 * np.pi * 8.0 * table["t"])}
    fits = [pp.fit(truth, data, ["model.rods[0].com"]) for data in (table, beating)]
    assert [fit.explained for fit in fits] == [True, False]
    assert "residuals are small, but go with the motion" in fits[1].verdict


@pytest.mark.parametrize(
    ("memory", "size"), [(0.5, 1e-3), pytest.param(0.9, 1e-3, marks=pytest.mark.slow), (0.98, 2e-4)]
)
def test_correlated_noise_is_no_missing_effect(single, memory: float, size: float) -> None:
    """Noise of first order: of the right model it explains what is left over; where the drag is missing, it does not."""
    truth, table = single
    white = np.random.default_rng(5).normal(0, size * np.sqrt(1 - memory**2), len(table["t"]) + 500)
    noisy = table | {"a1": table["a1"] + lfilter([1.0], [1.0, -memory], white)[500:]}
    fit = pp.fit(truth, noisy, "physics")
    assert fit.explained
    assert fit.verdict.startswith("Noise of the sensors that is correlated over 0."), fit.verdict
    without = pp.fit(truth.replace(effects=truth.effects[:1]), noisy, "physics")
    assert "Some effect is missing" in without.verdict


def test_what_is_odd_in_the_data_is_named(single, tmp_path: Path) -> None:
    """Cells without a number are counted, a sample far from its neighbours is named with its line; in clean data neither."""
    scene, table = single
    column = next(iter(scene.data.columns))
    clean = pp.fit(scene, table, free="effects[1].coefficient")
    assert not any("stand" in line or "Cells" in line for line in clean.report().sentences)
    odd = {name: list(values) for name, values in table.items()}
    odd[column][50] += 0.3
    odd[column][20] = odd[column][30] = ""
    path = tmp_path / "lab.csv"
    rows = [",".join(map(str, row)) for row in zip(*odd.values(), strict=True)]
    path.write_text("\n".join([",".join(odd), *rows]))
    words = "\n".join(pp.fit(scene, path, free="effects[1].coefficient").report().sentences)
    assert "Cells without a number, which are skipped: 2." in words
    assert words.startswith(f"1 sample stands out: {path}: line 52, column {column}, by 0.3")
    assert "rad. Correct or remove it, or use --robust" in words
    assert "units" not in words
    robust = pp.fit(scene, path, free="effects[1].coefficient", robust=True)
    assert robust.explained, robust.verdict  # an outlier that counts less is not a missing effect
    assert "rad. It counts less." in str(robust)
    for key, error in clean.errors.items():  # Huber's weights cost 3 % of the errors, one clipped sample of 900 nothing
        assert robust.errors[key] == pytest.approx(error, rel=0.3), key
        assert abs(robust.values[key] - clean.values[key]) < 2 * error, key


@pytest.mark.parametrize("count", [2, 5])
def test_the_farthest_samples_are_named(single, count: int) -> None:
    """With their places and how far they are off, the farthest three; how many there are is said in any case."""
    scene, table = single
    far = {50 + 40 * k: 0.3 + 0.1 * k for k in range(count)}
    angles = table["a1"].copy()
    angles[list(far)] += list(far.values())
    first = pp.fit(scene, table | {"a1": angles}, free="effects[1].coefficient").report().sentences[0]
    assert first.startswith(f"{count} samples stand out{', the farthest' if count > 3 else ''}: ")
    found = re.findall(r"sample (\d+), column a1, by (\S+) rad", first)
    assert [int(place) - 1 for place, _ in found] == sorted(far, reverse=True)[:3]
    assert [float(size) for _, size in found] == pytest.approx(sorted(far.values(), reverse=True)[:3], abs=0.02)
    assert first.endswith("Correct or remove them, or use --robust (robust=True).")


def test_a_piece_that_cannot_be_run_is_far_off(monkeypatch) -> None:
    """At each of its samples and nowhere else, with no slope; the other pieces count as ever."""
    truth = scene_of(1, Viscous(coefficient=2e-4), data=ANGLE)
    table = swings_of(truth, [0.8], [0.5])
    table = {name: values[:-40] for name, values in table.items()}  # the second swing is shorter
    table["a1"][30] = table["a1"][-30] = np.nan
    solution = pp.fit(truth, table, ["model.rods[0].com"]).solution
    problem, x = solution.problem, solution.x
    problem = replace(problem, batch=batch(read_swings(table, ANGLE), np.inf), share=1.0)
    starts, measured = np.array([[0.8, 0.5], [0.0, 0.0]]), Bound.measure

    def measure(bound: Bound, start: np.ndarray, times: np.ndarray) -> Any:
        if start[0] == starts[0, lost]:
            raise pp.RunError("no")
        return measured(bound, start, times)

    right = problem.evaluate(x, starts)
    monkeypatch.setattr(Bound, "measure", measure)
    for lost, kept in ((0, 1), (1, 0)):
        found = problem.evaluate(x, starts)
        seen = ~np.isnan(problem.batch.y[:, 0, lost])
        assert (found.r[lost] == np.where(seen, LOST, 0.0)).all()
        assert not found.by_start[lost].any()
        for one, other in zip(found, right, strict=True):
            np.testing.assert_array_equal(one[kept], other[kept])


def test_a_thin_rod_does_not_explain_a_thick_one() -> None:
    """A swing in space shows the inertia about the rod's own axis; the rod with its radius explains the data."""
    start = pp.Start(positions={"theta": 0.7, "phi": 0.4}, velocities={"theta": 1.3, "phi": -0.8})
    thick = scene_of(1, Viscous(coefficient=5e-5), data=Data(columns={"a": ("theta",), "b": ("phi",)})).replace(
        {"model.rods[0].radius": 0.03}, start=start
    )
    run = pp.simulate(thick)
    noise = np.random.default_rng(0).normal(0, NOISE, run.q.shape)
    table = {"t": run.t, "a": run.q[:, 0] + noise[:, 0], "b": run.q[:, 1] + noise[:, 1]}
    assert "cannot explain" in pp.fit(thick.replace({"model.rods[0].radius": 0.0}), table, "physics").verdict
    assert pp.fit(thick, table, "physics").explained


def needed(scene: pp.Scene, table: dict[str, np.ndarray]) -> set[str]:
    """The parts that the data need; a model with one part more never explains less."""
    parts = explain_residual(pp.fit(scene, table, "physics")).parts
    assert all(part.rms < 1.01 for part in parts if not part.present), parts
    return {part.name for part in parts if part.needed}


class Cubic(OnJoints):
    """A brake of one's own: -strength v³."""

    parameters: ClassVar[tuple[str, ...]] = ("strength",)
    strengths: ClassVar[tuple[str, ...]] = ("strength",)
    kind: Literal["cubic"] = "cubic"
    strength: NotNegative

    @property
    def resistances(self) -> tuple[str, ...]:
        return ("strength",)

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        return STEADY

    def torques(self, t: Any, q: np.ndarray, v: np.ndarray, xp: Any = np) -> np.ndarray:
        return -self.strength * v**3


@pytest.mark.parametrize(("strength", "damping"), [(2e-6, 0.0), pytest.param(0.0, 5e-4, marks=pytest.mark.slow)])
def test_every_effect_that_brakes_is_tried(strength: float, damping: float) -> None:
    """One of a user's own, and a damper that is part of a spring, which stays: each is needed where the data have it."""
    anchor = {"link": "rod", "point": (0.0, 0.0, -0.3), "stiffness": 0.2}
    truth = scene_of(1, Cubic(strength=strength), Anchor(**anchor, damping=damping), data=ANGLE)
    guess = scene_of(1, Cubic(strength=1e-6), Anchor(**anchor, damping=1e-4), data=ANGLE)
    parts = explain_residual(pp.fit(guess, swings_of(truth, [1.1]), "friction")).parts
    needed = {part.name: part.needed for part in parts}
    assert needed["effects[1], cubic"] == (strength > 0)
    assert needed["effects[2], anchor: damping"] == (damping > 0)


def test_outliers_hide_no_missing_part() -> None:
    """Of a robust fit: two samples far off do not change what the data need."""
    table = swings_of(scene_of(1, Viscous(coefficient=1e-4), Drag(diameter=0.01), data=ANGLE), [1.0], [0.7])
    odd = table["a1"].copy()
    odd[[50, 250]] += 2.0
    scene = scene_of(1, Viscous(coefficient=1e-4), data=ANGLE)
    fits = (explain_residual(pp.fit(scene, table | {"a1": a}, robust=True)) for a in (odd, table["a1"]))
    parts, clean = ({part.name for part in fit.parts if part.needed} for fit in fits)
    assert "drag" in clean
    assert parts == clean


@pytest.mark.slow
def test_parts_are_held_against_held_out_swings(single) -> None:
    """A part changes how many numbers are free, and how well other swings are predicted: both are said of every part."""
    truth, table = single
    fit = explain_residual(pp.fit(truth, table, "friction", hold_out=table))
    assert fit.hold_out is not None
    assert fit.hold_out.interval
    assert all(part.hold_out is not None and part.hold_out > 0 for part in fit.parts)


@pytest.mark.slow
def test_what_is_missing_is_needed(single) -> None:
    """Of the right model what it has; of one without its drag the drag, and the damping that stands in for it.

    Whether the wrong model needs its dry friction too is not said: damping may take all of that.
    """
    truth, table = single
    without = pp.Scene(**truth.given() | {"effects": truth.effects[:-1]})
    rightly = {"effects[1], viscous", "effects[2], dry_friction"}
    assert {"effects[1], viscous", "drag"} <= needed(without, table) <= rightly | {"drag"}
    assert needed(truth, table) == rightly | {"effects[3], drag"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "brake",
    [lambda c, **on: Viscous(coefficient=c, **on), lambda c, **on: Cubic(strength=c / 10, **on)],
    ids=["viscous", "a user's own"],
)
def test_a_friction_for_each_joint_is_needed(brake: Callable[..., Effect]) -> None:
    """Of a model with one friction for two joints that have their own: a viscous one, and one of a user's own."""
    own = [brake(c, joints=(joint,)) for c, joint in ((5e-5, "theta_1"), (1e-5, "theta_2"))]
    truth = scene_of(2, *own, DryFriction(kinetic=1e-4), data=ANGLES, duration=3.0)
    table = swings_of(truth, [1.0, 0.5], [0.6, -0.2], [0.5, 0.5])
    one = pp.Scene(**truth.given() | {"effects": [Gravity(), brake(3e-5), truth.effects[-1]]})
    here = f"effects[1], {own[0].kind}"
    assert needed(one, table) == {here, "effects[2], dry_friction", f"{here}: one for each joint"}


def test_a_double_pendulum_by_its_tips(tmp_path: Path, capfd, monkeypatch) -> None:
    """Tips as columns, gaps, and the command with its JSON and its fitted scene, from which the fit starts again."""
    data = Data(columns={"y1": "rod_1.y", "y2": "rod_2.y", "z2": "rod_2.z"}, offsets="zero")
    truth = scene_of(2, Viscous(coefficient=1e-4), data=data)
    start = pp.Start(positions={"theta_1": 0.6, "theta_2": -0.4})
    run = pp.simulate(pp.Scene(**truth.given() | {"start": start}))
    tips = run.tips + np.random.default_rng(1).normal(0, 1e-5, run.tips.shape)
    rows = [f"{t},{a},{b},{c}" for t, a, b, c in zip(run.t, tips[:, 0, 1], tips[:, 1, 1], tips[:, 1, 2], strict=True)]
    rows[20] = rows[20].rsplit(",", 1)[0] + ","
    del rows[40:45]
    csv, scene, out = tmp_path / "tips.csv", tmp_path / "scene.toml", tmp_path / "out.toml"
    csv.write_text("\n".join(["t,y1,y2,z2", *rows]))
    truth.replace({"effects[1].coefficient": 3e-4}).save(scene)
    command = ["fit", str(scene), str(csv), "--free", "friction", "--json", "--out", str(out)]
    monkeypatch.setattr("sys.argv", ["pendpin", *command])
    with pytest.raises(SystemExit) as end:
        main()
    assert not end.value.code
    found = json.loads(capfd.readouterr().out)
    assert {"values", "errors", "undetermined", "seconds", "train", "hold_out"} <= set(found)
    key = "effects[1].coefficient"
    assert abs(found["values"][key] - 1e-4) < 4 * found["errors"][key] < 1e-5
    assert pp.load_scene(out).effects[1].coefficient == found["values"][key]


def test_more_coordinates_of_a_tip_say_more() -> None:
    """A rod in space: by x and y, and by z too, the numbers are the true ones, by all three with smaller errors."""
    data = Data(columns={axis: f"rod.{axis}" for axis in "xyz"}, offsets="zero", noise=1e-4)
    truth = scene_of(1, Viscous(coefficient=2e-4), data=data)
    run = pp.simulate(pp.Scene(**truth.given() | {"start": pp.Start(positions={"theta": 0.7, "phi": 0.3})}))
    tips = run.tips[:, 0] + np.random.default_rng(0).normal(0, 1e-4, (len(run.t), 3))
    table = {"t": run.t} | dict(zip("xyz", tips.T, strict=True))
    guess, free = truth.replace({"effects[1].coefficient": 5e-4}), ["effects[1].coefficient", "model.rods[0].com"]
    part = guess.replace(data=Data(columns={"x": "rod.x", "y": "rod.y"}, offsets="zero", noise=1e-4))
    two, three = pp.fit(part, table, free), pp.fit(guess, table, free)
    for key, true in zip(free, (2e-4, 0.1), strict=True):
        assert all(abs(fit.values[key] - true) < 4 * fit.errors[key] < 0.2 * true for fit in (two, three))
        assert three.errors[key] < two.errors[key]


def test_an_inertia_stays_that_of_a_real_body() -> None:
    """Whatever the search coordinates: the three inertias meet the triangle inequality."""
    scene = scene_of(1)
    free = free_parameters(scene, "model.rods[0].inertia")
    for z in np.random.default_rng(0).exponential(1e-3, (100, len(free.start))):
        assert (z >= free.lower).all()
        inertia = np.sort(free.values(z))
        assert inertia[2] <= inertia[:2].sum() * (1 + 1e-12)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_motion_is_found_in_noise_as_large_as_itself(seed: int) -> None:
    """The ratio that a free swing shows is within four of its standard errors."""
    table = swings_of(scene_of(1, data=ANGLE, duration=6.0), [1.0], [0.4])
    table["a1"] = table["a1"] + np.random.default_rng(seed).normal(0, 0.5, len(table["t"]))
    found = pp.fit(scene_of(1, data=ANGLE), table)
    rod = pp.Rod(**ROD)
    (ratio,) = (c for c in found.combinations if c.name.startswith("inertia"))
    true = rod.properties.I1 / (rod.mass * rod.length / 2) + rod.length / 2
    assert abs(ratio.value - true) < 4 * ratio.error < 0.04 * true
    assert found.verdict.startswith("These data tell little")


def test_the_report_is_in_the_unit_of_the_data(single) -> None:
    """Degrees in the text are those of [data], residuals and outliers too; the numbers of a Fit stay in rad.

    Of four outliers the three farthest are named, the farthest first, and they are why the model does not explain the data.
    """
    scene, table = single
    odd = table["a1"].copy()
    odd[[50, 150, 250, 350]] += [0.4, -0.5, 0.3, 0.6]  # rad
    data = scene.data.model_copy(update={"unit": "degrees"})
    fit = pp.fit(
        scene.replace(data=data), table | {"a1": np.degrees(odd)}, free="effects[1].coefficient", hold_out=table
    )
    words = fit.report().sentences
    assert words[0].startswith("4 samples stand out, the farthest: sample 351, column a1, by 3")
    assert [word for word in words[0].replace(",", "").split() if word.isdigit()] == ["4", "351", "151", "51"]
    assert words[1].endswith("because of the samples that stand out.")
    assert fit.verdict == words[1]
    assert f"Fitted: rms a1 {np.degrees(fit.train.rms['a1']):.3g} degrees" in words
    assert not any(" rad" in line or "angles and times" in line for line in words)


def test_noise_alone_is_no_motion() -> None:
    """White noise is refused in one line."""
    table = {"t": np.arange(600) / 100, "segment": np.zeros(600), "a1": np.random.default_rng(0).normal(0, 1, 600)}
    with pytest.raises(pp.InputError, match="the columns hold noise, or a motion too fast for them"):
        pp.fit(scene_of(1, data=ANGLE), table)


def test_noise_that_hides_the_rates_hides_no_motion() -> None:
    """With noise of 3 degrees five samples may show a start at rest as one that goes over the top; residuals are noise."""
    data = Data(**ANGLE.model_dump() | {"offsets": "zero"})
    truth = scene_of(1, Viscous(coefficient=1e-4), data=data, duration=6.0, rate=40)
    table = swings_of(truth, [1.0])
    for seed in (2, 3, 4):
        noise = np.random.default_rng(seed).normal(0, 0.05, len(table["t"]))
        found = pp.fit(truth, table | {"a1": table["a1"] + noise}, ["effects[1].coefficient", "model.rods[0].com"])
        assert found.train.rms["a1"] <= noise.std() * 1.001, seed  # the motion without the noise is one of the model's
        assert found.errors, seed


@pytest.mark.parametrize("offsets", ["free", "zero"])
@pytest.mark.parametrize("unit", [1e3, 60.0, 1 / 60, 1e-3])
def test_numbers_of_a_model_that_does_not_follow_have_no_errors(unit: float, offsets: str) -> None:
    """Times in ms, in minutes, or 60 or 1000 times too fast: the verdict names the units; nothing pretends to be known.

    In ms no motion comes to its end, so that with zeros that are not free no unknown changes any residual.
    """
    scene = scene_of(1, data=Data(**ANGLE.model_dump() | {"offsets": offsets}))
    table = swings_of(scene, [1.0])
    found = pp.fit(scene, table | {"t": table["t"] * unit})
    assert not found.errors
    assert not found.combinations
    assert set(found.undetermined) == set(found.values)
    assert ("times slower" if unit > 1 else "times faster") in found.verdict
    assert "check the units of angles and times" in found.verdict
    assert all(np.isfinite(value) for value in found.values.values())


def test_angles_that_no_body_gives_end_in_a_verdict() -> None:
    """Counted the other way at one joint they drive the mass to 0; in ms no motion comes to their end."""
    truth = scene_of(2, Viscous(coefficient=1e-4), data=ANGLES)
    table = swings_of(truth, [0.4, 0.3], [0.9, -0.5])
    for odd in ({"a2": 2 * table["a1"] - table["a2"]}, {"t": 1000 * table["t"]}):
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            found = pp.fit(truth, table | odd, ["model.rods[1].mass", "effects[1].coefficient"])
        assert "cannot explain the data at all" in found.verdict
        assert not found.errors


def test_a_fit_that_does_not_follow_writes_nothing(tmp_path: Path, capfd, monkeypatch) -> None:
    """With the report exit status 1; wrong usage is 2, and a fault of the data names their file alone."""
    table, scene, csv, out = (
        swings_of(scene_of(1, data=ANGLE), [1.0]),
        *(tmp_path / x for x in ("s.toml", "d.csv", "o.toml")),
    )
    scene_of(1, data=ANGLE).save(scene)
    rows = [f"{t / 1000},0,{a}" for t, a in zip(table["t"], table["a1"], strict=True)]
    endings = []
    for text, more in ((rows, ["--json"]), (rows, ["--hold-out-start", "0.2"]), ([*rows, "9,0,high"], [])):
        csv.write_text("\n".join(["t,segment,a1", *text]))
        monkeypatch.setattr("sys.argv", ["pendpin", "fit", str(scene), str(csv), "--out", str(out), *more])
        with pytest.raises(SystemExit) as end:
            main()
        endings.append((end.value.code, *capfd.readouterr()))
    assert [ending[0] for ending in endings] == [1, 2, 1]
    assert set(json.loads(endings[0][1])["values"].values()) == {None}
    assert endings[2][2].startswith(f"pendpin: {csv}: line 203, column a1")
    assert not out.exists()
