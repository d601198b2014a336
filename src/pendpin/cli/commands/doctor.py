"""Printed equations, examined: pendpin doctor."""

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.inputs import Json, naming_options
from pendpin.cli.outputs import refuse_outputs
from pendpin.cli.printing import print_files, print_json
from pendpin.cli.work import Limit, limited, waiting


def doctor(
    file: Annotated[
        Path, typer.Argument(help="Equations: LaTeX, Markdown, plain text, or TOML with a table named equations.")
    ],
    rod: Annotated[
        str | None,
        typer.Option(
            help="point, thin, uniform, symmetric or general; or plane, double, acrobot, cart-pole, polar. Found if absent."
        ),
    ] = None,
    convention: Annotated[
        str | None,
        typer.Option(
            help="theta-ccw, phi-reversed, z-up, z-mirrored, swapped, b3-up, transposed, separated by commas; or standard. "
            "Found if absent."
        ),
    ] = None,
    symbols: Annotated[
        str | None, typer.Option(help="The meaning of the text's own symbols, as in alpha=theta,A=J_1.")
    ] = None,
    scene: Annotated[Path | None, typer.Option(help="A scene of a chain of rods that the equations describe.")] = None,
    html: Annotated[Path | None, typer.Option(help="Where to write the report as one HTML page.")] = None,
    limit: Limit = None,
    json: Json = False,
) -> None:
    """Say which printed equation of a rod is wrong, and which change corrects it.

    The exit status is 0 only if at least one equation could be read and each one that was read is right.
    """
    from pendpin.doctor.diagnose import diagnose_file
    from pendpin.doctor.recognition import check_choices
    from pendpin.doctor.reports.text import lines

    refuse_outputs([file], html=html)
    with naming_options():
        check_choices(rod, convention)
    with limited(limit) as work, waiting("reading", json, work) as progress:
        diagnosis = diagnose_file(file, rod, convention, progress, symbols, scene)
    print_json(diagnosis.to_json()) if json else _print_lines(lines(diagnosis))
    if html:
        from pendpin.doctor.reports.page import write_report

        print_files([write_report(html, diagnosis)], json)
    if not diagnosis.ok:
        raise typer.Exit(1)


def _print_lines(lines: Iterable[Iterable[tuple[str, str]]]) -> None:
    """Lines of pieces of text, each with its style."""
    from rich.console import Console
    from rich.text import Text

    console = Console()
    for line in lines:
        console.print(Text.assemble(*line), soft_wrap=True)
