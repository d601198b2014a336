"""Natural frequencies, damping and shapes: pendpin modes."""

from pathlib import Path
from typing import Annotated

import typer

from pendpin.cli.inputs import files_of, place_named, print_notes, scene_with
from pendpin.cli.options import Changes, Json, Lock, Mimic, Plot, SceneFile, Strict, UrdfFile
from pendpin.cli.outputs import refuse_outputs
from pendpin.cli.tables import print_files, print_modes
from pendpin.errors import inside


def modes(
    scene: SceneFile = None,
    urdf: UrdfFile = None,
    lock: Lock = None,
    mimic: Mimic = None,
    strict: Strict = False,
    changes: Changes = None,
    every: Annotated[bool, typer.Option("--all", help="Print every mode, not the lowest alone.")] = False,
    plot: Plot = None,
    html: Annotated[Path | None, typer.Option(help="Animation of a mode as one HTML page.")] = None,
    mode: Annotated[int, typer.Option(min=1, help="Which mode the page plays; the lowest is 1.")] = 1,
    json: Json = False,
) -> None:
    """Print the natural frequencies, damping ratios and shapes of small motions about the rest of a scene.

    Frequencies that both directions of a hanging chain share are one line.
    """
    from pendpin.stability.modes import modes as modes_of

    chosen = scene_with(scene, urdf, lock or (), mimic, changes or ())
    refuse_outputs([scene, *files_of(chosen)], plot=plot, html=html)
    with inside(place_named(urdf or scene)):
        print_notes(chosen, strict)
        found = modes_of(chosen)
        found.place(mode)
        print_modes(found, every, json)
        files = [found.save_plot(plot)] if plot else []
        files += [found.animate(mode).save(html)] if html else []
    print_files(files, json)
