"""A run as one figure: panels against time, the path of the tip beside them; or chosen quantities on one axes."""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

from pendpin.errors import InputError
from pendpin.files import write_whole
from pendpin.graphics.panels import (
    COLORS,
    MOST_JOINTS,
    PATHS,
    draw_drift,
    draw_quantities,
    panels_of,
    plain_name,
    quantity_panels,
    turns,
)
from pendpin.trajectory import Trajectory

FORMATS = ("png", "pdf", "svg")
DPI = 120
LEFT, WIDTH, ROW, LOW, PATH, TOP, BOTTOM = 1.0, 6.2, 1.9, 1.1, 3.2, 0.75, 0.55  # inches: margins, panels, paths beside
MOST_TURNS, FAINT = 200, 0.5  # beyond so many turning points lines become areas, through which others are seen
LABEL = 0.62  # inches, from an axis to its name: to find a place for it, matplotlib would draw everything twice
TICKS = 6  # of an axis at most, and one: drawing them takes half the time of a figure
LEAST = 4.0  # inches, of the panels where paths are beside them
LETTER = 0.066  # inches, of a legend
MOST_LETTERS = 90  # of a title


def save_plot(trajectory: Trajectory, path: str | Path, names: tuple[str, ...] = ()) -> Path:
    """Write the figure of a run, or of quantities of it, to a .png, .pdf or .svg file, whole. Raises InputError."""
    return write_figure(path, lambda: draw(trajectory, names))


def write_figure(path: str | Path, drawn: Callable[[], Any]) -> Path:
    """Write the figure that a function draws to a .png, .pdf or .svg file, whole or not at all. Raises InputError."""
    path = Path(path)
    kind = picture_kind(path)
    with plain_text(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph")  # a name in a script that the font lacks
        figure = drawn()
        return write_whole(path, lambda file: figure.savefig(file, format=kind, dpi=DPI))


@contextmanager
def plain_text() -> Iterator[None]:
    """matplotlib with its own letters, whatever the user's settings: in LaTeX, names of joints would be commands."""
    try:
        from matplotlib import rc_context
    except (OSError, ValueError) as error:  # no folder that it can write to, or settings of another version
        raise InputError(f"matplotlib does not start: {error}") from None
    with rc_context({"text.usetex": False}):
        yield


def picture_kind(path: Path) -> str:
    """The format that a file's name asks for. Raises InputError if it is none of FORMATS."""
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise InputError(f"{path}: a picture's name ends in one of: {', '.join('.' + f for f in FORMATS)}")
    return kind


def draw(run: Trajectory, names: tuple[str, ...] = ()) -> Any:
    """The figure of a run, or of quantities of it by name: a matplotlib Figure that needs no display."""
    from matplotlib.figure import Figure

    figure: Any = Figure()
    panels, sides = (quantity_panels(run, names), ()) if names else (panels_of(run), PATHS)
    axes, paths = ([figure.add_axes((0, 0, 1, 1)) for _ in some] for some in (panels, sides))
    for draw_panel, ax in zip((*panels, *sides), (*axes, *paths), strict=True):
        ax.set_prop_cycle(color=COLORS)
        draw_panel(ax, run)
        ax.grid(alpha=0.25, linewidth=0.6)
        ax.spines[["top", "right"]].set_visible(False)
        ax.locator_params(nbins=TICKS)
        ax.ticklabel_format(axis="y" if ax in axes else "both", style="sci", scilimits=(-3, 4), useOffset=False)
    for ax in axes:
        for line in ax.lines:
            line.set_alpha(FAINT if turns(run) > MOST_TURNS else 1.0)
        ax.sharex(axes[0])
        ax.tick_params(labelbottom=ax is axes[-1])
        if ax.get_legend_handles_labels()[0]:
            ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=9)
    axes[-1].set_xlabel("time, s")
    _place(figure, axes, paths, [LOW if panel is draw_drift else ROW for panel in panels])
    _write_title(figure, run)
    figure._repr_png_ = lambda: _png(figure)  # a notebook shows it, without pyplot too
    return figure


def _png(figure: Any) -> bytes:
    """The picture of a figure."""
    with BytesIO() as file, plain_text():
        figure.savefig(file, format="png", dpi=DPI / 2)
        return file.getvalue()


def _place(figure: Any, axes: list[Any], paths: list[Any], rows: list[float]) -> None:
    """Give the figure its size and its axes, of these heights in inches, their places.

    matplotlib's own layout would draw everything twice.
    """
    longest = max(len(text) for ax in axes for text in ax.get_legend_handles_labels()[1] or [""])
    beside, inner = LEFT + WIDTH + 0.55 + LETTER * longest, max(sum(rows), LEAST * bool(paths))
    width, height = beside + (LEFT + PATH + 0.2) * bool(paths), TOP + inner + BOTTOM
    rows, x = [row * inner / sum(rows) for row in rows], beside + LEFT
    places = [(LEFT, sum(rows[i + 1 :]), WIDTH, row - 0.25) for i, row in enumerate(rows)]
    places += [(x, inner / 2 + 0.35, PATH, inner / 2 - 0.6), (x, 0, PATH, inner / 2 - 0.6)][: len(paths)]
    figure.set_size_inches(width, height)
    for ax, (x, y, w, h) in zip((*axes, *paths), places, strict=True):
        ax.set_position((x / width, (BOTTOM + y) / height, w / width, h / height))
        ax.yaxis.set_label_coords(-LABEL / w, 0.5)


def _write_title(figure: Any, run: Trajectory) -> None:
    """The scene's title, and how it was integrated."""
    width, height = figure.get_size_inches()
    stats = run.stats
    how = f"{stats.method}, {stats.setting}, {stats.evaluations} evaluations"
    for text, y, style in ((run.title, 0.12, {"weight": "bold", "fontsize": 13}), (how, 0.4, {"fontsize": 9})):
        figure.text(LEFT / width, 1 - y / height, plain_name(text, MOST_LETTERS), va="top", **style)


def plot(run: Trajectory, names: tuple[str, ...], ax: Any = None) -> Any:
    """As `Trajectory.plot`."""
    if ax is None:
        with plain_text():
            return draw(run, names)
    draw_quantities(ax, run, names or run.joints[:MOST_JOINTS])
    ax.set_xlabel("time, s")
    ax.legend(fontsize=9)
    return ax
