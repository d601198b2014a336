"""The commands. They read, call, print and write; the physics is elsewhere."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pendpin.errors import InputError, PendpinError, RunError, inside, one_line

if TYPE_CHECKING:
    from pendpin.crosschecks import Report
    from pendpin.relevance import Relevance
    from pendpin.scene import Scene, Solver
    from pendpin.trajectory import Trajectory

app = typer.Typer(
    name="pendpin",
    help="The 3D compound pendulum and chains of rods: simulate, cross-check, draw, animate.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

SceneFile = Annotated[Path | None, typer.Argument(help="Scene file (TOML); the built-in single rod if absent.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")]


UsageError: Any = typer.BadParameter.__mro__[1]  # its base: whatever is wrong with the command line itself


def main() -> None:
    """Run the command line: every foreseen fault ends in one line on stderr and exit status 1, wrong usage in 2."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # names that no terminal can show
    try:
        sys.exit(app(prog_name="pendpin", standalone_mode=False))
    except PendpinError as error:
        _fail(str(error))
    except UsageError as error:
        _fail_usage(error)
    except KeyboardInterrupt:
        _fail("stopped by the user", 130)
    except BrokenPipeError:  # the reader of our output is gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except MemoryError:
        _fail("out of memory: ask for fewer samples or a smaller model")


def _fail(message: str, status: int = 1) -> None:
    print(f"pendpin: {one_line(message)}", file=sys.stderr)
    sys.exit(status)


def _fail_usage(error: Any) -> None:
    if len(sys.argv) < 2:
        sys.exit(2)  # the help has been printed
    command = error.ctx.command_path if error.ctx else "pendpin"
    _fail(f"{error.format_message().rstrip('.')}; see {command} --help", 2)


@app.command()
def run(
    scene: SceneFile = None,
    method: Annotated[str | None, typer.Option(help="Integration method, such as dop853.")] = None,
    tolerance: Annotated[float | None, typer.Option(help="Relative and absolute tolerance of a step.")] = None,
    step: Annotated[float | None, typer.Option(help="Largest step in s, for methods with a fixed one.")] = None,
    out: Annotated[Path, typer.Option(help="Where the run is saved.")] = Path("run.npz"),
    html: Annotated[Path | None, typer.Option(help="Animation as one HTML page.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Figure: .png, .pdf or .svg.")] = None,
    ledger: Annotated[bool, typer.Option("--ledger", help="Book the work of every effect.")] = False,
    explain: Annotated[bool, typer.Option("--explain", help="Say first what was bound, and what an evaluation calls.")] = False,
    view: Annotated[bool, typer.Option("--view", help="Show the motion in a browser, until Ctrl-C.")] = False,
    json: Json = False,
) -> None:
    """Simulate a scene, save the run, and say what it took and how far it can be trusted.

    Without SCENE the built-in rod is run, and run.html and run.png are written beside run.npz.
    """
    from pendpin.simulation import simulate

    chosen = _scene(scene)
    if scene is None:
        html, plot = html or Path("run.html"), plot or Path("run.png")
    _refuse_targets(scene, out, html, plot)
    _check_options(chosen.solver, method=method, tolerance=tolerance, step=step)
    if explain:
        _print_binding(chosen)
    stopped: RunError | None = None
    with inside(_place(scene)), _progress("integrating", chosen.duration, hidden=json) as watch:
        _print_notes(chosen)
        try:
            trajectory = simulate(chosen, method=method, tolerance=tolerance, step=step, ledger=ledger, watch=watch)
        except RunError as error:
            stopped, trajectory = error, error.partial
    files = [trajectory.save(out)]
    if plot:
        files.append(_save_plot(trajectory, plot))
    if html:
        files.append(_write_page(trajectory, html))
    _print_run(trajectory, files, json)
    if stopped:
        raise stopped
    if view:
        _show(trajectory)


@app.command()
def check(
    scene: SceneFile = None,
    urdf: Annotated[Path | None, typer.Option(help="A URDF in place of a scene, under gravity.")] = None,
    states: Annotated[int, typer.Option(min=1, max=10_000_000, help="How many random states.")] = 1000,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random states.")] = 0,
    json: Json = False,
) -> None:
    """Compute accelerations and reactions at random states by every route, and compare each pair of routes."""
    from pendpin.crosschecks import crosscheck
    from pendpin.effects import Gravity
    from pendpin.scene import Scene, UrdfModel

    if scene is not None and urdf is not None:
        raise typer.BadParameter("give a scene or a URDF, not both")
    chosen = Scene(model=UrdfModel(path=urdf), effects=(Gravity(),)) if urdf else _scene(scene)
    with inside(_place(urdf or scene)):
        _print_notes(chosen)
        report = crosscheck(chosen, states=states, seed=seed)
    _print_check(report, json)
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
    with inside(str(run)):
        if html is None:
            _show(trajectory)
        else:
            _print_files([_write_page(trajectory, html)])


@app.command()
def plot(
    run: Annotated[Path, typer.Argument(help="A saved run (.npz).")],
    out: Annotated[Path | None, typer.Option(help="The picture: .png, .pdf or .svg; RUN.png if absent.")] = None,
) -> None:
    """Draw a saved run: energy, angles and reactions against time."""
    from pendpin.trajectory import Trajectory

    _print_files([_save_plot(Trajectory.load(run), out or run.with_suffix(".png"))])


@app.command()
def effects(
    scene: SceneFile = None,
    accuracy: Annotated[float, typer.Option(help="What counts: tip distance over the chain's length.")] = 1e-3,
    json: Json = False,
) -> None:
    """Say what each effect changes and costs, and which ones the scene calls for at an accuracy."""
    from pendpin.relevance import relevance

    with _waiting("comparing runs with and without each effect", hidden=json):
        found = relevance(_scene(scene), accuracy)
    _print_relevance(found, json)


@app.command()
def urdf(
    scene: Annotated[Path, typer.Argument(help="Scene file (TOML) of a chain.")],
    out: Annotated[Path | None, typer.Option(help="Where to write it; to the terminal if absent.")] = None,
) -> None:
    """Write a chain as a URDF that Pinocchio, MuJoCo and Drake load to the same model."""
    from pendpin.files import write_whole
    from pendpin.scene import Chain
    from pendpin.urdf_chain import chain_urdf

    model = _scene(scene).model
    if not isinstance(model, Chain):
        raise PendpinError(f"{scene}: model.kind: it is a URDF already, {model.path}")
    text = chain_urdf(model)
    if out is None:
        print(text, end="")
    else:
        _print_files([write_whole(out, lambda file: file.write(text.encode()))])


@app.command()
def schema() -> None:
    """Print the JSON schema of a scene, for editors that complete and check TOML."""
    from json import dumps

    from pendpin.scene import Scene

    print(dumps(Scene.model_json_schema(), indent=2))


def _scene(path: Path | None) -> "Scene":
    from pendpin.scene import builtin_scene, load_scene

    return builtin_scene() if path is None else load_scene(path)


def _place(path: Path | None) -> str:
    return str(path or "the built-in rod")


def _check_options(solver: "Solver", **options: Any) -> None:
    """Options that stand in for those of a scene's solver are refused like those, under their own names."""
    try:
        solver.replaced(**{name: value for name, value in options.items() if value is not None})
    except InputError as error:
        name, reason = str(error).split(": ", 1)
        raise typer.BadParameter(reason, param_hint=f"--{name}") from None


def _refuse_targets(scene: Path | None, out: Path, html: Path | None, plot: Path | None) -> None:
    """What cannot be written is said before the work is done."""
    from pendpin.files import refuse_target
    from pendpin.plot import picture_kind

    if plot:
        picture_kind(plot)
    seen = {os.path.realpath(scene)} if scene else set()
    for path in filter(None, (out, html, plot)):
        refuse_target(path)
        if os.path.realpath(path) in seen:
            raise PendpinError(f"{path}: this name is given twice; every file needs its own")
        seen.add(os.path.realpath(path))


def _print_notes(scene: "Scene") -> None:
    from pendpin.model import build

    for note in build(scene.model).notes:
        print(f"pendpin: note: {note}", file=sys.stderr)


def _print_binding(scene: "Scene") -> None:
    from pendpin.dynamics import bind
    from pendpin.explain import explain

    for line in explain(bind(scene), scene.effects):
        print(line)


def _save_plot(trajectory: "Trajectory", path: Path) -> Path:
    from pendpin.plot import save_plot

    return save_plot(trajectory, path)


def _write_page(trajectory: "Trajectory", path: Path) -> Path:
    from pendpin.scenery import drawing_of
    from pendpin.view import write_page

    return write_page(path, drawing_of(trajectory))


def _show(trajectory: "Trajectory") -> None:
    from pendpin.scenery import drawing_of
    from pendpin.view import serve

    serve(drawing_of(trajectory), ready=lambda url: print(f"{url}  (Ctrl-C ends it)", flush=True), open_browser=True)


@contextmanager
def _waiting(what: str, hidden: bool) -> Iterator[None]:
    """A sign of life on stderr, only where a person watches."""
    from rich.console import Console

    console = Console(stderr=True)
    if hidden or not console.is_terminal:
        yield
        return
    with console.status(what):
        yield


@contextmanager
def _progress(what: str, end: float, hidden: bool) -> Iterator[Callable[[float], None]]:
    """A progress bar on stderr, only where a person watches."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=hidden or not console.is_terminal) as progress:
        task = progress.add_task(what, total=end)
        yield lambda t: progress.update(task, completed=t)


def _print_run(trajectory: "Trajectory", files: list[Path], as_json: bool) -> None:
    from dataclasses import asdict

    from pendpin.crosschecks import along

    stats, report = trajectory.stats, along(trajectory)
    if as_json:
        found = {"energy_drift": trajectory.energy().drift, "crosscheck": report and report.worst.relative}
        _print_json(asdict(stats) | found | {"files": [str(file) for file in files]})
        return
    rows = {
        "method": f"{stats.method}, {stats.setting} ({stats.library} {stats.version})",
        "engine": stats.engine,
        "steps": str(stats.steps),
        "evaluations": str(stats.evaluations),
        "seconds": f"{stats.seconds:.4f}",
        "energy drift": f"{trajectory.energy().drift:.1e} of the energy moved" if stats.conservative else "",
        "energy change": "" if stats.conservative else f"{_change(trajectory):+.6g} J",
        "cross-check": report and f"{report.worst.relative:.1e} at worst, {report.worst.quantity} along the run",
        "files": ", ".join(str(file) for file in files),
    }
    rows |= {f"work of {kind}": f"{work[-1]:+.6g} J" for kind, work in trajectory.work.items()}
    if trajectory.work:
        rows["kinetic energy"] = f"{trajectory.kinetic[-1] - trajectory.kinetic[0]:+.6g} J"
        rows["books are off by"] = f"{trajectory.imbalance:.1e} of the energy moved"
    _print_table(["run", ""], [[name, text] for name, text in rows.items() if text])


def _change(trajectory: "Trajectory") -> float:
    total = trajectory.energy().total
    return float(total[-1] - total[0])


def _print_check(report: "Report", as_json: bool) -> None:
    from dataclasses import asdict

    if as_json:
        _print_json(asdict(report) | {"ok": report.ok})
        return
    rows = [
        [
            r.quantity,
            r.place,
            f"{r.first} / {r.second}",
            f"{r.relative:.1e}",
            f"{r.ulps:.1f}",
            str(r.state),
            _verdict(r.ok),
        ]
        for r in report.rows
    ]
    _print_table(["quantity", "of", "routes", "relative", "ulps", "state", ""], rows)
    if found := report.worst_route:
        name, row = found
        place = f"{row.quantity} of {row.place}"
        print(f"farthest from {row.second} ({report.judged} states): {name}, {row.ulps:.1f} ulps in {place}")
    print(f"{report.states} states, bound {report.bound:g} of the terms that enter: {_verdict(report.ok)}")


def _verdict(ok: bool) -> str:
    return "ok" if ok else "BROKEN"


def _print_relevance(found: "Relevance", as_json: bool) -> None:
    from dataclasses import asdict

    if as_json:
        _print_json(asdict(found))
        return
    rows = [
        [row.effect, "yes" if row.listed else "no", f"{row.change:.1e}", _percent(row.share), row.verdict]
        for row in found.rows
    ]
    _print_table(["effect", "in the scene", "change", "share of time", "verdict"], rows)
    if found.horizon < found.duration:
        print(f"compared up to {found.horizon:.3g} s of {found.duration:g} s: beyond, the motion itself is known no better")


def _percent(share: float | None) -> str:
    return "" if share is None else f"{share:.0%}"


def _print_table(head: list[str], rows: list[list[str]]) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(*head, show_header=any(head[1:]))
    for row in rows:
        table.add_row(*map(Text, row))  # no markup in what users named
    console = Console()
    console.print(table)


def _print_json(value: Any) -> None:
    from json import dumps

    print(dumps(value, indent=2, default=str))


def _print_files(files: list[Path]) -> None:
    for file in files:
        print(f"wrote {file}")
