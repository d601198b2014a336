"""Error against time as one figure: all methods by name; or the cheapest of each tool, and what its next digit costs."""

from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError
from pendpin.graphics.figure import new_figure, write_figure
from pendpin.scene import METHODS
from pendpin.verification.work_precision.series import Curve

TOOLS = {"pendpin": "#D55E00", "mujoco": "#0072B2", "drake": "#009E73", "scipy": "#7A3E9D"}  # in every figure
NAMES = {"mujoco": "MuJoCo", "drake": "Drake", "scipy": "SciPy"}
PALE = "#cbd5e0"
DIGITS = (1e-3, 1e-9)  # errors between which the price of a digit is the mean
PEERS = {"mujoco": "#c53030", "drake": "#285e61", "scipy": "#4a5568"}
MARKS = "osD^vP*X"
FRONT = "#f6e05e"


def save_cost_plot(report: Any, path: str | Path, short: bool = False) -> Path:
    """Write the figure to a .png, .pdf or .svg file, whole or not at all. Raises InputError."""
    return write_figure(path, lambda: draw_cost(report) if short else draw_all(report))


def _refuse_nothing(report: Any) -> None:
    """Raises InputError where no run that can be drawn was made."""
    if not any(_drawn(curve, report.error)[0] for curve in report.curves):
        why = next((curve.failures[-1] for curve in report.curves if curve.failures), "no run was made")
        raise InputError(f"there is no figure of costs, because no method could be measured: {why}")


def draw_cost(report: Any) -> Any:
    """The cheapest method of pendpin and of each other simulator in strong colours, all others pale."""
    from matplotlib.figure import Figure

    _refuse_nothing(report)
    figure = Figure(figsize=(10, 6.2), layout="constrained")
    ax, prices = figure.subplots(1, 2, width_ratios=(3.4, 1))
    best = _cheapest(report)
    for tool, curve in best.items():
        look = {"linewidth": 3.2 if tool == "pendpin" else 2.2, "zorder": 3, "marker": "o", "ms": 4}
        name = f"{NAMES.get(tool, tool)}: {curve.name.removeprefix(tool).strip()}"
        ax.plot(*_drawn(curve, report.error), color=TOOLS[tool], label=name, **look)
    others = [curve for curve in report.curves if curve not in best.values()]
    for i, curve in enumerate(others):
        label = "_again" if i else f"{len(others)} other curves that were measured"
        ax.plot(*_drawn(curve, report.error), color=PALE, linewidth=1, zorder=1, label=label)
    _frame(ax, report)
    figure.legend(loc="outside upper right", ncols=3, frameon=False, fontsize=9)  # beside the curves, not on them
    _draw_prices(prices, best)
    _write_about(figure, ax, report)
    return figure


def draw_all(report: Any) -> Any:
    """All methods: error across, falling to the right; seconds up; a line for each."""
    _refuse_nothing(report)
    figure = new_figure(figsize=(10, 6.2), layout="constrained")
    ax = figure.subplots()
    shown = [curve for curve in report.curves if any(point.error < 1 for point in curve.points)]
    for i, curve in enumerate(sorted(shown, key=lambda curve: curve.peer)):
        _line(ax, curve, report.error, i)
    _front(ax, report)
    _frame(ax, report)
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=9)
    _write_about(figure, ax, report)
    return figure


def _write_about(figure: Any, ax: Any, report: Any) -> None:
    title = f"What accuracy costs: {report.subject}, {report.horizon:.3g} s"
    ax.set_title(title, loc="left", fontsize=13, fontweight="bold")
    figure.supxlabel(f"{report.machine}; {report.versions_text}", fontsize=7, color="#4a5568")


# --- the cheapest of each tool ------------------------------------------------------------------------------------


def _cheapest(report: Any) -> dict[str, Curve]:
    """The curve of each tool that meets the accuracy of interest in the least time; if none does, the most accurate."""

    def rank(curve: Curve) -> tuple[float, float]:
        seconds = curve.seconds_at(report.accuracy)
        return (0.0, seconds) if seconds is not None else (1.0, min(point.error for point in curve.points))

    best: dict[str, Curve] = {}
    for curve in sorted((curve for curve in report.curves if _drawn(curve, report.error)[0]), key=rank):
        best.setdefault(curve.name.split()[0] if curve.peer else "pendpin", curve)
    return {tool: best[tool] for tool in TOOLS if tool in best}


def _drawn(curve: Curve, least: float) -> tuple[list[float], list[float]]:
    """The errors below 1 that the reference can tell, and their times in s."""
    points = [point for point in curve.points if least < point.error < 1]
    return [point.error for point in points], [point.seconds for point in points]


def _draw_prices(ax: Any, best: dict[str, Curve]) -> None:
    """A bar for each tool: how many times as long a run takes that is ten times as accurate."""
    prices = {tool: price for tool, curve in reversed(best.items()) if (price := _next_digit(curve))}
    names, times = [NAMES.get(tool, tool) for tool in prices], list(prices.values())
    bars = ax.barh(names, times, 0.55, color=[TOOLS[tool] for tool in prices])
    ax.bar_label(bars, [f"{price:.2f} x" for price in prices.values()], padding=4, fontsize=11)
    ax.set_xlim(0, 1.35 * max([1.0, *times]))
    ax.set_title("the next digit takes", fontsize=10, loc="left")
    ax.spines[["top", "right", "bottom"]].set_visible(False)
    ax.tick_params(left=False, bottom=False, labelbottom=False)
    ax.set_box_aspect(1.2)


def _next_digit(curve: Curve) -> float | None:
    """The mean factor of time from one decade of error to the next within DIGITS; None if fewer than two are met."""
    decades = [error for k in range(17) if DIGITS[1] * 0.99 <= (error := 10.0**-k) <= DIGITS[0] * 1.01]
    times = [seconds for error in decades if (seconds := curve.seconds_at(error)) is not None]
    return (times[-1] / times[0]) ** (1 / (len(times) - 1)) if len(times) > 1 else None


# --- all methods --------------------------------------------------------------------------------------------------


def _line(ax: Any, curve: Curve, floor: float, index: int) -> None:
    points = [point for point in curve.points if point.error < 1]
    above = [point for point in points if point.error > floor]
    name = curve.name.split()[0]
    color = METHODS[name].color if name in METHODS and not curve.peer else PEERS.get(name, "#4a5568")
    dash = "--" if curve.peer else "-" if curve.name == name else "-."  # not compiled
    style: dict[str, Any] = {"linestyle": dash, "linewidth": 1.1 if curve.peer else 1.7}
    errors, seconds = [point.error for point in above], [point.seconds for point in above]
    ax.plot(errors, seconds, marker=MARKS[index % len(MARKS)], ms=4.5, color=color, label=curve.name, **style)


def _front(ax: Any, report: Any) -> None:
    """The least time at every error, of all curves, as a broad band behind the lines."""
    errors = np.geomspace(0.3, max(report.error, 1e-16), 200)
    best = [report.best(float(error), None) for error in errors]
    pairs = [(error, point[1]) for error, point in zip(errors, best, strict=True) if point]
    if pairs:
        look = {"color": FRONT, "linewidth": 9, "alpha": 0.55, "zorder": 0, "solid_capstyle": "round"}
        ax.plot(*zip(*pairs, strict=True), label="cheapest", **look)


def _frame(ax: Any, report: Any) -> None:
    ax.set_xscale("log")
    ax.set_yscale("log")
    left, right = 1.0, report.error / 3
    ax.set_xlim(left, right)  # errors fall to the right
    ax.axvspan(report.error, right, color="#edf2f7", zorder=-1)
    note = {"transform": ax.get_xaxis_transform(), "fontsize": 8, "va": "bottom", "ha": "left"}
    ax.text(report.error, 0.02, " accuracy of\n the reference", color="#718096", rotation=90, **note)
    ax.axvline(report.accuracy, color="#1a202c", linewidth=0.9, linestyle=":")
    ax.text(report.accuracy, 0.01, f" asked: {report.accuracy:g}", **note)
    ax.set_xlabel("largest error of a tip over the run, over the chain's length  (more accurate to the right)")
    ax.set_ylabel("time of the run, s  (compiling apart)")
    ax.grid(alpha=0.25, linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)
