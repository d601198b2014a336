"""Documents to statements: the formulas of a LaTeX or Markdown text, the lines of a plain one, the tables of a TOML file."""

import re
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from pendpin.errors import InputError, shown

MOST_BYTES = 2_000_000  # of a document
MOST_STATEMENTS = 500

_LINES = (
    "equation|align|aligned|alignat|gather|gathered|multline|eqnarray|split|flalign|displaymath|math|cases|subequations"
)
_OPENERS = re.compile(rf"\$\$|\\\[|\\\(|(?<!\\)\$|\\begin\{{(?:{_LINES})\*?\}}|```math|\n")
_CLOSERS = {"$$": "$$", r"\[": r"\]", r"\(": r"\)", "$": "$", "```math": "```"}
_WRAPPING = re.compile(rf"\\(?:begin|end)\{{(?:{_LINES})\*?\}}(?:\{{[^{{}}]{{0,20}}\}})?")

_BOX = re.compile(r"\s*\\f?boxe?d?\{(.*)\}\s*", re.DOTALL)


@dataclass(frozen=True)
class Statement:
    """The text of one formula and where it stands; `name` is the key in a TOML file or mapping."""

    text: str
    place: str
    name: str = ""

    def line_of(self, index: int) -> str:
        """The place of what begins at a character of the text."""
        count = self.text.count("\n", 0, index)
        return f"line {int(self.place.removeprefix('line ')) + count}" if count else self.place


@dataclass(frozen=True)
class Document:
    """The statements of a text, and what it says about symbols, rod and convention."""

    statements: tuple[Statement, ...]
    symbols: dict[str, str]
    rod: str | None = None
    convention: str | None = None


def read_text(text: str) -> Document:
    """The formulas of a document; where it has none in LaTeX's marks, its lines that hold an equals sign."""
    found = list(_formulas(text))
    if not found:
        lines = enumerate(text.splitlines(), start=1)
        marked = ((i, line.strip()) for i, line in lines if "=" in line)
        found = [Statement(line, f"line {i}") for i, line in marked if line[0] not in "#%"]
    return Document(tuple(found[:MOST_STATEMENTS]), {})


def _formulas(text: str) -> Iterator[Statement]:
    """What stands between marks of mathematics and holds an equals sign."""
    place, line, counted, missing = 0, 1, 0, set[str]()
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
        line, counted = line + text.count("\n", counted, match.start()), match.start()
        place = end + len(closer)
        if "=" in body:
            formula, begin = unwrapped(body)
            yield Statement(formula, f"line {line + body.count(chr(10), 0, begin)}")


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
