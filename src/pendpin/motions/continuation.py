"""Continues a run from any of its samples: to other times, and beyond its end."""

from copy import copy
from dataclasses import replace
from functools import cached_property

import numpy as np

from pendpin.dynamics.acting import recall_outputs
from pendpin.errors import InputError, RunError, is_number, shown
from pendpin.ground.arrays import Array, ArrayLike
from pendpin.integrators import Run
from pendpin.runs.integration import integrate_to_end
from pendpin.runs.preparation import Prepared
from pendpin.runs.run import fill_in, loop_of
from pendpin.scene import Scene, scene_of
from pendpin.trajectory import RunRecord, joined, samples_of

COUNTS = ("steps", "evaluations", "events", "seconds")  # of stats, that add up
ROUNDING = 1e-9  # of the distance of samples
ALL = 1_000_000_000  # output times
SIDE, CLOSE = 1e-12, 8  # of an interval, and units in the last place of a time: a state so near an event is that at it


class Continuation:
    """A run's scene, ready to be integrated on from any of its samples by the run's own method and setting."""

    def __init__(self, run: RunRecord, scene: Scene | None = None) -> None:
        self.run, self.scene = run, scene or scene_of(run)
        prepared = Prepared.of(self.scene, bool(run.work))
        self.dynamics, self._loop = prepared.dynamics, loop_of(prepared, lambda t: None)
        recall_outputs(self.dynamics.sampled_torques, run, self.scene.duration, self.scene.start.time)
        self._loop.first_segment = ALL  # of a piece: the run has shown what they cost
        self._loop.begin(run.q[0], run.v[0])  # all pieces share the scales of the run

    def beside(self, run: RunRecord) -> "Continuation":
        """The same, from other samples of the run."""
        other = copy(self)
        other.run = run
        vars(other).pop("sides_of_events", None)
        return other

    @cached_property
    def sides_of_events(self) -> RunRecord:
        """The run just before and just behind each of its events."""
        events = np.unique([event.t for event in self.run.events if self.run.t[0] < event.t <= self.run.t[-1]])
        times = np.unique(np.concatenate([np.nextafter(events, -np.inf), events]))
        return self.at(times[times >= self.run.t[0]])

    def piece(self, sample: int, times: Array) -> Run:
        """The motion from a sample of the run, at times (m,) in s since the scene's start, the sample's own first.

        Raises RunError where it cannot be integrated.
        """
        self._loop.times = times
        piece = integrate_to_end(self._loop, self.run.q[sample], self.run.v[sample], None)
        if piece.failure is not None:
            raise RunError(f"from t = {self.run.t[sample]:.10g} s on: {piece.failure}", self.run)
        return piece

    def _piece_with_events(self, sample: int, t: Array) -> Run:
        """A piece at times (m,) up to the next sample, with every time on the side of each event on which it is in the run.

        A piece meets an event when the run met it, but for the error of both. A time in between would be on the wrong side,
        as the instant of the event itself often is: the state there is taken just behind, or before, the event of the piece.
        """
        begin, end = self.run.t[[sample, min(sample + 1, len(self.run.t) - 1)]]
        expected = [event for event in self.run.events if begin < event.t <= end]
        start = self.scene.start.time
        asked = times = t - start
        if not expected or len(t) == 1:
            return self.piece(sample, times)
        whole = np.concatenate([times, [end - start]]) if t[-1] < end else times
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
            begin = self.run.t[sample]
            pieces.append(self._piece_with_events(sample, np.concatenate([[begin], due[due > begin]])))
            places.append(count + np.arange(len(due)) + (due[0] > begin))
            count += len(pieces[-1].t)
        rows = samples_of(self.fill_pieces(pieces, before[first]), np.concatenate(places))
        counts = {name: sum(getattr(piece, name) for piece in pieces) for name in COUNTS}
        stats = replace(self.run.stats, **counts)
        return self.run.of(replace(rows, t=t, stats=stats, events=self.run.events))

    def fill_pieces(self, pieces: list[Run], samples: ArrayLike) -> RunRecord:
        """All rows of k pieces, with accelerations, wrenches and energies, and the events of the first.

        Each begins at one of `samples` (k,) of the run. t is counted from the scene's start, the work from those samples.
        """
        arrays = {name: np.concatenate([getattr(piece, name) for piece in pieces]) for name in ("t", "q", "v", "work")}
        torques = [piece.torque for piece in pieces if piece.torque is not None]
        torque = np.concatenate(torques) if torques else None
        rows = fill_in(self.scene, self.dynamics, self._loop.balance, replace(pieces[0], **arrays, torque=torque))
        lengths = [len(piece.t) for piece in pieces]
        starts, places = np.repeat(np.cumsum([0, *lengths[:-1]]), lengths), np.repeat(samples, lengths)
        work = {kind: w - w[starts] + self.run.work[kind][places] for kind, w in rows.work.items()}
        return replace(rows, t=arrays["t"], work=work)


def at(run: RunRecord, times: ArrayLike) -> RunRecord:
    """The run at any times within it, integrated to there from the samples before (Trajectory.at)."""
    try:
        t = np.atleast_1d(np.asarray(times, float))
    except (TypeError, ValueError):
        raise InputError(f"times: {shown(times)} are not numbers") from None
    if t.ndim != 1 or not len(t) or not np.isfinite(t).all() or (np.diff(t) <= 0).any():
        raise InputError(f"times: {shown(times)} are not finite numbers in rising order, at least one")
    for moment in t[[0, -1]]:
        if not run.t[0] <= moment <= run.t[-1]:
            raise InputError(f"times: {moment:.15g} s is outside the run, {run.t[0]:.15g} to {run.t[-1]:.15g} s")
    return Continuation(run).at(t)


def extend(run: RunRecord, duration: float) -> RunRecord:
    """The run and its continuation for `duration` s (Trajectory.extend)."""
    if not is_number(duration) or not 0 < duration < np.inf:
        raise InputError(f"duration: {shown(duration)} is not a number of seconds above 0")
    scene, last = _longer(run, float(duration)), len(run.t) - 1
    ahead = np.flatnonzero(scene.clock > run.t[-1] + ROUNDING * (scene.clock[-1] - run.t[-1]))
    more = Continuation(run, scene)
    piece = more.piece(last, np.concatenate([[run.t[-1] - scene.start.time], scene.times[ahead]]))
    new = replace(samples_of(more.fill_pieces([piece], [last]), slice(1, None)), t=scene.clock[ahead])
    counts = {name: getattr(run.stats, name) + getattr(piece, name) for name in COUNTS}
    stats = replace(run.stats, stopped=None, **counts)
    return replace(joined([run, new]), stats=stats, scene=scene.recorded(), source=scene)


def _longer(run: RunRecord, duration: float) -> Scene:
    """The run's scene with a longer duration, and samples as dense as they are."""
    scene = scene_of(run)
    total, samples = scene.duration + duration, scene.solver.samples
    if scene.solver.times is None and (samples is None or scene.duration == 0):  # the start alone has no density
        return scene.replace({"solver.samples": None}, duration=total)
    count = (samples or 1) - 1
    if scene.solver.times is None and abs(count * total / scene.duration % 1 - 0.5) > 0.5 - ROUNDING:
        return scene.replace({"solver.samples": round(count * total / scene.duration) + 1}, duration=total)
    old, end = scene.clock, scene.start.time + scene.duration
    spacing = scene.duration / max(1, len(old) - 1)
    new = end + duration * np.arange(1, (count := max(1, round(duration / spacing) if spacing else 1)) + 1) / count
    times = (*old.tolist(), *(new if new[0] > old[-1] else new[1:]).tolist())
    return scene.replace(
        {"solver.samples": None, "solver.times": times}, duration=max(total, times[-1] - scene.start.time)
    )
