"""The result of a fit: numbers with errors, what they are worth, predictions of other swings, as text and as JSON."""

import textwrap
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError, find
from pendpin.fitting.data import Swing, read_swings, spread_of
from pendpin.fitting.fitting import OTHER_UNIT, Setting, Solution
from pendpin.fitting.parameters import Combination
from pendpin.fitting.prediction import Prediction, predict
from pendpin.fitting.uncertainty import NOISY, WHITE, autocorrelation, outliers, whiteness
from pendpin.graphics.style import BESIDE, BLACK, COLORS, SHADE, new_figure, plain_name, styled, with_unit, write_figure
from pendpin.ground.arguments import axes, fraction
from pendpin.ground.arrays import Array
from pendpin.ground.files import path_of, write_csv
from pendpin.ground.report import Report, Result, Table
from pendpin.scene import Chain, Scene, unit_of_key

CHECK = "check the units of angles and times, and what the columns measure"
WIDER = 1.2  # times: said from there on
MOSTLY = 0.5  # of the spread of a column: noise beside which there is little motion
POOR = 0.05  # of the spread of a column: residuals of a model that misses something large
OUTLIERS = 0.5  # of the squared residuals of a column: outliers with more of them explain what is left over
NAMED = 3  # outliers, the farthest
PERIOD, COLOURED = 60, 1e-3  # samples, about a period; level at which noise with one correlation time is refused
FAR = 10.0  # times the residuals of the fit: held-out errors that need a reason


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Result):
    """A fitted scene and what is known of its numbers.

    values and errors (standard errors) are by key path. Numbers that the data do not determine are in `undetermined` and
    have no error. Their values are the nearest to your guess among all that fit the data equally well. If the model does
    not follow the motion at all, nothing is determined; if the data are too short, there are no errors. Zeros of columns
    are in the unit of [data], residuals and noise in rad, or m for tips; the text has all of them in the unit of [data].
    """

    scene: Scene  # with the fitted numbers
    values: dict[str, float]
    errors: dict[str, float]
    covariance: Array  # (len(errors), len(errors)), in the order of errors
    undetermined: tuple[str, ...]
    combinations: tuple[Combination, ...]  # what is determined of the undetermined
    train: Prediction  # every sample counts
    hold_out: Prediction | None
    noise: dict[str, float]  # of the sensors, by column
    white: float  # probability of so much correlation in white residuals
    inflation: float  # of the standard errors by correlated residuals
    seconds: float  # of processor time
    setting: Setting
    solution: Solution
    parts: tuple[Any, ...] = ()  # what each part of the model is worth, where it was asked

    @property
    def residuals(self) -> tuple[Swing, ...]:
        """Measured minus fitted, swing by swing, (m, columns)."""
        pairs = zip(self.train.swings, self.train.predicted, strict=True)
        return tuple(swing._replace(y=swing.y - predicted) for swing, predicted in pairs)

    @property
    def follows(self) -> bool:
        """Whether the model follows the motion at all; if not, its numbers mean nothing."""
        return self.train.follows(np.array(list(self.noise.values())))

    @property
    def explained(self) -> bool:
        """Whether the model explains the data. The rest is noise, white and no larger than the sensors', or correlated.

        Correlated noise has one correlation time; what an effect leaves over goes with the motion, so that even its new part
        is correlated within a period.
        """
        loud = any(rms > NOISY * self.noise[name] for name, rms in self.train.usual.items())
        certainty = self.solution.certainty
        coloured = certainty.enough and whiteness(certainty.new, PERIOD) > COLOURED
        return self.follows and (coloured or (not loud and self.white > WHITE))

    def predict(self, data: Any, start: float = 0.1) -> Prediction:
        """Predict other swings, with 95 % prediction intervals; their starts are fitted on the first part `start` of each.

        A Prediction: predicted and interval, swing by swing, (m, columns) in rad or m; rms, max and covered by column.
        There are no intervals (None) without standard errors, as of data that are too short or not explained.
        """
        return predict(self.setting, self.solution, read_swings(data, self.setting.table), start)

    def plot(self, path: Any = None) -> Any:
        """A figure of measured and fitted angles, residuals and their autocorrelation; written to `path` if given."""
        return draw_fit(self) if path is None else write_figure(path, lambda: draw_fit(self))

    def confidence_region(self, one: str, other: str, level: float = 0.95) -> Array:
        """The ellipse (k, 2) that holds the true values of two free numbers together with a probability of `level`.

        That of a normal distribution with the covariance of the two. Raises InputError for a number without an error, and
        for a level that is not between 0 and 1.
        """
        places = [find(tuple(self.errors), key, "confidence_region:") for key in (one, other)]
        if one == other:
            raise InputError(f"confidence_region: {one} is there twice; give two numbers with errors")
        level = fraction("level", level, "a probability between 0 and 1")
        angle = np.linspace(0.0, 2 * np.pi, 200)
        values, directions = np.linalg.eigh(self.covariance[np.ix_(places, places)])
        circle = np.sqrt(-2 * np.log1p(-level)) * np.column_stack([np.cos(angle), np.sin(angle)])
        centre = np.array([self.values[one], self.values[other]])
        return centre + circle * np.sqrt(np.maximum(values, 0.0)) @ directions.T

    @styled()
    def plot_region(self, one: str, other: str, ax: Any = None) -> Any:
        """Draw confidence regions of two free numbers, 68 and 95 %, on a matplotlib Axes, else a new one.

        Each number alone is a cross of two standard errors.
        """
        ax = axes("ax", ax) or new_figure(5.5, 4.5).subplots()
        for level, color in ((0.95, COLORS[5]), (0.68, COLORS[0])):
            ax.fill(*self.confidence_region(one, other, level).T, color=color, alpha=0.35, label=f"{100 * level:.0f} %")
        x, y = self.values[one], self.values[other]
        crosses = 2 * self.errors[other], 2 * self.errors[one]
        ax.errorbar(x, y, *crosses, color=BLACK, fmt="o", capsize=3, label="each alone")
        x, y = (with_unit(key, unit_of_key(key, self.scene) or self.unit(key).strip()) for key in (one, other))
        ax.set(xlabel=x, ylabel=y)
        ax.legend(**BESIDE)
        return ax

    def to_csv(self, path: str | Path) -> Path:
        """Write what was measured, fitted or predicted, and the rest, sample by sample, in the unit of [data].

        Columns: set (fitted or held out), swing, t in s; then of each column itself, _fitted, _residual (measured minus
        fitted) and, with held-out swings, _interval (half of the 95 % prediction interval; empty for fitted swings).
        """
        sets = {"fitted": self.train} | ({"held out": self.hold_out} if self.hold_out else {})
        columns, rows = self.train.columns, []
        ends = ("", "_fitted", "_residual", *["_interval"] * any(one.interval is not None for one in sets.values()))
        for name, one in sets.items():
            sizes = np.array([one.table.in_si(column)[0] for column in columns])
            for i, (swing, predicted) in enumerate(zip(one.swings, one.predicted, strict=True)):
                half = np.full_like(swing.y, np.nan) if one.interval is None else one.interval[i]
                parts = np.stack([swing.y, predicted, swing.y - predicted, half][: len(ends)], -1) / sizes[:, None]
                numbers = parts.reshape(len(swing.t), -1).tolist()
                cells = (["" if np.isnan(x) else repr(x) for x in row] for row in numbers)
                rows += [(name, swing.name, repr(t), *row) for t, row in zip(swing.t.tolist(), cells, strict=True)]
        return write_csv(path_of(path), ("set", "swing", "t", *(f"{c}{e}" for c in columns for e in ends)), rows)

    def report(self) -> Report:
        """The fitted numbers with their errors, the verdict and its reasons."""
        rows = []
        for key, value in self.values.items():
            unit = self.unit(key)
            error = f"{self.errors[key]:.2g}{unit}" if key in self.errors else ""
            rows.append((key, "", "not determined") if key in self.undetermined else (key, f"{value:.6g}{unit}", error))
        held = self.hold_out
        data = {
            "values": {key: None if key in self.undetermined else value for key, value in self.values.items()},
            "errors": self.errors,
            "undetermined": list(self.undetermined),
            "combinations": {c.name: {"value": c.value, "error": c.error, "unit": c.unit} for c in self.combinations},
            "seconds": self.seconds,
            "train": {"rms": self.train.rms},
            "hold_out": held and {"rms": held.rms, "max": held.max, "covered": held.covered},
            "explained": self.explained,
            "verdict": self.verdict,
            "parts": [asdict(part) | {"needed": part.needed} for part in self.parts],
        }
        fault = None if self.follows else "its motions do not follow the data"
        return Report((Table(("", "value", "standard error"), rows), *self._words()), data, fault)

    @property
    def verdict(self) -> str:
        """Whether the model explains the data, in a sentence."""
        rms, part, slow = self.train.usual, self.train.part, self.setting.slowness
        if not 1 / OTHER_UNIT < slow < OTHER_UNIT:
            pace = f"{slow:.2g} times slower" if slow > 1 else f"{1 / slow:.2g} times faster"
            return f"The model cannot explain the data at all: they move {pace} than it; {CHECK}."
        if not np.isfinite(part):
            return f"The model cannot explain the data at all: its motions grow without bound; {CHECK}."
        worst = max(rms, key=lambda name: rms[name] / self.noise[name])
        times = rms[worst] / self.noise[worst]
        sizes = f"residuals of {worst} are {self.train.written(rms[worst], worst)}, {times:.3g} times the noise"
        k = self.train.columns.index(worst)  # whether samples that stand out are most of its squared residuals
        off = sum(swing.y[sample, k] ** 2 for _, swing, sample, column in self._outliers if column == k)
        if not self.setting.robust and off > OUTLIERS * np.nansum(self.train.errors()[:, k] ** 2):
            return f"The model cannot explain the data: {sizes}, because of the samples that stand out."
        if part > MOSTLY and times <= NOISY:
            return f"These data tell little: {100 * part:.2g} % of their variation is noise of the sensors."
        if self.explained and self.white > WHITE:
            return "The model explains the data: the residuals are white and no larger than the noise."
        if self.explained:
            memory = f"correlated over {self.solution.certainty.memory:.2g} s"
            return f"Noise of the sensors that is {memory} explains what the model leaves over: {sizes}."
        if times <= NOISY:
            return f"The model cannot explain the data: residuals are small, but go with the motion (p = {self.white:.1g})."
        what = f"{sizes}, {float(f'{100 * part:.2g}'):g} % of the motion, and correlated"
        if not self.follows:
            return f"The model cannot explain the data at all: {what}; {CHECK}."
        end = f"; else {CHECK}." if part > POOR else "."
        return f"The model cannot explain the data: {what}. Some effect is missing{end}"

    @cached_property
    def _outliers(self) -> list[tuple[float, Swing, int, int]]:
        return outliers(self.residuals, spread_of(self.train.swings))

    def unit(self, key: str) -> str:
        """Behind the zero of a column, the unit of [data]; other numbers are in those of the scene."""
        column = key.removeprefix("data.offsets.")
        return f" {self.setting.table.in_si(column)[1]}" if column != key else ""

    def _words(self) -> list[str]:
        rows = []
        if far := self._outliers:
            one, named = len(far) == 1, []
            for size, swing, sample, column in far[:NAMED]:
                name = self.train.columns[column]
                named.append(f"{swing.source} {swing.rows[sample]}, column {name}, by {self.train.written(size, name)}")
            many = "1 sample stands out" if one else f"{len(far)} samples stand out"
            less = f"Correct or remove {'it' if one else 'them'}, or use --robust (robust=True)."
            if self.setting.robust:
                less = "It counts less." if one else "They count less."
            rows.append(f"{many}{', the farthest' * (len(far) > NAMED)}: {'; '.join(named)}. {less}")
        rows.append(self.verdict)
        if missing := sum(swing.missing for swing in self.train.swings):
            rows.append(f"Cells without a number, which are skipped: {missing}.")
        if not isinstance(self.scene.model, Chain):
            rows.append('Masses and inertias are those of the URDF: a fit frees those of rods (kind = "chain") only.')
        key, rods = "model.rods[0].com", self.scene.model.all_rods if isinstance(self.scene.model, Chain) else ()
        if len(rods) == 1 and not rods[0].payload and key in self.errors and rods[0].properties.h:
            of = rods[0].properties
            other = (of.I2 if rods[0].turns == "y" else of.I1) / (of.m * of.h)
            rows.append(f"{key} = {other:.6g} m, its centre of oscillation, may fit alike: angles cannot tell.")
        if self.undetermined and self.follows:
            rows.append(
                f"Not determined by these data: {', '.join(self.undetermined)}. Do not free those that you can weigh or "
                "measure. The fitted scene holds, of all values that fit equally well, those nearest to your guess."
            )
        if self.combinations:
            rows.append("Only these combinations of them are determined:")
            rows += [f"  {combination}" for combination in self.combinations]
        certainty = self.solution.certainty
        if self.follows and not certainty.enough:
            rows.append(
                f"No standard errors: residuals stay correlated for {certainty.memory:.2g} s, too long for "
                f"{certainty.duration:.3g} s of data. Measure for longer, or mend the model."
            )
        if self.errors and self.inflation > WIDER:
            wider = f"{self.inflation:.3g} times wider"
            rows.append(f"Standard errors are up to {wider} because the residuals are correlated.")
        rms, usual = self.train.rms, self.train.usual
        outlying = any(rms[name] > NOISY * usual[name] for name in rms)
        without = f"; without outliers {self.train.listed(usual)}" if outlying else ""
        rows.append(f"Fitted: rms {self.train.listed(rms)}{without}")
        if self.hold_out:
            hold_out = self.hold_out
            rows.append(f"Held out: rms {hold_out.listed(hold_out.rms)}; largest {hold_out.listed(hold_out.max)}")
            if shares := ", ".join(f"{name} {100 * share:.3g} %" for name, share in hold_out.covered.items()):
                rows.append(f"Held-out samples within the 95 % prediction interval: {shares}")
            times = max(rms / max(usual[name], self.noise[name]) for name, rms in hold_out.rms.items())
            if times > FAR:
                rows.append(
                    f"Held-out errors are {times:.2g} times those of the fit: check the units of the held-out data. Larger "
                    "swings than the fitted ones, and those of another pendulum, are not predicted either."
                )
        return [*rows, *(str(part) for part in self.parts), f"{self.seconds:.1f} s"]


# --- a fit as one figure: measured and fitted swings, what is left over, and the autocorrelation of that -------------

GAP = 5.0  # times the usual time between samples: no curve is drawn across


@styled()
def draw_fit(fit: Fit) -> Any:
    """The figure; swings are drawn one after the other, with breaks between them, those held out on a shade."""
    figure = new_figure(11.0, 8.0)
    top, middle, below = figure.subplots(3, 1, height_ratios=(3, 2, 2))
    middle.sharex(top)
    end = _draw_swings(top, middle, fit.train, 0.0)
    if fit.hold_out:
        last = _draw_swings(top, middle, fit.hold_out, end)
        for ax in (top, middle):
            ax.axvspan(end, last, color=SHADE, zorder=0, linewidth=0)
        top.text(end, 1.01, "held out", transform=top.get_xaxis_transform(), fontsize=9)
    for name, color in zip(fit.train.columns, COLORS * len(fit.train.columns), strict=False):
        top.plot([], [], color=color, label=plain_name(name))
    top.plot([], [], ".", color=BLACK, markersize=2, label="measured")
    if fit.hold_out and fit.hold_out.interval:
        middle.fill_between([], [], [], color=COLORS[0], alpha=0.2, linewidth=0, label="95 % of\npredictions")
        middle.legend(**BESIDE)
    top.legend(**BESIDE)
    unit = " or ".join(sorted({fit.train.table.in_si(name)[1] for name in fit.train.columns}, key="m".__eq__))
    top.set_ylabel(f"measured, fitted ({unit})")
    middle.set_ylabel(f"measured minus fitted ({unit})")
    middle.set_xlabel("time, swings one after the other (s)")
    problem, r = fit.solution.problem, fit.solution.solved.r
    r = r.reshape(len(problem.batch.swing), -1, len(fit.train.columns))
    spacing = float(np.median(np.diff(fit.train.swings[0].t)))
    for k in range(len(fit.train.columns)):
        rho = autocorrelation(r[:, :, k : k + 1], 400)
        below.plot(spacing * np.arange(len(rho)), rho, color=COLORS[k % len(COLORS)])
    bound = 2 / np.sqrt(max((r != 0).sum() / len(fit.train.columns), 1))
    below.axhspan(-bound, bound, color=SHADE, linewidth=0, label="white noise,\n95 %")
    below.legend(**BESIDE)
    below.set(xlabel="lag (s)", ylabel="autocorrelation")
    figure.suptitle(textwrap.fill(fit.verdict, 120), fontsize=10, x=0.01, ha="left")
    return figure


def _draw_swings(top: Any, middle: Any, shown: Prediction, begin: float) -> float:
    """Draw swings from a time on, in the units of the data; the time at which the last ends."""
    scales = [1 / shown.table.in_si(name)[0] for name in shown.columns]
    for i, (swing, predicted, compared) in enumerate(zip(shown.swings, shown.predicted, shown.compared, strict=True)):
        t = swing.t - swing.t[0] + begin
        for k, scale in enumerate(scales):
            color = COLORS[k % len(COLORS)]
            top.plot(t, scale * swing.y[:, k], ".", color=BLACK, markersize=1)
            top.plot(*interrupt(t, scale * predicted[:, k]), color=color, linewidth=0.8)
            rest = np.where(compared, swing.y[:, k] - predicted[:, k], np.nan)
            middle.plot(*interrupt(t, scale * rest), color=color, linewidth=0.7)
            if shown.interval:
                at, half = interrupt(t, np.where(compared, scale * shown.interval[i][:, k], np.nan))
                middle.fill_between(at, -half, half, color=color, alpha=0.2, linewidth=0)
        begin = t[-1] + 0.02 * (t[-1] - t[0])
    return begin


def interrupt(t: Array, values: Array) -> tuple[Array, Array]:
    """A curve (m,) that is interrupted where the data are: where samples lie GAP times farther apart than most."""
    gaps = np.flatnonzero(np.diff(t) > GAP * np.median(np.diff(t))) + 1 if len(t) > 2 else np.array([], int)
    return np.insert(t, gaps, t[gaps]), np.insert(values, gaps, np.nan)
