"""The tools, a command each: what a result is worth and what it costs (check, hard, validate, cost, doctor); what a scene
does (stability, modes, effects, section, bifurcation)."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from typer import Argument, BadParameter, Exit, Option

from pendpin.cli import inputs
from pendpin.cli.outputs import finish, limited, print_report, refuse_outputs, reported, waiting, working
from pendpin.errors import InputError
from pendpin.ground.files import write_whole


@inputs.on_scene
def check(
    chosen: inputs.SceneInput,
    states: Annotated[int, Option(min=1, max=10_000_000, help="How many random states.")] = 1000,
    seed: Annotated[int, Option(min=0, help="Seed of the random states.")] = 0,
    every_row: Annotated[bool, Option("--all", help="Print every pair of routes in every quantity too.")] = False,
    limit: inputs.Limit = None,
    json: inputs.Json = False,
) -> None:
    """Compute accelerations and reactions at random states by every route, and compare each pair of routes.

    The table has a line for each route and a column for each quantity, with the worst difference in each cell.
    """
    from pendpin.motions.crosschecks.crosscheck import crosscheck

    with working(f"{states} states by every route", limit, json), chosen.noted() as scene:
        report = crosscheck(scene, states=states, seed=seed)
    print_report(report.report(every_row), json)
    finish(report.fault)


def hard(
    cases: Annotated[list[str] | None, Argument(metavar="CASE", help="Names of cases; all if absent.")] = None,
    listed: Annotated[bool, Option("--list", help="List the cases and run none.")] = False,
    short: Annotated[bool, Option("--short", help="Run the short forms, as the tests do.")] = False,
    peers: Annotated[bool, Option("--peers", help="Run the short forms in MuJoCo, Drake and plain SciPy.")] = False,
    limit: inputs.Limit = None,
    json: inputs.Json = False,
) -> None:
    """Run the hard cases (docs/hard_cases.md), each on its methods against its bound."""
    from pendpin.verification.hardcases import catalogue_report
    from pendpin.verification.hardcases import hard as run_cases

    if listed:
        print_report(catalogue_report(), json)
        return
    with limited(limit) as work:
        with waiting("the hard cases", json, work) as progress:
            report = run_cases(cases or (), full=not short, peers=peers, progress=progress)
        print_report(report.report(), json)
    finish(report.fault, report.stopped)


def validate(
    cases: Annotated[list[str] | None, Argument(metavar="CASE", help="Names of cases; all if absent.")] = None,
    listed: Annotated[bool, Option("--list", help="List the cases with their sources and run none.")] = False,
    methods: Annotated[list[str] | None, Option(help="Methods, with commas; all that run a case if absent.")] = None,
    html: Annotated[Path | None, Option(help="A page with the table, the motions and the sources.")] = None,
    limit: inputs.Limit = None,
    json: inputs.Json = False,
) -> None:
    """Compare runs with published results of ADAMS, Dymola, OpenSim, benchmarks and closed forms (docs/agreement.md).

    The table has a line for each published quantity, with the method that differs most.
    """
    from pendpin.verification.agreement import agreement_page, sources_report
    from pendpin.verification.agreement import validate as compare

    if listed:
        print_report(sources_report(), json)
        return
    chosen = inputs.split_at_commas(methods) or None
    with limited(limit) as work:
        with waiting("the published cases", json, work) as progress:
            report = compare(cases or (), chosen, progress)
        with reported(report.report(), json) as files:
            files += [write_whole(html, lambda file: file.write(agreement_page(report).encode()))] if html else []
    finish(report.fault, report.stopped)


@inputs.on_scene
def cost(
    chosen: inputs.SceneInput,
    duration: Annotated[float | None, Option(help="Duration in s, in place of the scene's.")] = None,
    methods: Annotated[
        list[str] | None, Option(help='Methods, separated by commas: as run takes them, or "dop853 not compiled".')
    ] = None,
    accuracy: Annotated[float, Option(help="Accuracy of interest: tip error divided by the chain's length.")] = 1e-9,
    peers: Annotated[bool, Option("--peers", help="Measure MuJoCo, Drake and plain SciPy too.")] = False,
    thorough: Annotated[bool, Option("--thorough", help="All methods, all settings, over the full duration.")] = False,
    budget: Annotated[float, Option(min=0, help="Stop measuring a method when its run takes longer, in s.")] = 1.0,
    plot: inputs.Plot = None,
    limit: inputs.Limit = None,
    json: inputs.Json = False,
) -> None:
    """Find the fastest method for each accuracy and its run time, in about 20 s. --thorough: a work-precision diagram."""
    from pendpin.verification.work_precision.cost import cost as measure

    refuse_outputs(chosen.files, plot=plot)
    options = {"accuracy": accuracy, "peers": peers, "thorough": thorough, "budget": budget}
    chosen = replace(chosen, scene=inputs.with_duration(chosen.scene, duration, None))
    with limited(limit) as work:
        asked = inputs.naming_options("methods", "accuracy")
        with waiting("the reference", json, work) as progress, chosen.noted() as scene, asked:
            report = measure(scene, methods=inputs.split_at_commas(methods) or None, **options, progress=progress)
        with reported(report.report(), json) as files:
            files += [report.plot(plot)] if plot else []
    finish(None, report.interrupted)


def doctor(
    file: Annotated[
        Path, Argument(help="Equations: LaTeX, Markdown, plain text, or TOML with a table named equations.")
    ],
    rod: Annotated[
        str | None,
        Option(
            help="point, thin, uniform, symmetric or general; or plane, moved, elastic, pulled, double, triple, acrobot, "
            "cart-pole, cart-double, polar, conical, turning, coupled, furuta. Found if absent."
        ),
    ] = None,
    convention: Annotated[
        list[str] | None,
        Option(
            help="theta-ccw, phi-reversed, z-up, z-mirrored, swapped, b3-up, transposed, separated by commas; or standard. "
            "Found if absent."
        ),
    ] = None,
    symbols: Annotated[
        list[str] | None, Option(help="The meaning of the text's own symbols, as in alpha=theta,A=J_1.")
    ] = None,
    scene: Annotated[Path | None, Option(help="A scene of a chain of rods that the equations describe.")] = None,
    html: Annotated[Path | None, Option(help="Where to write the report as one HTML page.")] = None,
    limit: inputs.Limit = None,
    json: inputs.Json = False,
) -> None:
    """Say which printed equation of a rod is wrong, and which change corrects it.

    The exit status is 0 only if at least one equation could be read and each one that was read is right.
    """
    from pendpin.doctor.diagnose import diagnose_file
    from pendpin.doctor.recognition import check_choices

    refuse_outputs([file], html=html)
    inputs.once_each(((text.partition("=")[0].strip(), text) for text in inputs.split_at_commas(symbols)), "--symbols")
    differences, own = (",".join(texts) if texts else None for texts in (convention, symbols))
    with inputs.naming_options():
        check_choices(rod, differences)
    with working("reading", limit, json) as progress:
        diagnosis = diagnose_file(file, rod, differences, progress, own, scene)
    with reported(diagnosis.report(), json) as files:
        files += [write_whole(html, lambda file: file.write(diagnosis.page().encode(errors="replace")))] if html else []
    if not diagnosis.ok:
        raise Exit(1)


@inputs.on_scene
def stability(
    chosen: inputs.SceneInput,
    lyapunov: Annotated[bool, Option("--lyapunov", help="Lyapunov exponents of the motion from the start.")] = False,
    planar: Annotated[bool, Option("--planar", help="With --lyapunov: changes in the motion's plane alone.")] = False,
    period: Annotated[float | None, Option(help="Period in s of the motion; that of the drive if absent.")] = None,
    limit: inputs.Limit = None,
    plot: inputs.Plot = None,
    json: inputs.Json = False,
) -> None:
    """Print the rests of a scene and whether they are stable; with a drive, the multipliers of its periodic motion.

    --lyapunov adds the Lyapunov exponents of the motion, each with its error; --plot then draws their estimates over time.
    """
    from pendpin.stability.linearize import stability as report_on
    from pendpin.stability.lyapunov import lyapunov as exponents_of

    refuse_outputs(chosen.files, plot=plot)
    for option, given in (("--plot", plot), ("--planar", planar)):
        inputs.refuse_alone(given and not lyapunov, option, "--lyapunov, whose exponents it is of")
    what = "the exponents" if lyapunov else "the rests"
    with chosen.noted() as scene, working(what, limit, json), inputs.naming_options("period"):
        found = exponents_of(scene, planar=planar) if lyapunov else report_on(scene, period)
    _conclude(found, plot, json)


def _conclude(result: Any, plot: Path | None, json: bool) -> None:
    """Print a result and write its figure, if one is asked for. Raises PendpinError for its fault: then there is none."""
    from pendpin.graphics.style import write_figure

    with reported(report := result.report(), json) as files:
        files += [write_figure(plot, lambda: result.plot().figure)] if plot and not report.fault else []
    finish(report.fault)


@inputs.on_scene
def modes(
    chosen: inputs.SceneInput,
    every: Annotated[bool, Option("--all", help="Print every mode, not the lowest alone.")] = False,
    plot: inputs.Plot = None,
    html: Annotated[Path | None, Option(help="Animation of a mode as one HTML page.")] = None,
    mode: Annotated[int | None, Option(min=1, help="Which mode the page plays; the lowest, 1, if absent.")] = None,
    limit: inputs.Limit = None,
    json: inputs.Json = False,
) -> None:
    """Print the natural frequencies, damping ratios and shapes of small motions about the rest of a scene.

    Frequencies that both directions of a hanging chain share are one line.
    """
    from pendpin.stability.modes import MOST_ROWS
    from pendpin.stability.modes import modes as modes_of

    inputs.refuse_alone(mode is not None and html is None, "--mode", "--html FILE, the page that plays it")
    refuse_outputs(chosen.files, plot=plot, html=html)
    with chosen.noted() as scene:
        with working("the modes", limit, json):
            result = modes_of(scene)
        result.place(mode := mode or 1)
        with reported(result.report(None if every else MOST_ROWS), json) as files:
            files += [result.save_plot(plot)] if plot else []
            files += [result.animate(mode).save(html)] if html else []


@inputs.on_scene
def effects(
    chosen: inputs.SceneInput,
    accuracy: Annotated[float, Option(help="Least change that matters: tip distance over the chain's length.")] = 1e-3,
    thorough: Annotated[bool, Option("--thorough", help="Compare over the full duration, whatever it takes.")] = False,
    limit: inputs.Limit = None,
    json: inputs.Json = False,
) -> None:
    """Show what each effect changes and costs, and which effects the scene needs at an accuracy."""
    from pendpin.sweeps.significance import significance

    what = "runs with and without each effect"
    with working(what, limit, json), chosen.noted() as scene, inputs.naming_options("accuracy"):
        report = significance(scene, accuracy, thorough)
    print_report(report.report(), json)


# --- Poincaré sections and bifurcation diagrams: pendpin section, pendpin bifurcation ---------------------------------

Of = Annotated[list[str], Option(help="Quantities to note, with commas: theta_2,theta_2_rate.")]
Skip = Annotated[int, Option(min=0, help="Points of each motion before the first that counts.")]


@inputs.on_scene
def section(
    chosen: inputs.SceneInput,
    at: Annotated[str, Option(help='Where: "theta_1 = 0, rising"; falling and both are other ways.')],
    of: Of,
    count: Annotated[int, Option(min=1, help="Points of each motion.")] = 300,
    skip: Skip = 0,
    starts: Annotated[int, Option(min=1, help="Motions; more than one need --energy.")] = 1,
    energy: Annotated[float | None, Option(help="Energy in J of starts that are drawn on the section.")] = None,
    seed: Annotated[int, Option(help="Seed of the starts.")] = 0,
    limit: inputs.Limit = None,
    plot: inputs.Plot = None,
    json: inputs.Json = False,
) -> None:
    """Print and draw a Poincaré section: a motion, or many of one energy, where a quantity crosses a level."""
    from pendpin.stability.sections import portrait
    from pendpin.stability.sections.points import read_crossing

    refuse_outputs(chosen.files, plot=plot)
    with inputs.naming_options("at", "of", "count", "skip", "starts", "energy"):
        place = read_crossing(at, tuple(filter(None, inputs.split_at_commas(of))), count, skip)
    if plot and len(place.of) != 2:
        raise BadParameter("--plot draws two quantities: give --of two names", param_hint="--of")
    with chosen.noted() as scene, working("the section", limit, json):
        drawn = portrait(scene, place, starts, energy, seed)
    _conclude(drawn, plot, json)


@inputs.on_scene
def bifurcation(
    chosen: inputs.SceneInput,
    vary: Annotated[list[str], Option(help="A number and its values: KEY=FROM:TO:COUNT.")],
    of: Of,
    strobe: Annotated[float | None, Option(help="Period in s of the strobe; that of the drive if absent.")] = None,
    count: Annotated[int, Option(min=1, help="Points of each motion.")] = 100,
    skip: Skip = 200,
    limit: inputs.Limit = None,
    plot: inputs.Plot = None,
    json: inputs.Json = False,
) -> None:
    """Print and draw a bifurcation diagram: points once a period, the state carried from value to value, up and down."""
    from pendpin.stability.sections import bifurcation as diagram_of
    from pendpin.stability.sections import strobe as strobe_of
    from pendpin.sweeps.plan import read_axes

    refuse_outputs(chosen.files, plot=plot)
    with inputs.naming_options("vary", "of", "count", "skip"):
        if len(vary) > 1:
            raise InputError(f"vary: a diagram has one number, not {len(vary)}; a sweep varies several")
        ((key, values),) = read_axes(vary).items()
        if strobe is not None and not 0 < strobe < float("inf"):
            raise BadParameter(f"{strobe} is not a number of seconds above 0", param_hint="--strobe")
        place = strobe_of(strobe, of=tuple(filter(None, inputs.split_at_commas(of))), count=count, skip=skip)
    with chosen.noted() as scene, working("the diagram", limit, json):
        diagram = diagram_of(scene, key, values, place)
    _conclude(diagram, plot, json)
