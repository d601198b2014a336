"""What a sweep is: a scene, the cases, the measures; and how a block of its cases is run.

Smooth scenes of few joints go side by side in the processor's vectors (runs/batches.py); any other case is simulated on its
own. What a case gives does not depend on its neighbours.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from threading import Event
from typing import Any, NamedTuple, TypeVar

import numpy as np

from pendpin.engines import ProgressCallback
from pendpin.errors import InputError, Interrupted, PendpinError, RunError, inside, shown
from pendpin.ground.arguments import parsed
from pendpin.ground.arrays import EPS, Array, Indices, Mask, subdivided
from pendpin.ground.libraries import installed
from pendpin.ground.records import LARGEST
from pendpin.integrators import Run
from pendpin.model.build import FARTHEST, build, start_state
from pendpin.model.kinematics import evaluate_each, marks_at, tip_distance
from pendpin.motions.trajectory import Trajectory
from pendpin.runs.accuracy.estimate import Gaps, estimate_error
from pendpin.runs.accuracy.runs import TAYLOR, choose_density, choose_length, refine_by_tolerance, sample_closely
from pendpin.runs.accuracy.thresholds import ESTIMATE, ROUNDING, SETTING, VECTOR
from pendpin.runs.batches import Cases, Motions, Series, ends_well, takes
from pendpin.runs.run import fill_in
from pendpin.runs.simulate import run_to_setting
from pendpin.scene import Scene, unit_of_key
from pendpin.sweeps.attractors import Attractor
from pendpin.sweeps.measures import Function, Measure, accumulated, evaluate_measure, fitted, measure
from pendpin.sweeps.plan import RESERVED, Plan, short_names
from pendpin.sweeps.workers import end_if_stopped
from pendpin.trajectory import RunRecord
from pendpin.trajectory.columns import unit_of

T = TypeVar("T")
TRIED = 33  # cases, at most, until one can be had
LOOSER = 100.0  # times the tolerance, for what compares two runs
CLOSER = 4  # times the samples, of cases whose samples do not tell what is between them
LARGEST_COUNT = 2.0**53
STATES = (("start", "positions"), ("start", "velocities"))  # beginnings of key paths
AT_POLE = 1e-4  # of cos(phi): rounding over its square is an error of 1e-8 in the angular acceleration of theta


@dataclass(frozen=True, eq=False)
class Task:
    """A sweep, as it is given to whoever runs a part of it."""

    scene: Scene
    plan: Plan
    measures: tuple[str | Function, ...]
    units: Mapping[str, str] = field(default_factory=dict)  # of varied numbers and measures, where they have one

    @cached_property
    def chosen(self) -> tuple[Measure, ...]:
        """The measures, fitted to the scene and the numbers that vary."""
        return tuple(fitted(measure(given), self.scene, self.plan.keys) for given in self.measures)

    @cached_property
    def columns(self) -> list[slice]:
        """Where the numbers of each measure are in a row of all of them."""
        sizes = [math.prod(length for _, length in m.dims) for m in self.chosen]
        return [slice(end - size, end) for size, end in zip(sizes, np.cumsum(sizes).tolist(), strict=True)]

    @cached_property
    def batch(self) -> "Batch | None":
        """What runs the cases side by side; None where series do not take the scene, or a key changes the run."""
        solver, kinds = self.scene.solver, {parsed(key)[0] for key in self.plan.keys}
        if kinds - {"model", "effects", "start"} or "start.time" in self.plan.keys or not takes(self.scene):
            return None
        if solver.accuracy is not None and solver.accuracy < VECTOR.finest:
            return None
        # one with the numbers of a case may be less smooth, as where a drag is 0 in the scene
        batch = from_a_case(self, lambda scene: Batch(self, scene) if takes(scene) else None)
        return batch if batch and batch.series[0].covered else None

    def __reduce__(self) -> tuple[type["Task"], tuple[Any, ...]]:
        """What is sent to another process: what is given, and nothing that follows from it."""
        return Task, (self.scene, self.plan, self.measures, self.units)


class Block(NamedTuple):
    """The measures of c cases."""

    values: Array  # (c, numbers of all measures); NaN where a case could not be run or has none
    why: Array  # (c,) of text: why a case could not be run, "" where it could


def sampled(task: Task) -> Task:
    """The task, sampled where the attractor looks if it is the only measure and the scene asks for no times of its own."""
    look, solver = task.chosen[0].function, task.scene.solver
    fixed = any(key.startswith(("duration", "solver", "start.time")) for key in task.plan.keys)
    given = len(task.chosen) > 1 or solver.samples or solver.times or fixed
    if given or not isinstance(look, Attractor) or not look.period:
        return task
    times = look.times(task.scene)
    return task if times is None else replace(task, scene=task.scene.with_solver(times=tuple(times.tolist())))


def checked(task: Task) -> Task:
    """The task with its units. Raises InputError for keys or measures that no case could have."""
    scene, names = from_a_case(task, lambda scene: scene), [m.name for m in task.chosen]
    varied = dict(zip(short_names(task.plan.keys), task.plan.keys, strict=True))
    units = {name: unit for name, key in varied.items() if (unit := unit_of_key(key, scene))}
    units |= {m.name: m.unit for m in task.chosen if m.unit}
    for i, name in enumerate(names):
        if name in names[:i] or name in RESERVED or name in varied:
            twice = "given twice; give one of them as a function of another name"
            raise InputError(f"measure: {name} is {twice if name in names[:i] else 'a name of the result'}")
        if not name or name.startswith((".", "__")) or "/" in name:
            raise InputError(f"measure: {shown(name)} cannot name a variable: give the function another __name__")
    lengths = dict[str, int]()
    for dimension, length in (pair for m in task.chosen for pair in m.dims):
        if lengths.setdefault(dimension, length) != length or dimension in varied or dimension in RESERVED:
            remedy = "give one of them another name, or both one length"
            raise InputError(f"measure: two dimensions are called {dimension}; {remedy}")
    series = {m.name: m.series for m in task.chosen if m.series}

    def units_of_series(scene: Scene) -> dict[str, str]:
        run = Trajectory.of(run_to_setting(scene.sampled(None, duration=0.0)))
        with inside("measure"):
            return {name: unit_of(run, quantity) for name, quantity in series.items() if len(run[quantity])}

    with suppress(RunError):  # every case will say why
        units = (from_a_case(task, units_of_series) if series else {}) | units
    return replace(task, units=units)


def from_a_case(task: Task, make: Callable[[Scene], T]) -> T:
    """What `make` makes of the last case, else of one before it that it takes. Raises InputError if it takes none."""
    places, errors = np.unique(np.linspace(0, task.plan.count - 1, TRIED).astype(int))[::-1], list[InputError]()
    for row in task.plan.rows(places):
        try:
            return make(set_numbers(task.scene, task.plan.keys, row))
        except InputError as error:
            errors.append(error)
    raise errors[-1]


def set_numbers(scene: Scene, keys: Sequence[str], row: Array) -> Scene:
    """The scene with these numbers (keys,) at their key paths. Raises InputError for a key that names no number."""
    whole = [int(x) if x.is_integer() and abs(x) < LARGEST_COUNT else x for x in row.tolist()]  # a count takes no float
    try:
        return scene.replace(dict(zip(keys, whole, strict=True)))
    except InputError as error:
        raise InputError(str(error).removeprefix("Scene: ")) from None


# --- a block of cases -----------------------------------------------------------------------------------------------


def run_block(task: Task, begin: int, end: int, stopped: Event | None = None) -> Block:
    """The measures of the cases from `begin` to `end`. Raises Interrupted once `stopped` is set."""
    stopped = stopped or Event()
    rows = task.plan.rows(np.arange(begin, end))
    block = Block(np.full((len(rows), task.columns[-1].stop), np.nan), np.full(len(rows), "", dtype=object))
    done = np.zeros(len(rows), bool)
    if task.batch:
        for series in task.batch.series:
            series.stopped = stopped
        done = task.batch.fill(rows, block)
    for i in np.flatnonzero(~done):
        end_if_stopped(stopped)
        block.values[i], block.why[i] = run_case(task, rows[i], partial(end_if_stopped, stopped))
    return block


def run_case(task: Task, row: Array, progress: ProgressCallback = lambda t: None) -> tuple[Array, str]:
    """The measures (measures,) of the case with these numbers (keys,), simulated on its own, and why there are none."""
    try:
        scene = set_numbers(task.scene, task.plan.keys, row)
        run = looser = run_to_setting(scene, progress=progress)
        if any(m.two for m in task.chosen):  # at a tolerance or accuracy 100 times looser, or a step twice as long
            if scene.solver.step is not None:
                setting = {"step": 2 * scene.solver.step}
            else:
                name = "tolerance" if scene.solver.accuracy is None else "accuracy"
                setting = {name: min(0.1, LOOSER * (getattr(scene.solver, name) or 0.0))}
            looser = run_to_setting(scene.with_solver(**setting), progress=progress)
        return np.concatenate([np.ravel(evaluate_measure(m, run, looser)) for m in task.chosen]), ""
    except Interrupted:
        raise
    except PendpinError as error:
        return np.full(task.columns[-1].stop, np.nan), str(error)


class Batch:
    """The cases of a sweep side by side; `series` are those of its setting, and looser ones or a ladder of settings."""

    def __init__(self, task: Task, scene: Scene) -> None:
        flips = any(m.name.startswith("flip_time") for m in task.chosen)
        self._flips = accumulated(build(scene.model)) if flips else []
        if all(m.ends for m in task.chosen):
            last_times = tuple(scene.clock[[0, -1]].tolist())
            scene = scene.sampled(None, last_times) if scene.solver.times else scene.sampled(2)
        self.task, self.scene, self.ladder, moved = task, scene, None, scene
        keys = [key for key in task.plan.keys if key.startswith("start.")]
        with suppress(PendpinError):  # a start with other numbers, where it is varied
            moved = set_numbers(scene, keys, np.random.default_rng(0).uniform(0.1, 1.0, len(keys)))
        starts = np.array([start_state(build(scene.model), case.start) for case in (scene, moved)])
        made = partial(Series, scene, starts=starts, flips=self._flips)
        if scene.solver.accuracy:
            self.ladder = Ladder(scene, made)
            self.series = self.ladder.series[::-1]
        else:
            fine = scene.solver.tolerance or 0.0
            looser = [min(0.1, LOOSER * fine)] if any(m.two for m in task.chosen) else []
            self.series = [made(tolerance) for tolerance in (fine, *looser)]
        # Where in (q, v) each key belongs, if all are angles or rates of the start in radians: then no scene is made.
        model, paths = self.series[0].dynamics.model, [parsed(key) for key in task.plan.keys]
        self._state, self._joints = start_state(model, scene.start), None
        states = all(len(path) == 3 and tuple(path[:2]) in STATES for path in paths)
        if states and task.scene.start.unit != "degrees":
            joints = [path[2] if isinstance(path[2], int) else model.index(path[2], "vary") for path in paths]
            self._joints = np.array([path[1] == "velocities" for path in paths], int), np.array(joints)

    def fill(self, rows: Array, block: Block) -> Mask:
        """Put in what the cases with these numbers (k, keys) give; those that went well (k,), the rest is untouched."""
        places, cases = self._cases(rows)
        done = np.zeros(len(rows), bool)
        if cases:
            for piece in cases.pieces(len(self.scene.times)):
                done[places[piece]] = self._fill_piece(rows, places[piece], cases.some(piece), block)
        return done

    def _cases(self, rows: Array) -> tuple[Indices, Cases | None]:
        """The cases with these numbers (k, keys), and where they are among them; `simulate` has to look at the others."""
        if self._joints is not None:
            states = np.tile(self._state, (len(rows), 1, 1))
            states[:, *self._joints] = rows
            places = np.flatnonzero(np.all(np.abs(states) <= [[FARTHEST], [LARGEST]], axis=(1, 2)))
            return places, self.series[0].started(*np.moveaxis(states[places], 1, 0)) if len(places) else None
        cases = dict[int, Cases]()
        for place, row in enumerate(rows):
            with suppress(PendpinError):  # simulate says why
                if case := self.series[0].case(set_numbers(self.task.scene, self.task.plan.keys, row)):
                    cases[place] = case
        if not cases:
            return np.array([], int), None
        models, *numbers = zip(*cases.values(), strict=True)
        return np.array([*cases]), Cases([model for (model,) in models], *map(np.concatenate, numbers))

    def _fill_piece(self, rows: Array, places: Indices, cases: Cases, block: Block) -> Mask:
        """Put in the measures of c cases, which are at `places` (c,) of the numbers (k, keys); which went well (c,)."""
        if self.ladder:
            *runs, good = self.ladder.run(cases)
        else:
            runs, good = [series.run(cases, self.scene.times) for series in self.series], np.ones(len(cases.q), bool)
        runs = [run._replace(t=self.scene.clock) for run in runs]
        for run in runs:
            good &= run.finite
        if self._flips:  # as series on angles, which a thin rod at its pole does not have
            good &= ~_turning_at_poles(cases)
        if all(key.startswith("start") for key in self.task.plan.keys):  # else each case has energies of its own
            good &= ends_well(self.series[0].dynamics, cases, runs[0])
        needs_run = np.zeros((len(good), len(self.task.chosen)), bool)  # which measures positions and rates do not tell
        self._measure(runs, np.flatnonzero(good), places, needs_run, block)
        between = np.array([m.between for m in self.task.chosen])
        closer = np.flatnonzero(good & (needs_run & between).any(1))
        if len(closer) and not self.ladder and len(self.scene.times) > 1:  # samples do not tell what is between them
            times, clock = (subdivided(x, CLOSER) for x in (self.scene.times, self.scene.clock))
            some = cases.some(closer)
            for piece in some.pieces(len(times)):
                runs_between = [series.run(some.some(piece), times)._replace(t=clock) for series in self.series]
                measured = np.zeros((len(piece), len(between)), bool) | ~between
                self._measure(runs_between, np.arange(len(piece)), places[closer[piece]], measured, block)
                needs_run[closer[piece]] &= measured
        for i in np.flatnonzero(good & needs_run.any(1)).tolist():
            if self.series[0].stopped.is_set():
                break
            place = int(places[i])
            try:
                whole = [self._complete(rows[place], run, i) for run in runs]
                for k in np.flatnonzero(needs_run[i]).tolist():
                    values = evaluate_measure(self.task.chosen[k], whole[0], whole[-1])
                    block.values[place, self.task.columns[k]] = np.ravel(values)
            except PendpinError as error:
                block.values[place], block.why[place] = np.nan, str(error)
        return good

    def _measure(self, runs: list[Motions], good: Indices, places: Indices, needs_run: Mask, block: Block) -> None:
        """Put in the measures of motions `good` (k,) of c cases at `places` (c,), or set where it `needs_run` (c, k)."""
        for k, (m, columns) in enumerate(zip(self.task.chosen, self.task.columns, strict=True)):
            if needs_run[:, k].all():
                continue
            values = None
            with suppress(LookupError):  # a series of something else than an angle
                values = m.of_motion(*runs[: 1 + m.two]) if m.of_motion else None
            if values is not None:
                block.values[places[good], columns] = values.reshape(len(places), -1)[good]
            needs_run[:, k] = np.isnan(values) if m.between and values is not None else values is None

    def _complete(self, row: Array, motions: Motions, place: int) -> RunRecord:
        """The run of case `place` of a batch, with forces and energies; its numbers are row (keys,)."""
        scene = set_numbers(self.scene, self.task.plan.keys, row).by("taylor", self.series[0].tolerance)
        dynamics = self.series[0].bound(scene)
        dynamics.use_compiled_samples()
        version, steps = installed("heyoka")["heyoka"] or "", int(motions.steps[place])
        run = Run.at_states(scene.times, motions.q[place], motions.v[place])
        run = replace(run, steps=steps, evaluations=steps, library="heyoka", version=version)
        return fill_in(scene, dynamics, None, run)


def _turning_at_poles(cases: Cases) -> Mask:
    """Which cases (c,) start with a thin rod at its pole, and not in the plane of phi alone."""
    rods = cases.models[0].rods
    thetas, phis = [rod.theta for rod in rods if rod.theta >= 0], [rod.phi for rod in rods if rod.phi >= 0]
    off_plane = np.any(cases.q[:, thetas], 1) | np.any(cases.v[:, thetas], 1)
    at_pole = np.asarray(off_plane & np.any(np.abs(np.cos(cases.q[:, phis])) < AT_POLE, 1))
    for i in np.flatnonzero(at_pole).tolist():
        at_pole[i] = cases.models[i].thin_at_pole(cases.q[i], AT_POLE) is not None
    return at_pole


class Ladder:
    """Accuracy as the target for cases side by side: series from coarse to fine, made by `make` for a tolerance.

    A case is done when the estimate from its last three runs meets the target; the rest is left to the search for one case.
    """

    def __init__(self, scene: Scene, make: Callable[[float], Series]) -> None:
        self._target, self._every = scene.solver.accuracy or 0.0, choose_density(scene)
        self._times = sample_closely(scene, self._every).times
        self._refinement = refine_by_tolerance(TAYLOR, self._target)
        first = min(VECTOR.coarser * self._target, SETTING.loosest)
        settings = [first / VECTOR.finer**i for i in range(VECTOR.most_series)]
        self.series = [make(setting) for setting in settings if setting >= self._refinement.least]

    def run(self, cases: Cases) -> tuple[Motions, Motions, Mask]:
        """Motions at the output times, those of tolerances 100 times looser, and which cases (c,) meet the target."""
        runs = [series.run(cases, self._times) for series in self.series[:3]]
        met = self._met(cases, runs, self.series[0].tolerance)
        for coarsest, series in zip(self.series[1:], self.series[3:], strict=False):
            if not len(left := np.flatnonzero(~met)):
                break
            few = cases.some(left)
            finer = [*(run.some(left) for run in runs[1:]), series.run(few, self._times)]
            met[left] = self._met(few, finer, coarsest.tolerance)
            for whole, part in zip(runs, finer, strict=True):
                whole.put(left, part)
        every = slice(None, None, self._every)
        looser, finest = (run._replace(t=run.t[every], q=run.q[:, every], v=run.v[:, every]) for run in runs[-2:])
        return finest, looser, met

    @np.errstate(invalid="ignore")  # a case that cannot be integrated to its end does not meet the target
    def _met(self, cases: Cases, runs: Sequence[Motions], coarsest: float) -> Mask:
        """Whether the error of the last of three runs of each case (c,), with rounding, is within the target."""
        points = [evaluate_each(marks_at, run.models, run.q) for run in runs]
        met = np.zeros(len(cases.q), bool)
        for i, model in enumerate(cases.models):
            coarse, middle, fine = (of_case[i] for of_case in points)
            length = choose_length(model, fine)
            pairs = ((coarse, middle), (middle, fine))
            first, second = (np.maximum.accumulate(tip_distance(*pair, length)) for pair in pairs)
            gaps = Gaps(first, second, (VECTOR.finer, VECTOR.finer), self._refinement.pace, self._refinement.scatter)
            steps = first / (VECTOR.step_error * coarsest)
            rounding = ROUNDING.start_units * EPS * (1 + np.abs(runs[-1].q[i]).max() + steps)
            size = float(tip_distance(fine, fine[:1], length).max())
            alike = not second.any() and np.abs(runs[-1].v[i]).any()  # says nothing of the error
            error = estimate_error(gaps, size, rounding, ESTIMATE.negligible * self._target).error[-1]
            met[i] = error <= self._target and not alike
        return met
