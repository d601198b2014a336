"""What scenes are made of: pendpin urdf, new, schema."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.inputs import flag, read_scene
from pendpin.cli.outputs import refuse_outputs
from pendpin.cli.printing import print_files
from pendpin.cli.streams import say
from pendpin.errors import PendpinError
from pendpin.ground.files import write_whole


def urdf(
    scene: Annotated[Path | None, typer.Argument(help="Scene file (TOML) of a chain.")] = None,
    out: Annotated[Path | None, typer.Option(help="Where to write the URDF; on the terminal if absent.")] = None,
    listed: Annotated[bool, flag("--list", help="List the robots that --urdf and model.name know.")] = False,
) -> None:
    """Write a chain as a URDF that Pinocchio, MuJoCo and Drake load to the same model; or list the robots by name."""
    from pendpin.ground.files import write_whole
    from pendpin.model.write_models import chain_urdf
    from pendpin.scene import Chain
    from pendpin.scene.models import robot_files

    if listed:
        print("\n".join(robot_files()))
        return
    if scene is None:
        raise typer.BadParameter("give the scene of a chain, or --list")
    if not (scene.suffix or scene.exists()) and scene.name in robot_files():
        file = robot_files()[scene.name]
        raise PendpinError(f"{scene}: this robot has a URDF already, {file}; pendpin run --urdf {scene} runs it")
    model = read_scene(scene).model
    if not isinstance(model, Chain):
        raise PendpinError(
            f"{scene}: model.kind: the model is a URDF file already: {getattr(model, 'file', 'a pin.Model')}"
        )
    refuse_outputs([scene], urdf=out)
    text = chain_urdf(model)
    if out is None:
        print(text, end="")
    else:
        print_files([write_whole(out, lambda file: file.write(text.encode()))])


# --- example scenes to begin with: pendpin new ----------------------------------------------------------------------


def new(
    example: Annotated[
        str, typer.Argument(help="Name of an example, such as crane; `pendpin new --list` lists all.")
    ] = "single_rod",
    listed: Annotated[bool, flag("--list", help="List the examples.")] = False,
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


# --- the JSON schema of a scene: pendpin schema ---------------------------------------------------------------------


def schema() -> None:
    """Print the JSON schema of a scene, for editors that complete and check TOML."""
    from json import dumps

    from pendpin.scene import Scene

    print(dumps(Scene.model_json_schema(), indent=2))
