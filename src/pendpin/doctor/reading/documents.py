"""Documents to statements: every equation of a LaTeX, Markdown, plain or TOML text, with the words around it."""

import re
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from html import unescape
from itertools import pairwise
from urllib.parse import unquote

from pendpin.doctor.reading.tokens import ENVIRONMENTS, cut, tokens
from pendpin.doctor.reading.tree import Unread
from pendpin.errors import InputError, shown

Formula = tuple[int, int, int, str]  # where it starts and ends with its marks, where it begins, and its text
MOST_BYTES = 2_000_000  # of a document
MOST_STATEMENTS, MOST_OF_A_DISPLAY = 500, 60_000  # of a document; characters
AROUND = 300  # characters of a sentence before and after an equation

_MARKS = {  # what opens a formula, and what closes it; where that is not said, it follows from what opens it
    r"\$\$": r"\$\$",
    r"\\\[": r"\\\]",
    r"\\\(": r"\\\)",
    r"(?<!\\)\$`": r"`\$",
    r"\$\{[\w.]+`": r"`\}",  # of JavaScript
    r"(?<!\\)\$": r"\$",
    r"```(?:math|\{math\})\s*\$\$": r"\$\$",
    r"```(?:math|\{math\})": "```",
    r":math:`|\{math\}`": "`",
    r"(?m:^\.\. math::[^\n]*$)": r"\n(?=\S)|\Z",
    r"<math[^<>]*>": "</math>|<math>",  # the other may be missing
    rf"\\begin\{{(?:{'|'.join(sorted(ENVIRONMENTS))})\*?\}}": "",
    r"\[(?:tex|itex|latex|math)\]": "",
    r"\{\\(?:display|text)style(?![A-Za-z])": "}",
}
_OPENERS = re.compile("|".join(f"({opener})" for opener in _MARKS))
_PICTURE = re.compile(
    r'!?(?:\[[^\n]*?\]\()?(?P<quoted>")?https?://[^\s"\'<>?]*(?:latex|math)[^\s"\'<>?]*\?(?:math=)?'
    r'(?P<formula>(?(quoted)[^"\'<>]+|[^\s"\'<>]+))'
)
_PREFIX = re.compile(r"\\(?:left|[bB]igg?l?|math[a-z]+|rm|it|cal)\s*\Z")
_PARAGRAPH = re.compile(r"(?:^[^\S\n]*\S[^\n]*(?:\n|\Z)){2,}", re.MULTILINE)
_HEADING = re.compile(r"(?m)^(?:#+ .*|\\(?:sub)*section\*?\{.*\}|[^\n]+\n(?:===+|---+))$")
# prints nothing, also where it holds an equals sign
_ESCAPED = re.compile(
    r"(?<!\\)\\\\(?=(?:d?frac|d?dot|theta|phi|omega|partial|sin|cos|left|right|mathcal|sqrt)\b)"
)  # in strings
_BLANK = re.compile(r"\\[hv]?phantom\*?\s*\{(?:[^{}]|\{[^{}]*\})*\}")
_SENTENCE = re.compile(
    r"(?<=[a-zA-Z0-9)}$\]])[.?!](?=\s+(?:[A-Z$*]|\\\[|$))|\n\s*\n(?=\s*\w)|\$\$\s*\n(?=[A-Z])|\n\s*[-*] |\\\\item"
)
_LABEL = re.compile(
    r"^\s*(?:>\s*|[-*+]\s+|\(?\d{1,3}[.):]\s+|\\item\s*)*(?:[^\W\d][\w ,'()（）-]{2,60}(?::\s+|：\s*))?"
)
_COMMENT = re.compile(
    r"\s+(?:#|//|%(?!2B))[^\n]*|[,;.]\s*$|\s+\(\w{1,5}\)\s*$|(?<=[\w)])\s+\"[^\"]*\"\s*;?\s*$"
    r"|\s+\([A-Za-z]+ (?:energy|of|for|from|about|in|the|is)\b[^()=]*\)\s*$"
)
# lines of comments in code that hold LaTeX: displays, or bare commands
_COMMENTED = re.compile(
    r"(?m)^(?:[ \t]*%(?![%\w]).*\n)*[ \t]*%.*\$\$.*\n(?:[ \t]*%.*\n?)*"
    r"|^[ \t]*(?:#(?!#)|//)[^$\n=]*\\[a-zA-Z]+[^$\n]*=[^$\n]*$"
)
_LABELLED = re.compile(r"\s*(?:#|%|//|!)+\s*(?:[Ee]q\w*\.?\s*)?\(?\d+\)?\s*[:.)]\s+")  # a comment such as % Eq 1: a = b
_BESIDE = re.compile(r"(?<![\\\w])([A-Za-z]{3,})[ ,]+(?=([A-Za-z]{2,})(?![\w(]))")
_BEFORE = re.compile(r"\s*((?:(?:[A-Za-z]{3,}|of|is|to|by|in)\s+)+)(?=[A-Za-z][^\s=+*/]*\s*=)")
_NO_EQUATION = re.compile(
    r"^\s*(?:for|while|if|elif|else|def|return|import|from|class|function|\w*print\w*)\b|[<>!]=|[-+*/]=|={3,}|(?:\bif\b|\?|&&|\|\|).*==|=>|\"\"|'{3}"
    r"|^\s*(?:plt\.|</?(?:img|a|div|p\s|!--|link|script|meta|table|t[dr]|html|svg|path|iframe|input)\b|\\(?:include|use|doc|set|new))|=\s*(?:None|True|False)\b|^\s*(?:\w+\.\s*)?(\w+)\s*=\s*(?:\w+\.)?\1\s*$"
)
_TYPED = re.compile(
    r"\s*(?:(?:parameter|constant|const|let|var|val|global|local|final|static|double|float|real|auto)\s+)+(?:Real\s+|double\s+|float\s+|(?:[A-Z]\w*\.)+[A-Z]\w*\s+)?",
    re.I,
)
_ADDED = re.compile(
    r"\s*(?:push!\(\s*(\w+)\s*,|(\w+)\.(?:append|push)\()(.*)\)\s*;?\s*$"
)  # a value to those of a quantity
_RETURNED = re.compile(r"\s*return\s+(?![\[{]|\w+(?:\(|\s*$))(?!.*[,=<>!?]|.*\b(?:if|and|or|not)\b)(.*[*/+-].*)$", re.S)
_RATES = re.compile(r"\s*return\s+(?:(?:[\w.]+\()?[\[(](.*)[\])]\)?|(.*,.*));?\s*$", re.S)  # of states, in their order
_TIME_STEP = r"(?:\w+(?:\.|->))?(?:dt|DT|Dt|tau|delta_?[tT]?(?:ime)?|[tT]ime_?[sS]tep|step|stepSize)"
_RATE = r"(?:[aA]cc\w*|[vV]el\w*|[dD]ot\w*|(?:omega|alpha|w|\bd\w+)_?\d?|_[va])"  # how a name of one ends
_STEPPED = re.compile(  # a step in time, omega += alpha*dt; without dt what is called like a rate is one
    r"\s*(?!(?:\w+\.)?t(?:ime)?\b)([^\W\d][\w.>\[\]-]*?)\s*(?:\+=|=\s*\1\s*\+(?!=))\s*"
    rf"(?:{_TIME_STEP}\s*\*\s*([\w.>\[\]-]+|\(.*\))|([\w.>\[\]-]+|\(.*\))\s*\*\s*{_TIME_STEP}|((?![dD][tT]\b)[\w.>-]*{_RATE}))"
    r"\s*;?\s*(?:(?:#|//|%).*)?$"
)
_UNPACKED = re.compile(  # x, v = state; or x = y[0]
    r"(?m)^\s*[\[(]?((?:[^\W\d]\w*\s*,\s*)+[^\W\d]\w*)[\])]?\s*=\s*[^\W\d]\w*\s*;?\s*(?:#.*)?$"
    r"|^\s*([^\W\d]\w*)\s*=\s*[^\W\d]\w*\[\d\]\s*;?\s*(?:#.*)?$"
)
_NAMING = re.compile(r"\s*[#%!]+\s*[A-Za-z]\w*[(\[]\d[)\]]\s*=\s*\w{1,12}'?\s*$")
_DEFINED = re.compile(r"^\s*(?:def|function)\s+(?:\w+\s*=\s*)?(\w+)\s*\(", re.MULTILINE)
_ANNOTATED = re.compile(r"(\s*\w+)(\s*:\s*[A-Za-z][\w.\[\], |]*?)(?=\s*=)")  # x: float = 1
_SEVERAL = re.compile(r"\s*([A-Za-z]\w*(?:\s*,\s*[A-Za-z]\w*)+)\s*=(?!=)([^;=]*);?\s*")  # x, y = l*sin(a), l*cos(a)
_LEFT = re.compile(r"((?:[^=]|(?<=[<>])=)+?)&?\s*=")
_GOES_ON = re.compile(r"(?:\s|\\displaystyle\b|&)*=")
_ENDS_OPEN = re.compile(r"[=+-](?:\s|\\\\|\\[,;!]|&)*$")
MOST_OF_A_LINE = 4000  # characters of code that go on over lines
_NOT_PROSE = """sin cos tan cot sec csc sqrt theta phi omega alpha beta psi gamma delta const constant mgl mgh dot ddot
varphi vartheta thetadot phidot ell lambda dtheta dphi ddtheta ddphi frac atan arctan mlg rho sigma eta tau"""
_NOT_WORDS = set(_NOT_PROSE.split())


@dataclass(frozen=True)
class Statement:
    """The text of one formula, where it stands, and the words around it; `name` is the key in a TOML file or mapping."""

    text: str
    place: str
    name: str = ""
    before: str = ""  # of its sentence, and the heading that it stands under
    after: str = ""
    section: int = 0  # the number of headings before it
    chained: bool = False  # its left side is that of the statement before it

    @property
    def context(self) -> str:
        """The words around it."""
        return f"{self.before} {self.after}"

    def line_of(self, index: int) -> str:
        """The place of what begins at a character of the text."""
        count = self.text.count("\n", 0, index)
        return f"line {int(self.place.removeprefix('line ')) + count}" if count else self.place


@dataclass(frozen=True, eq=False)
class Document:
    """The statements of a text, the whole text, and what a table of it says about symbols, rod and convention."""

    statements: tuple[Statement, ...]
    symbols: dict[str, str] = field(default_factory=dict)
    rod: str | None = None
    convention: str | None = None
    text: str = ""
    skipped: tuple[str, ...] = ()  # lines with an equals sign that are no equation

    @cached_property
    def sections(self) -> list[str]:
        """The text from each heading to the next; before the first heading what stands there."""
        cuts = [0, *(match.start() for match in _HEADING.finditer(self.text)), len(self.text)]
        return [self.text[start:end] for start, end in pairwise(cuts)]


def read_text(text: str) -> Document:
    """The formulas of a document between LaTeX's marks, and its lines and pieces of code that are equations."""
    found, skipped = list[tuple[int, Statement]](), list[str]()
    text = _BLANK.sub(_blank, _ESCAPED.sub(r" \\", _plain(text)))
    formulas = sorted({*_formulas(text), *_pictures(text)})
    formulas = sorted([*formulas, *_find_unmarked(text, formulas)])
    for start, end, begin, formula in _joined(text, formulas):
        found += [(begin + at, _statement(text, start, end, one, begin + at)) for at, one in equations_in(formula)]
    for start, end, one in _lines(text, [formula[:2] for formula in formulas], skipped):
        found.append((start, _statement(text, start, end, one, start)))
    chain: list[Statement] = []
    for _, one in sorted(found, key=lambda pair: pair[0])[:MOST_STATEMENTS]:
        if one.text.startswith("=") and chain and (left := _LEFT.match(chain[-1].text)):  # goes on with that left side
            one = replace(one, text=f"{left[1].strip()} {one.text}", chained=True)
        chain.append(one)
    return Document(tuple(chain), text=text, skipped=tuple(skipped))


def _plain(text: str) -> str:
    """The text with letters for HTML's entities, _ and ^ for its scripts; LaTeX in comments of code without their marks."""
    if not re.search(r"\\(?:section|documentclass|begin\{document\})", text):
        text = _COMMENTED.sub(lambda match: re.sub(r"(?m)^([ \t]*)(?:%+|#|//+)", _blank, match[0]), text)
    text = re.sub("&(?!lt;|gt;)[A-Za-z]+;", lambda match: unescape(match[0]), text)
    script = lambda match: ("_" if match[1] == "b" else "^") + (match[2] if match[2].isdigit() else f"({match[2]})")  # noqa: E731
    return re.sub(r"<su([bp])>([^<>]*)</su[bp]>", script, text)


def _blank(match: re.Match[str]) -> str:
    return " " * len(match[0])


def equations_in(formula: str) -> list[tuple[int, str]]:
    """The equations of a display or line, each with where it begins; of one that is not read, the whole.

    Where several names have values at once there is an equation for each, or for the column of names.
    """
    try:
        found = cut(tokens(formula, MOST_OF_A_DISPLAY))
    except Unread:
        return [(0, formula.strip())]
    equations = list[tuple[int, str]]()
    for i, piece in enumerate(found):
        kinds = [token.kind for token in piece]
        if "relation" not in kinds:
            continue
        prefix = _PREFIX.search(formula, 0, piece[0].start)  # \left and the like say nothing, but belong to it
        start, end = prefix.start() if prefix else piece[0].start, piece[-1].end
        left, value = formula[start : piece[kinds.index("relation")].start], piece[kinds.index("relation") + 1 :]
        names = [name.strip() for name in re.sub(r"^\s*\((.*)\)\s*$|,\s*$", r"\1", left).split(",")]
        if len(names) == 1 or not value or not all(re.fullmatch(r"(?:\w+\.\s*)?[^\W\d]\w*", name) for name in names):
            equations.append((start, formula[start:end]))
            continue
        more = [one for one in found[i + 1 : i + len(names)] if "relation" not in [token.kind for token in one]]
        values = [formula[one[0].start : one[-1].end] for one in (value, *more)]
        if values[0].startswith("sincos("):
            values = [f"{function}{values[0].removeprefix('sincos')}" for function in ("sin", "cos")]
        if len(values) == len(names):
            equations += [(start, f"{name} = {one}") for name, one in zip(names, values, strict=True)]
        else:
            equations.append((start, f"({', '.join(names)}) = {values[0]}"))
    return equations


def _statement(text: str, start: int, end: int, formula: str, begin: int) -> Statement:
    """A formula with its line and the sentence that it stands in."""
    before, after = text[max(0, start - AROUND) : start], text[end : end + AROUND]
    cut = [match.end() for match in _SENTENCE.finditer(before.rstrip())]
    before = before[cut[-1] :] if cut else before
    heading = _HEADING.findall(text[max(0, start - 6000) : start])
    closing = _SENTENCE.search(after)
    after = after[: closing.start() + 1] if closing else after
    before = f"{heading[-1] if heading else ''} {before}"
    section = len(_HEADING.findall(text[:start]))
    return Statement(formula, f"line {text.count(chr(10), 0, begin) + 1}", "", before, after, section)


def _formulas(text: str) -> Iterator[Formula]:
    """What stands between marks of mathematics."""
    place, missing = 0, set[str]()
    while match := _OPENERS.search(text, place):
        opener, place = match[0], match.end()
        own = opener.replace("begin", "end") if opener[0] == "\\" else opener.replace("[", "[/")
        closer = [*_MARKS.values()][(match.lastindex or 1) - 1] or re.escape(own)
        if closer in missing:
            continue
        closing = re.compile(closer).search(text, place)
        if closer == "}":
            depth, closing = 1, None
            for brace in re.finditer(r"(?<!\\)[{}]", text[: place + MOST_OF_A_LINE]):
                depth += (1 if brace[0] == "{" else -1) if brace.start() >= place else 0
                if depth == 0:
                    closing = brace
                    break
        if closing is None:
            missing |= {closer} - {"}"}
            continue
        body = text[place : closing.start()]
        if opener == "$" and "\n\n" in body:
            continue
        if "math" in opener and opener[0] in ".`":  # a blank line ends an equation
            ends = lambda match: " " * (len(match[0]) - 1) + "\f"  # noqa: E731
            body = re.sub(r"(?<=[^\s\\])[ \t]*\n(?=[ \t]*\n\s*\S)", ends, body)
        yield match.start(), closing.end(), place, body
        place = closing.end()


def _pictures(text: str) -> Iterator[Formula]:
    """The formulas in the addresses of their pictures."""
    for match in _PICTURE.finditer(text):
        formula = unescape(unquote(match["formula"].replace("&space;", " ")))
        while formula.endswith(")") and formula.count("(") < formula.count(")"):
            formula = formula[:-1]
        yield match.start(), match.end(), match.start("formula"), formula


def _find_unmarked(text: str, formulas: list[Formula]) -> Iterator[Formula]:
    """Lines of LaTeX without marks that are one equation together."""
    for match in _PARAGRAPH.finditer(text):
        bare = re.sub(r"\\[A-Za-z]+", " ", match[0])
        words = {*re.findall("[A-Za-z]{4,}", bare)} - _NOT_WORDS
        covered = any(start < match.end() and match.start() < end for start, end, _, _ in formulas)
        if bare != match[0] and bare.count("=") == 1 and not words and not covered:
            yield match.start(), match.end(), match.start(), match[0]


def _joined(text: str, formulas: list[Formula]) -> list[Formula]:
    """Formulas, where a display that may go on with the sum or the chain of the one before it is a row of that."""
    found: list[Formula] = []
    for start, end, begin, formula in formulas:
        beside = bool(_GOES_ON.match(formula))  # $x$ $= a$
        if found and (beside or text[start : start + 2] in ("$$", r"\[", r"\b", "``")):
            first, ended, at, before = found[-1]
            if beside and "=" not in before and not text[ended:start].strip():
                found[-1] = (first, end, at, before + " " * (begin - at - len(before)) + formula)
                continue
            goes_on = _ENDS_OPEN.search(before) or formula.lstrip(" &\n")[:1] in ("+", "-")
            if goes_on and not re.search(r"\w", text[ended:start]):
                between = "\f" + re.sub(r"[^\n]", " ", text[at + len(before) + 1 : begin])
                found[-1] = (first, end, at, before + between + formula)
                continue
        found.append((start, end, begin, formula))
    return found


def _lines(text: str, covered: list[tuple[int, int]], skipped: list[str]) -> Iterator[tuple[int, int, str]]:
    """Lines, and pieces of code within them, that are equations and stand outside the marks of mathematics.

    Each with where it begins and ends. Code goes on in the next line while a bracket is open, or after a sign.
    """
    start, spans, open_from = 0, iter([*covered, (len(text) + 1, len(text) + 1)]), -1
    span = next(spans)
    for number, line in enumerate(text.split("\n"), start=1):
        end = start + len(line)
        while span[1] <= start:
            span = next(spans)
        begin, start = start if open_from < 0 else open_from, end + 1
        whole, open_from = text[begin:end], -1
        quoted = text.count('"""', 0, begin) % 2  # code that is left out
        if (added := _ADDED.match(whole)) and not quoted:
            whole = f"{added[1] or added[2]} = {added[3]}"
        elif not quoted and (stepped := _STEPPED.match(whole)):
            whole = f"der({stepped[1]}) = {stepped[2] or stepped[3] or stepped[4]}"
        returns = not quoted and re.match(r"\s*return\b", whole)
        comment = whole.lstrip()[:1] in {"#", "%", "!"} and not _LABELLED.match(whole)
        if comment and _NAMING.match(whole):  # % X(1) = q1
            whole, comment = re.sub("[#%!]", " ", whole), False
        if span[0] < end or len(whole) > 20_000 or comment or not (returns or "=" in whole):
            continue
        bare = re.sub(r"(?<=[(,=\[\s])(['\"])[^'\"\n]*\1", "", whole)  # without strings and comments
        bare = re.sub(r"(?:#|//|(?<!\\)%).*", "", bare)
        bracket = bare.count("(") > bare.count(")") or bare.count("[") > bare.count("]")
        goes_on = bracket or re.search(r"(?:\.\.\.|\\|[-+*/=])\s*$", bare)
        if len(whole) < MOST_OF_A_LINE and goes_on and "\\" not in bare.rstrip()[:-1]:
            open_from = begin
            continue
        if returns:
            yield from ((begin, end, one) for one in _returned(whole, text[:begin]))
            continue
        codes = [(match.start(1), match[1]) for match in re.finditer(r"`([^`=]*=[^`]*)`", whole)]
        parts = [(at + i, one) for at, part in codes or _in_line(whole) for i, one in equations_in(part)]
        pieces = [(begin + at, end, one) for at, one in parts if codes or not _NO_EQUATION.search(one)]
        if not pieces:
            skipped.append(f"line {number}")
        yield from pieces


def _returned(line: str, before: str) -> Iterator[str]:
    """What a function of code returns: a value for its name, or rates, one for each of the states that it begins with."""
    functions = [*_DEFINED.finditer(before)]
    if functions and (value := _RETURNED.match(line)):
        yield f"{functions[-1][1]} = {value[1]}"
    elif functions and (rates := _RATES.match(line)) and not re.search(r"[=<>'\"]", line):
        values, unpacked = _at_commas(rates[1] or rates[2]), [*_UNPACKED.finditer(before, functions[-1].end())]
        every = [*(_at_commas(one[1]) for one in unpacked if one[1]), [one[2] for one in unpacked if one[2]]]
        states = next((names for names in every if 1 < len(names) == len(values)), list[str]())
        pairs = [pair for pair in zip(states, values, strict=False) if pair[1] not in (f"{pair[0]}_dot", f"d{pair[0]}")]
        moves = len(pairs) < len(states) or {*states} & {*values}  # of angles and rates the rate of an angle is one
        if moves and not any(name in values and rate in states for name, rate in pairs):  # else in another order
            yield from (f"{name}_dot = {rate}" for name, rate in pairs)


def _at_commas(text: str) -> list[str]:
    """The parts between commas outside brackets."""
    found = list[str]()
    for part in text.split(","):
        if found and any(found[-1].count(opened) > found[-1].count(closed) for opened, closed in ("()", "[]")):
            found[-1] += f",{part}"
        else:
            found.append(part)
    return [part.strip() for part in found]


def _in_line(line: str) -> Iterator[tuple[int, str]]:
    """A plain line without its label, comments and the like, and where that begins; nothing of one that is prose."""
    line = re.sub(r"\.\.\.[^\n]*\n|\\\n", lambda match: " " * (len(match[0]) - 1) + "\n", line)
    if annotated := _ANNOTATED.match(line):
        line = annotated[1] + " " * len(annotated[2]) + line[annotated.end() :]
    label = _LABELLED.match(line) or _LABEL.match(line)
    begin = label.end() if label and "=" not in label[0] else 0
    if typed := _TYPED.match(line[begin:]):
        begin += typed.end()
    equation = line[begin:].rstrip()
    while (shorter := _COMMENT.sub(lambda match: " " * len(match[0]), equation).rstrip()) != equation:
        equation = shorter
    equation = re.sub(r",\s*dtype\s*=\s*[\w.]+", lambda match: " " * len(match[0]), equation)  # of an array's numbers
    bare = re.sub(r"\\[A-Za-z]+|\\text\{[^}]*\}", " ", equation)
    beside = sum(not {*pair} & _NOT_WORDS for pair in _BESIDE.findall(bare))  # words with nothing but a space between
    prose = beside > 1 or (";" not in equation and _NO_EQUATION.search(bare))
    if "=" in equation and not prose and "|" not in equation.replace("||", "").lstrip()[:1]:
        if (words := _BEFORE.match(equation)) and not {*words[1].split()} & _NOT_WORDS:
            begin, equation = begin + words.end(), equation[words.end() :]
        several = len(equation) < MOST_OF_A_LINE and _SEVERAL.fullmatch(equation)
        names, values = (_at_commas(part) for part in (several.groups() if several else ("", "")))
        pairs = zip(names, values, strict=True) if several and len(names) == len(values) else ()
        yield from ([(begin, f"{name} = {value}") for name, value in pairs] or [(begin, equation)])


def read_toml(data: bytes, place: str) -> Document:
    """The tables [equations] and [symbols] of a TOML file. Raises InputError."""
    try:
        tables = tomllib.loads(data.decode())
    except (ValueError, RecursionError) as error:  # of TOML, of its letters, of numbers with thousands of digits
        raise InputError(f"{place}: not TOML: {error}") from None
    unknown = [name for name in tables if name not in ("equations", "symbols", "rod", "convention")]
    if unknown:
        raise InputError(f"{place}: {shown(unknown[0])}: unknown key; known are equations, symbols, rod and convention")
    for name in ("equations", "symbols"):
        table = tables.setdefault(name, {})
        if not isinstance(table, dict):
            raise InputError(f"{place}: {name}: {shown(table)} is not a table")
        for key, value in table.items():
            if not isinstance(value, str):
                raise InputError(f"{place}: {name}.{key}: {shown(value)} is not text; write it in quotes")
        if name == "equations" and not table:
            raise InputError(f'{place}: equations: missing; write [equations] and below it name = "expression"')
    for name in ("rod", "convention"):
        if name in tables and not isinstance(tables[name], str):
            raise InputError(f"{place}: {name}: {shown(tables[name])} is not text")
    found, rod, convention = tuple(statements(tables["equations"])), tables.get("rod"), tables.get("convention")
    return Document(found, tables["symbols"], rod, convention)


def statements(equations: dict[str, str] | Iterable[str]) -> Iterator[Statement]:
    """Named or numbered equations as statements."""
    pairs = equations.items() if isinstance(equations, dict) else (("", text) for text in equations)
    for number, (name, text) in enumerate(pairs, start=1):
        if number > MOST_STATEMENTS:
            return
        text = text.strip().strip("$").strip()
        if found := equations_in(text):  # without layout around it
            as_printed = all(text.startswith(one, at) for at, one in found)
            end = found[-1][0] + len(found[-1][1])
            text = text[found[0][0] : end] if as_printed else ", ".join(one for _, one in found)
        yield Statement(text, name or f"equation {number}", name)


def text_of(value: object) -> str | None:
    """The text of an Eq, expression or column of sympy, its functions of time as names; None for anything else."""
    from sympy import Derivative, Eq, Expr, MatrixBase, Symbol
    from sympy.core.function import AppliedUndef

    if isinstance(value, Eq):
        left, right = text_of(value.lhs), text_of(value.rhs)
        return None if left is None or right is None else f"{left} = {right}"
    if isinstance(value, MatrixBase):
        return f"({', '.join(str(text_of(entry)) for entry in value)})"
    if not isinstance(value, Expr):
        return None
    rates = {}
    for one in value.atoms(Derivative):
        if isinstance(one.expr, AppliedUndef):
            name, dots = one.expr.func.__name__, "d" * int(one.derivative_count)
            rates[one] = Symbol(f"\\{dots}ot{{{name}}}" if name.startswith("\\") else dots + name)
    value = value.xreplace(rates)
    return str(value.xreplace({one: Symbol(one.func.__name__) for one in value.atoms(AppliedUndef)}))
