"""What the commands print on the terminal: a report as sentences and tables, or its data as JSON."""

import os
from collections.abc import Mapping
from dataclasses import asdict, is_dataclass
from math import isfinite
from pathlib import Path
from typing import Any

from pendpin.ground.report import Report, Table

LEAST_WIDTH = 60  # letters: on a narrower terminal the lines of a table go on below
IN_A_FILE = 120  # letters, where the output is not a terminal


def print_report(report: Report, as_json: bool) -> None:
    """Print a report, or its data as JSON."""
    if as_json:
        print_json(report.data)
        return
    for part in report.parts:
        print(part) if isinstance(part, str) else print_table(part)


def print_table(table: Table) -> None:
    """A table on the terminal: names in the first column stay in one piece, and no letter is cut."""
    from rich import box, console
    from rich import table as rich

    names = not any(" " in row[0] for row in table.rows)
    columns = [rich.Column(title, overflow="fold", no_wrap=i == 0 and names) for i, title in enumerate(table.head)]
    shown = rich.Table(*columns, show_header=any(table.head[1:]), box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for row in table.rows:
        shown.add_row(*map(_plain_text, row))
    terminal = console.Console()
    known = terminal.is_terminal or "COLUMNS" in os.environ
    terminal.width = max(terminal.width, LEAST_WIDTH) if known else IN_A_FILE
    terminal.print(shown)
    for line in table.left_out:
        print(line)


def _plain_text(cell: str) -> Any:
    """A cell without markup, which may be in what users named."""
    from rich.text import Text

    return Text(cell)


def print_json(value: Any) -> None:
    """JSON on the terminal; a number that is not finite, which JSON lacks, is null."""
    from json import dumps

    print(dumps(_plain(value), indent=2, default=str))


def _plain(value: Any) -> Any:
    if is_dataclass(value) and not isinstance(value, type):
        value = asdict(value)
    if isinstance(value, Mapping):
        return {str(key): _plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return None if isinstance(value, float) and not isfinite(value) else value


def print_files(files: list[Path], as_json: bool = False) -> None:
    """The files written, a line each; none beside JSON."""
    for file in () if as_json else files:
        print(f"wrote {file}")
