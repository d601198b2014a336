"""Sections of a motion: its states where a quantity crosses a level (Poincaré) or once a period (stroboscopic).

A section is a function of a scene, or of a run: it continues the motion until it has all its points. Collected over
many starts of one energy it is a portrait; over a number of the scene, with the state carried on, a bifurcation diagram.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from pendpin.dynamics.dynamics import Dynamics, bind
from pendpin.engines import Moving
from pendpin.errors import InputError, RunError, is_number, shown
from pendpin.graphics.style import BESIDE, COLORS, new_figure, styled, with_unit
from pendpin.ground.arguments import axes, numbers
from pendpin.ground.arrays import Array, ArrayLike
from pendpin.ground.report import Report, Result, Table
from pendpin.model.build import build, start_state
from pendpin.motions.periodic import drive_of
from pendpin.motions.resolved import resolved
from pendpin.motions.search import find_instants, sign_changes
from pendpin.motions.trajectory import Trajectory
from pendpin.runs.batches.series import Level, Series, takes
from pendpin.runs.simulate import run_to_setting, varied
from pendpin.scene import Scene, Start, chosen_scene, scene_of, unit_of_key
from pendpin.trajectory import RunRecord, samples_of
from pendpin.trajectory.columns import unit_of

__all__ = ["Bifurcation", "Crossing", "Portrait", "Strobe", "bifurcation", "crossing", "portrait", "strobe"]

PATIENCE = 30  # durations of the scene without a crossing, until there is none
LONGEST = 16  # durations of the scene in one piece of a motion
STILL = 1e-9  # rad or m: a motion whose joints move less in a whole piece is at rest
TRIES = 20_000  # random angles for one start: as many are looked at until the energy is too small for all of them
MOST_POINTS, MOST_STARTS = 10_000_000, 100_000

Motion = Scene | str | Path | RunRecord


@dataclass(frozen=True)
class Section(ABC):
    """What is noted, at which instants of a motion. Call it with a scene or a run for the values (count, len(of)).

    As a measure of a sweep it is the variable `section`, with the dimensions `point`, by its kind, and quantity.
    """

    point: ClassVar[str]
    variable: ClassVar[str] = "section"
    of: tuple[str, ...]  # names of quantities, in the order of the columns
    count: int  # points
    skip: int = 0  # points before the first that counts, in which a motion settles

    def __post_init__(self) -> None:
        names = (self.of,) if isinstance(self.of, str) else self.of
        if not isinstance(names, Sequence) or not names or not all(isinstance(name, str) for name in names):
            raise InputError(f"of: {shown(self.of)} are not names of quantities, such as ('theta_2', 'theta_2_rate')")
        object.__setattr__(self, "of", tuple(names))
        for name, least in (("count", 1), ("skip", 0)):
            value = getattr(self, name)
            if type(value) is not int or not least <= value <= MOST_POINTS:
                raise InputError(f"{name}: {shown(value)} is not a whole number from {least} to {MOST_POINTS:,}")

    @property
    def dims(self) -> dict[str, int]:
        """The dimensions of its values, for a sweep."""
        return {self.point: self.count, "quantity": len(self.of)}

    def __call__(self, motion: Motion) -> Array:
        """The values (count, len(of)) at the points, from those of a scene's motion or of a run that is continued.

        Raises InputError for names that are none, RunError where the motion has too few points.
        """
        scene = scene_of(motion) if isinstance(motion, RunRecord) else chosen_scene(motion)
        self.check(scene)
        return self.collect(scene)[0]

    @abstractmethod
    def collect(self, scene: Scene) -> tuple[Array, Start]:
        """The values (count, len(of)) in the motion of a scene that was checked, and the state with which they end."""

    @property
    def names(self) -> tuple[str, ...]:
        """The quantities that it needs of a run."""
        return self.of

    def check(self, scene: Scene) -> dict[str, str]:
        """The units of the quantities. Raises InputError where the scene has no section, and for unknown names."""
        if not scene.duration:
            raise InputError("duration: a motion of 0 s has no section; give the scene a duration in s")
        at_start = Trajectory.of(run_to_setting(_lasting(scene, 0.0)))
        return {name: unit_of(at_start, name) for name in self.names}

    def values(self, rows: RunRecord) -> Array:
        """The quantities (n, len(of)) of n samples."""
        return np.stack([np.asarray(rows[name], float) for name in self.of], 1)


@dataclass(frozen=True)
class Crossing(Section):
    """A Poincaré section: where a quantity crosses a level. That of an angle counts whole turns as nothing."""

    point = "crossing"
    name: str = field(kw_only=True)
    level: float = field(default=0.0, kw_only=True)
    direction: int = field(default=1, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.name, str):
            raise InputError(f"name: {shown(self.name)} is not the name of a quantity, such as 'theta_1'")
        if not is_number(self.level) or not np.isfinite(self.level):
            raise InputError(f"level: {shown(self.level)} is not a finite number")
        if not is_number(self.direction) or self.direction not in {-1, 0, 1}:
            raise InputError(f"direction: {shown(self.direction)} is not 1 (rising), -1 (falling) or 0 (both)")

    @property
    def names(self) -> tuple[str, ...]:
        """The quantity that crosses, and those that are noted."""
        return (self.name, *self.of)

    def collect(self, scene: Scene) -> tuple[Array, Start]:
        """The values (count, len(of)) at the crossings, and the state at the end of the motion."""
        rows, points, since, wanted = list[Array](), 0, 0.0, self.skip + self.count
        for run in _pieces(scene):
            here = self.crossings(run)
            rows.append(self.values(here))
            points += len(here.t)
            if points >= wanted:
                return np.concatenate(rows)[self.skip : wanted], _start_at(run)
            since = 0.0 if len(here.t) else since + float(run.t[-1] - run.t[0])
            if since > PATIENCE * scene.duration:
                how = {1: "rises through", -1: "falls through", 0: "crosses"}[self.direction]
                rests = "; the motion has come to rest" if np.ptp(run.q, 0).max() < STILL else ""
                raise RunError(
                    f"{self.name} {how} {self.level:g}: {points} of {wanted} points, none in the last {since:.4g} s{rests}"
                )
        raise AssertionError  # the pieces have no end

    def crossings(self, run: RunRecord) -> RunRecord:
        """The run at the instants of its crossings, to its own accuracy. Raises InputError."""
        angle = self.name in run.joints and self.name not in (Trajectory.of(run).slides or ())

        def offset(rows: RunRecord) -> Array:
            off = rows[self.name] - self.level
            return np.sin(off) if angle else off  # 0 half a turn away too: these are left out below

        more = resolved(run)
        changes = sign_changes(more, offset, 1.0 if angle else abs(self.level))
        instants, places = np.unique(find_instants(more, offset, changes), return_index=True)
        chosen = np.isin(np.sign(changes.after[places]), [self.direction] if self.direction else [-1, 1])
        if not chosen.any():
            return samples_of(run, slice(0, 0))
        rows = more.at(instants[chosen])
        return samples_of(rows, np.cos(rows[self.name] - self.level) > 0) if angle else rows


@dataclass(frozen=True)
class Strobe(Section):
    """A stroboscopic section: once a period from the scene's start on, but for the start itself."""

    point = "strobe"
    period: float | None = field(default=None, kw_only=True)  # s; that of the drive if None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.period is not None and not (is_number(self.period) and 0 < self.period < np.inf):
            raise InputError(f"period: {shown(self.period)} is not a number of seconds above 0")

    def collect(self, scene: Scene) -> tuple[Array, Start]:
        """The values (count, len(of)) once a period, and the state at the last."""
        period = self.period
        if period is None:
            if not (frequency := drive_of(scene)):
                raise InputError("strobe: nothing drives this scene; give a period in s")
            period = 2 * np.pi / frequency
        times = scene.start.time + period * np.arange(self.skip + 1, self.skip + self.count + 1)
        run = run_to_setting(varied(scene, None, None, times, {}))
        return self.values(samples_of(run, slice(-self.count, None))), _start_at(run)


def crossing(
    name: str, level: float = 0.0, direction: int = 1, *, of: Sequence[str] | str, count: int = 300, skip: int = 0
) -> Crossing:
    """A Poincaré section, a function of a scene or a run, and a measure of a sweep.

    Args:
        name: the quantity that crosses, such as "theta_1". An angle crosses its level in every turn.
        level: in its unit.
        direction: 1 where it rises, -1 where it falls, 0 for both.
        of: names of the quantities that are noted.
        count: how many points; the motion continues until it has them.
        skip: points before them, in which the motion settles.

    Returns:
        The Crossing; called with a scene it gives the values (count, len(of)). Angles are not wrapped.

    Raises:
        InputError: for a level, direction or count that cannot be; when it is called, for unknown names.
        RunError: when it is called, where the motion does not cross so often.
    """
    return Crossing(of, count, skip, name=name, level=level, direction=direction)  # type: ignore[arg-type]


def read_crossing(text: str, of: Sequence[str], count: int, skip: int) -> Crossing:
    """The section of a text like "theta_1 = 0, rising"; "falling" and "both" are the other ways. Raises InputError."""
    name, equals, rest = text.partition("=")
    level, comma, way = rest.partition(",")
    ways = {"rising": 1, "falling": -1, "both": 0}
    if not equals or (comma and way.strip() not in ways):
        raise InputError(f"at: {shown(text)} is not NAME = LEVEL, rising; the other ways are falling and both")
    try:
        value = float(level)
    except ValueError:
        raise InputError(f"at: {shown(level.strip())} is not a number") from None
    return crossing(name.strip(), value, ways[way.strip()] if comma else 1, of=of, count=count, skip=skip)


def strobe(period: float | None = None, *, of: Sequence[str] | str, count: int = 200, skip: int = 200) -> Strobe:
    """A stroboscopic section: like `crossing`, once a period in s; that of the drive if absent."""
    return Strobe(of, count, skip, period=period)  # type: ignore[arg-type]


def _pieces(scene: Scene) -> Iterator[RunRecord]:
    """The motion of a scene, piece after piece, each longer than the one before."""
    longer = scene.duration
    while True:
        run = run_to_setting(_lasting(scene, longer))
        yield run
        scene = scene.model_copy(update={"start": _start_at(run)})
        longer = min(2 * longer, LONGEST * scene.duration)


def _lasting(scene: Scene, duration: float) -> Scene:
    """The scene with another duration in s, and samples as dense as they are."""
    intervals = (len(scene.times) - 1) * duration / scene.duration
    solver = scene.solver.model_copy(update={"samples": int(max(2, 1 + round(intervals))), "times": None})
    return scene.model_copy(update={"duration": duration, "solver": solver})


def _start_at(run: RunRecord) -> Start:
    """The last state of a run as a start."""
    return Start(time=float(run.t[-1]), positions=tuple(run.q[-1].tolist()), velocities=tuple(run.v[-1].tolist()))


# --- many starts of one energy ----------------------------------------------------------------------------------------


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
        for points in self._shown():
            ax.plot(*points.T, ".", ms=2.0, mew=0)
        x, y = (with_unit(name, self.units[name]) for name in self.section.of)
        ax.set(xlabel=x, ylabel=y)
        how = {1: ", rising", -1: ", falling", 0: ""}[self.section.direction]
        ax.set_title(f"{self.section.name} = {self.section.level:g}{how}; {self.energy:.6g} J")
        return ax

    def report(self) -> Report:
        """How the starts were drawn, how many motions have their points, and the range of each quantity."""
        good = [not reason for reason in self.why]
        head = ("quantity", "least", "largest", "unit")
        rows = [
            (name, f"{np.nanmin(column):.6g}", f"{np.nanmax(column):.6g}", self.units[name])
            for name, column in zip(self.section.of, np.moveaxis(self._shown(), -1, 0), strict=True)
            if any(good)
        ]
        how = (
            f"{len(self.starts)} starts at {self.energy:.6g} J on the section: angles are drawn evenly where their "
            "potential energy is below it; the rest is kinetic, in directions drawn evenly by the mass matrix."
        )
        parts = [how] if self.drawn else []
        parts.append(
            f"{sum(good)} of {len(good)} motions have {self.section.count} points each; angles from -pi to pi."
        )
        parts += [
            f"{sum(reason == one for reason in self.why)} have none: {one}" for one in dict.fromkeys(self.why) if one
        ]
        data = {"energy": self.energy, "of": self.section.of, "values": self.values.tolist(), "why": list(self.why)}
        table = [Table(head, rows)] if rows else []
        return Report((*parts, *table), data, None if any(good) else "no motion has all its points")

    def _shown(self) -> Array:
        """The values (starts, count, len(of)) with angles from -pi to pi."""
        angles = [self.units[name] == "rad" for name in self.section.of]
        return np.where(angles, _wrapped(self.values), self.values)


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
    if type(starts) is not int or not 1 <= starts <= MOST_STARTS:
        raise InputError(f"starts: {shown(starts)} is not a whole number from 1 to {MOST_STARTS:,}")
    if energy is not None and not (is_number(energy) and np.isfinite(energy)):
        raise InputError(f"energy: {shown(energy)} is not a finite number of joules")
    if type(seed) is not int or seed < 0:
        raise InputError(f"seed: {shown(seed)} is not a whole number from 0 on")
    if energy is None and starts > 1:
        raise InputError(f"energy: {starts} starts are drawn at one energy; give it in J")
    units, dynamics = section.check(scene), bind(scene)
    q, v = start_state(dynamics.model, scene.start)
    if energy is None:
        drawn, total = [scene.start], sum(dynamics.energy(q, v))
    else:
        total = float(energy)
        drawn = _draw_starts(dynamics, (q, v), section, starts, total, np.random.default_rng(seed))
    values, why = _points_side_by_side(scene, section, drawn), [""] * starts
    for place in np.flatnonzero(np.isnan(values).any((1, 2))):
        try:
            values[place], _ = section.collect(scene.model_copy(update={"start": drawn[place]}))
        except RunError as error:
            why[place] = str(error)
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
    level = Level(model.joints.index(section.name), section.level, section.direction)
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
    moving = _moving_joints(dynamics, q0, v0)
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
            v, L = np.zeros(len(q0)), np.linalg.cholesky(_mass_matrix(dynamics, q[place], moving))
            way = rng.normal(size=len(moving))
            speed = np.sqrt(2 * (energy - potential[place]) / (way @ way))
            v[moving] = speed * np.linalg.solve(L.T, way)
            v *= -1.0 if v[at] * section.direction < 0 else 1.0
            starts.append(Start(time=dynamics.start, positions=tuple(q[place].tolist()), velocities=tuple(v.tolist())))
    return starts


def _moving_joints(dynamics: Dynamics, q: Array, v: Array) -> Array:
    """The places of the joints that do not stay at 0 in a motion from q, v (nv,)."""
    on_angles = Dynamics(dynamics.model, dynamics.effects, form="angles", start=dynamics.start)
    engine, nv = on_angles.in_motion(q, v, False).engine, len(q)
    places = engine.places if isinstance(engine, Moving) else np.arange(2 * nv)
    return np.unique(places % nv)


def _mass_matrix(dynamics: Dynamics, q: Array, moving: Array) -> Array:
    """The mass matrix (k, k) of k joints at q (nv,), from kinetic energies: twice T is a quadratic form of the rates."""
    k = len(moving)
    rates = np.zeros((k, k, len(q)))
    for i in range(k):
        rates[i, :, moving[i]] += 1.0
        rates[:, i, moving[i]] += 1.0
    kinetic, _ = dynamics.energies(np.tile(q, (k * k, 1)), rates.reshape(k * k, -1))
    pairs = kinetic.reshape(k, k)  # T(e_i + e_j); T(2 e_i) on the diagonal
    own = np.diag(pairs) / 4  # T(e_i)
    return pairs - own[:, None] - own[None]


# --- a diagram over a number of the scene -----------------------------------------------------------------------------


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
            y = _wrapped(rows[..., 0]) if self.units[name] == "rad" else rows[..., 0]
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


MOST_CYCLE, SAME = (
    16,
    1e-6,
)  # points of a cycle that is told from chaos; their distance over the range of a quantity, or rad


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


def _wrapped(angle: Array) -> Array:
    """Angles in rad from -pi to pi."""
    return (angle + np.pi) % (2 * np.pi) - np.pi
