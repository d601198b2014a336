"""The tree of a printed expression: what stands where, as it was printed."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

Kind = Literal["number", "symbol", "sum", "product", "power", "function", "matrix", "derivative"]
Span = tuple[int, int]  # characters of the source, [start, end)
Name = tuple[str, str]  # a letter and its index
Rename = Callable[["Written"], "Written"]


@dataclass(frozen=True)
class Written:
    """A printed symbol: its letter, how many dots, its index, a hat or bold type, frames before and after."""

    letter: str
    dots: int = 0
    index: str = ""
    styled: bool = False
    frames: str = ""

    @property
    def name(self) -> Name:
        """Its letter and index."""
        return self.letter, self.index


TIME = Written("t")


class Unread(Exception):
    """What cannot be read: the message says why, `place` is the character of the source, `bracket` what is missing."""

    def __init__(self, reason: str, place: int = 0, bracket: str = "") -> None:
        super().__init__(reason)
        self.reason, self.place, self.bracket = reason, place, bracket


class Mismatch(Unread):
    """Numbers and vectors where the other is wanted: the text is read, but says nothing."""


@dataclass(frozen=True, eq=False)
class Node:
    """One part of an expression.

    kind      children              value                                  marks: spans in the source
    number    none                  Fraction                               none
    symbol    none                  name of the quantity                   none
    sum       terms                 signs (1 or -1)                        the sign of each, empty if none is printed
    product   factors               operators * / x (cross) . (dot) each   the operator, empty if none is printed
    power     base                  Fraction                               the exponent with its ^
    function  argument              sin, cos, ..., sqrt, norm              the name
    matrix    entries row by row    (rows, columns)                        none
    derivative expression           the variable: t, or a symbol's name    the variable, if it is printed
    """

    kind: Kind
    span: Span
    value: Any = None
    children: tuple["Node", ...] = ()
    marks: tuple[Span, ...] = ()
    bracketed: Span | None = None  # the brackets around it, where there are some
    fraction: bool = False  # a product printed as \\frac{}{}
    written: Written | None = None  # of a symbol

    @property
    def outer(self) -> Span:
        """Its place with its brackets."""
        return self.bracketed or self.span

    @cached_property
    def names(self) -> frozenset[str]:
        """The names of the quantities in it."""
        own = (self.value,) if self.kind in ("symbol", "derivative") and self.value != "t" else ()
        return frozenset(own).union(*(child.names for child in self.children))


def walk(node: Node) -> Iterator[Node]:
    """The node and everything below it, parents first."""
    nodes = [node]
    while nodes:
        node = nodes.pop()
        yield node
        nodes.extend(reversed(node.children))


def parts(sides: Iterable[Node]) -> Iterator[Node]:
    """Everything in some sides."""
    return (part for side in sides for part in walk(side))


def key(node: Node) -> tuple:
    """What two nodes that are printed alike have in common, wherever they stand, and whichever value a name has there."""
    value = node.value.partition("@")[0] if node.kind == "symbol" else node.value
    return (node.kind, value, *(key(child) for child in node.children))


def names_in(sides: Iterable[Node], definitions: Mapping[str, Node]) -> set[str]:
    """The names in some expressions, those inside definitions too."""
    found, fresh = set[str](), set[str]().union(*(side.names for side in sides))
    while fresh:
        found |= fresh
        fresh = set().union(*(definitions[name].names for name in fresh & definitions.keys())) - found
    return found


def with_meaning(node: Node, name: Written, value: str) -> Node:
    """An expression in which one printed symbol has another meaning."""
    if node.kind == "symbol" and node.written == name:
        return replace(node, value=value)
    return replace(node, children=tuple(with_meaning(child, name, value) for child in node.children))


def unknown(written: Written) -> str:
    """The name of a symbol that has no meaning of its own."""
    letter, dots, index, frames = written.letter, written.dots, written.index, written.frames
    return "?" + "d" * dots + letter + (f"_{index}" if index else "") + (f"^{frames}" if frames else "")


def rename(node: Node, change: Rename) -> Node:
    """An expression with other names."""
    written = change(node.written) if node.written else None
    value = unknown(written) if written and node.kind in ("symbol", "derivative") else node.value
    return replace(node, written=written, value=value, children=tuple(rename(one, change) for one in node.children))


def symbol_node(written: Written, span: Span) -> Node:
    """A printed name as a symbol whose meaning is not known yet."""
    return Node("symbol", span, unknown(written), written=written)


def divide(above: Node, below: Node, span: Span, mark: int, fraction: bool = True) -> Node:
    """A quotient; `mark` is the place of its sign."""
    return Node("product", span, ("*", "/"), (above, below), ((mark, mark),) * 2, fraction=fraction)


def differentiate(node: Node, by: Node, order: object, span: Span) -> Node:
    """The derivative of a node; a symbol's rate is a symbol. `written` is what it is derived by."""
    if by.written is None or order not in (1, 2):
        raise Unread("only first and second derivatives by one symbol are read", span[0])
    for _ in range(int(order)):
        if by.written == TIME and node.written is not None and node.kind == "symbol":
            node = symbol_node(replace(node.written, dots=node.written.dots + 1), span)
        else:
            node = Node("derivative", span, by.value, (node,), (by.span,), written=by.written)
    return node


def matrix_of(rows: list[list[Node]], span: Span) -> Node:
    """A matrix from its rows. Raises Unread where they have different lengths."""
    if len({len(row) for row in rows}) != 1:
        raise Unread("the rows of the matrix have different lengths", span[0])
    return Node("matrix", span, (len(rows), len(rows[0])), tuple(entry for row in rows for entry in row))
