"""Error against time as one figure."""

from pathlib import Path
from typing import Any

import numpy as np

from pendpin.analysis.work_precision.report import CostReport, Curve
from pendpin.graphics.figure import write_figure

COLORS = {
    "taylor": "#d9622b",
    "dop853": "#2b6cb0",
    "rk45": "#63a4d8",
    "rk23": "#a3c9e8",
    "lsoda": "#2f855a",
    "radau": "#6b46c1",
    "bdf": "#9f7aea",
    "gauss2": "#d69e2e",
    "gauss4": "#b7791f",
    "gauss6": "#744210",
    "rk4": "#718096",
    "euler": "#a0aec0",
}
PEERS = {"mujoco": "#c53030", "drake": "#285e61", "scipy": "#4a5568"}
MARKS = "osD^vP*X"
FRONT = "#f6e05e"


def save_cost_plot(report: CostReport, path: str | Path) -> Path:
    """Write the figure to a .png, .pdf or .svg file, whole or not at all. Raises InputError."""
    return write_figure(path, lambda: draw_cost(report))


def draw_cost(report: CostReport) -> Any:
    """The figure: error across, falling to the right; seconds up; a line for each method."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 6.2), layout="constrained")
    ax = figure.subplots()
    shown = [curve for curve in report.curves if any(point.error < 1 for point in curve.points)]
    for i, curve in enumerate(sorted(shown, key=lambda curve: curve.peer)):
        _line(ax, curve, report.error, i)
    _front(ax, report)
    _frame(ax, report)
    title = f"What accuracy costs: {report.subject}, {report.horizon:.3g} s"
    ax.set_title(title, loc="left", fontsize=13, fontweight="bold")
    figure.supxlabel(f"{report.machine}; {_versions(report)}", fontsize=7, color="#4a5568")
    return figure


def _line(ax: Any, curve: Curve, floor: float, index: int) -> None:
    points = [point for point in curve.points if point.error < 1]
    known = [point for point in points if point.error > floor]
    color = (PEERS if curve.peer else COLORS).get(curve.name.split()[0], "#4a5568")
    dash = "--" if curve.peer else "-." if curve.name.endswith("compiled") else "-"
    style: dict[str, Any] = {"linestyle": dash, "linewidth": 1.1 if curve.peer else 1.7}
    errors, seconds = [point.error for point in known], [point.seconds for point in known]
    ax.plot(errors, seconds, marker=MARKS[index % len(MARKS)], ms=4.5, color=color, label=curve.name, **style)


def _front(ax: Any, report: CostReport) -> None:
    """The least time at every error, of all curves, as a broad band behind the lines."""
    errors = np.geomspace(0.3, max(report.error, 1e-16), 200)
    best = [report.best(float(error), None) for error in errors]
    pairs = [(error, found[1]) for error, found in zip(errors, best, strict=True) if found]
    if pairs:
        ax.plot(
            *zip(*pairs, strict=True),
            color=FRONT,
            linewidth=9,
            alpha=0.55,
            zorder=0,
            label="cheapest",
            solid_capstyle="round",
        )


def _frame(ax: Any, report: CostReport) -> None:
    ax.set_xscale("log")
    ax.set_yscale("log")
    left, right = 1.0, report.error / 3
    ax.set_xlim(left, right)  # errors fall to the right
    ax.axvspan(report.error, right, color="#edf2f7", zorder=-1)
    ax.text(
        report.error,
        0.02,
        " the reference\n knows no better",
        transform=ax.get_xaxis_transform(),
        fontsize=8,
        color="#718096",
        rotation=90,
        va="bottom",
        ha="left",
    )
    ax.axvline(report.accuracy, color="#1a202c", linewidth=0.9, linestyle=":")
    ax.text(
        report.accuracy, 0.99, f" asked: {report.accuracy:g}", transform=ax.get_xaxis_transform(), fontsize=8, va="top"
    )
    ax.set_xlabel("largest error of a tip over the run, over the chain's length  (more accurate to the right)")
    ax.set_ylabel("time of the run, s  (compiling apart)")
    ax.grid(alpha=0.25, linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=9)


def _versions(report: CostReport) -> str:
    return ", ".join(f"{name} {number}" for name, number in report.versions.items())
