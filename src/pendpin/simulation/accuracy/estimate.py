"""An estimate of the error of the finest of three runs of one scene, each finer than the one before.

The estimate is valid if the gaps between runs are small compared with the motion, and if the gap between the last two
runs is smaller than that between the first two, as the order of the method predicts. Runs that agree much better than
necessary are accepted even if the gaps do not fall. The effect of rounding is not part of the gaps and is added.
"""

from dataclasses import dataclass

import numpy as np

from pendpin.arrays import Array

SLOWEST = 0.5  # of the expected order: gaps that fall more slowly give no estimate
SMALL = 0.1  # of the motion: larger gaps give no estimate
DISAGREEMENT = 10.0  # times the larger gap: the error of runs that agree, but not as their order promises
NOISE = 4.0  # times the rounding: smaller gaps need not fall


@dataclass(frozen=True, eq=False)
class Gaps:
    """Largest distances so far between three runs, over the length, at n output times; inf after the end of a run."""

    first: Array  # (n,), of the coarsest to the next
    second: Array  # (n,), of that to the finest
    promised: tuple[float, float]  # by what factor the error of the later run of each pair should be smaller
    pace: float  # the expected fraction of the order

    @property
    def fallen(self) -> float:
        """By what factor the gap has fallen; nan if both gaps are 0."""
        with np.errstate(all="ignore"):
            return float(self.first[-1] / self.second[-1])


@dataclass(frozen=True, eq=False)
class Estimate:
    """The error of the finest run, over the length, and whether the estimate is valid."""

    gaps: Gaps
    error: Array  # (n,), never falling; inf where there is no estimate
    small: bool  # whether the gaps are small compared with the motion
    regular: bool  # whether the gaps fall as predicted


def estimate(gaps: Gaps, size: float, rounding: Array, negligible: float) -> Estimate:
    """The error from the gaps, the size of the motion, the rounding error (n,), and a gap that is always small enough.

    All are divided by the length.
    """
    one, two, noise = gaps.first, gaps.second, NOISE * rounding
    larger = np.maximum(one, two)
    small = (larger <= max(SMALL * size, negligible)) | (larger <= noise)
    with np.errstate(all="ignore"):
        speed = np.log(one / two) / np.log(gaps.promised[0])
    regular = (speed >= SLOWEST * gaps.pace) | (two <= noise)
    power = np.clip(np.where(one <= noise, gaps.pace, speed), SLOWEST * gaps.pace, gaps.pace)
    fall = gaps.promised[1] ** power
    expected = np.where(
        one <= noise, one, one / gaps.promised[0] ** np.clip(speed, power, 1.0)
    )  # no accidental agreement
    from_order = np.maximum(two / (fall - 1), expected / fall)
    error = np.minimum(np.where(regular, from_order, np.inf), DISAGREEMENT * larger)
    error = np.where(small, error, np.inf) + rounding
    return Estimate(gaps, np.maximum.accumulate(error), bool(small[-1]), bool(regular[-1]))
