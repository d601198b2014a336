"""What was found of error against time: a row for each accuracy, and sentences about them."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pendpin.ground.report import Report, Result, Table
from pendpin.verification.work_precision.figure import draw_all, save_cost_plot
from pendpin.verification.work_precision.series import Curve, Point

ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-12)  # that every report answers for
UNCOMPILED = " not compiled"  # after the name of a method: called from Python, where `simulate` would compile
ONCE = 2.0  # times dearer is the first run of what is cheapest in the long run, if another method is named for a single run


@dataclass(frozen=True)
class CostRow:
    """The fastest run for an accuracy: the cheapest of all runs that meet it."""

    accuracy: float
    method: str = ""  # empty if no run that was measured meets the accuracy
    kind: str = ""  # of the setting: "tolerance" or "step"
    setting: float | None = None
    first_seconds: float | None = None  # of the first run, compiling included
    seconds: float | None = None  # of each further run
    once: str = ""  # the fastest for a single run, if that is another and much cheaper
    once_seconds: float | None = None
    peer: str = ""  # the cheapest of the other simulators
    peer_seconds: float | None = None
    why: str = ""  # the reason, where no run meets the accuracy

    @property
    def take(self) -> str:
        """The method and its setting in words."""
        return _taken(self.method, self.kind, self.setting) if self.setting else self.why

    @property
    def ratio(self) -> float | None:
        """The time of the other simulator over that of a further run."""
        return self.peer_seconds / self.seconds if self.peer_seconds and self.seconds else None


def _taken(name: str, kind: str, setting: float) -> str:
    return f"{name}, {kind} {setting:.1e} s" if kind == "step" else f"{name}, {kind} {setting:.0e}"


def row(curves: Sequence[Curve], accuracy: float, least: float) -> CostRow:
    """The answer for an accuracy from what was measured against a reference with the error `least`."""
    if accuracy < least:
        return CostRow(accuracy, why=f"the reference is accurate to {least:.0e} only")
    met = [(curve, point) for curve in curves if (point := curve.point_at(accuracy))]
    best = min(((c, p) for c, p in met if not c.peer), key=lambda pair: pair[1].seconds, default=None)
    peer = min(((c, p) for c, p in met if c.peer), key=lambda pair: pair[1].seconds, default=None)
    other = {"peer": peer[0].name, "peer_seconds": peer[1].seconds} if peer else {}
    if best is None:
        ours = [curve for curve in curves if not curve.peer]
        hopeless = ours and all(curve.failures and not curve.points for curve in ours)  # no run reached its end
        return CostRow(
            accuracy, **other, why=ours[0].failures[0] if hopeless else "no method reaches it in the time allowed"
        )
    curve, point = best
    first = (point.first_seconds, point.seconds)
    return CostRow(accuracy, curve.name, curve.kind, point.setting, *first, **_cheapest_single_run(met, point), **other)


def _cheapest_single_run(met: list[tuple[Curve, Point]], best: Point) -> dict[str, Any]:
    """The cheapest first run, if it is much cheaper than that of the best point."""
    curve, point = min(((c, p) for c, p in met if not c.peer), key=lambda pair: pair[1].first_seconds)
    if point.first_seconds * ONCE > best.first_seconds:
        return {}
    return {"once": _taken(curve.name, curve.kind, point.setting), "once_seconds": point.first_seconds}


@dataclass(frozen=True, repr=False)
class CostReport(Result):
    """Error against time on one scene and one machine."""

    subject: str  # the model, such as "3 rods"
    curves: tuple[Curve, ...]
    accuracy: float  # the accuracy of interest
    error: float  # of the reference
    solutions: tuple[str, str]  # the two computations that make the reference
    duration: float  # s, of the scene
    horizon: float  # s, end of the comparison: later the reference is not accurate enough, or takes too long
    machine: str
    versions: dict[str, str]
    repetitions: int
    thorough: bool = True  # whether all methods were measured at all settings
    halted: bool = False  # whether the comparison ends because more of the scene would take too long
    interrupted: bool = False
    missing: tuple[str, ...] = ()  # other simulators that were asked for and are not installed
    rows: tuple[CostRow, ...] = ()  # the answers, from coarse to fine

    def plot(self, path: str | Path | None = None) -> Any:
        """The figure of all methods that were measured; a path (.png, .pdf, .svg) is written. Raises InputError."""
        return draw_all(self) if path is None else save_cost_plot(self, path)

    def best(self, error: float, peers: bool | None = False) -> tuple[str, float] | None:
        """The cheapest curve that meets an error, and its time in s; of methods, of simulators (True) or of all (None)."""
        times = ((curve.name, curve.seconds_at(error)) for curve in self.curves if peers in (None, curve.peer))
        return min(((name, time) for name, time in times if time is not None), key=lambda pair: pair[1], default=None)

    @property
    def decades(self) -> tuple[float, ...]:
        """The powers of ten of error, from 0.1 down to the error of the reference."""
        return tuple(10.0**-k for k in range(1, 17) if 10.0**-k >= self.error)

    def report(self) -> Report:
        """The fastest method for each accuracy; where all was measured, every method's time at some errors; sentences."""
        methods = [_methods(self), *_further(self)] if self.thorough else []
        least = f"Processor times of {self.horizon:g} s of the scene: the least of {self.repetitions} after a first"
        end = f"{self.machine}; {self.versions_text}. {least}; a first run counts its compiling, but no imports."
        return Report((_accuracies(self), *methods, *self.words, end), asdict(self) | {"words": self.words})

    @property
    def versions_text(self) -> str:
        """The libraries and their versions."""
        return ", ".join(f"{name} {number}" for name, number in self.versions.items())

    @property
    def words(self) -> tuple[str, ...]:
        """The results in sentences."""
        return tuple(_words(self))


def _words(report: CostReport) -> Iterator[str]:
    if report.horizon < report.duration:
        differ = f"later, the two references differ by more than {report.accuracy / 10:.0e}"
        why = "the rest would take long; --thorough measures it" if report.halted else differ
        yield f"Compared up to {report.horizon:.3g} s of {report.duration:g} s: {why}."
    yield f"Error of the reference: {report.error:.0e}, the difference of {report.solutions[0]} and {report.solutions[1]}."
    if report.missing:
        yield f"Not installed, and so not compared: {', '.join(report.missing)} (pip install mujoco drake)."
    if not report.thorough:
        yield from _next_digit(report)
        return
    yield from _asked(report)
    for first, last, name in _spans(report):
        where = f"At {first:.0e}" if first == last else f"From {first:.0e} to {last:.0e}"
        yield f"{where} the cheapest is {name}."
    yield from _against_peers(report)


def _asked(report: CostReport) -> Iterator[str]:
    if (best := report.best(report.accuracy)) is None:
        yield f"No method that was tried reaches {report.accuracy:g} within the time allowed."
        return
    name, seconds = best
    finer = next(curve for curve in report.curves if curve.name == name).seconds_at(report.accuracy / 10)
    more = f"; the next digit costs {finer / seconds:.2f} times as much" if finer else ""
    yield f"{report.accuracy:g} costs {time_text(seconds)} with {name}{more}."


def _next_digit(report: CostReport) -> Iterator[str]:
    best = report.best(report.accuracy)
    finer = best and report.best(report.accuracy / 10)
    if best and finer:
        more = f"from {report.accuracy:g} to {report.accuracy / 10:g} takes {finer[1] / best[1]:.2f} times the time"
        yield f"One more digit, {more}, each by its fastest method."


def _spans(report: CostReport) -> Iterator[tuple[float, float, str]]:
    """Runs of decades with the same cheapest method: the first and last error, and its name; as the rows of the table."""
    best = [(error, name) for error in report.decades if (name := row(report.curves, error, report.error).method)]
    while best:
        name = best[0][1]
        count = next((i for i, (_, other) in enumerate(best) if other != name), len(best))
        yield best[0][0], best[count - 1][0], name
        best = best[count:]


def _against_peers(report: CostReport) -> Iterator[str]:
    """Beside the other simulators at each decade, by the runs of the table."""
    for error in report.decades:
        cheapest = row(report.curves, error, report.error)
        if cheapest.seconds and cheapest.peer_seconds:
            times = (
                f"{cheapest.method} {time_text(cheapest.seconds)}, {cheapest.peer} {time_text(cheapest.peer_seconds)}"
            )
            yield f"At {error:.0e}: {times}, {cheapest.ratio:.3g} times as long."
        elif cheapest.seconds and any(curve.peer for curve in report.curves):
            ours = f"{cheapest.method} {time_text(cheapest.seconds)}"
            yield f"At {error:.0e}: {ours}; no other simulator reaches it within the time allowed."


def _accuracies(report: CostReport) -> Table:
    """The fastest method for each accuracy, beside the fastest of the other simulators where they were measured."""
    peers = any(row.peer for row in report.rows)
    rows = []
    for row in report.rows:
        times = ("" if seconds is None else time_text(seconds) for seconds in (row.first_seconds, row.seconds))
        beside = f"{row.peer} {time_text(row.peer_seconds)}" if row.peer_seconds else ""
        beside += f", {row.ratio:.3g} x" if row.ratio else ""
        once = f"{row.once}: {time_text(row.once_seconds)}" if row.once_seconds else ""
        rows.append((f"{row.accuracy:g}", row.take, *times, *([beside] if peers else []), once))
    others = ["best of the others"] if peers else []
    return Table(("accuracy", "fastest method", "first run", "each further run", *others, "or, for a single run"), rows)


def _methods(report: CostReport) -> Table:
    """The time of every method at some errors, and its run that meets the accuracy."""
    errors = [error for error in ACCURACIES if error >= report.error]
    rows = []
    for curve in report.curves:
        times = ["" if t is None else time_text(t) for t in map(curve.seconds_at, errors)]
        point, unit = curve.point_at(report.accuracy), " s" if curve.kind == "step" else ""
        figures = [f"{point.setting:.0e}{unit}", str(point.steps), str(point.evaluations)] if point else ["", "", ""]
        rows.append((curve.name, *times, *figures))
    asked = (f"{report.accuracy:g} by", "steps", "evals")
    return Table(("error:", *(f"{error:.0e}" for error in errors), *asked), rows)


def _further(report: CostReport) -> Iterator[str]:
    """Why methods have no run, and what compiling takes on its own."""
    for curve in report.curves:
        if curve.failures and not curve.points:
            yield f"{curve.name} failed: {curve.failures[-1]}"
    compiled = [f"{curve.name} {time_text(curve.compile_seconds)}" for curve in report.curves if curve.compile_seconds]
    if compiled:
        yield f"Compiling, on its own: {', '.join(compiled)}."


def time_text(seconds: float) -> str:
    """A time for a person to read."""
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-6:.3g} µs"
