"""Compare with published results: pendpin validate."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.options import Json
from pendpin.cli.printing import print_files, print_report
from pendpin.cli.progress import waiting
from pendpin.errors import PendpinError


def validate(
    cases: Annotated[list[str] | None, typer.Argument(help="Names of cases; all if absent.")] = None,
    listed: Annotated[bool, typer.Option("--list", help="List the cases with their sources and run none.")] = False,
    methods: Annotated[
        str | None, typer.Option(help="Methods, separated by commas; all that can run a case if absent.")
    ] = None,
    html: Annotated[Path | None, typer.Option(help="A page with the table, the motions and the sources.")] = None,
    json: Json = False,
) -> None:
    """Compare runs with published results of ADAMS, Dymola, OpenSim, benchmarks and closed forms (docs/agreement.md).

    The table has a line for each published quantity, with the method that differs most.
    """
    from pendpin.verification.agreement.validate import sources_report
    from pendpin.verification.agreement.validate import validate as compare

    if listed:
        print_report(sources_report(), json)
        return
    chosen = methods.split(",") if methods else None
    with waiting("the published cases", hidden=json) as progress:
        report = compare(cases or (), chosen, progress)
    print_report(report.report(), json)
    if html is not None:
        from pendpin.verification.agreement.page import write_page

        print_files([write_page(html, report)], json)
    if report.stopped:
        raise KeyboardInterrupt
    if report.fault:
        raise PendpinError(report.fault)
