"""Where the steps of a method with a fixed step end: the step asked is the step taken, wherever the samples are.

A sample inside a step is computed by a shorter step of the same method from the end of the last whole one, which then goes
on as if the sample had not been: it has the order of the method. The last step of a run may so be shorter.
"""

import math
from typing import NamedTuple

from pendpin.ground.arrays import Array
from pendpin.integrators.base import StepPlan

NEAR = 1e-9  # of a step: a sample so near to the end of a step is there


class Block(NamedTuple):
    """Equal steps one after another."""

    start: float  # s
    steps: int
    step: float  # s: the one asked, to the rounding of the times of samples, or a shorter one after a corner


class Way(NamedTuple):
    """From the last stored state to a sample: blocks of steps, and a shorter step from their end to the sample."""

    blocks: tuple[Block, ...]
    start: float  # s, of the shorter step
    left: float  # s, its length; 0 where a step ends at the sample


class GridPlace(NamedTuple):
    """Where the stored state of a method with fixed steps is."""

    origin: float = 0.0  # s, from which steps are counted
    steps: int = -1  # whole ones since then; -1 before the first step of a run
    offset: float = 0.0  # s, behind the origin


class StepGrid:
    """The ends of steps of one size in s, counted from an origin, and how far behind it the stored state is.

    That state is at the end of a step; or inside one, behind a corner of what acts, from which it goes on to that end.
    """

    def __init__(self, step: float, place: GridPlace, t: float, plan: StepPlan) -> None:
        """The steps of the segment before, which ended at `place`, from t in s on; new ones where there was none."""
        self._step = step
        self._origin, self._count, self._offset = (t, 0, 0.0) if place.steps < 0 else place
        if plan.anew and self.inside(t):
            self._offset = t - self._origin

    @property
    def place(self) -> GridPlace:
        """What restores the place."""
        return GridPlace(self._origin, self._count, self._offset)

    def inside(self, t: float) -> bool:
        """Whether t in s is behind the stored state, inside a step."""
        return t != self._origin + self._offset

    def go_to(self, t: float) -> Way:
        """The way to a sample at t in s, and go it.

        Differences are taken from the origin: beside a late time a short one, as that of a pulse, would lose its digits.
        """
        elapsed, blocks = t - self._origin, list[Block]()
        count = max(self._count, count_whole_steps(elapsed, self._step))
        at_end = count > self._count and abs(elapsed - count * self._step) <= NEAR * self._step
        end = elapsed if at_end else count * self._step
        if count > self._count and self._offset > self._count * self._step:  # behind a corner
            first = end if count == self._count + 1 else (self._count + 1) * self._step
            blocks.append(Block(self._origin + self._offset, 1, first - self._offset))
            self._count, self._offset = self._count + 1, first
        if steps := count - self._count:
            blocks.append(
                Block(self._origin + self._offset, steps, (end - self._offset) / steps if at_end else self._step)
            )
            self._count, self._offset = count, end
        start = self._origin + self._offset
        if at_end:
            self._origin, self._count, self._offset = t, 0, 0.0
            return Way(tuple(blocks), start, 0.0)
        return Way(tuple(blocks), start, max(elapsed - self._offset, 0.0))


def count_whole_steps(interval: float, step: float) -> int:
    """How many whole steps fit into an interval, both in s."""
    return math.floor(interval / step + NEAR)


def largest_step(times: Array, step: float | None) -> float | None:
    """The largest step taken over output times (n,) in s: the one asked, or all of a shorter run; None if none is."""
    return None if step is None else min(step, float(times[-1] - times[0]) or step)
