"""An equation and its residuals at random states of the true motion."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from itertools import pairwise, product

import numpy as np

from pendpin.doctor.checking.evaluation import Context, Instead, Known, evaluate, norm, scale
from pendpin.doctor.reading.names import CONSTANTS, Vocabulary
from pendpin.doctor.reading.tree import Mismatch, Node, Unread, parts, symbols
from pendpin.doctor.systems.base import Quantities, Values

TOLERANCE = 1e-9  # relative to the terms, in floats
# each known up to a constant of its own: by how much it is moved to see its slope
ENERGIES = {"V": 1, "E": 2, "L": -3, "V1": 5, "V2": 7}
MOST_READINGS = 24


@dataclass(frozen=True, eq=False)
class Equation:
    """Sides that are equal, with what is chosen where a name or a column can mean two things."""

    sides: tuple[Node, ...]
    frame: str = "B"
    meanings: dict[str, str] = field(default_factory=dict)
    definitions: dict[str, Node] = field(default_factory=dict)
    tight: bool = False  # 3g/2l is read as 3g/(2l)

    def __post_init__(self) -> None:
        """A statement that something is constant says that its rate is 0."""
        *others, last = self.sides
        if others and last.value in CONSTANTS - self.definitions.keys():
            rates = [Node("derivative", side.span, "t", (side,)) for side in others]
            object.__setattr__(self, "sides", (*rates, Node("number", last.span, Fraction(0))))

    def meaning(self, name: str) -> str:
        """What a name stands for in this reading."""
        return self.meanings.get(name, name)

    @cached_property
    def names(self) -> set[str]:
        """The quantities in it, those inside definitions too."""
        found = set().union(*(symbols(side) for side in self.sides))
        fresh = found & self.definitions.keys()
        while fresh:
            below = set().union(*(symbols(self.definitions[name]) for name in fresh)) - found
            found |= below
            fresh = below & self.definitions.keys()
        return {self.meanings.get(name, name) for name in found}

    @cached_property
    def floats(self) -> bool:
        """Whether a constant may be added: an energy stands in it, and not only its derivatives."""
        names = {part.value for side in self.sides for part in _undifferentiated(side)}
        return bool({self.meanings.get(name, name) for name in names} & ENERGIES.keys())

    def context(self, quantities: Quantities) -> Context:
        """The equation's own meanings over some quantities."""
        return Context(
            quantities,
            self.definitions,
            self.frame,
            self.meanings,
            bool({"inertia", "inertiaO"} & self.names),
            self.floats,
        )

    def readings(self, words: Vocabulary) -> Iterator["Equation"]:
        """Itself with every other meaning of its names and columns, the likeliest first."""
        several: dict[str, tuple[str, ...]] = {}
        for part in (p for p in parts(self.sides) if p.written is not None):
            assert part.written is not None
            if len(found := words(part.written)) > 1 and found[0] not in self.definitions:
                several[found[0]] = found
        columns = any(p.kind == "matrix" and p.value == (3, 1) for p in parts(self.sides))
        choices = product(*several.values(), ("B", "I", "A") if columns else ("B",))
        for _, choice in zip(range(MOST_READINGS), choices, strict=False):
            chosen = dict(zip(several, choice, strict=False))
            yield replace(self, frame=choice[-1], meanings=chosen)


def _undifferentiated(node: Node) -> Iterator[Node]:
    """The symbols in an expression but for those inside derivatives."""
    if node.kind == "symbol":
        yield node
    elif node.kind != "derivative":
        for child in node.children:
            yield from _undifferentiated(child)


def residuals(
    equation: Equation, quantities: Quantities, known: Known | None = None, instead: Instead | None = None
) -> Iterator[tuple[Values, Values]]:
    """Of each pair of neighbouring sides: left minus right, rows of scalars (k, n), and the size of the terms (n,).

    `instead` gives parts another value; the sizes are then 0. Raises Unread where a vector is set equal to a number.
    """
    if equation.names & {"q_i", "dq_i"}:
        for angle in ("theta", "phi"):
            meant = {"q_i": angle, "dq_i": f"d{angle}"}
            yield from residuals(replace(equation, meanings=equation.meanings | meant), quantities, known, instead)
        return
    sized = quantities.xp is np and instead is None
    known = {} if known is None else known
    context = equation.context(quantities)
    values = [evaluate(side, context, known, instead) for side in equation.sides]
    if len(values) == 1:
        values.append(quantities.number(0))
    for i, (left, right) in enumerate(pairwise(values)):
        if left.shape[:-1] != right.shape[:-1]:  # 0 fits any shape
            if left.ndim == right.ndim:
                raise Mismatch("vectors of different lengths are set equal", equation.sides[i].span[0])
            small = i if left.ndim < right.ndim else i + 1
            node = equation.sides[small] if small < len(equation.sides) else None
            if node is not None and not (node.kind == "number" and node.value == 0):
                raise Mismatch("a vector is set equal to a number", node.span[0])
            left, right = (np.zeros_like(right), right) if small == i else (left, np.zeros_like(left))
        size: Values = np.zeros(1)
        if sized:
            size = norm(left) + sum((scale(side, context, known) for side in equation.sides[i : i + 2]), start=size)
        yield (left - right).reshape(-1, left.shape[-1]), size


def residuals_and_sizes(
    equation: Equation, quantities: Quantities, known: Known | None = None, instead: Instead | None = None
) -> Iterator[tuple[Values, Values]]:
    """The residuals, less what a constant in the energies may account for.

    That constant is the residual over its slope in the energies. It may depend on the parameters, which the second half of
    the states shares with the first: what is left is the difference between the halves, times the slope.
    """
    plain = residuals(equation, quantities, known, instead)
    if not equation.floats:
        yield from plain
        return
    half = quantities.shape[-1] // 2
    for (rows, size), slope in zip(plain, slopes(equation, quantities, instead), strict=True):
        if not np.any(slope):
            yield rows, size
        else:
            with np.errstate(all="ignore"):
                constant = rows / slope
            yield (constant[:, :half] - constant[:, half : 2 * half]) * slope[:, :half], size


def stack_residuals(
    equation: Equation, quantities: Quantities, known: Known | None = None, instead: Instead | None = None
) -> Values:
    """The residuals as one array (k, n); where a constant in the energies halves some rows, all have the first half."""
    rows = [rows for rows, _ in residuals_and_sizes(equation, quantities, known, instead)]
    states = min(part.shape[1] for part in rows)
    return np.concatenate([part[:, :states] for part in rows])


def slopes(equation: Equation, quantities: Quantities, instead: Instead | None) -> list[Values]:
    """How the residuals change as the zero of potential energy is moved by one unit, rows (k, n)."""
    moved = dict(instead or {})
    for node in (part for side in equation.sides for part in _undifferentiated(side)):
        name = equation.meanings.get(node.value, node.value)
        if name in ENERGIES and id(node) not in moved:
            moved[id(node)] = quantities[name] + quantities.number(ENERGIES[name])
    both = (residuals(equation, quantities, None, values) for values in (moved, instead or {}))
    return [there - here for (there, _), (here, _) in zip(*both, strict=True)]


def changed(equation: Equation, quantities: Quantities, instead: Instead) -> Values | None:
    """The residual with other values for some parts, rows (k, n); None where they have no meaning there."""
    try:
        with np.errstate(all="ignore"):
            return stack_residuals(equation, quantities, None, instead)
    except Unread:
        return None


def relative_error(equation: Equation, quantities: Quantities, full: Quantities | None = None) -> float:
    """The residual over the terms, root mean square over random states. Raises Unread, also for infinite values.

    `full` gives other states whose terms the residual is compared with: where nothing turns, terms may be rounding alone.
    """
    with np.errstate(all="ignore"):
        here = list(residuals_and_sizes(equation, quantities))
        there = here if full is None else residuals_and_sizes(equation, full)
        tops = np.array([np.sqrt(np.mean(np.sum(rows**2, 0))) for rows, _ in here])
        bottoms = np.array([np.sqrt(np.mean(size**2)) for _, size in there])
    if not (np.isfinite(tops).all() and np.isfinite(bottoms).all()):
        raise Unread("it divides by 0, takes the root of a negative number or grows beyond bounds")
    return float((tops / np.where(bottoms, bottoms, 1.0)).max())
