"""Printed symbols: accents, hats, bold type, indices, primes, frames in front and behind."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from pendpin.doctor.reading.names import Written, of_word, unknown
from pendpin.doctor.reading.tokens import ACCENTS, Token
from pendpin.doctor.reading.tree import Node, Span, Unread

MOST_DEPTH = 40  # brackets and accents inside each other
MOST_DOTS = 6
FRAMES = set("ABINOWG")


class PrintedNames:
    """A cursor over tokens that reads names."""

    def __init__(self, tokens: list[Token], latex: bool, tight: bool) -> None:
        end = tokens[-1].end if tokens else 0
        self.tokens, self.latex, self.tight = [*tokens, Token("end", "the end", end, end)], latex, tight
        self.place, self.depth, self.bars = 0, 0, 0

    def peek(self, ahead: int = 0) -> Token:
        """The token this number of places ahead."""
        return self.tokens[max(0, min(self.place + ahead, len(self.tokens) - 1))]

    def take(self) -> Token:
        """The next token, and past it."""
        token = self.peek()
        self.place = min(self.place + 1, len(self.tokens) - 1)
        return token

    @contextmanager
    def deeper(self) -> Iterator[None]:
        """One level down. Raises Unread where that is too deep."""
        self.depth += 1
        if self.depth > MOST_DEPTH:
            raise Unread(f"brackets nested more than {MOST_DEPTH} deep", self.peek().start)
        yield
        self.depth -= 1

    def digit(self) -> None:
        r"""LaTeX takes one digit where there are no braces, as in \frac12 and x^23."""
        token = self.peek()
        if self.latex and token.kind == "number" and len(token.text) > 1 and token.text.isdigit():
            first = Token("number", token.text[0], token.start, token.start + 1)
            rest = Token("number", token.text[1:], token.start + 1, token.end)
            self.tokens[self.place : self.place + 1] = [first, rest]

    def at_symbol(self) -> bool:
        """Whether a printed name begins here; it may begin with frames, as in {}^I C^A."""
        token = self.peek()
        if token.kind == "open" and token.text == "{":
            return self.peek(1).kind == "close" and self.peek(2).kind == "^"
        return token.kind in ("letter", "word", "accent", "style", "plain")

    def symbol(self) -> Node:
        """One quantity, of which is known only how it is written."""
        start = self.peek().start
        before = self._frame_before()
        written, end = self._written()
        if self.peek().kind == "^" and (after := self._frame_after()):
            both = written.letter == "C" and before and after
            written, end = replace(written, frames=before + after if both else ""), self.peek(-1).end
        dots = self._primes()
        written = replace(written, dots=written.dots + dots)
        if dots and self.peek().kind == "_" and not written.index:
            written = replace(written, index=self._index())
        if self.peek().kind == "^" and self.peek(1).kind == "arrow":
            written = replace(written, index=written.index + self.peek(1).text)
            self.take()
            self.take()
            dots = 1
        end = max(end, self.peek(-1).end if dots else end)
        for function_of_time in (["(", "t", ")"], ["{", "(", "t", ")", "}"]):
            if [self.peek(i).text for i in range(len(function_of_time))] == function_of_time:
                end = [self.take() for _ in function_of_time][-1].end
        return _symbol(written, (start, end))

    def _frame_before(self) -> str:
        if self.peek().kind != "open":
            return ""
        for _ in range(3):
            self.take()
        return self._frame_letter()

    def _frame_letter(self) -> str:
        bracketed = self.peek().kind == "open"
        if bracketed:
            self.take()
        token = self.take()
        if bracketed and self.peek().kind == "close":
            self.take()
        return token.text

    def _frame_after(self) -> str:
        ahead = 2 if self.peek(1).kind == "open" else 1
        if self.peek(ahead).kind == "letter" and self.peek(ahead).text in FRAMES:
            self.take()
            return self._frame_letter()
        return ""

    def _primes(self) -> int:
        count = 0
        while self.peek().kind == "prime":
            count += len(self.take().text)
        return count

    def _written(self) -> tuple[Written, int]:
        """A letter with what is above, below and around it, and where that ends."""
        with self.deeper():
            token = self.take()
            if token.kind in ("accent", "style", "plain"):
                written = self._decorated(token)
            elif token.kind == "word":
                written = of_word(token.text) or Written(token.text)
            elif token.kind == "letter":
                written = Written(token.text)
            else:
                raise Unread(f"{token.text!r} is not a symbol", token.start)
            while self.peek().kind == "dots":
                written = replace(written, dots=written.dots + ACCENTS[self.take().text])
            number = self.peek()
            if not self.latex and token.kind == "letter" and number.kind == "number" and number.start == token.end:
                written = replace(written, index=self.take().text)  # as in θ1
            if self.peek().kind == "index":
                written = replace(written, index=self.take().text)
            if self.peek().kind == "_":
                written = replace(written, index=self._index())
        return written, self.peek(-1).end

    def _decorated(self, token: Token) -> Written:
        """The symbol under an accent, or in another type."""
        bracketed = self.peek().kind == "open"
        opened = self.take() if bracketed else None
        if token.kind == "plain" and bracketed:
            return Written(self._plain(opened))
        written, _ = self._written()
        written = replace(written, dots=written.dots + self._primes())
        if opened is not None:
            if self.peek().kind != "close":
                raise Unread(f"\\{token.text} over more than one symbol", opened.start)
            self.take()
        if token.kind == "accent":
            return replace(written, dots=written.dots + ACCENTS[token.text])
        return replace(written, styled=written.styled or token.kind == "style")

    def _plain(self, opened: Token | None) -> str:
        """A word in upright type."""
        letters = []
        while self.peek().kind not in ("close", "end"):
            letters.append(self.take().text)
        if self.peek().kind == "end":
            raise Unread("the bracket { is not closed", opened.start if opened else 0)
        self.take()
        return "".join(letters)

    def _index(self) -> str:
        self.take()
        if self.peek().kind != "open":
            self.digit()
            token = self.take()
            opened = self.take() if token.kind == "plain" and self.peek().kind == "open" else None
            index = self._plain(opened) if opened else token.text
        else:
            opened, parts = self.take(), []
            while self.peek().kind != "close":
                if self.peek().kind == "end":
                    raise Unread("the bracket { is not closed", opened.start)
                part = self.take()
                if part.kind == "open":
                    parts.append(self._plain(part))
                elif part.kind not in ("plain", "style"):
                    parts.append(part.text)
            self.take()
            index = "".join(parts)
        if index == "G" and self.peek().text == "/" and self.peek(1).text == "O":
            self.take()
            self.take()
            index = "G/O"
        return index

    def differential(self) -> tuple[str, Node | None, int] | None:
        """In braces: d or the sign of partial derivatives, what it is put before, and the order; None for anything else."""
        if self.peek().kind != "open":
            return None
        self.take()
        token = self.take()
        if token.text not in ("d", "partial"):
            return None
        order, inner = self._order(), None
        if self.peek().kind != "close":
            braced = self.peek().text == "{" and self.take()
            if not self.at_symbol():
                return None
            inner = self.symbol()
            if braced and self.take().kind != "close":
                return None
            order = max(order, self._order())
        if self.peek().kind != "close":
            return None
        self.take()
        return token.text, inner, order

    def _order(self) -> int:
        if self.peek().kind == "superscript":
            return int(self.take().text)
        if self.peek().kind != "^":
            return 1
        self.take()
        text = self._frame_letter()
        return int(text) if text.isdigit() and len(text) == 1 else 1

    def differentiated(self, node: Node, by: Node, span: Span) -> Node:
        """The derivative of a node; a symbol's rate is a symbol. `written` is what it is derived by."""
        if by.written == Written("t") and node.written is not None and node.kind == "symbol":
            return _symbol(replace(node.written, dots=node.written.dots + 1), span)
        return Node("derivative", span, by.value, (node,), (by.span,), written=by.written)

    def environment(self) -> str:
        """The name after \\begin or \\end."""
        opened = self.take()
        if opened.kind != "open":
            raise Unread("\\begin without a name", opened.start)
        return self._plain(opened)

    def skip_group(self) -> None:
        """Past a token, or a bracket and what is in it."""
        depth = 0
        while self.peek().kind != "end":
            depth += {"open": 1, "close": -1}.get(self.take().kind, 0)
            if depth == 0:
                return


def _symbol(written: Written, span: Span) -> Node:
    """A printed name of which nothing else is known."""
    return Node("symbol", span, unknown(written), written=written)
