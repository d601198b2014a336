"""Error against time as one figure: the curves that matter in colour, the others grey with their names at their ends.

Every `report` here is a CostReport, whose file imports this one.
"""

from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError
from pendpin.graphics.style import BLACK, COLORS, GREY, PALE, SHADE, new_figure, styled, write_figure
from pendpin.verification.work_precision.series import Curve

DIGITS = (1e-3, 1e-9)  # errors between which the price of a digit is the mean
TOOLS = {"pendpin": "#D55E00", "mujoco": "#0072B2", "drake": "#009E73", "scipy": "#7A3E9D"}  # in every figure
NAMES = {"mujoco": "MuJoCo", "drake": "Drake", "scipy": "SciPy"}
MATTER = 4  # curves in colour: the cheapest of each tool, then those that are the cheapest at most errors
SIZE = (10.0, 6.2)  # inches
LINE, LETTER, AWAY = 8.0, 4.0, 4.0  # points: of a name at a curve's end, its height, a letter's width, its distance


def save_cost_plot(report: Any, path: str | Path, short: bool = False) -> Path:
    """Write the figure to a .png, .pdf or .svg file, whole or not at all. Raises InputError."""
    return write_figure(path, lambda: draw_cost(report) if short else draw_all(report))


@styled()
def draw_cost(report: Any) -> Any:
    """The cheapest method of pendpin and of each other simulator in strong colours, all others pale."""
    best, figure = _cheapest(report), new_figure(*SIZE)
    ax, prices = figure.subplots(1, 2, width_ratios=(3.4, 1))
    for tool, curve in best.items():
        name = f"{NAMES.get(tool, tool)}: {curve.name.removeprefix(tool).strip()}"
        _draw_curve(ax, curve, report.error, TOOLS[tool], name, 3.2 if tool == "pendpin" else 2.2)
    others = [curve for curve in report.curves if curve not in best.values()]
    for i, curve in enumerate(others):
        label = "_again" if i else f"{len(others)} other curves that were measured"
        ax.plot(*_points(curve, report.error), color=PALE, linewidth=1, zorder=1, label=label)
    _frame(figure, ax, report)
    figure.legend(loc="outside upper right", ncols=3)  # beside the curves, not on them
    _draw_prices(prices, best)
    return figure


@styled()
def draw_all(report: Any) -> Any:
    """All methods: error across, falling to the right; seconds up; a line for each."""
    matter, figure = _curves_that_matter(report), new_figure(*SIZE)
    ax = figure.subplots()
    for name, color in matter.items():
        curve = next(curve for curve in report.curves if curve.name == name)
        _draw_curve(ax, curve, report.error, color, name, 2.2)
    others = [curve for curve in report.curves if curve.name not in matter and _points(curve, report.error)[0]]
    for curve in others:
        ax.plot(*_points(curve, report.error), ".--" if curve.peer else ".-", color=PALE, linewidth=1, zorder=1)
    _frame(figure, ax, report)
    _name_ends(ax, others, report.error)
    figure.legend(loc="outside upper right", ncols=MATTER)
    return figure


# --- the curves that matter -----------------------------------------------------------------------------------------


def _points(curve: Curve, least: float) -> tuple[list[float], list[float]]:
    """The errors below 1 that the reference can tell, and their times in s."""
    points = [point for point in curve.points if least < point.error < 1]
    return [point.error for point in points], [point.seconds for point in points]


def _cheapest(report: Any) -> dict[str, Curve]:
    """The curve of each tool that meets the accuracy of interest in the least time; if none does, the most accurate.

    Raises InputError where no run that can be drawn was made.
    """

    def rank(curve: Curve) -> tuple[float, float]:
        seconds = curve.seconds_at(report.accuracy)
        return (0.0, seconds) if seconds is not None else (1.0, min(point.error for point in curve.points))

    best: dict[str, Curve] = {}
    for curve in sorted((curve for curve in report.curves if _points(curve, report.error)[0]), key=rank):
        best.setdefault(curve.name.split()[0] if curve.peer else "pendpin", curve)
    if not best:
        why = next((curve.failures[-1] for curve in report.curves if curve.failures), "no run was made")
        raise InputError(f"there is no figure of costs, because no method could be measured: {why}")
    return {tool: best[tool] for tool in TOOLS if tool in best}


def _curves_that_matter(report: Any) -> dict[str, str]:
    """The names of the MATTER curves that are drawn in colour, and their colours."""
    matter = {curve.name: TOOLS[tool] for tool, curve in _cheapest(report).items()}
    fronts = [best[0] for error in report.decades if (best := report.best(error)) is not None]
    free = [color for color in COLORS if color not in matter.values()]
    for name in sorted(dict.fromkeys(fronts), key=fronts.count, reverse=True):
        if name not in matter and len(matter) < MATTER:
            matter[name] = free[len(matter) % len(free)]
    return matter


def _draw_curve(ax: Any, curve: Curve, least: float, color: str, label: str, width: float) -> None:
    """One curve in colour; those of other simulators dashed."""
    look = {"linewidth": width, "linestyle": "--" if curve.peer else "-", "marker": "o", "zorder": 3}
    ax.plot(*_points(curve, least), color=color, label=label, **look)


def _name_ends(ax: Any, curves: list[Curve], least: float) -> None:
    """The name of each curve at its most accurate end, moved up or down where another name is, with a line to it."""
    (left, right), (low, high) = (np.log(ax.get_xlim()), np.log(ax.get_ylim()))
    width, height = 0.8 * 72 * SIZE[0], 0.8 * 72 * SIZE[1]  # points, about, of the axes
    ends = []
    for curve in curves:
        error, seconds = min(zip(*_points(curve, least), strict=True))
        x, y = (np.log(error) - left) / (right - left) * width, (np.log(seconds) - low) / (high - low) * height
        ends.append((y, x, error, seconds, curve.name))
    taken: list[tuple[float, float, float]] = []  # left, right and height of the names that are there
    for y, x, error, seconds, name in sorted(ends):
        end = x + AWAY + LETTER * len(name)
        up = next(
            step
            for step in sorted(range(-20, 21), key=abs)
            if all(end < a or x > b or abs(y + step * LINE / 2 - c) >= LINE for a, b, c in taken)
        )
        taken.append((x, end, y + up * LINE / 2))
        ax.annotate(
            name,
            (error, seconds),
            (AWAY + 8 * (abs(up) > 1), up * LINE / 2),
            textcoords="offset points",
            va="center",
            fontsize=7,
            color=GREY,
            arrowprops={"arrowstyle": "-", "color": PALE, "linewidth": 0.5, "shrinkA": 0, "shrinkB": 0},
        )


# --- the frame, and the price of a digit ----------------------------------------------------------------------------


def _frame(figure: Any, ax: Any, report: Any) -> None:
    """Logarithmic axes, what the reference cannot tell, the accuracy that was asked, titles."""
    ax.set(xscale="log", yscale="log")
    left, right = 1.0, report.error / 3
    ax.set_xlim(left, right)  # errors fall to the right
    ax.axvspan(report.error, right, color=SHADE, zorder=-1)
    note = {"transform": ax.get_xaxis_transform(), "fontsize": 8, "va": "bottom", "ha": "left"}
    ax.text(report.error, 0.02, " accuracy of\n the reference", color=GREY, rotation=90, **note)
    ax.axvline(report.accuracy, color=BLACK, linewidth=0.9, linestyle=":")
    ax.text(report.accuracy, 0.01, f" asked: {report.accuracy:g}", **note)
    ax.set_xlabel("largest error of a tip over the chain's length; more accurate to the right")
    ax.set_ylabel("time of the run, compiling apart (s)")
    title = f"What accuracy costs: {report.subject}, {report.horizon:.3g} s"
    ax.set_title(title, fontsize=13, fontweight="bold")
    figure.supxlabel(f"{report.machine}; {report.versions_text}", fontsize=7, color=GREY)


def _draw_prices(ax: Any, best: dict[str, Curve]) -> None:
    """A bar for each tool: how many times as long a run takes that is ten times as accurate."""
    prices = {tool: price for tool, curve in reversed(best.items()) if (price := _price_next_digit(curve))}
    names, times = [NAMES.get(tool, tool) for tool in prices], list(prices.values())
    bars = ax.barh(names, times, 0.55, color=[TOOLS[tool] for tool in prices])
    ax.bar_label(bars, [f"{price:.2f} x" for price in prices.values()], padding=4, fontsize=11)
    ax.set_xlim(0, 1.35 * max([1.0, *times]))
    ax.set_title("the next digit takes")
    ax.spines["bottom"].set_visible(False)
    ax.grid(visible=False)
    ax.tick_params(left=False, bottom=False, labelbottom=False)
    ax.set_box_aspect(1.2)


def _price_next_digit(curve: Curve) -> float | None:
    """The mean factor of time from one decade of error to the next within DIGITS; None if fewer than two are met."""
    decades = [error for k in range(17) if DIGITS[1] * 0.99 <= (error := 10.0**-k) <= DIGITS[0] * 1.01]
    times = [seconds for error in decades if (seconds := curve.seconds_at(error)) is not None]
    return (times[-1] / times[0]) ** (1 / (len(times) - 1)) if len(times) > 1 else None
