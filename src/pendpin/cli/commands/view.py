"""A saved run in the browser: pendpin view."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.outputs import refuse_outputs, show_live
from pendpin.cli.printing import print_files
from pendpin.errors import inside


def view(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN...", help="Saved runs (.npz), up to 4; all but the first as ghosts.")
    ],
    html: Annotated[Path | None, typer.Option(help="Write the animation to one HTML page and show nothing.")] = None,
    film: Annotated[Path | None, typer.Option(help="Write a film, .gif or .mp4, and show nothing.")] = None,
) -> None:
    """Show a saved run in a browser, on this machine only, until Ctrl-C; or write it as a page or a film.

    With several runs the page shows the first one, the others as ghosts, and the distance of the tips.

    The end of the page's address chooses its view: #t=1.5&view=above&speed=5&reactions=on&frames=on.
    """
    from pendpin.motions.trajectory import Trajectory

    first, *others = map(Trajectory.load, runs)
    refuse_outputs(runs, html=html, film=film)
    with inside(str(runs[0])):
        animation = first.animate(others)
        if html or film:
            print_files([animation.save(path) for path in (html, film) if path])
        else:
            show_live(animation)
