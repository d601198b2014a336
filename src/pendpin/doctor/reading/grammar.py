"""Tokens to trees: sums, products with and without signs, powers, functions, derivatives, brackets, matrices.

Written by hand and not from a grammar's rules, because every part keeps its place in the text, so that a mend can be written
there, and because what is almost mathematics is refused with a reason and never read as something else.
"""

import re
from dataclasses import replace
from fractions import Fraction

from pendpin.doctor.reading.names import GREEK, Vocabulary, Written, bound, unknown
from pendpin.doctor.reading.symbols import CLOSING, OF_TIME, SymbolReader, symbol_of
from pendpin.doctor.reading.tokens import is_latex, lines, tokens
from pendpin.doctor.reading.tree import Node, Span, Unread

OPENING = {closed: opened for opened, closed in CLOSING.items()}
SEPARATORS = (",", ";", "row", ".", "&")
ENDS = {"close", "relation", "other relation", "condition", "end", *SEPARATORS}
MATRICES = {"bmatrix", "pmatrix", "matrix", "array", "smallmatrix", "Bmatrix", "Vmatrix"}
DERIVATIVES = ("der", "diff", "Derivative", "D")
POWERS = {"pow": 0, "power": 0, "square": 2}
LISTS = {"array", "Matrix", "matrix", "vector"}  # functions of code that only make a matrix of a list
OF_CODE = (*DERIVATIVES, "diag", *POWERS, *LISTS)
TIME = Written("t")
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


class Parser(SymbolReader):
    """One pass over the tokens of a text."""

    def at_end(self) -> bool:
        """Whether an expression ends before the next token; | ends one that a | has opened."""
        token = self.peek()
        closes = token.kind == "|" and self.bars > 0
        return token.kind in ENDS or closes or (token.kind == "command" and token.text in ("end", "over"))

    def at_new_entry(self) -> bool:
        """Whether the next token begins an entry of a row such as [a b -c]: after a blank that no sign has behind it."""
        token, before = self.peek(), self.peek(-1)
        if not self.spaced or token.start == before.end or before.kind == "operator":
            return False
        return token.kind != "operator" or (token.text in "+-" and self.peek(1).start == token.end)

    def equations(self) -> list[list[Node]]:
        """Lines, sides, and equations on one line with a comma between. Raises Unread."""
        found: list[list[Node]] = [[]]
        before = ""  # what stands before this place: nothing, a side, or =
        while (token := self.peek()).kind != "end":
            if token.kind in SEPARATORS:
                self.take()
                if before == "=" and token.kind not in ("&", "."):
                    raise Unread("the right side of = is empty", token.start)
                ends = self.peek().kind in ("end", "relation", *SEPARATORS)
                if token.kind not in ("&", ".") and not ends and found[-1]:
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
                raise Unread(f"the bracket {token.text} closes nothing", token.start, OPENING.get(token.text, ""))
            else:
                found[-1].append(self.sum())
                before = "side"
        if before == "=":
            raise Unread("the right side of = is empty", token.start)
        return [sides for sides in found if sides]

    def sum(self) -> Node:
        """Terms with their signs."""
        signs, terms, marks, start = [], [], [], self.peek().start
        while not terms or (self.at_sign() and not self.at_new_entry()):
            sign, first = 1, self.peek()
            end = first.start
            while self.at_sign():
                token = self.take()
                sign, end = (-sign if token.text == "-" else sign), token.end
            if self.at_end():
                raise Unread("a term is missing", end)
            terms.append(self.product())
            signs.append(sign)
            marks.append((first.start, end))
        if len(terms) == 1 and marks[0][0] == marks[0][1]:
            return terms[0]
        return Node("sum", (start, terms[-1].outer[1]), tuple(signs), tuple(terms), tuple(marks))

    def product(self) -> Node:
        """Factors, multiplied with or without a sign."""
        factors, operators, marks = [self.power()], ["*"], [(0, 0)]
        slash = False
        while not (self.at_end() or self.at_sign() or self.at_new_entry()):
            token, name = self.peek(), factors[-1]
            mark, operator = (token.start, token.start), "*"
            if token.kind == "operator":
                operator, mark = self.take().text, (token.start, token.end)
                if self.at_end():
                    raise Unread("a factor is missing", token.end)
            elif slash and self.tight and token.kind in ("letter", "word", "number"):
                operator = "/"
            elif token.kind == "open" and token.start == self.end and self._is_long(name):
                raise Unread(f"the function {name.value.lstrip('?')} is not known", name.span[0])
            factors.append(self.power())
            if mark[0] == mark[1] and self._is_long(name) and self._is_long(factors[-1]):
                both = " ".join(factor.value.lstrip("?") for factor in factors[-2:])
                raise Unread(f"{both}: words, or names without a sign between them", name.span[0])
            operators.append(operator)
            marks.append(mark)
            slash = operator == "/" and (token.kind == "operator" or slash)
        if len(factors) == 1:
            return factors[0]
        start = factors[0].outer[0]
        marks[0] = (start, start)
        return Node("product", (start, factors[-1].outer[1]), tuple(operators), tuple(factors), tuple(marks))

    def _is_long(self, node: Node) -> bool:
        """Whether a factor is a name of several letters, such as zeros: before a bracket a function of code."""
        if self.latex or node.written is None or node.bracketed or node.written.dots:
            return False
        return len(node.written.letter) > 1 and node.written.letter not in {*GREEK.values(), "const"}

    def power(self) -> Node:
        """A factor with its exponents, or what is transposed; a letter after ^ belongs to the name before it."""
        base = self.atom()
        while base.bracketed is not None and self.peek().kind == "prime":
            token = self.take()
            if base.kind == "matrix" and not self.latex:
                base = Node("function", (base.outer[0], token.end), "transpose", (base,), ((token.start, token.end),))
            else:
                for _ in token.text:
                    base = Node("derivative", (base.outer[0], token.end), "t", (base,))
        while self.peek().kind in ("^", "superscript"):
            start, above = self.peek().start, self.script()
            end = self.end
            if above in ("T", "top", "intercal"):
                if base.kind == "product" and {*base.value} == {"*"} and self.latex:  # entries with blanks between
                    base = Node("matrix", base.outer, (1, len(base.children)), base.children)
                base = Node("function", (base.outer[0], end), "transpose", (base,), ((end, end),))
                continue
            if base.written is not None and base.kind == "symbol":
                below = self.script() if self.peek().kind == "_" else ""
                index = ",".join(filter(None, (base.written.index, below)))
                if re.fullmatch(r"[A-Za-z]+|\*", above):
                    written = replace(base.written, index=f"{index},{above}" if index else above)
                    base = symbol_of(written, (base.span[0], self.end))
                    continue
                base = symbol_of(replace(base.written, index=index), base.span) if below else base
            exponent = _exponent(above, start)
            if base.value == "norm" and exponent == 2:
                base = replace(base.children[0], bracketed=base.span)
            mark = (start, self.end)
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
            case "word" if self.peek(1).kind == "open" and token.text in OF_CODE:
                return self.function_of_code()
        if self.at_symbol():
            return self.symbol()
        if token.kind != "open":
            wrong = "it ends too early" if token.kind == "end" else f"{token.text!r} stands where a quantity should"
            raise Unread(wrong, token.start)
        group = self.group()
        if token.text == "{" and group.kind == "symbol" and group.written and self.peek().kind == "_":
            written = replace(group.written, index=group.written.index + self.script())  # as in {\bf q}_1
            return symbol_of(written, (token.start, self.end))
        return group

    # --- derivatives, functions and commands --------------------------------------------------------------------

    def derivative(self) -> Node | None:
        r"""A derivative in time or a partial one: \frac{d}{dt}, dD/d phi, d(...)/dt; None where there is none."""
        place, start = self.place, self.peek().start
        fraction = self.took("frac")
        above = self.differential(fraction)
        start_below = self.place
        below = self.differential(fraction) if above and (fraction or self.took("/")) else None
        if fraction and above and below is None and self.tokens[start_below : start_below + 2][-1].text == above[0]:
            raise Unread("a derivative that is not read", start)
        if above and below and above[0] == below[0] and (by := below[1]):
            inside, order = above[1:]
            if fraction or inside or by.written == TIME:
                if by.written is None or order != below[2]:
                    raise Unread("a derivative that is not read", start)
                inside = inside or self.power()
                return differentiated(inside, by, order, (start, self.end))
        self.place = place
        return None

    def differential(self, braced: bool) -> tuple[str, Node | None, int] | None:
        """d or the sign of partial derivatives, what it is put before, and the order; None for anything else."""
        if (braced and not self.took("{")) or self.peek().text not in ("d", "partial"):
            return None
        sign, inside = self.take().text, None
        order = self.order()
        if self.at_symbol():
            inside = self.symbol()
        elif self.peek().kind == "open":
            inside = self.group()
        order = max(order, self.order())
        return None if braced and not self.took("}") else (sign, inside, order)

    def order(self) -> int:
        """The number after ^, and past it; 1 where there is none."""
        text = self.script() if self.peek().kind in ("^", "superscript") else "1"
        return int(text) if re.fullmatch("[1-9]", text) else 1

    def function(self) -> Node:
        """A function of what is in brackets or, as in sin 2 phi, of a number and a symbol."""
        token = self.take()
        name, caret = token.text, self.peek()
        exponent = _exponent(self.script(), caret.start) if caret.kind in ("^", "superscript") else None
        mark, first = (caret.start, self.end), self.peek()
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
            marks = tuple((factor.span[0], factor.span[0]) for factor in factors)
            span = (first.start, factors[-1].outer[1])
            argument = Node("product", span, ("*",) * len(factors), tuple(factors), marks)
            argument = argument if len(factors) > 1 else factors[0]
        node = Node("function", (token.start, argument.outer[1]), name, (argument,), ((token.start, token.end),))
        return node if exponent is None else Node("power", node.span, exponent, (node,), (mark,))

    def function_of_code(self) -> Node:
        """der(x), diff(x, t), pow(x, 2), diag(a, b, c), array([...])."""
        token, inner = self.take(), self.group(row=False)
        name, start, span = token.text, token.start, (token.start, self.end)
        parts: tuple[Node, ...] = inner.children if inner.kind == "matrix" else (inner,)
        inside = parts[0]
        if name in LISTS:
            return replace(inner, bracketed=span)
        if name == "diag":
            zero = Node("number", (start, start), Fraction(0))
            return _matrix(
                [[part if i == j else zero for j in range(len(parts))] for i, part in enumerate(parts)], span
            )
        if name in POWERS:
            power = parts[1].value if len(parts) == 2 and parts[1].kind == "number" else POWERS[name]
            if power not in range(1, MOST_POWER + 1) or len(parts) > 2:
                raise Unread("only small numbers are read as exponents", start)
            mark = parts[-1].outer if len(parts) == 2 else (start, token.end)
            return Node("power", span, Fraction(power), (inside,), (mark,))
        if name in ("diff", "Derivative") and len(parts) == 1:
            raise Unread(f"{name} without a symbol to differentiate by", start)
        for by in parts[1:] or (symbol_of(TIME, (span[1] - 1, span[1] - 1)),):
            by, *count = by.children if by.kind == "matrix" else (by,)  # Derivative(x, (t, 2))
            order = count[0].value if count and count[0].kind == "number" else 1
            if by.written is None or order not in (1, 2):
                raise Unread(f"{name} is read of an expression and symbols", start)
            inside = differentiated(inside, by, int(order), span)
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
                return differentiated(inside, by, int(order), (token.start, self.end))
            case "sum":  # with small numbers as its bounds, written out
                start, scripts = self.take().start, {"_": "", "^": ""}
                while (mark := self.peek().kind) in scripts:
                    scripts[mark] = self.script()
                bounds = re.fullmatch(r"([a-z])=(\d) (\d)", f"{scripts['_']} {scripts['^']}")
                if bounds is None or not 0 <= int(bounds[3]) - int(bounds[2]) < MOST_TERMS:
                    raise Unread("a sum is read with small numbers as its bounds", start)
                body, numbers = self.product(), range(int(bounds[2]), int(bounds[3]) + 1)
                terms = tuple(_numbered(body, bounds[1], str(i)) for i in numbers)
                marks = ((start, start),) * len(terms)
                return Node("sum", (start, body.outer[1]), (1,) * len(terms), terms, marks)
        raise Unread(f"\\{token.text} stands where a quantity should", token.start)

    # --- brackets and matrices ----------------------------------------------------------------------------------

    def group(self, row: bool = True) -> Node:
        """What stands in brackets; with commas a column; in code also rows with ; and entries with a blank between."""
        opened, outer = self.take(), self.spaced
        self.spaced = row and opened.text == "[" and (outer or self._is_row())
        rows = [[self.sum()]]
        if self.took("over"):
            above, below = rows[0][0], self.sum()
            mark = (above.outer[0], above.outer[0])
            rows = [[Node("product", (mark[0], below.outer[1]), ("*", "/"), (above, below), (mark, mark))]]
        while self.peek().kind in (",", ";") or (self.spaced and not self.at_end()):
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

    def _is_row(self) -> bool:
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
        node = _matrix([row for row in rows if row], (token.start, self.end))
        if name != "Vmatrix":
            return node
        if self.peek().kind == "_":
            self.script()
        inner = node.children[0] if node.value == (1, 1) else node
        return Node("function", node.span, "norm", (inner,), ((token.start, token.end),))


def differentiated(node: Node, by: Node, order: int, span: Span) -> Node:
    """The derivative of a node; a symbol's rate is a symbol. `written` is what it is derived by."""
    for _ in range(order):
        if by.written == TIME and node.written is not None and node.kind == "symbol":
            node = symbol_of(replace(node.written, dots=node.written.dots + 1), span)
        else:
            node = Node("derivative", span, by.value, (node,), (by.span,), written=by.written)
    return node


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
