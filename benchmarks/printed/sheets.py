"""Sheets of right equations (sheets.txt), each printed in ten notations, as authors of textbooks print them."""

import ast
import re
from collections.abc import Callable
from pathlib import Path

FOLDER = Path(__file__).parent
GREEK = {"theta": "θ", "phi": "φ", "omega": "ω", "tau": "τ"}
NAME = re.compile(r"(d{0,2})(theta|phi|omega|tau|[A-Za-z])(?:_?(\w+))?$")
Style = Callable[[str, str, str], str]  # rates, letter, index


def sheets() -> dict[str, list[str]]:
    """The equations of each sheet by its title, as Python text."""
    found: dict[str, list[str]] = {}
    for line in (FOLDER / "sheets.txt").read_text().splitlines():
        if line.startswith("# "):
            title = line[2:]
            found[title] = []
        else:
            found[title].append(line)
    return found


def by_hand() -> list[tuple[str, str]]:
    """Texts of right equations written by hand, after textbooks, each with its title and notation."""
    parts = re.split(r"(?m)^=== (.*)\n", (FOLDER / "texts.txt").read_text())
    return list(zip(parts[1::2], parts[2::2], strict=True))


def _latex_name(letter: str, index: str) -> str:
    letter = f"\\{letter}" if letter in GREEK else letter
    index = f"\\{index}" if index in GREEK else index
    return f"{letter}_{{{index}}}" if len(index) > 1 else f"{letter}_{index}" if index else letter


def newton(rates: str, letter: str, index: str) -> str:
    """Dots over the letter."""
    name = _latex_name(letter, "")
    dotted = {0: name, 1: rf"\dot{{{name}}}", 2: rf"\ddot{{{name}}}"}[len(rates)]
    return dotted + _latex_name("", index)


def prime(rates: str, letter: str, index: str) -> str:
    """Primes."""
    return _latex_name(letter, index) + "'" * len(rates)


def leibniz(rates: str, letter: str, index: str) -> str:
    """d over dt."""
    name = _latex_name(letter, index)
    over = {1: rf"\frac{{d{name}}}{{dt}}", 2: rf"\frac{{d^2{name}}}{{dt^2}}"}
    return over.get(len(rates), name)


def greek(rates: str, letter: str, index: str) -> str:
    """Plain text with Greek letters and combining dots."""
    dots = {0: "", 1: "\u0307", 2: "\u0308"}[len(rates)]
    return GREEK.get(letter, letter) + dots + (f"_{index}" if index else "")


def code(rates: str, letter: str, index: str) -> str:
    """As a program names them."""
    return rates + letter + (f"_{index}" if index else "")


def dotted(rates: str, letter: str, index: str) -> str:
    """As a program names them, rates behind."""
    return letter + ("_" * (not index.isdigit()) + index if index else "") + {0: "", 1: "_dot", 2: "_ddot"}[len(rates)]


class Writer:
    """Prints trees of Python's syntax in one notation."""

    def __init__(self, style: Style, latex: bool, comma: bool = False) -> None:
        self.style, self.latex, self.comma = style, latex, comma

    def equation(self, text: str) -> str:
        """One equation."""
        return " = ".join(self.write(ast.parse(side, mode="eval").body) for side in text.split(" = "))

    def write(self, node: ast.AST, level: int = 0) -> str:
        """A tree; level 1 inside a product, 2 under a power."""
        text, own = self._parts(node)
        return (rf"\left({text}\right)" if self.latex else f"({text})") if own < level else text

    def _parts(self, node: ast.AST) -> tuple[str, int]:
        joint = " " if self.latex else "*"
        match node:
            case ast.Constant():
                return str(node.value), 3
            case ast.Name():
                match_ = NAME.match(node.id)
                assert match_, node.id
                return self.style(match_[1], match_[2], match_[3] or ""), 3 if not match_[1] else 2
            case ast.UnaryOp():
                return f"-{self.write(node.operand, 1)}", 0
            case ast.Call(func=ast.Name(id=name)):
                inside = self.write(node.args[0])
                if self.latex:
                    return (rf"\sqrt{{{inside}}}", 3) if name == "sqrt" else (rf"\{name}\left({inside}\right)", 2)
                return f"{name}({inside})", 2
            case ast.BinOp(op=ast.Add() | ast.Sub()):
                sign = "+" if isinstance(node.op, ast.Add) else "-"
                return f"{self.write(node.left)} {sign} {self.write(node.right, 1)}", 0
            case ast.BinOp(op=ast.Mult()):
                right = self.write(node.right, 1)
                cross = r" \cdot " if self.latex and right[:1].isdigit() else joint
                return f"{self.write(node.left, 1)}{cross}{right}", 1
            case ast.BinOp(op=ast.Div()):
                return self._fraction(node), 1
            case ast.BinOp(op=ast.Pow(), left=left, right=ast.Constant(value=power)):
                return self._power(left, power), 2
        raise ValueError(ast.dump(node))

    def _fraction(self, node: ast.BinOp) -> str:
        halved = isinstance(node.right, ast.Constant) and node.right.value in (2, 4) and self.comma
        if halved and isinstance(node.right, ast.Constant):
            return f"{str(1 / float(str(node.right.value))).replace('.', ',')} {self.write(node.left, 1)}"
        if self.latex:
            return rf"\frac{{{self.write(node.left)}}}{{{self.write(node.right)}}}"
        return f"{self.write(node.left, 1)}/{self.write(node.right, 2)}"

    def _power(self, left: ast.AST, power: int) -> str:
        if self.latex and isinstance(left, ast.Call) and isinstance(left.func, ast.Name):
            return rf"\{left.func.id}^{power}\left({self.write(left.args[0])}\right)"
        base = self.write(left, 3 if not isinstance(left, ast.Name) else 0)
        if not self.latex:
            return f"{base}**{power}"
        lifted = base if re.fullmatch(r"\\?\w+|\\d?dot\{\\?\w+\}(?:_\w)?|\w_\w", base) else rf"\left({base}\right)"
        return f"{lifted}^{power}"


def latin(rates: str, letter: str, index: str) -> str:
    """Other letters for the angles."""
    return newton(rates, {"theta": r"\psi", "phi": r"\beta", "q": r"\alpha"}.get(letter, letter), index)


NOTATIONS: dict[str, Writer] = {
    "Newton's dots": Writer(newton, True),
    "primes": Writer(prime, True),
    "Leibniz": Writer(leibniz, True),
    "Greek letters": Writer(greek, False),
    "other letters": Writer(latin, True),
    "index": Writer(newton, True),
    "display": Writer(newton, True),
    "code": Writer(code, False),
    "names with dot": Writer(dotted, False),
    "decimal comma": Writer(newton, True, comma=True),
}


def _frame(notation: str, title: str, lines: list[str]) -> str:
    """The text around the equations."""
    head = f"# {title[0].upper()}{title[1:]}\n\n"
    if notation in ("code", "names with dot"):
        return head + "```\n" + "\n".join(lines) + "\n```\n"
    if notation == "Greek letters":
        return head + "".join(f"- {line}\n" for line in lines)
    if notation == "display":
        rows = " \\\\\n".join(line.replace(" = ", " &= ", 1) for line in lines)
        return head + f"\\begin{{align}}\n{rows}\n\\end{{align}}\n"
    if notation == "index":
        return head + "".join(f"\\[ {line} \\tag{{{i}}} \\]\n" for i, line in enumerate(lines, start=1))
    legend = "where $\\psi$ is the angle theta and $\\beta$ is the angle phi.\n\n"
    if notation == "other letters" and "thin" not in title and ("rod" in title or "spherical" in title):
        head += legend
    return head + "".join(f"We have ${line}$.\n" for line in lines)


def texts(
    change: Callable[[int, str], str] = lambda i, line: line, only: str = "", style: str = ""
) -> list[tuple[str, str, str, list[str]]]:
    """Every sheet in every notation: its title, the notation, the text and its equations as Python text."""
    found = []
    for title, equations in sheets().items():
        for notation, writer in NOTATIONS.items():
            if (only and title != only) or (style and notation != style):
                continue
            own = [change(i, line) for i, line in enumerate(equations)]
            found.append((title, notation, _frame(notation, title, [writer.equation(line) for line in own]), own))
    return found
