"""What the engines get from the effects of a scene."""

from collections.abc import Callable
from dataclasses import dataclass

from pendpin.arrays import Array
from pendpin.effects import Motion


@dataclass(frozen=True, eq=False)
class Loads:
    """The sum of the effects of a scene, by interface; None for an interface that the scene does not use."""

    constant: Array  # (3,) m/s², W: the sum of the constant fields
    varying: Callable[[float], Array] | None = None  # t -> (3,) m/s², W: the sum of the others
    torque: Callable[[float, Array, Array], Array] | None = None  # t, q, v -> (nv,) N m, or N for slides
    wrench: Callable[[float, Motion], tuple[Array, Array]] | None = None  # force N, moment N m about com, (n, 3), W
    axial: bool = False  # whether wrenches may turn a rod about its own axis, or ask how far it has turned

    def field(self, t: float) -> Array:
        """The sum of all uniform fields at time t, (3,) m/s², W."""
        return self.constant if self.varying is None else self.constant + self.varying(t)
