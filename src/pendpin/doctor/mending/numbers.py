"""A wrong equation in numbers: its residual with other trees for some parts, and what each part would have to be."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pendpin.doctor.checking.evaluation import Known, evaluate
from pendpin.doctor.checking.residuals import Equation, changed, residuals, stack_residuals
from pendpin.doctor.reading.tree import Node, Unread, walk
from pendpin.doctor.systems.base import Quantities, Values, dot

CLOSE = 1e-8  # relative to the residual
ROLES = {"sum": "term", "matrix": "entry", "product": "factor", "function": "argument"}


@dataclass(frozen=True)
class Part:
    """A part of a printed equation, and what it is in what stands above it, from the side down to its parent."""

    node: Node
    role: str  # side, term, entry, factor, divisor, base or argument
    parents: tuple[Node, ...] = ()
    index: int = 0
    lone: bool = False  # a symbol or number that is all of a side, such as what an equation is solved for

    @property
    def whole(self) -> bool:
        """Whether it is a sum's term, a side or an entry: what can be added to and has a sign of its own."""
        return self.role in ("side", "term", "entry")

    @property
    def top(self) -> Node:
        """The outermost derivative that it stands in, or itself."""
        return next((node for node in self.parents if node.kind == "derivative"), self.node)


def parts_of(equation: Equation) -> list[Part]:
    """Every part of an equation, with its place."""

    def below(part: Part) -> Iterator[Part]:
        yield part
        node = part.node
        for i, child in enumerate(node.children):
            role = "divisor" if node.kind == "product" and node.value[i] == "/" else ROLES.get(node.kind, "base")
            yield from below(Part(child, role, (*part.parents, node), i))

    several = len(equation.sides) > 1
    sides = (Part(s, "side", (), 0, several and s.kind in ("symbol", "number")) for s in equation.sides)
    return [part for side in sides for part in below(side)]


def swapped(node: Node, swaps: Mapping[int, Node]) -> Node:
    """A tree with other parts, by id."""
    if id(node) in swaps or not node.children:
        return swaps.get(id(node), node)
    children = tuple(swapped(child, swaps) for child in node.children)
    return node if all(map(lambda a, b: a is b, children, node.children)) else replace(node, children=children)


class Numbers:
    """The values of an equation's parts at random states, and its residual with others in their places."""

    def __init__(self, equation: Equation, every: list[Part], quantities: Quantities) -> None:
        self.equation, self.quantities, self.known = equation, quantities, Known()
        self.rows = stack_residuals(equation, quantities, self.known)
        self.size = float(np.abs(self.rows).max())
        self._context = equation.context(quantities)
        self._tops = {id(part.node): part.top for part in every}
        self._above: dict[int, set[int]] = defaultdict(set)  # a part and all that it stands in, by id
        for part in every:
            for node in walk(part.node):
                self._above[id(node)].add(id(part.node))
        self._responses: dict[int, tuple[int, Values] | None] = {}

    def vanishes(self, rows: Values | None) -> bool:
        """Whether a residual is rounding."""
        return rows is not None and bool(np.abs(rows).max() <= CLOSE * self.size)

    def residual(self, swaps: Mapping[int, Node]) -> Values | None:
        """The residual with other trees for some parts, (k, n); None where it has no value.

        Where it is straight in a part, the slope gives it; else all that the parts stand in is evaluated again.
        """
        try:
            with np.errstate(all="ignore"):
                tops = {id(self._tops[place]): self._tops[place] for place in swaps}
                values = {
                    place: evaluate(swapped(node, swaps), self._context, None, self.known)
                    for place, node in tops.items()
                }
                place, value = next(iter(values.items()))
                response = self._responses.get(place)
                straight = response and response[0] == 1 and value.ndim == 1 and not self.equation.floats
                if response and straight and len(values) == 1:
                    return self.rows + response[1] * (value - self.known[place])
        except Unread:
            return None
        return changed(self.equation, self.quantities, {**self._kept(values), **values})

    def needed(self, part: Part) -> Iterator[Values]:
        """The values of a part with which the equation would hold: several where energies stand in it."""
        node, rows = part.node, self._targets[0]
        value = self.known.get(id(node))
        if value is None or part.top is not node:
            return
        try:
            if value.ndim == 1:
                power, slope = self._response(node, value)
                for target in self._targets if power else ():
                    with np.errstate(all="ignore"):
                        step = -(target * slope).sum(0) / (slope * slope).sum(0)
                        wanted = value**power + step
                        if np.abs(target + slope * step).max() <= CLOSE * self.size:
                            yield np.abs(wanted) ** (1 / power) if power % 2 == 0 else wanted**power
            elif value.shape == rows.shape and (part.whole or node.kind == "sum"):
                step = self._plain({id(node): value + rows}) - rows
                slope = dot(step, rows) / dot(rows, rows)
                if np.abs(step - slope * rows).max() <= CLOSE * self.size:
                    yield value - rows / slope
        except Unread:
            return

    def _response(self, node: Node, value: Values) -> tuple[int, Values]:
        """The power of a part's value in which the residual is straight, and its slope, (k, n); 0 where there is none."""
        if (known := self._responses.get(id(node))) is not None:
            return known
        rows, start, found = self._targets[0], value.astype(float), (0, value)
        for power in (1, -1, 2, -2) if node.kind == "number" else (1,):
            with np.errstate(all="ignore"):
                one, two = (self._plain({id(node): (start**power + k) ** (1 / power)}) for k in (1, 2))
            if np.abs(two - 2 * one + rows).max() <= 1e-10 * np.abs(two).max():
                found = (power, one - rows)
                break
        self._responses[id(node)] = found
        return found

    @cached_property
    def _targets(self) -> list[Values]:
        """What has to vanish: the residual, also with a usual constant in an energy."""
        rows, q = self._plain({}), self.quantities
        lengths = [q[name] for name in ("h", "l") if name in q] if self.equation.floats and "m" in q else []
        return [rows, *(rows + sign * q["m"] * q["g"] * length for length in lengths for sign in (1, -1))]

    def _plain(self, values: Mapping[int, Values]) -> Values:
        """The residual with other values, (k, n), an energy's constant taken as 0."""
        every = residuals(self.equation, self.quantities, None, {**self._kept(values), **values})
        with np.errstate(all="ignore"):
            return np.concatenate([rows for rows, _ in every])

    def _kept(self, values: Mapping[int, Values]) -> Known:
        """The values of what the parts do not stand in; none where an energy's zero is found by moving it."""
        touched = set().union(*(self._above[place] for place in values))
        return {} if self.equation.floats else {p: value for p, value in self.known.items() if p not in touched}
