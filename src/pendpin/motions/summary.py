"""A run in a few lines: model and method, errors, extremes; as text, as a table, in a notebook."""

from collections.abc import Mapping
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from pendpin.errors import InputError, PendpinError, amount, moment
from pendpin.ground.report import Report, Result, Table
from pendpin.model.kinematics import model_of, swings_at
from pendpin.motions.continuation import Continuation, find_coarse, resolve
from pendpin.motions.search import Quantity, find_largest, impacts
from pendpin.trajectory import RunRecord
from pendpin.trajectory.columns import NOTHING, UNITS, is_chain, swing

MOST_PERIODS = 4  # joints
LEAST_TURNS = 3  # upward crossings, for a period: two swings that can be compared
PERIODIC = 1e-3  # of the mean: swings that differ by less have one period, as far as samples show
SWING, TILT = "largest swing", "largest tilt"
FORCES = ("R1", "R2", "R3")
MOST_AGAIN = 2_000_000  # evaluations times joints: about a second, for which a summary may integrate again
EVALUATIONS_OF_EVENT = 500  # of a search on both sides of an event


class Figure(NamedTuple):
    """One number of a summary."""

    value: float
    unit: str
    time: float | None = None  # s, when it was so
    place: str = ""  # which rod

    def __str__(self) -> str:
        when = "" if self.time is None else f" at {moment(self.time)} s"
        return f"{self.value:.6g} {self.unit}{when}{self.place and f', {self.place}'}"


class Summary(Result, dict[str, Figure]):
    """The extremes of a run by name; it prints as a table. `remark` says where they are not those between the samples."""

    def __init__(self, rows: Mapping[str, Figure], remark: str = "") -> None:
        super().__init__(rows)
        self.remark = remark

    def report(self) -> Report:
        rows = [(name, str(figure)) for name, figure in self.items()]
        rows += [("extremes", self.remark)] if self.remark else []
        data = {name: figure._asdict() for name, figure in self.items()}
        return Report([Table(("", ""), rows)] if rows else [], data)

    __repr__ = Result.__str__  # of every row


def summary(run: Any) -> Summary:
    """The largest swing, or tilt of a link of a URDF, rest, extremes of the reactions, periods and energy of a run.

    Extremes are those between the samples too; those of the samples where that would take long, or where the run's scene
    cannot be built again.
    """
    if not len(run.t):
        return Summary({})
    try:
        if run.stats.stopped:  # nobody who has stopped a run waits for more of it
            raise InputError("the run ended early; run.maximum(name) searches between them")
        intervals = max(len(run.t) - 1, 1)
        again = run.stats.evaluations * len(find_coarse(run)) / intervals + EVALUATIONS_OF_EVENT * len(run.events)
        if again * len(run.joints) > MOST_AGAIN or not run.stats.evaluations:
            raise InputError("a search between them would take long; run.maximum(name) does it")
        rows, remark = _extremes(run, resolve(run)), ""
    except (PendpinError, np.linalg.LinAlgError) as error:
        rows, remark = _extremes(run, None), f"those of the {amount(len(run.t), 'sample')}: {error}"
    if not remark and (count := impacts(run)) and run.rod_reactions is not None:
        remark = f"forces are not defined at {amount(count, 'impact')}: those elsewhere"
    moving = np.flatnonzero(run.v.any(axis=1))
    if len(moving) and moving[-1] + 1 < len(run.t):  # at rest from the last event before nothing moves, if there is one
        last, still = run.t[moving[-1] : moving[-1] + 2]
        at = max((e.t for e in run.events if last < e.t <= still), default=float(still))
        rows["at rest from"] = Figure(at, "s")
    # the times between upward crossings of each joint's middle, as samples show them: the period where they are equal
    apart = np.diff(run.t).max(initial=0.0)
    for joint, q, v in list(zip(run.joints, run.q.T, run.v.T, strict=True))[:MOST_PERIODS]:
        x = q - (q.min() + q.max()) / 2
        up = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
        if len(up) < LEAST_TURNS or np.abs(v).max() * apart >= x.max():  # from six samples in a swing on
            continue
        swings = np.diff(run.t[up] - x[up] * (run.t[up + 1] - run.t[up]) / (x[up + 1] - x[up]))
        if np.ptp(swings) <= PERIODIC * swings.mean():
            rows[f"period of {joint}"] = Figure(float(swings.mean()), "s")
        else:
            between = f"from {swings.min():.4g} to {swings.max():.4g} s: not periodic"
            rows[f"mean period of {joint}"] = Figure(float(swings.mean()), "s", place=between)
    energy = run.energy().total
    rows["energy at the start"] = Figure(float(energy[0]), "J")
    rows["energy at the end"] = Figure(float(energy[-1]), "J")
    return Summary(rows, remark)


def _extremes(run: Any, more: Continuation | None) -> dict[str, Figure]:
    """The extremes by name, of a run that is resolved, or of its samples."""
    rows, of_whole = dict[str, Figure](), dict[str, tuple[Quantity, str]]()
    model, t = (None, run.t) if more is None else (more.dynamics.model, more.run.t)
    half = float(t[np.searchsorted(t, (t[0] + t[-1]) / 2)])
    if is_chain(run):
        of_whole[SWING] = (lambda rows: np.degrees(swing(rows))[:, None], "degrees")
    else:
        with suppress(PendpinError):  # as far as the run's model can be built again
            model = model or model_of(run)
            if not np.isnan(swings_at(model, run.q)).any():
                name = TILT if run.tips.shape[1] > 1 else SWING
                of_whole[name] = (lambda rows: np.degrees(swings_at(model, rows.q))[:, None], "degrees")
    of_whole["farthest sideways"] = (lambda rows: np.hypot(*rows.tips[:, -1, :2].T)[:, None], "m")
    for name, (quantity, unit) in of_whole.items():
        rows[name] = whole = _largest(run, more, quantity, unit)
        if name == TILT:
            rows[name] = whole._replace(place="of a link, from straight down")
        later = whole.time is not None and whole.time >= half
        rows[f"{name}, second half"] = whole if later else _largest(run, more, quantity, unit, half)
    parts = {} if run.rod_reactions is None else run.rod_reactions._asdict()
    force = max((np.abs(parts[name]).max() for name in FORCES if name in parts), default=0.0)
    size = {"R": force, "M": force * np.abs(run.tips).max(initial=0.0)}
    for name in (name for name in (*FORCES, "M1", "M2", "M3") if name in parts):
        if not np.abs(parts[name]).max() <= NOTHING * size[name[0]]:  # of rounding every sample is an extreme
            least, largest = (
                _largest(run, more, lambda rows, n=name, s=sign: s * getattr(rows.rod_reactions, n), UNITS[name])
                for sign in (-1.0, 1.0)
            )
            rows |= {f"{name} least": least._replace(value=-least.value), f"{name} largest": largest}
    return rows


def _largest(run: Any, more: Continuation | None, quantity: Quantity, unit: str, first: float = -np.inf) -> Figure:
    """The largest value of a quantity (n, rods) of a run from a sample at `first` in s on; of several rods it says which."""
    if more is None:
        t, values = run.t[run.t >= first], quantity(run)[run.t >= first]
        row, rod = np.unravel_index(int(np.argmax(values)), values.shape) if np.isfinite(values).all() else (0, 0)
        value, time, rods = values[row, rod], t[row], values.shape[1]
    else:
        value, time, rod, rods = find_largest(more, quantity, first)
    return Figure(float(value), unit, float(time), f"rod {rod + 1}" if rods > 1 else "")


def text(run: Any) -> str:
    """Three lines: model and method, errors, extremes."""
    if not len(run.t):
        return "Trajectory without samples"
    stats, trust = run.stats, []
    if stats.stopped:
        trust.append(f"ended early: {stats.stopped}")
    if stats.error is not None:
        trust.append(f"tip error {stats.error:.1e} of the length estimated, {stats.accuracy:g} asked")
    if stats.conservative:
        trust.append(f"energy drift {run.energy().drift:.1e} of the energy exchanged")
    if run.work:
        trust.append(f"works and energy differ by {run.imbalance:.1e} of the energy exchanged")
    trust += [f"note: {note}" for note in stats.notes[:1]]
    trust = trust or ["an effect has no potential: energy_balance=True computes its work"]
    rows = run.summary()
    parts = [f"{name} {rows[name]}" for name in ("at rest from", SWING, TILT) if name in rows]
    if "R3 largest" in rows:
        least, largest = rows["R3 least"], rows["R3 largest"]
        pushed = f"{-least.value:.4g} N at {moment(least.time)} s{least.place and f', {least.place}'}"
        if largest.value < 0:
            parts.append(f"compression from {-largest.value:.4g} to {pushed}")
        elif least.value < 0:
            parts.append(f"compression up to {pushed}, tension up to {largest}")
        else:
            parts.append(f"tension R3 from {least.value + 0.0:.4g} to {largest}")  # never -0
    parts += [f"{name} {figure}" for name, figure in rows.items() if name.startswith(("period", "mean period"))][:1]
    return "\n".join([f"Trajectory of {RunRecord.__repr__(run)}", "; ".join(trust), "; ".join(parts)])
