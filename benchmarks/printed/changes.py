"""Random single changes of equations, as Python syntax trees, which the doctor knows nothing of."""

import ast
import random
import re

SWAPS = {"theta": "phi", "phi": "theta", "dtheta": "dphi", "dphi": "dtheta", "ddtheta": "ddphi", "ddphi": "ddtheta"}

SWAPS |= {
    "R_1": "R_2",
    "R_2": "R_1",
    "R_3": "R_1",
    "l": "m",
    "m": "l",
    "h": "l",
    "r": "l",
    "v_x": "v_y",
    "xhat": "yhat",
}
SWAPS |= {"I_1": "I_3", "I_3": "I_2", "J_1": "I_1", "J_2": "J_1"}
SWAPS |= {"b1": "b2", "b2": "b3", "b3": "b1", "a2": "a3", "a3": "a2"}
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
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id != "sqrt":
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
    printed = ast.unparse(ast.fix_missing_locations(new_tree))
    sides[side] = re.sub(r"([*/]) -(\w+)", r"\1 (-\2)", printed)  # as on paper
    return kind, " = ".join(sides)
