"""What each part of a wrong equation would have to be for the equation to hold, at every random state.

From the top down: a side has to equal the other side; a term what is left of its sum; a factor the quotient; a base the
root. One pass gives the needed value of every part, and what kind of change it takes is read off from that.
"""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Literal

import numpy as np

from pendpin.doctor.checking.evaluation import Context, Known, evaluate, norm
from pendpin.doctor.checking.residuals import Equation
from pendpin.doctor.reading.tree import Node, key
from pendpin.doctor.systems.base import Quantities, Values, dot
from pendpin.doctor.systems.rod import AXES

Role = Literal["side", "term", "entry", "factor", "divisor", "base", "argument"]


@dataclass(frozen=True, eq=False)
class Need:
    """A part of an equation, its value, the value that would heal, and where it stands.

    `flat` says that only the size is needed, under an even power. `needed` is None where no value is known.
    """

    node: Node
    value: Values
    needed: Values | None
    role: Role
    parents: tuple[Node, ...]
    index: int = 0
    flat: bool = False
    parts: tuple[Values, ...] = ()  # the values of a sum's terms
    lone: bool = False  # a symbol that is all of a side, such as what an equation is solved for

    @property
    def parent(self) -> Node | None:
        """What it is a part of."""
        return self.parents[-1] if self.parents else None

    @property
    def whole(self) -> bool:
        """Whether it is a sum's term, a side or an entry: what can be added to and has a sign of its own."""
        return self.role in ("side", "term", "entry")


def needs(equation: Equation, quantities: Quantities, known: Known) -> Iterator[Need]:
    """Every part of an equation with the value that would heal it."""
    context = equation.context(quantities)
    for i, side in enumerate(equation.sides):
        for target in _targets(equation, quantities, known, i):
            lone = side.kind in ("symbol", "number") and len(equation.sides) > 1
            value = known[id(side)]
            wanted = target if target.ndim == value.ndim else np.zeros_like(value) if not np.any(target) else None
            yield from _down(Need(side, value, wanted, "side", (), i, lone=lone), context, known)


def equal_parts(found: list[Need], *kinds: str) -> list[list[Need]]:
    """The parts of some kinds, those together that are printed alike."""
    groups: dict[tuple, dict[int, Need]] = defaultdict(dict)
    for need in found:
        if need.node.kind in kinds:
            groups[key(need.node)][id(need.node)] = need
    return [list(members.values()) for members in groups.values()]


def _targets(equation: Equation, quantities: Quantities, known: Known, i: int) -> Iterator[Values]:
    """What side i has to be: the others, where they agree; energies also with a constant."""
    others = [known[id(side)] for k, side in enumerate(equation.sides) if k != i] or [quantities.number(0)]
    first = others[0]
    if any(other.shape != first.shape or not _close(other, first) for other in others[1:]):
        return
    yield first
    if equation.floats and first.ndim == 1 and "m" in quantities:
        weight = quantities["m"] * quantities["g"]
        for length in (name for name in ("h", "l") if name in quantities):
            for sign in (1, -1):
                yield first + sign * weight * quantities[length]


def _close(a: Values, b: Values) -> bool:
    return bool(np.abs(a - b).max() <= 1e-9 * (np.abs(a).max() + np.abs(b).max() + 1e-300))


def _down(need: Need, context: Context, known: Known) -> Iterator[Need]:
    """A part and everything below it."""
    node = need.node
    yield replace(need, parts=tuple(known[id(child)] for child in node.children)) if node.kind == "sum" else need
    for index, (child, wanted, role, flat) in enumerate(_children(need, context, known)):
        lone = need.lone and node.kind == "matrix"
        below = Need(child, known[id(child)], wanted, role, (*need.parents, node), index, flat, lone=lone)
        yield from _down(below, context, known)


def _children(need: Need, context: Context, known: Known) -> Iterator[tuple[Node, Values | None, Role, bool]]:
    """The children of a node with what they would have to be."""
    node, wanted = need.node, need.needed
    with np.errstate(all="ignore"):
        match node.kind:
            case "sum":
                for sign, child in zip(node.value, node.children, strict=True):
                    value = known[id(child)]
                    fits = wanted is not None and wanted.ndim == value.ndim and not need.flat
                    yield child, value + sign * (wanted - need.value) if fits else None, "term", False
            case "product":
                for i, child in enumerate(node.children):
                    role: Role = "divisor" if node.value[i] == "/" else "factor"
                    yield child, None if wanted is None else _factor(node, i, wanted, known), role, need.flat
            case "power":
                base, flat = node.children[0], _even(node.value) or need.flat
                yield base, None if wanted is None else _root(wanted, node.value, known[id(base)]), "base", flat
            case "matrix":
                for i, child in enumerate(node.children):
                    yield child, _entry(node, i, wanted, context), "entry", False
            case "function":
                yield node.children[0], None, "argument", False
            case "derivative":
                evaluate(node.children[0], context, known)
                yield node.children[0], _integrated(need, known), "base", False


def _integrated(need: Need, known: Known) -> Values | None:
    """What is differentiated times a constant factor that is missing; None where the factor is not constant.

    The states of the second half share the parameters of the first.
    """
    if need.needed is None or need.value.ndim != 1:
        return None
    first, second = np.split(need.needed / need.value, 2)
    value = known[id(need.node.children[0])]
    return value * np.tile(first, 2) if value.ndim == 1 and _close(first, second) else None


def _even(exponent: Fraction) -> bool:
    return exponent.denominator == 1 and exponent.numerator % 2 == 0


def _root(wanted: Values, exponent: Fraction, base: Values) -> Values | None:
    """The base whose power is wanted."""
    if base.ndim != 1 or wanted.ndim != 1 or not exponent:
        return None
    size = np.abs(wanted) ** float(1 / exponent)
    if _even(exponent):
        return size if (wanted > 0).all() else None
    return np.sign(wanted) * size


def _factor(node: Node, i: int, wanted: Values, known: Known) -> Values | None:
    """What factor i of a product has to be."""
    child, rest = known[id(node.children[i])], None
    operators = node.value
    for k, other in enumerate(node.children):
        if k == i:
            continue
        value = known[id(other)]
        if value.ndim > 1:
            if rest is not None and rest.ndim > 1:
                return None
            rest = value if rest is None else rest * value
        else:
            part = 1 / value if operators[k] == "/" else value
            rest = part if rest is None else rest * part
    if rest is None:
        return wanted
    if operators[i] == "/":
        return rest / wanted if rest.ndim == wanted.ndim == 1 else None
    if child.ndim + rest.ndim - 1 != wanted.ndim or (child.ndim > 1 and rest.ndim > 1):
        return None
    if rest.ndim == 1:
        return wanted / rest
    if wanted.ndim != rest.ndim or rest.ndim != 2:
        return None
    along = dot(wanted, rest) / dot(rest, rest)
    off = norm(wanted - along * rest)
    return along if (off <= 1e-8 * (norm(wanted) + 1e-12)).all() else None


def _entry(node: Node, i: int, wanted: Values | None, context: Context) -> Values | None:
    """What an entry of a matrix has to be."""
    if wanted is None:
        return None
    if wanted.shape[0] == 2:
        return wanted[i] if wanted.ndim == 2 else wanted[divmod(i, 2)]
    if node.value == (3, 1) and wanted.ndim == 2 and AXES[context.frame][0] in context.quantities:
        return dot(wanted, context.quantities[AXES[context.frame][i]])
    if node.value == (3, 3) and wanted.ndim == 3:
        row, column = divmod(i, 3)
        if not context.tensors:
            return wanted[row, column]
        first, second = (context.quantities[AXES["B"][k]] for k in (row, column))
        return dot(first, np.stack([dot(part, second) for part in wanted]))
    return None
