r"""The macros of a LaTeX document, \newcommand, \def and \DeclareMathOperator, written out where they are used."""

import re

MOST_ROUNDS = 8  # of macros within each other
LARGEST = 4  # times the document: what grows beyond that is left as it is
_DEFINES = re.compile(
    r"\\(?:(?:new|renew|provide)command\*?|def|DeclareMathOperator\*?)\s*\{?\s*\\([A-Za-z]+)\s*\}?\s*(?:\[(\d)\])?(?:#\d)*\s*(?=\{)"
)
_USED, _LINES = re.compile(r"\\([A-Za-z]+)"), re.compile(r"[^\n]")


def expand_macros(text: str) -> str:
    """A document with the macros that it defines written out, its lines numbered as before."""
    if not _DEFINES.search(text):
        return text
    macros, kept, place = dict[str, tuple[int, str]](), list[str](), 0
    for match in _DEFINES.finditer(text):
        if match.start() >= place:  # not within another one
            end = _closing(text, match.end())
            macros[match[1]] = int(match[2] or 0), text[match.end() + 1 : end - 1].replace("\n", " ").strip()
            kept += [text[place : match.start()], _LINES.sub(" ", text[match.start() : end])]
            place = end
    text, most = "".join([*kept, text[place:]]), LARGEST * len(text)
    for _ in range(MOST_ROUNDS):
        pieces, place, size = list[str](), 0, len(text)
        for match in _USED.finditer(text):
            if match.start() < place or match[1] not in macros:  # within an argument: in the next round
                continue
            count, body = macros[match[1]]
            end = match.end()
            for i in range(1, count + 1):
                begin = end
                while text[begin : begin + 1].isspace():
                    begin += 1
                end = _closing(text, begin) if text[begin : begin + 1] == "{" else begin + 1
                argument = text[begin + 1 : end - 1] if text[begin : begin + 1] == "{" else text[begin:end]
                if len(body) + body.count(f"#{i}") * len(argument) > most:
                    return text
                body = body.replace(f"#{i}", argument.replace("\n", " "))
            apart = " " * (body[-1:].isalpha() and text[end : end + 1].isalpha())
            pieces += [text[place : match.start()], body, apart, "\n" * text.count("\n", match.start(), end)]
            place, size = end, size + len(body)
            if size > most:
                return text
        if not pieces:
            break
        text = "".join([*pieces, text[place:]])
    return text


def _closing(text: str, begin: int) -> int:
    """Where the braces that begin at a place are closed; the end of the text where they are not."""
    depth = 0
    for brace in re.compile(r"(?<!\\)[{}]").finditer(text, begin):
        depth += 1 if brace[0] == "{" else -1
        if depth == 0:
            return brace.end()
    return len(text)
