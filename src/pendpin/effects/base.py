"""The seams through which a scene's effects enter the dynamics (docs/effects.md).

An effect only ever adds. It is a frozen, validated record of its parameters with one method that is written once over
plain arithmetic: the functions it needs (sqrt, sin, ...) come in as `xp`, so the same lines run on floats and symbols.
"""

from abc import abstractmethod
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from pendpin.records import Record

Array = NDArray[Any]  # floats, or symbols in an object array


class Effect(Record):
    """One effect of a scene; a subclass of one of the seams below says how it acts."""

    smooth: ClassVar[bool] = True  # False keeps a scene off the Taylor lane
    kind: Any  # Literal["its name"] in each effect


class FieldEffect(Effect):
    """A uniform acceleration field that acts on every mass."""

    @property
    def constant(self) -> bool:
        """Whether the field is the same at all times: then it is evaluated once, when the scene is bound."""
        return False

    @abstractmethod
    def field(self, t: Any, xp: Any = np) -> Array:
        """The field at time t in s: (3,) in m/s², in the world W."""
