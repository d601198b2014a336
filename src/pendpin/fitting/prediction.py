"""What a fitted model says of swings: of those that it was fitted to, and of others, with the interval to be expected."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pendpin.errors import InputError, amount
from pendpin.fitting.data import FEWEST, Swing, batch, spread_of, thin_out
from pendpin.fitting.fitting import FINEST, Setting, Solution, shown_swings, start_states
from pendpin.fitting.guess import joint_angles
from pendpin.fitting.problem import solve_starts
from pendpin.fitting.uncertainty import NOISY, huber_scale
from pendpin.ground.arguments import fraction
from pendpin.ground.arrays import Array, Mask
from pendpin.scene import Data

QUANTILE = 1.959964  # of a normal distribution: 95 % lie within it
LOST = 0.25  # of the spread of a column: residuals of a model that does not follow the motion


class Prediction(NamedTuple):
    """What a fitted model says of swings, their starts being fitted on the first part of each."""

    swings: tuple[Swing, ...]  # measured
    predicted: tuple[Array, ...]  # (m, columns) rad or m, of each swing
    compared: tuple[Array, ...]  # (m,) whether a sample counts: those after the part that the start was fitted on
    columns: tuple[str, ...]
    table: Data  # has the unit of each column, in which errors are printed
    robust: bool = False  # whether outliers do not speak against the model
    interval: tuple[Array, ...] | None = None  # (m, columns) rad or m: half widths in which 95 % of measurements lie

    def __repr__(self) -> str:
        of = amount(len(self.swings), "swing")
        return f"Prediction of {of}: rms {self.listed(self.rms)}, largest {self.listed(self.max)}"

    def listed(self, values: dict[str, float]) -> str:
        """A number of each column with its unit, in a line."""
        return ", ".join(f"{name} {self.written(values[name], name)}" for name in self.columns)

    def written(self, value: float, column: str) -> str:
        """A number in rad or m in the unit of its column, with that unit."""
        size, unit = self.table.in_si(column)
        return f"{value / size:.3g} {unit}"

    def errors(self) -> Array:
        """Measured minus predicted, over the samples that count, (N, columns)."""
        parts = zip(self.swings, self.predicted, self.compared, strict=True)
        return np.concatenate([(swing.y - predicted)[compared] for swing, predicted, compared in parts])

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
    def covered(self) -> dict[str, float]:
        """The share of the samples that count within the prediction interval, by column; empty without an interval."""
        if self.interval is None:
            return {}
        errors = self.errors()
        half = np.concatenate([half[compared] for half, compared in zip(self.interval, self.compared, strict=True)])
        inside = (np.abs(errors) <= half).sum(0) / (~np.isnan(errors)).sum(0)
        return dict(zip(self.columns, inside.tolist(), strict=True))

    @property
    def max(self) -> dict[str, float]:
        """The largest error of each column, rad or m."""
        return dict(zip(self.columns, np.nanmax(np.abs(self.errors()), 0).tolist(), strict=True))


def fitted_prediction(setting: Setting, solution: Solution) -> Prediction:
    """What the fit itself says of the swings that it was made from."""
    shown = shown_swings(setting, solution.problem, solution.x, solution.solved.starts)
    predicted = tuple(swing.y for swing in shown)
    compared = tuple(np.ones(len(swing.t), bool) for swing in setting.swings)
    return Prediction(setting.swings, predicted, compared, setting.columns, setting.table, setting.robust)


def compared_samples(swings: Sequence[Swing], start: float) -> list[Mask]:
    """Which samples (m,) of each swing are compared: those after its first part `start`. Raises InputError."""
    start = fraction("hold_out_start", start, "between 0 and 1: it is the part that a start is fitted on")
    compared = [swing.t > swing.t[0] + start * (swing.t[-1] - swing.t[0]) for swing in swings]
    for late, swing in zip(compared, swings, strict=True):
        late[:FEWEST] = False
        if not late.any():
            raise InputError(f"segment {swing.name}: too few samples to fit a start and compare the rest")
    return compared


def predict(
    setting: Setting, solution: Solution, swings: Sequence[Swing], start: float, interval: bool = True
) -> Prediction:
    """Predict other swings with the fitted numbers (Fit.predict), with the interval of 95 % where errors are known.

    To first order, that is by the sum of three variances: that of the unknowns, with which the starts of the swings follow,
    that of these starts by the samples that they were fitted to, and that of one residual of the fit (G. Seber, C. Wild,
    Nonlinear Regression, Wiley, 1989, section 5.1). What the model misses is in the residuals only.
    """
    swings, certainty, x = thin_out(swings, FINEST * setting.pendulum.pace), solution.certainty, solution.x
    compared = compared_samples(swings, start)
    heads = [swing.part(~late) for swing, late in zip(swings, compared, strict=True)]
    problem = replace(solution.problem, batch=batch(heads, np.inf), share=1.0)
    angles = joint_angles(setting.pendulum, heads, solution.z)
    solved = solve_starts(problem, x, start_states(setting, problem, x, angles), 20)
    full = batch(swings, np.inf)
    columns = problem.show(x, solved.starts, full.t)
    predicted = tuple(columns[: len(swing.t), :, k] for k, swing in enumerate(swings))
    widths = None
    known = interval and certainty.enough and fitted_prediction(setting, solution).follows(setting.noise)
    if known and np.isfinite(columns).all():
        whole = replace(problem, batch=full._replace(y=np.nan_to_num(full.y)))
        _, by_start, by_unknowns = whole.evaluate(x, solved.starts)
        slopes, starts = by_unknowns + by_start @ solved.follow, certainty.inflation * by_start @ solved.R_inverse
        variance = 1 + ((slopes @ certainty.covariance) * slopes).sum(-1) + (starts**2).sum(-1)  # in units of weights
        half = QUANTILE * np.sqrt(variance).reshape(len(variance), -1, len(whole.weights)) / whole.weights
        widths = tuple(half[k, : len(swing.t)] for k, swing in enumerate(swings))
    return Prediction(tuple(swings), predicted, tuple(compared), setting.columns, setting.table, interval=widths)
