"""Error against time as data: the runs of a method as points of a curve."""

from dataclasses import dataclass

import numpy as np

from pendpin.errors import brief
from pendpin.ground.arrays import EPS


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
        front = self.front
        for cheaper, point in zip((None, *front), front, strict=False):
            if point.error <= error:
                if cheaper is None:
                    return point.seconds
                share = np.log(cheaper.error / error) / np.log(cheaper.error / max(point.error, EPS))
                return float(cheaper.seconds * (point.seconds / cheaper.seconds) ** share)
        return None

    @property
    def front(self) -> tuple[Point, ...]:
        """Its points that no other beats in both error and time, the cheapest first."""
        points: list[Point] = []
        for point in sorted(self.points, key=lambda point: (point.seconds, point.error)):
            if not points or point.error < points[-1].error:
                points.append(point)
        return tuple(points)
