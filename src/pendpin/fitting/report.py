"""The result of a fit: numbers with errors, what they are worth, predictions of other swings, as text and as JSON."""

import textwrap
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pendpin.errors import InputError
from pendpin.fitting.data import FEWEST, Swing, batch, cut_pieces, read_swings, spread_of, thin_out
from pendpin.fitting.fitting import FINEST, OTHER_UNIT, Setting, Solution, start_states
from pendpin.fitting.guess import joint_angles
from pendpin.fitting.problem import solve_starts
from pendpin.fitting.uncertainty import NOISY, WHITE, Combination, autocorrelation, huber_scale, outliers, whiteness
from pendpin.ground.arrays import Array, Mask
from pendpin.ground.report import Report, Result, Table
from pendpin.scene import Chain, Data, Scene

CHECK = "check the units of angles and times, and what the columns measure"
WIDER = 1.2  # times: said from there on
MOSTLY = 0.5  # of the spread of a column: noise beside which there is little motion
LOST = 0.25  # of the spread of a column: residuals of a model that does not follow the motion
POOR = 0.05  # of the spread of a column: residuals of a model that misses something large
OUTLIERS = 0.5  # of the squared residuals of a column: outliers with more of them explain what is left over
NAMED = 3  # outliers, the farthest
PERIOD, COLOURED = 60, 1e-3  # samples, about a period; level at which noise with one correlation time is refused
FAR = 10.0  # times the residuals of the fit: held-out errors that need a reason


class Prediction(NamedTuple):
    """What a fitted model says of swings, their starts being fitted on the first part of each."""

    swings: tuple[Swing, ...]  # measured
    predicted: tuple[Array, ...]  # (m, columns) rad or m, of each swing
    compared: tuple[Array, ...]  # (m,) whether a sample counts: those after the part that the start was fitted on
    columns: tuple[str, ...]
    table: Data  # has the unit of each column, in which errors are printed
    robust: bool = False  # whether outliers do not speak against the model

    def __repr__(self) -> str:
        return f"Prediction of {len(self.swings)} swings: rms {self.listed(self.rms)}, largest {self.listed(self.max)}"

    def listed(self, values: dict[str, float]) -> str:
        """A number of each column with its unit, in a line."""
        return ", ".join(f"{name} {self.written(values[name], name)}" for name in self.columns)

    def written(self, value: float, column: str) -> str:
        """A number in rad or m in the unit of its column, with that unit."""
        size, unit = self.table.in_si(column)
        return f"{value / size:.3g} {unit}"

    def errors(self) -> Array:
        """Predicted less measured, over the samples that count, (N, columns)."""
        parts = zip(self.swings, self.predicted, self.compared, strict=True)
        return np.concatenate([(predicted - swing.y)[compared] for swing, predicted, compared in parts])

    @property
    @np.errstate(over="ignore")  # of motions that grow without bound
    def rms(self) -> dict[str, float]:
        """The root of the mean square error of each column, rad or m."""
        return dict(zip(self.columns, np.sqrt(np.nanmean(self.errors() ** 2, 0)).tolist(), strict=True))

    @property
    def usual(self) -> dict[str, float]:
        """The rms of each column, of robust fits without outliers, rad or m."""
        if not self.robust:
            return self.rms
        errors = self.errors()
        return dict(zip(self.columns, huber_scale(errors, ~np.isnan(errors), 0).tolist(), strict=True))

    @property
    def part(self) -> float:
        """The largest usual error of a column over the standard deviation of what was measured there."""
        return float(max(np.array(list(self.usual.values())) / spread_of(self.swings)))

    def follows(self, noise: Array) -> bool:
        """Whether it follows the motion: errors are below a quarter of it, or are noise (columns,), rad or m."""
        return self.part <= LOST or bool((np.array(list(self.usual.values())) <= NOISY * noise).all())

    @property
    def max(self) -> dict[str, float]:
        """The largest error of each column, rad or m."""
        return dict(zip(self.columns, np.nanmax(np.abs(self.errors()), 0).tolist(), strict=True))


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
        """Measured less fitted, swing by swing, (m, columns)."""
        pairs = zip(self.train.swings, self.train.predicted, strict=True)
        return tuple(swing._replace(y=swing.y - predicted) for swing, predicted in pairs)

    @property
    def follows(self) -> bool:
        """Whether the model follows the motion at all: else its numbers mean nothing."""
        return self.train.follows(np.array(list(self.noise.values())))

    @property
    def explained(self) -> bool:
        """Whether the model explains the data: the rest is noise, white and no larger than the sensors', or correlated.

        Correlated noise has one correlation time; what an effect leaves over goes with the motion, so that even its new part
        is correlated within a period.
        """
        loud = any(rms > NOISY * self.noise[name] for name, rms in self.train.usual.items())
        certainty = self.solution.certainty
        coloured = certainty.enough and whiteness(certainty.new, PERIOD) > COLOURED
        return self.follows and (coloured or (not loud and self.white > WHITE))

    def predict(self, data: Any, start: float = 0.1) -> Prediction:
        """Predict other swings; their starts are fitted on the first part `start` of each."""
        return predict(self.setting, self.solution, read_swings(data, self.setting.table), start)

    def plot(self, path: Any = None) -> Any:
        """A figure of measured and fitted angles, residuals and their autocorrelation; written to `path` if given."""
        from pendpin.graphics.figure import write_figure

        return draw_fit(self) if path is None else write_figure(path, lambda: draw_fit(self))

    def report(self) -> Report:
        """The fitted numbers with their errors, the verdict and its reasons."""
        hold_out = self.hold_out and {"rms": self.hold_out.rms, "max": self.hold_out.max}
        data = {
            "values": {key: None if key in self.undetermined else value for key, value in self.values.items()},
            "errors": self.errors,
            "undetermined": list(self.undetermined),
            "combinations": {c.name: {"value": c.value, "error": c.error, "unit": c.unit} for c in self.combinations},
            "seconds": self.seconds,
            "train": {"rms": self.train.rms},
            "hold_out": hold_out,
            "explained": self.explained,
            "verdict": self.verdict,
            "parts": [asdict(part) | {"needed": part.needed} for part in self.parts],
        }
        fault = None if self.follows else "its motions do not follow the data"
        return Report((Table(("", "value", "standard error"), self._rows()), *self._words()), data, fault)

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
        size = self.train.written(rms[worst], worst)
        times = f"residuals of {worst} are {size}, {rms[worst] / self.noise[worst]:.3g} times the noise"
        if self._outliers_explain(worst):
            return f"The model cannot explain the data: {times}, because of the samples that stand out."
        if part > MOSTLY and rms[worst] <= NOISY * self.noise[worst]:
            return f"These data tell little: {100 * part:.2g} % of their variation is noise of the sensors."
        if self.explained:
            if self.white > WHITE:
                return "The model explains the data: the residuals are white and no larger than the noise."
            memory = f"{self.solution.certainty.memory:.2g} s"
            return (
                f"Noise of the sensors that is correlated over {memory} explains what the model leaves over: {times}."
            )
        if rms[worst] <= NOISY * self.noise[worst]:
            return f"The model cannot explain the data: residuals are small, but go with the motion (p = {self.white:.1g})."
        what = f"{times}, {float(f'{100 * part:.2g}'):g} % of the motion, and correlated"
        if not self.follows:
            return f"The model cannot explain the data at all: {what}; {CHECK}."
        if part > POOR:
            return f"The model cannot explain the data: {what}. Some effect is missing; else {CHECK}."
        return f"The model cannot explain the data: {what}. Some effect is missing."

    def _rows(self) -> list[tuple[str, str, str]]:
        """Key path, value and standard error of each free number as text; a number that is not determined has no value."""
        rows = []
        for key, value in self.values.items():
            unit = self.unit(key)
            error = f"{self.errors[key]:.2g}{unit}" if key in self.errors else ""
            unsure = key in self.undetermined
            rows.append((key, "", "not determined") if unsure else (key, f"{value:.6g}{unit}", error))
        return rows

    def unit(self, key: str) -> str:
        """Behind the zero of a column, the unit of [data]; other numbers are in those of the scene."""
        column = key.removeprefix("data.offsets.")
        return f" {self.setting.table.in_si(column)[1]}" if column != key else ""

    def _outliers(self) -> list[tuple[float, Swing, int, int]]:
        return outliers(self.residuals, spread_of(self.train.swings))

    def _outliers_explain(self, name: str) -> bool:
        """Whether samples that stand out, in a fit that is not robust, are most of the squared residuals of a column."""
        k = self.train.columns.index(name)
        off = sum(swing.y[sample, k] ** 2 for _, swing, sample, column in self._outliers() if column == k)
        return not self.setting.robust and off > OUTLIERS * np.nansum(self.train.errors()[:, k] ** 2)

    def _odd_samples(self) -> list[str]:
        """Which samples stand out."""
        if not (far := self._outliers()):
            return []
        one = len(far) == 1
        many = "1 sample stands" if one else f"{len(far)} samples stand"
        shown = "; ".join(
            f"{swing.source} {swing.rows[sample]}, column {name}, by {self.train.written(size, name)}"
            for size, swing, sample, column in far[:NAMED]
            for name in (self.train.columns[column],)
        )
        less = f"Correct or remove {'it' if one else 'them'}, or use --robust (robust=True)."
        if self.setting.robust:
            less = "It counts less." if one else "They count less."
        return [f"{many} out{', the farthest' * (len(far) > NAMED)}: {shown}. {less}"]

    def _words(self) -> list[str]:
        """The verdict and its reasons, as lines of text."""
        rows = [*self._odd_samples(), self.verdict]
        if missing := sum(swing.missing for swing in self.train.swings):
            rows.append(f"Cells without a number, which are skipped: {missing}.")
        if not isinstance(self.scene.model, Chain):
            rows.append('Masses and inertias are those of the URDF: a fit frees those of rods (kind = "chain") only.')
        if self.undetermined and self.follows:
            rows.append(
                f"Not determined by these data: {', '.join(self.undetermined)}. Do not free those that you can weigh or "
                "measure. The fitted scene holds, of all values that fit equally well, those nearest to your guess."
            )
        if self.combinations:
            rows.append("Only these combinations of them are determined:")
            rows += [f"  {combination}" for combination in self.combinations]
        if self.follows and not self.solution.certainty.enough:
            certainty = self.solution.certainty
            rows.append(
                f"No standard errors: residuals stay correlated for {certainty.memory:.2g} s, too long for "
                f"{certainty.duration:.3g} s of data. Measure for longer, or mend the model."
            )
        if self.errors and self.inflation > WIDER:
            rows.append(
                f"Standard errors are up to {self.inflation:.3g} times wider because the residuals are correlated."
            )
        rms, usual = self.train.rms, self.train.usual
        outlying = any(rms[name] > NOISY * usual[name] for name in rms)
        without = f"; without outliers {self.train.listed(usual)}" if outlying else ""
        rows.append(f"Fitted: rms {self.train.listed(rms)}{without}")
        if self.hold_out:
            hold_out = self.hold_out
            rows.append(f"Held out: rms {hold_out.listed(hold_out.rms)}; largest {hold_out.listed(hold_out.max)}")
            times = max(rms / max(usual[name], self.noise[name]) for name, rms in hold_out.rms.items())
            if times > FAR:
                rows.append(
                    f"Held-out errors are {times:.2g} times those of the fit: check the units of the held-out data. Larger "
                    "swings than the fitted ones, and those of another pendulum, are not predicted either."
                )
        return [*rows, *(str(part) for part in self.parts), f"{self.seconds:.1f} s"]


def fitted_prediction(setting: Setting, solution: Solution) -> Prediction:
    """What the fit itself says of the swings that it was made from."""
    p, starts = solution.problem, solution.solved.starts
    columns = p.show(solution.x, starts, p.batch.t)
    predicted = []
    for k, swing in enumerate(setting.swings):
        places = np.flatnonzero(p.batch.swing == k)
        pieces = zip(places, cut_pieces([swing], p.batch.longest), strict=True)
        predicted.append(np.concatenate([columns[: len(piece.t), :, place] for place, piece in pieces]))
    compared = tuple(np.ones(len(swing.t), bool) for swing in setting.swings)
    return Prediction(setting.swings, tuple(predicted), compared, setting.columns, setting.table, setting.robust)


def compared_samples(swings: Sequence[Swing], start: float) -> list[Mask]:
    """Which samples (m,) of each swing are compared: those after its first part `start`. Raises InputError."""
    if not 0 < start < 1:
        raise InputError(f"hold_out_start: {start:g} is not between 0 and 1: it is the part that a start is fitted on")
    compared = [swing.t > swing.t[0] + start * (swing.t[-1] - swing.t[0]) for swing in swings]
    for late, swing in zip(compared, swings, strict=True):
        late[:FEWEST] = False
        if not late.any():
            raise InputError(f"segment {swing.name}: too few samples to fit a start and compare the rest")
    return compared


def predict(setting: Setting, solution: Solution, swings: Sequence[Swing], start: float) -> Prediction:
    """Predict other swings with the fitted numbers (Fit.predict)."""
    swings = thin_out(swings, FINEST * setting.pace)
    compared = compared_samples(swings, start)
    heads = [swing.part(~late) for swing, late in zip(swings, compared, strict=True)]
    problem = replace(solution.problem, batch=batch(heads, np.inf), share=1.0)
    angles = joint_angles(setting.pendulum, heads, solution.z)
    solved = solve_starts(problem, solution.x, start_states(setting, solution.offsets, angles, np.inf), 20)
    full = batch(swings, np.inf)
    columns = problem.show(solution.x, solved.starts, full.t)
    predicted = tuple(columns[: len(swing.t), :, k] for k, swing in enumerate(swings))
    return Prediction(tuple(swings), predicted, tuple(compared), setting.columns, setting.table)


# --- a fit as one figure --------------------------------------------------------------------------------------------

COLORS = ("#d9622b", "#2b6cb0", "#2f855a", "#6b46c1", "#b7791f", "#4a5568")
HELD = "#edf2f7"
MOST_LAGS = 400
GAP = 5.0  # times the usual time between samples: no curve is drawn across


def draw_fit(fit: Fit) -> Any:
    """The figure; swings are drawn one after the other, with breaks between them."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 8), layout="constrained")
    top, middle, below = figure.subplots(3, 1, height_ratios=(3, 2, 2))
    middle.sharex(top)
    end = _swings(top, middle, fit.train, 0.0)
    if fit.hold_out:
        last = _swings(top, middle, fit.hold_out, end)
        for ax in (top, middle):
            ax.axvspan(end, last, color=HELD, zorder=0)
        top.text(end, 1.01, "held out", transform=top.get_xaxis_transform(), fontsize=8, color="#4a5568")
    for k, name in enumerate(fit.train.columns):
        top.plot([], [], color=COLORS[k % len(COLORS)], label=name)
    top.plot([], [], "k.", markersize=2, label="measured")
    top.legend(loc="upper right", fontsize=8, ncols=4)
    units = sorted({fit.train.table.in_si(name)[1] for name in fit.train.columns}, key="m".__eq__)
    top.set_ylabel(f"measured and fitted, {' or '.join(units)}")
    middle.set_ylabel(f"measured less fitted, {' or '.join(units)}")
    middle.ticklabel_format(axis="y", style="sci", scilimits=(-3, 4))
    middle.set_xlabel("time, s; swings one after the other")
    _correlation(below, fit)
    figure.suptitle(textwrap.fill(fit.verdict, 120), fontsize=10, x=0.01, ha="left")
    return figure


def _swings(top: Any, middle: Any, shown: Any, begin: float) -> float:
    """Draw swings from a time on, in the units of the data; the time at which the last ends."""
    scales = [1 / shown.table.in_si(name)[0] for name in shown.columns]
    for swing, predicted, compared in zip(shown.swings, shown.predicted, shown.compared, strict=True):
        t = swing.t - swing.t[0] + begin
        for k in range(predicted.shape[1]):
            color = COLORS[k % len(COLORS)]
            scale = scales[k]
            top.plot(t, scale * swing.y[:, k], "k.", markersize=1)
            top.plot(*_broken(t, scale * predicted[:, k]), color=color, linewidth=0.8)
            rest = np.where(compared, swing.y[:, k] - predicted[:, k], np.nan)
            middle.plot(*_broken(t, scale * rest), color=color, linewidth=0.7)
        begin = t[-1] + 0.02 * (t[-1] - t[0])
    return begin


def _broken(t: Array, values: Array) -> tuple[Array, Array]:
    """A curve (m,) that is interrupted where the data are: where samples lie GAP times farther apart than most."""
    gaps = np.flatnonzero(np.diff(t) > GAP * np.median(np.diff(t))) + 1 if len(t) > 2 else np.array([], int)
    return np.insert(t, gaps, t[gaps]), np.insert(values, gaps, np.nan)


def _correlation(ax: Any, fit: Fit) -> None:
    problem, r = fit.solution.problem, fit.solution.solved.r
    r = r.reshape(len(problem.batch.swing), -1, len(fit.train.columns))
    spacing = float(np.median(np.diff(fit.train.swings[0].t)))
    for k, name in enumerate(fit.train.columns):
        rho = autocorrelation(r[:, :, k : k + 1], MOST_LAGS)
        ax.plot(spacing * np.arange(len(rho)), rho, color=COLORS[k % len(COLORS)], label=name)
    bound = 2 / np.sqrt(max((r != 0).sum() / len(fit.train.columns), 1))
    ax.axhspan(-bound, bound, color=HELD)
    ax.set_ylabel("autocorrelation of residuals")
    ax.set_xlabel("lag, s (shaded: white noise, 95 %)")
