"""Joints of a URDF that are frozen: those that a scene locks, mimic joints on request, and joints that move no mass."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pendpin.errors import InputError, choices, not_one_of, shown
from pendpin.model.bodies import pinocchio
from pendpin.model.urdf_xml import Element, has_inertia, needed, number, put, triple

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
