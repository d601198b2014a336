"""What every lane offers."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

from pendpin.derivations.base import Array
from pendpin.engines import Derivative


@dataclass(frozen=True)
class Stretch:
    """The states at the output times of one stretch, and what they took."""

    y: Array  # (n, 2 nv); shorter than the times where the lane had to stop
    steps: int
    failure: str | None = None  # why the lane had to stop


class Lane(ABC):
    """One integrator with its setting; `library` and `version` say who carries it."""

    library: str
    version: str

    @abstractmethod
    def integrate(self, derivative: Derivative, y: Array, times: Array, first_step: float | None) -> Stretch:
        """The states at `times` (n,), from y at times[0]; `first_step` in s is a proposal, where there is one."""
