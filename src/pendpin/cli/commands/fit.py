"""A model from measured swings: pendpin fit."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.inputs import files_of, print_notes, read_scene
from pendpin.cli.options import Json, Plot
from pendpin.cli.outputs import refuse_outputs
from pendpin.cli.progress import waiting
from pendpin.cli.tables import print_files, print_fit
from pendpin.errors import inside


def fit(
    scene: Annotated[Path, typer.Argument(help="Scene file (TOML) with guesses and a table named data.")],
    data: Annotated[list[Path], typer.Argument(help="Measured swings: one CSV file or several.")],
    free: Annotated[
        str, typer.Option(help='Key paths, separated by commas, or "physics" (bodies, frictions, drags), "friction".')
    ] = "physics",
    hold_out: Annotated[
        list[Path] | None, typer.Option(help="CSV of other swings, which the fitted model predicts.")
    ] = None,
    hold_out_start: Annotated[
        float, typer.Option(help="Part of each held-out swing on which its start is fitted; the rest is compared.")
    ] = 0.1,
    explain_residual: Annotated[
        bool,
        typer.Option(
            "--explain-residual", help="Fit again without each part of the model, and with parts that it lacks."
        ),
    ] = False,
    robust: Annotated[bool, typer.Option("--robust", help="Give outliers less weight.")] = False,
    out: Annotated[Path | None, typer.Option(help="Where to write the fitted scene (TOML).")] = None,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Identify parameters of a scene from measured swings: values, errors, and which numbers the data cannot determine."""
    from pendpin.fitting import explain_residual as explained
    from pendpin.fitting import fit as fitted

    chosen = read_scene(scene)
    refuse_outputs([scene, *data, *(hold_out or []), *files_of(chosen)], plot=plot, scene=out)
    with inside(str(scene)):
        print_notes(chosen, strict=False)
    with inside(str(scene)), waiting("fitting", hidden=json) as progress:
        found = fitted(chosen, data, free, hold_out, hold_out_start, robust=robust, progress=progress)
        if explain_residual:
            found = explained(found, progress)
    print_fit(found, json)
    print_files([file for file in (out and found.scene.save(out), plot and found.plot(plot)) if file], json)
