"""Text to tokens: LaTeX, plain text and their mixtures, with the place of every token."""

import html
import re
import unicodedata
from collections.abc import Iterator
from typing import NamedTuple

from pendpin.doctor.reading.names import FUNCTIONS, GREEK, of_word, spelled
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
_NAMES = {  # LaTeX's commands by the kind of their token; after = what they stand for
    "style": """hat widehat vec mathbf boldsymbol bm bold mathbb overline bar underline symbf textbf bf tilde widetilde
        overrightarrow vb va vu uvec pmb""",
    "plain": """mathrm mathit mathsf mathcal mathscr text textrm textit operatorname rm it cal mathfrak mbox mathnormal
        textnormal textsc""",
    "gap": "quad qquad Rightarrow Longrightarrow implies iff Leftrightarrow Longleftrightarrow therefore",
    "space": """, ; : ! displaystyle large Large textstyle limits nonumber notag hfill left right middle hspace phantom
        allowbreak thinspace medspace enspace big Big bigg Bigg bigl bigr Bigl Bigr biggl biggr Biggl Biggr small qty
        scriptstyle mathop mathbin ensuremath hfil normalsize bigm Bigm strut""",
    "arrow": "uparrow downarrow",
    "other relation": "approx neq ne leq geq le ge ll gg sim simeq propto",
    "arrow relation": "to rightarrow longrightarrow Rrightarrow leftrightarrow",
    ",": "in",
    "command": "sqrt frac tfrac=frac dfrac=frac cfrac=frac partial begin end over underbrace overbrace sum dv pdv",
    "letter": "top intercal prime star dagger",
    "matrix": "pmat bmat mat pmatrix bmatrix matrix",
    "row": r"\ cr newline",
    "operator": "cdot=* times=x ast=* div=/ wedge=x bullet=.",
    "relation": "equiv== triangleq== coloneqq== eqdef== doteq==",
    "|": "| vert=| Vert=| lvert=| rvert=| lVert=| rVert=|",
    "open": r"{=\{ lbrace=\{ lbrack=[ lparen=(",
    "close": r"}=\} rbrace=\} rbrack=] rparen=)",
    "function": " ".join(FUNCTIONS - {"sqrt"}),
    "accent": " ".join(ACCENTS),
}
_COMMANDS = {
    word.split("=")[0]: (kind, word.partition("=")[2] or word) for kind in _NAMES for word in _NAMES[kind].split()
}
_COMMANDS |= {" ": ("space", " "), **{name: ("letter", letter) for name, letter in GREEK.items()}}
_SIGNS = {
    "operator": dict(zip("+-−–*/·⋅×∙÷∗", "+---*/**x*/*", strict=True)) | {"%2B": "+"},
    "superscript": dict(zip("⁰¹²³⁴⁵⁶", "0123456", strict=True)),
    "half": {"½": "1/2", "⅓": "1/3", "¼": "1/4", "¾": "3/4", "⅔": "2/3", "⅙": "1/6", "⅛": "1/8"},
    "dots": {"\u0307": "dot", "\u0308": "ddot", "\u02d9": "dot", "\u00a8": "ddot"},
    "index": dict(zip("₀₁₂₃₄₅₆", "0123456", strict=True)),
    "letter": GREEK,
    "open": {"(": "(", "[": "[", "{": "{"},
    "close": {")": ")", "]": "]", "}": "}"},
    "prime": {"'": "'", "′": "'", "’": "'", "″": "''"},
    "relation": {"=": "=", "==": "=", ":=": "="},
    "gap": {"⇒": "⇒", "⟹": "⟹"},
    "function": {"√": "sqrt"},
    "command": {"∂": "partial"},
    "other relation": {letter: letter for letter in "<>≈≠≤≥∼≪≫"},
    "^": {"^": "^", "**": "^"},
    **{letter: {letter: letter} for letter in "_,.;|&"},
}
_CHARACTERS = {name: (kind, text) for kind, table in _SIGNS.items() for name, text in table.items()}

# blanks in the place of what says nothing of quantities: labels, comments, module names, the number of an equation
_NOISE = re.compile(
    r"\\(?:label|tag|ref|eqref|[hv]space|[hv]?phantom|(?:text)?color|cite|footnote)\*?\s*\{[^{}]*\}"
    r"|(?<!\\)%(?!2B)[^\n]*|(?<=\\\\)\[-?[\d.]+ ?[a-z]{2}\]"
    r"|\b(?:np|numpy|math|Math|sp|sympy|ca|cs|jnp|torch|self|params?|par|obj|this|p)\.\s?_?(?=[A-Za-z])|(?<=[\w)\]])\.T\b|&space;|\.\.\.[^\n]*\n"
    r"|(?:\\[lc]?dots\s*(?:f_\d\s*)?)?(?<=[\s.,s])\(\d{1,2}(?:[.-]\d{1,3})?[a-z]?\)\s*$|\\[lc]?dots\s*[a-z]_\d\s*$|\\q?quad\s*\(\s*[ijkn]\s*=[^()]*\)|\.(?=[*/^])|(?<=\s)\.(?=[+-]\s)"
    r"|</?(?:i|b|em|strong|p|br|span|code|var)\b[^<>]*>|&(?:nbsp|thinsp|middot);"
)
_NAMED = re.compile(r"""\b(?:params?|par|p|self|cfg|config|const)\[\s*(['"])(\w+)\1\s*\]""")  # params["m1"] is m1
_UNIT = r"(?:rad|kg|cm|mm|km|Hz|deg|[msNJ])(?:\^\{?-?[123]\}?|[²³]|(?![A-Za-z_^]))"
_UNITS = re.compile(  # of a parameter: what stands between its number and the end
    r"(?P<value>=\s*[-−]?\s*\d+(?:[.,]\d+)?(?:\(\d+\))?)"
    rf"(?:[\s~{{}}()/·*.]|\\[,;: ]|\\(?:mathrm|text|rm|frac|textrm|cdot|mbox)\b|{_UNIT})*{_UNIT}[\s}})]*$"
)
_FUNCTION_NAMES = "|".join(sorted(FUNCTIONS))
_TOKEN = re.compile(
    rf"""(?P<plain>\\(?:mathrm|textrm|text|mathit|operatorname\*?|rm|mbox)\s*\{{\s*(?:d|diag|{_FUNCTION_NAMES})\s*\}}|\{{\s*\\rm\s+d\s*\}})
    |(?P<tag></?su[bp]>)|(?P<entity>&[A-Za-z]+;)
    |(?P<prose>(?:\(\s*)?\\(?:text(?:rm|it|bf)?|mbox|intertext)\s*\{{(?P<words>[^{{}}]*)\}}\s*\)?)
    |(?P<prime>\^\s*(?:\{{\s*(?:(?:\\prime\b|['′])\s*)+\}}|\\prime\b|['′]))
    |(?P<typo>\\dot\{{\\partial\}})
    |(?P<command>\\(?:[A-Za-z]+\*?|.))
    |(?P<number>(?<![(\[,\d])(?<![ijkn]=)(?:\d+\{{,\}}\d+|\d+,\d+(?!\d|\s*[,)\]]))|(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][+-]?\d\d?(?![\w.]))?)
    |(?P<element>(?!zeros|ones|frac)[A-Za-z]\w*(?:[(\[]\d{{1,2}}(?:,\s*[:1])?[)\]]|[(\[]:,\s*\d{{1,2}}[)\]]))
    |(?P<word>[A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9]+)*)
    |(?P<sign>\*\*|==|:=|%2B|.)""",
    re.VERBOSE | re.DOTALL,
)
_PROSE_WORDS = {"and", "or", "with", "where", "so", "thus", "hence", "for", "if", "when"}
_CONDITION = re.compile(r"\b(?:for|if|when|at|near|provided|unless)\b")
# J_1c is J_1 c
_INDEXED = re.compile(rf"(?:[A-Za-z]|{'|'.join(name for name in GREEK if name.isascii())})_\d(?=[A-Za-z])")


def is_latex(text: str) -> bool:
    """Whether an equation is printed in LaTeX rather than in plain text."""
    return bool(re.search(r"\\[A-Za-z,;:!|{]|\{", text))


def tokens(text: str) -> list[Token]:
    """The tokens of one equation. Raises Unread for a character or command that means nothing here."""
    if len(text) > MOST_CHARACTERS:
        raise Unread(f"longer than {MOST_CHARACTERS:,} characters")
    latex, found, place = is_latex(text), list[Token](), 0
    text = _NAMED.sub(lambda match: match[2].rjust(len(match[0])), text)
    text = _NOISE.sub(lambda match: " " * len(match[0]), text)
    if units := _UNITS.search(text):
        value = units["value"].partition("(")[0]
        text = text[: units.start()] + value.ljust(len(units[0]))
    while place < len(text):
        new = list(_tokens_at(text, place, latex))
        found += [token for token in new if token.kind != "space"]
        place = new[-1].end
        if len(found) > MOST_TOKENS:
            raise Unread(f"longer than {MOST_TOKENS:,} symbols")
    return _merged(found)


def _tokens_at(text: str, start: int, latex: bool) -> Iterator[Token]:
    """The token at one place; of a word perhaps several."""
    match = _TOKEN.match(text, start)
    assert match is not None
    kind, found, end = match.lastgroup, match[0], match.end()
    if kind == "prose":  # which end an equation, or are a condition, or a name such as const
        words = match["words"].strip()
        if words in _PROSE_WORDS or not re.fullmatch(r"[A-Za-z.]*", match["words"]):
            yield Token("condition" if _CONDITION.search(words) else ",", words, start, end)
            return
        kind, found = ("sign", "(") if found[0] == "(" else ("command", found[: found.index("{")].rstrip())
        end = start + len(found)
    match kind:
        case "plain":
            name = re.findall("[a-z]+", found)[-1]
            yield Token("function" if name in FUNCTIONS else "word" if name == "diag" else "letter", name, start, end)
        case "prime":
            yield Token("prime", "'" * len(re.findall("prime|['′]", found)), start, end)
        case "tag" if found[1] == "/":
            yield Token("close", "}", start, end)
        case "tag":
            yield from (Token(mark := "_^"["p" in found], mark, start, end), Token("open", "{", end, end))
        case "entity":
            letter = html.unescape(found)
            if letter not in _CHARACTERS or letter == "&":
                raise Unread(f"{found} has no meaning in an equation here", start)
            yield Token(*_CHARACTERS[letter], start, end)
        case "typo":  # of a partial derivative by a rate
            yield from (Token("command", "partial", start, start + 6), Token("accent", "dot", start + 6, end))
        case "command":
            name = found[1:].rstrip("*") or "*"
            if name not in _COMMANDS:
                raise Unread(f"\\{name} has no meaning in an equation here", start)
            yield Token(*_COMMANDS[name], start, end)
        case "number":
            yield Token("number", found.replace("{,}", ".").replace(",", "."), start, end)
        case "element" if not latex and re.split(r"\W", found)[0] not in FUNCTIONS:
            yield Token("word", found, start, end)
        case "element" | "word":
            word = re.match("[A-Za-z]+" if latex else r"[A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9]+)*", found)
            assert word is not None
            yield from _letters(word[0], start, latex, text)
        case _ if found.isspace() or found in "~\u2009\u202f":
            yield Token("space", found, start, start + 1)
        case _:  # neither a digit nor a Latin letter; a letter with dots above is two
            apart = found.isalpha() and found not in _CHARACTERS
            for letter in unicodedata.normalize("NFD", found) if apart else [found]:
                if letter not in _CHARACTERS and not (letter.isascii() and letter.isalpha()):
                    code = f"{found!r} (U+{ord(found):04X})"
                    raise Unread(f"the character {code} has no meaning in an equation here", start)
                yield Token(*_CHARACTERS.get(letter, ("letter", letter)), start, end)


def _letters(word: str, place: int, latex: bool, text: str) -> Iterator[Token]:
    """A word: one name, or several letters and functions that are multiplied without a sign."""
    end = place + len(word)
    if word in _PROSE_WORDS and len(word) > 2:
        yield Token("condition" if _CONDITION.search(word) else ",", word, place, end)
    elif word.lower() in FUNCTIONS and (word.islower() or text[end : end + 1] in ("(", "[")):
        yield Token("function", word.lower(), place, end)
    elif not latex and (match := _INDEXED.match(word)) and not ((written := of_word(word)) and written.dots):
        yield Token("word", match[0], place, place + match.end())
        yield from _letters(word[match.end() :], place + match.end(), latex, text)
    else:
        over_dt = word == "dt" and text[:place].rstrip().endswith("/")
        for part in ["d", "t"] if over_dt else spelled(word, latex, "*" in text):
            kind = "function" if part in FUNCTIONS else "word" if len(part) > 1 else "letter"
            yield Token(kind, part, place, place + len(part))
            place += len(part)


def _merged(found: list[Token]) -> list[Token]:
    r"""The tokens with \mathrm d as d; with s and c before an angle as sine and cosine, in brackets if both are there."""
    following = zip(found, [*found[1:], None], strict=False)
    found = [a for a, b in following if a.kind != "plain" or b is None or b[:2] != ("letter", "d")]
    short, in_brackets = set[int](), set[int]()
    for i, token in enumerate(found):
        if token.kind == "arrow relation":  # between two equations, or of a limit
            between = _relates(found[:i]) and _relates(found[i:])
            found[i] = token._replace(kind="gap" if between else "other relation")
        after = found[i + 1 : i + 4]
        if token.kind == "letter" and token.text in "sc" and after and after[0].start == token.end:
            if after[0].text in ("theta", "phi") and (len(after) < 2 or after[1].kind != "prime"):
                short.add(i)
            elif [one.kind for one in after] == ["open", "letter", "close"] and after[1].text in GREEK:
                in_brackets.add(i)
    if {found[i].text for i in in_brackets} == {"s", "c"}:
        short |= in_brackets
    for i in short:
        found[i] = found[i]._replace(kind="function", text="sin" if found[i].text == "s" else "cos")
    return found


def lines(found: list[Token]) -> list[Token]:
    r"""Tokens with a separator between equations only: not where a row goes on with a sum, nor at labels and &.

    A gap such as \quad or \Rightarrow separates two equations if both sides of it have a relation.
    """
    kept: list[Token] = []
    related = False
    for line in _split(found, "row"):
        bare = [token for token in line if token.kind not in ("&", "gap")]
        if kept and bare and (bare[0].kind != "operator" or (related and _relates(bare))):
            kept.append(Token("row", "\\", bare[0].start, bare[0].start))
            related = False
        for piece in _split(line, "gap"):
            if related and _relates(piece):
                kept.append(Token(",", ",", piece[0].start, piece[0].start))
                related = False
            for column in _split(piece, "&"):
                if not (related and column and column[0].kind == "open" and not _relates(column)):
                    kept += column
                related = related or _relates(column)
    return kept


def _relates(found: list[Token]) -> bool:
    return any(token.kind == "relation" for token in found)


def _split(found: list[Token], kind: str) -> list[list[Token]]:
    """The tokens between separators of a kind that stand outside matrices and braces."""
    pieces, depth = [list[Token]()], 0
    for token in found:
        depth += {"begin": 1, "end": -1, "{": 1, "}": -1}.get(token.text, 0)
        if token.kind == kind and depth == 0:
            pieces.append([])
        else:
            pieces[-1].append(token)
    return pieces
