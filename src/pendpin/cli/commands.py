"""The commands. They read, call, print and write; the physics is elsewhere."""

import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pendpin.cli.inputs import (
    check_options,
    files_of,
    lasting,
    place_named,
    print_binding,
    print_notes,
    read_scene,
    refuse_targets,
    scene_with,
)
from pendpin.cli.outputs import save_plot, show_run, write_page, write_run
from pendpin.cli.streams import drop_output, finish_output, prepare_streams, say
from pendpin.cli.sweep import map_, sweep
from pendpin.cli.tables import (
    print_cases,
    print_check,
    print_cost,
    print_diagnosis,
    print_effects,
    print_files,
    print_fit,
    print_hard,
    print_run,
    progress_bar,
    waiting,
)
from pendpin.errors import Halted, Note, PendpinError, RunError, inside, one_line
from pendpin.versions import VERSION

if TYPE_CHECKING:
    pass

app = typer.Typer(
    name="pendpin",
    help="The 3D compound pendulum and chains of rods: simulate, cross-check, draw, animate.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

SceneFile = Annotated[Path | None, typer.Argument(help="Scene file (TOML); the built-in single rod if absent.")]
UrdfFile = Annotated[
    str | None,
    typer.Option(metavar="FILE|NAME", help="A URDF, or a robot by name such as ur5, under gravity, from rest."),
]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Another value in the scene: model.rods[0].mass=2."),
]
Lock = Annotated[list[str] | None, typer.Option(help="NAME=POSITION freezes a joint of the URDF, in rad or m.")]
Mimic = Annotated[str | None, typer.Option(help="Joints of the URDF with <mimic>: free or locked.")]
Strict = Annotated[bool, typer.Option("--strict", help="Refuse a model with findings: inertia that no real body has.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")]


UsageError: Any = typer.BadParameter.__mro__[1]  # its base: whatever is wrong with the command line itself


def main() -> None:
    """Run the command line: every foreseen fault ends in one line on stderr and exit status 1, wrong usage in 2."""
    prepare_streams()
    warnings.simplefilter("ignore", Note)  # the commands print them as lines of their own
    try:
        status = app(prog_name="pendpin", standalone_mode=False)
        if status == 130:  # what newer typers make of Ctrl-C
            raise KeyboardInterrupt
        sys.stdout.flush()
        sys.exit(status)
    except PendpinError as error:
        _fail(str(error))
    except UsageError as error:
        _fail_usage(error)
    except (KeyboardInterrupt, typer.Abort):
        _fail("stopped by the user", 130)
    except BrokenPipeError:  # the reader of our output is gone
        drop_output()
        sys.exit(1)
    except (
        OSError
    ) as error:  # faults of files are raised as InputError; this one is the output, on a full disk or closed
        drop_output()
        _fail(f"{error.filename or 'the output cannot be written'}: {error.strerror or error}")
    except MemoryError:
        _fail("out of memory: ask for fewer samples or a smaller model")


def _fail(message: str, status: int = 1) -> None:
    finish_output()
    say(f"pendpin: {one_line(message)}")
    sys.exit(status)


def _fail_usage(error: Any) -> None:
    if len(sys.argv) < 2:
        sys.exit(2)  # the help has been printed
    command = error.ctx.command_path if error.ctx else "pendpin"
    _fail(f"{error.format_message().rstrip('.')}; see {command} --help", 2)


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"pendpin {VERSION}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """The 3D compound pendulum and chains of rods: simulate, cross-check, draw, animate."""


@app.command()
def run(
    scene: SceneFile = None,
    urdf: UrdfFile = None,
    lock: Lock = None,
    mimic: Mimic = None,
    strict: Strict = False,
    changes: Changes = None,
    duration: Annotated[float | None, typer.Option(help="Duration in s, in place of the scene's.")] = None,
    samples: Annotated[
        int | None, typer.Option(help="Output times from 0 to the end, in place of the scene's.")
    ] = None,
    method: Annotated[str | None, typer.Option(help="Integration method, such as dop853.")] = None,
    tolerance: Annotated[float | None, typer.Option(help="Relative and absolute tolerance of a step.")] = None,
    step: Annotated[float | None, typer.Option(help="Largest step in s, for fixed-step methods.")] = None,
    accuracy: Annotated[
        float | None,
        typer.Option(help="Target accuracy: largest tip error divided by the chain's length."),
    ] = None,
    limit: Annotated[float | None, typer.Option(min=0, help="Stop the run after this time, in s.")] = None,
    checkpoint: Annotated[Path | None, typer.Option(help="Save the state of the run here; continue from it.")] = None,
    every: Annotated[float, typer.Option(min=0, help="Time between two saves of that file, in s.")] = 5.0,
    out: Annotated[Path, typer.Option(help="Where the run is saved: .npz, or .csv for a table.")] = Path("run.npz"),
    html: Annotated[Path | None, typer.Option(help="Animation as one HTML page.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Figure: .png, .pdf or .svg.")] = None,
    energy_balance: Annotated[bool, typer.Option("--energy-balance", help="Compute the work of every effect.")] = False,
    explain: Annotated[bool, typer.Option("--explain", help="Print first what acts in this scene.")] = False,
    view: Annotated[bool, typer.Option("--view", help="Show the motion in a browser, until Ctrl-C.")] = False,
    json: Json = False,
) -> None:
    """Simulate a scene, save the run, and print its cost and its checks.

    Without SCENE the built-in rod is run, and run.html and run.png are written beside run.npz. If a run with
    a checkpoint was killed or stopped, the same command continues it.
    """
    from pendpin.analysis.crosscheck import along
    from pendpin.files import refuse_other_format
    from pendpin.graphics.figure import picture_kind
    from pendpin.simulation.checkpoint import resumable
    from pendpin.simulation.simulate import simulate

    chosen = lasting(scene_with(scene, urdf, lock or (), mimic, changes or ()), duration, samples)
    if scene is None and urdf is None:
        html, plot = html or Path("run.html"), plot or Path("run.png")
    if plot:
        picture_kind(plot)
    refuse_targets([out, html, plot, checkpoint], [scene, *files_of(chosen)])
    if html:
        refuse_other_format(html, ".html")
    refuse_other_format(out, ".npz", ".csv")
    options = {"method": method, "tolerance": tolerance, "step": step, "accuracy": accuracy}
    check_options(chosen.solver, **options)
    if explain:
        print_binding(chosen)
    stopped: RunError | None = None
    with resumable(checkpoint):
        with inside(place_named(urdf or scene)), progress_bar("integrating", chosen.duration, hidden=json) as progress:
            print_notes(chosen, strict)
            options |= {"energy_balance": energy_balance, "limit": limit, "checkpoint": checkpoint, "every": every}
            try:
                trajectory = simulate(chosen, **options, progress=progress)
            except RunError as error:
                stopped, trajectory = error, error.partial
        report = along(trajectory)
        print_run(trajectory, report, write_run(trajectory, out, plot, html), json)
    if checkpoint and not isinstance(stopped, Halted):
        checkpoint.resolve().unlink(missing_ok=True)
    if stopped:
        raise stopped
    if view:
        show_run(trajectory)
    if report and report.fault:
        raise PendpinError(f"the cross-check along the run failed: {report.fault}")


@app.command()
def check(
    scene: SceneFile = None,
    urdf: UrdfFile = None,
    lock: Lock = None,
    mimic: Mimic = None,
    strict: Strict = False,
    changes: Changes = None,
    states: Annotated[int, typer.Option(min=1, max=10_000_000, help="How many random states.")] = 1000,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random states.")] = 0,
    json: Json = False,
) -> None:
    """Compute accelerations and reactions at random states by every route, and compare each pair of routes."""
    from pendpin.analysis.crosscheck import crosscheck

    chosen = scene_with(scene, urdf, lock or (), mimic, changes or ())
    with inside(place_named(urdf or scene)):
        print_notes(chosen, strict)
        report = crosscheck(chosen, states=states, seed=seed)
    print_check(report, json)
    if report.fault:
        raise PendpinError(report.fault)


@app.command()
def view(
    run: Annotated[Path, typer.Argument(help="A saved run (.npz).")],
    html: Annotated[Path | None, typer.Option(help="Write the animation to one HTML page and show nothing.")] = None,
) -> None:
    """Show a saved run in a browser, on this machine only, until Ctrl-C; or write it as one HTML page."""
    from pendpin.trajectory import Trajectory

    trajectory = Trajectory.load(run)
    refuse_targets([html], [run])
    with inside(str(run)):
        if html is None:
            show_run(trajectory)
        else:
            print_files([write_page(trajectory, html)])


@app.command()
def plot(
    run: Annotated[Path, typer.Argument(help="A saved run (.npz).")],
    out: Annotated[Path | None, typer.Option(help="The picture: .png, .pdf or .svg; RUN.png if absent.")] = None,
) -> None:
    """Draw a saved run: energy, angles and reactions against time."""
    from pendpin.trajectory import Trajectory

    trajectory = Trajectory.load(run)
    picture = out or run.with_suffix(".png")
    refuse_targets([picture], [run])
    print_files([save_plot(trajectory, picture)])


@app.command()
def effects(
    scene: SceneFile = None,
    accuracy: Annotated[
        float, typer.Option(help="Smallest change that matters: tip distance over the chain's length.")
    ] = 1e-3,
    json: Json = False,
) -> None:
    """Show what each effect changes and costs, and which effects the scene needs at an accuracy."""
    from pendpin.analysis.significance import significance

    with waiting("comparing runs with and without each effect", hidden=json):
        found = significance(read_scene(scene), accuracy)
    print_effects(found, json)


@app.command()
def cost(
    scene: SceneFile = None,
    methods: Annotated[str | None, typer.Option(help="Methods, separated by commas; all if absent.")] = None,
    accuracy: Annotated[
        float, typer.Option(help="Accuracy of interest: tip error divided by the chain's length.")
    ] = 1e-9,
    peers: Annotated[bool, typer.Option("--peers", help="Measure MuJoCo, Drake and plain SciPy too.")] = False,
    budget: Annotated[float, typer.Option(min=0, help="The longest run of a method, in s.")] = 1.0,
    plot: Annotated[Path | None, typer.Option(help="Figure: .png, .pdf or .svg.")] = None,
    json: Json = False,
) -> None:
    """Show error against time for every integrator, and the cheapest one at each accuracy."""
    from pendpin.analysis.work_precision import METHODS
    from pendpin.analysis.work_precision import cost as measure
    from pendpin.analysis.work_precision_figure import save_cost_plot
    from pendpin.graphics.figure import picture_kind

    chosen = read_scene(scene)
    if plot:
        picture_kind(plot)
        refuse_targets([plot], [scene, *files_of(chosen)])
    with inside(place_named(scene)), waiting("the reference", hidden=json) as progress:
        names = [name.strip() for name in methods.split(",")] if methods else METHODS
        report = measure(chosen, methods=names, accuracy=accuracy, peers=peers, budget=budget, progress=progress)
    print_cost(report, json)
    if plot:
        print_files([save_cost_plot(report, plot)])
    if report.interrupted:
        raise KeyboardInterrupt


@app.command()
def fit(
    scene: Annotated[Path, typer.Argument(help="Scene file (TOML) with guesses and a [data] table.")],
    data: Annotated[list[Path], typer.Argument(help="Measured swings: one CSV file or several.")],
    free: Annotated[
        str, typer.Option(help='Key paths, separated by commas, or "physics" (inertias, frictions, drags), "friction".')
    ] = "physics",
    hold_out: Annotated[list[Path] | None, typer.Option(help="CSV of other swings, to be predicted.")] = None,
    hold_out_start: Annotated[
        float, typer.Option(help="Part of each held-out swing on which its start is fitted; the rest is compared.")
    ] = 0.1,
    explain_residual: Annotated[
        bool, typer.Option("--explain-residual", help="Fit without each part of the model, and with parts it lacks.")
    ] = False,
    robust: Annotated[bool, typer.Option("--robust", help="Let outliers count less.")] = False,
    out: Annotated[Path | None, typer.Option(help="The fitted scene (TOML).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Figure: .png, .pdf or .svg.")] = None,
    json: Json = False,
) -> None:
    """Fit free numbers of a scene to measured swings: values with errors, and what the data cannot tell."""
    from pendpin.analysis.fit import explain_residual as explained
    from pendpin.analysis.fit import fit as fitted
    from pendpin.graphics.figure import picture_kind

    chosen = read_scene(scene)
    if plot:
        picture_kind(plot)
    refuse_targets([out, plot], [scene, *data, *(hold_out or []), *files_of(chosen)])
    with inside(str(scene)), waiting("fitting", hidden=json) as progress:
        found = fitted(chosen, data, free, hold_out, hold_out_start, robust=robust, progress=progress)
        if explain_residual:
            found = explained(found, progress)
    print_fit(found, json)
    files = [chosen_file for chosen_file in (out and found.scene.save(out), plot and found.plot(plot)) if chosen_file]
    if files and not json:
        print_files(files)


@app.command()
def hard(
    cases: Annotated[list[str] | None, typer.Argument(help="Names of cases; all if absent.")] = None,
    listed: Annotated[bool, typer.Option("--list", help="Name the cases, and run none.")] = False,
    short: Annotated[bool, typer.Option("--short", help="The short forms, as in the tests.")] = False,
    peers: Annotated[
        bool, typer.Option("--peers", help="Run the short forms in MuJoCo, Drake and plain SciPy.")
    ] = False,
    json: Json = False,
) -> None:
    """Run the hard cases (docs/hard_cases.md), each on its methods against its bound."""
    from pendpin.analysis.hardcases import CASES
    from pendpin.analysis.hardcases import hard as run_cases

    if listed:
        print_cases(list(CASES.values()), json)
        return
    with waiting("the hard cases", hidden=json) as progress:
        report = run_cases(cases or (), full=not short, peers=peers, progress=progress)
    print_hard(report, json)
    if report.stopped:
        raise KeyboardInterrupt
    if report.fault:
        raise PendpinError(report.fault)


@app.command()
def doctor(
    file: Annotated[Path, typer.Argument(help="Equations: LaTeX, Markdown, plain text, or TOML with [equations].")],
    rod: Annotated[str | None, typer.Option(help="thin, uniform or general; the symbols tell if absent.")] = None,
    convention: Annotated[
        str | None, typer.Option(help="theta-ccw, phi-reversed, z-up, swapped, with commas; found if absent.")
    ] = None,
    html: Annotated[Path | None, typer.Option(help="The report as one HTML page.")] = None,
    json: Json = False,
) -> None:
    """Say which printed equation of a rod is wrong, and which change corrects it.

    The exit status is 0 only if some equation could be read and all that could hold.
    """
    from pendpin.analysis.doctor.diagnose import diagnose_file

    refuse_targets([html], [file])
    with waiting("reading", hidden=json) as progress:
        diagnosis = diagnose_file(file, rod, convention, progress)
    print_diagnosis(diagnosis, json)
    if html:
        from pendpin.analysis.doctor.reports.page import write_report

        files = [write_report(html, diagnosis)]
        if not json:
            print_files(files)
    if not diagnosis.ok:
        raise typer.Exit(1)


@app.command()
def urdf(
    scene: Annotated[Path, typer.Argument(help="Scene file (TOML) of a chain.")],
    out: Annotated[Path | None, typer.Option(help="Where to write it; to the terminal if absent.")] = None,
) -> None:
    """Write a chain as a URDF that Pinocchio, MuJoCo and Drake load to the same model."""
    from pendpin.files import write_whole
    from pendpin.model.write_urdf import chain_urdf
    from pendpin.scene import Chain

    model = read_scene(scene).model
    if not isinstance(model, Chain):
        raise PendpinError(
            f"{scene}: model.kind: the model is a URDF file already: {getattr(model, 'file', 'a pin.Model')}"
        )
    refuse_targets([out], [scene])
    text = chain_urdf(model)
    if out is None:
        print(text, end="")
    else:
        print_files([write_whole(out, lambda file: file.write(text.encode()))])


@app.command()
def new(
    example: Annotated[
        str, typer.Argument(help="Its name, such as crane; `pendpin new --list` names all.")
    ] = "single_rod",
    listed: Annotated[bool, typer.Option("--list", help="Name the examples.")] = False,
) -> None:
    """Print a commented example scene, to be changed: pendpin new crane > my.toml."""
    from pendpin.scene.examples import example_names, example_text

    print("\n".join(example_names()) if listed else example_text(example), end="\n" if listed else "")


@app.command()
def schema() -> None:
    """Print the JSON schema of a scene, for editors that complete and check TOML."""
    from json import dumps

    from pendpin.scene import Scene

    print(dumps(Scene.model_json_schema(), indent=2))


app.command()(sweep)
app.command("map")(map_)
