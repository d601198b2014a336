"""A saved run in the browser: pendpin view."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.inputs import refuse_targets
from pendpin.cli.outputs import show_run, write_page
from pendpin.cli.tables import print_files
from pendpin.errors import inside


def view(
    run: Annotated[Path, typer.Argument(help="A saved run (.npz).")],
    html: Annotated[Path | None, typer.Option(help="Write the animation to one HTML page and show nothing.")] = None,
) -> None:
    """Show a saved run in a browser, on this machine only, until Ctrl-C; or write it as one HTML page.

    The page's address may end in what it shall show: #t=1.5&view=above&speed=5&reactions=on.
    """
    from pendpin.trajectory import Trajectory

    trajectory = Trajectory.load(run)
    refuse_targets([html], [run])
    with inside(str(run)):
        if html is None:
            show_run(trajectory)
        else:
            print_files([write_page(trajectory, html)])
