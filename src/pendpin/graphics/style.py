"""The one look of every figure: colours, letters, axes, legends, and the way a quantity is written with its unit."""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

from pendpin.errors import InputError, one_line
from pendpin.ground.files import path_of, write_whole

# Colours that colour-blind people tell apart (Okabe and Ito, Color Universal Design, 2008).
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
BLACK = COLORS[-1]
GREY, PALE, SHADE = "#718096", "#b8c2cf", "#edf2f7"  # notes, curves that matter less, areas behind them
STYLE: dict[Any, Any] = {
    "text.usetex": False,  # in LaTeX, names of joints would be commands
    "axes.prop_cycle": f"cycler('linestyle', ['-', '--', ':']) * cycler('color', {list(COLORS)})",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.alpha": 0.25,
    "grid.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.labelsize": 10,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.formatter.limits": (-3, 4),
    "axes.formatter.useoffset": False,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "lines.linewidth": 1.2,
    "lines.markersize": 4,
}
FORMATS = ("png", "pdf", "svg")
SHOWN = 84  # of a figure in a page or a notebook
BESIDE: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5)}  # of a legend: right of its axes


@contextmanager
def styled() -> Iterator[None]:
    """matplotlib with pendpin's look, whatever the user's settings; also a decorator of functions that draw."""
    try:
        from matplotlib import rc_context
    except (OSError, ValueError) as error:  # no folder that it can write to, or settings of another version
        raise InputError(f"matplotlib does not start: {error}") from None
    with rc_context(STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph")  # a name in a script that the font lacks
        yield


def new_figure(width: float, height: float, layout: Any = "constrained") -> Any:
    """A matplotlib Figure of this size in inches, which a notebook shows without pyplot too."""
    from matplotlib.figure import Figure

    figure: Any = Figure(figsize=(width, height), layout=layout)
    figure._repr_png_ = lambda: picture_of(figure)
    return figure


def with_unit(name: str, unit: str = "") -> str:
    """A quantity and its unit as every axis names it: "theta_1 (rad)"; the name alone where there is no unit."""
    return f"{plain_name(name, 60)} ({unit})" if unit else plain_name(name, 60)


def plain_name(name: str, most: int = 40) -> str:
    """A name as matplotlib shows it letter by letter: no mathematics between dollars, and never left out."""
    text = one_line(name[:most]).replace("$", r"\$")
    return f" {text}" if text.startswith("_") else text


def write_figure(path: str | Path, drawn: Callable[[], Any]) -> Path:
    """Write the figure that a function draws to a .png, .pdf or .svg file, whole or not at all. Raises InputError."""
    path = path_of(path)
    kind = picture_kind(path)
    with styled():
        figure = drawn()
        return write_whole(path, lambda file: figure.savefig(file, format=kind, dpi=120))


def picture_kind(path: Path) -> str:
    """The format that a file's name asks for. Raises InputError if it is none of FORMATS."""
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise InputError(f"{path}: a picture's name ends in one of: {', '.join('.' + f for f in FORMATS)}")
    return kind


def picture_of(figure: Any) -> bytes:
    """The picture of a figure, as PNG."""
    with BytesIO() as file, styled():
        figure.savefig(file, format="png", dpi=SHOWN)
        return file.getvalue()
