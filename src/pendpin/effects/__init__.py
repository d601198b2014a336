"""The effects a scene may call for, one module a family; `AnyEffect` lists those that a scene file can name."""

from typing import Annotated, Any

from pydantic import Discriminator, InstanceOf, Tag
from pydantic.json_schema import SkipJsonSchema

from pendpin.effects.base import Bodies, BodyEffect, Effect, FieldEffect, JointEffect, Motion
from pendpin.effects.gravity import Gravity


def _branch(value: Any) -> str:
    if isinstance(value, Effect):
        return "~instance"
    return f"~{value.get('kind', '')}" if isinstance(value, dict) else "~no table"


AnyEffect = Annotated[
    Annotated[Gravity, Tag("~gravity")] | Annotated[SkipJsonSchema[InstanceOf[Effect]], Tag("~instance")],
    Discriminator(_branch),
]

__all__ = ["AnyEffect", "Bodies", "BodyEffect", "Effect", "FieldEffect", "Gravity", "JointEffect", "Motion"]
