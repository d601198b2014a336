"""Right equations rewritten by random algebra."""

import random

import sympy as sp

ANGLES = [sp.Symbol("theta"), sp.Symbol("phi")]


def rewritten(left: sp.Expr, right: sp.Expr, chance: random.Random) -> tuple[sp.Expr, sp.Expr]:
    """A right equation after three random steps of algebra."""
    s, c = sp.sin, sp.cos
    x = chance.choice(ANGLES)
    steps = [
        lambda a, b: (sp.expand(a), b),
        lambda a, b: (a, sp.expand(b)),
        lambda a, b: (sp.factor(a), sp.factor(b)),
        lambda a, b: (a - b, sp.Integer(0)),
        lambda a, b: (sp.Integer(0), b - a),
        lambda a, b: (b, a),
        lambda a, b: (a * sp.Symbol("m"), b * sp.Symbol("m")),
        lambda a, b: (a / sp.Symbol("l"), b / sp.Symbol("l")),
        lambda a, b: (a * c(x), sp.expand(b * c(x))),
        lambda a, b: (a * chance.choice([2, 3, 12]), b * 1),
        lambda a, b: (a.subs(c(x) ** 2, 1 - s(x) ** 2), b.subs(c(x) ** 2, 1 - s(x) ** 2)),
        lambda a, b: (a.subs(s(x) * c(x), s(2 * x) / 2), b.subs(s(x) * c(x), s(2 * x) / 2)),
        lambda a, b: (a.subs(c(x) ** 2, (1 + c(2 * x)) / 2), b.subs(c(x) ** 2, (1 + c(2 * x)) / 2)),
        lambda a, b: (sp.together(a - b), sp.Integer(0)),
        lambda a, b: (a + b, 2 * b),
        lambda a, b: (sp.collect(sp.expand(a), chance.choice(list(a.free_symbols or {sp.Symbol("m")}))), b),
    ]
    for step in chance.sample(steps, 3):
        before = left - right
        new_left, new_right = step(left, right)
        if _same_equation(new_left - new_right, before):
            left, right = new_left, new_right
    return left, right


def _same_equation(new: sp.Expr, old: sp.Expr) -> bool:
    """Whether a residual is the old one times what is not 0: a number, a mass, a length, the cosine of an angle."""
    quotient = sp.simplify(new / old) if old != 0 else sp.nan
    parts = len(sp.Add.make_args(quotient))
    return bool(parts == 1 and quotient != 0 and quotient.free_symbols <= {sp.Symbol("m"), sp.Symbol("l"), *ANGLES})
