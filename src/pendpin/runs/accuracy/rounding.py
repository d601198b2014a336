"""The effect of rounding errors of the start, the steps and the accelerations, which the motion may magnify.

A run is shifted by many units of rounding at its start and at later times. Its distance from another run shows how
much the motion magnifies rounding errors. The later shifts are needed: a rod that falls from near upright returns to it, and
rounding of its speed at the bottom then matters most. The errors of the steps add up like a random walk. Every later shift
is away from 0, so that the shifts add up: shifts in random directions may cancel where they count, and the estimate was up
to 260 times too small then. Mirrored motions get mirrored shifts, and the same estimate.

The first, coarsest run of a search is shifted, by a small part of the target: its distance from the next run is that of
their integration errors and of the shifts together, a bound that costs nothing. Where it is too large, rounding is measured
alone.
"""

from dataclasses import dataclass

import numpy as np

from pendpin.dynamics.contacts.contacts import check_start
from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import Engine
from pendpin.ground.arrays import EPS, Array
from pendpin.model.build import build, start_state
from pendpin.model.kinematics import marks_at, tip_distance
from pendpin.runs.accuracy.runs import Attempt, Runs, compute_speeds, measure_gap
from pendpin.runs.accuracy.thresholds import INSTABILITY, ROUNDING
from pendpin.runs.state import Shifts
from pendpin.scene import Scene, Start
from pendpin.trajectory import RunRecord


@dataclass(frozen=True, eq=False)
class RoundingError:
    """The rounding error of a run, over the length, and how much the motion magnifies errors until its end."""

    error: Array  # (n,), inf after the end of a run
    growth: float  # of an error of the start
    path: float  # the farthest that a tip may have moved, over the length

    @property
    def last(self) -> float:
        """The error at the end."""
        return float(self.error[-1])

    def magnified_beyond(self, error: float) -> bool:
        """Whether the error is larger, and grows faster than a small error of the rates does in any steady motion."""
        return self.last > error and self.growth > INSTABILITY.steady_growth * self.path


def run_first(runs: Runs, scene: Scene, target: float) -> tuple[RunRecord, float]:
    """The first run of a search, shifted by a part of the target, and by how many units of rounding."""
    dynamics = runs.prepare(scene).bound
    q, v = start_state(dynamics.model, scene.start)
    shift = min(ROUNDING.first_shift * target, ROUNDING.largest_first_shift)
    units = shift / EPS / max(1.0, float(np.abs(q).max()))
    unit = _compute_unit(dynamics.engine, np.zeros(1), q[None], v[None], scene.duration / ROUNDING.first_steps)
    shifted = _shift_start(scene, dynamics, unit, units)
    return runs.run(shifted, shifts=_plan_later_shifts(units, len(runs.times))), units


def bound_rounding(gap: Array, units: float, fine: RunRecord, length: float) -> RoundingError:
    """A bound (n,) on the rounding error of the run `fine`, from the gap (n,) of the first two runs; over the length."""
    growth = np.where(gap > ROUNDING.linear, np.inf, gap / (units * EPS))
    return _scale_growth(growth, fine, length)


def measure_rounding(runs: Runs, coarse: Attempt, fine: Attempt, target: float, length: float) -> RoundingError:
    """The rounding error of the run `fine` at the times of `runs` (n,), over the length.

    It is measured beside the run `coarse`, which costs less. If shifts of many times the rounding move that too far,
    smaller ones are compared with `fine` in the same segments and without shifts.
    """
    best, times, units = fine.run, ROUNDING.enlargement, _count_units(fine.run)
    gap = measure_gap(coarse.run, _run_shifted(runs, coarse.scene, best, times * units), length, len(runs.times))
    if gap[-1] > ROUNDING.linear and target > ROUNDING.linear / ROUNDING.enlargement:
        times = ROUNDING.linear / target
        still, shifted = _run_pair(runs, fine, times)
        gap = measure_gap(still, shifted, length, len(runs.times))
        changed = measure_gap(best, still, length, len(gap)) > ROUNDING.linear  # segments alone change the run
        gap = np.where(changed, np.inf, gap)
    return _scale_growth(gap / (times * units * EPS), best, length)


def measure_rounding_of_lost_run(runs: Runs, lost: Attempt, target: float, length: float) -> RoundingError:
    """The rounding error (n,) of a motion such as that of a run that is itself wrong, over the length."""
    times = min(ROUNDING.enlargement, ROUNDING.linear / target)
    still, shifted = _run_pair(runs, lost, times)
    gap = measure_gap(still, shifted, length, len(runs.times))
    return RoundingError(gap / times, float(gap[-1] / (times * _count_units(lost.run) * EPS)), 0.0)


def compute_start_rounding(scene: Scene, length: float) -> float:
    """How far half a unit of rounding of the start's positions moves the tips, over the length."""
    model = build(scene.model)
    q, _ = start_state(model, scene.start)
    exact, rounded = (marks_at(model, x[None]) for x in (q, q - EPS / 2 * q))
    return float(tip_distance(exact, rounded, length)[0])


def _scale_growth(growth: Array, run: RunRecord, length: float) -> RoundingError:
    """The rounding error of a run whose motion magnifies errors of the start by `growth` (n,), over the length.

    Rounded numbers of the model make a motion a little faster or slower: that error grows with the path.
    """
    speeds = np.append(compute_speeds(run, length), np.full(len(growth) - len(run.t), np.inf))
    times = np.append(run.t - run.t[0], np.full(len(growth) - len(run.t), np.inf))
    path = np.where(times > 0, times * speeds, 0.0)
    walk = ROUNDING.walk_units * float(np.sqrt(run.stats.steps))
    error = EPS + (ROUNDING.model_units + walk) * EPS * path + growth * _count_units(run) * EPS
    return RoundingError(error, float(growth[-1]), float(path[-1]))


def _count_units(run: RunRecord) -> float:
    """The units of rounding of a run."""
    return ROUNDING.start_units + ROUNDING.step_units * float(np.sqrt(run.stats.steps))


def _run_pair(runs: Runs, attempt: Attempt, times: float) -> tuple[RunRecord, RunRecord]:
    """Two runs in the same segments, the second of them shifted by so many times the rounding."""
    scene, run = attempt.scene, attempt.run
    return _run_shifted(runs, scene, run, 0.0), _run_shifted(runs, scene, run, times * _count_units(run))


def _run_shifted(runs: Runs, scene: Scene, fine: RunRecord, units: float) -> RunRecord:
    """A run of the scene, shifted by so many units of rounding at its start and at later times."""
    some = np.unique(np.linspace(0, len(fine.t) - 1, ROUNDING.states).astype(int))
    step = (fine.t[-1] - fine.t[0]) / max(fine.stats.steps, 1)
    dynamics = runs.prepare(scene).bound
    unit = _compute_unit(dynamics.engine, fine.t[some] - fine.t[0], fine.q[some], fine.v[some], step)
    return runs.run(_shift_start(scene, dynamics, unit, units), shifts=_plan_later_shifts(units, len(runs.times)))


def _plan_later_shifts(units: float, count: int) -> Shifts:
    """Shifts by units of rounding during a run with `count` samples; with contacts there are none after the start."""
    return Shifts(units * EPS, max(1, count // ROUNDING.later_shifts))


def _shift_start(scene: Scene, dynamics: Dynamics, unit: tuple[Array, Array], units: float) -> Scene:
    """The scene with its start shifted by so many units of rounding (nv,) of positions and rates."""
    q, v = start_state(dynamics.model, scene.start)
    dq, dv = unit
    ahead = np.where(q == 0, _draw_directions(len(q), 1) * _find_signs(v), np.sign(q))
    positions = q - units * dq * ahead  # towards 0: never beyond the farthest
    if dynamics.contacts is not None:
        check_start(dynamics.contacts, dynamics.model, q)  # else a start beyond a stop would be moved to it
        positions = np.clip(positions, dynamics.contacts.lower, dynamics.contacts.upper)
    rates = v + units * dv * _draw_directions(len(v), 2) * _find_signs(np.where(v == 0, q, v))
    start = Start(time=scene.start.time, positions=tuple(positions.tolist()), velocities=tuple(rates.tolist()))
    return scene.model_copy(update={"start": start})


def _compute_unit(engine: Engine, t: Array, q: Array, v: Array, step: float) -> tuple[Array, Array]:
    """The rounding errors of one step in positions and rates (nv,), from states q, v (n, nv) at t (n,).

    They are those of the largest values, and in the rates that of the accelerations over a step in s.
    """
    rounded, exact = (engine.evaluate(t, q * (1 + x * EPS), v * (1 - x * EPS)).acceleration for x in (1, 0))
    return EPS * np.abs(q).max(0), EPS * np.abs(v).max(0) + step * np.abs(rounded - exact).max(0)


def _draw_directions(count: int, seed: int) -> Array:
    """Numbers (count,) from 0.5 to 1 with either sign, always the same."""
    random = np.random.default_rng(seed)
    return random.uniform(0.5, 1, count) * random.choice([-1.0, 1.0], count)


def _find_signs(x: Array) -> Array:
    """1 or -1 for each number (n,), 1 for 0: what it is multiplied by is mirrored with the motion."""
    return np.where(x < 0, -1.0, 1.0)
