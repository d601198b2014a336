"""How measured swings are read from a CSV file."""

import math
from typing import Annotated, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag

from pendpin.ground.records import FrozenDict, Number, Positive, Record

_Measured = Annotated[
    Annotated[tuple[str, ...], Tag("~joints")] | Annotated[str, Tag("~tip")],
    Discriminator(lambda given: "~tip" if isinstance(given, str) else "~joints"),
]
_Offsets = Annotated[
    Annotated[Literal["free", "zero"], Tag("~word")]
    | Annotated[dict[str, Number], AfterValidator(FrozenDict), Tag("~table")],
    Discriminator(lambda given: "~table" if isinstance(given, dict) else "~word"),
]


class Data(Record):
    """How measured swings are read from a CSV file, for a fit: which column measures what.

    A column measures the sum of the joints listed (an absolute angle is a sum), or one coordinate of a tip in W, in m,
    as "rod_1.y". Each column has a zero of its own, which the fit finds unless `offsets` says otherwise.
    """

    time: str = Field("t", description="the column of times, s")
    segment: str | None = Field(None, description="the column that tells independent swings apart; one swing if absent")
    columns: Annotated[dict[str, _Measured], Field(min_length=1), AfterValidator(FrozenDict)] = Field(
        description='by column: the joints whose angles add up to it, or the coordinate of a tip, as "rod_1.y"'
    )
    unit: Literal["radians", "degrees"] = Field("radians", description="of the angles")
    offsets: _Offsets = Field(
        "free", description="the zero of each column: free, zero, or by column in `unit` (m for tips)"
    )
    noise: Positive | None = Field(None, description="rad, standard deviation of the sensors; estimated if absent")

    def in_si(self, column: str) -> tuple[float, str]:
        """What one of the column's unit is in rad or m, and the name of its unit."""
        if isinstance(self.columns[column], str):
            return 1.0, "m"
        return (math.pi / 180, "degrees") if self.unit == "degrees" else (1.0, "rad")
