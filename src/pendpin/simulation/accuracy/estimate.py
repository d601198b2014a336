"""What three runs of one scene, each finer than the one before, tell about the error of the last.

An estimate is believed where it behaves: the gaps are small beside the motion, and that between the last two runs is
smaller than that between the first two, as the order of the method promises. Runs that agree far better than they have to
are believed as well, whether gaps fall or not. What rounding does to the motion is no part of these gaps and is added.
"""

from dataclasses import dataclass

import numpy as np

from pendpin.arrays import Array

SLOWEST = 0.5  # of the order that is reckoned with: errors that fall more slowly are not understood
SMALL = 0.1  # of the motion: a larger gap says nothing
DISAGREEMENT = 10.0  # times the larger gap: the error of runs that agree, but not as their order promises
NOISE = 4.0  # times the rounding: smaller gaps need not fall


@dataclass(frozen=True, eq=False)
class Gaps:
    """Between three runs: the largest so far, over the length, at n output times; inf where a run did not get."""

    first: Array  # (n,), of the coarsest to the next
    second: Array  # (n,), of that to the finest
    promised: tuple[float, float]  # by what factor the error of the later run of each pair should be smaller
    pace: float  # of the order, which is reckoned with

    @property
    def fallen(self) -> float:
        """By what factor the gap has fallen; nan where that says nothing."""
        with np.errstate(all="ignore"):
            return float(self.first[-1] / self.second[-1])


@dataclass(frozen=True, eq=False)
class Estimate:
    """The error of the finest run, over the length, and what stands against it."""

    gaps: Gaps
    error: Array  # (n,), never falling; inf where nothing can be said
    small: bool  # whether the gaps are small beside the motion
    regular: bool  # whether they fall


def estimate(gaps: Gaps, size: float, rounding: Array, negligible: float) -> Estimate:
    """The error from the gaps, the size of the motion, what rounding does to it (n,), and the gap that never matters.

    All over the length.
    """
    one, two, noise = gaps.first, gaps.second, NOISE * rounding
    larger = np.maximum(one, two)
    small = (larger <= max(SMALL * size, negligible)) | (larger <= noise)
    with np.errstate(all="ignore"):
        speed = np.log(one / two) / np.log(gaps.promised[0])
    regular = (speed >= SLOWEST * gaps.pace) | (two <= noise)
    power = np.clip(np.where(one <= noise, gaps.pace, speed), SLOWEST * gaps.pace, gaps.pace)
    falls = [factor**power for factor in gaps.promised]
    from_order = np.maximum(two / (falls[1] - 1), one / (falls[0] * falls[1]))
    error = np.minimum(np.where(regular, from_order, np.inf), DISAGREEMENT * larger)
    error = np.where(small, error, np.inf) + rounding
    return Estimate(gaps, np.maximum.accumulate(error), bool(small[-1]), bool(regular[-1]))
