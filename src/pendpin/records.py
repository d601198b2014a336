"""Frozen, validated data: the base of scenes and effects, and the number types they use."""

from typing import Annotated, Any

from pydantic import AllowInfNan, BaseModel, ConfigDict, Field, Strict, ValidationError

from pendpin.errors import InputError, explain

LARGEST = 1e150  # of any number in a scene or a run: its square stays within doubles
LARGEST_SIZE = 1e100  # of a length, mass or inertia, and 1 over the least inertia: their products stay within doubles
Number = Annotated[  # an int or float; never text or a bool
    float, Strict(), AllowInfNan(False), Field(ge=-LARGEST, le=LARGEST)
]
Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]
Vector = tuple[Number, Number, Number]


class _OneLineErrors(type(BaseModel)):
    """Calling the class raises InputError; inside another record pydantic keeps its own error, for the full path."""

    def __call__(cls, *args: Any, **data: Any) -> Any:
        try:
            return super().__call__(*args, **data)
        except ValidationError as error:
            raise InputError(explain(error.errors(include_url=False), cls.__name__)) from None


class Record(BaseModel, metaclass=_OneLineErrors):
    """Frozen data that refuses unknown keys; a bad value raises InputError with its path."""

    model_config = ConfigDict(frozen=True, extra="forbid")
