"""Replacing values in nested records by their key paths."""

from typing import Any

from pendpin.effects import Effect, has_kind
from pendpin.errors import InputError, KeyPath, inside, written
from pendpin.ground.records import Record


def changed(value: Any, path: KeyPath, new: Any, place: KeyPath = ()) -> Any:
    """Nested data with one value replaced: records on the way become tables, lists and tables are copied.

    Raises InputError where the path leads nowhere; what an unknown name in a record is, the record's own check says.
    """
    if not path:
        return new
    key, rest = path[0], path[1:]
    here = (*place, key)
    if isinstance(value, Record):
        if key in type(value).model_fields:
            new = changed(default_of(value, key), rest, new, here)
        fields = value.given() | {_name(key, place): new}
        if not isinstance(value, Effect) or has_kind(value):
            return fields
        with inside(written(place)):
            return type(value)(**fields)  # of a user's own class: no table could name it
    if isinstance(value, dict):
        return value | {_name(key, place): changed(value.get(key), rest, new, here)}
    if isinstance(value, tuple | list):
        if not isinstance(key, int) or key >= len(value):
            there = f"from [0] to [{len(value) - 1}]" if len(value) > 1 else "[0] alone" if value else "empty"
            raise InputError(f"{written(here)}: {written(place)} is a list of {len(value)}: {there}")
        return [*value[:key], changed(value[key], rest, new, here), *value[key + 1 :]]
    if value is None and isinstance(key, str):  # a table that was left out
        return {key: changed(None, rest, new, here)}
    why = "nothing is given there" if value is None else f"{value!r} has no parts"
    raise InputError(f"{written(here)}: {written(place)}: {why}; set {written(place)} as a whole")


def default_of(record: Record, name: Any) -> Any:
    """The value of a field, given or not; None where there is no such field."""
    return getattr(record, name) if name in type(record).model_fields else None


def _name(key: str | int, place: KeyPath) -> str:
    if isinstance(key, int):
        raise InputError(f"{written((*place, key))}: {written(place)} is a table of names, not a list")
    return key
