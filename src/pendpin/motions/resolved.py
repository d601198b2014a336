"""A run with samples so close that they show how it moved between them.

They do if positions follow from rates and rates from accelerations; where they do not, there are more.
"""

from dataclasses import replace

import numpy as np

from pendpin.errors import InputError
from pendpin.ground.arrays import Array, Indices, Mask, subdivided
from pendpin.integrators.fixed import NEAR
from pendpin.motions.continuation import Continuation
from pendpin.trajectory import RunRecord, joined, samples_of

OFF = 0.1  # of what a joint moves in an interval or beside it: a sine in steps of a radian is integrated so well
STILL = 1e-9  # of what a joint moves in all: less is rounding
ROUNDING = 2.0**-46  # of the largest value
STEPS = 2  # parts that an interval is cut into, times the steps that the run took in it
PARTS, LEVELS = 4, 8  # into how many it is cut again, how often: a rod that passes its pole turns in any time
GROWN = 4  # times as many intervals as after the first cut: a passage of a pole has few at any level, rounding has ever more
MOST = 200_000  # samples after that
BESIDE = 1e-7  # of the run: how far before and behind an event a sample is taken, as rates jump in between


def resolved(run: RunRecord) -> Continuation:
    """The run; where its samples do not tell how it moved between them, with more.

    Raises InputError if these would be too many.
    """
    dense = STEPS * run.stats.steps / max(len(run.t) - 1, 1)  # parts of a whole interval between samples
    most = np.inf
    more = _sampled_too(Continuation(run), _beside_events(run, find_coarse(run)))
    for _ in range(LEVELS):
        if not 0 < len(coarse := find_coarse(more.run)) <= most:
            break
        most = np.inf if dense else min(most, GROWN * len(coarse))
        shares = np.diff(more.run.t)[coarse] / np.diff(run.t)[_intervals_of(run, more.run.t[coarse])]
        parts = np.maximum(PARTS, np.ceil(dense * shares)).astype(int)
        if len(more.run.t) + parts.sum() > MOST:
            raise InputError(
                f"crossings: {len(run.t)} samples are too few for a run of {run.stats.steps} steps; "
                f"run it with samples = {run.stats.steps}"
            )
        cuts = np.ones(len(more.run.t) - 1, int)
        cuts[coarse] = parts
        more, dense = _sampled_too(more, subdivided(more.run.t, cuts)), 0.0
    return more


def _sampled_too(more: Continuation, times: Array) -> Continuation:
    """The run with samples at some times (k,) as well."""
    run, times = more.run, np.setdiff1d(_where_steps_end(more, times), more.run.t)
    if not len(times):
        return more
    whole = joined([run, more.at(times)])
    return more.beside(replace(samples_of(whole, np.argsort(whole.t, kind="stable")), events=run.events))


def _where_steps_end(more: Continuation, times: Array) -> Array:
    """The times (k,), of a run with a fixed step the ends of steps before them, counted from its samples.

    Steps begin anew at a sample: inside a step it would change the motion behind it.
    """
    if (step := more.scene.solver.step) is None:
        return times
    before = _intervals_of(more.run, times)
    begin, left = more.run.t[before], more.run.t[before + 1] - times
    steps = np.floor((times - begin) / step + NEAR)
    return np.where(left > NEAR * step, begin + steps * step, times)


def _intervals_of(run: RunRecord, t: Array) -> Indices:
    """The intervals (k,) between samples in which times (k,) are."""
    return np.clip(np.searchsorted(run.t, t, "right") - 1, 0, max(len(run.t) - 2, 0))


def times_of_events(run: RunRecord) -> Array:
    """The times (k,) of its events, rising."""
    return np.array([event.t for event in run.events])


def _beside_events(run: RunRecord, intervals: Indices) -> Array:
    """Times (2 k,) just before and behind the k events in some intervals."""
    at = times_of_events(run)
    at = at[np.isin(_intervals_of(run, at), intervals)]
    margin = BESIDE * (run.t[-1] - run.t[0])
    return np.clip(np.concatenate([at - margin, at + margin]), run.t[0], run.t[-1])


def find_coarse(run: RunRecord) -> Indices:
    """The intervals (k,) in which a position does not follow from the rates at both ends, or a rate from accelerations.

    Not those of an event, where they jump.
    """
    if len(run.t) == 1:  # which may have events: of a run that was stopped before its second sample
        return np.arange(0)
    dt, coarse = np.diff(run.t)[:, None], np.zeros(len(run.t) - 1, bool)
    # A rate that moves no position by more than its rounding is rounding itself, as in a run at rest.
    with np.errstate(over="ignore"):  # infinite where the interval is 5e-324 s
        least = ROUNDING * np.abs(run.q).max(initial=0.0) / dt
    for x, rate, floor in ((run.q, run.v, 0.0), (run.v, run.a, least)):
        coarse |= strays(dt, x, rate, floor).any(1)
    closed = _intervals_of(run, times_of_events(run))
    closed = closed[dt[closed, 0] <= 3 * BESIDE * (run.t[-1] - run.t[0])]
    coarse[closed] = False
    return np.flatnonzero(coarse)


def strays(dt: Array, x: Array, rate: Array, floor: Array | float = 0.0) -> Mask:
    """The intervals (..., n - 1, m), of dt (n - 1, 1) s, in which values (..., n, m) do not follow from their rates.

    Differences up to a floor (n - 1, 1) are rounding, and so are those up to `ROUNDING` and `STILL`.
    """
    off = np.abs(np.diff(x, axis=-2) - dt * (rate[..., 1:, :] + rate[..., :-1, :]) / 2)
    path = dt * np.maximum(np.abs(rate[..., 1:, :]), np.abs(rate[..., :-1, :]))
    beside = np.concatenate([path[..., :1, :], path, path[..., -1:, :]], -2)
    path = np.maximum(path, np.maximum(beside[..., :-2, :], beside[..., 2:, :]))
    moved, largest = np.ptp(x, -2, keepdims=True), np.abs(x).max((-2, -1), initial=0.0, keepdims=True)
    return off > OFF * path + STILL * moved + ROUNDING * largest + floor
