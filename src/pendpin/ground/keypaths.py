"""Key paths, the one notation for places in a scene: `model.rods[0].mass`, `start.positions.theta_1`.

Error messages, Scene.replace and the command line use them. A name with other characters than letters, digits, _ and -
stands in quotes: `start.positions.'left hip'`.
"""

import ast
import re
from collections.abc import Iterator, Mapping
from typing import Any

from pendpin.errors import InputError, KeyPath, is_number, shown

_PART = re.compile(r"""\[(\d{1,9})\]|\.?(?:([\w-]+)|('(?:[^'\\\n]|\\.)*'|"(?:[^"\\\n]|\\.)*"))""")


def parsed(text: str) -> KeyPath:
    """The parts of a key path. Raises InputError for what is none."""
    if not isinstance(text, str):
        raise InputError(f"{shown(text)} is not a key path, such as model.rods[0].mass")
    parts: list[str | int] = []
    place = 0
    while place < len(text) or not parts:
        part = _PART.match(text, place)
        dotted = part is not None and text[place] == "."
        if part is None or dotted != (bool(parts) and part[1] is None) or (part[1] and not parts):
            raise InputError(
                f'{shown(text)} is not a key path, such as model.rods[0].mass or start.positions."left hip"'
            )
        index, plain, quoted = part.groups()
        parts.append(int(index) if index else plain or _unquoted(quoted))
        place = part.end()
    return tuple(parts)


def number_at(record: Any, key: str) -> float:
    """The number at a key path of a scene. Raises InputError where there is none."""
    value = record
    for part in parsed(key):
        try:
            value = value[part] if isinstance(part, int) or isinstance(value, Mapping) else getattr(value, part)
        except (AttributeError, LookupError, TypeError):
            raise InputError(f"{key}: the scene has nothing there; name a number, as model.rods[0].length") from None
    if not is_number(value):
        raise InputError(f"{key}: {shown(value)} is not a number")
    return float(value)


def places_of(name: str, value: Any, path: KeyPath = ()) -> list[KeyPath]:
    """The key paths in nested tables and lists that end in a name, in their order."""
    items = value.items() if isinstance(value, Mapping) else enumerate(value) if isinstance(value, list | tuple) else ()
    paths = []
    for part, inner in items:
        paths += [(*path, part)] * (part == name) + places_of(name, inner, (*path, part))
    return paths


def leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Every value of nested tables and lists, with its key path."""
    if isinstance(value, dict):
        for name, part in value.items():
            yield from leaves(part, f"{path}.{name}" if path else str(name))
    elif isinstance(value, list | tuple):
        for i, part in enumerate(value):
            yield from leaves(part, f"{path}[{i}]")
    else:
        yield path, value


def _unquoted(literal: str) -> str:
    try:
        return ast.literal_eval(literal)
    except (SyntaxError, ValueError):
        raise InputError(f"{shown(literal)} is not a name in quotes") from None
