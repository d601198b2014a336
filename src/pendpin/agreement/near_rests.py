"""Published frequencies and bounds of stability: what a case says of the motions near a rest, and what pendpin finds."""

from collections.abc import Iterator

import numpy as np
from pydantic import Field

from pendpin.arrays import Array
from pendpin.dynamics.residual import matrices
from pendpin.dynamics.vibrations import vibrations
from pendpin.keypaths import number_at
from pendpin.model.build import build, start_state
from pendpin.records import Number, Positive, Record
from pendpin.scene import Scene
from pendpin.simulation.periodic import periodic_orbit

WINDOW = 0.02  # of a published bound of stability: where the verdict is looked for to change
HALVINGS = 40  # of that window: 2e-2 to a rounding


class Published(Record):
    """What a published quantity needs in any case."""

    name: str = Field(description="what the source publishes")
    unit: str = Field(description="its unit")
    bound: Positive = Field(description="in that unit: how far the published numbers themselves may be off")
    because: str = Field(description="where the bound comes from")


class Frequencies(Published):
    """Natural frequencies in rad/s of small motions about the scene's start, a rest."""

    values: tuple[Number, ...] = Field(description="the published numbers, rising")
    every: int = Field(1, description="how many modes share each of them: 2 where both directions are alike")

    def compute(self, scene: Scene) -> Array:
        """The lowest natural frequencies of the scene, as many as are published."""
        q, v = start_state(build(scene.model), scene.start)
        omega = vibrations(matrices(scene, q, v, np.zeros(len(q)))).omega
        return omega[:: self.every][: len(self.values)]


class StabilityBounds(Published):
    """Values of a number of the scene at which its periodic motion becomes stable, or unstable."""

    values: tuple[Number, ...] = Field(description="the published numbers, rising")
    key: str = Field(description="the key path of the number")

    def compute(self, scene: Scene) -> Array:
        """Where the multipliers of the scene's motion leave the unit circle, next to each published value."""
        number_at(scene, self.key)
        return np.array([self._next_to(scene, value) for value in self.values])

    def _next_to(self, scene: Scene, value: float) -> float:
        low, high = (1 - WINDOW) * value, (1 + WINDOW) * value
        before, after = (self._stable(scene, end) for end in (low, high))
        if before == after:
            return float("nan")  # no change of stability is near
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if self._stable(scene, middle) == before else (low, middle)
        return (low + high) / 2

    def _stable(self, scene: Scene, value: float) -> bool:
        return periodic_orbit(scene.replace({self.key: value})).stable


def differences(quantity: Frequencies | StabilityBounds, scene: Scene) -> Iterator[float]:
    """By how much each found number differs from the published one, in its unit; NaN where there is none."""
    value = quantity.compute(scene)
    yield from np.abs(value - np.array(quantity.values)).tolist()
