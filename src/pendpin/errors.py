"""The errors pendpin raises: each message is one line that says what is wrong, where, and what would be right."""

import re
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


class MissingLibrary(PendpinError):
    """An optional library is needed and not installed; the message holds the command that brings it."""


def one_line(text: str) -> str:
    """Text as one line that a terminal can show: lines joined, control characters escaped, cut where it has no end."""
    joined = re.sub(r"\s*[\r\n]+\s*", " ", text.strip())
    cut = joined if len(joined) <= MOST_CHARACTERS else f"{joined[:MOST_CHARACTERS]}..."
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in cut)


def shown(value: Any, most: int = 60) -> str:
    """A value as one short line of printable text, for a message."""
    if isinstance(value, int) and abs(value) >= 10**most:
        return "a whole number without end"
    text = one_line(repr(value))
    return text if len(text) <= most else f"{text[: most - 3]}..."


def choices(names: Any) -> str:
    """Names as a list in a message."""
    return ", ".join(str(name) for name in names)


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
            path += f".{part}" if path else part
    if fault["type"] == "union_tag_invalid" and fault["ctx"]["tag"] != "~no table":
        path += ".kind"
    return path.removesuffix(".[key]")


def _reason(fault: Any) -> str:
    context, value = fault.get("ctx", {}), shown(fault.get("input"))
    match fault["type"]:
        case "union_tag_invalid" if context["tag"] == "~no table":
            return f"{value} is not a table with a `kind`"
        case "union_tag_invalid":
            allowed = [tag for tag in context["expected_tags"].replace("'", "").split(", ") if tag != "~instance"]
            return f"{shown(context['tag'].removeprefix('~'))} is not one of: {choices(allowed).replace('~', '')}"
        case "literal_error":
            return f"{value} is not one of: {context['expected'].replace(chr(39), '')}"
        case "value_error":
            return str(context["error"])
        case kind if kind in _REASONS:
            return _REASONS[kind].format(value=value, **context)
        case _:
            return f"{value}: {fault['msg'].removeprefix('Input ').replace(' after validation', '')}"


_REASONS = {
    "extra_forbidden": "unknown key",
    "missing": "missing",
    "float_type": "{value} is not a number",
    "finite_number": "{value} is not a finite number",
    "int_type": "{value} is not a whole number",
    "int_from_float": "{value} is not a whole number",
    "greater_than": "{value} is not above {gt}",
    "greater_than_equal": "{value} is below {ge}",
    "less_than": "{value} is not below {lt}",
    "less_than_equal": "{value} is above {le}",
    "string_type": "{value} is not text",
    "path_type": "{value} is not a path",
    "tuple_type": "{value} is not a list",
    "dict_type": "{value} is not a table",
    "model_type": "{value} is not a table",
    "too_long": "{actual_length} values, where {max_length} are wanted",
    "too_short": "{actual_length} values, where at least {min_length} are wanted",
}
