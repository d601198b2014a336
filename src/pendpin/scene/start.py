"""When, where and how fast the motion starts."""

from typing import Annotated, Any, Literal

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

    @classmethod
    def at_rest(cls, scene: Any) -> "Start":
        """The stable equilibrium of a scene nearest to its start's positions, with the effects as they are at the start.

        Friction is left out. Raises InputError if there is no equilibrium.
        """
        from pendpin.motions.special_starts import at_rest

        return at_rest(scene)

    @classmethod
    def conical(cls, scene: Any, angle: float) -> "Start":
        """The steady cone of a single rod about the vertical, at an angle from it in rad: the tip runs round a circle.

        The rate Omega follows from Omega² cos(angle) = m g h / (I1 + m h²). Exact for a rod without inertia about its
        axis (radius 0, a point mass), where gravity alone acts. No other rod has a steady cone on a universal joint: its
        spin, -theta' sin(phi), changes round the circle, and with it an energy that is constant. It nods by about
        I3 / (I1 + m h²) sin(angle) tan²(angle); beyond 1 % of the angle that is noted. Raises InputError for scenes
        without a cone.
        """
        from pendpin.motions.special_starts import conical

        return conical(scene, angle)
