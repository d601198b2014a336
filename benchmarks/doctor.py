"""How well the equation doctor finds faults: random single changes of right equations, and right equations rewritten.

    python benchmarks/doctor.py [--mutations 200] [--rewritings 100] [--seed 0] [--show]

Equations are changed as Python syntax trees, which the doctor knows nothing of, and printed in four notations. A mend
counts as the true one if the mended equation is the original up to a constant factor, every symbol taken as independent.
"""

import argparse
import ast
import random
import time
from dataclasses import dataclass

import numpy as np
import sympy as sp

from pendpin.analysis.doctor.checking.check import TOLERANCE, Equation, random_states, relative_error
from pendpin.analysis.doctor.checking.evaluation import Context, evaluate
from pendpin.analysis.doctor.checking.mechanics import Convention, Quantities
from pendpin.analysis.doctor.diagnose import diagnose
from pendpin.analysis.doctor.mending.laws import free_states
from pendpin.analysis.doctor.reading.grammar import parse
from pendpin.analysis.doctor.reading.names import MATRICES, VECTORS
from pendpin.analysis.doctor.reading.tree import Unread, symbols

KINEMATICS = """
yhat = cos(theta)*a2 + sin(theta)*a3
zhat = -sin(theta)*a2 + cos(theta)*a3
a1 = cos(phi)*b1 + sin(phi)*b3
a3 = -sin(phi)*b1 + cos(phi)*b3
b3 = sin(phi)*xhat + sin(theta)*cos(phi)*yhat + cos(theta)*cos(phi)*zhat
omega = -dtheta*xhat + dphi*a2
omega = -dtheta*cos(phi)*b1 + dphi*b2 - dtheta*sin(phi)*b3
omega_1 = -dtheta*cos(phi)
omega_3 = -dtheta*sin(phi)
domega_1 = -ddtheta*cos(phi) + dtheta*dphi*sin(phi)
domega_3 = -ddtheta*sin(phi) - dtheta*dphi*cos(phi)
"""
UNIFORM = """
x = l/2*sin(phi)
y = l/2*cos(phi)*sin(theta)
z = l/2*cos(phi)*cos(theta)
v_x = l/2*dphi*cos(phi)
v_y = -l/2*dphi*sin(theta)*sin(phi) + l/2*dtheta*cos(theta)*cos(phi)
v_z = -l/2*dphi*cos(theta)*sin(phi) - l/2*dtheta*sin(theta)*cos(phi)
a_G = l/2*((ddphi + dtheta**2*sin(phi)*cos(phi))*b1 + (ddtheta*cos(phi) - 2*dtheta*dphi*sin(phi))*b2\
 - (dphi**2 + dtheta**2*cos(phi)**2)*b3)
l/2*(ddphi + dtheta**2*sin(phi)*cos(phi)) = 1/m*(R_1 - cos(theta)*sin(phi)*F_g)
l/2*(ddtheta*cos(phi) - 2*dtheta*dphi*sin(phi)) = 1/m*(R_2 - sin(theta)*F_g)
-l/2*(dphi**2 + dtheta**2*cos(phi)**2) = 1/m*(-R_3 + cos(phi)*cos(theta)*F_g)
m*l/2*(ddphi + dtheta**2*sin(phi)*cos(phi)) = R_1 - m*g*cos(theta)*sin(phi)
R_2 = m*l/2*(ddtheta*cos(phi) - 2*dtheta*dphi*sin(phi)) + m*g*sin(theta)
R_3 = m*l/2*(dphi**2 + dtheta**2*cos(phi)**2) + m*g*cos(theta)*cos(phi)
V = -m*g*l/2*cos(phi)*cos(theta)
V = m*g*l/2*(1 - cos(phi)*cos(theta))
"""
THIN = (
    UNIFORM
    + """
m*l**2/12*(-ddtheta*cos(phi) + dtheta*dphi*sin(phi)) + m*l**2/12*dtheta*dphi*sin(phi) = l/2*R_2
m*l**2/12*ddphi + m*l**2/12*dtheta**2*sin(phi)*cos(phi) = -l/2*R_1
ddtheta = 2*dtheta*dphi*tan(phi) - 3*g*sin(theta)/(2*l*cos(phi))
ddphi = -dtheta**2*sin(phi)*cos(phi) - 3*g/(2*l)*cos(theta)*sin(phi)
m*l**2/3*cos(phi)*ddtheta - 2*m*l**2/3*sin(phi)*dtheta*dphi + m*g*l/2*sin(theta) = 0
m*l**2/3*ddphi + m*l**2/3*dtheta**2*sin(phi)*cos(phi) + m*g*l/2*cos(theta)*sin(phi) = 0
T = m*l**2/6*(dphi**2 + dtheta**2*cos(phi)**2)
L = m*l**2*dphi**2/6 + m*l**2*dtheta**2*cos(phi)**2/6 + m*g*l*cos(theta)*cos(phi)/2
T = 1/2*m*(v_x**2 + v_y**2 + v_z**2) + 1/2*(I_1*omega_1**2 + I_2*omega_2**2)
"""
)
THICK = (
    UNIFORM
    + """
I_1 = m*(3*r**2 + l**2)/12
I_3 = m*r**2/2
I_1*(-ddtheta*cos(phi) + dtheta*dphi*sin(phi)) + (I_1 - I_3)*dtheta*dphi*sin(phi) = l/2*R_2 - M_c*sin(phi)
I_2*ddphi + (I_1 - I_3)*dtheta**2*sin(phi)*cos(phi) = -l/2*R_1
M_3 = M_c*cos(phi)
T = m*(3*r**2 + 4*l**2)/24*(dphi**2 + dtheta**2*cos(phi)**2) + m*r**2/4*dtheta**2*sin(phi)**2
"""
)
GENERAL = """
J_1 = I_1 + m*h**2
m*h*(ddphi + dtheta**2*sin(phi)*cos(phi)) = R_1 - m*g*cos(theta)*sin(phi)
m*h*(ddtheta*cos(phi) - 2*dtheta*dphi*sin(phi)) = R_2 - m*g*sin(theta)
m*h*(dphi**2 + dtheta**2*cos(phi)**2) = R_3 - m*g*cos(theta)*cos(phi)
J_2*ddphi + (J_1 - I_3)*dtheta**2*sin(phi)*cos(phi) + m*g*h*cos(theta)*sin(phi) = 0
I_2*ddphi + (I_1 - I_3)*dtheta**2*sin(phi)*cos(phi) = -h*R_1
ddtheta = (2*(J_1 - I_3)*dtheta*dphi*sin(phi) - m*g*h*sin(theta))*cos(phi)/(J_1*cos(phi)**2 + I_3*sin(phi)**2)
ddphi = -((J_1 - I_3)*dtheta**2*cos(phi) + m*g*h*cos(theta))*sin(phi)/J_2
T = 1/2*(J_1*cos(phi)**2 + I_3*sin(phi)**2)*dtheta**2 + 1/2*J_2*dphi**2
L = 1/2*(J_1*cos(phi)**2 + I_3*sin(phi)**2)*dtheta**2 + 1/2*J_2*dphi**2 + m*g*h*cos(theta)*cos(phi)
V = -m*g*h*cos(theta)*cos(phi)
"""
EQUATIONS = [
    (rod, line)
    for rod, text in (("thin", KINEMATICS), ("thin", THIN), ("uniform", THICK), ("general", GENERAL))
    for line in filter(None, text.splitlines())
]

# --- changes --------------------------------------------------------------------------------------------------------

SWAPS = {"theta": "phi", "phi": "theta", "dtheta": "dphi", "dphi": "dtheta", "ddtheta": "ddphi", "ddphi": "ddtheta"}
SWAPS |= {
    "R_1": "R_2",
    "R_2": "R_1",
    "R_3": "R_1",
    "l": "m",
    "m": "l",
    "I_1": "I_3",
    "I_3": "I_2",
    "J_1": "I_1",
    "J_2": "J_1",
}
SWAPS |= {"b1": "b2", "b2": "b3", "b3": "b1", "a2": "a3", "a3": "a2", "xhat": "yhat", "v_x": "v_y", "h": "l", "r": "l"}
Tree = ast.expr


def nodes(tree: Tree) -> list[ast.AST]:
    """All expressions of a tree."""
    return [node for node in ast.walk(tree) if isinstance(node, ast.expr)]


def single(node: ast.AST) -> bool:
    """Whether a factor is one: a name, number, function or power."""
    return isinstance(node, ast.Name | ast.Constant | ast.Call) or (
        isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow)
    )


def changes(node: ast.AST) -> list[tuple[str, Tree]]:
    """Named single changes of one node."""
    found: list[tuple[str, Tree]] = []
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        other = ast.Sub() if isinstance(node.op, ast.Add) else ast.Add()
        found += [("sign", ast.BinOp(node.left, other, node.right)), ("dropped term", node.left)]
        found += [("sign", ast.BinOp(ast.UnaryOp(ast.USub(), node.left), node.op, node.right))]
        if isinstance(node.op, ast.Add):
            found += [("dropped term", node.right)]
    if isinstance(node, ast.UnaryOp):
        found += [("sign", node.operand)]
    if isinstance(node, ast.Constant):
        found += [("factor", ast.Constant(value)) for value in (1, 2, 3, 4, 6, 12) if value != node.value]
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
        found += [("factor", ast.BinOp(ast.Constant(k), ast.Mult(), node)) for k in (2, 3)]
        found += [("dropped factor", a) for a, b in ((node.left, node.right), (node.right, node.left)) if single(b)]
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div):
        found += [("dropped factor", node.left)] if single(node.right) else []
        found += [("factor", ast.BinOp(node, ast.Div(), ast.Constant(2)))]
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
        found += [("power", node.left), ("power", ast.BinOp(node.left, ast.Pow(), ast.Constant(3)))]
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        other = {"sin": "cos", "cos": "sin", "tan": "sin"}[node.func.id]
        found += [
            ("function", ast.Call(ast.Name(other), node.args, [])),
            ("power", ast.BinOp(node, ast.Pow(), ast.Constant(2))),
        ]
    if isinstance(node, ast.Name) and node.id in SWAPS:
        found += [("symbol", ast.Name(SWAPS[node.id]))]
    return found


class Replace(ast.NodeTransformer):
    """A tree with one node replaced."""

    def __init__(self, old: ast.AST, new: Tree) -> None:
        self.old, self.new = old, new

    def visit(self, node: ast.AST) -> ast.AST:
        """The new node in place of the old one."""
        return self.new if node is self.old else super().generic_visit(node)


def extra_term(tree: Tree, chance: random.Random) -> tuple[str, Tree]:
    """One term too many, of the size of another."""
    sums = [n for n in nodes(tree) if isinstance(n, ast.BinOp) and isinstance(n.op, ast.Add | ast.Sub)]
    if not sums:
        return "", tree
    target = chance.choice(sums)
    term = ast.BinOp(target.right, ast.Mult(), ast.Call(ast.Name("cos"), [ast.Name("theta")], []))
    return "extra term", Replace(target, ast.BinOp(target, ast.Add(), term)).visit(
        ast.parse(ast.unparse(tree), mode="eval").body
    )


def changed(text: str, chance: random.Random) -> tuple[str, str]:
    """One random change on one side of an equation: its kind and the new text."""
    sides = text.split(" = ")
    side = chance.choice([i for i, part in enumerate(sides) if not part.replace("_", "").isalnum()])
    tree = ast.parse(sides[side], mode="eval").body
    node = chance.choice([n for n in nodes(tree) if changes(n)])
    kinds: dict[str, list[Tree]] = {}
    for kind, new in changes(node):
        kinds.setdefault(kind, []).append(new)
    kind = chance.choice(sorted(kinds))
    new_tree = Replace(node, chance.choice(kinds[kind])).visit(tree)
    if chance.random() < 0.06:
        kind, new_tree = extra_term(ast.parse(sides[side], mode="eval").body, chance)
    sides[side] = ast.unparse(ast.fix_missing_locations(new_tree))
    return kind, " = ".join(sides)


# --- notations ------------------------------------------------------------------------------------------------------

PRINTED = {
    "theta": r"\theta",
    "phi": r"\phi",
    "dtheta": r"\dot{\theta}",
    "dphi": r"\dot{\phi}",
    "ddtheta": r"\ddot{\theta}",
}
PRINTED |= {
    "ddphi": r"\ddot{\phi}",
    "omega": r"{}^I\mathbf{\omega}^B",
    "a_G": r"{}^I\mathbf{a}_{G/O}",
    "domega_1": r"\dot{\omega}_1",
}
PRINTED |= {
    "domega_3": r"\dot{\omega}_3",
    **{f"{c}hat": rf"\hat{{{c}}}" for c in "xyz"},
    **{f"omega_{i}": rf"\omega_{i}" for i in "123"},
}
PRINTED |= {f"{f}{i}": rf"\hat{{{f}}}_{i}" for f in "ab" for i in "123"}
OTHER = PRINTED | {
    "dtheta": r"\dot\theta",
    "dphi": r"\dot\phi",
    "ddtheta": r"\ddot\theta",
    "ddphi": r"\ddot\phi",
    "omega": r"\vec{\omega}",
}
OTHER |= {"a_G": r"\vec{a}_G", **{f"{f}{i}": rf"\mathbf{{{f}}}_{{{i}}}" for f in "ab" for i in "123"}}


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


# --- the check of the doctor ----------------------------------------------------------------------------------------


class Independent(Quantities):
    """Every symbol an independent random number or vector: what is printed counts, not what holds in mechanics."""

    def __init__(self) -> None:
        self.rod, self.xp, self.base, self._known = "thin", np, {"theta": np.zeros(40)}, {}

    def __getitem__(self, name: str) -> np.ndarray:
        """Random, but always the same for a name."""
        if name not in self._known:
            seed = np.random.default_rng(abs(hash(name)) % 2**32)
            shape = (3, 40) if name in VECTORS else (3, 3, 40) if name in MATRICES else (40,)
            self._known[name] = seed.uniform(0.3, 2.0, shape)
        return self._known[name]

    def __contains__(self, name: str) -> bool:
        """Every name."""
        return True


WORLD = Independent()


def left_over(text: str) -> np.ndarray:
    """Left minus right of an equation, every symbol independent."""
    sides = parse(text)[0]
    meanings = {name: "rG" if name == "r" else name for side in sides for name in symbols(side)}
    try:
        values = [
            evaluate(side, Context(WORLD, {}, meanings={k: v for k, v in meanings.items() if k != "r"}))
            for side in sides
        ]
    except Unread:  # a number is added to a vector
        return np.full(1, np.nan)
    return (values[0] - (values[1] if len(values) > 1 else 0)).ravel()


def same(first: str, second: str, rod: str = "") -> bool:
    """Whether two equations are the same but for a factor; with a rod, also where F_g is m g, a1 is x and the like."""
    found = _proportional(left_over(first), left_over(second))
    if found or not rod:
        return found
    world = free_states(rod, Convention())
    pairs = [[evaluate(side, Context(world, {})).ravel() for side in parse(text)[0]] for text in (first, second)]
    return all(a.shape == b.shape and np.allclose(a, b, rtol=1e-9) for a, b in zip(*pairs, strict=True))


def _proportional(a: np.ndarray, b: np.ndarray) -> bool:
    if a.shape != b.shape or not np.abs(b).max() > 0:
        return False
    ratio = a[np.argmax(np.abs(b))] / b[np.argmax(np.abs(b))]
    if np.abs(a - ratio * b).max() <= 1e-9 * np.abs(a).max():
        return True
    if np.abs(b).min() == 0:
        return False
    parameters = [WORLD[name] for name in ("m", "l")] if len(a) == len(WORLD["m"]) else []
    return any(np.ptp(a / b * p**k) <= 1e-9 * np.abs(a / b * p**k).max() for p in parameters for k in (1, -1))


def mutations(count: int, seed: int, show: bool) -> tuple[int, int, int]:
    """How often the true mend is first, and how often a wrong equation is said to hold or not read."""
    chance = random.Random(seed)
    first = wrong = done = 0
    while done < count:
        rod, text = chance.choice(EQUATIONS)
        notation = NOTATIONS[done % len(NOTATIONS)]
        kind, new = changed(text, chance)
        if not kind or same(text, new) or not fails(new, rod):
            continue
        done += 1
        began = time.process_time()
        finding = diagnose([noted(new, notation)], rod=rod).findings[0]
        seconds = time.process_time() - began
        wrong += finding.verdict == "holds"
        good = bool(finding.mends) and same(text, finding.mends[0].latex, rod)
        first += good
        if show and (not good or seconds > 5):
            found = finding.mends[0].latex if finding.mends else finding.remark
            print(
                f"{rod} {kind} [{notation}] {seconds:.1f} s\n  was    {text}\n  is     {finding.latex}"
                f"\n  found  {finding.verdict}: {found}"
            )
    return first, wrong, done


def fails(text: str, rod: str) -> bool:
    """Whether a changed equation is wrong: some changes are none, as cos for cos of an angle that does not enter.

    This is asked of the truth in plain notation; one that cannot be evaluated is wrong.
    """
    errors = []
    for equation in Equation(tuple(parse(text)[0])).readings():
        try:
            errors.append(relative_error(equation, random_states(rod, Convention())))
        except Unread:
            continue
    return min(errors, default=1.0) > TOLERANCE


# --- rewriting ------------------------------------------------------------------------------------------------------

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
        ratio = _constant_ratio(new_left - new_right, before)
        if ratio:
            left, right = new_left, new_right
    return left, right


def _constant_ratio(new: sp.Expr, old: sp.Expr) -> bool:
    """Whether a step kept the equation: its residual is the old one times what is not 0 (one number tells)."""
    free = sorted(old.free_symbols | new.free_symbols, key=str)
    ratios = []
    for seed in (1, 2):
        values = {symbol: sp.Float(0.3 + 1.3 * random.Random(f"{symbol}{seed}").random(), 30) for symbol in free}
        scale = values.get(sp.Symbol("m"), 1)
        del scale
        a, b = new.subs(values), old.subs(values)
        if abs(a) < 1e-15 or abs(b) < 1e-15:
            return False
        ratios.append(a / b)
    factors = (1, -1, 2, 3, 12)
    known = [f for f in factors if abs(ratios[0] - f) < 1e-12]
    return bool(known) or _monomial_ratio(new, old)


def _monomial_ratio(new: sp.Expr, old: sp.Expr) -> bool:
    quotient = sp.simplify(new / old)
    return len(sp.Add.make_args(quotient)) == 1 and quotient.free_symbols <= {sp.Symbol("m"), sp.Symbol("l"), *ANGLES}


def rewritings(count: int, seed: int, show: bool) -> tuple[int, int]:
    """How many right equations are said to fail or cannot be read, of how many."""
    chance = random.Random(seed)
    scalar = [
        (rod, text)
        for rod, text in EQUATIONS
        if not ({*["b1", "b2", "b3", "a1", "a2", "a3", "omega", "a_G"]} & set(_words(text)))
    ]
    bad = 0
    for done in range(count):
        rod, text = chance.choice(scalar)
        left, right = (sp.sympify(side) for side in text.split(" = "))
        left, right = rewritten(left, right, chance)
        names = {sp.Symbol(name): latex for name, latex in PRINTED.items()}
        in_latex = f"{sp.latex(left, symbol_names=names)} = {sp.latex(right, symbol_names=names)}"
        printed = [in_latex, f"{left} = {right}", sp.Eq(left, right, evaluate=False)][done % 3]
        finding = diagnose([printed], rod=rod).findings[0]
        if finding.verdict != "holds":
            bad += 1
            if show:
                print(
                    f"{rod}\n  was  {text}\n  is   {finding.latex}"
                    f"\n  found {finding.verdict} {finding.error:.2g} {finding.remark}"
                )
    return bad, count


def _words(text: str) -> list[str]:
    return [
        node.id
        for side in text.split(" = ")
        for node in ast.walk(ast.parse(side, mode="eval"))
        if isinstance(node, ast.Name)
    ]


def main() -> None:
    """Print both rates."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--mutations", type=int, default=200)
    arguments.add_argument("--rewritings", type=int, default=100)
    arguments.add_argument("--seed", type=int, default=0)
    arguments.add_argument("--show", action="store_true", help="print what is not found")
    options = arguments.parse_args()
    began = time.process_time()
    first, wrong, count = mutations(options.mutations, options.seed, options.show)
    if count:
        print(
            f"{count} single changes in four notations: the true mend is named first in {first / count:.1%}; "
            f"{wrong} said to hold"
        )
    bad, total = rewritings(options.rewritings, options.seed, options.show)
    print(
        f"{total} right equations rewritten: {bad} said to fail or not read; "
        f"{time.process_time() - began:.0f} s of CPU in all"
    )


if __name__ == "__main__":
    main()
