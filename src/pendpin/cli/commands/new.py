"""Example scenes to begin with: pendpin new."""

from typing import Annotated

import typer


def new(
    example: Annotated[
        str, typer.Argument(help="Name of an example, such as crane; `pendpin new --list` lists all.")
    ] = "single_rod",
    listed: Annotated[bool, typer.Option("--list", help="List the examples.")] = False,
) -> None:
    """Print a commented example scene, to be changed: pendpin new crane > my.toml."""
    from pendpin.scene.examples import example_names, example_text

    print("\n".join(example_names()) if listed else example_text(example), end="\n" if listed else "")
