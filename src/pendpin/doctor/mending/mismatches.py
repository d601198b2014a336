"""Changes of an equation that mixes numbers and vectors: a unit vector missing, too many, or in place of another symbol."""

from collections.abc import Iterator

import numpy as np

from pendpin.doctor.mending.edits import Edit, Editor
from pendpin.doctor.mending.needs import Need, Role
from pendpin.doctor.reading.tree import Node

NOTHING = np.zeros(1)
MOST_TERMS = 6  # of a sum whose neighbouring terms are tried together
SCALARS = ("theta", "phi", "dtheta", "dphi", "ddtheta", "ddphi", "m", "l", "g", "h")


def changes_of_kind(sides: list[Node], editor: Editor) -> Iterator[Edit]:
    """Edits that turn a number into a vector or the reverse, without values: their texts are to be tried."""
    for side in sides:
        for need in _parts(side, "side", (), 0):
            yield from _changes(need, editor)


def _parts(node: Node, role: Role, parents: tuple[Node, ...], index: int) -> Iterator[Need]:
    yield Need(node, NOTHING, None, role, parents, index)
    if node.kind in ("function", "derivative"):
        return
    inner: Role = {"sum": "term", "power": "base", "matrix": "entry"}.get(node.kind, "factor")  # type: ignore[assignment]
    for i, child in enumerate(node.children):
        yield from _parts(child, inner, (*parents, node), i)


def _changes(need: Need, editor: Editor) -> Iterator[Edit]:
    node, joint = need.node, " " if editor.printer.latex else "*"
    directions = editor.printer.spec.directions
    if need.whole and node.kind != "sum":
        for name in directions:
            text, old, end = editor.printer.symbol(name), editor.of(node.outer), node.outer[1]
            yield Edit(((end, end, joint + text),), 1.2, f"{text} is missing after {old}", old, f"{old} {text}")
    if node.kind == "sum":
        yield from _directions_of_runs(node, editor)
    if need.role == "factor" and node.kind == "symbol":
        yield editor.removed(need, "factor", 1.25)
    if need.role == "term" and len(need.parents[-1].children) > 1:
        yield editor.removed(need, "term", 1.3)
    if node.kind == "symbol":
        for name in SCALARS if node.value in editor.printer.spec.vectors else directions:
            yield editor.replaced(need, editor.put(node.span, editor.printer.symbol(name)), 1.15)


def _directions_of_runs(node: Node, editor: Editor) -> Iterator[Edit]:
    """A unit vector after several neighbouring terms, which then stand in brackets."""
    for first in range(min(len(node.children), MOST_TERMS) - 1):
        for last in range(first + 1, min(len(node.children), MOST_TERMS)):
            start = node.children[first].outer[0] if first else node.marks[0][0]
            end = node.children[last].outer[1]
            for name in editor.printer.spec.directions:
                text = editor.printer.symbol(name)
                splices = ((start, start, "("), (end, end, ")" + (" " if editor.printer.latex else "*") + text))
                old = editor.of((start, end))
                yield Edit(splices, 1.35, f"{text} is missing after {old}", old, f"({old}) {text}")
