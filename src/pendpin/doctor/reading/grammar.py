"""Tokens to trees: sums, products with and without signs, powers, functions, fractions, brackets, matrices."""

import re
from dataclasses import replace
from fractions import Fraction

from pendpin.doctor.reading.binding import bound
from pendpin.doctor.reading.names import GREEK, Vocabulary, Written, unknown
from pendpin.doctor.reading.printed_names import CLOSING, OF_TIME, PrintedNames, differentiated, symbol_of
from pendpin.doctor.reading.tokens import is_latex, lines, tokens
from pendpin.doctor.reading.tree import Node, Span, Unread

SEPARATORS = (",", ";", "row", ".", "&")
ENDS = {"close", "relation", "other relation", "condition", "end", *SEPARATORS}
MATRICES = {"bmatrix", "pmatrix", "matrix", "array", "smallmatrix", "Bmatrix", "Vmatrix"}
DERIVATIVES = ("der", "diff", "Derivative", "D")
POWERS = {"pow": 0, "power": 0, "square": 2}
LISTS = {"array", "Matrix", "matrix", "vector"}  # functions of code that only make a matrix of a list
MOST_POWER = 12
MOST_DIGITS = 30
MOST_TERMS = 6  # of a sum with bounds


def parse(text: str, words: Vocabulary | None = None, *, tight: bool = False) -> list[list[Node]]:
    """The equations of a text, each a list of sides that are equal; `tight` reads 3g/2l as 3g/(2l). Raises Unread.

    Its names mean nothing yet, unless some `words` are given.
    """
    try:
        equations = Parser(lines(tokens(text)), is_latex(text), tight).equations()
    except RecursionError:
        raise Unread("nested too deeply") from None
    return [[bound(side, words) for side in sides] for sides in equations] if words else equations


def lone(text: str, words: Vocabulary) -> Node | None:
    """The one expression that a text is; None for an equation or several. Raises Unread."""
    found = parse(text, words)
    return found[0][0] if [len(sides) for sides in found] == [1] else None


class Parser(PrintedNames):
    """One pass over the tokens of a text."""

    def equations(self) -> list[list[Node]]:
        """Lines, sides, and equations on one line with a comma between. Raises Unread."""
        found: list[list[Node]] = [[]]
        before = ""  # what stands before this place: nothing, a side, or =
        while (token := self.peek()).kind != "end":
            if token.kind in SEPARATORS:
                self.take()
                if before == "=" and token.kind not in ("&", "."):
                    raise Unread("the right side of = is empty", token.start)
                next_kind = self.peek().kind
                if token.kind not in ("&", ".") and next_kind not in ("end", "relation", *SEPARATORS) and found[-1]:
                    found.append([])
                    before = ""
            elif token.kind == "relation":
                if before == "=" or not found[-1]:
                    raise Unread("the left side of = is empty", token.start)
                self.take()
                before = "="
            elif token.kind == "condition":
                self.take()
                if self.peek().kind not in ("end", *SEPARATORS):
                    raise Unread(f"an equation that holds only {token.text} is not checked", token.start)
            elif token.kind == "other relation":
                raise Unread(f"not an equation: it holds the relation {token.text}", token.start)
            elif before == "side" or token.kind == "close":
                opening = {closed: opened for opened, closed in CLOSING.items()}.get(token.text, "")
                raise Unread(f"the bracket {token.text} closes nothing", token.start, opening)
            else:
                found[-1].append(self.sum())
                before = "side"
        if before == "=":
            raise Unread("the right side of = is empty", token.start)
        return [sides for sides in found if sides]

    def sum(self) -> Node:
        """Terms with their signs."""
        signs, terms, marks, start = [], [], [], self.peek().start
        while True:
            sign, first = 1, self.peek()
            end = first.start
            while self.peek().kind == "operator" and self.peek().text in "+-":
                token = self.take()
                sign, end = (-sign if token.text == "-" else sign), token.end
            if self.ends():
                raise Unread("a term is missing", end)
            terms.append(self.product())
            signs.append(sign)
            marks.append((first.start, end))
            if self.peek().text not in ("+", "-") or self.peek().kind != "operator" or self.new_entry():
                break
        if len(terms) == 1 and marks[0][0] == marks[0][1]:
            return terms[0]
        return Node("sum", (start, terms[-1].outer[1]), tuple(signs), tuple(terms), tuple(marks))

    def product(self) -> Node:
        """Factors, multiplied with or without a sign."""
        factors, operators, marks = [self.power()], ["*"], [(0, 0)]
        slash = False
        while True:
            token = self.peek()
            if self.ends() or (token.kind == "operator" and token.text in "+-") or self.new_entry():
                break
            mark, operator, name = (token.start, token.start), "*", factors[-1]
            if token.kind == "operator":
                operator, mark = self.take().text, (token.start, token.end)
                if self.ends():
                    raise Unread("a factor is missing", token.end)
            elif slash and self.tight and token.kind in ("letter", "word", "number"):
                operator = "/"
            elif token.kind == "open" and token.start == self.peek(-1).end and self.is_long(name):
                raise Unread(f"the function {name.value.lstrip('?')} is not known", name.span[0])
            factors.append(self.power())
            if mark[0] == mark[1] and self.is_long(name) and self.is_long(factors[-1]):
                both = " ".join(factor.value.lstrip("?") for factor in factors[-2:])
                raise Unread(f"{both}: words, or names without a sign between them", name.span[0])
            operators.append(operator)
            marks.append(mark)
            slash = operator == "/" and (token.kind == "operator" or slash)
        if len(factors) == 1:
            return factors[0]
        marks[0] = (factors[0].outer[0], factors[0].outer[0])
        span = (factors[0].outer[0], factors[-1].outer[1])
        return Node("product", span, tuple(operators), tuple(factors), tuple(marks))

    def is_long(self, node: Node) -> bool:
        """Whether a factor is a name of several letters, such as zeros: before a bracket a function of code."""
        if self.latex or node.written is None or node.bracketed or node.written.dots:
            return False
        return len(node.written.letter) > 1 and node.written.letter not in {*GREEK.values(), "const"}

    def new_entry(self) -> bool:
        """Whether the next token begins an entry of a row such as [a b -c]: after a blank that no sign has behind it."""
        token, before = self.peek(), self.peek(-1)
        if not self.spaced or token.start == before.end or before.kind == "operator":
            return False
        return token.kind != "operator" or (token.text in "+-" and self.peek(1).start == token.end)

    def ends(self) -> bool:
        """Whether an expression ends before the next token; | ends one that a | has opened."""
        token = self.peek()
        closes = token.kind == "|" and self.bars > 0
        return token.kind in ENDS or closes or (token.kind == "command" and token.text in ("end", "over"))

    def power(self) -> Node:
        """A factor with its exponents, or what is transposed; a letter after ^ belongs to the name before it."""
        base = self.atom()
        while base.bracketed is not None and self.peek().kind == "prime":
            token = self.take()
            if base.kind == "matrix" and not self.latex:
                base = Node("function", (base.outer[0], token.end), "transpose", (base,), ((token.start, token.end),))
                continue
            for _ in token.text:
                base = Node("derivative", (base.outer[0], token.end), "t", (base,))
        while self.peek().kind in ("^", "superscript"):
            start, above = self.peek().start, self.script()
            end = self.peek(-1).end
            if above in ("T", "top", "intercal"):
                if base.kind == "product" and {*base.value} == {"*"} and self.latex:  # entries with blanks between
                    base = Node("matrix", base.outer, (1, len(base.children)), base.children)
                base = Node("function", (base.outer[0], end), "transpose", (base,), ((end, end),))
                continue
            below = self.script() if self.peek().kind == "_" and base.kind == "symbol" else ""
            index = ",".join(filter(None, (base.written.index if base.written else "", below)))
            if base.written is not None and base.kind == "symbol" and re.fullmatch(r"[A-Za-z]+|\*", above):
                index = f"{index},{above}" if index else above
                base = symbol_of(replace(base.written, index=index), (base.span[0], self.peek(-1).end))
                continue
            if base.written is not None and below:  # an index after the exponent
                base = symbol_of(replace(base.written, index=index), base.span)
            exponent = _exponent(above, start)
            if base.value == "norm" and exponent == 2:
                base = replace(base.children[0], bracketed=base.span)
            mark = (start, self.peek(-1).end)
            base = Node("power", (base.outer[0], mark[1]), exponent, (base,), (mark,))
            any(self.took(*argument) for argument in OF_TIME)
        return base

    def atom(self) -> Node:
        """A number, symbol, function, fraction, bracket or matrix."""
        token = self.peek()
        if token.text in ("d", "partial", "frac") and (node := self.derivative()):
            return node
        match token.kind:
            case "number" | "half":
                self.take()
                if len(token.text) > MOST_DIGITS:
                    raise Unread(f"a number of {len(token.text)} digits", token.start)
                return Node("number", (token.start, token.end), Fraction(token.text))
            case "function":
                return self.function()
            case "command":
                return self.command()
            case "matrix":
                return self.matrix()
            case "|":
                return self.length()
            case "word" if self.peek(1).kind == "open" and token.text in (*DERIVATIVES, "diag", *POWERS, *LISTS):
                return self.named_function()
        if self.at_symbol():
            return self.symbol()
        if token.kind == "open":
            group = self.group()
            if token.text == "{" and group.kind == "symbol" and group.written and self.peek().kind == "_":
                written = replace(group.written, index=group.written.index + self.script())  # as in {\bf q}_1
                return symbol_of(written, (token.start, self.peek(-1).end))
            return group
        wrong = "it ends too early" if token.kind == "end" else f"{token.text!r} stands where a quantity should"
        raise Unread(wrong, token.start)

    def function(self) -> Node:
        """A function of what is in brackets or, as in sin 2 phi, of a number and a symbol."""
        token = self.take()
        name, caret = token.text, self.peek()
        exponent = _exponent(self.script(), caret.start) if caret.kind in ("^", "superscript") else None
        mark, first = (caret.start, self.peek(-1).end), self.peek()
        if exponent and exponent < 0:
            raise Unread(f"{name}^-1 may be the inverse function or 1/{name}: write which", token.start)
        if name == "sqrt" and first.text == "[" and self.latex:
            raise Unread("only square roots are read", token.start)
        if first.kind == "open" and not self.at_symbol():
            argument = self.group(row=False)
        else:
            factors = [self.atom()] if first.kind in ("number", "half") else []
            if self.peek().kind == "command" or self.at_symbol():
                factors.append(self.atom())
            if not factors:
                raise Unread(f"{name} of nothing", first.start)
            if self.peek().text == "t" and factors[-1].kind == "symbol":  # cos omega t
                factors.append(self.symbol())
            marks, signs = tuple((factor.span[0], factor.span[0]) for factor in factors), ("*",) * len(factors)
            argument = Node("product", (first.start, factors[-1].outer[1]), signs, tuple(factors), marks)
            argument = argument if len(factors) > 1 else factors[0]
        node = Node("function", (token.start, argument.outer[1]), name, (argument,), ((token.start, token.end),))
        return node if exponent is None else Node("power", node.span, exponent, (node,), (mark,))

    def named_function(self) -> Node:
        """der(x), diff(x, t), pow(x, 2), diag(a, b, c), array([...]) of code."""
        token, inner = self.take(), self.group(row=False)
        span = (token.start, self.peek(-1).end)
        parts: tuple[Node, ...] = inner.children if inner.kind == "matrix" else (inner,)
        inside = parts[0]
        if token.text in LISTS:
            return replace(inner, bracketed=span)
        if token.text == "diag":
            zero = Node("number", (token.start, token.start), Fraction(0))
            return _matrix([[parts[i] if i == j else zero for j in range(len(parts))] for i in range(len(parts))], span)
        if token.text in POWERS:
            power = parts[1].value if len(parts) == 2 and parts[1].kind == "number" else POWERS[token.text]
            if power not in range(1, MOST_POWER + 1) or len(parts) > 2:
                raise Unread("only small numbers are read as exponents", token.start)
            mark = parts[-1].outer if len(parts) == 2 else (token.start, token.end)
            return Node("power", span, Fraction(power), (inside,), (mark,))
        time = symbol_of(Written("t"), (span[1] - 1, span[1] - 1))
        if token.text in ("diff", "Derivative") and len(parts) == 1:
            raise Unread(f"{token.text} without a symbol to differentiate by", token.start)
        orders = [by.children if by.kind == "matrix" else (by,) for by in parts[1:] or (time,)]  # Derivative(x, (t, 2))
        for children in orders:
            by, *count = children
            times = count[0].value if count and count[0].kind == "number" else 1
            if by.written is None or times not in (1, 2):
                raise Unread(f"{token.text} is read of an expression and symbols", token.start)
            for _ in range(int(times)):
                inside = differentiated(inside, by, span)
        return inside

    def command(self) -> Node:
        r"""\sqrt, \frac, \begin of a matrix, \underbrace, \sum, \dv and \pdv."""
        token = self.peek()
        match token.text:
            case "sqrt":
                return self.function()
            case "begin":
                return self.matrix()
            case "frac":
                self.take()
                self.digit()
                above = self.atom()
                self.digit()
                parts, marks = (above, self.atom()), ((token.start, token.start),) * 2
                return Node("product", (token.start, parts[1].outer[1]), ("*", "/"), parts, marks, fraction=True)
            case "underbrace" | "overbrace":  # without its label
                self.take()
                node = self.group() if self.peek().kind == "open" else self.atom()
                if self.peek().kind in ("_", "^"):
                    self.script()
                return node
            case "dv" | "pdv":
                self.take()
                order = self.atom().value if self.peek().text == "[" else 1
                inside = self.atom()
                inside, by = (inside, self.atom()) if self.peek().text == "{" else (self.power(), inside)
                if by.written is None or order not in (1, 2):
                    raise Unread("a derivative by more than one symbol", token.start)
                for _ in range(int(order)):
                    inside = differentiated(inside, by, (token.start, self.peek(-1).end))
                return inside
            case "sum":
                return self.series()
        raise Unread(f"\\{token.text} stands where a quantity should", token.start)

    def series(self) -> Node:
        r"""The terms of \sum_{i=1}^{2}, written out."""
        start, scripts = self.take().start, {"_": "", "^": ""}
        while (mark := self.peek().kind) in scripts:
            scripts[mark] = self.script()
        bounds = re.fullmatch(r"([a-z])=(\d) (\d)", f"{scripts['_']} {scripts['^']}")
        if bounds is None or not 0 <= int(bounds[3]) - int(bounds[2]) < MOST_TERMS:
            raise Unread("a sum is read with small numbers as its bounds", start)
        body = self.product()
        terms = tuple(_numbered(body, bounds[1], str(i)) for i in range(int(bounds[2]), int(bounds[3]) + 1))
        return Node("sum", (start, body.outer[1]), (1,) * len(terms), terms, ((start, start),) * len(terms))

    def group(self, row: bool = True) -> Node:
        """What stands in brackets; with commas a column; in code also rows with ; and entries with a blank between."""
        opened, outer = self.take(), self.spaced
        self.spaced = row and opened.text == "[" and (outer or self.is_row())
        rows = [[self.sum()]]
        if self.took("over"):
            above, below = rows[0][0], self.sum()
            mark = (above.outer[0], above.outer[0])
            rows = [[Node("product", (mark[0], below.outer[1]), ("*", "/"), (above, below), (mark, mark))]]
        while self.peek().kind in (",", ";") or (self.spaced and not self.ends()):
            separator = self.take().kind if self.peek().kind in (",", ";") else ""
            if self.peek().kind == "close":
                break
            if separator == ";" and opened.text == "[":
                rows.append([])
            rows[-1].append(self.sum())
        blank, self.spaced, token = self.spaced, outer, self.peek()
        if token.kind != "close" or token.text != CLOSING[opened.text]:
            wrong = f"{opened.text} is closed by {token.text}"
            reason = wrong if token.kind == "close" else f"the bracket {opened.text} is not closed"
            raise Unread(reason, opened.start, CLOSING[opened.text])
        span = (opened.start, self.take().end)
        entries = [entry for row in rows for entry in row]
        if len(entries) == 1:
            return replace(entries[0], bracketed=span)
        if opened.text == "[" and {entry.kind for entry in entries} == {"matrix"}:  # [[a, b], [c, d]]
            rows = [[*entry.children] for entry in entries]
        elif len(rows) == 1 and not blank:
            rows = [[entry] for entry in entries]
        return _matrix(rows, span, span if blank else None)

    def is_row(self) -> bool:
        """Whether the bracket that is open holds entries with a blank between, as in MATLAB."""
        depth, semicolon = 1, False
        for token, following in zip(self.tokens[self.place :], self.tokens[self.place + 1 :], strict=False):
            depth += {"open": 1, "close": -1}.get(token.kind, 0)
            semicolon = semicolon or (token.kind == ";" and depth == 1)
            if depth == 0 or (token.kind == "," and depth == 1):
                return depth == 0 and not self.latex and (semicolon or self.starred or following.kind == "prime")
        return False

    def length(self) -> Node:
        """What stands between two |: the length of a vector."""
        opened = self.take()
        self.bars += 1
        inner = self.sum()
        self.bars -= 1
        if self.peek().kind != "|":
            raise Unread("the bracket | is not closed", opened.start)
        closed = self.take()
        if self.peek().kind == "_":
            self.script()
        return Node("function", (opened.start, closed.end), "norm", (inner,), ((opened.start, opened.end),))

    def matrix(self) -> Node:
        r"""The environment of a matrix, or \pmat{...}; an empty entry is 0."""
        token, opened = self.take(), self.take()
        name = self.plain() if token.text == "begin" and opened.kind == "open" else ""
        if token.text == "begin" and name not in MATRICES:
            raise Unread(f"\\begin{{{name}}} has no meaning in an equation here", token.start)
        if name == "array" and self.peek().kind == "open":
            self.take()
            self.plain()
        rows = [list[Node]()]
        while True:
            end = self.peek()
            if end.kind == "end":
                raise Unread("the matrix has no \\end", token.start)
            closes = end.text == "end" or end.kind == "close"
            if closes and not rows[-1]:
                break
            empty = closes or end.kind in ("&", "row")
            rows[-1].append(Node("number", (end.start, end.start), Fraction(0)) if empty else self.sum())
            end = self.peek()
            if end.kind in ("&", "row"):
                self.take()
                rows += [[]] if end.kind == "row" else []
            elif end.text == "end" or end.kind == "close":
                break
            else:
                raise Unread(f"{end.text!r} ends no entry of a matrix", end.start)
        if self.take().text == "end" and self.take().kind == "open":
            self.plain()
        node = _matrix([row for row in rows if row], (token.start, self.peek(-1).end))
        if name != "Vmatrix":
            return node
        if self.peek().kind == "_":
            self.script()
        inner = node.children[0] if node.value == (1, 1) else node
        return Node("function", node.span, "norm", (inner,), ((token.start, token.end),))


def _matrix(rows: list[list[Node]], span: Span, bracketed: Span | None = None) -> Node:
    if not rows or len({len(row) for row in rows}) > 1:
        raise Unread("the rows of the matrix have different lengths", span[0])
    entries = tuple(entry for row in rows for entry in row)
    return Node("matrix", span, (len(rows), len(rows[0])), entries, bracketed=bracketed)


def _numbered(node: Node, letter: str, number: str) -> Node:
    """A term of a sum, its running index a number."""
    children = tuple(_numbered(child, letter, number) for child in node.children)
    if node.written is None:
        return replace(node, children=children)
    if node.written == Written(letter):
        return Node("number", node.span, Fraction(number), bracketed=node.bracketed)
    index = re.sub(rf"(?:(?<![A-Za-z])|(?<=theta)|(?<=phi)){letter}(?![A-Za-z])", number, node.written.index)
    written = replace(node.written, index=index)
    return replace(node, written=written, value=unknown(written), children=children)


def _exponent(text: str, place: int) -> Fraction:
    """A small number, or a half."""
    text = re.sub(r"frac(\d)(\d)", r"\1/\2", text)
    if not re.fullmatch(r"[+-]?\d{1,9}(?:\.\d{1,3}|/[1-9])?", text):
        raise Unread("only numbers are read as exponents", place)
    value = Fraction(text)
    if abs(value) > MOST_POWER or value.denominator > 2:
        raise Unread(f"the exponent {value} is not from -{MOST_POWER} to {MOST_POWER}", place)
    return value
