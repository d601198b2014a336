"""Changes whose size is found and not listed: numbers, factors and terms that are missing."""

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from pendpin.doctor.checking.residuals import Equation, changed
from pendpin.doctor.mending.edits import Edit, Editor, apply
from pendpin.doctor.mending.monomials import (
    Monomial,
    Reader,
    fraction_of,
    reader_of,
    simple,
)
from pendpin.doctor.mending.moves import number_cost
from pendpin.doctor.mending.needs import Need, equal_parts
from pendpin.doctor.reading.tree import divisors, symbols, walk
from pendpin.doctor.systems.base import Quantities, Spec, Values, dot

MOST_TERMS = 8  # of a sum whose neighbouring terms are tried together
INERTIAS = ("I1", "I2", "I3", "J1", "J2", "J3", "h")


def by_need(found: list[Need], quantities: Quantities, editor: Editor, names: set[str]) -> Iterator[Edit]:
    """Numbers to be replaced, factors and terms that are missing, as the needed values tell."""
    reader = reader_of(quantities)
    for need in found:
        if need.needed is None or not np.isfinite(need.needed).all():
            continue
        if need.node.kind == "number":
            yield from _number(need, found, editor)
        if need.flat:
            continue
        if need.whole:
            yield from _factors(need, reader, editor, names)
        if need.whole or need.node.kind == "sum" or (need.node.bracketed and need.node.kind != "number"):
            yield from _terms(need, reader, editor, names)
        if need.node.kind == "sum":
            yield from _factors_of_runs(need, reader, editor, names)


def possible(equation: Equation, spec: Spec) -> set[str]:
    """Quantities that a missing term or factor may hold: not what the equation is solved for."""
    lone = {side.value for side in equation.sides if side.kind == "symbol"}
    inertias = [name for name in INERTIAS if name in spec.common]
    families = (set(family) for family in spec.families if len(equation.names.intersection(family)) > 1)
    below = {f"1/{name}" for side in equation.sides for part in divisors(side) for name in symbols(part)}
    return equation.names.union({*spec.unknowns, *inertias, "Mc"}, below, *families) - lone


def _number(need: Need, found: list[Need], editor: Editor) -> Iterator[Edit]:
    """Another number in place of one."""
    assert need.needed is not None
    value = fraction_of(np.abs(need.needed) if need.flat else need.needed) if need.needed.ndim == 1 else None
    if not value or value == need.node.value:
        return
    edit = editor.number(need, abs(value), number_cost(need, abs(value)))
    if value > 0:
        yield edit
    elif owner := next((n for n in found if n.whole and n.node in need.parents and not n.flat), None):
        words = f"{edit.words}, and the sign of {editor.of(owner.node.outer)} is wrong"
        if abs(value) != need.node.value:
            yield Edit((*edit.splices, editor.sign(owner)), edit.cost + 1.0, words, edit.old, edit.new)


def _factors(need: Need, reader: Reader, editor: Editor, names: set[str]) -> Iterator[Edit]:
    """A factor that is missing: a fraction, a symbol, a sine."""
    ratio = _ratio(need)
    if ratio is None:
        return
    for monomial in reader.all(ratio):
        plain = not monomial.powers
        if monomial.factor < 0 or (plain and monomial.factor == 1) or odd_extra(monomial, reader, names, 2):
            continue
        if plain and monomial.factor.numerator == 1:
            below = editor.below(need.node, monomial.factor.denominator)
            if below is not None:
                yield editor.replaced(need, below, 1.2 + simple(monomial.factor))
        cost = 1.22 + 0.01 * len(need.parents) + simple(monomial.factor) + 0.5 * need.lone
        cost += 0.0 if plain else 0.3 * (monomial.size - 1) + 0.4 * (monomial.factor != 1)
        yield editor.missing(need, monomial, cost)


def _factors_of_runs(need: Need, reader: Reader, editor: Editor, names: set[str]) -> Iterator[Edit]:
    """A factor that is missing before several neighbouring terms, which then stand in brackets."""
    node, signs = need.node, need.node.value
    if need.needed is None or need.needed.shape != need.value.shape or len(signs) > MOST_TERMS:
        return
    for first in range(len(signs) - 1):
        for last in range(first + 1, len(signs)):
            if last - first + 1 == len(signs) and need.node.bracketed is None and need.role != "side":
                continue
            run = sum((signs[i] * need.parts[i] for i in range(first, last + 1)), start=0 * need.value)
            part = Need(node, run, run + need.needed - need.value, "term", need.parents)
            ratio = _ratio(part)
            for monomial in reader.all(ratio) if ratio is not None else ():
                if monomial.factor <= 0 or not monomial.powers or odd_extra(monomial, reader, names, 2):
                    continue
                yield _before_run(need, first, last, monomial, editor)


def _before_run(need: Need, first: int, last: int, monomial: Monomial, editor: Editor) -> Edit:
    """The edit that puts a factor and brackets around some terms of a sum."""
    node, text = need.node, editor.bracketed(editor.printer.monomial(monomial))
    start, end = node.children[first].outer[0], node.children[last].outer[1]
    mark = node.marks[first]
    minus = node.value[first] < 0
    opened = f"{text}{'' if editor.printer.latex else '*'}({'-' if minus else ''}"
    opening = (mark[0], start, ("+ " if first else "") + opened)
    old = editor.text[mark[0] : end].strip()
    cost = 1.3 + unused(monomial, editor) + simple(monomial.factor)
    cost += 0.3 * (monomial.size - 1) + 0.3 * (monomial.factor != 1)
    words = f"the factor {text} is missing in {old}"
    return Edit((opening, (end, end, ")")), cost, words, old, f"{opened}{editor.text[start:end].strip()})")


def _ratio(need: Need) -> Values | None:
    """Needed over present, (n,); None where it is not a number."""
    value, needed = need.value, need.needed
    if needed is None or value.ndim != needed.ndim or value.ndim > 2:
        return None
    with np.errstate(all="ignore"):
        if value.ndim == 1:
            return needed / value
        ratio = dot(needed, value) / dot(value, value)
        return ratio if np.abs(needed - ratio * value).max() <= 1e-8 * np.abs(needed).max() else None


def _terms(need: Need, reader: Reader, editor: Editor, names: set[str]) -> Iterator[Edit]:
    """A term that is missing after a sum, side or entry."""
    assert need.needed is not None
    inside = need.parent is not None and need.parent.kind == "sum"
    if need.needed.ndim != need.value.ndim or (inside and need.node.kind != "sum"):
        return
    missing = need.needed - need.value
    for monomial, direction in _read(missing, reader):
        if odd_extra(monomial, reader, names, 6):
            continue
        vector = editor.printer.symbol(direction) if direction else ""
        text = editor.printer.monomial(monomial, vector)
        splice = editor.added(need.node, 1 if monomial.factor > 0 else -1, text)
        cost = 1.55 + unused(monomial, editor) + simple(monomial.factor) + 0.05 * monomial.size
        cost += 0.5 * steep(monomial, names, reader.quantities.spec) + 0.5 * need.lone
        sign = "+" if monomial.factor > 0 else "-"
        yield Edit((splice,), cost, f"the term {sign} {text} is missing", "", f"{sign} {text}")


def odd_extra(monomial: Monomial, reader: Reader, names: set[str], most: int) -> bool:
    """Whether a monomial holds a quantity that would stand there in an unlikely way.

    That is one of another kind than the equation's, one below a fraction, or one with many others.
    """
    extra = [(name, power) for name, power in monomial.powers if name in reader.extra]
    if not extra:
        return False
    name, power = extra[0]
    spec = reader.quantities.spec
    sums = {part for term in spec.sums.get(name, ()) for part in term} & set(spec.unknowns)
    parts = sums if name in spec.sums else set(name.split(" - "))
    if power < 0:
        return f"1/{name}" not in names or monomial.size > most
    falls = any(p < 0 and n in spec.moving for n, p in monomial.powers) and name != "M3"
    return falls or monomial.size > most or not parts <= names


def steep(monomial: Monomial, names: set[str], spec: Spec) -> int:
    """How many angles and rates a monomial is divided by that the equation is not."""
    below = [name.rpartition(" ")[2] for name, power in monomial.powers if power < 0 and name in spec.moving]
    return sum(f"1/{name}" not in names for name in below)


def unused(monomial: Monomial, editor: Editor) -> float:
    """What names cost that the text does not use."""
    words = " ".join(name.replace("- ", "") for name, _ in monomial.powers if name not in editor.printer.spec.sums)
    return 0.03 * len(set(words.split()) - {"sin", "cos"} - editor.printer.styles.keys())


def _read(values: Values, reader: Reader) -> Iterator[tuple[Monomial, str]]:
    """Scalars or vectors as monomials, with the direction of a vector."""
    if values.ndim == 1:
        yield from ((monomial, "") for monomial in reader.all(values))
    elif values.shape[:-1] == (3,):
        for name in reader.quantities.spec.directions:
            unit = reader.quantities[name]
            along = dot(values, unit)
            if np.abs(values - along * unit).max() <= 1e-8 * np.abs(values).max():
                yield from ((monomial, name) for monomial in reader.all(along))


def equal_products(found: list[Need], equation: Equation, quantities: Quantities, editor: Editor) -> list[Edit]:
    """A number that is wrong in the same way wherever it or an equal product stands, such as m l²/3 printed twice."""
    edits = []
    for members in (group for group in equal_parts(found, "product", "number") if len(group) > 1):
        if any(part.kind == "sum" for part in walk(members[0].node)):
            continue
        factor = _common_factor(members, equation, quantities)
        if factor is not None and factor > 0:
            edits += list(_rescaled(members, factor, editor))
    return edits


def _common_factor(members: list[Need], equation: Equation, quantities: Quantities) -> Fraction | None:
    """The factor on all members that heals, where the residual is straight in it."""
    rows = []
    for k in (1.0, 2.0, 3.0):
        after = changed(equation, quantities, {id(n.node): k * n.value for n in members})
        if after is None:
            return None
        rows.append(after.ravel())
    slope = rows[1] - rows[0]
    if np.abs(rows[2] - rows[1] - slope).max() > 1e-9 * np.abs(rows[2]).max() or not np.abs(slope).min() > 0:
        return None
    return fraction_of(1 - rows[0] / slope)


def _rescaled(members: list[Need], factor: Fraction, editor: Editor) -> Iterator[Edit]:
    """Each number of the products replaced, so that the product is multiplied by a factor."""
    first = members[0].node
    below = {id(p) for divisor in divisors(first) for p in walk(divisor)}
    raised = {id(p) for n in walk(first) if n.kind in ("power", "function") for p in walk(n)}
    for alike in zip(*(walk(member.node) for member in members), strict=True):
        number = alike[0]
        if number.kind != "number" or id(number) in raised:
            continue
        value = number.value / factor if id(number) in below else number.value * factor
        text = editor.printer.number(value)
        splices = tuple(editor.put(part.span, text) for part in alike)
        start, end = first.outer
        old = editor.of(first.outer)
        new = apply(editor.text[start:end], ((splices[0][0] - start, splices[0][1] - start, splices[0][2]),)).strip()
        cost = 1.1 + simple(value) + (0.1 if value.denominator > 1 else 0.0)
        where = "in both places" if len(members) == 2 else f"in all {len(members)} places"
        yield Edit(splices, cost, f"{old} should be {new}, {where}", old, new)
