"""The commands of sweeps: `pendpin sweep` runs one, `pendpin map` shows what a store holds. And `pendpin fit`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Argument, BadParameter, Option

from pendpin.cli import inputs
from pendpin.cli.outputs import finish, limited, print_report, progress_bar, refuse_outputs, reported, say, working
from pendpin.errors import InputError, inside
from pendpin.ground.report import Report

if TYPE_CHECKING:
    from pendpin.sweeps.plan import Plan

VARY = "KEY=FROM:TO:COUNT or KEY=1,2,5; with --sample KEY=LOW:HIGH or KEY=normal(MEAN,DEVIATION). May be repeated."
MEASURE = "Number to be measured, such as swing, theta_1.max or flip_time.spread (see --list). May be repeated."
FREE = 'Key paths, separated by commas, or "physics" (bodies, frictions, drags), "friction"; "physics" if absent.'
HELD_OUT = "Part of each held-out swing on which its start is fitted; the rest is compared. 0.1 if absent."
EXPLAIN = "Fit again without each part of the model, and with parts that it lacks."


@inputs.on_scene
def sweep(
    chosen: inputs.SceneInput,
    vary: Annotated[list[str] | None, Option(help=VARY)] = None,
    measure: Annotated[list[str] | None, Option(help=MEASURE)] = None,
    listed: Annotated[bool, Option("--list", help="List the measures and run nothing.")] = False,
    out: Annotated[Path | None, Option(help="Zarr store of the results. If it exists, the sweep continues it.")] = None,
    csv: Annotated[Path | None, Option(help="Table of all cases, for small sweeps.")] = None,
    plot: Annotated[Path | None, Option(help="Figure of the first measure: .png, .pdf or .svg.")] = None,
    cases: Annotated[Path | None, Option(help="CSV: keys in the first line, a case in each further line.")] = None,
    in_pairs: Annotated[bool, Option("--zip", help="Vary all keys together: first values, second values, ...")] = False,
    sample: Annotated[int | None, Option(min=1, help="Number of random cases.")] = None,
    sampling: Annotated[str | None, Option(help="latin, sobol or random; latin if absent.")] = None,
    sobol: Annotated[int | None, Option(min=2, help="Sobol' indices: the number of base cases, a power of 2.")] = None,
    seed: Annotated[int, Option(min=0, help="Seed of random cases.")] = 0,
    workers: Annotated[int | None, Option(min=1, help="Processes on this machine; threads if absent.")] = None,
    dask: Annotated[str | None, Option(help="Address of a running Dask cluster, such as tcp://host:8786.")] = None,
    method: inputs.Method = None,
    tolerance: inputs.Tolerance = None,
    accuracy: inputs.Accuracy = None,
    limit: inputs.Limit = None,
    json: inputs.Json = False,
) -> None:
    """Run a scene with many sets of numbers and measure each run."""
    from pendpin.sweeps.measures import measures_report
    from pendpin.sweeps.sweep import sweep as run

    if listed:
        print_report(measures_report(), json)
        return
    refuse_outputs([*chosen.files, cases], csv=csv, plot=plot, store=None if out is None or out.exists() else out)
    inputs.refuse_alone(sampling is not None and sample is None, "--sampling", "--sample N")
    with inputs.naming_options("vary"):
        plan = _plan(vary or [], cases, in_pairs, sample, sampling or "latin", sobol, seed)
    settings: dict[str, Any] = {"method": method, "tolerance": tolerance, "accuracy": accuracy}
    with limited(limit) as work, progress_bar("sweeping", plan.count, hidden=json) as bar:

        def progress(done: int, count: int) -> None:
            work.doing = f"{done} of {count} cases" + "; the same sweep resumes from there" * bool(out)
            bar(done)

        work.doing = f"the first of {plan.count} cases"
        where: dict[str, Any] = {"out": out, "workers": workers, "dask": dask, "progress": progress}
        dataset = run(chosen.scene, plan, tuple(measure or ("swing",)), **where, **settings)
    files = [*([out] if out else []), *_write_files(dataset, csv, plot, None)]
    finish(_show(dataset, files, json, (vary or [], seed) if sobol else None).fault)


def map_(
    store: Annotated[Path, Argument(help="Zarr store of a sweep, finished or not.")],
    measure: Annotated[str | None, Option(help="The measure; the first if absent.")] = None,
    csv: Annotated[Path | None, Option(help="Table of all cases.")] = None,
    plot: inputs.Plot = None,
    json: inputs.Json = False,
) -> None:
    """Show what a sweep has found so far."""
    from pendpin.sweeps.figure import chosen
    from pendpin.sweeps.store import load

    refuse_outputs([], csv=csv, plot=plot)
    dataset = load(store)
    _show(dataset, _write_files(dataset, csv, plot, chosen(dataset, measure)), json)


def _plan(
    vary: list[str], cases: Path | None, in_pairs: bool, sample: int | None, sampling: str, sobol: int | None, seed: int
) -> "Plan":
    from pendpin.sweeps import plan as plans

    if sum(map(bool, (cases, in_pairs, sample, sobol))) > 1:
        raise BadParameter("give one of --cases, --zip, --sample and --sobol")
    if cases and vary:
        raise InputError("--vary: --cases names the numbers already; leave one of them out")
    if cases:
        return plans.cases_of(cases)
    if sobol:
        return plans.sobol_plan(plans.read_spreads(vary), sobol, seed)
    if sample:
        if sampling == "sobol" and sample & (sample - 1):
            say(f"pendpin: note: {plans.UNEVEN.format(sample)}")
        return plans.samples(plans.read_spreads(vary), sample, sampling, seed)
    axes = plans.read_axes(vary)
    return plans.pairs(axes) if in_pairs else plans.grid(axes)


def _show(dataset: Any, files: list[Path], json: bool, sobol: tuple[list[str], int] | None = None) -> Report:
    """Print what was measured and the files written, then what a Sobol' plan (vary, seed) says."""
    from pendpin.sweeps.figure import names_of, sweep_report
    from pendpin.sweeps.plan import read_spreads, shares_report

    report = sweep_report(dataset)
    parts, data = [*report.parts, *(f"wrote {file}" for file in files)], dict(report.data)
    data["files"] = [str(file) for file in files]
    if sobol:
        vary, seed = sobol
        shares = shares_report(read_spreads(vary), {name: dataset[name].values for name in names_of(dataset)}, seed)
        parts, data = [*parts, *shares.parts], data | shares.data
    print_report(Report(parts, data), json)
    return report


def _write_files(dataset: Any, csv: Path | None, plot: Path | None, measure: str | None) -> list[Path]:
    from pendpin.sweeps.figure import save_map
    from pendpin.sweeps.store import write_table

    return [*([write_table(dataset, csv)] if csv else []), *([save_map(dataset, plot, measure)] if plot else [])]


def fit(
    scene: Annotated[Path, Argument(help="Scene file (TOML) with guesses and a table named data.")],
    data: Annotated[list[Path], Argument(help="Measured swings: one CSV file or several.")],
    free: Annotated[list[str] | None, Option(help=FREE)] = None,
    hold_out: Annotated[list[Path] | None, Option(help="CSV of other swings, which the fitted model predicts.")] = None,
    hold_out_start: Annotated[float | None, Option(help=HELD_OUT)] = None,
    explain_residual: Annotated[bool, Option("--explain-residual", help=EXPLAIN)] = False,
    robust: Annotated[bool, Option("--robust", help="Give outliers less weight.")] = False,
    out: Annotated[Path | None, Option(help="Where to write the fitted scene (TOML).")] = None,
    csv: Annotated[Path | None, Option(help="Samples: measured, fitted or predicted, residual, interval.")] = None,
    plot: inputs.Plot = None,
    limit: inputs.Limit = None,
    json: inputs.Json = False,
) -> None:
    """Identify parameters of a scene from measured swings: values, errors, and which numbers the data cannot determine."""
    from pendpin.fitting import explain_residual as explained
    from pendpin.fitting import fit as fitted
    from pendpin.fitting.data import read_swings
    from pendpin.fitting.fitting import data_table
    from pendpin.scene import load_scene

    if hold_out_start is not None and not (hold_out and 0 < hold_out_start < 1):
        raise BadParameter("give --hold-out, and a part between 0 and 1", param_hint="--hold-out-start")
    chosen = inputs.SceneInput(load_scene(scene), scene, urdf=None, strict=False)
    refuse_outputs([*chosen.files, *data, *(hold_out or [])], plot=plot, scene=out, csv=csv)
    with chosen.noted() as guesses:
        table = data_table(guesses)
    swings, others = read_swings(data, table), read_swings(hold_out, table) if hold_out else None
    with working("fitting", limit, json) as progress, inside(str(scene)):
        start = hold_out_start or 0.1
        result = fitted(guesses, swings, free or "physics", others, start, robust=robust, progress=progress)
        if explain_residual and result.follows:
            result = explained(result, progress)
    with reported(report := result.report(), json) as files:
        if not report.fault:
            written = (out and result.scene.save(out), plot and result.plot(plot), csv and result.to_csv(csv))
            files += [file for file in written if file]
    if report.fault:
        raise InputError(f"{scene}: {report.fault}" + "; no file is written" * bool(out or plot or csv))
