"""Changes of a printed equation in its author's hand: which characters are replaced, and by what."""

import re
from dataclasses import dataclass
from fractions import Fraction

from pendpin.doctor.mending.numbers import Monomial, Part
from pendpin.doctor.reading.tree import Node, Span, walk
from pendpin.doctor.systems.base import Spec

_BARE = re.compile(r"\\[dtc]?frac\s*(?:\d|\{[^{}]*\})?\s*$")  # a number after it may have no braces
Splice = tuple[int, int, str]  # these characters of the text become those
MOST_SHOWN = 60  # characters of a product in which a change is shown


@dataclass(frozen=True)
class Writer:
    """Writes changes of a text, its numbers, symbols and products as it does. `styles` gives names as it prints them."""

    text: str
    latex: bool
    styles: dict[str, str]
    spec: Spec

    @property
    def joint(self) -> str:
        """What stands between factors."""
        return " " if self.latex else "*"

    def symbol(self, name: str) -> str:
        """A quantity, or a function of an angle or of two."""
        function, _, angle = name.rpartition(" ")
        if function:
            shown = re.sub(r"[^-+]+", lambda match: self.symbol(match[0]), angle)
            return "\\" * self.latex + f"{function}({shown})"
        base = name.lstrip("d")
        if name not in self.styles and base in self.styles:  # a rate of what the page has, written as others are
            letter, dots = self.styles[base], name[: -len(base)]
            for other, text in self.styles.items():
                before, found, behind = self.styles.get(dots + other, "").partition(text)
                if found:
                    return before + " " * bool(re.search(r"\\d+ot$", before) and letter[:1].isalpha()) + letter + behind
            if self.latex or not letter.isascii():
                marks = {"d": "\u0307", "dd": "\u0308"}
                return rf"\{dots}ot{{{letter}}}" if self.latex else letter + marks.get(dots, "")
        return self.styles.get(name) or (self.spec.printed.get(name, name) if self.latex else name)

    def number(self, value: Fraction) -> str:
        """A whole number, or a fraction, in plain text in brackets."""
        if value.denominator == 1:
            return str(value)
        return rf"\frac{{{value.numerator}}}{{{value.denominator}}}" if self.latex else f"({value})"

    def monomial(self, monomial: Monomial) -> str:
        """A product without its sign."""

        def raised(name: str, power: int) -> str:
            """A function's exponent stands before its bracket in LaTeX."""
            text, mark = self.symbol(name), "^" if self.latex else "**"
            if self.latex and power != 1:
                text, _, bracket = text.partition("(") if re.match(r"\\(sin|cos)\(", text) else (text, "", "")
                return f"{text}^{power}" + (f"({bracket}" if bracket else "")
            return text if power == 1 else f"{text}{mark}{power}"

        top, bottom = abs(monomial.factor.numerator), monomial.factor.denominator
        above = [raised(name, power) for name, power in monomial.powers if power > 0]
        below = [str(bottom)] * (bottom != 1) + [raised(name, -power) for name, power in monomial.powers if power < 0]
        above = [str(top)] * (top != 1 or not above) + above
        text, under = self.joint.join(above), self.joint.join(below)
        if under and self.latex:
            return rf"\frac{{{text}}}{{{under}}}"
        return text + (f"/({under})" if len(below) > 1 else f"/{under}" if under else "")

    def of(self, span: Span) -> str:
        """The characters of a span."""
        return self.text[span[0] : span[1]].strip()

    def put(self, span: Span, new: str) -> Splice:
        """Replace a span, with a space or sign where two names would run together."""

        def run_together(left: str, right: str) -> bool:
            if not self.latex:
                return bool(re.search(r"\w$", left) and re.match(r"\w", right))
            names = re.search(r"\\[A-Za-z]+$", left) and re.match(r"[A-Za-z]", right)
            return bool(names or (re.search(r"(?<!frac)\d$", left) and re.match(r"\d", right)))

        before, after, joint = self.text[: span[0]], self.text[span[1] :], self.joint
        if self.latex and _BARE.search(before) and len(new) > 1 and new.isdigit():
            return (*span, f"{{{new}}}")
        if new:
            new += joint * run_together(new, after)
            new = joint * run_together(before, new) + new
        return (*span, new)

    def rename(self, node: Node, new: str) -> Splice:
        """Another argument, or symbol, function and the like; a sum in code with the owner of each, as self.m1."""
        start, end = node.marks[0] if node.kind in ("function", "derivative") else node.span
        if new[:1] == "(" and (owner := re.search(r"(?:[A-Za-z]\w*\.)+$", self.text[:start])):
            return (owner.start(), end, re.sub(r"(?<!\w)(?=[A-Za-z])", owner[0], new))
        return self.put((start, end), new)

    def before(self, start: int, factor: str) -> Splice:
        """A factor in front of what starts at a place."""
        joint = r" \cdot " if self.latex and re.match(r"\d", self.text[start:]) else self.joint
        return (start, start, factor + joint)

    def sign(self, part: Part) -> Splice:
        """The other sign for a term, side or entry."""
        if part.role == "term":
            total = part.parents[-1]
            minus = total.value[part.index] < 0
            return (*total.marks[part.index], ("+" if part.index else "") if minus else "-")
        start, end = part.node.outer
        if part.node.kind == "sum" and part.node.children[1:] and not part.node.bracketed:
            return (start, end, f"-({self.text[start:end]})")
        return (start, start + 1, "") if self.text[start] == "-" else (start, start, "-")

    def without(self, part: Part) -> Splice:
        """A sum without one of its terms, the next one losing its plus; or a product without one of its factors."""
        whole, (start, end) = part.parents[-1], part.node.outer
        if part.index and not whole.fraction:
            return (whole.marks[part.index][0], end, "")
        if part.role == "term":
            return (whole.marks[0][0], whole.marks[1][1 if whole.value[1] > 0 else 0], "")
        if whole.fraction:
            return (start, end, "{1}" if self.text[start] == "{" else "1")
        return (start, end, "1") if whole.value[1] == "/" else (start, whole.children[1].outer[0], "")

    def exponent(self, node: Node, power: int) -> Splice:
        """Another exponent for a power, none for 1; or one for a node that has none. `power` is from 1 to 4."""
        mark = "^" if self.latex else "**"
        if node.kind == "power":
            start, end = node.marks[0]
            mark, following = "^" if "^" in self.text[start:end] else mark, self.text[end : end + 1]
            space = " " * (following.isalpha() if power == 1 else following.isdigit())
            return (start, end, ("" if power == 1 else f"{mark}{power}") + space)
        if node.kind == "function" and self.latex and node.bracketed is None:
            return (node.marks[0][1], node.marks[0][1], f"{mark}{power} ")
        return (node.outer[1], node.outer[1], f"{mark}{power}")

    def shown(self, part: Part, splice: Splice) -> tuple[str, str]:
        """What is shown of a change: the factor, fraction or term that it is in, before and after."""
        node = part.node
        for parent in reversed(part.parents):
            wide = parent.span[1] - parent.span[0] > MOST_SHOWN or any(below.kind == "sum" for below in walk(parent))
            if wide or parent.kind not in ("product", "power", "function"):
                break
            node = parent
            if parent.kind == "product":
                break
        start, end = min(node.outer[0], splice[0]), max(node.outer[1], splice[1])
        old = self.text[start:end]
        new = spliced(old, ((splice[0] - start, splice[1] - start, splice[2]),))
        bare = lambda text: re.sub(r"^\{([^{}]*)\}$", r"\1", text.strip())  # noqa: E731
        return bare(old), bare(new)


def spliced(text: str, splices: tuple[Splice, ...]) -> str:
    """The text with its changes."""
    for start, end, new in sorted(splices, reverse=True):
        text = text[:start] + new + text[end:]
    return text


def overlap(a: tuple[Splice, ...], b: tuple[Splice, ...]) -> bool:
    """Whether two changes touch the same characters."""
    return any((x[0] < y[1] and y[0] < x[1]) or x[0] == y[0] for x in a for y in b)
