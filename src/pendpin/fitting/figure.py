"""A fit as one figure: measured and fitted columns, residuals, their autocorrelation, the held-out part shaded."""

import textwrap
from typing import Any

import numpy as np

from pendpin.fitting.uncertainty import autocorrelation
from pendpin.ground.arrays import Array

COLORS = ("#d9622b", "#2b6cb0", "#2f855a", "#6b46c1", "#b7791f", "#4a5568")
HELD = "#edf2f7"
MOST_LAGS = 400
GAP = 5.0  # times the usual time between samples: no curve is drawn across


def draw_fit(fit: Any) -> Any:
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


def _correlation(ax: Any, fit: Any) -> None:
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
