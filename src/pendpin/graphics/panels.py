"""The panels of a run's figure: energy, positions, reactions against time, and the path of the tip."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from pendpin.effects import FrameEffect
from pendpin.errors import InputError, shown
from pendpin.graphics.drawing import smooth
from pendpin.graphics.style import BLACK, COLORS, GREY, plain_name, with_unit
from pendpin.ground.arrays import Array, Indices
from pendpin.ground.keypaths import leaves
from pendpin.scene import Scene
from pendpin.trajectory import RunRecord
from pendpin.trajectory.columns import DRIFT, named_with_units, unit_of

MOST_KEYS = 2  # in which runs differ, in a label
MOST = 4  # runs: the eye tells four colours and dashes apart
DASHES = ("-", (0, (4, 2)), (0, (1, 1.5)), (0, (6, 1.5, 1, 1.5)))  # in a figure: of the first run, the second, ...
Runs = RunRecord | Sequence[RunRecord] | None


def runs_of(run: RunRecord, compare: Runs) -> list[RunRecord]:
    """A run and those it is compared with. Raises InputError for too many, or runs at other times."""
    others = [compare] if isinstance(compare, RunRecord) else [] if compare is None else compare
    if not isinstance(others, Sequence):
        raise InputError(f"compare: {shown(others)} is not a run, nor a list of runs")
    if len(others) >= MOST:
        raise InputError(f"compare: {len(others) + 1} runs are too many for one picture, which holds {MOST}")
    for other in others:
        if not isinstance(other, RunRecord):
            raise InputError(f"compare: a {type(other).__name__} is not a run")
        if len(run.t) and (not len(other.t) or other.t[0] > run.t[-1] or other.t[-1] < run.t[0]):
            raise InputError(
                f"compare: the run from {run.t[0]:g} to {run.t[-1]:g} s has no time in common with another"
            )
    return [run, *others]


def labels_of(runs: Sequence[RunRecord]) -> list[str]:
    """What tells runs apart: their methods and settings, or their scenes, or their places in the list."""
    for one in (
        lambda run: f"{run.stats.method}, {run.stats.setting}",
        lambda run: run.title,
        lambda run: f"{run.title}, {run.stats.method}, {run.stats.setting}",
    ):
        labels = [one(run) for run in runs]
        if len(set(labels)) == len(labels):
            return labels
    return [f"run {i + 1}: {label}" for i, label in enumerate(_different_numbers(runs))]


def _different_numbers(runs: Sequence[RunRecord]) -> list[str]:
    """Of each run the numbers of its scene in which it differs from another, by key path; else its method and setting."""
    tables = [dict(leaves(run.scene)) for run in runs]
    keys = [
        key
        for key in dict.fromkeys(k for table in tables for k in table)
        if len({repr(t.get(key)) for t in tables}) > 1
    ]
    if not keys:
        return [f"{run.stats.method}, {run.stats.setting}" for run in runs]
    more = f", ... ({len(keys)} numbers)" if len(keys) > MOST_KEYS else ""
    return [", ".join(f"{key} {table.get(key, 'absent')}" for key in keys[:MOST_KEYS]) + more for table in tables]


def rows_within(run: RunRecord, first: RunRecord) -> Indices:
    """The samples of a run in the time of another, indices (k,)."""
    return np.flatnonzero((run.t >= first.t[0]) & (run.t <= first.t[-1]))


def distance(run: RunRecord, first: RunRecord) -> Array:
    """How far the last tips of two runs are apart at the samples of `rows_within`, (k,) in m.

    Where the first run has no sample a cubic spline through its samples gives the tip; its error falls with the fourth
    power of the time between samples.
    """
    from scipy.interpolate import CubicSpline

    rows = rows_within(run, first)
    t, tip = run.t[rows], run.tips[rows, -1]
    at = np.searchsorted(first.t, t)
    if (first.t[np.minimum(at, len(first.t) - 1)] == t).all():
        return np.linalg.norm(tip - first.tips[at, -1], axis=-1)
    once = np.concatenate([[True], np.diff(first.t) > 0])
    return np.linalg.norm(tip - CubicSpline(first.t[once], first.tips[once, -1])(t), axis=-1)


# --- the panels of a run's figure -----------------------------------------------------------------------------------

KINDS = {"rad": "angle", "rad/s": "angular velocity", "rad/s²": "angular acceleration", "m": "position"}
KINDS |= {"m/s": "velocity", "m/s²": "acceleration", "N": "force", "N m": "moment", "J": "energy", "": "energy drift"}
STYLES = ("-", "--", ":")  # of the first, second and third rod: lines that lie on each other are seen
MOST_RODS = 3
MOST_POINTS = 30_000  # of a path
MOST_JOINTS = 6  # of a tree: those that move most
NOTHING = 1e-12  # of the largest force times the model's size: a moment below is rounding

Panel = Callable[[Any, RunRecord], None]


def panels_of(run: RunRecord) -> list[Panel]:
    """What is drawn against time, from above: drift where energy is conserved, moments where there are any."""
    panels: list[Panel] = [draw_energy]
    if run.stats.conservative:
        panels.append(draw_drift)
    panels += [draw_positions, draw_forces]
    if run.rod_reactions is not None:
        size = np.abs(run.rod_reactions.R3).max() * np.abs(run.tips).max()
        panels += [draw_moments] * bool(np.abs(run.rod_reactions.M3).max() > NOTHING * size)
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
    labels = labels_of(runs)
    for dash, label, run in zip(DASHES[1:], labels[1:], runs[1:], strict=False):
        apart = distance(run, runs[0])
        ax.plot(
            run.t[rows_within(run, runs[0])],
            np.where(apart > 0, apart, np.nan),
            label=plain_name(label, 24),
            color=BLACK,
            linestyle=dash,
        )
    ax.set_yscale("log")
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
    names, unit = named_with_units(run, joints)
    for color, joint, name in zip(COLORS, joints, names, strict=False):
        ax.plot(run.t, run.q[:, joint], label=plain_name(name), color=color)
    _say_left_out(ax, len(joints), len(run.joints), "joints")
    ax.set_ylabel(with_unit("position", unit))


def draw_forces(ax: Any, run: RunRecord) -> None:
    """R1, R2, R3 of a single rod; the tension R3 of several; of a tree the size of the force in each joint."""
    if run.rod_reactions is None:
        for color, joint in zip(COLORS, joints_shown(run), strict=False):
            size = np.linalg.norm(run.wrench[:, joint, :3], axis=-1)
            ax.plot(run.t, size, label=plain_name(run.joints[joint]), color=color)
        ax.set_ylabel("joint force (N)")
    elif _count(run) == 1:
        for color, name in zip(COLORS, ("R1", "R2", "R3"), strict=False):
            ax.plot(run.t, run[name], label=name, color=color)
        ax.set_ylabel("reactions (N)")
    else:
        _draw_rods(ax, run, "R3")
        ax.set_ylabel("tension R3 (N)")


def draw_moments(ax: Any, run: RunRecord) -> None:
    """The moment M3 of each rod's joint about the rod."""
    _draw_rods(ax, run, "M3")
    ax.set_ylabel("moment M3 (N m)")


def _draw_rods(ax: Any, run: RunRecord, name: str) -> None:
    """A reaction of the rods that are shown."""
    values = getattr(run.reactions(), name)
    for color, style, rod in zip(COLORS, STYLES, rods_shown(run), strict=False):
        label = f"rod {rod + 1}" if _count(run) > 1 else name
        ax.plot(run.t, values[:, rod], style, label=label, color=color)
    _say_left_out(ax, len(rods_shown(run)), _count(run), "rods")


def _say_left_out(ax: Any, drawn: int, count: int, what: str) -> None:
    """In the legend, that not all are drawn."""
    if drawn < count:
        ax.plot([], [], " ", label=f"{drawn} of {count} {what}")


def draw_path_from_above(ax: Any, run: RunRecord) -> None:
    """The tip's path in the horizontal plane, and the pivot of a chain."""
    if run.rod_reactions is not None:
        ax.plot([0], [0], "+", color=GREY, markersize=9)
    _draw_path(ax, run, 0, 1)
    said = relative(run)
    ax.set_title(f"path of the tip{(said and f' {said},{chr(10)}') or ', '}from above")


def draw_path_from_the_front(ax: Any, run: RunRecord) -> None:
    """The tip's path in the plane of y and z: the axes do not depend on the motion, so that runs compare."""
    _draw_path(ax, run, 1, 2)
    ax.set_title("from the front")


def draw_path_from_the_side(ax: Any, run: RunRecord) -> None:
    """The tip's path in the plane of x and z."""
    _draw_path(ax, run, 0, 2)
    ax.set_title("from the side")


def _draw_path(ax: Any, run: RunRecord, right: int, up: int) -> None:
    """Two coordinates of the last tip to one scale, a dot where it starts."""
    path = run.tips[:, -1]
    middle, reach = (path.min(0) + path.max(0)) / 2, np.ptp(path, axis=0).max() / 2
    ax.update_datalim([(middle[right] + side * reach, middle[up]) for side in (-1, 1)])  # one scale for all three views
    if len(path) > 2:
        rate = len(path) / np.ptp(run.t)  # a second: no coarser than the samples
        path = smooth(run.t, path, np.gradient(path, run.t, axis=0), rate, max(MOST_POINTS, len(path)))[1]
    ax.plot(path[:, right], path[:, up], color=COLORS[0], linewidth=0.8)
    ax.plot(path[:1, right], path[:1, up], "o", color=COLORS[1], markersize=5)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel=with_unit("xyz"[right], "m"), ylabel=with_unit("xyz"[up], "m"))


PATHS: tuple[Panel, ...] = (draw_path_from_above, draw_path_from_the_front, draw_path_from_the_side)


def relative(run: RunRecord) -> str:
    """What a figure says where the support moves, as all places are those in its frame."""
    if isinstance(run.source, Scene):
        moves = any(isinstance(effect, FrameEffect) for effect in run.source.effects)
    else:
        moves = any(effect.get("kind") == "support" for effect in run.scene.get("effects") or ())
    return "relative to the support" if moves else ""


def quantity_panels(run: RunRecord, names: tuple[str, ...]) -> list[Panel]:
    """A panel for each unit of some quantities. Raises InputError for a name that the run lacks."""
    units = {name: unit_of(run, name) for name in names}
    by_unit = [tuple(name for name in names if units[name] == unit) for unit in dict.fromkeys(units.values())]
    return [partial(draw_quantities, names=together) for together in by_unit]


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


def turns(run: RunRecord) -> int:
    """The largest number of turning points of a joint."""
    return int((np.diff(np.sign(run.v), axis=0) != 0).sum(axis=0).max(initial=0))
