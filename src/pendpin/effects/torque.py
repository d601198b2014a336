"""A torque that is a function: a controller, a table, any law of one's own."""

from collections.abc import Callable
from hashlib import sha256
from typing import Any, Literal

import numpy as np
from pydantic import Field, field_serializer

from pendpin.arrays import Array
from pendpin.effects.base import OnJoints, returned
from pendpin.errors import InputError, shown


class Torque(OnJoints):
    """Torques about some joints from a function of time and state: Torque(lambda t, q, v: -2.0 * v, joints=["theta_1"]).

    The function gets t in s and the positions and rates (k,) of these joints, in rad and rad/s, and returns their
    torques (k,) in N m. It is called with floats, once an evaluation: a scene with one is not compiled, and is not
    written to a file.
    """

    kind: Literal["torque"] = Field("torque", description="which effect it is")
    function: Callable[..., Any] = Field(description="f(t, q, v) -> torques (k,), N m", repr=False)

    @classmethod
    def from_one(cls, function: Callable[..., Any]) -> dict[str, Any]:
        """The function, which needs no name."""
        return {"function": function}

    @property
    def smooth(self) -> bool:
        """False: what a function does is not known, and it takes no symbols."""
        return False

    def torques(self, t: Any, q: Array, v: Array, xp: Any = np) -> Array:
        """What the function returns, (k,) N m. Raises InputError if that is not k finite numbers."""
        found = self.function(t, q.copy(), v.copy())
        torques = returned("effects: Torque: its function", found, q.shape)
        if not np.isfinite(torques).all():
            raise InputError(f"effects: Torque: its function returned {shown(found)} at t = {t:.10g} s")
        return torques

    @field_serializer("function")
    def _named(self, function: Callable[..., Any]) -> str:
        """What a record of a run says of the function: its name, and what tells its code from another's."""
        code = getattr(function, "__code__", None)
        cells = [repr(cell.cell_contents) for cell in getattr(function, "__closure__", None) or ()]
        parts = repr((code and code.co_code, code and [repr(c) for c in code.co_consts], cells))
        return f"{getattr(function, '__qualname__', type(function).__name__)} {sha256(parts.encode()).hexdigest()[:16]}"
