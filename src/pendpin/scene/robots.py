"""The robots of example-robot-data, by name."""

from collections import Counter
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from pendpin.errors import InputError, MissingLibrary, nearest_or_all, shown

FOLDER = "share/example-robot-data/robots"


def robot_file(name: str) -> Path:
    """The URDF of a robot by its name. Raises InputError that says which name was probably meant."""
    files = robot_files()
    short = name.removesuffix(".urdf").removesuffix("_description")
    if name not in files and short not in files:
        hint = f"{shown(name)} is not a robot of example-robot-data{nearest_or_all(name, tuple(files))}"
        raise InputError(f"model.name: {hint}; `pendpin urdf --list` lists all")
    return files[name if name in files else short]


@cache
def robot_files() -> dict[str, Path]:
    """The URDFs of the installed example-robot-data by name: that of the file, or of its folder if it is alone there.

    Of a file `ur5_robot.urdf` the name is ur5; where two files have one name, that of their folder.
    """
    files = sorted(_folder().rglob("*.urdf"))
    by_folder = Counter(_folder_name(path) for path in files)
    names: dict[str, list[Path]] = {}
    for path in files:
        own = {path.stem, path.stem.removesuffix("_robot")}
        own |= {_folder_name(path)} if by_folder[_folder_name(path)] == 1 else set()
        for name in own:
            names.setdefault(name, []).append(path)
    exact = {name: next((path for path in paths if path.stem == name), paths[0]) for name, paths in names.items()}
    twice = {name for name, paths in names.items() if sum(path.stem == name for path in paths) > 1}
    qualified = {_folder_name(path): path for path in files if path.stem in twice}
    return dict(sorted({name: path for name, path in (exact | qualified).items() if name not in twice}.items()))


def _folder_name(path: Path) -> str:
    """The robot that a folder NAME_description is about."""
    folder = path.relative_to(_folder()).parts[0]
    return folder.removesuffix("_description").removesuffix("_data").removesuffix("_simple")


def _folder() -> Path:
    spec = find_spec("cmeel")
    for place in (spec and spec.submodule_search_locations) or ():
        folder = Path(place).parent / "cmeel.prefix" / FOLDER
        if folder.is_dir():
            return folder
    raise MissingLibrary("robots by name need example-robot-data: pip install example-robot-data")
