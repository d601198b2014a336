"""What accuracy costs in time: pendpin cost."""

from typing import Annotated

import typer

from pendpin.cli.inputs import SceneInput, naming_options, on_scene
from pendpin.cli.options import Json, Plot
from pendpin.cli.outputs import refuse_outputs
from pendpin.cli.printing import print_files, print_report
from pendpin.cli.progress import waiting


@on_scene
def cost(
    chosen: SceneInput,
    methods: Annotated[
        str | None, typer.Option(help='Methods, separated by commas: as run takes them, or "dop853 not compiled".')
    ] = None,
    accuracy: Annotated[
        float, typer.Option(help="Accuracy of interest: tip error divided by the chain's length.")
    ] = 1e-9,
    peers: Annotated[bool, typer.Option("--peers", help="Measure MuJoCo, Drake and plain SciPy too.")] = False,
    thorough: Annotated[
        bool, typer.Option("--thorough", help="Measure all methods at all settings, over the full duration.")
    ] = False,
    budget: Annotated[
        float, typer.Option(min=0, help="Stop measuring a method when one of its runs takes longer, in s.")
    ] = 1.0,
    plot: Plot = None,
    short: Annotated[
        bool, typer.Option("--short", help="Draw the cheapest method of each tool, and the time of its next digit.")
    ] = False,
    json: Json = False,
) -> None:
    """Find the fastest method for each accuracy and its run time, in about 20 s. --thorough: a work-precision diagram."""
    from pendpin.verification.work_precision.cost import cost as measure
    from pendpin.verification.work_precision.figure import save_cost_plot

    refuse_outputs(chosen.files, plot=plot)
    with waiting("the reference", hidden=json) as progress, chosen.noted() as scene:
        names = [name.strip() for name in methods.split(",")] if methods else None
        options = {"methods": names, "accuracy": accuracy, "peers": peers, "thorough": thorough, "budget": budget}
        with naming_options("methods", "accuracy"):
            report = measure(scene, **options, progress=progress)
    print_report(report.report(), json)
    if plot:
        print_files([save_cost_plot(report, plot, short)], json)
    if report.interrupted:
        raise KeyboardInterrupt
