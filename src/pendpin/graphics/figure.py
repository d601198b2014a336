"""A run as one figure: energy, angles and joint reactions against time."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError, one_line
from pendpin.files import write_whole
from pendpin.trajectory import Trajectory

FORMATS = ("png", "pdf", "svg")
DPI = 120
MOST_LINES = 6  # curves a panel names; of more, the first and the last are drawn


def save_plot(trajectory: Trajectory, path: str | Path) -> Path:
    """Write the figure of a run to a .png, .pdf or .svg file, whole or not at all. Raises InputError."""
    path = Path(path)
    kind = picture_kind(path)
    with plain_text(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph")  # a name in a script that the font lacks
        figure = draw(trajectory)
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


def draw(trajectory: Trajectory) -> Any:
    """The figure of a run: a matplotlib Figure that needs no display."""
    from matplotlib.figure import Figure

    panels = [_energy, _drift, _angles, _forces]
    if trajectory.rods is not None and np.abs(trajectory.rods.M3).max() > 0:
        panels.append(_moments)
    figure = Figure(figsize=(9, 2.1 * len(panels) + 0.6))
    axes = figure.subplots(len(panels), 1, sharex=True)
    for panel, ax in zip(panels, axes, strict=True):
        panel(ax, trajectory)
        ax.grid(alpha=0.25, linewidth=0.6)
        ax.spines[["top", "right"]].set_visible(False)
        if ax.get_legend_handles_labels()[0]:
            ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=9)
    axes[-1].set_xlabel("time, s")
    figure.align_ylabels()
    longest = max(len(text) for ax in axes for text in ax.get_legend_handles_labels()[1] or [""])
    height = figure.get_size_inches()[1]  # margins by hand: matplotlib's own layout draws everything twice
    margins = {"left": 0.1, "right": 0.92 - 0.0085 * longest, "bottom": 0.5 / height, "top": 1 - 0.35 / height}
    figure.subplots_adjust(**margins, hspace=0.18)
    stats = trajectory.stats
    title = f"{_plain(stats.method)}, {stats.setting}, {stats.evaluations} evaluations"
    figure.suptitle(title, fontsize=10, y=1 - 0.1 / height, va="top")
    return figure


def _plain(name: str) -> str:
    """A name as matplotlib shows it letter by letter: no mathematics between dollars, and never left out."""
    text = one_line(name[:40]).replace("$", r"\$")
    return f" {text}" if text.startswith("_") else text


def _energy(ax: Any, trajectory: Trajectory) -> None:
    energy = trajectory.energy()
    ax.plot(trajectory.t, energy.kinetic, label="kinetic", color="#d9622b")
    ax.plot(trajectory.t, energy.potential, label="potential", color="#2b6cb0")
    ax.plot(trajectory.t, energy.total, label="total", color="#1a202c", linewidth=1.8)
    ax.set_ylabel("energy, J")


def _drift(ax: Any, trajectory: Trajectory) -> None:
    total = trajectory.energy().total
    ax.plot(trajectory.t, total - total[0], color="#1a202c", linewidth=0.9, label="total - start")
    ax.set_ylabel("energy drift, J")
    ax.ticklabel_format(axis="y", style="sci", scilimits=(-2, 2))


def _angles(ax: Any, trajectory: Trajectory) -> None:
    for column in _shown(len(trajectory.joints)):
        ax.plot(trajectory.t, trajectory.q[:, column], label=_plain(trajectory.joints[column]), linewidth=1.2)
    ax.set_ylabel("position, rad" if trajectory.rods is not None else "position, rad or m")


def _forces(ax: Any, trajectory: Trajectory) -> None:
    if trajectory.rods is None:
        for column in _shown(len(trajectory.joints)):
            size = np.linalg.norm(trajectory.wrench[:, column, :3], axis=-1)
            ax.plot(trajectory.t, size, label=_plain(trajectory.joints[column]), linewidth=1.2)
        ax.set_ylabel("joint force, N")
        return
    count = trajectory.rods.R1.shape[1]
    names = ("R1", "R2", "R3") if count == 1 else ("R3",)
    for name in names:
        for column in _shown(count):
            label = name if count == 1 else f"{name}, rod {column + 1}"
            ax.plot(trajectory.t, getattr(trajectory.rods, name)[:, column], label=label, linewidth=1.2)
    ax.set_ylabel("reactions, N" if count == 1 else "tension, N")


def _moments(ax: Any, trajectory: Trajectory) -> None:
    rods = trajectory.reactions()
    count = rods.M3.shape[1]
    for column in _shown(count):
        label = "M3" if count == 1 else f"M3, rod {column + 1}"
        ax.plot(trajectory.t, rods.M3[:, column], label=label, linewidth=1.2)
    ax.set_ylabel("moment, N m")
    ax.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3))


def _shown(count: int) -> list[int]:
    half = MOST_LINES // 2
    return list(range(count)) if count <= MOST_LINES else [*range(half), *range(count - half, count)]


def plot(trajectory: Trajectory, names: tuple[str, ...], ax: Any = None) -> Any:
    """As `Trajectory.plot`."""
    if not names and ax is None:
        with plain_text():
            return draw(trajectory)
    if ax is None:
        from matplotlib.figure import Figure

        ax = Figure(figsize=(7, 3.5), layout="constrained").subplots()
    for name in names or trajectory.joints[:MOST_LINES]:
        ax.plot(trajectory.t, trajectory[name], label=_plain(name), linewidth=1.2)
    ax.set_xlabel("time, s")
    ax.legend(fontsize=9)
    return ax
