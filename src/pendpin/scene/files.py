"""Scenes from TOML files and from runs."""

from pathlib import Path
from typing import Any

from pendpin.errors import InputError, inside, shown
from pendpin.scene.examples import example_names
from pendpin.scene.scene import Scene
from pendpin.scene.toml import read_toml


def load_scene(path: str | Path) -> Scene:
    """Read a scene from a TOML file; the files that it names are relative to that file. Raises InputError."""
    path = Path(path)
    if str(path) in example_names() and not path.exists():
        raise InputError(f"{path}: no such file; `pendpin new {path} > {path}.toml` writes the example of that name")
    with inside(str(path)):
        raw = read_toml(path)
        if not raw:
            raise InputError("it is empty; `pendpin new` prints a scene to start from")
        try:
            return Scene(**raw)
        except InputError as error:  # the file's name says enough
            raise InputError(str(error).removeprefix("Scene: ")) from None


def chosen_scene(scene_or_path: Scene | str | Path) -> Scene:
    """A scene as it is, or that of a file. Raises InputError for anything else."""
    scene = load_scene(scene_or_path) if isinstance(scene_or_path, str | Path) else scene_or_path
    if not isinstance(scene, Scene):
        raise InputError(f"scene: {shown(scene_or_path)} is not a Scene, nor the path of a scene file")
    return scene


def scene_of(run: Any) -> Scene:
    """The scene of a run. Raises InputError where a saved run's scene holds what no file can."""
    if isinstance(run.source, Scene):
        return run.source
    try:
        return Scene(**run.scene)
    except InputError as error:
        advice = "give it, as Trajectory.load(path, scene=scene)"
        raise InputError(f"the run's scene cannot be built again: {error}; {advice}") from None
