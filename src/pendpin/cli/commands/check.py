"""Compare the routes at random states: pendpin check."""

from typing import Annotated

import typer

from pendpin.cli.inputs import SceneInput, on_scene
from pendpin.cli.options import Json
from pendpin.cli.printing import print_report
from pendpin.errors import PendpinError


@on_scene
def check(
    chosen: SceneInput,
    states: Annotated[int, typer.Option(min=1, max=10_000_000, help="How many random states.")] = 1000,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random states.")] = 0,
    every_row: Annotated[bool, typer.Option("--all", help="Print every pair of routes in every quantity too.")] = False,
    json: Json = False,
) -> None:
    """Compute accelerations and reactions at random states by every route, and compare each pair of routes.

    The table has a line for each route and a column for each quantity, with the worst difference in each cell.
    """
    from pendpin.motions.crosschecks.crosscheck import crosscheck

    with chosen.noted() as scene:
        report = crosscheck(scene, states=states, seed=seed)
    print_report(report.report(every_row), json)
    if report.fault:
        raise PendpinError(report.fault)
