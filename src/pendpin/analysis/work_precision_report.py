"""Error against time as data: points, curves, and sentences about them."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pendpin.records import MOST_REPR

TINY = float(np.finfo(float).eps)


@dataclass(frozen=True)
class Point:
    """One run: its setting, its error, its cost."""

    setting: float  # the tolerance, or the step in s
    error: float  # largest tip distance to the reference during the run, divided by the chain's length
    seconds: float  # of integration with its sampling: the least of some repetitions, warm-up and compiling apart
    steps: int
    evaluations: int


@dataclass(frozen=True)
class Curve:
    """One method, or one method of another simulator, from coarse to fine."""

    name: str
    library: str
    kind: str  # of its settings: "tolerance" or "step"
    points: tuple[Point, ...]
    failures: tuple[str, ...] = ()  # why runs did not reach the end
    compile_seconds: float = 0.0  # the longest
    peer: bool = False

    def point_at(self, error: float) -> Point | None:
        """The cheapest point that meets this error."""
        return next((point for point in self.front if point.error <= error), None)

    def seconds_at(self, error: float) -> float | None:
        """The least time in which this error is met, interpolated in logarithms between its points; None if it is not."""
        front = self.front
        for cheaper, point in zip((None, *front), front, strict=False):
            if point.error <= error:
                return point.seconds if cheaper is None else _between(cheaper, point, error)
        return None

    @property
    def front(self) -> tuple[Point, ...]:
        """Its points that no other beats in both error and time, the cheapest first."""
        found: list[Point] = []
        for point in sorted(self.points, key=lambda point: (point.seconds, point.error)):
            if not found or point.error < found[-1].error:
                found.append(point)
        return tuple(found)


def _between(cheaper: Point, dearer: Point, error: float) -> float:
    share = np.log(cheaper.error / error) / np.log(cheaper.error / max(dearer.error, TINY))
    return float(cheaper.seconds * (dearer.seconds / cheaper.seconds) ** share)


@dataclass(frozen=True, repr=False)
class CostReport:
    """Error against time on one scene and one machine."""

    subject: str  # the model, such as "3 rods"
    curves: tuple[Curve, ...]
    accuracy: float  # the accuracy of interest
    error: float  # of the reference
    solutions: tuple[str, str]  # the two computations that make the reference
    duration: float  # s, of the scene
    horizon: float  # s, end of the comparison: later the reference is not accurate enough
    machine: str
    versions: dict[str, str]
    repetitions: int
    interrupted: bool = False

    def best(self, error: float, peers: bool | None = False) -> tuple[str, float] | None:
        """The cheapest curve that meets an error, and its time in s; of methods, of simulators (True) or of all (None)."""
        found = ((curve.name, curve.seconds_at(error)) for curve in self.curves if peers in (None, curve.peer))
        return min(((name, time) for name, time in found if time is not None), key=lambda pair: pair[1], default=None)

    @property
    def decades(self) -> tuple[float, ...]:
        """The powers of ten of error, from 0.1 down to the error of the reference."""
        return tuple(10.0**-k for k in range(1, 17) if 10.0**-k >= self.error)

    def __repr__(self) -> str:
        return f"What accuracy costs on {self.subject}: {' '.join(self.words)}"[:MOST_REPR]

    @property
    def words(self) -> tuple[str, ...]:
        """The results in sentences."""
        return tuple(_words(self))


def _words(report: CostReport) -> Iterator[str]:
    if report.horizon < report.duration:
        yield (
            f"Compared up to {report.horizon:.3g} s of {report.duration:g} s: later, the two references differ by more than "
            f"{report.accuracy / 10:.0e}."
        )
    yield f"Error of the reference: {report.error:.0e}, the difference of {report.solutions[0]} and {report.solutions[1]}."
    yield from _asked(report)
    for first, last, name in _spans(report):
        where = f"At {first:.0e}" if first == last else f"From {first:.0e} to {last:.0e}"
        yield f"{where} the cheapest is {name}."
    yield from _against_peers(report)


def _asked(report: CostReport) -> Iterator[str]:
    if (found := report.best(report.accuracy)) is None:
        yield f"No method that was tried reaches {report.accuracy:g} within the time allowed."
        return
    name, seconds = found
    finer = next(curve for curve in report.curves if curve.name == name).seconds_at(report.accuracy / 10)
    more = f"; the next digit costs {finer / seconds:.2f} times as much" if finer else ""
    yield f"{report.accuracy:g} costs {time_text(seconds)} with {name}{more}."


def _spans(report: CostReport) -> Iterator[tuple[float, float, str]]:
    """Runs of decades with the same cheapest method: the first and last error, and its name."""
    best = [(error, found[0]) for error in report.decades if (found := report.best(error))]
    while best:
        name = best[0][1]
        count = next((i for i, (_, other) in enumerate(best) if other != name), len(best))
        yield best[0][0], best[count - 1][0], name
        best = best[count:]


def _against_peers(report: CostReport) -> Iterator[str]:
    for error in report.decades:
        own, other = report.best(error), report.best(error, peers=True)
        if own and other:
            times = f"{own[0]} {time_text(own[1])}, {other[0]} {time_text(other[1])}"
            yield f"At {error:.0e}: {times}, {other[1] / own[1]:.3g} times as long."
        elif own and any(curve.peer for curve in report.curves):
            yield f"At {error:.0e}: {own[0]} {time_text(own[1])}; no other simulator reaches it within the time allowed."


def time_text(seconds: float) -> str:
    """A time for a person to read."""
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-6:.3g} µs"
