"""Printed names: accents, hats, bold type, indices, primes, frames in front and behind, read from tokens by a cursor."""

import re
from dataclasses import replace

from pendpin.doctor.reading.names import Written, of_word, unknown
from pendpin.doctor.reading.tokens import ACCENTS, Token
from pendpin.doctor.reading.tree import Node, Span, Unread

CLOSING = {"(": ")", "[": "]", "{": "}", "\\{": "\\}"}
FRAMES = set("ABINOWG")
OF_TIME = (["(", "t", ")"], ["{", "(", "t", ")", "}"], ["[", "t", "]"])


def symbol_of(written: Written, span: Span) -> Node:
    """A printed name of which nothing else is known."""
    return Node("symbol", span, unknown(written), written=written)


class SymbolReader:
    """A cursor over the tokens of a text that reads names."""

    def __init__(self, found: list[Token], latex: bool, tight: bool) -> None:
        end = found[-1].end if found else 0
        self.tokens, self.latex, self.tight = [*found, Token("end", "the end", end, end)], latex, tight
        self.starred = any(token.text == "*" for token in found)  # products have a sign
        self.place, self.bars, self.spaced = 0, 0, False  # of |, how many are open; whether blanks separate entries

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

    @property
    def end(self) -> int:
        """The place behind the token before."""
        return self.peek(-1).end

    def at_sign(self) -> bool:
        """Whether + or - comes next."""
        return self.peek().kind == "operator" and self.peek().text in "+-"

    def at_symbol(self) -> bool:
        """Whether a printed name begins here; it may begin with frames, as in {}^I C^A."""
        if self.peek().text == "{":
            return self.peek(1).kind == "close" and self.peek(2).kind == "^"
        return self.peek().kind in ("letter", "word", "accent", "style", "plain")

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
        sign = self.take().text if self.at_sign() else ""
        self.digit()
        one = self.take()
        if one.kind in ("plain", "style"):
            one = self.take()
        text = sign + (self.plain() if one.kind == "open" else one.text)
        return "G/O" if text == "G" and mark.kind == "_" and self.took("/", "O") else text

    def symbol(self) -> Node:
        """One quantity, of which is known only how it is written."""
        start, before = self.peek().start, ""
        if self.peek().kind == "open":
            self.place += 2
            before = self.script()
        written = self.written()
        framed = self.peek(2 if self.peek(1).kind == "open" else 1)
        if self.peek().kind == "^" and framed.kind == "letter" and framed.text in FRAMES:
            frame = self.script()
            written = replace(written, frames=before + frame if before and written.letter == "C" else "")
        while self.peek().kind == "prime":
            written = replace(written, dots=written.dots + len(self.take().text))
        if self.peek().kind == "_" and not written.index:
            written = replace(written, index=self.script())
        if self.peek().kind == "^" and self.peek(1).kind == "arrow":
            written = replace(written, index=written.index + self.script())
        any(self.took(*argument) for argument in OF_TIME)
        if written.letter == "sum" and written.index:
            raise Unread("a sum is read with small numbers as its bounds", start)
        return symbol_of(written, (start, self.end))

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
