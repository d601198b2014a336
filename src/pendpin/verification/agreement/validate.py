"""Every published case by every method that can run it, and once to a target accuracy, against the published numbers."""

import html
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from io import StringIO
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError, MissingLibrary, not_one_of
from pendpin.graphics.panels import draw_path_from_above, draw_path_from_the_side
from pendpin.graphics.style import new_figure, styled
from pendpin.ground.files import write_whole
from pendpin.ground.report import Report, Result, Table
from pendpin.model.build import build
from pendpin.model.kinematics import scale
from pendpin.motions.simulate import simulate
from pendpin.motions.trajectory import Trajectory
from pendpin.scene import METHODS
from pendpin.verification.agreement.published import Case, Frequencies, Quantity, published_cases
from pendpin.verification.claims import Claim, Progress, attempt, choose_cases, collect, describe_broken

# Errors of these settings are a hundred times below the tightest bound of the cases that use them; a case names others.
USUAL = {
    "dop853": 1e-11,
    "rk45": 1e-11,
    "rk23": 1e-9,
    "radau": 1e-10,
    "bdf": 1e-10,
    "lsoda": 1e-11,
    "taylor": 1e-16,
    "gauss2": 2e-4,
    "gauss4": 2e-3,
    "gauss6": 5e-3,
    "rk4": 1e-3,
    "euler": 5e-6,
}
TO_ACCURACY = "accuracy"  # in place of a method: the run whose estimate of its own error is tested too


@dataclass(frozen=True)
class Comparison(Claim):
    """One published quantity against one run; the figure is the largest difference, in the quantity's unit."""

    source: str
    quantity: str
    unit: str

    def __str__(self) -> str:
        why = self.failure or f"{self.measured:.3g} {self.unit} is above {self.bound:.3g}"
        return f"{self.case}, {self.quantity}, by {self.method}: {why}"

    @property
    def shown(self) -> str:
        """The difference with its unit, in a table."""
        return "failed" if self.measured is None else f"{self.measured:.1e} {self.unit}"


@dataclass(frozen=True, repr=False)
class AgreementReport(Result):
    """The comparisons so far, and what was left out with the reasons."""

    comparisons: tuple[Comparison, ...]
    left_out: tuple[str, ...] = ()
    stopped: bool = False  # True if the user stopped it before the end

    @property
    def broken(self) -> tuple[Comparison, ...]:
        """The comparisons beyond their bounds."""
        return tuple(row for row in self.comparisons if not row.ok)

    @property
    def worst(self) -> tuple[Comparison, ...]:
        """Of each quantity the method that differs most; a run that failed counts as that."""
        worst: dict[tuple[str, str], Comparison] = {}
        for row in self.comparisons:
            before = worst.setdefault((row.case, row.quantity), row)
            if before.measured is not None and not (row.measured or np.inf) <= before.measured:
                worst[row.case, row.quantity] = row
        return tuple(worst.values())

    @property
    def fault(self) -> str | None:
        """The broken comparisons in one line; None if all hold."""
        return describe_broken(self.broken)

    def report(self) -> Report:
        """Of each published quantity the method that differs most; the runs that failed; what was left out; the counts."""
        cases = ["", *(row.case for row in self.worst)]  # each named once
        rows = [
            ("" if r.case == before else r.case, r.quantity, f"{r.bound:.1e} {r.unit}", r.shown, r.method, r.verdict)
            for before, r in zip(cases, self.worst, strict=False)
        ]
        words = [f"{row.case} by {row.method}: {row.failure}" for row in self.comparisons if row.failure]
        words += [f"left out: {line}" for line in self.left_out]
        words += [f"{len(self.comparisons)} comparisons, {len(self.broken)} beyond their bounds"]
        data = [asdict(row) | {"holds": row.ok} for row in self.comparisons]
        data = [{"difference": row.pop("measured")} | row for row in data]
        head = ("case", "quantity", "bound", "largest difference", "by", "")
        return Report((Table(head, rows), *words), data, self.fault)


def sources_report() -> Report:
    """The published cases with what they compare and where the numbers come from."""
    cases = published_cases()
    rows = [(name, case.title, case.origin, case.source) for name, case in cases.items()]
    data = [{"case": name} | case.model_dump(mode="json") for name, case in cases.items()]
    return Report((Table(("case", "motion", "numbers by", "source"), rows),), data)


def validate(
    names: Sequence[str] = (), methods: Sequence[str] | None = None, progress: Progress = lambda what: None
) -> AgreementReport:
    """Run published cases and compare them with their published numbers.

    After Ctrl-C the report holds the comparisons so far.

    Args:
        names: of the cases; all if empty.
        methods: the methods to run them by; all that can run a case if absent. "accuracy" stands for a run to the case's
            target accuracy, whose claimed error is added to the bound of positions.
        progress: called with the case and the method.

    Returns:
        The report: each difference beside its bound.

    Raises:
        InputError: for unknown names.
    """
    cases = choose_cases(published_cases(), names, "validate")
    for method in methods or ():
        if method not in (*METHODS, TO_ACCURACY):
            raise InputError(f"methods: {not_one_of(method, (*METHODS, TO_ACCURACY))}")
    left_out: list[str] = []
    rows, stopped = collect(_compare_all(cases, methods or (TO_ACCURACY, *METHODS), progress, left_out))
    return AgreementReport(rows, tuple(left_out), stopped)


def _compare_all(
    cases: dict[str, Case], methods: Sequence[str], progress: Progress, left_out: list[str]
) -> Iterator[Comparison]:
    for name, case in cases.items():
        yield from _compare_near(name, case, progress, left_out)
        for method in methods if case.quantities else ():
            if method in case.leave_out:
                left_out.append(f"{name} by {method}: {case.leave_out[method]}")
                continue
            progress(f"{name} by {method}")
            yield from _compare(name, case, method, left_out)


def _compare(name: str, case: Case, method: str, left_out: list[str]) -> Iterator[Comparison]:
    """The comparisons of a case by one method; a failed run is one for each quantity."""

    def run_case() -> Trajectory:
        if method == TO_ACCURACY:
            return simulate(case.scene, times=case.times, accuracy=case.accuracy)
        return simulate(case.scene.by(method, case.settings.get(method, USUAL[method])), times=case.times)

    run, error = attempt(run_case)
    if isinstance(error, MissingLibrary):
        left_out.append(f"{name} by {method}: {error}")
        return
    for quantity in case.quantities:
        bound = quantity.bound + _claim(quantity, run)
        difference = None if run is None else largest_difference(quantity, run)
        by = f"accuracy {case.accuracy:g}" if method == TO_ACCURACY else method
        yield Comparison(name, by, difference, bound, error and str(error), case.source, quantity.name, quantity.unit)


def _compare_near(name: str, case: Case, progress: Progress, left_out: list[str]) -> Iterator[Comparison]:
    """The comparisons of what a case says of the motions near a rest, which no method integrates."""
    for quantity in (*case.frequencies, *case.stability):
        by = "linear model" if isinstance(quantity, Frequencies) else "multipliers"
        progress(f"{name} by the {by}")
        published = np.array(quantity.values)
        difference, error = attempt(
            lambda: max(np.abs(quantity.compute(case.scene) - published).tolist())  # noqa: B023  called at once
        )
        if isinstance(error, MissingLibrary):
            left_out.append(f"{name} by the {by}: {error}")
            continue
        source, unit = case.source, quantity.unit
        yield Comparison(name, by, difference, quantity.bound, error and str(error), source, quantity.name, unit)


def _claim(quantity: Quantity, run: Trajectory | None) -> float:
    """What a run's own estimate adds to the bound of a place, in m: its claim is a part of the length."""
    if run is None or run.stats.error is None or quantity.of not in ("centre of mass", "tip"):
        return 0.0
    return run.stats.error * scale(build(run.source.model))


def largest_difference(quantity: Quantity, run: Trajectory) -> float:
    """The largest difference of any published number to the run at the same time, in the quantity's unit."""
    samples = np.searchsorted(run.t, quantity.times - 1e-12 * run.t[-1])
    return float(np.abs(quantity.observed(run)[samples] - quantity.published).max())


# --- the agreement with published results as one HTML page ----------------------------------------------------------

SHOWN = 10.0  # s, of a longer motion: later swings lie on top of the first
SAMPLES, COLUMNS = 1001, 4  # of each path; of the figure

HEAD = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>pendpin: agreement with published results</title>
<style>
li { overflow-wrap: anywhere; }
body { font: 16px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 68rem; padding: 0 1rem; color: #1a202c; }
table { border-collapse: collapse; width: 100%; font-size: 0.9rem; }
th, td { text-align: left; padding: 0.35rem 0.6rem; border-bottom: 1px solid #e2e8f0; vertical-align: top; }
td { font-variant-numeric: tabular-nums; }
svg { width: 100%; height: auto; }
div.wide { overflow-x: auto; }
@media (max-width: 40rem) {
  table { font-size: 0.75rem; }
  th, td { padding: 0.35rem 0.15rem; }
  td:last-child { overflow-wrap: anywhere; }
  svg { min-width: 40rem; }
}
</style></head><body>
"""


def write_page(path: Path, report: AgreementReport) -> Path:
    """Write the page, whole or not at all. Raises InputError where the path refuses."""
    return write_whole(path, lambda file: file.write(page(report).encode()))


def page(report: AgreementReport) -> str:
    """The report as HTML that needs no network: the worst method of each quantity, then sources and motions."""
    names = list(dict.fromkeys(row.case for row in report.comparisons))
    motions, sources = StringIO(), []
    with styled():
        draw_motions(names).savefig(motions, format="svg")
    for name in names:
        case = published_cases()[name]
        words = f"{case.title}. Numbers by {case.origin}. {case.source}. {case.note}"
        sources.append(f"<li><strong>{name}</strong>: {html.escape(words)}</li>")
    parts = [
        HEAD,
        "<h1>Agreement with published results</h1>",
        "<p>Each row shows the method that differs most.</p>",
        f'<div class="wide">{report.report()._repr_html_()}</div><h2>Motions</h2>',
        f'<div class="wide">{motions.getvalue()[motions.getvalue().index("<svg") :]}</div>',
        "<h2>Sources</h2><ul>",
        *sources,
        "</ul></body></html>\n",
    ]
    return "\n".join(parts)


@styled()
def draw_motions(names: list[str]) -> Any:
    """A figure with the path of the tip of each case, from the side, or from above where it stays level.

    Cases of frequencies and bounds of stability have no motion to draw.
    """
    names = [name for name in names if published_cases()[name].quantities]
    rows = max(1, ceil(len(names) / COLUMNS))
    figure = new_figure(3.2 * COLUMNS, 3.2 * rows)
    axes = np.ravel(figure.subplots(rows, COLUMNS, squeeze=False))
    for ax, name in zip(axes, names, strict=False):
        case = published_cases()[name]
        run = simulate(case.scene, duration=min(case.times[-1], SHOWN), samples=SAMPLES)
        level = np.ptp(run.tips[:, -1, 2]) < 1e-3 * np.ptp(run.tips[:, -1], axis=0).max()
        (draw_path_from_above if level else draw_path_from_the_side)(ax, run)
        ax.set_title(name)
    for ax in axes[len(names) :]:
        ax.set_axis_off()
    return figure
