"""What was found of error against time: runs, curves and a row for each accuracy, sentences about them, and their figure."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError, brief
from pendpin.graphics.style import BLACK, COLORS, GREY, PALE, SHADE, new_figure, styled, write_figure
from pendpin.ground.arrays import EPS
from pendpin.ground.report import Report, Result, Table

ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-12)  # that every report answers for
UNCOMPILED = " not compiled"  # after the name of a method: called from Python, where `simulate` would compile
ONCE = 2.0  # times dearer is the first run of what is cheapest in the long run, if another method is named for a single run


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
        """The time of the first run, compiling included, s."""
        return self.seconds + self.compile_seconds


@dataclass(frozen=True, repr=False)
class Curve:
    """One method, or one method of another simulator, from coarse to fine."""

    name: str
    library: str
    kind: str  # of its settings: "tolerance" or "step"
    points: tuple[Point, ...] = ()
    failures: tuple[str, ...] = ()  # why runs did not reach the end
    peer: bool = False

    def __repr__(self) -> str:
        errors = ", ".join(f"{point.error:.1e} at {point.setting:.0e}" for point in self.points)
        return brief(f"Curve of {self.name}, error at each {self.kind}: {errors or 'none'}")

    @property
    def compile_seconds(self) -> float:
        """The longest time that compiling took, s."""
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
        return _method_in_words(self.method, self.kind, self.setting) if self.setting else self.why

    @property
    def ratio(self) -> float | None:
        """The time of the other simulator over that of a further run."""
        return self.peer_seconds / self.seconds if self.peer_seconds and self.seconds else None


def _method_in_words(name: str, kind: str, setting: float) -> str:
    return f"{name}, {kind} {setting:.1e} s" if kind == "step" else f"{name}, {kind} {setting:.0e}"


def cost_row(curves: Sequence[Curve], accuracy: float, least: float) -> CostRow:
    """The answer for an accuracy from what was measured against a reference with the error `least`."""
    if accuracy < least:
        return CostRow(accuracy, why=f"the reference is accurate to {least:.0e} only")
    met = [(curve, point) for curve in curves if (point := curve.point_at(accuracy))]
    peer = min(((c, p) for c, p in met if c.peer), key=lambda pair: pair[1].seconds, default=None)
    more: dict[str, Any] = {"peer": peer[0].name, "peer_seconds": peer[1].seconds} if peer else {}
    own = [(c, p) for c, p in met if not c.peer]
    if not own:
        ours = [curve for curve in curves if not curve.peer]
        hopeless = ours and all(curve.failures and not curve.points for curve in ours)  # no run reached its end
        why = ours[0].failures[0] if hopeless else "no method reaches it in the time allowed"
        return CostRow(accuracy, **more, why=why)
    curve, best = min(own, key=lambda pair: pair[1].seconds)
    other, once = min(own, key=lambda pair: pair[1].first_seconds)
    if once.first_seconds * ONCE <= best.first_seconds:
        more |= {"once": _method_in_words(other.name, other.kind, once.setting), "once_seconds": once.first_seconds}
    return CostRow(accuracy, curve.name, curve.kind, best.setting, best.first_seconds, best.seconds, **more)


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
        """The figure of all methods that were measured, and of what the next digit takes; written to a path if given."""
        return draw_cost(self) if path is None else write_figure(path, lambda: draw_cost(self))

    def best(self, error: float, peers: bool = False) -> tuple[str, float] | None:
        """The cheapest method that meets an error, and its time in s; with `peers` that of the other simulators."""
        times = ((curve.name, curve.seconds_at(error)) for curve in self.curves if curve.peer == peers)
        return min(((name, time) for name, time in times if time is not None), key=lambda pair: pair[1], default=None)

    @property
    def decades(self) -> tuple[float, ...]:
        """The powers of ten of error, from 0.1 down to the error of the reference."""
        return tuple(10.0**-k for k in range(1, 17) if 10.0**-k >= self.error)

    def report(self) -> Report:
        """The fastest method for each accuracy; where all was measured, every method's time at some errors; sentences."""
        # the fastest method for each accuracy, beside the fastest of the other simulators where they were measured
        peers, once, rows = any(row.peer for row in self.rows), any(row.once_seconds for row in self.rows), []
        for row in self.rows:
            times = (time_text(seconds) for seconds in (row.first_seconds, row.seconds))
            beside = f"{row.peer} {time_text(row.peer_seconds)}" if row.peer_seconds else ""
            beside += f", {row.ratio:.3g} x" if row.ratio else ""
            single = f"{row.once}: {time_text(row.once_seconds)}" if row.once_seconds else ""
            rows.append((f"{row.accuracy:g}", row.take, *times, *[beside] * peers, *[single] * once))
        others = (*["best of the others"] * peers, *["or, for a single run"] * once)
        head = ("accuracy", "fastest method", "first run", "each further run", *others)
        methods: list[str | Table] = []
        if self.thorough:
            # the time of every method at some errors, and its run that meets the accuracy
            errors, all_methods = [error for error in ACCURACIES if error >= self.error], []
            for curve in self.curves:
                point, unit = curve.point_at(self.accuracy), " s" if curve.kind == "step" else ""
                figures = ["", "", ""]
                if point:
                    figures = [f"{point.setting:.0e}{unit}", str(point.steps), str(point.evaluations)]
                all_methods.append((curve.name, *(time_text(curve.seconds_at(error)) for error in errors), *figures))
            titles = ("error:", *(f"{error:.0e}" for error in errors), f"{self.accuracy:g} by", "steps", "evals")
            no_run = (curve for curve in self.curves if curve.failures and not curve.points)
            methods = [Table(titles, all_methods), *(f"{c.name} failed: {c.failures[-1]}" for c in no_run)]
            compiled = [f"{c.name} {time_text(c.compile_seconds)}" for c in self.curves if c.compile_seconds]
            methods += [f"Compiling, on its own: {', '.join(compiled)}."] if compiled else []
        least = f"Processor times of {self.horizon:g} s of the scene: the least of {self.repetitions} after a first"
        end = f"{self.machine_text}. {least}; a first run counts its compiling, but no imports."
        return Report((Table(head, rows), *methods, *self.words, end), asdict(self) | {"words": self.words})

    @property
    def machine_text(self) -> str:
        """The machine and the versions, in one line."""
        return f"{self.machine}; {', '.join(f'{name} {number}' for name, number in self.versions.items())}"

    @property
    def words(self) -> tuple[str, ...]:
        """The results in sentences: of a thorough report at each decade of error, by the runs of the table."""
        accuracy, error, words = self.accuracy, self.error, list[str]()
        if self.horizon < self.duration:
            differ = f"later, the two references differ by more than {accuracy / 10:.0e}"
            why = "the rest would take long; --thorough measures it" if self.halted else differ
            words.append(f"Compared up to {self.horizon:.3g} s of {self.duration:g} s: {why}.")
        words.append(
            f"Error of the reference: {error:.0e}, the difference of {self.solutions[0]} and {self.solutions[1]}."
        )
        if self.missing:
            words.append(f"Not installed, and so not compared: {', '.join(self.missing)} (pip install mujoco drake).")
        best = self.best(accuracy)
        if not self.thorough:
            if best and (finer := self.best(accuracy / 10)):
                more = f"from {accuracy:g} to {accuracy / 10:g}, takes {finer[1] / best[1]:.2f} times the time"
                words.append(f"One more digit, {more}, each by its fastest method.")
            return tuple(words)
        if best is None:
            words.append(f"No method that was tried reaches {accuracy:g} within the time allowed.")
        else:
            name, seconds = best
            finer = next(curve for curve in self.curves if curve.name == name).seconds_at(accuracy / 10)
            more = f"; the next digit costs {finer / seconds:.2f} times as much" if finer else ""
            words.append(f"{accuracy:g} costs {time_text(seconds)} with {name}{more}.")
        rows = [cost_row(self.curves, decade, error) for decade in self.decades]
        for name, group in groupby((one for one in rows if one.method), key=lambda one: one.method):
            decades = [one.accuracy for one in group]
            first, last = decades[0], decades[-1]
            where = f"At {first:.0e}" if first == last else f"From {first:.0e} to {last:.0e}"
            words.append(f"{where} the cheapest is {name}.")
        for one in rows:
            ours = one.seconds and f"At {one.accuracy:.0e}: {one.method} {time_text(one.seconds)}"
            if ours and one.peer_seconds:
                words.append(f"{ours}, {one.peer} {time_text(one.peer_seconds)}, {one.ratio:.3g} times as long.")
            elif ours and any(curve.peer for curve in self.curves):
                words.append(f"{ours}; no other simulator reaches it within the time allowed.")
        return tuple(words)


def time_text(seconds: float | None) -> str:
    """A time for a person to read; nothing for None."""
    if seconds is None:
        return ""
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-6:.3g} µs"


# --- error against time as one figure: the curves that matter in colour, the others grey with their names -----------

DIGITS = (1e-3, 1e-9)  # errors between which the price of a digit is the mean
TOOLS = {"pendpin": "#D55E00", "mujoco": "#0072B2", "drake": "#009E73", "scipy": "#7A3E9D"}  # in every figure
NAMES = {"mujoco": "MuJoCo", "drake": "Drake", "scipy": "SciPy"}
MATTER = 4  # curves in colour: the cheapest of each tool, then those that are the cheapest at most errors
SIZE = (12.0, 6.2)  # inches
WIDTHS = (4.4, 1.0)  # of the curves, and of the prices, in proportion
LINE, LETTER, AWAY = 8.0, 4.0, 4.0  # points: of a name at a curve's end, its height, a letter's width, its distance


@styled()
def draw_cost(report: CostReport) -> Any:
    """A line for each method: error across, falling to the right; seconds up. Beside them what the next digit takes."""
    best, figure = _cheapest(report), new_figure(*SIZE)
    ax, prices = figure.subplots(1, 2, width_ratios=WIDTHS)
    matter = {curve.name: TOOLS[tool] for tool, curve in best.items()}
    fronts = [first[0] for error in report.decades if (first := report.best(error)) is not None]
    free = [color for color in COLORS if color not in matter.values()]
    for name in sorted(dict.fromkeys(fronts), key=fronts.count, reverse=True):
        if name not in matter and len(matter) < MATTER:
            matter[name] = free[len(matter) % len(free)]
    others = [curve for curve in report.curves if curve.name not in matter and _points(curve, report.error)[0]]
    for name, color in matter.items():
        curve = next(curve for curve in report.curves if curve.name == name)
        look = {"linewidth": 2.2, "linestyle": "--" if curve.peer else "-", "marker": "o", "zorder": 3}
        ax.plot(*_points(curve, report.error), color=color, label=name, **look)
    for curve in others:
        ax.plot(*_points(curve, report.error), ".--" if curve.peer else ".-", color=PALE, linewidth=1, zorder=1)
    # logarithmic axes with titles, what the reference cannot tell, the accuracy that was asked
    ax.set(xscale="log", yscale="log")
    left, right = 1.0, report.error / 3
    ax.set_xlim(left, right)  # errors fall to the right
    ax.axvspan(report.error, right, color=SHADE, zorder=-1)
    note = {"transform": ax.get_xaxis_transform(), "fontsize": 8, "va": "bottom", "ha": "left"}
    ax.text(report.error, 0.02, " accuracy of\n the reference", color=GREY, rotation=90, **note)
    ax.axvline(report.accuracy, color=BLACK, linewidth=0.9, linestyle=":")
    ax.text(report.accuracy, 0.01, f" asked: {report.accuracy:g}", **note)
    ax.set_xlabel("largest error of a tip over the chain's length; more accurate to the right")
    ax.set_ylabel("time of the run, compiling apart (s)")
    title = f"What accuracy costs: {report.subject}, {report.horizon:.3g} s"
    ax.set_title(title, fontsize=13, fontweight="bold")
    figure.supxlabel(report.machine_text, fontsize=7, color=GREY)
    _name_ends(ax, others, report.error)
    figure.legend(loc="outside upper right", ncols=MATTER)  # beside the curves, not on them
    _draw_prices(prices, best)
    return figure


def _points(curve: Curve, least: float) -> tuple[list[float], list[float]]:
    """The errors below 1 that the reference can tell, and their times in s."""
    points = [point for point in curve.points if least < point.error < 1]
    return [point.error for point in points], [point.seconds for point in points]


def _cheapest(report: CostReport) -> dict[str, Curve]:
    """Of each tool the curve that meets the accuracy in the least time, else the most accurate. InputError without a run."""

    def rank(curve: Curve) -> tuple[float, float]:
        seconds = curve.seconds_at(report.accuracy)
        return (0.0, seconds) if seconds is not None else (1.0, min(point.error for point in curve.points))

    best: dict[str, Curve] = {}
    for curve in sorted((curve for curve in report.curves if _points(curve, report.error)[0]), key=rank):
        best.setdefault(curve.name.split()[0] if curve.peer else "pendpin", curve)
    if not best:
        why = next((curve.failures[-1] for curve in report.curves if curve.failures), "no run was made")
        raise InputError(f"there is no figure of costs, because no method could be measured: {why}")
    return {tool: best[tool] for tool in TOOLS if tool in best}


def _name_ends(ax: Any, curves: list[Curve], least: float) -> None:
    """The name of each curve at its most accurate end, moved up or down where another name is, with a line to it."""
    (left, right), (low, high) = (np.log(ax.get_xlim()), np.log(ax.get_ylim()))
    share = WIDTHS[0] / sum(WIDTHS)
    width, height = 0.8 * 72 * SIZE[0] * share, 0.8 * 72 * SIZE[1]  # points, about, of the axes
    ends = []
    for curve in curves:
        error, seconds = min(zip(*_points(curve, least), strict=True))
        x, y = (np.log(error) - left) / (right - left) * width, (np.log(seconds) - low) / (high - low) * height
        ends.append((y, x, error, seconds, curve.name))
    taken: list[tuple[float, float, float]] = []  # left, right and height of the names that are there
    for y, x, error, seconds, name in sorted(ends):
        end = x + AWAY + LETTER * len(name)
        up = next(
            step
            for step in sorted(range(-20, 21), key=abs)
            if all(end < a or x > b or abs(y + step * LINE / 2 - c) >= LINE for a, b, c in taken)
        )
        taken.append((x, end, y + up * LINE / 2))
        place, line = (AWAY + 8 * (abs(up) > 1), up * LINE / 2), {"arrowstyle": "-", "color": PALE, "linewidth": 0.5}
        look: Any = {"textcoords": "offset points", "va": "center", "fontsize": 7, "color": GREY}
        ax.annotate(name, (error, seconds), place, arrowprops=line | {"shrinkA": 0, "shrinkB": 0}, **look)


def _draw_prices(ax: Any, best: dict[str, Curve]) -> None:
    """A bar for each tool: how many times as long a run takes that is ten times as accurate, in the mean within DIGITS."""
    decades = [error for k in range(17) if DIGITS[1] * 0.99 <= (error := 10.0**-k) <= DIGITS[0] * 1.01]
    prices: dict[str, float] = {}
    for tool, curve in reversed(best.items()):
        times = [seconds for error in decades if (seconds := curve.seconds_at(error)) is not None]
        if len(set(times)) > 1:  # one run that is accurate enough for all of them tells nothing of a digit
            prices[tool] = (times[-1] / times[0]) ** (1 / (len(times) - 1))
    names, bars = [NAMES.get(tool, tool) for tool in prices], list(prices.values())
    drawn = ax.barh(names, bars, 0.55, color=[TOOLS[tool] for tool in prices])
    ax.bar_label(drawn, [f"{price:.2f} x" for price in bars], padding=4, fontsize=11)
    ax.set_xlim(0, 1.35 * max([1.0, *bars]))
    ax.set_ylim((len(bars) - 1) / 2 - len(TOOLS) / 2, (len(bars) - 1) / 2 + len(TOOLS) / 2)  # few bars are no thicker
    ax.set_title("the next digit takes")
    ax.spines["bottom"].set_visible(False)
    ax.grid(visible=False)
    ax.tick_params(left=False, bottom=False, labelbottom=False)
    ax.set_box_aspect(1.2)
