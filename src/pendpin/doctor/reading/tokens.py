"""Text to tokens: LaTeX, plain text and their mixtures, with the place of every token."""

import re
from collections.abc import Iterator
from itertools import takewhile
from typing import NamedTuple

from pendpin.doctor.reading.names import FUNCTIONS, GREEK, is_rate, is_word, letters_of
from pendpin.doctor.reading.tree import Unread

MOST_CHARACTERS = 20_000  # of one equation
MOST_TOKENS = 2_000


class Token(NamedTuple):
    """kind: number, letter, word, function, accent, style, operator, open, close, command, relation, or the text itself."""

    kind: str
    text: str
    start: int
    end: int


ACCENTS = {"dot": 1, "ddot": 2, "Dot": 1, "Ddot": 2, "dddot": 3}
_NAMED = {  # LaTeX's commands that stand for themselves, by the kind of their token
    "style": """hat widehat vec mathbf boldsymbol bm bold mathbb overline bar underline symbf textbf bf tilde widetilde
        overrightarrow""",
    "plain": "mathrm mathit mathsf mathcal mathscr text textrm textit operatorname rm it cal mathfrak",
    "gap": "quad qquad Rightarrow Longrightarrow implies iff Leftrightarrow therefore",
    "space": """, ; : ! displaystyle large Large textstyle limits nonumber notag hfill left right middle hspace phantom
        allowbreak thinspace medspace enspace big Big bigg Bigg bigl bigr Bigl Bigr biggl biggr Biggl Biggr""",
    "arrow": "uparrow downarrow",
    "other relation": "approx neq ne leq geq le ge ll gg sim simeq propto to rightarrow",
    "command": "sqrt frac partial begin end top intercal over underbrace overbrace",
}
_WRITTEN = {  # commands that stand for another text
    "operator": {"cdot": "*", "times": "x", "ast": "*", "div": "/", "wedge": "x", "bullet": "."},
    "relation": dict.fromkeys(("equiv", "triangleq", "coloneqq", "eqdef", "doteq"), "="),
    "command": dict.fromkeys(("tfrac", "dfrac", "cfrac"), "frac"),
    "|": dict.fromkeys(("|", "vert", "Vert", "lvert", "rvert", "lVert", "rVert"), "|"),
    "open": {"{": r"\{", "lbrace": r"\{", "lbrack": r"\[", "lparen": r"\("},
    "close": {"}": r"\}", "rbrace": r"\}", "rbrack": r"\]", "rparen": r"\)"},
    "row": {"\\": "\\"},
    "space": {" ": " "},
    "letter": GREEK,
    "function": {name: name for name in FUNCTIONS - {"sqrt"}},
    "accent": {name: name for name in ACCENTS},
}
COMMANDS = {name: (kind, name) for kind, names in _NAMED.items() for name in names.split()}
COMMANDS |= {name: (kind, text) for kind, table in _WRITTEN.items() for name, text in table.items()}
_CHARACTERS = {
    "operator": dict(zip("+-−–*/·⋅×∙÷", "+---*/**x*/", strict=True)),
    "superscript": dict(zip("⁰¹²³⁴⁵⁶", "0123456", strict=True)),
    "half": {"½": "1/2", "⅓": "1/3", "¼": "1/4", "¾": "3/4", "⅔": "2/3", "⅙": "1/6", "⅛": "1/8"},
    "dots": {"\u0307": "dot", "\u0308": "ddot"},
    "index": dict(zip("₀₁₂₃", "0123", strict=True)),
    "letter": GREEK,
    "open": {letter: letter for letter in "([{"},
    "close": {letter: letter for letter in ")]}"},
    "prime": {"'": "'", "′": "'", "’": "'", "″": "''"},
    "relation": {"=": "="},
    "other relation": {letter: letter for letter in "<>≈≠≤≥∼≪≫"},
    **{letter: {letter: letter} for letter in "^_,.;|"},
}
CHARACTERS = {name: (kind, text) for kind, table in _CHARACTERS.items() for name, text in table.items()}

_NUMBER = re.compile(r"\d+(?:\.\d+)?|\.\d+")
_DECIMAL_COMMA = re.compile(r"(?:0,|\d+\{,\})\d+|(?<![(,\d])\d+,\d+(?![\d,)]|\s*[,)])")
_LATIN = re.compile(r"[A-Za-z]+")
_WORD = re.compile(r"[A-Za-z][A-Za-z0-9]*(?:_(?:[A-Za-z0-9]+))*")
_ELEMENT = re.compile(r"[A-Za-z]\w*(?:\(\d{1,2}\)|\[\d{1,2}\]|\(:,\s*\d{1,2}\)|\[:,\s*\d{1,2}\])")
_INDEXED = re.compile(r"[A-Za-z]+_\d(?=[A-Za-z])")  # a name before another, as in J_1c
_PRODUCT = re.compile(r"(?:sin|cos|tan|sqrt|theta|phi|omega|[mMglLhrIJFTV]\d?)+")  # what is multiplied without a sign
_COMMAND = re.compile(r"\\([A-Za-z]+\*?|.)", re.DOTALL)
_PRIMES = re.compile(r"\^\s*(?:\{\s*(?:(?:\\prime\b|['′])\s*)+\}|\\prime\b|['′])")
_PROSE = re.compile(r"\(?\s*\\(?:text(?:rm|it|bf)?|mbox|intertext)\s*\{([^{}]*)\}\s*\)?")
_PROSE_WORDS = {"and", "or", "with", "where", "so", "thus", "hence", "for", "if", "when"}
_CONDITION = re.compile(r"\b(?:for|if|when|at|near|provided|unless)\b")
_DECORATION = re.compile(
    r"\\(?:label|tag|ref|eqref|hspace|vspace|mbox|nonumber)\*?\s*\{[^{}]*\}|(?<!\\)%[^\n]*"
    r"|(?<=\\\\)\[-?[\d.]+ ?[a-z]{2}\]|\b(?:np|numpy|math|Math|sp|sympy|self|params|par|obj|this)\.(?=[A-Za-z])"
    r"|(?<=[\s.,])\(\d{1,2}(?:[.-]\d{1,3})?[a-z]?\)\s*$|\\q?quad\s*\(\s*[ijkn]\s*=[^()]*\)|\.(?=[*/^])"
)


def is_latex(text: str) -> bool:
    """Whether an equation is printed in LaTeX rather than in plain text."""
    return "\\" in text or "{" in text


def tokens(text: str) -> list[Token]:
    """The tokens of one equation. Raises Unread for a character or command that means nothing here."""
    if len(text) > MOST_CHARACTERS:
        raise Unread(f"longer than {MOST_CHARACTERS:,} characters")
    latex, found, place = is_latex(text), [], 0
    code = not latex and "*" in text
    while place < len(text):
        if match := _DECORATION.match(text, place):
            place = match.end()
        elif match := _PRIMES.match(text, place):
            found.append(Token("prime", "'" * len(re.findall("prime|['′]", match[0])), place, match.end()))
            place = match.end()
        elif text[place] in "(\\" and (prose := _prose(text, place)):
            found.append(prose)
            place = prose.end
        elif text[place].isspace() or text[place] in "~&\u2009\u202f":
            if text[place] == "&":
                found.append(Token("&", "&", place, place + 1))
            place += 1
        else:
            new = _next(text, place, latex, code)
            found.extend(token for token in new if token.kind != "space")
            place = new[-1].end
        if len(found) > MOST_TOKENS:
            raise Unread(f"longer than {MOST_TOKENS:,} symbols")
    return list(_merged(found))


def _prose(text: str, place: int) -> Token | None:
    """Words beside an equation, which end it, or a condition; None for a name, such as const."""
    match = _PROSE.match(text, place)
    words = match[1].strip() if match else ""
    if match is None or (words not in _PROSE_WORDS and re.fullmatch(r"[A-Za-z.]*", match[1])):
        return None
    return Token("condition" if _CONDITION.search(words) else ",", words, place, match.end())


def _merged(found: list[Token]) -> Iterator[Token]:
    r"""Tokens with \mathrm{d} and \operatorname{sin} as the letter and the function that they stand for."""
    place = 0
    while place < len(found):
        token = found[place]
        word = found[place + 1 : place + 4]
        adjacent = word and word[0].start == token.end and (len(word) < 2 or word[1].kind != "prime")
        if token.kind == "letter" and token.text in "sc" and adjacent and word[0].text in ("theta", "phi"):
            yield token._replace(kind="function", text="sin" if token.text == "s" else "cos")
            place += 1
        elif token.kind == "plain" and word and word[0][:2] == ("letter", "d"):
            place += 1
        elif token.kind == "plain" and _braced(word) in {"d", "diag", *FUNCTIONS}:
            yield word[1]._replace(start=token.start, end=word[2].end)
            place += 4
        else:
            yield token
            place += 1


def _braced(word: list[Token]) -> str:
    """What stands alone in brackets; empty where nothing does."""
    return word[1].text if [token.kind for token in word[::2]] == ["open", "close"] else ""


def _next(text: str, place: int, latex: bool, code: bool) -> list[Token]:
    """The token, or the tokens of one word, that start at a place."""
    letter = text[place]
    if letter == "\\":
        return [_command(text, place)]
    if match := _DECIMAL_COMMA.match(text, place):
        return [Token("number", match[0].replace("{,}", ".").replace(",", "."), place, match.end())]
    if match := _NUMBER.match(text, place):
        return [Token("number", match[0], place, match.end())]
    if not latex and (match := _ELEMENT.match(text, place)) and not FUNCTIONS & {re.split(r"\W", match[0])[0]}:
        return [Token("word", match[0], place, match.end())]
    if letter.isascii() and letter.isalpha():
        match = (_LATIN if latex else _WORD).match(text, place)
        assert match is not None
        return _letters(match[0], place, latex, code)
    return [_sign(text, place)]


def _letters(word: str, place: int, latex: bool, code: bool) -> list[Token]:
    """A word: one name, or several letters and functions that are multiplied without a sign, which is rare in `code`."""
    if word in FUNCTIONS:
        return [Token("function", word, place, place + len(word))]
    if not latex and (match := _INDEXED.match(word)) and not is_rate(word):
        first = Token("word", match[0], place, match.end() + place)
        return [first, *_letters(word[match.end() :], first.end, latex, code)]
    if not latex and (word == "der" or is_word(word) or (code and not _PRODUCT.fullmatch(word))):
        return [Token("word", word, place, place + len(word))]
    if word in ("diag", "der"):
        return [Token("word", word, place, place + len(word))]
    found = []
    for part in letters_of(word, latex):
        kind = "function" if part in FUNCTIONS else "word" if len(part) > 1 and not latex else "letter"
        found.append(Token(kind, part, place, place + len(part)))
        place += len(part)
    return found


def _command(text: str, place: int) -> Token:
    match = _COMMAND.match(text, place)
    if match is None:
        raise Unread("a lone backslash at the end", place)
    name, end = match[1].rstrip("*"), match.end()
    if name not in COMMANDS:
        raise Unread(f"\\{name} has no meaning in an equation here", place)
    return Token(*COMMANDS[name], place, end)


def _sign(text: str, place: int) -> Token:
    """The token of a character that is neither a digit nor a Latin letter."""
    if text.startswith("**", place):
        return Token("^", "^", place, place + 2)
    if text.startswith(("==", ":="), place):
        return Token("relation", "=", place, place + 2)
    letter = text[place]
    if letter not in CHARACTERS:
        raise Unread(f"the character {letter!r} (U+{ord(letter):04X}) has no meaning in an equation here", place)
    return Token(*CHARACTERS[letter], place, place + 1)


def joined(found: list[Token]) -> list[Token]:
    """Tokens without the breaks of lines before those that only go on with a sum or product, and without labels."""
    kept: list[Token] = []
    related = False  # whether this row has a relation already
    for i, token in enumerate(found):
        inside = token.kind in ("row", "&") and _inside_matrix(kept)
        rest = [other.kind for other in takewhile(lambda other: other.kind != "row", found[i + 1 :])]
        if token.kind == "row" and not inside:
            line = [other for other in found[i + 1 :] if other.kind != "&"]
            if line and line[0].kind == "operator" and "relation" not in rest:
                continue
            related = False
        if token.kind == "gap":
            gap = [other.kind for other in takewhile(lambda other: other.kind not in ("row", "gap"), found[i + 1 :])]
            if related and "relation" in gap:
                kept.append(token._replace(kind=","))
                related = False
            continue
        if token.kind == "&" and not inside and kept and kept[-1].kind != "row":
            if related and rest and "relation" not in rest and rest[0] == "open":
                kept.append(token._replace(kind="label", text=str(len(rest))))
            continue
        related = related or token.kind == "relation"
        kept.append(token)
    return list(_without_labels(kept))


def _without_labels(found: list[Token]) -> Iterator[Token]:
    """Tokens without the last column of a row, such as (b_1), which names the equation."""
    skipped = 0
    for token in found:
        if token.kind == "label":
            skipped = int(token.text)
        elif skipped:
            skipped -= 1
        else:
            yield token


def _inside_matrix(before: list[Token]) -> bool:
    """Whether a matrix is open after some tokens."""
    names = [token.text for token in before if token.kind == "command" and token.text in ("begin", "end")]
    return names.count("begin") > names.count("end")
