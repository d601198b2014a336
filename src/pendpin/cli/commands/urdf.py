"""A chain as a URDF: pendpin urdf."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.inputs import read_scene
from pendpin.cli.outputs import refuse_outputs
from pendpin.cli.printing import print_files
from pendpin.errors import PendpinError


def urdf(
    scene: Annotated[Path | None, typer.Argument(help="Scene file (TOML) of a chain.")] = None,
    out: Annotated[Path | None, typer.Option(help="Where to write the URDF; on the terminal if absent.")] = None,
    listed: Annotated[bool, typer.Option("--list", help="List the robots that --urdf and model.name know.")] = False,
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
