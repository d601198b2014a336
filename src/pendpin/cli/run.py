"""Runs and scenes: simulate, show a saved run, draw it, write a model:
pendpin run, view, plot, urdf, reference, new, schema."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from typer import Argument, BadParameter, Option

from pendpin.cli import inputs
from pendpin.cli.outputs import print_files, print_report, progress_bar, refuse_outputs, say, working
from pendpin.errors import Halted, PendpinError, RunError, inside
from pendpin.ground.files import write_whole


@inputs.on_scene
def run(
    chosen: inputs.SceneInput,
    duration: Annotated[float | None, Option(help="Duration in s, in place of the scene's.")] = None,
    samples: Annotated[int | None, Option(help="Output times from 0 to the end, in place of the scene's.")] = None,
    method: inputs.Method = None,
    tolerance: inputs.Tolerance = None,
    step: Annotated[float | None, Option(help="Step in s, for fixed-step methods.")] = None,
    accuracy: inputs.Accuracy = None,
    limit: Annotated[float | None, Option(min=0, help="Stop the run after this time in s, with compiling.")] = None,
    checkpoint: Annotated[Path | None, Option(help="Save the state of the run here; continue from it.")] = None,
    every: Annotated[float | None, Option(min=0, help="Time between two saves of that file in s; 5 if absent.")] = None,
    out: Annotated[Path, Option(help="Where the run is saved: .npz, or .csv for a table.")] = Path("run.npz"),
    html: Annotated[Path | None, Option(help="Animation as one HTML page.")] = None,
    plot: inputs.Plot = None,
    energy_balance: Annotated[bool, Option("--energy-balance", help="Compute the work of every effect.")] = False,
    anyway: Annotated[bool, Option("--anyway", help="Continue when the energy goes wrong; a note says when.")] = False,
    view: Annotated[bool, Option("--view", help="Show the motion in a browser, until Ctrl-C.")] = False,
    json: inputs.Json = False,
) -> None:
    """Simulate a scene, save the run, and print its cost and its checks.

    Without SCENE the built-in rod is run, and run.html and run.png are written beside run.npz.

    If a run with a checkpoint was killed or stopped, the same command continues it.
    """
    from pendpin.graphics.figure import save_plot
    from pendpin.graphics.report import run_report
    from pendpin.graphics.view import Animation
    from pendpin.motions.crosschecks.crosscheck import crosscheck_run
    from pendpin.motions.trajectory import simulate
    from pendpin.runs.checkpoint import EVERY, resumable

    inputs.refuse_alone(every is not None and not checkpoint, "--every", "--checkpoint FILE, which it saves so often")
    scene = inputs.with_duration(chosen.scene, duration, samples)
    chosen = replace(chosen, scene=scene)
    if chosen.path is None and chosen.urdf is None:
        html, plot = html or Path("run.html"), plot or Path("run.png")
    refuse_outputs(chosen.files, plot=plot, html=html, run=out, checkpoint=checkpoint)
    settings = {"method": method, "tolerance": tolerance, "step": step, "accuracy": accuracy}
    with inputs.naming_options():
        scene.solver.with_settings(**settings)
    settings |= {"energy_balance": energy_balance, "limit": limit, "checkpoint": checkpoint, "anyway": anyway}
    settings |= {"every": EVERY if every is None else every}
    with resumable(checkpoint):
        with chosen.noted(), progress_bar("integrating", scene.duration, hidden=json) as progress:
            try:
                trajectory, stopped = simulate(scene, **settings, progress=progress), None
            except RunError as error:
                trajectory, stopped = error.partial, error
                if scene.duration and not trajectory.stats.steps and not isinstance(error, Halted):
                    raise  # it did not begin: there is nothing to save
        report = crosscheck_run(trajectory)
        files = [trajectory.to_csv(out) if out.suffix.lower() == ".csv" else trajectory.save(out)]
        files += [save_plot(trajectory, plot)] if plot else []
        animation = Animation(trajectory, check=lambda run: report.verdict if report else "")  # which was made once
        files += [animation.save(html)] if html else []
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
        _show_live(animation)
    if report and report.fault:
        raise PendpinError(f"the cross-check along the run failed: {report.fault}")


def view(
    runs: Annotated[list[Path], Argument(metavar="RUN", help="Saved runs (.npz), up to 4; the later ones as ghosts.")],
    html: Annotated[Path | None, Option(help="Write the animation to one HTML page and show nothing.")] = None,
    film: Annotated[Path | None, Option(help="Write a film, .gif or .mp4, and show nothing.")] = None,
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
            _show_live(animation)


def _show_live(animation: Any) -> None:
    """Show the motion of a run in a browser until Ctrl-C."""
    from pendpin.graphics.view import serve

    drawing, report = animation.drawing_and_report()
    serve(drawing, lambda url: print(f"{url}  (Ctrl-C ends it)", flush=True), report, open_browser=True)


def plot(
    run: Annotated[Path, Argument(help="A saved run (.npz).")],
    names: Annotated[
        list[str] | None,
        Argument(metavar="NAME", help="Quantities to draw, such as theta_1 R3_2; the whole figure if absent."),
    ] = None,
    compare: Annotated[list[Path] | None, Option(help="A saved run to be drawn over it; may be repeated.")] = None,
    out: Annotated[Path | None, Option(help="File for the figure (.png, .pdf or .svg); RUN.png if absent.")] = None,
) -> None:
    """Draw a saved run: energy, angles, reactions and the path of the tip, or quantities by name, such as energy_drift."""
    from pendpin.graphics.figure import save_plot
    from pendpin.motions.trajectory import Trajectory

    trajectory = Trajectory.load(run)
    picture = out or run.with_suffix(".png")
    refuse_outputs([run, *(compare or ())], plot=picture)
    others = [Trajectory.load(other) for other in compare or ()]
    print_files([save_plot(trajectory, picture, tuple(names or ()), others)])


def urdf(
    scene: Annotated[Path | None, Argument(help="Scene file (TOML) of a chain.")] = None,
    out: Annotated[Path | None, Option(help="Where to write the URDF; on the terminal if absent.")] = None,
    listed: Annotated[bool, Option("--list", help="List the robots that --urdf and model.name know.")] = False,
) -> None:
    """Write a chain as a URDF that Pinocchio, MuJoCo and Drake load to the same model; or list the robots by name."""
    from pendpin.model.write_models import chain_urdf
    from pendpin.scene import Chain, load_scene
    from pendpin.scene.models import robot_files

    if listed:
        print("\n".join(robot_files()))
        return
    if scene is None:
        raise BadParameter("give the scene of a chain, or --list")
    if not (scene.suffix or scene.exists()) and scene.name in robot_files():
        file = robot_files()[scene.name]
        raise PendpinError(f"{scene}: this robot has a URDF already, {file}; pendpin run --urdf {scene} runs it")
    model = load_scene(scene).model
    if not isinstance(model, Chain):
        reason = f"{scene}: model.kind: the model is a URDF file already: {getattr(model, 'file', 'a pin.Model')}"
        raise PendpinError(reason)
    refuse_outputs([scene], urdf=out)
    text = chain_urdf(model)
    if out is None:
        print(text, end="")
    else:
        print_files([write_whole(out, lambda file: file.write(text.encode()))])


@inputs.on_scene
def reference(
    chosen: inputs.SceneInput,
    out: Annotated[Path, Option(help="A new folder for the model files and the numbers.")],
    seed: Annotated[int, Option(min=0, help="Seed of the random states.")] = 0,
    limit: inputs.Limit = None,
    json: inputs.Json = False,
) -> None:
    """Write a model as URDF, MJCF and SDF with reference numbers and error bounds, for another engine's tests."""
    from pendpin.verification.agreement.reference import write_reference

    with working("numbers in 50 digits", limit, json), chosen.noted() as scene:
        made = write_reference(scene, out, seed)
    print_report(made, json)


def new(
    example: Annotated[str, Argument(help="An example, such as crane; `pendpin new --list` lists all.")] = "single_rod",
    listed: Annotated[bool, Option("--list", help="List the examples with their titles.")] = False,
) -> None:
    """Print a commented example scene, to be changed: pendpin new crane > my.toml.

    A file that the scene names, such as the track of a trolley, is put into the working folder, if it is not there.
    """
    from tomllib import loads

    from pendpin.scene.toml import example_names, read_example

    if listed:
        names = example_names()
        width = max(map(len, names))
        print("\n".join(f"{name:{width}}  {loads(read_example(name)[0])['title']}" for name in names))
        return
    text, files = read_example(example)
    for file in files:  # one of that name stays as it is, and that is said
        target, content = Path(file.name), file.read_bytes()
        if not target.exists():
            written = write_whole(target, lambda out, content=content: out.write(content))
            say(f"pendpin: wrote {written}, which the scene reads")
        elif target.read_bytes() != content:
            say(f"pendpin: note: {target} is there already, and is not that of the example")
    print(text, end="")


def schema() -> None:
    """Print the JSON schema of a scene, for editors that complete and check TOML."""
    from json import dumps

    from pendpin.scene import Scene

    print(dumps(Scene.model_json_schema(), indent=2))
