"""A series: the runs of one method, from coarse to fine, until one is accurate enough."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from pendpin.errors import brief
from pendpin.ground.arrays import EPS, Array
from pendpin.runs.simulate import Budget


@dataclass(frozen=True)
class Point:
    """One run: its setting, its error, its cost."""

    setting: float  # the tolerance, or the step in s
    error: float  # largest tip distance to the reference during the run, divided by the chain's length
    seconds: float  # of integration with its sampling: the least of some repetitions, warm-up and compiling apart
    steps: int
    evaluations: int
    compile_seconds: float = 0.0  # before the first run

    @property
    def first_seconds(self) -> float:
        """Of the first run, compiling included, s."""
        return self.seconds + self.compile_seconds


@dataclass(frozen=True, repr=False)
class Curve:
    """One method, or one method of another simulator, from coarse to fine."""

    name: str
    library: str
    kind: str  # of its settings: "tolerance" or "step"
    points: tuple[Point, ...]
    failures: tuple[str, ...] = ()  # why runs did not reach the end
    peer: bool = False

    def __repr__(self) -> str:
        errors = ", ".join(f"{point.error:.1e} at {point.setting:.0e}" for point in self.points)
        return brief(f"Curve of {self.name}, error at each {self.kind}: {errors or 'none'}")

    @property
    def compile_seconds(self) -> float:
        """The longest time of compiling, s."""
        return max((point.compile_seconds for point in self.points), default=0.0)

    def point_at(self, error: float) -> Point | None:
        """The cheapest point that meets this error."""
        return next((point for point in self.front if point.error <= error), None)

    def seconds_at(self, error: float) -> float | None:
        """The least time in which this error is met, interpolated in logarithms between its points; None if it is not."""
        found = self.setting_and_seconds_at(error)
        return found and found[1]

    def setting_and_seconds_at(self, error: float) -> tuple[float, float] | None:
        """The setting that meets this error in the least time, and that time, interpolated between its points."""
        front = self.front
        for cheaper, point in zip((None, *front), front, strict=False):
            if point.error <= error:
                if cheaper is None:
                    return point.setting, point.seconds
                share = np.log(cheaper.error / error) / np.log(cheaper.error / max(point.error, EPS))
                between = ((cheaper.setting, point.setting), (cheaper.seconds, point.seconds))
                setting, seconds = (float(a * (b / a) ** share) for a, b in between)
                return setting, seconds
        return None

    @property
    def front(self) -> tuple[Point, ...]:
        """Its points that no other beats in both error and time, the cheapest first."""
        points: list[Point] = []
        for point in sorted(self.points, key=lambda point: (point.seconds, point.error)):
            if not points or point.error < points[-1].error:
                points.append(point)
        return tuple(points)


# --- a series -------------------------------------------------------------------------------------------------------

MOST_STEPS = 20  # of a series of steps
GROWTH = 2.0  # of the time from one setting to the next
PATIENCE = 5.0  # times the time that a run is worth: one that takes longer is stopped


@dataclass(frozen=True)
class Trial:
    """One run: its tips, or why there are none."""

    tips: Array | None  # (n, rods, 3) m, W
    seconds: float
    steps: int = 0
    evaluations: int = 0
    compile_seconds: float = 0.0
    library: str = ""
    failure: str | None = None
    hopeless: bool = False  # whether other settings fail as well


@dataclass(eq=False)
class Series:
    """One method, or one of another simulator, with the runs made so far."""

    name: str
    library: str
    kind: str  # of its settings: "tolerance" or "step"
    settings: Iterator[float]  # from coarse to fine
    run: Callable[[float, float], Trial]  # with a setting and the s after which it is stopped
    peer: bool = False
    points: list[Point] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    ended: bool = False

    @property
    def curve(self) -> Curve:
        """What was measured."""
        return Curve(self.name, self.library, self.kind, tuple(self.points), tuple(self.failures), self.peer)

    @property
    def expected(self) -> float:
        """The s that the next run takes, about; 0 before the first."""
        return GROWTH * self.points[-1].seconds if self.points else 0.0

    def first_at(self, error: float) -> float | None:
        """The least s of a first run that meets an error, compiling included."""
        return min((point.first_seconds for point in self.points if point.error <= error), default=None)


@dataclass(frozen=True)
class Climb:
    """How series climb: what is measured at each setting, and which settings are worth it."""

    error_of: Callable[[Array], float]  # of tips (n, rods, 3), over the length
    repetitions: int
    budget: float  # s: a method whose run takes longer has ended
    every: bool  # whether every setting is measured, or tolerances only from the error that is wanted on
    progress: Callable[[str], None]

    def up_to(self, series: Series, error: float, worth: float, limit: Budget) -> None:
        """Run finer and finer settings until one meets an error, the next takes more than `worth` s, or no time is left."""
        while not series.ended and series.first_at(error) is None and series.expected <= worth and limit.left > 0:
            setting = self._next(series, error)
            if setting is None:
                series.ended = True
                return
            self.progress(f"{series.name}, {setting:.1e}")
            trial = series.run(setting, min(PATIENCE * worth, limit.left))
            series.library = trial.library or series.library
            series.ended = trial.hopeless or trial.seconds > self.budget
            if trial.tips is None:
                series.failures.append(trial.failure or "")
                if trial.seconds > worth:
                    return
            else:
                series.points.append(self._point(series, setting, trial, worth))

    def _next(self, series: Series, error: float) -> float | None:
        skipped = None
        for setting in series.settings:
            if self.every or series.kind == "step" or setting <= error * (1 + 1e-9):
                return setting
            skipped = setting
        return skipped

    def _point(self, series: Series, setting: float, trial: Trial, worth: float) -> Point:
        """A point with the least time of some repetitions, as many as are worth it; that of the first run if none."""
        spent, times = trial.seconds, []
        while len(times) < self.repetitions and spent < worth:
            times.append(series.run(setting, PATIENCE * worth).seconds)
            spent += times[-1]
        assert trial.tips is not None
        counts = (trial.steps, trial.evaluations, trial.compile_seconds)
        return Point(setting, self.error_of(trial.tips), min(times, default=trial.seconds), *counts)


def tolerances(least: float, stride: int = 1) -> Iterator[float]:
    """Decades, or every so many, from 0.01 to the least."""
    yield from (10.0**-k for k in range(2, 19, stride) if 10.0**-k >= least * (1 - 1e-9))


def steps(first: float) -> Iterator[float]:
    """Steps in s, each half the one before."""
    yield from (first / 2**k for k in range(MOST_STEPS))
