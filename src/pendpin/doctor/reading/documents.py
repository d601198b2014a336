"""Documents to statements: every equation of a LaTeX, Markdown, plain or TOML text, with the words around it."""

import re
import tomllib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from html import unescape
from itertools import islice, pairwise
from typing import Any
from urllib.parse import unquote

from pendpin.doctor.reading.macros import expand_macros
from pendpin.doctor.reading.tokens import ENVIRONMENTS, cut, tokens
from pendpin.doctor.reading.tree import Unread
from pendpin.errors import InputError, shown
from pendpin.ground import files

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
    r"```(?:math(?!\w)|\{math\})": "```",
    r":math:`|\{math\}`": "`",
    r"(?m:^\.\. math::[^\n]*$)": r"\n(?=\S)|\Z",
    r"<math[^<>]*>": "</math>|<math>",  # the other may be missing
    rf"\\begin\{{(?:{'|'.join(sorted(ENVIRONMENTS))})\*?\}}": "",
}
_BRACED = r"\{(?:[^{}]|\{(?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*\})*\}"
_PLAIN = (  # other languages in LaTeX and letters
    (r"<sub>(\w+)</sub>", r"_\1"),
    (r"(?m)^[ \t]*#[ \t]*define[ \t]+([A-Za-z]\w*)[ \t]+(?=[-\w(.])", r"\1 = "),  # of C
    (r"(?<=[\w;)])[ \t]*/\*[^\n*]*\*/", ""),  # and its comments
    (r"<sup>(\w+)</sup>", r"^\1"),
    (r"(\\begin\{align(?:at|edat)\*?\})\{\d\}", r"\1   "),  # how many columns
    (r"(?ms)^```(?!math|\{)(\w+[^\n]*\n(?:(?!```).)*\n)```", r"~~~\1~~~"),  # code
    (rf"\\[hv]?phantom\*?\s*{_BRACED}", " "),  # also where it holds an equals sign
    # in strings
    (r"(?<!\\)\\\\(?=(?:d?frac|d?dot|theta|phi|omega|partial|sin|cos|left|right|mathcal|sqrt|begin|end)\b)", r" \\"),
)
_OPENERS = re.compile("|".join(f"({opener})" for opener in _MARKS))
_PICTURE = re.compile(
    r'!?(?:\[[^\n]*?\]\()?(?P<quoted>")?https?://[^\s"\'<>?]*(?:latex|math)[^\s"\'<>?]*\?(?:math=)?'
    r'(?P<formula>(?(quoted)[^"\'<>]+|[^\s"\'<>]+))'
)
_LOOK = re.compile(r"^(?:\s*\\(?:bg_\w+|fn_\w+|dpi\{\d+\}|inline|(?i:tiny|small|large|huge)\b))+")  # of a picture
_PREFIX = re.compile(r"\\(?:left|[bB]igg?l?|math[a-z]+|rm|it|cal)\s*\Z")
_HEADING = re.compile(r"(?m)^(?:#+ .*|~~~.*|\\(?:sub)*section\*?\{.*\}|[^\n]+\n(?:===+|---+))$")
_SENTENCE = re.compile(
    r"(?<=[a-zA-Z0-9)}$\]])[.?!](?=\s+(?:[A-Z$*]|\\\[|$))|\n\s*\n(?=\s*\w)|\$\$\s*\n(?=[A-Z])|\n\s*[-*] "
)
_LABEL = re.compile(
    r"^\s*(?:>\s*|[-*+•]\s+|\(?\d{1,3}[.):]\s+|\\item\s*)*(?:[^\W\d][\w ,'()（）-]{2,60}(?::\s+|：\s*))?"
    r"(?:[A-Z][a-z]{3,} (?:[a-z]{4,} )?(?=[A-Za-z]\w{0,2}\s*=))?"  # Kinetic energy T = ...
)
_COMMENT = re.compile(r"\s+(?:#|//|%(?!2B))[^\n]*|[,;.]\s*$|(?<=[\w)])\s+\"[^\"]*\"\s*;?\s*$")
_REMARK = re.compile(r"(?m)^[ \t]*(?:#+|///?|%+|!+|\*)(?=\s)")
_BESIDE = re.compile(r"(?<![\\\w])([A-Za-z]{3,})[ ,]+(?=([A-Za-z]{2,})(?![\w(]))")
_NO_EQUATION = re.compile(
    r"^\s*(?:for|while|do|if|elif|else|def|return|import|from|class|function|\w*print\w*)\b|[<>!]=|[-+*/]=|={3,}|(?:\bif\b|\?|&&|\|\|).*==|=>|\"\""
    r"|^\s*(?:plt\.|</?(?:img|a|div|p\s|!--|link|script|meta|table|t[dr]|html|svg|path|iframe|input)\b|<\w+\s+[\w-]+=[\"']|\\(?:include|use|doc|set|new))|=\s*(?:None|True|False)\b|=\s*(?:\w+\.)*(?:symbols|Symbol|dynamicsymbols|Function|syms?|SX|MX)\s*\(|^\s*(?:\w+\.\s*)?(\w+)\s*=\s*(?:\w+\.)?\1(?:\(\w+\))?\s*$"
)
_RETURNED = re.compile(r"\s*return\s+(?![\[{]|\w+(?:\(|\s*$))(?!.*[,=<>!?]|.*\b(?:if|and|or|not)\b)(.*[*/+-].*)$", re.S)
_RATES = re.compile(  # of states, in their order: return v, a or dydt = [v, a]
    r"\s*(?:return\s+|(?:[dD]|\w*[dD](?:ot|eriv))\w*\s*=\s*(?=[\w.]*[\[(]))"
    r"(?:[\w.]+\([\[(]([^=<>'\"]*)[\])]\)|[\[(]([^=<>'\"]*)[\])]|([^=<>'\"]*,[^=<>'\"]*));?\s*$"
)
_TIME_STEP = r"(?:\w+(?:\.|->))?(?:dt|DT|Dt|tau|delta_?[tT]?(?:ime)?|[tT]ime_?[sS]tep|step|stepSize)"
_RATE = r"(?:[aA]cc\w*|[vV]el\w*|[dD]ot\w*|(?:omega|alpha|w|\bd\w+)_?\d?|_[va]|angle[VA])"  # how a name of one ends
_GROUP = r"\((?:[^()]|\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\))*\)"  # brackets, four of them within each other at most
_FACTOR = rf"-?(?:[\w.>\[\]]*{_GROUP}|[\w.>\[\]-]+)(?:(?:\*\*|\^)\d)?"
_TERM = rf"{_FACTOR}(?:\s*[*/]\s*{_FACTOR})*"
_OF_NEW = re.compile(r"^(?:new|next)_?(?=\w)|(?<=\w)_?[nN](?:ew|ext)$")


def _rate_in_step(match: re.Match[str]) -> str:
    """What a step in time says of a rate; that of theta is omega also where omega_new is the last one."""
    value = match[4] or match[5] or match[6]
    return f"der({match[1]}) = {'-' * ('-' in match.group(2, 3))}{_OF_NEW.sub('', value)}"


_BY_NAME = r"(?:THETA|PHI|OMEGA|ALPHA)_?\d?"
_CODE: tuple[tuple[str, str | Callable[[re.Match[str]], str]], ...] = (  # lines of code in plain notation
    (r"^\s*(?:push!\(\s*(\w+)\s*,|(\w+)\.(?:append|push)\()(.*)\)\s*;?\s*$", r"\1\2 = \3"),
    (  # a step in time, omega += alpha*dt, says what the rate is; without dt what is called like a rate is one
        r"^\s*(?!(?:\w+\.)?t(?:ime)?\b)(?:new_?|next_?)?([^\W\d][\w.>\[\]-]*?)(?:_?[nN](?:ew|ext))?\s*"
        rf"(?:([+-])=|=\s*\1\s*([+-])(?!=))\s*\(?(?:{_TIME_STEP}\s*\*\s*({_TERM})|({_TERM}?)\s*\*\s*{_TIME_STEP}"
        rf"|((?![dD][tT]\b)[\w.>-]*{_RATE}))\)?\s*;?\s*(?:(?:#|//|%).*)?$",
        _rate_in_step,
    ),
    (  # so does d_omega = alpha*dt
        rf"^\s*(?:\w+\.)?d(?:elta)?_?([A-Za-z]\w*)\s*=\s*(?:{_TIME_STEP}\s*\*\s*({_TERM})|({_TERM}?)\s*\*\s*{_TIME_STEP})"
        r"\s*;?\s*(?:(?:#|//|%).*)?$",
        lambda match: f"der({match[1]}) = {match[2] or match[3]}",
    ),
    (
        r"(?i)^\s*(?:(?:parameter|constant|const|let|var|val|global|local|final|static|double|float|real|auto)\s+)+"
        r"(?:Real\s+|double\s+|float\s+|(?:[A-Z]\w*\.)+[A-Z]\w*\s+)?",
        "",
    ),
    (r"^(\s*\w+)\s*:\s*[A-Za-z][\w.\[\], |]*?(?=\s*=)", r"\1"),  # x: float = 1
    (r"^\s*[A-Za-z]\w+[\s&*]+(?=[^\W\d]\w*\s*=(?!=)[\s\S]*;\s*(?://.*)?$)", ""),  # qreal x = 1;
    (r"(?i)\b(?:mass|length|angle|radius|force)\s+(?=[^\W\d_]\w{0,2}\s*=)", ""),  # mass m = 0.1 kg
    (r",\s*dtype\s*=\s*[\w.]+", ""),  # of an array's numbers
    # what a table holds by its name: params["m1"], and params.get("m1", 1.0)
    (r"\b[\w.]+(?:\[|\.get\()\s*(['\"])([^\W\d]\w*)\1\s*(?:,[^(),]*)?[\])]", r"\2"),
    (r"^\s*\w+\s*=\s*(?:\w+\.)?Eq\(([\s\S]*)\)\s*$", lambda match: " = ".join(_at_marks(match[1]))),  # of sympy
    # of a solver that looks for where expressions vanish
    (r"^\s*[eE][qQ]n?_?\d*\s*=(?=[^=#%]*[*+-])([^=#%;]+?)\s*;?\s*(?:[#%].*)?$", r"\1 = 0"),
    (r"^\s*(\w+)\((?=1:2|2:3|3:4|4:5|5:6)(\d):(\d)\)(?=\s*=(?!=))", r"[\1(\2); \1(\3)]"),  # two entries at once
    # an element by its name: dydx[THETA_1] = y[OMEGA_1]
    (rf"^\s*d\w*\[({_BY_NAME})\](?=\s*=)", lambda match: f"der({match[1].lower()})"),
    (rf"\b\w+\[({_BY_NAME})\]", lambda match: match[1].lower()),
)
_INDEXED = re.compile(r"(\\[a-z]{2,}|(?<![A-Za-z\\])[A-Za-z])_\{?(\d)\}?(?!\w)")
_RECORDS = re.compile(r"\bd([a-z]\w*)\.\w+\s*=(?!=)")
_MEMBER = re.compile(r"\bm_([ml])\d?\b")  # of an object in C++: m_m1, m_l1
_AGAIN = re.compile(r"\s*([^\W\d]\w*)\s*([-+*/])=(?!=)\s*(.*?)\s*;?\s*(?:(?:#|//|%).*)?$", re.S)  # x /= 2
_INDEX = r"\[\s*{}\s*(?:[+-]\s*1\s*)?\]"
_OF_ARRAYS = re.compile(rf"\s*([^\W\d][\w.]*){_INDEX.format('([a-z])')}\s*=\s*\1{_INDEX.format(chr(92) + '2')}")
_STEPPED = re.compile(r"(?m)^\s*[\w.>\[\]-]+\s*\+=\s*[^\n=]*?\*\s*([^\W\d]\w*[A-Za-z])\s*;?\s*$")
_UNPACKED = re.compile(  # x, v = state; or x = y[0]
    r"(?m)^\s*[\[(]?((?:[^\W\d]\w*\s*,\s*)+[^\W\d]\w*)[\])]?\s*=\s*[^\W\d]\w*\s*;?\s*(?:#.*)?$"
    r"|(?:^|;)[^\S\n]*([^\W\d]\w*)\s*=\s*[^\W\d]\w*[\[(]\d[\])]\s*(?=;|#|%|$)"
)
_ENTRY = re.compile(r"\b([^\W\d]\w*)([\[(])(\d)[\])]")
_DEFINED = re.compile(r"^\s*(?:def|function)\s+(?:\w+\s*=\s*)?(\w+)\s*\(([\w, ]*)", re.MULTILINE)
_SEVERAL = re.compile(  # x, y = a, b; also with a dot above, as in Julia
    r"\s*\(?((?:(?:self\.)?[^\W\d][\w\u0307\u0308]*\s*,\s*)+(?:self\.)?[^\W\d][\w\u0307\u0308]*)\)?,?\s*:?=(?!=)\s*(.*)",
    re.S,
)
_QUOTED = re.compile(r"(?<![`$\w])`([^`$\n=]*=[^`$\n]*)`(?![`$])")  # `a = b` between words
_LEFT = re.compile(r"((?:[^=]|(?<=[<>])=)+?)&?\s*=")
_ENDS_OPEN = re.compile(r"[=+-](?:\s|\\\\|\\[,;!]|&)*$")
_INDENTED = r"(?:\t|[ \t]{3,})[-+*/](?![-+*/=])[^\n;]*"
_GOES_ON = re.compile(rf"(?:{_INDENTED}\n){{0,20}}?{_INDENTED};[ \t]*(?://.*)?$", re.M)
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
    """The formulas of a document between LaTeX's marks, and its lines that are equations."""
    found, skipped, text = list[tuple[int, Statement]](), list[str](), expand_macros(text)
    text = re.sub("&(?!lt;|gt;)[A-Za-z]+;", lambda match: unescape(match[0]), text)
    for pattern, by in _PLAIN:
        text = re.sub(pattern, by, text)
    if {"m", "l"} <= set(_MEMBER.findall(text)) and not re.search(r"\$|\\[a-z]{3}", text):
        text = re.sub(r"\bm_(?=[A-Za-z])", "", text)
    for name in ("u", "tau"):  # the one load of a vector of inputs
        text = text if re.search(rf"\b{name}\[[1-9:]", text) else re.sub(rf"\b{name}\[0\]", name, text)
    for record in {name for name in _RECORDS.findall(text) if re.search(rf"\b{name}\.\w", text)}:  # ds.x beside s.x
        text = re.sub(rf"\bd{record}\.(\w+)(?=\s*=(?!=))", rf"der({record}.\1)", text)
    for name, index in {*_INDEXED.findall(text)}:  # m2 beside m_2
        begins = "" if name.startswith("\\") else r"(?<![\w\\^])"
        text = re.sub(rf"{begins}{re.escape(name)}{index}(?!\w)", re.escape(f"{name}_{index}"), text)
    pictures = {*_pictures(text)}  # which may hold the marks of others
    alone = (one for one in _formulas(text) if not any(start < one[0] < end for start, end, *_ in pictures))
    formulas = sorted({*alone, *pictures})
    for start, end, begin, formula in _joined(text, formulas):
        found += [(begin + at, _statement(text, start, end, one, begin + at)) for at, one in equations_in(formula)]
    for start, end, one in _lines(text, [formula[:2] for formula in formulas], skipped):
        found.append((start, _statement(text, start, end, one, start)))
    chain: list[Statement] = []
    for _, one in sorted(found, key=lambda pair: pair[0])[:MOST_STATEMENTS]:
        if one.text.startswith("=") and chain and (left := _LEFT.match(chain[-1].text)):  # goes on with that left side
            one = replace(one, text=f"{left[1].strip()} {one.text}", chained=True)
        chain.append(one)
    if not chain and (said := _REMARK.sub(lambda match: " " * len(match[0]), text)) != text:
        return read_text(said)  # code whose comments alone hold equations
    return Document(tuple(chain), text=text, skipped=tuple(skipped))


def equations_in(formula: str) -> list[tuple[int, str]]:
    """The equations of a display or line, each with where it begins; of one that is not read, the whole."""
    try:
        found = cut(tokens(formula, MOST_OF_A_DISPLAY))
    except Unread:
        return [(0, formula.strip())]
    equations = list[tuple[int, str]]()
    for piece in found:
        if any(token.kind == "relation" for token in piece):
            prefix = _PREFIX.search(formula, 0, piece[0].start)  # \left and the like say nothing, but belong to it
            start = prefix.start() if prefix else piece[0].start
            equations.append((start, formula[start : piece[-1].end]))
    return equations


def _statement(text: str, start: int, end: int, formula: str, begin: int) -> Statement:
    """A formula with its line and the sentence that it stands in."""
    before, after = text[max(0, start - AROUND) : start], text[end : end + AROUND]
    sentences = [0, *(match.end() for match in _SENTENCE.finditer(before.rstrip()))]
    headings, closing = _HEADING.findall(text[:start]), _SENTENCE.search(after)
    after = after[: closing.start() + 1] if closing else after
    before = f"{headings[-1] if headings else ''} {before[sentences[-1] :]}"
    return Statement(formula, f"line {text.count(chr(10), 0, begin) + 1}", "", before, after, len(headings))


def _formulas(text: str) -> Iterator[Formula]:
    """What stands between marks of mathematics."""
    place, missing = 0, set[str]()
    while match := _OPENERS.search(text, place):
        opener, place = match[0], match.end()
        closer = [*_MARKS.values()][(match.lastindex or 1) - 1] or re.escape(opener.replace("begin", "end"))
        closing = None if closer in missing else re.compile(closer).search(text, place)
        if closing is None:
            missing.add(closer)
            continue
        body = text[place : closing.start()]
        if opener == "$" and "\n\n" in body:
            continue
        if "math" in opener and opener[0] in ".`":  # a blank line ends an equation, an option as :label: is none
            body = re.sub(r"(?m)^\s*:\w+:[^\n]*$", lambda match: " " * len(match[0]), body)
            ends = lambda match: " " * (len(match[0]) - 1) + "\f"  # noqa: E731
            body = re.sub(r"(?<=[^\s\\])[ \t]*\n(?=[ \t]*\n\s*\S)", ends, body)
        yield match.start(), closing.end(), place, body
        place = closing.end()


def _pictures(text: str) -> Iterator[Formula]:
    """The formulas in the addresses of their pictures."""
    for match in _PICTURE.finditer(text):
        formula = _LOOK.sub("", unescape(unquote(match["formula"].replace("&space;", " "))))
        while formula.endswith(")") and formula.count("(") < formula.count(")"):
            formula = formula[:-1]
        yield match.start(), match.end(), match.start("formula"), formula


def _joined(text: str, formulas: list[Formula]) -> list[Formula]:
    """Formulas, where a display that may go on with the sum or the chain of the one before it is a row of that."""
    found: list[Formula] = []
    for start, end, begin, formula in formulas:
        first, ended, at, before = found[-1] if found else (0, 0, 0, "=")
        is_display = bool(found) and text[start : start + 2] in ("$$", r"\[", r"\b", "``")
        is_rest = is_display and (_ENDS_OPEN.search(before) or formula.lstrip(" &\n")[:1] in ("+", "-"))
        if is_rest and not re.search(r"\w", text[ended:start]):
            between = "\f" + re.sub(r"[^\n]", " ", text[at + len(before) + 1 : begin])
            found[-1] = (first, end, at, before + between + formula)
        else:
            found.append((start, end, begin, formula))
    return found


def _lines(text: str, covered: list[tuple[int, int]], skipped: list[str]) -> Iterator[tuple[int, int, str]]:
    """Lines that are equations and stand outside the marks of mathematics.

    Each with where it begins and ends. Code goes on in the next line while a bracket is open, or after a sign.
    """
    steps = {name for name, often in Counter(_STEPPED.findall(text)).items() if often > 1}  # in time, whatever its name
    start, spans, open_from = 0, iter([*covered, (len(text) + 1, len(text) + 1)]), -1
    span = next(spans)
    for number, line in enumerate(text.split("\n"), start=1):
        end = start + len(line)
        while span[1] <= start:
            span = next(spans)
        begin, start = start if open_from < 0 else open_from, end + 1
        whole, open_from = text[begin:end], -1
        if span[0] < end or len(whole) > 20_000:
            continue
        quoted = text.count('"""', 0, begin) % 2  # code that is left out
        if (step := _STEPPED.match(whole)) and step[1] in steps:
            whole = f"{whole[: step.start(1)]}dt"
        if stepped := _OF_ARRAYS.match(whole):  # omega[i + 1] = omega[i] + ...: as of omega itself
            whole = re.sub(_INDEX.format(stepped[2]), "", whole)
        for pattern, by in () if quoted else _CODE:
            whole = re.sub(pattern, by, whole)
        again = None if quoted else _AGAIN.match(whole)  # of what was computed
        if again and re.search(rf"(?m)^[^\n=(]*\b{again[1]}\s*:?=(?!=)", text[:begin]):
            whole = f"{again[1]} = {again[1]} {again[2]} ({again[3]})"
        returns = not quoted and re.match(r"\s*return\b", whole)
        if whole.lstrip()[:1] in {"#", "%", "!"} or whole.lstrip()[:2] in {"//", "/*"} or not (returns or "=" in whole):
            continue
        bare = re.sub(r"(?<=[(,=\[\s])(['\"])[^'\"\n]*\1", "", whole)  # without strings and comments
        bare = re.sub(r"(?:#|//|(?<!\\)%).*|\\[ \t]*(?=\n)", "", bare)
        bracket = bare.count("(") > bare.count(")") or bare.count("[") > bare.count("]")
        following = text[end + 1 : end + MOST_OF_A_LINE]  # in C a line goes on until the semicolon
        divided = re.match(r"[ \t]*/\s*[(\[\w]", following) or (";" not in bare and _GOES_ON.match(following))
        goes_on = bracket or divided or re.search(r"(?:\.\.\.|\\|[-+*/=])\s*&?\s*$", bare)
        if len(whole) < MOST_OF_A_LINE and goes_on and "\\" not in bare.rstrip()[:-1]:
            open_from = begin
            continue
        rates = [*_returned(whole, text, begin)] if returns or _RATES.match(whole) else []
        if returns or rates:
            yield from ((begin, end, one) for one in rates)
            continue
        marked = [(quote.start(1), quote[1]) for quote in _QUOTED.finditer(whole)] or [(0, whole)]
        each = [(at + i, one) for at, code in marked for i, part in _in_line(code) for one in _for_each_name(part)]
        parts = [(at + i, one) for at, part in each for i, one in equations_in(part)]
        pieces = [(begin + at, end, one) for at, one in parts if not _NO_EQUATION.search(one)]
        if not pieces:
            skipped.append(f"line {number}")
        yield from pieces


def _returned(line: str, text: str, begin: int) -> Iterator[str]:
    """What a function of code returns: a value for its name, or rates, one for each of the states that it begins with."""
    functions = [*_DEFINED.finditer(text[:begin])]
    if functions and (value := _RETURNED.match(line)):
        yield f"{functions[-1][1]} = {value[1]}"
    elif functions and (rates := _RATES.match(line)):
        inside = next(filter(None, rates.groups()), "").rstrip("; \n")  # none of an empty list
        values = _at_marks(inside, ";") if len(_at_marks(inside, ";")) > 1 else _at_marks(inside)
        unpacked = [*_UNPACKED.finditer(text[:begin], functions[-1].end())]
        every = [*(_at_marks(one[1]) for one in unpacked if one[1]), [one[2] for one in unpacked if one[2]]]
        given, count = _at_marks(functions[-1][2]), len(values)  # f(t, th, om) may give om and another
        windows = (given[i : i + count] for i in range(len(given) - count + 1))
        every.append(max(windows, key=lambda some: len({*some} & {*values}), default=list[str]()))
        fits = lambda names: 1 < len(names) == count and (names is not every[-1] or {*names} & {*values})  # noqa: E731
        states = next(filter(fits, every), list[str]())
        pairs = [pair for pair in zip(states, values, strict=False) if pair[1] not in (f"{pair[0]}_dot", f"d{pair[0]}")]
        moves = len(pairs) < len(states) or {*states} & {*values}  # of angles and rates the rate of an angle is one
        if moves and not any(name in values and rate in states for name, rate in pairs):  # else in another order
            for name, rate in pairs:
                plain = "_" not in name and name[1:] not in states
                yield f"{name}_dot = {rate}" if plain else f"der({name}) = {rate}"
        # the states may have no names: return [y[1], -sin(y[0])]; what stands twice is of two branches
        entries = {(one[1], one[2]) for one in _ENTRY.finditer(inside) if one[1] in _at_marks(functions[-1][2])}
        start = re.escape(re.split(r"[=\[]", line)[0].strip())
        once = len(re.findall(rf"(?m)^[^\S\n]*{start}\s*=?\s*[\w.(]*\[", text)) < 2
        if not states and once and len(entries) == 1 and any(map(_ENTRY.fullmatch, values)):
            ((name, bracket),) = entries
            first, closing = (0, "]") if bracket == "[" else (1, ")")
            yield from (f"d{name}{bracket}{i}{closing} = {rate}" for i, rate in enumerate(values, start=first))


def _for_each_name(line: str) -> list[str]:
    """Code that gives several names their values at once, as an equation for each, or for the column of names."""
    if not (several := _SEVERAL.fullmatch(line)):
        return [line]
    right = re.sub(r"^sincos(\(.*\))$", r"sin\1, cos\1", several[2].rstrip(" ;"))
    names, values = _at_marks(several[1]), _at_marks(right)
    if len(names) == len(values):
        return [f"{name} = {value}" for name, value in zip(names, values, strict=True)]
    return [f"({', '.join(names)}) = {several[2]}"]


def _at_marks(text: str, by: str = ",") -> list[str]:
    """The parts between commas, or other marks, outside brackets."""
    found = list[str]()
    for part in text.split(by):
        if found and any(found[-1].count(opened) > found[-1].count(closed) for opened, closed in ("()", "[]")):
            found[-1] += by + part
        else:
            found.append(part)
    return [part.strip() for part in found]


def _in_line(line: str) -> Iterator[tuple[int, str]]:
    """A plain line without its label, comments and the like, and where that begins; nothing of one that is prose."""
    line = re.sub(r"\.\.\.[^\n]*\n|\\\n|&[ \t]*\n[ \t]*&?", lambda match: " " * (len(match[0]) - 1) + "\n", line)
    label = _LABEL.match(line)
    begin = label.end() if label and "=" not in label[0] else 0
    equation = line[begin:].rstrip()
    while (shorter := _COMMENT.sub(lambda match: " " * len(match[0]), equation).rstrip()) != equation:
        equation = shorter
    bare = re.sub(r"\\[A-Za-z]+|\\text\{[^}]*\}", " ", equation)
    beside = sum(not {*pair} & _NOT_WORDS for pair in _BESIDE.findall(bare))  # words with nothing but a space between
    prose = beside > 1 or _NO_EQUATION.search(bare)
    if "=" in equation and not prose and "|" not in equation.replace("||", "").lstrip()[:1]:
        yield begin, equation


def read_toml(data: bytes, place: str) -> Document:
    """The tables [equations] and [symbols] of a TOML file. Raises InputError."""
    try:
        tables = tomllib.loads(files.text_of(data, "TOML"))
    except InputError as error:
        raise InputError(f"{place}: {error}") from None
    except (ValueError, RecursionError) as error:  # of TOML, of its letters, of numbers with thousands of digits
        raise InputError(f"{place}: not TOML: {error}") from None
    kinds = {"equations": "a table", "symbols": "a table", "rod": "text", "convention": "text"}
    if unknown := [name for name in tables if name not in kinds]:
        raise InputError(f"{place}: {shown(unknown[0])}: unknown key; known are equations, symbols, rod and convention")
    tables: dict[str, Any] = {"equations": {}, "symbols": {}} | tables
    for name, value in tables.items():
        if not isinstance(value, dict if kinds[name] == "a table" else str):
            raise InputError(f"{place}: {name}: {shown(value)} is not {kinds[name]}")
        for key, one in value.items() if isinstance(value, dict) else ():
            if not isinstance(one, str):
                raise InputError(f"{place}: {name}.{key}: {shown(one)} is not text; write it in quotes")
    if not tables["equations"]:
        raise InputError(f'{place}: equations: missing; write [equations] and below it name = "expression"')
    found = tuple(statements(tables["equations"]))
    return Document(found, tables["symbols"], tables.get("rod"), tables.get("convention"))


def statements(equations: dict[str, str] | Iterable[str]) -> Iterator[Statement]:
    """Named or numbered equations as statements."""
    pairs = equations.items() if isinstance(equations, dict) else (("", text) for text in equations)
    for number, (name, text) in enumerate(islice(pairs, MOST_STATEMENTS), start=1):
        yield Statement(text.strip().strip("$").strip(), name or f"equation {number}", name)


def text_of(value: object) -> str | None:
    """The text of an Eq, expression or matrix of sympy, without LaTeX in its names; None for anything else."""
    from sympy import Eq, Expr, MatrixBase

    if not isinstance(value, Eq | Expr | MatrixBase):
        return None
    return re.sub(r"[\\{}]", "", f"{value.lhs} = {value.rhs}" if isinstance(value, Eq) else str(value))
