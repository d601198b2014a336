"""`pendpin reference`: what other engines load and compute agrees with the numbers, and a wrong number is found."""

import importlib.util
import json
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import pendpin as pp
from pendpin.cli import main
from pendpin.model.bodies import tree_of
from pendpin.model.build import build
from pendpin.verification.agreement.reference import STATES, reference_states, write_reference

ENGINES = Path(__file__).parents[1] / "examples" / "engines"
GRAVITY = pp.effects.Gravity()
MIXED = (
    pp.Rod(length=1.0, mass=1.0, radius=0.05),
    pp.Rod(length=0.5, mass=0.2),
    pp.Rod(length=0.3, mass=0.4, payload=0.1, radius=0.01),
    pp.Rod(length=0.8, mass=2.0, com=0.3, inertia=(0.1, 0.12, 0.03)),
    pp.Rod(length=1.0, mass=0.5, radius=0.1),
)
HINGES = (
    MIXED[0],
    pp.Rod(length=0.5, mass=0.2, radius=0.02, joint="hinge"),
    pp.Rod(length=0.8, mass=2.0, com=0.3, inertia=(0.1, 0.12, 0.03), joint="hinge", axis="y", hangs_on="rod_1", at=0.4),
    pp.Rod(length=0.3, mass=0.4, payload=0.1, radius=0.01),
)
SCENES = {
    name: pp.Scene(model=model, effects=[GRAVITY], start=pp.Start(positions=start), duration=duration)
    for name, model, start, duration in (
        ("rod", pp.Chain(rods=[MIXED[0]]), {"phi": 0.4}, 0.5),
        ("double", pp.Chain(rods=MIXED[2:4]), {"theta_2": 0.4}, 2.0),
        ("tree", pp.Chain(rods=HINGES), {"phi_3": 0.4}, 1.0),
        ("ten mixed rods", pp.Chain(rods=MIXED, copies=2), {}, 0.5),
        ("ur5", pp.UrdfModel("ur5"), {}, 0.5),
        ("panda", pp.UrdfModel("panda"), {}, 0.1),
    )
}
DAMPED = pp.Scene(
    model=pp.Chain(rods=MIXED[2:4]),
    effects=[GRAVITY, pp.effects.Viscous(coefficient=0.2, joints=["theta_1"]), pp.effects.Viscous(coefficient=0.1)],
    duration=0.5,
)
PACKAGES = {"pinocchio": "pinocchio", "mujoco": "mujoco", "drake": "pydrake"}


class Folders(dict[str, Path]):
    """The folder of each scene, written when it is first asked for."""

    def __init__(self, top: Path) -> None:
        super().__init__()
        self.top = top

    def __missing__(self, name: str) -> Path:
        self[name] = self.top / name.replace(" ", "-")
        write_reference(SCENES[name], self[name])
        return self[name]


@pytest.fixture(scope="module", name="folders")
def written(tmp_path_factory: pytest.TempPathFactory) -> Folders:
    """A folder for each scene."""
    return Folders(tmp_path_factory.mktemp("reference"))


def loaded(name: str, path: Path) -> ModuleType:
    """A Python file as a module."""
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(params=PACKAGES, name="engine")
def engine_of(request: pytest.FixtureRequest) -> Iterator[ModuleType]:
    """The function of each engine that examples/engines has."""
    if find_spec(PACKAGES[request.param]) is None:
        pytest.skip(f"{request.param} is not installed: CI's last step installs it")
    yield loaded("engine", ENGINES / f"{request.param}_engine.py")
    sys.modules.pop("engine", None)


def folder_test(folder: Path, engine: ModuleType) -> ModuleType:
    """The folder's own test file, with an engine."""
    sys.modules["engine"] = engine
    return loaded("test_reference_in_a_folder", folder / "test_reference.py")


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (name in ("ten mixed rods", "panda", "ur5"))) for name in SCENES],
)
def test_the_engine_agrees_at_every_state(name: str, folders: Folders, engine: ModuleType) -> None:
    """Accelerations, mass matrix, wrenches and energies, through the folder's own test."""
    file = folder_test(folders[name], engine)
    for number in range(STATES):
        file.test_state(number)


def test_two_dampings_are_carried_by_mjcf_alone(tmp_path: Path, engine: ModuleType) -> None:
    """Drake takes one of the two of SDF's universal joint, and engines ignore those of a URDF: neither is written."""
    folder = Path(write_reference(DAMPED, tmp_path / "damped").data["path"])
    assert {file.name for file in folder.glob("model.*")} == {"model.xml"}
    file = folder_test(folder, engine)
    if "mujoco" in str(engine.__file__):
        file.test_state(0)
    else:
        with pytest.raises(ValueError, match=r"mujoco_engine\.py"):
            file.test_state(0)


@pytest.mark.parametrize("quantity", ["a", "mass_matrix", "wrench", "kinetic", "potential"])
def test_a_wrong_number_is_found(quantity: str, folders: Folders, engine: ModuleType) -> None:
    """A number that is off by a millionth of the largest one of its quantity."""
    file = folder_test(folders["double"], engine)
    if quantity == "potential" and "drake" in str(engine.__file__):
        return  # its engine does not return it
    state = file.REFERENCE["states"][3]
    values = np.array(state[quantity])
    last = values.size - 2 if quantity == "wrench" else values.size - 1  # the moment about the second axis
    values.flat[last] += 1e-6 * np.abs(values).max()
    state[quantity] = values.tolist()
    with pytest.raises(AssertionError, match=f"{quantity} is off by"):
        file.test_state(3)


@pytest.mark.parametrize("planted", ["ixx", "mass", "xyz"])
def test_a_wrong_model_is_found(planted: str, folders: Folders, tmp_path: Path) -> None:
    """An inertia, a mass or a centre of mass that is off by 1 in 10,000 in the URDF."""
    engine = loaded("engine", ENGINES / "pinocchio_engine.py")
    text = (folders["rod"] / "model.urdf").read_text()
    scene = SCENES["rod"].replace(
        {
            "ixx": {"model.rods[0].inertia": (0.0840, 0.0839583, 0.00125)},
            "mass": {"model.rods[0].mass": 1.0001},
            "xyz": {"model.rods[0].com": 0.50005},
        }[planted]
    )
    other = Path(write_reference(scene, tmp_path / "other").data["path"])
    (tmp_path / "other" / "model.urdf").write_text(text)
    file = folder_test(other, engine)
    with pytest.raises(AssertionError, match="is off by"):
        file.test_state(0)
    sys.modules.pop("engine", None)


@pytest.mark.skipif(find_spec("pydrake") is None, reason="Drake is not installed: CI's last step installs it")
@pytest.mark.parametrize("name", ["rod", "double", "tree", "ur5"])
def test_drake_loads_the_sdf_to_the_same_model(name: str, folders: Folders) -> None:
    """The universal joint is one joint there; mass matrix and accelerations are those of the JSON."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    reference = json.loads((folders[name] / "reference.json").read_text())
    plant = MultibodyPlant(time_step=0.0)
    Parser(plant).AddModelsFromString((folders[name] / "model.sdf").read_text(), "sdf")
    plant.mutable_gravity_field().set_gravity_vector(reference["conventions"]["gravity"])
    plant.Finalize()
    joints = [plant.get_joint(index) for index in plant.GetJointIndices()]
    places = {}
    for joint in joints:
        for i, part in enumerate(joint.name().split("__")[: joint.num_velocities()]):
            places[part] = joint.velocity_start() + i
    at = [places[joint] for joint in reference["joints"]]
    context = plant.CreateDefaultContext()
    for state in reference["states"]:
        q, v = np.zeros((2, len(at)))
        q[at], v[at] = state["q"], state["v"]
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)
        M = plant.CalcMassMatrix(context)[np.ix_(at, at)]
        a = plant.EvalTimeDerivatives(context).get_generalized_velocity().CopyToVector()[at]
        assert np.abs(M - state["mass_matrix"]).max() < 1e-12 * np.abs(M).max()
        assert np.abs(a - state["a"]).max() < 1e-9 * np.abs(a).max()


# --- the numbers themselves -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["double", "tree", "ur5"])
def test_the_states_balance(name: str, folders: Folders) -> None:
    """M a + bias = 0 for free joints: the wrench has no component along a joint's axis; M is that of the kinetic energy."""
    reference = json.loads((folders[name] / "reference.json").read_text())
    axes = tree_of(build(SCENES[name].model).pin).axes
    for state in reference["states"]:
        M, v, wrench = (np.array(state[key]) for key in ("mass_matrix", "v", "wrench"))
        assert np.array_equal(M, M.T)
        assert np.linalg.eigvalsh(M).min() > 0
        assert v @ M @ v / 2 == pytest.approx(state["kinetic"], rel=1e-14)
        along = np.einsum("ij,ij->i", axes, wrench[:, 3:])
        assert np.abs(along).max() < 1e-13 * np.abs(wrench).max()


def test_the_motion_is_that_of_a_finer_run(folders: Folders) -> None:
    """A run by another method and tolerance is within the bounds at all 50 times."""
    reference = json.loads((folders["double"] / "reference.json").read_text())
    t, q, v = (np.array(reference["motion"][key]) for key in ("t", "q", "v"))
    assert len(t) == 50
    run = pp.simulate(SCENES["double"], times=t, method="rk45", tolerance=1e-13)
    assert np.abs(run.q - q).max() <= 2 * reference["bounds"]["motion"]["q"] + 1e-10
    assert np.abs(run.v - v).max() <= 2 * reference["bounds"]["motion"]["v"] + 1e-9


def test_loads_widen_the_bound() -> None:
    """Torques and wrenches are doubles: the states say so in their bounds; without them only the last digit is rounded."""
    scene = SCENES["rod"]
    random = np.random.default_rng(5)
    _, free = reference_states(pp.bind(scene), random)
    drag = scene.replace(effects=(GRAVITY, pp.effects.Drag(linear=0.1)))
    _, loaded_bounds = reference_states(pp.bind(drag), random)
    assert free["a"] < 1e-14
    assert loaded_bounds["a"] < 1e-12


# --- the folder -------------------------------------------------------------------------------------------------------


def test_what_a_format_cannot_carry_is_left_out_and_said(tmp_path: Path) -> None:
    """Drag is in no model file; viscous damping is in MJCF and SDF; a thin rod has no SDF. The numbers stay."""
    rod = SCENES["rod"]
    drag = write_reference(rod.replace(effects=(GRAVITY, pp.effects.Drag())), tmp_path / "drag")
    assert set(drag.data["left_out"]) == {"model.urdf", "model.xml", "model.sdf"}
    written = [f"wrote {tmp_path / 'drag' / name}" for name in drag.data["files"]]
    assert drag.sentences == [*written, *(f"{name} is left out: {why}" for name, why in drag.data["left_out"].items())]
    assert sorted(drag.data["files"]) == sorted(path.name for path in (tmp_path / "drag").iterdir())
    assert "effects[1]: drag" in drag.data["left_out"]["model.xml"]
    assert "effects[1]: drag" in (tmp_path / "drag" / "README.md").read_text()
    assert len(json.loads((tmp_path / "drag" / "reference.json").read_text())["states"]) == STATES
    damped = write_reference(rod.replace(effects=(GRAVITY, pp.effects.Viscous(coefficient=0.1))), tmp_path / "damped")
    assert set(damped.data["left_out"]) == {"model.urdf"}
    assert (tmp_path / "damped" / "model.xml").read_text().count('damping="0.1"') == 2
    thin = write_reference(rod.replace({"model.rods[0].radius": 0.0}), tmp_path / "thin")
    assert set(thin.data["left_out"]) == {"model.sdf"}


def test_the_scene_in_the_folder_is_the_scene(folders: Folders) -> None:
    """It loads to the same model, start and effects."""
    for name in ("double", "ur5"):
        assert pp.load_scene(folders[name] / "scene.toml") == SCENES[name]


def test_a_folder_is_written_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd) -> None:
    """One that is there is left alone; an error leaves nothing behind."""
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "mine.txt").write_text("mine")
    monkeypatch.setattr("sys.argv", ["pendpin", "reference", "--out", str(tmp_path / "there")])
    with pytest.raises(SystemExit) as ended:
        main()
    said = capfd.readouterr().err
    assert ended.value.code == 1
    assert "it exists already" in said
    assert said.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["there"]
    assert [path.name for path in (tmp_path / "there").iterdir()] == ["mine.txt"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"effects": (GRAVITY, pp.effects.DryFriction(kinetic=0.1))}, "no dry friction and no stops"),
        ({"model": pp.Chain(rods=[MIXED[0]], copies=500)}, "500 rods"),
    ],
)
def test_scenes_without_reference_numbers_are_refused(change: dict[str, Any], words: str, tmp_path: Path) -> None:
    """One line, and no folder."""
    with pytest.raises(pp.InputError, match=words):
        write_reference(SCENES["rod"].replace(start=pp.Start()).replace(**change), tmp_path / "out")
    assert not list(tmp_path.iterdir())
