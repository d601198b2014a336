"""Reference numbers for other engines' tests: pendpin reference."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.inputs import SceneInput, on_scene
from pendpin.cli.options import Json
from pendpin.cli.printing import print_files, print_json
from pendpin.cli.progress import waiting


@on_scene
def reference(
    chosen: SceneInput,
    out: Annotated[Path, typer.Option(help="A new folder for the model files and the numbers.")],
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random states.")] = 0,
    json: Json = False,
) -> None:
    """Write a model as URDF, MJCF and SDF with reference numbers and error bounds, for another engine's tests."""
    from pendpin.verification.agreement.reference import write_reference

    with chosen.noted() as scene, waiting("50 digits", hidden=json):
        made = write_reference(scene, out, seed)
    if json:
        print_json({"path": str(made.path), "files": made.files, "left_out": made.left_out})
        return
    print_files([made.path / name for name in made.files])
    for name, why in made.left_out.items():
        print(f"{name} is left out: {why}")
