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

from pendpin.arrays import Array, Indices, Mask, subdivided
from pendpin.dynamics.binding import acting
from pendpin.dynamics.compiling import equations_of
from pendpin.dynamics.dynamics import Dynamics
from pendpin.dynamics.symbols import parameters_of, staying_zero
from pendpin.dynamics.timing import timing
from pendpin.engines import Engine
from pendpin.integrators.taylor import HIGH, SERIES, SMALL, expressions, run_time_parameters
from pendpin.model import kinematics
from pendpin.model.build import Model, build, start_state
from pendpin.records import LARGEST
from pendpin.scene import Scene
from pendpin.simulation.guards import OFF, ROUNDING

WIDTH = 16  # cases side by side, the same on every machine: two vectors hide the time that an instruction takes
MOST_STATES = 200_000  # of a case
SAMPLES_AT_ONCE = 256  # between two chances to stop
STEPS_AT_ONCE = 65_536  # in so many samples, at most

Sums = Sequence[Sequence[int]]  # places of joints whose angles are added


class Case(NamedTuple):
    """The start and the numbers of one scene."""

    model: Model
    q: Array  # (nv,) at the start
    v: Array  # (nv,)
    parameters: tuple[float, ...]  # of the series
    longest: float  # s, the longest step; 0 where an effect has corners, which series do not take side by side


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

    def case(self, scene: Scene) -> Case | None:
        """A scene as a case; None where its structure is another. Raises InputError for one that cannot be run."""
        dynamics = self.dynamics if scene.model == self.scene.model else self.bound(scene)
        if scene.effects == self.scene.effects and dynamics is self.dynamics:
            return self.started(*start_state(dynamics.model, scene.start))
        parameters = parameters_of(dynamics.engine, acting(dynamics.model, scene.effects), scene.start.time)
        if parameters.structure != self._structure:
            return None
        case = self._case(scene, dynamics, parameters.values)
        return case if case.longest else None

    @property
    def covered(self) -> bool:
        """Whether the scene can be run: no effect of it has corners."""
        return self._own.longest > 0

    def started(self, q: Array, v: Array) -> Case:
        """The scene of the series from another start, q, v (nv,)."""
        return self._own._replace(q=q, v=v)

    def _case(self, scene: Scene, dynamics: Dynamics, values: Sequence[float]) -> Case:
        q, v = start_state(dynamics.model, scene.start)
        pace = timing(dynamics, acting(dynamics.model, scene.effects), q, v, scene.duration, self.tolerance).pace
        longest = 0.0 if len(pace.corners) else SERIES * float(pace.shortest[0])
        return Case(dynamics.model, q, v, tuple(run_time_parameters(self._recording, values)), longest)

    def run(self, cases: Sequence[Case], times: Array) -> Motions:
        """The motions of up to WIDTH cases; one that cannot go on is NaN.

        Where one cannot, or its angles are to be read between the times, it is run alone, and the others without it.
        """
        found, needed = self._attempt(cases, times, 1)
        bad = ~np.isfinite(found.q[:, -1]).all(1)
        for i in np.flatnonzero((needed > 1) | (bad.any() and len(cases) > 1)).tolist():
            for whole, part in zip(found, self._alone(cases[i], times), strict=True):
                whole[i] = part[0]
        return found

    def _alone(self, case: Case, times: Array) -> Motions:
        """One case, with enough states between times (n,) to read its angles."""
        found, needed = self._attempt([case], times, parts := 1)
        while needed[0] > 1 and not self.stopped.is_set():
            parts = math.ceil(parts * needed[0])
            if parts * len(times) > MOST_STATES:
                found.q[:, 1:] = np.nan
                break
            found, needed = self._attempt([case], times, parts)
        return found

    def _attempt(self, cases: Sequence[Case], times: Array, parts: int) -> tuple[Motions, Array]:
        """The motions, and by how much finer (c,) each interval of the times has to be cut than into `parts`."""
        series, fine = self._take(), subdivided(times, parts)
        try:
            which = np.resize(np.arange(len(cases)), WIDTH)  # up to the width, with copies
            series.pars[:] = np.array([case.parameters for case in cases]).T[:, which]
            passages = [event.callback for event in series.nt_events] if self._flips else []
            for passage in passages:
                passage.first[:] = np.nan
            y = np.array([self.engine.pack(case.q, case.v) for case in cases]).T[self._moving]
            longest = np.array([case.longest for case in cases])[which]
            states, steps = _along(series, y[:, which], fine, longest, self.stopped)
            flips = np.fmin.reduce([passage.first for passage in passages], initial=np.nan)
            (q, v), needed = self._read(states, steps, cases, fine, parts)
            return Motions(q, v, np.broadcast_to(flips, WIDTH)[: len(cases)].copy(), steps[: len(cases)]), needed
        finally:
            with self._lock:
                self._spare.append(series)

    def _read(self, states: Array, steps: Array, cases: Sequence[Case], fine: Array, parts: int) -> tuple[Array, Array]:
        """Positions and rates (2, c, n, nv) from states (n, moving, width), and how much closer they have to be (c,)."""
        found = np.full((2, len(cases), (len(fine) - 1) // parts + 1, len(cases[0].q)), np.nan)
        found[:, :, 0], needed = ([case.q for case in cases], [case.v for case in cases]), np.zeros(len(cases))
        for i, case in enumerate(cases):
            rows = np.zeros((len(fine), self._recording.size))
            rows[:, self._moving] = states[:, :, i]
            if np.isfinite(rows).all():
                needed[i] = self.engine.denser(fine, rows, int(steps[i]))
                found[:, i, 1:] = [x[::parts][1:] for x in self.engine.unpack(fine, rows, case.q)]
        return found, needed

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
        events = {"nt_events": [hy.nt_event_batch(guard, _Passage()) for guard in guards]} if guards else {}
        return hy.taylor_adaptive_batch(
            [(state[i], rates[i]) for i in self._moving],
            np.zeros((len(self._moving), WIDTH)),
            tol=self.tolerance,
            high_accuracy=self.tolerance < HIGH,
            compact_mode=len(self.dynamics.model.joints) * len(self._moving) > SMALL * self._recording.size,
            pars=np.zeros((len(self._own.parameters), WIDTH)),
            **events,
        )


class _Passage:
    """Notes the first time at which a guard passes 0 in each place of the vector; copied with the series it belongs to."""

    def __init__(self) -> None:
        self.first = np.full(WIDTH, np.nan)

    def __call__(self, series: Any, t: float, direction: int, place: int) -> None:
        self.first[place] = np.fmin(self.first[place], t)


def _along(series: Any, y: Array, times: Array, longest: Array, stopped: Event) -> tuple[Array, Array]:
    """States (n, size, width) at the times, and steps (width,), of `longest` (width,) s at most; NaN where one fails."""
    states, steps = np.full((len(times), *y.shape), np.nan), np.zeros(y.shape[1])
    states[0], series.state[:] = y, y
    series.set_time(times[0])
    for first in range(0, len(times) - 1, SAMPLES_AT_ONCE):
        grid = np.repeat(times[first : first + SAMPLES_AT_ONCE + 1, None], y.shape[1], axis=1)
        grid[0] = series.time
        _, found = series.propagate_grid(grid, max_steps=STEPS_AT_ONCE, max_delta_t=longest)
        outcomes, _, _, taken = zip(*series.propagate_res, strict=True)
        steps += taken
        if stopped.is_set() or any(outcome != outcome.time_limit for outcome in outcomes):
            break
        states[first + 1 : first + len(grid)] = found[1:]
    return states, steps


def ends_well(dynamics: Dynamics, q: Array, v: Array) -> Mask:
    """Whether each start (c,) came to its end, in numbers that are not too large, with the energy it should have."""
    good = np.asarray(((np.abs(q) <= LARGEST) & (np.abs(v) <= LARGEST)).all((1, 2)))
    if not dynamics.conservative or not good.any():
        return good
    ends = [rows[good][:, [0, -1]].reshape(-1, q.shape[2]) for rows in (q, v)]
    kinetic = kinematics.kinetic_energy(dynamics.model, *ends).reshape(-1, 2)
    potential = dynamics.potential(ends[0], kinematics.poses(dynamics.model, ends[0])).reshape(-1, 2)
    off, moved = np.abs(np.diff(kinetic + potential))[:, 0], kinetic.max(1) + np.ptp(potential, axis=1)
    good[good] = off <= OFF * moved + ROUNDING * (moved + np.abs(potential).max(1))
    return good


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
        found = series.run([series.started(*start) for start in zip(q[places], v[places], strict=True)], times)
        return Batch(places, found.q, found.v, int(found.steps.sum()), time.perf_counter() - begin)

    pool = ThreadPoolExecutor(workers)
    try:
        pieces = np.split(np.arange(len(q)), range(WIDTH, len(q), WIDTH))
        running = [pool.submit(run, places) for places in pieces]
        while running:
            yield running.pop(0).result()
    finally:
        series.stopped.set()
        pool.shutdown(cancel_futures=True)
