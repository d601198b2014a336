"""Documents to statements: every equation of a LaTeX, Markdown, plain or TOML text, with the words around it."""

import re
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

from pendpin.errors import InputError, shown

MOST_BYTES = 2_000_000  # of a document
MOST_STATEMENTS = 500
AROUND = 300  # characters of a sentence before and after an equation

_LINES = (
    "equation|align|aligned|alignat|gather|gathered|multline|eqnarray|split|flalign|displaymath|math|cases|subequations"
)
_OPENERS = re.compile(rf"\$\$|\\\[|\\\(|(?<!\\)\$`?|\\begin\{{(?:{_LINES})\*?\}}|```math|\n")
_CLOSERS = {"$$": "$$", r"\[": r"\]", r"\(": r"\)", "$": "$", "$`": "`$", "```math": "```"}
_WRAPPING = re.compile(rf"\\(?:begin|end)\{{(?:{_LINES})\*?\}}(?:\{{[^{{}}]{{0,20}}\}})?")
_BOX = re.compile(r"\s*\\f?boxe?d?\{(.*)\}\s*", re.DOTALL)
_HEADING = re.compile(r"(?m)^(?:#+ .*|\\(?:sub)*section\*?\{.*\}|[^\n]+\n(?:===+|---+))$")
_SENTENCE = re.compile(
    r"(?<=[a-zA-Z0-9)}$\]])[.?!](?=\s+(?:[A-Z$*]|\\\[|$))|\n\s*\n(?=\s*\w)|\$\$\s*\n(?=[A-Z])|\n\s*[-*] |\\\\item"
)
_LABEL = re.compile(r"^\s*(?:>\s*|[-*+]\s+|\(?\d{1,3}[.):]\s+|\\item\s*)*(?:[A-Za-z][\w ,'()-]{2,60}:\s+)?")
_COMMENT = re.compile(r"\s+(?:#|//|%).*$|[,;.]\s*$|\s+\(\w{1,5}\)\s*$")
_WORD = re.compile(r"(?<![\\\w])[A-Za-z]{3,}(?![\w(])")
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

    @cached_property
    def sections(self) -> list[str]:
        """The text from each heading to the next; before the first heading what stands there."""
        cuts = [0, *(match.start() for match in _HEADING.finditer(self.text)), len(self.text)]
        return [self.text[start:end] for start, end in pairwise(cuts)]


def read_text(text: str) -> Document:
    """The formulas of a document between LaTeX's marks, and its lines and pieces of code that are equations."""
    found, covered = [], []
    for start, end, begin, formula in _formulas(text):
        covered.append((start, end))
        if "=" in formula:
            found.append((start, _statement(text, start, end, formula, begin)))
    found += [(start, statement) for start, statement in _lines(text, covered)]
    ordered = [statement for _, statement in sorted(found, key=lambda pair: pair[0])]
    return Document(tuple(ordered[:MOST_STATEMENTS]), text=text)


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


def _formulas(text: str) -> Iterator[tuple[int, int, int, str]]:
    """What stands between marks of mathematics: where it starts and ends with them, where it begins, and the formula."""
    place, missing = 0, set[str]()
    while match := _OPENERS.search(text, place):
        opener = match[0]
        place = match.end()
        closer = _CLOSERS.get(opener) or opener.replace("begin", "end")
        if opener == "\n" or closer in missing:
            continue
        end = text.find(closer, place)
        if end < 0:
            missing.add(closer)
            continue
        body = text[place:end]
        if opener == "$" and "\n\n" in body:
            continue
        formula, begin = unwrapped(body)
        yield match.start(), end + len(closer), place + begin, formula
        place = end + len(closer)


def _lines(text: str, covered: list[tuple[int, int]]) -> Iterator[tuple[int, Statement]]:
    """Lines, and pieces of code within them, that are equations and stand outside the marks of mathematics."""
    start, spans = 0, iter([*covered, (len(text) + 1, len(text) + 1)])
    span = next(spans)
    for line in text.split("\n"):
        end = start + len(line)
        while span[1] <= start:
            span = next(spans)
        if "=" in line and span[0] >= end and line[0] not in "#%" and len(line) < 20_000:
            for inside, equation in _in_line(line):
                yield start + inside, _statement(text, start + inside, end, equation, start + inside)
        start = end + 1


def _in_line(line: str) -> Iterator[tuple[int, str]]:
    """The equations of a plain line."""
    if codes := list(re.finditer(r"`([^`=]*=[^`]*)`", line)):
        yield from ((match.start(1), match[1]) for match in codes)
        return
    label = _LABEL.match(line)
    begin = label.end() if label and "=" not in label[0] else 0
    equation = line[begin:]
    while (shorter := _COMMENT.sub("", equation)) != equation:
        equation = shorter
    equation = equation.rstrip().removesuffix("\\\\").strip()
    words = [
        word for word in _WORD.findall(re.sub(r"\\[A-Za-z]+|\\text\{[^}]*\}", " ", equation)) if word not in _NOT_WORDS
    ]
    sentences = [word for word in words if word.islower()]
    if equation and len(sentences) < 3 and "|" not in equation.replace("||", "")[:1]:
        yield begin, equation


def unwrapped(text: str) -> tuple[str, int]:
    """A formula without the environments and boxes around its lines, its blank ends cut, and where in the text it begins."""
    box = _BOX.fullmatch(text)
    inner = _WRAPPING.sub(lambda match: " " * len(match[0]), box[1] if box else text)
    return inner.strip(), (box.start(1) if box else 0) + len(inner) - len(inner.lstrip())


def read_toml(data: bytes, place: str) -> Document:
    """The tables [equations] and [symbols] of a TOML file. Raises InputError."""
    try:
        tables = tomllib.loads(data.decode())
    except (ValueError, RecursionError) as error:  # of TOML, of its letters, of numbers with thousands of digits
        raise InputError(f"{place}: not TOML: {error}") from None
    unknown = [name for name in tables if name not in ("equations", "symbols", "rod", "convention")]
    if unknown:
        raise InputError(f"{place}: {shown(unknown[0])}: unknown key; known are equations, symbols, rod and convention")
    equations = _texts(tables.get("equations", {}), "equations", place)
    if not equations:
        raise InputError(f'{place}: equations: missing; write [equations] and below it name = "expression"')
    symbols = _texts(tables.get("symbols", {}), "symbols", place)
    words = {name: tables[name] for name in ("rod", "convention") if name in tables}
    for name, value in words.items():
        if not isinstance(value, str):
            raise InputError(f"{place}: {name}: {shown(value)} is not text")
    return Document(tuple(statements(equations)), symbols, words.get("rod"), words.get("convention"))


def _texts(table: Any, name: str, place: str) -> dict[str, str]:
    if not isinstance(table, dict):
        raise InputError(f"{place}: {name}: {shown(table)} is not a table")
    for key, value in table.items():
        if not isinstance(value, str):
            raise InputError(f"{place}: {name}.{key}: {shown(value)} is not text; write it in quotes")
    return table


def statements(equations: dict[str, str] | Iterable[str]) -> Iterator[Statement]:
    """Named or numbered equations as statements."""
    pairs = equations.items() if isinstance(equations, dict) else (("", text) for text in equations)
    for number, (name, text) in enumerate(pairs, start=1):
        if number > MOST_STATEMENTS:
            return
        yield Statement(unwrapped(text.strip().strip("$").strip())[0], name or f"equation {number}", name)
