"""Text to tokens: LaTeX, plain text, code and their mixtures, with their places; and which tokens are one equation."""

import re
import unicodedata
from bisect import bisect
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import NamedTuple

from pendpin.doctor.reading.names import FUNCTIONS, GREEK, SCRIPT_L, of_word, spelled
from pendpin.doctor.reading.tree import Unread

MOST_CHARACTERS, MOST_TOKENS = 20_000, 2_000  # of one equation
LONGEST_NAME = 80  # characters of an object's name and its number
MOST_OF_A_NUMBER = 4  # tokens of the number beside an equation, such as (b_1)
MATRICES = {"bmatrix", "pmatrix", "matrix", "array", "smallmatrix", "Bmatrix", "pmat"}
CLOSING = {"(": ")", "[": "]", "{": "}", r"\{": r"\}", **{name: name for name in MATRICES}, "pmat": "}"}
_LAYOUT = """equation align aligned alignat alignedat gather gathered multline multlined eqnarray split flalign
displaymath math cases subequations"""
ENVIRONMENTS = set(_LAYOUT.split())
# functions of code: what they get, as they get it; powers, with the exponent that is not said; products; and others
AS_GIVEN = {"array", "asarray", "Matrix", "matrix", "vector", "vertcat", "simplify", "expand", "trigsimp"}
POWERS = {"pow": 0, "power": 0, "square": 2}
PRODUCTS = {"dot": ".", "cross": "x", "solve": "*", "matmul": "*", "mtimes": "*"}
DERIVATIVES, INVERSES = {"diff", "Derivative", "gradient"}, {"inv", "inverse"}
CALLED = {*AS_GIVEN, *POWERS, *PRODUCTS, *DERIVATIVES, *INVERSES, "Rational"}
ACCENTS = {"dot": 1, "ddot": 2, "Dot": 1, "Ddot": 2, "dddot": 3}
SEPARATORS = {"row", ",", ";", ".", "gap", "arrow relation", "&"}


class Token(NamedTuple):
    """kind: number, letter, word, function, accent, style, operator, open, close, command, relation, or the text itself.

    What is raised or lowered is one token, ^ or _, its text without brackets. The text of a strange one says why. A blank
    stands between the entries of a row such as [a b -c].
    """

    kind: str
    text: str
    start: int
    end: int


_PLAIN = """mathrm mathit mathsf mathcal mathscr text textrm textit operatorname rm it cal mathfrak mbox mathnormal
textnormal textsc"""
_COMMANDS = {  # of LaTeX, by the kind of their token; after → what they stand for
    "style": """hat widehat vec vect mathbf boldsymbol bm bold mathbb overline bar underline symbf textbf bf tilde widetilde
        overrightarrow vb va vu uvec pmb""",
    "gap": "quad qquad Rightarrow Longrightarrow implies iff Leftrightarrow Longleftrightarrow therefore because",
    "space": rf"""{_PLAIN} , ; : ! displaystyle large Large textstyle limits nonumber notag hfill left right middle hspace
        phantom allowbreak lgroup rgroup thinspace medspace enspace big Big bigg Bigg bigl bigr Bigl Bigr biggl biggr Biggl
        Biggr small qty scriptstyle mathop mathbin ensuremath hfil normalsize bigm Bigm strut boxed fbox framebox boxe
        cancel highlight""",
    "other relation": "neq ne leq geq le ge ll gg sim propto",
    "arrow relation": "to rightarrow longrightarrow Rrightarrow leftrightarrow",
    ",": "in &",
    "command": "det frac tfrac→frac dfrac→frac cfrac→frac flatfrac→frac partial underbrace overbrace sum dv pdv→dv",
    "over": "over",
    "letter": "lag→ℒ Lag→ℒ Lagr→ℒ l e max min top intercal prime star dagger uparrow downarrow upsilon Upsilon Pi Xi "
    + " ".join(f"{name}→{letter}" for name, letter in GREEK.items()),
    "row": r"\ cr newline",
    "operator": "cdot→* times→x ast→* div→/ wedge→x bullet→.",
    "relation": "equiv→= triangleq→= coloneqq→= eqdef→= doteq→= approx→≈ simeq→≈",
    "|": "| vert→| Vert→| lvert→| rvert→| lVert→| rVert→|",
    "open": r"{→\{ lbrace→\{ lbrack→[ lparen→( langle→(",
    "close": r"}→\} rbrace→\} rbrack→] rparen→) rangle→)",
    "function": " ".join(map("→".join, FUNCTIONS.items())) + " tg→tan ctg→cot",
    "accent": " ".join(ACCENTS),
}
_SIGNS = {  # and of characters and signs
    "blank": "¦",
    "operator": "+ - −→- –→- * / ·→* ⋅→* ×→x ∙→* ÷→/ ∗→* @→* ∖ %2B→+",
    "^": "⁰→0 ¹→1 ²→2 ³→3 ⁴→4 ⁵→5 ⁶→6",
    "_": "₀→0 ₁→1 ₂→2 ₃→3 ₄→4 ₅→5 ₆→6 ᵢ→i ⱼ→j ₖ→k ₙ→n",
    "number": "½→1/2 ⅓→1/3 ¼→1/4 ¾→3/4 ⅔→2/3 ⅙→1/6 ⅛→1/8",
    "dots": "\u0307→dot \u0308→ddot \u02d9→dot \u00a8→ddot \u0302→hat",
    "letter": " ".join(f"{name}→{letter}" for name, letter in GREEK.items()),
    "open": "( [ {",
    "close": ") ] }",
    "prime": "' ′→' ’→' ´→' ″→''",
    "relation": "= ==→= :=→= ≈",
    "gap": "⇒ ⟹",
    "function": "√→sqrt",
    "command": "∂→partial",
    "other relation": "< > ≠ ≤ ≥ ∼ ≪ ≫",
    "script": "^ **→^ _",
    **{letter: letter for letter in ",.;|&"},
}


def _table(kinds: dict[str, str]) -> dict[str, tuple[str, str]]:
    """The kind and text of each entry."""
    pairs = ((kind, *entry.partition("→")[::2]) for kind, entries in kinds.items() for entry in entries.split())
    return {name: (kind, text or name) for kind, name, text in pairs}


COMMANDS, CHARACTERS = _table(_COMMANDS) | {" ": ("space", " ")}, _table(_SIGNS) | {"\f": ("row", "\\")}

_SOLVED = re.compile(  # A\b, the solution of A x = b
    rf"\A[^\\{{}}]*[\w)\]]\s*\\\s*(?:[(\[]|(?!(?:{'|'.join(filter(str.isalpha, COMMANDS))})\b)\w+\b)[^\\{{}}]*\Z",
    re.DOTALL,
)
_WORD = re.compile(r"(?<![\w\\])[A-Za-z]\w+\Z")
_UNIT = r"(?:rad|kg|cm|mm|km|Hz|deg|[msNJ])(?:\^\{?-?[123]\}?|[²³]|(?![A-Za-z_^]))"
# one of many values of a quantity in time: theta1[end], x[i], theta2[0]
_SAMPLE = r"(?<=\w)(?:\[\s*(?:end|[ijkn]|-1|:)\s*\]|(?<=[a-z]\d)\[\d\])"
_OWNING = """obj env model sys system robot pendulum par params p self cfg config const sol solution res result this state
states current prev"""
_OWNERS = set(_OWNING.split())


def _name_member(match: re.Match[str]) -> str:
    """self.m is m, robot.m1 is m1, bob1.mass is mass_1, pole.m is m_pole."""
    owners, number, _, name, call = match.groups()
    if call and name.lower() not in FUNCTIONS and name not in CALLED:
        return match[0]
    owner = owners.split(".")[-1]
    if not (call or re.search(r"\d", name)) and (number or not _OWNERS & {*owner.split("_")}):
        name = f"{name}_{number or owner}"
    return f"{name}{call or ''}"


def _mark_rows(match: re.Match[str]) -> str:
    """In MATLAB's brackets each line is a row, and without commas a blank separates."""
    inside = re.sub(r"(?<=[\w)\]'])([ \t]*)\n(?=\s*(?:-\S|[\w(]))", r"\1;", match[0])
    is_row = "," not in inside and (";" in inside or "*" in match.string or match[0][-1] == "'")
    return re.sub(r"(?<=[\w)'])\s(?=\s*(?:[-+]?[\w(]))", "¦", inside) if is_row else inside


Rewriting = tuple[str | re.Pattern[str], str | Callable[[re.Match[str]], str]]
_REWRITTEN: tuple[Rewriting, ...] = (  # what says nothing of quantities is blank, or written otherwise
    (  # labels, comments, module names, the number of an equation, the points of functions of each element
        r"\\tag\s*\d|\\(?:label|tag|ref|eqref|[hv]space|(?:text)?color|unit|si)\*?\s*\{(?:[^{}]|\{[^{}]*\})*\}"
        r"|(?<=\\\\)\[-?[\d.]+ ?[a-z]{2}\]"
        r"|(?<!\\)%(?!2B)[^\n]*|\.\.\.[^\n]*\n"
        r"|\b(?:np|jnp|numpy|math|Mathf?|s[mp]p?|sym?|sympy|casadi|ca|self|params?|par|p)\.\s?_?(?=[A-Za-z])"
        r"|\b(?:[A-Za-z]\w*::)+"
        r"|(?:(?<=[\s.,])|\\[lc]?dots\s*)\(\d{1,2}(?:[.-]\d{1,3})?[a-z]?\)\s*$|\\q?quad\s*\([\w.*]{1,5}\)\s*$"
        r"|\.(?=[*/^=])|(?<=\w)\.'|(?<=\s)\.(?=[+-]\s)|(?<=[a-z])\.(?=\()|(?<=[\w)\]])\.T\b|\\(?=[_*])|(?<!\\)\\\s*$"
        r"|@[SM](?:Vector|Matrix)\b|@\([\w, ]*\)"
        r"|^[^=:{}]{0,30}(?:_\{[^=:{}]{1,20}\}[^=:{}]{0,10})?:(?!=)\s*&?(?=[^=:]*=)|\s\[(?:(?:rad|kg|Hz|[msNJ])[/*·^²\d]*)+\]\s*$",
        "",
    ),
    (  # dots set over a letter, an arrow with words, a relation with a mark
        r"\\(?:overset|stackrel)\s*\{\s*(?:(\.\s*\.|\\cdot\s*\\cdot)|\.|\\cdot)\s*\}",
        lambda match: (r"\ddot" if match[1] else r"\dot").ljust(len(match[0])),
    ),
    (r"\\x(?:long)?(?:right|Right)arrow\s*(?:\[[^\]]*\])?\{(?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*\}", r"\\to "),
    (r"\\(?:overset|stackrel|underset)\s*\{[^{}]*\}\s*\{\s*(?==\s*\})", r"{"),
    (
        r"\\(?:abs|norm)\*?\s*\{((?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*)\}",
        lambda match: f"|{match[1].rjust(len(match[0]) - 2)}|",
    ),
    (r"(\^\s*(?:\w|\{[^{}]*\}))\s*(_(?:\w|\{[^{}]*\}|\\[a-z]+))", r"\2\1"),  # l^2_1 is l_1^2
    (r"\{\s*(?:\\(?:rm|it|bf)\s*|\\m?kern\s*-?[\d.]+\s*[a-z]{2}\s*)?\}(?!\s*[\^_])", ""),  # braces around nothing
    # of a whole equation
    (r"\\(?:boldsymbol|mathbf|textbf|bm|boxed)\s*(?=\{(?:[^{}=]|\{(?:[^{}]|\{[^{}]*\})*\})*=)", ""),
    (r"(?<![\^_])\{([-+=])\}", r" \1 "),  # a sign in braces, which LaTeX sets without blanks
    (r"=\s*\\pm(?=\s*\\sqrt)", "="),  # of a speed, whose square is compared
    (r"\\dot\{\\partial\}", r"\\partial\\dot "),  # a slip, of a partial derivative by a rate
    (  # the unit of a parameter: what stands between its number and the end
        r"(=\s*[-−]?\s*\d+(?:[.,]\d+)?)(?:\(\d+\))?"
        rf"(?:[\s~{{}}()/·*.]|\\[,;: ]|\\(?:mathrm|text|rm|frac|textrm|cdot|mbox)\b|{_UNIT})*{_UNIT}[\s}})]*$",
        lambda match: match[1].ljust(len(match[0])),
    ),
)
_OF_LATEX: tuple[Rewriting, ...] = (
    (r"\\(?=[()])", ""),  # of brackets with a mark
    # a point between quantities multiplies, as in m.a or P.Cos(\theta)
    (
        r"(?<=[\w)}])\.(?=[A-Za-z](?![A-Za-z])|[A-Za-z]{3}\s?\(|\\(?:sin|cos|tan|d?dot|theta|phi|varphi|omega|alpha)(?![A-Za-z]))",
        "*",
    ),
)
_OF_CODE: tuple[Rewriting, ...] = (
    (r"\((?:float|double|int|real)\)\s*(?=[\w(])", ""),  # of a value's kind
    (r"(?<=\d\.\d)f\b|(?<=\d\.)f\b|(?:(?<=\d\.)|(?<=\.\d))_[a-z]\w{0,5}\b", ""),  # of numbers in C and Fortran
    (r"(?<![\w\]})^_])_(?=[A-Za-z]\w*)", ""),  # a name that begins with _
    (r"(?:^\s*|(?<=[-+/=(,])\s*|(?<=\*)\s+)\*(?=[A-Za-z])", ""),  # of what a pointer leads to
    # in Fortran, and 3. for 3.0
    (r"(?<![\w.])(\d+)\.?(\.\d+)?[dD]0\b|(?<![\w.])(\d+)\.(?=\s+[*/+-]|\s*\))", r"\1\2\3"),
    (r"\b(?:M_PI|(?:Mathf\.)?PI)\b", "pi"),
    (r"(?i)\bfour_?thirds\b", "(4/3)"),
    (r"\b(?:pole|rod|pend|pendulum)_(?=(?:angle|theta)(?![a-z]))", ""),
    (r"(?<=\w['′])([234])(?=[\s*)]|$)", r"^\1"),  # a power that is no longer raised, as in θ1'2
    (r"\b(Pow|Sin|Cos|Tan|Sqrt|(?:sin|cos|tan|sqrt|pow)f)(?=\s*\()", lambda match: match[1].lower().rstrip("f")),
    (r"\.inv\(\)", "^(-1) "),
    # functions behind their argument, as in Rust: theta.sin().powi(2)
    (r"((?<![\w.])[\w.]+|\([^()]*\))\.(sin|cos|tan|sqrt)\(\)", r"\2(\1)"),
    (r"(\b\w+)\.diff\((?=\w)", r"diff(\1,"),
    (r"\.pow[if]?\((\d)(?:\.0)?\)", r"^\1"),
    # of an object: state.getTheta1()
    (r"\b\w+\.get_?([A-Za-z]\w*)\(\)", lambda match: match[1][0].lower() + match[1][1:]),
    (r"\b((?:[A-Za-z_]\w*\.)*[A-Za-z_]+?)(\d?)(?:\.|->)(_?)(?=[^\W\d])(\w+)\b(\s*\()?", _name_member),
    (r"\[[^\[\]]*\]'?", _mark_rows),
    # where others are there, it is a step in time
    (_SAMPLE, lambda match: match[0] if len({*re.findall(_SAMPLE, match.string)}) > 1 else ""),
    (_SOLVED, lambda match: match[0].replace("\\", "∖", 1)),
)
_PATTERNS = {  # of tokens, the first that fits; "" where LaTeX and plain text have it alike
    "environment": r"\\(?:begin|end)\s*\{\s*[A-Za-z]+\*?\s*\}(?:(?<=[yt]\})(?:\[\w\])?\{[^{}]*\}|(?<=[yd]\})\[\w\])?",
    "matrix": r"\\[pb]?mat(?:rix)?\s*\{",
    "prose": r"(?:\(\s*)?\\(?:text(?:rm|it|bf)?|mbox|intertext)\s*\{(?P<words>[^{}]*)\}\s*\)?",
    # Lagrange's, beside which L is a length
    "script": r"\\(?:math(?:cal|scr|frak)|cal)\s*(?:\{\s*[Ll]\s*\}|[Ll](?![A-Za-z]))|\{\s*\\cal\s+L\s*\}|ℒ",
    "plain": rf"\\(?:{'|'.join(_PLAIN.split())})\*?\s*\{{\s*[A-Za-z]+\d*\s*\}}|\{{\s*\\(?:rm|it)\s+[A-Za-z]+\s*\}}",
    "prime": r"\^\s*(?:\{\s*(?:(?:\\prime\b|['′])\s*)+\}|\\prime\b|['′])",
    "command": r"\\(?:[A-Za-z]+\*?|.)",
    "digit": r"(?<=[_^])\d|(?<=frac)\d|(?<=frac[\s\d])\d|(?<=frac\s[\da-z])\d",  # as in \frac12
    "number": r"(?<![(\[,\d])(?<![ijkn]=)(?:\d+\{,\}\d+|\d+,\d+(?!\d|\s*[,)\]]))"
    r"|(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][+-]?\d\d?(?![\w.]))?",
    "element": r"[A-Za-z]{1,2}[(\[]\d\s*,\s*\d[)\]]|(?!\d)\w+\[\d\]\s*\[\d\]"
    r"|(?!zeros|ones|frac)[A-Za-z]\w*(?:[(\[]\d{1,2}(?:,\s*[:1]|:\d)?[)\]]|[(\[]:,\s*\d{1,2}[)\]])",
    "mixed": r"(?<![A-Za-z])dd?[θφϕϑωα][0-9]?(?:_?dt)?(?![A-Za-z])(?!\s*/\s*dt)"
    r"|[θφϕϑωα][0-9]?_?dd?ot(?![A-Za-z])|[θφϕϑα][0-9]?dd?(?![A-Za-z])",
    "word": r"[A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9]+)*(?:_(?=\s+[-+]|[-+][A-Za-z]|\s*[*/=),;]|$))?",
    "sign": r"\*\*|==|:=|%2B|.",
}
_ONLY = {"digit": True, "element": False, "mixed": False}  # in LaTeX, or in plain text
_TOKEN = {
    latex: re.compile(
        "|".join(f"(?P<{kind}>{one})" for kind, one in _PATTERNS.items() if _ONLY.get(kind, latex) == latex), re.DOTALL
    )
    for latex in (True, False)
}
_BLANK = "~\u200b\u200c\u200d\u2061\u2062\u2063\u2064\ufe0f\ufeff"  # what looks like nothing
_PROSE_WORDS = {"and", "or", "with", "where", "so", "thus", "hence", "for", "if", "when"}
_CONDITION = re.compile(r"\b(?:for|if|when|at|near|provided|unless)\b")

# behind sin, where it is a name in code
_NAMES_VALUE = re.compile(r"\s*(?:=|[-+/)]|\*(?!\*)|\*\*\d\s*(?:[-+*/)]|$)|$)")

# J_1c is J_1 c
_INDEXED = re.compile(rf"(?:[A-Za-z]|{'|'.join(name for name in GREEK if name.isascii())})_\d(?=[A-Za-z])")


def is_latex(text: str) -> bool:
    """Whether an equation is printed in LaTeX rather than in plain text."""
    return bool(re.search(r"\\[A-Za-z,;:!|{(]|\{", text)) and not _SOLVED.match(text)


def tokens(text: str, most: int = MOST_CHARACTERS) -> list[Token]:
    """The tokens of a text. Raises Unread for one that is too long or too deep."""
    if len(text) > most:
        raise Unread(f"longer than {most:,} characters")
    latex, read = is_latex(text), rewrite(text, _REWRITTEN)
    read = rewrite(read, _OF_LATEX if latex else _OF_CODE)
    found, place = list[Token](), 0
    try:
        while place < len(read):
            first, *others = _scan(read, place, latex)
            end = others[-1].end if others else first.end
            if (
                read[place - 1 : place] == " " != text[place - 1 : place]
            ):  # of bob1.acc, read as acc_1, all is the token
                word = _WORD.search(text, max(0, place - LONGEST_NAME), place + 1)
                first = first._replace(start=word.start()) if word else first
            found += [token for token in (first, *others) if token.kind != "space"]
            place = end
    except RecursionError:
        raise Unread("nested too deeply") from None
    return found


def rewrite(text: str, table: tuple[Rewriting, ...]) -> str:
    """A text in which what matches is written otherwise, at the end of its place."""
    for pattern, by in table:
        write = by if callable(by) else lambda match, by=by: match.expand(by)
        text = re.sub(pattern, lambda match, write=write: write(match).rjust(len(match[0])), text)
    return text


def _scan(text: str, start: int, latex: bool) -> Iterator[Token]:
    """The token at one place, of a word perhaps several."""
    match = _TOKEN[latex].match(text, start)
    assert match is not None
    found, end = match[0], match.end()
    strange = lambda what: Token("strange", f"{what} has no meaning in an equation here", start, end)  # noqa: E731
    match match.lastgroup:
        case "environment":
            called = found[found.index("{") + 1 : found.index("}")].strip(" *")
            kind = "|" if called == "Vmatrix" else "open" if found.startswith(r"\begin") else "close"
            yield Token(kind, called, start, end) if called in MATRICES | ENVIRONMENTS | {"Vmatrix"} else strange(found)
        case "matrix":
            yield Token("open", "pmat", start, end)
        case "prose" if not re.fullmatch(r"[A-Za-z.]*", match["words"]) or match["words"] in _PROSE_WORDS:
            words = match["words"].strip()  # which end an equation, or are a condition
            yield Token("condition" if _CONDITION.search(words) else ",", words, start, end)
        case "prose" if r"\textbf" in found:
            yield Token("style", "textbf", start, start + found.index("{"))
        case "prose" | "plain":
            name: str = (re.findall(r"[A-Za-z]+\d*", found if match["words"] is None else match["words"]) or [""])[-1]
            kind = "function" if name in FUNCTIONS else "word" if name[-1:].isdigit() else "letter"
            yield Token(kind if name else "space", FUNCTIONS.get(name, name), start, end)
        case "script":
            yield Token("letter", SCRIPT_L, start, end)
        case "prime":
            yield Token("prime", "'" * len(re.findall("prime|['′]", found)), start, end)
        case "command":
            name = found[1:].rstrip("*") or "*"
            rate = name not in COMMANDS and (written := of_word(name)) and written.dots  # of a text's own, as \dtheta
            known = ("word", name) if rate else COMMANDS.get(name)
            yield Token(*known, start, end) if known else strange(f"\\{name}")
        case "digit" | "number":
            yield Token("number", found.replace("{,}", ".").replace(",", "."), start, end)
        case "mixed":  # dθ, θ1dot
            yield Token("word", "".join(GREEK.get(letter, letter) for letter in found), start, end)
        case "element" if re.split(r"\W", found)[0] not in FUNCTIONS:
            yield Token("word", found, start, end)
        case "element" | "word":
            word = re.match("[A-Za-z]+" if latex else r"[A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9]+)*_?", found)
            assert word is not None
            yield from _letters(word[0], start, latex, text)
        case _ if found != "\f" and (found.isspace() or found in _BLANK):
            yield Token("space", found, start, start + 1)
        case _ if CHARACTERS.get(found, ("",))[0] == "script":
            yield _script(text, Token(CHARACTERS[found][1], "", start, end), latex)
        case _:  # neither a digit nor a Latin letter; a letter with dots above is two
            apart = found.isalpha() and found not in CHARACTERS
            for letter in unicodedata.normalize("NFD", found) if apart else [found]:
                if letter not in CHARACTERS and not (letter.isascii() and letter.isalpha()):
                    yield strange(f"the character {found!r} (U+{ord(found):04X})")
                    return
                yield Token(*CHARACTERS.get(letter, ("letter", letter)), start, end)


def _script(text: str, mark: Token, latex: bool) -> Token:
    """What is raised or lowered: a number with its sign, a letter, or what stands in brackets."""
    inside, depth, place, sign = list[Token](), 0, mark.end, ""
    while not inside or depth:
        if place == len(text):
            reason = f"the bracket {inside[0].text} is not closed" if inside else "it ends too early"
            return Token("strange", reason, inside[0].start if inside else mark.start, place)
        new = list(_scan(text, place, latex))
        new = new if inside else new[:1]
        place = new[-1].end
        if strange := next((token for token in new if token.kind == "strange"), None):
            return strange._replace(end=place)
        if not inside and new[0].kind == "close":
            return Token("strange", f"{new[0].text!r} stands where an index or exponent should", mark.start, mark.end)
        if not inside and new[0].kind == "operator" and new[0].text in "+-" and not sign:
            sign = new[0].text
        elif new[0].kind not in ("space", "style"):
            depth += sum({"open": 1, "close": -1}.get(token.kind, 0) for token in new)
            inside += new
    texts = (
        token.kind * (token.kind in ("_", "^")) + token.text for token in inside if token.kind not in ("open", "close")
    )
    return mark._replace(text=sign + "".join(texts), end=place)


def _letters(word: str, place: int, latex: bool, text: str) -> Iterator[Token]:
    """A word: one name, or several letters and functions that are multiplied without a sign."""
    end = place + len(word)
    if word in _PROSE_WORDS and len(word) > 2:
        yield Token("condition" if _CONDITION.search(word) else ",", word, place, end)
    elif not latex and word in FUNCTIONS and _NAMES_VALUE.match(text, end):
        yield Token("word", word, place, end)
    elif (name := word.lower()) in FUNCTIONS and (word.islower() or text[end : end + 1] in ("(", "[")):
        yield Token("function", FUNCTIONS[name], place, end)
    elif not latex and (match := _INDEXED.match(word)) and not ((written := of_word(word)) and written.dots):
        yield Token("word", match[0], place, place + match.end())
        yield from _letters(word[match.end() :], place + match.end(), latex, text)
    else:
        over_dt = word == "dt" and text[:place].rstrip().endswith("/")
        code = "*" in text or (not text[:place].strip() and text[end:].lstrip()[:1] == "=")  # or a name with its value
        for part in ["d", "t"] if over_dt else spelled(word, latex, code):
            kind = "function" if part in FUNCTIONS else "word" if len(part) > 1 else "letter"
            yield Token(kind, FUNCTIONS.get(part, part), place, place + len(part))
            place += len(part)


def _pieces(found: list[Token]) -> list[tuple[list[Token], list[Token]]]:
    """What stands between separators outside brackets, with those before it.

    Without environments, & and gaps, and without brackets that begin an equation and hold all of it.
    """
    found = [one for one in found if one.text not in ENVIRONMENTS]
    closed, opened = dict[int, int](), list[int]()
    for i, token in enumerate(found):
        if token.kind == "open":
            opened.append(i)
        fits = [j for j in opened[-20:] if token.kind == "close" and CLOSING[found[j].text] == token.text]
        if fits:
            closed[fits[-1]] = i
            del opened[opened.index(fits[-1]) :]
    relations = [i for i, token in enumerate(found) if token.kind == "relation"]
    layout = set[int]()
    for i, token in enumerate(found):
        end = closed.get(i, len(found) if token.text == r"\{" else 0)
        begins = i == 0 or found[i - 1].kind in SEPARATORS or i - 1 in layout
        if begins and any(j < end for j in relations[bisect(relations, i) :][:1]):
            layout |= {i, end}
    pieces, around = list[tuple[list[Token], list[Token]]]([([], [])]), list[int]()  # openers around a token
    for i, token in enumerate(found):
        while around and closed[around[-1]] < i:
            around.pop()
        if i in layout:
            continue
        if not around and token.kind in SEPARATORS:
            if pieces[-1][1]:
                pieces.append(([], []))
            pieces[-1][0].append(token)
            continue
        in_matrix = bool(around) and found[around[-1]].text in MATRICES
        if token.kind != "gap" and (in_matrix or token.kind not in ("row", "&")):
            pieces[-1][1].append(token)
        if i in closed:
            around.append(i)
    return [pair for pair in pieces if pair[1]]


def cut(found: list[Token]) -> list[list[Token]]:
    r"""The tokens of each equation without layout: environments, & and gaps, and brackets around equations.

    An equation ends at \\ where what follows is not the rest of a sum, at a comma, and at & or \quad if there is a relation
    on both sides. What begins with = after \\ goes on with the chain before it, but is listed by itself.
    """
    equations = list[list[Token]]()
    for (marks, piece), (after, following) in pairwise([*_pieces(found), ([], [])]):
        kinds, begins, before = {token.kind for token in marks}, piece[0].kind, equations[-1] if equations else []
        between = [token for token in marks if token.kind in (".", "arrow relation")]
        if before and "row" in kinds and before[-1].kind == begins == "relation":  # a = \\ = b
            before.pop()
        ends_open = bool(before) and before[-1].kind in ("relation", "operator")
        is_left = {token.kind for token in after} == {"&"} and following[0].kind == "relation"  # as y in & y &= b
        both = _relates(before) and (_relates(piece) or is_left)
        if "row" in kinds:
            goes_on = begins == "condition" or ends_open or (begins in ("operator", "relation") and not both)
        elif kinds & {",", ";"}:
            names = [token.text for token in marks] == [","] and not any(map(_relates, equations))
            goes_on, between = names or begins == "condition", marks if names else between  # of a, b = c all is kept
        elif kinds == {"&"} and _relates(before) and begins == "open" and len(piece) <= MOST_OF_A_NUMBER and not both:
            continue
        else:
            goes_on = begins == "relation" or not both or kinds == {"."}
        if before and goes_on:
            before += between + piece
        else:
            equations.append(piece)
    if any(len(piece) > MOST_TOKENS for piece in equations):
        raise Unread(f"longer than {MOST_TOKENS:,} symbols")
    return equations


def _relates(found: list[Token]) -> bool:
    return any(token.kind == "relation" for token in found)
