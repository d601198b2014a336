"""A run as one figure: panels against time, the path of the tip beside them; or chosen quantities on one axes."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.effects import FrameEffect
from pendpin.errors import InputError
from pendpin.graphics.drawing import Runs, distance, labels_of, runs_of, smooth
from pendpin.graphics.style import BESIDE, BLACK, COLORS, GREY, new_figure, plain_name, styled, with_unit, write_figure
from pendpin.ground.arguments import axes
from pendpin.scene import Scene
from pendpin.trajectory import RunRecord
from pendpin.trajectory.columns import DRIFT, NOTHING, is_chain, unit_of
from pendpin.trajectory.record import MOST_LETTERS

DASHES = ("-", (0, (4, 2)), (0, (1, 1.5)), (0, (6, 1.5, 1, 1.5)))  # of the first run, the second, ...
LEFT, WIDTH, ROW, LOW, PATH, TOP, BOTTOM = 1.0, 6.2, 1.9, 1.1, 3.2, 0.75, 0.55  # inches: margins, panels, paths beside
MOST_TURNS, FAINT = 200, 0.5  # a curve with more turning points fills an area; so faint, others are seen through it
LABEL = 0.62  # inches, from an axis to its name: to find a place for it, matplotlib would draw everything twice
TICKS = 6  # of an axis at most, and one: drawing them takes half the time of a figure
LEAST = 6.0  # inches, of the panels where paths are beside them
LETTER = 0.066  # inches, of a legend
MARKS = ("\u2014", "\u2013 \u2013", "\u00b7\u00b7\u00b7", "\u2013\u00b7\u2013")  # the same in letters

Panel = Callable[[Any, RunRecord], None]


def save_plot(run: RunRecord, path: str | Path, names: tuple[str, ...] = (), compare: Runs = None) -> Path:
    """Write the figure of a run, or of quantities of it, to a .png, .pdf or .svg file, whole. Raises InputError."""
    runs = runs_of(run, compare)
    return write_figure(path, lambda: draw(runs, names))


@styled()
def draw(runs: Sequence[RunRecord], names: tuple[str, ...] = ()) -> Any:
    """The figure of a run, or of quantities of it by name; further runs dashed over it, their distance below."""
    figure = new_figure(1.0, 1.0, layout=None)  # its size and places follow from what is drawn
    run, compared = runs[0], len(runs) > 1
    if names:  # a panel for each unit
        units = {name: unit_of(run, name) for name in names}
        by_unit = [tuple(name for name in names if units[name] == unit) for unit in dict.fromkeys(units.values())]
        panels, sides = [partial(draw_quantities, names=together) for together in by_unit], ()
    else:
        panels, sides = panels_of(run) + [draw_distance] * compared, SIDES if is_rope(run) else PATHS
    axes, paths = ([figure.add_axes((0, 0, 1, 1)) for _ in some] for some in (panels, sides))
    for draw_panel, ax in zip((*panels, *sides), (*axes, *paths), strict=True):
        if draw_panel is draw_distance:
            draw_distance(ax, runs)
        else:
            draw_runs(draw_panel, ax, runs)
            ax.locator_params(nbins=TICKS)
    turns = int((np.diff(np.sign(run.v), axis=0) != 0).sum(axis=0).max(initial=0))  # the most of a joint
    for ax in axes:
        for line in ax.lines:
            line.set_alpha(FAINT if turns > MOST_TURNS else line.get_alpha())
            line.set_marker("o" if len(run.t) == 1 else line.get_marker())  # no line goes through one sample
        ax.sharex(axes[0])
        ax.tick_params(labelbottom=ax is axes[-1])
    for ax in (*axes, *paths):
        names = ax.get_legend_handles_labels()[1]
        if names and not (len(names) == 1 and ax.get_ylabel().startswith(names[0])):  # what the axis says already
            ax.legend(**BESIDE)
    axes[-1].set_xlabel("time (s)")
    _place(figure, axes, paths, [LOW if panel is draw_drift else ROW for panel in panels])
    # the scene's title, and how it was integrated; of several runs, which is which
    (width, height), stats = figure.get_size_inches(), run.stats
    how = f"{stats.method}, {stats.setting}, {stats.evaluations} evaluations" if stats.evaluations else ""
    if compared:
        how = "   ".join(f"{mark} {label}" for mark, label in zip(MARKS, labels_of(runs), strict=False))
    for text, y, style in ((run.title, 0.12, {"weight": "bold", "fontsize": 13}), (how, 0.4, {"fontsize": 9})):
        most = MOST_LETTERS * (1 if style.get("weight") else len(runs))
        figure.text(LEFT / width, 1 - y / height, plain_name(text, most), va="top", **style)
    return figure


def draw_runs(draw_panel: Any, ax: Any, runs: Sequence[RunRecord]) -> None:
    """A panel of the first run, the others dashed on it; the legend says which of them lacks a quantity."""
    ax.set_prop_cycle(color=COLORS)
    draw_panel(ax, runs[0])
    if len(runs) > 1 and runs[0].tips.shape[1] == 1:  # colours tell theta from phi, dashes the runs
        for line in ax.lines:
            line.set_linestyle("-" if line.get_linestyle() == "--" else line.get_linestyle())
    axis = ax.get_ylabel()
    for i, run in enumerate(runs[1:], start=1):
        ax.set_prop_cycle(color=COLORS)
        before, names = {*ax.lines, *ax.collections}, ax.get_legend_handles_labels()[1]
        try:
            draw_panel(ax, run)
        except InputError:
            ax.plot([], [], " ", label=f"run {i + 1} has none")
        for line in set(ax.lines) - before:
            if line.get_linestyle() != "None":  # which holds a word of the legend alone
                line.set(linestyle=DASHES[i % len(DASHES)], linewidth=1.8, alpha=0.75)
        for drawn in {*ax.lines, *ax.collections} - before:
            drawn.set_label("_another run" if drawn.get_label() in names else drawn.get_label())
    ax.set_ylabel(axis)


def _place(figure: Any, axes: list[Any], paths: list[Any], rows: list[float]) -> None:
    """Give the figure its size, and its axes, of these heights in inches, places: matplotlib would draw it all twice."""
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


@styled()
def plot(run: RunRecord, names: tuple[str, ...], ax: Any = None, compare: Runs = None) -> Any:
    """Draw quantities of a run over time (Trajectory.plot)."""
    runs = runs_of(run, compare)
    if axes("ax", ax) is None:
        return draw(runs, names)
    draw_runs(partial(draw_quantities, names=names or run.joints[:MOST_JOINTS]), ax, runs)
    ax.set_xlabel("time (s)")
    ax.legend()
    return ax


# --- the panels -----------------------------------------------------------------------------------------------------

KINDS = {"rad": "angle", "rad/s": "angular velocity", "rad/s²": "angular acceleration", "m": "position"}
KINDS |= {"m/s": "velocity", "m/s²": "acceleration", "N": "force", "N m": "moment", "J": "energy", "": "energy drift"}
STYLES = ("-", "--", ":")  # of the first, second and third rod: lines that lie on each other are seen
MOST_RODS = 3
VIEWS = {"above": (0, 1), "front": (1, 2), "side": (0, 2)}  # of x, y, z those to the right and up
MOST_POINTS = 30_000  # of a path
MOST_JOINTS = 6  # of a tree: those that move most


def panels_of(run: RunRecord) -> list[Panel]:
    """What is drawn against time: drift where energy is conserved, moments if any, no swing of a rope held at both ends."""
    panels: list[Panel] = [draw_energy, *[draw_drift] * run.stats.conservative]
    if is_rope(run):
        held = np.ptp(run["swing"]) < HELD * run["swing"].max()
        return [draw_offset, *[draw_swing] * (not held), draw_largest_tension, *panels]
    several = run.rod_reactions is not None and _count(run) > 1
    tensions = partial(draw_rods, name="R3", axis="tension R3 (N)")
    panels += [draw_positions, tensions if several else draw_forces]
    if run.rod_reactions is not None:
        size = np.abs(run.rod_reactions.R3).max() * np.abs(run.tips).max()
        moments = partial(draw_rods, name="M3", axis="moment M3 (N m)")
        panels += [moments] * bool(np.abs(run.rod_reactions.M3).max() > NOTHING * size)
    return panels


def draw_energy(ax: Any, run: RunRecord) -> None:
    """Kinetic and potential energy and their sum, the energy, the potential from its least value on."""
    kinetic, potential = run.kinetic, run.potential - run.potential.min()
    ax.plot(run.t, kinetic, label="kinetic", color=COLORS[1])
    if potential.any():
        ax.plot(run.t, potential, label="potential*", color=COLORS[0])
        ax.plot(run.t, kinetic + potential, label="energy", color=BLACK, linewidth=1.6, zorder=1)
        ax.plot([], [], " ", label="* above its least")
    ax.set_ylabel("energy (J)")


def draw_drift(ax: Any, run: RunRecord) -> None:
    """The change of the energy, which should be none, divided by the energy exchanged."""
    ax.plot(run.t, run[DRIFT], color=BLACK, linewidth=0.9)
    for label in ("change of the energy /", "energy exchanged"):
        ax.plot([], [], " ", label=label)
    ax.set_ylabel("energy drift")


def draw_distance(ax: Any, runs: Sequence[RunRecord]) -> None:
    """How far the tips of further runs are from that of the first, on a logarithmic axis; 0 is not drawn."""
    first, labels = runs[0], labels_of(runs)
    for dash, label, run in zip(DASHES[1:], labels[1:], runs[1:], strict=False):
        (rows, apart), look = distance(run, first), {"linestyle": dash, "label": plain_name(label, 24)}
        ax.plot(run.t[rows], np.where(apart > 0, apart, np.nan), color=BLACK, **look)
    ax.set_yscale("log")
    low, high = ax.get_ylim()
    if high < 10 * low:  # no power of 10 is in it, and 2.2 x 10^0 would reach the name of the axis
        ax.yaxis.set_minor_formatter("{x:.3g}")
    ax.set_ylabel("tips apart (m)")


def draw_positions(ax: Any, run: RunRecord) -> None:
    """theta solid and phi dashed, a colour for each of several rods; of a tree the joints that move most."""
    rods = rods_shown(run)
    if rods and len(run.joints) == 2 * _count(run):
        for color, rod in zip(COLORS, rods, strict=False):
            for i, joint in enumerate((2 * rod, 2 * rod + 1)):
                look = {"color": COLORS[i] if len(rods) == 1 else color, "linestyle": STYLES[i]}
                ax.plot(run.t, run.q[:, joint], label=plain_name(run.joints[joint]), **look)
        _say_left_out(ax, len(rods), _count(run), "rods")
        ax.set_ylabel("position (rad)")
        return
    joints = joints_shown(run)
    names = [run.joints[joint] for joint in joints]
    units = [unit_of(run, name) for name in names]
    if several := len(set(units)) > 1:  # angles and slides: each with its own
        names = [f"{name} ({unit})" for name, unit in zip(names, units, strict=True)]
    for color, joint, name in zip(COLORS, joints, names, strict=False):
        ax.plot(run.t, run.q[:, joint], label=plain_name(name), color=color)
    _say_left_out(ax, len(joints), len(run.joints), "joints")
    ax.set_ylabel(with_unit("position", "rad or m" if several else units[0]))


def draw_forces(ax: Any, run: RunRecord) -> None:
    """R1, R2, R3 of a single rod; of a tree the size of the force in each joint."""
    if run.rod_reactions is None:
        for color, joint in zip(COLORS, joints_shown(run), strict=False):
            size = np.linalg.norm(run.wrench[:, joint, :3], axis=-1)
            ax.plot(run.t, size, label=plain_name(run.joints[joint]), color=color)
        ax.set_ylabel("joint force (N)")
    else:
        for color, name in zip(COLORS, ("R1", "R2", "R3"), strict=False):
            ax.plot(run.t, run[name], label=name, color=color)
        ax.set_ylabel("reactions (N)")


def draw_rods(ax: Any, run: RunRecord, name: str, axis: str) -> None:
    """A reaction of the rods that are shown: their tension R3, or the moment M3 of each joint about its rod."""
    ax.set_ylabel(axis)
    values = getattr(run.reactions(), name)
    for color, style, rod in zip(COLORS, STYLES, rods_shown(run), strict=False):
        label = f"rod {rod + 1}" if _count(run) > 1 else name
        ax.plot(run.t, values[:, rod], style, label=label, color=color)
    _say_left_out(ax, len(rods_shown(run)), _count(run), "rods")


def _say_left_out(ax: Any, drawn: int, count: int, what: str) -> None:
    """In the legend, that not all are drawn."""
    if drawn < count:
        ax.plot([], [], " ", label=f"{drawn} of {count} {what}")


def draw_path(ax: Any, run: RunRecord, view: str) -> None:
    """Two coordinates of the last tip to one scale whatever the motion, a dot where it starts; from above with the pivot."""
    right, up = VIEWS[view]
    said = support_note(run)
    if view == "above" and run.rod_reactions is not None:
        ax.plot([0], [0], "+", color=GREY, markersize=9)
    path = run.tips[:, -1]
    middle, reach = (path.min(0) + path.max(0)) / 2, np.ptp(path, axis=0).max() / 2
    ax.update_datalim([(middle[right] + side * reach, middle[up]) for side in (-1, 1)])  # one scale for all three views
    if len(path) > 2:
        rate = len(path) / np.ptp(run.t)  # a second: no coarser than the samples
        path = smooth(run.t, path, None, rate, max(MOST_POINTS, len(path)))[1]
    ax.plot(path[:, right], path[:, up], color=COLORS[0], linewidth=0.8)
    ax.plot(path[:1, right], path[:1, up], "o", color=COLORS[1], markersize=5)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel=with_unit("xyz"[right], "m"), ylabel=with_unit("xyz"[up], "m"))
    whose = f"path of the tip {said},\n" if said else "path of the tip, "
    ax.set_title(f"{whose if view == 'above' else ''}from {'' if view == 'above' else 'the '}{view}")


def support_note(run: RunRecord) -> str:
    """What a figure says where the support moves, as all places are those in its frame."""
    if isinstance(run.source, Scene):
        moves = any(isinstance(effect, FrameEffect) for effect in run.source.effects)
    else:
        moves = any(effect.get("kind") == "support" for effect in run.scene.get("effects") or ())
    return "relative to the support" if moves else ""


def draw_quantities(ax: Any, run: RunRecord, names: tuple[str, ...]) -> None:
    """Quantities by name on one axes; it bears the name of a single one, else what their unit measures."""
    for name in names:
        ax.plot(run.t, run[name], label=plain_name(name))
    units = list(dict.fromkeys(unit_of(run, name) for name in names))
    kind = KINDS.get(units[0], "position") if len(units) == 1 else "quantities"
    ax.set_ylabel(with_unit(names[0] if len(names) == 1 else kind, " or ".join(filter(None, units))))


def _count(run: RunRecord) -> int:
    """How many rods on universal joints there are."""
    return 0 if run.rod_reactions is None else run.rod_reactions.R3.shape[1]


def rods_shown(run: RunRecord) -> list[int]:
    """All rods of up to three, else the first, the middle and the last."""
    count = _count(run)
    return list(range(count)) if count <= MOST_RODS else [0, (count - 1) // 2, count - 1]


def joints_shown(run: RunRecord) -> list[int]:
    """All joints of up to six, else the six that move most, in model order."""
    return sorted(np.argsort(-np.ptp(run.q, axis=0), kind="stable")[:MOST_JOINTS].tolist())


# --- the panels of a rope: a chain of so many rods that their angles one by one say little --------------------------

MOST_AS_RODS = 12  # of longer chains the figure is that of a rope
SHAPES = 8  # instants at which a rope's shape is drawn
SLENDER = 0.5  # of its height: a rope that moves less far sideways is drawn wider, so that its shapes are apart
HELD = 0.01  # of its largest value: a swing that changes by less is that of a tip that is held


def is_rope(run: RunRecord) -> bool:
    """Whether a run is that of a chain of more than MOST_AS_RODS rods."""
    return is_chain(run) and len(run.joints) > 2 * MOST_AS_RODS


def draw_offset(ax: Any, run: RunRecord) -> None:
    """How far the last tip is from below the support: along x, along y, and in all."""
    x, y = run.tips[:, -1, :2].T
    ax.plot(run.t, np.hypot(x, y), label="sideways", color=BLACK, linewidth=1.6)
    ax.plot(run.t, x, label="x", color=COLORS[0])
    ax.plot(run.t, y, label="y", color=COLORS[1])
    if said := support_note(run):
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
    from matplotlib import colormaps

    x, y, height = run.tips.max((0, 1), initial=0.0) - run.tips.min((0, 1), initial=0.0)
    across = int(y > x)
    slender = bool(0 < max(x, y) < SLENDER * height)
    rows = np.unique(np.linspace(0, len(run.t) - 1, SHAPES).round().astype(int))
    for color, row in zip(colormaps["viridis"](np.linspace(0.0, 0.9, len(rows))), rows, strict=True):
        points = np.insert(run.tips[row], 0, 0.0, axis=0)
        ax.plot(points[:, across], points[:, 2], color=color, linewidth=1.4, label=f"{run.t[row]:.4g} s")
        ax.plot(points[-1:, across], points[-1:, 2], "o", color=color, markersize=4)
    ax.plot([0], [0], "+", color=GREY, markersize=9)
    if not slender:
        ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel=with_unit("xy"[across] + ", drawn wider than z" * slender, "m"), ylabel="z (m)")
    ax.set_title(f"shape of the rope{support_note(run) and ', '}{support_note(run)}")


def draw_tension_along(ax: Any, run: RunRecord) -> None:
    """Tension over arc length, at the upper ends of the rods: its range in time; at both ends of the run and at its peak."""
    from matplotlib import colormaps

    R3, ends = run.reactions().R3, run.tips[0]
    lengths = np.linalg.norm(np.diff(ends, axis=0, prepend=0.0), axis=-1)
    s = np.cumsum(lengths) - lengths
    ax.fill_between(s, R3.min(0), R3.max(0), color=COLORS[5], alpha=0.25, linewidth=0, label="at any time")
    peak, last = int(R3.max(1).argmax()), len(R3) - 1
    rows = np.unique([0, last // 2 if peak in (0, last) else peak, last])
    for color, row in zip(colormaps["viridis"](np.linspace(0.0, 0.9, len(rows))), rows, strict=True):
        ax.plot(s, R3[row], color=color, linewidth=1.4, label=f"{run.t[row]:.4g} s" + ", peak" * bool(row == peak))
    ax.set(xlabel="arc length from the support (m)", ylabel="tension R3 (N)")
    ax.set_title("tension along the rope")


PATHS: tuple[Panel, ...] = tuple(partial(draw_path, view=view) for view in VIEWS)  # beside the panels
SIDES: tuple[Panel, ...] = (draw_shapes, draw_tension_along, PATHS[0])  # of a rope
