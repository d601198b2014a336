"""Printed equations, examined: pendpin doctor."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.inputs import refuse_targets
from pendpin.cli.options import Json
from pendpin.cli.tables import print_diagnosis, print_files, waiting


def doctor(
    file: Annotated[Path, typer.Argument(help="Equations: LaTeX, Markdown, plain text, or TOML with [equations].")],
    rod: Annotated[str | None, typer.Option(help="thin, uniform or general; the symbols tell if absent.")] = None,
    convention: Annotated[
        str | None, typer.Option(help="theta-ccw, phi-reversed, z-up, swapped, with commas; found if absent.")
    ] = None,
    html: Annotated[Path | None, typer.Option(help="The report as one HTML page.")] = None,
    json: Json = False,
) -> None:
    """Say which printed equation of a rod is wrong, and which change corrects it.

    The exit status is 0 only if some equation could be read and all that could hold.
    """
    from pendpin.analysis.doctor.diagnose import diagnose_file

    refuse_targets([html], [file])
    with waiting("reading", hidden=json) as progress:
        diagnosis = diagnose_file(file, rod, convention, progress)
    print_diagnosis(diagnosis, json)
    if html:
        from pendpin.analysis.doctor.reports.page import write_report

        files = [write_report(html, diagnosis)]
        if not json:
            print_files(files)
    if not diagnosis.ok:
        raise typer.Exit(1)
