"""Where a quantity of a run crosses a level: found among the samples, then integrated to the instant."""

from dataclasses import replace

import numpy as np
from scipy.optimize import root_scalar

from pendpin.arrays import Array, Indices
from pendpin.errors import InputError, shown
from pendpin.simulation.continuation import Continuation
from pendpin.trajectory import Trajectory, samples_of

JUMP = 1e-3  # of the offsets around it: what is still on the other side has not crossed but jumps
AFTER = 1e-13  # of the times: how far behind a jump the state is taken
SHARES = np.arange(1, 8) / 8  # of an interval: where the quantity is looked at
LEVELS = 5  # of looks, each 8 times as close as the last
OFF = 0.1  # of what a joint moves in all: samples that explain each other so well are dense
EPS = float(np.finfo(float).eps)
STEPS = 2.0  # looks to a step of a run whose samples are not
FEWEST = 2  # looks between two samples that are worth it
MOST = 200_000  # looks at a run with few samples


def crossings(run: Trajectory, name: str, level: float, direction: int) -> Trajectory:
    """As `Trajectory.crossings`."""
    if isinstance(level, bool) or not isinstance(level, int | float) or not np.isfinite(level):
        raise InputError(f"level: {shown(level)} is not a finite number")
    if direction not in {-1, 0, 1}:
        raise InputError(f"direction: {shown(direction)} is not 1 (upwards), -1 (downwards) or 0 (both)")
    more = Continuation(_with_more_samples(run))
    times, offset = _looked_at(more, name, level, more.run[name] - level)
    signs = _signs(offset)
    changed = np.flatnonzero(signs[1:] * signs[:-1] < 0)
    chosen = [i for i in changed if direction in {0, int(signs[i + 1])}]
    instants = np.unique([_instant(more, name, level, times[i : i + 2], offset[i : i + 2]) for i in chosen])
    if not len(instants):
        return replace(samples_of(run, slice(0, 0)), stats=replace(run.stats, steps=0, evaluations=0, events=0))
    return more.at(instants)


def _with_more_samples(run: Trajectory) -> Trajectory:
    """The run; if its samples do not tell where it went between them, with samples at half its steps.

    Raises InputError if these would be too many.
    """
    intervals = len(run.t) - 1
    looks = int(np.ceil(STEPS * run.stats.steps / max(intervals, 1)))
    if looks < FEWEST or _dense(run):
        return run
    if looks * intervals > MOST:
        raise InputError(
            f"crossings: {len(run.t)} samples are too few for a run of {run.stats.steps} steps; "
            f"run it with samples = {run.stats.steps}"
        )
    shares = np.arange(looks) / looks
    between = (run.t[:-1, None] + shares * np.diff(run.t)[:, None]).reshape(-1)
    return Continuation(run).at(np.unique(np.append(between, run.t[-1])))


def _dense(run: Trajectory) -> bool:
    """Whether the samples show the motion between them: no joint goes further there than it goes in all.

    And positions follow from the rates at the samples, and rates from accelerations, within a tenth of that.
    """
    dt = np.diff(run.t)[:, None]
    for x, rate in ((run.q, run.v), (run.v, run.a)):
        size = np.maximum(np.ptp(x, 0), EPS * np.abs(x).max())
        off = np.abs(np.diff(x, axis=0) - dt * (rate[1:] + rate[:-1]) / 2)
        if (dt * np.abs(rate).max(0) > size).any() or (off > OFF * size).any():
            return False
    return True


def _looked_at(more: Continuation, name: str, level: float, offset: Array) -> tuple[Array, Array]:
    """Times and offsets (m,): the samples, and places between those, closer and closer to where it turns back near 0."""
    times = more.run.t
    for _ in range(LEVELS):
        places = _turns_near(offset)
        if not len(places):
            break
        between = np.unique(times[places, None] + SHARES * (times[places + 1] - times[places])[:, None])
        together = np.concatenate([times, between])
        order = np.argsort(together, kind="stable")
        times, offset = together[order], np.concatenate([offset, more.at(between)[name] - level])[order]
    return times, offset


def _turns_near(offset: Array) -> Indices:
    """Intervals (k,) beside a local minimum of |offset| (n,) that is close to 0, with one sign on both sides."""
    before, size, after = np.abs(offset[:-2]), np.abs(offset[1:-1]), np.abs(offset[2:])
    same = (offset[1:-1] * offset[:-2] > 0) & (offset[1:-1] * offset[2:] > 0)
    near = size <= np.maximum(before, after) - size
    turns = np.flatnonzero(same & near & (size <= before) & (size <= after)) + 1
    return np.unique(np.concatenate([turns - 1, turns]).astype(np.intp))


def _signs(offset: Array) -> Array:
    """Signs (n,); a sample on the level counts to the side that the quantity comes from."""
    signs = np.sign(offset)
    for i in np.flatnonzero(signs == 0):
        signs[i] = signs[i - 1] if i else 0.0
    return signs


def _instant(more: Continuation, name: str, level: float, bracket: Array, offset: Array) -> float:
    """The instant of the one crossing in a bracket of times (2,): of a jump, the instant after it."""
    after = np.sign(offset[1])

    def value(t: float) -> float:
        return float(more.at(np.array([t]))[name][0] - level)

    begin, end = bracket
    if offset[0] == 0:
        return float(begin)
    instant = float(root_scalar(value, bracket=(begin, end), method="brentq", xtol=1e-15 * max(1.0, abs(end))).root)
    off = value(instant)
    jumped = off * after < 0 and abs(off) > JUMP * np.abs(offset).max()
    return min(float(end), instant + AFTER * max(float(end - begin), abs(instant))) if jumped else instant
