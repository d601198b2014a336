"""What a scene does: pendpin stability, modes, effects, section, bifurcation."""

from pathlib import Path
from typing import Annotated

from typer import BadParameter, Option

from pendpin.cli.inputs import (
    Json,
    Limit,
    Plot,
    SceneInput,
    flag,
    naming_options,
    on_scene,
    refuse_alone,
    split_at_commas,
)
from pendpin.cli.outputs import print_files, print_report, refuse_outputs, working
from pendpin.errors import InputError, PendpinError


@on_scene
def stability(
    chosen: SceneInput,
    lyapunov: Annotated[
        bool, flag("--lyapunov", help="The Lyapunov exponents of the motion from the start, over its duration.")
    ] = False,
    planar: Annotated[
        bool, flag("--planar", help="With --lyapunov: only changes in the plane in which the motion stays.")
    ] = False,
    period: Annotated[float | None, Option(help="Period in s of the motion; that of the drive if absent.")] = None,
    limit: Limit = None,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Print the rests of a scene and whether they are stable; with a drive, the multipliers of its periodic motion.

    --lyapunov adds the Lyapunov exponents of the motion, each with its error; --plot then draws their estimates over time.
    """
    from pendpin.graphics.style import write_figure
    from pendpin.stability.linearize import stability as report_on
    from pendpin.stability.lyapunov import Lyapunov
    from pendpin.stability.lyapunov import lyapunov as exponents_of

    refuse_outputs(chosen.files, plot=plot)
    refuse_alone(
        (plot or planar) and not lyapunov, "--plot" if plot else "--planar", "--lyapunov, whose exponents it is of"
    )
    what = "the exponents" if lyapunov else "the rests"
    with chosen.noted() as scene, working(what, limit, json), naming_options("period"):
        found = exponents_of(scene, planar=planar) if lyapunov else report_on(scene, period)
    print_report(found.report(), json)
    if plot and isinstance(found, Lyapunov):
        print_files([write_figure(plot, lambda: found.plot().figure)], json)


@on_scene
def modes(
    chosen: SceneInput,
    every: Annotated[bool, flag("--all", help="Print every mode, not the lowest alone.")] = False,
    plot: Plot = None,
    html: Annotated[Path | None, Option(help="Animation of a mode as one HTML page.")] = None,
    mode: Annotated[int | None, Option(min=1, help="Which mode the page plays; the lowest, 1, if absent.")] = None,
    limit: Limit = None,
    json: Json = False,
) -> None:
    """Print the natural frequencies, damping ratios and shapes of small motions about the rest of a scene.

    Frequencies that both directions of a hanging chain share are one line.
    """
    from pendpin.stability.modes import MOST_ROWS
    from pendpin.stability.modes import modes as modes_of

    refuse_alone(mode is not None and html is None, "--mode", "--html FILE, the page that plays it")
    refuse_outputs(chosen.files, plot=plot, html=html)
    with chosen.noted() as scene:
        with working("the modes", limit, json):
            result = modes_of(scene)
        result.place(mode := mode or 1)
        print_report(result.report(None if every else MOST_ROWS), json)
        files = [result.save_plot(plot)] if plot else []
        files += [result.animate(mode).save(html)] if html else []
    print_files(files, json)


@on_scene
def effects(
    chosen: SceneInput,
    accuracy: Annotated[
        float, Option(help="Smallest change that matters: tip distance over the chain's length.")
    ] = 1e-3,
    thorough: Annotated[
        bool, flag("--thorough", help="Compare over the full duration, however long that takes.")
    ] = False,
    limit: Limit = None,
    json: Json = False,
) -> None:
    """Show what each effect changes and costs, and which effects the scene needs at an accuracy."""
    from pendpin.sweeps.significance import significance

    what = "runs with and without each effect"
    with working(what, limit, json), chosen.noted() as scene, naming_options("accuracy"):
        report = significance(scene, accuracy, thorough)
    print_report(report.report(), json)


# --- Poincaré sections and bifurcation diagrams: pendpin section, pendpin bifurcation ---------------------------------

Of = Annotated[list[str], Option(help="Quantities to note, with commas: theta_2,theta_2_rate.")]
Skip = Annotated[int, Option(min=0, help="Points of each motion before the first that counts.")]


@on_scene
def section(
    chosen: SceneInput,
    at: Annotated[str, Option(help='Where: "theta_1 = 0, rising"; falling and both are other ways.')],
    of: Of,
    count: Annotated[int, Option(min=1, help="Points of each motion.")] = 300,
    skip: Skip = 0,
    starts: Annotated[int, Option(min=1, help="Motions; more than one need --energy.")] = 1,
    energy: Annotated[float | None, Option(help="Energy in J of starts that are drawn on the section.")] = None,
    seed: Annotated[int, Option(help="Seed of the starts.")] = 0,
    limit: Limit = None,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Print and draw a Poincaré section: a motion, or many of one energy, where a quantity crosses a level."""
    from pendpin.graphics.style import write_figure
    from pendpin.stability.sections import portrait
    from pendpin.stability.sections.points import read_crossing

    refuse_outputs(chosen.files, plot=plot)
    with naming_options("at", "of", "count", "skip", "starts", "energy"):
        place = read_crossing(at, tuple(filter(None, split_at_commas(of))), count, skip)
    if plot and len(place.of) != 2:
        raise BadParameter("--plot draws two quantities: give --of two names", param_hint="--of")
    with chosen.noted() as scene, working("the section", limit, json):
        drawn = portrait(scene, place, starts, energy, seed)
    print_report(report := drawn.report(), json)
    if report.fault:
        raise PendpinError(report.fault)
    if plot:
        print_files([write_figure(plot, lambda: drawn.plot().figure)], json)


@on_scene
def bifurcation(
    chosen: SceneInput,
    vary: Annotated[list[str], Option(help="A number and its values: KEY=FROM:TO:COUNT.")],
    of: Of,
    strobe: Annotated[float | None, Option(help="Period in s of the strobe; that of the drive if absent.")] = None,
    count: Annotated[int, Option(min=1, help="Points of each motion.")] = 100,
    skip: Skip = 200,
    limit: Limit = None,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Print and draw a bifurcation diagram: points once a period, the state carried from value to value, up and down."""
    from pendpin.graphics.style import write_figure
    from pendpin.stability.sections import bifurcation as diagram_of
    from pendpin.stability.sections import strobe as strobe_of
    from pendpin.sweeps.plan import read_axes

    refuse_outputs(chosen.files, plot=plot)
    with naming_options("vary", "of", "count", "skip"):
        if len(vary) > 1:
            raise InputError(f"vary: a diagram has one number, not {len(vary)}; a sweep varies several")
        ((key, values),) = read_axes(vary).items()
        if strobe is not None and not 0 < strobe < float("inf"):
            raise BadParameter(f"{strobe} is not a number of seconds above 0", param_hint="--strobe")
        place = strobe_of(strobe, of=tuple(filter(None, split_at_commas(of))), count=count, skip=skip)
    with chosen.noted() as scene, working("the diagram", limit, json):
        diagram = diagram_of(scene, key, values, place)
    print_report(report := diagram.report(), json)
    if report.fault:
        raise PendpinError(report.fault)
    if plot:
        print_files([write_figure(plot, lambda: diagram.plot().figure)], json)
