"""What accuracy costs in time: pendpin cost."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.inputs import files_of, place_named, read_scene, refuse_targets
from pendpin.cli.options import Json, SceneFile
from pendpin.cli.tables import print_cost, print_files, waiting
from pendpin.errors import inside


def cost(
    scene: SceneFile = None,
    methods: Annotated[str | None, typer.Option(help="Methods, separated by commas; all if absent.")] = None,
    accuracy: Annotated[
        float, typer.Option(help="Accuracy of interest: tip error divided by the chain's length.")
    ] = 1e-9,
    peers: Annotated[bool, typer.Option("--peers", help="Measure MuJoCo, Drake and plain SciPy too.")] = False,
    budget: Annotated[float, typer.Option(min=0, help="The longest run of a method, in s.")] = 1.0,
    plot: Annotated[Path | None, typer.Option(help="Figure: .png, .pdf or .svg.")] = None,
    json: Json = False,
) -> None:
    """Show error against time for every integrator, and the cheapest one at each accuracy."""
    from pendpin.analysis.work_precision import METHODS
    from pendpin.analysis.work_precision import cost as measure
    from pendpin.analysis.work_precision_figure import save_cost_plot
    from pendpin.graphics.figure import picture_kind

    chosen = read_scene(scene)
    if plot:
        picture_kind(plot)
        refuse_targets([plot], [scene, *files_of(chosen)])
    with inside(place_named(scene)), waiting("the reference", hidden=json) as progress:
        names = [name.strip() for name in methods.split(",")] if methods else METHODS
        report = measure(chosen, methods=names, accuracy=accuracy, peers=peers, budget=budget, progress=progress)
    print_cost(report, json)
    if plot:
        print_files([save_cost_plot(report, plot)])
    if report.interrupted:
        raise KeyboardInterrupt
