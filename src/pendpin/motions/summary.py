"""A run in a few lines: model and method, errors, extremes; as text, as a table, in a notebook."""

import html
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from pendpin.ground.arrays import Array
from pendpin.trajectory import RunRecord

MOST_PERIODS = 4  # joints
LEAST_TURNS = 3  # upward crossings, for a period: two swings that can be compared
PERIODIC = 1e-3  # of the mean: swings that differ by less have one period, as far as samples show
FORCES = ("R1", "R2", "R3")


class Figure(NamedTuple):
    """One number of a summary."""

    value: float
    unit: str
    time: float | None = None  # s, when it was so
    place: str = ""  # which rod

    def __str__(self) -> str:
        when = "" if self.time is None else f" at {self.time:.6g} s"
        return f"{self.value:.6g} {self.unit}{when}{self.place and f', {self.place}'}"


class Summary(dict[str, Figure]):
    """The extremes of a run by name; it prints as a table."""

    def __repr__(self) -> str:
        width = max(map(len, self), default=0)
        return "\n".join(f"{name:<{width}}  {figure}" for name, figure in self.items())

    def _repr_html_(self) -> str:
        rows = (
            f"<tr><th>{html.escape(name)}</th><td>{html.escape(str(figure))}</td></tr>" for name, figure in self.items()
        )
        return f"<table>{''.join(rows)}</table>"


def summary(run: Any) -> Summary:
    """The largest swing, when it comes to rest if it does, the extremes of the reactions, periods and energy of a run."""
    if not len(run.t):
        return Summary()
    rows, half = {}, np.searchsorted(run.t, (run.t[0] + run.t[-1]) / 2)
    for name, values, unit in (
        *([] if np.isnan(run.swing).any() else [("largest swing", np.degrees(run.swing), "degrees")]),
        ("farthest sideways", np.hypot(*run.tips[:, -1, :2].T), "m"),
    ):
        rows[name] = _extreme(values[:, None], run.t, np.max, unit, [""])
        rows[f"{name}, second half"] = _extreme(values[half:, None], run.t[half:], np.max, unit, [""])
    rows |= _rest(run)
    if run.rod_reactions is not None:
        count = run.rod_reactions.R1.shape[1]
        rods = [f"rod {i + 1}" for i in range(count)] if count > 1 else [""]
        for name, unit in (*((force, "N") for force in FORCES), ("M3", "N m")):
            values = getattr(run.rod_reactions, name)
            if values.any():
                rows[f"{name} least"] = _extreme(values, run.t, np.min, unit, rods)
                rows[f"{name} largest"] = _extreme(values, run.t, np.max, unit, rods)
    rows |= dict(_periods(run))
    energy = run.energy().total
    rows["energy at the start"] = Figure(float(energy[0]), "J")
    rows["energy at the end"] = Figure(float(energy[-1]), "J")
    return Summary(rows)


def _rest(run: Any) -> dict[str, Figure]:
    """From when on nothing moves: the last event before that; nothing where it moves at the end, or never does."""
    moving = np.flatnonzero(run.v.any(axis=1))
    if not len(moving) or moving[-1] + 1 == len(run.t):
        return {}
    last, still = run.t[moving[-1] : moving[-1] + 2]
    return {"at rest from": Figure(max((e.t for e in run.events if last < e.t <= still), default=float(still)), "s")}


def _extreme(values: Array, t: Array, of: Any, unit: str, places: list[str]) -> Figure:
    """The least or largest of values (n, places), when and where."""
    row, column = np.argwhere(values == of(values))[0] if np.isfinite(values).all() else (0, 0)
    return Figure(float(values[row, column]), unit, float(t[row]), places[column])


def _periods(run: Any) -> Iterator[tuple[str, Figure]]:
    """The times between the crossings of each joint's middle, upwards, as the samples show them; none of few samples.

    Where they are equal they are the period; else the motion has none, and their mean and their range are said.
    """
    apart = np.diff(run.t).max(initial=0.0)
    for joint, q, v in list(zip(run.joints, run.q.T, run.v.T, strict=True))[:MOST_PERIODS]:
        x = q - (q.min() + q.max()) / 2
        up = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
        if len(up) < LEAST_TURNS or np.abs(v).max() * apart >= x.max():  # from six samples in a swing on
            continue
        times = run.t[up] - x[up] * (run.t[up + 1] - run.t[up]) / (x[up + 1] - x[up])
        swings = np.diff(times)
        if np.ptp(swings) <= PERIODIC * swings.mean():
            yield f"period of {joint}", Figure(float(swings.mean()), "s")
        else:
            between = f"from {swings.min():.4g} to {swings.max():.4g} s: not periodic"
            yield f"mean swing of {joint}", Figure(float(swings.mean()), "s", place=between)


def text(run: Any) -> str:
    """Three lines: model and method, errors, extremes."""
    if not len(run.t):
        return "Trajectory without samples"
    first = f"Trajectory of {RunRecord.__repr__(run)}"
    rows = summary(run)
    parts = [f"at rest from {rows['at rest from']}"] if "at rest from" in rows else []
    parts += [f"largest swing {rows['largest swing']}"] if "largest swing" in rows else []
    if "R3 largest" in rows:
        parts.append(f"tension R3 from {rows['R3 least'].value:.4g} to {rows['R3 largest']}")
    parts += [f"{name} {figure}" for name, figure in rows.items() if name.startswith(("period", "mean swing"))][:1]
    return "\n".join([first, _trust(run), "; ".join(parts)])


def _trust(run: Any) -> str:
    stats, parts = run.stats, []
    if stats.stopped:
        parts.append(f"ended early: {stats.stopped[:200]}")
    if stats.error is not None:
        parts.append(f"tip error {stats.error:.1e} of the length estimated, {stats.accuracy:g} asked")
    if stats.conservative:
        parts.append(f"energy drift {run.energy().drift:.1e} of the energy exchanged")
    if run.work:
        parts.append(f"works and energy differ by {run.imbalance:.1e} of the energy exchanged")
    parts += [f"note: {note[:120]}" for note in stats.notes[:1]]
    return "; ".join(parts) or "an effect has no potential: energy_balance=True computes its work"


def page(run: Any, player: str) -> str:
    """A run in a notebook: the player, three lines, and the table of extremes."""
    lines = f'<pre style="white-space: pre-wrap">{html.escape(text(run))}</pre>'
    return f"{player}{lines}{summary(run)._repr_html_()}"
