"""Key paths, the one notation for places in a scene: `model.rods[0].mass`, `start.positions.theta_1`.

Error messages, Scene.replace and the command line use them. A name with other characters than letters, digits, _ and -
stands in quotes: `start.positions.'left hip'`.
"""

import re

from pendpin.errors import InputError, shown

KeyPath = tuple[str | int, ...]  # names of fields or joints, and places in lists

_PLAIN = re.compile(r"[\w-]+")
_PART = re.compile(r"""\[(\d{1,9})\]|\.?(?:([\w-]+)|'((?:[^'\\]|\\.)*)'|"((?:[^"\\]|\\.)*)")""")


def written(path: KeyPath) -> str:
    """A key path as text."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            name = part if _PLAIN.fullmatch(part) else "'" + re.sub(r"(['\\])", r"\\\1", part) + "'"
            text += f".{name}" if text else name
    return text


def parsed(text: str) -> KeyPath:
    """The parts of a key path. Raises InputError for text that is none."""
    parts: list[str | int] = []
    place = 0
    while place < len(text) or not parts:
        found = _PART.match(text, place)
        dotted = found is not None and text[place] == "."
        if found is None or dotted != (bool(parts) and found[1] is None):
            raise InputError(f"{shown(text)} is not a key path, such as model.rods[0].mass or start.positions.theta_1")
        index, plain, *quoted = found.groups()
        name = plain or re.sub(r"\\(.)", r"\1", next((part for part in quoted if part is not None), ""))
        parts.append(int(index) if index else name)
        place = found.end()
    return tuple(parts)
