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

from pendpin.ground.arrays import EPS, Array
from pendpin.model.kinematics import marks_at, tip_distance
from pendpin.runs.accuracy.runs import Attempt, Ruler, Runs
from pendpin.runs.accuracy.thresholds import INSTABILITY, ROUNDING
from pendpin.runs.checkpoint import Shifts
from pendpin.runs.run import complete
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
    q, _ = runs.start
    shift = min(ROUNDING.first_shift * target, ROUNDING.largest_first_shift)
    units = shift / EPS / max(1.0, float(np.abs(q).max()))
    states = np.zeros(1), *(x[None] for x in runs.start)
    shifted = _shift_start(runs, scene, states, scene.duration / ROUNDING.first_steps, units)
    return runs.run(shifted, shifts=_plan_later_shifts(units, len(runs.times))), units


def bound_rounding(gap: Array, units: float, fine: RunRecord, ruler: Ruler) -> RoundingError:
    """A bound (n,) on the rounding error of the run `fine`, from the gap (n,) of the first two runs; over the length."""
    growth = np.where(gap > ROUNDING.linear, np.inf, gap / (units * EPS))
    return _scale_growth(growth, fine, ruler)


def measure_rounding(runs: Runs, coarse: Attempt, fine: Attempt, target: float, ruler: Ruler) -> RoundingError:
    """The rounding error of the run `fine` at the times of `runs` (n,), over the length.

    It is measured beside the run `coarse`, which costs less. If shifts of many times the rounding move that too far,
    smaller ones are compared with `fine` in the same segments and without shifts.
    """
    best, times, units = fine.run, ROUNDING.enlargement, _count_units(fine.run)
    gap = ruler.measure_gap(coarse.run, _run_shifted(runs, coarse.scene, best, times * units))
    if gap[-1] > ROUNDING.linear and target > ROUNDING.linear / ROUNDING.enlargement:
        times = ROUNDING.linear / target
        still, shifted = _run_pair(runs, fine, times)
        gap = ruler.measure_gap(still, shifted)
        changed = ruler.measure_gap(best, still) > ROUNDING.linear  # segments alone change the run
        gap = np.where(changed, np.inf, gap)
    return _scale_growth(gap / (times * units * EPS), best, ruler)


def measure_rounding_of_lost_run(runs: Runs, lost: Attempt, target: float, ruler: Ruler) -> RoundingError:
    """The rounding error (n,) of a motion such as that of a run that is itself wrong, over the length."""
    times = min(ROUNDING.enlargement, ROUNDING.linear / target)
    still, shifted = _run_pair(runs, lost, times)
    gap = ruler.measure_gap(still, shifted)
    return RoundingError(gap / times, float(gap[-1] / (times * _count_units(lost.run) * EPS)), 0.0)


def compute_start_rounding(runs: Runs, ruler: Ruler) -> float:
    """How far half a unit of rounding of the start's positions moves the tips, over the length."""
    q, _ = runs.start
    exact, rounded = (marks_at(ruler.model, x[None]) for x in (q, q - EPS / 2 * q))
    return float(tip_distance(exact, rounded, ruler.length)[0])


def _scale_growth(growth: Array, run: RunRecord, ruler: Ruler) -> RoundingError:
    """The rounding error of a run whose motion magnifies errors of the start by `growth` (n,), over the length.

    Rounded numbers of the model make a motion a little faster or slower: that error grows with the path.
    """
    speeds = ruler.measure_speeds(run)
    times = run.t[np.minimum(ruler.places, len(run.t) - 1)] - run.t[0]
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
    states = fine.t[some] - fine.t[0], fine.q[some], fine.v[some]
    return runs.run(_shift_start(runs, scene, states, step, units), shifts=_plan_later_shifts(units, len(runs.times)))


def _plan_later_shifts(units: float, count: int) -> Shifts:
    """Shifts by units of rounding during a run with `count` samples; with contacts there are none after the start."""
    return Shifts(units * EPS, max(1, count // ROUNDING.later_shifts))


def _shift_start(runs: Runs, scene: Scene, states: tuple[Array, ...], step: float, units: float) -> Scene:
    """The scene with its start shifted by so many units of rounding of positions and rates, each that of one step in s.

    They are those of the largest values among states t (n,), q, v (n, nv), and in the rates that of the accelerations.
    """
    (t, q, v), (q0, v0), contacts = states, runs.start, runs.dynamics.contacts
    rounded, exact = (complete(runs.dynamics, t, q * (1 + x * EPS), v * (1 - x * EPS))[0] for x in (1, 0))
    dq, dv = EPS * np.abs(q).max(0), EPS * np.abs(v).max(0) + step * np.abs(rounded - exact).max(0)
    ahead = np.where(q0 == 0, _draw_directions(len(q0), 1) * _find_signs(v0), np.sign(q0))
    positions = q0 - units * dq * ahead  # towards 0: never beyond the farthest
    if contacts is not None:
        positions = np.clip(positions, contacts.lower, contacts.upper)  # else it would be moved to its stop
    rates = v0 + units * dv * _draw_directions(len(v0), 2) * _find_signs(np.where(v0 == 0, q0, v0))
    start = Start(time=scene.start.time, positions=tuple(positions.tolist()), velocities=tuple(rates.tolist()))
    return scene.model_copy(update={"start": start})


def _draw_directions(count: int, seed: int) -> Array:
    """Numbers (count,) from 0.5 to 1 with either sign, always the same."""
    random = np.random.default_rng(seed)
    return random.uniform(0.5, 1, count) * random.choice([-1.0, 1.0], count)


def _find_signs(x: Array) -> Array:
    """1 or -1 for each number (n,), 1 for 0: what it is multiplied by is mirrored with the motion."""
    return np.where(x < 0, -1.0, 1.0)
