"""A saved run in the browser: pendpin view."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.outputs import refuse_outputs, show_run, write_page
from pendpin.cli.tables import print_files
from pendpin.errors import inside


def view(
    run: Annotated[Path, typer.Argument(help="A saved run (.npz).")],
    html: Annotated[Path | None, typer.Option(help="Write the animation to one HTML page and show nothing.")] = None,
) -> None:
    """Show a saved run in a browser, on this machine only, until Ctrl-C; or write it as one HTML page.

    An ending of the page's address sets what it shows: #t=1.5&view=above&speed=5&reactions=on.
    """
    from pendpin.trajectory import Trajectory

    trajectory = Trajectory.load(run)
    refuse_outputs([run], html=html)
    with inside(str(run)):
        if html is None:
            show_run(trajectory)
        else:
            print_files([write_page(trajectory, html)])
