"""Laws that walk all effects and all measures: docs, test cases, fits and batches know each of them."""

import re
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

import pendpin as pp
import scene_effects
from effect_cases import EFFECTS, ROD, ZERO
from pendpin import effects as fx
from pendpin.fitting.data import sensors_of
from pendpin.fitting.parameters import free_parameters
from pendpin.fitting.problem import bind_pendulum
from pendpin.model.build import build
from pendpin.runs.batches import Motions
from pendpin.runs.simulate import run_to_setting
from pendpin.scene import Data
from pendpin.sweeps.measures import MEASURES, STATISTICS, evaluate_measure, measure

DOCS = Path(__file__).parents[1] / "docs"
BRANCHES = [get_args(branch)[0] for branch in get_args(get_args(fx.AnyEffect)[0])]  # the last is any instance
CLASSES = {kind.model_fields["kind"].default: kind for kind in BRANCHES[:-1]}
STANDS_FOR_OTHERS = "as_written"  # in a scene it is replaced by effects that have cases of their own


def test_the_walk_meets_every_effect_that_a_scene_may_name() -> None:
    """The JSON schema of a scene, which is made without this walk, has the same kinds."""
    schema = pp.Scene.model_json_schema()
    names = [branch["$ref"].rpartition("/")[2] for branch in schema["properties"]["effects"]["items"]["oneOf"]]
    assert set(CLASSES) == {schema["$defs"][name]["properties"]["kind"]["const"] for name in names}


@pytest.mark.parametrize("kind", CLASSES)
def test_the_docs_describe_every_parameter_of_an_effect(kind: str) -> None:
    """Under a heading with the effect's name."""
    text = (DOCS / "effects.md").read_text()
    [section] = re.findall(rf"^## {kind.replace('_', ' ').capitalize()}\n(.*?)(?=^## |\Z)", text, re.M | re.S)
    assert [name for name in CLASSES[kind].model_fields if name != "kind" and f"`{name}`" not in section] == []


@pytest.mark.parametrize("kind", [kind for kind in CLASSES if kind != STANDS_FOR_OTHERS])
def test_the_laws_of_effects_have_a_case_of_each(kind: str) -> None:
    """One that acts, and where strengths are declared one of strength 0, which changes no bit."""
    assert kind in {effect.kind for effect in EFFECTS.values()} | set(scene_effects.KINDS)
    if CLASSES[kind].strengths:
        assert kind in {effect.kind for effect in ZERO.values()}


@pytest.mark.parametrize("name", [name for name, effect in EFFECTS.items() if effect.symbolic])
def test_a_fit_can_free_every_number_of_an_effect(name: str) -> None:
    """Each changes a parameter of the equations: a fit has a derivative by it. A direction's length counts for nothing."""
    effect = EFFECTS[name]
    scene = pp.Scene(duration=1.0, model=pp.Chain(rods=[ROD]), effects=[effect])
    keys = [f"effects[0].{key}" for key in effect.parameters if key != "csv" and getattr(effect, key) is not None]
    free = free_parameters(scene, keys)
    sensors = sensors_of(Data(columns={"a": ("theta",), "b": ("phi",)}), build(scene.model))
    bound = bind_pendulum(scene, free, sensors, 0.0, 1.0, 0.05).at(free.start)
    directions = bound.variations.equations.directions[: len(free.keys)]
    assert len(free.keys) >= len(keys)
    idle = {key for key, direction in zip(free.keys, directions, strict=True) if not direction.shared}
    assert idle == ({"effects[0].direction[2]"} if name == "gravity" else set())


@pytest.mark.parametrize("name", [name for name, effect in EFFECTS.items() if isinstance(effect, fx.JointEffect)])
def test_what_only_brakes_declares_its_resistances(name: str) -> None:
    """A torque whose power is below 0 at all rates declares by which numbers; no other one does."""
    effect, random = EFFECTS[name], np.random.default_rng(1)
    states = random.normal(size=(200, 2, len(effect.on or "ab")))
    each = effect.of_joints(np.ones(1))
    given = {} if each is None else {"each": each}
    power = np.array([np.sum(effect.torques(t, q, v, **given) * v) for t, (q, v) in enumerate(states)])
    assert bool(effect.resistances) == bool((power < 0).all())


@pytest.mark.parametrize("name", [*MEASURES, *(f".{statistic}" for statistic in STATISTICS)])
def test_the_docs_name_every_measure(name: str) -> None:
    assert f"`{name}`" in (DOCS / "sweep.md").read_text().partition("## What is measured")[2].partition("\n## ")[0]


@pytest.fixture(scope="module")
def runs() -> tuple[pp.Trajectory, pp.Trajectory]:
    """A double pendulum that turns over, and a looser run of it."""
    rod = pp.Rod(length=1.0, mass=1.0, radius=0.02)
    start = pp.Start(positions={"theta_1": 2.5, "phi_1": 0.2}, velocities={"theta_1": 6.0, "phi_2": 1.0})
    model = pp.Chain(rods=[rod, rod])
    scene = pp.Scene(duration=1.0, model=model, start=start, effects=[fx.Gravity()], solver=pp.Solver(samples=41))
    return run_to_setting(scene), run_to_setting(scene.with_solver(tolerance=1e-6))


@pytest.mark.parametrize("name", [*MEASURES, *(f"theta_2.{statistic}" for statistic in STATISTICS)])
@pytest.mark.parametrize("spread", ["", ".spread"])
def test_a_measure_is_the_same_of_a_run_and_of_a_batch(name: str, spread: str, runs: tuple[pp.Trajectory, ...]) -> None:
    """Whatever is declared for batches gives, to rounding, what the function gives for a run.

    But for the spread of a passage: of a run it is how far the angles have differed so far, at least as much. What is
    searched between samples is the same to the tolerance of the run, 1e-10, or is left to the whole run; its spread, of
    samples that are off by 1e-8 themselves, to a share of them.
    """
    if spread and MEASURES.get(name, measure("swing")).two:
        return
    of_name, model = measure(name + spread), pp.bind(pp.Scene(**runs[0].scene)).model
    flips = [evaluate_measure(MEASURES["flip_time"], run, run) for run in runs]
    batch = [
        Motions([model], run.t, run.q[None], run.v[None], np.array([flip]), np.zeros(1))
        for run, flip in zip(runs, flips, strict=True)
    ]
    if of_name.of_motion:
        values = of_name.of_motion(*batch[: 1 + of_name.two])
    else:
        return  # a batch computes whole runs for it
    if spread and MEASURES.get(name, of_name).spread:
        assert 0 < values[0] <= evaluate_measure(of_name, *runs) < 1e-7
        return
    if of_name.between:
        values = np.where(np.isnan(values), evaluate_measure(of_name, *runs), values)
    rtol, atol = (0.2, 1e-9) if of_name.between and spread else (0, 1e-10) if of_name.between else (1e-12, 1e-14)
    np.testing.assert_allclose(values, [evaluate_measure(of_name, *runs)], rtol=rtol, atol=atol)
