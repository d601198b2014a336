"""What a URDF or a pin.Model says of its joints' bearings and limits, in force where a scene lists as_written."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple
from xml.etree.ElementTree import Element

from pendpin.effects import AsWritten, Effect
from pendpin.errors import choices, shown
from pendpin.model.urdf_xml import number
from pendpin.scene.models import FARTHEST

SHOWN = 3  # joints in a note


class WrittenJoint(NamedTuple):
    """A joint's numbers in the file; rad, or m for a prismatic joint."""

    name: str
    damping: float  # N m s/rad
    friction: float  # N m
    lower: float  # -inf where nothing limits it
    upper: float


def written_joints(joints: Mapping[str, Element]) -> tuple[WrittenJoint, ...]:
    """The numbers of the joints that move, checked before. Equal limits, as a file has that means none, do not limit."""
    return tuple(_written(name, joint) for name, joint in joints.items() if joint.get("type") != "fixed")


def _written(name: str, joint: Element) -> WrittenJoint:
    damping, friction = (_value(joint.find("dynamics"), key) for key in ("damping", "friction"))
    limit = None if joint.get("type") == "continuous" else joint.find("limit")
    lower, upper = (_value(limit, key) for key in ("lower", "upper"))
    return WrittenJoint(name, damping, friction, *limits(lower, upper))


def limits(lower: float, upper: float) -> tuple[float, float]:
    """The limits that act: none where both are equal, nor beyond FARTHEST."""
    if lower == upper:
        return -math.inf, math.inf
    low, high = (x if abs(x) < FARTHEST else math.copysign(math.inf, x) for x in (lower, upper))
    return low, high


def _value(element: Element | None, key: str) -> float:
    return 0.0 if element is None or element.get(key) is None else number("", element, key)


def ignored(joints: Sequence[WrittenJoint], effects: Sequence[Effect]) -> tuple[str, ...]:
    """One note on what the file says of its joints and no as_written of the scene lets act; none if that is nothing."""
    listed = [effect for effect in effects if isinstance(effect, AsWritten)]
    left = {
        "<dynamics damping>": [] if any(x.damping for x in listed) else [j.name for j in joints if j.damping],
        "<dynamics friction>": [] if any(x.friction for x in listed) else [j.name for j in joints if j.friction],
        "<limit>": [] if any(x.limits for x in listed) else [j.name for j in joints if _limited(j)],
    }
    shown_names = {
        what: choices(map(shown, names)) if len(names) <= SHOWN else f"{len(names)} joints ({shown(names[0])}, ...)"
        for what, names in left.items()
        if names
    }
    parts = [f"{what} of {names}" for what, names in shown_names.items()]
    if not parts:
        return ()
    return (f"{', '.join(parts)}: ignored; the effect as_written (--as-written, effects.AsWritten()) lets them act",)


def written_text(joints: Sequence[WrittenJoint], effects: Sequence[Effect]) -> str:
    """What acts as written, in words; "" where the effects list none of it."""
    listed = [effect for effect in effects if isinstance(effect, AsWritten)]
    counts = {
        "damping": sum(j.damping > 0 for j in joints) * any(x.damping for x in listed),
        "dry friction": sum(j.friction > 0 for j in joints) * any(x.friction for x in listed),
        "stops": sum(map(_limited, joints)) * any(x.limits for x in listed),
    }
    parts = [f"{what} of {count} joint{'s' * (count > 1)}" for what, count in counts.items() if count]
    return choices(parts) or ("nothing: the file writes none" if listed else "")


def homes(joints: Sequence[WrittenJoint], effects: Sequence[Effect]) -> dict[str, float]:
    """Where joints begin of which a start says nothing, if limits act as written that leave out 0: at the nearer one."""
    if not any(isinstance(effect, AsWritten) and effect.limits for effect in effects):
        return {}
    nearest = {joint.name: min(max(joint.lower, 0.0), joint.upper) for joint in joints}
    return {name: position for name, position in nearest.items() if position}


def _limited(joint: WrittenJoint) -> bool:
    return math.isfinite(joint.lower) or math.isfinite(joint.upper)
