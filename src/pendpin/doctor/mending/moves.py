"""Every small change of a printed equation that can be listed: a sign, a function, a symbol, a power, a term left out.

Each move says what value it gives to which part, so that all are tried on numbers before any is written.
"""

from collections.abc import Iterator
from fractions import Fraction
from functools import partial
from itertools import combinations

import numpy as np

from pendpin.doctor.checking.dimensions import Disagreement, dimension
from pendpin.doctor.checking.evaluation import Context, evaluate, function, power
from pendpin.doctor.mending.edits import Edit, Editor
from pendpin.doctor.mending.monomials import Monomial, atom, simple
from pendpin.doctor.mending.needs import Need, equal_parts
from pendpin.doctor.reading.tree import Node, Span, Unread
from pendpin.doctor.systems.base import Quantities, Values

FUNCTIONS = {"sin": 1.0, "cos": 1.0, "tan": 1.1, "cot": 1.2}  # and the cost of writing one for another
CIRCULAR = {"sin", "cos", "tan", "cot", "sec", "csc"}
_FACTORS = "2 1/2 3 1/3 4 1/4 3/2 2/3 6 1/6 12 1/12"
FACTORS = [Fraction(factor) for factor in _FACTORS.split()]


def moves(found: list[Need], context: Context, editor: Editor) -> Iterator[Edit]:
    """All moves of one part, then those of all equal parts at once."""
    seen: set[int] = set()
    for need in found:
        if id(need.node) not in seen:
            seen.add(id(need.node))
            yield from _of_part(need, context, editor)
    yield from _of_equal_parts(found, context, editor)


def _of_part(need: Need, context: Context, editor: Editor) -> Iterator[Edit]:
    node, alone = need.node, 0.5 * need.lone
    if need.whole and node.kind != "number":
        old, new = _term(need, editor)
        words = f"the sign of {editor.of(node.outer)} is wrong"
        first = 0.01 * (need.role == "term" and not need.index)  # a sum seldom begins with a minus
        yield Edit((editor.sign(need),), 1.0 + alone + first, words, old, new, {id(node): np.negative})
        yield from _forgotten(need, context, editor)
    if need.role == "side" and not need.lone:
        yield editor.replaced(need, (*node.outer, "0"), 1.35, 0 * need.value)
    if need.role == "term" and len(need.parents[-1].children) > 1:
        yield editor.removed(need, "term", 1.25, 0 * need.value)
    if need.role in ("factor", "divisor") and need.value.ndim == 1:
        yield editor.removed(need, "factor", 1.2, np.ones_like(need.value))
    for value, text, cost in replacements(node, context, editor):
        yield editor.replaced(need, editor.put(own_span(node), text), cost + alone, value)
    if node.kind == "number" and node.value:
        yield from _numbers(need, editor)
    yield from _powers(need, context, editor)
    yield from _multiples(need, editor)
    if node.kind == "derivative" and node.value != "t":
        for other in context.quantities.spec.state:
            yield editor.replaced(need, editor.put(node.marks[0], editor.printer.symbol(other)), 1.1)


def own_span(node: Node) -> Span:
    """Where the name of a symbol or function stands."""
    return node.span if node.kind == "symbol" else node.marks[0]


def _term(need: Need, editor: Editor) -> tuple[str, str]:
    """A term before and after its sign is changed."""
    text = editor.of(need.node.outer)
    if need.role != "term":
        return text, text[1:].lstrip() if text[:1] == "-" else f"-{text}"
    minus = need.parents[-1].value[need.index] < 0
    return ("-" + text, "+" + text) if minus else ("+" + text, "-" + text)


def _forgotten(need: Need, context: Context, editor: Editor) -> Iterator[Edit]:
    """One of the factors that are forgotten most."""
    spec = context.quantities.spec
    listed = [(factor, "", 1) for factor in FACTORS] + [(Fraction(1), name, 1) for name in sorted(spec.still)]
    listed += [(Fraction(1), name, 1) for name in spec.moving if " " in name]
    listed += [(Fraction(1), name, -1) for name in (*sorted(spec.still), *spec.moving) if not name.startswith("sin")]
    for factor, name, exponent in listed:
        usable = name in editor.printer.styles and name in context.quantities
        if usable or " " in name or not name:
            with np.errstate(all="ignore"):
                values = float(factor) * (atom(name, context.quantities) ** exponent if name else np.ones(1))
            if not (np.isfinite(values).all() and np.any(values)):
                continue
            monomial = Monomial(factor, ((name, exponent),) if name else ())
            yield editor.missing(need, monomial, 1.25 + simple(factor), partial(np.multiply, values))


def replacements(node: Node, context: Context, editor: Editor) -> Iterator[tuple[Values, str, float]]:
    """Other symbols for a symbol, other functions for a function: value, text and cost."""
    quantities = context.quantities
    if node.kind == "symbol":
        name = context.meaning(node.value)
        for other in own_names(name, context):
            yield context.symbol(other, 0), other.lstrip("?"), 1.05
        for other in filter(lambda other: _in_use(other, context, editor), alternatives(name, quantities)):
            of = quantities.spec.dimensions
            cost = 1.05 if of.get(other) == of.get(name) else 1.3
            used = other in editor.printer.styles or not editor.printer.styles
            yield quantities[other], editor.printer.symbol(other), cost if used else cost + 0.1
    if node.kind == "function" and node.value in CIRCULAR:
        inner = evaluate(node.children[0], context)
        slash = "\\" if editor.of(node.marks[0]).startswith("\\") else ""
        for other, cost in FUNCTIONS.items():
            if other != node.value:
                yield function(other, inner, 0, context), slash + other, cost


def own_names(name: str, context: Context) -> Iterator[str]:
    """Symbols that the text or the user defined, in place of another of the same dimension."""
    own = context.definitions
    for other in own:
        if other != name and other.startswith("?"):
            try:
                spec = context.quantities.spec
                same = dimension(own[other], own, spec) == dimension(Node("symbol", (0, 0), name), own, spec)
                fits = same and context.symbol(other, 0).ndim == 1
            except (Unread, Disagreement):
                continue
            if fits:
                yield other


def alternatives(name: str, quantities: Quantities) -> list[str]:
    """Names that could stand in place of one: of its family first, and the common ones."""
    spec = quantities.spec
    family = [other for names in spec.families if name in names for other in names]
    if name in spec.vectors | spec.matrices:
        return [other for other in dict.fromkeys(family) if other != name]
    others = [other for other in dict.fromkeys([*family, *spec.common]) if other != name and other in quantities]
    return [other for other in others if other not in spec.vectors and np.any(quantities[other])]


def _in_use(name: str, context: Context, editor: Editor) -> bool:
    """Whether a name is a parameter of the system, or one that the text uses."""
    spec = context.quantities.spec
    known = name not in spec.still or name in (*spec.parameters, *spec.common)
    return (known and name not in spec.values) or name in editor.printer.styles


def _powers(need: Need, context: Context, editor: Editor) -> Iterator[Edit]:
    """Another exponent, or one where there is none."""
    node = need.node
    if node.kind == "power":
        base = evaluate(node.children[0], context)
        for exponent in (1, 2, 3, 4):
            if base.ndim == 1 and exponent != node.value:
                value = power(base, Fraction(exponent), 0, context)
                yield editor.replaced(need, editor.exponent(node, exponent), 1.1, value)
    plain = node.kind in ("symbol", "function") and (need.parent is None or need.parent.kind != "power")
    if plain and (need.role != "argument" or node.bracketed) and need.value.ndim == 1 and not need.lone:
        for exponent in (2, 3):
            yield editor.replaced(need, editor.exponent(node, exponent), 1.15, need.value**exponent)


def _multiples(need: Need, editor: Editor) -> Iterator[Edit]:
    """The argument of a function, in brackets, doubled or halved."""
    inside = need.role == "argument" and need.node.bracketed and need.parents[-1].value in CIRCULAR
    if inside and need.value.ndim == 1:
        for factor in (Fraction(2), Fraction(1, 2)):
            text = editor.bracketed(editor.printer.number(factor))
            yield editor.replaced(need, editor.before(need.node.span[0], text), 1.2, need.value * float(factor))


def _numbers(need: Need, editor: Editor) -> Iterator[Edit]:
    """A usual multiple of a number."""
    for factor in FACTORS:
        value = need.node.value * factor
        if value.denominator == 1 or need.node.value == 1:
            yield editor.number(need, value, 0.05 + number_cost(need, value), need.value * float(factor))


def number_cost(need: Need, value: Fraction) -> float:
    """What another number costs: more for a fraction inside a printed one."""
    printed = any(parent.fraction for parent in need.parents[-2:])
    return 1.0 + simple(value) + 0.5 * need.lone + (0.0 if value.denominator == 1 else 0.6 if printed else 0.1)


def _of_equal_parts(found: list[Need], context: Context, editor: Editor) -> Iterator[Edit]:
    """The same replacement wherever a symbol or function stands, and two symbols exchanged."""
    several = equal_parts(found, "symbol", "function", "number")
    for members in several:
        if len(members) > 1:
            yield from _together(members, context, editor)
    for kind, least, cost in (("symbol", 2, 1.6), ("number", 2, 1.3)):
        names = [members for members in several if members[0].node.kind == kind]
        for first, second in combinations(names, 2):
            if len(first) + len(second) >= least and first[0].value.shape == second[0].value.shape:
                yield _exchanged(first, second, editor, cost)


def _together(members: list[Need], context: Context, editor: Editor) -> Iterator[Edit]:
    for value, text, cost in replacements(members[0].node, context, editor):
        splices = tuple(editor.put(own_span(n.node), text) for n in members)
        old, new = editor.shown(members[0], splices[:1])
        words = f"{old} should be {new}, wherever it stands"
        yield Edit(splices, cost + 0.35, words, old, new, {id(n.node): value for n in members})


def _exchanged(first: list[Need], second: list[Need], editor: Editor, cost: float) -> Edit:
    a, b = editor.of(first[0].node.span), editor.of(second[0].node.span)
    splices = [editor.put(n.node.span, b) for n in first] + [editor.put(n.node.span, a) for n in second]
    instead = {id(n.node): second[0].value for n in first} | {id(n.node): first[0].value for n in second}
    return Edit(tuple(splices), cost, f"{a} and {b} are exchanged", a, b, instead)
