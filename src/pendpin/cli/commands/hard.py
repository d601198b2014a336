"""The hard cases: pendpin hard."""

from typing import Annotated

import typer

from pendpin.cli.options import Json
from pendpin.cli.printing import print_report
from pendpin.cli.progress import waiting
from pendpin.errors import PendpinError


def hard(
    cases: Annotated[list[str] | None, typer.Argument(help="Names of cases; all if absent.")] = None,
    listed: Annotated[bool, typer.Option("--list", help="List the cases and run none.")] = False,
    short: Annotated[bool, typer.Option("--short", help="Run the short forms, as the tests do.")] = False,
    peers: Annotated[
        bool, typer.Option("--peers", help="Run the short forms in MuJoCo, Drake and plain SciPy.")
    ] = False,
    json: Json = False,
) -> None:
    """Run the hard cases (docs/hard_cases.md), each on its methods against its bound."""
    from pendpin.verification.hardcases import CASES
    from pendpin.verification.hardcases import hard as run_cases
    from pendpin.verification.hardcases.running import catalogue_report

    if listed:
        print_report(catalogue_report(CASES.values()), json)
        return
    with waiting("the hard cases", hidden=json) as progress:
        report = run_cases(cases or (), full=not short, peers=peers, progress=progress)
    print_report(report.report(), json)
    if report.stopped:
        raise KeyboardInterrupt
    if report.fault:
        raise PendpinError(report.fault)
