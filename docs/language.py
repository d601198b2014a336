"""Flags the patterns of stiff English that a machine can find: `python docs/language.py` prints every place.

It reads the pages, the README, the unreleased changes, and from the source errors, notes, help and the docstrings of public
names. A test holds that nothing is flagged. Code, tables and generated parts are left out; a formula or `code` is one word.
"""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

TOP = Path(__file__).parents[1]
MOST_WORDS = 40  # in a sentence; English textbooks of mechanics have 20 on average
NUMBER = r"[-+±]?\d[\d.,]*(?:e[-+]?\d+)?"
UNIT = r"(?:\s?(?:%|°|ms|s|µs|us|ns|m|mm|cm|kg|N|J|rad|GB|MB|kB|Hz|degrees|times)\b)?"
NOUNS = "ledger|kink|seam|witness|judge|rival|leg|goal|referee|hearer"  # ours alone

RULES = {  # name: pattern in a sentence; what to write instead
    "Of ... in front": (r"^Of (?!course)", "start with the subject"),
    "is no N": (
        r"(?<!there )\b(?:is|are|was|were) no(?:ne\b| (?!more|less|other|better|worse|\w+er than|longer|larger|closer))",
        "is not a N",
    ),
    "What ... as a noun": (r"^What\b(?![^?]*\?)|\b(?:of|by|from|than|for|at|with) what\b", "name the thing"),
    "goes on": (r"\b(?:go|goes|going|went|gone) on\b(?! \d)", "continue, resume"),
    "is taken": (
        r"\b(?:is|are|was|were|be|been) taken\b(?! (?:from|about|apart|out of))|\bto take\b",
        "use, choose, need",
    ),
    "whole": (
        r"\b(?:written|as|out|read|kept|file|is|are|be) whole\b(?! \w+s?\b)|\bthe whole of\b",
        "complete, all of",
    ),
    "so many, so much": (r"\bso (?:many|much|few|little|long a|short a|large a|small a)\b", "say how many"),
    "ends so": (r"\b(?:end|ends|ended|stay|stays|stand|stands) so\b|\bfor ever\b", "say how"),
    "numbers in a row": (rf"(?:{NUMBER}{UNIT}(?:, (?:and |or )?| and | or | to )){{3}}{NUMBER}", "a table"),
    "colons and semicolons": (r"[:;]\s.*[:;]\s", "two sentences"),
    "words of builders": (rf"\b(?:{NOUNS})s?\b|\bbooks\b|\b(?:hand|hands|handed) down\b|\bhears\b", "the field's word"),
}
ALLOWED = {("CHANGELOG.md", "colons and semicolons"), ("CHANGELOG.md", "too long")}  # an entry is a list of changes
PATTERNS = {
    name: re.compile(pattern, re.IGNORECASE if name[0].islower() else 0) for name, (pattern, _) in RULES.items()
}
GENERATED = re.compile(r"<!-- (figures|table|peers) -->.*?<!-- end of \1 -->", re.DOTALL)
LEFT_OUT = re.compile(  # front matter, fences, lines of tables, headings, pictures and code, formulae
    r"\A---\n.*?\n---\n|^ *(`{3,}|:{3,}).*?^ *\1|^ *\|.*?$|^#+ .*?$|^!\[.*?$|^ {4,}\S.*?$|\$\$.*?\$\$", re.M | re.S
)
ABBREVIATIONS = re.compile(r"\b(e\.g|i\.e|cf|No|pp|vs|(?:(?<=[A-Z]\. )|(?<=\()|(?<=: )|(?<=and ))[A-Z])\.(?= )")
ASIDE = re.compile(
    r"\([^()]*\)|^(?:(?:effects\[X\]|line X|[^\s:;,]+)(?:,? (?:and |column )?[\w.-]+)?: )+"
)  # and labels
END = re.compile(r"(?<=[.!?])[)\"']?\s+(?=[\"'(]?[A-ZΑ-Ω`0-9])")


def blanked(match: re.Match[str]) -> str:
    """What is left out, as empty lines: line numbers stay."""
    return "\n" * match[0].count("\n")


def plain(text: str) -> str:
    """One paragraph as a line of words: code and formulae as C, links as their text."""
    text = re.sub(r"!?\[([^]A-Z][^]]*)\]\([^)]*\)", r"\1", " ".join(text.split()))
    text = re.sub(r"!?\[[^]]*\]\([^)]*\)", "CODE", text)  # the title of a page
    text = re.sub(r"`+[^`]+`+|\$[^$]+\$|:\w+:`[^`]+`|<[^>]+>|https?://\S+", "CODE", text)
    return ABBREVIATIONS.sub(r"\1", re.sub(r"[*_]{1,2}(?=\w)|(?<=[\w.,:)])[*_]{1,2}", "", text))


def paragraphs(text: str) -> Iterator[tuple[int, str]]:
    """(line, paragraph) of Markdown or of a docstring: an entry of a list, or of Args, is a paragraph of its own."""
    start, lines = 1, []
    for number, line in enumerate([*text.split("\n"), ""], 1):
        new = not line.strip() or re.match(
            r"\s*(?:[-*] |\d+\. |> |\w+: (?=\S))|\s*(?:Args|Returns|Raises|Example):", line
        )
        if new and lines:
            yield start, " ".join(lines)
            lines = []
        if line.strip():
            start = start if lines else number
            lines.append(re.sub(r"^\s*(?:[-*] |\d+\. |> )", "", line))


def sentences(text: str) -> Iterator[tuple[int, str]]:
    """(line, sentence) of a text."""
    for line, paragraph in paragraphs(text):
        yield from ((line, sentence) for sentence in END.split(plain(paragraph)) if sentence)


def page(path: Path) -> str:
    """The prose of a page; of the changes those that are not released."""
    text = path.read_text(encoding="utf-8")
    if path.name == "CHANGELOG.md":
        text = "\n## ".join(text.split("\n## ")[:2])
    return LEFT_OUT.sub(blanked, GENERATED.sub(blanked, text))


def words_of(node: ast.AST | None) -> str | None:
    """A string with its placeholders as X; None if a node is something else."""
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.JoinedStr(values=parts):
            return "".join(words_of(part) or "X" for part in parts)
    return None


def public_names() -> set[str]:
    """The names of `pendpin` and of its effects."""
    homes = (TOP / "src/pendpin/__init__.py", TOP / "src/pendpin/effects/__init__.py")
    text = "".join(home.read_text(encoding="utf-8").split("__all__ = [")[1].split("]")[0] for home in homes)
    return set(re.findall(r"\w+", text))


def docstrings(tree: ast.Module, public: set[str], commands: bool) -> Iterator[tuple[int, str]]:
    """(line, docstring) of what users see: commands, public names and their methods."""
    for node in tree.body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef) and (node.name in public or commands):
            methods = node.body if isinstance(node, ast.ClassDef) else []
            for one in [node, *methods]:
                if isinstance(one, ast.ClassDef | ast.FunctionDef) and not one.name.startswith("_"):
                    yield one.lineno, ast.get_docstring(one) or ""


def messages(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """(line, text) of the errors, notes and help texts of a file: strings of three words and more in calls."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            for value in [*node.args, *(k.value for k in node.keywords if k.arg in ("help", "description"))]:
                if (text := words_of(value)) and text.count(" ") >= 3:
                    yield node.lineno, text


def flags(sentence: str) -> Iterator[tuple[str, str]]:
    """(rule, what to write instead) of all that is stiff in a sentence."""
    bare = ASIDE.sub("", sentence)
    if not bare[:1].isupper() or bare.startswith("X"):  # a message may be fault: reason; remedy
        bare = re.sub(r"[:;]", "", bare, count=1)
    for name, pattern in PATTERNS.items():
        if pattern.search(bare if name.startswith("colons") else sentence):
            yield name, RULES[name][1]
    if (count := len(sentence.split())) > MOST_WORDS:
        yield "too long", f"{count} words: two sentences"


def texts() -> Iterator[tuple[Path, int, str]]:
    """(file, line, text) of everything that is read."""
    pages = [*(TOP / "docs").rglob("*.md"), TOP / "README.md", TOP / "CHANGELOG.md"]
    yield from ((path, 0, page(path)) for path in sorted(pages) if "reference/api" not in path.as_posix())
    public = public_names()
    for path in sorted((TOP / "src").rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for line, text in [*docstrings(tree, public, "commands" in path.parts), *messages(tree)]:
            yield path, line - 1, text


def findings() -> list[str]:
    """A line for each flag: place, rule, advice, sentence."""
    return [
        f"{path.relative_to(TOP)}:{start + line}: {rule} ({advice}): {sentence}"
        for path, start, text in texts()
        for line, sentence in sentences(text)
        for rule, advice in flags(sentence)
        if (path.name, rule) not in ALLOWED
    ]


if __name__ == "__main__":
    found = findings()
    print(*found, sep="\n")
    sys.exit(bool(found))
