"""run.show: a run in meshcat's viewer and in Pinocchio's, by the commands that they are sent."""

from typing import Any

import meshcat
import numpy as np
import pinocchio as pin
import pytest
from meshcat.path import Path
from pinocchio.visualize import MeshcatVisualizer

import pendpin as pp

GRAVITY = [pp.effects.Gravity()]


class Recorder:
    """In place of a viewer's connection to its server."""

    def __init__(self) -> None:
        self.commands: list[dict[str, Any]] = []

    def send(self, command: Any) -> None:
        self.commands.append(command.lower())

    def of(self, kind: str) -> list[dict[str, Any]]:
        return [command for command in self.commands if command["type"] == kind]


def recorded() -> tuple[Any, Recorder]:
    window = Recorder()
    return meshcat.Visualizer.view_into(window, Path(("meshcat",))), window


def test_meshcat_is_sent_the_rods_where_they_are() -> None:
    model = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0), pp.Rod(length=0.5, mass=0.5, payload=1.0)])
    start = pp.Start(time=100.0, positions={"theta_1": 0.4, "phi_2": 0.7})
    run = pp.simulate(pp.Scene(duration=1.0, model=model, start=start, effects=GRAVITY))
    viewer, window = recorded()
    assert run.show(viewer) is viewer
    assert len(window.of("set_object")) == 2 + 2 + 1 + 1  # rods, joints, the payload, what they hang from
    [film] = window.of("set_animation")
    tracks = {
        (animation["path"].rsplit("/", 1)[-1], track["name"]): track["keys"]
        for animation in film["animations"]
        for track in animation["clip"]["tracks"]
    }
    places = tracks["body_1", ".position"]
    assert (places[0]["time"], places[-1]["time"]) == (0, 60)  # frames of 1/60 s from the start of the run
    for key in places:
        row = np.argmin(np.abs(run.t - run.t[0] - key["time"] / 60))
        np.testing.assert_allclose(key["value"], run.tips[row, 0], atol=1e-12)
    [position] = [c["value"] for c in window.of("set_property") if c["property"] == "position"]
    assert np.linalg.norm(position) > 1.5  # outside of what moves


def test_pinocchios_viewer_is_sent_the_meshes_of_the_urdf_where_they_are() -> None:
    model = pp.UrdfModel("ur5")
    run = pp.simulate(pp.Scene(duration=0.1, model=model, effects=GRAVITY))
    share = next(folder for folder in model.file.parents if folder.name == "share")
    own, collisions, visuals = pin.buildModelsFromUrdf(str(model.file), package_dirs=[str(share)])
    viewer, window = recorded()
    visualizer = MeshcatVisualizer(own, collisions, visuals)
    visualizer.initViewer(viewer=viewer, open=False)
    visualizer.loadViewerModel()
    meshes = [c["path"] for c in window.of("set_object")]
    assert len(meshes) >= len(visuals.geometryObjects) == 7
    assert run.show(visualizer) is visualizer
    data, geometry = own.createData(), pin.GeometryData(visuals)
    pin.updateGeometryPlacements(own, data, visuals, geometry, run.configurations(own)[-1])
    placed = {c["path"]: np.reshape(c["matrix"], (4, 4)).T for c in window.of("set_transform")}  # the last of each
    for shape, place in zip(visuals.geometryObjects, geometry.oMg, strict=True):
        [seen] = [matrix for path, matrix in placed.items() if path.endswith(shape.name)]
        np.testing.assert_allclose(seen[:3, 3], place.translation, atol=1e-12)


def test_what_is_no_viewer_is_refused() -> None:
    run = pp.simulate(pp.Scene(duration=0.1, model=pp.Chain(rods=[pp.Rod(length=1, mass=1)]), effects=GRAVITY))
    with pytest.raises(pp.InputError, match=r"show: 'none' .*meshcat\.Visualizer.*MeshcatVisualizer"):
        run.show("none")
