"""The package's docstrings are plain text with `code`: here they become reStructuredText without changing a word."""

import re
from typing import Any

_SPECIAL = re.compile(r"([*|\\])")
_TRAILING_UNDERSCORE = re.compile(r"(?<=\w)_(?!\w)")


def escaped(text: str) -> str:
    """One line with `code` kept as code, and characters that have a meaning in reStructuredText escaped elsewhere."""
    parts = re.split(r"(`[^`]+`)", text)
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
    literal = False
    for place, line in enumerate(lines):
        if literal and (not line.strip() or line.startswith("    ")):
            continue
        literal = line.rstrip().endswith("::")
        if not literal and not _is_code(line):
            lines[place] = escaped(line)


def skip(app: Any, what: str, name: str, thing: Any, skipped: bool, options: Any) -> bool | None:
    """Leave out the fields of records (they stand in the table), and what has no docstring."""
    if name.startswith("model_") or name in ("kind",):
        return True
    return skipped or None


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("autodoc-process-docstring", convert, priority=400)
    app.connect("autodoc-skip-member", skip)
    return {"parallel_read_safe": True}
