"""Arguments of Python functions, each as it is used or InputError with its name; and key paths."""

import ast
import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from pendpin.errors import InputError, KeyPath, find, is_number, shown
from pendpin.ground.arrays import Array


def flag(name: str, value: Any) -> bool:
    """A bool, Python's or NumPy's: any text and NaN would count as true."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise InputError(f"{name}: {shown(value)} is neither True nor False")


def whole_number(name: str, value: Any, least: int = 1, most: float = np.inf) -> int:
    """A whole number, Python's or NumPy's."""
    if not isinstance(value, int | np.integer) or isinstance(value, bool) or not least <= value <= most:
        to = f"to {most:,}" if most < np.inf else "on"
        raise InputError(f"{name}: {shown(value)} is not a whole number from {least} {to}")
    return operator.index(value)


def names_in(name: str, value: Any, valid: tuple[str, ...]) -> Sequence[str]:
    """One name or a list of names, each of them valid."""
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, Sequence):
        raise InputError(f"{name}: {shown(value)} is not a list of names")
    for one in names:
        find(valid, one, f"{name}:")
    return names


def function(name: str, value: Any) -> Any:
    """What can be called."""
    if not callable(value):
        raise InputError(f"{name}: {shown(value)} is not a function; leave it out for none")
    return value


def axes(name: str, value: Any) -> Any:
    """A matplotlib Axes, or None for one of its own."""
    if value is not None and not hasattr(value, "add_line"):
        raise InputError(f"{name}: {shown(value)} is not a matplotlib Axes")
    return value


def number(
    name: str, value: Any, right: str = "a finite number", fits: Callable[[float], Any] = math.isfinite
) -> float:
    """A number, Python's or NumPy's, that fits."""
    plain = value.item() if isinstance(value, np.generic) else value
    if not is_number(plain) or not fits(plain):
        raise InputError(f"{name}: {shown(plain)} is not {right}")
    return plain


def seconds(name: str, value: Any, lasting: bool = False) -> float:
    """A number of seconds, 0 or above, or infinity; if `lasting`, a finite one above 0."""
    if lasting:
        return number(name, value, "a number of seconds above 0", lambda t: 0 < t < np.inf)
    return number(name, value, "a number of seconds, 0 or above", lambda t: t >= 0)


def fraction(name: str, value: Any, right: str = "between 0 and 1") -> float:
    """A number between 0 and 1, both left out."""
    return number(name, value, right, lambda part: 0 < part < 1)


def numbers(name: str, values: Any, finite: bool = False) -> Array:
    """Numbers as an array of floats of any shape, if asked for all finite; not text, complex numbers or bools."""
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "iufO":
            raise TypeError
        array = array.astype(float, copy=False)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name}: {shown(values)} are not numbers") from None
    if finite and not np.isfinite(array).all():
        place = np.argwhere(~np.isfinite(array))[0].tolist()
        where = "".join(f"[{i}]" for i in place)
        raise InputError(f"{name}{where}: {array[tuple(place)]} is not a finite number")
    return array


# --- key paths: the one notation for places in a scene, as model.rods[0].mass ---------------------------------------

# Error messages, Scene.replace and the command line use them. A name with other characters than letters, digits, _ and -
# stands in quotes: start.positions.'left hip'.
_PART = re.compile(r"""\[(\d{1,9})\]|\.?(?:([\w-]+)|('(?:[^'\\\n]|\\.)*'|"(?:[^"\\\n]|\\.)*"))""")


def parsed(text: str) -> KeyPath:
    """The parts of a key path. Raises InputError for what is not one."""
    if not isinstance(text, str):
        raise InputError(f"{shown(text)} is not a key path, such as model.rods[0].mass")
    parts: list[str | int] = []
    place = 0
    while place < len(text) or not parts:
        part = _PART.match(text, place)
        dotted = part is not None and text[place] == "."
        if part is None or dotted != (bool(parts) and part[1] is None) or (part[1] and not parts):
            example = 'model.rods[0].mass or start.positions."left hip"'
            raise InputError(f"{shown(text)} is not a key path, such as {example}")
        index, plain, quoted = part.groups()
        try:
            parts.append(int(index) if index else plain or ast.literal_eval(quoted))
        except (SyntaxError, ValueError):
            raise InputError(f"{shown(quoted)} is not a name in quotes") from None
        place = part.end()
    return tuple(parts)


def number_at(record: Any, key: str) -> float:
    """The number at a key path of a scene. Raises InputError where there is none."""
    value = record
    for part in parsed(key):
        try:
            records = not isinstance(value, Mapping | tuple)
            value = ({name: getattr(value, name) for name in type(value).model_fields} if records else value)[part]
        except (AttributeError, LookupError, TypeError):
            raise InputError(f"{key}: the scene has nothing there; name a number, as model.rods[0].length") from None
    if not is_number(value):
        reason = "no number is given there; set one" if value is None else f"{shown(value)} is not a number"
        raise InputError(f"{key}: {reason}")
    return float(value)


def nested(value: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, Any]]:
    """All that is in nested tables and lists, what holds others before these, with its key path."""
    items = value.items() if isinstance(value, Mapping) else enumerate(value) if isinstance(value, list | tuple) else ()
    for part, inner in items:
        yield (*path, part), inner
        yield from nested(inner, (*path, part))


def leaves(value: Any) -> dict[str, Any]:
    """Every value in nested tables and lists that holds no others, by its key path as text."""
    ends = [(path, inner) for path, inner in nested(value) if not isinstance(inner, Mapping | list | tuple)]
    steps = [[f"[{part}]" if isinstance(part, int) else f".{part}" for part in path] for path, _ in ends]
    return {"".join(step).removeprefix("."): inner for step, (_, inner) in zip(steps, ends, strict=True)}
