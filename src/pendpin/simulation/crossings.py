"""Where a quantity of a run crosses a level: found among the samples, then integrated to the instant."""

from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from pendpin.arrays import Array, Indices
from pendpin.errors import InputError, shown
from pendpin.integrators.events import AT_ONCE
from pendpin.simulation.continuation import Continuation
from pendpin.trajectory import Trajectory, samples_of

LOOKS = 8  # places between two samples at which the quantity is looked at, where it may cross twice


def crossings(run: Trajectory, name: str, level: float, direction: int) -> Trajectory:
    """As `Trajectory.crossings`."""
    if isinstance(level, bool) or not isinstance(level, int | float) or not np.isfinite(level):
        raise InputError(f"level: {shown(level)} is not a finite number")
    if direction not in {-1, 0, 1}:
        raise InputError(f"direction: {shown(direction)} is not 1 (upwards), -1 (downwards) or 0 (both)")
    offset = run[name] - level
    more = Continuation(run)
    times, offset = _looked_at(more, name, level, offset)
    signs = _signs(offset)
    changed = np.flatnonzero(signs[1:] * signs[:-1] < 0)
    chosen = [i for i in changed if direction in {0, int(signs[i + 1])}]
    instants = np.unique([_instant(more, name, level, times[i : i + 2], offset[i : i + 2]) for i in chosen])
    if not len(instants):
        return replace(samples_of(run, slice(0, 0)), stats=replace(run.stats, steps=0, evaluations=0, events=0))
    return more.at(instants)


def _looked_at(more: Continuation, name: str, level: float, offset: Array) -> tuple[Array, Array]:
    """Times and offsets (m,): the samples, and places between those where the quantity turns back near the level."""
    run, places = more.run, _turns_near(offset)
    if not len(places):
        return run.t, offset
    share = np.arange(1, LOOKS) / LOOKS
    between = np.unique((run.t[places, None] + share * (run.t[places + 1] - run.t[places])[:, None]).ravel())
    times = np.concatenate([run.t, between])
    values = np.concatenate([offset, more.at(between)[name] - level])
    order = np.argsort(times, kind="stable")
    return times[order], values[order]


def _turns_near(offset: Array) -> Indices:
    """Intervals beside a sample that is nearest to the level among its neighbours, on one side of it, and not far."""
    size = np.abs(offset)
    same = (offset[1:-1] * offset[:-2] > 0) & (offset[1:-1] * offset[2:] > 0)
    near = size[1:-1] <= np.maximum(size[:-2], size[2:]) - size[1:-1]
    least = (size[1:-1] <= size[:-2]) & (size[1:-1] <= size[2:])
    turns = np.flatnonzero(same & near & least) + 1
    ends = [i for i in (0, len(offset) - 2) if len(offset) > 1]
    return np.unique(np.concatenate([turns - 1, turns, ends]).astype(np.intp))


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
    instant = brentq(value, begin, end, xtol=1e-15 * max(1.0, abs(end)), rtol=1e-15)
    jumped = value(instant) * after < 0 and abs(value(instant)) > JUMP * np.abs(offset).max()
    return float(min(end, instant + AT_ONCE * max(1.0, abs(instant)))) if jumped else float(instant)


JUMP = 1e-3  # of the offsets around it: what is still on the other side has not crossed but jumped
