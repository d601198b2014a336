"""A torque that is a function: a controller, a table, any law of one's own."""

import inspect
from collections.abc import Callable
from functools import partial
from hashlib import sha256
from types import MethodType
from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, field_serializer, model_validator

from pendpin.effects.base import OnJoints, returned
from pendpin.effects.pace import STEADY, Pace
from pendpin.errors import InputError, shown
from pendpin.ground.arrays import Array
from pendpin.ground.records import Positive


class Torque(OnJoints):
    """Torques about some joints from a function of time and state: Torque(lambda t, q, v: -2.0 * v, joints=["theta_1"]).

    The function gets t in s and the positions and rates (k,) of these joints, in rad and rad/s, and returns their
    torques (k,) in N m. It is called with floats, once an evaluation: a scene with one is not compiled, and is not
    written to a file. How fast it changes cannot be seen from outside: declare `steady` or `shortest`, and `gradual`,
    or a note says what was assumed.

    `every` in s makes it a sampled torque, as of a digital controller: the function is called at t = 0, every, 2 every, ...
    after the start, and its output is held until the next instant. A step of the integration ends at each.
    """

    kind: Literal["torque"] = Field("torque", description="which effect it is")
    function: Callable[..., Any] = Field(description="f(t, q, v) -> torques (k,), N m", repr=False)
    steady: bool = Field(False, description="time makes no difference to it")
    shortest: Positive | None = Field(None, description="s, the shortest time in which it changes at rest")
    gradual: bool | None = Field(None, description="it changes with positions and rates as slowly as the motion does")

    every: Positive | None = Field(None, description="s, between two instants at which it is sampled; held in between")

    @model_validator(mode="after")
    def _one_pace(self) -> Self:
        declared = [name for name in ("steady", "shortest", "gradual") if getattr(self, name) not in (None, False)]
        if self.every is not None and declared:
            raise ValueError(
                f"every and {declared[0]} do not go together: what is sampled changes at its instants only"
            )
        return self

    @classmethod
    def from_one(cls, function: Callable[..., Any]) -> dict[str, Any]:
        """The function, which needs no name."""
        return {"function": function}

    @property
    def smooth(self) -> bool:
        """False: what a function does is not known, and it takes no symbols."""
        return False

    def pace(self, begin: float, end: float, negligible: float) -> Pace | None:
        """As declared; None if it is not."""
        if self.steady:
            return STEADY
        return None if self.shortest is None else Pace.even(self.shortest)

    def torques(self, t: Any, q: Array, v: Array, xp: Any = np) -> Array:
        """The torques that the function returns, (k,) N m. Raises InputError if that is not k finite numbers."""
        output = self.function(t, q.copy(), v.copy())
        torques = returned("effects: Torque: its function", output, q.shape)
        if not np.isfinite(torques).all():
            raise InputError(f"effects: Torque: its function returned {shown(output)} at t = {t:.10g} s")
        return torques

    @field_serializer("function")
    def _named(self, function: Callable[..., Any]) -> str:
        """What a record of a run says of the function: its name, and what tells it from another."""
        name = getattr(function, "__qualname__", type(function).__name__)
        return f"{name} {sha256(_identity(function).encode()).hexdigest()[:16]}"


def _identity(function: Any) -> str:
    """The source of a function and the values that it holds, by which a saved run knows it again."""
    if isinstance(function, partial):
        return repr((_identity(function.func), function.args, function.keywords))
    if isinstance(function, MethodType):
        return repr((_identity(function.__func__), vars(function.__self__)))
    if not inspect.isfunction(function):
        return repr((_source(type(function)), vars(function) if hasattr(function, "__dict__") else function))
    held = [repr(cell.cell_contents) for cell in function.__closure__ or ()]
    return repr((_source(function), held, function.__defaults__, function.__kwdefaults__))


def _source(thing: Any) -> str:
    """The source of a function or class; where there is none, as of what was typed at a prompt, a name of this process."""
    try:
        return inspect.getsource(thing)
    except (OSError, TypeError):
        return f"{thing.__qualname__} {id(thing)}"
