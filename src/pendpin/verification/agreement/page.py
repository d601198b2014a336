"""The agreement with published results as one HTML page, and the motions of its cases as one figure."""

import html
from io import StringIO
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.graphics.figure import plain_text
from pendpin.graphics.panels import draw_path_from_above, draw_path_from_the_side
from pendpin.ground.files import write_whole
from pendpin.motions.simulate import simulate
from pendpin.verification.agreement.published import published_cases
from pendpin.verification.agreement.validate import AgreementReport

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
    parts = [
        HEAD,
        "<h1>Agreement with published results</h1>",
        "<p>Each row shows the method that differs most.</p>",
        f'<div class="wide">{report.report()._repr_html_()}</div><h2>Motions</h2>',
        f'<div class="wide">{_svg(names)}</div>',
        "<h2>Sources</h2><ul>",
        *map(_source, names),
        "</ul></body></html>\n",
    ]
    return "\n".join(parts)


def _source(name: str) -> str:
    case = published_cases()[name]
    words = f"{case.title}. Numbers by {case.origin}. {case.source}. {case.note}"
    return f"<li><strong>{name}</strong>: {html.escape(words)}</li>"


def _svg(names: list[str]) -> str:
    text = StringIO()
    with plain_text():
        draw_motions(names).savefig(text, format="svg")
    return text.getvalue()[text.getvalue().index("<svg") :]


def draw_motions(names: list[str]) -> Any:
    """A figure with the path of the tip of each case, from the side, or from above where it stays level.

    Cases of frequencies and bounds of stability have no motion to draw.
    """
    from matplotlib.figure import Figure

    names = [name for name in names if published_cases()[name].quantities]
    rows = max(1, ceil(len(names) / COLUMNS))
    figure = Figure(figsize=(3.2 * COLUMNS, 3.2 * rows), layout="constrained")
    axes = np.ravel(figure.subplots(rows, COLUMNS, squeeze=False))
    for ax, name in zip(axes, names, strict=False):
        case = published_cases()[name]
        run = simulate(case.scene, duration=min(case.times[-1], SHOWN), samples=SAMPLES)
        level = np.ptp(run.tips[:, -1, 2]) < 1e-3 * np.ptp(run.tips[:, -1], axis=0).max()
        (draw_path_from_above if level else draw_path_from_the_side)(ax, run)
        ax.set_title(name, fontsize=10)
    for ax in axes[len(names) :]:
        ax.set_axis_off()
    return figure
