"""What a URDF says of its joints beside their axes: locks, mimics, joints that move no mass, damping, friction, limits."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pendpin.effects import AsWritten, Effect
from pendpin.errors import InputError, choices, not_one_of, shown
from pendpin.model.bodies import pinocchio
from pendpin.model.urdf_xml import Element, has_inertia, needed, number, put, triple
from pendpin.scene.models import FARTHEST

SHOWN = 3  # joints in a note
MOST_LISTED = 3  # joints in a note


class _Mimic(NamedTuple):
    """A joint whose position should follow another's: multiplier times that, plus offset (rad, or m for slides)."""

    joint: str
    multiplier: float
    offset: float


def freeze_joints(joints: dict[str, Element], lock: Mapping[str, float], mimic: str) -> tuple[str, ...]:
    """Make locked joints fixed ones at their positions (rad, or m for slides); notes on what mimics another.

    Raises InputError for a joint that does not exist or cannot move, and for a broken <mimic>.
    """
    moving = {name: joint for name, joint in joints.items() if joint.get("type") != "fixed"}
    for name in lock:
        if name not in moving:
            raise InputError(f"model.lock: joint {not_one_of(name, moving)}")
    mimics = {name: follower for name, joint in moving.items() if (follower := _mimic_of(name, joint))}
    frozen = dict(lock)
    if mimic == "locked":
        frozen = {name: _followed(name, mimics, lock) for name in mimics} | frozen
    for name, position in frozen.items():
        if position:  # at 0 its origin stays as written, to the last bit
            _move_origin(joints[name], position)
        joints[name].set("type", "fixed")
    return _mimic_note({name: x.joint for name, x in mimics.items() if name not in lock}, joints, frozen)


def massless_joints(links: dict[str, Element], joints: dict[str, Element]) -> tuple[str, ...]:
    """The moving joints beyond which no link has a mass or an inertia; none where that is true of all of them."""
    above = {_end(joint, "child"): _end(joint, "parent") for joint in joints.values()}
    carrying: set[str] = set()
    for link in filter(lambda name: has_inertia(links[name]), links):
        while link not in carrying:
            carrying.add(link)
            link = above.get(link, link)
    moving = [name for name, joint in joints.items() if joint.get("type") != "fixed"]
    names = tuple(name for name in moving if _end(joints[name], "child") not in carrying)
    return names if len(names) < len(moving) else ()


def massless_finding(names: Sequence[str]) -> tuple[str, ...]:
    """What is said about such joints."""
    if not names:
        return ()
    if len(names) == 1:
        who, its, stands = f"joint {shown(names[0])}", "its", "it is"
    else:
        more = f" and {len(names) - 6} more" * (len(names) > 6)
        who, its, stands = f"joints {choices(map(shown, names[:6]))}{more}", "their", "they are"
    return (
        f"{who} can move massless links only: {its} motion is undefined and moves nothing else; {stands} locked at 0",
    )


def _end(joint: Element, end: str) -> str:
    return needed("", joint, end).get("link", "")


def _mimic_of(name: str, joint: Element) -> _Mimic | None:
    mimic, where = joint.find("mimic"), f"joint {shown(name)}"
    if mimic is None:
        return None
    if not mimic.get("joint"):
        raise InputError(f"{where}: <mimic> names no joint")
    multiplier, offset = (
        number(where, mimic, key) if key in mimic.attrib else default
        for key, default in (("multiplier", 1.0), ("offset", 0.0))
    )
    return _Mimic(mimic.get("joint", ""), multiplier, offset)


def _followed(name: str, mimics: Mapping[str, _Mimic], lock: Mapping[str, float]) -> float:
    """Where a mimic joint stands: where the joint that it follows is locked, or at its zero. Raises InputError."""
    path, slope, position = [name], 1.0, 0.0
    while path[-1] in mimics and path[-1] not in lock:
        master, multiplier, offset = mimics[path[-1]]
        if master in path:
            raise InputError(f"joint {shown(name)}: it mimics itself, by way of {choices(map(shown, path[1:]))}")
        path, position, slope = [*path, master], position + slope * offset, slope * multiplier
    return position + slope * lock.get(path[-1], 0.0)


def _mimic_note(
    masters: Mapping[str, str], joints: Mapping[str, Element], frozen: Mapping[str, float]
) -> tuple[str, ...]:
    """One note on all joints that mimic others, each with its master."""
    free = [_pair(name, master, joints) for name, master in masters.items() if name not in frozen]
    locked = [
        f"{_pair(name, master, joints)} and is locked at {frozen[name]:g}"
        for name, master in masters.items()
        if name in frozen
    ]
    parts = []
    if free:
        they, move, them = ("it", "moves", "it") if len(free) == 1 else ("they", "move", "them")
        parts.append(
            f'{_listed(free)} in the file, but {they} {move} independently here; mimic = "locked" freezes {them}'
        )
    return (*parts, *([f"{_listed(locked)}"] if locked else []))


def _pair(name: str, master: str, joints: Mapping[str, Element]) -> str:
    return f"{shown(name)} mimics {shown(master)}{'' if master in joints else ' (no joint)'}"


def _listed(texts: Sequence[str]) -> str:
    more = f", ... ({len(texts)} joints)" if len(texts) > MOST_LISTED else ""
    return f"joint{'s' * (len(texts) > 1)} {choices(texts[:MOST_LISTED])}{more}"


def _move_origin(joint: Element, position: float) -> None:
    pin, origin, axis = pinocchio(), joint.find("origin"), joint.find("axis")
    if origin is None:
        origin = Element("origin")
        joint.append(origin)
    xyz, rpy = (np.array(triple("", origin, key)) for key in ("xyz", "rpy"))
    along = np.array([1.0, 0.0, 0.0] if axis is None else triple("", axis, "xyz"))
    along /= np.abs(along).max()
    along /= np.linalg.norm(along)
    R = pin.rpy.rpyToMatrix(rpy)
    if joint.get("type") == "prismatic":
        put(origin, "xyz", xyz + R @ along * position)
    else:
        put(origin, "rpy", pin.rpy.matrixToRpy(R @ pin.exp3(along * position)))


# --- what a URDF or a pin.Model says of its joints' bearings and limits, in force where a scene lists as_written ----


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
