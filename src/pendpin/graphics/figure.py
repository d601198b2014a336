"""A run as one figure: panels against time, the path of the tip beside them; or chosen quantities on one axes."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from pendpin.errors import InputError
from pendpin.graphics.panels import (
    DASHES,
    MOST_JOINTS,
    PATHS,
    Runs,
    draw_distance,
    draw_drift,
    draw_quantities,
    labels_of,
    panels_of,
    quantity_panels,
    runs_of,
    turns,
)
from pendpin.graphics.ropes import SIDES, is_rope, panels_of_rope
from pendpin.graphics.style import BESIDE, COLORS, TIME, new_figure, plain_name, styled, write_figure
from pendpin.ground.arguments import axes
from pendpin.trajectory import RunRecord

LEFT, WIDTH, ROW, LOW, PATH, TOP, BOTTOM = 1.0, 6.2, 1.9, 1.1, 3.2, 0.75, 0.55  # inches: margins, panels, paths beside
MOST_TURNS, FAINT = 200, 0.5  # beyond so many turning points lines become areas, through which others are seen
LABEL = 0.62  # inches, from an axis to its name: to find a place for it, matplotlib would draw everything twice
TICKS = 6  # of an axis at most, and one: drawing them takes half the time of a figure
LEAST = 6.0  # inches, of the panels where paths are beside them
LETTER = 0.066  # inches, of a legend
MARKS = ("\u2014", "\u2013 \u2013", "\u00b7\u00b7\u00b7", "\u2013\u00b7\u2013")  # the same in letters
MOST_LETTERS = 90  # of a title


def save_plot(run: RunRecord, path: str | Path, names: tuple[str, ...] = (), compare: Runs = None) -> Path:
    """Write the figure of a run, or of quantities of it, to a .png, .pdf or .svg file, whole. Raises InputError."""
    others = runs_of(run, compare)[1:]
    return write_figure(path, lambda: draw(run, names, others))


@styled()
def draw(run: RunRecord, names: tuple[str, ...] = (), compare: Sequence[RunRecord] = ()) -> Any:
    """The figure of a run, or of quantities of it by name: a matplotlib Figure that needs no display.

    Runs to `compare` are drawn with dashes over the first, on the same axes, and their distance from it below.
    """
    figure = new_figure(1.0, 1.0, layout=None)  # its size and places follow from what is drawn
    runs = [run, *compare]
    if names:
        panels, sides = quantity_panels(run, names), ()
    else:
        panels, sides = (panels_of_rope(run), SIDES) if is_rope(run) else (panels_of(run), PATHS)
    if compare and not names:
        panels = [*panels, draw_distance]
    axes, paths = ([figure.add_axes((0, 0, 1, 1)) for _ in some] for some in (panels, sides))
    for draw_panel, ax in zip((*panels, *sides), (*axes, *paths), strict=True):
        draw_runs(draw_panel, ax, runs)
        if draw_panel is not draw_distance:  # its axis is logarithmic
            ax.locator_params(nbins=TICKS)
    for ax in axes:
        for line in ax.lines:
            line.set_alpha(FAINT if turns(run) > MOST_TURNS else line.get_alpha())
            line.set_marker("o" if len(run.t) == 1 else line.get_marker())  # no line goes through one sample
        ax.sharex(axes[0])
        ax.tick_params(labelbottom=ax is axes[-1])
    for ax in (*axes, *paths):
        names = ax.get_legend_handles_labels()[1]
        if names and not (len(names) == 1 and ax.get_ylabel().startswith(names[0])):  # what the axis says already
            ax.legend(**BESIDE)
    axes[-1].set_xlabel(TIME)
    _place(figure, axes, paths, [LOW if panel is draw_drift else ROW for panel in panels])
    _write_title(figure, runs)
    return figure


def draw_runs(draw_panel: Any, ax: Any, runs: Sequence[RunRecord]) -> None:
    """A panel of the first run, and those of the others on it: each with its dashes, and without names of its own.

    A quantity that one of the others lacks is left out, and the legend says which run that is.
    """
    if draw_panel is draw_distance:
        return draw_distance(ax, runs)
    for i, run in enumerate(runs):
        ax.set_prop_cycle(color=COLORS)
        before, lacks = {*ax.lines, *ax.collections}, False
        try:
            draw_panel(ax, run)
        except InputError:
            if not i:
                raise
            lacks = True
        if len(runs) > 1 and not i and run.tips.shape[1] == 1:  # colours tell theta from phi, dashes the runs
            for line in ax.lines:
                line.set_linestyle("-" if line.get_linestyle() == "--" else line.get_linestyle())
        for line in set(ax.lines) - before if i else ():
            line.set(linestyle=DASHES[i % len(DASHES)], label="_another run", linewidth=1.8, alpha=0.75)
        for area in set(ax.collections) - before if i else ():
            area.set_label("_another run")
        if lacks:
            ax.plot([], [], " ", label=f"run {i + 1} has none")
    return None


def _place(figure: Any, axes: list[Any], paths: list[Any], rows: list[float]) -> None:
    """Give the figure its size and its axes, of these heights in inches, their places.

    matplotlib's own layout would draw everything twice.
    """
    beside, inner = LEFT + WIDTH + _room_for_legend(axes), max(sum(rows), LEAST * bool(paths))
    width, height = beside + (LEFT + PATH + max(0.2, _room_for_legend(paths))) * bool(paths), TOP + inner + BOTTOM
    rows, x = [row * inner / sum(rows) for row in rows], beside + LEFT
    places = [(LEFT, sum(rows[i + 1 :]), WIDTH, row - 0.25) for i, row in enumerate(rows)]
    tall = inner / max(1, len(paths)) - 0.85  # with room for names below and a title above
    apart = (inner - 0.25 - tall) / max(1, len(paths) - 1)
    places += [(x, (len(paths) - 1 - i) * apart, PATH, tall) for i in range(len(paths))]
    figure.set_size_inches(width, height)
    for ax, (x, y, w, h) in zip((*axes, *paths), places, strict=True):
        ax.set_position((x / width, (BOTTOM + y) / height, w / width, h / height))
        ax.yaxis.set_label_coords(-LABEL / w, 0.5)


def _room_for_legend(axes: list[Any]) -> float:
    """The width in inches of the widest legend to the right of some axes, 0 without any."""
    longest = max((len(text) for ax in axes for text in ax.get_legend_handles_labels()[1]), default=0)
    return 0.55 + LETTER * longest if longest else 0.0


def _write_title(figure: Any, runs: Sequence[RunRecord]) -> None:
    """The scene's title, and how it was integrated; of several runs, which is which."""
    width, height = figure.get_size_inches()
    stats = runs[0].stats
    how = f"{stats.method}, {stats.setting}, {stats.evaluations} evaluations" if stats.evaluations else ""
    if len(runs) > 1:
        how = "   ".join(f"{mark} {label}" for mark, label in zip(MARKS, labels_of(runs), strict=False))
    for text, y, style in ((runs[0].title, 0.12, {"weight": "bold", "fontsize": 13}), (how, 0.4, {"fontsize": 9})):
        most = MOST_LETTERS * (1 if style.get("weight") else len(runs))
        figure.text(LEFT / width, 1 - y / height, plain_name(text, most), va="top", **style)


@styled()
def plot(run: RunRecord, names: tuple[str, ...], ax: Any = None, compare: Runs = None) -> Any:
    """Draw quantities of a run over time (Trajectory.plot)."""
    runs = runs_of(run, compare)
    if axes("ax", ax) is None:
        return draw(run, names, runs[1:])
    draw_runs(partial(draw_quantities, names=names or run.joints[:MOST_JOINTS]), ax, runs)
    ax.set_xlabel(TIME)
    ax.legend()
    return ax
