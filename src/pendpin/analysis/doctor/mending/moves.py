"""Every small change of a printed equation that can be listed: a sign, a function, a symbol, a power, a term left out.

Each move says what value it gives to which part, so that all are tried on numbers before any is written.
"""

import re
from collections import defaultdict
from collections.abc import Iterator
from fractions import Fraction
from functools import partial
from itertools import combinations

import numpy as np

from pendpin.analysis.doctor.checking.dimensions import Disagreement, dimension
from pendpin.analysis.doctor.checking.evaluation import Context, evaluate, power
from pendpin.analysis.doctor.checking.mechanics import COORDINATES, PARAMETERS, Quantities, Values
from pendpin.analysis.doctor.mending.edits import Edit, Editor
from pendpin.analysis.doctor.mending.monomials import Monomial, atom, simple
from pendpin.analysis.doctor.mending.needs import Need
from pendpin.analysis.doctor.reading.names import DIMENSION_OF, MATRICES, SHORT_FUNCTIONS, UNIT_VECTORS, VECTORS
from pendpin.analysis.doctor.reading.tree import Node, Unread, key

COMMON = ("theta", "phi", "dtheta", "dphi", "ddtheta", "ddphi", "m", "l", "g", "R1", "R2", "R3", "M3", "Mc", "Fg")
ANY = ("h", "I1", "I2", "I3", "J1", "J2", "J3")
RODS = {"thin": (), "uniform": ("r", "I1", "I2", "I3"), "symmetric": ANY, "general": ANY}
_FAMILIES = """x y z; vx vy vz; ax ay az; w1 w2 w3; wd1 wd2 wd3; ac1 ac2 ac3; vc1 vc2 vc3; I1 I2 I3 J1 J2 J3; T V L E
wx wy wz; xT yT zT; M1 M2 M3 Mc; rG vG aG rT; omega alpha; h l r; R M"""
FAMILIES = [tuple(names.split()) for names in re.split(r"[;\n]", _FAMILIES)]
FAMILIES += [tuple(sorted(UNIT_VECTORS)), tuple(sorted(MATRICES)), SHORT_FUNCTIONS]
FUNCTIONS = ("sin", "cos", "tan", "cot")
CIRCULAR = {"sin", "cos", "tan", "cot", "sec", "csc"}
_FACTORS = "2 1/2 3 1/3 4 1/4 3/2 2/3 6 1/6 12 1/12"
FACTORS = [Fraction(factor) for factor in _FACTORS.split()]
FORGOTTEN = [(factor, "", 1) for factor in FACTORS] + [(Fraction(1), name, 1) for name in ("m", "l", "g")]
FORGOTTEN += [(Fraction(1), f"{f} {angle}", 1) for f in ("sin", "cos") for angle in ("theta", "phi")]
FORGOTTEN += [(Fraction(1), name, -1) for name in ("m", "l", "cos phi")]


def moves(found: list[Need], context: Context, editor: Editor) -> Iterator[Edit]:
    """All moves of one part, then those of all equal parts at once."""
    seen: set[int] = set()
    for need in found:
        if id(need.node) not in seen:
            seen.add(id(need.node))
            yield from _of_part(need, context, editor)
    yield from _of_equal_parts(found, context, editor)


def _of_part(need: Need, context: Context, editor: Editor) -> Iterator[Edit]:
    node = need.node
    if need.whole and need.value.ndim and node.kind != "number":
        splices = (editor.sign(need),)
        old, new = _term(need, editor)
        yield Edit(
            splices,
            1.0 + 0.5 * need.lone,
            f"the sign of {_plain(need, editor)} is wrong",
            old,
            new,
            {id(node): np.negative},
        )
    if need.role == "side" and not need.lone:
        words = f"{editor.of(node.outer)} should be 0"
        yield Edit(((*node.outer, "0"),), 1.35, words, editor.of(node.outer), "0", {id(node): 0 * need.value})
    if need.role == "term" and len(need.parents[-1].children) > 1:
        words = f"the term {editor.of(node.outer)} is too many"
        yield Edit((editor.without_term(need),), 1.25, words, editor.of(node.outer), "", {id(node): 0 * need.value})
    if need.role in ("factor", "divisor") and need.value.ndim == 1:
        one = {id(node): np.ones_like(need.value)}
        yield Edit(
            (editor.without_factor(need),),
            1.2,
            f"the factor {editor.of(node.outer)} is too many",
            editor.of(node.outer),
            "",
            one,
        )
    if need.whole and node.kind != "number":
        yield from _missing(need, context, editor)
    for value, text, cost in replacements(node, context, editor):
        splice = editor.put(node.span if node.kind == "symbol" else node.marks[0], text)
        old, new = editor.shown(need, (splice,))
        yield Edit((splice,), cost + 0.5 * need.lone, f"{old} should be {new}", old, new, {id(node): value})
    yield from _powers(need, context, editor)
    yield from _multiples(need, context, editor)
    yield from _numbers(need, editor)
    if node.kind == "derivative" and node.value != "t":
        for other in COORDINATES:
            splice = editor.put(node.marks[0], editor.printer.symbol(other))
            old, new = editor.shown(need, (splice,))
            yield Edit((splice,), 1.1, f"{old} should be {new}", old, new)


def _missing(need: Need, context: Context, editor: Editor) -> Iterator[Edit]:
    """One of the factors that are forgotten most."""
    for factor, name, exponent in FORGOTTEN:
        if name in editor.printer.styles or " " in name or not name:
            values = atom(name, context.quantities) ** exponent if name else np.ones(1)
            text = editor.printer.monomial(Monomial(factor, ((name, exponent),) if name else ()))
            splice = editor.before(need.node, text if editor.printer.latex or "/" not in text else f"({text})")
            old, new = editor.shown(need, (splice,))
            words = f"the factor {text} is missing in {old}"
            change = {id(need.node): partial(np.multiply, float(factor) * values)}
            yield Edit((splice,), 1.25 + simple(factor), words, old, new, change)


def _term(need: Need, editor: Editor) -> tuple[str, str]:
    """A term before and after its sign is changed."""
    text = editor.of(need.node.outer)
    if need.role != "term":
        return text, f"-{text}"
    signs = need.parents[-1].value
    return ("-" + text, "+" + text) if signs[need.index] < 0 else ("+" + text, "-" + text)


def _plain(need: Need, editor: Editor) -> str:
    return editor.of(need.node.outer)


def replacements(node: Node, context: Context, editor: Editor) -> Iterator[tuple[Values, str, float]]:
    """Other symbols for a symbol, other functions for a function: value, text and cost."""
    quantities = context.quantities
    if node.kind == "symbol":
        name = context.meaning(node.value)
        for other in own_names(name, context):
            yield context.symbol(other, 0), other.lstrip("?"), 1.05
        for other in alternatives(name, quantities):
            same = DIMENSION_OF.get(other) == DIMENSION_OF.get(name)
            if not _in_use(other, context, editor):
                continue
            used = other in editor.printer.styles or not editor.printer.styles
            yield quantities[other], editor.printer.symbol(other), (1.05 if same else 1.3) + (0.0 if used else 0.1)
    if node.kind == "function" and node.value in CIRCULAR:
        inner = _argument(node, context)
        for other in FUNCTIONS:
            if inner is not None and other != node.value:
                slash = "\\" if editor.of(node.marks[0]).startswith("\\") else ""
                with np.errstate(all="ignore"):
                    yield (
                        _functions(other, inner, quantities),
                        slash + other,
                        1.0 + 0.1 * FUNCTIONS.index(other) ** 2 / 4,
                    )


def own_names(name: str, context: Context) -> Iterator[str]:
    """Symbols that the text or the user defined, in place of another of the same dimension."""
    own = context.definitions
    for other in own:
        if other != name and other.startswith("?"):
            try:
                same = dimension(own[other], own) == dimension(Node("symbol", (0, 0), name), own)
                fits = same and context.symbol(other, 0).ndim == 1
            except (Unread, Disagreement):
                continue
            if fits:
                yield other


def _argument(node: Node, context: Context) -> Values | None:
    return evaluate(node.children[0], context)


def _functions(name: str, x: Values, quantities: Quantities) -> Values:
    xp = quantities.xp
    if name in ("sin", "cos"):
        return getattr(xp, name)(x)
    return xp.sin(x) / xp.cos(x) if name == "tan" else xp.cos(x) / xp.sin(x)


def alternatives(name: str, quantities: Quantities) -> list[str]:
    """Names that could stand in place of one: of its family first, and the common ones."""
    family = [other for names in FAMILIES if name in names for other in names]
    if name in VECTORS | MATRICES:
        return [other for other in dict.fromkeys(family) if other != name]
    rest = [*COMMON, *RODS[quantities.rod]]
    others = [other for other in dict.fromkeys([*family, *rest]) if other != name and other in quantities]
    return [other for other in others if other not in VECTORS and np.any(quantities[other])]


def _in_use(name: str, context: Context, editor: Editor) -> bool:
    """Whether a name is a parameter of the rod, or one that the text uses."""
    rod = context.quantities.rod
    return (
        name not in ("h", "r", "I1", "I2", "I3", "J1", "J2", "J3")
        or name in (*PARAMETERS[rod], *RODS[rod])
        or name in editor.printer.styles
    )


def _powers(need: Need, context: Context, editor: Editor) -> Iterator[Edit]:
    """Another exponent, or one where there is none."""
    node = need.node
    if node.kind == "power" and isinstance(node.value, Fraction):
        base = _argument(node, context)
        for exponent in (1, 2, 3, 4):
            if base is not None and base.ndim == 1 and exponent != node.value:
                splice = editor.other_exponent(node, exponent)
                old, new = editor.shown(need, (splice,))
                yield Edit(
                    (splice,),
                    1.1,
                    f"{old} should be {new}",
                    old,
                    new,
                    {id(node): power(base, Fraction(exponent), 0, context)},
                )
    plain = node.kind in ("symbol", "function") and (need.parent is None or need.parent.kind != "power")
    plain = plain and (need.role != "argument" or node.bracketed is not None)
    if plain and need.value.ndim == 1 and not need.lone and node.kind != "number":
        for exponent in (2, 3):
            splice = editor.exponent(node, exponent)
            old, new = editor.shown(need, (splice,))
            yield Edit((splice,), 1.15, f"{old} should be {new}", old, new, {id(node): need.value**exponent})


def _multiples(need: Need, context: Context, editor: Editor) -> Iterator[Edit]:
    """The argument of a function doubled or halved, and the factor of an argument left out."""
    node = need.node
    if need.role == "argument" and need.parents[-1].kind == "function" and need.value.ndim == 1:
        for factor in (Fraction(2), Fraction(1, 2)):
            number = editor.printer.number(factor)
            splice = editor.before(node, number if editor.printer.latex else f"({number})")
            if need.parents[-1].value != "sqrt" and node.bracketed is not None:
                splice = (node.span[0], node.span[0], splice[2])
                old, new = editor.shown(need, (splice,))
                yield Edit((splice,), 1.2, f"{old} should be {new}", old, new, {id(node): need.value * float(factor)})


def _numbers(need: Need, editor: Editor) -> Iterator[Edit]:
    """A usual multiple of a number."""
    if need.node.kind != "number" or not need.node.value:
        return
    for factor in FACTORS:
        value = need.node.value * factor
        if value.denominator == 1 or need.node.value == 1:
            text = editor.printer.number(value)
            splice = editor.put(need.node.span, text if value.denominator == 1 or editor.printer.latex else f"({text})")
            old, new = editor.shown(need, (splice,))
            yield Edit(
                (splice,),
                0.05 + number_cost(need, value),
                f"{old} should be {new}",
                old,
                new,
                {id(need.node): need.value * float(factor)},
            )


def number_cost(need: Need, value: Fraction) -> float:
    """What another number costs: more for a 1 that might be left out, and for a fraction inside a printed one."""
    printed = any(parent.fraction for parent in need.parents[-2:])
    idle = value == 1 and (need.role == "divisor" or (need.role == "factor" and not need.parents[-1].fraction))
    broken = value.denominator > 1
    return 1.0 + simple(value) + 0.5 * need.lone + 0.25 * idle + (0.6 if printed else 0.1) * broken


def _of_equal_parts(found: list[Need], context: Context, editor: Editor) -> Iterator[Edit]:
    """The same replacement wherever a symbol or function stands, and two symbols exchanged."""
    groups: dict[tuple, dict[int, Need]] = defaultdict(dict)
    for need in found:
        if need.node.kind in ("symbol", "function", "number"):
            groups[key(need.node)][id(need.node)] = need
    several = {k: list(members.values()) for k, members in groups.items()}
    for members in several.values():
        if len(members) > 1:
            yield from _together(members, context, editor)
    for kind, least, cost in (("symbol", 2, 1.6), ("number", 2, 1.3)):
        names = [members for members in several.values() if members[0].node.kind == kind]
        for first, second in combinations(names, 2):
            if len(first) + len(second) >= least and first[0].value.shape == second[0].value.shape:
                yield _exchanged(first, second, editor, cost)


def _together(members: list[Need], context: Context, editor: Editor) -> Iterator[Edit]:
    for value, text, cost in replacements(members[0].node, context, editor):
        splices = tuple(editor.put(n.node.span if n.node.kind == "symbol" else n.node.marks[0], text) for n in members)
        old, new = editor.shown(members[0], splices[:1])
        words = f"{old} should be {new}, wherever it stands"
        yield Edit(splices, cost + 0.35, words, old, new, {id(n.node): value for n in members})


def _exchanged(first: list[Need], second: list[Need], editor: Editor, cost: float) -> Edit:
    a, b = editor.of(first[0].node.span), editor.of(second[0].node.span)
    splices = [editor.put(n.node.span, b) for n in first] + [editor.put(n.node.span, a) for n in second]
    instead = {id(n.node): second[0].value for n in first} | {id(n.node): first[0].value for n in second}
    return Edit(tuple(splices), cost, f"{a} and {b} are exchanged", a, b, instead)
