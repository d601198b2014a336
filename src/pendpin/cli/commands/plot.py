"""The figure of a saved run: pendpin plot."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.inputs import refuse_targets
from pendpin.cli.outputs import save_plot
from pendpin.cli.tables import print_files


def plot(
    run: Annotated[Path, typer.Argument(help="A saved run (.npz).")],
    names: Annotated[
        list[str] | None, typer.Argument(help="Quantities such as theta_1 R3_2; else the whole figure.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="The picture: .png, .pdf or .svg; RUN.png if absent.")] = None,
) -> None:
    """Draw a saved run: energy, angles, reactions and the path of the tip, or quantities by name."""
    from pendpin.trajectory import Trajectory

    trajectory = Trajectory.load(run)
    picture = out or run.with_suffix(".png")
    refuse_targets([picture], [run])
    print_files([save_plot(trajectory, picture, tuple(names or ()))])
