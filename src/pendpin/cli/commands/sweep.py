"""The commands of sweeps: `pendpin sweep` runs one, `pendpin map` shows what a store holds."""

from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pendpin.cli.inputs import SceneInput, naming_options, on_scene
from pendpin.cli.options import Accuracy, Json, Method, Plot, Tolerance
from pendpin.cli.outputs import refuse_outputs
from pendpin.cli.progress import progress_bar
from pendpin.cli.tables import print_files, print_json, print_measures, print_table
from pendpin.errors import InputError

if TYPE_CHECKING:
    from pendpin.sweeps.plan import Plan

VARY = "KEY=FROM:TO:COUNT or KEY=1,2,5; with --sample KEY=LOW:HIGH or KEY=normal(MEAN,DEVIATION). May be repeated."
FIGURES = ("least", "median", "most")  # of the values of a measure
MEASURE = (
    "Number to be measured, such as swing, flip_time, theta_1.max or flip_time.spread (see --list). May be repeated."
)


@on_scene
def sweep(
    chosen: SceneInput,
    vary: Annotated[list[str] | None, typer.Option(help=VARY)] = None,
    measure: Annotated[list[str] | None, typer.Option(help=MEASURE)] = None,
    listed: Annotated[bool, typer.Option("--list", help="List the measures and run nothing.")] = False,
    out: Annotated[
        Path | None, typer.Option(help="Zarr store of the results. If it exists, the sweep continues it.")
    ] = None,
    csv: Annotated[Path | None, typer.Option(help="Table of all cases, for small sweeps.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Figure of the first measure: .png, .pdf or .svg.")] = None,
    cases: Annotated[
        Path | None, typer.Option(help="CSV of cases: keys in the first line, a case in each further line.")
    ] = None,
    in_pairs: Annotated[
        bool, typer.Option("--zip", help="Vary all keys together: the first values, the second values, ...")
    ] = False,
    sample: Annotated[int | None, typer.Option(min=1, help="Number of random cases.")] = None,
    sampling: Annotated[str, typer.Option(help="latin, sobol or random.")] = "latin",
    sobol: Annotated[
        int | None, typer.Option(min=2, help="Compute Sobol' indices from this number of base cases, a power of 2.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of random cases.")] = 0,
    workers: Annotated[int | None, typer.Option(min=1, help="Processes on this machine; threads if absent.")] = None,
    dask: Annotated[
        str | None, typer.Option(help="Address of a running Dask cluster, such as tcp://host:8786.")
    ] = None,
    method: Method = None,
    tolerance: Tolerance = None,
    accuracy: Accuracy = None,
    json: Json = False,
) -> None:
    """Run a scene with many sets of numbers and measure each run."""
    from pendpin.sweeps.sweep import sweep as run

    if listed:
        print_measures(json)
        return
    refuse_outputs([*chosen.files, cases], csv=csv, plot=plot, store=None if out is None or out.exists() else out)
    with naming_options("vary"):
        plan = _plan(vary or [], cases, in_pairs, sample, sampling, sobol, seed)
    settings = {"method": method, "tolerance": tolerance, "accuracy": accuracy}
    with progress_bar("sweeping", plan.count, hidden=json) as bar:
        measures = tuple(measure or ("swing",))
        dataset = run(
            chosen.scene,
            plan,
            measures,
            out=out,
            workers=workers,
            dask=dask,
            progress=lambda done, _: bar(done),
            **settings,
        )
    shares = partial(_shares, dataset, vary or [], seed) if sobol else dict
    _show(dataset, [*([out] if out else []), *_written(dataset, csv, plot, None)], json, shares)
    if (dataset["why"].values != "").all():
        raise typer.Exit(1)


def map_(
    store: Annotated[Path, typer.Argument(help="Zarr store of a sweep, finished or not.")],
    measure: Annotated[str | None, typer.Option(help="The measure; the first if absent.")] = None,
    csv: Annotated[Path | None, typer.Option(help="Table of all cases.")] = None,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Show what a sweep has found so far."""
    from pendpin.sweeps.figure import chosen
    from pendpin.sweeps.store import load

    refuse_outputs([], csv=csv, plot=plot)
    dataset = load(store)
    _show(dataset, _written(dataset, csv, plot, chosen(dataset, measure)), json)


def _plan(
    vary: list[str], cases: Path | None, in_pairs: bool, sample: int | None, sampling: str, sobol: int | None, seed: int
) -> "Plan":
    from pendpin.sweeps import plan as plans
    from pendpin.sweeps.sensitivity import sobol_plan

    if sum(map(bool, (cases, in_pairs, sample, sobol))) > 1:
        raise typer.BadParameter("give one of --cases, --zip, --sample and --sobol")
    if cases and vary:
        raise InputError("--vary: --cases names the numbers already; leave one of them out")
    if cases:
        return plans.cases_of(cases)
    if sobol:
        return sobol_plan(plans.read_spreads(vary), sobol, seed)
    if sample:
        return plans.samples(plans.read_spreads(vary), sample, sampling, seed)
    axes = plans.read_axes(vary)
    return plans.pairs(axes) if in_pairs else plans.grid(axes)


def _show(dataset: Any, files: list[Path], json: bool, shares: Callable[[], dict[str, Any]] = dict) -> None:
    """Print what was measured, and the files written; `shares` may raise InputError, when the rest is there."""
    from pendpin.sweeps.figure import label, names_of
    from pendpin.sweeps.store import NOT_RUN

    why = dataset["why"].values
    run, reasons = why != NOT_RUN, Counter(str(reason) for reason in why.flat if reason and reason != NOT_RUN)
    counts = {"cases": why.size, "not_run": int((~run).sum()), "failed": reasons.total()}
    measures = {name: _range(dataset[name].values[run]) for name in names_of(dataset)}
    if json:
        sobol = {"sobol": indices} if (indices := shares()) else {}
        print_json(counts | {"measures": measures, "files": [str(file) for file in files]} | sobol)
        return
    cells = [
        [label(name, dataset), *(f"{row[k]:.6g}" for k in FIGURES), str(row["none"])] for name, row in measures.items()
    ]
    print_table(["measure", *FIGURES, "no value"], cells)
    waiting = f"; {counts['not_run']} not run yet" if counts["not_run"] else ""
    print(f"{counts['cases']} cases; {counts['failed']} could not be run{waiting}")
    for reason, times in reasons.most_common(5):
        print(f"  {times} x {reason}")
    print_files(files)
    for name, rows in shares().items():
        print(f"Shares of the variance of {name} (95 % intervals):")
        head = ["varied", "alone", "+-", "with all others", "+-"]
        print_table(head, [[key, *(f"{x:.3f}" for x in row.values())] for key, row in rows.items()])


def _written(dataset: Any, csv: Path | None, plot: Path | None, measure: str | None) -> list[Path]:
    from pendpin.sweeps.figure import save_map
    from pendpin.sweeps.store import write_table

    return [*([write_table(dataset, csv)] if csv else []), *([save_map(dataset, plot, measure)] if plot else [])]


def _range(values: Any) -> dict[str, Any]:
    """The least, median and largest finite value, and how many are not finite."""
    import numpy as np

    good = values[np.isfinite(values)]
    figures = [float(of(good)) if good.size else np.nan for of in (np.min, np.median, np.max)]
    return dict(zip(FIGURES, figures, strict=True)) | {"none": values.size - good.size}


def _shares(dataset: Any, vary: list[str], seed: int) -> dict[str, Any]:
    """Sobol' indices of each measure, by key."""
    from pendpin.sweeps.figure import names_of
    from pendpin.sweeps.plan import read_spreads
    from pendpin.sweeps.sensitivity import indices

    spreads = read_spreads(vary)
    return {name: indices(spreads, dataset[name].values, seed) for name in names_of(dataset)}
