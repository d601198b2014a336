"""Continues a run from any of its samples: to other times, beyond its end, and to samples that show how it moved.

Samples show how a run moved where positions follow from rates, and rates from accelerations. Elsewhere `resolve` takes more.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np

from pendpin.dynamics.acting import recall_outputs
from pendpin.errors import InputError, Interrupted, RunError, shown
from pendpin.ground.arguments import numbers, seconds
from pendpin.ground.arrays import Array, ArrayLike, Indices, Mask, subdivided
from pendpin.integrators import Run
from pendpin.integrators.fixed import NEAR, last_step_end
from pendpin.runs.integration import integrate_to_end
from pendpin.runs.preparation import Prepared
from pendpin.runs.run import fill_in, loop_of
from pendpin.scene import Scene, scene_of
from pendpin.trajectory import RunRecord, joined, samples_of

COUNTS = ("steps", "evaluations", "events", "seconds")  # of stats, that add up
NEAR_SAMPLE = 1e-9  # of the distance of samples
ALL = 1_000_000_000  # output times
SIDE, CLOSE = 1e-12, 8  # of an interval, and units in the last place of a time: a state so near an event is that at it
OFF = 0.1  # of what a joint moves in an interval or beside it: a sine in steps of a radian is integrated so well
STILL = 1e-9  # of what a joint moves in all: less is rounding
ROUNDING = 2.0**-46  # of the largest value
STEPS = 2  # parts that an interval is cut into, times the steps that the run took in it
PARTS, LEVELS = 4, 8  # into how many it is cut again, how often: a rod that passes its pole turns in any time
GROWN = 4  # times as many intervals as after the first cut: a passage of a pole has few at any level, rounding has ever more
MOST = 200_000  # samples after that
KEPT = 1_000_000  # positions in the pieces that are kept: searches for several extremes look at the same times
BESIDE = 1e-7  # of the run: how far before and behind an event a sample is taken, as rates jump in between
APART = 32  # and units in the last place of a time, at least: the points at which this is searched are apart


class Continuation:
    """A run's scene, ready to be integrated on from any of its samples by the run's own method and setting."""

    def __init__(self, run: RunRecord, scene: Scene | None = None) -> None:
        self.run, self.scene = run, scene or scene_of(run)
        prepared = Prepared.of(self.scene, bool(run.work))
        self.dynamics, self._loop = prepared.dynamics, loop_of(prepared, lambda t: None)
        recall_outputs(self.dynamics.sampled_torques, run, self.scene.duration, self.scene.start.time)
        self._loop.first_segment = ALL  # of a piece: the run has shown what they cost
        self._loop.begin(run.q[0], run.v[0])  # all pieces share the scales of the run
        self._kept = dict[bytes, Run]()  # pieces, by the end of their interval and their times

    @cached_property
    def sides_of_events(self) -> RunRecord:
        """The run just before and just behind each of its events."""
        events = np.unique([event.t for event in self.run.events if self.run.t[0] < event.t <= self.run.t[-1]])
        times = np.unique(np.concatenate([np.nextafter(events, -np.inf), events]))
        return self.at(times[times >= self.run.t[0]])

    def piece(self, sample: int, times: Array) -> Run:
        """The motion from a sample of the run at times (m,) in s since the scene's start, its own first. RunError."""
        self._loop.times = times
        piece = integrate_to_end(self._loop, self.run.q[sample], self.run.v[sample])
        if isinstance(piece.failure, Interrupted):
            raise KeyboardInterrupt  # a piece is a part of other work, which it ends
        if piece.failure is not None:
            raise RunError(f"from t = {self.run.t[sample]:.10g} s on: {piece.failure}", self.run)
        return piece

    def _piece_with_events(self, sample: int, t: Array) -> Run:
        """A piece at times (m,) up to the next sample, with every time on its side of each event of the run."""
        # A piece meets an event when the run met it, but for the error of both. At a time in between, which would be on the
        # wrong side, the state is taken just behind, or before, the event of the piece.
        begin, end = self.run.t[[sample, min(sample + 1, len(self.run.t) - 1)]]
        expected = [event for event in self.run.events if begin < event.t <= end]
        asked = times = since_start(self.scene, t)
        if not expected or len(t) == 1:
            return self.piece(sample, times)
        whole = np.concatenate([times, since_start(self.scene, end[None])]) if t[-1] < end else times
        piece = self.piece(sample, whole)
        margin = SIDE * (end - begin) + CLOSE * np.spacing(max(abs(times[0]), abs(times[-1])))
        for event, met in zip(expected, piece.happened, strict=False):
            if event[1:] != met[1:]:
                break  # another order of events: the piece is as likely as the run
            before = np.minimum(times, max(met.t - margin, times[0]))
            times = np.where(t >= event.t, np.maximum(times, met.t + margin), before)
        if (times != asked).any():
            piece = self.piece(sample, np.maximum.accumulate([*times, *whole[len(times) :]]))
        arrays = {name: getattr(piece, name)[: len(asked)] for name in ("q", "v", "work", "torque")}
        return replace(piece, t=asked, **arrays)

    def at(self, t: Array) -> RunRecord:
        """The run at times (m,) inside it, rising."""
        before = np.searchsorted(self.run.t, t, side="right") - 1
        first = np.flatnonzero(np.diff(before, prepend=-1))  # of the times after each sample
        pieces, places, count = [], list[Array](), 0
        for sample, due in zip(before[first], np.split(t, first[1:]), strict=True):
            begin, end = self.run.t[[sample, min(sample + 1, len(self.run.t) - 1)]]
            times = np.concatenate([[begin], due[due > begin]])
            key = np.append(times, end).tobytes()
            piece = self._kept.get(key) or self._piece_with_events(sample, times)
            if len(self._kept) * piece.q.size < KEPT:
                self._kept[key] = piece
            pieces.append(piece)
            places.append(count + np.arange(len(due)) + (due[0] > begin))
            count += len(pieces[-1].t)
        rows = samples_of(self.fill_pieces(pieces, before[first]), np.concatenate(places))
        stats = replace(self.run.stats, **{name: sum(getattr(piece, name) for piece in pieces) for name in COUNTS})
        return self.run.of(replace(rows, t=t, stats=stats, events=self.run.events))

    def fill_pieces(self, pieces: list[Run], samples: ArrayLike) -> RunRecord:
        """All rows of k pieces from `samples` (k,) of the run, with what is derived; the events of the first."""
        arrays = {name: np.concatenate([getattr(piece, name) for piece in pieces]) for name in ("t", "q", "v", "work")}
        torques = [piece.torque for piece in pieces if piece.torque is not None]
        torque = np.concatenate(torques) if torques else None
        rows = fill_in(self.scene, self.dynamics, self._loop.balance, replace(pieces[0], **arrays, torque=torque))
        lengths = [len(piece.t) for piece in pieces]
        starts, places = np.repeat(np.cumsum([0, *lengths[:-1]]), lengths), np.repeat(samples, lengths)
        work = {kind: w - w[starts] + self.run.work[kind][places] for kind, w in rows.work.items()}
        return replace(rows, t=arrays["t"], work=work)


def since_start(scene: Scene, t: Array) -> Array:
    """Times (n,) of a scene in s since its start; of samples exactly, as beside a late start their times are rounded."""
    place = np.minimum(np.searchsorted(scene.clock, t), len(scene.clock) - 1)
    return np.where(scene.clock[place] == t, scene.times[place], t - scene.start.time)


def at(run: RunRecord, times: ArrayLike) -> RunRecord:
    """The run at any times within it, integrated to there from the samples before (Trajectory.at)."""
    t = np.atleast_1d(numbers("times", times, finite=True))
    if t.ndim != 1 or not len(t) or (np.diff(t) <= 0).any():
        raise InputError(f"times: {shown(times)} are not numbers in rising order, at least one")
    for moment in t[[0, -1]]:
        if not run.t[0] <= moment <= run.t[-1]:
            raise InputError(f"times: {moment:.15g} s is outside the run, {run.t[0]:.15g} to {run.t[-1]:.15g} s")
    return Continuation(run).at(t)


def extend(run: RunRecord, duration: float) -> RunRecord:
    """The run and its continuation for `duration` s (Trajectory.extend)."""
    duration = seconds("duration", duration, lasting=True)
    scene = scene_of(run)
    done = since_start(scene, run.t)
    total, samples, even = scene.duration + float(duration), scene.solver.samples, scene.solver.times is None
    if even and (samples is None or scene.duration == 0):  # the start alone has no density
        scene = scene.replace({"solver.samples": None}, duration=total)
    elif samples and even and abs((count := (samples - 1) * total / scene.duration) % 1 - 0.5) > 0.5 - NEAR_SAMPLE:
        scene = scene.replace({"solver.samples": round(count) + 1}, duration=total)
    else:  # samples as dense as they are
        old, end = scene.clock, scene.start.time + scene.duration
        spacing = scene.duration / max(1, len(old) - 1)
        new = end + duration * np.arange(1, (count := max(1, round(duration / spacing) if spacing else 1)) + 1) / count
        times = (*old.tolist(), *(new if new[0] > old[-1] else new[1:]).tolist())
        total = max(total, times[-1] - scene.start.time)
        scene = scene.replace({"solver.samples": None, "solver.times": times}, duration=total)
    ahead = np.flatnonzero(scene.clock > run.t[-1] + NEAR_SAMPLE * (scene.clock[-1] - run.t[-1]))
    more, step = Continuation(run, scene), scene.solver.step
    last = len(done) - 1 if step is None else last_step_end(done, step)  # inside a step it would not go on as one run
    piece = more.piece(last, np.concatenate([done[last:], scene.times[ahead]]))
    new = samples_of(more.fill_pieces([piece], [last]), slice(len(done) - last, None))
    new = replace(new, t=scene.clock[ahead])
    counts = {name: getattr(run.stats, name) + getattr(piece, name) for name in COUNTS}
    stats = replace(run.stats, stopped=None, **counts)
    return replace(joined([run, new]), stats=stats, scene=scene.recorded(), source=scene)


# --- samples that show how a run moved ------------------------------------------------------------------------------


def resolve(run: RunRecord) -> Continuation:
    """The run, with more samples where its own do not show how it moved. InputError if these would be too many."""
    dense = STEPS * run.stats.steps / max(len(run.t) - 1, 1)  # parts of a whole interval between samples
    most = np.inf
    events, margin = times_of_events(run), margin_of_events(run)  # samples just before and behind them
    events = events[np.isin(_intervals_of(run, events), find_coarse(run))]
    beside = np.clip(np.concatenate([events - margin, events + margin]), run.t[0], run.t[-1])
    more = Continuation(run)
    _add_samples(more, beside)
    for _ in range(LEVELS):
        if not 0 < len(coarse := find_coarse(more.run)) <= most:
            break
        most = np.inf if dense else min(most, GROWN * len(coarse))
        shares = np.diff(more.run.t)[coarse] / np.diff(run.t)[_intervals_of(run, more.run.t[coarse])]
        parts = np.maximum(PARTS, np.ceil(dense * shares)).astype(int)
        if len(more.run.t) + parts.sum() > MOST:
            few = f"{len(run.t)} samples are too few for a run of {run.stats.steps} steps"
            raise InputError(f"crossings: {few}; run it with samples = {run.stats.steps}")
        cuts = np.ones(len(more.run.t) - 1, int)
        cuts[coarse] = parts
        _add_samples(more, subdivided(more.run.t, cuts))
        dense = 0.0
    return more


def _add_samples(more: Continuation, times: Array) -> None:
    """Give the run samples at some times (k,) as well."""
    run = more.run
    if (step := more.scene.solver.step) is not None:
        # At the ends of steps, counted from its samples: steps begin anew at a sample, and would change behind it.
        before = _intervals_of(run, times)
        begin, left = run.t[before], run.t[before + 1] - times
        steps = np.floor((times - begin) / step + NEAR)
        times = np.where(left > NEAR * step, begin + steps * step, times)
    times = np.setdiff1d(times, run.t)
    if len(times):
        whole = joined([run, more.at(times)])
        more.run = replace(samples_of(whole, np.argsort(whole.t, kind="stable")), events=run.events)


def _intervals_of(run: RunRecord, t: Array) -> Indices:
    """The intervals (k,) between samples in which times (k,) are."""
    return np.clip(np.searchsorted(run.t, t, "right") - 1, 0, max(len(run.t) - 2, 0))


def times_of_events(run: RunRecord) -> Array:
    """The times (k,) of the events of a run, s."""
    return np.array([event.t for event in run.events])


def margin_of_events(run: RunRecord) -> float:
    """How far before and behind an event of a run a sample is taken, s."""
    return max(BESIDE * float(run.t[-1] - run.t[0]), APART * float(np.spacing(np.abs(run.t[[0, -1]]).max())))


def find_coarse(run: RunRecord) -> Indices:
    """The intervals (k,), but for those of events, in which q or v do not follow from their rates at both ends."""
    if len(run.t) == 1:  # which may have events: of a run that was stopped before its second sample
        return np.arange(0)
    dt, coarse = np.diff(run.t)[:, None], np.zeros(len(run.t) - 1, bool)
    # A rate that moves no position by more than its rounding is rounding itself, as in a run at rest.
    with np.errstate(over="ignore"):  # infinite where the interval is 5e-324 s
        least = ROUNDING * np.abs(run.q).max(initial=0.0) / dt
    for x, rate, floor in ((run.q, run.v, 0.0), (run.v, run.a, least)):
        coarse |= strays(dt, x, rate, floor).any(1)
    closed = _intervals_of(run, times_of_events(run))
    closed = closed[dt[closed, 0] <= 3 * margin_of_events(run)]
    coarse[closed] = False
    return np.flatnonzero(coarse)


def strays(dt: Array, x: Array, rate: Array, floor: Array | float = 0.0) -> Mask:
    """The intervals (..., n - 1, m) of dt (n - 1, 1) s in which values (..., n, m) stray from their rates."""
    off = x[..., 1:, :] - x[..., :-1, :]  # in place, as a sweep waits for this
    off -= dt / 2 * (rate[..., 1:, :] + rate[..., :-1, :])
    off, speed = np.abs(off, out=off), np.abs(rate)
    path = np.maximum(speed[..., 1:, :], speed[..., :-1, :])
    path *= dt
    most = path.copy("K")
    np.maximum(most[..., 1:, :], path[..., :-1, :], out=most[..., 1:, :])
    np.maximum(most[..., :-1, :], path[..., 1:, :], out=most[..., :-1, :])
    most *= OFF
    top, bottom = x.max(-2, keepdims=True, initial=-np.inf), x.min(-2, keepdims=True, initial=np.inf)
    largest = np.maximum(top, -bottom).max(-1, keepdims=True, initial=0.0)
    return off > most + (STILL * (top - bottom) + ROUNDING * largest) + floor
