"""Varying and writing scenes: key paths, replace, save; messages for mistakes; what help() and the schema show."""

import json
import pydoc
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.effects import Effect
from pendpin.errors import Note, written
from pendpin.ground.arguments import parsed
from pendpin.ground.records import Record
from pendpin.scene import builtin_scene, unit_of_key
from scene_generator import case_of

EXAMPLES = Path(__file__).parents[1] / "examples"
ONE = {"kind": "chain", "rods": [{"length": 1.0, "mass": 1.0}]}
names = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=8)


def records(base: type[Record] = Record) -> list[type[Record]]:
    """All records of pendpin's own that a scene is made of."""
    found = [cls for cls in base.__subclasses__() if cls.__module__.startswith("pendpin.")]
    return [*found, *(inner for cls in found for inner in records(cls))]


@given(st.lists(names | st.integers(0, 10**6), max_size=5), names)
def test_key_paths_are_read_as_they_are_written(rest: list[str | int], first: str) -> None:
    """Whatever the names hold."""
    assert parsed(written((first, *rest))) == (first, *rest)


@pytest.mark.parametrize(
    "text", ["", ".", "a.", ".a", "a..b", "[0]", "a[", "a[x]", "a[1]b", "a b", "a.'b", "a[-1]", 'a."\\x"']
)
def test_no_key_path(text: str) -> None:
    """Text that is none is refused with an example of one."""
    with pytest.raises(pp.InputError, match="is not a"):
        parsed(text)


def test_a_record_is_no_list() -> None:
    """One rod in place of a list of rods is named as it was given; the required value is named first."""
    with pytest.raises(pp.InputError, match=r"^rods: Rod\(length=1.0, mass=1.0\) is not a list$"):
        pp.Chain(rods=pp.Rod(length=1.0, mass=1.0))
    with pytest.raises(pp.InputError, match=r"Viscous\(coefficient=..., ...\)"):
        pp.effects.Viscous(0.1)


@law(100)
@given(st.integers(0, 10**9), names)
def test_save_and_load_are_inverse(tmp_path_factory: pytest.TempPathFactory, number: int, joint: str) -> None:
    """Every scene that TOML can hold comes back equal, whatever its joints are called."""
    folder = tmp_path_factory.mktemp("saved")
    try:
        scene = pp.Scene(**case_of(1, number, folder).scene).replace({f"start.positions.{written((joint,))}": 0.1})
    except pp.InputError:
        return
    assert pp.load_scene(scene.save(folder / "scene.toml")) == scene


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda p: p.stem)
def test_examples_are_saved_and_loaded(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the files that they name, relative to where they were read."""
    monkeypatch.chdir(EXAMPLES)
    scene = pp.load_scene(path.name)
    assert pp.load_scene(scene.save(tmp_path / "scene.toml")) == scene == pp.load_scene(path)


def test_code_is_not_saved(tmp_path: Path) -> None:
    """An effect of one's own is no text."""

    class Mine(pp.effects.Gravity):
        """A subclass."""

    scene = pp.Scene(model=ONE, effects=[Mine()])
    with pytest.raises(pp.InputError, match="Mine cannot be written to TOML"):
        scene.save(tmp_path / "scene.toml")
    changed = scene.replace({"effects[0].acceleration": 1.0})
    assert type(changed.effects[0]) is Mine
    with pytest.raises(pp.InputError, match=r"effects\[0\]: acceleration: -1.0 is below 0"):
        scene.replace({"effects[0].acceleration": -1.0})


def test_a_copy_of_a_record_keeps_nothing_that_was_computed_of_the_old_fields() -> None:
    """A rod's inertia, and which rods a chain's rods hang on, are those of the new fields."""
    rod = pp.Rod(length=1.0, mass=1.0)
    assert rod.properties.m == 1.0
    assert rod.model_copy(update={"mass": 2.0}).properties == pp.Rod(length=1.0, mass=2.0).properties
    chain = pp.Chain(rods=[rod, rod, rod])
    assert len(chain.parents) == 3
    assert chain.model_copy(update={"rods": (rod, rod)}).parents == pp.Chain(rods=[rod, rod]).parents


def test_replace_by_key_path_and_by_field() -> None:
    """The rest stays, and the scene that was there too."""
    scene = pp.load_scene(EXAMPLES / "crane.toml")
    before = scene.model_dump()
    other = scene.replace({"start.velocities.theta_1": 0.5, "model.rods[0].mass": np.float64(2)}, duration=5.0)
    assert (other.duration, other.start.velocities, other.model.rods[0].mass) == (5.0, {"theta_1": 0.5}, 2.0)
    assert other.model.rods[1:] == scene.model.rods[1:]
    assert scene.model_dump() == before
    assert scene.replace() == scene


REFUSED: list[tuple[str, Any]] = [
    ("duration", -3),
    ("duration", "long"),
    ("model.rods[0].mass", -1.0),
    ("model.rods[0].length", 0.0),
    ("model.rods[0].masss", 1.0),
    ("model.kind", "chan"),
    ("model.copies", 0),
    ("effects[0].kind", "gravty"),
    ("effects[0].acceleration", float("nan")),
    ("solver.method", "dop583"),
    ("solver.tolerance", 1e-30),
    ("solver.step", 0.1),
    ("start.positions.theta", "45"),
    ("start.unit", "degree"),
    ("start.times", [0.0]),
    ("sover", {}),
]


@pytest.mark.parametrize(("path", "value"), REFUSED, ids=lambda x: str(x))
def test_replace_refuses_what_the_constructor_refuses_with_the_same_words(path: str, value: Any) -> None:
    """The same data, written out by hand."""
    tables: dict[str, Any] = {
        "model": {"kind": "chain", "rods": [{"length": 1.0, "mass": 1.0}]},
        "start": {"positions": {"theta": 0.1}},
        "effects": [{"kind": "gravity"}],
    }
    scene, place = pp.Scene(**tables), parsed(path)
    inner: Any = tables
    for part in place[:-1]:
        inner = inner.setdefault(part, {}) if isinstance(inner, dict) else inner[part]
    inner[place[-1]] = value
    with pytest.raises(pp.InputError) as constructed:
        pp.Scene(**tables)
    with pytest.raises(pp.InputError) as replaced:
        scene.replace({path: value})
    assert str(replaced.value) == str(constructed.value)


FIELDS = sorted({name for cls in records() for name in cls.model_fields} - {"model", "effects"})
NUMBERS = (-3, 0, 1, 2.5, 1e-30, 1e200, 10**400, float("nan"), float("inf"), True, None)
TEXTS = ("", "45", "gravity", "dry_friction", "chain", "urdf", "degrees", "dop853")
TABLES = ([], [1.0], [1.0, 2.0, 3.0], [-1, 0, 1], {}, {"theta_1": 0.1}, {"kind": "drag"})
VALUES = st.sampled_from((*NUMBERS, *TEXTS, *TABLES))


def places_in(data: Any, place: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    """The key paths of everything in nested tables and lists."""
    inner = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list | tuple) else ()
    return [path for key, value in inner for path in ((*place, key), *places_in(value, (*place, key)))]


def changed_by_hand(data: Any, path: tuple[str | int, ...], value: Any) -> Any:
    """The same data with one value replaced."""
    if not path:
        return value
    copied = dict(data) if isinstance(data, dict) else list(data)
    copied[path[0]] = changed_by_hand(copied[path[0]] if len(path) > 1 else None, path[1:], value)  # pyright: ignore
    return copied


def made(make: Callable[[], pp.Scene]) -> pp.Scene | str:
    """A scene, or the line that refuses it."""
    try:
        return make()
    except pp.InputError as error:
        return str(error)


@law(300)
@given(st.data(), st.integers(0, 10**9), VALUES, st.none() | st.sampled_from(FIELDS) | names)
def test_replace_and_constructor_agree(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject, number: int, value: Any, key: str | None
) -> None:
    """Any value at any place of any scene: both refuse it with the same line, or both make the same scene."""
    tables = case_of(2, number, tmp_path_factory.getbasetemp()).scene
    scene = made(lambda: pp.Scene(**tables))
    if isinstance(scene, str):
        return
    place = data.draw(st.sampled_from(places_in(tables)))
    if key is not None:  # a key beside it, or in it, known there or not
        place = (*(place if isinstance(place[-1], int) else place[:-1]), key)
    here: Any = tables
    for part in place[:-1]:
        here = here[part]
    if not isinstance(here, dict) and not isinstance(place[-1], int):
        return
    constructed = made(lambda: pp.Scene(**changed_by_hand(tables, place, value)))
    replaced = made(lambda: scene.replace({written(place): value}))
    if isinstance(replaced, str) and len(place) == 1 and place[0] not in pp.Scene.model_fields:
        replaced, constructed = (line.partition(";")[0] for line in (replaced, constructed))  # replace may say where
    assert replaced == constructed


@pytest.mark.parametrize(
    ("path", "place"),
    [("length", r"model\.rods\[0\]\.length \(or 1 more"), ("positions.theta_1", r"start\.positions\.theta_1\?")],
)
def test_a_part_of_a_key_path_is_completed(path: str, place: str) -> None:
    """A name that stands deeper in the scene: the line says where."""
    scene = pp.Scene(model={**ONE, "copies": 1, "rods": ONE["rods"] * 2}, start={"positions": {"theta_1": 0.1}})
    with pytest.raises(pp.InputError, match=f"unknown key; did you mean {place}"):
        scene.replace({path: 1.0})


@pytest.mark.parametrize(
    ("path", "says"),
    [
        ("model.rods[1].mass", r"model.rods\[1\]: model.rods is a list of 1"),
        ("model.rods.mass", "model.rods.mass: model.rods is a list of 1"),
        ("start.positions[0]", r"start.positions\[0\]: start.positions is a table of names"),
        ("model.rods[0].inertia[1]", "nothing is given there; set .* as a whole"),
        ("duration.s", "duration: 10.0 has no parts; set duration as a whole"),
    ],
)
def test_key_paths_that_lead_nowhere(path: str, says: str) -> None:
    """Say where they end."""
    with pytest.raises(pp.InputError, match=says):
        pp.Scene(model=ONE).replace({path: 1.0})


def test_what_was_meant() -> None:
    """Unknown keys, kinds, joints and robots get the nearest name in the message."""
    for make, meant in [
        (lambda: pp.Rod(length=1.0, masss=1.0), "'mass'"),
        (lambda: pp.Scene(model=ONE, effects=[{"kind": "gravty"}]), "'gravity'"),
        (lambda: pp.Scene(model=ONE, effects=[{"kind": "drag", "winnd": (0, 0, 0)}]), "'wind'"),
        (
            lambda: pp.bind(pp.Scene(model=ONE, effects=[{"kind": "viscous", "coefficient": 1, "joints": ["teta"]}])),
            "'theta'",
        ),
        (lambda: pp.UrdfModel("ur55").file, "'ur5'"),
    ]:
        with pytest.raises(pp.InputError, match=f"did you mean {meant}"):
            make()


def test_degrees() -> None:
    """The unit turns angles and their rates, and no slides."""
    start = pp.Start(positions={"theta": 45.0}, velocities={"phi": 180.0}, unit="degrees")
    run = pp.simulate(builtin_scene().replace(start=start), duration=0.0)
    np.testing.assert_allclose(run.q[0], [np.pi / 4, 0.0], rtol=1e-15)
    np.testing.assert_allclose(run.v[0], [0.0, np.pi], rtol=1e-15)


def test_slips_are_noted() -> None:
    """Not refused: said as warnings, and by the commands as notes."""
    scene = builtin_scene().replace({"start.positions.theta": 45.0})
    with pytest.warns(Note, match="theta: 45 rad is more than a whole turn"):
        pp.simulate(scene, duration=0.1)
    stop = pp.effects.Stop(upper=30.0, joints=["theta"])
    with pytest.warns(Note, match=r"effects\[1\].upper: 30 rad is more than a whole turn"):
        pp.simulate(builtin_scene().replace(effects=[*builtin_scene().effects, stop]), duration=0.1)
    thin = pp.Scene(model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]), effects=[pp.effects.Drag()], duration=0.1)
    with pytest.warns(Note, match="drag does not act on rod_1, of radius 0"):
        pp.simulate(thin)
    push = pp.effects.Push(link="rod_1", force=(1.0, 0.0, 0.0), point=2.0)
    with pytest.warns(Note, match=r"effects\[1\].point: 2 m is beyond the ends of rod, 0 to 1 m"):
        pp.simulate(builtin_scene().replace(effects=[*builtin_scene().effects, push]), duration=0.1)
    with pytest.warns(Note, match="nothing acts"):
        pp.simulate(builtin_scene().replace(effects=[]), duration=0.1)


def test_one_joint_by_two_names() -> None:
    """theta and theta_1 of a single rod are one."""
    with pytest.raises(pp.InputError, match="theta and theta_1 are the same joint"):
        pp.simulate(builtin_scene().replace({"start.positions.theta_1": 0.1}))


def test_times_and_samples() -> None:
    """A path works; times are the scene's own; a run to other times is the same run."""
    run = pp.simulate(EXAMPLES / "single_rod.toml", duration=2.0, samples=11)
    np.testing.assert_array_equal(run.t, np.linspace(0.0, 2.0, 11))
    scene = pp.load_scene(EXAMPLES / "single_rod.toml").replace({"start.time": 3.0})
    later = pp.simulate(scene, times=np.array([3.2, 4.0, 5.0]))
    np.testing.assert_array_equal(later.t, [3.2, 4.0, 5.0])
    np.testing.assert_allclose(later.q, run.q[[1, 5, 10]], atol=1e-9)
    for bad, says in [
        ({"times": [3.2, 3.1]}, "does not come after"),
        ({"times": [2.0]}, "outside the run"),
        ({"times": [9.0], "duration": 1.0}, "outside the run"),
        ({"times": [3.5], "samples": 3}, "leave one of them out"),
        ({"times": []}, "at least one"),
        ({"times": "soon"}, "not numbers"),
        ({"times": [np.nan]}, "finite"),
    ]:
        with pytest.raises(pp.InputError, match=says):
            pp.simulate(scene, **bad)
    with pytest.raises(pp.InputError, match="5 is not a Scene"):
        pp.simulate(5)  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize(
    "cls", [cls for cls in records() if "dynamics" not in cls.__module__], ids=lambda c: c.__name__
)
def test_every_field_is_described(cls: type[Record]) -> None:
    """With its unit, in help() and in the JSON schema; records of pendpin.dynamics belong to one run, not to a user."""
    shown = re.sub(r" from '[^']*'", "", pydoc.plain(pydoc.render_doc(cls)))  # the path of a module is the machine's
    assert "Annotated[" not in shown
    assert len(shown) < (6000 if issubclass(cls, Effect) else 4000)
    for name, field in cls.model_fields.items():
        assert field.description, name
        assert f"{name}: {field.description}" in shown


def test_the_schema_describes_every_field() -> None:
    """As editors show it."""
    schema = pp.Scene.model_json_schema()
    tables = [schema, *schema["$defs"].values()]
    assert all(field.get("description") for table in tables for field in table.get("properties", {}).values())
    assert "Fields:" not in json.dumps(schema)


def test_the_public_names_and_nothing_else() -> None:
    """What completion shows."""
    assert dir(pp) == sorted(pp.__all__)
    assert all(getattr(pp, name) for name in pp.__all__)


def test_the_built_in_scene_is_the_one_that_the_readme_runs() -> None:
    """README's Python lines write the same scene on a rod of their own: one start, gravity, 10 s, to rounding one motion."""
    start = pp.Start(positions={"theta": 0.7, "phi": 0.4}, velocities={"theta": 1.3, "phi": -0.8})
    rod = pp.Rod(length=1.0, mass=1.0, radius=0.01)
    scene = pp.Scene(duration=10.0, model=pp.Chain(rods=[rod]), start=start, effects=[pp.effects.Gravity()])
    one, other = (pp.simulate(x, tolerance=1e-12, samples=11) for x in (scene, builtin_scene()))
    np.testing.assert_allclose(other.q, one.q, rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        *(("duration", "s"), ("start.positions.theta_1", "degrees"), ("start.velocities[1]", "degrees/s")),
        *(("model.rods[0].com", "m"), ("model.rods[0].payload", "kg"), ("model.rods[0].inertia[2]", "kg m²")),
        *(("effects[0].acceleration", "m/s²"), ("effects[1].stiffness", "N m²"), ("effects[2].stiffness", "N/m")),
        *(("effects[2].point[0]", "m"), ("effects[3].coefficient", ""), ("effects[3].linear", "N s/m²")),
        *(("effects[0].direction[2]", ""), ("effects[4].latitude", "degrees"), ("model.copies", "")),
    ],
)
def test_a_number_has_the_unit_with_which_its_description_begins(key: str, unit: str) -> None:
    anchor = fx.Anchor(link="rod", point=(0, 0, 0), stiffness=1.0)
    effects = [fx.Gravity(), fx.Bending(stiffness=1.0), anchor, fx.Drag(), fx.Rotation(latitude=45.0)]
    rods = [pp.Rod(length=1.0, mass=1.0)]
    assert unit_of_key(key, pp.Scene(model=pp.Chain(rods=rods), start={"unit": "degrees"}, effects=effects)) == unit
