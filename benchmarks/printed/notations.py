"""Equations, given as Python text, printed in four notations."""

import ast
from dataclasses import dataclass

import sympy as sp

PRINTED = {angle: rf"\{angle}" for angle in ("theta", "phi")}
PRINTED |= {f"{d * 'd'}{angle}": rf"\{d * 'd'}ot{{\{angle}}}" for angle in ("theta", "phi") for d in (1, 2)}
PRINTED |= {"omega": r"{}^I\mathbf{\omega}^B", "a_G": r"{}^I\mathbf{a}_{G/O}"}
PRINTED |= {f"omega_{i}": rf"\omega_{i}" for i in "123"} | {f"domega_{i}": rf"\dot{{\omega}}_{i}" for i in "13"}
PRINTED |= {f"{c}hat": rf"\hat{{{c}}}" for c in "xyz"} | {f"{f}{i}": rf"\hat{{{f}}}_{i}" for f in "ab" for i in "123"}
OTHER = PRINTED | {f"{d * 'd'}{angle}": rf"\{d * 'd'}ot\{angle}" for angle in ("theta", "phi") for d in (1, 2)}
OTHER |= {"omega": r"\vec{\omega}", "a_G": r"\vec{a}_G"}
OTHER |= {f"{f}{i}": rf"\mathbf{{{f}}}_{{{i}}}" for f in "ab" for i in "123"}


@dataclass(frozen=True)
class Latex:
    """A style of LaTeX: names, how functions and brackets are printed."""

    names: dict[str, str]
    plain: bool  # sin(x) and plain brackets, as in the printed derivation

    def write(self, node: ast.AST, level: int = 0) -> str:
        """The LaTeX of a tree; `level` 1 inside a product, 2 under a power."""
        text, own = self._parts(node)
        return self._bracket(text) if own < level else text

    def _bracket(self, text: str) -> str:
        return f"({text})" if self.plain else rf"\left({text}\right)"

    def _parts(self, node: ast.AST) -> tuple[str, int]:
        match node:
            case ast.Constant():
                return str(node.value), 3
            case ast.Name():
                return self.names.get(node.id, node.id), 3
            case ast.UnaryOp():
                return f"-{self.write(node.operand, 1)}", 0
            case ast.Call(func=ast.Name(id=name)):
                return self._call(name, node.args[0], ""), 2
            case ast.BinOp(op=ast.Add() | ast.Sub()):
                sign = "+" if isinstance(node.op, ast.Add) else "-"
                return f"{self.write(node.left)}{sign}{self.write(node.right, 1)}", 0
            case ast.BinOp(op=ast.Mult()):
                left, right = self.write(node.left, 1), self.write(node.right, 1)
                joint = (
                    r" \cdot "
                    if right[:1].isdigit()
                    else " "
                    if left[-1:].isalpha() and right[:1].isalpha() and "\\" in left
                    else ""
                )
                return f"{left}{joint}{right}", 1
            case ast.BinOp(op=ast.Div()):
                return rf"\frac{{{self.write(node.left)}}}{{{self.write(node.right)}}}", 2
            case ast.BinOp(op=ast.Pow(), left=ast.Call(func=ast.Name(id=name))):
                return self._call(name, node.left.args[0], f"^{{{self.write(node.right)}}}"), 2
            case ast.BinOp():
                return f"{self.write(node.left, 3)}^{{{self.write(node.right)}}}", 2
        raise ValueError(ast.dump(node))

    def _call(self, name: str, argument: ast.AST, power: str) -> str:
        inside = self.write(argument)
        if self.plain:
            return f"{name}{power}({inside})"
        return rf"\{name}{power}{{{inside}}}" if len(inside) > 6 else rf"\{name}{power} {inside} "


STYLES = {"LaTeX as printed": Latex(PRINTED, True), "LaTeX, other style": Latex(OTHER, False)}
NOTATIONS = (*STYLES, "plain text", "sympy")


def noted(text: str, notation: str) -> object:
    """An equation in a notation: text, or sympy's Eq."""
    if notation in STYLES:
        return " = ".join(STYLES[notation].write(ast.parse(side, mode="eval").body) for side in text.split(" = "))
    if notation == "plain text":
        return text
    left, right = (
        sp.sympify(side, locals={name: sp.Symbol(name) for name in ("E", "I", "S", "N", "Q")})
        for side in text.split(" = ")
    )
    return sp.Eq(left, right, evaluate=False)
