"""An estimate of the error of the finest of three runs of one scene, each finer than the one before.

Errors fall with a power of the setting, on the whole the promised one, and each is off that law by a factor: with falls
f1, f2 and the scatter s, e2 <= e1 s / f1 and e3 <= e2 s / f2. The gaps g1 >= e1 - e2 and g2 >= e2 - e3 then give
    e3 <= g2 s / (f2 - s),    e3 <= g1 s / (f1 - s) s / f2,
and the larger of the two is the estimate: by the second, two runs that agree by accident are no evidence.
It is valid if the gaps are small compared with the motion, and fall as the order of the method predicts. Runs that agree
much better than necessary are accepted even if the gaps do not fall. The effect of rounding is not part of the gaps and is
added. What no run can show is a force of a user's own that acts for less than all steps: notes name what is assumed of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pendpin.dynamics.timing import declared_smooth, users_own
from pendpin.effects import Effect, Torque
from pendpin.ground.arrays import Array
from pendpin.runs.accuracy.thresholds import ESTIMATE


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
    """The error from the gaps, the size of the motion, the rounding error (n,), and a gap that is always small enough.

    All are divided by the length. The error that follows from the gaps is multiplied by `safety`.
    """
    noise, slowest = ESTIMATE.noise * rounding, ESTIMATE.slowest * gaps.pace
    larger = np.maximum(gaps.first, gaps.second)
    small = (larger <= max(ESTIMATE.small * size, negligible)) | (larger <= noise)
    with np.errstate(all="ignore"):
        seen = np.log(gaps.first / gaps.second) / np.log(gaps.promised[0])
        power = np.where(gaps.first <= noise, gaps.pace, seen)
        regular = (power >= slowest) | (gaps.second <= noise)
        error = np.where(regular, _bound_error(gaps, np.clip(power, slowest, 1.0)), np.inf)
    error = np.where(small & gaps.distinct, np.minimum(error, ESTIMATE.disagreement * larger), np.inf)
    return Estimate(gaps, np.maximum.accumulate(safety * error + rounding), bool(small[-1]), bool(regular[-1]))


def _bound_error(gaps: Gaps, power: Array) -> Array:
    """The error (n,) from both gaps, which have fallen with a power (n,) of what is promised."""
    scatter, powers = gaps.scatter, (power, np.minimum(power, gaps.pace))
    before, last = (np.maximum(promised**p, scatter) for promised, p in zip(gaps.promised, powers, strict=True))
    from_first = gaps.first * scatter / (before - scatter) * scatter / last
    return np.maximum(gaps.second * scatter / (last - scatter), from_first)


def list_assumptions(effects: Sequence[Effect]) -> tuple[str, ...]:
    """A note on each effect of the user's own that does not declare that it is smooth, or that it is not."""
    own = [(i, effect) for i, effect in enumerate(effects) if users_own(effect) and not effect.idle]
    return tuple(_note(f"effects[{i}] ({effect.kind})", effect) for i, effect in own if not declared_smooth(effect))


def _note(name: str, effect: Effect) -> str:
    if declared_smooth(effect) is False:
        return f"{name} is not smooth: the estimated error assumes that no step jumps over what it does"
    declaration = "gradual" if isinstance(effect, Torque) else "smooth"
    return (
        f"{name} does not declare that it is smooth in positions and rates: the estimated error assumes it, and what acts "
        f"within a short step may be missed; if it is, declare `{declaration}`"
    )
