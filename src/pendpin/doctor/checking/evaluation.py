"""An equation and its readings; its trees to numbers: scalars, vectors and tensors, for any type of number."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from itertools import islice, product
from typing import Any

import numpy as np

from pendpin.doctor.reading.names import CONSTANTS, Vocabulary
from pendpin.doctor.reading.tree import Mismatch, Node, Unread, Written, key, names_in, parts, walk
from pendpin.doctor.systems.base import LOADS, Quantities, Values, cross, dot, inverse
from pendpin.doctor.systems.rod import AXES, turned

LARGEST = 12  # rows and columns of a matrix
# each known up to a constant of its own: by how much it is moved to see its slope
ENERGIES = {"V": 1, "E": 2, "L": -3, "V1": 5, "V2": 7}
MOST_READINGS = 24
Known = dict[int, Values]  # the value of every node, by id
Instead = Mapping[int, Values]  # what nodes, by id, are changed to


@dataclass(frozen=True, eq=False)
class Equation:
    """Sides that are equal, what the text defines, and what is chosen where a name or a column can mean two things.

    `frame` is the frame that columns of components belong to; `meanings` replaces names that can mean two things.
    """

    sides: tuple[Node, ...]
    frame: str = "B"
    meanings: dict[str, str] = field(default_factory=dict)
    definitions: dict[str, Node] = field(default_factory=dict)
    tight: bool = False  # 3g/2l is read as 3g/(2l)
    still: tuple[Node, ...] = ()  # what a chain says to be 0 beside: the rate of its last side

    def __post_init__(self) -> None:
        """A statement that something is constant says that its rate is 0."""
        *others, last = self.sides
        if others and last.value in CONSTANTS - self.definitions.keys():
            still = Node("derivative", others[-1].span, "t", (others[-1],)), Node("number", last.span, Fraction(0))
            object.__setattr__(self, "sides", tuple(others) if others[1:] else still)
            object.__setattr__(self, "still", still if others[1:] else ())

    def meaning(self, name: str) -> str:
        """What a name stands for in this reading."""
        return self.meanings.get(name, name)

    @cached_property
    def names(self) -> set[str]:
        """The quantities in it, those inside definitions too."""
        return set(map(self.meaning, names_in(self.sides, self.definitions)))

    @cached_property
    def energies(self) -> list[Node]:
        """The energies in it but for those inside derivatives: a constant may be added to each."""

        def below(node: Node) -> list[Node]:
            if node.kind == "symbol":
                return [node] if self.meaning(node.value) in ENERGIES else []
            return [] if node.kind == "derivative" else [one for child in node.children for one in below(child)]

        return [node for side in self.sides for node in below(side)]

    @cached_property
    def tensors(self) -> bool:
        """Whether matrices of 3 x 3 numbers hold components of a tensor."""
        return bool({"inertia", "inertiaO"} & self.names)

    def context(self, quantities: Quantities) -> "Context":
        """Its meanings over some quantities."""
        return Context(self, quantities)

    def readings(self, words: Vocabulary, apart: bool = True) -> Iterator["Equation"]:
        """Itself with every other meaning of its names and columns, the likeliest first.

        At last, where letters may stand `apart`, with L as the Lagrangian where it stands alone or is differentiated, and a
        length elsewhere.
        """
        several, writings = dict[str, tuple[str, ...]](), dict[str, Written]()
        used = names_in(self.sides, self.definitions) & self.definitions.keys()
        for sides in (self.sides, [self.definitions[name] for name in sorted(used)]):
            for written in filter(None, (part.written for part in parts(sides))):
                found = words(written)
                own = sides is self.sides or found[:1] == ("L",)  # a definition may hold the length, too
                if len(found) > 1 and own and found[0] not in self.definitions:
                    several[found[0]], writings[found[0]] = found, written
        columns = any(p.kind == "matrix" and p.value == (3, 1) for p in parts(self.sides))
        choices = product(*several.values(), ("B", "I", "A") if columns else ("B",))
        for *chosen, frame in islice(choices, MOST_READINGS):
            yield replace(self, frame=frame, meanings=dict(zip(several, chosen, strict=True)))
        for name in sorted(name for name, found in several.items() if apart and "L" in found):
            for other in (other for other in several[name] if other not in ENERGIES):
                sides = tuple(_with_length(side, writings[name], other) for side in self.sides)
                if name in names_in(sides, {}) and [*map(key, sides)] != [*map(key, self.sides)]:
                    yield from replace(self, sides=sides).readings(words, apart=False)


def _with_length(node: Node, name: Written, value: str, inside: bool = False) -> Node:
    """An expression in which a letter is a length, but where it is a side, a term or what is differentiated."""
    if node.kind == "symbol":
        return replace(node, value=value) if inside and node.written == name else node
    inside = node.kind not in ("sum", "derivative")
    return replace(node, children=tuple(_with_length(child, name, value, inside) for child in node.children))


@dataclass(frozen=True, eq=False)
class Context:
    """An equation over some quantities. What a definition comes to is computed once, and None while that is done."""

    equation: Equation
    quantities: Quantities
    _defined: dict[str, Values | None] = field(default_factory=dict, init=False)

    def symbol(self, name: str, place: int) -> Values:
        """The value of a symbol. Raises Unread for one without a meaning."""
        name, definitions = self.equation.meaning(name), self.equation.definitions
        if name in definitions:
            if name not in self._defined:
                self._defined[name] = None
                self._defined[name] = evaluate(definitions[name], self)
            if (value := self._defined[name]) is None:
                raise Unread(f"{name.lstrip('?')} is defined by itself", place)
            return value
        if name == "pi":
            return self.quantities.number(1) * self.quantities.xp.pi
        if name in CONSTANTS and self.equation.energies:  # one may be added
            return self.quantities.number(0)
        if name not in self.quantities:
            known = f"the symbol {name.lstrip('?')} is not known: say what it is with --symbols, or in a definition"
            raise Unread(known, place)
        try:
            return self.quantities[name]
        except KeyError as missing:
            raise Unread(f"{missing.args[0]} has no meaning for {self.quantities.spec.title}", place) from None

    def means_constant(self, node: Node) -> bool:
        """Whether a symbol stands for what does not move."""
        name, definitions = self.equation.meaning(node.value), self.equation.definitions
        closed = name in definitions and self._defined.get(name, 0) is not None
        inside = definitions[name].names if closed else {name}
        return all(self.equation.meaning(part) in self.quantities.spec.still for part in inside)


def evaluate(node: Node, context: Context, known: Known | None = None, instead: Instead | None = None) -> Values:
    """The value of a tree; those of its parts go to `known`. `instead` gives nodes, by id, another value.

    Raises Unread where numbers and vectors are mixed.
    """
    if instead and id(node) in instead:
        return instead[id(node)]
    inside = () if node.kind == "derivative" else node.children
    value = _value(node, [evaluate(child, context, known, instead) for child in inside], context)
    if known is not None:
        known[id(node)] = value
    return value


def _value(node: Node, parts: list[Values], context: Context) -> Values:
    place, quantities = node.span[0], context.quantities
    match node.kind:
        case "number":
            top, bottom = quantities.number(node.value.numerator), node.value.denominator
            return top if bottom == 1 else top / quantities.number(bottom)
        case "symbol":
            return context.symbol(node.value, place)
        case "sum":
            shape = max((part.shape[:-1] for part in parts), key=len)
            total: Any = 0
            for sign, part, child in zip(node.value, parts, node.children, strict=True):
                if part.shape[:-1] != shape and not (child.kind == "number" and child.value == 0):
                    raise Mismatch("a number is added to a vector", child.span[0])
                total = total + part if sign > 0 else total - part
            return total
        case "product":
            return _product(node, parts)
        case "power":
            return _power(parts[0], node.value, place, quantities)
        case "function":
            return _function(node.value, parts[0], place, quantities)
        case "derivative":
            return _derivative(node, context)
        case _:
            return _matrix(node, parts, context)


def _derivative(node: Node, context: Context) -> Values:
    """A derivative in time or by a coordinate or rate. Raises Unread for one by anything else.

    That of H, the energy as a function of coordinates and momenta, is by a coordinate that of the Lagrangian reversed, and
    by a momentum the rate of its coordinate.
    """
    name, quantities, below = context.equation.meaning(node.value), context.quantities, node.children[0]
    spec = quantities.spec
    lettered = below.kind == "symbol" and below.written and below.written.letter == "H"
    if lettered and context.equation.meaning(below.value) == "E":
        if name in spec.coordinates:
            return -quantities.derivative(lambda q: q["L"], name)
        for coordinate in (one for one in spec.coordinates if spec.momentum(one) == name):
            return quantities[f"d{coordinate}"]
    if name in ("q", "dq") and "q" in spec.formulas:  # of a number by all coordinates, or all rates
        by = (replace(node, value=one) for one in (spec.coordinates if name == "q" else spec.rates))
        return np.stack([_derivative(one, context) for one in by])
    if name not in ("t", *spec.state, *LOADS):
        raise Unread(f"a derivative by {name.lstrip('?')} is not read", node.span[0])
    if all(context.means_constant(part) for part in walk(below) if part.kind in ("symbol", "derivative")):
        raise Unread("the derivative of a constant", node.span[0])
    try:
        value = quantities.derivative(lambda q: evaluate(below, replace(context, quantities=q)), name)
    except KeyError:
        raise Unread("the rate of an acceleration or reaction is not known", node.span[0]) from None
    lone = below.kind == "symbol" and name in spec.coordinates and quantities.xp is np and value.ndim == 1
    if lone and context.equation.meaning(below.value) not in {"T", *ENERGIES, *spec.unknowns} and not np.any(value):
        # as of W, a weight, where it is a function of action
        raise Unread("the derivative of a constant", node.span[0])
    return value


def _product(node: Node, parts: list[Values]) -> Values:
    """Factors from left to right, but a tensor and the vector behind it first, as in omega x I omega."""
    factors = list(zip(node.value, parts, node.children, strict=True))
    for i in range(len(factors) - 2, -1, -1):
        (operator, first, child), (joint, second, _) = factors[i : i + 2]
        if first.ndim == 3 and second.ndim == 2 and joint in "*.":
            factors[i : i + 2] = [(operator, _multiply(first, second, joint, child.span[0]), child)]
    value, crossed = factors[0][1], False
    for operator, part, child in factors[1:]:
        operator = "x" if crossed and operator == "*" and part.ndim == 2 else operator  # as in r x m v
        crossed = operator == "x" and part.ndim == 1
        value = _multiply(value, part, operator, child.span[0])
    return value


def _multiply(a: Values, b: Values, operator: str, place: int) -> Values:
    """A product of scalars, vectors and tensors, as far as it has a meaning. Raises Unread."""
    if operator == "/" and b.ndim != 1:
        raise Mismatch("a division by a vector", place)
    if 1 in (a.ndim, b.ndim):
        return a / b if operator == "/" else a * b
    if a.shape[-2] != b.shape[0]:
        raise Mismatch("a product of vectors of different lengths", place)
    if operator == "x" and a.shape[:-1] == b.shape[:-1] == (3,):
        return cross(a, b)
    if operator == "x" and a.shape[:-1] == b.shape[:-1] == (2,):  # about the axis of a plane
        return a[0] * b[1] - a[1] * b[0]
    if a.ndim == b.ndim == 2 and operator in "*.":
        return dot(a, b)
    if a.ndim == b.ndim == 2:
        raise Mismatch("a product of vectors that has no meaning", place)
    return np.einsum(f"{'ij'[3 - a.ndim :]}n,{'jk'[: b.ndim - 1]}n->{'i' * (a.ndim - 2)}{'k' * (b.ndim - 2)}n", a, b)


def _power(base: Values, exponent: Fraction, place: int, quantities: Quantities) -> Values:
    """A power; the square of a vector is that of its length. Raises Unread."""
    if base.ndim == 3 and exponent == -1:
        return inverse(base, quantities)
    if base.ndim > 1:
        if exponent != 2 or base.ndim != 2:
            raise Mismatch("a power of a vector", place)
        return dot(base, base)
    if exponent.denominator == 2:
        base, exponent = quantities.xp.sqrt(base), exponent * 2
    whole = int(exponent)
    value = base ** abs(whole) if whole else quantities.number(1)
    return quantities.number(1) / value if whole < 0 else value


def _function(name: str, x: Values, place: int, quantities: Quantities) -> Values:
    """A function of a number. Raises Unread for a vector."""
    if name == "transpose":
        return x.swapaxes(0, 1) if x.ndim == 3 else x
    if name == "det" and x.ndim == 3 and x.shape[:2] == (2, 2):
        return x[0, 0] * x[1, 1] - x[0, 1] * x[1, 0]
    if name == "norm" and x.ndim <= 2:
        x, name = (dot(x, x) if x.ndim == 2 else x * x), "sqrt"
    if x.ndim != 1:
        raise Mismatch(f"{name} of a vector", place)
    if name == "det":
        raise Mismatch("det of a number", place)
    xp = quantities.xp
    if name == "sign":
        return x / xp.sqrt(x * x)
    if name not in ("tan", "cot", "sec", "csc"):
        return getattr(xp, name)(x)
    sin, cos, one = xp.sin(x), xp.cos(x), quantities.number(1)
    top, bottom = {"tan": (sin, cos), "cot": (cos, sin), "sec": (one, cos), "csc": (one, sin)}[name]
    return top / bottom


def _matrix(node: Node, parts: list[Values], context: Context) -> Values:
    """A matrix of numbers, a column of three rows that are vectors, or a vector from its components in a frame."""
    quantities, (rows, columns), axes = context.quantities, node.value, AXES[context.equation.frame]
    entries = {part.ndim for part in parts}
    if node.value == (3, 1) and entries == {2} and not context.equation.tensors:
        return np.stack(parts)
    if entries != {1} or max(rows, columns) > LARGEST:
        raise Unread("a matrix of vectors" if entries != {1} else "a matrix of this size", node.span[0])
    if node.value == (3, 1) and axes[0] in quantities:  # a system in a plane has no frames: columns are lists
        components = zip(parts, axes, strict=True)
        return sum((part * quantities[axis] for part, axis in components), start=quantities.number(0))
    if 1 in (rows, columns):
        return np.stack(parts)
    matrix = np.stack(parts).reshape(rows, columns, -1)
    return turned(quantities, matrix) if node.value == (3, 3) and context.equation.tensors else matrix


def scale(node: Node, context: Context, known: Known) -> Values:
    """The size of the terms that make up a value (n,): sums are taken without their signs. Floats only."""
    match node.kind:
        case "sum" | "matrix":
            return sum((scale(child, context, known) for child in node.children), start=np.zeros(1))
        case "product":
            value: Any = 1.0
            for operator, child in zip(node.value, node.children, strict=True):
                value = value / norm(known[id(child)]) if operator == "/" else value * scale(child, context, known)
            return value
        case "power" if node.value > 0:
            return scale(node.children[0], context, known) ** float(node.value)
        case "derivative":  # its terms are of the size of those below it, where a rate is of the size of 1
            inside = Known()
            evaluate(node.children[0], context, inside)
            return norm(known[id(node)]) + scale(node.children[0], context, inside)
        case "symbol":  # a rate that vanishes, of a quantity that is conserved
            name, quantities = context.equation.meaning(node.value), context.quantities
            derived = name[:1] == "d" and name not in quantities.base and name[1:] in quantities.spec.formulas
            return norm(known[id(node)]) + (norm(quantities[name[1:]]) if derived else 0.0)
        case _:
            return norm(known[id(node)])


def norm(value: Values) -> Values:
    """The size of scalars, vectors and tensors, (n,)."""
    return np.sqrt((value * value).sum(tuple(range(value.ndim - 1)))) if value.ndim > 1 else np.abs(value)
