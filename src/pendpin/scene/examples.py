"""The example scenes that come with pendpin."""

import re
from pathlib import Path

from pendpin.errors import InputError, is_no
from pendpin.files import folder_of


def example_names() -> list[str]:
    """The names of the examples."""
    return sorted(path.stem for path in examples_folder().glob("*.toml"))


def example_text(name: str) -> str:
    """An example scene as text, with its comments; the files that it names by their whole paths. Raises InputError."""
    names = example_names()
    if name not in names:
        raise InputError(is_no("example", name, names))
    text = (examples_folder() / f"{name}.toml").read_text(encoding="utf-8")
    return re.sub(r'(?m)^(csv|path) = "([^"]+)"', lambda m: f'{m[1]} = "{(examples_folder() / m[2]).as_posix()}"', text)


def examples_folder() -> Path:
    """Where they are."""
    return folder_of("examples")
