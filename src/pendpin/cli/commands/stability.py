"""Whether rests and driven motions are stable: pendpin stability."""

from typing import Annotated

import typer

from pendpin.cli.inputs import SceneInput, on_scene
from pendpin.cli.limits import Limit, limited
from pendpin.cli.options import Json, Plot
from pendpin.cli.outputs import refuse_outputs
from pendpin.cli.printing import print_files, print_report


@on_scene
def stability(
    chosen: SceneInput,
    lyapunov: Annotated[
        bool, typer.Option("--lyapunov", help="The Lyapunov exponents of the motion from the start, over its duration.")
    ] = False,
    planar: Annotated[
        bool, typer.Option("--planar", help="With --lyapunov: only changes in the plane in which the motion stays.")
    ] = False,
    period: Annotated[
        float | None, typer.Option(help="Period in s of the motion; that of the drive if absent.")
    ] = None,
    limit: Limit = None,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Print the rests of a scene and whether they are stable; with a drive, the multipliers of its periodic motion.

    --lyapunov adds the Lyapunov exponents of the motion, each with its error; --plot then draws their estimates over time.
    """
    from pendpin.graphics.figure import write_figure
    from pendpin.stability.lyapunov import Lyapunov
    from pendpin.stability.lyapunov import lyapunov as exponents_of
    from pendpin.stability.report import stability as report_on

    refuse_outputs(chosen.files, plot=plot)
    if (plot or planar) and not lyapunov:
        raise typer.BadParameter(
            "it is of Lyapunov exponents: give --lyapunov too", param_hint="--plot" if plot else "--planar"
        )
    with chosen.noted() as scene, limited(limit):
        found = exponents_of(scene, planar=planar) if lyapunov else report_on(scene, period)
    print_report(found.report(), json)
    if plot and isinstance(found, Lyapunov):
        print_files([write_figure(plot, lambda: found.plot().figure)], json)
