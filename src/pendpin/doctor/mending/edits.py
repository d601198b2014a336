"""Changes of a printed equation: where characters are replaced, by what, in which words, and how unlikely it is."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from pendpin.doctor.checking.evaluation import Instead
from pendpin.doctor.mending.monomials import Monomial, Printer
from pendpin.doctor.mending.needs import Need
from pendpin.doctor.reading.tree import Node, Span, walk
from pendpin.doctor.systems.base import Values

_BARE = re.compile(r"\\[dtc]?frac\s*(?:\d|\{[^{}]*\})?\s*$")  # a number after it may have no braces
Change = Values | Callable[[Values], Values]
Splice = tuple[int, int, str]  # these characters of the source become this text


@dataclass(frozen=True, eq=False)
class Edit:
    """One change. `instead` gives nodes, by id, a new value or a function of it, where known; `old` and `new` are shown."""

    splices: tuple[Splice, ...]
    cost: float
    words: str
    old: str = ""
    new: str = ""
    instead: Instead | None = None
    changes: int = 1


def apply(text: str, splices: tuple[Splice, ...]) -> str:
    """The text with its changes."""
    for start, end, new in sorted(splices, reverse=True):
        text = text[:start] + new + text[end:]
    return text


def overlap(a: tuple[Splice, ...], b: tuple[Splice, ...]) -> bool:
    """Whether two changes touch the same characters."""
    return any((x[0] < y[1] and y[0] < x[1]) or x[0] == y[0] for x in a for y in b)


class Editor:
    """Writes changes of one source text."""

    def __init__(self, text: str, printer: Printer) -> None:
        self.text, self.printer = text, printer

    def of(self, span: Span) -> str:
        """The characters of a span."""
        return self.text[span[0] : span[1]].strip()

    def put(self, span: Span, new: str) -> Splice:
        """Replace a span, with a space or sign where two names would run together."""
        before, after = self.text[: span[0]], self.text[span[1] :]
        if self.printer.latex and _BARE.search(before) and len(new) > 1 and new.isdigit():
            return (*span, f"{{{new}}}")
        joint = " " if self.printer.latex else "*"
        if new and after and re.match(r"\w", after) and self._runs_on(new, after):
            new += joint
        if new and before and self._runs_on(before, new):
            new = joint + new
        return (*span, new)

    def _runs_on(self, left: str, right: str) -> bool:
        if self.printer.latex:
            return bool(
                (re.search(r"\\[A-Za-z]+$", left) and re.match(r"[A-Za-z]", right))
                or (re.search(r"(?<!frac)\d$", left) and re.match(r"\d", right))
            )
        return bool(re.search(r"\w$", left) and re.match(r"\w", right))

    def replaced(self, need: Need, splice: Splice, cost: float, change: Change | None = None) -> Edit:
        """Something else in a part; `change` is its new value, or what becomes of its value."""
        old, new = self.shown(need, (splice,))
        return Edit((splice,), cost, f"{old} should be {new}", old, new, _changed(need, change))

    def removed(self, need: Need, what: str, cost: float, change: Change | None = None) -> Edit:
        """A product without one of its factors, a sum without one of its terms."""
        splice = self.without_factor(need) if what == "factor" else self.without_term(need)
        old = self.of(need.node.outer)
        return Edit((splice,), cost, f"the {what} {old} is too many", old, "", _changed(need, change))

    def number(self, need: Need, value: Fraction, cost: float, change: Change | None = None) -> Edit:
        """Another positive number in place of one; a factor 1 is left out."""
        if value == 1 and need.role in ("factor", "divisor") and not need.parents[-1].fraction:
            return self.removed(need, "factor", cost, change)
        return self.replaced(need, self.put(need.node.span, self.bracketed(self.printer.number(value))), cost, change)

    def missing(self, need: Need, factor: Monomial, cost: float, change: Change | None = None) -> Edit:
        """A part with one more factor in front of it."""
        text = self.bracketed(self.printer.monomial(factor))
        splice = self.before(need.node.outer[0], text)
        old, new = self.shown(need, (splice,))
        return Edit((splice,), cost, f"the factor {text} is missing in {old}", old, new, _changed(need, change))

    def bracketed(self, text: str) -> str:
        """A fraction of plain text in brackets."""
        return text if self.printer.latex or "/" not in text else f"({text})"

    def before(self, start: int, factor: str) -> Splice:
        """A factor in front of what starts at a place."""
        joint = "*" if not self.printer.latex else r" \cdot " if re.match(r"\d", self.text[start:]) else " "
        return (start, start, factor + joint)

    def sign(self, need: Need) -> Splice:
        """The other sign for a term, side or entry."""
        node = need.node
        if need.role == "term":
            signs = need.parents[-1].value
            mark = need.parents[-1].marks[need.index]
            if signs[need.index] < 0:
                return (*mark, "+" if need.index else "")
            return (*mark, "-") if mark[1] > mark[0] else (mark[0], mark[0], "-")
        start = node.outer[0]
        return (start, start + 1, "") if self.text[start] == "-" else (start, start, "-")

    def without_term(self, need: Need) -> Splice:
        """A sum without one of its terms; the term that comes first then loses its plus."""
        total = need.parents[-1]
        mark, end = total.marks[need.index], need.node.outer[1]
        if len(total.children) == 1:
            return (mark[0], end, "0")
        if need.index == 0:
            following = total.marks[1]
            signs = total.value
            return (mark[0], following[1] if signs[1] > 0 else following[0], "")
        return (mark[0], end, "")

    def without_factor(self, need: Need) -> Splice:
        """A product without one of its factors."""
        product = need.parents[-1]
        if product.fraction:
            return (*need.node.outer, "{1}" if self.text[need.node.outer[0]] == "{" else "1")
        if need.index == 0:
            operators = product.value
            following = product.children[1]
            if operators[1] == "/":
                return (*need.node.outer, "1")
            return (need.node.outer[0], following.outer[0], "")
        return (product.marks[need.index][0], need.node.outer[1], "")

    def exponent(self, node: Node, power: int) -> Splice:
        """Another exponent for a power, none for 1; or one for a node that has none. `power` is from 1 to 4."""
        mark = "^" if self.printer.latex else "**"
        if node.kind == "power":
            start, end = node.marks[0]
            mark = "^" if "^" in self.text[start:end] else mark
            name_follows = self.text[end : end + 1].isalpha() if power == 1 else self.text[end : end + 1].isdigit()
            return (start, end, ("" if power == 1 else f"{mark}{power}") + " " * name_follows)
        if node.kind == "function" and self.printer.latex and node.bracketed is None:
            return (node.marks[0][1], node.marks[0][1], f"{mark}{power} ")
        return (node.outer[1], node.outer[1], f"{mark}{power}")

    def added(self, node: Node, sign: int, term: str) -> Splice:
        """One more term after a sum, side or entry."""
        end = node.span[1] if node.kind == "sum" or node.bracketed else node.outer[1]
        return (end, end, f" {'+' if sign > 0 else '-'} {term}")

    def shown(self, need: Need, splices: tuple[Splice, ...]) -> tuple[str, str]:
        """What is shown of a change: the factor, fraction or term that it is in, before and after."""
        node = need.node
        for parent in reversed(need.parents):
            if parent.kind not in ("product", "power", "function") or parent.span[1] - parent.span[0] > 60:
                break
            if any(part.kind == "sum" for part in walk(parent)):
                break
            node = parent
            if parent.kind == "product":
                break
        start, end = (min(node.outer[0], *(s[0] for s in splices)), max(node.outer[1], *(s[1] for s in splices)))
        inside = tuple((a - start, b - start, new) for a, b, new in splices)
        return _bare(self.text[start:end]), _bare(apply(self.text[start:end], inside))

    def below(self, node: Node, factor: int) -> Splice | None:
        """Multiply the denominator of a printed fraction; None for what is none."""
        if not (node.kind == "product" and node.fraction and self.printer.latex):
            return None
        start = node.children[1].span[0]
        return self.put((start, start), f"{factor} " if not re.match(r"\d", self.text[start:]) else rf"{factor} \cdot ")


def _changed(need: Need, change: Change | None) -> Instead | None:
    return None if change is None else {id(need.node): change}


def _bare(text: str) -> str:
    """Without the braces around all of it."""
    text = text.strip()
    inside = text[1:-1]
    return inside if text[:1] == "{" and text[-1:] == "}" and "{" not in inside and "}" not in inside else text
