"""Printed names and derivatives: accents, hats, bold type, indices, primes, frames in front and behind, d/dt."""

import re
from abc import ABC, abstractmethod
from dataclasses import replace

from pendpin.doctor.reading.names import Written, of_word, unknown
from pendpin.doctor.reading.tokens import ACCENTS, Token
from pendpin.doctor.reading.tree import Node, Span, Unread

CLOSING = {"(": ")", "[": "]", "{": "}", "\\{": "\\}"}
FRAMES = set("ABINOWG")
OF_TIME = (["(", "t", ")"], ["{", "(", "t", ")", "}"], ["[", "t", "]"])


class PrintedNames(ABC):
    """A cursor over tokens that reads names, and derivatives of what the grammar reads."""

    def __init__(self, found: list[Token], latex: bool, tight: bool) -> None:
        end = found[-1].end if found else 0
        self.tokens, self.latex, self.tight = [*found, Token("end", "the end", end, end)], latex, tight
        self.starred = any(token.text == "*" for token in found)  # products have a sign
        self.place, self.bars, self.spaced = 0, 0, False

    @abstractmethod
    def power(self) -> Node:
        """A factor with its exponents: the grammar's."""

    @abstractmethod
    def group(self, row: bool = True) -> Node:
        """What stands in brackets: the grammar's."""

    def peek(self, ahead: int = 0) -> Token:
        """The token this number of places ahead."""
        return self.tokens[max(0, min(self.place + ahead, len(self.tokens) - 1))]

    def take(self) -> Token:
        """The next token, and past it."""
        token = self.peek()
        self.place = min(self.place + 1, len(self.tokens) - 1)
        return token

    def took(self, *texts: str) -> bool:
        """Whether these tokens come next, and past them."""
        found = [self.peek(i).text for i in range(len(texts))] == [*texts]
        self.place += len(texts) if found else 0
        return found

    def plain(self) -> str:
        """The text in the bracket that is open, past its end; of brackets in it what is inside."""
        letters, depth, opened = [], 1, self.peek(-1)
        while depth:
            token = self.take()
            if token.kind == "end":
                raise Unread(f"the bracket {opened.text} is not closed", opened.start, CLOSING.get(opened.text, ""))
            depth += {"open": 1, "close": -1}.get(token.kind, 0)
            if token.kind not in ("open", "close", "plain", "style"):
                letters.append(token.text)
        return "".join(letters)

    def digit(self) -> None:
        r"""LaTeX takes one digit where there are no braces, as in \frac12 and x^23."""
        token = self.peek()
        if self.latex and token.kind == "number" and len(token.text) > 1 and token.text.isdigit():
            first = Token("number", token.text[0], token.start, token.start + 1)
            rest = Token("number", token.text[1:], token.start + 1, token.end)
            self.tokens[self.place : self.place + 1] = [first, rest]

    def script(self) -> str:
        """What stands after the ^ or _ that comes next, without blanks and brackets; a number has its sign."""
        mark = self.take()
        if mark.kind == "superscript":
            return mark.text
        sign = self.take().text if self.peek().kind == "operator" and self.peek().text in "+-" else ""
        self.digit()
        one = self.take()
        if one.kind in ("plain", "style"):
            one = self.take()
        text = sign + (self.plain() if one.kind == "open" else one.text)
        return "G/O" if text == "G" and mark.kind == "_" and self.took("/", "O") else text

    def at_symbol(self) -> bool:
        """Whether a printed name begins here; it may begin with frames, as in {}^I C^A."""
        token = self.peek()
        if token.text == "{":
            return self.peek(1).kind == "close" and self.peek(2).kind == "^"
        return token.kind in ("letter", "word", "accent", "style", "plain")

    def symbol(self) -> Node:
        """One quantity, of which is known only how it is written."""
        start, before = self.peek().start, ""
        if self.peek().kind == "open":
            self.place += 2
            before = self.script()
        written = self.written()
        framed = self.peek(2 if self.peek(1).kind == "open" else 1)
        if self.peek().kind == "^" and framed.kind == "letter" and framed.text in FRAMES:
            frames = before + self.script() if before and written.letter == "C" else self.script() and ""
            written = replace(written, frames=frames)
        while self.peek().kind == "prime":
            written = replace(written, dots=written.dots + len(self.take().text))
        if self.peek().kind == "_" and not written.index:
            written = replace(written, index=self.script())
        if self.peek().kind == "^" and self.peek(1).kind == "arrow":
            written = replace(written, index=written.index + self.script())
        any(self.took(*argument) for argument in OF_TIME)
        if written.letter == "sum" and written.index:
            raise Unread("a sum is read with small numbers as its bounds", start)
        return symbol_of(written, (start, self.peek(-1).end))

    def written(self) -> Written:
        """A letter with what is above, below and around it."""
        token = self.take()
        if token.kind in ("accent", "style", "plain"):
            written = self.decorated(token)
        elif token.text == "dot" and self.peek().kind in ("letter", "word"):  # dot theta
            written = self.written()
            return replace(written, dots=written.dots + 1)
        elif token.kind in ("word", "letter"):
            written = (of_word(token.text) if token.kind == "word" else None) or Written(token.text)
        else:
            raise Unread(f"{token.text!r} is not a symbol", token.start)
        while self.peek().kind == "dots":
            written = replace(written, dots=written.dots + ACCENTS[self.take().text])
        number = self.peek()
        if not self.latex and token.kind == "letter" and number.kind == "number" and number.start == token.end:
            written = replace(written, index=self.take().text)  # as in θ1
        while self.peek().kind == "index":
            written = replace(written, index=written.index + self.take().text)
        return replace(written, index=self.script()) if self.peek().kind == "_" else written

    def decorated(self, token: Token) -> Written:
        """The symbol under an accent, or in another type."""
        opened = self.take() if self.peek().kind == "open" else None
        place = self.place
        if token.kind == "plain" and opened:
            name = self.plain()
            if re.fullmatch("[A-Za-z]*", name):
                return Written("L" if name == "l" and token.text in ("mathscr", "mathcal") else name)
            self.place = place
        inside = self.symbol() if opened else None
        written = (inside.written if inside else None) or self.written()
        if opened and self.take().kind != "close":
            raise Unread(f"\\{token.text} over more than one symbol", opened.start)
        styled = written.styled or token.kind == "style"
        return replace(written, dots=written.dots + ACCENTS.get(token.text, 0), styled=styled)

    def derivative(self) -> Node | None:
        r"""A derivative in time or a partial one: \frac{d}{dt}, dD/d phi, d(...)/dt; None where there is none."""
        place, start = self.place, self.peek().start
        fraction = self.took("frac")
        above = self.differential(fraction)
        start_below = self.place
        below = self.differential(fraction) if above and (fraction or self.took("/")) else None
        if fraction and above and below is None and self.tokens[start_below : start_below + 2][-1].text == above[0]:
            raise Unread("a derivative that is not read", start)
        if above is None or below is None or above[0] != below[0] or below[1] is None:
            self.place = place
            return None
        (_, inside, order), by = above, below[1]
        if not (fraction or inside or by.written == Written("t")):
            self.place = place
            return None
        if by.written is None or order != below[2]:
            raise Unread("a derivative that is not read", start)
        inside = inside or self.power()
        for _ in range(order):
            inside = differentiated(inside, by, (start, self.peek(-1).end))
        return inside

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


def differentiated(node: Node, by: Node, span: Span) -> Node:
    """The derivative of a node; a symbol's rate is a symbol. `written` is what it is derived by."""
    if by.written == Written("t") and node.written is not None and node.kind == "symbol":
        return symbol_of(replace(node.written, dots=node.written.dots + 1), span)
    return Node("derivative", span, by.value, (node,), (by.span,), written=by.written)


def symbol_of(written: Written, span: Span) -> Node:
    """A printed name of which nothing else is known."""
    return Node("symbol", span, unknown(written), written=written)
