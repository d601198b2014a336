"""What stands in brackets: groups, columns, lengths and matrices."""

from abc import ABC, abstractmethod
from dataclasses import replace
from fractions import Fraction

from pendpin.doctor.reading.printed_names import PrintedNames
from pendpin.doctor.reading.tokens import Token
from pendpin.doctor.reading.tree import Node, Unread

CLOSING = {"(": ")", "[": "]", "{": "}", "\\{": "\\}"}
MATRICES = {"bmatrix", "pmatrix", "matrix", "array", "smallmatrix", "Bmatrix"}


class Brackets(PrintedNames, ABC):
    """A reader of brackets; what is inside is read by `sum`."""

    @abstractmethod
    def sum(self) -> Node:
        """Terms with their signs: the grammar's."""

    def group(self) -> Node:
        """What stands in brackets; with commas a column."""
        with self.deeper():
            opened = self.take()
            entries = [self.sum()]
            if self.peek().text == "over":
                entries = [self._over(entries[0])]
            while self.peek().kind in (",", ";"):
                self.take()
                entries.append(self.sum())
            self.close(opened)
        span = (opened.start, self.peek(-1).end)
        if len(entries) > 1:
            return Node("matrix", span, (len(entries), 1), tuple(entries))
        return replace(entries[0], bracketed=span)

    def _over(self, above: Node) -> Node:
        r"""The fraction of {a \over b}."""
        self.take()
        below = self.sum()
        start = above.outer[0]
        return Node("product", (start, below.outer[1]), ("*", "/"), (above, below), ((start, start),) * 2)

    def length(self) -> Node:
        """What stands between two |: the length of a vector."""
        with self.deeper():
            opened = self.take()
            self.bars += 1
            inner = self.sum()
            self.bars -= 1
            if self.peek().kind != "|":
                raise Unread("the bracket | is not closed", opened.start)
            closed = self.take()
        return Node("function", (opened.start, closed.end), "norm", (inner,), ((opened.start, opened.end),))

    def close(self, opened: Token) -> None:
        """Take the bracket that closes one. Raises Unread, with the place of the one that is open."""
        token = self.peek()
        if token.kind != "close" or token.text != CLOSING[opened.text]:
            wrong = f"{opened.text} is closed by {token.text}"
            reason = wrong if token.kind == "close" else f"the bracket {opened.text} is not closed"
            raise Unread(reason, opened.start, CLOSING[opened.text])
        self.take()

    def matrix(self) -> Node:
        """The environment of a matrix; an empty entry is 0."""
        with self.deeper():
            start, name = self.take().start, self.environment()
            if name not in MATRICES:
                raise Unread(f"\\begin{{{name}}} has no meaning in an equation here", start)
            if name == "array" and self.peek().kind == "open":
                self.skip_group()
            rows = []
            while not self._at_end():
                rows.append(self._row())
            self.take()
            self.environment()
        width = max(map(len, rows), default=0)
        if not width or any(len(row) != width for row in rows):
            raise Unread("the rows of the matrix have different lengths", start)
        return Node("matrix", (start, self.peek(-1).end), (len(rows), width), tuple(e for row in rows for e in row))

    def _at_end(self) -> bool:
        return self.peek().kind == "command" and self.peek().text == "end"

    def _row(self) -> list[Node]:
        """The entries up to the end of a row, and past it."""
        entries = [self._entry()]
        while self.peek().kind == "&":
            self.take()
            entries.append(self._entry())
        token = self.peek()
        if token.kind == "row":
            self.take()
        elif token.kind != "command":
            raise Unread(f"{token.text!r} ends no entry of a matrix", token.start)
        return entries

    def _entry(self) -> Node:
        token = self.peek()
        if token.kind == "end":
            raise Unread("the matrix has no \\end", token.start)
        if token.kind in ("&", "row") or self._at_end():
            return Node("number", (token.start, token.start), Fraction(0))
        return self.sum()
