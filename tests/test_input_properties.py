"""Damaged scenes and URDFs, by the hundred: each loads to a model that moves, or is refused in one line."""

import copy
import json
import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bad_input import ROD
from laws import law
from pendpin import PendpinError, Trajectory, load_scene, simulate
from pendpin.dynamics.dynamics import Dynamics
from pendpin.errors import Note
from pendpin.model.build import build
from pendpin.scene import Chain, Solver, UrdfModel
from run_files import run_file

LONGER = settings.default.max_examples > 100  # a longer search has other examples each time
SETTINGS = settings(law(100), database=None, derandomize=not LONGER)

SCENE: dict[str, Any] = {
    "duration": 1.0,
    "model": {
        "kind": "chain",
        "rods": [
            {"length": 1.0, "mass": 1.0, "radius": 0.01, "payload": 0.1},
            {"length": 0.5, "mass": 2.0, "com": 0.2, "inertia": [0.2, 0.2, 0.1]},
        ],
        "copies": 2,
    },
    "start": {"positions": {"theta_1": 0.7, "phi_2": 0.4}, "velocities": [0.0] * 8},
    "effects": [
        {"kind": "gravity", "acceleration": 9.81, "direction": [0.0, 0.0, -1.0]},
        {"kind": "viscous", "coefficient": 0.1},
        {"kind": "spring", "stiffness": 1.0, "rest": 0.1, "joints": ["phi_1"]},
        {"kind": "motor", "joint": "theta_1", "amplitude": 1.0, "frequency": 2.0},
        {"kind": "push", "link": "rod_2", "force": [1.0, 0.0, 0.0], "point": 0.5},
        {"kind": "drag", "density": 1.0, "linear": 0.1, "wind": [1.0, 0.0, 0.0], "diameter": 0.1, "buoyancy": True},
        {"kind": "support", "amplitude": [0.1, 0.0, 0.0], "frequency": 3.0},
        {"kind": "rotation", "latitude": 48.0},
        {"kind": "dry_friction", "kinetic": 0.1, "static": 0.2},
        {"kind": "stop", "lower": -2.0, "upper": 2.0, "restitution": 0.5, "joints": ["theta_1"]},
    ],
    "solver": {"method": "dop853", "tolerance": 1e-8, "samples": 3},
}

SPECIAL = [
    0,
    -1,
    0.0,
    -0.0,
    1e308,
    -1e308,
    1e160,
    5e-324,
    1e-160,
    2**53 + 1,
    10**30,
    1e-14,
    True,
    "",
    "urdf",
    "nan",
    [],
    {},
]
junk = st.one_of(
    st.sampled_from(SPECIAL),
    st.floats(),
    st.integers(),
    st.text(max_size=5),
    st.lists(st.floats(), max_size=4),
    st.dictionaries(st.text(max_size=3), st.floats(), max_size=2),
)
number_text = st.one_of(
    st.sampled_from(["nan", "inf", "1e400", "-1", "0", "-0.0", "1e308", "1e160", "5e-324", "1e-160", "1,5", "", "1kg"]),
    st.floats().map(repr),
    st.text(st.characters(codec="utf-8", exclude_categories=["Cc"]), max_size=4),
)


def moves_or_is_refused(load: Callable[[], Dynamics]) -> bool:
    """Whether it loads: then the accelerations in a generic state are finite. If not, it says why in one line."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", Note)
            dynamics = load()
            state = np.sin(1.0 + np.arange(len(dynamics.model.joints)))
            assert np.isfinite(dynamics.acceleration(0.0, state, state)).all()
    except PendpinError as error:
        message = str(error)
    else:
        return True
    assert message.isprintable()
    assert len(message) < 2000
    return False


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The paths of everything inside nested tables and lists."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [place for key, part in inner for place in [(*path, key), *places(part, (*path, key))]]


@st.composite
def damaged_scenes(draw: st.DrawFn) -> dict[str, Any]:
    """The scene above with one or two values replaced, left out, repeated, or added."""
    scene = json.loads(json.dumps(SCENE))
    for _ in range(draw(st.integers(1, 2))):
        *path, last = draw(st.sampled_from(places(scene) or [("duration",)]))
        table = scene
        for key in path:
            table = table[key]
        match draw(st.sampled_from(["replace", "replace", "leave out", "repeat", "add"])):
            case "leave out" if last in table or isinstance(table, list):
                del table[last]
            case "repeat" if isinstance(table, list):
                table.append(table[last])
            case "add" if isinstance(table, dict):
                table[draw(st.text(max_size=5))] = draw(junk)
            case _:
                table[last] = draw(junk)
    return scene


def toml(value: Any) -> str:
    """A value as TOML, tables inline."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{text(key)} = {toml(part)}" for key, part in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return text(value) if isinstance(value, str | bool) else repr(value)


def text(value: str | bool) -> str:
    """Text in quotes, or true or false: the same in JSON as in TOML."""
    return json.dumps(value, ensure_ascii=False)


@st.composite
def damaged_trees(draw: st.DrawFn) -> str:
    """The URDF with elements left out, repeated elsewhere, or given other attributes."""
    robot = ElementTree.fromstring(ROD)
    for _ in range(draw(st.integers(1, 2))):
        parents = {child: parent for parent in robot.iter() for child in parent}
        if not parents:
            break
        element = draw(st.sampled_from(list(parents)))
        keys = sorted(element.attrib)
        match draw(st.sampled_from(["set", "set", "set", "clear", "leave out", "repeat"])):
            case "set" if keys:
                key = draw(st.sampled_from(keys))
                parts = element.get(key, "").split()
                parts[draw(st.integers(0, len(parts) - 1)) if parts else slice(0)] = draw(number_text)
                element.set(key, " ".join(parts))
            case "clear" if keys:
                del element.attrib[draw(st.sampled_from(keys))]
            case "repeat":
                draw(st.sampled_from([robot, *parents])).append(copy.deepcopy(element))
            case _:
                parents[element].remove(element)
    return ElementTree.tostring(robot, encoding="unicode")


@st.composite
def damaged_texts(draw: st.DrawFn) -> str:
    """The URDF with pieces of its text left out, doubled, swapped, or replaced."""
    pieces = re.findall(r"<|>|\"|[^<>\"]+", ROD.split("?>")[1])
    for _ in range(draw(st.integers(1, 2))):
        first, second = draw(st.integers(0, len(pieces) - 1)), draw(st.integers(0, len(pieces) - 1))
        match draw(st.sampled_from(["leave out", "double", "swap", "replace"])):
            case "leave out":
                pieces[first : min(second + 1, first + 9)] = []
            case "double":
                pieces[second:second] = pieces[first : first + 9]
            case "swap":
                pieces[first], pieces[second] = pieces[second], pieces[first]
            case _:
                pieces[first] = draw(number_text)
    return "".join(pieces)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for all examples: each writes the same file anew."""
    return tmp_path_factory.mktemp("damaged")


@SETTINGS
@given(scene=damaged_scenes())
def test_damaged_scenes(folder: Path, scene: dict[str, Any]) -> None:
    """From the file to the first instant of its run."""
    path = folder / "scene.toml"
    path.write_text("".join(f"{text(key)} = {toml(part)}\n" for key, part in scene.items()), encoding="utf-8")

    def load() -> Dynamics:
        scene = load_scene(path)
        if isinstance(scene.model, Chain) and scene.model.count > 50:
            scene = scene.model_copy(update={"model": scene.model.model_copy(update={"copies": 1})})
        simulate(scene.model_copy(update={"duration": 0.0, "solver": Solver(engine=scene.solver.engine)}))
        return Dynamics(build(scene.model), ())

    moves_or_is_refused(load)


@SETTINGS
@given(text=damaged_trees() | damaged_texts())
def test_damaged_urdfs(folder: Path, text: str) -> None:
    """From the file to the first acceleration."""
    path = folder / "rod.urdf"
    path.write_text(text, encoding="utf-8")
    moves_or_is_refused(lambda: Dynamics(build(UrdfModel(path=path)), ()))


@st.composite
def damaged_runs(draw: st.DrawFn) -> bytes:
    """A saved run with bytes changed, left out, or put in."""
    data = bytearray(run_file())
    for _ in range(draw(st.integers(1, 3))):
        at, length = draw(st.integers(0, len(data) - 1)), draw(st.integers(0, 40))
        data[at : at + length] = draw(st.binary(max_size=8))
    return bytes(data)


@SETTINGS
@given(data=damaged_runs())
def test_damaged_runs(folder: Path, data: bytes) -> None:
    """A damaged file is refused as such, unless the damage is where nobody looks."""
    path = folder / "run.npz"
    path.write_bytes(data)
    try:
        loaded = Trajectory.load(path)
    except PendpinError as error:
        message = str(error)
    else:
        message = str(path) if loaded.sound == len(loaded.t) else "unsound"
    assert message.startswith(str(path))
    assert message.isprintable()


def test_undamaged_scene_and_urdf_move(folder: Path) -> None:
    """What the damage starts from is sound."""
    (folder / "scene.toml").write_text("".join(f"{key} = {toml(part)}\n" for key, part in SCENE.items()))
    (folder / "rod.urdf").write_text(ROD)
    assert moves_or_is_refused(lambda: Dynamics(build(load_scene(folder / "scene.toml").model), ()))
    assert moves_or_is_refused(lambda: Dynamics(build(UrdfModel(path=folder / "rod.urdf")), ()))
