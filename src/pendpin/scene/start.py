"""When, where and how fast the motion starts."""

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from pendpin.records import Number, Record

Values = Annotated[
    Annotated[dict[str, Number], Tag("~by name")] | Annotated[tuple[Number, ...], Tag("~in order")],
    Discriminator(lambda value: "~by name" if isinstance(value, dict) else "~in order"),
]


class Start(Record):
    """When and where the motion starts, by joint name (what is left out is 0) or as a full list in model order."""

    time: Number = Field(0.0, description="s; the run goes from here to time + duration")
    positions: Values = Field(default_factory=dict, description="rad, or degrees; m for prismatic joints")
    velocities: Values = Field(default_factory=dict, description="rad/s, or degrees/s; m/s for prismatic joints")
    unit: Literal["radians", "degrees"] = Field("radians", description="of the angles and their rates")
