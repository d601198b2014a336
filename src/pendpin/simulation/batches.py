"""Many runs side by side in the processor's vectors: the equations are compiled once, with their numbers as parameters.

A case is a scene of one structure: it differs from others in its start and in the numbers of its model and effects, which
are run-time parameters of one set of Taylor series. The result of a case does not depend on its neighbours in the vector.
Other scenes are run by `simulate`.
"""

import math
import time
from collections.abc import Generator, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import deepcopy
from threading import Event, Lock
from typing import Any, NamedTuple

import numpy as np

from pendpin.arrays import Array, Indices, subdivided
from pendpin.dynamics.acting import acting
from pendpin.dynamics.compiling import equations_of
from pendpin.dynamics.dynamics import Dynamics
from pendpin.dynamics.symbols import parameters_of, staying_zero
from pendpin.dynamics.timing import timing
from pendpin.engines import Engine
from pendpin.integrators.taylor import HIGH, SERIES, SMALL, expressions, run_time_parameters
from pendpin.integrators.taylor_vectors import Passage, along, passages
from pendpin.model.build import Model, build, start_state
from pendpin.scene import Scene

WIDTH = 16  # cases side by side, the same on every machine: two vectors hide the time that an instruction takes
NARROW = 8  # for up to SMALL joints: one rod is then 10 % faster, two rods are 10 to 60 % slower
AT_ONCE = 128  # cases that are sorted into vectors
MOST_STATES = 200_000  # of a case

Sums = Sequence[Sequence[int]]  # places of joints whose angles are added


class Cases(NamedTuple):
    """The starts and the numbers of c scenes of one structure."""

    models: Sequence[Model]  # (c,)
    q: Array  # (c, nv) at the start
    v: Array  # (c, nv)
    parameters: Array  # (c, p) of the series
    longest: Array  # (c,) s, the longest step; 0 where an effect has corners, which series do not take side by side

    def some(self, places: Indices) -> "Cases":
        """Those at these places (k,)."""
        return Cases([self.models[i] for i in places], *(rows[places] for rows in self[1:]))

    def pieces(self, samples: int, workers: int = 1) -> list[Indices]:
        """Places (k,) of cases that one worker runs at once: their samples fit into the memory, and no worker is idle."""
        size = min(AT_ONCE, MOST_STATES // samples, len(self.q) // (2 * workers))
        size = max(WIDTH, size // WIDTH * WIDTH)
        return [np.arange(begin, min(begin + size, len(self.q))) for begin in range(0, len(self.q), size)]


def together(cases: Sequence[Cases]) -> Cases:
    """All of these cases."""
    models, *rows = zip(*cases, strict=True)
    return Cases([model for some in models for model in some], *(np.concatenate(part) for part in rows))


class Motions(NamedTuple):
    """The motions of c cases; NaN after the first sample of a case that cannot be integrated to its end."""

    q: Array  # (c, n, nv)
    v: Array  # (c, n, nv)
    flips: Array  # (c,) s since the start, first passage of a sum of angles through an odd multiple of pi, else NaN
    steps: Array  # (c,)


class Series:
    """The compiled series of a scene's structure. `flips`: sums of angles whose passages are to be found.

    With `other`, a case whose start differs wherever starts do, a part of the state that sets out from 0 and stays 0 is not
    integrated: phi in a planar motion. Several threads may use a Series. Raises InputError for a scene that the Taylor
    method does not take.
    """

    def __init__(self, scene: Scene, tolerance: float, flips: Sums = (), other: Scene | None = None) -> None:
        self.scene, self.tolerance, self._flips = scene.by("taylor", tolerance), tolerance, flips
        self.stopped, self.compile_seconds = Event(), 0.0
        self.dynamics = self.bound(self.scene)
        self.engine: Engine = self.dynamics.engine
        begin = scene.start.time
        still = staying_zero(self.engine, self.dynamics.effects, begin, self._zeros(scene, other)) if other else ()
        equations, parameters = equations_of(self.engine, self.dynamics.effects, begin, still)
        self._recording, self._structure = equations.recording, parameters.structure
        self._moving = np.setdiff1d(np.arange(self._recording.size), still)
        self._width = NARROW if len(self.dynamics.model.joints) <= SMALL else WIDTH
        self._own = self._case(self.scene, self.dynamics, parameters.values)
        self._first: Any = None
        self._spare: list[Any] = []
        self._lock = Lock()

    def bound(self, scene: Scene) -> Dynamics:
        """The dynamics of a case: on angles where their passages are to be found, which directions do not count."""
        form = "angles" if self._flips else "directions"
        return Dynamics(build(scene.model), scene.effects, "auto", form, scene.start.time)

    def _zeros(self, *scenes: Scene) -> list[int]:
        """The places of the state that are 0 at the start of all these scenes."""
        starts = [self.engine.pack(*start_state(self.dynamics.model, scene.start)) for scene in scenes]
        return np.flatnonzero(~np.any(starts, axis=0)).tolist()

    def case(self, scene: Scene) -> Cases | None:
        """A scene as one case; None where its structure is another. Raises InputError for one that cannot be run."""
        dynamics = self.dynamics if scene.model == self.scene.model else self.bound(scene)
        if scene.effects == self.scene.effects and dynamics is self.dynamics:
            return self.started(*(x[None] for x in start_state(dynamics.model, scene.start)))
        parameters = parameters_of(dynamics.engine, acting(dynamics.model, scene.effects), scene.start.time)
        if parameters.structure != self._structure:
            return None
        case = self._case(scene, dynamics, parameters.values)
        return case if case.longest[0] else None

    @property
    def covered(self) -> bool:
        """Whether the scene can be run: no effect of it has corners."""
        return bool(self._own.longest[0] > 0)

    def started(self, q: Array, v: Array) -> Cases:
        """The scene of the series from other starts, q, v (c, nv)."""
        models, _, _, *numbers = self._own.some(np.zeros(len(q), int))
        return Cases(models, q, v, *numbers)

    def _case(self, scene: Scene, dynamics: Dynamics, values: Sequence[float]) -> Cases:
        q, v = start_state(dynamics.model, scene.start)
        pace = timing(dynamics, acting(dynamics.model, scene.effects), q, v, scene.duration, self.tolerance).pace
        longest = 0.0 if len(pace.corners) else SERIES * float(pace.shortest[0])
        numbers = run_time_parameters(self._recording, values)
        return Cases([dynamics.model], q[None], v[None], np.array([numbers]), np.array([longest]))

    def run(self, cases: Cases, times: Array) -> Motions:
        """The motions of c cases at the times (n,); one that cannot go on is NaN.

        Where one cannot, all of its vector are run again, each alone; so is one whose angles are to be read between the
        times.
        """
        found, needed = self._attempt(cases, times, 1)
        again = needed > 1
        if len(cases.q) > 1:
            again |= ~np.isfinite(found.q[:, -1]).all(1)
        for i in np.flatnonzero(again):
            for whole, part in zip(found, self._alone(cases.some(np.array([i])), times), strict=True):
                whole[i] = part[0]
        return found

    def _alone(self, case: Cases, times: Array) -> Motions:
        """One case, with enough states between times (n,) to read its angles."""
        found, needed = self._attempt(case, times, parts := 1)
        while needed[0] > parts and not self.stopped.is_set():
            if needed[0] * len(times) > MOST_STATES:
                found.q[:, 1:] = np.nan
                break
            found, needed = self._attempt(case, times, parts := math.ceil(needed[0]))
        return found

    def _attempt(self, cases: Cases, times: Array, parts: int) -> tuple[Motions, Array]:
        """The motions, and into how many parts (c,) the intervals of the times have to be cut at least."""
        fine = subdivided(times, parts)
        if len(self._moving) and len(fine) > 1:
            rows, steps, flips = self._integrate(cases, fine)
        else:  # all at rest, for good, or the start alone: heyoka refuses no equations and no interval
            rows = np.repeat(self._with_zeros(self._packed(cases))[:, None], len(fine), axis=1)
            steps, flips = np.zeros(len(rows)), np.full(len(rows), np.nan)
        q, v, needed = self._read(rows, steps, cases, fine, parts)
        return Motions(q, v, flips, steps), needed

    def _integrate(self, cases: Cases, fine: Array) -> tuple[Array, Array, Array]:
        """States (c, n, size) at the fine times (n,), steps (c,), first passages (c,) in s; NaN where a case ends early."""
        order, y = self._by_energy(cases), self._packed(cases)
        rows = np.full((len(y), len(fine), self._recording.size), np.nan)
        steps, flips = np.full((2, len(y)), np.nan)
        series = self._take()
        try:
            for places in np.resize(order, (-(-len(order) // self._width), self._width)):  # whole vectors, with copies
                if self.stopped.is_set():
                    break
                series.pars[:] = cases.parameters[places].T
                states, steps[places] = along(series, y[places], fine, cases.longest[places], self.stopped)
                rows[places] = self._with_zeros(states)
                flips[places] = np.fmin.reduce([passage.first for passage in passages(series)], initial=np.nan)
        finally:
            with self._lock:
                self._spare.append(series)
        return rows, steps, flips

    def _with_zeros(self, states: Array) -> Array:
        """The whole states (..., size) from what moves of them (..., moving)."""
        if states.shape[-1] == self._recording.size:
            return states
        rows = np.zeros((*states.shape[:-1], self._recording.size))
        rows[..., self._moving] = states
        return rows

    def _by_energy(self, cases: Cases) -> Indices:
        """The places (c,) of the cases in the order of their energies: alike, they take like numbers of steps.

        As they come where each has a model of its own.
        """
        if len(cases.q) <= self._width or any(model is not cases.models[0] for model in cases.models):
            return np.arange(len(cases.q))
        return np.argsort(np.add(*self.dynamics.energies(cases.q, cases.v)))

    def _packed(self, cases: Cases) -> Array:
        """What moves of the states (c, moving) at the start."""
        if self.engine.on_angles:
            return np.concatenate([cases.q, cases.v], 1)[:, self._moving]
        return np.array([self.engine.pack(*start) for start in zip(cases.q, cases.v, strict=True)])[:, self._moving]

    def _read(self, rows: Array, steps: Array, cases: Cases, fine: Array, parts: int) -> tuple[Array, Array, Array]:
        """Positions and rates (c, n, nv) from states (c, n, size), and into how many parts intervals have to be cut (c,)."""
        (c, nv), needed = cases.q.shape, np.zeros(len(rows))
        if self.engine.on_angles:
            return rows[..., :nv], rows[..., nv:], needed
        q, v = np.full((2, c, (len(fine) - 1) // parts + 1, nv), np.nan)
        q[:, 0], v[:, 0] = cases.q, cases.v
        for i in np.flatnonzero(np.isfinite(rows).all((1, 2))):
            turns = self.engine.density(rows[i]) * np.diff(fine).max()
            needed[i] = parts * max(turns, steps[i] / max(len(fine) - 1, 1))
            q[i, 1:], v[i, 1:] = (x[::parts][1:] for x in self.engine.unpack(fine, rows[i], cases.q[i]))
        return q, v, needed

    def _take(self) -> Any:
        """Series that no other thread uses: a copy of the first, which is compiled here."""
        with self._lock:
            if self._first is None:
                begin = time.perf_counter()
                self._first = self._compiled()
                self.compile_seconds = time.perf_counter() - begin
            return self._spare.pop() if self._spare else deepcopy(self._first)

    def _compiled(self) -> Any:
        import heyoka as hy

        state, rates = expressions(hy, self._recording)
        sums = [[state[i] for i in places if i in self._moving] for places in self._flips]
        guards = [hy.cos(sum(angles) * 0.5) for angles in sums if angles]
        events = {"nt_events": [hy.nt_event_batch(guard, Passage(self._width)) for guard in guards]} if guards else {}
        return hy.taylor_adaptive_batch(
            [(state[i], rates[i]) for i in self._moving],
            np.zeros((len(self._moving), self._width)),
            tol=self.tolerance,
            high_accuracy=self.tolerance < HIGH,
            compact_mode=len(self.dynamics.model.joints) * len(self._moving) > SMALL * self._recording.size,
            pars=np.zeros((self._own.parameters.shape[1], self._width)),
            **events,
        )


class Batch(NamedTuple):
    """The motions of a few starts; NaN behind the first sample of one that did not get to its end."""

    places: Indices  # (c,)
    q: Array  # (c, n, nv)
    v: Array
    steps: int
    seconds: float


def side_by_side(series: Series, times: Array, q: Array, v: Array, workers: int) -> Generator[Batch, None, None]:
    """The motions from q, v (k, nv), batch by batch, in order, by threads. Close the iterator to stop."""

    def run(places: Indices) -> Batch:
        begin = time.perf_counter()
        found = series.run(cases.some(places), times)
        return Batch(places, found.q, found.v, int(found.steps.sum()), time.perf_counter() - begin)

    cases, pool = series.started(q, v), ThreadPoolExecutor(workers)
    try:
        running = [pool.submit(run, places) for places in cases.pieces(len(times), workers)]
        while running:
            yield running.pop(0).result()
    finally:
        series.stopped.set()
        pool.shutdown(cancel_futures=True)
