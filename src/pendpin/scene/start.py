"""When, where and how fast the motion starts."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag

from pendpin.ground.records import FrozenDict, Number, Record

Values = Annotated[
    Annotated[dict[str, Number], AfterValidator(FrozenDict), Tag("~by name")]
    | Annotated[tuple[Number, ...], Tag("~in order")],
    Discriminator(lambda value: "~by name" if isinstance(value, dict) else "~in order"),
]


class Start(Record):
    """When and where the motion starts, by joint name (what is left out is 0) or as a full list in model order."""

    time: Number = Field(0.0, description="s; the run goes from here to time + duration")
    positions: Values = Field(default_factory=FrozenDict, description="rad, or degrees; m for prismatic joints")
    velocities: Values = Field(default_factory=FrozenDict, description="rad/s, or degrees/s; m/s for prismatic joints")
    unit: Literal["radians", "degrees"] = Field("radians", description="of the angles and their rates")

    def __eq__(self, other: object) -> bool:
        """Whether both are the same start; the public class, which adds two ways to find one, makes no difference."""
        return isinstance(other, Start) and vars(self) == vars(other)

    def __hash__(self) -> int:
        return hash((self.time, self.positions, self.velocities, self.unit))
