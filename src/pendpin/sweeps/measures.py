"""What is measured of each run of a sweep: a number by name, or a function of the run.

A name is one of `MEASURES`, or a series of a run with a statistic, such as theta_1.max or R3_2.rms; with `.spread` behind
it, the difference between the run and one at a tolerance 100 times looser: what can be believed of the measure.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from pendpin.equations.base import PHI, THETA
from pendpin.errors import InputError, PendpinError, RunError, choices, not_one_of, shown
from pendpin.ground.arrays import Array
from pendpin.ground.report import Report, Table
from pendpin.model.build import Model, build
from pendpin.model.kinematics import evaluate_each, model_of, poses, swings_at, tilts_of_chain, tip_distance, tips
from pendpin.motions.continuation import Continuation, resolve, strays
from pendpin.motions.periodic import period_of, periodic_orbit, small_motions
from pendpin.motions.periodic import stable as is_stable
from pendpin.motions.search import Changes, extreme, find_instants, find_largest, first_crossings, sign_changes
from pendpin.motions.trajectory import Trajectory
from pendpin.runs.batches import Motions
from pendpin.runs.simulate import run_to_setting
from pendpin.scene import Scene, Start, scene_of
from pendpin.sweeps.attractors import NAME as ATTRACTOR
from pendpin.sweeps.attractors import PART, Attractor, read_attractor
from pendpin.sweeps.extremes import largest
from pendpin.trajectory import RunRecord, samples_of
from pendpin.trajectory.columns import DRIFT

SETTLED = 0.02  # of the largest distance from the final state: the usual two per cent
UNSETTLED = 0.9  # of the run: what settles later may not have settled
SPREAD = ".spread"
# sin²(angle / 2) of a swing: nearer to the top its rounding hides the angle, to 1e-8 rad at the top itself
BELOW = 0.999
TURN = 1.0  # rad, from sample to sample, that samples follow
PIECES = 50  # of a run, for a Lyapunov exponent

Function = Callable[[Trajectory], Any]  # a number; or an array, where the function says its `dims`


@dataclass(frozen=True)
class Measure:
    """A number of a run, or of the run and a looser one; `of_motion` gives those of a batch where q and v say them all."""

    name: str
    unit: str
    function: Callable[..., Any]  # of a Trajectory, or of two
    two: bool = False  # whether it compares two runs, or the Motions of two batches
    spread: Callable[[Trajectory, Trajectory], float] | None = None  # where it is not the difference of both
    of_motion: Callable[..., Array] | None = None
    series: str = ""  # the quantity of a run, for a statistic of one
    between: bool = False  # whether `of_motion` is NaN where samples do not tell what is between them
    without: str = "no value"  # what it says of a run that it has none
    ends: bool = False  # whether `of_motion` looks at the start and the end alone
    dims: tuple[tuple[str, int], ...] = ()  # names and lengths of the dimensions of its values, if it is not one number


def measure(name_or_function: str | Function) -> Measure:
    """A measure by its name, or a function of a run. Raises InputError for an unknown name."""
    if callable(name_or_function):
        name = getattr(name_or_function, "variable", getattr(name_or_function, "__name__", "function"))
        return Measure(name, "", name_or_function, dims=tuple(getattr(name_or_function, "dims", {}).items()))
    if not isinstance(name_or_function, str):
        raise InputError(f"measure: {shown(name_or_function)} is neither a name nor a function of a run")
    if name_or_function.endswith(SPREAD):
        return _spread(measure(name_or_function.removesuffix(SPREAD)))
    if name_or_function in MEASURES:
        return MEASURES[name_or_function]
    if name_or_function == ATTRACTOR or name_or_function.startswith(f"{ATTRACTOR}("):
        return Measure(ATTRACTOR, "", read_attractor(name_or_function))
    series, _, statistic = name_or_function.rpartition(".")
    if series and statistic in STATISTICS:
        unit = "s" if statistic == "argmax" else ""
        return Measure(
            *(name_or_function, unit, partial(_statistic, series, statistic)),
            of_motion=partial(_statistic_of_motions, series, statistic),
            series=series,
            between=statistic in EXTREMES,
            ends=statistic == "final",
        )
    if series:
        raise InputError(f"measure: {name_or_function}: {not_one_of(statistic, (*STATISTICS, SPREAD[1:]))}")
    series = f"a series of a run followed by {choices(f'.{name}' for name in STATISTICS)}, such as theta_1.max"
    raise InputError(f"measure: {not_one_of(name_or_function, (*MEASURES, ATTRACTOR))}; nor {series}")


def fitted(m: Measure, scene: Scene, keys: Sequence[str]) -> Measure:
    """The measure as it is of a scene whose numbers at `keys` vary: that of attractors has a number of each joint."""
    if not isinstance(m.function, Attractor):
        return m
    period = m.function.period
    if period is None and not any("frequency" in key for key in keys):
        period = period_of(scene)
    look = Attractor(period, 1 + 4 * len(build(scene.model).joints))
    times = look.times(scene) if period and "duration" not in keys else None
    sampled = times is not None and np.isin(times, scene.clock).all()  # by the samples; else each run is asked
    of_motion = partial(look.of_motions, times) if times is not None and sampled else None
    return replace(m, function=look, of_motion=of_motion, dims=((PART, look.size),))


def _statistic(series: str, statistic: str, run: RunRecord) -> float:
    """That of a series of a run; the largest and the least are between the samples too."""
    if statistic in EXTREMES and series != DRIFT:
        return extreme(run, series, EXTREMES[statistic])[statistic == "argmax"]
    return float(STATISTICS[statistic](run.t, run[series]))


def _statistic_of_motions(series: str, statistic: str, m: Motions) -> Array:
    """That of an angle of c motions, (c,). Raises KeyError for another series."""
    joint = {name: i for i, name in enumerate(m.models[0].joints)}[series]
    if statistic not in EXTREMES:
        return STATISTICS[statistic](m.t, m.q[..., joint])
    sign, one = EXTREMES[statistic], slice(joint, joint + 1)
    value, t = largest(m.t, sign * m.q[..., one], sign * m.v[..., one])
    return t if statistic == "argmax" else sign * value


def evaluate_measure(m: Measure, run: RunRecord, looser: RunRecord) -> Any:
    """A number or an array, of a run or of a run and a looser one. Raises RunError for a function that fails."""
    one, other = Trajectory.of(run), Trajectory.of(looser)
    try:
        value = m.function(one, other) if m.two else m.function(one)
        if isinstance(value, str):
            raise TypeError(f"it returns the text {shown(value)}, not a number")
        values = np.asarray(value, float)
        if values.shape != (shape := tuple(length for _, length in m.dims)):
            raise TypeError(f"its values are of shape {values.shape}, not {shape}")
        return values[()]
    except PendpinError:
        raise
    except Exception as error:  # of a function that the user gave
        raise RunError(f"{m.name}: {type(error).__name__}: {error}") from None


def _spread(of: Measure) -> Measure:
    if isinstance(of.function, Attractor):
        raise InputError(f"measure: {of.name}{SPREAD}: the numbers of attractors have no difference")
    if of.two:
        raise InputError(f"measure: {of.name}{SPREAD}: {of.name} is a comparison of two runs already")
    function, of_motion = of.function, of.of_motion
    difference = (lambda one, other: np.abs(one - other)) if of.between else _difference
    both = of_motion and (lambda one, other: difference(of_motion(one), of_motion(other)))
    pair = of.spread or (lambda one, other: float(_difference(np.array(function(one)), np.array(function(other)))))
    how = {"series": of.series, "between": of.between, "ends": of.ends}
    return Measure(of.name + SPREAD, of.unit, pair, True, of_motion=both, **how)


def _difference(one: Array, other: Array) -> Array:
    """|one - other| (c,); 0 where neither exists, inf where one does."""
    gap = np.abs(one - other)
    return np.where(np.isnan(one) & np.isnan(other), 0.0, np.where(np.isnan(gap), math.inf, gap))


def _mean(t: Array, x: Array) -> Array:
    """The mean over the times (n,) s of series x (..., n)."""
    return np.trapezoid(x, t, axis=-1) / (t[-1] - t[0]) if len(t) > 1 else x[..., 0]


STATISTICS: dict[str, Callable[[Array, Array], Array]] = {  # of the times (n,) and series (..., n)
    "max": lambda t, x: np.max(x, -1),
    "min": lambda t, x: np.min(x, -1),
    "final": lambda t, x: x[..., -1],
    "mean": _mean,
    "rms": lambda t, x: np.sqrt(_mean(t, x**2)),
    "argmax": lambda t, x: t[np.argmax(x, -1)],
}

EXTREMES = {"max": 1.0, "min": -1.0, "argmax": 1.0}  # statistics that are searched between the samples, and their sign

FAMILIES = (
    f"QUANTITY{choices(f'.{name}' for name in STATISTICS)}: of any quantity of a run, as in theta_1.max; .argmax is a time.",
    f"{ATTRACTOR}, {ATTRACTOR}(PERIOD): the number of what a motion settles at, seen once in a period in s or of the drive.",
    f"MEASURE{SPREAD}: its difference between the run and one 100 times looser, an estimate of its error.",
)


def measures_report() -> Report:
    """The measures by name, with their units and what each is."""
    head, every = ("measure", "unit", "what"), MEASURES.values()
    rows = [(m.name, m.unit, (m.function.__doc__ or "").partition("\n")[0]) for m in every]
    return Report((Table(head, rows), *FAMILIES), [dict(zip(head, row, strict=True)) for row in rows])


# --- measures of a whole run ----------------------------------------------------------------------------------------


def swing(run: Trajectory) -> float:
    """The largest angle of any rod, joint to tip, from hanging straight down, rad; NaN where none can swing."""
    model = model_of(run)
    if np.isnan(swings_at(model, run.q[:1])[0]):
        return math.nan
    plane = None if model.chain is None else _turns_in_plane(run.q[None], run.v[None])
    if plane and np.abs(plane[0]).max() >= np.pi:
        return math.pi
    return find_largest(resolve(run), lambda rows: swings_at(model, rows.q)[:, None])[0]


def _turns_in_plane(q: Array, v: Array) -> tuple[Array, Array] | None:
    """How far rods (c, n, rods) are from straight down, less whole turns at the start, and their rates; None in space."""
    for moving, still in ((THETA, PHI), (PHI, THETA)):
        if not (q[..., still].any() or v[..., still].any()):
            # the samples of a rod side by side in memory, as what follows looks along them: a third of the time
            turned, rates = (np.moveaxis(x[..., moving], -1, 1).copy("C") for x in (q, v))
            for rod in range(1, turned.shape[1]):
                turned[:, rod] += turned[:, rod - 1]
                rates[:, rod] += rates[:, rod - 1]
            turned -= 2 * np.pi * np.round(turned[..., :1] / (2 * np.pi))
            return np.moveaxis(turned, 1, -1), np.moveaxis(rates, 1, -1)
    return None


def _swing_of_motions(m: Motions) -> Array:
    """`swing` of each of c motions of a chain, (c,); NaN where samples do not tell it."""
    if m.models[0].chain is None:
        return np.full(len(m.q), np.nan)
    if plane := _turns_in_plane(m.q, m.v):  # the sums of its joints' angles, or it has passed over the top
        below = np.abs(plane[0]).max((1, 2)) < np.pi  # else it is over the top at a sample, no matter how far
        swings = np.full(len(m.q), np.pi)
        if below.any():
            swings[below] = np.minimum(largest(m.t, *(x[below] for x in plane), sizes=True)[0], np.pi)
        return swings
    turns = np.abs(m.v).sum(-1).max(1) * np.diff(m.t).max(initial=0.0)
    follows = np.asarray(~strays(np.diff(m.t)[:, None], m.q, m.v).any((1, 2)) & (turns < TURN))
    square = largest(m.t, *tilts_of_chain(m.q, m.v), follows=follows)[0]
    return np.where(square < BELOW, 2 * np.arcsin(np.sqrt(np.minimum(square, BELOW))), np.nan)


def period(run: Trajectory) -> float:
    """The mean time between two rises of the first joint's angle through 0, s; NaN with fewer than two."""
    rises = run.crossings(run.joints[0], level=0.0, direction=+1).t
    return float((rises[-1] - rises[0]) / (len(rises) - 1)) if len(rises) > 1 else math.nan


def energy_drift(run: Trajectory) -> float:
    """The largest change of the total energy over the energy exchanged; NaN where energy is not conserved."""
    return run.energy().drift if run.stats.conservative else math.nan


def settling_time(run: Trajectory) -> float:
    """The time from which all angles stay within 2 % of their largest distance from where they end, s.

    NaN for a motion that gets there only in the last tenth of the run: it may not settle.
    """
    return _settled(resolve(run))


def settling_time_spread(run: Trajectory, looser: Trajectory) -> float:
    """How far the settling time may be off, s: inf where it may not settle at all, 0 where it does not."""
    # A swing that just reaches, or just misses, the 2 % moves the settling time by half a period, however small the error.
    # So the distances, each of two angles, may be off by as much as both runs ever differ, and by the tolerance at least.
    more = resolve(run)
    apart = max(float(np.abs(more.run.q - looser.at(more.run.t).q).max()), run.stats.tolerance or 0.0)
    return _spread_of_instant(*(_settled(more, side * 2 * (1 + SETTLED) * apart) for side in (1.0, 0.0, -1.0)))


def _spread_of_instant(early: float, instant: float, late: float) -> float:
    """How far an instant may be off, in s: inf where there may be none, 0 where there is none."""
    if math.isnan(early):
        return 0.0
    return math.inf if math.isnan(late) else max(instant - early, late - instant, 0.0)


def _settled(more: Continuation, wider: float = 0.0) -> float:
    """The settling time of a run that is resolved, in s, where the 2 % are wider by so many rad."""
    run, end = more.run, more.run.q[-1]

    def away(rows: RunRecord) -> Array:
        return np.abs(rows.q - end).max(-1)

    size = find_largest(more, lambda rows: away(rows)[:, None])[0]
    level = SETTLED * size + wider
    if size and level <= 0:
        return math.nan
    last = Changes(*(x[-1:] for x in sign_changes(more, lambda rows: away(rows) - level, size)))
    time = float(find_instants(more, lambda rows: away(rows) - level, last).sum() - run.t[0]) if len(last.end) else 0.0
    return math.nan if time > UNSETTLED * (run.t[-1] - run.t[0]) else time


def flip_time(run: Trajectory) -> float:
    """The first time at which a rod passes over the top, s from the start; NaN if none does.

    A rod is over the top where the sum of the theta angles, or of the phi angles, from the support down to it passes an
    odd multiple of pi, either way.
    """
    return _first_passage(resolve(run), lambda t: np.zeros(len(t))) - float(run.t[0])


def flip_time_spread(run: Trajectory, looser: Trajectory) -> float:
    """How far the flip time may be off, s: inf where there may be one or none, 0 where there is none."""
    # The difference of two flip times may vanish by chance, and says nothing of a top that both runs just miss. So the sums
    # of angles may be off by as much as they have differed so far: a rod may be over the top as soon as it is so near, and
    # is there once it is so far beyond. They are off by the tolerance at least: the first steps of both runs are the same.
    more = resolve(run)
    t, other = more.run.t, looser.at(more.run.t)
    apart = more.run.q - other.q
    sums = np.stack([apart[:, places].sum(1) for places in accumulated(more.dynamics.model)])
    apart = np.maximum(np.maximum.accumulate(np.abs(sums).max(0)), run.stats.tolerance or 0.0)
    beyond = (lambda at, side=side: side * np.interp(at, t, apart) for side in (-1.0, 0.0, 1.0))
    return _spread_of_instant(*(_first_passage(more, each) for each in beyond))


def _first_passage(more: Continuation, beyond: Callable[[Array], Array]) -> float:
    """The first time in s at which a rod is `beyond` (k,) rad, of times (k,) in s, over the top; NaN if none ever is."""

    def short_of(places: list[int], rows: RunRecord) -> Array:
        half, side = rows.q[:, places].sum(1) / 2, math.copysign(1.0, math.cos(more.run.q[0, places].sum() / 2))
        return side * np.cos(half) + np.sin(np.clip(beyond(rows.t), -np.pi, np.pi) / 2)

    quantities = [partial(short_of, places) for places in accumulated(more.dynamics.model)]
    if min(quantity(samples_of(more.run, slice(0, 1)))[0] for quantity in quantities) <= 0:
        return float(more.run.t[0])
    return float(np.fmin.reduce(first_crossings(more, quantities)))


def accumulated(model: Model) -> list[list[int]]:
    """The places of the joints whose angles add up to that of each rod: theta_1, theta_1 + theta_2, ...; so for phi."""
    if not model.rods:
        return [[i] for i in range(len(model.joints))]
    parents, moved = model.tree.parents, {rod.last: rod for rod in model.rods}
    sums: list[list[int]] = []
    for axis in ("theta", "phi"):
        by_rod = dict[int, list[int]]()  # by the joint that moves it: those above it of this axis
        for rod in model.rods:
            above, own = parents[rod.first], getattr(rod, axis)
            while above not in (-1, *moved):  # a link of a URDF that is not a rod
                above = parents[above]
            by_rod[rod.last] = [*by_rod.get(above, []), *[own] * (own >= 0)]
            sums += [by_rod[rod.last]] * (own >= 0)
    return sums


def lyapunov(run: Trajectory) -> float:
    """The largest Lyapunov exponent over the run, 1/s: the mean rate at which a small difference grows.

    By pairs of runs (G. Benettin et al., Meccanica 15 (1980)). In each of PIECES parts of the time another run begins near
    this one. Its distance at the end, in rad and rad/s, made small again, is the start of the next.
    """
    scene, ends = scene_of(run), np.unique(np.linspace(0, len(run.t) - 1, PIECES + 1).astype(int))
    states = np.concatenate([run.q, run.v], 1)
    small = max(1e-7, math.sqrt(run.stats.tolerance or 0.0))
    apart_by, growth = np.full(states.shape[1], small / math.sqrt(states.shape[1])), 0.0
    for begin, end in pairwise(ends):
        q, v = np.split(states[begin] + apart_by, 2)
        start = Start.at_state(float(run.t[begin]), q, v)
        piece = scene.sampled(2, duration=float(run.t[end] - run.t[begin]))
        other = run_to_setting(piece.model_copy(update={"start": start}))
        apart_by = np.concatenate([other.q[-1], other.v[-1]]) - states[end]
        grown = float(np.linalg.norm(apart_by))
        growth += math.log(grown / small)
        apart_by *= small / grown
    return growth / float(run.t[-1] - run.t[0])


def divergence(run: Trajectory, looser: Trajectory) -> float:
    """The distance of the tips at the end between the run and one 100 times looser, over the largest tip distance."""
    if len(run.t) != len(looser.t):
        return math.inf
    return float(_tips_apart(run.tips[-1:], looser.tips[-1:])[0])


def _divergence_of_motions(motions: Motions, looser: Motions) -> Array:
    """`divergence` of each of the c runs, (c,)."""
    tips_of = lambda model, q: tips(model, poses(model, q))  # noqa: E731
    return _tips_apart(*(evaluate_each(tips_of, m.models, m.q[:, -1:])[:, 0] for m in (motions, looser)))


def _tips_apart(one: Array, other: Array) -> Array:
    """The largest distance (c,) of tips (c, rods, 3) m over the largest distance from W's origin."""
    size = np.linalg.norm(one, axis=-1).max(-1)
    return tip_distance(one, other, 1.0) / np.where(size > 0, size, 1.0)


def frequency_1(run: Trajectory) -> float:
    """The lowest natural frequency about the rest near the start, rad/s."""
    return float(small_motions(scene_of(run)).vibrations.omega[0])


def damping_1(run: Trajectory) -> float:
    """The damping ratio of the mode with the lowest natural frequency."""
    return float(small_motions(scene_of(run)).vibrations.damping_ratio[0])


def stable(run: Trajectory) -> float:
    """1 where the rest, or the driven periodic motion, near the start is stable, else 0."""
    return float(is_stable(scene_of(run)))


def multiplier(run: Trajectory) -> float:
    """The size of the largest multiplier of the driven periodic motion near the start."""
    return float(np.abs(periodic_orbit(scene_of(run)).multipliers).max())


_FLIPS: dict[str, Any] = {"of_motion": lambda m: m.flips, "without": "did not turn over", "ends": True}
MEASURES = {
    m.name: m
    for m in (
        Measure("swing", "rad", swing, of_motion=_swing_of_motions, between=True),
        Measure("period", "s", period, without="has no period"),
        Measure("energy_drift", "", energy_drift),
        Measure("settling_time", "s", settling_time, spread=settling_time_spread, without="did not settle"),
        Measure("flip_time", "s", flip_time, spread=flip_time_spread, **_FLIPS),
        Measure("lyapunov", "1/s", lyapunov),
        Measure("frequency_1", "rad/s", frequency_1),
        Measure("damping_1", "", damping_1),
        Measure("stable", "", stable),
        Measure("multiplier", "", multiplier),
        Measure("divergence", "", divergence, two=True, of_motion=_divergence_of_motions, ends=True),
    )
}
