"""When, where and how fast the motion starts."""

from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag

from pendpin.late import from_above
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

    @classmethod
    def at_rest(cls, scene: Any) -> Self:
        """The stable equilibrium of a scene nearest to its start's positions, with the effects as they are at the start.

        Friction is left out. Raises InputError if there is no equilibrium.
        """
        return from_above("Start.at_rest")(scene)

    @classmethod
    def conical(cls, scene: Any, angle: float) -> Self:
        """The steady cone of a single rod about the vertical, at an angle from it in rad: the tip runs round a circle.

        Exact for a rod without inertia about its axis; a thick rod on a universal joint nods. The rate Omega follows
        from Omega² cos(angle) = m g h / (I1 + m h²). Raises InputError for other scenes.
        """
        return from_above("Start.conical")(scene, angle)
