"""The one generator of changes of a wrong equation: parts of its tree become others, characters of its text say the same.

What could be wrong is listed: a sign, number, symbol, function, power, factor or term, one alone or all that are printed
alike. What has a size, a number, factor or term that is missing, is read from the value that a part would have to have.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from itertools import combinations, pairwise

import numpy as np

from pendpin.doctor.checking.residuals import Disagreement, Equation, dimension
from pendpin.doctor.mending.numbers import CLOSE, Monomial, Numbers, Part, fraction_of, parts_of, reader_of, swapped
from pendpin.doctor.mending.writing import Splice, Writer
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.names import MASS
from pendpin.doctor.reading.tree import Node, Unread, key, parts
from pendpin.doctor.systems.base import System, Values, dot, random_states
from pendpin.doctor.systems.tables import FAMILIES

FUNCTIONS = {"sin": 1.0, "cos": 1.0, "tan": 1.1, "cot": 1.2}  # and what it costs to write one for another
CIRCULAR = {*FUNCTIONS, "sec", "csc"}
FACTORS = [Monomial(Fraction(*pair)) for n in (2, 3, 4, 6, 12) for pair in ((n, 1), (1, n))]
FACTORS += [Monomial(Fraction(3, 2)), Monomial(Fraction(2, 3))]
ODDNESS = {1: 0.0, 2: 0.02, 3: 0.03, 4: 0.03, 6: 0.03, 12: 0.03, 8: 0.08, 24: 0.08, 5: 0.12, 9: 0.12, 10: 0.12, 7: 0.14}
PLANAR = FAMILIES.keys() - {"polar", "furuta"}
INERTIAS = {"I1", "I2", "I3", "J1", "J2", "J3", "h"}  # that a missing term may hold, wherever the page is about them
MOST_FACTORS = 3  # that are missing at one place: who forgets more has made another mistake
MOST_EXTRA = 6  # how much a missing term may hold beside a quantity that is no parameter, sine or rate
MOST_SHOWN = 60  # characters of a product that has a factor too many
NUMBER = Node("number", (0, 0), Fraction(1))  # that is printed nowhere


@dataclass(frozen=True, eq=False)
class Change:
    """A change of the text, how unlikely it is, in words, and the trees that stand in place of others, by id."""

    splices: tuple[Splice, ...]
    cost: float
    words: str
    old: str = ""
    new: str = ""
    swaps: Mapping[int, Node] = field(default_factory=dict)
    count: int = 1

    @property
    def order(self) -> tuple[float, int, str]:
        """The likeliest first, of these the shortest."""
        return self.cost, len(self.words), self.words

    def __and__(self, other: "Change") -> "Change":
        """Two changes as one; one may stand within the other."""
        swaps = {place: swapped(node, other.swaps) for place, node in self.swaps.items()}
        swaps |= {place: swapped(node, self.swaps) for place, node in other.swaps.items()}
        words = f"{self.words}, and {other.words}", f"{self.old}; {other.old}", f"{self.new}; {other.new}"
        return Change((*self.splices, *other.splices), self.cost + other.cost, *words, swaps, count=2)


def times(node: Node, monomial: Monomial) -> Node:
    """A part times a monomial."""
    factors = [("*", node), ("*", replace(NUMBER, value=monomial.factor))]
    for name, power in monomial.powers:
        function, _, quantity = name.rpartition(" ")
        atom = Node("symbol", (0, 0), quantity)
        atom = Node("function", (0, 0), function, (atom,)) if function else atom
        atom = atom if abs(power) == 1 else Node("power", (0, 0), Fraction(abs(power)), (atom,))
        factors.append(("*" if power > 0 else "/", atom))
    operators, children = zip(*factors, strict=True)
    return Node("product", node.span, operators, children, ((0, 0),) * len(children))


def oddness(factor: Fraction) -> float:
    """How odd a fraction is: 0 for 1, small for halves, thirds and twelfths, larger for others."""
    return sum(ODDNESS.get(abs(part), 0.2) for part in (factor.numerator, factor.denominator))


class Patient:
    """A wrong equation: one reading of what is printed, and every small change of it, written as its text is.

    `numbers` holds its values at random states; None where it has none.
    """

    def __init__(self, printed: Printed, equation: Equation, system: System, writer: Writer) -> None:
        self.printed, self.equation, self.system, self.writer = printed, equation, system, writer
        self.spec, self.parts, self.numbers = system.spec, parts_of(equation), None
        states = random_states(system)
        with suppress(Unread):
            self.numbers = Numbers(equation, states)
        self.quantities = states
        products = [node for node in parts(equation.sides) if node.kind == "product"]
        pairs = (pair for node in products for pair in zip(node.value, node.children, strict=True))
        self._is_planar = self.spec.kind.split()[0] in PLANAR  # no law there divides by a sine, a cosine or a rate
        self._below = {name for operator, child in pairs if operator == "/" for name in child.names}

    # --- what is listed -----------------------------------------------------------------------------------------

    def listed(self) -> Iterator[Change]:
        """The changes that can be listed: of one part, of all that are printed alike."""
        alike: dict[tuple, list[Part]] = defaultdict(list)
        for part in self.parts:
            yield from self._of_part(part)
            if part.node.kind in ("symbol", "function", "number"):
                alike[key(part.node)].append(part)
        for group in (group for group in alike.values() if len(group) > 1):
            where = "in both places" if len(group) == 2 else f"in all {len(group)} places"
            for new, text, cost in self._replacements(group[0]):
                splices = tuple(self.writer.rename(part.node, text) for part in group)
                first = self._replaced(group[0], splices[0], cost + (0.15 if new.kind == "number" else 0.35), new)
                swaps = {id(part.node): new for part in group}
                yield replace(first, splices=splices, words=f"{first.words}, {where}", swaps=swaps)

    def _of_part(self, part: Part) -> Iterator[Change]:
        node, writer = part.node, self.writer
        if part.whole and node.kind != "number":
            several = node.kind == "sum" and bool(node.children[1:])
            cost = 1.0 + 0.5 * part.lone + 0.1 * several + 0.01 * (part.role == "term" and not part.index)
            words = f"the sign of {writer.of(node.outer)} is wrong"
            yield self._replaced(part, writer.sign(part), cost, times(node, Monomial(Fraction(-1))), words)
            for factor in (*FACTORS, *self._forgotten):
                yield self._missing(part, factor, 1.25 + oddness(factor.factor) + 0.5 * part.lone)
        if part.role in ("factor", "divisor") or (part.role == "term" and len(part.parents[-1].children) > 1):
            yield self._removed(part, 1.25 if part.role == "term" else 1.2)
        if part.whole or part.role == "factor":
            yield from self._brackets(part)
        if node.kind == "product":
            yield from self._upside_down(node)
        for new, text, cost in self._replacements(part):
            yield self._in_place(part, new, text, cost + 0.5 * part.lone)
        exponents: set[int] = {1, 2, 3, 4} - {node.value} if node.kind == "power" else set()
        if node.kind in ("symbol", "function") and part.role != "base":
            exponents = {2} if part.lone else {2, 3} if part.role != "argument" or node.bracketed else set()
        for exponent in exponents:
            base, cost = (node.children[0], 1.1) if node.kind == "power" else (node, 1.15 + 0.5 * part.lone)
            raised = Node("power", node.span, Fraction(exponent), (base,), (node.span,))
            yield self._replaced(part, writer.exponent(node, exponent), cost, raised)

    def _upside_down(self, node: Node) -> Iterator[Change]:
        """Quotients of a product the other way round, as l/g for g/l."""
        for i, (above, below) in enumerate(pairwise(node.children)):
            if node.value[i : i + 2] == ("*", "/") and (above.names or above.value == 1) and below.names:
                children = (*node.children[:i], below, above, *node.children[i + 2 :])
                first, second = (self.writer.text[slice(*one.outer)] for one in (above, below))
                splices = (*above.outer, second), (*below.outer, first)
                old = self.writer.of(node.span if node.fraction else (above.outer[0], below.outer[1]))
                words = f"the quotient {old} is upside down" if len(old) <= MOST_SHOWN else "a quotient is upside down"
                yield Change(splices, 1.15, words, old, "", {id(node): replace(node, children=children)})

    def _brackets(self, part: Part) -> Iterator[Change]:
        """A bracket that ends too late, as in m (a + b), or that is missing, as in m a + b."""
        node, free = part.node, part.role != "term" or part.parents[-1].value[part.index] > 0
        last = node.children[-1] if node.kind == "product" and not node.fraction else node
        inside = last.bracketed if last is not node and last.kind == "sum" and part.whole and free else None
        for i in range(1, len(last.children)) if inside and {*node.value[1:]} <= {"*"} else ():
            first = replace(last, value=last.value[:i], children=last.children[:i])
            first = replace(node, children=(*node.children[:-1], first))
            moved = Node("sum", node.span, (1, *last.value[i:]), (first, *last.children[i:]))
            cut, end = last.children[i - 1].outer[1], inside[1] if inside else 0
            rest, splices = self.writer.of((cut, end - 1)), ((cut, cut, ")"), (end - 1, end, ""))
            yield Change(splices, 1.2, f"{rest} belongs behind the bracket", rest, rest, {id(node): moved})
        begins = node.kind == "sum" and node.value[0] > 0 and not node.marks[0][1] > node.span[0]
        head = node.children[0] if begins else node
        plain = head is not node and head.kind == "product" and not head.bracketed and {*head.value[1:]} <= {"*"}
        for i in range(1, len(head.children)) if plain else ():
            rest = replace(head, value=("*", *head.value[i + 1 :]), children=head.children[i:])
            total = replace(node, children=(rest, *node.children[1:]))
            moved = replace(head, value=head.value[: i + 1], children=(*head.children[:i], total))
            start, end = head.children[i].outer[0], node.children[-1].outer[1]
            words = f"a bracket is missing around {self.writer.of((start, end))}"
            cost = 1.2 if any(one.names for one in head.children[:i]) else 1.6
            yield Change(((start, start, "("), (end, end, ")")), cost, words, "", "( )", {id(node): moved})

    def _replacements(self, part: Part) -> Iterator[tuple[Node, str, float]]:
        """Other symbols for a symbol, functions for a function, numbers for a number: the tree, its text, the cost."""
        node, writer, units = part.node, self.writer, self.spec.dimensions
        if node.kind == "number" and node.value:
            for value in (node.value * factor.factor for factor in FACTORS):
                if value.denominator == 1 or node.value == 1:
                    yield replace(NUMBER, value=value), writer.number(value), 0.05 + _cost_of_number(part, value)
        if node.kind == "symbol":
            name, own = self.equation.meaning(str(node.value)), self.equation.definitions
            for other in own.keys() - {name}:  # what the text or the user defined, of the same dimension
                with suppress(Disagreement):
                    here, there = (dimension(Node("symbol", (0, 0), one), own, self.spec, {}) for one in (name, other))
                    if other.startswith("?") and here == there:
                        yield replace(node, value=other), other.lstrip("?"), 1.05
            if name not in {*self.spec.still, *self.spec.unknowns} and own.get(name, node).names - self.spec.still:
                rate = Node("derivative", node.span, "t", (node,))
                if writer.latex:
                    yield rate, rf"\dot{{{writer.of(node.span)}}}", 1.1
            masses = [one for one in self.spec.parameters if units.get(one) == MASS] if units.get(name) == MASS else []
            sums = (some for count in range(2, len(masses) + 1) for some in combinations(masses, count) if name in some)
            for some in sums:  # of a mass that moves others with it
                several = tuple(Node("symbol", (0, 0), one) for one in some)
                total = Node("sum", node.span, (1,) * len(several), several, ((0, 0),) * len(several), node.span)
                yield total, f"({' + '.join(writer.symbol(str(one.value)) for one in several)})", 1.2
            for other in self._alternatives(name):
                cost = 1.05 if units.get(other) == units.get(name) else 1.3
                cost += 0.1 * bool(writer.styles and other not in writer.styles)
                yield replace(node, value=other), writer.symbol(other), cost
        if node.kind == "function" and node.value in CIRCULAR:
            slash = "\\" * self.writer.of(node.marks[0]).startswith("\\")
            for other in FUNCTIONS.keys() - {node.value}:
                yield replace(node, value=other), slash + other, FUNCTIONS[other]
        arguments = (one.node for one in self.parts if one.role == part.role == "argument" and one.node.kind == "sum")
        for printed, other in {key(other): other for other in arguments}.items():
            if printed != key(node):
                yield other, writer.of(other.span if node.bracketed else other.outer), 1.1
        if node.kind == "derivative" and node.value != "t":
            for other in self.spec.state:
                yield replace(node, value=other), writer.symbol(other), 1.1

    def _alternatives(self, name: str) -> list[str]:
        """Names that could stand in place of one: of its family first, and the common ones."""
        spec, q, arrays = self.spec, self.quantities, self.spec.arrays
        family = [other for names in spec.families if name in names for other in names]
        known = ({*family} - spec.still | {*spec.parameters, *spec.common}) - spec.values.keys()
        known = (known | self.writer.styles.keys()) - {name}
        if name in arrays:
            return [other for other in dict.fromkeys(family) if other in known]
        return [
            one for one in dict.fromkeys([*family, *spec.common]) if one in known - arrays and one in q and q[one].any()
        ]

    @cached_property
    def _forgotten(self) -> list[Monomial]:
        """What is forgotten most beside numbers: a symbol of the text, above or below, a sine or cosine."""
        spec, q = self.spec, self.quantities
        styled = self.writer.styles.keys() & {*spec.still, *spec.rates} - spec.arrays
        names = sorted(name for name in styled if name in q and np.any(q[name]))
        names += [name for name in spec.moving if name.rpartition(" ")[2] in spec.coordinates]
        above = ("sin ", "cos ") if self._is_planar else ("sin ",)  # and never below
        powers = [(name, power) for name in names for power in (1, -1) if power > 0 or not name.startswith(above)]
        return [Monomial(Fraction(1), (power,)) for power in powers]

    # --- what has a size ----------------------------------------------------------------------------------------

    def by_need(self, part: Part, value: Values, needed: Values) -> Iterator[Change]:
        """Another number, a factor or a term that is missing, as the value tells with which the equation would hold."""
        node, reader = part.node, reader_of(self.quantities)
        if node.kind == "number" and (wanted := fraction_of(needed)) and wanted > 0 and wanted != node.value:
            new, cost = replace(NUMBER, value=wanted), _cost_of_number(part, wanted)
            yield self._in_place(part, new, self.writer.number(wanted), cost)
        if value.ndim != needed.ndim or value.ndim > 2 or not np.isfinite(needed).all():
            return
        if part.whole:
            with np.errstate(all="ignore"):
                ratio = needed / value if value.ndim == 1 else dot(needed, value) / dot(value, value)
            straight = value.ndim == 1 or np.abs(needed - ratio * value).max() <= CLOSE * np.abs(needed).max()
            for found in reader.read(ratio, self._extras) if straight else ():
                likely = found.factor > 0 and found.size <= MOST_FACTORS and found != Monomial(Fraction(1))
                if likely and not self._is_odd(found, 2):
                    cost = 1.22 + 0.01 * len(part.parents) + oddness(found.factor) + 0.5 * part.lone
                    cost += (0.3 * (found.size - 1) + 0.3 * (found.factor != 1)) * bool(found.powers)
                    yield self._missing(part, found, cost)
        if node.kind != "sum" and (node.kind == "number" or not (part.role in ("side", "entry") or node.bracketed)):
            return
        known = self.numbers.known if self.numbers else {}
        present = [known[id(one)] for one in (node.children if node.kind == "sum" else (node,))]
        lacking = needed - value
        with np.errstate(all="ignore"):  # what is there already is not missing once more
            again = value.ndim > 1 or any(fraction_of(lacking / one) for one in present if one.ndim == 1)
        terms = reader.read(lacking, self._extras) if not again else ()
        end = node.span[1] if node.kind == "sum" or node.bracketed else node.outer[1]
        for monomial in (term for term in terms if not self._is_odd(term, MOST_EXTRA)):
            steep = sum(power < 0 and name not in self._below for name, power in monomial.powers)
            cost = 1.55 + oddness(monomial.factor) + 0.05 * monomial.size + 0.5 * steep + 0.5 * part.lone
            text = f"{'+' if monomial.factor > 0 else '-'} {self.writer.monomial(monomial)}"
            yield Change(((end, end, f" {text}"),), cost, f"the term {text} is missing", "", text)

    @cached_property
    def _extras(self) -> dict[str, tuple[int, ...]]:
        """Quantities that a missing term or factor may hold beside the usual ones, with their powers.

        They are of the kinds that the equation is about, and not what it is solved for.
        """
        spec, names = self.spec, self.equation.names
        lone = {side.value for side in self.equation.sides if side.kind == "symbol"}
        families = (set(family) for family in spec.families if len(names.intersection(family)) > 1)
        possible = names.union(spec.unknowns, ["Mc"], INERTIAS & {*spec.common}, *families) - lone
        below = self._below - lone
        return {name: (1, 2) * (name in possible) + (-1,) * (name in below) for name in spec.extra}

    def _is_odd(self, monomial: Monomial, most: int) -> bool:
        """Whether it holds a quantity that is no usual one together with much else, or over an angle or a rate."""
        extra = [name for name, _ in monomial.powers if name in self._extras]
        falls = any(power < 0 and name in self.spec.moving for name, power in monomial.powers)
        if falls and self._is_planar:
            return True
        return bool(extra) and (monomial.size > most or (falls and extra[-1] != "M3"))

    # --- a change written ---------------------------------------------------------------------------------------

    def _in_place(self, part: Part, new: Node, text: str, cost: float) -> Change:
        """A symbol, function, number or variable in place of another; a factor 1 is left out."""
        if text == "1" and part.role in ("factor", "divisor") and not part.parents[-1].fraction:
            return self._removed(part, cost)
        return self._replaced(part, self.writer.rename(part.node, text), cost, new)

    def _replaced(self, part: Part, splice: Splice, cost: float, new: Node, words: str = "") -> Change:
        old, shown = self.writer.shown(part, splice)
        return Change((splice,), cost, words or f"{old} should be {shown}", old, shown, {id(part.node): new})

    def _removed(self, part: Part, cost: float) -> Change:
        """A sum without a term, which leaves 0 of any shape in its place, or a product without a factor."""
        what, old = "term" if part.role == "term" else "factor", self.writer.of(part.node.outer)
        new = times(part.node, Monomial(Fraction(0))) if what == "term" else NUMBER
        product = self.writer.of(part.parents[-1].outer) if what == "factor" else ""
        words = f"the {what} {old} is too many" + f" in {product}" * (0 < len(product) <= MOST_SHOWN)
        return Change((self.writer.without(part),), cost, words, old, "", {id(part.node): new})

    def _missing(self, part: Part, factor: Monomial, cost: float) -> Change:
        """A part with one more factor in front of it."""
        text, start = self.writer.monomial(factor), part.node.outer[0]
        text = f"({text})" if "/" in text and not self.writer.latex else text
        if part.node.kind == "sum" and len(part.node.children) == 1 and not part.node.bracketed:
            start = part.node.marks[0][1]  # behind the sign of a term alone
        splice = self.writer.before(start, text)
        words = f"the factor {text} is missing in {self.writer.of(part.node.outer)}"
        return self._replaced(part, splice, cost, times(part.node, factor), words)


def _cost_of_number(part: Part, value: Fraction) -> float:
    """What another number costs: more for a fraction inside a printed one."""
    printed = any(parent.fraction for parent in part.parents[-2:])
    return 1.0 + oddness(value) + 0.5 * part.lone + (value.denominator > 1) * (0.6 if printed else 0.1)
