"""Tokens to trees: sums, products, powers, functions, derivatives, brackets, matrices.

By hand and not from a grammar's rules: every part keeps its place in the text, for mends, and what is almost mathematics is
refused with a reason.
"""

import re
from dataclasses import replace
from fractions import Fraction
from functools import partial

from pendpin.doctor.reading.names import GREEK, Vocabulary, Written, bound, of_word
from pendpin.doctor.reading.tokens import (
    ACCENTS,
    AS_GIVEN,
    CALLED,
    CLOSING,
    DERIVATIVES,
    INVERSES,
    MATRICES,
    POWERS,
    PRODUCTS,
    SEPARATORS,
    Token,
    cut,
    is_latex,
    tokens,
)
from pendpin.doctor.reading.tree import TIME, Node, Unread, differentiate, divide, matrix_of, rename, symbol_node

OPENING = {")": "(", "]": "[", "}": "{", r"\}": r"\{"}
ENDS = {"close", "relation", "other relation", "condition", "over", "end", "blank", *SEPARATORS}
FRAMES, TRANSPOSED = set("ABINOWG"), {"T", "top", "intercal"}
MOST_DIGITS, MOST_POWER = 30, 12
MOST_TERMS = 6  # of a sum with bounds


def parse(text: str, words: Vocabulary | None = None, *, tight: bool = False) -> list[list[Node]]:
    """The equations of a text, each a list of sides that are equal; `tight` reads 3g/2l as 3g/(2l). Raises Unread.

    Its names mean nothing yet, unless some `words` are given.
    """
    try:
        pieces = list[list[Token]]()
        for piece in cut(tokens(text)):  # with the rows that a chain goes on in
            if pieces and piece[0].kind == "relation":
                pieces[-1] += piece
            else:
                pieces.append(piece)
        equations = [_Parser(piece, is_latex(text), tight, text).sides() for piece in pieces]
    except RecursionError:
        raise Unread("nested too deeply") from None
    return [[bound(side, words) for side in sides] for sides in equations] if words else equations


def lone(text: str, words: Vocabulary) -> Node | None:
    """The one expression that a text is; None for an equation or several. Raises Unread."""
    found = parse(text, words)
    return found[0][0] if [len(sides) for sides in found] == [1] else None


class _Parser:
    """A cursor over the tokens of one equation."""

    def __init__(self, found: list[Token], latex: bool, tight: bool, text: str = "") -> None:
        end = found[-1].end if found else 0
        self.tokens, self.latex, self.tight = [*found, Token("end", "the end", end, end)], latex, tight
        self.text = text
        self.place, self.bars = 0, 0  # of |, how many are open

    def peek(self, ahead: int = 0) -> Token:
        """The token some places ahead; behind the last one, the end."""
        return self.tokens[max(0, min(self.place + ahead, len(self.tokens) - 1))]

    def take(self) -> Token:
        """The next token, and past it; the end is never passed."""
        token = self.peek()
        self.place = min(self.place + 1, len(self.tokens) - 1)
        return token

    def took(self, *texts: str) -> bool:
        """Whether these tokens come next, and past them."""
        found = [self.peek(i).text for i in range(len(texts)) if self.peek(i).kind not in ("_", "^")] == [*texts]
        self.place += len(texts) if found else 0
        return found

    def took_time(self) -> bool:
        """Whether a dependence on time, (t), comes next, and past it."""
        return self.took("(", "t", ")") or self.took("{", "(", "t", ")", "}") or self.took("[", "t", "]")

    def at_sign(self) -> bool:
        """Whether a plus or minus comes next."""
        return self.peek().kind == "operator" and self.peek().text in "+-"

    def at_symbol(self) -> bool:
        """Whether a printed name begins here; it may begin with frames, as in {}^I C^A."""
        framed = [self.peek(i).text for i in (0, 1)] == ["{", "}"] and self.peek(2).kind == "^"
        return framed or self.peek().kind in ("letter", "word", "accent", "style")

    def at_end(self) -> bool:
        """Whether nothing more belongs to the term: the text, a bracket or a pair of bars ends."""
        return self.peek().kind in ENDS or (self.peek().kind == "|" and self.bars > 0)

    def sides(self) -> list[Node]:
        """What stands on the sides of each =. Raises Unread."""
        if strange := next((token for token in self.tokens if token.kind == "strange"), None):
            raise Unread(strange.text, strange.start, "}" if "is not closed" in strange.text else "")
        found = list[Node]()
        while True:
            token = self.peek()
            if token.kind in ("relation", "end", "condition"):
                side = "left" if token.kind == "relation" and not found else "right"
                raise Unread(f"the {side} side of = is empty", token.start)
            if token.kind not in ("close", "other relation", *SEPARATORS):
                found.append(self.sum())
            token = self.take()
            rounded = token.text == "≈" and len(found) > 1  # behind a chain
            if rounded or token.kind == "end" or (token.kind == "condition" and self.peek().kind == "end"):
                exact = [side for side in found if side.kind != "number" or "." not in self.text[slice(*side.span)]]
                return exact if len(exact) > 1 else found  # omega = v/l = 1.2 gives a value beside
            if token.kind != "relation":
                wrong = {
                    "condition": f"an equation that holds only {token.text} is not checked",
                    ",": "it gives values to several names at once: write an equation for each",
                    "relation": f"not an equation: it holds the relation {token.text}",
                }.get(token.kind.split(" ")[-1], f"the bracket {token.text} closes nothing")
                raise Unread(wrong, token.start, OPENING.get(token.text, ""))

    def sum(self) -> Node:
        """Terms with their signs. Raises Unread where one is missing."""
        signs, terms, marks, start = [], [], [], self.peek().start
        while not terms or self.at_sign():
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
        factors, operators, marks, slash = [self.power()], ["*"], [(0, 0)], False
        while not (self.at_end() or self.at_sign()):
            token, name = self.peek(), factors[-1]
            mark, operator = (token.start, token.start), "*"
            if token.kind == "operator":
                operator, mark = self.take().text, (token.start, token.end)
                if self.at_end():
                    raise Unread("a factor is missing", token.end)
            elif slash and self.tight and token.kind in ("letter", "word", "number"):
                operator = "/"
            elif token.kind == "open" and token.start == self.peek(-1).end and self._is_long(name):
                raise Unread(f"the function {name.value.lstrip('?')} is not known", name.span[0])
            if operator == "∖":  # A\b
                factors[-1], operator = Node("power", name.outer, Fraction(-1), (name,), (mark,)), "*"
            factors.append(self.power())
            if mark[0] == mark[1] and self._is_long(name) and self._is_long(factors[-1]):
                both = " ".join(factor.value.lstrip("?") for factor in factors[-2:])
                raise Unread(f"{both}: words, or names without a sign between them", name.span[0])
            operators.append(operator)
            marks.append(mark)
            slash = operator == "/" and (token.kind == "operator" or slash)
        if len(factors) == 1:
            return factors[0]
        span = (factors[0].outer[0], factors[-1].outer[1])
        marks[0] = (span[0], span[0])
        return Node("product", span, tuple(operators), tuple(factors), tuple(marks))

    def _is_long(self, node: Node) -> bool:
        """Whether a factor is a name of several letters, such as zeros: before a bracket a function of code."""
        if self.latex or node.written is None or node.bracketed or node.written.dots:
            return False
        return len(node.written.letter) > 1 and node.written.letter not in {*GREEK.values(), "const"}

    def power(self) -> Node:
        """A factor with its exponents, or what is transposed."""
        base = self.atom()
        while base.bracketed is not None and self.peek().kind == "prime":
            token = self.take()
            if base.kind == "matrix" and not self.latex:
                base = Node("function", (base.outer[0], token.end), "transpose", (base,), ((token.start, token.end),))
            else:
                for _ in token.text:
                    base = Node("derivative", (base.outer[0], token.end), "t", (base,))
        while self.peek().kind == "^":
            token = self.take()
            if token.text in TRANSPOSED:
                base = Node("function", (base.outer[0], token.end), "transpose", (base,), ((token.end, token.end),))
                continue
            if base.written == Written("e") and not re.fullmatch(r"[+-]?[\d.]+", token.text):
                base = self.exponential(base, token)
                continue
            exponent = exponent_of(token)
            if base.value == "norm" and exponent == 2:
                base = replace(base.children[0], bracketed=base.span)
            end = self.peek(-1).end
            base = Node("power", (base.outer[0], end), exponent, (base,), ((token.start, end),))
            self.took_time()
        return base

    def exponential(self, base: Node, token: Token) -> Node:
        """e with its exponent, which is an expression."""
        exponent = re.sub(r"\A\s*(?:\^|\*\*)\s*", lambda mark: " " * len(mark[0]), self.text[token.start : token.end])
        parser = _Parser(tokens(" " * token.start + exponent), self.latex, self.tight, self.text)
        inner = parser.sum()
        if parser.peek().kind != "end":
            raise Unread("an exponent that is not read", token.start)
        return Node("function", (base.span[0], token.end), "exp", (inner,), (base.span,))

    def atom(self) -> Node:
        """A number, symbol, function, fraction, bracket or matrix."""
        token = self.peek()
        if token.text in ("d", "partial", "frac") and token.kind not in ("^", "_") and (node := self.derivative()):
            return node
        if self.at_sign():  # m*g*-cos(theta)
            self.take()
            inner, sign = self.power(), -1 if token.text == "-" else 1
            return Node("sum", (token.start, inner.outer[1]), (sign,), (inner,), ((token.start, token.end),))
        match token.kind:
            case "number":
                self.take()
                if len(token.text) > MOST_DIGITS:
                    raise Unread(f"a number of {len(token.text)} digits", token.start)
                return Node("number", (token.start, token.end), Fraction(token.text))
            case "function":
                return self.function()
            case "command":
                return self.command()
            case "|":
                return self.length()
            case "word" if self.peek(1).kind == "open" and token.text in {"der", "D", *CALLED}:
                return self.function_of_code()
        if self.at_symbol():
            return self.symbol()
        if token.kind != "open":
            self.take()
            wrong = "it ends too early" if token.kind == "end" else f"{token.text!r} stands where a quantity should"
            raise Unread(wrong, token.start)
        group = self.group()
        if token.text != "{" or group.kind != "symbol" or group.written is None:
            return group
        place, node = self.place, self.marked(group.written, token.start)  # as in {\bf q}_1
        return node if self.place > place else group

    def symbol(self) -> Node:
        """One quantity, of which is known only how it is written: accents, hats, indices, primes, frames."""
        start = self.peek().start
        before = self.take().text if self.took("{", "}") else ""
        token = self.take()
        if token.kind in ("accent", "style") or (token.text == "dot" and self.peek().kind in ("letter", "word")):
            opened, braces = self.peek(), 0
            while self.peek().kind == "open" and token.kind != "word" and self.peek(1).kind != "close":
                self.take()
                braces += 1
            written = self.symbol().written or TIME
            if not all(self.take().kind == "close" for _ in range(braces)):
                raise Unread(f"\\{token.text} over more than one symbol", opened.start)
            dots = written.dots + ACCENTS.get(token.text, 0)
            written = replace(written, dots=dots, styled=written.styled or token.kind == "style")
            if token.text in ("hat", "widehat") and written.letter in ("r", "theta", "phi"):  # unlike r in bold type
                written = replace(written, letter=f"{written.letter}hat")
        elif token.kind in ("word", "letter"):
            written = (of_word(token.text) if token.kind == "word" else None) or Written(token.text)
            if token.text == "Delta" and self.peek().text in ("theta", "phi", "alpha", "t"):  # a difference is one name
                written = Written(f"Delta{self.take().text}")
        else:
            raise Unread(f"{token.text!r} is not a symbol", token.start)
        return self.marked(written, start, before)

    def marked(self, written: Written, start: int, before: str = "") -> Node:
        """A name with what stands behind it: dots, primes, indices, frames; a letter after ^ belongs to it."""
        while True:
            mark, last = self.peek(), self.peek(-1)
            adjoins = last.kind == "letter" and last.end == mark.start and not self.latex  # as in θ1
            if mark.kind == "dots":
                dots = written.dots + ACCENTS.get(mark.text, 0)
                written = replace(written, dots=dots, styled=written.styled or mark.text == "hat")
            elif mark.kind == "prime":
                written = replace(written, dots=written.dots + len(mark.text))
            elif mark.kind == "^" and mark.text in FRAMES:
                written = replace(written, frames=before + mark.text if before and written.letter == "C" else "")
            elif mark.kind == "^" and mark.text not in TRANSPOSED and re.fullmatch(r"[A-Za-z]+(?:_?\d)?|\*", mark.text):
                written = replace(written, index=",".join(filter(None, (written.index, mark.text))))
            elif mark.kind == "_" or (mark.kind == "number" and adjoins) or mark.text in ("uparrow", "downarrow"):
                written = replace(written, index=written.index + mark.text)
            else:
                break
            self.take()
        self.took_time()
        return symbol_node(written, (start, self.peek(-1).end))

    def derivative(self) -> Node | None:
        r"""A derivative in time or a partial one: \frac{d}{dt}, dD/d phi, d(...)/dt; None where there is none."""
        place, start = self.place, self.peek().start
        fraction = self.took("frac")
        above, start_below = self.differential(fraction), self.place
        below = self.differential(fraction) if above and (fraction or self.took("/")) else None
        if fraction and above and below is None and self.tokens[start_below : start_below + 2][-1].text == above[0]:
            raise Unread("a derivative that is not read", start)
        if above and below and above[0] == below[0] and (by := below[1]):
            inside, order = above[1:]
            if fraction or inside or by.written == TIME:
                if by.written is None or order != below[2]:
                    raise Unread("a derivative that is not read", start)
                inside = inside or self.power()
                return differentiate(inside, by, order, (start, self.peek(-1).end))
        self.place = place
        return None

    def differential(self, braced: bool) -> tuple[str, Node | None, int] | None:
        """d or the sign of partial derivatives, what it is put before, and the order; None for anything else."""
        if self.peek(braced and self.peek().text == "{").text not in ("d", "partial"):
            return None
        if braced and not self.took("{"):  # \frac d{dt}
            return (self.take().text, None, 1)
        sign, order, inside = self.take().text, 1, None
        for _ in range(2):
            if self.peek().kind == "^" and re.fullmatch("[1-9]", self.peek().text):
                order = int(self.take().text)
            if inside is None and (self.at_symbol() or self.peek().kind == "open"):
                inside = self.symbol() if self.at_symbol() else self.group()
        return None if braced and not self.took("}") else (sign, inside, order)

    def function(self) -> Node:
        """A function of what is in brackets or, as in sin 2 phi, of a number and a symbol."""
        token, caret = self.take(), self.peek()
        exponent = exponent_of(self.take()) if caret.kind == "^" else None
        first = self.peek()
        if exponent and exponent < 0:
            raise Unread(f"{token.text}^-1 may be the inverse function or 1/{token.text}: write which", token.start)
        if token.text == "sqrt" and first.text == "[" and self.latex:
            raise Unread("only square roots are read", token.start)
        if first.kind == "open" and not self.at_symbol():
            argument = self.group()
        else:
            factors = [self.atom()] if first.kind == "number" else []
            if self.peek().kind == "command" or self.at_symbol():
                factors.append(self.atom())
            if not factors:
                raise Unread(f"{token.text} of nothing", first.start)
            if self.peek()[:2] == ("letter", "t") and factors[-1].kind == "symbol":  # cos omega t
                factors.append(self.symbol())
            marks = tuple((factor.span[0], factor.span[0]) for factor in factors)
            span = (first.start, factors[-1].outer[1])
            argument = Node("product", span, ("*",) * len(factors), tuple(factors), marks)
            argument = argument if len(factors) > 1 else factors[0]
        node = Node("function", (token.start, argument.outer[1]), token.text, (argument,), ((token.start, token.end),))
        return node if exponent is None else Node("power", node.span, exponent, (node,), ((caret.start, caret.end),))

    def function_of_code(self) -> Node:
        """der(x), diff(x, t), pow(x, 2), diag(a, b, c), array([...])."""
        token, inner = self.take(), self.group()
        name, start, span = token.text, token.start, (token.start, self.peek(-1).end)
        parts = inner.children if inner.kind == "matrix" else (inner,)
        inside = parts[0]
        if name in AS_GIVEN:
            return replace(inner, bracketed=span)
        if name == "Rational" and len(parts) <= 2:
            return divide(inside, parts[1], span, start, fraction=False) if len(parts) == 2 else inside
        if name in INVERSES and len(parts) <= 2:
            return Node("power", span, Fraction(-1), (inner,), ((start, token.end),))
        if name in PRODUCTS and len(parts) == 2:
            first = inside
            if name == "solve":
                first = Node("power", inside.span, Fraction(-1), (inside,), ((start, start),))
            return Node("product", span, ("*", PRODUCTS[name]), (first, parts[1]), ((start, start),) * 2)
        if name in POWERS:
            power = parts[1].value if len(parts) == 2 and parts[1].kind == "number" else POWERS[name]
            if power not in range(1, 13) or len(parts) > 2:
                raise Unread("only small numbers are read as exponents", start)
            mark = parts[-1].outer if len(parts) == 2 else (start, token.end)
            return Node("power", span, Fraction(power), (inside,), (mark,))
        if name in DERIVATIVES and len(parts) == 1:
            raise Unread(f"{name} without a symbol to differentiate by", start)
        if len(parts) == 3 and parts[2].kind == "number":  # diff(x, t, 2)
            parts = (inside, matrix_of([[*parts[1:]]], span))
        for by in parts[1:] or (symbol_node(TIME, (span[1] - 1, span[1] - 1)),):
            by, *count = by.children if by.kind == "matrix" else (by,)  # Derivative(x, (t, 2))
            inside = differentiate(inside, by, count[0].value if count else 1, span)
        return inside

    def command(self) -> Node:
        r"""\frac, \underbrace, \dv, \det and \sum."""
        token = self.take()
        start = token.start
        match token.text:
            case "frac":
                above, below = self.atom(), self.atom()
                return divide(above, below, (start, below.outer[1]), start)
            case "underbrace" | "overbrace":  # without its label
                node = self.group() if self.peek().kind == "open" else self.atom()
                if self.peek().kind in ("_", "^"):
                    self.take()
                return node
            case "dv":  # of LaTeX's physics: \dv[2]{x}{t}, \dv{t} before what is derived, \pdv{L}{x}
                order = self.group() if self.peek().text == "[" else Node("number", (start, start), Fraction(1))
                first = self.atom()
                inside, by = (first, self.atom()) if self.peek().text == "{" else (self.power(), first)
                return differentiate(inside, by, order.value, (start, self.peek(-1).end))
            case "det":
                inner = self.atom()
                return Node("function", (start, inner.outer[1]), "det", (inner,), ((start, token.end),))
            case "sum":  # with small numbers as its bounds, written out
                scripts = {"_": "", "^": ""}
                while (mark := self.peek().kind) in scripts:
                    scripts[mark] = self.take().text
                bounds = re.fullmatch(r"([a-z])=(\d) (\d)", f"{scripts['_']} {scripts['^']}")
                if bounds is None or not 0 <= int(bounds[3]) - int(bounds[2]) < MOST_TERMS:
                    raise Unread("a sum is read with small numbers as its bounds", start)
                body, numbers = self.product(), range(int(bounds[2]), int(bounds[3]) + 1)
                running = rf"(?:(?<![A-Za-z])|(?<=theta)|(?<=phi)){bounds[1]}(?![A-Za-z])"
                numbered = lambda one, i: replace(one, index=re.sub(running, str(i), one.index))  # noqa: E731
                terms = tuple(rename(body, partial(numbered, i=i)) for i in numbers)
                return Node("sum", (start, body.outer[1]), (1,) * len(terms), terms, ((start, start),) * len(terms))
        raise Unread(f"\\{token.text} stands where a quantity should", start)

    def group(self) -> Node:
        r"""What stands in brackets; with commas a column; of a matrix rows with ; or \\, entries with &, 0 where empty."""
        opened, rows, blanks = self.take(), [list[Node]()], False
        is_matrix = opened.text in MATRICES
        while (token := self.peek()).kind != "close":
            if is_matrix and token.kind in ("&", "row"):
                rows[-1].append(Node("number", (token.start, token.start), Fraction(0)))
            else:
                rows[-1].append(self.sum())
            token = self.peek()
            if self.took("over"):
                above, below = rows[-1].pop(), self.sum()
                span = (above.outer[0], below.outer[1])
                rows[-1].append(divide(above, below, span, span[0], fraction=False))
            elif token.kind in (",", ";", "&", "row", "blank"):
                self.take()
                blanks |= token.kind == "blank"
                if token.kind == "row" or (token.kind == ";" and opened.text == "["):
                    rows.append([])
            else:
                break
        token = self.peek()
        if token.kind != "close" or token.text != CLOSING[opened.text]:
            wrong = f"{opened.text} is closed by {token.text}"
            reason = wrong if token.kind == "close" else f"the bracket {opened.text} is not closed"
            raise Unread(reason, opened.start, CLOSING[opened.text])
        span = (opened.start, self.take().end)
        rows = [row for row in rows if row]
        entries = [entry for row in rows for entry in row]
        if not entries:
            raise Unread(f"{token.text!r} stands where a quantity should", token.start)
        if is_matrix:
            return matrix_of(rows, span)
        if len(entries) == 1:
            return replace(entries[0], bracketed=span)
        if opened.text == "[" and {entry.kind for entry in entries} == {"matrix"}:  # [[a, b], [c, d]]
            rows = [[*entry.children] for entry in entries]
        elif len(rows) == 1 and not blanks:
            rows = [[entry] for entry in entries]
        return replace(matrix_of(rows, span), bracketed=span)

    def length(self) -> Node:
        """What stands between two |: the length of a vector."""
        opened = self.take()
        self.bars += 1
        inner = self.sum()
        self.bars -= 1
        closed = self.take()
        if closed.kind != "|":
            raise Unread("the bracket | is not closed", opened.start)
        if self.peek().kind == "_":  # which norm it is
            self.take()
        return Node("function", (opened.start, closed.end), "norm", (inner,), ((opened.start, opened.end),))


def exponent_of(token: Token) -> Fraction:
    """A small number, or a half."""
    text = re.sub(r"frac(\d)(\d)", r"\1/\2", token.text)
    if not re.fullmatch(r"[+-]?\d{1,9}(?:\.\d{1,3}|/[1-9])?", text):
        raise Unread("only numbers are read as exponents", token.start)
    value = Fraction(text)
    if abs(value) > MOST_POWER or value.denominator > 2:
        raise Unread(f"the exponent {value} is not from -{MOST_POWER} to {MOST_POWER}", token.start)
    return value
