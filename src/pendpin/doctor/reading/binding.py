"""What is read gets a meaning: printed names become the quantities of one system, or stay the text's own."""

from dataclasses import replace

from pendpin.doctor.reading.names import Vocabulary, Written
from pendpin.doctor.reading.tree import Node, Span

MOST_DOTS = 6
FUNCTIONS_OF_STATE = {"T", "V", "L", "E", "x", "y", "z", "rG", "b3"}


def bound(node: Node, words: Vocabulary) -> Node:
    """A tree whose names are the first meanings that some words give them.

    A bracket that only says what a quantity depends on, as in D(phi), is no factor.
    """
    if node.kind == "symbol":
        assert node.written is not None
        return replace(named(node.written, node.span, words), bracketed=node.bracketed)
    children = tuple(bound(child, words) for child in node.children)
    if node.kind == "derivative":
        return replace(node, value=words(node.written)[0] if node.written else "t", children=children)
    if node.kind != "product":
        return replace(node, children=children) if children else node
    arguments = [i for i in range(1, len(children)) if _is_argument(children[i - 1], children[i], words)]
    if not arguments:
        return replace(node, children=children)
    every = {i - 1 for i in arguments if _of_all(children[i])}
    left = [i for i in range(len(children)) if i not in arguments]
    factors = [_styled(children[i], words) if i in every else children[i] for i in left]
    if len(factors) == 1:
        return factors[0] if node.bracketed is None else replace(factors[0], bracketed=node.bracketed)
    operators, marks = (tuple(listed[i] for i in left) for listed in (node.value, node.marks))
    return replace(node, value=operators, children=tuple(factors), marks=marks)


def named(written: Written, span: Span, words: Vocabulary) -> Node:
    """A printed name as a node; with dots over what has no name for its rate, a derivative in time."""
    found = words(written)
    if 0 < written.dots < MOST_DOTS and found[0].startswith("?"):
        return Node("derivative", span, "t", (named(replace(written, dots=written.dots - 1), span, words),))
    return Node("symbol", span, found[0], written=written)


def _is_argument(name: Node, node: Node, words: Vocabulary) -> bool:
    """Whether a bracket says what a quantity depends on."""
    if node.kind != "matrix" and not node.bracketed:
        return False
    inside = node.children if node.kind == "matrix" else (node,)
    known = name.kind in ("symbol", "derivative") and not name.bracketed
    function = known and (str(name.value).startswith("?") or name.value in FUNCTIONS_OF_STATE)
    states = all(part.kind == "symbol" and part.value in words.state for part in inside)
    return bool((function and states) or (known and _of_all(node)))


def _of_all(node: Node) -> bool:
    """Whether an argument is all coordinates at once, or their rates."""
    inside = node.children if node.kind == "matrix" else (node,)
    return all(part.kind == "symbol" and part.value in ("q", "dq") for part in inside)


def _styled(node: Node, words: Vocabulary) -> Node:
    """A name as if in bold type: M(q) is a matrix or vector, however it is printed."""
    return node if node.written is None else named(replace(node.written, styled=True), node.span, words)
