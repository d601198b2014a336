"""The errors pendpin raises: each message is one line that says what is wrong, where, and what would be right."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

MOST_CHARACTERS = 1_000  # of a message


class PendpinError(Exception):
    """Root of every error that a user's input or scene can cause. Its message is one line of printable text."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class InputError(PendpinError):
    """A scene, URDF, run file, number or name that cannot be used."""


class RunError(PendpinError):
    """A run that could not reach its end: the message names the time and the reason, `partial` is what was done."""

    def __init__(self, message: str, partial: Any = None) -> None:
        super().__init__(message)
        self.partial = partial


class Halted(RunError):
    """A run that was ended from outside (by the user, for lack of time or of room on the disk) and could go on."""


class Interrupted(Halted):
    """A run that the user stopped."""


class MissingLibrary(PendpinError):
    """An optional library is needed and not installed; the message holds the command that brings it."""


def one_line(text: str) -> str:
    """Text as one line that a terminal can show: lines joined, control characters escaped, the middle of much cut."""
    joined, half = re.sub(r"\s*[\r\n]+\s*", " ", text.strip()), MOST_CHARACTERS // 2
    cut = joined if len(joined) <= MOST_CHARACTERS else f"{joined[:half]}...{joined[-half:]}"
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in cut)


def shown(value: Any, most: int = 60) -> str:
    """A value as one short line of printable text, for a message."""
    if isinstance(value, int) and abs(value) >= 10**most:
        return f"a number of {int(value.bit_length() * 0.30103)} digits"
    try:
        text = one_line(repr(value))
    except (RecursionError, ValueError):  # ValueError: a whole number in it has thousands of digits
        text = f"a {type(value).__name__} that is too deep or too long to show"
    return text if len(text) <= most else f"{text[: most - 3]}..."


def choices(names: Any) -> str:
    """Names as a list in a message."""
    return ", ".join(str(name) for name in names)


@contextmanager
def inside(place: str) -> Iterator[None]:
    """What raises InputError in the block raises it with its place in front, once: `place: message`."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{place}: {str(error).removeprefix(f'{place}: ')}") from None


def explain(faults: list[Any], whole: str) -> str:
    """The first of pydantic's faults as `path: what is wrong`; `whole` names the record where there is no path."""
    fault = min(faults, key=lambda f: f["type"] in {"missing", "too_short"})  # often the echo of another fault
    others = len([f for f in faults if f["type"] != "too_short"]) - 1
    more = f" (and {others} more)" if others > 0 else ""
    return f"{_path(fault) or whole}: {_reason(fault)}{more}"


def _path(fault: Any) -> str:
    path = ""
    for part in fault["loc"]:
        if isinstance(part, int):
            path += f"[{part}]"
        elif not part.startswith("~"):  # names of union branches start with ~
            name = part if re.fullmatch(r"[\w-]+|\[key\]", part) else shown(part)
            path += f".{name}" if path else name
    if fault["type"] == "union_tag_invalid" and fault["ctx"]["tag"] != "~no table":
        path += ".kind"
    return path.removesuffix(".[key]")


def _reason(fault: Any) -> str:
    context, value = fault.get("ctx", {}), shown(fault.get("input"))
    match fault["type"]:
        case "union_tag_invalid" if context["tag"] == "~no table":
            return f"{value} is not a table with a `kind`"
        case "union_tag_invalid" if context["tag"] == "~":
            return f"missing; it is one of: {_allowed(context)}"
        case "union_tag_invalid":
            return f"{shown(context['tag'].removeprefix('~'))} is not one of: {_allowed(context)}"
        case "literal_error":
            return f"{value} is not one of: {context['expected'].replace(chr(39), '').replace(' or ', ', ')}"
        case "value_error":
            return str(context["error"])
        case "float_type" if type(fault["input"]) is int:
            return f"{value} is beyond double precision"
        case kind if kind in _REASONS:
            return _REASONS[kind].format(value=value, **context)
        case _:
            return f"{value}: {fault['msg'].removeprefix('Input ').replace(' after validation', '')}"


def _allowed(context: Any) -> str:
    tags = context["expected_tags"].replace("'", "").split(", ")
    return choices(tag.removeprefix("~") for tag in tags if tag != "~instance")


_REASONS = {
    "extra_forbidden": "unknown key",
    "missing": "missing",
    "float_type": "{value} is not a number",
    "finite_number": "{value} is not a finite number",
    "float_parsing": "{value} is not a number",
    "bool_type": "{value} is not true or false",
    "bool_parsing": "{value} is not true or false",
    "int_parsing": "{value} is not a whole number",
    "int_type": "{value} is not a whole number",
    "int_from_float": "{value} is not a whole number",
    "greater_than": "{value} is not above {gt:.15g}",
    "greater_than_equal": "{value} is below {ge:.15g}",
    "less_than": "{value} is not below {lt:.15g}",
    "less_than_equal": "{value} is above {le:.15g}",
    "string_type": "{value} is not text",
    "path_type": "{value} is not a path",
    "tuple_type": "{value} is not a list",
    "dict_type": "{value} is not a table",
    "model_type": "{value} is not a table",
    "too_long": "{actual_length} values, where {max_length} are wanted",
    "too_short": "{actual_length} values, where at least {min_length} are wanted",
}
