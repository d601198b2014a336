"""Diagrams of sections: portraits, of many motions of one energy, and bifurcation diagrams, over a number of the scene."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.dynamics.dynamics import Dynamics, bind
from pendpin.engines import Moving
from pendpin.errors import InputError, RunError, attempt, shown
from pendpin.graphics.style import BESIDE, COLORS, new_figure, styled, with_unit
from pendpin.ground.arguments import axes, number, numbers, parsed, whole_number
from pendpin.ground.arrays import Array, ArrayLike
from pendpin.ground.report import Report, Result, Table
from pendpin.model.bodies import mass_matrix
from pendpin.model.build import build, start_state
from pendpin.motions.periodic import wrap
from pendpin.runs.batches import Series, takes
from pendpin.scene import Scene, Start, chosen_scene, unit_of_key
from pendpin.stability.sections.points import PATIENCE, Crossing, Section

TRIES = 20_000  # random angles for one start: as many are looked at until the energy is too small for all of them
MOST_STARTS = 100_000
MOST_CYCLE = 16  # points of a cycle that is distinguished from chaos
SAME = 1e-6  # of the range of a quantity, or rad: the distance of two points of a cycle that are one


@dataclass(frozen=True, eq=False, repr=False)
class Portrait(Result):
    """A Poincaré section of many motions of one energy."""

    section: Crossing
    energy: float  # J
    drawn: bool  # whether the starts were drawn at this energy; else there is one, the scene's own
    starts: tuple[Start, ...]
    values: Array  # (starts, count, len(of)); NaN where a motion has no such points
    why: tuple[str, ...]  # for each start why it has none, "" where it has
    units: dict[str, str]

    @styled()
    def plot(self, ax: Any = None) -> Any:
        """Draw the second quantity against the first, a colour for each motion, on a matplotlib Axes; returns it."""
        if len(self.section.of) != 2:
            raise InputError(f"of: a section is drawn of two quantities, not of {len(self.section.of)}")
        ax = axes("ax", ax) or new_figure(7.0, 5.5).subplots()
        shown = self._shown()
        size = float(np.clip(150 / np.sqrt(shown[..., 0].size + 1), 2.0, 6.0))
        for points in shown:
            ax.plot(*points.T, ".", ms=size, mew=0)
        x, y = (with_unit(name, self.units[name]) for name in self.section.of)
        ax.set(xlabel=x, ylabel=y)
        how = {1: ", rising", -1: ", falling", 0: ""}[self.section.direction]
        ax.set_title(f"{self.section.name} = {self.section.level:g}{how}; {self.energy:.6g} J")
        return ax

    def report(self) -> Report:
        """How the starts were drawn, how many motions have their points, and the range of each quantity."""
        good = [not reason for reason in self.why]
        head = ("quantity", "least", "largest", "unit")
        columns = zip(self.section.of, np.moveaxis(self._shown(), -1, 0), strict=True) if any(good) else ()
        rows = [(name, f"{np.nanmin(x):.6g}", f"{np.nanmax(x):.6g}", self.units[name]) for name, x in columns]
        how = (
            f"{len(self.starts)} starts at {self.energy:.6g} J on the section: angles are drawn evenly where their "
            "potential energy is below it; the rest is kinetic, in directions drawn evenly by the mass matrix."
        )
        parts, points = [how] if self.drawn else [], f"{self.section.count} points each"
        parts.append(f"{sum(good)} of {len(good)} motions have {points}; angles from -pi to pi.")
        parts += [f"{self.why.count(one)} have none: {one}" for one in dict.fromkeys(self.why) if one]
        data = {"energy": self.energy, "of": self.section.of, "values": self.values.tolist(), "why": list(self.why)}
        table = [Table(head, rows)] if rows else []
        return Report((*parts, *table), data, None if any(good) else f"no motion has all its points: {self.why[0]}")

    def _shown(self) -> Array:
        """The values (starts, count, len(of)) with angles from -pi to pi."""
        return np.where([self.units[name] == "rad" for name in self.section.of], wrap(self.values), self.values)


def portrait(
    scene: Scene | str | Path, section: Crossing, starts: int = 1, energy: float | None = None, seed: int = 0
) -> Portrait:
    """A Poincaré section of the motion of a scene, or of many motions of one energy.

    Args:
        scene: a Scene, or the path of a TOML file.
        section: from `crossing`.
        starts: how many motions; more than one need an energy.
        energy: in J, kinetic and potential, 0 at W's origin as in run.energy(). Angles of the starts are drawn evenly,
            with the section's own at its level, until their potential energy is below it. The rest is kinetic, in
            directions drawn evenly by the mass matrix. Joints that stay at 0 in the scene's own motion stay there.
            Without an energy the motion is that from the scene's own start.
        seed: of the starts.

    Raises:
        InputError: for a section or numbers that cannot be, and where no such start is found.
    """
    scene = chosen_scene(scene)
    if not isinstance(section, Crossing):
        raise InputError(f"section: {shown(section)} is not a pp.sections.crossing(...)")
    starts = whole_number("starts", starts, most=MOST_STARTS)
    energy = energy if energy is None else number("energy", energy, "a finite number of joules")
    seed = whole_number("seed", seed, least=0)
    if energy is None and starts > 1:
        raise InputError(f"energy: {starts} starts are drawn at one energy; give it in J")
    units, dynamics = section.find_units(scene), bind(scene)
    q, v = start_state(dynamics.model, scene.start)
    if energy is None:
        drawn, total = [scene.start], sum(dynamics.energy(q, v))
    else:
        total = energy
        drawn = _draw_starts(dynamics, (q, v), section, starts, total, np.random.default_rng(seed))
    values, why = _points_side_by_side(scene, section, drawn), [""] * starts
    for place in np.flatnonzero(np.isnan(values).any((1, 2))):
        moved = scene.model_copy(update={"start": drawn[place]})
        points, error = attempt(partial(section.collect, moved), RunError)
        if points is None:
            why[place] = str(error)
        else:
            values[place], _ = points
    return Portrait(section, total, energy is not None, tuple(drawn), values, tuple(why), units)


def _points_side_by_side(scene: Scene, section: Crossing, starts: Sequence[Start]) -> Array:
    """The values (starts, count, len(of)) of motions that Taylor series take side by side; NaN for the others."""
    values = np.full((len(starts), section.count, len(section.of)), np.nan)
    model, tolerance = build(scene.model), scene.solver.tolerance
    names = [*model.joints, *(f"{joint}_rate" for joint in model.joints)]
    turns = [joint for joint, slides in zip(model.joints, model.slides, strict=True) if not slides]
    if tolerance is None or not takes(scene) or section.name not in turns or not {*section.of} <= {*names}:
        return values
    q, v = (np.array(x) for x in zip(*(start_state(model, start) for start in starts), strict=True))
    level = model.joints.index(section.name), section.level, section.direction
    series = Series(scene, tolerance, np.stack([q, v], 1), level=level)
    if series.covered:
        columns = [1 + names.index(name) for name in section.of]
        points = series.cross(series.started(q, v), section.skip + section.count, PATIENCE * scene.duration)
        for place, rows in enumerate(points):
            if len(rows) == section.skip + section.count:
                values[place] = rows[section.skip :, columns]
    return values


def _draw_starts(
    dynamics: Dynamics, own: tuple[Array, Array], section: Crossing, count: int, energy: float, rng: np.random.Generator
) -> list[Start]:
    """Starts of one energy in J on a section; `own` is q, v (nv,) of the scene's own start."""
    model, (q0, v0) = dynamics.model, own
    if section.name not in model.joints:
        raise InputError(f"at: {section.name} is not the angle of a joint; starts of one energy are drawn on one")
    if not dynamics.conservative:
        raise InputError("energy: effects of this scene have no potential energy; give starts of your own in a sweep")
    if model.pin is None:
        many = f"{len(model.joints)} joints are too many for starts of one energy"
        raise InputError(f"energy: {many}; give a single start")
    # the joints that do not stay at 0 in the scene's own motion
    on_angles = Dynamics(dynamics.model, dynamics.effects, form="angles", start=dynamics.start)
    engine, nv = on_angles.in_motion(q0, v0, False).engine, len(q0)
    moving = np.unique((engine.places if isinstance(engine, Moving) else np.arange(nv)) % nv)
    at = model.joints.index(section.name)
    if at not in moving:
        raise InputError(f"at: {section.name} stays at 0 in this scene; give it a start or a rate")
    turning = np.array([i for i in moving if i != at and not model.slides[i]], int)
    q = np.tile(q0, (TRIES, 1))
    q[:, at] = section.level
    starts, least = list[Start](), np.inf
    while len(starts) < count:
        q[:, turning] = rng.uniform(-np.pi, np.pi, (TRIES, len(turning)))
        _, potential = dynamics.energies(q, np.zeros_like(q))
        least = min(least, float(potential.min()))
        good = np.flatnonzero(potential < energy)[: count - len(starts)]
        if not len(good):
            raise InputError(f"energy: {energy:g} J is too little: on the section at least {least:.6g} J are potential")
        for place in good:
            v, L = np.zeros(len(q0)), np.linalg.cholesky(mass_matrix(model.pin, q[place])[np.ix_(moving, moving)])
            way = rng.normal(size=len(moving))
            speed = np.sqrt(2 * (energy - potential[place]) / (way @ way))
            v[moving] = speed * np.linalg.solve(L.T, way)
            v *= -1.0 if v[at] * section.direction < 0 else 1.0
            starts.append(Start.at_state(dynamics.start, q[place], v))
    return starts


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
        name, size = self.section.of[0], float(np.clip(300 / len(self.at), 1.5, 5.0))
        for rows, colour, label in ((self.down, COLORS[1], "down"), (self.up, COLORS[0], "up")):
            y = wrap(rows[..., 0]) if self.units[name] == "rad" else rows[..., 0]
            ax.plot(np.repeat(self.at, y.shape[1]), y.ravel(), ".", ms=size, mew=0, color=colour, label=label)
        ax.set(xlabel=with_unit(self.key, self.units[self.key]), ylabel=with_unit(name, self.units[name]))
        ax.legend(**BESIDE, markerscale=9 / size)
        return ax

    def points(self, rows: Array) -> Array:
        """How many different points each value has, (k,): the period in strobes; -1 for more than MOST_CYCLE, 0 for none."""
        turns = [self.units[name] == "rad" for name in self.section.of]
        # sine and cosine in place of each angle: whole turns count as nothing
        states = np.concatenate([np.where(turns, np.cos(rows), rows), np.where(turns, np.sin(rows), 0.0)], -1)
        size, counts = np.maximum(1.0, np.abs(states).max((1, 2))), np.full(len(rows), -1)
        for length in range(min(MOST_CYCLE, rows.shape[1] // 2), 0, -1):
            counts[np.abs(states[:, length:] - states[:, :-length]).max((1, 2)) <= SAME * size] = length
        return np.where(np.isnan(rows).any((1, 2)), 0, counts)

    def report(self) -> Report:
        """Where the number of points changes, up and down."""
        rows = list[tuple[str, str, str]]()
        words = {-1: "no cycle found", 0: "no motion", 1: "the same point in every period"}
        for way, values, order in (("up", self.up, 1), ("down", self.down, -1)):
            at, counts = self.at[::order], self.points(values)[::order].tolist()
            for i, count in enumerate(counts):
                if i == 0 or count != counts[i - 1]:
                    rows.append((way, f"{at[i]:.6g}", words.get(count, f"a cycle of {count} points")))
        data = {"key": self.key, "at": self.at.tolist(), "of": self.section.of}
        data |= {"up": self.up.tolist(), "down": self.down.tolist()}
        fault = "no motion can be run" if np.isnan(self.up).all() and np.isnan(self.down).all() else None
        why = list(self.why)
        if any(words[-1] in row for row in rows):
            why.append(f"No cycle found: chaos, over {MOST_CYCLE} points, or not settled. A larger skip tells which.")
        return Report((Table(("way", f"from {self.key}", "motion"), rows), *why), data, fault)


def bifurcation(scene: Scene | str | Path, key: str, values: ArrayLike, section: Section) -> Bifurcation:
    """A section at each value of a number of the scene, each motion begun where the last one ended: up, then down.

    Raises InputError for a key, values or a section that cannot be. A motion that cannot be run is NaN; the next begins
    at the scene's own start.
    """
    scene = chosen_scene(scene)
    if not isinstance(section, Section):
        raise InputError(f"section: {shown(section)} is not a pp.sections.strobe(...) or crossing(...)")
    parsed(key)  # a key that is none is refused
    at = numbers("values", values)
    if at.ndim != 1 or not len(at) or (np.diff(at) <= 0).any():
        raise InputError("values: give the values of the number in rising order, at least one")
    scenes = [scene.replace({key: float(value)}) for value in at]
    units = section.find_units(scenes[0]) | {key: unit_of_key(key, scene)}
    room, why, start = np.full((2, len(at), section.count, len(section.of)), np.nan), dict[str, None](), scene.start
    for rows, order in zip(room, (range(len(at)), range(len(at))[::-1]), strict=True):
        for place in order:
            moved = scenes[place].model_copy(update={"start": start})
            points, error = attempt(partial(section.collect, moved), RunError)
            if points is None:
                why[f"{key} = {at[place]:g}: {error}"], start = None, scene.start
            else:
                rows[place], start = points
    return Bifurcation(key, at, section, room[0], room[1], tuple(why), units)
