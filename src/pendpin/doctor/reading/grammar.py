"""Tokens to trees: sums, products with and without signs, powers, functions, fractions, matrices."""

from dataclasses import replace
from fractions import Fraction

from pendpin.doctor.reading.binding import bound
from pendpin.doctor.reading.brackets import CLOSING, Brackets
from pendpin.doctor.reading.names import Vocabulary, unknown
from pendpin.doctor.reading.tokens import Token, is_latex, joined, tokens
from pendpin.doctor.reading.tree import Node, Span, Unread

ENDS = {"close", "relation", "other relation", "condition", "&", "row", ",", ";", ".", "end"}
MOST_POWER = 12
MOST_DIGITS = 30
SEPARATORS = (",", ";", "row", ".", "&")


def parse(text: str, words: Vocabulary | None = None, *, tight: bool = False) -> list[list[Node]]:
    """The equations of a text, each a list of sides that are equal; `tight` reads 3g/2l as 3g/(2l). Raises Unread.

    Its names mean nothing yet, unless some `words` are given.
    """
    equations = Parser(joined(tokens(text)), is_latex(text), tight).equations()
    return [[bound(side, words) for side in sides] for sides in equations] if words else equations


def lone(text: str, words: Vocabulary) -> Node | None:
    """The one expression that a text is; None for an equation or several. Raises Unread."""
    found = parse(text, words)
    return found[0][0] if [len(sides) for sides in found] == [1] else None


class Parser(Brackets):
    """One pass over the tokens of a text."""

    def equations(self) -> list[list[Node]]:
        """Lines, sides, and equations on one line with a comma between. Raises Unread."""
        found: list[list[Node]] = [[]]
        before = ""  # what stands before this place: nothing, a side, or =
        while (token := self.peek()).kind != "end":
            if token.kind in SEPARATORS:
                self.take()
                if self._separates(token, before) and found[-1]:
                    found.append([])
                    before = ""
            elif token.kind == "relation":
                if before == "=" or not found[-1]:
                    raise Unread("the left side of = is empty", token.start)
                self.take()
                before = "="
            elif before == "side" or token.kind in ("close", "condition", "other relation"):
                self._misplaced(token)
            else:
                found[-1].append(self.sum())
                before = "side"
        if before == "=":
            raise Unread("the right side of = is empty", token.start)
        return [sides for sides in found if sides]

    def _separates(self, token: Token, before: str) -> bool:
        """Whether a separator, which is taken, ends an equation. Raises Unread where that has no right side."""
        if token.kind in ("&", "."):
            return False
        if before == "=":
            raise Unread("the right side of = is empty", token.start)
        return self.peek().kind not in ("end", "&", "relation", *SEPARATORS)

    def _misplaced(self, token: Token) -> None:
        """Past a condition after which nothing follows. Raises Unread for all else that begins no side."""
        if token.kind == "condition":
            self.take()
            if self.peek().kind in ("end", *SEPARATORS):
                return
            raise Unread(f"an equation that holds only {token.text} is not checked", token.start)
        if token.kind == "other relation":
            raise Unread(f"not an equation: it holds the relation {token.text}", token.start)
        opening = {closed: opened for opened, closed in CLOSING.items()}.get(token.text, "")
        raise Unread(f"the bracket {token.text} closes nothing", token.start, opening)

    def sum(self) -> Node:
        """Terms with their signs."""
        signs, terms, marks, start = [], [], [], self.peek().start
        while True:
            sign, mark = self._signs(self.peek().start)
            if self._ends(self.peek()):
                raise Unread("a term is missing", mark[1])
            terms.append(self.product())
            signs.append(sign)
            marks.append(mark)
            if self.peek().text not in ("+", "-") or self.peek().kind != "operator":
                break
        if len(terms) == 1 and marks[0][0] == marks[0][1]:
            return terms[0]
        return Node("sum", (start, terms[-1].outer[1]), tuple(signs), tuple(terms), tuple(marks))

    def _signs(self, place: int) -> tuple[int, Span]:
        sign, end = 1, place
        while self.peek().kind == "operator" and self.peek().text in "+-":
            token = self.take()
            sign, end = (-sign if token.text == "-" else sign), token.end
        return sign, (place, end)

    def product(self) -> Node:
        """Factors, multiplied with or without a sign."""
        factors, operators, marks = [self.power()], ["*"], [(0, 0)]
        slash = False
        while True:
            token = self.peek()
            if self._ends(token) or (token.kind == "operator" and token.text in "+-"):
                break
            mark = (token.start, token.start)
            operator = "*"
            if token.kind == "operator":
                operator, mark = self._operator(), (token.start, token.end)
            elif slash and self.tight and token.kind in ("letter", "word", "number"):
                operator = "/"
            factors.append(self.power())
            operators.append(operator)
            marks.append(mark)
            slash = operator == "/" and (token.kind == "operator" or slash)
        if len(factors) == 1:
            return factors[0]
        marks[0] = (factors[0].outer[0], factors[0].outer[0])
        span = (factors[0].outer[0], factors[-1].outer[1])
        return Node("product", span, tuple(operators), tuple(factors), tuple(marks))

    def _operator(self) -> str:
        token = self.take()
        if self._ends(self.peek()):
            raise Unread("a factor is missing", token.end)
        return token.text

    def _ends(self, token: Token) -> bool:
        """Whether an expression ends before a token; | ends one that a | has opened."""
        closes = token.kind == "|" and self.bars > 0
        return token.kind in ENDS or closes or (token.kind == "command" and token.text in ("end", "over"))

    def power(self) -> Node:
        """A factor with its exponents."""
        base = self.atom()
        bracketed = base.bracketed is not None
        while bracketed and self.peek().kind == "prime":
            for _ in self.take().text:
                base = Node("derivative", (base.outer[0], self.peek(-1).end), "t", (base,))
        while self.peek().kind in ("^", "superscript"):
            if end := self._transposed():
                base = Node("function", (base.outer[0], end), "transpose", (base,), ((end, end),))
                continue
            exponent, mark = self.exponent()
            if self.peek().kind == "_" and base.kind == "symbol" and base.written and not base.written.index:
                written = replace(base.written, index=self._index())  # an index after the exponent
                base = replace(base, value=unknown(written), written=written)
                mark = (mark[0], self.peek(-1).end)
            if base.value == "norm" and exponent == 2:
                base = replace(base.children[0], bracketed=base.span)
            base = Node("power", (base.outer[0], mark[1]), exponent, (base,), (mark,))
        return base

    def _transposed(self) -> int:
        """The end of a T that is an exponent, and past it; 0 where there is none."""
        place = self.place
        self.take()
        if [self.peek().kind, self.peek(2).kind] == ["open", "close"]:
            self.take()
        if self.peek().text not in ("T", "top", "intercal"):
            self.place = place
            return 0
        end = self.take().end
        return self.take().end if self.tokens[place + 1].kind == "open" else end

    def exponent(self) -> tuple[Fraction, Span]:
        """A small number after ^, with its place."""
        token = self.take()
        if token.kind == "superscript":
            return Fraction(token.text), (token.start, token.end)
        value = self.atom_of_exponent()
        if abs(value) > MOST_POWER or value.denominator > 2:
            raise Unread(f"the exponent {value} is not from -{MOST_POWER} to {MOST_POWER}", token.start)
        return value, (token.start, self.peek(-1).end)

    def atom_of_exponent(self) -> Fraction:
        """The number of an exponent, such as 2, {2}, (-1), {1/2}."""
        start = self.peek()
        bracketed = start.kind == "open"
        if bracketed:
            self.take()
            node = self.sum()
            self.close(start)
        else:
            sign, _ = self._signs(start.start)
            self.digit()
            node = self.atom()
            node = Node("sum", node.span, (sign,), (node,))
        return _constant(node, start.start)

    def atom(self) -> Node:
        """A number, symbol, function, fraction, bracket or matrix."""
        token = self.peek()
        if token.text == "d" and token.kind == "letter" and (node := self._slashed()):
            return node
        if token.kind == "number" or token.kind == "half":
            return self._number()
        if token.kind == "function":
            return self._function()
        if token.kind == "command":
            return self._command()
        if token.kind == "open" and not self.at_symbol():
            return self.group()
        if token.text == "der" and self.peek(1).text == "(":
            self.take()
            inner = self.group()
            if inner.written is None:
                raise Unread("der of more than one symbol", token.start)
            written = replace(inner.written, dots=inner.written.dots + 1)
            return Node("symbol", (token.start, inner.outer[1]), unknown(written), written=written)
        if token.text == "diag" and self.peek(1).kind == "open":
            return self._diagonal()
        if token.kind == "|":
            return self.length()
        if self.at_symbol():
            return self.symbol()
        wrong = "it ends too early" if token.kind == "end" else f"{token.text!r} stands where a quantity should"
        raise Unread(wrong, token.start)

    def _number(self) -> Node:
        token = self.take()
        if len(token.text) > MOST_DIGITS:
            raise Unread(f"a number of {len(token.text)} digits", token.start)
        return Node("number", (token.start, token.end), Fraction(token.text))

    def _function(self) -> Node:
        token = self.take()
        name = token.text
        exponent = self.exponent() if self.peek().kind in ("^", "superscript") else None
        if exponent and exponent[0] < 0:
            raise Unread(f"{name}^-1 may be the inverse function or 1/{name}: write which", token.start)
        if name == "sqrt" and self.peek().text == "[":
            raise Unread("only square roots are read", token.start)
        argument = self._argument(name)
        node = Node("function", (token.start, argument.outer[1]), name, (argument,), ((token.start, token.end),))
        return node if exponent is None else Node("power", node.span, exponent[0], (node,), (exponent[1],))

    def _argument(self, name: str) -> Node:
        """Of a function: what is in brackets, or, as in sin 2 phi, a number and a symbol."""
        if self.peek().kind == "open" and not self.at_symbol():
            return self.group()
        start, factors = self.peek().start, []
        with self.deeper():
            while self.peek().kind in ("number", "half") and len(factors) < 1:
                factors.append(self._number())
            if self.peek().kind == "command" or self.at_symbol():
                factors.append(self.atom())
        if not factors:
            raise Unread(f"{name} of nothing", start)
        if len(factors) == 1:
            return factors[0]
        marks = ((start, start), (factors[1].span[0], factors[1].span[0]))
        return Node("product", (start, factors[1].outer[1]), ("*", "*"), tuple(factors), marks)

    def _command(self) -> Node:
        token = self.peek()
        if token.text == "frac":
            return self._derivative() or self._fraction()
        if token.text == "sqrt":
            return self._function()
        if token.text == "begin":
            return self.matrix()
        if token.text in ("underbrace", "overbrace"):
            return self._labelled()
        if token.text == "partial" and (node := self._slashed()):
            return node
        raise Unread(f"\\{token.text} stands where a quantity should", token.start)

    def _diagonal(self) -> Node:
        """diag(a, b, c): a matrix."""
        start = self.take().start
        entries = self.group().children
        count, zero = len(entries), Node("number", (start, start), Fraction(0))
        cells = [entries[i] if i == j else zero for i in range(count) for j in range(count)]
        return Node("matrix", (start, self.peek(-1).end), (count, count), tuple(cells))

    def _labelled(self) -> Node:
        """What stands over or under a brace, without the brace and its label."""
        self.take()
        node = self.atom()
        if self.peek().kind in ("_", "^"):
            self.take()
            self.skip_group()
        return node

    def _fraction(self) -> Node:
        start = self.take().start
        with self.deeper():
            parts = []
            for _ in range(2):
                self.digit()
                parts.append(self.atom())
        span = (start, parts[1].outer[1])
        return Node("product", span, ("*", "/"), tuple(parts), ((start, start), (start, start)), fraction=True)

    def _slashed(self) -> Node | None:
        """A derivative on one line, as dD/d phi; None where there is none."""
        place, start = self.place, self.take()
        above = self.symbol() if self.at_symbol() else None
        slash, sign = self.take().text, self.take()
        if above is None or slash != "/" or sign.text != start.text or not self.at_symbol():
            self.place = place
            return None
        below = self.symbol()
        return self.differentiated(above, below, (start.start, below.span[1]))

    def _derivative(self) -> Node | None:
        """d/dt or a partial derivative, where a fraction is one."""
        place, start = self.place, self.peek().start
        self.take()
        above, below = self.differential(), self.differential()
        if above is None or below is None or below[1] is None or above[0] != below[0] or above[2] != below[2]:
            self.place = place
            return None
        node = above[1] if above[1] is not None else self.atom()
        for _ in range(above[2]):
            node = self.differentiated(node, below[1], (start, self.peek(-1).end))
        return node


def _constant(node: Node, place: int) -> Fraction:
    """The value of an exponent, made of numbers only."""
    if node.kind == "number":
        return node.value
    if node.kind == "sum":
        return sum((s * _constant(c, place) for s, c in zip(node.value, node.children, strict=True)), Fraction(0))
    if node.kind == "product" and all(child.kind in ("number", "sum") for child in node.children):
        value = Fraction(1)
        for operator, child in zip(node.value, node.children, strict=True):
            other = _constant(child, place)
            if operator == "/" and not other:
                break
            value = value / other if operator == "/" else value * other
        else:
            return value
    raise Unread("only numbers are read as exponents", place)
