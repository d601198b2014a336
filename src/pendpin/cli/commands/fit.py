"""A model from measured swings: pendpin fit."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.inputs import files_of, read_scene, refuse_targets
from pendpin.cli.options import Json
from pendpin.cli.tables import print_files, print_fit, waiting
from pendpin.errors import inside


def fit(
    scene: Annotated[Path, typer.Argument(help="Scene file (TOML) with guesses and a [data] table.")],
    data: Annotated[list[Path], typer.Argument(help="Measured swings: one CSV file or several.")],
    free: Annotated[
        str, typer.Option(help='Key paths, separated by commas, or "physics" (bodies, frictions, drags), "friction".')
    ] = "physics",
    hold_out: Annotated[list[Path] | None, typer.Option(help="CSV of other swings, to be predicted.")] = None,
    hold_out_start: Annotated[
        float, typer.Option(help="Part of each held-out swing on which its start is fitted; the rest is compared.")
    ] = 0.1,
    explain_residual: Annotated[
        bool, typer.Option("--explain-residual", help="Fit without each part of the model, and with parts it lacks.")
    ] = False,
    robust: Annotated[bool, typer.Option("--robust", help="Let outliers count less.")] = False,
    out: Annotated[Path | None, typer.Option(help="The fitted scene (TOML).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Figure: .png, .pdf or .svg.")] = None,
    json: Json = False,
) -> None:
    """Fit free numbers of a scene to measured swings: values with errors, and what the data cannot tell."""
    from pendpin.analysis.fit import explain_residual as explained
    from pendpin.analysis.fit import fit as fitted
    from pendpin.graphics.figure import picture_kind

    chosen = read_scene(scene)
    if plot:
        picture_kind(plot)
    refuse_targets([out, plot], [scene, *data, *(hold_out or []), *files_of(chosen)])
    with inside(str(scene)), waiting("fitting", hidden=json) as progress:
        found = fitted(chosen, data, free, hold_out, hold_out_start, robust=robust, progress=progress)
        if explain_residual:
            found = explained(found, progress)
    print_fit(found, json)
    files = [chosen_file for chosen_file in (out and found.scene.save(out), plot and found.plot(plot)) if chosen_file]
    if files and not json:
        print_files(files)
