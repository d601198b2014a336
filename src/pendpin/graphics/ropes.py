"""The panels of a rope's figure: a chain of so many rods that their angles one by one say little."""

from typing import Any

import numpy as np

from pendpin.graphics.panels import Panel, draw_drift, draw_energy, draw_path_from_above, relative
from pendpin.graphics.style import BLACK, COLORS, GREY, with_unit
from pendpin.trajectory import RunRecord
from pendpin.trajectory.columns import is_chain

MOST_AS_RODS = 12  # of longer chains the figure is that of a rope
SHAPES = 8  # instants at which a rope's shape is drawn
SLENDER = 0.5  # of its height: a rope that moves less far sideways is drawn wider, so that its shapes are told apart
HELD = 0.01  # of its largest value: a swing that changes by less is that of a tip that is held


def is_rope(run: RunRecord) -> bool:
    """Whether a run is that of a chain of more than MOST_AS_RODS rods."""
    return is_chain(run) and len(run.joints) > 2 * MOST_AS_RODS


def panels_of_rope(run: RunRecord) -> list[Panel]:
    """What is drawn against time, from above: no swing of a rope that is held at both ends."""
    held = np.ptp(run["swing"]) < HELD * run["swing"].max()
    swinging = [draw_offset] + [draw_swing] * (not held)
    return [*swinging, draw_largest_tension, draw_energy, *[draw_drift] * run.stats.conservative]


def draw_offset(ax: Any, run: RunRecord) -> None:
    """How far the last tip is from below the support: along x, along y, and in all."""
    x, y = run.tips[:, -1, :2].T
    ax.plot(run.t, np.hypot(x, y), label="sideways", color=BLACK, linewidth=1.6)
    ax.plot(run.t, x, label="x", color=COLORS[0])
    ax.plot(run.t, y, label="y", color=COLORS[1])
    if said := relative(run):
        ax.plot([], [], " ", label=said)
    ax.set_ylabel("tip's offset (m)")


def draw_swing(ax: Any, run: RunRecord) -> None:
    """The angle of the line from the support to the last tip from straight down."""
    ax.plot(run.t, run["swing"], color=BLACK)
    for label in ("line to the tip,", "from straight down"):
        ax.plot([], [], " ", label=label)
    ax.set_ylabel("swing (rad)")


def draw_largest_tension(ax: Any, run: RunRecord) -> None:
    """The largest and the least tension along the rope at each time."""
    R3 = run.reactions().R3
    ax.plot(run.t, R3.max(1), label="largest in the rope", color=COLORS[0])
    ax.plot(run.t, R3.min(1), label="least in the rope", color=COLORS[1])
    ax.set_ylabel("tension R3 (N)")


def draw_shapes(ax: Any, run: RunRecord) -> None:
    """The rope at SHAPES instants, in the vertical plane through x or y in which it moves more; to one scale, or wider."""
    x, y, height = run.tips.max((0, 1), initial=0.0) - run.tips.min((0, 1), initial=0.0)
    across = int(y > x)
    slender = bool(0 < max(x, y) < SLENDER * height)
    rows = np.unique(np.linspace(0, len(run.t) - 1, SHAPES).round().astype(int))
    for color, row in zip(_colors_of_times(len(rows)), rows, strict=True):
        points = np.concatenate([np.zeros((1, 3)), run.tips[row]])
        ax.plot(points[:, across], points[:, 2], color=color, linewidth=1.4, label=f"{run.t[row]:.4g} s")
        ax.plot(points[-1:, across], points[-1:, 2], "o", color=color, markersize=4)
    ax.plot([0], [0], "+", color=GREY, markersize=9)
    if not slender:
        ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel=with_unit("xy"[across] + ", drawn wider than z" * slender, "m"), ylabel="z (m)")
    ax.set_title(f"shape of the rope{relative(run) and ', '}{relative(run)}")


def draw_tension_along(ax: Any, run: RunRecord) -> None:
    """Tension over arc length, at the upper ends of the rods: its range in time; at both ends of the run and at its peak."""
    R3, ends = run.reactions().R3, run.tips[0]
    lengths = np.linalg.norm(np.diff(ends, axis=0, prepend=0.0), axis=-1)
    s = np.cumsum(lengths) - lengths
    ax.fill_between(s, R3.min(0), R3.max(0), color=COLORS[5], alpha=0.25, linewidth=0, label="at any time")
    peak, last = int(R3.max(1).argmax()), len(R3) - 1
    rows = np.unique([0, last // 2 if peak in (0, last) else peak, last])
    for color, row in zip(_colors_of_times(len(rows)), rows, strict=True):
        ax.plot(s, R3[row], color=color, linewidth=1.4, label=f"{run.t[row]:.4g} s" + ", peak" * bool(row == peak))
    ax.set(xlabel="arc length from the support (m)", ylabel="tension R3 (N)")
    ax.set_title("tension along the rope")


def _colors_of_times(count: int) -> Any:
    """Colours (count, 4) from the first instant to the last, dark to light."""
    from matplotlib import colormaps

    return colormaps["viridis"](np.linspace(0.0, 0.9, count))


SIDES: tuple[Panel, ...] = (draw_shapes, draw_tension_along, draw_path_from_above)
