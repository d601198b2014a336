"""The package's docstrings are plain text with `code`: here they become reStructuredText without changing a word.

A default in a signature that is the name of a constant is shown as its value.
"""

import inspect
import re
from typing import Any

_SPECIAL = re.compile(r"([*|\\])")
_CONSTANT = re.compile(r"(?<== )[A-Z][A-Z_]+\b")
_OPTION = re.compile(r"(`[^`]+`)|(?<![\w-])(--[a-z][a-z-]+|\w+://[\w.:/]*\w)")  # or an address
_TRAILING_UNDERSCORE = re.compile(r"(?<=\w)_(?!\w)")


def escaped(text: str) -> str:
    """One line with `code` and --options as code; elsewhere what has a meaning in reStructuredText is escaped."""
    parts = re.split(r"(`[^`]+`)", _OPTION.sub(lambda found: found[1] or f"`{found[2]}`", text))
    for place, part in enumerate(parts):
        if place % 2:
            parts[place] = f"``{part[1:-1]}``"
        else:
            parts[place] = _TRAILING_UNDERSCORE.sub(r"\\_", _SPECIAL.sub(r"\\\1", part))
    return "".join(parts)


def _is_code(line: str) -> bool:
    return line.lstrip().startswith((">>>", "..."))


def convert(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Escape each line of prose; before napoleon reads the sections."""
    if what == "module":  # the rule for the package's own imports is not for readers of the site
        lines[:] = re.sub(r"\s*May import:[^.]*\.", "", "\n".join(lines)).split("\n")
    literal = False
    for place, line in enumerate(lines):
        if literal and (not line.strip() or line.startswith("    ")):
            continue
        literal = line.rstrip().endswith("::")
        if not literal and not _is_code(line):
            lines[place] = escaped(line)


def show_values(
    app: Any, what: str, name: str, thing: Any, options: Any, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """The signature with the values of constants: `every: float = 30.0`. A record that a run fills in has none."""
    if signature and "<factory>" in signature:
        return "", None
    function = inspect.unwrap(thing.__init__ if isinstance(thing, type) else thing)
    known = getattr(function, "__globals__", {})
    if signature:
        signature = _CONSTANT.sub(lambda found: repr(known.get(found[0], found[0])), signature)
    return signature, returned


def skip(app: Any, what: str, name: str, thing: Any, skipped: bool, options: Any) -> bool | None:
    """Leave out the fields of records (they stand in the table), and what has no docstring."""
    if name.startswith("model_") or name in ("kind",):
        return True
    return skipped or None


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("autodoc-process-docstring", convert, priority=400)
    app.connect("autodoc-skip-member", skip)
    app.connect("autodoc-process-signature", show_values)
    return {"parallel_read_safe": True}
