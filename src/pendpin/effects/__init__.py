"""What acts in a scene: one file per family of effects, and the interfaces that they use (docs/effects.md).

May import: the ground (errors, records, files, arrays). No engine.
To add an effect: a class in a file here, and its name in `AnyEffect` below if a scene file may name it.
"""

from typing import Annotated, Any, get_args

from pydantic import BeforeValidator, Discriminator, InstanceOf, Tag
from pydantic.json_schema import SkipJsonSchema

from pendpin.effects.base import (
    Bodies,
    BodyEffect,
    Effect,
    FieldEffect,
    FrameEffect,
    Idle,
    JointEffect,
    Motion,
    OnJoints,
)
from pendpin.effects.drag import Drag
from pendpin.effects.fields import Gravity, Rotation, Support
from pendpin.effects.friction_and_stops import AsWritten, ContactEffect, DryFriction, Stop
from pendpin.effects.joints import Bending, Motor, Spring, Torque, Viscous
from pendpin.effects.push import Anchor, Push
from pendpin.ground.arrays import applied, cross, dot


def _branch(value: Any) -> str:
    if isinstance(value, Effect):
        return "~instance"
    return f"~{value.get('kind', '')}" if isinstance(value, dict) else "~no table"


def _write_out(value: Any) -> Any:
    """A kind's name as its table, and a function as the torque on all joints that it computes."""
    if isinstance(value, str):
        return {"kind": value}
    if isinstance(value, type) and issubclass(value, Effect):
        raise ValueError(f"{value.__name__} is a class: write {value.__name__}(...)")
    return Torque(value) if callable(value) else value


AnyEffect = Annotated[
    Annotated[Gravity, Tag("~gravity")]
    | Annotated[Viscous, Tag("~viscous")]
    | Annotated[Spring, Tag("~spring")]
    | Annotated[Motor, Tag("~motor")]
    | Annotated[Bending, Tag("~bending")]
    | Annotated[Anchor, Tag("~anchor")]
    | Annotated[Push, Tag("~push")]
    | Annotated[Drag, Tag("~drag")]
    | Annotated[Support, Tag("~support")]
    | Annotated[Rotation, Tag("~rotation")]
    | Annotated[DryFriction, Tag("~dry_friction")]
    | Annotated[Stop, Tag("~stop")]
    | Annotated[AsWritten, Tag("~as_written")]
    | Annotated[SkipJsonSchema[InstanceOf[Effect]], Tag("~instance")],
    Discriminator(_branch),
    BeforeValidator(_write_out),
]


def has_kind(effect: Effect) -> bool:
    """Whether a scene file can name this effect: it is one of pendpin's, not of a user's own class."""
    return any(type(effect) is get_args(branch)[0] for branch in get_args(get_args(AnyEffect)[0]))


__all__ = ["Anchor", "AsWritten", "Bending", "Bodies", "BodyEffect", "ContactEffect", "Drag", "DryFriction"]
__all__ += ["Effect", "FieldEffect", "FrameEffect", "Gravity", "Idle", "JointEffect", "Motion", "Motor"]
__all__ += ["OnJoints", "Push", "Rotation", "Spring", "Stop", "Support", "Torque", "Viscous", "applied", "cross"]
__all__ += ["dot"]


def __dir__() -> list[str]:
    """The effects and their interfaces, for completion."""
    return __all__
