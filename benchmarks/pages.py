"""Writes what a benchmark measured into the pages that show it, between two marks."""

from collections.abc import Sequence
from pathlib import Path


def write_between_marks(page: Path, mark: str, lines: Sequence[str]) -> None:
    """Replace what stands between `<!-- mark -->` and `<!-- end of mark -->`, each on a line of its own."""
    begin, end = f"<!-- {mark} -->\n", f"<!-- end of {mark} -->\n"
    text = page.read_text()
    assert text.count(begin) == text.count(end) == 1, f"{page}: the marks of {mark} are not there once"
    before, rest = text.split(begin)
    page.write_text(before + begin + "\n".join(lines).rstrip() + "\n" + end + rest.split(end)[1])
