"""How a scene is integrated, and how often its motion is recorded."""

from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, ValidationInfo, WithJsonSchema, field_validator
from pydantic_core import PydanticKnownError

from pendpin.errors import choices
from pendpin.ground.records import Number, Positive, Record
from pendpin.scene.methods import METHODS, fixed_methods, names

TOLERANCE = 1e-10  # unless another is given
LEAST_TOLERANCE = 1e-14  # where the method is still to be chosen
MAX_SAMPLES = 2_000_000


def _refuse_unknown(name: str) -> str:
    if name not in names():
        raise PydanticKnownError("literal_error", {"expected": ", ".join(names())})
    return name


MethodName = Annotated[
    str, Field(strict=True), AfterValidator(_refuse_unknown), WithJsonSchema({"type": "string", "enum": list(names())})
]


class Solver(Record):
    """How the scene is integrated and how often the motion is recorded.

    A method has a tolerance (relative and absolute, rad and rad/s) or, with fixed steps, a step. The step asked is
    the step taken; the last one may be shorter, and samples inside a step have the order of the method. An accuracy replaces
    both: pendpin finds the tolerance or step that meets it, and with method "auto" the method too.
    """

    method: MethodName = Field("auto", description=f"{choices(names())} (docs/accuracy.md)")
    engine: Literal["auto", "pinocchio", "chain", "compiled"] = Field(
        "auto", description="which equations compute the accelerations: auto, pinocchio, chain, compiled"
    )
    accuracy: Annotated[Positive, Field(le=0.1)] | None = Field(
        None, description="the target: largest tip error during the run, divided by the chain's length"
    )
    tolerance: Annotated[Number, Field(le=0.1)] | None = Field(
        None, validate_default=True, description=f"for methods without a fixed step; {TOLERANCE:g} if none is given"
    )
    step: Positive | None = Field(
        None, validate_default=True, description=f"s, for methods with a fixed step: {', '.join(fixed_methods())}"
    )
    samples: Annotated[int, Field(strict=True, ge=1, le=MAX_SAMPLES)] | None = Field(
        None,
        description="evenly spaced output times from 0 to duration, both ends included; 60 a second (at least 2) if absent",
    )
    times: Annotated[tuple[Number, ...], Field(min_length=1, max_length=MAX_SAMPLES)] | None = Field(
        None, description="s, rising: the output times in place of samples, from start.time to start.time + duration"
    )

    @field_validator("tolerance")
    @classmethod
    def _tolerance_of(cls, tolerance: float | None, info: ValidationInfo) -> float | None:
        method = info.data.get("method", "")
        if info.data.get("accuracy") is not None:
            return _none_beside_accuracy(tolerance)
        if method in fixed_methods():
            if tolerance is not None:
                raise ValueError(f"{method} takes a step, not a tolerance")
            return None
        least = least_tolerance(method)
        if tolerance is not None and tolerance < least:
            raise PydanticKnownError("greater_than_equal", {"ge": least})
        return TOLERANCE if tolerance is None else tolerance

    @field_validator("step")
    @classmethod
    def _step_of(cls, step: float | None, info: ValidationInfo) -> float | None:
        method = info.data.get("method", "")
        if info.data.get("accuracy") is not None:
            return _none_beside_accuracy(step)
        # a tolerance that was refused is the fault; that no step is given follows from it
        if method in fixed_methods() and step is None and "tolerance" in info.data:
            raise ValueError(f"{method} takes a step, in s")
        if step is not None and method and method not in fixed_methods():
            raise ValueError(f"{method} takes a tolerance, not a step; a step is for {choices(fixed_methods())}")
        return step

    @field_validator("times")
    @classmethod
    def _times_rise(cls, times: tuple[float, ...] | None, info: ValidationInfo) -> tuple[float, ...] | None:
        if times is None:
            return None
        if info.data.get("samples") is not None:
            raise ValueError("samples are given too; leave one of them out")
        for i, (before, after) in enumerate(pairwise(times), 1):
            if not before < after:
                raise ValueError(f"times[{i}], {after:.15g} s, does not come after {before:.15g} s")
        return times

    def replaced(self, **settings: Any) -> Self:
        """The solver with the settings given (those not None); its own settings that no longer fit are left out."""
        settings = {name: value for name, value in settings.items() if value is not None}
        method = settings.get("method", self.method)
        unfit = {"tolerance" if isinstance(method, str) and method in fixed_methods() else "step"}
        if "accuracy" in settings:
            unfit = {"tolerance", "step"}
        elif "tolerance" in settings or "step" in settings:
            unfit |= {"accuracy"}
        if "samples" in settings or "times" in settings:
            unfit |= {"samples", "times"}
        kept = {name: value for name, value in self.model_dump().items() if value is not None and name not in unfit}
        return type(self)(**(kept | settings))


def least_tolerance(method: str) -> float:
    """The smallest tolerance that a method takes."""
    return METHODS[method].least_tolerance if method in METHODS else LEAST_TOLERANCE


def _none_beside_accuracy(value: float | None) -> None:
    if value is not None:
        raise ValueError("an accuracy is given, from which pendpin finds this number; leave one of them out")
