"""Gravity: a constant uniform field."""

from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, field_validator

from pendpin.effects.base import FieldEffect
from pendpin.ground.arrays import Array
from pendpin.ground.records import NotNegative, Vector


class Gravity(FieldEffect):
    """Uniform gravity: the field is acceleration * direction / |direction|.

    acceleration in m/s² (9.81); direction in the world W, z up ((0, 0, -1)), of any length but zero.
    """

    parameters: ClassVar[tuple[str, ...]] = ("acceleration", "direction")
    strengths: ClassVar[tuple[str, ...]] = ("acceleration",)
    kind: Literal["gravity"] = Field("gravity", description="which effect it is")
    acceleration: NotNegative = Field(9.81, description="m/s²")
    direction: Vector = Field((0.0, 0.0, -1.0), description="in the world W, z up; of any length but 0")

    @field_validator("direction")
    @classmethod
    def _not_zero(cls, direction: Vector) -> Vector:
        if not any(direction):
            raise ValueError("a direction needs a length: [0, 0, -1] points down")
        return direction

    def with_numbers(self, numbers: Any) -> Self:
        """The effect as it is: the sum of all constant fields is a parameter."""
        return self

    @property
    def constant(self) -> bool:
        """Gravity does not change with time."""
        return True

    def field(self, t: Any, xp: Any = np) -> Array:
        """The same (3,) vector in m/s², W, at all times."""
        direction = np.array(self.direction) / max(map(abs, self.direction))  # no overflow for any finite numbers
        return self.acceleration * (direction / np.sqrt(direction @ direction))
