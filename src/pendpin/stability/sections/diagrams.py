"""Bifurcation diagrams: a section over a number of the scene, the state carried from value to value."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError, RunError, shown
from pendpin.graphics.style import BESIDE, COLORS, new_figure, styled, with_unit
from pendpin.ground.arguments import axes, numbers
from pendpin.ground.arrays import Array, ArrayLike
from pendpin.ground.report import Report, Result, Table
from pendpin.scene import Scene, chosen_scene, unit_of_key
from pendpin.stability.sections.points import Section, wrapped

MOST_CYCLE = 16  # points of a cycle that is told from chaos
SAME = 1e-6  # of the range of a quantity, or rad: the distance of two points of a cycle that are one


@dataclass(frozen=True, eq=False, repr=False)
class Bifurcation(Result):
    """A stroboscopic section at each of k values of a number: the state is carried from value to value, up and down."""

    key: str
    at: Array  # (k,) the values
    section: Section
    up: Array  # (k, count, len(of)); NaN where a motion cannot be run
    down: Array
    why: tuple[str, ...]  # why motions could not be run
    units: dict[str, str]  # of the quantities and of the number

    @styled()
    def plot(self, ax: Any = None) -> Any:
        """Draw the first quantity against the number, up and down, on a matplotlib Axes; returns it."""
        ax = axes("ax", ax) or new_figure(7.0, 4.5).subplots()
        name = self.section.of[0]
        for rows, colour, label in ((self.down, COLORS[1], "down"), (self.up, COLORS[0], "up")):
            y = wrapped(rows[..., 0]) if self.units[name] == "rad" else rows[..., 0]
            ax.plot(np.repeat(self.at, y.shape[1]), y.ravel(), ".", ms=1.5, mew=0, color=colour, label=label)
        ax.set(xlabel=with_unit(self.key, self.units[self.key]), ylabel=with_unit(name, self.units[name]))
        ax.legend(**BESIDE, markerscale=6)
        return ax

    def points(self, rows: Array) -> Array:
        """How many different points each value has, (k,): the period in strobes; -1 for more than MOST_CYCLE, or none."""
        return np.array(
            [_cycle(_on_circle(section, [self.units[name] for name in self.section.of])) for section in rows]
        )

    def report(self) -> Report:
        """Where the number of points changes, up and down."""
        rows = list[tuple[str, str, str]]()
        for way, values in (("up", self.up), ("down", self.down)):
            at, counts = (self.at, self.points(values)) if way == "up" else (self.at[::-1], self.points(values)[::-1])
            first = np.flatnonzero(np.diff(counts, prepend=counts[0] - 1))
            rows += [(way, f"{at[i]:.6g}", _described(int(counts[i]))) for i in first]
        data = {
            "key": self.key,
            "at": self.at.tolist(),
            "of": self.section.of,
            "up": self.up.tolist(),
            "down": self.down.tolist(),
        }
        parts = (Table(("way", f"from {self.key}", "motion"), rows), *self.why)
        return Report(
            parts, data, "no motion can be run" if np.isnan(self.up).all() and np.isnan(self.down).all() else None
        )


def bifurcation(scene: Scene | str | Path, key: str, values: ArrayLike, section: Section) -> Bifurcation:
    """A section at each value of a number of the scene, each motion begun where the last one ended: up, then down.

    Raises InputError for a key, values or a section that cannot be. A motion that cannot be run is NaN; the next begins
    at the scene's own start.
    """
    scene = chosen_scene(scene)
    if not isinstance(section, Section):
        raise InputError(f"section: {shown(section)} is not a pp.sections.strobe(...) or crossing(...)")
    at = numbers("values", values)
    if at.ndim != 1 or not len(at) or (np.diff(at) <= 0).any():
        raise InputError("values: give the values of the number in rising order, at least one")
    scenes = [scene.replace({key: float(value)}) for value in at]
    units = section.check(scenes[0]) | {key: unit_of_key(key, scene)}
    room, why, start = np.full((2, len(at), section.count, len(section.of)), np.nan), dict[str, None](), scene.start
    for rows, order in zip(room, (range(len(at)), range(len(at))[::-1]), strict=True):
        for place in order:
            try:
                rows[place], start = section.collect(scenes[place].model_copy(update={"start": start}))
            except RunError as error:
                why[f"{key} = {at[place]:g}: {error}"] = None
                start = scene.start
    return Bifurcation(key, at, section, room[0], room[1], tuple(why), units)


def _cycle(points: Array) -> int:
    """After how many of the points (count, m) they repeat; 0 where there are none, -1 if they do not up to MOST_CYCLE."""
    if np.isnan(points).any():
        return 0
    for length in range(1, min(MOST_CYCLE, len(points) // 2) + 1):
        if np.abs(points[length:] - points[:-length]).max() <= SAME * max(1.0, float(np.abs(points).max())):
            return length
    return -1


def _on_circle(points: Array, units: Sequence[str]) -> Array:
    """Points (count, m) with sine and cosine in place of each angle: whole turns count as nothing."""
    columns = [(np.sin(x), np.cos(x)) if unit == "rad" else (x,) for x, unit in zip(points.T, units, strict=True)]
    return np.stack([part for parts in columns for part in parts], 1)


def _described(count: int) -> str:
    if count <= 0:
        return (
            "no motion" if count == 0 else f"no cycle of up to {MOST_CYCLE} points, or not settled: a larger skip tells"
        )
    return "the same point in every period" if count == 1 else f"a cycle of {count} points"
