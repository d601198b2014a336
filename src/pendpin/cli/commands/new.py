"""Example scenes to begin with: pendpin new."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.streams import say
from pendpin.ground.files import write_whole


def new(
    example: Annotated[
        str, typer.Argument(help="Name of an example, such as crane; `pendpin new --list` lists all.")
    ] = "single_rod",
    listed: Annotated[bool, typer.Option("--list", help="List the examples.")] = False,
) -> None:
    """Print a commented example scene, to be changed: pendpin new crane > my.toml.

    A file that the scene names, such as the track of a trolley, is put into the working folder, if it is not there.
    """
    from pendpin.scene.toml import example_names, example_text, files_of_example

    if listed:
        print("\n".join(example_names()))
        return
    text = example_text(example)
    for file in files_of_example(text):
        _put_here(file)
    print(text, end="")


def _put_here(file: Path) -> None:
    """Copy a file of the examples into the working folder; one of that name stays as it is, and that is said."""
    target, content = Path(file.name), file.read_bytes()
    if not target.exists():
        say(f"pendpin: wrote {write_whole(target, lambda out: out.write(content))}, which the scene reads")
    elif target.read_bytes() != content:
        say(f"pendpin: note: {target} is there already, and is not that of the example")
