"""The settings of a method from coarse to fine, and how much smaller the error of each should be."""

import math
from dataclasses import dataclass

import numpy as np

from pendpin.arrays import Array
from pendpin.scene import least_tolerance

LOOSEST = 1e-2  # tolerance of a first run
MOST_STEPS = 1e7  # of one run
TAYLOR = "taylor"
RUNGE_KUTTA = ("dop853", "rk45", "rk23")  # their steps change with their first one
IMPLICIT = ("radau", "bdf", "lsoda", "gauss2", "gauss4", "gauss6")  # may agree on a wrong way across a jump
STEADY = ("radau", "bdf", "lsoda", TAYLOR)  # methods that show by themselves what rounding does
WHOLE = 1.0 - 1e-9  # rounding of a number of steps
ORDERS = {"gauss2": 2.0, "gauss4": 4.0, "gauss6": 6.0, "rk4": 4.0, "euler": 1.0}
POWERS = {"dop853": 9.0, "rk45": 6.0, "rk23": 4.0, "radau": 6.0, "bdf": 7.0, "lsoda": 14.0}  # of the step, at most
SCATTER = {"dop853": 2.5, "lsoda": 3.0, "bdf": 2.5, TAYLOR: 2.5}  # measured on random scenes, with a margin
USUAL_SCATTER = 1.5


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
    usual: float = 100.0  # how much smaller the next error should be, without an estimate
    smallest: float = 10.0  # the least such factor: with a smaller one two runs may be equal
    pace: float = 0.85  # the power of the promised factor by which errors fall at least
    scatter: float = USUAL_SCATTER  # the largest factor between two errors and their power law
    spacing: float | None = None  # s, of steps

    def finer(self, setting: float, factor: float) -> float:
        """The setting with an error smaller by about `factor`, or half way to the least where that is too small."""
        if self.method == TAYLOR:  # compiled series are kept: few different ones
            factor = self.smallest ** math.ceil(math.log(max(factor, 1.0), self.smallest) * WHOLE)
        ratio = max(factor, self.smallest) ** (1 / self.order)
        if self.spacing is not None:
            count = round(self.spacing / setting)
            return self.spacing / max(count + 1, math.ceil(count * ratio * WHOLE))
        if setting / ratio >= self.least * self.smallest:
            return setting / ratio
        middle = math.sqrt(setting * self.least)
        return middle if middle >= self.least * self.smallest**2 else self.least

    def promised(self, coarse: float, fine: float, more: float = math.inf) -> float:
        """How much smaller the error of the finer setting should be, with so many times `more` steps.

        A tolerance that does not change the steps, as where a fast effect bounds them, promises nothing.
        """
        factor = (coarse / fine) ** self.order
        return min(factor, more ** POWERS[self.method]) if self.method in POWERS else factor

    def too_many(self, steps: float, seconds: float) -> str:
        """What is said of a run of more than MOST_STEPS."""
        order = f" is of order {self.order:g} and" if self.spacing else ""
        return (
            f"{self.method}{order} would take about {steps:.0e} steps, {_duration(seconds)}; take a method of higher order, "
            "such as dop853"
        )


def _duration(seconds: float) -> str:
    for unit, size in (("days", 86_400.0), ("hours", 3_600.0), ("minutes", 60.0)):
        if seconds > 2 * size:
            return f"about {seconds / size:.0f} {unit}"
    return f"about {seconds:.0f} s"


def by_tolerance(method: str, accuracy: float, turned: float = 1.0) -> Refinement:
    """The tolerances of an adaptive method, which are relative to angles of up to `turned` rad.

    The error of a power series jumps with its order, from 5 to 1000 a hundredth.
    """
    least, scatter = least_tolerance(method), SCATTER.get(method, USUAL_SCATTER)
    large = 10.0 ** math.floor(math.log10(max(turned, 1.0)))
    first = max(min((1e3 if method == TAYLOR else 100) * accuracy, LOOSEST) / large, 1e4 * least)
    if method == TAYLOR:
        return Refinement(method, first, least, smallest=100.0, pace=0.5, scatter=scatter)
    return Refinement(method, first, least, pace=0.7, scatter=scatter)


def by_step(method: str, times: Array, wanted: int) -> Refinement:
    """The steps of a method with fixed ones over output times (n,) in s; the first takes about `wanted` steps in all."""
    spacing = float(np.diff(times).max())
    first = spacing / max(1, math.ceil(wanted * spacing / float(times[-1] - times[0])))
    return Refinement(method, first, 0.0, ORDERS[method], usual=30.0, smallest=4.0, spacing=spacing)
