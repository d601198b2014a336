"""What was found of error against time: a row for each accuracy, and sentences about them."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError
from pendpin.graphics.figure import new_figure, write_figure
from pendpin.ground.report import Report, Result, Table
from pendpin.scene import METHODS
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


# --- error against time as one figure -------------------------------------------------------------------------------

TOOLS = {"pendpin": "#D55E00", "mujoco": "#0072B2", "drake": "#009E73", "scipy": "#7A3E9D"}  # in every figure
NAMES = {"mujoco": "MuJoCo", "drake": "Drake", "scipy": "SciPy"}
PALE = "#cbd5e0"
DIGITS = (1e-3, 1e-9)  # errors between which the price of a digit is the mean
PEERS = {"mujoco": "#c53030", "drake": "#285e61", "scipy": "#4a5568"}
MARKS = "osD^vP*X"
FRONT = "#f6e05e"


def save_cost_plot(report: CostReport, path: str | Path, short: bool = False) -> Path:
    """Write the figure to a .png, .pdf or .svg file, whole or not at all. Raises InputError."""
    return write_figure(path, lambda: draw_cost(report) if short else draw_all(report))


def _refuse_nothing(report: CostReport) -> None:
    """Raises InputError where no run that can be drawn was made."""
    if not any(_drawn(curve, report.error)[0] for curve in report.curves):
        why = next((curve.failures[-1] for curve in report.curves if curve.failures), "no run was made")
        raise InputError(f"there is no figure of costs, because no method could be measured: {why}")


def draw_cost(report: CostReport) -> Any:
    """The cheapest method of pendpin and of each other simulator in strong colours, all others pale."""
    from matplotlib.figure import Figure

    _refuse_nothing(report)
    figure = Figure(figsize=(10, 6.2), layout="constrained")
    ax, prices = figure.subplots(1, 2, width_ratios=(3.4, 1))
    best = _cheapest(report)
    for tool, curve in best.items():
        look = {"linewidth": 3.2 if tool == "pendpin" else 2.2, "zorder": 3, "marker": "o", "ms": 4}
        name = f"{NAMES.get(tool, tool)}: {curve.name.removeprefix(tool).strip()}"
        ax.plot(*_drawn(curve, report.error), color=TOOLS[tool], label=name, **look)
    others = [curve for curve in report.curves if curve not in best.values()]
    for i, curve in enumerate(others):
        label = "_again" if i else f"{len(others)} other curves that were measured"
        ax.plot(*_drawn(curve, report.error), color=PALE, linewidth=1, zorder=1, label=label)
    _frame(ax, report)
    figure.legend(loc="outside upper right", ncols=3, frameon=False, fontsize=9)  # beside the curves, not on them
    _draw_prices(prices, best)
    _write_about(figure, ax, report)
    return figure


def draw_all(report: CostReport) -> Any:
    """All methods: error across, falling to the right; seconds up; a line for each."""
    _refuse_nothing(report)
    figure = new_figure(figsize=(10, 6.2), layout="constrained")
    ax = figure.subplots()
    shown = [curve for curve in report.curves if any(point.error < 1 for point in curve.points)]
    for i, curve in enumerate(sorted(shown, key=lambda curve: curve.peer)):
        _line(ax, curve, report.error, i)
    _front(ax, report)
    _frame(ax, report)
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=9)
    _write_about(figure, ax, report)
    return figure


def _write_about(figure: Any, ax: Any, report: CostReport) -> None:
    title = f"What accuracy costs: {report.subject}, {report.horizon:.3g} s"
    ax.set_title(title, loc="left", fontsize=13, fontweight="bold")
    figure.supxlabel(f"{report.machine}; {report.versions_text}", fontsize=7, color="#4a5568")


# --- the cheapest of each tool ------------------------------------------------------------------------------------


def _cheapest(report: CostReport) -> dict[str, Curve]:
    """The curve of each tool that meets the accuracy of interest in the least time; if none does, the most accurate."""

    def rank(curve: Curve) -> tuple[float, float]:
        seconds = curve.seconds_at(report.accuracy)
        return (0.0, seconds) if seconds is not None else (1.0, min(point.error for point in curve.points))

    best: dict[str, Curve] = {}
    for curve in sorted((curve for curve in report.curves if _drawn(curve, report.error)[0]), key=rank):
        best.setdefault(curve.name.split()[0] if curve.peer else "pendpin", curve)
    return {tool: best[tool] for tool in TOOLS if tool in best}


def _drawn(curve: Curve, least: float) -> tuple[list[float], list[float]]:
    """The errors below 1 that the reference can tell, and their times in s."""
    points = [point for point in curve.points if least < point.error < 1]
    return [point.error for point in points], [point.seconds for point in points]


def _draw_prices(ax: Any, best: dict[str, Curve]) -> None:
    """A bar for each tool: how many times as long a run takes that is ten times as accurate."""
    prices = {tool: price for tool, curve in reversed(best.items()) if (price := _price_next_digit(curve))}
    names, times = [NAMES.get(tool, tool) for tool in prices], list(prices.values())
    bars = ax.barh(names, times, 0.55, color=[TOOLS[tool] for tool in prices])
    ax.bar_label(bars, [f"{price:.2f} x" for price in prices.values()], padding=4, fontsize=11)
    ax.set_xlim(0, 1.35 * max([1.0, *times]))
    ax.set_title("the next digit takes", fontsize=10, loc="left")
    ax.spines[["top", "right", "bottom"]].set_visible(False)
    ax.tick_params(left=False, bottom=False, labelbottom=False)
    ax.set_box_aspect(1.2)


def _price_next_digit(curve: Curve) -> float | None:
    """The mean factor of time from one decade of error to the next within DIGITS; None if fewer than two are met."""
    decades = [error for k in range(17) if DIGITS[1] * 0.99 <= (error := 10.0**-k) <= DIGITS[0] * 1.01]
    times = [seconds for error in decades if (seconds := curve.seconds_at(error)) is not None]
    return (times[-1] / times[0]) ** (1 / (len(times) - 1)) if len(times) > 1 else None


# --- all methods --------------------------------------------------------------------------------------------------


def _line(ax: Any, curve: Curve, floor: float, index: int) -> None:
    points = [point for point in curve.points if point.error < 1]
    above = [point for point in points if point.error > floor]
    name = curve.name.split()[0]
    color = METHODS[name].color if name in METHODS and not curve.peer else PEERS.get(name, "#4a5568")
    dash = "--" if curve.peer else "-" if curve.name == name else "-."  # not compiled
    style: dict[str, Any] = {"linestyle": dash, "linewidth": 1.1 if curve.peer else 1.7}
    errors, seconds = [point.error for point in above], [point.seconds for point in above]
    ax.plot(errors, seconds, marker=MARKS[index % len(MARKS)], ms=4.5, color=color, label=curve.name, **style)


def _front(ax: Any, report: CostReport) -> None:
    """The least time at every error, of all curves, as a broad band behind the lines."""
    errors = np.geomspace(0.3, max(report.error, 1e-16), 200)
    best = [report.best(float(error), None) for error in errors]
    pairs = [(error, point[1]) for error, point in zip(errors, best, strict=True) if point]
    if pairs:
        look = {"color": FRONT, "linewidth": 9, "alpha": 0.55, "zorder": 0, "solid_capstyle": "round"}
        ax.plot(*zip(*pairs, strict=True), label="cheapest", **look)


def _frame(ax: Any, report: CostReport) -> None:
    ax.set_xscale("log")
    ax.set_yscale("log")
    left, right = 1.0, report.error / 3
    ax.set_xlim(left, right)  # errors fall to the right
    ax.axvspan(report.error, right, color="#edf2f7", zorder=-1)
    note = {"transform": ax.get_xaxis_transform(), "fontsize": 8, "va": "bottom", "ha": "left"}
    ax.text(report.error, 0.02, " accuracy of\n the reference", color="#718096", rotation=90, **note)
    ax.axvline(report.accuracy, color="#1a202c", linewidth=0.9, linestyle=":")
    ax.text(report.accuracy, 0.01, f" asked: {report.accuracy:g}", **note)
    ax.set_xlabel("largest error of a tip over the run, over the chain's length  (more accurate to the right)")
    ax.set_ylabel("time of the run, s  (compiling apart)")
    ax.grid(alpha=0.25, linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)
