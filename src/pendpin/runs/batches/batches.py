"""A batch: many runs of scenes of one structure, as arrays. Starts and numbers go in, states come out, in pieces.

Three callers have batches: `simulate_many`, a sweep, and the search for an accuracy of many cases. series.py integrates
them in the processor's vectors; pools.py shares pieces among threads and processes.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pendpin.ground.arrays import Array, Indices, Mask
from pendpin.model.build import Model

WIDTH = 16  # cases side by side, the same on every machine: two vectors hide the time that an instruction takes
AT_ONCE = 128  # cases that are sorted into vectors
MOST_STATES = 200_000  # of a case, and of a piece: it bounds the memory of a worker
MOST_JOINTS = 10  # up to which series are compiled for a batch: five rods compile in 2 s and run ten times as fast


class Cases(NamedTuple):
    """The starts and the numbers of c scenes of one structure."""

    models: Sequence[Model]  # (c,)
    q: Array  # (c, nv) at the start
    v: Array  # (c, nv)
    parameters: Array  # (c, p) of the series
    longest: Array  # (c,) s, the longest step; 0 where an effect has corners, which series do not take side by side

    @classmethod
    def joined(cls, cases: Sequence["Cases"]) -> "Cases":
        """All of these cases."""
        models, *rows = zip(*cases, strict=True)
        return cls([model for part in models for model in part], *(np.concatenate(part) for part in rows))

    def some(self, places: Indices) -> "Cases":
        """Those at these places (k,)."""
        return Cases([self.models[i] for i in places], *(rows[places] for rows in self[1:]))

    def pieces(self, samples: int, workers: int = 1) -> list[Indices]:
        """Places (k,) of cases that one worker runs at once: their samples fit into the memory, and no worker is idle."""
        size = min(AT_ONCE, MOST_STATES // samples, len(self.q) // (2 * workers))
        size = max(WIDTH, size // WIDTH * WIDTH)
        return [np.arange(begin, min(begin + size, len(self.q))) for begin in range(0, len(self.q), size)]


class Motions(NamedTuple):
    """The motions of c cases; NaN after the first sample of a case that cannot be integrated to its end."""

    models: Sequence[Model]  # (c,)
    t: Array  # (n,) s
    q: Array  # (c, n, nv)
    v: Array  # (c, n, nv)
    flips: Array  # (c,) s since the start, first passage of a sum of angles through an odd multiple of pi, else NaN
    steps: Array  # (c,)

    def some(self, places: Indices) -> "Motions":
        """Copies of those at these places (k,)."""
        return Motions([self.models[i] for i in places], self.t, *(rows[places] for rows in self[2:]))

    def put(self, places: Indices, motions: "Motions") -> None:
        """Write other motions of the same cases over those at these places (k,)."""
        for rows, others in zip(self[2:], motions[2:], strict=True):
            rows[places] = others

    @property
    def finite(self) -> Mask:
        """Which cases (c,) were integrated to their ends."""
        return np.asarray(np.isfinite(self.q).all((1, 2)) & np.isfinite(self.v).all((1, 2)))
