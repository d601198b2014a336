"""Small faults in Python code: places in the syntax tree where an operator, a number or a bound can be another."""

import ast
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import NamedTuple

COMPARISONS = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq}
COMPARISONS |= {ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In}
TURNED = {ast.Lt: ast.Gt, ast.LtE: ast.GtE, ast.Gt: ast.Lt, ast.GtE: ast.LtE}
SIGNS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.BitAnd: ast.BitOr}
SIGNS |= {ast.BitOr: ast.BitAnd, ast.FloorDiv: ast.Mult}
OPPOSITES = ("min max", "minimum maximum", "argmin argmax", "any all", "fmin fmax", "floor ceil", "sin cos")
NAMES = {a: b for pair in OPPOSITES for a, b in (pair.split(), pair.split()[::-1])}
FACTORS = (1.03, 1 / 1.03, 10.0, 0.1)  # of a number that is not whole


class Fault(NamedTuple):
    """One change of one file."""

    module: str  # the file's path in src/pendpin
    line: int  # of the file as it was, from 1
    kind: str
    before: str  # the expression
    after: str
    begin: int  # place in the file's text
    end: int
    text: str  # of the line

    def planted(self, text: str) -> str:
        """The file with the fault."""
        return text[: self.begin] + self.after + text[self.end :]

    @property
    def name(self) -> str:
        """What is written of it, wherever its line is now."""
        return f"{self.module}: {self.text}: {self.before} -> {self.after}"


def faults(module: str, text: str, random: Random) -> list[Fault]:
    """One fault at each place of a file's functions that has one, but for those that run when the file is imported."""
    tree, starts = ast.parse(text), _line_starts(text)
    found = []
    run_already = {node.func.id for node in _outside_functions(tree) if isinstance(node.func, ast.Name)}
    for node in _in_functions(tree, run_already):
        for kind, changed in _changes(node, random):
            begin, end = (
                starts[line - 1] + len(text[starts[line - 1] :].encode()[:column].decode())
                for line, column in ((node.lineno, node.col_offset), (node.end_lineno, node.end_col_offset))
            )
            after = ast.unparse(changed)
            if isinstance(node, ast.BinOp | ast.UnaryOp | ast.Compare | ast.BoolOp):
                after = f"({after})"
            line = text.splitlines()[node.lineno - 1].strip()
            found.append(Fault(module, node.lineno, kind, " ".join(text[begin:end].split()), after, begin, end, line))
    return found


def _line_starts(text: str) -> list[int]:
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    return starts


def _outside_functions(tree: ast.Module) -> Iterator[ast.Call]:
    """The calls in the statements of a file itself."""
    for statement in tree.body:
        if not isinstance(statement, ast.FunctionDef | ast.ClassDef):
            yield from (node for node in ast.walk(statement) if isinstance(node, ast.Call))


def _in_functions(node: ast.AST, without: set[str]) -> Iterator[ast.AST]:
    """The expressions in all functions but some, without those that are evaluated when these are defined."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.FunctionDef):
            yield from _in_functions(child, without)
        elif child.name not in without:
            for statement in child.body:
                yield from _in_code(statement)


def _in_code(node: ast.AST) -> Iterator[ast.AST]:
    """Expressions whose value counts: no messages, annotations or assertions, such as the `strict` of zip."""
    if isinstance(node, ast.JoinedStr | ast.Raise | ast.Assert | ast.Import | ast.ImportFrom):
        return
    if isinstance(node, ast.keyword) and node.arg == "strict":
        return
    yield node
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield from _in_code(child)


def _changes(node: ast.AST, random: Random) -> Iterator[tuple[str, ast.expr]]:
    """The changed forms of an expression itself, not of its parts; at most one of each kind."""
    match node:
        case ast.Compare(left, [op], right):
            table = random.choice([table for table in (COMPARISONS, TURNED) if type(op) in table])
            yield "comparison", ast.Compare(left, [table[type(op)]()], right)
        case ast.Constant(bool(value)):
            yield "constant", ast.Constant(not value)
        case ast.Constant(int(value)):
            yield "constant", ast.Constant(value + random.choice((-1, 1) if value else (1,)))
        case ast.Constant(float(value)):
            yield "constant", ast.Constant(value * random.choice(FACTORS) if value else 1e-3)
        case ast.BinOp(left, op, right) if type(op) in SIGNS:
            yield "sign", ast.BinOp(left, SIGNS[type(op)](), right)
        case ast.BinOp(left, ast.Pow(), right):
            yield "sign", ast.BinOp(left, ast.Mult(), right)
        case ast.UnaryOp(ast.USub() | ast.Not() | ast.Invert(), operand):
            yield "sign", operand
        case ast.BoolOp(op, values):
            yield "sign", ast.BoolOp(ast.Or() if isinstance(op, ast.And) else ast.And(), values)
        case ast.Name(name) | ast.Attribute(attr=name) if name in NAMES:
            other = ast.Name(NAMES[name]) if isinstance(node, ast.Name) else ast.Attribute(node.value, NAMES[name])
            yield "min/max", other
        case ast.Slice(lower, upper, step):
            if changed := [one for one in (_moved(lower, upper, step, 0), _moved(lower, upper, step, 1)) if one]:
                yield "slice", random.choice(changed)


def _moved(lower: ast.expr | None, upper: ast.expr | None, step: ast.expr | None, which: int) -> ast.expr | None:
    """A slice with one of its bounds moved by one."""
    bounds = [lower, upper]
    if bounds[which] is None:
        return None
    bounds[which] = ast.BinOp(bounds[which], ast.Add(), ast.Constant(1))  # pyright: ignore[reportArgumentType]
    return ast.Slice(*bounds, step)


def faults_of(folder: Path, modules: list[str], seed: int) -> list[Fault]:
    """The faults of some files of src/pendpin in a folder, in random order."""
    random = Random(seed)
    found = [fault for name in modules for fault in faults(name, (folder / name).read_text(), random)]
    random.shuffle(found)
    return found
