"""Simulate a scene: pendpin run."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pendpin.cli.inputs import SceneInput, lasting, naming_options, on_scene
from pendpin.cli.options import Accuracy, Json, Method, Plot, Tolerance
from pendpin.cli.outputs import refuse_outputs, show_live, write_run
from pendpin.cli.printing import print_files, print_report
from pendpin.cli.progress import progress_bar
from pendpin.errors import Halted, PendpinError, RunError

if TYPE_CHECKING:
    from pendpin.motions.trajectory import Trajectory
    from pendpin.scene import Scene


@on_scene
def run(
    chosen: SceneInput,
    duration: Annotated[float | None, typer.Option(help="Duration in s, in place of the scene's.")] = None,
    samples: Annotated[
        int | None, typer.Option(help="Output times from 0 to the end, in place of the scene's.")
    ] = None,
    method: Method = None,
    tolerance: Tolerance = None,
    step: Annotated[float | None, typer.Option(help="Step in s, for fixed-step methods.")] = None,
    accuracy: Accuracy = None,
    limit: Annotated[
        float | None, typer.Option(min=0, help="Stop the run after this time in s, with compiling.")
    ] = None,
    checkpoint: Annotated[Path | None, typer.Option(help="Save the state of the run here; continue from it.")] = None,
    every: Annotated[float, typer.Option(min=0, help="Time between two saves of that file, in s.")] = 5.0,
    out: Annotated[Path, typer.Option(help="Where the run is saved: .npz, or .csv for a table.")] = Path("run.npz"),
    html: Annotated[Path | None, typer.Option(help="Animation as one HTML page.")] = None,
    plot: Plot = None,
    energy_balance: Annotated[bool, typer.Option("--energy-balance", help="Compute the work of every effect.")] = False,
    anyway: Annotated[
        bool, typer.Option("--anyway", help="Continue when the energy goes wrong; a note says from when.")
    ] = False,
    explain: Annotated[bool, typer.Option("--explain", help="Print the effects that act in this scene.")] = False,
    view: Annotated[bool, typer.Option("--view", help="Show the motion in a browser, until Ctrl-C.")] = False,
    json: Json = False,
) -> None:
    """Simulate a scene, save the run, and print its cost and its checks.

    Without SCENE the built-in rod is run, and run.html and run.png are written beside run.npz.

    If a run with a checkpoint was killed or stopped, the same command continues it.
    """
    from pendpin.dynamics.dynamics import bind
    from pendpin.dynamics.explanation import explain as explain_run
    from pendpin.graphics.report import run_report
    from pendpin.motions.crosschecks.crosscheck import crosscheck_run
    from pendpin.runs.checkpoint import resumable

    scene = lasting(chosen.scene, duration, samples)
    chosen = replace(chosen, scene=scene)
    if chosen.path is None and chosen.urdf is None:
        html, plot = html or Path("run.html"), plot or Path("run.png")
    refuse_outputs(chosen.files, plot=plot, html=html, run=out, checkpoint=checkpoint)
    settings = {"method": method, "tolerance": tolerance, "step": step, "accuracy": accuracy}
    with naming_options():
        scene.solver.replaced(**settings)
    settings |= {"energy_balance": energy_balance, "limit": limit, "checkpoint": checkpoint, "every": every}
    settings |= {"anyway": anyway}
    with resumable(checkpoint):
        with chosen.noted(), progress_bar("integrating", scene.duration, hidden=json) as progress:
            trajectory, stopped = _simulated(scene, settings, progress)
        if explain and not json:
            for line in explain_run(bind(scene), trajectory.stats):
                print(line)
        report = crosscheck_run(trajectory)
        files = write_run(trajectory, out, plot, html)
        answer = run_report(trajectory, report.verdict if report else "")
        checks = {"crosscheck": report and report.worst.relative, "crosscheck_ok": report and report.ok}
        data = answer.data | checks | {"files": [str(file) for file in files]}
        print_report(replace(answer, data=data), json)
        print_files(files, json)
    if checkpoint and not isinstance(stopped, Halted):
        checkpoint.resolve().unlink(missing_ok=True)
    if stopped:
        raise stopped
    if view:
        show_live(trajectory.animate())
    if report and report.fault:
        raise PendpinError(f"the cross-check along the run failed: {report.fault}")


def _simulated(
    scene: "Scene", settings: dict[str, Any], progress: Callable[[float], None]
) -> tuple["Trajectory", RunError | None]:
    """The run, and why it ended early if it did."""
    from pendpin.motions.simulate import simulate

    try:
        return simulate(scene, **settings, progress=progress), None
    except RunError as error:
        return error.partial, error
