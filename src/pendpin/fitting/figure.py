"""A fit as one figure: measured and fitted swings, what is left over, and the autocorrelation of that.

Every `fit` here is a Fit, whose file imports this one.
"""

import textwrap
from typing import Any

import numpy as np

from pendpin.fitting.prediction import Prediction
from pendpin.fitting.uncertainty import autocorrelation
from pendpin.graphics.style import BESIDE, BLACK, COLORS, SHADE, join_units, new_figure, plain_name, styled, with_unit
from pendpin.ground.arrays import Array
from pendpin.scene import unit_of_key

MOST_LAGS = 400
GAP = 5.0  # times the usual time between samples: no curve is drawn across


@styled()
def draw_fit(fit: Any) -> Any:
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
    unit = join_units(sorted({fit.train.table.in_si(name)[1] for name in fit.train.columns}, key="m".__eq__))
    top.set_ylabel(f"measured, fitted ({unit})")
    middle.set_ylabel(f"measured minus fitted ({unit})")
    middle.set_xlabel("time, swings one after the other (s)")
    _draw_correlation(below, fit)
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


def _draw_correlation(ax: Any, fit: Any) -> None:
    problem, r = fit.solution.problem, fit.solution.solved.r
    r = r.reshape(len(problem.batch.swing), -1, len(fit.train.columns))
    spacing = float(np.median(np.diff(fit.train.swings[0].t)))
    for k in range(len(fit.train.columns)):
        rho = autocorrelation(r[:, :, k : k + 1], MOST_LAGS)
        ax.plot(spacing * np.arange(len(rho)), rho, color=COLORS[k % len(COLORS)])
    bound = 2 / np.sqrt(max((r != 0).sum() / len(fit.train.columns), 1))
    ax.axhspan(-bound, bound, color=SHADE, linewidth=0, label="white noise,\n95 %")
    ax.legend(**BESIDE)
    ax.set_ylabel("autocorrelation")
    ax.set_xlabel("lag (s)")


@styled()
def draw_region(fit: Any, one: str, other: str, ax: Any) -> Any:
    """Confidence regions of two numbers together: 68 and 95 %, and each alone as a cross of two standard errors."""
    ax = ax or new_figure(5.5, 4.5).subplots()
    for level, color in ((0.95, COLORS[5]), (0.68, COLORS[0])):
        ax.fill(*fit.confidence_region(one, other, level).T, color=color, alpha=0.35, label=f"{100 * level:.0f} %")
    x, y = fit.values[one], fit.values[other]
    ax.errorbar(x, y, 2 * fit.errors[other], 2 * fit.errors[one], color=BLACK, fmt="o", capsize=3, label="each alone")
    x, y = (with_unit(key, unit_of_key(key, fit.scene) or fit.unit(key).strip()) for key in (one, other))
    ax.set(xlabel=x, ylabel=y)
    ax.legend(**BESIDE)
    return ax
