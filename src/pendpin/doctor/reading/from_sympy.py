"""Expressions of sympy as text that the grammar reads: functions of time and their derivatives become symbols."""

from typing import Any


def text_of(value: Any) -> str | None:
    """The text of an Eq, expression or column of three; None for anything else."""
    from sympy import Derivative, Eq, Expr, MatrixBase, Symbol
    from sympy.core.function import AppliedUndef

    if isinstance(value, Eq):
        left, right = text_of(value.lhs), text_of(value.rhs)
        return None if left is None or right is None else f"{left} = {right}"
    if isinstance(value, MatrixBase):
        return f"({', '.join(str(text_of(entry)) for entry in value)})"
    if not isinstance(value, Expr):
        return None
    orders = sorted(value.atoms(Derivative), key=lambda one: -one.derivative_count)
    rates = {one: int(one.derivative_count) for one in orders if isinstance(one.expr, AppliedUndef)}
    value = value.xreplace({one: Symbol(_rate(one.expr.func.__name__, order)) for one, order in rates.items()})
    return str(value.xreplace({one: Symbol(one.func.__name__) for one in value.atoms(AppliedUndef)}))


def _rate(name: str, order: int) -> str:
    """The name of a derivative in time, of a name in plain text or in LaTeX."""
    return f"\\{'d' * order}ot{{{name}}}" if name.startswith("\\") else "d" * order + name
