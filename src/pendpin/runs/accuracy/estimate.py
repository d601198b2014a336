"""An estimate of the error of the finest of three runs of one scene, each finer than the one before.

Errors fall with a power of the setting, on the whole the promised one, and each is off that law by a factor: with falls
f1, f2 and the scatter s, e2 <= e1 s / f1 and e3 <= e2 s / f2. The gaps g1 >= e1 - e2 and g2 >= e2 - e3 then give
    e3 <= g2 s / (f2 - s),    e3 <= g1 s / (f1 - s) s / f2,
and the larger of the two is the estimate: because of the second one, two runs that agree by chance do not look exact. It is
valid if the gaps are small compared with the motion, and fall as the order of the method predicts, unless runs agree much
better than necessary. What no run can show is a force of a user's own that acts for less than all steps: notes say what is
assumed.

Rounding is not part of the gaps and is added. A run is shifted by many units of rounding at its start and later: its
distance from another run shows how much the motion magnifies rounding errors. The later shifts are needed: a rod that falls
from near upright returns to it, and rounding of its speed at the bottom then matters most. The errors of the steps add up
like a random walk. Every later shift is away from 0, so that the shifts add up: shifts in random directions may cancel where
they count, and the estimate was up to 260 times too small then. Mirrored motions get mirrored shifts, and the same estimate.
The first, coarsest run of a search is shifted by a small part of the target: its distance from the next run is a bound that
costs nothing. Where it is too large, rounding is measured alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pendpin.dynamics.pace import declared_smooth
from pendpin.effects import Effect, Torque
from pendpin.ground.arrays import EPS, Array
from pendpin.runs.accuracy.runs import Attempt, Ruler, Runs
from pendpin.runs.accuracy.thresholds import ESTIMATE, INSTABILITY, ROUNDING
from pendpin.scene import Scene, Start
from pendpin.trajectory import RunRecord


@dataclass(frozen=True, eq=False)
class Gaps:
    """Largest distances so far between three runs, over the length, at n output times; inf after the end of a run."""

    first: Array  # (n,), of the coarsest to the next
    second: Array  # (n,), of that to the finest
    promised: tuple[float, float]  # by what factor the error of the later run of each pair should be smaller
    pace: float  # the expected power of that factor
    scatter: float  # the largest factor between two errors and their power law

    @property
    def fallen(self) -> float:
        """By what factor the gap has fallen; nan if both gaps are 0."""
        with np.errstate(all="ignore"):
            return float(self.first[-1] / self.second[-1])

    @property
    def distinct(self) -> bool:
        """Whether the settings are so far apart that the errors must fall, and the gaps bound them."""
        return min(self.promised) ** self.pace > (1 + 1 / ESTIMATE.disagreement) * self.scatter


@dataclass(frozen=True, eq=False)
class Estimate:
    """The error of the finest run, over the length, and whether the estimate is valid."""

    gaps: Gaps
    error: Array  # (n,), never falling; inf where there is no estimate
    small: bool  # whether the gaps are small compared with the motion
    regular: bool  # whether the gaps fall as predicted

    @property
    def lost(self) -> bool:
        """Whether the gaps are large and do not fall: the runs have nothing in common at their ends."""
        return not self.small and self.gaps.fallen < ESTIMATE.smallest_fall


def estimate_error(gaps: Gaps, size: float, rounding: Array, negligible: float, safety: float = 1.0) -> Estimate:
    """The error from gaps, the size of the motion, rounding (n,) and a gap that is small enough, all over the length."""
    noise, slowest, scatter = ESTIMATE.noise * rounding, ESTIMATE.slowest * gaps.pace, gaps.scatter
    larger = np.maximum(gaps.first, gaps.second)
    small = (larger <= max(ESTIMATE.small * size, negligible)) | (larger <= noise)
    with np.errstate(all="ignore"):
        seen = np.log(gaps.first / gaps.second) / np.log(gaps.promised[0])
        power = np.where(gaps.first <= noise, gaps.pace, seen)
        regular = (power >= slowest) | (gaps.second <= noise)
        power = np.clip(power, slowest, 1.0)
        powers = zip(gaps.promised, (power, np.minimum(power, gaps.pace)), strict=True)
        before, last = (np.maximum(promised**p, scatter) for promised, p in powers)
        from_first = gaps.first * scatter / (before - scatter) * scatter / last
        error = np.where(regular, np.maximum(gaps.second * scatter / (last - scatter), from_first), np.inf)
    error = np.where(small & gaps.distinct, np.minimum(error, ESTIMATE.disagreement * larger), np.inf)
    return Estimate(gaps, np.maximum.accumulate(safety * error + rounding), bool(small[-1]), bool(regular[-1]))


def list_assumptions(effects: Sequence[Effect]) -> tuple[str, ...]:
    """A note on each effect of the user's own that does not declare that it is smooth, or that it is not."""
    notes = []
    for i, effect in enumerate(effects):
        if effect.idle or (smooth := declared_smooth(effect)):
            continue
        name, declaration = f"effects[{i}] ({effect.kind})", "gradual" if isinstance(effect, Torque) else "smooth"
        if smooth is False:
            note = f"{name} is not smooth: the estimated error assumes that no step jumps over what it does"
        else:
            assumed = "the estimated error assumes it, and what acts within a short step may be missed"
            note = f"{name} does not declare that it is smooth in positions and rates: {assumed}"
            note += f"; if it is, declare `{declaration}`"
        notes.append(note)
    return tuple(notes)


# --- rounding --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class RoundingError:
    """The rounding error of a run, over the length, and how much the motion magnifies errors until its end."""

    error: Array  # (n,), inf after the end of a run
    growth: float  # of an error of the start
    path: float  # the farthest that a tip may have moved, over the length

    @property
    def last(self) -> float:
        """The error at the end of the run."""
        return float(self.error[-1])

    def magnified_beyond(self, error: float) -> bool:
        """Whether the error is larger, and grows faster than a small error of the rates does in any steady motion."""
        return self.last > error and self.growth > INSTABILITY.steady_growth * self.path


def run_first(runs: Runs, scene: Scene, target: float) -> tuple[RunRecord, float]:
    """The first run of a search, shifted by a part of the target, and by how many units of rounding."""
    q, v = runs.start
    shift = min(ROUNDING.first_shift * target, ROUNDING.largest_first_shift)
    units = shift / EPS / max(1.0, float(np.abs(q).max()))
    states = np.zeros(1), q[None], v[None]
    return _run_shifted(runs, scene, states, scene.duration / ROUNDING.first_steps, units), units


def bound_rounding(gap: Array, units: float, fine: RunRecord, ruler: Ruler) -> RoundingError:
    """A bound (n,) on the rounding error of the run `fine`, from the gap (n,) of the first two runs; over the length."""
    growth = np.where(gap > ROUNDING.linear, np.inf, gap / (units * EPS))
    return _scale_growth(growth, fine, ruler)


def measure_rounding(runs: Runs, coarse: Attempt, fine: Attempt, target: float, ruler: Ruler) -> RoundingError:
    """The rounding error of the run `fine` at the times of `runs` (n,), over the length, measured beside a coarser run."""
    best, times, units = fine.run, ROUNDING.enlargement, _count_units(fine.run)
    gap = ruler.measure_gap(coarse.run, _run_like(runs, coarse.scene, best, times * units))
    if gap[-1] > ROUNDING.linear and target > ROUNDING.linear / ROUNDING.enlargement:
        times = ROUNDING.linear / target  # smaller shifts, beside a run in the same segments without any
        still, shifted = (_run_like(runs, fine.scene, best, x * units) for x in (0.0, times))
        gap = ruler.measure_gap(still, shifted)
        changed = ruler.measure_gap(best, still) > ROUNDING.linear  # segments alone change the run
        gap = np.where(changed, np.inf, gap)
    return _scale_growth(gap / (times * units * EPS), best, ruler)


def measure_rounding_of_lost_run(runs: Runs, lost: Attempt, target: float, ruler: Ruler) -> RoundingError:
    """The rounding error (n,) of a motion such as that of a run that is itself wrong, over the length."""
    times, units = min(ROUNDING.enlargement, ROUNDING.linear / target), _count_units(lost.run)
    still, shifted = (_run_like(runs, lost.scene, lost.run, x * units) for x in (0.0, times))
    gap = ruler.measure_gap(still, shifted)
    return RoundingError(gap / times, float(gap[-1] / (times * units * EPS)), 0.0)


def _scale_growth(growth: Array, run: RunRecord, ruler: Ruler) -> RoundingError:
    """The rounding error of a run whose motion magnifies errors of the start by `growth` (n,), over the length."""
    times = run.t[np.minimum(ruler.places, len(run.t) - 1)] - run.t[0]
    path = np.where(times > 0, times * ruler.measure_speeds(run), 0.0)
    walk = ROUNDING.walk_units * float(np.sqrt(run.stats.steps))
    # Rounded numbers of the model make a motion a little faster or slower: that error grows with the path.
    error = EPS + (ROUNDING.model_units + walk) * EPS * path + growth * _count_units(run) * EPS
    return RoundingError(error, float(growth[-1]), float(path[-1]))


def _count_units(run: RunRecord) -> float:
    return ROUNDING.start_units + ROUNDING.step_units * float(np.sqrt(run.stats.steps))


def _run_like(runs: Runs, scene: Scene, run: RunRecord, units: float) -> RunRecord:
    """A run of the scene, shifted by so many units of rounding of a run like it."""
    some = np.unique(np.linspace(0, len(run.t) - 1, ROUNDING.states).astype(int))
    step = (run.t[-1] - run.t[0]) / max(run.stats.steps, 1)
    return _run_shifted(runs, scene, (run.t[some] - run.t[0], run.q[some], run.v[some]), step, units)


def _run_shifted(runs: Runs, scene: Scene, states: tuple[Array, ...], step: float, units: float) -> RunRecord:
    """A run shifted by so many units of rounding at its start and at later times; with contacts at the start alone."""
    (t, q, v), (q0, v0), contacts = states, runs.start, runs.dynamics.contacts
    # Units of the largest values among states t (n,), q, v (n, nv); in the rates also of the accelerations over a step.
    both = np.concatenate([q * (1 + EPS), q]), np.concatenate([v * (1 - EPS), v])
    rounded, exact = np.split(runs.dynamics.sample(np.tile(t, 2), *both)[0], 2)
    dq, dv = EPS * np.abs(q).max(0), EPS * np.abs(v).max(0) + step * np.abs(rounded - exact).max(0)
    # Directions from 0.5 to 1, always the same, times the signs of the motion, with which they are mirrored.
    draws = (np.random.default_rng(seed) for seed in (1, 2))
    ahead, aside = (draw.uniform(0.5, 1, len(q0)) * draw.choice([-1.0, 1.0], len(q0)) for draw in draws)
    ahead = np.where(q0 == 0, ahead * np.where(v0 < 0, -1.0, 1.0), np.sign(q0))
    aside = aside * np.where(np.where(v0 == 0, q0, v0) < 0, -1.0, 1.0)
    positions = q0 - units * dq * ahead  # towards 0: never beyond the farthest
    if contacts is not None:
        positions = np.clip(positions, contacts.lower, contacts.upper)  # else it would be moved to its stop
    start = Start.at_state(scene.start.time, positions, v0 + units * dv * aside)
    shifts = units * EPS, max(1, len(runs.times) // ROUNDING.later_shifts)
    return runs.run(scene.model_copy(update={"start": start}), shifts=shifts)
