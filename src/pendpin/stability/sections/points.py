"""The points of a section: where a quantity crosses a level, or once a period, in as many pieces as it takes."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np

from pendpin.errors import InputError, RunError, shown
from pendpin.ground.arguments import seconds, whole_number
from pendpin.ground.arrays import Array
from pendpin.ground.files import number_in
from pendpin.motions.periodic import period_of
from pendpin.motions.search import check_crossing, crossings
from pendpin.motions.trajectory import Trajectory
from pendpin.runs.simulate import run_to_setting, varied
from pendpin.scene import Scene, Start, chosen_scene, scene_of
from pendpin.trajectory import RunRecord, samples_of
from pendpin.trajectory.columns import unit_of

PATIENCE = 30  # durations of the scene without a crossing, until there is none
LONGEST = 16  # durations of the scene in one piece of a motion
STILL = 1e-9  # rad or m: a motion whose joints move less in a whole piece is at rest
MOST_POINTS = 10_000_000

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
            object.__setattr__(self, name, whole_number(name, getattr(self, name), least, MOST_POINTS))

    @property
    def dims(self) -> dict[str, int]:
        """The dimensions of its values, for a sweep."""
        return {self.point: self.count, "quantity": len(self.of)}

    def __call__(self, motion: Motion) -> Array:
        """The values (count, len(of)) at the points of a scene's motion, or of a run, continued. InputError, RunError."""
        scene = scene_of(motion) if isinstance(motion, RunRecord) else chosen_scene(motion)
        self.find_units(scene)
        return self.collect(scene)[0]

    @abstractmethod
    def collect(self, scene: Scene) -> tuple[Array, Start]:
        """The values (count, len(of)) in the motion of a scene that was checked, and the state with which they end."""

    @property
    def names(self) -> tuple[str, ...]:
        """The quantities that it needs of a run."""
        return self.of

    def find_units(self, scene: Scene) -> dict[str, str]:
        """The units of the quantities. Raises InputError where the scene has no section, and for unknown names."""
        if not scene.duration:
            raise InputError("duration: a motion of 0 s has no section; give the scene a duration in s")
        at_start = Trajectory.of(run_to_setting(scene.sampled(None, duration=0.0)))
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
        check_crossing(self.level, self.direction)

    @property
    def names(self) -> tuple[str, ...]:
        """The quantity that crosses, and those that are noted."""
        return (self.name, *self.of)

    def collect(self, scene: Scene) -> tuple[Array, Start]:
        """The values (count, len(of)) at the crossings, and the state at the end of the motion."""
        rows, points, since, wanted, longer = list[Array](), 0, 0.0, self.skip + self.count, scene.duration
        while True:
            intervals = (len(scene.times) - 1) * longer / scene.duration  # samples as dense as the scene's
            run = run_to_setting(scene.sampled(int(max(2, 1 + round(intervals))), duration=longer))
            angle = self.name in run.joints and self.name not in (Trajectory.of(run).slides or ())
            here = crossings(run, self.name, self.level, self.direction, angle)
            rows.append(self.values(here))
            points += len(here.t)
            end = Start.at_state(float(run.t[-1]), run.q[-1], run.v[-1])
            if points >= wanted:
                return np.concatenate(rows)[self.skip : wanted], end
            since = 0.0 if len(here.t) else since + float(run.t[-1] - run.t[0])
            if since > PATIENCE * scene.duration:
                how = {1: "rises through", -1: "falls through", 0: "crosses"}[self.direction]
                rests = "; the motion has come to rest" if np.ptp(run.q, 0).max() < STILL else ""
                found = f"{points} of {wanted} points, none in the last {since:.4g} s{rests}"
                raise RunError(f"{self.name} {how} {self.level:g}: {found}")
            scene = scene.model_copy(update={"start": end})
            longer = min(2 * longer, LONGEST * scene.duration)


@dataclass(frozen=True)
class Strobe(Section):
    """A stroboscopic section: once a period from the scene's start on, but for the start itself."""

    point = "strobe"
    period: float | None = field(default=None, kw_only=True)  # s; that of the drive if None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.period is not None:
            seconds("period", self.period, lasting=True)

    def collect(self, scene: Scene) -> tuple[Array, Start]:
        """The values (count, len(of)) once a period, and the state at the last."""
        period = self.period or period_of(scene)
        if period is None:
            raise InputError("strobe: nothing drives this scene; give a period in s")
        times = scene.start.time + period * np.arange(self.skip + 1, self.skip + self.count + 1)
        run = run_to_setting(varied(scene, None, None, times, {}))
        end = Start.at_state(float(run.t[-1]), run.q[-1], run.v[-1])
        return self.values(samples_of(run, slice(-self.count, None))), end


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
    if not np.isfinite(value := number_in("at", level)):
        raise InputError(f"at: {shown(level.strip())} is not a finite number")
    return crossing(name.strip(), value, ways[way.strip()] if comma else 1, of=of, count=count, skip=skip)


def strobe(period: float | None = None, *, of: Sequence[str] | str, count: int = 200, skip: int = 200) -> Strobe:
    """A stroboscopic section: like `crossing`, once a period in s; that of the drive if absent."""
    return Strobe(of, count, skip, period=period)  # type: ignore[arg-type]
