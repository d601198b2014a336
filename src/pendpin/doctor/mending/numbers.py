"""A wrong equation in numbers: its residual with other trees for some parts, what each part would have to be, and how values
are read back as a small fraction times a product of powers.
"""

import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from typing import NamedTuple

import numpy as np

from pendpin.doctor.checking.evaluation import ENERGIES, Equation, Known
from pendpin.doctor.checking.residuals import changed, stack_residuals
from pendpin.doctor.reading.names import CONSTANTS
from pendpin.doctor.reading.tree import Node, Unread, names_in, walk
from pendpin.doctor.systems.base import Quantities, Values, dot, formula

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

    def __init__(self, equation: Equation, quantities: Quantities) -> None:
        self.equation, self.quantities, self.known = equation, quantities, Known()
        self.rows = stack_residuals(equation, quantities, self.known)
        self.size = float(np.abs(self.rows).max())
        # beside changes elsewhere all keeps its value but energies, constants and tensors, which depend on other names
        self._fixed = dict(self.known)
        for node in (part.node for part in parts_of(equation) if id(part.node) in self.known):
            names = set(map(equation.meaning, names_in((node,), equation.definitions)))
            if names & (ENERGIES.keys() | CONSTANTS) or any(part.value in ((3, 1), (3, 3)) for part in walk(node)):
                del self._fixed[id(node)]

    def vanishes(self, rows: Values | None) -> bool:
        """Whether a residual is rounding."""
        return rows is not None and bool(np.abs(rows).max() <= CLOSE * self.size)

    def residual(self, swaps: Mapping[int, Node]) -> Values | None:
        """The residual with other trees for some parts, (k, n); None where it has no value.

        What does not change keeps its value, but for energies, whose zero is found by moving them.
        """
        sides = tuple(swapped(side, swaps) for side in self.equation.sides)
        return changed(replace(self.equation, sides=sides), self.quantities, self._fixed)

    def needed(self, part: Part) -> Values | None:
        """The value of a part with which the equation would hold; of a number its size. None where there is none.

        Two other values of the part show whether the residual is straight in it, its square or the inverse of these. Of a
        vector only what the residual can be taken from is known: a side or a term. An energy's constant is taken as 0.
        """
        above = {id(node) for node in (*part.parents, part.node)}
        kept = {} if self.equation.energies else {place: v for place, v in self.known.items() if place not in above}

        def rows_with(value: Values) -> Values:
            return stack_residuals(self.equation, self.quantities, None, kept | {id(part.node): value}, plain=True)

        if (value := self.known.get(id(part.node))) is None:  # within a derivative
            return None
        with suppress(Unread), np.errstate(all="ignore"):
            rows = rows_with(value)
            if value.ndim > 1 and value.shape == rows.shape and (part.whole or part.node.kind == "sum"):
                step = rows_with(value + rows) - rows
                slope = dot(step, rows) / dot(rows, rows)
                return value - rows / slope if self.vanishes(step - slope * rows) else None
            start = value.astype(float)
            for power in (1, -1, 2, -2) if part.node.kind == "number" else (1,) if value.ndim == 1 else ():
                one, two = (rows_with((start**power + k) ** (1 / power)) for k in (1, 2))
                slope = one - rows
                if np.abs(two - one - slope).max() <= 1e-10 * np.abs(two).max():
                    step = -(rows * slope).sum(0) / (slope * slope).sum(0)
                    wanted = start**power + step
                    wanted = wanted if power == 1 else np.abs(wanted) ** (1 / power)
                    return wanted if self.vanishes(rows + slope * step) else None
        return None


class Monomial(NamedTuple):
    """A fraction times powers of atoms: names of quantities, "sin phi" and the like."""

    factor: Fraction
    powers: tuple[tuple[str, int], ...] = ()

    @property
    def size(self) -> int:
        """How much there is to write."""
        return sum(abs(power) for _, power in self.powers)


MOST = 60  # of the numerator and denominator of a fraction that counts as small
MOST_POWER = 4


def fraction_of(values: Values) -> Fraction | None:
    """The small fraction that all values are within rounding of, or None."""
    first = float(values[0])
    if not np.isfinite(values).all() or np.ptp(values) > CLOSE * max(abs(first), 1e-12) or not abs(first) < MOST:
        return None
    found = Fraction(float(np.mean(values))).limit_denominator(MOST)
    return found if 0 < abs(found.numerator) <= MOST and abs(float(found) - first) < CLOSE * abs(first) else None


class Reader:
    """Reads values at the states of some quantities back as monomials."""

    def __init__(self, quantities: Quantities) -> None:
        spec = quantities.spec
        atom = lambda name: formula(re.sub(r"^(sin|cos) (.*)", r"\1(\2)", name))(quantities)  # noqa: E731
        plain = (name for name in spec.parameters if name != "r" or "h" not in spec.parameters)
        self.names = tuple(name for name in (*plain, *spec.moving) if name not in spec.values)
        self.atoms = np.array([atom(name) for name in self.names])
        logs = np.log(np.abs(self.atoms)).T
        self._inverse = np.linalg.pinv(np.column_stack([logs, np.ones(len(logs))]))
        extra = {name: atom(name) for name in spec.extra if name not in self.names}
        self.extra = {name: values for name, values in extra.items() if np.abs(values).min() > 0}

    def plain(self, values: Values) -> Monomial | None:
        """A monomial in parameters, rates, sines and cosines: a straight line through the logarithms gives the powers."""
        with np.errstate(all="ignore"):
            powers = self._inverse @ np.log(np.abs(values))
        whole = np.round(powers[:-1])
        close = np.isfinite(powers).all() and np.abs(powers[:-1] - whole).max(initial=0) < 1e-5
        if not close or np.abs(whole).max(initial=0) > MOST_POWER:
            return None
        factor = fraction_of(values / np.prod(self.atoms ** whole[:, None], axis=0))
        powers = tuple((name, int(power)) for name, power in zip(self.names, whole, strict=True) if power)
        return Monomial(factor, powers) if factor else None

    def read(self, values: Values, extras: dict[str, tuple[int, ...]]) -> Iterator[Monomial]:
        """Every monomial that fits: in plain atoms, or with one more quantity to one of the powers that it may have."""
        if not np.isfinite(values).all() or np.abs(values).min() == 0:
            return
        if found := self.plain(values):
            yield found
        for name in extras.keys() & self.extra.keys():
            for power in extras[name]:
                if found := self.plain(values / self.extra[name] ** power):
                    yield Monomial(found.factor, (*found.powers, (name, power)))


reader_of = cache(Reader)
