"""The tree of a printed expression: what stands where, as it was printed."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal

Kind = Literal["number", "symbol", "sum", "product", "power", "function", "matrix", "derivative"]
Span = tuple[int, int]  # characters of the source, [start, end)


@dataclass(frozen=True)
class Written:
    """A printed symbol: its letter, how many dots, its index, a hat or bold type, frames before and after."""

    letter: str
    dots: int = 0
    index: str = ""
    styled: bool = False
    frames: str = ""


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
    """What two nodes that are printed alike have in common, wherever they stand."""
    return (node.kind, node.value, *(key(child) for child in node.children))


def symbols(node: Node) -> set[str]:
    """The names of the quantities in an expression."""
    return {part.value for part in walk(node) if part.kind in ("symbol", "derivative")} - {"t"}


def with_meaning(node: Node, name: Written, value: str) -> Node:
    """An expression in which one printed symbol has another meaning."""
    if node.kind == "symbol" and node.written == name:
        return replace(node, value=value)
    return replace(node, children=tuple(with_meaning(child, name, value) for child in node.children))
