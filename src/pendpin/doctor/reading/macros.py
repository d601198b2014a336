r"""The macros of a LaTeX document, \newcommand, \def and \DeclareMathOperator, written out where they are used."""

import re

MOST_ROUNDS = 8  # of macros within each other
LARGEST = 4  # times the document: what grows beyond that is left as it is
_DEFINES = re.compile(
    r"\\(?:(?:new|renew|provide)command\*?|def|DeclareMathOperator\*?)\s*\{?\s*\\([A-Za-z]+)\s*\}?\s*(?:\[(\d)\])?(?:#\d)*\s*(?=\{)"
)
_LINES = re.compile(r"[^\n]")


def expand_macros(text: str) -> str:
    """A document with the macros that it defines written out, its lines numbered as before."""
    if not _DEFINES.search(text):
        return text
    macros: dict[str, tuple[int, str]] = {}
    while match := _DEFINES.search(text):
        end = _closing(text, match.end())
        macros[match[1]] = int(match[2] or 0), text[match.end() + 1 : end - 1].replace("\n", " ").strip()
        text = text[: match.start()] + _LINES.sub(" ", text[match.start() : end]) + text[end:]
    used, most = re.compile(rf"\\({'|'.join(map(re.escape, macros))})(?![A-Za-z])"), LARGEST * len(text)
    for _ in range(MOST_ROUNDS):
        pieces, place = list[str](), 0
        for match in used.finditer(text):
            if match.start() < place:  # within an argument: in the next round
                continue
            count, body = macros[match[1]]
            end = match.end()
            for i in range(1, count + 1):
                begin = end
                while text[begin : begin + 1].isspace():
                    begin += 1
                end = _closing(text, begin) if text[begin : begin + 1] == "{" else begin + 1
                argument = text[begin + 1 : end - 1] if text[begin : begin + 1] == "{" else text[begin:end]
                body = body.replace(f"#{i}", argument.replace("\n", " "))
            apart = " " * (body[-1:].isalpha() and text[end : end + 1].isalpha())
            pieces += [text[place : match.start()], body, apart, "\n" * text.count("\n", match.start(), end)]
            place = end
        longer = "".join([*pieces, text[place:]])
        if longer == text or len(longer) > most:
            break
        text = longer
    return text


def _closing(text: str, begin: int) -> int:
    """Where the braces that begin at a place are closed; the end of the text where they are not."""
    depth = 0
    for brace in re.compile(r"(?<!\\)[{}]").finditer(text, begin):
        depth += 1 if brace[0] == "{" else -1
        if depth == 0:
            return brace.end()
    return len(text)
