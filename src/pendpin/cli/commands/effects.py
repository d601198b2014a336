"""What each effect changes: pendpin effects."""

from typing import Annotated

import typer

from pendpin.cli.inputs import SceneInput, on_scene
from pendpin.cli.options import Json
from pendpin.cli.printing import print_report
from pendpin.cli.progress import waiting


@on_scene
def effects(
    chosen: SceneInput,
    accuracy: Annotated[
        float, typer.Option(help="Smallest change that matters: tip distance over the chain's length.")
    ] = 1e-3,
    thorough: Annotated[
        bool, typer.Option("--thorough", help="Compare over the full duration, however long that takes.")
    ] = False,
    json: Json = False,
) -> None:
    """Show what each effect changes and costs, and which effects the scene needs at an accuracy."""
    from pendpin.sweeps.significance import significance

    with waiting("comparing runs with and without each effect", hidden=json), chosen.noted() as scene:
        report = significance(scene, accuracy, thorough)
    print_report(report.report(), json)
