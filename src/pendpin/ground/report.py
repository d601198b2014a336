"""A report: what a tool found, as sentences and tables with units, as plain data, and whether all is well.

Every result of a tool is a `Result`: it says what it found in one `Report`, and prints alike as text, in a notebook or on a
page. cli/outputs.py prints reports on the terminal, as tables or as JSON.
"""

import html
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from pendpin.errors import brief

FEW = 8  # rows of each table in a representation: all of pendpin's routes for one rod, and any two, stay whole


class Table(NamedTuple):
    """Columns with titles, which name the unit of their numbers where cells do not, and rows of cells as text."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    more: int = 0  # further rows, which are left out
    whole: str = ""  # how to see them all

    def first(self, most: int) -> "Table":
        """The table with at most this number of rows."""
        return self._replace(rows=self.rows[:most], more=self.more + max(len(self.rows) - most, 0))

    @property
    def left_out(self) -> list[str]:
        """A line that counts the rows that are left out, if there are any."""
        return [f"... and {self.more} more{self.whole and f'; all: {self.whole}'}"] * bool(self.more)

    def lines(self) -> Iterator[str]:
        """The table as text, in aligned columns; without a head where no column but the first has a title."""
        rows = [self.head, *self.rows] if any(self.head[1:]) else self.rows
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        for row in rows:
            yield "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        yield from self.left_out


class Styled(str):
    """A line of text in pieces, each with its style on a terminal, in words of rich."""

    pieces: Sequence[tuple[str, str]]

    def __new__(cls, pieces: Sequence[tuple[str, str]]) -> "Styled":
        """The text of all pieces."""
        line = super().__new__(cls, "".join(text for text, _ in pieces))
        line.pieces = pieces
        return line


@dataclass(frozen=True, repr=False)
class Report:
    """What a tool found: its parts in the order in which they are read, and all of it as plain data."""

    parts: Sequence[str | Table]
    data: Any
    fault: str | None = None  # what is not well, in one line; None if all is well

    def __str__(self) -> str:
        return "\n".join(line for part in self.parts for line in ([part] if isinstance(part, str) else part.lines()))

    def __repr__(self) -> str:
        parts = tuple(part if isinstance(part, str) else part.first(FEW) for part in self.parts)
        text = str(Report(parts, None))
        return brief(f"{self.fault}\n{text}" if self.fault else text)

    def _repr_html_(self) -> str:
        pieces = list[str]()
        for part in self.parts:
            if isinstance(part, str):
                pieces.append(_paragraph(part))
                continue
            cells = [[html.escape(cell) for cell in row] for row in [part.head, *part.rows]]
            head, *rows = ("".join(f"<td>{cell}</td>" for cell in row) for row in cells)
            heading = f"<tr>{head.replace('td>', 'th>')}</tr>" if any(part.head[1:]) else ""
            body = "".join(f"<tr>{row}</tr>" for row in rows)
            pieces += [f"<table>{heading}{body}</table>", *map(_paragraph, part.left_out)]
        return "".join(pieces)

    @property
    def tables(self) -> list[Table]:
        """Its tables."""
        return [part for part in self.parts if isinstance(part, Table)]

    @property
    def sentences(self) -> list[str]:
        """All that is not a table."""
        return [part for part in self.parts if isinstance(part, str)]


class Result(ABC):
    """The result of a tool, which prints as its report."""

    @abstractmethod
    def report(self) -> Report:
        """What was found, in sentences, tables and plain data."""

    def __str__(self) -> str:
        return str(self.report())

    def __repr__(self) -> str:
        return repr(self.report())

    def _repr_html_(self) -> str:
        return self.report()._repr_html_()


def _paragraph(text: str) -> str:
    return f"<p>{html.escape(text)}</p>"
