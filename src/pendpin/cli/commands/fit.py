"""A model from measured swings: pendpin fit."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.inputs import Json, Plot, files_of, flag, print_notes, read_scene
from pendpin.cli.outputs import refuse_outputs
from pendpin.cli.printing import print_files, print_report
from pendpin.cli.work import Limit, limited, waiting
from pendpin.errors import InputError, inside


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
        float | None,
        typer.Option(
            help="Part of each held-out swing on which its start is fitted; the rest is compared. 0.1 if absent."
        ),
    ] = None,
    explain_residual: Annotated[
        bool,
        flag("--explain-residual", help="Fit again without each part of the model, and with parts that it lacks."),
    ] = False,
    robust: Annotated[bool, flag("--robust", help="Give outliers less weight.")] = False,
    out: Annotated[Path | None, typer.Option(help="Where to write the fitted scene (TOML).")] = None,
    plot: Plot = None,
    limit: Limit = None,
    json: Json = False,
) -> None:
    """Identify parameters of a scene from measured swings: values, errors, and which numbers the data cannot determine."""
    from pendpin.fitting import explain_residual as explained
    from pendpin.fitting import fit as fitted
    from pendpin.fitting.data import read_swings
    from pendpin.fitting.fitting import data_table

    if hold_out_start is not None and not (hold_out and 0 < hold_out_start < 1):
        raise typer.BadParameter("give --hold-out, and a part between 0 and 1", param_hint="--hold-out-start")
    chosen = read_scene(scene)
    refuse_outputs([scene, *data, *(hold_out or []), *files_of(chosen)], plot=plot, scene=out)
    with inside(str(scene)):
        print_notes(chosen, strict=False)
        table = data_table(chosen)
    swings, others = read_swings(data, table), read_swings(hold_out, table) if hold_out else None
    with limited(limit) as work, inside(str(scene)), waiting("fitting", json, work) as progress:
        result = fitted(chosen, swings, free, others, hold_out_start or 0.1, robust=robust, progress=progress)
        if explain_residual and result.follows:
            result = explained(result, progress)
    report = result.report()
    print_report(report, json)
    if report.fault:
        raise InputError(f"{scene}: {report.fault}" + "; no file is written" * bool(out or plot))
    print_files([file for file in (out and result.scene.save(out), plot and result.plot(plot)) if file], json)
