"""Batches: many runs of scenes of one structure, as arrays, side by side in the processor's vectors.

Starts and numbers go in, states come out, in pieces: for `simulate_many`, for sweeps and for sections. Cases of a structure
differ in starts and in the numbers of models and effects: run-time parameters of one set of Taylor series, compiled
once. What a case gives does not depend on its neighbours in the vector.
"""

import math
import time
from collections.abc import Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass
from threading import Event, Lock
from typing import Any, NamedTuple

import numpy as np

from pendpin.dynamics.acting import acting
from pendpin.dynamics.compiling import EquationsOfMotion, drop_zeros
from pendpin.dynamics.dynamics import Dynamics
from pendpin.dynamics.pace import paces_of
from pendpin.engines import Engine, Moving
from pendpin.ground.arrays import Array, Indices, Mask, subdivided
from pendpin.ground.libraries import heyoka, wait_for
from pendpin.ground.records import LARGEST
from pendpin.integrators import taylor_takes
from pendpin.integrators.taylor import COMPENSATED, LONGEST_STEP, SMALL, expressions, run_time_parameters
from pendpin.model.build import Model, build, start_state
from pendpin.runs.run import OFF
from pendpin.scene import Scene
from pendpin.trajectory import exchanged
from pendpin.trajectory.parts import ROUNDING

WIDTH = 16  # cases side by side, the same on every machine: two vectors hide the time that an instruction takes
AT_ONCE = 512  # cases whose samples are in memory at once
MOST_STATES = 200_000  # of a case, and of a piece: it bounds the memory of a worker
MOST_JOINTS = 10  # up to which series are compiled for a batch: five rods compile in 2 s and run ten times as fast
NARROW = 8  # cases side by side for up to SMALL joints: one rod is then 10 % faster, two rods are 10 to 60 % slower
SAMPLES_AT_ONCE = 256  # between two chances to stop
STEPS_AT_ONCE = 65_536  # in so many samples, at most

Sums = Sequence[Sequence[int]]  # places of joints whose angles are added
Level = tuple[int, float, int]  # joint, angle in rad of any turn, and direction: 1 rising, -1 falling, 0 both


def takes(scene: Scene) -> bool:
    """Whether motions of a scene can be run as a batch: smooth, of few joints, by a method that may be Taylor series."""
    named = scene.solver.method in ("auto", "taylor")
    return named and scene.duration > 0 and taylor_takes(scene, build(scene.model), MOST_JOINTS)


class Cases(NamedTuple):
    """The starts and the numbers of c scenes of one structure."""

    models: Sequence[Model]  # (c,)
    q: Array  # (c, nv) at the start
    v: Array  # (c, nv)
    parameters: Array  # (c, p) of the series
    longest: Array  # (c,) s, the longest step; 0 where an effect has corners, which series do not take side by side
    energies: Array  # (c, 2) J, kinetic and potential at the start

    def some(self, places: Indices) -> "Cases":
        """Those at these places (k,)."""
        return Cases([self.models[i] for i in places], *(rows[places] for rows in self[1:]))

    def pieces(self, samples: int, workers: int = 1) -> list[Indices]:
        """Places (k,) of cases that one worker runs at once: their samples fit into the memory, and no worker is idle."""
        size = min(AT_ONCE, MOST_STATES // samples, len(self.q) // (2 * workers))
        size = max(WIDTH, size // WIDTH * WIDTH)
        return [np.arange(begin, min(begin + size, len(self.q))) for begin in range(0, len(self.q), size)]


class Motions(NamedTuple):
    """The motions of c cases; NaN after the first sample of a case that cannot be integrated to its end."""

    models: Sequence[Model]  # (c,)
    t: Array  # (n,) s
    q: Array  # (c, n, nv)
    v: Array  # (c, n, nv)
    flips: Array  # (c,) s since the start, first passage of a sum of angles through an odd multiple of pi, else NaN
    steps: Array  # (c,)

    def some(self, places: Indices) -> "Motions":
        """Copies of those at these places (k,)."""
        return Motions([self.models[i] for i in places], self.t, *(rows[places] for rows in self[2:]))

    def put(self, places: Indices, motions: "Motions") -> None:
        """Write other motions of the same cases over those at these places (k,)."""
        for rows, others in zip(self[2:], motions[2:], strict=True):
            rows[places] = others

    @property
    def finite(self) -> Mask:
        """Which cases (c,) were integrated to their ends."""
        return np.asarray(np.isfinite(self.q[:, -1]).all(1) & np.isfinite(self.v[:, -1]).all(1))


class Series:
    """The compiled series of a scene's structure, for several threads. Raises InputError for a scene that they do not take.

    `flips`: sums of angles whose passages are to be found; `level`: where states are to be noted. What stays 0 in motions
    from all `starts` (c, 2, nv), positions and rates, is not integrated: phi in a plane of theta.
    """

    def __init__(
        self, scene: Scene, tolerance: float, starts: Array, flips: Sums = (), level: Level | None = None
    ) -> None:
        self.scene, self.tolerance, self._flips, self._level = scene.by("taylor", tolerance), tolerance, flips, level
        self.stopped, self.compile_seconds = Event(), 0.0
        self.dynamics = self.bound(self.scene)
        some = np.where(starts.any(0), np.random.default_rng(0).uniform(0.1, 1.0, starts.shape[1:]), 0.0)
        whole = EquationsOfMotion(self.dynamics.engine, self.dynamics.effects, scene.start.time)
        self.engine: Engine = drop_zeros(whole, *some)
        equations, parameters = whole._replace(engine=self.engine).function()
        self._recording, self._structure = equations.recording, parameters.structure
        self._numbers = run_time_parameters(self._recording)
        self._whole = self.dynamics.engine.size  # numbers of a state with what stays 0
        self._places = self.engine.places if isinstance(self.engine, Moving) else np.arange(self._whole)
        self._width = NARROW if len(self.dynamics.model.joints) <= SMALL else WIDTH
        self._own = self._case(self.scene, self.dynamics, parameters.shared)
        self.covered = bool(self._own.longest[0] > 0)  # whether the scene can be run: no effect of it has corners
        self._first: Any = None
        self._spare: list[Any] = []
        self._lock = Lock()

    def bound(self, scene: Scene) -> Dynamics:
        """The dynamics of a case: on angles where their passages are to be found, which directions do not count."""
        form = "angles" if self._flips or self._level else "directions"
        return Dynamics(build(scene.model), scene.effects, "auto", form, scene.start.time)

    def case(self, scene: Scene) -> Cases | None:
        """A scene as one case; None where its structure is another. Raises InputError for one that cannot be run."""
        dynamics = self.dynamics if scene.model == self.scene.model else self.bound(scene)
        if scene.effects == self.scene.effects and dynamics is self.dynamics:
            return self.started(*(x[None] for x in start_state(dynamics.model, scene.start)))
        effects = acting(dynamics.model, scene.effects)
        parameters = EquationsOfMotion(dynamics.engine, effects, scene.start.time).parameters()
        if parameters.structure != self._structure:
            return None
        case = self._case(scene, dynamics, parameters.shared)
        return case if case.longest[0] else None

    def started(self, q: Array, v: Array) -> Cases:
        """The scene of the series from other starts, q, v (c, nv)."""
        models, _, _, parameters, longest, _ = self._own.some(np.zeros(len(q), int))
        return Cases(models, q, v, parameters, longest, np.stack(self.dynamics.energies(q, v), 1))

    def _case(self, scene: Scene, dynamics: Dynamics, values: Sequence[float]) -> Cases:
        q, v = start_state(dynamics.model, scene.start)
        pace = paces_of(dynamics, acting(dynamics.model, scene.effects), q, v, scene.duration, self.tolerance).pace
        longest = 0.0 if len(pace.corners) else LONGEST_STEP * float(pace.shortest[0])
        numbers = np.array([self._numbers(values)])
        energies = np.stack(dynamics.energies(q[None], v[None]), 1)
        return Cases([dynamics.model], q[None], v[None], numbers, np.array([longest]), energies)

    def run(self, cases: Cases, times: Array) -> Motions:
        """The motions of c cases at the times (n,); one that cannot go on is NaN."""
        # Where one cannot, all of its vector are run again, each alone; so is one with angles to be read between the times.
        motions, needed = self._attempt(cases, times, 1)
        again = needed > 1
        if len(cases.q) > 1:
            again |= ~motions.finite
        for i in np.flatnonzero(again):
            place = np.array([i])
            motion, fine = self._attempt(cases.some(place), times, parts := 1)
            while fine[0] > parts and not self.stopped.is_set():
                if fine[0] * len(times) > MOST_STATES:
                    motion.q[:, 1:] = np.nan
                    break
                motion, fine = self._attempt(cases.some(place), times, parts := math.ceil(fine[0]))
            motions.put(place, motion)
        return motions

    def _attempt(self, cases: Cases, times: Array, parts: int) -> tuple[Motions, Array]:
        """The motions, and into how many parts (c,) the intervals of the times have to be cut at least."""
        fine, packed = subdivided(times, parts), self._pack(cases)
        # The samples of one number lie side by side in memory. Numbers that stay 0 are left as they were allocated.
        rows = np.zeros((self._whole, len(packed), len(fine)))
        rows[self._places] = np.nan
        rows[self._places, :, 0] = packed.T
        steps, flips = np.full((2, len(packed)), np.nan)
        if len(fine) > 1:
            for series, places in self._vectors(cases):
                noting = [event.callback for event in series.nt_events] if self._flips and series.with_events else []
                for passage in noting:
                    passage.first[:] = np.nan
                states, steps[places] = _propagate(series, packed[places], fine, cases.longest[places], self.stopped)
                rows[self._places[:, None], places] = states
                for passage in noting:
                    flips[places] = np.fmin(flips[places], passage.first)
        else:  # the start alone: heyoka refuses no interval
            steps[:] = 0.0
        q, v, needed = self._read(rows.transpose(1, 2, 0), steps, cases, fine, parts)
        return Motions(cases.models, times, q, v, flips, steps), needed

    def cross(self, cases: Cases, count: int, patience: float) -> list[Array]:
        """The states at the first crossings of the level of each of c cases, (k, 1 + 2 nv): t in s since the start, q, v.

        Fewer than `count` of a case that cannot go on, or does not cross the level for so many s.
        """
        states, y = [np.empty((0, 1 + 2 * cases.q.shape[1]))] * len(cases.q), self._pack(cases)
        for series, places in self._vectors(cases):
            (notes,) = (event.callback for event in series.nt_events)
            series.state[:] = y[places].T
            series.set_time(0.0)
            notes.rows = [[] for _ in places]
            ahead, end = self.scene.duration, 0.0
            while not self.stopped.is_set():
                end += ahead
                series.propagate_until(end, max_steps=STEPS_AT_ONCE, max_delta_t=cases.longest[places])
                if any(outcome != outcome.time_limit for outcome, *_ in series.propagate_res):
                    break
                if all(len(rows) >= count or end - (rows[-1][0] if rows else 0.0) > patience for rows in notes.rows):
                    break
                ahead = min(2 * ahead, patience)
            for place, rows in zip(places, notes.rows, strict=True):
                if rows:
                    table = np.array(rows[:count])
                    whole = self.engine.whole(table[:, 1:]) if isinstance(self.engine, Moving) else table[:, 1:]
                    states[place] = np.concatenate([table[:, :1], whole], 1)
        return states

    def _vectors(self, cases: Cases) -> Iterator[tuple[Any, Indices]]:
        """Series that no other thread uses, with the parameters of a vector of cases, and their places (width,)."""
        with self._lock:  # a copy of the first series, which is compiled here
            if self._first is None:
                self._first, self.compile_seconds = wait_for(self._compiled)
            series = self._spare.pop() if self._spare else deepcopy(self._first)
        order = np.arange(len(cases.q))
        if len(order) > self._width:
            order = np.argsort(cases.energies.sum(1))  # alike ones take like numbers of steps
        try:  # the last vector has copies
            for places in np.resize(order, (-(-len(order) // self._width), self._width)):
                if self.stopped.is_set():
                    break
                series.pars[:] = cases.parameters[places].T
                yield series, places
        finally:
            with self._lock:
                self._spare.append(series)

    def _pack(self, cases: Cases) -> Array:
        if self.engine.on_angles:
            return np.concatenate([cases.q, cases.v], 1)[:, self._places]
        return np.array([self.engine.pack(*start) for start in zip(cases.q, cases.v, strict=True)])

    def _read(self, rows: Array, steps: Array, cases: Cases, fine: Array, parts: int) -> tuple[Array, Array, Array]:
        """Positions and rates (c, n, nv) from states (c, n, size), and into how many parts intervals have to be cut (c,)."""
        (c, nv), needed = cases.q.shape, np.zeros(len(rows))
        if self.engine.on_angles:
            return rows[..., :nv], rows[..., nv:], needed
        rows = rows[..., self._places]
        q, v = np.full((2, c, (len(fine) - 1) // parts + 1, nv), np.nan)
        q[:, 0], v[:, 0] = cases.q, cases.v
        for i in np.flatnonzero(np.isfinite(rows).all((1, 2))):
            turns = self.engine.density(rows[i]) * np.diff(fine).max()
            needed[i] = parts * max(turns, steps[i] / max(len(fine) - 1, 1))
            q[i, 1:], v[i, 1:] = (x[::parts][1:] for x in self.engine.unpack(fine, rows[i], cases.q[i]))
        return q, v, needed

    def _compiled(self) -> tuple[Any, float]:
        """heyoka's integrator of the cases side by side, and the s in which it was compiled."""
        begin, hy = time.thread_time(), heyoka()
        state, rates = expressions(hy, self._recording)
        moving = dict(zip(self._places.tolist(), state, strict=True))
        sums = [[moving[i] for i in joints if i in moving] for joints in self._flips]
        guards = [hy.cos(sum(angles) * 0.5) for angles in sums if angles]
        noted = [hy.nt_event_batch(guard, _Passage(np.full(self._width, np.nan))) for guard in guards]
        if self._level:
            ways = {1: hy.event_direction.positive, -1: hy.event_direction.negative, 0: hy.event_direction.any}
            joint, angle, direction = self._level
            place = self._places.tolist().index(joint)
            guard, notes = hy.sin(state[place] - angle), _Notes(place, angle, [[] for _ in range(self._width)])
            noted.append(hy.nt_event_batch(guard, notes, direction=ways[direction]))
        events = {"nt_events": noted} if noted else {}
        series = hy.taylor_adaptive_batch(
            list(zip(state, rates, strict=True)),
            np.zeros((len(state), self._width)),
            tol=self.tolerance,
            high_accuracy=self.tolerance < COMPENSATED,
            compact_mode=len(self.dynamics.model.joints) * len(state) > SMALL * self._whole,
            pars=np.zeros((self._own.parameters.shape[1], self._width)),
            **events,
        )
        return series, time.thread_time() - begin


@dataclass(eq=False)
class _Passage:
    """Notes the first time at which a guard passes 0 in each place of the vector; copied with the series it belongs to."""

    first: Array  # (width,) s

    def __call__(self, series: Any, t: float, direction: int, place: int) -> None:
        self.first[place] = np.fmin(self.first[place], t)


@dataclass(eq=False)
class _Notes:
    """Notes time and state where an angle passes a level, but not half a turn away; copied as `_Passage`."""

    place: int  # of the angle in a state
    level: float  # rad
    rows: list[list[Array]]  # of each place of the vector

    def __call__(self, series: Any, t: float, direction: int, place: int) -> None:
        series.update_d_output(np.full(len(self.rows), t))
        state = series.d_output[:, place]
        if t > 0 and math.cos(state[self.place] - self.level) > 0:  # a start on the level has not crossed it
            self.rows[place].append(np.array([t, *state]))


def _propagate(series: Any, y: Array, times: Array, longest: Array, stopped: Event) -> tuple[Array, Array]:
    """States (size, width, n) at the times, and steps (width,), of `longest` (width,) s at most; NaN where one fails."""
    states, steps = np.full((*y.T.shape, len(times)), np.nan), np.zeros(len(y))
    states[..., 0] = series.state[:] = y.T
    series.set_time(times[0])
    limits = {"max_steps": STEPS_AT_ONCE, "max_delta_t": longest}
    for first in range(0, len(times) - 1, SAMPLES_AT_ONCE):
        ahead = times[first + 1 : first + SAMPLES_AT_ONCE + 1]
        if len(times) == 2:  # nothing is to be read between two steps
            series.propagate_until(ahead[0], **limits)
            reached = series.state[None]
        else:
            grid = np.concatenate([series.time[None], np.repeat(ahead[:, None], len(y), axis=1)])
            reached = series.propagate_grid(grid, **limits)[1][1:]
        outcomes, _, _, taken = zip(*series.propagate_res, strict=True)
        steps += taken
        if stopped.is_set() or any(outcome != outcome.time_limit for outcome in outcomes):
            break
        states[..., first + 1 : first + 1 + len(ahead)] = reached.transpose(1, 2, 0)
    return states, steps


def ends_well(dynamics: Dynamics, cases: Cases, motions: Motions) -> Mask:
    """Whether each of c motions came to its end, in numbers that are not too large, with the energy it should have."""
    q, v = motions.q, motions.v
    good = np.asarray(((np.abs(q) <= LARGEST) & (np.abs(v) <= LARGEST)).all((1, 2)))
    if not dynamics.conservative or not good.any():
        return good
    ends = np.stack(dynamics.energies(q[good, -1], v[good, -1]), 1)  # kinetic and potential (k, 2)
    both = np.stack([cases.energies[good], ends], 1)
    off, scale = np.abs(np.diff(both.sum(2), axis=1))[:, 0], exchanged(*both.T)[-1]
    if (off > OFF * scale).any():
        # where little is exchanged, the rounding of a potential counts, which may vanish at the ends
        elsewhere = np.array([dynamics.energies(x + 1.0, np.zeros_like(x))[1] for x in (q[good, 0], q[good, -1])])
        scale = np.maximum(scale, ROUNDING * np.abs(elsewhere).max(0))
    good[good] = off <= OFF * scale
    return good
