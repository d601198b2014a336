"""The example scenes that come with pendpin."""

import re
from pathlib import Path

from pendpin.errors import InputError, nearest_or_all, shown
from pendpin.ground.files import folder_of


def example_names() -> list[str]:
    """The names of the examples."""
    return sorted(path.stem for path in examples_folder().glob("*.toml"))


def example_text(name: str) -> str:
    """An example scene as text, with its comments. Raises InputError."""
    names = example_names()
    if name not in names:
        raise InputError(f"{shown(name)} is not an example{nearest_or_all(name, tuple(names))}")
    return (examples_folder() / f"{name}.toml").read_text(encoding="utf-8")


def files_of_example(text: str) -> list[Path]:
    """The files that an example names relative to its own."""
    return [examples_folder() / name for _, name in re.findall(r'(?m)^(csv|path) = "([^"]+)"', text)]


def examples_folder() -> Path:
    """Where they are."""
    return folder_of("examples")
