"""What the engines get from the effects of a scene."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pendpin.effects import Motion
from pendpin.ground.arrays import Array


@dataclass(frozen=True, eq=False)
class Loads:
    """The sum of the effects of a scene, by interface; None for an interface that the scene does not use."""

    constant: Array  # (3,) m/s², W: the sum of the constant fields
    varying: Callable[[float], Array] | None = None  # t -> (3,) m/s², W: the sum of the others
    torque: Callable[[float, Array, Array], Array] | None = None  # t, q, v -> (nv,) N m, or N for slides
    wrench: Callable[[float, Motion], tuple[Array, Array]] | None = None  # force N, moment N m about com, (n, 3), W
    together: Callable[[Array, Motion], tuple[Array, Array]] | None = None  # as `wrenches`, where all effects allow it
    axial: bool = False  # whether wrenches may turn a rod about its own axis, or ask how far it has turned

    def wrenches(self, t: Array, motion: Motion) -> tuple[Array, Array]:
        """Forces and moments (k, n, 3) as `wrench`, at times (k,) and states (k, n, ...) of the motion."""
        if self.together is not None:
            return self.together(t, motion)
        assert self.wrench is not None
        states = zip(t, *motion[:4], strict=True)
        force, moment = zip(*(self.wrench(time, Motion(*state)) for time, *state in states), strict=True)
        return np.array(force), np.array(moment)

    def field(self, t: float) -> Array:
        """The sum of all uniform fields at time t, (3,) m/s², W."""
        return self.constant if self.varying is None else self.constant + self.varying(t)
