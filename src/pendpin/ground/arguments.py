"""Arguments of Python functions: each as it is used, or InputError with its name."""

import operator
from typing import Any

import numpy as np

from pendpin.errors import InputError, is_number, shown
from pendpin.ground.arrays import Array


def flag(name: str, value: Any) -> bool:
    """A bool, Python's or NumPy's: any text and NaN would count as true."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise InputError(f"{name}: {shown(value)} is neither True nor False")


def count(name: str, value: Any, least: int = 1) -> int:
    """A whole number, Python's or NumPy's."""
    if not isinstance(value, int | np.integer) or isinstance(value, bool) or value < least:
        raise InputError(f"{name}: {shown(value)} is not a count of {least} or more")
    return operator.index(value)


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


def seconds(name: str, value: Any) -> float:
    """A number of seconds, 0 or above, or infinity."""
    number = value.item() if isinstance(value, np.generic) else value
    if not is_number(number) or not number >= 0:
        raise InputError(f"{name}: {shown(value)} is not a number of seconds, 0 or above")
    return number


def numbers(name: str, values: Any) -> Array:
    """Numbers as an array of floats of any shape, finite or not; not text, complex numbers or bools."""
    try:
        array = np.asarray(values)
        if array.dtype.char == "d":
            return array
        if array.dtype.kind not in "iufO":
            raise TypeError
        return array.astype(float, copy=False)
    except (TypeError, ValueError):
        raise InputError(f"{name}: {shown(values)} are not numbers") from None
