"""The settings of a method from coarse to fine, and how much smaller the error of each should be."""

import math
from dataclasses import dataclass

import numpy as np

from pendpin.arrays import Array
from pendpin.scene import least_tolerance

LOOSEST = 1e-2  # tolerance of a first run
MOST_STEPS = 1e7  # of one run
TAYLOR = "taylor"
WHOLE = 1.0 - 1e-9  # rounding of a number of steps
ORDERS = {"gauss2": 2.0, "gauss4": 4.0, "gauss6": 6.0, "rk4": 4.0, "euler": 1.0}


@dataclass(frozen=True)
class Refinement:
    """The settings of one method, a tolerance or a step; errors should fall with their power `order`.

    A step is a whole fraction of `spacing`, the longest time between samples, so that the steps taken equal the setting
    and different settings give different runs.
    """

    method: str
    first: float  # the coarsest setting
    least: float  # the finest there is; 0 for steps, which end at MOST_STEPS
    order: float = 1.0
    usual: float = 30.0  # how much smaller the next error should be, without an estimate
    smallest: float = 10.0  # the least such factor: with a smaller one two runs may be equal
    pace: float = 0.85  # the expected fraction of the order
    spacing: float | None = None  # s, of steps

    def finer(self, setting: float, factor: float) -> float:
        """The setting with an error smaller by about `factor`; never below the least."""
        ratio = max(factor, self.smallest) ** (1 / self.order)
        if self.spacing is not None:
            count = round(self.spacing / setting)
            return self.spacing / max(count + 1, math.ceil(count * ratio * WHOLE))
        found = setting / ratio
        return self.least if found < self.least * math.sqrt(self.smallest) else found

    def promised(self, coarse: float, fine: float) -> float:
        """How much smaller the error of the finer setting should be."""
        return (coarse / fine) ** self.order


def by_tolerance(method: str, accuracy: float) -> Refinement:
    """The tolerances of an adaptive method. The error of a power series jumps with its order, from 5 to 1000 a hundredth."""
    least = least_tolerance(method)
    if method == TAYLOR:
        first = min(max(1e3 * accuracy, 1e4 * least), LOOSEST)
        return Refinement(method, first, least, usual=100.0, smallest=100.0, pace=0.25)
    return Refinement(method, min(max(100 * accuracy, 300 * least), LOOSEST), least, pace=0.7)


def by_step(method: str, times: Array, wanted: int) -> Refinement:
    """The steps of a method with fixed ones over output times (n,) in s; the first takes about `wanted` steps in all."""
    spacing = float(np.diff(times).max())
    first = spacing / max(1, math.ceil(wanted * spacing / float(times[-1] - times[0])))
    return Refinement(method, first, 0.0, ORDERS[method], smallest=4.0, spacing=spacing)
