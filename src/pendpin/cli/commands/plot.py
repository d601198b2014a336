"""The figure of a saved run: pendpin plot."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.outputs import refuse_outputs
from pendpin.cli.printing import print_files


def plot(
    run: Annotated[Path, typer.Argument(help="A saved run (.npz).")],
    names: Annotated[
        list[str] | None, typer.Argument(help="Quantities to draw, such as theta_1 R3_2; the whole figure if absent.")
    ] = None,
    compare: Annotated[
        list[Path] | None, typer.Option(help="Another saved run to be drawn on the same axes; may be repeated.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="File for the figure (.png, .pdf or .svg); RUN.png if absent.")
    ] = None,
) -> None:
    """Draw a saved run: energy, angles, reactions and the path of the tip, or quantities by name, such as energy_drift."""
    from pendpin.graphics.figure import save_plot
    from pendpin.motions.trajectory import Trajectory

    trajectory = Trajectory.load(run)
    picture = out or run.with_suffix(".png")
    refuse_outputs([run, *(compare or ())], plot=picture)
    others = [Trajectory.load(other) for other in compare or ()]
    print_files([save_plot(trajectory, picture, tuple(names or ()), others)])
