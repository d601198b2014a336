"""Whether rests and driven motions are stable: pendpin stability."""

from typing import Annotated

import typer

from pendpin.cli.inputs import files_of, place_named, print_notes, scene_with
from pendpin.cli.options import Changes, Json, Lock, Mimic, Plot, SceneFile, Strict, UrdfFile
from pendpin.cli.outputs import refuse_outputs
from pendpin.cli.tables import print_exponents, print_files, print_stability
from pendpin.errors import inside


def stability(
    scene: SceneFile = None,
    urdf: UrdfFile = None,
    lock: Lock = None,
    mimic: Mimic = None,
    strict: Strict = False,
    changes: Changes = None,
    lyapunov: Annotated[
        bool, typer.Option("--lyapunov", help="The Lyapunov exponents of the motion from the start, over its duration.")
    ] = False,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Print the rests of a scene and whether they are stable; with a drive, the multipliers of its periodic motion.

    --lyapunov adds the Lyapunov exponents of the motion, each with its error; --plot then draws their estimates over time.
    """
    from pendpin.stability.lyapunov import lyapunov as exponents_of
    from pendpin.stability.report import stability as report_on

    chosen = scene_with(scene, urdf, lock or (), mimic, changes or ())
    refuse_outputs([scene, *files_of(chosen)], plot=plot)
    if plot and not lyapunov:
        raise typer.BadParameter("it draws Lyapunov exponents: give --lyapunov too", param_hint="--plot")
    with inside(place_named(urdf or scene)):
        print_notes(chosen, strict)
        if not lyapunov:
            print_stability(report_on(chosen), json)
            return
        found = exponents_of(chosen)
    print_exponents(found, json)
    if plot:
        found.plot().figure.savefig(plot)
        print_files([plot], json)
