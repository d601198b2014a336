"""Natural frequencies, damping and shapes: pendpin modes."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.inputs import SceneInput, on_scene
from pendpin.cli.limits import Limit, limited
from pendpin.cli.options import Json, Plot
from pendpin.cli.outputs import refuse_outputs
from pendpin.cli.printing import print_files, print_report


@on_scene
def modes(
    chosen: SceneInput,
    every: Annotated[bool, typer.Option("--all", help="Print every mode, not the lowest alone.")] = False,
    plot: Plot = None,
    html: Annotated[Path | None, typer.Option(help="Animation of a mode as one HTML page.")] = None,
    mode: Annotated[int, typer.Option(min=1, help="Which mode the page plays; the lowest is 1.")] = 1,
    limit: Limit = None,
    json: Json = False,
) -> None:
    """Print the natural frequencies, damping ratios and shapes of small motions about the rest of a scene.

    Frequencies that both directions of a hanging chain share are one line.
    """
    from pendpin.stability.modes import MOST_ROWS
    from pendpin.stability.modes import modes as modes_of

    refuse_outputs(chosen.files, plot=plot, html=html)
    with chosen.noted() as scene:
        with limited(limit):
            result = modes_of(scene)
        result.place(mode)
        print_report(result.report(None if every else MOST_ROWS), json)
        files = [result.save_plot(plot)] if plot else []
        files += [result.animate(mode).save(html)] if html else []
    print_files(files, json)
