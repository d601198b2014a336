"""Expressions of sympy as plain text that the grammar reads: functions of time and their derivatives become symbols."""

from typing import Any

from pendpin.doctor.reading.grammar import lone
from pendpin.doctor.reading.names import Vocabulary
from pendpin.doctor.reading.tree import Unread
from pendpin.doctor.systems.rod_names import meanings


def text_of(value: Any) -> str | None:
    """The text of an Eq, expression or column of three; None for anything else."""
    from sympy import Eq, Expr, MatrixBase

    if isinstance(value, Eq):
        left, right = text_of(value.lhs), text_of(value.rhs)
        return None if left is None or right is None else f"{left} = {right}"
    if isinstance(value, MatrixBase):
        return f"({', '.join(str(_named(entry)) for entry in value)})"
    return str(_named(value)) if isinstance(value, Expr) else None


def _named(expression: Any) -> Any:
    """An expression whose functions of time, their derivatives and oddly named symbols are plain symbols."""
    from sympy import Derivative, Symbol
    from sympy.core.function import AppliedUndef

    derivatives = sorted(expression.atoms(Derivative), key=lambda d: -d.derivative_count)
    chosen = {d: Symbol(_derived(d)) for d in derivatives if isinstance(d.expr, AppliedUndef)}
    expression = expression.xreplace(chosen)
    expression = expression.xreplace({f: Symbol(_plain(f.func.__name__)) for f in expression.atoms(AppliedUndef)})
    return expression.xreplace({s: Symbol(_plain(s.name)) for s in expression.free_symbols})


def _derived(derivative: Any) -> str:
    """The name of a derivative in time."""
    return "d" * int(derivative.derivative_count) + _plain(derivative.expr.func.__name__)


def _plain(name: str) -> str:
    """A symbol's name in plain text: \\dot{\\theta} is dtheta."""
    if name.isidentifier() and name.isascii():
        return name
    try:
        found = lone(name, Vocabulary(meanings))
    except Unread:
        return name
    return found.value if found and found.kind == "symbol" and not found.value.startswith("?") else name
