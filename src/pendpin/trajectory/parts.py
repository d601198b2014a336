"""The further results of a run: joint reactions, energy, and counts and times."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pendpin.ground.arrays import TINY, Array

ROUNDING = 1e-9  # of a potential energy or work: a motion that exchanges less is lost in their rounding


def exchanged(kinetic: Array, *others: Array) -> Array:
    """The energy exchanged up to each sample, (n,) in J; the scale of every energy error.

    The largest kinetic energy, or the range of the potential energy or of a work (n,) if that is larger.
    """
    so_far, least = np.maximum.accumulate, np.full_like(kinetic, TINY)
    ranges = [np.maximum(so_far(x) + so_far(-x), ROUNDING * so_far(np.abs(x))) for x in others]
    return np.maximum.reduce([least, so_far(kinetic), *ranges])


def share(error: Array, scale: Array) -> float:
    """The largest of energy errors (n,) over the energy exchanged (n,) at the end; 0 without samples."""
    return float(error.max() / scale[-1]) if len(error) else 0.0


class Reactions(NamedTuple):
    """Joint reactions on each rod of a universal joint, (n, rods): R1, R2, R3 in N, M3, Mc in N m (DESIGN in docs)."""

    R1: Array
    R2: Array
    R3: Array
    M3: Array
    Mc: Array

    def __repr__(self) -> str:
        ranges = ", ".join(
            f"{name} {x.min(initial=0):.6g} to {x.max(initial=0):.6g}" for name, x in self._asdict().items()
        )
        return f"Reactions {self.R1.shape}: {ranges}"


class Energy(NamedTuple):
    """Kinetic and potential energy, (n,) in J; the potential is that of the conservative effects."""

    kinetic: Array
    potential: Array

    def __repr__(self) -> str:
        return f"Energy of {len(self.kinetic)} samples: drift {self.drift:.1e} of the energy exchanged"

    @property
    def total(self) -> Array:
        """Their sum, (n,) in J."""
        return self.kinetic + self.potential

    @property
    def exchanged(self) -> Array:
        """The energy exchanged up to each sample, (n,) in J."""
        return exchanged(self.kinetic, self.potential)

    @property
    def drift(self) -> float:
        """Largest departure of the total from its start, divided by the energy exchanged."""
        return share(np.abs(self.total - self.total[:1]), self.exchanged)


KINDS = ("stick", "reverse", "slip", "stop", "release")


class Event(NamedTuple):
    """What happened to a joint, under dry friction or at a stop.

    A sliding joint came to rest (stick) or turned back (reverse), a held one started to slide (slip), one reached a
    limit (stop) or left the limit on which it rested (release).
    """

    t: float  # s, as a run's t
    joint: str
    kind: str  # one of KINDS


@dataclass(frozen=True, kw_only=True)
class Counts:
    """What one run took, or many together: method, setting, counts and times."""

    method: str
    tolerance: float | None  # of a method without a fixed step
    step: float | None  # s, of a method with one; the last may be shorter
    steps: int
    evaluations: int
    seconds: float  # of integration with its sampling
    compile_seconds: float
    library: str
    version: str

    @property
    def setting(self) -> str:
        """The tolerance or step, in words."""
        return f"step {self.step:g} s" if self.tolerance is None else f"tolerance {self.tolerance:g}"


@dataclass(frozen=True, kw_only=True)
class Stats(Counts):
    """Method, setting, counts, times and estimated error of a run."""

    events: int  # impacts, and joints that stuck or came loose
    engine: str
    conservative: bool = False  # whether every effect has a potential, so that the energy should not change
    stopped: str | None = None  # why the run ended early
    accuracy: float | None = None  # the target: largest tip error divided by the chain's length
    error: float | None = None  # the estimated error
    all_seconds: float | None = None  # of every run that led to this one
    notes: tuple[str, ...] = ()  # remarks on the run
